//! A body in free flight or fall, or a robot in flight at the end of a boom.

use std::f64::consts::PI;

use super::dial::{Dial, Hidden};
use super::draw::Draw;
use super::motion::{GRAVITY, rk4};
use super::sensing::Column;
use super::{Exact, World};

/// A delayed sensor is not among them: a later start is as good an explanation.
pub(super) const CAUSES: &[&str] = &["air-drag", "gravity", "counterweight", "encoder-scale"];

pub(super) const OUTSIDE: &[&str] = &[
    "linear-drag",
    "lift",
    "side-wind",
    "ripple",
    "gear-ripple",
    "saturation",
    "turn-damping",
];

/// Where a flight starts: places (m) and speeds (m/s), and how long it is (s).
#[derive(Clone, Copy, Debug)]
struct Throw {
    start: [f64; 4],
    length: f64,
}

/// Flights of one body, thrown or dropped, or at the end of a boom.
pub(super) struct Flights {
    columns: Vec<Column>,
    throws: Vec<Throw>,
    rate: f64,
    boom: Option<f64>,
    /// Mass (kg) and diameter (m), where the operator tells.
    body: Option<(f64, f64)>,
}

impl Flights {
    /// Flights in which each of `ids` can show.
    pub(super) fn new(ids: &[&str], draw: &mut Draw) -> Flights {
        let asks = |any: &[&str]| ids.iter().any(|id| any.contains(id));
        let on_boom = asks(&["counterweight", "turn-damping"])
            || (!asks(&["lift", "side-wind"]) && draw.chance(0.25));
        let across = on_boom || asks(&["lift", "side-wind"]) || draw.chance(0.6);
        let noise = draw.scale(2e-3, 1e-2);
        let mut columns = vec![Column::noisy("y_m", noise)];
        if across {
            columns.insert(0, Column::noisy("x_m", noise));
        }
        let (rate, body) = (draw.one(&[50.0, 100.0, 200.0]), draw.chance(0.5));
        let body = body.then(|| (draw.scale(0.05, 3.0), draw.between(0.06, 0.25)));
        let throws = (0..draw.one(&[4, 6, 8])).map(|_| {
            if on_boom {
                let (forward, up) = (draw.between(0.0, 1.5), draw.between(1.0, 2.5));
                Throw {
                    start: [0.0, draw.between(0.0, 0.1), forward, up],
                    length: 2.0 * up / GRAVITY,
                }
            } else if across {
                let (forward, up) = (draw.between(2.0, 8.0), draw.between(3.0, 8.0));
                Throw {
                    start: [0.0, draw.between(1.0, 2.0), forward, up],
                    length: 2.2 * up / GRAVITY,
                }
            } else {
                let height = draw.between(5.0, 30.0);
                Throw {
                    start: [0.0, height, 0.0, 0.0],
                    length: 0.9 * (2.0 * height / GRAVITY).sqrt(),
                }
            }
        });
        let throws = throws.collect();
        let boom = on_boom.then(|| (draw.between(1.0, 2.2) * 1e3).round() * 1e-3);
        Flights {
            columns,
            throws,
            rate,
            boom,
            body: body.filter(|_| !on_boom),
        }
    }

    fn fly(&self, throw: &Throw, hidden: &Hidden) -> Exact {
        let forces = Forces::new(hidden);
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a few hundred"
        )]
        let rows = (throw.length * self.rate) as usize + 1;
        let (mut state, h) = (throw.start, 0.1 / self.rate);
        if let Some(length) = self.boom {
            // Angles, and their rates: x along the arc, y the height.
            let pivot = (state[1] / length).asin();
            state = [
                state[0] / length,
                pivot,
                state[2] / length,
                state[3] / length / pivot.cos(),
            ];
        }
        let (mut time, mut places) = (Vec::with_capacity(rows), [Vec::new(), Vec::new()]);
        for row in 0..rows {
            time.push(row as f64 / self.rate);
            let [x, y] = match self.boom {
                None => [state[0], state[1]],
                Some(length) => [length * state[0], length * state[1].sin()],
            };
            places[0].push(x);
            places[1].push(y);
            for _ in 0..10 {
                state = rk4(
                    |_, y| match self.boom {
                        None => forces.free(y),
                        Some(length) => forces.on_boom(y, length),
                    },
                    0.0,
                    &state,
                    h,
                );
            }
        }
        let mut settings = Vec::new();
        if let Some((mass, diameter)) = self.body {
            settings.extend([
                ("mass_kg".to_owned(), mass),
                ("diameter_m".to_owned(), diameter),
            ]);
        }
        settings.extend(self.boom.map(|length| ("boom_radius_m".to_owned(), length)));
        let [x, y] = places;
        let values = if self.columns.len() == 1 {
            vec![y]
        } else {
            vec![x, y]
        };
        Exact {
            settings: settings.into_iter().collect(),
            valve: None,
            time,
            values,
        }
    }
}

/// What acts on a body in the air, each as an acceleration.
struct Forces {
    gravity: f64,
    drag: f64,
    linear: f64,
    lift: f64,
    wind: f64,
    /// The counterweight's moment over that of the body, and its moment of inertia over the body's.
    counterweight: (f64, f64),
    turn: f64,
}

impl Forces {
    fn new(h: &Hidden) -> Forces {
        let (mass, place) = (
            h.or_zero("counterweight mass_ratio"),
            h.or_zero("counterweight distance_ratio"),
        );
        Forces {
            gravity: h.get("environment.gravity_m_s2", GRAVITY),
            drag: h.or_zero("environment.drag_per_m"),
            linear: h.or_zero("linear_drag_per_s"),
            lift: h.or_zero("lift_per_s"),
            wind: h.or_zero("side_wind_m_s2"),
            counterweight: (mass * place, mass * place * place),
            turn: h.or_zero("turn_damping_per_s"),
        }
    }

    /// Accelerations by the air at the velocity (u, v).
    fn air(&self, u: f64, v: f64) -> [f64; 2] {
        let along = self.drag * u.hypot(v) + self.linear;
        [
            -along * u - self.lift * v + self.wind,
            -along * v + self.lift * u,
        ]
    }

    fn free(&self, &[_, _, u, v]: &[f64; 4]) -> [f64; 4] {
        let [ax, ay] = self.air(u, v);
        [u, v, ax, ay - self.gravity]
    }

    /// A point at the end of a massless boom that turns and pivots about its base, a counterweight
    /// behind it.
    fn on_boom(&self, &[_, pivot, turning, pivoting]: &[f64; 4], length: f64) -> [f64; 4] {
        let (sin, cos) = pivot.sin_cos();
        let (moment, inertia) = (1.0 - self.counterweight.0, 1.0 + self.counterweight.1);
        // Along the turn and along the pivot.
        let air = self
            .air(length * cos * turning, length * pivoting)
            .map(|a| a / length / inertia);
        let turn = air[0] / cos + 2.0 * sin / cos * pivoting * turning - self.turn * turning;
        let fall = -self.gravity * moment * cos / (length * inertia)
            - sin * cos * turning * turning
            + air[1];
        [turning, pivoting, turn, fall]
    }
}

impl World for Flights {
    fn columns(&self) -> &[Column] {
        &self.columns
    }

    fn runs(&self) -> usize {
        self.throws.len()
    }

    fn logs(&self, runs: &[usize], hidden: &Hidden) -> Vec<Option<Exact>> {
        runs.iter()
            .map(|run| Some(self.fly(&self.throws[*run], hidden)))
            .collect()
    }

    fn dials(&self, id: &str, draw: &mut Draw) -> Option<Vec<Dial>> {
        let way = draw.one(&[-1.0, 1.0]);
        Some(match id {
            "air-drag" => vec![Dial::up_to("environment.drag_per_m", 1.0)],
            "gravity" => {
                vec![Dial::linear(
                    "environment.gravity_m_s2",
                    GRAVITY,
                    GRAVITY * (1.0 + 0.4 * way),
                )]
            }
            "counterweight" => vec![
                Dial::up_to("counterweight mass_ratio", 0.9),
                Dial::fixed("counterweight distance_ratio", draw.between(0.3, 0.8)),
            ],
            "linear-drag" => vec![Dial::up_to("linear_drag_per_s", 2.0)],
            "lift" => vec![Dial::up_to("lift_per_s", way * PI / 2.0)],
            "side-wind" => vec![Dial::up_to("side_wind_m_s2", way * 3.0)],
            "turn-damping" => vec![Dial::up_to("turn_damping_per_s", 5.0)],
            _ => return None,
        })
    }

    /// A wrong scale of x is another speed, which nobody knows.
    fn sensed(&self, id: &str) -> Vec<&'static str> {
        let is_seen = |name: &&str| id != "encoder-scale" || *name == "y_m";
        self.columns
            .iter()
            .map(|column| column.name)
            .filter(is_seen)
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fall() -> Flights {
        Flights {
            columns: vec![Column::noisy("y_m", 1e-3)],
            throws: Vec::new(),
            rate: 50.0,
            boom: None,
            body: None,
        }
    }

    /// From rest with drag: y = y₀ − ln cosh(t √(g c))/c.
    #[test]
    fn a_fall_with_drag_in_closed_form() {
        let throw = Throw {
            start: [0.0, 30.0, 0.0, 0.0],
            length: 2.0,
        };
        let c = 0.05;
        let drag = Hidden::of(&[Dial::fixed("environment.drag_per_m", c)], 1.0);
        let run = fall().fly(&throw, &drag);
        for (t, y) in run.time.iter().zip(&run.values[0]) {
            assert!(
                (y - (30.0 - (t * (GRAVITY * c).sqrt()).cosh().ln() / c)).abs() < 1e-9,
                "{t}"
            );
        }
    }

    /// A lift ∝ v turns the velocity without changing its length where nothing else acts.
    #[test]
    fn lift_turns_the_velocity() {
        let throw = Throw {
            start: [0.0, 0.0, 3.0, 0.0],
            length: 1.0,
        };
        let lift = [
            Dial::fixed("lift_per_s", 0.5),
            Dial::fixed("environment.gravity_m_s2", 0.0),
        ];
        let run = fall().fly(&throw, &Hidden::of(&lift, 1.0));
        for (t, y) in run.time.iter().zip(&run.values[0]) {
            assert!((y - 6.0 * (1.0 - (0.5 * t).cos())).abs() < 1e-9, "{t}");
        }
    }

    /// On a boom energy is kept, and so is the moment of momentum about the vertical.
    #[test]
    fn a_boom_keeps_energy_and_momentum() {
        let forces = Forces {
            counterweight: (0.4, 0.2),
            ..Forces::new(&Hidden::default())
        };
        let mut state = [0.0, 0.1, 1.5, 2.0];
        let numbers = |&[_, pivot, turning, pivoting]: &[f64; 4]| {
            let around = pivot.cos().powi(2) * turning;
            let energy = 0.5 * 1.2 * (pivoting * pivoting + around * turning);
            (energy + GRAVITY * 0.6 / 1.5 * pivot.sin(), around)
        };
        let before = numbers(&state);
        for _ in 0..500 {
            state = rk4(|_, y| forces.on_boom(y, 1.5), 0.0, &state, 1e-3);
        }
        let after = numbers(&state);
        assert!(
            (before.0 - after.0).abs() < 1e-9 && (before.1 - after.1).abs() < 1e-9,
            "{before:?} {after:?}"
        );
    }
}
