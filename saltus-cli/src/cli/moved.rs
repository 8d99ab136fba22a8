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

/// A command, a flag or a value of a flag that the command line does not take any more.
struct Moved {
    /// The command.
    command: &'static str,
    /// The flag, or the flag and its value; empty for the whole command.
    words: &'static str,
    place: Place,
}

const fn moved(command: &'static str, words: &'static str, place: Place) -> Moved {
    Moved {
        command,
        words,
        place,
    }
}

const DESIGN: Place = Place::Now("saltus design PLAN.toml");

const BY_ERROR: Place = Place::Gone("jumps are integrated with an error of 1e-9 in each step");

const BEST_SEED: Place =
    Place::Gone("the best seed's policy is taken; `saltus learn --seed 7 --seeds 1` has one alone");

const MOVED: &[Moved] = &[
    moved("diagnose", "--power", DESIGN),
    moved("diagnose", "--effect", DESIGN),
    moved("diagnose", "--propose", DESIGN),
    moved(
        "diagnose",
        "--inject",
        Place::Now("saltus inject CAUSE=VALUE --out FOLDER"),
    ),
    moved(
        "diagnose",
        "--false-alarms",
        Place::Gone("5 % of data without an effect may be said to have one"),
    ),
    moved(
        "diagnose",
        "--samples",
        Place::Gone("each plan of --replan is flown 200 times"),
    ),
    moved(
        "plan",
        "--no-slip",
        Place::Gone("friction_coefficient in the course limits the friction that a stance needs"),
    ),
    moved(
        "verify",
        "--scatter",
        Place::Gone("[errors] of the robot says what is drawn, --samples 0 draws nothing"),
    ),
    moved("verify", "--accuracy", BY_ERROR),
    moved("verify", "--fixed-step", BY_ERROR),
    moved("run", "--policy-seed", BEST_SEED),
    moved("export", "--policy-seed", BEST_SEED),
    moved(
        "export",
        "--effort",
        Place::Gone("a squared second of open valve costs 0.01 m²/s²"),
    ),
    moved(
        "export",
        "--period",
        Place::Gone("it is that of the robot's sensors: --set sensors.period_ms=5"),
    ),
    moved(
        "filling",
        "--most",
        Place::Gone("the count ends at 10000 jumps"),
    ),
    moved(
        "jump",
        "--constant",
        Place::Study("landing_scatter -- 120 30 100"),
    ),
    moved(
        "jump",
        "--greatest",
        Place::Gone("try boxes and pressures in a loop: --set leg.supply_pressure_gauge_psi=160"),
    ),
];

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
    let is_asked = |moved: &&Moved| {
        let asked: Vec<&str> = moved.words.split_whitespace().collect();
        moved.command == command
            && (asked.is_empty() || words.windows(asked.len()).any(|some| some == asked))
    };
    let moved = MOVED.iter().find(is_asked)?;
    let asked = format!("{} {}", moved.command, moved.words);
    Some(CliError::Moved {
        asked: asked.trim_end().into(),
        place: moved.place,
    })
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
        for moved in MOVED {
            let line = format!("{} {}", moved.command, moved.words);
            let line: Vec<OsString> = line.split_whitespace().map(OsString::from).collect();
            let words = std::iter::once("saltus".into()).chain(line.iter().cloned());
            assert!(crate::cli::Cli::try_parse_from(words).is_err(), "{line:?}");
            let error = refused(&line).expect("listed").to_string();
            assert!(error.contains(&moved.place.to_string()), "{error}");
            if let Place::Study(study) = moved.place {
                let name = study.split_whitespace().next().expect("a name");
                let file = studies.join(format!("{name}.rs"));
                assert!(file.is_file() || studies.join(name).is_dir(), "{name}");
            }
        }
    }
}
