//! Gas in rooms with walls, and in tubes; a room has a pressure and a temperature.

use std::f64::consts::PI;

/// Dynamic viscosity (Pa s) of air at room temperature.
const VISCOSITY: f64 = 1.82e-5;
/// What a sharp entry and an exit into a room take, in dynamic pressures.
const ENDS: f64 = 0.5 + 1.0;

/// A perfect gas: heat ratio and gas constant (J/(kg K)).
pub(super) type Gas = (f64, f64);

/// A room with gas.
#[derive(Clone, Copy, Debug)]
pub(super) struct Room {
    /// Pa.
    pub pressure: f64,
    /// K.
    pub temperature: f64,
    /// m³, and how fast it grows (m³/s).
    pub volume: [f64; 2],
}

/// Gas that flows into a room (kg/s; out of it below 0), and its temperature (K).
pub(super) type Flow = (f64, f64);

/// The wall of a room: its temperature (K), and its thermal resistance (K/W). Without resistance
/// the gas is as warm as the wall.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wall(pub f64, pub f64);

impl Room {
    /// Rates of pressure and temperature (Pa/s, K/s).
    ///
    /// The first law of an open room with p V = m R T: V ṗ/(κ − 1) = c_p Σ ṁ T + Q − κ/(κ − 1) p V̇,
    /// and Ṫ/T = ṗ/p + V̇/V − ṁ/m.
    pub(super) fn rates(&self, (kappa, gas): Gas, flows: &[Flow], wall: Wall) -> [f64; 2] {
        let ([v, grows], p, t) = (self.volume, self.pressure, self.temperature);
        let inflow: f64 = flows.iter().map(|flow| flow.0).sum();
        if wall.1 == 0.0 {
            return [(gas * t * inflow - p * grows) / v, 0.0];
        }
        let heat = (wall.0 - t) / wall.1;
        let enthalpy: f64 = flows.iter().map(|(flow, of)| flow * of).sum();
        let rate = (kappa * gas * enthalpy + (kappa - 1.0) * heat - kappa * p * grows) / v;
        [
            rate,
            t * (rate / p + grows / v) - gas * t * t * inflow / (p * v),
        ]
    }
}

/// A tube of a length, an inner diameter and a roughness (m), in which gas of a specific energy
/// R T (J/kg) flows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tube {
    pub length: f64,
    pub diameter: f64,
    pub roughness: f64,
    pub energy: f64,
}

impl Tube {
    /// m³.
    pub(super) fn volume(&self) -> f64 {
        0.25 * PI * self.diameter * self.diameter * self.length
    }

    /// Friction factor of Darcy at a mass flow (kg/s): that of Hagen and Poiseuille, or of
    /// Haaland (1983) where that is greater.
    fn friction(&self, flow: f64) -> f64 {
        let reynolds = 4.0 * flow / (PI * self.diameter * VISCOSITY);
        let laminar = 64.0 / reynolds;
        if reynolds < 500.0 {
            return laminar;
        }
        let rough = (self.roughness / self.diameter / 3.7).powf(1.11);
        laminar.max((-1.8 * (6.9 / reynolds + rough).log10()).powi(-2))
    }

    /// By how much the square of the pressure (Pa²) falls along it at a mass flow (kg/s) > 0: that
    /// of an isothermal gas, R T (f L/D + ends) G².
    pub(super) fn fall(&self, flow: f64) -> f64 {
        let each = flow / (0.25 * PI * self.diameter * self.diameter);
        self.energy * (self.friction(flow) * self.length / self.diameter + ENDS) * each * each
    }

    /// The mass flow (kg/s) at which the square of the pressure falls by `fall` (Pa²): of the sign
    /// of that.
    pub(super) fn flow(&self, fall: f64) -> f64 {
        let wanted = fall.abs();
        if wanted < 1.0 {
            return 0.0;
        }
        // The flow goes by the root where it is turbulent, and along a line where it is laminar.
        let mut flow = 1e-3 * (wanted / self.fall(1e-3)).sqrt();
        for _ in 0..50 {
            let part = wanted / self.fall(flow);
            let reynolds = 4.0 * flow / (PI * self.diameter * VISCOSITY);
            flow *= if reynolds < 500.0 {
                part.powf(0.8)
            } else {
                part.powf(0.55)
            };
            if (part - 1.0).abs() < 1e-10 {
                break;
            }
        }
        flow.copysign(fall)
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::motion::AIR;
    use super::*;

    /// A slow flow is that of Hagen and Poiseuille, a fast one loses f L/D of its dynamic pressure
    /// with the factor of Moody's chart; and a flow is the one that its fall belongs to.
    #[test]
    fn a_tube_in_closed_form() {
        let tube = Tube {
            length: 1.5,
            diameter: 4e-3,
            roughness: 0.0,
            energy: AIR.1 * 293.0,
        };
        let slow = 1e-6;
        let laminar = 256.0 * VISCOSITY * tube.length * tube.energy / (PI * tube.diameter.powi(4));
        // Its ends take 1.5 dynamic pressures beside 64/Re times 375, Re 17.5.
        let ends = 1.5 / (64.0 / 17.5 * 375.0);
        assert!((tube.fall(slow) / (laminar * slow) - 1.0 - ends).abs() < 1e-2 * ends);
        // Re 1e5: 0.0180 for a smooth tube (e.g. White, Fluid Mechanics, fig. 6.13), Haaland to 2 %.
        let fast = 1e5 * 0.25 * PI * tube.diameter * VISCOSITY;
        assert!((tube.friction(fast) / 0.0180 - 1.0).abs() < 0.02);
        for flow in [1e-7, 1e-5, 5e-5, 3e-4, 5e-3] {
            assert!(
                (tube.flow(tube.fall(flow)) / flow - 1.0).abs() < 1e-9,
                "{flow}"
            );
            assert!(
                (tube.flow(-tube.fall(flow)) / flow + 1.0).abs() < 1e-9,
                "{flow}"
            );
        }
    }

    /// Without heat, gas in a closed room stays on its adiabat; without resistance of the wall, on
    /// its isotherm.
    #[test]
    fn a_closed_room_in_closed_form() {
        let volume = |t: f64| [1e-4 * (1.0 - 4.0 * t), -4e-4];
        for (resistance, power) in [(f64::INFINITY, AIR.0), (0.0, 1.0)] {
            let rates = |t: f64, y: &[f64; 2]| {
                let [pressure, temperature] = *y;
                let room = Room {
                    pressure,
                    temperature,
                    volume: volume(t),
                };
                room.rates(AIR, &[], Wall(300.0, resistance))
            };
            let mut y = [1e5, 300.0];
            for k in 0..100 {
                y = super::super::super::motion::rk4(rates, 1e-3 * f64::from(k), &y, 1e-3);
            }
            let squeezed = 1.0 / 0.6_f64;
            assert!(
                (y[0] / (1e5 * squeezed.powf(power)) - 1.0).abs() < 1e-9,
                "{y:?}"
            );
            assert!(
                (y[1] / (300.0 * squeezed.powf(power - 1.0)) - 1.0).abs() < 1e-9,
                "{y:?}"
            );
        }
    }
}
