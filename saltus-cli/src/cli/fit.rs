//! `saltus fit`: parameters of a leg from benchtop firings.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use saltus::Robot;
use saltus::diagnosis::{Combination, Estimated as Parameter, Undetermined, disbelieve};
use saltus::experiment::{self, Folder};
use saltus::fit::{self, Fitted, USUAL};
use serde_json::{Value, json};

use super::Status;
use super::common::{OutputFlags, RobotFlags, read_folders};
use super::diagnose::words;
use crate::error::CliError;
use crate::output::{
    self, Column, Files, Format, Table, columns, counted, digits, reachable, unit,
};
use crate::progress::Progress;
use crate::slip::{Estimated, slip};

/// Fit the parameters of a leg to benchtop firings, with standard errors and what the data do not
/// tell
#[derive(Args, Debug)]
#[command(
    after_help = "`saltus fit --help` explains data and output.",
    after_long_help = LONG_HELP,
    mut_arg("robot", |robot| robot.help("Robot that is believed to have been measured, in place of the folder's: a built-in one or a TOML file"))
)]
pub(crate) struct Fit {
    /// Data folders of kind bench: an experiment.toml and a CSV file for each firing
    #[arg(value_name = "FOLDER", required = true)]
    folders: Vec<PathBuf>,

    /// Parameters that are fitted at the same time, as keys of a robot file [default: those of the
    /// thesis' table 4.2]
    #[arg(long, value_name = "KEY,KEY,…", value_delimiter = ',')]
    parameters: Vec<String>,

    /// Write the robot with the fitted leg to this file
    #[arg(long, value_name = "FILE.toml")]
    robot_out: Option<PathBuf>,

    #[command(flatten)]
    robot: RobotFlags,

    #[command(flatten)]
    output: OutputFlags,
}

const LONG_HELP: &str = "\
Examples:
  saltus fit bench/monday
  saltus fit bench/monday bench/tuesday --robot-out fitted.toml --format json
  saltus fit bench/monday --parameters leg.discharge_coefficient,leg.orifice_radius_m
  saltus inject valve-discharge=0.5 --out synthetic && saltus fit synthetic

Data are those of `saltus diagnose`, of kind bench. All parameters are fitted at the same time, by least squares in which single bad \
readings count little. --parameters takes leg.discharge_coefficient, leg.orifice_radius_m, leg.dead_volume_m3, leg.valve_delay_s, \
leg.viscous_friction_n_s_per_m, leg.coulomb_friction_n and the keys of every other effect that the bench can show (a wrong name \
lists them); without it the first and the third to the sixth of these are fitted.

What the data do not tell has no standard error. Of two parameters that only show as a product, the product is reported: gas flows in \
proportion to the discharge coefficient times the square of the orifice's radius, and nothing else depends on either. Standard errors \
count in that residuals can be larger than the stated noise, and that neighbouring ones are alike (inflation, 1 for white noise as stated).

CSV columns, one row for each parameter and each product that is known in its place: parameter, believed, value, standard_error \
(empty: not determined), at_bound (true where physics allows no more).

JSON: {\"command\": \"fit\", \"robot\": NAME, \"data\": {\"hash\", \"rows\", \"runs\", \"notes\"}, \"parameters\": [{\"name\", \"believed\", \
\"value\", \"standard_error\" (or null), \"at_bound\", \"slip\" (null, or what slip of unit it equals)}], \"correlation\": [[…]], \"undetermined\": [{\"together\": {NAME: relative change}, \
\"determined\": {\"combination\", \"exponents\", \"value\", \"standard_error\"} or null}], \"residuals\": [{\"channel\", \"rms_before\", \
\"rms_after\", \"noise\"}], \"inflation\": …}.

The exit code is 1 if the data do not determine every parameter.";

/// A parameter or a product of parameters.
struct Fitting {
    name: String,
    believed: f64,
    value: f64,
    error: Option<f64>,
    is_at_bound: bool,
}

const COLUMNS: [Column<Fitting>; 5] = columns! {
    "parameter", "", |it| it.name.clone();
    "believed", "", |it| it.believed;
    "value", "", |it| it.value;
    "standard_error", "", |it| it.error;
    "at_bound", "", |it| it.is_at_bound;
};

/// A fit with what it is of.
struct Report<'a> {
    folder: &'a Folder,
    believed: &'a Robot,
    fitted: &'a Fitted,
}

impl Fit {
    pub(crate) fn run(self) -> Result<Status, CliError> {
        self.output.report_ready()?;
        reachable("--robot-out", self.robot_out.as_deref())?;
        let mut folder = read_folders(&self.folders)?;
        let misstated = disbelieve(&mut folder.experiment);
        folder.notes.extend(misstated.iter().map(words::misstated));
        let unusable = |reason: String| CliError::content(folder.path.display(), reason);
        let believed = self.robot.robot_if_any(folder.robot_name())?;
        let believed = believed.ok_or(CliError::Missing {
            flag: "--robot",
            allowed: "the robot that was measured",
        })?;
        experiment::plausible(&folder, Some(&believed))?;
        let names: Vec<String> = match self.parameters.as_slice() {
            [] => USUAL.map(str::to_owned).into(),
            names => names.iter().map(|name| name.trim().to_owned()).collect(),
        };
        let progress = Progress::new("fit", 0);
        let fitted = fit::fit(&folder.experiment, &believed, &names);
        drop(progress);
        let fitted = fitted.map_err(|error| match error {
            fit::Error::Parameter { name, known } => {
                CliError::flag("--parameters", name, format!("of {}", known.join(", ")))
            }
            fit::Error::Twice { name } => {
                CliError::flag("--parameters", name, "parameters, each once")
            }
            other => unusable(other.to_string()),
        })?;
        let report = Report {
            folder: &folder,
            believed: &believed,
            fitted: &fitted,
        };
        let text = match self.output.format() {
            Format::Text => report.text(),
            Format::Json => output::json(&report.json()),
            Format::Csv => report.table().csv(),
        };
        let mut files = Files::default();
        if let Some(path) = &self.robot_out {
            files.add("--robot-out", path, report.robot().into_bytes());
        }
        files.report(self.output.out(), text);
        files.write()?;
        Ok(Status::of(fitted.estimate.undetermined.is_empty()))
    }
}

/// What slip of unit a fitted parameter equals.
fn slip_of(p: &Parameter) -> Option<String> {
    let error = p.error.unwrap_or(f64::NAN);
    slip(&Estimated {
        unit: unit(&p.name),
        believed: p.believed,
        value: p.value,
        error,
        is_gain: false,
    })
}

impl Report<'_> {
    fn name(&self, parameter: usize) -> &str {
        &self.fitted.estimate.parameters[parameter].name
    }

    /// A product in words.
    fn words(&self, known: &Combination) -> String {
        let power = |&(i, exponent): &(usize, f64)| match exponent {
            1.0 => self.name(i).to_owned(),
            2.0 => format!("{}²", self.name(i)),
            _ => format!("{}^{}", self.name(i), digits(exponent, 3)),
        };
        known
            .exponents
            .iter()
            .map(power)
            .collect::<Vec<_>>()
            .join(" · ")
    }

    fn unknown(&self, direction: &Undetermined) -> String {
        if let Some(known) = &direction.known {
            let (value, error) = (digits(known.value, 6), digits(known.error, 2));
            return format!(
                "only {} is determined: {value} ± {error}",
                self.words(known)
            );
        }
        let part = |&(i, part): &(usize, f64)| format!("{} by {}", self.name(i), digits(part, 2));
        let parts: Vec<String> = direction.parts.iter().map(part).collect();
        match parts.as_slice() {
            [_] => format!("{} is not determined", self.name(direction.parts[0].0)),
            _ => format!(
                "not determined is the direction of relative changes {}",
                parts.join(", ")
            ),
        }
    }

    /// For people.
    fn text(&self) -> String {
        let Report {
            folder,
            believed,
            fitted,
        } = self;
        let estimate = &fitted.estimate;
        // Writing into a string does not fail.
        let mut out = format!(
            "{}: leg fitted to {}, {}; data {}\n",
            believed.name,
            counted(folder.experiment.runs.len(), "firing"),
            counted(folder.rows, "row"),
            folder.hash
        );
        for note in &folder.notes {
            let _ = writeln!(out, "note: {note}");
        }
        let wide = estimate
            .parameters
            .iter()
            .map(|p| p.name.len())
            .max()
            .unwrap_or_default()
            .max(9);
        let _ = writeln!(
            out,
            "\n  {:<wide$}  {:>11}  {:>11}  {:>9}",
            "parameter", "believed", "fitted", "±"
        );
        for p in &estimate.parameters {
            let error = p.error.map_or("–".into(), |error| digits(error, 2));
            let bound = if p.is_at_bound {
                "  as far as physics allows"
            } else {
                ""
            };
            let (name, was, is) = (&p.name, digits(p.believed, 5), digits(p.value, 5));
            let slip = slip_of(p).map_or(String::new(), |slip| format!("  {slip}"));
            let _ = writeln!(
                out,
                "  {name:<wide$}  {was:>11}  {is:>11}  {error:>9}{bound}{slip}"
            );
        }
        for direction in &estimate.undetermined {
            let _ = writeln!(
                out,
                "\nThe data do not tell all of these: {}.",
                self.unknown(direction)
            );
        }
        if estimate.parameters.len() > 1 {
            let _ = writeln!(out, "\nCorrelation of the errors, in this order:");
            for row in &estimate.correlation {
                let cells: Vec<String> = row.iter().map(|c| format!("{c:>6.2}")).collect();
                let _ = writeln!(out, "  {}", cells.join(" "));
            }
        }
        let _ = writeln!(out, "\nResiduals (root mean square):");
        for r in &estimate.residuals {
            let (before, after, noise) =
                (digits(r.before, 3), digits(r.after, 3), digits(r.noise, 3));
            let _ = writeln!(
                out,
                "  {}: {before} before, {after} after, noise {noise}",
                r.channel
            );
        }
        if estimate.inflation > 1.5 {
            let factor = digits(estimate.inflation.sqrt(), 2);
            let _ = writeln!(
                out,
                "Residuals are larger or more alike than white noise as stated: standard errors \
                 are {factor} times as large for it."
            );
        }
        out
    }

    /// For programs.
    fn json(&self) -> Value {
        let Report {
            folder,
            believed,
            fitted,
        } = self;
        let estimate = &fitted.estimate;
        let parameters = estimate.parameters.iter().map(|p| {
            json!({
                "name": p.name,
                "believed": p.believed,
                "value": p.value,
                "standard_error": p.error,
                "at_bound": p.is_at_bound,
                "slip": slip_of(p),
            })
        });
        let named = |parts: &[(usize, f64)]| -> Value {
            parts
                .iter()
                .map(|&(i, part)| (self.name(i), part))
                .collect()
        };
        let undetermined = estimate.undetermined.iter().map(|direction| {
            let known = direction.known.as_ref().map(|known| {
                json!({
                    "combination": self.words(known),
                    "exponents": named(&known.exponents),
                    "value": known.value,
                    "standard_error": known.error,
                })
            });
            json!({ "together": named(&direction.parts), "determined": known })
        });
        let residuals = estimate.residuals.iter().map(|r| {
            json!({ "channel": r.channel, "rms_before": r.before, "rms_after": r.after, "noise": r.noise })
        });
        json!({
            "command": "fit",
            "robot": believed.name,
            "data": {
                "hash": folder.hash,
                "rows": folder.rows,
                "runs": folder.experiment.runs.len(),
                "notes": folder.notes,
            },
            "parameters": parameters.collect::<Vec<_>>(),
            "correlation": estimate.correlation,
            "undetermined": undetermined.collect::<Vec<_>>(),
            "residuals": residuals.collect::<Vec<_>>(),
            "inflation": estimate.inflation,
        })
    }

    /// A row for each parameter and each product that is known in its place.
    fn table(&self) -> Table {
        let estimate = &self.fitted.estimate;
        let mut rows: Vec<Fitting> = estimate
            .parameters
            .iter()
            .map(|p| Fitting {
                name: p.name.clone(),
                believed: p.believed,
                value: p.value,
                error: p.error,
                is_at_bound: p.is_at_bound,
            })
            .collect();
        let known = estimate
            .undetermined
            .iter()
            .filter_map(|it| it.known.as_ref());
        rows.extend(known.map(|known| {
            Fitting {
                name: self.words(known),
                believed: known
                    .exponents
                    .iter()
                    .map(|&(i, e)| estimate.parameters[i].believed.powf(e))
                    .product(),
                value: known.value,
                error: Some(known.error),
                is_at_bound: false,
            }
        }));
        Table::of(&COLUMNS, rows)
    }

    /// The robot with the fitted leg, as a file that says where it is from.
    fn robot(&self) -> String {
        let Report { folder, fitted, .. } = self;
        let mut text = format!(
            "# Fitted by `saltus fit` to {}, data {}:\n",
            Path::new(folder.path.file_name().unwrap_or(folder.path.as_os_str())).display(),
            folder.hash
        );
        for p in &fitted.estimate.parameters {
            let error = p.error.map_or("not determined alone".into(), |error| {
                format!("± {}", digits(error, 2))
            });
            let _ = writeln!(
                text,
                "# {} = {} {error}, in place of {}",
                p.name,
                digits(p.value, 6),
                digits(p.believed, 6)
            );
        }
        for direction in &fitted.estimate.undetermined {
            let _ = writeln!(text, "# {}", self.unknown(direction));
        }
        text + "\n" + &fitted.robot.to_toml()
    }
}
