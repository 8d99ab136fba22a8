//! `saltus learn`: tables of values that learn to run.

mod report;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use saltus::gait::Draw;
use saltus::gait::learn::{Algorithm, Bin, Bins, Reward, Term};
use saltus::learning::{Learnt, PolicyFile, Settings, Task, learn};

use self::report::Report;
use super::Status;
use super::common::{OutputFlags, PlotOption, RobotFlags, Threads, seed};
use super::disturb::{self, Typed};
use super::recorded::Beside;
use crate::error::CliError;
use crate::input;
use crate::interrupt::Interrupt;
use crate::output::{Files, Format};
use crate::progress::Progress;

/// Let a robot learn to run: valves as in chapter 6 of the thesis, or firing angles
#[derive(Args, Debug)]
#[command(
    after_help = "`saltus learn --help` explains the tasks and the output.",
    after_long_help = LONG_HELP,
    mut_arg("robot", |robot| robot.help("Robot that runs: a built-in one with feet that can slip (rats-run) or a TOML file [default: rats-run]"))
)]
pub(crate) struct Learn {
    /// What is learnt
    #[arg(value_parser = named(&Task::ALL, Task::name))]
    task: Task,

    /// What learns [default: q, run-zone sarsa-lambda]
    #[arg(long, value_parser = named(&Algorithm::ALL, Algorithm::name))]
    algorithm: Option<Algorithm>,

    /// Learning rate α, from 0 to 1 [default: 1, with traces 0.8, by strides 0.2]
    #[arg(long, value_name = "NUMBER", value_parser = unit, allow_negative_numbers = true)]
    alpha: Option<f64>,

    /// Discount γ of a step, from 0 to 1 [default: 0.3, by strides 1]
    #[arg(long, value_name = "NUMBER", value_parser = unit, allow_negative_numbers = true)]
    gamma: Option<f64>,

    /// Decay λ of traces, from 0 to 1 [default: 0.9]
    #[arg(long, value_name = "NUMBER", value_parser = unit, allow_negative_numbers = true)]
    lambda: Option<f64>,

    /// Share of random actions in the first episode [default: 1, run-zone 0.95]
    #[arg(long, value_name = "SHARE", value_parser = unit, allow_negative_numbers = true)]
    epsilon: Option<f64>,

    /// Factor of this share from one episode to the next [default: 0.99, with traces 0.95 where valves are learnt]
    #[arg(long, value_name = "NUMBER", value_parser = unit, allow_negative_numbers = true)]
    decay: Option<f64>,

    /// A part of the reward and its coefficient, as in rate=1, threshold:2=1; may be repeated
    #[arg(long, value_name = "TERM=COEFFICIENT", value_parser = term)]
    reward: Vec<(Term, f64)>,

    /// The steps of a number that is observed, in SI units, as in wheel_rate=-5:20:25; 1 step leaves it out; may be repeated
    #[arg(long, value_name = "NAME=FROM:TO:COUNT", value_parser = steps_of)]
    state: Vec<(String, Bin)>,

    /// Episodes [default: 1000, with traces 100; climb 500; run-zone 40; run-stride 500; jump-stride 2000]
    #[arg(long, value_name = "COUNT", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    episodes: Option<u32>,

    /// Steps of an episode at most [default: run-legs 1000, climb 2000, run-zone 360, by strides 60]
    #[arg(long, value_name = "COUNT", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    steps: Option<u32>,

    /// Seeds, each of which learns alone
    #[arg(long, value_name = "COUNT", default_value_t = 30, allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    seeds: u32,

    /// The first seed
    #[arg(long, value_name = "SEED", default_value_t = 1, allow_negative_numbers = true, value_parser = seed)]
    seed: u64,

    /// Draw the robot of each episode around the given one, as `saltus run` with --robots does
    #[arg(long)]
    draw: bool,

    /// What changes in each episode, as in torque=5@0.5:0.7s: see `saltus run --help`; may be repeated
    #[arg(long, value_name = "WHAT=VALUE@FROM:TO", value_parser = disturb::disturb, allow_hyphen_values = true)]
    disturb: Vec<Typed>,

    /// Go on from this file, which `saltus learn --out` wrote as JSON, with its settings, seeds and robot, to more --episodes
    #[arg(long, value_name = "FILE.json", conflicts_with_all = SETTINGS.split(' '))]
    resume: Option<PathBuf>,

    #[command(flatten)]
    threads: Threads,

    #[command(flatten)]
    robot: RobotFlags,

    #[command(flatten)]
    plot: PlotOption,

    #[command(flatten)]
    output: OutputFlags,
}

/// Flags of what a file to go on from says itself.
const SETTINGS: &str = "algorithm alpha gamma lambda epsilon decay reward state \
    steps seeds seed draw disturb robot overrides";

const LONG_HELP: &str = "\
Examples:
  saltus learn run-zone --algorithm sarsa-lambda --episodes 40 --seeds 30 --out policy.json --plot curve.svg
  saltus learn run-legs --algorithm q --alpha 0.3 --gamma 1
  saltus learn run-legs --reward rate=1 --set leg.valve_delay_ms=0
  saltus learn run-stride --algorithm sarsa --out stride.json && saltus run policy stride.json --animate stride.html
  saltus learn run-legs --state pivot_angle=-0.1:0.1:4 --state wheel_rate=-10:21:20
  saltus learn run-zone --resume policy.json --episodes 80 --out policy.json

Tasks, of the robot on its boom (rats-run), from rest on two legs. What is observed stands in brackets: --state gives its steps.
  run-legs     each millisecond one valve is open, or none; for 1 s. [wheel_angle, wheel_rate, pivot_angle, pivot_rate, in the \
states of table 6.1; extension, pressure and since_fired of the leg below, and time, with 1 step each]
  climb        the same before a box 21 cm high and long, 0.5 m away; for 2 s, or until a foot is on the box and the axle over it, \
as high as on two legs
  run-zone     each 5 ms the valve of the leg in the active zone is open, or not; to 1.6 m, or for 1.8 s. [wheel_angle by the encoder, \
wheel_rate by the filtered gyro, in the states of table 6.3]
  run-stride   as each leg enters the active zone, its firing angle and valve opening time; to 1.6 m, or for 3 s. [wheel_rate, lean of that leg, \
speed, pivot_angle] It is one of 6 angles and 3 times
  jump-stride  the same over a box 10 cm high and 21 cm long, 1 m away, until the axle is a wheel's radius behind it. [box_distance, too]

Algorithms: sarsa (6.2.2), q (6.2.3), sarsa-lambda (6.2.4), q-lambda (6.2.5; a trace ends where an action is not greedy). Actions \
are random with probability epsilon, which fades from episode to episode; of equal values one is drawn. The defaults are those \
of tables 6.2 and 6.4 as printed. With gamma 0.3 at 1 kHz a learner looks 1.4 ms ahead, while a valve takes 10 ms: \
--alpha 0.3 --gamma 1 interchanges the two columns.

Rewards, summed over the terms given, for each step: threshold:RATE (1 where the wheel is faster than RATE in rad/s, else -1), \
rate (of the wheel, rad/s), travel (way in m), time (-1 for each second), gas (-1 for each kg), speed:SPEED (minus the \
distance from SPEED in m/s); at the end: stall (-1 where the robot stands), arrival (1 at the goal). The default: run-legs threshold:2=1; \
climb travel=1 and arrival=10; run-zone rate=1; run-stride travel=1, time=1 and stall=3; jump-stride travel=1 and arrival=3.

Each seed learns alone. What it learnt is scored without exploration: in five episodes that differ by noise and drawn robots, of which the one in the middle counts (in run-legs and climb, where nothing is drawn, in one). \
There, of equal values the first counts. The answer has the mean of the middle \
half of the seeds with its 95 % interval (bootstrap), and the seed that did best.

CSV, a row for each seed: seed, episodes, reward (of the scored episode), angle_rad, travel_m, arrived_s (empty: the goal was not reached), \
time_s, firings, gas_kg, outside (share of the steps of learning in which a number was outside the states' ranges), broken (episodes that ended because the \
motion could not be computed further), episodes_to_90_percent (until the mean of ten episodes has 90 % of the last tenth's angle or travel; empty: the robot did not learn to run, or less than 20 episodes).

JSON: {\"command\": \"learn\", \"task\", \"robot\", \"algorithm\", \"episodes\", \"seeds\", \"interrupted\", \"score\": {\"name\" (travel_m or \
angle_rad), \"learnt\": {\"mean_of_middle_half\", \"interval_95\"}, \"best\"}, \"arrived\": {\"count\", \"of\", \"interval_95\"}, \
\"time_to_the_goal_s\" (of the seeds that reach it) and \"episodes_to_90_percent\" (of the seeds that learn to run), each with the keys of \
\"learnt\" or null without such a seed, \"rows\": [{the columns}], \"curve\": [{\"episode\", \"mean_of_middle_half\", \"low\", \"high\"}], \
\"best_seed\", \"policy\": {the settings, \"tables\"}}. The policy is what --resume goes on from.

Ctrl-C ends learning after the episodes that run; the answer is then of what was learnt, with exit code 130, and can be resumed. A robot that learns \
nothing is an answer: the exit code is 0. The answer depends on the seeds alone, not on --threads, nor on whether it was resumed.";

/// Parser of a flag that takes one of `all` by its name.
fn named<T: Copy + Send + Sync + 'static>(
    all: &'static [T],
    name: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T> {
    let names = PossibleValuesParser::new(all.iter().map(|it| name(*it)));
    names.map(move |asked| {
        let is_it = |it: &&T| name(**it) == asked;
        *all.iter().find(is_it).expect("one of the names")
    })
}

/// Parser of a flag.
fn unit(text: &str) -> Result<f64, String> {
    match text.trim().parse() {
        Ok(x) if (0.0..=1.0).contains(&x) => Ok(x),
        _ => Err("must be a number from 0 to 1".into()),
    }
}

/// Parser of a flag.
fn steps_of(text: &str) -> Result<(String, Bin), String> {
    const WANTED: &str = "must be NAME=FROM:TO:COUNT, as in wheel_rate=-5:20:25";
    let (name, steps) = text.split_once('=').ok_or(WANTED)?;
    let parts: Vec<&str> = steps.split(':').map(str::trim).collect();
    let [from, to, count] = parts[..] else {
        return Err(WANTED.into());
    };
    let number = |text: &str| text.parse().ok().filter(|x: &f64| x.is_finite());
    let bin = Bin {
        from: number(from).ok_or(WANTED)?,
        to: number(to).ok_or(WANTED)?,
        count: count.parse().map_err(|_| WANTED)?,
    };
    Ok((name.trim().into(), bin))
}

/// Parser of a flag.
fn term(text: &str) -> Result<(Term, f64), String> {
    let wanted = || {
        format!(
            "must be TERM=COEFFICIENT with {}, as in rate=1",
            Term::WRITTEN
        )
    };
    let (name, by) = text.split_once('=').ok_or_else(wanted)?;
    let by = by.trim().parse().ok();
    let by = by.filter(|x: &f64| x.is_finite() && x.abs() <= 1e9);
    let by = by.ok_or("the coefficient must be a number from -1e9 to 1e9")?;
    Ok((Term::written(name).ok_or_else(wanted)?, by))
}

impl Learn {
    pub(crate) fn run(self) -> Result<Status, CliError> {
        self.output.check()?;
        self.output.ready(&self.plot)?;
        let before = self.before()?;
        let settings = self.settings(before.as_ref())?;
        let seeds = before
            .as_ref()
            .map_or((self.seed, self.seeds as usize), |file| {
                (
                    file.tables.first().map_or(1, |held| held.seed),
                    file.tables.len(),
                )
            });
        let mut files = Files::default();
        files.extend(self.output.out().map(|out| ("--out", out)));
        files.check()?;
        let interrupt = Interrupt::listen()?;
        let learnt = self.learn(&settings, seeds, before.as_ref(), &interrupt)?;
        let report = Report {
            settings: &settings,
            learnt: &learnt,
            interrupted: interrupt.came(),
        };
        let text = match self.output.format() {
            Format::Json => report.json(),
            Format::Csv => report.table().csv(),
            Format::Text => report.text(),
        };
        self.output.write_with(
            text,
            &self.plot,
            || Ok(report.drawing()),
            None::<Beside<'_>>,
        )?;
        Ok(if report.interrupted {
            Status::Interrupted
        } else {
            Status::Done
        })
    }

    /// The settings of the task with what the flags change, or those of what is gone on from.
    fn settings(&self, before: Option<&PolicyFile>) -> Result<Settings, CliError> {
        if let Some(before) = before {
            let mut settings = before.settings.clone();
            self.goes_on(before, &mut settings)?;
            return Ok(settings);
        }
        let algorithm = self.algorithm.unwrap_or(self.task.algorithm());
        let mut settings = self
            .task
            .settings(self.robot.robot_or("rats-run")?, algorithm);
        if self.lambda.is_some() && !settings.algorithm.has_traces() {
            let name = settings.algorithm.name();
            let allowed = format!("left out with --algorithm {name}, which has no traces");
            return Err(CliError::flag("--lambda", "", allowed));
        }
        let robot = &settings.plant.robot;
        if self.draw && robot.leg.cylinder().is_none() {
            let allowed = "used with a robot with pneumatic legs, whose supply is drawn";
            return Err(CliError::flag("--draw", "", allowed));
        }
        if !self.disturb.is_empty() {
            disturb::check(&self.disturb, robot)?;
            let disturbances = self.disturb.iter().map(|typed| typed.disturbance);
            settings.plant.disturbances = disturbances.collect();
        }
        if self.draw {
            settings.plant.draw = Some(Draw::around(&settings.plant.robot));
        }
        let rates = &mut settings.rates;
        rates.alpha = self.alpha.unwrap_or(rates.alpha);
        rates.gamma = self.gamma.unwrap_or(rates.gamma);
        rates.lambda = self.lambda.unwrap_or(rates.lambda);
        let schedule = &mut settings.schedule;
        schedule.epsilon = self.epsilon.unwrap_or(schedule.epsilon);
        schedule.decay = self.decay.unwrap_or(schedule.decay);
        schedule.episodes = self
            .episodes
            .map_or(schedule.episodes, |count| count as usize);
        settings.steps = self.steps.map_or(settings.steps, |count| count as usize);
        if !self.state.is_empty() {
            settings.bins = self.bins(&settings)?;
        }
        if !self.reward.is_empty() {
            settings.reward = Reward(self.reward.clone());
        }
        Ok(settings)
    }

    /// The states of a table.
    fn bins(&self, settings: &Settings) -> Result<Bins, CliError> {
        let robot = &settings.plant.robot.name;
        let wrong = |error| CliError::content(robot, error);
        let environment = settings.environment().map_err(wrong)?;
        let observed: Vec<&str> = environment.observed().iter().map(|it| it.name).collect();
        let mut axes = settings.bins.axes().to_vec();
        for (name, bin) in &self.state {
            let Some(place) = observed.iter().position(|it| it == name) else {
                let allowed = format!("one of {}", observed.join(", "));
                return Err(CliError::flag("--state", name, allowed));
            };
            let alone = Bins::new(vec![*bin]);
            alone.map_err(|error| CliError::content(format!("--state {name}"), error))?;
            axes[place] = *bin;
        }
        Bins::new(axes).map_err(|error| CliError::content("--state", error))
    }

    /// What is gone on from.
    fn before(&self) -> Result<Option<PolicyFile>, CliError> {
        let Some(path) = &self.resume else {
            return Ok(None);
        };
        // It may be replaced by what it becomes.
        if self.output.out() != Some(path) {
            input::note(path);
            input::spared()?;
        }
        Ok(Some(PolicyFile::load(path)?))
    }

    /// Gives `settings` the episodes asked for, of which there are more than in `before`.
    fn goes_on(&self, before: &PolicyFile, settings: &mut Settings) -> Result<(), CliError> {
        let file = self.resume.as_deref().unwrap_or(Path::new("")).display();
        let (theirs, ours) = (settings.task.name(), self.task.name());
        if theirs != ours {
            let allowed = format!("{theirs}, which {file} was learnt in");
            return Err(CliError::flag("TASK", ours, allowed));
        }
        let done = before.tables.iter().map(|held| held.curve.len());
        let done = done.min().unwrap_or(0);
        let episodes = &mut settings.schedule.episodes;
        *episodes = self.episodes.map_or(*episodes, |count| count as usize);
        if *episodes > done {
            return Ok(());
        }
        let allowed = format!("above {done}, the episodes in {file}");
        Err(CliError::flag("--episodes", *episodes, allowed))
    }

    fn learn(
        &self,
        settings: &Settings,
        seeds: (u64, usize),
        before: Option<&PolicyFile>,
        interrupt: &Interrupt,
    ) -> Result<Learnt, CliError> {
        let done = before.map_or(0, |file| {
            file.tables.iter().map(|table| table.curve.len()).sum()
        });
        let total = (seeds.1 * settings.schedule.episodes).saturating_sub(done);
        let progress = Progress::new("episodes", total);
        let stopped = AtomicBool::new(false);
        let goes_on = || {
            progress.advance(1);
            if interrupt.came() {
                stopped.store(true, Ordering::Relaxed);
            }
            !stopped.load(Ordering::Relaxed)
        };
        let threads = self.threads.count().get();
        learn(settings, seeds, before, threads, &goes_on)
            .map_err(|error| CliError::content(&settings.plant.robot.name, error))
    }
}
