//! A walker with two straight legs: it pivots on one of them, then on the other. Each step is a run of
//! its own of the machine that stands on that leg: it begins at a place and rates of its own, which
//! nobody predicts.

use std::f64::consts::TAU;

use saltus_robot::Robot;
use saltus_robot::units::{INERTIA, Quantity, Unit};

use super::machine::{Motions, Piece, TORQUE};
use crate::experiment::{Experiment, Run, Sort};
use crate::layout::{Draw, Layout, round};
use crate::mechanism::{Counterweight, Drive, Gauge, Inertia, Joint, Link, Mechanism, Shows, Way};
use crate::spec::{
    Domain, LINK, LOAD, OUTPUT, PART, Problem, Source, Spec, Synthesis, TILT, asked, calm,
    counting, lively, noisy, required,
};

const FRICTION: (Quantity, Domain) = (TORQUE.0, Domain::NON_NEGATIVE.up_to(1e5));
const DAMPING: (Quantity, Domain) = (
    Quantity {
        si: "N m s",
        dimension: [1, 2, -1],
        units: &[("_nm_s", Unit::SI)],
    },
    Domain::NON_NEGATIVE.up_to(1e5),
);
const ABOUT_HIP: (Quantity, Domain) = (INERTIA, Domain::POSITIVE.up_to(1e6).called("an inertia"));

/// The kind.
pub(super) const SPEC: Spec = Spec {
    sort: Sort::Walk,
    id: "walk",
    description: "A walker with two straight legs",
    channels: &[
        asked("outer_leg_stands", OUTPUT),
        lively("lean_rad", TILT),
        lively("hip_angle_rad", TILT),
        calm("torque_nm", TORQUE),
    ],
    rig: &[
        required("leg_mass_kg", LOAD),
        required("leg_length_m", LINK),
        required("inner_centre_from_hip_m", LINK),
        required("outer_centre_from_hip_m", LINK),
        required("inner_inertia_about_hip_kg_m2", ABOUT_HIP),
        required("outer_inertia_about_hip_kg_m2", ABOUT_HIP),
        required("hip_coulomb_nm", FRICTION),
        required("hip_viscous_nm_s", DAMPING),
        required("hip_mass_kg", LOAD),
    ],
    model: |data, _: Option<&Robot>| Ok(Box::new(of(data)?)),
    synthesis: Synthesis {
        instruments: &[
            noisy("outer_leg_stands", 0.0),
            counting("lean_rad", 4.363_323e-5),
            counting("hip_angle_rad", 7.669_904e-4),
            noisy("torque_nm", 0.0),
        ],
        without_boom: None,
        runs: 12,
        lay_out,
        source: Source::Model,
    },
    ..PART
};

/// Acceleration of gravity (m/s²).
const GRAVITY: f64 = 9.80665;
/// Fewest rows of a step.
const LEAST: usize = 12;
/// Names of the legs.
const LEGS: [&str; 2] = ["inner", "outer"];

/// What `[rig]` says.
#[derive(Clone, Copy, Debug)]
struct Believed {
    mass: f64,
    length: f64,
    /// Of the inner and the outer leg: its centre from the hip (m), its inertia about the hip.
    centers: [f64; 2],
    inertias: [f64; 2],
    dry: f64,
    viscous: f64,
    hip: f64,
}

impl Believed {
    /// # Errors
    /// [`Problem::NoMachine`] where a leg is no body.
    fn of(run: &Run) -> Result<Believed, Problem> {
        let number = |key: &str| run.settings.get(key).copied().unwrap_or(f64::NAN);
        let rig = Believed {
            mass: number("leg_mass_kg"),
            length: number("leg_length_m"),
            centers: LEGS.map(|leg| number(&format!("{leg}_centre_from_hip_m"))),
            inertias: LEGS.map(|leg| number(&format!("{leg}_inertia_about_hip_kg_m2"))),
            dry: number("hip_coulomb_nm"),
            viscous: number("hip_viscous_nm_s"),
            hip: number("hip_mass_kg"),
        };
        for (leg, (center, inertia)) in rig.centers.iter().zip(rig.inertias).enumerate() {
            let name = LEGS[leg];
            if *center > rig.length {
                return Err(Problem::NoMachine {
                    what: format!(
                        "rig.{name}_centre_from_hip_m = {center}: must be within the leg, \
                         leg_length_m = {}: are both in m, not mm, cm or inch?",
                        rig.length
                    ),
                });
            }
            let [least, most] = [center, &rig.length].map(|length| rig.mass * length * length);
            if inertia <= least || inertia > most {
                return Err(Problem::NoMachine {
                    what: format!(
                        "rig.{name}_inertia_about_hip_kg_m2 = {inertia}: must be above mass times \
                         {name}_centre_from_hip_m squared, {least:.3e}, and at most mass times \
                         leg_length_m squared, {most:.3e}: are all in kg and m?"
                    ),
                });
            }
        }
        Ok(rig)
    }

    /// The machine that stands on leg `own`: that leg turns about its foot, the other one hangs from
    /// the hip.
    fn mechanism(&self, own: usize) -> Mechanism {
        let link = |leg: usize, joint, center, counterweight| {
            let about_hip = self.inertias[leg];
            Link {
                name: format!("{}_leg", LEGS[leg]),
                joint,
                mass: self.mass,
                center: [0.0, center],
                inertia: Inertia::Center(about_hip - self.mass * self.centers[leg].powi(2)),
                counterweight,
            }
        };
        let hip = Joint {
            // The hip's angle grows as the swinging leg falls behind the other.
            way: Way::Turns { back: true },
            friction: self.dry,
            damping: self.viscous,
            ..Joint::turning("hip", Some(0), [0.0, self.length])
        };
        let at_hip = Counterweight {
            name: "hip".into(),
            at: [0.0, self.length],
            mass: self.hip,
        };
        let (center, other) = (self.length - self.centers[own], 1 - own);
        let gauge = |column: &str, k| Gauge {
            column: column.into(),
            shows: Shows::Coordinate(k),
        };
        Mechanism {
            name: "[rig]".into(),
            gravity: GRAVITY,
            links: vec![
                link(
                    own,
                    Joint::turning("foot", None, [0.0; 2]),
                    center,
                    Some(at_hip),
                ),
                link(other, hip, -self.centers[other], None),
            ],
            springs: Vec::new(),
            drives: vec![Drive {
                column: "torque_nm".into(),
                joint: 1,
            }],
            gauges: vec![gauge("lean_rad", 0), gauge("hip_angle_rad", 1)],
        }
    }
}

/// The walks of an experiment, step by step.
fn of(experiment: &Experiment) -> Result<Motions, Problem> {
    let first = experiment.runs.first().cloned().unwrap_or_default();
    let rig = Believed::of(&first)?;
    let (steps, pieces) = cut(experiment);
    if pieces.is_empty() {
        return Err(Problem::NoMachine {
            what: format!(
                "no step has {LEAST} rows: outer_leg_stands must stay the same that long"
            ),
        });
    }
    let mechanisms = vec![rig.mechanism(0), rig.mechanism(1)];
    let motions = Motions::new(&steps, mechanisms, pieces)?;
    let note = format!(
        "{} steps; the place and rates at which a step begins are estimated from that step, of \
         walks left out as well: figures are those of single steps, not of whole walks",
        steps.runs.len()
    );
    Ok(motions.noting(vec![note]))
}

/// Each step as a run, with the leg that stands and the walk that it is of.
fn cut(experiment: &Experiment) -> (Experiment, Vec<Piece>) {
    let column = |name| experiment.column(name).unwrap_or(0);
    let stands = column("outer_leg_stands");
    let needed = ["lean_rad", "hip_angle_rad", "torque_nm"].map(column);
    let (mut steps, mut pieces) = (Vec::new(), Vec::new());
    for (group, run) in experiment.runs.iter().enumerate() {
        let (mut from, mut number) = (0, 0);
        let rows = run.time.len();
        for row in 1..=rows {
            if row < rows && run.values[stands][row] == run.values[stands][from] {
                continue;
            }
            number += 1;
            let whole = |r: &usize| needed.iter().all(|c| run.values[*c][*r].is_finite());
            let within: Vec<usize> = (from..row).filter(whole).collect();
            if within.len() >= LEAST {
                let of = |values: &Vec<f64>| within.iter().map(|r| values[*r]).collect();
                steps.push(Run {
                    name: format!("{} step {number}", run.name),
                    settings: run.settings.clone(),
                    valve: None,
                    time: of(&run.time),
                    values: run.values.iter().map(of).collect(),
                });
                let mechanism = usize::from(run.values[stands][from] > 0.5);
                pieces.push(Piece { mechanism, group });
            }
            from = row;
        }
    }
    let steps = Experiment {
        runs: steps,
        ..experiment.clone()
    };
    (steps, pieces)
}

/// Adds walks of one step each, on one leg and the other in turn, with a torque of two sines at the
/// hip.
fn lay_out(layout: &mut Layout, runs: usize, draw: &mut Draw) {
    /// Rate (rad/s) at which such a walker falls over.
    const FALLS: f64 = 5.9;
    let [torque, stands] = ["torque_nm", "outer_leg_stands"].map(|name| layout.column(name));
    let centers = [(); 2].map(|()| round(draw.stepped(0.03, 0.06, 1e-4)));
    let inertias = centers.map(|c| round(draw.between(2.0, 3.0) * 0.7 * c * c));
    let rig = [
        ("leg_mass_kg", 0.7),
        ("leg_length_m", 0.28),
        ("inner_centre_from_hip_m", centers[0]),
        ("outer_centre_from_hip_m", centers[1]),
        ("inner_inertia_about_hip_kg_m2", inertias[0]),
        ("outer_inertia_about_hip_kg_m2", inertias[1]),
        ("hip_coulomb_nm", 5e-3),
        ("hip_viscous_nm_s", 2e-3),
        ("hip_mass_kg", round(draw.stepped(1.0, 3.0, 0.1))),
    ];
    for run in 0..runs {
        let lean = draw.between(-0.22, -0.15);
        // Fast enough to get over the foot, by a fifth at most.
        let rate = -lean * FALLS * draw.between(1.08, 1.2);
        let hip = [2.0 * lean, draw.between(0.0, 1.0)];
        layout.add(&rig, 91, 5e-3, vec![lean, hip[0], rate, hip[1]]);
        let sines = [(); 2].map(|()| {
            (
                draw.between(0.01, 0.04),
                draw.between(5.0, 15.0),
                draw.between(0.0, TAU),
            )
        });
        let Some(own) = layout.experiment.runs.last_mut() else {
            continue;
        };
        own.values[stands].fill(f64::from(u8::from(run % 2 == 0)));
        for (value, t) in own.values[torque].iter_mut().zip(&own.time) {
            *value = round(sines.iter().map(|(a, w, p)| a * (w * t + p).sin()).sum());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit;
    use crate::folds::folds;
    use crate::kind::Kind;
    use crate::settings::Settings;

    const ROWS: usize = 81;
    const STEP: f64 = 5e-3;
    const MASS: f64 = 0.7;
    const LENGTH: f64 = 0.28;
    const CENTERS: [f64; 2] = [0.045, 0.05];
    const INERTIAS: [f64; 2] = [4.3e-3, 4.4e-3];
    const DRY: f64 = 6e-3;
    const VISCOUS: f64 = 1.5e-3;

    /// Torque (N m) at the hip.
    fn torque(t: f64) -> f64 {
        0.03 * (9.0 * t).sin() + 0.01
    }

    /// Lagrange's equations of a step in the angles of both legs from the vertical, that of the
    /// swinging one forward as it hangs: rates of angles and rates.
    fn slope(
        own: usize,
        [weight, inertia]: [f64; 2],
        t: f64,
        [stands, swings, fast, faster]: [f64; 4],
    ) -> [f64; 4] {
        let (other, gravity) = (1 - own, GRAVITY);
        let about_center = INERTIAS[own] - MASS * CENTERS[own].powi(2);
        let above = LENGTH - CENTERS[own];
        let a = about_center + MASS * above * above + (MASS + inertia) * LENGTH * LENGTH;
        let b = INERTIAS[other];
        let k = MASS * CENTERS[other] * LENGTH;
        let (sin, cos) = (stands - swings).sin_cos();
        // Dry friction sets in within 1 mrad/s, as the method needs a slope.
        let rate = fast - faster;
        let hip = torque(t) - DRY * (rate / 1e-3).tanh() - VISCOUS * rate;
        let lever = MASS * above + (weight + MASS) * LENGTH;
        let x = gravity * lever * stands.sin() + hip + k * sin * faster * faster;
        let y = -MASS * gravity * CENTERS[other] * swings.sin() - hip - k * sin * fast * fast;
        let det = a * b - k * k * cos * cos;
        [
            fast,
            faster,
            (b * x + k * cos * y) / det,
            (k * cos * x + a * y) / det,
        ]
    }

    /// Lean, angle and torque at the hip of a step, by Heun's method in 50 steps a row.
    fn step(own: usize, hip: [f64; 2], start: [f64; 4]) -> [Vec<f64>; 3] {
        const FINE: usize = 50;
        let h = STEP / FINE as f64;
        let (mut x, mut columns) = (start, [Vec::new(), Vec::new(), Vec::new()]);
        for row in 0..ROWS {
            columns[0].push(x[0]);
            columns[1].push(x[0] - x[1]);
            columns[2].push(torque(row as f64 * STEP));
            for i in 0..FINE {
                let t = row as f64 * STEP + i as f64 * h;
                let a = slope(own, hip, t, x);
                let there = std::array::from_fn(|k| x[k] + h * a[k]);
                let b = slope(own, hip, t + h, there);
                x = std::array::from_fn(|k| x[k] + 0.5 * h * (a[k] + b[k]));
            }
        }
        columns
    }

    /// Walks of three steps each.
    fn walks(hip: [f64; 2], count: usize) -> Experiment {
        let rig = [
            ("leg_mass_kg", MASS),
            ("leg_length_m", LENGTH),
            ("inner_centre_from_hip_m", CENTERS[0]),
            ("outer_centre_from_hip_m", CENTERS[1]),
            ("inner_inertia_about_hip_kg_m2", INERTIAS[0]),
            ("outer_inertia_about_hip_kg_m2", INERTIAS[1]),
            ("hip_coulomb_nm", DRY),
            ("hip_viscous_nm_s", VISCOUS),
            ("hip_mass_kg", 2.0),
        ];
        let columns = ["outer_leg_stands", "lean_rad", "hip_angle_rad", "torque_nm"];
        let mut draw = Draw::new(3);
        let runs = (0..count).map(|walk| {
            let mut run = Run {
                name: format!("walk-{walk}.csv"),
                settings: rig.iter().map(|(key, x)| ((*key).to_owned(), *x)).collect(),
                values: vec![Vec::new(); 4],
                ..Run::default()
            };
            for number in 0..3 {
                let own = (walk + number) % 2;
                let lean = draw.between(-0.22, -0.18);
                let start = [lean, -lean, draw.between(0.6, 0.9), draw.between(-1.0, 0.0)];
                run.values[0].extend([own as f64; ROWS]);
                let measured = step(own, hip, start);
                for (values, measured) in run.values[1..].iter_mut().zip(measured) {
                    values.extend(measured);
                }
            }
            run.time = (0..3 * ROWS).map(|row| row as f64 * STEP).collect();
            run
        });
        Experiment {
            kind: Sort::Walk,
            mechanism: None,
            columns: columns.map(str::to_owned).into(),
            noise: vec![None, Some(1e-4), Some(1e-4), None],
            resolution: vec![None; 4],
            runs: runs.collect(),
        }
    }

    /// Weight and inertia at the hip are found apart, from equations of their own.
    #[test]
    fn a_counterweight_is_found() {
        let hidden = [0.3, 1.6];
        let kind = of(&walks(hidden, 2)).expect("a model");
        let runs: Vec<usize> = (0..kind.logs().len()).collect();
        let cause = kind
            .causes()
            .iter()
            .position(|c| c.id == "counterweight")
            .expect("a cause");
        let before = fit::fit_none(&kind, &runs).expect("an answer");
        let fit = fit::fit_with(&kind, &before, cause, &runs).expect("an answer");
        for (found, hidden) in fit.terms.of(cause).iter().zip(hidden) {
            // Fixed steps are off by 0.1 σ, which is worth 0.02 kg in the direction that is told least.
            assert!((found - hidden).abs() < 0.03, "{found} {hidden}");
        }
        // What is left is not worth a reading's noise.
        let readings: usize = kind.logs().iter().map(|log| log.readings.len()).sum();
        assert!(fit.loss < readings as f64, "{} of {readings}", fit.loss);
    }

    #[test]
    fn walks_are_left_out_whole() {
        let kind = of(&walks([1.0, 1.0], 3)).expect("a model");
        assert_eq!(kind.logs().len(), 9);
        let left_out: Vec<Vec<usize>> = folds(&kind, &Settings::default())
            .into_iter()
            .map(|fold| fold.runs)
            .collect();
        assert_eq!(left_out, [vec![0, 1, 2], vec![3, 4, 5], vec![6, 7, 8]]);
        // Where a step starts is its own.
        assert_eq!(kind.unknowns(4).len(), 4);
        assert!(kind.notes().iter().any(|note| note.contains("9 steps")));
    }

    #[test]
    fn what_is_no_walk_is_refused() {
        let refused = |change: &dyn Fn(&mut Run)| {
            let mut experiment = walks([1.0, 1.0], 1);
            experiment.runs.iter_mut().for_each(change);
            of(&experiment).expect_err("no walk").to_string()
        };
        let set = |key: &'static str, x: f64| {
            move |run: &mut Run| {
                run.settings.insert(key.into(), x);
            }
        };
        let light = refused(&set("outer_inertia_about_hip_kg_m2", 1e-3));
        assert!(
            light.contains("outer_inertia_about_hip_kg_m2 = 0.001: must be above"),
            "{light}"
        );
        let far = refused(&set("inner_centre_from_hip_m", 0.3));
        assert!(
            far.contains("must be within the leg, leg_length_m = 0.28"),
            "{far}"
        );
        let short = refused(&|run: &mut Run| {
            for (row, stands) in run.values[0].iter_mut().enumerate() {
                *stands = (row / 5 % 2) as f64;
            }
        });
        assert!(short.contains("no step has 12 rows"), "{short}");
    }
}
