//! `--analyse`: what a gait is worth, in words and as JSON.

use std::fmt::Write as _;

use clap::ValueEnum;
use saltus::Robot;
use saltus::gait::analysis::basin::{Basin, Fate};
use saltus::gait::analysis::energy::Energy;
use saltus::gait::analysis::frontier::{Choice, Choices};
use saltus::gait::analysis::periodic::{Multiplier, Periodic};
use saltus::gait::analysis::stride::{Firing, Strides};
use saltus::gait::analysis::{Effort, Report, report_with};
use saltus::gait::{Draw, Ending, GaitError, Setup};
use serde_json::{Value, json};

use super::Run;
use super::gait::{Chosen, Kind};
use super::report::{head, joined};
use crate::cli::Status;
use crate::cli::disturb::Typed;
use crate::cli::refused::refused;
use crate::error::CliError;
use crate::output::{self, Files, Format, digits, message};
use crate::progress::Progress;

/// How much is tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Depth {
    /// Some seconds: one start for periodic gaits, coarse grids of starts, four choices
    Quick,
    /// Half a minute on one core
    Full,
}

/// A multiplier of a smaller modulus is counted, not listed, in the text.
const LISTED: f64 = 0.01;

/// An analysis and what it is of.
struct Analysis<'a> {
    setup: &'a Setup,
    chosen: &'a Chosen,
    disturbances: &'a [Typed],
    depth: Depth,
    effort: &'a Effort,
    report: &'a Report,
}

impl Depth {
    fn name(self) -> &'static str {
        match self {
            Depth::Quick => "quick",
            Depth::Full => "full",
        }
    }

    fn effort(self) -> Effort {
        let full = Effort::default();
        match self {
            Depth::Full => full,
            Depth::Quick => Effort {
                rates: vec![12.0],
                sizes: vec![2, 4, 8],
                choices: Choices {
                    angles: vec![0.0, 0.1],
                    openings: vec![0.02, 0.04],
                    legs: [20, 20],
                    ..full.choices
                },
                ..full
            },
        }
    }
}

impl Run {
    /// Refuses what has no analysis, before any work.
    pub(super) fn can_be_analysed(&self, robot: &Robot, chosen: &Chosen) -> Result<(), CliError> {
        let refuse = |allowed: String| Err(CliError::flag("--analyse", "", allowed));
        if chosen.kind != Kind::Fixed {
            return refuse(format!(
                "used with --gait fixed, whose firing angle and valve opening time are constant, not {}",
                chosen.kind.name()
            ));
        }
        if !chosen.forwards {
            return refuse("used with --direction forwards, not backwards".into());
        }
        if robot.leg.cylinder().is_none() {
            return refuse("used with a robot with pneumatic legs, whose gas is counted".into());
        }
        if self.output.format() == Format::Csv {
            return refuse("used with --format text or json, not csv".into());
        }
        let angle = chosen.firing_angle().unwrap_or_default();
        Strides::new(robot, Firing::new(angle, chosen.valve_open))
            .map(|_| ())
            .map_err(|error| not_analysed(error, robot))
    }

    /// Analyses the gait and reports.
    pub(super) fn analysed(
        &self,
        setup: &Setup,
        chosen: &Chosen,
        depth: Depth,
    ) -> Result<Status, CliError> {
        let mut files = Files::default();
        files.extend(self.output.out().map(|out| ("--out", out)));
        files.check()?;
        let effort = self.effort(setup, depth);
        if self.exact {
            message("the analysis takes about ten times as long with --exact as without");
        } else if depth == Depth::Full {
            message(
                "the analysis takes about half a minute, and some seconds with --analyse quick",
            );
        }
        let progress = Progress::new("analysis", 0);
        let report = report_with(setup, &effort, |part| progress.note(part))
            .map_err(|error| not_analysed(error, &setup.robot))?;
        drop(progress);
        let analysis = Analysis {
            setup,
            chosen,
            disturbances: &self.disturb,
            depth,
            effort: &effort,
            report: &report,
        };
        self.output.write_report(match self.output.format() {
            Format::Json => output::json(&analysis.value()),
            _ => analysis.text(),
        })?;
        Ok(match report.summary.ending {
            Ending::Ran => Status::Done,
            Ending::Stalled { .. } => Status::No,
        })
    }

    fn effort(&self, setup: &Setup, depth: Depth) -> Effort {
        let mut effort = depth.effort();
        effort.threads = self.threads.count().get();
        // A robot on a slope rolls down that one.
        if setup.robot.ground.tilt < 0.0 {
            effort.slope = -setup.robot.ground.tilt;
        }
        let draw = Draw {
            across: self.drawn_across,
            ..Draw::around(&setup.robot)
        };
        match self.robots {
            Some(robots) => effort.with_robots(draw, robots.get(), self.seed),
            None => effort,
        }
    }
}

/// What is wrong with a gait that cannot be analysed.
fn not_analysed(error: GaitError, robot: &Robot) -> CliError {
    match error {
        GaitError::Input {
            ref name,
            value,
            ref allowed,
        } if name.starts_with("slope") => {
            let slope = short(value);
            let reason = format!("--analyse: a slope of {slope} rad must be {allowed}");
            CliError::content(&robot.name, reason)
        }
        GaitError::Input {
            ref name,
            value,
            ref allowed,
        } if name == "firing angle (rad)" => {
            let allowed = format!("{allowed}, for --analyse");
            CliError::flag("--firing-angle", format!("{value} rad"), allowed)
        }
        error => refused(error, robot),
    }
}

impl Analysis<'_> {
    fn text(&self) -> String {
        let setup = self.setup;
        let mut text = format!(
            "{}: {}, {} s, analysed\n",
            setup.robot.name,
            self.chosen.words,
            short(setup.seconds)
        );
        for typed in self.disturbances {
            text += &line("disturbed by", &typed.text);
        }
        let summary = &self.report.summary;
        // A robot that stands has no travel, whatever the noise of its feet.
        let moved = |x: f64| short(if x.abs() < 1e-6 { 0.0 } else { x });
        text += &line("ending", &ending(summary.ending));
        text += &line("travel", &format!("{} m", moved(summary.travel)));
        text += &line("mean speed", &format!("{} m/s", moved(summary.mean_speed)));
        text += "energy of the run\n";
        for (name, words) in parts(&self.report.energy) {
            text += &line(name, &words);
        }
        text += &self.gaits();
        text += &self.rolling();
        text += &self.starts();
        text + &self.frontier()
    }

    fn gaits(&self) -> String {
        let firing = self.report.firing;
        let mut text = format!(
            "periodic gaits at α_f {} rad, valve open {} ms, fired without sensors and cycles\n",
            short(firing.angle),
            short(firing.valve_open * 1e3)
        );
        let rates: Vec<String> = self.effort.rates.iter().map(|rate| short(*rate)).collect();
        let from = format!("upright at {} rad/s", rates.join(" and "));
        text += &line("starts", &from);
        if self.report.gaits.is_empty() {
            text += &line("none", "the starts stall or come to no periodic gait");
        }
        for gait in &self.report.gaits {
            let name = if gait.legs == 1 {
                "1 leg".into()
            } else {
                format!("{} legs", gait.legs)
            };
            let words = format!(
                "period {} s, {} m/s, {} g/m, work {} J/m, {}",
                short(gait.period),
                short(gait.speed),
                short(gait.gas * 1e3),
                short(gait.work),
                stability(gait)
            );
            text += &line(&name, &words);
            text += &line("  multipliers", &multipliers(gait));
        }
        text
    }

    fn rolling(&self) -> String {
        let mut text = "rolling without drive, on point feet and without a boom\n".to_owned();
        let name = format!("down {} rad", short(self.effort.slope));
        text += &line(
            &name,
            &self.report.rolling.map_or_else(
                || "stops, or leaves the ground".to_owned(),
                |rolling| {
                    format!(
                        "{} rad/s before a foot comes down, {} rad/s after, multiplier {}",
                        short(rolling.before),
                        short(rolling.after),
                        short(rolling.multiplier)
                    )
                },
            ),
        );
        let least = self.report.least_slope;
        let least = least.map_or("none".into(), |slope| format!("{} rad", short(slope)));
        text + &line("least slope", &least)
    }

    fn starts(&self) -> String {
        let starts = &self.effort.starts;
        let [lean, rate] = [starts.leans, starts.rates].map(|range| range.map(short));
        let mut text = format!(
            "starts that run, on one foot with a lean of {} to {} rad and {} to {} rad/s\n",
            lean[0], lean[1], rate[0], rate[1]
        );
        for basin in &self.report.basins {
            let mut words = format!(
                "{} % run for {} legs, boundary {} sides long",
                digits(1e2 * basin.share, 3),
                starts.legs,
                digits(basin.boundary, 3)
            );
            if basin.fails() > 0 {
                // Writing to a string does not fail.
                let _ = write!(words, ", {} not simulated", basin.fails());
            }
            text += &line(&format!("{0} x {0} starts", basin.size), &words);
        }
        text
    }

    fn frontier(&self) -> String {
        let choices = &self.effort.choices;
        let tried = choices.angles.len() * choices.openings.len();
        let who = match &choices.drawn {
            None => "of this robot".to_owned(),
            Some((_, robots, seed)) => format!("of {robots} drawn robots, seed {seed}"),
        };
        let mut text = format!(
            "speed against gas {who}: of {tried} choices of α_f and t_v, those that none is better than\n"
        );
        if self.report.frontier.is_empty() {
            let share = format!("no choice runs for {} % of robots", 1e2 * self.effort.share);
            text += &line("none", &share);
        }
        for choice in &self.report.frontier {
            let mut words = format!(
                "{} m/s, {} g/m",
                short(choice.speed),
                short(choice.gas * 1e3)
            );
            if choices.drawn.is_some() {
                let _ = write!(words, ", {} of {} run", choice.running, choice.robots);
            }
            let open = digits(choice.opening * 1e3, 4);
            let name = format!("{} rad, {open} ms", short(choice.angle));
            text += &line(&name, &words);
        }
        text
    }

    fn value(&self) -> Value {
        let report = self.report;
        let ending = match report.summary.ending {
            Ending::Ran => json!({ "how": "ran" }),
            Ending::Stalled { since, at } => {
                json!({ "how": "stalled", "since_s": since.max(0.0), "at_m": at })
            }
        };
        let rolling = report.rolling.map(|rolling| {
            json!({
                "rate_before_rad_s": rolling.before,
                "rate_after_rad_s": rolling.after,
                "multiplier": rolling.multiplier,
            })
        });
        let choices = &self.effort.choices;
        let starts = &self.effort.starts;
        let of = |choices: &[Choice]| choices.iter().map(choice).collect::<Vec<_>>();
        let analysis = json!({
            "analysis": self.depth.name(),
            "ending": ending,
            "travel_m": report.summary.travel,
            "mean_speed_m_s": report.summary.mean_speed,
            "energy_j": energy(&report.energy),
            "firing": {
                "angle_rad": report.firing.angle,
                "valve_open_s": report.firing.valve_open,
                "section_lean_rad": report.firing.section,
            },
            "periodic_gaits": {
                "start_rates_rad_s": self.effort.rates,
                "found": report.gaits.iter().map(gait).collect::<Vec<_>>(),
            },
            "rolling": {
                "slope_rad": self.effort.slope,
                "steady": rolling,
                "least_slope_rad": report.least_slope,
            },
            "starts": {
                "leans_rad": starts.leans,
                "rates_rad_s": starts.rates,
                "legs": starts.legs,
                "grids": report.basins.iter().map(grid).collect::<Vec<_>>(),
            },
            "speed_against_gas": {
                "drawn_robots": choices.drawn.as_ref().map(|(_, robots, _)| robots),
                "angles_rad": choices.angles,
                "valve_open_s": choices.openings,
                "start_rate_rad_s": choices.rate,
                "least_share_running": self.effort.share,
                "running": of(&report.choices),
                "frontier": of(&report.frontier),
            },
        });
        joined([head(self.setup, self.chosen, self.disturbances), analysis])
    }
}

fn ending(ending: Ending) -> String {
    match ending {
        Ending::Ran => "ran to the end of its time".into(),
        Ending::Stalled { since, at } => format!(
            "stalled: stands still since {} s, at {} m",
            short(since.max(0.0)),
            short(at)
        ),
    }
}

/// The energy's parts in words: what comes in, what is lost, what is gained, the rest.
fn parts(energy: &Energy) -> [(&'static str, String); 12] {
    let one = |x: f64| format!("{} J", joules(x));
    let each = |all: &[f64]| {
        let words: Vec<String> = all.iter().map(|x| joules(*x)).collect();
        format!("{} J", words.join(", "))
    };
    [
        ("gas, its exergy", one(energy.gas)),
        ("from outside", one(energy.outside)),
        (
            "not made work",
            format!("{} in valves, exhaust, chambers", one(energy.valves)),
        ),
        ("work of the legs", each(&energy.leg_work)),
        ("lost in legs", each(&energy.leg_loss)),
        ("lost in other joints", one(energy.joints)),
        ("lost by slip", one(energy.slip)),
        ("lost to the air", one(energy.drag)),
        ("lost at the ground", one(energy.impacts)),
        ("lost at end stops", one(energy.stops)),
        (
            "gained",
            format!("{} in motion, height and springs", one(energy.gained)),
        ),
        ("unexplained", one(energy.unexplained())),
    ]
}

/// An energy (J) for people, without round-off.
fn joules(x: f64) -> String {
    short(if x.abs() < 1e-9 { 0.0 } else { x })
}

fn energy(energy: &Energy) -> Value {
    json!({
        "gas_exergy": energy.gas,
        "outside": energy.outside,
        "valves_and_exhaust": energy.valves,
        "leg_work": energy.leg_work,
        "lost_in_legs": energy.leg_loss,
        "lost_in_other_joints": energy.joints,
        "lost_by_slip": energy.slip,
        "lost_in_impacts_at_ground": energy.impacts,
        "lost_in_impacts_at_stops": energy.stops,
        "lost_to_the_air": energy.drag,
        "gained": energy.gained,
        "lost": energy.lost(),
        "unexplained": energy.unexplained(),
    })
}

/// Whether neighbours come nearer, in words: open where the error does not tell.
fn stability(gait: &Periodic) -> &'static str {
    let (most, error) = gait.greatest();
    if gait.is_stable() {
        "stable"
    } else if most - error > 1.0 {
        "unstable"
    } else {
        "stable or not: within the error"
    }
}

fn multipliers(gait: &Periodic) -> String {
    let (listed, small): (Vec<&Multiplier>, Vec<&Multiplier>) = gait
        .multipliers
        .iter()
        .partition(|multiplier| multiplier.value.norm() >= LISTED);
    let one = |multiplier: &&Multiplier| {
        let value = multiplier.value;
        let number = if value.im == 0.0 {
            short(value.re)
        } else {
            let sign = if value.im < 0.0 { '-' } else { '+' };
            format!("{} {sign} {}i", short(value.re), short(value.im.abs()))
        };
        format!("{number} ± {}", digits(multiplier.error, 1))
    };
    let mut words: Vec<String> = listed.iter().map(one).collect();
    if !small.is_empty() {
        words.push(format!("{} below {LISTED}", small.len()));
    }
    if words.is_empty() {
        return "none: no number is free to differ".into();
    }
    words.join("; ")
}

fn gait(gait: &Periodic) -> Value {
    let multiplier = |m: &Multiplier| {
        json!({
            "real": m.value.re, "imaginary": m.value.im, "modulus": m.value.norm(), "error": m.error,
        })
    };
    json!({
        "legs": gait.legs,
        "period_s": gait.period,
        "speed_m_s": gait.speed,
        "gas_kg_per_m": gait.gas,
        "work_j_per_m": gait.work,
        "residual": gait.residual,
        "is_stable": gait.is_stable(),
        "stability": stability(gait),
        "multipliers": gait.multipliers.iter().map(multiplier).collect::<Vec<_>>(),
    })
}

/// A grid: for each lean, what each rate leads to.
fn grid(basin: &Basin) -> Value {
    let word = |fate: &Fate| match fate {
        Fate::Runs => "runs",
        Fate::Stalls => "stalls",
        Fate::Fails => "not simulated",
    };
    let rows = basin.fates.chunks(basin.size);
    let fates: Vec<Vec<&str>> = rows.map(|row| row.iter().map(word).collect()).collect();
    json!({
        "cells_a_side": basin.size,
        "share_running": basin.share,
        "boundary": basin.boundary,
        "not_simulated": basin.fails(),
        "fates_by_lean_then_rate": fates,
    })
}

fn choice(choice: &Choice) -> Value {
    json!({
        "firing_angle_rad": choice.angle,
        "valve_open_s": choice.opening,
        "speed_m_s": choice.speed,
        "gas_kg_per_m": choice.gas,
        "running": choice.running,
        "robots": choice.robots,
    })
}

fn line(name: &str, words: &str) -> String {
    format!("  {name:<22} {words}\n")
}

/// A number for people.
fn short(x: f64) -> String {
    digits(x, 4)
}
