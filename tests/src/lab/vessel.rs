//! A vessel filling or discharging through an orifice.

use std::f64::consts::PI;

use super::dial::{Dial, Hidden};
use super::draw::Draw;
use super::motion::{AIR, CARBON_DIOXIDE, GRAVITY, nozzle, rk4};
use super::sensing::Column;
use super::{Exact, World};

pub(super) const CAUSES: &[&str] = &[
    "heat-transfer",
    "gas-type",
    "encoder-scale",
    "sensor-offset",
];

pub(super) const OUTSIDE: &[&str] = &[
    "valve-ramp",
    "clogging",
    "ripple",
    "gear-ripple",
    "saturation",
];

/// What was set of a run.
#[derive(Clone, Copy, Debug)]
struct Setting {
    pressure: f64,
    temperature: f64,
    /// Pressure (Pa) on the other side of the orifice; where it is above, the vessel fills from it.
    outside: f64,
    length: f64,
}

/// Runs of one vessel.
pub(super) struct Vessels {
    columns: Vec<Column>,
    volume: f64,
    wall: f64,
    /// Whether the operator knows the wall's area.
    wall_known: bool,
    orifice: f64,
    discharge: f64,
    settings: Vec<Setting>,
    rows: usize,
}

impl Vessels {
    pub(super) fn new(ids: &[&str], draw: &mut Draw) -> Vessels {
        let volume = draw.scale(0.002, 0.05);
        let orifice = draw.between(1.5e-3, 4e-3);
        let discharge = draw.between(0.6, 0.95);
        // Time in which the gas would be gone at the first rate.
        let scale = volume / (discharge * PI / 4.0 * orifice * orifice * 0.685 * 290.0);
        let count = draw.one(&[4, 5, 6]);
        let settings = (0..count).map(|k| {
            let temperature = draw.between(288.0, 300.0);
            let length = scale * draw.between(1.5, 3.0);
            let high = draw.between(4e5, 12e5);
            if k % 3 == 2 {
                Setting {
                    pressure: 1e5,
                    temperature,
                    outside: high,
                    length,
                }
            } else {
                Setting {
                    pressure: high,
                    temperature,
                    outside: 1e5,
                    length,
                }
            }
        });
        let settings = settings.collect();
        let mut columns = vec![Column::noisy("pressure_pa", 3000.0)];
        if ids
            .iter()
            .any(|id| ["heat-transfer", "gas-type"].contains(id))
            || draw.chance(0.7)
        {
            columns.push(Column::noisy("temperature_k", 1.0));
        }
        Vessels {
            columns,
            volume,
            wall: (36.0 * PI).cbrt() * volume.powf(2.0 / 3.0) * draw.between(1.1, 1.6),
            wall_known: draw.chance(0.8) || ids.contains(&"heat-transfer"),
            orifice,
            discharge,
            settings,
            rows: draw.one(&[60, 100, 150]),
        }
    }

    fn run(&self, setting: &Setting, hidden: &Hidden) -> Exact {
        let gas = (
            hidden.get("gas.heat_ratio", AIR.0),
            hidden.get("gas.constant_j_per_kg_k", AIR.1),
        );
        let area = self.discharge * PI / 4.0 * self.orifice * self.orifice;
        let convection = hidden.or_zero("convection");
        let (ramp, clog) = (
            hidden.or_zero("valve_ramp_s"),
            hidden.or_zero("clogging_per_s"),
        );
        let rates = |t: f64, &[mass, energy]: &[f64; 2]| {
            let (pressure, temperature) = state(gas, self.volume, [mass, energy]);
            let part = if ramp > 0.0 { (t / ramp).min(1.0) } else { 1.0 } * (-clog * t).exp();
            // Enthalpy of the side that the gas comes from.
            let inwards = setting.outside > pressure;
            let source = if inwards {
                setting.temperature
            } else {
                temperature
            };
            let flow = nozzle(part * area, gas, source, setting.outside, pressure);
            let enthalpy = gas.0 / (gas.0 - 1.0) * gas.1 * source;
            let heat = if convection > 0.0 {
                convection
                    * self.wall
                    * per_area(gas, mass / self.volume, setting.temperature, temperature)
            } else {
                0.0
            };
            [flow, flow * enthalpy + heat]
        };
        let mass = setting.pressure * self.volume / (gas.1 * setting.temperature);
        let mut y = [mass, setting.pressure * self.volume / (gas.0 - 1.0)];
        let mut exact = Exact {
            values: vec![Vec::new(); self.columns.len()],
            ..Exact::default()
        };
        let keys = [
            ("volume_m3", self.volume),
            ("orifice_diameter_m", self.orifice),
            ("initial_pressure_pa", setting.pressure),
            ("initial_temperature_k", setting.temperature),
            ("ambient_pressure_pa", setting.outside),
        ];
        exact.settings = keys.map(|(key, value)| (key.to_owned(), value)).into();
        if self.wall_known {
            exact.settings.insert("wall_area_m2".into(), self.wall);
        }
        let between = setting.length / self.rows as f64;
        for row in 0..=self.rows {
            let t = row as f64 * between;
            let (pressure, temperature) = state(gas, self.volume, y);
            exact.time.push(t);
            for (values, value) in exact.values.iter_mut().zip([pressure, temperature]) {
                values.push(value);
            }
            for part in 0..20 {
                let h = between / 20.0;
                y = rk4(rates, t + f64::from(part) * h, &y, h);
            }
        }
        exact
    }
}

/// Pressure (Pa) and temperature (K) of a perfect gas of this mass (kg) and inner energy (J) in a
/// volume (m³).
fn state((kappa, gas): (f64, f64), volume: f64, [mass, energy]: [f64; 2]) -> (f64, f64) {
    (
        (kappa - 1.0) * energy / volume,
        (kappa - 1.0) * energy / (mass * gas),
    )
}

/// Heat flux (W/m²) from a wall at `wall` kelvin to a gas at `inside`, by natural convection with
/// Nu = Ra^⅓: the length drops out.
fn per_area((kappa, gas): (f64, f64), density: f64, wall: f64, inside: f64) -> f64 {
    let film = 0.5 * (wall + inside);
    // Sutherland's viscosity of air, and its conductivity by a Prandtl number of 0.71.
    let viscosity = 1.716e-5 * (film / 273.15).powf(1.5) * (273.15 + 110.4) / (film + 110.4);
    let heat_capacity = kappa / (kappa - 1.0) * gas;
    let conductivity = viscosity * heat_capacity / 0.71;
    let rayleigh_per_length_cubed =
        GRAVITY / film * (wall - inside).abs() * density * density * heat_capacity
            / (viscosity * conductivity);
    conductivity * rayleigh_per_length_cubed.cbrt() * (wall - inside)
}

impl World for Vessels {
    fn columns(&self) -> &[Column] {
        &self.columns
    }

    fn runs(&self) -> usize {
        self.settings.len()
    }

    fn logs(&self, runs: &[usize], hidden: &Hidden) -> Vec<Option<Exact>> {
        runs.iter()
            .map(|run| Some(self.run(&self.settings[*run], hidden)))
            .collect()
    }

    fn dials(&self, id: &str, draw: &mut Draw) -> Option<Vec<Dial>> {
        let longest = self
            .settings
            .iter()
            .map(|setting| setting.length)
            .fold(0.0, f64::max);
        Some(match id {
            "heat-transfer" => vec![Dial::up_to("convection", 0.2)],
            "gas-type" => vec![
                Dial::fixed("gas.heat_ratio", CARBON_DIOXIDE.0),
                Dial::fixed("gas.constant_j_per_kg_k", CARBON_DIOXIDE.1),
            ],
            "valve-ramp" => vec![Dial::up_to(
                "valve_ramp_s",
                longest * draw.between(0.2, 0.5),
            )],
            "clogging" => vec![Dial::up_to("clogging_per_s", 3.0 / longest)],
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Choked and adiabatic: T falls as 1/(1 + t/τ)² with τ = 2 V/((κ − 1) C_d A √(κ R T₀)
    /// (2/(κ+1))^((κ+1)/(2(κ−1)))), on the isentrope.
    #[test]
    fn a_choked_discharge_in_closed_form() {
        let vessels = Vessels::new(&["gas-type"], &mut Draw::new(5, 0));
        let setting = Setting {
            pressure: 9e5,
            temperature: 295.0,
            outside: 1e5,
            length: 10.0,
        };
        let run = vessels.run(&setting, &Hidden::default());
        let area = vessels.discharge * PI / 4.0 * vessels.orifice * vessels.orifice;
        let speed = (1.4 * 287.05 * 295.0_f64).sqrt();
        let tau = 2.0 * vessels.volume / (0.4 * area * speed * (2.0_f64 / 2.4).powi(3));
        for (k, t) in run.time.iter().enumerate() {
            let (p, cooled) = (run.values[0][k], (1.0 + t / tau).powi(-2));
            let isentropic = 9e5 * cooled.powf(3.5);
            // Choked to 1.89 times the pressure outside.
            if isentropic > 1.9e5 {
                assert!((p / isentropic - 1.0).abs() < 1e-7, "{t}");
                assert!(
                    (run.values[1][k] / (295.0 * cooled) - 1.0).abs() < 1e-7,
                    "{t}"
                );
            }
        }
    }

    /// Gas that fills a vessel without losses brings its enthalpy, κ times its inner energy: m =
    /// m₀ + (p − p₀) V/(κ R T).
    #[test]
    fn a_filled_vessel_is_warm() {
        let vessels = Vessels::new(&["gas-type"], &mut Draw::new(6, 0));
        let setting = Setting {
            pressure: 1e5,
            temperature: 300.0,
            outside: 5e5,
            length: 200.0,
        };
        let run = vessels.run(&setting, &Hidden::default());
        for (p, t) in run.values[0].iter().zip(&run.values[1]) {
            let mixed = p / (1e5 / 300.0 + (p - 1e5) / (1.4 * 300.0));
            // Steps do not see where the flow turns laminar, at the end.
            assert!((t - mixed).abs() < 0.02, "{p} {t} {mixed}");
        }
        assert!(run.values[0][60] > 4.9e5);
    }

    /// With a very good wall the gas keeps the wall's temperature.
    #[test]
    fn a_good_wall_keeps_the_temperature() {
        let vessels = Vessels::new(&["heat-transfer"], &mut Draw::new(7, 0));
        let setting = Setting {
            pressure: 9e5,
            temperature: 295.0,
            outside: 1e5,
            length: 20.0,
        };
        let coldest = |c: f64| {
            let hidden = Hidden::of(&[Dial::fixed("convection", c)], 1.0);
            vessels.run(&setting, &hidden).values[1]
                .iter()
                .copied()
                .fold(f64::INFINITY, f64::min)
        };
        assert!(coldest(0.0) < coldest(0.13) && coldest(0.13) < coldest(1.0));
        assert!(coldest(3.0) > 280.0, "{}", coldest(3.0));
    }
}
