//! What every command takes: the robot, and where the answer goes.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use clap::Args;
use saltus::Robot;

use crate::error::CliError;
use crate::output::{Files, Format};
use crate::plot::{Drawing, PlotFile};

/// Which robot.
#[derive(Args, Debug)]
#[command(next_help_heading = "Robot and output")]
pub(crate) struct RobotFlags {
    /// Robot: a built-in one (rats-planar, rats-boom, spring-hopper, table-hopper) or a TOML file
    #[arg(long, value_name = "NAME|FILE", default_value = "rats-planar")]
    robot: String,

    /// Override a parameter of the robot by its dotted key, as in leg.stroke_m=0.05; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
}

impl RobotFlags {
    /// The robot with its overrides.
    pub(crate) fn robot(&self) -> Result<Robot, CliError> {
        Ok(saltus::resolve(&self.robot, &self.overrides)?)
    }
}

/// Options of every command that reports.
#[derive(Args, Debug)]
#[command(next_help_heading = "Robot and output")]
pub(crate) struct Common {
    #[command(flatten)]
    robot: RobotFlags,

    #[command(flatten)]
    output: OutputFlags,
}

/// Where the answer goes.
#[derive(Args, Debug)]
#[command(next_help_heading = "Robot and output")]
pub(crate) struct OutputFlags {
    /// Format of the report; without it as --out's ending says (.json, .csv), else text
    #[arg(long, value_enum)]
    format: Option<Format>,

    /// Write the report to this file instead of standard output
    #[arg(long, short, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// The option of commands with much to compute.
#[derive(Args, Debug)]
pub(crate) struct Threads {
    /// Threads to work with; the answer does not depend on it [default: as many as the machine has]
    #[arg(long, value_name = "COUNT", help_heading = "Robot and output")]
    threads: Option<NonZeroUsize>,
}

impl Threads {
    /// Most threads that are of use.
    const MOST: usize = 256;

    /// How many.
    pub(crate) fn count(&self) -> NonZeroUsize {
        let most = NonZeroUsize::MIN.saturating_add(Threads::MOST - 1);
        self.threads
            .or_else(|| std::thread::available_parallelism().ok())
            .unwrap_or(NonZeroUsize::MIN)
            .min(most)
    }
}

/// The option of commands with something to see.
#[derive(Args, Debug)]
#[command(next_help_heading = "Robot and output")]
pub(crate) struct PlotOption {
    /// Draw the answer to this file, .svg or .png
    #[arg(long, value_name = "FILE.svg|FILE.png", value_parser = PlotFile::parse)]
    plot: Option<PlotFile>,
}

impl PlotOption {
    /// Whether a plot is asked for.
    pub(crate) fn is_set(&self) -> bool {
        self.plot.is_some()
    }
}

impl Common {
    /// The robot with its overrides.
    pub(crate) fn robot(&self) -> Result<Robot, CliError> {
        self.robot.robot()
    }

    /// The robot with its overrides and `more`.
    pub(crate) fn robot_with(&self, more: &[String]) -> Result<Robot, CliError> {
        Ok(saltus::resolve(&self.robot.robot, &[self.robot.overrides.as_slice(), more].concat())?)
    }
}

impl std::ops::Deref for Common {
    type Target = OutputFlags;
    fn deref(&self) -> &OutputFlags {
        &self.output
    }
}

impl OutputFlags {
    /// The format asked for.
    pub(crate) fn format(&self) -> Format {
        let by_name = || self.out.as_deref().and_then(Format::of_file);
        self.format.or_else(by_name).unwrap_or(Format::Text)
    }

    /// The format, where a flag asks for one.
    pub(crate) fn asked(&self) -> Option<Format> {
        self.format
    }

    /// Where the answer goes, if not to standard output.
    pub(crate) fn out(&self) -> Option<&Path> {
        self.out.as_deref()
    }

    /// Writes the report alone.
    pub(crate) fn write_report(&self, report: String) -> Result<(), CliError> {
        let mut files = Files::default();
        files.report(self.out.as_deref(), report);
        files.write()
    }

    /// Writes the report and the plot, if one is asked for: both or neither.
    pub(crate) fn write_with_plot(
        &self,
        report: String,
        option: &PlotOption,
        drawing: impl FnOnce() -> Result<Drawing, CliError>,
    ) -> Result<(), CliError> {
        self.write_with(report, option, drawing, None)
    }

    /// As [`write_with_plot`](Self::write_with_plot), with one page more: its flag, file and text.
    pub(crate) fn write_with(
        &self,
        report: String,
        option: &PlotOption,
        drawing: impl FnOnce() -> Result<Drawing, CliError>,
        page: Option<(&'static str, &Path, String)>,
    ) -> Result<(), CliError> {
        let mut files = Files::default();
        if let Some(plot) = &option.plot {
            self.check_distinct("--plot", plot.path())?;
            files.add(plot.path(), plot.draw(&drawing()?)?);
        }
        if let Some((flag, path, html)) = page {
            self.check_distinct(flag, path)?;
            files.add(path, html.into_bytes());
        }
        files.report(self.out.as_deref(), report);
        files.write()
    }

    fn check_distinct(&self, flag: &'static str, file: &Path) -> Result<(), CliError> {
        match &self.out {
            Some(out) if out == file => Err(CliError::flag(flag, file.display(), "another file than --out")),
            _ => Ok(()),
        }
    }
}

/// Parser of a flag.
pub(crate) fn page_file(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let is_page = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("html"));
    if is_page { Ok(path) } else { Err("the name must end in .html".into()) }
}
