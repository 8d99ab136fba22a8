//! A piston moved slowly back and forth under regulated pressure.

use std::f64::consts::{PI, TAU};

use super::dial::{Dial, Hidden};
use super::draw::Draw;
use super::sensing::Column;
use super::{Exact, World};

pub(super) const CAUSES: &[&str] = &[
    "coulomb-friction",
    "directional-friction",
    "seal-friction",
    "viscous-friction",
    "return-spring",
    "encoder-scale",
    "sensor-offset",
];

pub(super) const OUTSIDE: &[&str] = &[
    "position-friction",
    "stribeck",
    "ripple",
    "gear-ripple",
    "saturation",
];

/// One test: a set pressure, and how the piston is moved.
#[derive(Clone, Copy, Debug)]
struct Test {
    pressure: f64,
    /// Least and greatest position (m).
    low: f64,
    high: f64,
    /// Speed (m/s) between the reversals, and how long each takes (s).
    speed: f64,
    reversal: f64,
    regulator: f64,
}

/// Tests of one piston at several pressures.
pub(super) struct Strokes {
    columns: [Column; 3],
    bore: f64,
    tests: Vec<Test>,
    rate: f64,
    /// Way (m) over which friction turns over, and how the seal stands at the start, from −1 to 1.
    presliding: f64,
    seal: f64,
}

impl Strokes {
    pub(super) fn new(draw: &mut Draw) -> Strokes {
        let tests = draw.one(&[4, 5, 6]);
        let test = |k: usize, draw: &mut Draw| Test {
            pressure: 1e5 + 6e5 * k as f64 / (tests - 1) as f64,
            low: draw.between(0.003, 0.01),
            high: draw.between(0.05, 0.09),
            speed: draw.scale(2e-3, 2e-2),
            reversal: draw.between(0.1, 0.4),
            regulator: draw.between(500.0, 3000.0),
        };
        Strokes {
            columns: [
                Column::noisy("position_m", 1e-5),
                Column::noisy("pressure_gauge_pa", 50.0),
                Column::noisy("force_n", 0.06),
            ],
            bore: draw.one(&[0.016, 0.01905, 0.025]),
            tests: (0..tests).map(|k| test(k, draw)).collect(),
            rate: draw.one(&[20.0, 50.0]),
            presliding: draw.scale(5e-5, 3e-4),
            seal: draw.between(-1.0, 1.0),
        }
    }

    fn run(&self, test: &Test, h: &Hidden) -> Exact {
        let area = PI / 4.0 * self.bore * self.bore;
        let both = h.or_zero("leg.coulomb_friction_n");
        let [forward, back] = ["coulomb_friction_forward_n", "coulomb_friction_back_n"]
            .map(|key| both + h.or_zero(key));
        let (seal, viscous) = (
            h.or_zero("leg.seal_friction_n_per_pa"),
            h.or_zero("leg.viscous_friction_n_s_per_m"),
        );
        let spring = (
            h.or_zero("leg.return_spring.stiffness_n_per_m"),
            h.or_zero("leg.return_spring.preload_n"),
        );
        let (rough, waves) = (h.or_zero("rough_n"), h.get("rough_length_m", 1.0));
        let (stribeck, slow) = (h.or_zero("stribeck_n"), h.get("stribeck_m_s", 1.0));
        let there = (test.high - test.low) / test.speed;
        let mut exact = Exact {
            values: vec![Vec::new(); 3],
            ..Exact::default()
        };
        exact.settings.insert("bore_m".into(), self.bore);
        let length = test.length();
        let (mut t, mut state, mut before) = (0.0, self.seal, test.low);
        let retracted = self.tests.iter().map(Test::farthest).fold(0.0, f64::max);
        while t < length {
            let (position, speed) = test.moved(t, there);
            let moved: f64 = position - before;
            // After Dahl: friction comes to its full value over the presliding way, exactly for a
            // way one way.
            state =
                moved.signum() + (state - moved.signum()) * (-moved.abs() / self.presliding).exp();
            before = position;
            // The regulator gives way a little: it lets out air while the piston retracts.
            let pressure = test.pressure
                + test.regulator * (0.7 * speed / test.speed + 0.3 * (TAU * t / 7.0).sin());
            let dry = seal * pressure
                + rough * (1.0 + (TAU * position / waves).sin())
                + stribeck * (-(speed / slow).powi(2)).exp();
            // The seal that is turned one way is held by the friction of that way.
            let rubs = 0.5 * ((1.0 + state) * forward - (1.0 - state) * back);
            let extension = retracted - position;
            let force = pressure * area + state * dry + rubs + viscous * speed
                - spring.0 * extension
                - spring.1;
            exact.time.push(t);
            for (values, value) in exact.values.iter_mut().zip([position, pressure, force]) {
                values.push(value);
            }
            t = exact.time.len() as f64 / self.rate;
        }
        exact
    }
}

impl Test {
    /// Two ways there and back, at most 40 s.
    fn length(&self) -> f64 {
        let there = (self.high - self.low) / self.speed;
        (4.0 * (there + self.reversal)).min(40.0)
    }

    /// The greatest position (m) it comes to: from the farthest of all the spring is counted.
    fn farthest(&self) -> f64 {
        let there = (self.high - self.low) / self.speed;
        self.moved(self.length().min(there + self.reversal), there)
            .0
    }

    /// Position (m, retracting) and speed (m/s) at time `t`: to and fro, with rounded reversals.
    fn moved(&self, t: f64, there: f64) -> (f64, f64) {
        let half = there + self.reversal;
        let phase = t.rem_euclid(2.0 * half);
        let (t, way) = if phase < half {
            (phase, 1.0)
        } else {
            (phase - half, -1.0)
        };
        // Speed rises over half of a reversal, holds, and falls over the other half.
        let (up, v) = (0.5 * self.reversal, self.speed);
        let reach = v * (half - up);
        let (gone, speed) = if t < up {
            (0.5 * v * t * t / up, v * t / up)
        } else if t < half - up {
            (v * (t - 0.5 * up), v)
        } else {
            let left = half - t;
            (reach - 0.5 * v * left * left / up, v * left / up)
        };
        let start = if way > 0.0 {
            self.low
        } else {
            self.low + reach
        };
        (start + way * gone, way * speed)
    }
}

impl World for Strokes {
    fn columns(&self) -> &[Column] {
        &self.columns
    }

    fn runs(&self) -> usize {
        self.tests.len()
    }

    fn logs(&self, runs: &[usize], hidden: &Hidden) -> Vec<Option<Exact>> {
        runs.iter()
            .map(|run| Some(self.run(&self.tests[*run], hidden)))
            .collect()
    }

    fn dials(&self, id: &str, draw: &mut Draw) -> Option<Vec<Dial>> {
        Some(match id {
            "coulomb-friction" => vec![Dial::up_to("leg.coulomb_friction_n", 50.0)],
            "directional-friction" => vec![
                Dial::up_to("coulomb_friction_forward_n", draw.between(5.0, 20.0)),
                Dial::up_to("coulomb_friction_back_n", 50.0),
            ],
            "seal-friction" => vec![Dial::up_to("leg.seal_friction_n_per_pa", 1e-4)],
            "viscous-friction" => vec![Dial::up_to("leg.viscous_friction_n_s_per_m", 2000.0)],
            "return-spring" => vec![
                Dial::up_to(
                    "leg.return_spring.stiffness_n_per_m",
                    draw.between(100.0, 500.0),
                ),
                Dial::up_to("leg.return_spring.preload_n", draw.between(2.0, 20.0)),
            ],
            "position-friction" => {
                vec![
                    Dial::up_to("rough_n", 20.0),
                    Dial::fixed("rough_length_m", draw.between(0.008, 0.025)),
                ]
            }
            "stribeck" => {
                vec![
                    Dial::up_to("stribeck_n", 20.0),
                    Dial::fixed("stribeck_m_s", draw.scale(1e-3, 1e-2)),
                ]
            }
            _ => return None,
        })
    }

    /// The position only says which way the piston goes.
    fn sensed(&self, _: &str) -> Vec<&'static str> {
        vec!["pressure_gauge_pa", "force_n"]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Speed is the rate of position, and after a period the piston is back.
    #[test]
    fn the_piston_goes_to_and_fro() {
        let world = Strokes::new(&mut Draw::new(1, 0));
        for test in &world.tests {
            let there = (test.high - test.low) / test.speed;
            let period = 2.0 * (there + test.reversal);
            for i in 0..200 {
                let t = period * (f64::from(i) + 0.37) / 100.0;
                let rate = (test.moved(t + 1e-6, there).0 - test.moved(t - 1e-6, there).0) / 2e-6;
                assert!((rate - test.moved(t, there).1).abs() < 1e-6, "{t}");
                assert!((test.moved(t + period, there).0 - test.moved(t, there).0).abs() < 1e-12);
            }
        }
    }

    /// Friction acts against the motion: between forth and back lies twice of it.
    #[test]
    fn between_forth_and_back_lies_twice_the_friction() {
        let world = Strokes::new(&mut Draw::new(2, 0));
        let test = world.tests[0];
        let h = Hidden::of(&[Dial::fixed("leg.coulomb_friction_n", 3.0)], 1.0);
        let run = world.run(&test, &h);
        let area = PI / 4.0 * world.bore * world.bore;
        let rest = run.values[2]
            .iter()
            .zip(&run.values[1])
            .map(|(f, p)| f - p * area);
        let (low, high) = rest.fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(x), b.max(x)));
        assert!(
            (low + 3.0).abs() < 1e-3 && (high - 3.0).abs() < 1e-3,
            "{low} {high}"
        );
    }
}
