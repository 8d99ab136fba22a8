//! The fitted simulation against the multi-body simulation, for every term of the table.

use std::path::Path;

use saltus_diagnosis::rig::{Course, Rig, Start};
use saltus_robot::{Drive, Robot, Term, resolve};
use saltus_sim_check as sim_check;
use sim_check::{Happening, Settings, Sim};

/// How far the two may be apart in the lean (rad) and in height, travel and extension (m). Both
/// are exact to their tolerances. What remains is the error of the fitted simulation's fixed steps.
const TOLERANCE: f64 = 1e-5;

/// Terms in which they are further apart.
struct Apart {
    terms: &'static [Term],
    /// In which robots.
    in_robot: fn(&Robot) -> bool,
    /// How far.
    tolerance: f64,
    reason: &'static str,
}

const APART: &[Apart] = &[
    Apart {
        terms: &[Term::FootRadius, Term::Stroke],
        in_robot: |_| true,
        tolerance: 5e-5,
        reason: "steps over a foot that rolls on 5 cm or the edge of a table of forces",
    },
    Apart {
        terms: &[Term::AcrossFriction],
        in_robot: |_| true,
        tolerance: 6e-4,
        reason: "steps too long for friction that grows with speeds up to 0.1 mm/s",
    },
    Apart {
        terms: &[Term::GroundStiffness, Term::GroundDamping],
        in_robot: |robot| robot.leg.body.mass == 0.0,
        tolerance: 3e-2,
        reason: "the 20 g that a leg has at least on soft ground",
    },
];

/// Terms that say nothing of a motion from its start to its landing.
const UNKNOWN: &[(&[Term], &str)] = &[
    (&[Term::PickedUp], "it is the planar model's"),
    (
        &[Term::Restitution],
        "the motion ends before the touch-down",
    ),
    (
        &[
            Term::RateError,
            Term::FiringAngleError,
            Term::ValveOpenError,
            Term::SupplyError,
        ],
        "the scatter of inputs is no part of a motion",
    ),
    (
        &[Term::StrutDistance, Term::StrutRadius],
        "no strut meets anything on level ground",
    ),
    (
        &[
            Term::WheelCounts,
            Term::RadiusCounts,
            Term::PivotCounts,
            Term::FineGyroRange,
            Term::CoarseGyroRange,
            Term::GyroNoise,
            Term::GyroBias,
            Term::FineAccelerometerRange,
            Term::CoarseAccelerometerRange,
            Term::AccelerometerRadius,
            Term::AccelerometerNoise,
            Term::AccelerometerBias,
            Term::ConverterBits,
            Term::OutputDelayCycles,
            Term::LoopPeriod,
            Term::RangeReach,
            Term::RangeNoise,
            Term::RangePeriod,
        ],
        "what is measured is no part of a motion",
    ),
];

/// Values of terms that the laboratory does not turn, or turns further than the robots of
/// [`robots`] can stand.
const VALUES: &[(Term, f64)] = &[
    (Term::ImbalanceAngle, 1.0),
    (Term::LeastPulse, 0.03),
    (Term::ClosingDelay, 0.025),
    (Term::RodLength, 0.2),
    (Term::RodRadius, 0.05),
    (Term::ReturnStiffness, 200.0),
    (Term::ReturnPreload, 4.0),
    (Term::PortPosition, 0.03),
    (Term::CushionLength, 0.01),
    (Term::BoomRadius, 0.3),
    (Term::BoomFlex, 430.0),
    (Term::BoomFlexTime, 1.5e-3),
    (Term::Slope, 0.08),
    (Term::Tilt, 0.08),
    (Term::StaticFriction, 0.35),
    (Term::KineticFriction, 0.28),
    (Term::GroundStiffness, 1.2e4),
];

/// Terms that act only together.
const GROUPS: &[&[Term]] = &[
    &[Term::Imbalance, Term::ImbalanceAngle],
    &[
        Term::RodLength,
        Term::RodRadius,
        Term::LegCenter,
        Term::LegMass,
    ],
    &[Term::ReturnStiffness, Term::ReturnPreload],
    &[Term::PortPosition, Term::PortArea],
    &[
        Term::CushionLength,
        Term::CushionStiffness,
        Term::CushionDamping,
    ],
    &[Term::BoomFlex, Term::BoomFlexTime],
    &[Term::CounterweightDistance, Term::CounterweightMass],
    &[Term::StaticFriction, Term::KineticFriction],
    &[Term::GroundStiffness, Term::GroundDamping],
    &[Term::TubeLength, Term::TubeDiameter, Term::TubeRoughness],
    &[Term::TankVolume, Term::TankWall],
];

/// A start on the retracted foot (rad, rad/s), when the leg is commanded, and for how long (s).
#[derive(Clone, Copy, Debug)]
struct Launch {
    lean: f64,
    rate: f64,
    fire: f64,
    opening: f64,
}

/// One that fires over the whole stroke, and one whose drive is switched off within it.
const LAUNCHES: [Launch; 2] = [
    Launch {
        lean: -0.3,
        rate: 4.5,
        fire: 0.06,
        opening: 0.08,
    },
    Launch {
        lean: 0.02,
        rate: 3.0,
        fire: 0.0,
        opening: 0.02,
    },
];

fn built_in(name: &str) -> Robot {
    resolve(name, &[]).expect("sound")
}

/// Each drive with legs that have no mass, free and on a boom; and the thesis' robot, whose legs
/// have mass.
fn robots() -> Vec<Robot> {
    let thesis = built_in("rats-boom");
    let mut rough = thesis.clone();
    (rough.ground.static_friction, rough.ground.kinetic_friction) = (3.0, 3.0);
    rough.name += " on rough ground";
    let mut pushed = built_in("spring-hopper");
    pushed.leg.drive = Drive::Constant { force: 120.0 };
    pushed.name = "constant-hopper".into();
    let free = ["rats-planar", "spring-hopper", "table-hopper"].map(built_in);
    let mut all = vec![thesis.clone(), rough];
    for robot in free.into_iter().chain([pushed]) {
        let mut on_boom = robot.clone();
        on_boom.boom = thesis.boom;
        on_boom.name += " on a boom";
        all.extend([robot, on_boom]);
    }
    all.extend(fed());
    all
}

/// The thesis' robot with a tank, tubes and spools; and one with muscles instead of cylinders.
fn fed() -> Vec<Robot> {
    let tank = [
        "tank.volume_l=0.3",
        "tank.wall_resistance_k_per_w=5",
        "leg.tube.length_m=0.5",
        "leg.tube.diameter_mm=4",
        "leg.tube.roughness_mm=0.01",
        "leg.valve_time_constant_ms=2",
    ];
    let tank = resolve("rats-boom", &tank.map(String::from)).expect("sound");
    let page = include_str!("../../robots/README.md");
    let mut examples = page
        .split("```toml\n")
        .filter_map(|rest| rest.split("```").next());
    let muscle = examples.find(|text| text.contains("kind = \"muscle\""));
    let muscle = Robot::parse(muscle.expect("it is there"), "muscle", Path::new("."));
    vec![tank, muscle.expect("sound")]
}

/// The robot of the page of keys, which has every term.
fn everything() -> Robot {
    let readme = include_str!("../../robots/README.md");
    let page = readme.split("```toml\n").nth(1);
    let page = page
        .and_then(|rest| rest.split("```").next())
        .expect("the page of keys");
    Robot::parse(page, "page", Path::new(".")).expect("the page is a robot")
}

/// Values of `term` to set in `robot`: above, the laboratory's, or others than its own.
fn values(term: Term, robot: &Robot) -> Vec<f64> {
    if let Some((_, value)) = VALUES.iter().find(|(of, _)| *of == term) {
        return vec![*value];
    }
    let mut hidden = term.spec().hidden.to_vec();
    hidden.dedup();
    if !hidden.is_empty() {
        return hidden;
    }
    let own = term.of(robot).filter(|x| *x != 0.0 && x.is_finite());
    let value = own.map(|x| 1.1 * x).or_else(|| term.of(&everything()));
    vec![value.unwrap_or_else(|| panic!("{term:?} needs a value in VALUES"))]
}

/// `robot` with `term` at `value`, and what acts only with it.
fn with(robot: &Robot, term: Term, value: f64) -> Robot {
    let mut robot = robot.clone();
    let group = GROUPS.iter().find(|group| group.contains(&term));
    for &other in group.copied().unwrap_or_default() {
        let value = values(other, &robot)[0];
        other.set(&mut robot, value);
    }
    term.set(&mut robot, value);
    assert!(
        term.domain(&robot).contains(value),
        "{}: {term:?} = {value}",
        robot.name
    );
    robot
}

/// Time (s) over which a gyro's rate is compared, as the angle that it comes to.
const GYRO: f64 = 0.01;

/// What sensors read: lean (rad), height, travel and extension (m), turn and pivot of a boom (rad),
/// and what the wheel's gyro says over 10 ms (rad).
type Row = [f64; 7];

/// What they read of `course` at `time` (s).
fn at(course: &Course, time: f64) -> Row {
    let pose = course.at(time, &mut 0);
    let boom = pose.boom.unwrap_or_default();
    [
        pose.lean.0,
        pose.height.0,
        pose.travel.0,
        pose.extension.0,
        boom.turn.0,
        boom.pivot.0,
        GYRO * (pose.lean.1 + boom.turn.1 * boom.pivot.0.sin()),
    ]
}

/// Greatest difference of two rows.
fn apart(a: &Row, b: &Row) -> f64 {
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
}

/// Jump of `robot` after `launch` up to `end` (s), as the fitted simulation has it.
fn jump(robot: &Robot, launch: &Launch, end: f64) -> Course {
    let (lean, rate) = (launch.lean, launch.rate);
    let shut = launch.fire + launch.opening;
    Rig::new(robot)
        .jump(Start::Rolling { lean, rate }, launch.fire, shut, Some(end))
        .unwrap_or_else(|| panic!("{}, {launch:?}: a motion", robot.name))
}

/// Poses of the multi-body simulation every 4 ms until it lands, falls over or has stood for 0.6 s,
/// from the same start; soft ground carries it from there.
fn poses(robot: &Robot, launch: &Launch) -> Vec<(f64, Row)> {
    let rig = sim_check::Rig::new(robot, &[]).expect("a rig");
    let (mut q, mut v) = rig.stand(launch.lean, launch.rate).expect("a start");
    let lean = rig.lean_coordinate();
    if robot.ground.stiffness.is_some() {
        let start = jump(robot, launch, 0.0).at(0.0, &mut 0);
        let of_boom = start.boom.map(|boom| [boom.turn, boom.pivot]);
        let first = of_boom.unwrap_or([start.travel, start.height]);
        for (k, (place, rate)) in first.into_iter().enumerate() {
            (q[k], v[k]) = (place, rate);
        }
    }
    let settings = Settings {
        penetration: 0.05,
        ..Settings::default()
    };
    let mut sim = Sim::new(&rig.mechanism, &q, &v, settings).expect("a start");
    let left = |sim: &Sim<'_>| {
        let events = sim.events();
        events.iter().any(|e| e.what == Happening::LiftOff(0, 0))
    };
    // Where a robot that does not jump comes down on its next foot.
    let next_foot = 0.98 * std::f64::consts::PI / f64::from(robot.body.legs);
    let mut found = Vec::new();
    let (mut is_fired, mut flies) = (false, false);
    for tick in 1..1000 {
        let time = 4e-3 * f64::from(tick);
        while sim.time() < time {
            let until = if is_fired {
                time
            } else {
                launch.fire.min(time)
            };
            sim.run_eventwise(until, &[]).expect("a motion");
            if !flies && left(&sim) {
                flies = true;
                sim.stop_touching();
            }
            if !is_fired && sim.time() >= launch.fire {
                is_fired = true;
                sim.fire(0, launch.opening).expect("a command");
            }
        }
        let q = sim.coordinates();
        let [travel, height] = rig.axle(q);
        let ends = if flies {
            height < rig.radius
        } else {
            q[lean].abs() > next_foot.min(1.4) || time > 0.6
        };
        if ends {
            break;
        }
        let v = sim.velocities();
        let [turn, pivot] = if robot.boom.is_some() {
            [q[0], q[1]]
        } else {
            [0.0; 2]
        };
        let gyro = v[rig.lean_velocity()] + v[0] * pivot.sin();
        let extension = q[rig.extension_coordinate(0)];
        let row = [q[lean], height, travel, extension, turn, pivot, GYRO * gyro];
        found.push((time, row));
    }
    found
}

/// How far the two simulations of `robot` are apart, and how far the motion is from that of
/// `plain`.
fn compare(robot: &Robot, plain: &Robot, launch: &Launch) -> (f64, f64) {
    let poses = poses(robot, launch);
    let end = poses.last().map_or(0.0, |(time, _)| *time);
    let (course, before) = (jump(robot, launch, end), jump(plain, launch, end));
    let (mut off, mut shows) = (0.0_f64, 0.0_f64);
    for (time, pose) in poses {
        let found = at(&course, time);
        off = off.max(apart(&found, &pose));
        shows = shows.max(apart(&found, &at(&before, time)));
    }
    (off, shows)
}

/// Where the two simulations are further apart under `term` than they may be, and how much the
/// term shows at most.
fn try_out(term: Term, robots: &[Robot]) -> (Vec<String>, f64) {
    let (mut wrong, mut most) = (Vec::new(), 0.0_f64);
    for plain in robots.iter().filter(|robot| term.applies(robot)) {
        let known = |apart: &&Apart| apart.terms.contains(&term) && (apart.in_robot)(plain);
        let (tolerance, reason) = APART
            .iter()
            .find(known)
            .map_or((TOLERANCE, "steps"), |apart| {
                (apart.tolerance, apart.reason)
            });
        for value in values(term, plain) {
            let robot = with(plain, term, value);
            for launch in &LAUNCHES {
                let (off, shows) = compare(&robot, plain, launch);
                most = most.max(shows);
                if off.is_nan() || off > tolerance {
                    let name = &robot.name;
                    wrong.push(format!(
                        "{name}, {term:?} = {value}, {launch:?}: apart by {off:.1e}, by {reason} \
                         {tolerance:.0e}"
                    ));
                }
            }
        }
    }
    (wrong, most)
}

/// A term that shows in no robot would not be tested.
#[test]
#[ignore = "nightly: 8 s"]
fn every_term_does_what_it_does_in_the_multi_body_simulation() {
    let robots = robots();
    let mut wrong = Vec::new();
    for &term in Term::ALL {
        if UNKNOWN.iter().any(|(all, _)| all.contains(&term)) {
            continue;
        }
        let (apart, shows) = try_out(term, &robots);
        wrong.extend(apart);
        if shows < 10.0 * TOLERANCE {
            wrong.push(format!("{term:?} shows by {shows:.1e} only"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Also where the axle passes over the foot before it is fired off it, and where the leg fires late
/// and low; whatever drives the leg: a spring is not caught again, and where a motor is switched
/// off within the stroke the foot leaves.
#[test]
fn an_outcome_is_the_apex_and_the_landing_of_the_flight() {
    for robot in robots() {
        let fast = Rig::new(&robot);
        let whole = sim_check::Rig::new(&robot, &[]).expect("a rig");
        for [lean, rate, valve_open] in [
            [-0.25, 4.0, 0.08],
            [-0.054, 6.0, 0.083],
            [-0.017, 3.05, 0.071],
            [0.1, 5.0, 0.05],
            [0.3, 3.5, 0.04],
            [-0.1, 3.5, 0.02],
        ] {
            let launch = sim_check::Launch {
                lean,
                rate,
                firing_angle: lean,
                valve_open,
            };
            let plan = sim_check::Plan {
                landing_height: robot.body.radius,
                ..sim_check::Plan::default()
            };
            let report = whole.jump(&launch, &plan).expect("a motion");
            let (apex, landing) = fast.outcome(lean, rate, valve_open).expect("a jump");
            // Of one low jump, off a muscle, the multi-body simulation gives no landing.
            let has_landing = !report.landing_at.is_nan();
            assert!(
                has_landing || robot.name == "muscle leg" && lean == 0.3,
                "{}",
                robot.name
            );
            let landing_off = if has_landing {
                landing - report.landing_at
            } else {
                0.0
            };
            let off = [apex - report.apex, landing_off];
            assert!(
                off[0].abs() < 3e-6 && off[1].abs() < 5e-6,
                "{} {launch:?}: apex and landing off by {off:?} m",
                robot.name
            );
        }
    }
}

/// Also on ground that has given way under the robot at rest.
#[test]
fn a_hop_from_rest_is_that_of_the_multi_body_simulation() {
    let soft = [
        "ground.stiffness_n_per_m=1.2e4",
        "ground.damping_n_s_per_m=90",
    ];
    let rough = ["ground.static_friction=3", "ground.kinetic_friction=3"];
    let cases = [vec![], soft.to_vec(), [soft, rough].concat()];
    for (terms, opening) in cases.iter().zip([0.02, 0.04, 0.08]) {
        let overrides: Vec<String> = terms.iter().map(ToString::to_string).collect();
        let robot = resolve("rats-boom", &overrides).expect("sound");
        let firing = sim_check::Firing {
            lean: 0.0,
            rate: 0.0,
            on: 0.005,
            opening,
        };
        let rig = sim_check::Rig::new(&robot, &[]).expect("a rig");
        let flown = rig.flown(&firing, Settings::default()).expect("a hop");
        let end = sim_check::TICK * flown.rows.len() as f64;
        let course = Rig::new(&robot)
            .jump(Start::Rest, firing.on, firing.on + opening, Some(end))
            .expect("a hop");
        for (tick, [_, pivot, ..]) in flown.rows.iter().enumerate() {
            let time = sim_check::TICK * tick as f64;
            let off = course.at(time, &mut 0).boom.expect("a boom").pivot.0 - pivot;
            assert!(
                off.abs() < 1e-6,
                "{terms:?}, {opening} s: off by {off} rad at {time} s"
            );
        }
    }
}
