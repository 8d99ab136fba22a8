//! The command from another program, which gives it words and files and takes its answer.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

use clap::error::ErrorKind;

use crate::cli::{Cli, Status, Unparsed};
use crate::session::{self, Embedded, Session, Stop, Stopped};

/// What a command answers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Answer {
    /// Whether the answer is yes: exit code 0 in a shell, 1 otherwise.
    pub yes: bool,
    /// What would stand on standard output.
    pub report: String,
    /// What would stand on standard error.
    pub messages: Vec<String>,
}

/// Why there is no answer.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refused {
    /// Bad input: exit code 2 in a shell. The text is that of the command, without `error: `.
    #[error("{0}")]
    Input(String),
    /// The flag was raised.
    #[error("stopped")]
    Stopped,
}

/// Runs `words`, the command line without the program's name, on this thread.
///
/// `files` are robots, courses and tables by name: where a word names one of these, it is taken in
/// the place of a file. Work looks at `stop` many times a second, and ends soon after it is raised; files that it
/// was to write are then not there.
///
/// # Errors
/// [`Refused`].
///
/// # Example
/// ```
/// use std::collections::BTreeMap;
///
/// let words = ["simulate", "--omega", "5", "--alpha-f", "-0.1", "--format", "csv"];
/// let answer = saltus_cli::ask(&words.map(String::from), BTreeMap::new(), Default::default())?;
/// assert!(answer.report.starts_with("omega0_rad_s,phi0_rad"));
/// # Ok::<(), saltus_cli::Refused>(())
/// ```
pub fn ask(
    words: &[String],
    files: BTreeMap<String, String>,
    stop: Stop,
) -> Result<Answer, Refused> {
    let embedded = Embedded {
        files,
        stop,
        ..Embedded::default()
    };
    let session = Session {
        words: words.to_vec(),
        embedded: Some(embedded),
        ..Session::default()
    };
    let outer = session::with(|own| std::mem::replace(own, session));
    let came = catch_unwind(AssertUnwindSafe(|| run(words)));
    let session = session::with(|own| std::mem::replace(own, outer));
    let status = match came {
        Ok(status) => status?,
        Err(payload) if payload.is::<Stopped>() => return Err(Refused::Stopped),
        Err(payload) => resume_unwind(payload),
    };
    let Embedded {
        screen,
        messages,
        stop,
        ..
    } = session.embedded.unwrap_or_default();
    if status == Status::Interrupted && stop.load(std::sync::atomic::Ordering::Relaxed) {
        return Err(Refused::Stopped);
    }
    Ok(Answer {
        yes: status == Status::Done,
        report: String::from_utf8_lossy(&screen).into_owned(),
        messages,
    })
}

fn run(words: &[String]) -> Result<Status, Refused> {
    let words: Vec<OsString> = words.iter().map(OsString::from).collect();
    let cli = Cli::parsed(&words).map_err(|error| match error {
        Unparsed::Refused(error) => Refused::Input(short(&error)),
        Unparsed::Moved(error) => Refused::Input(error.to_string()),
    })?;
    cli.run().map_err(|error| Refused::Input(error.to_string()))
}

/// What is wrong with the words, without the usage of the command.
fn short(error: &clap::Error) -> String {
    let text = error.render().to_string();
    if matches!(
        error.kind(),
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion
    ) {
        return text;
    }
    let text = text.strip_prefix("error: ").unwrap_or(&text);
    let end = text
        .find("\n\nUsage:")
        .or(text.find("\n\nFor more information"));
    text[..end.unwrap_or(text.len())].trim_end().to_owned()
}
