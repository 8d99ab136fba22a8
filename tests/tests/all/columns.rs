//! Every column that a kind of experiment with a robot or a machine predicts, against the multi-body
//! simulation.

use std::collections::BTreeMap;

use saltus::gait::{
    Disturbance, Footfall, Logger, Row, Run as Follower, Setup, Smooth, What, When, run,
};
use saltus_diagnosis::kinds::Problem;
use saltus_diagnosis::layout::{Draw, Layout};
use saltus_diagnosis::mechanism::{
    Drive, Gauge, Inertia, Joint, Law, Link, Mechanism, Shows, Side, Spring, Way,
};
use saltus_diagnosis::{Channel, Experiment, Run, Sort, Terms, kinds};
use saltus_robot::{Robot, resolve};
use saltus_sim_check::{
    self as sim_check, Body, Firing, Launch, Placement, Settings, Sim, Stepping, TICK, Vec3,
};

/// Kinds of which the multi-body simulation makes data.
const KINDS: [Sort; 8] = [
    Sort::Bench,
    Sort::Hop,
    Sort::Jump,
    Sort::Outcomes,
    Sort::Run,
    Sort::TankLeg,
    Sort::Walk,
    Sort::Machine,
];

/// Columns that are not compared here.
const NOT_COMPARED: &[(Sort, &[&str], &str)] = &[
    (
        Sort::Outcomes,
        &["omega_rad_s", "alpha_f_rad", "valve_open_s"],
        "requests, which nothing predicts",
    ),
    (
        Sort::Run,
        &[
            "valve_1", "valve_2", "valve_3", "valve_4", "valve_5", "valve_6", "valve_7", "valve_8",
            "valve_9", "valve_10", "valve_11", "valve_12",
        ],
        "commands, which nothing predicts",
    ),
    (
        Sort::Walk,
        &["outer_leg_stands", "torque_nm"],
        "inputs, which nothing predicts",
    ),
    (
        Sort::Machine,
        &["*_nm", "*_n"],
        "inputs, which nothing predicts",
    ),
    (
        Sort::TankLeg,
        &[
            "valve_*",
            "torso_y_m",
            "torso_angle_rad",
            "*_angle_rad",
            "foot_*_y_m",
        ],
        "commands, and the posture at the start, which nothing predicts",
    ),
    (
        Sort::TankLeg,
        &["tank_pressure_gauge_pa", "*_pressure_gauge_pa", "com_y_m"],
        "no robot of the multi-body simulation; lab.rs compares two models of a tank leg",
    ),
    (
        Sort::TankLeg,
        &["com_x_m"],
        "no robot of the multi-body simulation, and no column of the laboratory: compared nowhere",
    ),
];

/// Keys of a robot file by which the robots differ.
const ROBOTS: [(&str, &[&str]); 5] = [
    ("as it is", &[]),
    (
        "tank",
        &[
            "tank.volume_l=0.3",
            "tank.wall_resistance_k_per_w=5",
            "leg.tube.length_m=0.5",
            "leg.tube.diameter_mm=4",
            "leg.valve_time_constant_ms=2",
        ],
    ),
    // A point that does not slip does not know the slope.
    ("slope", &["ground.slope_deg=1", "foot.radius_mm=20"]),
    ("round foot", &["foot.radius_mm=20"]),
    ("heavy legs", &["leg.mass_kg=0.15", "leg.center_m=0.19"]),
];

/// Robots of which a kind has no data, by the start of their names.
const LEFT_OUT: &[(Sort, &str, &str)] = &[
    (Sort::Run, "tank", "the kind refuses it"),
    (
        Sort::Run,
        "slope",
        "it makes three strides at most that can be read",
    ),
    (
        Sort::Run,
        "heavy legs, on a boom",
        "it makes three strides that can be read",
    ),
    (Sort::Run, "round foot, on a boom", "it rolls backwards"),
];

/// Root mean square difference of a prediction, as a part of the range of its column: ten times what
/// fixed steps leave.
const TOLERANCE: f64 = 2e-5;

/// Kinds that are further apart, and how far in the noise of the instrument.
const APART: &[(Sort, f64, &str)] = &[
    (
        Sort::Run,
        0.6,
        "starts are estimated, and legs that are out add inertia only",
    ),
    (
        Sort::Walk,
        1.0,
        "steps across which dry friction at the hip turns",
    ),
    (
        Sort::Machine,
        0.3,
        "steps across which dry friction of the joints turns",
    ),
];

/// Data of the multi-body simulation without noise.
struct Recording {
    name: String,
    experiment: Experiment,
    robot: Option<Robot>,
    /// The unknowns of its runs; empty: as they are estimated from the data.
    unknowns: Vec<Vec<f64>>,
}

/// The robot on a boom, or without one.
fn robot(sort: Sort, on_boom: bool, keys: &[&str]) -> Robot {
    let name = match (sort, on_boom) {
        (Sort::Run, _) => "rats-run",
        (_, true) => "rats-boom",
        (_, false) => "rats-planar",
    };
    let keys: Vec<String> = keys.iter().map(ToString::to_string).collect();
    let mut robot = resolve(name, &keys).expect("a robot");
    robot.boom = robot.boom.filter(|_| on_boom);
    robot
}

/// Noise or step of the instruments, by the ends of the columns' names.
const INSTRUMENTS: [(&str, f64); 13] = [
    ("wheel_angle_rad", 7.854e-3),
    ("pivot_angle_rad", 3.927e-3),
    ("radius_angle_rad", 3.927e-3),
    ("hip_angle_rad", 7.67e-4),
    ("lean_rad", 4.363e-5),
    ("wheel_rate_rad_s", 0.1),
    ("position_m", 1e-4),
    ("pressure_pa", 2e3),
    ("distance_m", 3e-3),
    ("apex_m", 2e-3),
    ("tip_x_m", 5e-4),
    ("_rad", 5e-4),
    ("_m", 2e-3),
];

/// Noise or step of the instrument of a column, if it has one.
fn noise(column: &str) -> Option<f64> {
    let own = INSTRUMENTS.iter().find(|(end, _)| column.ends_with(end))?;
    Some(own.1)
}

/// An experiment of runs with these columns, without noise; what it has is known all the same.
fn experiment(kind: Sort, columns: &[&str], runs: Vec<Run>) -> Experiment {
    Experiment {
        kind,
        columns: columns.iter().map(ToString::to_string).collect(),
        noise: columns.iter().map(|column| noise(column)).collect(),
        resolution: vec![None; columns.len()],
        mechanism: None,
        runs,
    }
}

/// The supply of a robot, among the settings of a run.
fn supply(robot: &Robot) -> BTreeMap<String, f64> {
    let cylinder = robot.leg.cylinder().expect("a pneumatic leg");
    [("supply_pressure_gauge_pa".to_owned(), cylinder.supply.0)].into()
}

/// Hops or jumps.
fn firings(sort: Sort, robot: &Robot) -> (Experiment, Vec<Vec<f64>>) {
    const COLUMNS: [&str; 6] = [
        "wheel_angle_rad",
        "pivot_angle_rad",
        "radius_angle_rad",
        "wheel_rate_rad_s",
        "x_m",
        "y_m",
    ];
    let is_there = |k: &usize| {
        let name = COLUMNS[*k];
        let of_boom = matches!(name, "pivot_angle_rad" | "radius_angle_rad");
        sort.spec().channel(name).is_some() && (robot.boom.is_some() || !of_boom)
    };
    let columns: Vec<usize> = (0..COLUMNS.len()).filter(is_there).collect();
    let rig = sim_check::Rig::new(robot, &[]).expect("a rig");
    let (mut runs, mut unknowns) = (Vec::new(), Vec::new());
    for (lean, rate, on, opening) in [(-0.3, 4.5, 0.07, 0.08), (-0.2, 5.5, 0.03, 0.05)] {
        let [lean, rate] = if sort == Sort::Hop {
            [0.0; 2]
        } else {
            [lean, rate]
        };
        let firing = Firing {
            lean,
            rate,
            on,
            opening,
        };
        let flown = rig.flown(&firing, Settings::default()).expect("a jump");
        runs.push(Run {
            name: format!("run-{}", runs.len()),
            settings: supply(robot),
            valve: Some((on, Some(on + opening))),
            time: (0..flown.rows.len()).map(|row| row as f64 * TICK).collect(),
            values: columns
                .iter()
                .map(|k| flown.rows.iter().map(|row| row[*k]).collect())
                .collect(),
        });
        // The gyro feels the turn of a boom on its positive side.
        let gyro = robot.boom.map(|_| 1.0);
        let start = [lean, rate].into_iter().chain(gyro);
        unknowns.push(if sort == Sort::Hop {
            Vec::new()
        } else {
            start.collect()
        });
    }
    let names: Vec<&str> = columns.iter().map(|k| COLUMNS[*k]).collect();
    (experiment(sort, &names, runs), unknowns)
}

/// Outcomes of jumps.
fn outcomes(robot: &Robot) -> (Experiment, Vec<Vec<f64>>) {
    let rig = sim_check::Rig::new(robot, &[]).expect("a rig");
    let row = |[rate, lean, valve_open]: [f64; 3]| {
        let launch = Launch {
            rate,
            lean,
            firing_angle: lean,
            valve_open,
        };
        let [distance, apex] = rig.landed(&launch, Settings::default()).expect("a jump");
        [rate, lean, valve_open, distance, apex]
    };
    let rows = [
        [4.0, -0.1, 0.08],
        [5.0, 0.05, 0.06],
        [4.5, 0.15, 0.1],
        [5.5, 0.0, 0.05],
    ]
    .map(row);
    let columns = [
        "omega_rad_s",
        "alpha_f_rad",
        "valve_open_s",
        "distance_m",
        "apex_m",
    ];
    let run = Run {
        name: "jumps".into(),
        time: (0..rows.len()).map(|row| row as f64).collect(),
        values: (0..5)
            .map(|k| rows.iter().map(|row| row[k]).collect())
            .collect(),
        ..Run::default()
    };
    (
        experiment(Sort::Outcomes, &columns, vec![run]),
        vec![Vec::new(); rows.len()],
    )
}

/// A leg on the bench: the robot upright, with all mass in its body, until its foot leaves the ground.
fn bench(robot: &Robot) -> (Experiment, Vec<Vec<f64>>) {
    let mut runs = Vec::new();
    for load in [1.5, 3.0] {
        let mut upright = robot.clone();
        // One leg stands on the ground.
        upright.body.mass = load + robot.leg.body.mass;
        let rig = sim_check::Rig::new(&upright, &[]).expect("a rig");
        let (q, v) = rig.stand(0.0, 0.0).expect("a start");
        let mut sim = Sim::new(&rig.mechanism, &q, &v, Settings::default()).expect("a start");
        let (on, opening) = (0.01, 0.2);
        let (mut time, mut values) = (Vec::new(), vec![Vec::new(); 2]);
        sim.run(on, &[]).expect("a rest");
        sim.fire(0, opening).expect("a command");
        for tick in 11.. {
            sim.run(f64::from(tick) * TICK, &[]).expect("a motion");
            let extension = sim.coordinates()[rig.extension_coordinate(0)];
            if extension > 0.99 * robot.leg.stroke {
                break;
            }
            time.push(sim.time());
            values[0].push(extension);
            values[1].push(sim.pressure(0));
        }
        let mut settings = supply(robot);
        settings.insert("load_mass_kg".into(), load);
        runs.push(Run {
            name: format!("{load} kg"),
            settings,
            valve: Some((on, Some(on + opening))),
            time,
            values,
        });
    }
    (
        experiment(Sort::Bench, &["position_m", "pressure_pa"], runs),
        vec![Vec::new(); 2],
    )
}

/// When (s) a robot that is pushed is left alone: without a boom it would roll backwards.
const PUSHED: f64 = 0.5;

/// Log of a running robot by instruments without error.
struct Log {
    logger: Logger,
    legs: usize,
    on_boom: bool,
    /// When (s) the log begins.
    from: f64,
    time: Vec<f64>,
    /// Valves; wheel angle and rate, travel and height of the axle; radius and pivot angle.
    values: Vec<Vec<f64>>,
}

impl Follower for Log {
    fn row(&mut self, row: &Row<'_>) {
        let (q, v) = (row.coordinates, row.velocities);
        // A gyro on the wheel feels the turn of a boom that is tilted.
        let turn = if self.on_boom { v[0] * q[1].sin() } else { 0.0 };
        let mut exact = vec![row.lean, row.rate - turn, row.axle[0], row.axle[1]];
        exact.extend(q[..2].iter().filter(|_| self.on_boom));
        let (legs, times, columns) = (self.legs, &mut self.time, &mut self.values);
        columns.resize(legs + exact.len(), Vec::new());
        let is_kept = row.time > self.from;
        self.logger.log(row, |time, values| {
            if !is_kept {
                return;
            }
            times.push(time);
            let (valves, measured) = values.split_at(legs);
            let is_measured = measured[0].is_finite();
            let exact = exact
                .iter()
                .map(|x| if is_measured { *x } else { f64::NAN });
            for (column, value) in columns.iter_mut().zip(valves.iter().copied().chain(exact)) {
                column.push(value);
            }
        });
    }

    fn footfall(&mut self, _: &Footfall) {}
}

/// A run; how each stride starts is estimated.
fn strides(robot: &Robot) -> (Experiment, Vec<Vec<f64>>) {
    let legs = robot.body.legs as usize;
    let mut log = Log {
        logger: Logger::new(robot),
        legs,
        on_boom: robot.boom.is_some(),
        from: if robot.boom.is_some() { 0.0 } else { PUSHED },
        time: Vec::new(),
        values: Vec::new(),
    };
    let pushes = Some(Disturbance {
        when: When::Time(0.3, PUSHED),
        what: What::Torque(5.0),
    });
    let setup = Setup {
        zone: -0.3,
        stepping: Stepping::Adaptive,
        disturbances: pushes
            .filter(|_| robot.boom.is_none())
            .into_iter()
            .collect(),
        ..Setup::new(robot.clone(), Smooth::QUICK.program(), 5.0)
    };
    run(&setup, &mut log).expect("a run");
    let valves = (1..=legs).map(|leg| format!("valve_{leg}"));
    let measured = ["wheel_angle_rad", "wheel_rate_rad_s", "x_m", "y_m"];
    let of_boom = ["radius_angle_rad", "pivot_angle_rad"];
    let names = measured
        .iter()
        .chain(of_boom.iter().filter(|_| robot.boom.is_some()));
    let columns: Vec<String> = valves.chain(names.map(ToString::to_string)).collect();
    let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
    let run = Run {
        name: "run".into(),
        settings: supply(robot),
        valve: None,
        time: log.time,
        values: log.values,
    };
    (experiment(Sort::Run, &columns, vec![run]), Vec::new())
}

/// A link in the plane, whose centre is `center` (m) above its joint.
fn link(
    parent: Option<usize>,
    joint: sim_check::Joint,
    at: f64,
    mass: f64,
    center: f64,
    inertia: f64,
) -> Body {
    let (x, y, z) = (Vec3::x(), Vec3::y(), Vec3::z());
    Body {
        name: format!("link at {at} m"),
        parent,
        joint,
        placement: Placement::at(z * at),
        mass,
        center: z * center,
        // Of a disc, which is a body.
        inertia: (y * y.transpose() + (x * x.transpose() + z * z.transpose()) * 0.5) * inertia,
    }
}

/// Coordinates of a mechanism from a start, at these times (s).
fn moved(
    mechanism: &sim_check::Mechanism,
    start: &[f64],
    time: &[f64],
    mut take: impl FnMut(&Sim<'_>),
) {
    let (q, v) = start.split_at(start.len() / 2);
    let mut sim = Sim::new(mechanism, q, v, Settings::default()).expect("a start");
    for &time in time {
        sim.run(time, &[]).expect("a motion");
        take(&sim);
    }
}

const DOWN: f64 = -9.80665;

/// Steps of the walker that is laid out, on one leg and the other, under a constant torque.
fn walks() -> Recording {
    let mut layout = Layout::new(Sort::Walk, false, Some(4), &mut Draw::new(5));
    let [stands, lean, hip, torque] =
        ["outer_leg_stands", "lean_rad", "hip_angle_rad", "torque_nm"]
            .map(|name| layout.column(name));
    for (k, run) in layout.experiment.runs.iter_mut().enumerate() {
        let of = |key: &str| run.settings[key];
        let (mass, length) = (of("leg_mass_kg"), of("leg_length_m"));
        let legs = ["inner", "outer"].map(|leg| {
            let center = of(&format!("{leg}_centre_from_hip_m"));
            let about_hip = of(&format!("{leg}_inertia_about_hip_kg_m2"));
            (center, about_hip - mass * center * center)
        });
        let own = usize::from(run.values[stands][0] > 0.5);
        let ([stance, swing], push) = ([legs[own], legs[1 - own]], 0.01 * (k as f64 - 1.5));
        let mut tree = sim_check::Tree::default();
        let foot = sim_check::Joint::Revolute(Vec3::y());
        let mut standing = link(None, foot, 0.0, mass, length - stance.0, stance.1);
        standing.add_point_mass(of("hip_mass_kg"), Vec3::z() * length);
        tree.add(standing).expect("a body");
        // The hip's angle grows as the swinging leg falls behind the other.
        let back = sim_check::Joint::Revolute(-Vec3::y());
        tree.add(link(Some(0), back, length, mass, -swing.0, swing.1))
            .expect("a body");
        let mut mechanism = sim_check::Mechanism::new(tree, Vec3::z() * DOWN);
        mechanism.joints[1].friction = of("hip_coulomb_nm");
        mechanism.joints[1].damping = of("hip_viscous_nm_s");
        mechanism.forces = vec![0.0, push];
        run.values[torque].fill(push);
        let mut rows = Vec::new();
        moved(&mechanism, &layout.unknowns[k], &run.time, |sim| {
            rows.push(sim.coordinates().to_vec());
        });
        for (column, k) in [(lean, 0), (hip, 1)] {
            run.values[column] = rows.iter().map(|row| row[k]).collect();
        }
    }
    Recording {
        name: "walker".into(),
        experiment: layout.experiment,
        robot: None,
        unknowns: layout.unknowns,
    }
}

/// Of an arm that turns and of a slide on it: mass (kg), centre above the joint (m), inertia (kg m²).
const PARTS: [(f64, f64, f64); 2] = [(0.6, -0.1, 4e-3), (0.3, -0.15, 2e-3)];
/// Dry friction and damping of both joints.
const FRICTION: (f64, f64) = (0.02, 0.01);
/// Stiffness (N/m) of the spring that holds the slide, and where it rests (m).
const SPRING: (f64, f64) = (120.0, 0.1);
/// The tip (m) above the slide's joint.
const TIP: f64 = -0.2;

/// The arm as its operator describes it.
fn described() -> Mechanism {
    let part = |name: &str, parent, way, (mass, center, inertia)| Link {
        name: name.into(),
        joint: Joint {
            name: name.into(),
            parent,
            way,
            at: [0.0; 2],
            angle: 0.0,
            friction: FRICTION.0,
            damping: FRICTION.1,
        },
        mass,
        center: [0.0, center],
        inertia: Inertia::Center(inertia),
        counterweight: None,
    };
    let gauge = |(column, shows): (&str, Shows)| Gauge {
        column: column.into(),
        shows,
    };
    let (link, at, back) = (1, [0.0, TIP], true);
    let gauges = [
        ("arm_rad", Shows::Coordinate(0)),
        ("slide_m", Shows::Coordinate(1)),
        ("tilt_rad", Shows::Angle { link, back }),
        ("tip_x_m", Shows::Place { link, at, axis: 0 }),
        ("tip_y_m", Shows::Place { link, at, axis: 1 }),
    ];
    let drive = |column: &str, joint| Drive {
        column: column.into(),
        joint,
    };
    let (stiffness, from) = SPRING;
    let side = Side::Both;
    Mechanism {
        name: "arm".into(),
        gravity: -DOWN,
        links: vec![
            part("arm", None, Way::Turns { back: false }, PARTS[0]),
            part("slide", Some(0), Way::Slides([0.0, -1.0]), PARTS[1]),
        ],
        springs: vec![Spring {
            joint: 1,
            law: Law::Linear {
                stiffness,
                from,
                side,
            },
        }],
        drives: vec![drive("arm_nm", 0), drive("slide_n", 1)],
        gauges: gauges.map(gauge).into(),
    }
}

/// The arm as bodies.
fn arm() -> sim_check::Mechanism {
    let mut tree = sim_check::Tree::default();
    let joints = [
        sim_check::Joint::Revolute(Vec3::y()),
        sim_check::Joint::Prismatic(-Vec3::z()),
    ];
    for (k, (joint, (mass, center, inertia))) in joints.into_iter().zip(PARTS).enumerate() {
        let body = link(k.checked_sub(1), joint, 0.0, mass, center, inertia);
        tree.add(body).expect("a body");
    }
    let mut arm = sim_check::Mechanism::new(tree, Vec3::z() * DOWN);
    for joint in &mut arm.joints {
        (joint.friction, joint.damping) = FRICTION;
    }
    arm.joints[1].spring = SPRING;
    arm
}

/// Swings of the arm, one of them under a constant torque and force.
fn machine() -> Recording {
    let mut arm = arm();
    let columns = [
        "arm_rad", "slide_m", "tilt_rad", "tip_x_m", "tip_y_m", "arm_nm", "slide_n",
    ];
    let unknowns = vec![vec![0.7, 0.12, 0.5, -0.2], vec![-0.4, 0.15, 2.0, 0.3]];
    let run = |(start, push): (&Vec<f64>, [f64; 2])| {
        let time: Vec<f64> = (0..301).map(|row| 5e-3 * f64::from(row)).collect();
        let mut values = vec![Vec::new(); columns.len()];
        arm.forces = push.to_vec();
        moved(&arm, start, &time, |sim| {
            let q = sim.coordinates();
            let tip = sim.pose().frames[1].point(&(Vec3::z() * TIP));
            let row = [q[0], q[1], -q[0], tip.x, tip.z, push[0], push[1]];
            for (column, value) in values.iter_mut().zip(row) {
                column.push(value);
            }
        });
        Run {
            name: "swing".into(),
            time,
            values,
            ..Run::default()
        }
    };
    let runs = unknowns
        .iter()
        .zip([[0.0, 0.0], [0.3, 1.5]])
        .map(run)
        .collect();
    Recording {
        name: "arm".into(),
        experiment: Experiment {
            mechanism: Some(described()),
            ..experiment(Sort::Machine, &columns, runs)
        },
        robot: None,
        unknowns,
    }
}

/// Every recording of `sort`.
fn recordings(sort: Sort) -> Vec<Recording> {
    match sort {
        Sort::Walk => return vec![walks()],
        Sort::Machine => return vec![machine()],
        Sort::TankLeg => return Vec::new(),
        _ => {}
    }
    let is_out = |name: &str| {
        let mut out = LEFT_OUT.iter();
        out.any(|(of, robot, _)| *of == sort && name.starts_with(robot))
    };
    let mut all = Vec::new();
    for (name, keys) in ROBOTS {
        for (boom, on_boom) in [("on a boom", true), ("free", false)] {
            let name = format!("{name}, {boom}");
            // A bench has no boom.
            if is_out(&name) || (sort == Sort::Bench && on_boom) {
                continue;
            }
            let robot = robot(sort, on_boom, keys);
            let (experiment, unknowns) = match sort {
                Sort::Bench => bench(&robot),
                Sort::Outcomes => outcomes(&robot),
                Sort::Run => strides(&robot),
                _ => firings(sort, &robot),
            };
            all.push(Recording {
                name,
                experiment,
                robot: Some(robot),
                unknowns,
            });
        }
    }
    all
}

/// Of each column the root mean square difference of prediction and recording: as a part of the
/// column's range, and in the noise of its instrument.
fn differences(recording: &Recording) -> Result<BTreeMap<String, [f64; 2]>, Problem> {
    let kind = kinds::build(&recording.experiment, recording.robot.as_ref())?;
    let off = Terms::off(kind.causes());
    let mut all = vec![Vec::new(); kind.channels().len()];
    for (run, log) in kind.logs().iter().enumerate() {
        let neutral = || kind.unknowns(run).iter().map(|u| u.neutral).collect();
        let unknowns = recording.unknowns.get(run).cloned().unwrap_or_else(neutral);
        let predicted = kind.predict(run, &off, &unknowns).expect("a motion");
        for (reading, predicted) in log.readings.iter().zip(predicted) {
            all[reading.channel].push((reading.value, predicted));
        }
    }
    let measure = |(channel, rows): (&Channel, Vec<(f64, f64)>)| {
        let squares: f64 = rows.iter().map(|(a, b)| (a - b).powi(2)).sum();
        let rms = (squares / rows.len() as f64).sqrt();
        let low = rows.iter().map(|row| row.0).fold(f64::INFINITY, f64::min);
        let high = rows
            .iter()
            .map(|row| row.0)
            .fold(f64::NEG_INFINITY, f64::max);
        (
            channel.name.clone(),
            [rms / (high - low), rms / channel.noise],
        )
    };
    Ok(kind.channels().iter().zip(all).map(measure).collect())
}

/// Whether `column` is `name`, or one of the family that `name` with a star stands for.
fn is_of(column: &str, name: &str) -> bool {
    match name.split_once('*') {
        None => column == name,
        Some((start, end)) => column.starts_with(start) && column.ends_with(end),
    }
}

#[test]
#[ignore = "nightly: 9 s"]
fn every_column_is_that_of_the_multi_body_simulation() {
    let mut wrong = Vec::new();
    for sort in KINDS {
        let apart = APART.iter().find(|(of, ..)| *of == sort);
        let mut compared: Vec<String> = Vec::new();
        for recording in recordings(sort) {
            let found = differences(&recording).unwrap_or_else(|problem| {
                wrong.push(format!("{sort:?}, {}: {problem}", recording.name));
                BTreeMap::new()
            });
            for (column, [of_range, of_noise]) in found {
                let is_near = apart.is_some_and(|(_, most, _)| of_noise < *most);
                if !(of_range < TOLERANCE || is_near) {
                    let name = &recording.name;
                    wrong.push(format!(
                        "{sort:?}, {name}, {column}: {of_range:.1e} of its range, {of_noise:.2} σ"
                    ));
                }
                compared.push(column);
            }
        }
        for column in sort.spec().channels {
            let is_compared = compared.iter().any(|own| is_of(own, column.name));
            let mut not = NOT_COMPARED.iter().filter(|(of, ..)| *of == sort);
            let is_excused = not.any(|(_, names, _)| names.contains(&column.name));
            if is_compared == is_excused {
                wrong.push(format!("{sort:?}, {}: compared {is_compared}", column.name));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
