//! A mass on a guide, driven by a measured force.

use std::f64::consts::TAU;

use super::dial::{Dial, Hidden};
use super::draw::Draw;
use super::motion::{first, rk4};
use super::sensing::Column;
use super::{Exact, World};

pub(super) const CAUSES: &[&str] = &[
    "coulomb-friction",
    "directional-friction",
    "viscous-friction",
    "return-spring",
    "air-drag",
    "mass",
    "encoder-scale",
    "sensor-offset",
    "sensor-delay",
];

pub(super) const OUTSIDE: &[&str] = &[
    "position-friction",
    "cubic-spring",
    "ripple",
    "gear-ripple",
    "saturation",
];

/// How the mass is driven: amplitudes (N), rates (rad/s) and phases of sines, all in a window that
/// opens and closes smoothly.
#[derive(Clone, Copy, Debug)]
struct Drive {
    sines: [(f64, f64, f64); 3],
    length: f64,
}

impl Drive {
    fn force(&self, t: f64) -> f64 {
        let window = (t / 0.2).clamp(0.0, 1.0).powi(2);
        window
            * self
                .sines
                .iter()
                .map(|(a, w, p)| a * (w * t + p).sin())
                .sum::<f64>()
    }
}

/// Runs of one mass.
pub(super) struct Slides {
    columns: [Column; 2],
    mass: f64,
    drives: Vec<Drive>,
    rate: f64,
}

impl Slides {
    /// The measured force has noise, which a model that is driven by it integrates twice.
    pub(super) fn new(draw: &mut Draw) -> Slides {
        let mut position = Column::noisy("position_m", 2e-4);
        if draw.chance(0.4) {
            (position.noise, position.resolution) =
                (draw.one(&[0.0, 1e-4]), draw.one(&[2e-4, 5e-4]));
        }
        let mass = (draw.scale(0.5, 4.0) * 1e3).round() * 1e-3;
        let drives = (0..draw.one(&[5, 6, 8])).map(|_| {
            // Fast enough that a mass without friction stays on the guide.
            let sines = [(); 3].map(|()| {
                let rate = TAU * draw.scale(1.0, 4.0);
                (
                    mass * draw.between(1.0, 4.0) * rate / 10.0,
                    rate,
                    draw.between(0.0, TAU),
                )
            });
            Drive {
                sines,
                length: draw.between(0.7, 1.2),
            }
        });
        let drives = drives.collect();
        let rate = draw.one(&[500.0, 1000.0]);
        let force = Column::noisy("force_n", mass * draw.scale(1e-3, 1e-2));
        Slides {
            columns: [force, position],
            mass,
            drives,
            rate,
        }
    }

    fn run(&self, drive: &Drive, h: &Hidden) -> Exact {
        let guide = Guide::new(self.mass, h);
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a few thousand"
        )]
        let rows = (drive.length * self.rate) as usize;
        let (mut state, step) = ([0.0, 0.0], 1.0 / self.rate);
        let mut exact = Exact {
            values: vec![Vec::new(); 2],
            ..Exact::default()
        };
        exact.settings.insert("mass_kg".into(), self.mass);
        for row in 0..rows {
            let t = row as f64 * step;
            exact.time.push(t);
            exact.values[0].push(drive.force(t));
            exact.values[1].push(state[0]);
            for half in 0..2 {
                let h = 0.5 * step;
                guide.go(|t| drive.force(t), t + f64::from(half) * h, &mut state, h);
            }
        }
        exact
    }
}

/// What acts on the mass beside the drive.
struct Guide {
    mass: f64,
    /// Dry friction forward and back.
    coulomb: [f64; 2],
    viscous: f64,
    spring: (f64, f64, f64),
    drag: f64,
    rough: (f64, f64),
}

impl Guide {
    fn new(mass: f64, h: &Hidden) -> Guide {
        let spring = (
            h.or_zero("leg.return_spring.stiffness_n_per_m"),
            h.or_zero("leg.return_spring.preload_n"),
            h.or_zero("cubic_spring_n_per_m3"),
        );
        Guide {
            mass: mass + h.or_zero("mass_kg added"),
            coulomb: ["coulomb_friction_forward_n", "coulomb_friction_back_n"]
                .map(|key| h.or_zero("leg.coulomb_friction_n") + h.or_zero(key)),
            viscous: h.or_zero("leg.viscous_friction_n_s_per_m"),
            spring,
            drag: h.or_zero("environment.drag_per_m"),
            rough: (h.or_zero("rough_n"), h.get("rough_length_m", 1.0)),
        }
    }

    /// Dry friction (N) against a motion that goes forward (1) or back (−1).
    fn dry(&self, x: f64, way: f64) -> f64 {
        self.coulomb[usize::from(way < 0.0)] + self.rough.0 * (1.0 + (TAU * x / self.rough.1).sin())
    }

    /// Force (N) of all but dry friction.
    fn free(&self, drive: f64, [x, v]: [f64; 2]) -> f64 {
        let (k, preload, cubic) = self.spring;
        drive
            - (k + cubic * x * x) * x
            - preload
            - (self.viscous + self.drag * self.mass * v.abs()) * v
    }

    /// Goes on by `h` seconds: slides one way, turns, or sticks.
    fn go(&self, drive: impl Fn(f64) -> f64, mut t: f64, y: &mut [f64; 2], mut h: f64) {
        for _ in 0..8 {
            let pull = |t: f64, x: f64| {
                let free = self.free(drive(t), [x, 0.0]);
                if free.abs() > self.dry(x, free) {
                    free.signum()
                } else {
                    0.0
                }
            };
            let way = if y[1] == 0.0 {
                pull(t, y[0])
            } else {
                y[1].signum()
            };
            if way == 0.0 {
                // Held until the drive is stronger.
                if pull(t + h, y[0]) == 0.0 {
                    return;
                }
                let part = first(h, |h| pull(t + h, y[0]) != 0.0);
                (t, h) = (t + part, h - part);
                continue;
            }
            let rate = |t: f64, y: &[f64; 2]| {
                [
                    y[1],
                    (self.free(drive(t), *y) - way * self.dry(y[0], way)) / self.mass,
                ]
            };
            let after = |h: f64| rk4(rate, t, y, h);
            let next = after(h);
            if next[1] * way >= 0.0 || self.dry(y[0], way) == 0.0 {
                *y = next;
                return;
            }
            let part = first(h, |h| after(h)[1] * way < 0.0);
            *y = [after(part)[0], 0.0];
            (t, h) = (t + part, h - part);
        }
    }
}

impl World for Slides {
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
        Some(match id {
            "coulomb-friction" => vec![Dial::up_to("leg.coulomb_friction_n", 1.5 * self.mass)],
            "directional-friction" => {
                let [least, most] = [draw.between(0.1, 0.4), 1.5].map(|share| share * self.mass);
                let [forward, back] = draw.one(&[[least, most], [most, least]]);
                vec![
                    Dial::up_to("coulomb_friction_forward_n", forward),
                    Dial::up_to("coulomb_friction_back_n", back),
                ]
            }
            "viscous-friction" => vec![Dial::up_to(
                "leg.viscous_friction_n_s_per_m",
                10.0 * self.mass,
            )],
            "return-spring" => vec![
                Dial::up_to(
                    "leg.return_spring.stiffness_n_per_m",
                    self.mass * draw.between(2.0, 20.0),
                ),
                Dial::up_to(
                    "leg.return_spring.preload_n",
                    self.mass * draw.between(0.05, 0.5),
                ),
            ],
            "air-drag" => vec![Dial::up_to("environment.drag_per_m", 2.0)],
            "mass" => vec![Dial::up_to(
                "mass_kg added",
                self.mass * draw.one(&[-0.3, 0.5]),
            )],
            "position-friction" => vec![
                Dial::up_to("rough_n", self.mass),
                Dial::fixed("rough_length_m", draw.between(0.02, 0.08)),
            ],
            "cubic-spring" => vec![Dial::up_to("cubic_spring_n_per_m3", 200.0 * self.mass)],
            _ => return None,
        })
    }

    fn sensed(&self, id: &str) -> Vec<&'static str> {
        // Where the guide begins nobody knows, and a gear is on the position.
        match id {
            "sensor-offset" => vec!["force_n"],
            "gear-ripple" => vec!["position_m"],
            _ => vec!["force_n", "position_m"],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn guide(values: &[(&'static str, f64)]) -> Guide {
        let dials: Vec<Dial> = values
            .iter()
            .map(|(key, value)| Dial::fixed(*key, *value))
            .collect();
        Guide::new(2.0, &Hidden::of(&dials, 1.0))
    }

    fn pushed(guide: &Guide, force: f64, start: [f64; 2], time: f64) -> [f64; 2] {
        let mut state = start;
        let steps = 1000;
        for i in 0..steps {
            let h = time / f64::from(steps);
            guide.go(|_| force, f64::from(i) * h, &mut state, h);
        }
        state
    }

    #[test]
    fn friction_stops_a_mass_and_holds_it() {
        // v²/2 = a x with a = F/m; it comes to rest after 1 s, and 2.5 N do not move it.
        let guide = guide(&[("leg.coulomb_friction_n", 3.0)]);
        let [x, v] = pushed(&guide, 0.0, [0.0, 1.5], 2.0);
        assert!((x - 0.75).abs() < 1e-9 && v == 0.0, "{x} {v}");
        assert_eq!(pushed(&guide, 2.5, [0.0, 0.0], 1.0), [0.0, 0.0]);
        assert!((pushed(&guide, 4.0, [0.0, 0.0], 1.0)[0] - 0.25).abs() < 1e-9);
        // Back it is held by 1 N alone.
        let (forward, back) = (
            ("coulomb_friction_forward_n", 3.0),
            ("coulomb_friction_back_n", 1.0),
        );
        let guide = self::guide(&[forward, back]);
        assert!((pushed(&guide, 4.0, [0.0, 0.0], 1.0)[0] - 0.25).abs() < 1e-9);
        assert!((pushed(&guide, -2.0, [0.0, 0.0], 1.0)[0] + 0.25).abs() < 1e-9);
    }

    #[test]
    fn drag_in_closed_form() {
        // x = ln(1 + c v₀ t)/c.
        let [x, _] = pushed(
            &guide(&[("environment.drag_per_m", 0.4)]),
            0.0,
            [0.0, 2.0],
            1.5,
        );
        assert!(
            (x - (1.0_f64 + 0.4 * 2.0 * 1.5).ln() / 0.4).abs() < 1e-9,
            "{x}"
        );
    }

    #[test]
    fn a_spring_in_closed_form() {
        let spring = guide(&[
            ("leg.return_spring.stiffness_n_per_m", 18.0),
            ("leg.return_spring.preload_n", 1.8),
        ]);
        let [x, _] = pushed(&spring, 0.0, [0.1, 0.0], 1.0);
        assert!((x - (-0.1 + 0.2 * 3.0_f64.cos())).abs() < 1e-9, "{x}");
    }
}
