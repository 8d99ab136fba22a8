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
    /// Another command line; `{X}` stands for what follows the flag, X if nothing does, and `…` for the
    /// other words.
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
            Place::Now(line) => write!(f, "is another command now: {}", typed(line, None, &[])),
            Place::Gone(instead) => write!(f, "is gone: {instead}"),
        }
    }
}

/// What the command line does not take any more, a line each: a command, a flag or a flag and its
/// value, and where it is.
const MOVED: &str = "\
jump --target -> study ball_jump 0.3,0.2
jump --heading -> study ball_jump 0.3,0.2
jump --rest -> study ball_jump 0.3,0.2
jump --map -> study ball_jump map 0.2
jump --onto -> study over_box 0.12 2.2 2.2 16 3 100 onto
jump --constant -> study box
jump --greatest -> gone try boxes and pressures in a loop: --set leg.supply_pressure_gauge_psi=160
jump --plot -> gone there is nothing to draw of a box
run --bears -> study bears steer 40 bears-steer.svg
run --analyse -> study analyse
run optimal -> study optimal 3 1.6 0.9 100
run --gait -> now saltus run {closed-loop} …
run --policy -> now saltus run policy {FILE.json} …
run --policy-seed -> gone the best seed runs; `saltus learn --seed 7 --seeds 1` has one alone
learn --algorithm bayes -> study few_strides 30 60
learn --algorithm cma-es -> study few_strides 30 60
learn --algorithm hill-climbing -> study hill_climbing 30 500
learn --tilings -> study seen_states 30 500
learn --animate -> now saltus run policy FILE.json --animate {FILE.html}
learn --shown -> gone `saltus learn --episodes 4` stops there: its policy can be run
learn --replacing -> study seen_states 30 500
parkour -> study parkour
export optimal -> study optimal 3 1.6 0.9 100
export --gait -> now saltus export gait {closed-loop} …
export --as -> gone saltus export policy writes C99, which a program in Rust links
export --policy-seed -> gone the best seed is written; `saltus learn --seed 7 --seeds 1` has one alone
export --effort -> gone a squared second of open valve costs 0.01 m²/s²
export --period -> gone it is that of the robot's sensors: --set sensors.period_ms=5
diagnose --plot -> gone the page of --report has the charts
diagnose --power -> now saltus design {PLAN.toml} …
diagnose --effect -> now saltus design PLAN.toml --effect {CAUSE=VALUE}
diagnose --propose -> now saltus design PLAN.toml --propose {COUNT}
diagnose --inject -> now saltus inject {CAUSE=VALUE} …
diagnose --false-alarms -> gone 5 % of data without an effect may be said to have one
diagnose --samples -> gone each plan of --replan is flown 200 times
plan --no-slip -> gone friction_coefficient in the course limits what a stance needs
verify --accuracy -> gone jumps are integrated with an error of 1e-9 in each step
verify --fixed-step -> gone jumps are integrated with an error of 1e-9 in each step
filling --most -> gone the count ends at 10000 jumps
";

/// A line of [`MOVED`]: the words, of which the first is the command, and where they are.
fn moved() -> impl Iterator<Item = (&'static str, Place)> {
    MOVED.lines().filter_map(|line| {
        let (words, rest) = line.split_once(" -> ")?;
        let place = match rest.split_once(' ')? {
            ("study", study) => Place::Study(study),
            ("now", line) => Place::Now(line),
            (_, instead) => Place::Gone(instead),
        };
        Some((words, place))
    })
}

/// The command line of [`Place::Now`] with the value that follows the flag and the other words.
fn typed(line: &str, value: Option<&str>, others: &[&str]) -> String {
    let (before, rest) = line.split_once('{').unwrap_or((line, ""));
    let (default, after) = rest.split_once('}').unwrap_or_default();
    let value = value.map_or_else(|| default.to_owned(), quoted);
    let others: Vec<String> = others.iter().map(|word| quoted(word)).collect();
    let line = format!("{before}{value}{after}");
    line.replace('…', &others.join(" ")).trim_end().to_owned()
}

/// A word as a shell takes it.
pub(crate) fn quoted(word: &str) -> String {
    let is_plain = !word.is_empty()
        && word
            .chars()
            .all(|c| c.is_alphanumeric() || "-_./:=,+@%".contains(c));
    if is_plain {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

/// The user's own command line in its new form: what follows `flag` among `words` and the other words.
fn in_new_form(line: &str, flag: &str, words: &[&str]) -> String {
    let Some(at) = words.iter().position(|word| *word == flag) else {
        return typed(line, None, &[]);
    };
    let value = words.get(at + 1).filter(|word| !word.starts_with("--"));
    let after = at + 1 + usize::from(value.is_some());
    // A gait, a language or a folder that came first is none of the new command's.
    let first = usize::from(at > 0 && !words[0].starts_with("--"));
    let others = words[first..at].iter().chain(&words[after..]);
    let others: Vec<&str> = others.copied().collect();
    typed(line, value.copied(), &others)
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
    let is_asked = |(asked, _): &(&str, Place)| {
        let mut asked = asked.split(' ');
        let is_command = asked.next().is_some_and(|it| it == command);
        let asked: Vec<&str> = asked.collect();
        is_command && (asked.is_empty() || words.windows(asked.len()).any(|some| some == asked))
    };
    let (asked, place) = moved().find(is_asked)?;
    let place_text = match (place, asked.split_once(' ')) {
        (Place::Now(line), Some((_, flag))) => format!(
            "is another command now: {}",
            in_new_form(line, flag, &words)
        ),
        _ => place.to_string(),
    };
    Some(CliError::Moved {
        asked: asked.to_owned(),
        place: place_text,
    })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use clap::Parser;

    use super::*;

    /// Who types an old command gets his own in its new form, which is taken.
    #[test]
    fn a_command_that_moved_is_answered_with_its_new_form() {
        let check = |old: &str, new: &str| {
            let line: Vec<OsString> = old.split(' ').map(OsString::from).collect();
            let error = refused(&line).expect("listed").to_string();
            assert!(error.ends_with(&format!("now: saltus {new}")), "{error}");
            let words = std::iter::once("saltus").chain(new.split(' '));
            assert!(crate::cli::Cli::try_parse_from(words).is_ok(), "{new}");
        };
        check(
            "run --robot mine.toml --gait disc --seconds 3 --plot a.svg",
            "run disc --robot mine.toml --seconds 3 --plot a.svg",
        );
        check("run --gait=disc --seconds 3", "run disc --seconds 3");
        check("run --gait", "run closed-loop");
        check(
            "run --policy mine.json --seconds 3",
            "run policy mine.json --seconds 3",
        );
        check(
            "learn run-zone --animate a.html",
            "run policy FILE.json --animate a.html",
        );
        check(
            "export c --gait closed-loop --out firmware",
            "export gait closed-loop --out firmware",
        );
        check("diagnose --power mine.toml", "design mine.toml");
        check(
            "diagnose --power mine.toml --effect viscous-friction=25",
            "design mine.toml --effect viscous-friction=25",
        );
        check(
            "diagnose --inject viscous-friction=25 --out hidden",
            "inject viscous-friction=25 --out hidden",
        );
        let spaces = ["run", "--policy", "my file.json"].map(OsString::from);
        let error = refused(&spaces).expect("listed").to_string();
        assert!(
            error.ends_with("saltus run policy 'my file.json'"),
            "{error}"
        );
    }

    /// Nothing that is listed is taken, each is told where it is, and each study is there.
    #[test]
    fn who_asks_for_what_moved_is_told_where_it_is() {
        let studies = Path::new(env!("CARGO_MANIFEST_DIR")).join("../studies/src/bin");
        assert_eq!(moved().count(), MOVED.lines().count());
        for (words, place) in moved() {
            let line: Vec<OsString> = words.split(' ').map(OsString::from).collect();
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
