//! Lengths that gravity and drives cannot move as fast as was measured, or as far.

use saltus_numeric::statistics::quantile;

use super::{Check, DEGREE, LENGTHS, TIMES, Units, View, clock, slope_and_bend};
use crate::mechanism::{Mechanism, Shows};

const GRAVITY: f64 = 9.806_65;
/// Length (m) of a machine above which its lengths are doubted: a stiff spring that nobody states moves a
/// short one as fast.
const DOUBTED: f64 = 0.5;

/// The numbers of a mass on a guide.
pub(crate) const SLIDE: &[Check] = &[
    Check {
        name: "position_m",
        sizes: |view| {
            let way = driven(view)?;
            // What of it is doubted: forces that nobody measured.
            (way.own > 3.0 * way.most).then_some((way.own, 0.5 * way.free))
        },
        what: "half the way of a free mass under the measured force",
        allowed: (0.0, 3.0),
        strict: false,
        units: LENGTHS,
    },
    clock(
        |view| {
            let way = driven(view)?;
            view.paced(way.free, way.span)
        },
        TIMES,
    ),
];

/// The numbers of a pendulum.
pub(crate) const PENDULUM: &[Check] = &[
    Check {
        name: "angle_rad",
        sizes: |view| Some((swing(view, "angle_rad")?, 0.3)),
        what: "the amplitude of a usual swing",
        // Beyond half a turn nothing swings to and fro.
        allowed: (0.0, 11.0),
        strict: false,
        units: &[("deg", DEGREE)],
    },
    Check {
        name: "centre_from_axle_m",
        sizes: |view| {
            let length = view.setting("centre_from_axle_m")?;
            let [able, measured] = pendulum(view)?;
            (length > DOUBTED).then_some((length, length * able / measured))
        },
        what: "the length at which gravity and the torque move it as fast as measured",
        allowed: (0.0, 10.0),
        strict: false,
        units: LENGTHS,
    },
    Check {
        name: "inertia_about_centre_kg_m2",
        sizes: |view| {
            let inertia = view.setting("inertia_about_centre_kg_m2")?;
            let [able, measured] = pendulum(view)?;
            Some((inertia, inertia * able / measured))
        },
        what: "the inertia at which gravity and the torque move it as fast as measured",
        allowed: (0.0, 30.0),
        strict: true,
        units: &[
            ("kg cm2", 1e-4),
            ("g m2", 1e-3),
            ("kg mm2", 1e-6),
            ("g cm2", 1e-7),
        ],
    },
    clock(
        |view| {
            let [able, measured] = pendulum(view)?;
            view.paced(able, measured)
        },
        TIMES,
    ),
];

/// The angles of a machine, and the lengths of its links.
pub(crate) const LINKS: Check = Check {
    name: "*_rad",
    sizes: |view| {
        let machine = view.mechanism?;
        let link = machine.gauges.iter().find_map(|gauge| match gauge.shows {
            Shows::Coordinate(link) | Shows::Angle { link, .. } if gauge.column == view.name => {
                Some(link)
            }
            _ => None,
        })?;
        Some((acceleration(view, view.name)?, able(view, machine, link)?))
    },
    what: "the acceleration (rad/s²) that gravity, springs and drives give such links",
    allowed: (1e-5, 15.0),
    strict: false,
    units: &[
        ("rad, and time_s in ms", 1e6),
        ("deg", DEGREE),
        ("rad, and the lengths of links in mm", 1e-3),
        ("rad, and the lengths of links in cm", 1e-2),
        ("rad, and the lengths of links in inch", 0.0254),
    ],
};

/// The places of a machine.
pub(crate) const PLACES: Check = Check {
    name: "*_m",
    sizes: |view| {
        let machine = view.mechanism?;
        let mut gauges = machine.gauges.iter();
        let gauge = gauges.find(|gauge| gauge.column == view.name)?;
        let (link, at) = match gauge.shows {
            Shows::Place { link, at, .. } => (link, at),
            Shows::Coordinate(link) => (link, [0.0; 2]),
            Shows::Angle { .. } => return None,
        };
        if machine
            .to_ground(link)
            .all(|k| machine.links[k].joint.turns())
        {
            let joints = machine
                .to_ground(link)
                .map(|k| size(machine.links[k].joint.at));
            return Some((
                view.span(view.name)?,
                2.0 * (joints.sum::<f64>() + size(at)),
            ));
        }
        let drives = machine.drives.iter();
        let force: f64 = drives
            .filter_map(|drive| largest(view, &drive.column))
            .sum();
        let mass: f64 = machine.links.iter().map(|link| link.mass).sum();
        let springs: f64 = (machine.springs.iter())
            .filter(|spring| !machine.links[spring.joint].joint.turns())
            .map(|spring| spring.law.at(0.0).abs().max(spring.law.at(0.1).abs()))
            .sum();
        let [_, bend] = slope_and_bend(&view.run.time, view.column(view.name)?)?;
        Some((
            (2.0 * bend).abs(),
            machine.gravity + (force + springs) / mass,
        ))
    },
    what: "what the lengths of the links, or gravity and the drives (m/s²), allow",
    allowed: (0.0, 10.0),
    strict: false,
    units: LENGTHS,
};

/// What gauges in other units make of a force (N), and of the force that a bore would have.
pub(crate) const FORCES_AND_BORES: Units = &[
    ("lbf", 4.448_221_615_260_5),
    ("kgf", GRAVITY),
    ("kN", 1e3),
    ("N, and bore_m in ft", 10.763_910_416_709_7),
    ("N, and bore_m in inch", 1_550.003_100_006_2),
    ("N, and bore_m in cm", 1e4),
    ("N, and bore_m in mm", 1e6),
];

/// Ways (m) of a mass.
struct Way {
    /// From its least to its greatest place.
    span: f64,
    /// The same beyond what its first speed makes.
    own: f64,
    /// That of a free mass under the measured force.
    free: f64,
    /// The farthest that force, weight and first speed can push it: springs that hold the mass, friction and
    /// drag only take from the work of the force, and no mass is faster than ∫|F| dt/m.
    most: f64,
}

fn driven(view: &View<'_>) -> Option<Way> {
    /// Part of the rows that tell the first speed.
    const FIRST: usize = 20;
    let mass = view.setting("mass_kg")?;
    let (time, forces) = (&view.run.time, view.column("force_n")?);
    let position = view.column("position_m")?;
    let first = (time.len() / FIRST).max(3).min(time.len());
    let [speed, _] = slope_and_bend(&time[..first], &position[..first])?;
    let span = view.span("position_m")?;
    let ([mut free, mut most], [mut at, mut bound]) = ([0.0; 2], [0.0; 2]);
    let (mut low, mut high) = (0.0_f64, 0.0_f64);
    for (times, force) in time.windows(2).zip(forces) {
        let (step, force) = (times[1] - times[0], Some(*force).filter(|f| f.is_finite()));
        let pull = force.unwrap_or(0.0) / mass;
        free += step * pull;
        most += step * (pull.abs() + GRAVITY);
        at += step * free;
        bound += step * most;
        (low, high) = (low.min(at), high.max(at));
    }
    Some(Way {
        span,
        own: span - speed.abs() * view.length()?,
        free: high - low,
        most: bound,
    })
}

/// Half the span (rad) of an angle that goes to and fro about its middle.
fn swing(view: &View<'_>, name: &str) -> Option<f64> {
    /// Passes through the middle from which on it does so.
    const PASSES: usize = 4;
    let values = view.column(name)?;
    let half = 0.5 * view.span(name)?;
    let middle = quantile(values, 0.05)? + half;
    // Noise about the middle is no pass.
    let sides = values.iter().map(|value| value - middle);
    let mut sides: Vec<bool> = sides
        .filter(|x| x.abs() > 0.5 * half)
        .map(|x| x > 0.0)
        .collect();
    sides.dedup();
    (sides.len() > PASSES).then_some(half)
}

/// Acceleration of a column that it exceeds in a tenth of its rows, by differences over a hundredth of
/// the run.
fn acceleration(view: &View<'_>, name: &str) -> Option<f64> {
    let values = view.column(name)?;
    let rows = (view.run.time.iter().zip(values)).filter(|(_, value)| value.is_finite());
    let rows: Vec<(&f64, &f64)> = rows.collect();
    let lag = (rows.len() / 100).max(1);
    let of = |k: usize| {
        let [a, b, c] = [rows[k], rows[k + lag], rows[k + 2 * lag]];
        let rate = |a: (&f64, &f64), b: (&f64, &f64)| (b.1 - a.1) / (b.0 - a.0);
        (2.0 * (rate(b, c) - rate(a, b)) / (c.0 - a.0)).abs()
    };
    let all: Vec<f64> = (0..rows.len().saturating_sub(2 * lag)).map(of).collect();
    quantile(&all, 0.9)
}

/// Greatest magnitude of a column.
fn largest(view: &View<'_>, name: &str) -> Option<f64> {
    let values = view.column(name)?.iter().filter(|value| value.is_finite());
    Some(values.fold(0.0, |most, value| value.abs().max(most)))
}

fn size([x, y]: [f64; 2]) -> f64 {
    x.hypot(y)
}

/// Acceleration (rad/s²) that gravity and the torque give a pendulum of this length (m), and the
/// measured one.
fn pendulum(view: &View<'_>) -> Option<[f64; 2]> {
    let length = view.setting("centre_from_axle_m")?;
    let mass = view.setting("mass_kg")?;
    let inertia = view.setting("inertia_about_centre_kg_m2").unwrap_or(0.0);
    let lifted = (0.5 * view.span("angle_rad")?).min(1.0);
    let torque = mass * GRAVITY * length * lifted + largest(view, "torque_nm").unwrap_or(0.0);
    let able = torque / (inertia + mass * length * length);
    Some([able, acceleration(view, "angle_rad")?])
}

/// Acceleration (rad/s²) that gravity, springs and drives give a joint that turns, with all that it
/// carries stretched out.
fn able(view: &View<'_>, machine: &Mechanism, link: usize) -> Option<f64> {
    let half = 0.5 * view.span(view.name)?;
    let (mut torque, mut inertia, mut reach) = (0.0, 0.0, 0.0_f64);
    for (k, own) in machine.links.iter().enumerate() {
        if !machine.carries(link, k) {
            continue;
        }
        let outer = machine.to_ground(k).take_while(|joint| *joint != link);
        let joints: f64 = outer.map(|joint| size(machine.links[joint].joint.at)).sum();
        let away = joints + size(own.center);
        let about = match own.inertia {
            crate::mechanism::Inertia::Center(inertia) => inertia,
            crate::mechanism::Inertia::Unknown => 0.0,
        };
        torque += own.mass * machine.gravity * away * half.min(1.0);
        inertia += about + own.mass * away * away;
        reach = reach.max(away);
    }
    let turning = |joint: usize| machine.links[joint].joint.turns();
    let drives = machine.drives.iter().filter(|drive| turning(drive.joint));
    let drives = drives.filter_map(|drive| largest(view, &drive.column));
    let springs = machine
        .springs
        .iter()
        .filter(|spring| turning(spring.joint));
    let springs = springs.map(|spring| {
        let ends = [-half, 0.0, half].map(|q| spring.law.at(q).abs());
        ends.into_iter().fold(0.0, f64::max)
    });
    torque += drives.chain(springs).sum::<f64>();
    (reach > DOUBTED).then_some(torque / inertia)
}

#[cfg(test)]
mod tests {
    use crate::experiment::{Experiment, Run, Sort};
    use crate::kinds;
    use crate::layout::{Draw, Layout};
    use crate::mechanism::{Gauge, Shows};
    use crate::plausible::implausible;

    /// What is said of a mass (1 kg) under a force (N), at these places (m) for a second.
    fn said(force: f64, place: impl Fn(f64) -> f64) -> Option<String> {
        let time: Vec<f64> = (0..=100).map(|k| 0.01 * f64::from(k)).collect();
        let experiment = Experiment {
            kind: Sort::Slide,
            columns: vec!["force_n".into(), "position_m".into()],
            noise: vec![None; 2],
            resolution: vec![None; 2],
            mechanism: None,
            runs: vec![Run {
                name: "a.csv".into(),
                settings: [("mass_kg".to_owned(), 1.0)].into(),
                values: vec![
                    vec![force; time.len()],
                    time.iter().map(|t| place(*t)).collect(),
                ],
                time,
                ..Run::default()
            }],
        };
        implausible(&experiment, None).map(|found| found.symptom)
    }

    #[test]
    fn no_mass_goes_farther_than_its_drive_can_push_it() {
        // 2 N push 1 kg a metre in a second: 300 of them are millimetres, with some friction.
        for size in [300.0, 1000.0] {
            let far = said(2.0, |t| size * t * t).expect("refused");
            assert!(far.ends_with("is it in mm?"), "{far}");
        }
        assert_eq!(said(2.0, |t| t * t), None);
        // It was fast at the start; it falls; a spring throws it.
        assert_eq!(said(0.001, |t| 3.0 * t - 0.5 * t * t), None);
        assert_eq!(said(2.0, |t| 4.9 * t * t), None);
        assert_eq!(said(0.0, |t| 0.1 * (1.0 - (30.0 * t).cos())), None);
    }

    /// An arm whose hand is seen: places reach as far as the links.
    #[test]
    fn no_hand_reaches_farther_than_its_arm() {
        let layout = Layout::new(Sort::Machine, false, Some(1), &mut Draw::new(3));
        let said = |unit: f64| {
            let mut own = layout.experiment.clone();
            let machine = own.mechanism.as_mut().expect("a machine");
            machine.gauges.push(Gauge {
                column: "hand_m".into(),
                shows: Shows::Place {
                    link: 1,
                    at: [0.0, -0.2],
                    axis: 0,
                },
            });
            own.columns.push("hand_m".into());
            own.noise.push(None);
            own.resolution.push(None);
            let run = &mut own.runs[0];
            run.values.push(
                run.time
                    .iter()
                    .map(|t| 0.3 * unit * (5.0 * t).sin())
                    .collect(),
            );
            kinds::build(&own, None).expect("a model");
            implausible(&own, None).map(|found| (found.name, found.symptom))
        };
        assert_eq!(said(1.0), None);
        let (name, symptom) = said(1000.0).expect("refused");
        assert!(
            name == "hand_m" && symptom.ends_with("is it in mm?"),
            "{name} {symptom}"
        );
    }
}
