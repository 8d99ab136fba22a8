//! How many strides a learner needs: the six numbers of the smooth law are learnt in starts from rest, by Bayesian
//! optimisation and by CMA-ES, and what was learnt is scored on other robots beside the thesis' two lines.
//!
//! ```text
//! cd studies && cargo run --release --bin few_strides -- 30 60
//! ```
//!
//! Seeds, and starts of each; 2 and 6 where nothing is given. Every learner begins in the middle of the ranges.

use saltus_gait::{Draw, Footfall, GaitError, Lines, Program, Row, Run, Setup, drawn_robot, run};
use saltus_numeric::parallel::{available, map_on};
use saltus_robot::Robot;
use saltus_studies::few::{Bayes, Evolution, Learner};
use saltus_studies::laws::within_bounds;

/// Travel (m) that is to be quick, and the longest time for it (s).
const GOAL: f64 = 1.6;
const LONGEST: f64 = 3.0;
/// Seeds of robots on which a law is scored, and how many.
const HELD_OUT: u64 = 500;
const ROBOTS: usize = 40;
/// Where learners begin, as a part of each parameter's range: its middle.
const START: [f64; 6] = [0.5; 6];

/// Ends a run at its goal, and counts its strides.
#[derive(Default)]
struct ToGoal {
    strides: usize,
    arrived: bool,
}

impl Run for ToGoal {
    fn row(&mut self, row: &Row<'_>) {
        self.arrived |= row.axle[0] >= GOAL;
    }
    fn footfall(&mut self, _: &Footfall) {
        self.strides += 1;
    }
    fn goes_on(&mut self) -> bool {
        !self.arrived
    }
}

/// The time to the goal (s), more than the longest where it is not reached, and the strides.
fn start(robot: Robot, program: Program, seed: u64) -> Result<(f64, usize), GaitError> {
    let mut setup = Setup::new(robot, program, LONGEST);
    setup.zone = -0.3;
    setup.seed = seed;
    let mut followed = ToGoal::default();
    let summary = run(&setup, &mut followed)?;
    let missed = 2.0 * LONGEST - summary.travel.clamp(0.0, GOAL);
    Ok((summary.time_to_1_6_m.unwrap_or(missed), followed.strides))
}

fn law(x: &[f64]) -> Program {
    within_bounds(x).program()
}

/// What one seed learnt: after each start the time of the best law, and the strides so far.
struct Curve {
    times: Vec<f64>,
    strides: Vec<usize>,
    best: Vec<f64>,
}

fn learn(
    robot: &Robot,
    mut learner: Box<dyn Learner>,
    (starts, seed): (usize, u64),
) -> Result<Curve, GaitError> {
    let mut curve = Curve {
        times: Vec::new(),
        strides: Vec::new(),
        best: Vec::new(),
    };
    let mut strides = 0;
    for k in 0..starts as u64 {
        let x = learner.ask();
        let (time, taken) = start(robot.clone(), law(&x), seed.wrapping_mul(1000) + k)?;
        learner.tell(&x, -time);
        strides += taken;
        let (now, _) = start(robot.clone(), law(&learner.best()), 77)?;
        curve.times.push(now);
        curve.strides.push(strides);
    }
    curve.best = learner.best();
    Ok(curve)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let given: Vec<usize> = std::env::args()
        .skip(1)
        .map(|it| it.parse())
        .collect::<Result<_, _>>()?;
    let (seeds, starts) = match given[..] {
        [seeds, starts] => (seeds, starts),
        _ => (2, 6),
    };
    let robot = saltus_robot::resolve("rats-run", &[])?;
    let draw = Draw::around(&robot);
    let held_out = |program: &Program| -> Result<Vec<f64>, GaitError> {
        let one = |k: usize| {
            let drawn = drawn_robot(&robot, &draw, HELD_OUT, k)?;
            Ok(start(drawn, program.clone(), k as u64)?.0)
        };
        map_on(available(), ROBOTS, one).into_iter().collect()
    };
    let two = Program::ClosedLoop(Lines::Two {
        first: 0.35,
        slope: -0.01,
        switch: 5.0,
        last: -0.1,
        at: 13.3,
        jumps: false,
    });
    let (begin, _) = start(robot.clone(), law(&START), 77)?;
    println!(
        "where learners begin: {begin:.3} s; two lines: {:.3} s",
        start(robot.clone(), two.clone(), 77)?.0
    );
    println!(
        "two lines on {ROBOTS} drawn robots: median {:.3} s",
        median(held_out(&two)?)
    );
    for name in ["Bayesian optimisation", "CMA-ES"] {
        let one = |k: usize| {
            let seed = k as u64 + 1;
            let learner: Box<dyn Learner> = match name {
                "CMA-ES" => Box::new(Evolution::new(START.to_vec(), 0.2, seed)),
                _ => Box::new(Bayes::new(START.to_vec(), seed)),
            };
            learn(&robot, learner, (starts, seed))
        };
        let curves: Vec<Curve> = map_on(available(), seeds, one)
            .into_iter()
            .collect::<Result<_, _>>()?;
        let last = median(curves.iter().map(|c| c.times[starts - 1]).collect());
        let within = |c: &Curve| {
            let own = c.times[starts - 1];
            let at = c.times.iter().position(|time| *time <= 1.1 * own);
            c.strides[at.unwrap_or(starts - 1)] as f64
        };
        println!("{name}: {seeds} seeds, {starts} starts");
        for k in [5, 10, 20, 40, starts].into_iter().filter(|k| *k <= starts) {
            let time = median(curves.iter().map(|c| c.times[k - 1]).collect());
            let strides = median(curves.iter().map(|c| c.strides[k - 1] as f64).collect());
            println!("  after {k} starts, {strides} strides: {time:.3} s");
        }
        println!(
            "  strides until within 10 % of the end, median: {}",
            median(curves.iter().map(within).collect())
        );
        let best = curves
            .iter()
            .min_by(|a, b| a.times[starts - 1].total_cmp(&b.times[starts - 1]));
        if let Some(best) = best {
            println!(
                "  the best of them, {last:.3} s in the median, on drawn robots: median {:.3} s",
                median(held_out(&law(&best.best))?)
            );
        }
    }
    Ok(())
}
