//! `saltus design`: what a planned experiment can tell.

use std::fmt::Write;
use std::path::PathBuf;

use clap::Args;
use saltus::Robot;
use saltus::diagnosis::Power;
use saltus::experiment::Plan;
use saltus::inject::{self, Asked, Effect};
use saltus::power::{self, PowerError, Proposed, SEEN, Told};
use serde_json::{Value, json};

use super::Status;
use super::common::{OutputFlags, RobotFlags};
use super::diagnose::Claims;
use crate::error::CliError;
use crate::output::{self, Column, Format, Table, cells, columns, digits, grid, split, with_unit};
use crate::progress::Progress;

/// Say what a planned experiment can tell: how often a diagnosis of its data would name each effect
#[derive(Args, Debug)]
#[command(
    after_help = "`saltus design --help` explains the plan and the output.",
    after_long_help = LONG_HELP,
    mut_arg("robot", |robot| robot.help("Robot that the operator believes will be measured, in place of the plan's: a built-in one or a TOML file"))
)]
pub(crate) struct Design {
    /// What will be measured
    #[arg(value_name = "PLAN.toml")]
    plan: PathBuf,

    /// Effect that may be there, with its size; may be repeated [default: every cause at two sizes]
    #[arg(long, value_name = "CAUSE=VALUE")]
    effect: Vec<Effect>,

    /// Propose so many jumps that tell the effects apart best
    #[arg(long, value_name = "COUNT", allow_negative_numbers = true, value_parser = clap::value_parser!(u16).range(1..=200))]
    propose: Option<u16>,

    #[command(flatten)]
    claims: Claims,

    #[command(flatten)]
    robot: RobotFlags,

    #[command(flatten)]
    output: OutputFlags,
}

const LONG_HELP: &str = "\
Examples:
  saltus design plan.toml
  saltus design plan.toml --effect air-drag=0.02 --effect mass=2.9 --propose 12

No data are needed: PLAN.toml says what will be measured, and the answer is how often a diagnosis of that would \
name each effect (alone or with two rivals at most), how often nothing, and what it would be taken for. Keys of a plan: kind, robot, \
runs (how many; of outcomes jumps), [noise], [resolution] and [known] as in experiment.toml; [[jump]] of the kinds jump and outcomes, in the \
place of runs: approach_rate_rad_s, firing_angle_rad, valve_open_s, of jump supply_pressure_gauge_psi, and repeat. \
Without --effect every cause is tried at two sizes: those that all readings together show by 6 and by 12 standard deviations of \
noise and of the model's own error (--model-error). --propose gives the jumps of a grid that tell the \
effects apart best. An example:
  kind = \"outcomes\"
  robot = \"rats-boom\"
  noise = { distance_mm = 3, apex_mm = 2 }
  [[jump]]
  approach_rate_rad_s = 4.5
  firing_angle_rad = 0.05
  valve_open_s = 0.08
  repeat = 6

JSON: {\"command\": \"design\", \"kind\", \"robot\", \"runs\", \"experiments_drawn\", \"effects\": [{\"id\", \"column\", \"parameters\", \"seen_by_sigmas\", \"named\", \"alone\", \"nothing\" (shares), \
\"others\": {id: share}}], \"never_seen\": [ids], \"proposed\" (null without --propose): {\"jumps\": [{approach_rate_rad_s, firing_angle_rad, valve_open_s, supply_pressure_gauge_pa}], \"effects\"}}.

CSV columns, one row for each parameter of an effect: cause (the id), column, parameter, value, seen_by_sigmas, named, alone, nothing.";

impl Design {
    pub(crate) fn run(self) -> Result<Status, CliError> {
        self.output.report_ready()?;
        let plan = Plan::open(&self.plan)?;
        let robot = self.robot_of(&plan)?;
        let mut settings = self.claims.settings()?;
        for known in &plan.known {
            if settings.known.iter().all(|other| other.name != known.name) {
                settings.known.push(known.clone());
            }
        }
        let progress = Progress::new("effects", 0);
        let advance = |_: &str| progress.advance(1);
        let wrong = |error: PowerError| match error {
            PowerError::Data(
                error @ (inject::Error::Cause { .. } | inject::Error::Value { .. }),
            ) => CliError::content("--effect", error),
            error @ PowerError::NoJumps { .. } => CliError::content("--propose", error),
            error => CliError::content(self.plan.display(), error),
        };
        let told = power::told(&plan, robot.as_ref(), &self.effect, &settings, &advance);
        let told = told.map_err(wrong)?;
        let propose = |count: u16| {
            let (robot, count) = (robot.as_ref(), usize::from(count));
            power::propose(&plan, robot, &self.effect, count, &settings, &advance)
        };
        let proposed = self.propose.map(propose).transpose().map_err(wrong)?;
        drop(progress);
        let answer = Answer {
            kind: plan.kind.spec().id,
            robot: robot.as_ref(),
            draws: settings.draws,
            told,
            proposed,
        };
        self.output.write_report(match self.output.format() {
            Format::Json => output::json(&answer.json()),
            Format::Csv => answer.csv(),
            Format::Text => answer.text(),
        })?;
        Ok(Status::Done)
    }

    /// The robot that the operator believes in: that of the flags, of the plan or of the kind.
    fn robot_of(&self, plan: &Plan) -> Result<Option<Robot>, CliError> {
        let beside = |name: &String| {
            let is_builtin = Robot::builtin_names().any(|known| known == name);
            match self.plan.parent().filter(|_| !is_builtin) {
                Some(folder) => folder.join(name).display().to_string(),
                None => name.clone(),
            }
        };
        let usual = plan.robot.as_ref().map(beside);
        let usual = usual.or(plan.kind.spec().robot.map(str::to_owned));
        self.robot.robot_if_any(usual)
    }
}

/// What is said.
struct Answer<'a> {
    kind: &'static str,
    robot: Option<&'a Robot>,
    draws: usize,
    told: Told,
    proposed: Option<Proposed>,
}

/// Shares below this are not said.
const SMALL: f64 = 0.05;

fn percent(share: f64) -> String {
    format!("{} %", digits(100.0 * share, 2))
}

/// Mean over effects of how often they are named.
fn mean(effects: &[Power]) -> f64 {
    effects.iter().map(|power| power.named).sum::<f64>() / effects.len().max(1) as f64
}

/// A cause, of a sensor with its column.
fn title(power: &Power) -> String {
    power.column.as_ref().map_or(power.id.to_owned(), |column| {
        format!("{} of {column}", power.id)
    })
}

/// A row for each parameter of an effect.
fn columns<'a>() -> [Column<(&'a Power, &'a (String, f64))>; 8] {
    columns! {
        "cause", "", |(power, _)| power.id;
        "column", "", |(power, _)| power.column.clone();
        "parameter", "", |(_, it)| it.0.clone();
        "value", "", |(_, it)| it.1;
        "seen_by_sigmas", "", |(power, _)| power.visible;
        "named", "", |(power, _)| power.named;
        "alone", "", |(power, _)| power.alone;
        "nothing", "", |(power, _)| power.nothing;
    }
}

impl Answer<'_> {
    fn text(&self) -> String {
        let of = self
            .robot
            .map_or(String::new(), |robot| format!(" of {}", robot.name));
        let mut text = format!(
            "What {} of kind {}{of} can tell, in {} experiments drawn\n\n",
            self.count(self.told.runs),
            self.kind,
            self.draws
        );
        text += &table(&self.told.effects);
        text += &self.summary();
        if !self.told.hidden.is_empty() {
            let _ = writeln!(
                text,
                "No size of these shows by {} σ: {}.",
                SEEN[0],
                self.told.hidden.join(", ")
            );
        }
        if let Some(proposed) = &self.proposed {
            let _ = writeln!(
                text,
                "\nThese {} of a grid tell the effects apart best:\n",
                self.count(proposed.jumps.len())
            );
            text += &jumps(&proposed.jumps);
            let _ = writeln!(
                text,
                "\nWith them, an effect is named in {} on average, in place of {}.\n",
                percent(mean(&proposed.told.effects)),
                percent(mean(&self.told.effects))
            );
            text += &table(&proposed.told.effects);
        }
        text
    }

    fn count(&self, runs: usize) -> String {
        let what = match (self.kind, runs) {
            ("outcomes" | "jump", 1) => "jump",
            ("outcomes" | "jump", _) => "jumps",
            (_, 1) => "run",
            _ => "runs",
        };
        format!("{runs} {what}")
    }

    fn summary(&self) -> String {
        format!(
            "\nSeen by: standard deviations of noise and of the model's own error by which all readings \
             together\nshow the effect. Named: alone or with two rivals at most; on average {}. \
             Taken for: what is named\nwith it or in its place, in {} of the experiments or more.\n",
            percent(mean(&self.told.effects)),
            percent(SMALL)
        )
    }

    fn json(&self) -> Value {
        let proposed = self.proposed.as_ref().map(|proposed| {
            let jump = |asked: &Asked| {
                json!({
                    "approach_rate_rad_s": asked.rate,
                    "firing_angle_rad": asked.firing_angle,
                    "valve_open_s": asked.valve_open,
                    "supply_pressure_gauge_pa": asked.supply,
                })
            };
            json!({
                "jumps": proposed.jumps.iter().map(jump).collect::<Vec<_>>(),
                "effects": proposed.told.effects.iter().map(entry).collect::<Vec<_>>(),
            })
        });
        json!({
            "command": "design",
            "kind": self.kind,
            "robot": self.robot.map(|robot| &robot.name),
            "runs": self.told.runs,
            "experiments_drawn": self.draws,
            "effects": self.told.effects.iter().map(entry).collect::<Vec<_>>(),
            "never_seen": self.told.hidden,
            "proposed": proposed,
        })
    }

    fn csv(&self) -> String {
        let effects = self.told.effects.iter();
        let rows = effects.flat_map(|power| power.values.iter().map(move |value| (power, value)));
        Table::of(&columns(), rows).csv()
    }
}

fn entry(power: &Power) -> Value {
    json!({
        "id": power.id,
        "column": power.column,
        "parameters": power.values.iter().cloned().collect::<Value>(),
        "seen_by_sigmas": power.visible,
        "named": power.named,
        "alone": power.alone,
        "nothing": power.nothing,
        "others": power.others.iter().copied().collect::<Value>(),
    })
}

fn table(effects: &[Power]) -> String {
    let mut lines = vec![cells("effect|size|seen by|named|alone|nothing|taken for")];
    for power in effects {
        let size = |(name, value): &(String, f64)| {
            let (stem, unit) = split(name);
            let stem = stem.rsplit('.').next().unwrap_or(stem);
            format!("{stem} {}", with_unit(*value, 5, unit))
        };
        let sizes: Vec<String> = power.values.iter().map(size).collect();
        let others = power
            .others
            .iter()
            .filter(|(_, share)| *share >= SMALL)
            .take(3);
        let others: Vec<String> = others
            .map(|(id, share)| format!("{id} {}", percent(*share)))
            .collect();
        lines.push(vec![
            title(power),
            sizes.join(", "),
            format!("{} σ", digits(power.visible, 2)),
            percent(power.named),
            percent(power.alone),
            percent(power.nothing),
            others.join(", "),
        ]);
    }
    grid(&lines, 2)
}

/// Jumps that are alike in one line.
fn jumps(asked: &[Asked]) -> String {
    let mut lines = vec![cells(
        "times|approach rate|firing angle|valve open|supply (gauge)",
    )];
    let mut rest = asked;
    while let Some(first) = rest.first() {
        let count = rest.iter().take_while(|other| *other == first).count();
        rest = &rest[count..];
        let supply = first.supply.map_or(String::new(), |pressure| {
            format!("{} kPa", digits(1e-3 * pressure, 4))
        });
        lines.push(vec![
            count.to_string(),
            format!("{} rad/s", digits(first.rate, 3)),
            format!("{} rad", digits(first.firing_angle, 3)),
            format!("{} s", digits(first.valve_open, 3)),
            supply,
        ]);
    }
    grid(&lines, 0)
}
