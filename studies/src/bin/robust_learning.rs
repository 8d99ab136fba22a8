//! What was learnt on one robot, on others: drawn robots, slopes, pushes, other supply, slippery ground; learnt with and
//! without drawn robots; and how soon it is learnt anew after a change.
//!
//! ```text
//! cd studies && cargo run --release --bin robust_learning -- 30 40
//! ```
//!
//! Seeds, and trials of each in each place; 2 and 3 where nothing is given. A number is the share of the trials that come
//! 1.6 m far in 3 s, as mean of the middle half of the seeds with its 95 % interval; then the median time (s) of those that do.

use saltus::gait::learn::{Algorithm, Schedule, Score, Tabular};
use saltus::gait::{
    Disturbance, Draw, Footfall, GaitError, Lines, Program, Row, Run, Setup, Smooth, What, When,
    drawn_robot, run,
};
use saltus::learning::{Learnt, PolicyFile, Settings, Task, interquartile, learn};
use saltus::numeric::parallel::{available, map_on};
use saltus::robot::Robot;
use saltus_studies::laws::{by_law, seek};

type Failed = Box<dyn std::error::Error>;

/// Seeds of trials, which no training has.
const HELD_OUT: u64 = 500;
/// Longest time (s), and the goal (m).
const LONGEST: f64 = 3.0;
const GOAL: f64 = 1.6;

/// What was learnt.
enum Policy {
    Table(Tabular),
    Law(Smooth),
}

impl Policy {
    /// When an episode of the task of `settings` reaches the goal (s).
    fn arrives(&self, settings: &Settings, seed: (u64, usize)) -> Result<Option<f64>, GaitError> {
        let score = match self {
            Policy::Table(table) => settings.trial(table, seed)?,
            Policy::Law(law) => by_law(settings.environment()?.as_ref(), law, seed)?,
        };
        Ok(score.outcome.arrived)
    }
}

/// Where a policy is tried.
struct Place {
    name: &'static str,
    robot: Robot,
    draws: bool,
    torque: Option<f64>,
}

fn places() -> Result<Vec<Place>, Failed> {
    let place = |name, overrides: &[&str], draws, torque| -> Result<Place, Failed> {
        let overrides: Vec<String> = overrides.iter().map(|it| (*it).into()).collect();
        let robot = saltus::resolve("rats-run", &overrides)?;
        Ok(Place {
            name,
            robot,
            draws,
            torque,
        })
    };
    Ok(vec![
        place("as it is", &[], false, None)?,
        place("drawn robots", &[], true, None)?,
        place("3° uphill", &["ground.slope_deg=3"], false, None)?,
        place("3° downhill", &["ground.slope_deg=-3"], false, None)?,
        place("held back by 5 N m at 0.5 to 0.7 s", &[], false, Some(-5.0))?,
        place("pushed by 5 N m at 0.5 to 0.7 s", &[], false, Some(5.0))?,
        place(
            "supply 96 psi",
            &["leg.supply_pressure_gauge_psi=96"],
            false,
            None,
        )?,
        place(
            "supply 144 psi",
            &["leg.supply_pressure_gauge_psi=144"],
            false,
            None,
        )?,
        place(
            "friction 0.45",
            &["ground.static_friction=0.45"],
            false,
            None,
        )?,
    ])
}

impl Place {
    fn disturbances(&self) -> Vec<Disturbance> {
        let when = When::Time(0.5, 0.7);
        let what = self.torque.map(What::Torque);
        what.map(|what| Disturbance { when, what })
            .into_iter()
            .collect()
    }

    /// Times (s) to the goal; none where it is not reached.
    fn trials(
        &self,
        policy: &Policy,
        settings: &Settings,
        count: usize,
    ) -> Result<Vec<Option<f64>>, Failed> {
        let mut there = settings.clone();
        there.plant.robot = self.robot.clone();
        there.plant.robot.leg.least_pulse = settings.plant.robot.leg.least_pulse;
        there.plant.draw = self.draws.then(|| Draw::around(&self.robot));
        there.plant.disturbances = self.disturbances();
        if settings.task == Task::RunZone {
            there.steps = 600;
        }
        let one = |k| policy.arrives(&there, (HELD_OUT, k));
        Ok((0..count).map(one).collect::<Result<_, _>>()?)
    }

    /// The same of a program of the controller.
    fn runs(&self, program: &Program, count: usize) -> Result<Vec<Option<f64>>, Failed> {
        let one = |k: usize| {
            let robot = if self.draws {
                drawn_robot(&self.robot, &Draw::around(&self.robot), HELD_OUT, k)?
            } else {
                self.robot.clone()
            };
            let mut setup = Setup::new(robot, program.clone(), LONGEST);
            setup.zone = -0.3;
            setup.seed = HELD_OUT + k as u64;
            setup.disturbances = self.disturbances();
            run(&setup, &mut ToGoal(0.0)).map(|summary| summary.time_to_1_6_m)
        };
        let all = map_on(available(), count, one);
        Ok(all.into_iter().collect::<Result<_, _>>()?)
    }
}

struct ToGoal(f64);

impl Run for ToGoal {
    fn row(&mut self, row: &Row<'_>) {
        self.0 = row.axle[0];
    }
    fn footfall(&mut self, _: &Footfall) {}
    fn goes_on(&mut self) -> bool {
        self.0 < GOAL
    }
}

/// The share that arrives, over seeds, and the median time of those that do.
fn said(trials: &[Vec<Option<f64>>]) -> String {
    let share = |all: &Vec<Option<f64>>| all.iter().flatten().count() as f64 / all.len() as f64;
    let shares: Vec<f64> = trials.iter().map(share).collect();
    let mut times: Vec<f64> = trials.iter().flatten().flatten().copied().collect();
    times.sort_by(f64::total_cmp);
    let median = times
        .get(times.len() / 2)
        .map_or("–".into(), |it| format!("{it:.3}"));
    interquartile(&shares).map_or(String::new(), |it| {
        let [low, high] = it.interval.map(|x| 100.0 * x);
        format!("{:.0} % [{low:.0} {high:.0}], {median}", 100.0 * it.value)
    })
}

/// A way of learning.
struct Way {
    name: &'static str,
    task: Task,
    /// A table of values; none: a law by Bayesian optimisation.
    algorithm: Option<Algorithm>,
    draws: bool,
    episodes: usize,
}

impl Way {
    fn settings(&self, robot: &Robot) -> Settings {
        let algorithm = self.algorithm.unwrap_or(Algorithm::Q);
        let mut settings = self.task.settings(robot.clone(), algorithm);
        settings.schedule.episodes = self.episodes;
        if self.draws {
            settings.plant.draw = Some(Draw::around(robot));
        }
        settings
    }

    fn learnt(&self, robot: &Robot, seeds: usize) -> Result<(Settings, Learnt), Failed> {
        let settings = self.settings(robot);
        let learnt = learn(&settings, (1, seeds), None, available(), &|| true)?;
        Ok((settings, learnt))
    }

    /// What each seed learnt.
    fn policies(&self, robot: &Robot, seeds: usize) -> Result<(Settings, Vec<Policy>), Failed> {
        if self.algorithm.is_some() {
            let (settings, learnt) = self.learnt(robot, seeds)?;
            let tables = learnt.pupils.into_iter();
            return Ok((settings, tables.map(|it| Policy::Table(it.table)).collect()));
        }
        let settings = self.settings(robot);
        let laws = seek(&settings, seeds, available())?.into_iter();
        Ok((settings, laws.map(|it| Policy::Law(it.law)).collect()))
    }
}

/// Mean speed (m/s) of an episode to the goal; 0 where it is not reached.
fn speed(score: &Score) -> f64 {
    score.outcome.arrived.map_or(0.0, |time| GOAL / time)
}

/// Episodes until the mean speed of ten is 90 % of `wanted`.
fn until(curve: &[Score], wanted: f64) -> Option<f64> {
    let speeds: Vec<f64> = curve.iter().map(speed).collect();
    let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
    let first = speeds
        .windows(10)
        .map(mean)
        .position(|it| it >= 0.9 * wanted);
    first.map(|first| (first + 10) as f64)
}

/// Learns anew after a change, from what was learnt before and from nothing.
fn anew(way: &Way, robot: &Robot, seeds: usize) -> Result<(), Failed> {
    let (settings, before) = way.learnt(robot, seeds)?;
    let mut file = PolicyFile::of(&settings, &before);
    file.tables.iter_mut().for_each(|held| held.curve.clear());
    for (name, change) in [
        ("supply 96 psi", "leg.supply_pressure_gauge_psi=96"),
        ("friction 0.45", "ground.static_friction=0.45"),
        ("2 kg heavier", "body.mass_kg=4.75"),
    ] {
        let changed = saltus::resolve("rats-run", &[change.into()])?;
        let mut settings = way.settings(&changed);
        let scratch = learn(&settings, (1, seeds), None, available(), &|| true)?;
        settings.schedule = Schedule {
            epsilon: 0.1,
            ..settings.schedule
        };
        let warm = learn(&settings, (1, seeds), Some(&file), available(), &|| true)?;
        // What can be reached after the change, by each seed.
        let wanted = |k: usize| {
            let both = [&scratch, &warm].map(|it| speed(&it.pupils[k].score));
            both[0].max(both[1])
        };
        let episodes = |learnt: &Learnt| {
            let pupils = learnt.pupils.iter().enumerate();
            let all = pupils.filter_map(|(k, it)| until(&it.curve, wanted(k)));
            let all: Vec<f64> = all.collect();
            let text = interquartile(&all).map_or("–".into(), |it| {
                let [low, high] = it.interval;
                format!("{:.0} [{low:.0} {high:.0}]", it.value)
            });
            format!("{text}, {} of {seeds}", all.len())
        };
        println!("| {name} | {} | {} |", episodes(&warm), episodes(&scratch));
    }
    Ok(())
}

/// All ways, or a short version of them.
fn ways(short: bool) -> Vec<Way> {
    let stride = |name, algorithm, draws, episodes| Way {
        name,
        task: Task::RunStride,
        algorithm,
        draws,
        episodes: if short { 10 } else { episodes },
    };
    let zone = |name, draws| Way {
        name,
        task: Task::RunZone,
        algorithm: Some(Algorithm::SarsaLambda),
        draws,
        episodes: 40,
    };
    vec![
        stride("law, bayes", None, false, 60),
        stride("law, bayes, learnt on drawn robots", None, true, 120),
        stride("table of strides, q", Some(Algorithm::Q), false, 500),
        stride(
            "table of strides, q, learnt on drawn robots",
            Some(Algorithm::Q),
            true,
            500,
        ),
        zone("run-zone, sarsa-lambda", false),
        zone("run-zone, sarsa-lambda, learnt on drawn robots", true),
    ]
}

fn main() -> Result<(), Failed> {
    let given: Vec<usize> = std::env::args()
        .skip(1)
        .map(|it| it.parse())
        .collect::<Result<_, _>>()?;
    let [seeds, trials] = match given[..] {
        [seeds, trials] => [seeds, trials],
        _ => [2, 3],
    };
    let robot = saltus::resolve("rats-run", &[])?;
    let ways = ways(seeds < 5);
    let places = places()?;
    let header: Vec<&str> = places.iter().map(|it| it.name).collect();
    println!("| | {} |", header.join(" | "));
    println!("| --- |{}", " --- |".repeat(header.len()));
    for way in &ways {
        let (settings, policies) = way.policies(&robot, seeds)?;
        let cells = places.iter().map(|place| {
            let one = |k: usize| {
                let all = place.trials(&policies[k], &settings, trials);
                all.map_err(|error| error.to_string())
            };
            let all = map_on(available(), seeds, one).into_iter();
            Ok::<_, Failed>(said(&all.collect::<Result<Vec<_>, _>>()?))
        });
        let cells: Vec<String> = cells.collect::<Result<_, _>>()?;
        println!("| {} | {} |", way.name, cells.join(" | "));
    }
    let two = Program::ClosedLoop(Lines::Two {
        first: 0.35,
        slope: -0.01,
        switch: 5.0,
        last: -0.1,
        at: 13.3,
        jumps: false,
    });
    for (name, program) in [
        ("the thesis' two lines", two),
        ("the smooth law", Smooth::QUICK.program()),
    ] {
        let cells = places
            .iter()
            .map(|place| Ok::<_, Failed>(said(&[place.runs(&program, seeds * trials)?])));
        let cells: Vec<String> = cells.collect::<Result<_, _>>()?;
        println!("| {name} | {} |", cells.join(" | "));
    }
    println!(
        "\nEpisodes of the table of strides to 90 % of the speed that it comes to after a change:\n"
    );
    println!("| change | from what was learnt before | from nothing |\n| --- | --- | --- |");
    anew(&ways[2], &robot, seeds)
}
