//! The controller's tables against the planner, its take-offs against a search with whole jumps,
//! and its loop in the simulation.

use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;
use saltus::ballistic::{Disc, Obstacle};
use saltus::controller::{
    Approach, Guess, NoTakeOff, Observer, Reason, Rule, Sensed, Task, Timing,
};
use saltus::export::{self, ExportError, Request, Tables};
use saltus::on_plant::OnPlant;
use saltus::planner::{FIRING_ANGLES, Measure, Roots, TableRequest};
use saltus::{Launch, Planner, Robot};
use saltus_tests::controlled::{Command, Encoder, Start, jump, spread};

#[rustfmt::skip]
#[path = "../../../controller/examples/rats_planar/tables.rs"]
mod tables;

fn uniform(random: &mut Pcg64, low: f64, high: f64) -> f64 {
    Uniform::new(low, high).expect("a range").sample(random)
}

#[allow(clippy::cast_possible_truncation)]
fn single(x: f64) -> f32 {
    x as f32
}

/// For obstacles and take-offs: the wheel lands on the ground.
fn on_the_ground() -> Request {
    Request {
        rates: (2.75, 6.25, 14),
        distances: (0.2, 0.8, 13),
        start_lean: Some(-0.5),
        ..Request::default()
    }
}

#[test]
fn what_the_table_fires_lands_within_two_millimetres_everywhere() {
    let planner = Planner::new(Robot::rats_planar());
    let request = Request {
        distances: (0.3, 1.0, 15),
        landing_height: Some(0.0),
        start_lean: Some(-0.5),
        ..Request::default()
    };
    let tables = Tables::<f32>::new(&planner, &request).expect("tables");
    let [table, map] = tables.bytes();
    assert!(table + map <= 16 * 1024, "{table} + {map} bytes");
    let [(open, all), _] = tables.cells();
    // 0.3 m at 6 rad/s needs an angle before the start lean.
    assert!(open >= all - 4, "{open} of {all}");
    let mut random = Pcg64::seed_from_u64(1);
    let (mut worst, mut answered) = (0.0_f64, 0);
    for _ in 0..20_000 {
        let (rate, distance) = (
            single(uniform(&mut random, 3.0, 6.0)),
            single(uniform(&mut random, 0.3, 1.0)),
        );
        let Ok(angle) = tables.controller().firing_angle(rate, distance, 0.0) else {
            continue;
        };
        answered += 1;
        let launch = Launch {
            rate: rate.into(),
            lean: -0.5,
            firing_angle: angle.into(),
            valve_open: 0.1,
        };
        let landing = planner
            .jump(&launch)
            .expect("a stance")
            .distance(0.0)
            .expect("a landing");
        worst = worst.max((landing - f64::from(distance)).abs());
    }
    // The issue asks for 2 mm; this table has 0.03, and a tenth is left for another processor's
    // round-off and luck.
    assert!(worst < 1e-4 && answered > 19_000, "{worst} m, {answered}");
    assert!(
        worst <= 2.0 * tables.misses().table,
        "{worst} m, {:?}",
        tables.misses()
    );
}

#[test]
fn one_distance_is_a_curve_within_the_tolerance_whatever_the_steps() {
    let planner = Planner::new(Robot::rats_planar());
    let curve = |newton_steps| {
        let request = Request {
            distances: (0.6, 0.6, 1),
            newton_steps,
            ..Request::default()
        };
        Tables::<f64>::new(&planner, &request)
            .expect("a curve")
            .misses()
            .table
    };
    // A line would miss by 9 mm. One Newton step and two leave the map's own error, at most.
    let [plain, once, twice] = [0, 1, 2].map(curve);
    assert!(plain < 1e-4, "{plain}");
    assert!(once < 2e-4 && twice < 2e-4, "{once} {twice}");
}

#[test]
fn the_controller_answers_as_the_table_does() {
    let robots = ["rats-planar", "rats-boom", "spring-hopper"];
    let mut answered = 0;
    for robot in robots {
        let planner = Planner::new(saltus::resolve(robot, &[]).expect("a robot"));
        for (landing_height, start_lean) in [(None, None), (Some(0.0), None), (None, Some(-0.4))] {
            let request = Request {
                distances: (0.3, 0.6, 4),
                landing_height,
                start_lean,
                ..Request::default()
            };
            let tables = Tables::<f32>::new(&planner, &request).expect("tables");
            let height = landing_height.unwrap_or(planner.robot().body.radius);
            let table = planner
                .table(&TableRequest {
                    rates: vec![3.1, 4.0, 5.0, 5.9],
                    measure: Measure::Distance {
                        landing_height: height,
                    },
                    targets: vec![0.35, 0.5, 0.6],
                    valve_open: 0.1,
                    start_lean,
                    firing_angles: FIRING_ANGLES,
                    roots: Roots::Least,
                    sensitivities: false,
                    threads: 1,
                })
                .expect("a table");
            for cell in &table.cells {
                let controller = tables.controller();
                let angle =
                    controller.firing_angle(single(cell.rate), single(cell.target), single(height));
                let (Ok(angle), Some(entry)) = (angle, cell.entries.first()) else {
                    continue;
                };
                answered += 1;
                let launch = Launch {
                    firing_angle: angle.into(),
                    ..entry.jump.launch
                };
                let lean = start_lean.unwrap_or(launch.firing_angle);
                let jump = planner.jump(&Launch { lean, ..launch }).expect("a stance");
                let landing = jump.distance(height).expect("a landing");
                assert!(
                    (landing - cell.target).abs() < request.tolerance,
                    "{robot} {cell:?}: {angle}"
                );
            }
        }
    }
    assert!(answered > 80, "{answered}");
}

#[test]
fn tables_that_cannot_be_made_say_why() {
    let planner = Planner::new(Robot::rats_planar());
    let check = |request: Request, text: &str| {
        let error = Tables::<f32>::new(&planner, &request)
            .expect_err(text)
            .to_string();
        assert!(error.contains(text), "{error}");
    };
    check(
        Request {
            rates: (3.0, 3.0, 13),
            ..Request::default()
        },
        "greatest approach rate (rad/s) = 3: must be above",
    );
    check(
        Request {
            distances: (30.0, 40.0, 5),
            ..Request::default()
        },
        "no cell of the firing table is open",
    );
    check(
        Request {
            tolerance: 1e-12,
            ..Request::default()
        },
        "is open",
    );
    check(
        Request {
            newton_steps: 4,
            ..Request::default()
        },
        "Newton steps = 4: must be from 0 to 3",
    );
    let windy =
        saltus::resolve("rats-planar", &["environment.drag_per_m=0.1".into()]).expect("a robot");
    let error = Tables::<f32>::new(&Planner::new(windy), &Request::default()).expect_err("drag");
    assert!(matches!(error, ExportError::Drag { .. }), "{error}");
}

/// What a jump keeps clear of a box from `front`, by the planner's own jump: over the box, and
/// behind it.
fn exact_margin(
    planner: &Planner,
    rate: f64,
    angle: f64,
    [front, length, height]: [f64; 3],
) -> f64 {
    let radius = planner.robot().body.radius;
    let launch = Launch {
        rate,
        lean: -0.5,
        firing_angle: angle,
        valve_open: 0.1,
    };
    let Some(flight) = planner.jump(&launch).ok().and_then(|jump| jump.flight) else {
        return f64::NEG_INFINITY;
    };
    let Ok(landing) = flight.time_to_height(radius) else {
        return f64::NEG_INFINITY;
    };
    let beyond = flight.range_to_height(radius).unwrap_or(f64::NEG_INFINITY) - (front + length);
    let Ok(solid) = Obstacle::block([front, 0.0], [front + length, height]) else {
        return f64::NEG_INFINITY;
    };
    let over = flight
        .clearance(&Disc::wheel(radius), &solid, 0.0, landing)
        .unwrap_or(f64::NEG_INFINITY);
    over.min(beyond)
}

#[test]
fn take_offs_are_those_of_a_search_with_whole_jumps() {
    let planner = Planner::new(Robot::rats_planar());
    let tables = Tables::<f32>::new(&planner, &on_the_ground()).expect("tables");
    let controller = tables.controller();
    let (radius, stride) = (
        f64::from(controller.robot.radius),
        f64::from(controller.robot.stride),
    );
    let mut random = Pcg64::seed_from_u64(2);
    let (mut yes, mut no) = (0, 0);
    for _ in 0..150 {
        let rate = uniform(&mut random, 3.0, 6.0);
        let [distance, length, height] =
            [(0.3, 1.2), (0.02, 0.2), (0.02, 0.25)].map(|(a, b)| uniform(&mut random, a, b));
        let approach = Approach {
            distance,
            height,
            length,
            speed: rate * radius,
            clearance: 0.01,
        }
        .map(single);
        let margin = |k: u32, angle: f64| {
            exact_margin(
                &planner,
                rate,
                angle,
                [distance - f64::from(k) * stride, length, height],
            )
        };
        match controller.take_off(&approach) {
            Ok(t) => {
                yes += 1;
                let exact = margin(t.touch_down, t.firing_angle.into());
                // The map's 2 mm, and nothing for hope: what it promises is kept.
                assert!(
                    exact > f64::from(t.clearance) - 2.5e-3,
                    "{approach:?}: {t:?} {exact}"
                );
            }
            Err(NoTakeOff {
                reason: Reason::Infeasible,
                ..
            }) => {
                no += 1;
                let fronts = (0..4).filter(|k| distance - f64::from(*k) * stride >= radius + 0.01);
                let best = fronts
                    .flat_map(|k| (0..=120).map(move |i| (k, -0.5 + 0.0075 * f64::from(i))))
                    .filter(|(_, angle)| *angle <= f64::from(controller.map.angles.last))
                    .map(|(k, angle)| margin(k, angle))
                    .fold(f64::NEG_INFINITY, f64::max);
                // Within the angles that the map holds, but for cells at its ends that are closed.
                assert!(best < 0.01 + 0.02, "{approach:?}: {best}");
            }
            Err(no) => panic!("{approach:?}: {no:?}"),
        }
    }
    assert!(yes > 30 && no > 20, "{yes} {no}");
}

#[test]
fn decisions_over_an_obstacle_settle_and_keep_clear() {
    let planner = Planner::new(Robot::rats_planar());
    let tables = Tables::<f32>::new(&planner, &on_the_ground()).expect("tables");
    let controller = tables.controller();
    let mut random = Pcg64::seed_from_u64(3);
    let (mut settled, mut refused, mut ticks) = (0, 0, 0);
    for _ in 0..300 {
        let rate = uniform(&mut random, 3.0, 6.0);
        let distance = uniform(&mut random, 0.45, 0.7);
        let [front, length, height] =
            [(0.27, 0.35), (0.02, 0.08), (0.02, 0.2)].map(|(a, b)| uniform(&mut random, a, b));
        let obstacle = saltus::controller::Obstacle {
            front,
            back: front + length,
            height,
            clearance: 0.01,
        }
        .map(single);
        let sensed = Sensed {
            lean: -0.5,
            rate: single(rate),
        };
        let mut task = Task {
            distance: single(distance),
            landing_height: 0.24,
            obstacle: Some(obstacle),
            guess: None,
        };
        // Ten milliseconds.
        for tick in 1..=10 {
            match controller.decide(&sensed, &task) {
                Ok(d) if d.settled => {
                    let exact = exact_margin(
                        &planner,
                        rate,
                        d.firing_angle.into(),
                        [front, length, height],
                    );
                    // 1 cm asked for; 2 mm count as none, and the map has as much of its own.
                    assert!(exact > 0.01 - 4.5e-3, "{task:?}: {exact}");
                    settled += 1;
                    ticks += tick;
                    break;
                }
                Ok(d) => {
                    task.guess = Some(Guess {
                        firing_angle: d.firing_angle,
                        valve_open: d.valve_open,
                    });
                }
                Err(_) => {
                    refused += 1;
                    break;
                }
            }
        }
    }
    assert!(
        settled > 150 && f64::from(ticks) < 4.0 * f64::from(settled),
        "{settled} {refused} {ticks}"
    );
}

/// Numbers of one kind as numbers of another.
trait Map<R> {
    type Out;
    fn map(self, f: impl Fn(f64) -> R) -> Self::Out;
}

impl Map<f32> for Approach<f64> {
    type Out = Approach<f32>;
    fn map(self, f: impl Fn(f64) -> f32) -> Approach<f32> {
        let Approach {
            distance,
            height,
            length,
            speed,
            clearance,
        } = self;
        Approach {
            distance: f(distance),
            height: f(height),
            length: f(length),
            speed: f(speed),
            clearance: f(clearance),
        }
    }
}

impl Map<f32> for saltus::controller::Obstacle<f64> {
    type Out = saltus::controller::Obstacle<f32>;
    fn map(self, f: impl Fn(f64) -> f32) -> saltus::controller::Obstacle<f32> {
        let saltus::controller::Obstacle {
            front,
            back,
            height,
            clearance,
        } = self;
        saltus::controller::Obstacle {
            front: f(front),
            back: f(back),
            height: f(height),
            clearance: f(clearance),
        }
    }
}

/// Tables for touch-downs at -0.5 rad, whose rates these are.
fn for_the_loop() -> Request {
    Request {
        rates: (2.75, 6.25, 14),
        distances: (0.3, 1.0, 15),
        landing_height: Some(0.0),
        start_lean: Some(-0.5),
        ..Request::default()
    }
}

/// How a jump in the loop is fired.
#[derive(Clone, Copy, PartialEq)]
enum By {
    /// By the controller's decisions.
    Controller,
    /// The same, behind an encoder without steps.
    PerfectSensors,
    /// Always at its angle for 4.5 rad/s.
    Constant,
}

/// Landing errors (m) of so many jumps of `robot` to 0.6 m at random rates, fired at 1 kHz behind
/// an encoder.
fn in_the_loop(tables: &Tables<f32>, robot: &Robot, jumps: usize, by: By) -> Vec<f64> {
    let controller = tables.controller();
    let distance = 0.6;
    let constant = controller
        .firing_angle(4.5, single(distance), 0.0)
        .expect("in reach");
    let mut random = Pcg64::seed_from_u64(4);
    let mut fly = || {
        let rate = uniform(&mut random, 3.0, 6.0);
        let mut encoder = Encoder::drawn(&mut random);
        if by == By::PerfectSensors {
            encoder.phase = None;
        }
        let sensed = Sensed {
            lean: single(encoder.read(-0.5)),
            rate: single(encoder.approach_rate(-0.5, rate)),
        };
        let mut observer = Observer {
            sensed,
            period: 1e-3,
            pendulum: controller.robot.pendulum,
            memory: 0.9,
        };
        let control = |lean: f64| {
            observer.update(single(encoder.read(lean)));
            let task = Task {
                distance: single(distance),
                landing_height: 0.0,
                obstacle: None,
                guess: None,
            };
            let timing = if by == By::Constant {
                controller.timing(&observer.sensed, constant)
            } else {
                controller.decide(&observer.sensed, &task).map(|d| d.timing)
            };
            match timing {
                Ok(Timing::Fire(after)) => Command::Fire {
                    after: after.into(),
                    valve_open: 0.1,
                },
                Ok(Timing::Late(_)) => Command::Fire {
                    after: 0.0,
                    valve_open: 0.1,
                },
                _ => Command::Wait,
            }
        };
        let start = Start { lean: -0.5, rate };
        let landing = jump(robot, start, 0.0, control).expect("a motion");
        landing.expect("a jump") - distance
    };
    (0..jumps).map(|_| fly()).collect()
}

#[test]
fn in_the_loop_the_controller_is_three_times_better_than_a_constant_angle() {
    let robot = Robot::rats_planar();
    let planner = Planner::new(robot.clone());
    let tables = Tables::<f32>::new(&planner, &for_the_loop()).expect("tables");
    let [ours, constant] =
        [By::Controller, By::Constant].map(|by| spread(&in_the_loop(&tables, &robot, 24, by))[1]);
    assert!(3.0 * ours < constant, "{ours} m, {constant} m");
}

/// On its boom the robot lands 2 cm short of what the planar model's tables say; those made for it
/// land on it. What the encoder's steps add to the mean, they add on the planar robot as well.
#[test]
#[ignore = "nightly: 13 s"]
fn in_the_loop_tables_for_the_boom_land_on_it() {
    let robot = Robot::rats_planar();
    let boom = Robot::builtin("rats-boom").expect("a robot");
    let request = for_the_loop();
    let plant = OnPlant::new(&robot, &boom).expect("a plant");
    let (planner, correction) =
        export::planner(robot.clone(), &plant, &request).expect("a planner");
    assert!(correction.jumps <= 100, "{correction:?}");
    let mut tables = Tables::<f32>::new(&planner, &request).expect("tables");
    tables.confirm(&plant, &request).expect("jumps");
    let confirmed = tables.confirmed().expect("jumps");
    assert!(
        confirmed.jumps > 500 && confirmed.miss <= 2e-3,
        "{confirmed:?}"
    );
    let [mean, deviation, _] = spread(&in_the_loop(&tables, &boom, 200, By::Controller));
    println!("rats-boom: {mean:.5} ± {deviation:.5} m");
    assert!(
        mean.abs() < 1.5e-3 && deviation < 8e-3,
        "{mean} ± {deviation} m"
    );
    let [mean, deviation, _] = spread(&in_the_loop(&tables, &boom, 40, By::PerfectSensors));
    println!("with perfect sensors: {mean:.5} ± {deviation:.5} m");
    assert!(
        mean.abs() < 1e-3 && deviation < 1e-3,
        "{mean} ± {deviation} m"
    );
    let flat = Tables::<f32>::new(&Planner::new(robot.clone()), &request).expect("tables");
    let [mean, deviation, _] = spread(&in_the_loop(&flat, &robot, 200, By::Controller));
    println!("the planar robot by its own tables: {mean:.5} ± {deviation:.5} m");
    let [mean, ..] = spread(&in_the_loop(&flat, &boom, 40, By::Controller));
    println!("by the planar tables: {mean:.5} m");
    assert!(mean < -0.02, "{mean} m");
}

#[test]
fn the_committed_example_is_what_is_exported_today() {
    let request = Request {
        rates: (2.75, 6.25, 14),
        distances: (0.2, 0.8, 13),
        start_lean: Some(-0.5),
        newton_steps: 1,
        valve_open: 0.04,
        valve_range: Some((0.03, 0.04)),
        ..Request::default()
    };
    let today = Tables::<f32>::new(&Planner::new(Robot::rats_planar()), &request).expect("tables");
    let (today, there) = (today.controller(), tables::RATS_PLANAR);
    // Rounding aside, which other processors do otherwise.
    let close = |a: f32, b: f32| (a - b).abs() <= 1e-5 * (1.0 + a.abs());
    let (Rule::Table(a), Rule::Table(b)) = (today.rule, there.rule) else {
        panic!("tables")
    };
    assert!(
        a.nodes
            .iter()
            .flatten()
            .zip(b.nodes.iter().flatten())
            .all(|(a, b)| close(*a, *b))
    );
    assert!(
        today
            .map
            .nodes
            .iter()
            .flatten()
            .zip(there.map.nodes.iter().flatten())
            .all(|(a, b)| close(*a, *b))
    );
    assert_eq!(
        (
            a.open,
            today.map.open,
            today.limits,
            today.rates,
            today.robot
        ),
        (
            b.open,
            there.map.open,
            there.limits,
            there.rates,
            there.robot
        )
    );
}
