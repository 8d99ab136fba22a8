//! Machines against equations of motion that were written by hand, and against laws.

use super::plant::Row;
use super::*;
use crate::fit;
use crate::folds::folds;
use crate::kind::{Cause, Terms};
use crate::mechanism::{Law, Side, Spring, Way};
use crate::settings::Settings;
use crate::toy::{self, terms};

/// Rows of a run, 5 ms apart.
const ROWS: usize = 401;
const STEP: f64 = 5e-3;
/// Standard deviation that the tests' columns state.
const NOISE: f64 = 1e-5;

/// Runge and Kutta's method of fourth order, in 20 steps a row.
fn integrated<const N: usize>(
    start: [f64; N],
    rows: usize,
    slope: impl Fn(f64, &[f64; N]) -> [f64; N],
) -> Vec<[f64; N]> {
    const FINE: usize = 20;
    let h = STEP / FINE as f64;
    let moved = |x: &[f64; N], by: f64, d: &[f64; N]| std::array::from_fn(|i| x[i] + by * d[i]);
    let (mut x, mut all) = (start, vec![start]);
    for row in 1..rows {
        for i in 0..FINE {
            let t = (row - 1) as f64 * STEP + i as f64 * h;
            let a = slope(t, &x);
            let b = slope(t + 0.5 * h, &moved(&x, 0.5 * h, &a));
            let c = slope(t + 0.5 * h, &moved(&x, 0.5 * h, &b));
            let d = slope(t + h, &moved(&x, h, &c));
            x = std::array::from_fn(|k| x[k] + h / 6.0 * (a[k] + 2.0 * b[k] + 2.0 * c[k] + d[k]));
        }
        all.push(x);
    }
    all
}

/// A double pendulum in absolute angles.
#[derive(Clone, Copy)]
struct Double {
    masses: [f64; 2],
    centers: [f64; 2],
    inertias: [f64; 2],
    length: f64,
    /// Viscous friction in shoulder and elbow.
    viscous: [f64; 2],
}

const ARM: Double = Double {
    masses: [0.6, 0.4],
    centers: [0.11, 0.09],
    inertias: [2e-3, 1.2e-3],
    length: 0.25,
    viscous: [0.0, 0.0],
};

/// Torque at the shoulder.
fn torque(t: f64) -> f64 {
    0.15 * (5.0 * t).sin() + 0.1 * (8.3 * t).sin()
}

impl Double {
    /// Rates of both angles and of their rates, under a torque at the shoulder.
    fn slope(&self, [a, b, da, db]: [f64; 4], torque: f64) -> [f64; 4] {
        let ([m1, m2], [c1, c2], [i1, i2]) = (self.masses, self.centers, self.inertias);
        let (l, g) = (self.length, 9.80665);
        let (sin, cos) = (a - b).sin_cos();
        let mass = [
            [i1 + m1 * c1 * c1 + m2 * l * l, m2 * l * c2 * cos],
            [m2 * l * c2 * cos, i2 + m2 * c2 * c2],
        ];
        let elbow = -self.viscous[1] * (db - da);
        let shoulder = torque - self.viscous[0] * da;
        let force = [
            shoulder - elbow - m2 * l * c2 * sin * db * db - (m1 * c1 + m2 * l) * g * a.sin(),
            elbow + m2 * l * c2 * sin * da * da - m2 * c2 * g * b.sin(),
        ];
        let det = mass[0][0] * mass[1][1] - mass[0][1] * mass[1][0];
        [
            da,
            db,
            (mass[1][1] * force[0] - mass[0][1] * force[1]) / det,
            (mass[0][0] * force[1] - mass[1][0] * force[0]) / det,
        ]
    }

    /// The same as a mechanism.
    fn mechanism(&self) -> Mechanism {
        let mut mechanism = two_links(&mut Draw::new(1));
        for (k, link) in mechanism.links.iter_mut().enumerate() {
            link.mass = self.masses[k];
            link.center = [0.0, -self.centers[k]];
            link.inertia = Inertia::Center(self.inertias[k]);
        }
        mechanism.links[1].joint.at = [0.0, -self.length];
        mechanism
    }

    /// What sensors of shoulder and elbow say in runs from several starts.
    fn measured(&self, starts: &[[f64; 4]]) -> Experiment {
        let run = |start: &[f64; 4]| {
            let rows = integrated(*start, ROWS, |t, x| self.slope(*x, torque(t)));
            let time: Vec<f64> = (0..ROWS).map(|row| row as f64 * STEP).collect();
            Run {
                name: format!("{start:?}"),
                values: vec![
                    rows.iter().map(|x| x[0]).collect(),
                    rows.iter().map(|x| x[1] - x[0]).collect(),
                    time.iter().map(|t| torque(*t)).collect(),
                ],
                time,
                ..Run::default()
            }
        };
        Experiment {
            kind: Sort::Machine,
            mechanism: Some(ARM.mechanism()),
            columns: ["shoulder_rad", "elbow_rad", "shoulder_nm"]
                .map(str::to_owned)
                .into(),
            noise: vec![Some(NOISE), Some(NOISE), None],
            resolution: vec![None; 3],
            runs: starts.iter().map(run).collect(),
        }
    }
}

const STARTS: [[f64; 4]; 3] = [
    [0.5, 0.2, 0.3, -1.0],
    [-0.8, -0.3, 0.0, 0.0],
    [0.1, 0.6, -1.0, 2.0],
];

/// Fits causes one after the other; their values.
fn fitted(kind: &Motions, names: &[&str]) -> Vec<Vec<f64>> {
    let runs: Vec<usize> = (0..kind.logs().len()).collect();
    let place = |name: &&str| {
        let is_it = |c: &Cause| c.parameters[0].name == *name;
        kind.causes().iter().position(is_it).expect("a cause")
    };
    let causes: Vec<usize> = names.iter().map(place).collect();
    let before = fit::fit_none(kind, &runs).expect("an answer");
    let fit = causes
        .iter()
        .try_fold(before, |base, &c| fit::fit_with(kind, &base, c, &runs));
    let fit = fit.expect("an answer");
    causes.iter().map(|c| fit.terms.of(*c).to_vec()).collect()
}

#[test]
fn a_double_pendulum_moves_as_its_equations_say() {
    let experiment = ARM.measured(&STARTS);
    let kind = of(&experiment).expect("a model");
    for (run, [a, b, da, db]) in STARTS.iter().enumerate() {
        let said = kind.predict(run, &Terms::off(kind.causes()), &[*a, b - a, *da, db - da]);
        let said = said.expect("an answer");
        for (reading, said) in kind.logs()[run].readings.iter().zip(said) {
            // Phases are off by 2e-4 rad at the end, of a swing that goes through more than 1 rad.
            assert!((reading.value - said).abs() < 1e-3, "{reading:?} {said}");
        }
    }
}

#[test]
fn hidden_friction_and_mass_are_found() {
    let hidden = Double {
        masses: [0.6, 0.48],
        inertias: [2e-3, 1.44e-3],
        viscous: [0.0, 4e-3],
        ..ARM
    };
    let kind = of(&hidden.measured(&STARTS)).expect("a model");
    let found = fitted(
        &kind,
        &["elbow.mass_share", "elbow.viscous_friction_n_m_s_per_rad"],
    );
    assert!((found[0][0] / 1.2 - 1.0).abs() < 2e-3, "{found:?}");
    assert!((found[1][0] / 4e-3 - 1.0).abs() < 2e-2, "{found:?}");
}

/// The friction that was hidden is named, alone.
#[test]
fn a_diagnosis_names_the_joint_that_rubs() {
    let hidden = Double {
        viscous: [0.0, 4e-3],
        ..ARM
    };
    let mut experiment = hidden.measured(&STARTS);
    let mut draw = Draw::new(5);
    for value in experiment
        .runs
        .iter_mut()
        .flat_map(|run| run.values[..2].iter_mut().flatten())
    {
        *value += 1e-3 * draw.normal();
    }
    experiment.noise = vec![Some(1e-3), Some(1e-3), None];
    let kind = of(&experiment).expect("a model");
    let found = crate::diagnose(&kind, &Settings::default(), &|_| ()).expect("an answer");
    let names: Vec<&str> = found
        .findings
        .iter()
        .map(|finding| {
            kind.causes()[finding.best.cause].parameters[0]
                .name
                .as_str()
        })
        .collect();
    assert_eq!(names, ["elbow.viscous_friction_n_m_s_per_rad"]);
    let value = found.after.terms.get(found.findings[0].best.cause, 0);
    assert!((value / 4e-3 - 1.0).abs() < 0.05, "{value}");
}

/// A cart on a slope of springs with a pole that turns back, and a point that is seen: without
/// losses its energy stays, with a counterweight as well.
#[test]
fn energy_stays() {
    let mut mechanism = two_links(&mut Draw::new(2));
    mechanism.links[0].joint.way = Way::Slides([0.6, 0.8]);
    mechanism.links[1].joint.way = Way::Turns { back: true };
    mechanism.links[1].joint.angle = 0.4;
    mechanism.links[1].counterweight = Some(Counterweight {
        name: "boom".into(),
        at: [0.05, -0.3],
        mass: 0.5,
    });
    let law = Law::Linear {
        stiffness: 60.0,
        from: -0.1,
        side: Side::Both,
    };
    mechanism.springs = vec![Spring { joint: 0, law }];
    let mut change = Change::none(&mechanism);
    change.counterweight[1] = [-0.2, 0.7];
    change.slope = 0.1;
    let plant = Plant::new(&mechanism, change).expect("a machine");
    let inputs = [Input::default()];
    let energy = |row: &Row| plant.energy(row) + 30.0 * (row.q[0] + 0.1).powi(2);
    let drift = |h: f64| {
        let (q, v) = ([0.05, 0.9], [0.4, -2.0]);
        let [first, last] = [h, 3.0].map(|t| {
            plant
                .after((&q, &v), (0.0, t), &inputs, h)
                .expect("an answer")
        });
        (energy(&last) / energy(&first) - 1.0).abs()
    };
    // The error of fixed steps falls like their square.
    assert!(
        drift(1e-3) < 2e-4 && drift(2.5e-4) < 2e-5,
        "{} {}",
        drift(1e-3),
        drift(2.5e-4)
    );
}

/// Weight holds a pendulum back and inertia slows it: a small swing takes 2π √(J/(g l W)).
#[test]
fn weight_and_inertia_count_apart() {
    let mut mechanism = two_links(&mut Draw::new(3));
    mechanism.links.truncate(1);
    mechanism.gauges.truncate(1);
    let own = &mut mechanism.links[0];
    (own.mass, own.center, own.inertia) = (0.3, [0.0, -0.1], Inertia::Center(1e-3));
    own.counterweight = Some(Counterweight {
        name: "boom".into(),
        at: [0.0, -0.4],
        mass: 1.0,
    });
    let (weight, inertia) = (0.25, 1.5);
    let mut change = Change::none(&mechanism);
    change.counterweight[0] = [weight, inertia];
    let plant = Plant::new(&mechanism, change).expect("a machine");
    let about = 1e-3 + 0.3 * 0.01 + inertia * 0.16;
    let period = TAU * f64::sqrt(about / (9.80665 * (0.3 * 0.1 + weight * 0.4)));
    let after = plant.after((&[1e-3], &[0.0]), (0.0, period), &[Input::default()], 1e-3);
    let after = after.expect("an answer");
    assert!(
        (after.q[0] - 1e-3).abs() < 1e-8 && after.v[0].abs() < 1e-6,
        "{after:?}"
    );
}

/// A driven pendulum with both frictions, of which nobody knows the inertia: the first guess is near
/// to it, and the fit finds all three.
#[test]
fn an_inertia_that_nobody_knows_is_found() {
    let (mass, center, about, dry, viscous) = (0.7, 0.05, 4.4e-3, 4e-3, 1.5e-3);
    let moment = mass * 9.80665 * center;
    let drive = |t: f64| {
        if (0.3..1.2).contains(&t) {
            0.1
        } else {
            0.03 * (14.0 * t).sin()
        }
    };
    let slope = |t: f64, [q, v]: &[f64; 2]| {
        // Dry friction that sets in within 1 mrad/s, as the method needs a slope.
        let rub = dry * (v / 1e-3).tanh();
        [
            *v,
            (drive(t) - moment * q.sin() - rub - viscous * v) / about,
        ]
    };
    let rows = integrated([0.6, 0.0], 801, slope);
    let time: Vec<f64> = (0..801).map(|row| f64::from(row) * STEP).collect();
    let columns = [
        ("angle_rad", rows.iter().map(|x| x[0]).collect()),
        ("torque_nm", time.iter().map(|t| drive(*t)).collect()),
    ];
    let mut experiment = toy::measured(Sort::Machine, &[], &time, &columns);
    experiment.noise = vec![Some(1e-4), None];
    let mut mechanism = two_links(&mut Draw::new(1));
    mechanism.links.truncate(1);
    let own = &mut mechanism.links[0];
    (own.name, own.joint.name) = ("leg".into(), "leg".into());
    (own.mass, own.center, own.inertia) = (mass, [0.0, -center], Inertia::Unknown);
    mechanism.drives[0].column = "torque_nm".into();
    mechanism.gauges.truncate(1);
    mechanism.gauges[0].column = "angle_rad".into();
    experiment.mechanism = Some(mechanism);
    let kind = of(&experiment).expect("a model");
    let wanted = about - mass * center * center;
    let first = kind.causes()[0].parameters[0].neutral;
    assert_eq!(kind.common(), 1);
    // Windows of a tenth of a swing tell it to some per cent.
    assert!((first / wanted - 1.0).abs() < 0.15, "{first} {wanted}");
    let names = [
        "leg.coulomb_friction_n_m",
        "leg.viscous_friction_n_m_s_per_rad",
    ];
    let found = fitted(&kind, &names);
    // The torque's steps fall between rows of 5 ms, on which it is taken as a line.
    assert!((found[0][0] / dry - 1.0).abs() < 0.1, "{found:?}");
    assert!((found[1][0] / viscous - 1.0).abs() < 0.1, "{found:?}");
}

/// Sensors of a place, of an angle in the world and of a joint say the same as geometry does, early
/// and late.
#[test]
fn sensors_show_what_geometry_says() {
    let mut mechanism = ARM.mechanism();
    mechanism.gauges = vec![
        Gauge {
            column: "tip_x_m".into(),
            shows: Shows::Place {
                link: 1,
                at: [0.0, -0.2],
                axis: 0,
            },
        },
        Gauge {
            column: "tip_y_m".into(),
            shows: Shows::Place {
                link: 1,
                at: [0.0, -0.2],
                axis: 1,
            },
        },
        Gauge {
            column: "arm_rad".into(),
            shows: Shows::Angle {
                link: 1,
                back: true,
            },
        },
    ];
    let rows = integrated(STARTS[0], ROWS, |t, x| ARM.slope(*x, torque(t)));
    let time: Vec<f64> = (0..ROWS).map(|row| row as f64 * STEP).collect();
    let of_rows = |f: fn(&[f64; 4]) -> f64| rows.iter().map(f).collect::<Vec<f64>>();
    // A link that hangs swings back below as it turns forward.
    let columns = [
        (
            "tip_x_m",
            of_rows(|x| -0.25 * x[0].sin() - 0.2 * x[1].sin()),
        ),
        (
            "tip_y_m",
            of_rows(|x| -0.25 * x[0].cos() - 0.2 * x[1].cos()),
        ),
        ("arm_rad", of_rows(|x| -x[1])),
        ("shoulder_nm", time.iter().map(|t| torque(*t)).collect()),
    ];
    let mut experiment = toy::measured(Sort::Machine, &[], &time, &columns);
    experiment.mechanism = Some(mechanism);
    let kind = of(&experiment).expect("a model");
    let [a, b, da, db] = STARTS[0];
    let start = [a, b - a, da, db - da];
    let said = |terms: &Terms| kind.predict(0, terms, &start).expect("an answer");
    let exact = said(&Terms::off(kind.causes()));
    let readings = &kind.logs()[0].readings;
    for (reading, said) in readings.iter().zip(&exact) {
        assert!((reading.value - said).abs() < 1e-3, "{reading:?} {said}");
    }
    // One row late, it shows the row before.
    let late = said(&terms(&kind, &[("sensor-delay@tip_x_m", 0, STEP)]));
    for i in 3..exact.len() {
        let before = if readings[i].channel == 0 {
            exact[i - 3]
        } else {
            exact[i]
        };
        assert!((late[i] - before).abs() < 1e-9, "{i}");
    }
    // The start is solved for, as no joint has a sensor.
    for (own, wanted) in kind.unknowns(0).iter().zip(start) {
        assert!((own.neutral - wanted).abs() < 0.05, "{own:?} {wanted}");
    }
}

#[test]
fn a_spring_acts_on_its_side() {
    let linear = |side| Law::Linear {
        stiffness: 3.0,
        from: 0.5,
        side,
    };
    for (side, low, high) in [
        (Side::Both, 1.5, -1.5),
        (Side::Above, 0.0, -1.5),
        (Side::Below, 1.5, 0.0),
    ] {
        assert_eq!(linear(side).at(0.0), low, "{side}");
        assert_eq!(linear(side).at(1.0), high, "{side}");
    }
    let table = Law::Table(vec![[0.0, 1.0], [1.0, 3.0], [2.0, 0.0]]);
    for (x, force) in [
        (-1.0, -1.0),
        (0.0, 1.0),
        (0.5, 2.0),
        (1.5, 1.5),
        (3.0, -3.0),
    ] {
        assert!((table.at(x) - force).abs() < 1e-12, "{x}");
    }
}

/// A machine at rest starts at rest: its rate is as good as known.
#[test]
fn rest_at_the_start_is_seen() {
    let mut experiment = ARM.measured(&[[0.0; 4]]);
    for values in &mut experiment.runs[0].values[..2] {
        values[..40].fill(0.0);
    }
    let kind = of(&experiment).expect("a model");
    let rate = &kind.unknowns(0)[2];
    assert_eq!(rate.neutral, 0.0);
    assert!(
        (rate.bounds.1 - 5.0 * NOISE / (39.0 * STEP)).abs() < 1e-9,
        "{rate:?}"
    );
}

#[test]
fn what_is_no_machine_is_refused() {
    type Change<'c> = &'c dyn Fn(&mut Mechanism);
    let good = ARM.measured(&STARTS[..1]);
    let refused = |change: &dyn Fn(&mut Mechanism)| {
        let mut experiment = good.clone();
        change(experiment.mechanism.as_mut().expect("a mechanism"));
        of(&experiment).expect_err("no machine").to_string()
    };
    let cases: [(&str, Change); 6] = [
        ("0 links: must be from 1 to 12", &|m| m.links.clear()),
        ("column wrist_rad is missing", &|m| {
            m.gauges[0].column = "wrist_rad".into();
        }),
        ("column elbow_nm is missing", &|m| {
            m.drives[0].column = "elbow_nm".into();
        }),
        ("column elbow_rad is named twice", &|m| {
            m.gauges[0].column = "elbow_rad".into();
        }),
        ("nothing is measured", &|m| m.gauges.clear()),
        ("moves nothing that has mass", &|m| {
            (m.links[1].mass, m.links[1].inertia) = (0.0, Inertia::Center(0.0));
        }),
    ];
    for (expected, change) in cases {
        let said = refused(change);
        assert!(said.contains(expected), "{said}\n{expected}");
    }
    let table = |m: &mut Mechanism| {
        let law = Law::Table(vec![[0.0, 1.0], [0.0, 2.0]]);
        m.springs = vec![Spring { joint: 0, law }];
    };
    assert!(refused(&table).contains("which rise"));
    let mut none = good.clone();
    none.mechanism = None;
    assert!(
        of(&none)
            .expect_err("no file")
            .to_string()
            .contains("rig.chain is missing")
    );
}

/// A slope that a sensor's offset would explain as well is no cause; one that shows by itself is.
#[test]
fn a_slope_is_a_cause_where_it_shows() {
    let has_slope = |mechanism: Mechanism| {
        let mut experiment = ARM.measured(&STARTS[..1]);
        experiment.mechanism = Some(mechanism);
        let kind = of(&experiment).expect("a model");
        kind.causes().iter().any(|cause| cause.id == "ground-slope")
    };
    assert!(!has_slope(ARM.mechanism()));
    let mut two = ARM.mechanism();
    two.gauges[1].shows = Shows::Angle {
        link: 1,
        back: false,
    };
    assert!(has_slope(two));
}

/// Runs of one group are left out together.
#[test]
fn groups_are_left_out_whole() {
    let experiment = ARM.measured(&[STARTS[0], STARTS[1], STARTS[2], STARTS[0]]);
    let groups = [0, 0, 1, 2];
    let pieces = groups.map(|group| Piece {
        mechanism: 0,
        group,
    });
    let kind = Motions::new(&experiment, vec![ARM.mechanism()], pieces.to_vec()).expect("a model");
    let left_out: Vec<Vec<usize>> = folds(&kind, &Settings::default())
        .into_iter()
        .map(|fold| fold.runs)
        .collect();
    assert_eq!(left_out, [vec![0, 1], vec![2], vec![3]]);
}
