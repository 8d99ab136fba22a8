//! A piston moved slowly back and forth under regulated pressure: what its seal does to the force.

use std::f64::consts::{FRAC_PI_4, PI, TAU};

use saltus_numeric::statistics::quantile;

use super::{Causes, FREE, amount, causes, directional, faults, gain, offset, simple, unknown};
use crate::experiment::{Experiment, Run, Sort};
use crate::kind::{Asked, Cause, Data, Kind, Parameter};
use crate::layout::{Draw, Layout, count};
use crate::noise;
use crate::plausible::{Check, FORCES_AND_BORES, LENGTHS};
use crate::spec::{
    BORE, Column, FORCE, GAUGE, PART, POSITION, Source, Spec, Synthesis, calm, lively, noisy,
    required,
};

/// What is given of a run.
#[derive(Clone, Debug, PartialEq)]
struct Drive {
    /// Bore (m).
    bore: f64,
    /// Gauge pressure (Pa) at each reading.
    pressure: Vec<f64>,
    /// Position (m, increasing as it retracts against the pressure) without its noise, and speed
    /// (m/s), at each reading.
    motion: Vec<(f64, f64)>,
}

/// Strokes.
#[derive(Clone, Debug)]
pub struct Strokes {
    data: Data,
    drives: Vec<Drive>,
    causes: Causes<Effect>,
    /// Greatest position (m) of all, from which the extension is counted.
    retracted: f64,
    /// Speed (m/s) over which friction that falls with speed does so: a quarter of the usual one.
    slow: f64,
}

impl Strokes {
    /// The experiment's strokes.
    pub fn new(experiment: &Experiment) -> Strokes {
        let column = |name| experiment.column(name).unwrap_or(0);
        let [position, pressure, force] =
            ["position_m", "pressure_gauge_pa", "force_n"].map(column);
        let mut data = Data::of(experiment, &[force]);
        let of_pressure = noise::channels(experiment, &[pressure]).swap_remove(0);
        // What is compared with p A has the noise of p in it.
        let bores = experiment
            .runs
            .iter()
            .filter_map(|run| run.settings.get("bore_m"));
        let area = FRAC_PI_4 * bores.fold(0.0, |most: f64, bore| most.max(bore * bore));
        let channel = &mut data.channels[0];
        channel.noise = channel.noise.hypot(area * of_pressure.noise);
        channel.is_given &= of_pressure.is_given;
        let drives: Vec<Drive> = experiment
            .runs
            .iter()
            .map(|run| drive(run, position, pressure, force))
            .collect();
        let places = drives.iter().flat_map(|drive| &drive.motion).map(|m| m.0);
        let retracted = places.fold(f64::NEG_INFINITY, f64::max);
        let speeds: Vec<f64> = drives
            .iter()
            .flat_map(|drive| &drive.motion)
            .map(|m| m.1.abs())
            .collect();
        let slow = 0.25 * quantile(&speeds, 0.5).unwrap_or(0.0).max(1e-6);
        Strokes {
            causes: Causes::of(&mut data, listed(), unnamed()),
            slow,
            data,
            drives,
            retracted,
        }
    }
}

/// What a cause does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Effect {
    Coulomb,
    Directional,
    Seal,
    Viscous,
    Spring,
    /// Without a name.
    Stribeck,
    Tightening,
    Quadratic,
}

/// Terms without a name.
fn unnamed() -> Vec<(Option<Effect>, Cause)> {
    let term = |id, name, scale| simple(id, name, 0.0, (-1e4 * scale, 1e4 * scale), scale, &[]);
    causes! {
        Effect::Stribeck => term("dry friction that falls with speed", "c_n", 0.5);
        Effect::Tightening => term("dry friction c x", "c_n_per_m", 10.0);
        Effect::Quadratic => term("force on the rod, -c |v| v", "c_n_s2_per_m2", 100.0);
    }
}

fn listed() -> Vec<(Option<Effect>, Cause)> {
    let viscous = "viscous_friction_n_s_per_m";
    let spring = vec![
        unknown("stiffness_n_per_m", 0.0, (0.0, 1e6), 10.0),
        unknown("preload_n", 0.0, (0.0, 1e4), 1.0),
    ];
    let coulomb = amount("coulomb-friction", "coulomb_friction_n", 1e4, 0.5, &[1.0]);
    let mut all = causes! {
        Effect::Directional => directional(&coulomb);
        Effect::Coulomb => coulomb;
        Effect::Seal => amount("seal-friction", "seal_friction_n_per_pa", 1.0, 1e-6, &[1e-5]);
        Effect::Viscous => amount("viscous-friction", viscous, 1e6, 1.0, &[10.0]);
        Effect::Spring => Cause::several("return-spring", spring);
    };
    all.extend(faults([offset("force_n", "n", FREE, 0.5), gain("force_n")]));
    all
}

/// What drives the rows of a run that have a force; empty cells of the others are bridged.
fn drive(run: &Run, position: usize, pressure: usize, force: usize) -> Drive {
    let rows: Vec<usize> = (0..run.time.len())
        .filter(|&i| run.values[force][i].is_finite())
        .collect();
    let times: Vec<f64> = rows.iter().map(|&i| run.time[i]).collect();
    let along = |column: usize| -> Vec<f64> {
        let mut last = run.values[column]
            .iter()
            .copied()
            .find(|v| v.is_finite())
            .unwrap_or(0.0);
        rows.iter()
            .map(|&i| {
                let value = run.values[column][i];
                last = if value.is_finite() { value } else { last };
                last
            })
            .collect()
    };
    let bore = run.settings.get("bore_m").copied().unwrap_or(0.01);
    Drive {
        bore,
        pressure: along(pressure),
        motion: motion(&times, &along(position)),
    }
}

/// Position and speed from least-squares lines over nine readings.
fn motion(times: &[f64], position: &[f64]) -> Vec<(f64, f64)> {
    const HALF: usize = 4;
    let n = position.len();
    (0..n)
        .map(|i| {
            let window = i.saturating_sub(HALF)..(i + HALF + 1).min(n);
            let count = window.len() as f64;
            let mean = |values: &[f64]| values[window.clone()].iter().sum::<f64>() / count;
            let (t, x) = (mean(times), mean(position));
            let (mut above, mut below) = (0.0, 0.0);
            for k in window.clone() {
                let dt = times[k] - t;
                above += dt * (position[k] - x);
                below += dt * dt;
            }
            let speed = if below > 0.0 { above / below } else { 0.0 };
            (x + speed * (times[i] - t), speed)
        })
        .collect()
}

impl Kind for Strokes {
    fn data(&self) -> &Data {
        &self.data
    }

    /// How the seal stands at the start, and over what way it turns over.
    fn unknowns(&self, _: usize) -> Vec<Parameter> {
        vec![
            unknown("seal_state", 0.0, (-1.0, 1.0), 0.5),
            unknown("presliding_m", 2e-4, (1e-6, 5e-3), 1e-4),
        ]
    }

    fn stronger(&self) -> String {
        "strokes over a longer way, at several speeds and pressures".into()
    }

    /// Force on the load cell: p A, friction against the motion (after Dahl: it turns over within
    /// the presliding way), less a spring that grows as the rod extends.
    fn truths(&self, asked: &Asked<'_>) -> Option<Vec<f64>> {
        let (run, terms, unknowns) = asked.parts();
        let drive = &self.drives[run];
        let area = FRAC_PI_4 * drive.bore * drive.bore;
        let (mut state, way) = (unknowns[0], unknowns[1]);
        let of = |effect, p| self.causes.get(effect, p, terms);
        let [coulomb, forward] = self
            .causes
            .friction(Effect::Coulomb, Effect::Directional, terms);
        let seal = of(Effect::Seal, 0)?;
        let viscous = of(Effect::Viscous, 0)?;
        let (stiffness, preload) = (of(Effect::Spring, 0)?, of(Effect::Spring, 1)?);
        let [stribeck, tightening, quadratic] =
            [Effect::Stribeck, Effect::Tightening, Effect::Quadratic]
                .map(|effect| self.causes.or(effect, 0.0, terms));
        let mut last = drive.motion.first()?.0;
        let out: Vec<f64> = drive
            .motion
            .iter()
            .zip(&drive.pressure)
            .map(|(&(x, speed), &pressure)| {
                let moved = x - last;
                last = x;
                let end = if moved < 0.0 { -1.0 } else { 1.0 };
                state = end + (state - end) * (-moved.abs() / way).exp();
                let extended = self.retracted - x;
                let dry = coulomb
                    + seal * pressure.max(0.0)
                    + stribeck * (-speed.abs() / self.slow).exp()
                    + tightening * extended;
                let spring = stiffness * extended + preload;
                let braked = (viscous + quadratic * speed.abs()) * speed;
                pressure * area + state * dry + forward + braked - spring
            })
            .collect();
        Some(out)
    }
}

/// The kind.
pub(super) const SPEC: Spec = Spec {
    sort: Sort::Stroke,
    id: "stroke",
    description: "A piston moved slowly",
    channels: &[
        lively("position_m", POSITION),
        // A regulator may hold it to one count.
        Column {
            scale: 1000.0,
            ..calm("pressure_gauge_pa", GAUGE)
        },
        lively("force_n", FORCE),
    ],
    settings: &[required("bore_m", BORE)],
    // Nothing is simulated.
    longest: f64::INFINITY,
    checks: &[
        Check {
            name: "position_m",
            sizes: |view| Some((view.span("position_m")?, 5.0 * view.setting("bore_m")?)),
            what: "the stroke of a cylinder five times as long as wide",
            allowed: (0.0, 10.0),
            strict: false,
            units: LENGTHS,
        },
        Check {
            name: "force_n",
            sizes: |view| {
                let area = FRAC_PI_4 * view.setting("bore_m")?.powi(2);
                let pressure = quantile(view.column("pressure_gauge_pa")?, 0.5)?;
                // Friction of the seal is as large as the force of a low pressure.
                (pressure > 5e4).then_some(())?;
                Some((quantile(view.column("force_n")?, 0.5)?, pressure * area))
            },
            what: "pressure times area",
            allowed: (0.35, 5.0),
            strict: false,
            units: FORCES_AND_BORES,
        },
    ],
    model: |data, _| Ok(Box::new(Strokes::new(data))),
    synthesis: Synthesis {
        instruments: &[
            noisy("position_m", 1e-5),
            noisy("pressure_gauge_pa", 50.0),
            noisy("force_n", 0.06),
        ],
        without_boom: None,
        runs: 5,
        lay_out,
        source: Source::Model,
    },
    ..PART
};

/// Adds slow strokes at several pressures, each twice back and forth with round turns.
fn lay_out(layout: &mut Layout, runs: usize, draw: &mut Draw) {
    let (seal, way) = (draw.between(-1.0, 1.0), draw.between(5e-5, 3e-4));
    for k in 0..runs {
        let set = 1e5 + 6e5 * k as f64 / (runs - 1).max(1) as f64;
        let (middle, half) = (draw.between(0.03, 0.05), draw.between(0.02, 0.025));
        let period = draw.between(8.0, 20.0);
        let rate = 0.02;
        layout.add(
            &[("bore_m", 0.01905)],
            count(2.0 * period, rate),
            rate,
            vec![seal, way],
        );
        let (position, pressure) = (
            layout.column("position_m"),
            layout.column("pressure_gauge_pa"),
        );
        let Some(run) = layout.experiment.runs.last_mut() else {
            return;
        };
        for (row, t) in run.time.iter().enumerate() {
            // Nearly a triangle: an arcsine of a sine that stays short of 1.
            let phase = TAU * t / period;
            run.values[position][row] = middle - half * (0.99 * phase.cos()).asin() / (PI / 2.0);
            run.values[pressure][row] =
                set + 1500.0 * (0.7 * phase.sin() + 0.3 * (TAU * t / 7.0).sin());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::toy;

    const BORE: f64 = 0.02;
    const PRESSURE: f64 = 3e5;
    /// Force (N) of the pressure.
    const PUSH: f64 = PRESSURE * FRAC_PI_4 * BORE * BORE;
    /// Speed (m/s) of the piston, pushed in and pulled out again.
    const SPEED: f64 = 0.01;
    /// Rows, every 0.1 s, of which the middle one turns round.
    const ROWS: u32 = 81;

    fn place(row: u32) -> f64 {
        0.02 + SPEED * (4.0 - (f64::from(row) * 0.1 - 4.0).abs())
    }

    fn strokes() -> Strokes {
        let time: Vec<f64> = (0..ROWS).map(|k| f64::from(k) * 0.1).collect();
        let columns = [
            ("position_m", (0..ROWS).map(place).collect()),
            ("pressure_gauge_pa", vec![PRESSURE; time.len()]),
            ("force_n", time.clone()),
        ];
        let settings = [("bore_m", BORE)];
        Strokes::new(&toy::measured(Sort::Stroke, &settings, &time, &columns))
    }

    /// Force (N) beyond that of the pressure, row by row, with terms on; the seal is turned the way
    /// that it goes first.
    fn beyond(on: &[(&str, usize, f64)]) -> Vec<f64> {
        let strokes = strokes();
        let found = strokes.predict(0, &toy::terms(&strokes, on), &[1.0, 1e-4]);
        found.expect("an answer").iter().map(|f| f - PUSH).collect()
    }

    /// Rows where it goes steadily one way, and back.
    const WAYS: [(std::ops::Range<usize>, f64); 2] = [(5..35, 1.0), (46..76, -1.0)];

    /// Holds each row of both ways against `closed(row, direction)`.
    #[track_caller]
    fn check(found: &[f64], closed: impl Fn(u32, f64) -> f64) {
        for (rows, way) in WAYS {
            for row in rows {
                let y = closed(u32::try_from(row).expect("a row"), way);
                assert!(
                    (found[row] - y).abs() < 1e-9,
                    "row {row}: {} {y}",
                    found[row]
                );
            }
        }
    }

    #[test]
    fn without_a_term_it_is_pressure_times_area() {
        check(&beyond(&[]), |_, _| 0.0);
    }

    #[test]
    fn friction_is_against_the_motion() {
        check(&beyond(&[("coulomb-friction", 0, 4.0)]), |_, way| 4.0 * way);
        let each = [
            ("directional-friction", 0, 4.0),
            ("directional-friction", 1, 1.0),
        ];
        check(&beyond(&each), |_, way| 1.5 + 2.5 * way);
        check(&beyond(&[("seal-friction", 0, 1e-5)]), |_, way| {
            way * 1e-5 * PRESSURE
        });
        check(&beyond(&[("viscous-friction", 0, 50.0)]), |_, way| {
            way * 50.0 * SPEED
        });
    }

    #[test]
    fn terms_without_a_name_are_against_the_motion() {
        check(
            &beyond(&[("dry friction that falls with speed", 0, 3.0)]),
            |_, way| way * 3.0 * f64::exp(-4.0),
        );
        check(
            &beyond(&[("force on the rod, -c |v| v", 0, 200.0)]),
            |_, way| way * 200.0 * SPEED * SPEED,
        );
        let retracted = strokes().retracted;
        check(&beyond(&[("dry friction c x", 0, 100.0)]), |row, way| {
            way * 100.0 * (retracted - place(row))
        });
    }

    /// Dahl: from one side to the other by a factor e for each presliding way.
    #[test]
    fn friction_turns_over_within_the_presliding_way() {
        const WAY: f64 = 5e-3;
        let strokes = strokes();
        let terms = toy::terms(&strokes, &[("coulomb-friction", 0, 4.0)]);
        let found = strokes.predict(0, &terms, &[1.0, WAY]).expect("an answer");
        for row in 45..75 {
            let back = strokes.retracted - place(row);
            let closed = PUSH + 4.0 * (2.0 * (-back / WAY).exp() - 1.0);
            let force = found[row as usize];
            assert!((force - closed).abs() < 1e-9, "row {row}: {force} {closed}");
        }
    }

    #[test]
    fn a_spring_pulls_the_more_the_farther_the_rod_is_out() {
        let on = [("return-spring", 0, 200.0), ("return-spring", 1, 3.0)];
        // The most retracted place is where lines over nine rows see it, 2 mm short of the turn.
        let found = beyond(&on);
        let change = |a: u32, b: u32| 200.0 * (place(a) - place(b));
        for row in 5..35 {
            let closed = found[5] + change(row, 5);
            assert!((found[row as usize] - closed).abs() < 1e-9, "row {row}");
        }
        let greatest = found.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        assert!((greatest + 3.0).abs() < 1e-9, "{greatest}: the preload");
    }

    #[test]
    fn a_load_cell_has_a_gain_and_an_offset() {
        check(&beyond(&[("sensor-offset", 0, 2.0)]), |_, _| 2.0);
        check(&beyond(&[("encoder-scale", 0, 1.2)]), |_, _| 0.2 * PUSH);
    }
}
