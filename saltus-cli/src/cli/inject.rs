//! `saltus inject`: synthetic data with hidden effects.

use std::fmt::Write;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use saltus::diagnosis::Sort;
use saltus::experiment;
use saltus::inject::{self, Effect, Made, Request, Truth};
use saltus::recording::Origin;
use serde_json::{Value, json};

use super::Status;
use super::common::{FormatFlag, OutFolder, RobotFlags, Seed};
use super::recorded::command as asked_for;
use crate::error::CliError;
use crate::output::{self, Column, Format, Table, columns, counted, digits, print};

/// The file of a robot that goes with the data.
const OWN: &str = "robot.toml";

/// Make measured data with known effects hidden in them, on which a diagnosis can be tried
#[derive(Args, Debug)]
#[command(
    after_help = "`saltus inject --help` explains the output.",
    after_long_help = LONG_HELP,
    mut_arg("robot", |robot| robot.help("Robot that the operator believes is measured: a built-in one or a TOML file [default: that of the kind]")),
    mut_arg("format", |format| format.help("Format of the report [default: text]")),
    mut_arg("out", |out| out.help("Write the data to this folder, a new or an empty one"))
)]
pub(crate) struct Inject {
    /// Effects that are hidden in the data; none: nothing is hidden
    #[arg(value_name = "CAUSE=VALUE")]
    effects: Vec<Effect>,

    /// Kind of the data
    #[arg(long, value_parser = kinds(), default_value = "bench")]
    kind: Sort,

    /// Runs, of outcomes jumps [default: as many as is usual of the kind]
    #[arg(long, value_name = "COUNT", allow_negative_numbers = true, value_parser = clap::value_parser!(u16).range(1..=500))]
    runs: Option<u16>,

    /// Write the runs as MCAP files in place of CSV
    #[arg(long)]
    mcap: bool,

    #[command(flatten)]
    seed: Seed,

    #[command(flatten)]
    robot: RobotFlags,

    #[command(flatten)]
    format: FormatFlag,

    #[command(flatten)]
    out: OutFolder,
}

const LONG_HELP: &str = "\
Examples:
  saltus inject coulomb-friction=25 --out synthetic
  saltus inject encoder-scale=wheel_angle_rad:1.02 axle-friction=0.3 --kind jump --out both

The report says what is hidden in the data; their folder does not. CAUSE is an id, VALUE its parameter in the unit of its name, \
several with commas; of a sensor COLUMN:VALUE. A CAUSE that the kind does not have is answered with a list of those that it has. \
docs/logs.md has the format of the data.

JSON: {\"command\": \"inject\", \"kind\", \"seed\", \"runs\", \"rows\", \"causes\": [{\"id\", \"column\", \"parameters\"}]}.

CSV columns, one row for each parameter: cause (the id), column, parameter, value.";

/// Reads the kinds by their names, with what they are for the help.
fn kinds() -> impl TypedValueParser<Value = Sort> {
    let value = |sort: Sort| PossibleValue::new(sort.spec().id).help(sort.spec().description);
    PossibleValuesParser::new(Sort::ALL.map(value))
        .try_map(|id| Sort::named(&id).ok_or("one of the possible values"))
}

impl Inject {
    pub(crate) fn run(self) -> Result<Status, CliError> {
        self.out.ready()?;
        let usual = self.kind.spec().robot;
        let robot = self.robot.robot_if_any(usual.map(str::to_owned))?;
        let mut made = inject::make(&Request {
            kind: self.kind,
            robot: robot.as_ref(),
            effects: &self.effects,
            seed: self.seed.seed,
            runs: self.runs.map(usize::from),
            asked: &[],
        })?;
        // A robot of its own goes with the data.
        let name = self.robot.name().or(usual);
        let is_builtin = |name| saltus::Robot::builtin_names().any(|known| known == name);
        let is_own = !self.robot.overrides().is_empty() || !name.is_some_and(is_builtin);
        let own = robot.as_ref().filter(|_| is_own);
        let listed = if own.is_some() { Some(OWN) } else { name };
        let listed = listed.filter(|_| usual.is_some());
        let more: Vec<(&str, String)> = own
            .map(|robot| (OWN, robot.to_toml()))
            .into_iter()
            .collect();
        let words = asked_for();
        let origin = Origin {
            command: &words,
            seed: Some(self.seed.seed),
            robot: robot.as_ref(),
        };
        if self.mcap {
            for run in &mut made.experiment.runs {
                run.name = format!("{}.mcap", run.name.trim_end_matches(".csv"));
            }
        }
        let folder = self.out.path();
        experiment::write_from(folder, &made.experiment, listed, &more, &origin)?;
        print(&match self.format.asked() {
            Some(Format::Json) => output::json(&self.json(&made)),
            Some(Format::Csv) => csv(&made.truth),
            _ => self.text(&made),
        })?;
        Ok(Status::Done)
    }

    fn text(&self, made: &Made) -> String {
        let (runs, rows) = size(made);
        let mut text = format!(
            "{}: {}, {} of kind {}\n",
            self.out.path().display(),
            counted(runs, "run"),
            counted(rows, "row"),
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

    fn json(&self, made: &Made) -> Value {
        let entry = |truth: &Truth| {
            let parameters: Value = truth.parameters.iter().cloned().collect();
            json!({ "id": truth.id, "column": truth.column, "parameters": parameters })
        };
        let (runs, rows) = size(made);
        json!({
            "command": "inject",
            "kind": self.kind.spec().id,
            "seed": self.seed.seed,
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

/// A row for each parameter of an effect.
fn csv(truth: &[Truth]) -> String {
    let columns: [Column<(&Truth, &(String, f64))>; 4] = columns! {
        "cause", "", |(it, _)| it.id;
        "column", "", |(it, _)| it.column.clone();
        "parameter", "", |(_, it)| it.0.clone();
        "value", "", |(_, it)| it.1;
    };
    let rows = truth
        .iter()
        .flat_map(|it| it.parameters.iter().map(move |value| (it, value)));
    Table::of(&columns, rows).csv()
}
