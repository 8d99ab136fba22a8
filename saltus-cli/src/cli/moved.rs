//! What was a part of the command once: a user who asks for it is told where it is.

use std::borrow::Cow;
use std::ffi::OsString;
use std::fmt;

use crate::error::CliError;

/// Where a part of the command has gone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    /// A program of `studies/`, by its name and arguments.
    Study(&'static str),
    /// Another command line.
    Now(&'static str),
    /// Nowhere; what to do instead.
    Gone(&'static str),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::Study(study) => write!(
                f,
                "is a study now: in the repository, cd studies && cargo run --release --bin {study}"
            ),
            Place::Now(line) => write!(f, "is another command now: {line}"),
            Place::Gone(instead) => write!(f, "is gone: {instead}"),
        }
    }
}

/// A command line that is not taken any more: the command, the flag or the flag and its value (empty for the whole command),
/// and where it is.
type Moved = (&'static str, &'static str, Place);

const MOVED: &[Moved] = &[
    to_study("jump", "--target", "ball_jump 0.3,0.2"),
    to_study("jump", "--heading", "ball_jump 0.3,0.2"),
    to_study("jump", "--rest", "ball_jump 0.3,0.2"),
    to_study("jump", "--map", "ball_jump map 0.2"),
    to_study("jump", "--onto", "over_box 0.12 2.2 2.2 16 3 100 onto"),
    to_study("jump", "--constant", "box"),
    gone(
        "jump",
        "--greatest",
        "try boxes and pressures in a loop: --set leg.supply_pressure_gauge_psi=160",
    ),
    gone("jump", "--plot", "there is nothing to draw of a box"),
    to_study("run", "--bears", "bears steer 40 bears-steer.svg"),
    to_study("run", "--analyse", "analyse"),
    to_study("run", "--gait optimal", "optimal 3 1.6 0.9 100"),
    to_study("export", "--gait optimal", "optimal 3 1.6 0.9 100"),
    to_study("learn", "--algorithm bayes", "few_strides 30 60"),
    to_study("learn", "--algorithm cma-es", "few_strides 30 60"),
    to_study("learn", "--algorithm hill-climbing", "hill_climbing 30 500"),
    to_study("learn", "--tilings", "seen_states 30 500"),
    to_study("learn", "--replacing", "seen_states 30 500"),
    to_study("parkour", "", "parkour INSTANCES.json"),
    gone(
        "export",
        "--as",
        "saltus export policy writes C99, which a program in Rust links",
    ),
    gone(
        "run",
        "--policy-seed",
        "the best seed runs; `saltus learn --seed 7 --seeds 1` has one alone",
    ),
    gone(
        "export",
        "--policy-seed",
        "the best seed is written; `saltus learn --seed 7 --seeds 1` has one alone",
    ),
    gone(
        "export",
        "--effort",
        "a squared second of open valve costs 0.01 m²/s²",
    ),
    gone(
        "export",
        "--period",
        "it is that of the robot's sensors: --set sensors.period_ms=5",
    ),
    gone("diagnose", "--plot", "the page of --report has the charts"),
    to_command("diagnose", "--power", "saltus design PLAN.toml"),
    to_command(
        "diagnose",
        "--effect",
        "saltus design PLAN.toml --effect CAUSE=VALUE",
    ),
    to_command(
        "diagnose",
        "--propose",
        "saltus design PLAN.toml --propose COUNT",
    ),
    to_command(
        "diagnose",
        "--inject",
        "saltus inject CAUSE=VALUE --out FOLDER",
    ),
    gone(
        "diagnose",
        "--false-alarms",
        "5 % of data without an effect may be said to have one",
    ),
    gone(
        "diagnose",
        "--samples",
        "each plan of --replan is flown 200 times",
    ),
    gone(
        "plan",
        "--no-slip",
        "friction_coefficient in the course limits what a stance needs",
    ),
    gone(
        "verify",
        "--scatter",
        "[errors] of the robot says what is drawn",
    ),
    gone(
        "verify",
        "--accuracy",
        "jumps are integrated with an error of 1e-9 in each step",
    ),
    gone(
        "verify",
        "--fixed-step",
        "jumps are integrated with an error of 1e-9 in each step",
    ),
    gone("filling", "--most", "the count ends at 10000 jumps"),
];

/// What is a study now.
const fn to_study(command: &'static str, words: &'static str, study: &'static str) -> Moved {
    (command, words, Place::Study(study))
}

/// What another command line does.
const fn to_command(command: &'static str, words: &'static str, line: &'static str) -> Moved {
    (command, words, Place::Now(line))
}

/// What nothing does.
const fn gone(command: &'static str, words: &'static str, instead: &'static str) -> Moved {
    (command, words, Place::Gone(instead))
}

/// That a command line which could not be parsed asks for something that has moved.
pub(crate) fn refused(line: &[OsString]) -> Option<CliError> {
    let line: Vec<Cow<str>> = line.iter().map(|word| word.to_string_lossy()).collect();
    let (command, rest) = line.split_first()?;
    // `--flag=value` is `--flag value`.
    let words: Vec<&str> = rest
        .iter()
        .flat_map(|word| match word.split_once('=') {
            Some((flag, value)) if flag.starts_with("--") => vec![flag, value],
            _ => vec![word.as_ref()],
        })
        .collect();
    let is_asked = |(of, asked, _): &&Moved| {
        let asked: Vec<&str> = asked.split_whitespace().collect();
        *of == command && (asked.is_empty() || words.windows(asked.len()).any(|some| some == asked))
    };
    let (command, words, place) = *MOVED.iter().find(is_asked)?;
    let asked = format!("{command} {words}").trim_end().into();
    Some(CliError::Moved { asked, place })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use clap::Parser;

    use super::*;

    /// Nothing that is listed is taken, each is told where it is, and each study is there.
    #[test]
    fn who_asks_for_what_moved_is_told_where_it_is() {
        let studies = Path::new(env!("CARGO_MANIFEST_DIR")).join("../studies/src/bin");
        for (command, words, place) in MOVED {
            let line = format!("{command} {words}");
            let line: Vec<OsString> = line.split_whitespace().map(OsString::from).collect();
            let words = std::iter::once("saltus".into()).chain(line.iter().cloned());
            assert!(crate::cli::Cli::try_parse_from(words).is_err(), "{line:?}");
            let error = refused(&line).expect("listed").to_string();
            assert!(error.contains(&place.to_string()), "{error}");
            if let Place::Study(study) = place {
                let name = study.split_whitespace().next().expect("a name");
                let file = studies.join(format!("{name}.rs"));
                assert!(file.is_file() || studies.join(name).is_dir(), "{name}");
            }
        }
    }
}
