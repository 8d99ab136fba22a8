//! A part that swings about a fixed axis, with or without a torque.

use std::f64::consts::TAU;

use super::dial::{Dial, Hidden};
use super::draw::Draw;
use super::motion::{GRAVITY, first, rk4};
use super::sensing::Column;
use super::{Exact, World};

pub(super) const CAUSES: &[&str] = &[
    "inertia",
    "mass",
    "imbalance",
    "coulomb-friction",
    "viscous-friction",
    "air-drag",
    "encoder-scale",
    "sensor-offset",
    "sensor-delay",
];

pub(super) const OUTSIDE: &[&str] = &["cubic-spring", "gear-ripple", "ripple", "saturation"];

/// Time (s) between rows.
const ROW: f64 = 5e-3;

/// How a run goes: let go at an angle (rad), or driven from rest by two sines of amplitude (N m),
/// rate (rad/s) and phase.
#[derive(Clone, Copy, Debug)]
struct Drive {
    angle: f64,
    sines: [(f64, f64, f64); 2],
}

impl Drive {
    /// Torque (N m): it sets in smoothly, and is the same from one row to the next along a line.
    fn torque(&self, t: f64) -> f64 {
        let at = |t: f64| {
            let sum: f64 = self
                .sines
                .iter()
                .map(|(a, w, p)| a * (w * t + p).sin())
                .sum();
            (t / 0.3).clamp(0.0, 1.0) * sum
        };
        let row = (t / ROW + 1e-9).floor();
        let share = (t / ROW - row).clamp(0.0, 1.0);
        at(row * ROW) * (1.0 - share) + at((row + 1.0) * ROW) * share
    }
}

/// Runs of one part.
pub(super) struct Pendulums {
    columns: [Column; 2],
    mass: f64,
    centre: f64,
    inertia: f64,
    drives: Vec<Drive>,
}

impl Pendulums {
    pub(super) fn new(draw: &mut Draw) -> Pendulums {
        let rounded = |x: f64| (x * 1e3).round() * 1e-3;
        let (mass, centre) = (
            rounded(draw.scale(0.1, 5.0)),
            rounded(draw.scale(0.04, 0.5)),
        );
        let inertia = mass * centre * centre * draw.scale(0.05, 2.0);
        let moment = mass * GRAVITY * centre;
        let natural = (moment / (inertia + mass * centre * centre)).sqrt();
        let drives = (0..draw.one(&[4, 6])).map(|run| {
            if run % 2 == 0 {
                return Drive {
                    angle: draw.between(0.4, 1.6),
                    sines: [(0.0, 1.0, 0.0); 2],
                };
            }
            let sines = [(); 2].map(|()| {
                // Off its resonance, in which it would turn over.
                let rate = natural * draw.one(&[0.3, 0.5, 0.6, 1.6, 2.0, 3.0]);
                let size = moment * draw.between(0.05, 0.15);
                (size, rate, draw.between(0.0, TAU))
            });
            Drive { angle: 0.0, sines }
        });
        let drives = drives.collect();
        let mut angle = Column::noisy("angle_rad", draw.scale(3e-4, 2e-3));
        if draw.chance(0.5) {
            (angle.noise, angle.resolution) = (0.0, draw.one(&[7.67e-4, 1.5e-3]));
        }
        Pendulums {
            columns: [angle, Column::noisy("torque_nm", 0.0)],
            mass,
            centre,
            inertia,
            drives,
        }
    }

    fn run(&self, drive: &Drive, h: &Hidden) -> Exact {
        let axle = Axle::new(self, h);
        let mut exact = Exact {
            values: vec![Vec::new(); 2],
            ..Exact::default()
        };
        exact.settings = [
            ("mass_kg".to_owned(), self.mass),
            ("centre_from_axle_m".to_owned(), self.centre),
            ("inertia_about_centre_kg_m2".to_owned(), self.inertia),
        ]
        .into();
        let mut state = [drive.angle, 0.0];
        for row in 0..1200 {
            let t = f64::from(row) * ROW;
            exact.time.push(t);
            exact.values[0].push(state[0]);
            exact.values[1].push(drive.torque(t));
            for part in 0..5 {
                let h = 0.2 * ROW;
                axle.go(|t| drive.torque(t), t + f64::from(part) * h, &mut state, h);
            }
        }
        exact
    }
}

/// What acts on the part beside the drive.
struct Axle {
    inertia: f64,
    weight: f64,
    dry: f64,
    viscous: f64,
    drag: f64,
    cubic: f64,
}

impl Axle {
    fn new(part: &Pendulums, h: &Hidden) -> Axle {
        let mass = part.mass * h.get("mass_share", 1.0);
        let centre = part.centre + h.or_zero("imbalance_m");
        let about_axis = part.inertia + mass * centre * centre;
        Axle {
            inertia: about_axis * h.get("inertia_share", 1.0),
            weight: mass * GRAVITY * centre,
            dry: h.or_zero("coulomb_friction_n_m"),
            viscous: h.or_zero("viscous_friction_n_m_s_per_rad"),
            drag: h.or_zero("drag_n_m_s2_per_rad2"),
            cubic: h.or_zero("cubic_spring_n_m_per_rad3"),
        }
    }

    /// Torque (N m) of all but dry friction.
    fn free(&self, drive: f64, [angle, rate]: [f64; 2]) -> f64 {
        drive
            - self.weight * angle.sin()
            - self.cubic * angle.powi(3)
            - (self.viscous + self.drag * rate.abs()) * rate
    }

    /// Goes on by `h` seconds: turns one way, turns back, or sticks.
    fn go(&self, drive: impl Fn(f64) -> f64, mut t: f64, y: &mut [f64; 2], mut h: f64) {
        for _ in 0..8 {
            let pull = |t: f64| {
                let free = self.free(drive(t), [y[0], 0.0]);
                if free.abs() > self.dry {
                    free.signum()
                } else {
                    0.0
                }
            };
            let way = if y[1] == 0.0 { pull(t) } else { y[1].signum() };
            if way == 0.0 {
                if pull(t + h) == 0.0 {
                    return;
                }
                let part = first(h, |h| pull(t + h) != 0.0);
                (t, h) = (t + part, h - part);
                continue;
            }
            let rate = |t: f64, y: &[f64; 2]| {
                [
                    y[1],
                    (self.free(drive(t), *y) - way * self.dry) / self.inertia,
                ]
            };
            let after = |h: f64| rk4(rate, t, y, h);
            let next = after(h);
            if next[1] * way >= 0.0 || self.dry == 0.0 {
                *y = next;
                return;
            }
            let part = first(h, |h| after(h)[1] * way < 0.0);
            *y = [after(part)[0], 0.0];
            (t, h) = (t + part, h - part);
        }
    }
}

impl World for Pendulums {
    fn columns(&self) -> &[Column] {
        &self.columns
    }

    fn runs(&self) -> usize {
        self.drives.len()
    }

    fn logs(&self, runs: &[usize], hidden: &Hidden) -> Vec<Option<Exact>> {
        runs.iter()
            .map(|run| Some(self.run(&self.drives[*run], hidden)))
            .collect()
    }

    fn dials(&self, id: &str, draw: &mut Draw) -> Option<Vec<Dial>> {
        let moment = self.mass * GRAVITY * self.centre;
        let rate = (moment / (self.inertia + self.mass * self.centre * self.centre)).sqrt();
        let either = |draw: &mut Draw| draw.one(&[0.7, 1.4]);
        Some(match id {
            "inertia" => vec![Dial::linear("inertia_share", 1.0, either(draw))],
            "mass" => vec![Dial::linear("mass_share", 1.0, either(draw))],
            "imbalance" => vec![Dial::up_to(
                "imbalance_m",
                self.centre * draw.one(&[-0.3, 0.4]),
            )],
            "coulomb-friction" => vec![Dial::up_to("coulomb_friction_n_m", 0.05 * moment)],
            "viscous-friction" => vec![Dial::up_to(
                "viscous_friction_n_m_s_per_rad",
                0.2 * moment / rate,
            )],
            "air-drag" => vec![Dial::up_to(
                "drag_n_m_s2_per_rad2",
                0.2 * moment / (rate * rate),
            )],
            "cubic-spring" => vec![Dial::up_to("cubic_spring_n_m_per_rad3", 0.3 * moment)],
            _ => return None,
        })
    }

    /// A commanded torque has no noise in terms of which its errors would be counted.
    fn sensed(&self, _: &str) -> Vec<&'static str> {
        vec!["angle_rad"]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A small swing without losses is a cosine; with dry friction each half swing is one about
    /// ±T/M, and so 2 T/M shorter.
    #[test]
    fn a_small_swing_in_closed_form() {
        let axle = |dry: f64| Axle {
            inertia: 0.5,
            weight: 2.0,
            dry,
            viscous: 0.0,
            drag: 0.0,
            cubic: 0.0,
        };
        let swung = |axle: &Axle, time: f64| {
            let mut state = [1e-3, 0.0];
            let h = time / 1000.0;
            for i in 0..1000 {
                axle.go(|_| 0.0, f64::from(i) * h, &mut state, h);
            }
            state[0]
        };
        assert!((swung(&axle(0.0), 1.0) - 1e-3 * 2.0_f64.cos()).abs() < 1e-9);
        let half = std::f64::consts::PI / 2.0;
        assert!((swung(&axle(2e-4), half) + 0.8e-3).abs() < 1e-8);
        assert!((swung(&axle(2e-4), 2.0 * half) - 0.6e-3).abs() < 1e-8);
    }
}
