//! `saltus diagnose --inject`: synthetic data with hidden effects.

use std::fmt::Write;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use saltus::diagnosis::Sort;
use saltus::experiment;
use saltus::inject::{self, Effect, Made, Request, Truth};
use saltus::recording::Origin;
use serde_json::{Map, Value, json};

use super::Diagnose;
use crate::cli::Status;
use crate::cli::common::robot;
use crate::cli::recorded::command as asked_for;
use crate::error::CliError;
use crate::output::{self, Files, Format, digits, reachable_folder};

/// The file of a robot that goes with the data.
const OWN: &str = "robot.toml";

/// What data are made in place of a diagnosis.
#[derive(Args, Debug)]
#[command(next_help_heading = "Synthetic data")]
pub(super) struct InjectFlags {
    /// Make data with this hidden effect and write them to the folder --out; none: without an
    /// effect; may be repeated
    #[arg(long, value_name = "CAUSE=VALUE")]
    pub(super) inject: Vec<String>,

    /// Kind of the data that are made
    #[arg(long, value_parser = kinds(), default_value = "bench", requires = "inject", conflicts_with_all = ["folders", "power"])]
    kind: Sort,

    /// Runs that are made, of outcomes jumps [default: as many as is usual of the kind]
    #[arg(long, value_name = "COUNT", requires = "inject", conflicts_with_all = ["folders", "power"], value_parser = clap::value_parser!(u16).range(1..=500))]
    runs: Option<u16>,

    /// Write the runs that are made as MCAP files in place of CSV
    #[arg(long, requires = "inject", conflicts_with_all = ["folders", "power"])]
    mcap: bool,
}

/// Reads the kinds by their names, with what they are for the help.
fn kinds() -> impl TypedValueParser<Value = Sort> {
    let value = |sort: Sort| PossibleValue::new(sort.spec().id).help(sort.spec().description);
    PossibleValuesParser::new(Sort::ALL.map(value))
        .try_map(|id| Sort::named(&id).ok_or("one of the possible values"))
}

impl InjectFlags {
    /// Whether data are to be made.
    pub(super) fn is_set(&self) -> bool {
        !self.inject.is_empty()
    }

    fn effects(&self) -> Result<Vec<Effect>, CliError> {
        let asked: Vec<&String> = self.inject.iter().filter(|text| *text != "none").collect();
        if asked.len() < self.inject.len() && self.inject.len() > 1 {
            return Err(CliError::flag("--inject", "none", "the only one"));
        }
        Ok(asked
            .into_iter()
            .map(|text| text.parse())
            .collect::<Result<_, _>>()?)
    }

    /// Makes the data, and says what is hidden in them.
    pub(super) fn run(&self, command: &Diagnose) -> Result<Status, CliError> {
        let Some(folder) = command.output.out() else {
            return Err(CliError::Missing {
                flag: "--out",
                allowed: "a new or an empty folder for the data",
            });
        };
        reachable_folder(folder)?;
        let name = command.robot.as_deref().or(self.kind.spec().robot);
        let robot = name
            .map(|name| robot(name, &command.overrides))
            .transpose()?;
        let effects = self.effects()?;
        let mut made = inject::make(&Request {
            kind: self.kind,
            robot: robot.as_ref(),
            effects: &effects,
            seed: command.seed,
            runs: self.runs.map(usize::from),
            asked: &[],
        })?;
        let is_builtin = |name: &str| saltus::Robot::builtin_names().any(|known| known == name);
        // A robot of its own goes with the data.
        let own = robot
            .as_ref()
            .filter(|_| !command.overrides.is_empty() || !name.is_some_and(is_builtin));
        let listed = if own.is_some() { Some(OWN) } else { name };
        let listed = listed.filter(|_| self.kind.spec().robot.is_some());
        let more: Vec<(&str, String)> = own
            .map(|robot| (OWN, robot.to_toml()))
            .into_iter()
            .collect();
        let words = asked_for();
        let origin = Origin {
            command: &words,
            seed: Some(command.seed),
            robot: robot.as_ref(),
        };
        if self.mcap {
            for run in &mut made.experiment.runs {
                run.name = format!("{}.mcap", run.name.trim_end_matches(".csv"));
            }
        }
        experiment::write_from(folder, &made.experiment, listed, &more, &origin)?;
        let mut files = Files::default();
        files.report(
            None,
            match command.output.format() {
                Format::Json => output::json(&self.json(&made, command.seed)),
                Format::Csv => csv(&made.truth),
                Format::Text => self.text(&made, folder),
            },
        );
        files.write()?;
        Ok(Status::Done)
    }

    fn text(&self, made: &Made, folder: &std::path::Path) -> String {
        let (runs, rows) = size(made);
        let mut text = format!(
            "{}: {runs} runs, {rows} rows of kind {}\n",
            folder.display(),
            self.kind.spec().id
        );
        if made.truth.is_empty() {
            text.push_str("Nothing is hidden in them.\n");
        }
        for truth in &made.truth {
            let column = truth
                .column
                .as_ref()
                .map_or(String::new(), |column| format!(" of {column}"));
            let _ = write!(text, "Hidden: {}{column}", truth.id);
            for (name, value) in &truth.parameters {
                let _ = write!(text, ", {name} = {}", digits(*value, 9));
            }
            text.push('\n');
        }
        text
    }

    fn json(&self, made: &Made, seed: u64) -> Value {
        let entry = |truth: &Truth| {
            let parameters: Map<String, Value> = truth
                .parameters
                .iter()
                .map(|(name, value)| (name.clone(), json!(value)))
                .collect();
            json!({ "id": truth.id, "column": truth.column, "parameters": parameters })
        };
        let (runs, rows) = size(made);
        json!({
            "command": "diagnose --inject",
            "kind": self.kind.spec().id,
            "seed": seed,
            "runs": runs,
            "rows": rows,
            "causes": made.truth.iter().map(entry).collect::<Vec<_>>(),
        })
    }
}

fn size(made: &Made) -> (usize, usize) {
    let runs = &made.experiment.runs;
    (runs.len(), runs.iter().map(|run| run.time.len()).sum())
}

fn csv(truth: &[Truth]) -> String {
    let mut text = String::from("cause,column,parameter,value\n");
    for t in truth {
        let column = t.column.as_deref().unwrap_or_default();
        for (name, value) in &t.parameters {
            let _ = writeln!(text, "{},{column},{name},{value:?}", t.id);
        }
    }
    text
}
