//! Why a command could not be carried out. An answer that is no is not an error: see
//! [`Status`](crate::cli::Status).

use std::path::{Path, PathBuf};

use saltus::input::InputError;
pub(crate) use saltus::input::cut;
use saltus::planner::TableError;
use saltus::sim_check::SimError;
use saltus::{RobotError, StanceError};

/// Bad input, or a place that could not be read or written: exit code 2.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub(crate) enum CliError {
    /// The robot, its file or an override.
    #[error(transparent)]
    Robot(#[from] RobotError),
    /// A value of a flag, or flags that do not go together.
    #[error("{flag}{}{value}: must be {allowed}", if value.is_empty() { "" } else { " " })]
    Flag {
        /// The flag as typed.
        flag: &'static str,
        /// Its value.
        value: String,
        /// What is allowed.
        allowed: String,
    },
    /// A flag without which the command has nothing to do.
    #[error("{flag} is missing: {allowed}")]
    Missing {
        /// The flag.
        flag: &'static str,
        /// What it takes.
        allowed: &'static str,
    },
    /// A part of the command that has moved.
    #[error("{asked} {place}")]
    Moved {
        /// The command, the flag or the value.
        asked: String,
        /// Where it is.
        place: String,
    },
    /// A value in a file.
    #[error("{file}:{line}: {key} = {value}: must be {allowed}")]
    Value {
        /// The file.
        file: String,
        /// Line, from 1.
        line: u64,
        /// Column or key.
        key: String,
        /// The value as written; a long one is cut.
        value: String,
        /// What is allowed.
        allowed: String,
    },
    /// A file that is not what it should be, or cannot be read.
    #[error(transparent)]
    Input(#[from] InputError),
    /// A jump that cannot be computed.
    #[error("{jump}: {source}")]
    Jump {
        /// Which one.
        jump: String,
        /// Why not.
        source: StanceError,
    },
    /// A jump that cannot be verified.
    #[error(transparent)]
    Trial(#[from] saltus::verify::TrialError),
    /// Tables for a controller.
    #[error("export: {0}")]
    Export(#[from] saltus::export::ExportError),
    /// What the planner does not take.
    #[error(transparent)]
    Request(#[from] TableError),
    /// Measured data.
    #[error(transparent)]
    Experiment(#[from] saltus::experiment::Error),
    /// A planned experiment.
    #[error(transparent)]
    Plan(#[from] saltus::experiment::PlanError),
    /// What was learnt before.
    #[error(transparent)]
    Policy(#[from] saltus::learning::PolicyError),
    /// Synthetic data.
    #[error(transparent)]
    Inject(#[from] saltus::inject::Error),
    /// A robot that cannot be a rig of bodies.
    #[error(transparent)]
    Rig(#[from] SimError),
    /// A file or stream that the system does not let us write.
    #[error("{}: cannot be written: {source}", file.display())]
    Write {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A plot that cannot be drawn.
    #[error("{}: cannot be drawn: {reason}", file.display())]
    Plot {
        /// The file.
        file: PathBuf,
        /// Why not.
        reason: String,
    },
}

impl CliError {
    /// Exit code of every error.
    pub(crate) const EXIT: u8 = 2;

    #[allow(clippy::needless_pass_by_value)] // A reference shows itself just as well.
    pub(crate) fn flag(
        flag: &'static str,
        value: impl ToString,
        allowed: impl Into<String>,
    ) -> CliError {
        CliError::Flag {
            flag,
            value: value.to_string(),
            allowed: allowed.into(),
        }
    }

    /// Refuses the flags that are given where they mean nothing.
    pub(crate) fn unused(given: &[(&'static str, bool)], allowed: &str) -> Result<(), CliError> {
        match given.iter().find(|(_, is_given)| *is_given) {
            Some((flag, _)) => Err(CliError::flag(flag, "", allowed)),
            None => Ok(()),
        }
    }

    pub(crate) fn content(file: impl ToString, reason: impl ToString) -> CliError {
        InputError::content(file, reason).into()
    }

    pub(crate) fn write(file: &Path, source: std::io::Error) -> CliError {
        CliError::Write {
            file: file.into(),
            source,
        }
    }
}
