//! Jumps at random approach rates in the multi-body simulation, fired by the controller behind a
//! quantised encoder at 1 kHz: how far from where they should land, beside the exact planner, a
//! constant firing angle, and perfect sensors.
//!
//!     cd studies && cargo run --release --bin in_the_loop -- [JUMPS] [PROGRAM]
//!
//! PROGRAM is another controller, such as `controller/examples/robot.c`: for each jump it reads a
//! line `start RATE LEAN`, then a line with the lean for each millisecond, and answers each of
//! these with `wait` or `fire AFTER VALVE_OPEN`. Its jumps have to be those of the Rust controller,
//! to the bit.

use std::io::{BufRead, BufReader, Write};
use std::process::{Command as Program, Stdio};

use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;
use saltus_controller::{Controller, Observer, Sensed, Task, Timing};
use saltus_lagrangian::Launch;
use saltus_planner::Planner;
use saltus_robot::Robot;
use saltus_tests::controlled::{Command, Encoder, Start, jump, spread};

#[rustfmt::skip]
#[path = "../../../controller/examples/rats_planar/tables.rs"]
mod tables;

use tables::RATS_PLANAR;

/// Where to land (m), with the wheel's centre at the table's landing height.
const DISTANCE: f64 = 0.5;
/// Lean (rad) at which the robot touches down, and the start lean of the tables.
const TOUCH_DOWN: f32 = RATS_PLANAR.rates.reference_lean;
/// Memory of the observer, as `robot.c` has it.
const MEMORY: f32 = 0.9;

/// How an angle is found.
#[derive(Clone, Copy)]
enum By<'a> {
    Controller,
    Planner(&'a Planner),
    Constant(f32),
}

#[allow(clippy::cast_possible_truncation)]
fn single(x: f64) -> f32 {
    x as f32
}

/// The robot's loop: reads, observes, decides.
struct Loop<'a> {
    controller: Controller<'static, f32>,
    observer: Observer<f32>,
    by: By<'a>,
}

impl<'a> Loop<'a> {
    fn new(rate: f64, lean: f64, memory: f32, by: By<'a>) -> Loop<'a> {
        let controller = RATS_PLANAR;
        let sensed = Sensed {
            lean: single(lean),
            rate: single(rate),
        };
        let period = controller.limits.period;
        Loop {
            controller,
            observer: Observer {
                sensed,
                period,
                pendulum: controller.robot.pendulum,
                memory,
            },
            by,
        }
    }

    fn tick(&mut self, lean: f64) -> Command {
        self.observer.update(single(lean));
        let sensed = self.observer.sensed;
        let robot = self.controller.robot;
        let task = Task {
            distance: single(DISTANCE),
            landing_height: robot.landing_height,
            obstacle: None,
            guess: None,
        };
        let timing = match self.by {
            By::Controller => self.controller.decide(&sensed, &task).map(|d| d.timing),
            By::Constant(angle) => self.controller.timing(&sensed, angle),
            By::Planner(planner) => self
                .controller
                .rate_at(&sensed, TOUCH_DOWN)
                .and_then(|rate| {
                    let start =
                        self.controller
                            .firing_angle(rate, task.distance, task.landing_height)?;
                    self.controller
                        .timing(&sensed, exact(planner, rate.into(), start.into()))
                }),
        };
        match timing {
            Ok(Timing::Fire(after)) => Command::Fire {
                after: after.into(),
                valve_open: robot.valve_open.into(),
            },
            Ok(Timing::Late(_)) => Command::Fire {
                after: 0.0,
                valve_open: robot.valve_open.into(),
            },
            _ => Command::Wait,
        }
    }
}

/// The planner's own firing angle (rad), by Newton on whole jumps.
fn exact(planner: &Planner, rate: f64, start: f64) -> f32 {
    let (lean, valve_open) = (
        f64::from(TOUCH_DOWN),
        f64::from(RATS_PLANAR.robot.valve_open),
    );
    let mut angle = start;
    for _ in 0..3 {
        let launch = Launch {
            rate,
            lean,
            firing_angle: angle,
            valve_open,
        };
        let jump = planner.sensitive_jump(&launch).ok();
        let Some(landing) =
            jump.and_then(|jump| jump.distance(RATS_PLANAR.robot.landing_height.into()))
        else {
            break;
        };
        angle -= (landing.value - DISTANCE) / landing.slope[1];
    }
    single(angle)
}

/// A controller in a program of its own.
struct Outside {
    input: std::process::ChildStdin,
    output: BufReader<std::process::ChildStdout>,
    child: std::process::Child,
}

impl Outside {
    fn new(path: &str) -> Outside {
        let mut child = Program::new(path)
            .arg(DISTANCE.to_string())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap_or_else(|error| panic!("{path}: {error}"));
        let (input, output) = (
            child.stdin.take().expect("a pipe"),
            child.stdout.take().expect("a pipe"),
        );
        Outside {
            input,
            output: BufReader::new(output),
            child,
        }
    }

    fn start(&mut self, rate: f64, lean: f64) {
        writeln!(self.input, "start {:?} {:?}", single(rate), single(lean))
            .expect("a controller that reads");
    }

    fn tick(&mut self, lean: f64) -> Command {
        writeln!(self.input, "{:?}", single(lean))
            .and_then(|()| self.input.flush())
            .expect("a controller that reads");
        let mut line = String::new();
        self.output
            .read_line(&mut line)
            .expect("a controller that answers");
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["wait"] => Command::Wait,
            ["fire", after, valve_open] => {
                let number = |text: &str| f64::from(text.parse::<f32>().expect("a number"));
                Command::Fire {
                    after: number(after),
                    valve_open: number(valve_open),
                }
            }
            _ => panic!("the controller says {line:?}"),
        }
    }
}

#[expect(clippy::too_many_lines, reason = "one experiment")]
fn main() {
    let mut arguments = std::env::args().skip(1);
    let jumps: usize = arguments
        .next()
        .map_or(40, |text| text.parse().expect("a number of jumps"));
    let mut outside = arguments.next().map(|path| Outside::new(&path));
    let robot = Robot::rats_planar();
    let planner = Planner::new(robot.clone());
    let lean = f64::from(TOUCH_DOWN);
    let height = f64::from(RATS_PLANAR.robot.landing_height);
    let constant = RATS_PLANAR
        .firing_angle(4.5, single(DISTANCE), single(height))
        .expect("in reach");

    let mut random = Pcg64::seed_from_u64(7);
    let rates = Uniform::new(3.0, 6.0).expect("a range");
    let kinds = [
        ("controller", By::Controller, true),
        ("exact planner", By::Planner(&planner), true),
        ("constant angle", By::Constant(constant), true),
        ("controller, perfect sensors", By::Controller, false),
    ];
    let mut errors = vec![Vec::new(); kinds.len() + 1];
    let mut lost = vec![0; kinds.len() + 1];
    for _ in 0..jumps {
        let rate = rates.sample(&mut random);
        let encoder = Encoder::drawn(&mut random);
        for (k, (_, by, quantised)) in kinds.iter().enumerate() {
            let encoder = if *quantised {
                encoder
            } else {
                Encoder { phase: None }
            };
            let memory = if *quantised { MEMORY } else { 0.0 };
            let mut control = Loop::new(
                encoder.approach_rate(lean, rate),
                encoder.read(lean),
                memory,
                *by,
            );
            let start = Start { lean, rate };
            let landing = jump(&robot, start, height, |lean| {
                control.tick(encoder.read(lean))
            })
            .expect("a jump");
            match landing {
                Some(landing) => errors[k].push(landing - DISTANCE),
                None => lost[k] += 1,
            }
        }
        if let Some(outside) = &mut outside {
            outside.start(encoder.approach_rate(lean, rate), encoder.read(lean));
            let start = Start { lean, rate };
            let landing = jump(&robot, start, height, |lean| {
                outside.tick(encoder.read(lean))
            })
            .expect("a jump");
            match landing {
                Some(landing) => errors[kinds.len()].push(landing - DISTANCE),
                None => lost[kinds.len()] += 1,
            }
        }
    }
    println!("{jumps} jumps to {DISTANCE} m at 3 to 6 rad/s; landing errors (mm):");
    println!(
        "{:30} {:>8} {:>8} {:>8} {:>6}",
        "", "mean", "sd", "worst", "lost"
    );
    let names = kinds.iter().map(|k| k.0).chain(["the program"]);
    for (name, (errors, lost)) in names
        .zip(errors.iter().zip(&lost))
        .take(kinds.len() + usize::from(outside.is_some()))
    {
        let [mean, sd, worst] = spread(errors).map(|x| 1e3 * x);
        println!("{name:30} {mean:8.2} {sd:8.2} {worst:8.2} {lost:6}");
    }
    let [ours, constant] = [&errors[0], &errors[2]].map(|e| spread(e)[1]);
    println!("{:.1} times better than a constant angle", constant / ours);
    assert!(lost[0] == 0 && constant > 3.0 * ours);
    if let Some(Outside {
        input, mut child, ..
    }) = outside
    {
        drop(input);
        let ended = child.wait().expect("a program that ends");
        assert!(ended.success(), "the program ended with {ended}");
        assert!(
            errors[kinds.len()] == errors[0],
            "the program's jumps are not those of the Rust controller"
        );
        println!("the program's jumps are those of the Rust controller, to the bit");
    }
}
