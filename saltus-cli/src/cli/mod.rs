//! The commands: one file each.

mod common;
mod completions;
mod design;
mod diagnose;
mod disturb;
mod export;
mod filling;
mod film;
mod fit;
mod inject;
mod jump;
mod law;
mod learn;
mod learned;
mod limits;
mod map;
mod moved;
mod plan;
mod proof;
mod recorded;
mod refused;
mod run;
mod simulate;
mod table;
mod target;
mod terms;
mod unusual;
mod verify;
mod with;

use std::ffi::OsString;
use std::io::Write;
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

use crate::error::CliError;
use crate::output::message;
use crate::session;

pub(crate) use moved::Place;

/// Plans the jumps of legged robots.
///
/// A robot rolls onto one leg and pivots over it; at the firing angle the leg pushes off, and the
/// robot flies. Angles are leans of the leg from the upright, forward positive, in rad; everything
/// else is in SI units, and every column's name ends with its unit. The approach rate ω is how fast
/// the robot tips over its foot, at the firing angle; a distance goes from the foot to where the
/// wheel touches (--start-lean and --landing-height count them elsewhere).
#[derive(Debug, Parser)]
#[command(name = "saltus", version, propagate_version = true, after_help = AFTER_HELP)]
pub(crate) struct Cli {
    #[command(subcommand)]
    command: Command,

    /// Warnings for numbers out of their usual range.
    #[arg(skip)]
    warnings: Vec<String>,
}

const AFTER_HELP: &str = "\
Examples:
  saltus simulate --omega 5 --alpha-f -0.1
  saltus simulate --omega 5 --alpha-f -0.25:0.05:7 --plot figure-5.9.svg
  saltus simulate --batch jumps.csv --out answers.csv
  saltus table --omega 3:6:61 --distance 0.6
  saltus law --omega 3:6:5 --distance 1
  saltus map --omega 2:7:51 --alpha-f -0.5:0.5:41 --plot map.png
  saltus plan course.toml --plot plan.svg
  saltus verify course.toml --plant rats-boom --friction 0.3:1:8
  saltus run closed-loop --seconds 5 --plot run.svg
  saltus filling --omega 4.5 --alpha-f -0.1 --set tank.volume_l=0.5
  saltus jump --obstacle 0.16x0.21@1.3
  saltus learn run-zone --out policy.json --plot curve.svg
  saltus diagnose logs/monday --report monday.html
  saltus inject coulomb-friction=25 --out synthetic
  saltus design plan.toml --propose 12
  saltus fit bench/monday --robot-out fitted.toml
  saltus export c --distance 0.3:0.8:11 --out firmware/src
  saltus export mjcf --robot rats-boom --out rats-boom.xml
  saltus export urdf --robot rats-boom --out rats-boom.urdf

Exit codes: 0 done, 1 the answer is no, 2 bad input.
`saltus help COMMAND` explains a command and its output.";

/// The commands, a line each: what clap reads, and runs.
macro_rules! commands {
    ($($name:ident $flags:path;)+) => {
        #[derive(Debug, Subcommand)]
        enum Command {
            $($name($flags)),+
        }

        impl Command {
            fn run(self) -> Result<Status, CliError> {
                match self {
                    $(Command::$name(command) => command.run()),+
                }
            }
        }
    };
}

commands! {
    Simulate simulate::Simulate;
    Table table::Table;
    Law law::Law;
    Map map::Map;
    Plan plan::Plan;
    Verify verify::Verify;
    Run run::Run;
    Filling filling::FillingOf;
    Jump jump::Jump;
    Learn learn::Learn;
    Diagnose diagnose::Diagnose;
    Design design::Design;
    Inject inject::Inject;
    Fit fit::Fit;
    Export export::Export;
    Completions completions::Completions;
}

/// Why a command line is none.
pub(crate) enum Unparsed {
    /// It asks for help, or is wrong.
    Refused(clap::Error),
    /// It asks for what has moved, or names no gait.
    Moved(Box<CliError>),
}

/// What a command that was carried out says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Status {
    /// Done.
    Done,
    /// The answer is no.
    No,
    /// The answer is of the part that was done before Ctrl-C.
    Interrupted,
}

impl Status {
    /// Done where the answer is yes.
    fn of(yes: bool) -> Status {
        if yes { Status::Done } else { Status::No }
    }
}

impl Cli {
    /// Parses the words after the program's name.
    ///
    /// # Errors
    /// What `clap` says, or where what they ask for has moved.
    pub(crate) fn parsed(words: &[OsString]) -> Result<Cli, Unparsed> {
        let line = std::iter::once("saltus".into()).chain(words.iter().cloned());
        let parsed = Cli::command()
            .try_get_matches_from(line)
            .and_then(|matches| {
                let cli = Cli::from_arg_matches(&matches)?;
                let warnings = unusual::warnings(&matches);
                Ok(Cli { warnings, ..cli })
            });
        parsed.map_err(|error| match known(words) {
            Some(known) if error.use_stderr() => Unparsed::Moved(Box::new(known)),
            _ => Unparsed::Refused(error.format(&mut Cli::command())),
        })
    }

    /// Runs the command that was parsed.
    pub(crate) fn run(self) -> Result<Status, CliError> {
        for warning in &self.warnings {
            message(&format!("warning: {warning}"));
        }
        self.command.run()
    }
}

/// What is known to be wrong with words that are no command line.
fn known(words: &[OsString]) -> Option<CliError> {
    moved::refused(words)
        .or_else(|| run::without_gait(words))
        .or_else(|| export::running::without_gait(words))
}

/// Parses the command line, runs its command and says how it went.
pub fn main() -> ExitCode {
    let words: Vec<OsString> = std::env::args_os().skip(1).collect();
    let typed = words.iter().map(|word| word.to_string_lossy().into_owned());
    session::with(|session| session.words = typed.collect());
    let done = match Cli::parsed(&words) {
        Ok(cli) => cli.run(),
        Err(Unparsed::Refused(error)) => error.exit(),
        Err(Unparsed::Moved(error)) => Err(*error),
    };
    match done {
        Ok(Status::Done) => ExitCode::SUCCESS,
        Ok(Status::No) => ExitCode::FAILURE,
        Ok(Status::Interrupted) => ExitCode::from(130),
        Err(error) => {
            // Where stderr is closed, the exit code has to do.
            let _ = writeln!(std::io::stderr(), "error: {error}");
            ExitCode::from(CliError::EXIT)
        }
    }
}

#[cfg(test)]
#[path = "../../tests/command/named.rs"]
mod named;

#[cfg(test)]
mod tests {
    use std::path::{Path, PathBuf};

    use clap::error::ErrorKind;
    use clap::{CommandFactory, Parser};

    use super::named::named;

    /// The Markdown files below `folder`.
    fn pages(folder: &Path) -> Vec<PathBuf> {
        let entries = std::fs::read_dir(folder).expect("a folder");
        let mut pages = Vec::new();
        for path in entries.map(|entry| entry.expect("an entry").path()) {
            if path.is_dir() {
                pages.extend(self::pages(&path));
            } else if path.extension().is_some_and(|end| end == "md") {
                pages.push(path);
            }
        }
        pages
    }

    /// Each command that a document names is one that the command line takes. The nightly test
    /// `every_command_in_the_documents_runs` runs them.
    #[test]
    fn every_command_in_the_documents_can_be_typed() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let mut pages = pages(&root.join("docs"));
        let others = ["README.md", "CONTRIBUTING.md", "robots/README.md"];
        pages.extend(others.map(|page| root.join(page)));
        let mut parsed = 0;
        let mut wrong = Vec::new();
        for page in pages {
            let text = std::fs::read_to_string(&page).expect("a page");
            for words in named(&text) {
                // The shell takes what follows `>` and `&&`.
                let is_ours = |word: &String| word != ">" && word != "&&";
                let words = words.into_iter().take_while(is_ours);
                let line = std::iter::once("saltus".to_owned()).chain(words);
                let line: Vec<String> = line.collect();
                // A sentence names a flag without its value, or a command without what it needs.
                let names_a_flag = line.last().is_some_and(|word| word.starts_with("--"));
                match super::Cli::try_parse_from(&line).map_err(|error| (error.kind(), error)) {
                    Ok(_) | Err((ErrorKind::DisplayHelp, _)) => {}
                    Err((ErrorKind::InvalidValue, _)) if names_a_flag => {}
                    Err((
                        ErrorKind::MissingRequiredArgument
                        | ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand,
                        _,
                    )) if line.len() < 5 => {}
                    Err((_, error)) => {
                        wrong.push(format!("{}: {}: {error}", page.display(), line.join(" ")));
                    }
                }
                parsed += 1;
            }
        }
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
        assert!(parsed > 150, "{parsed} commands");
    }

    #[test]
    fn the_command_line_is_sound() {
        super::Cli::command().debug_assert();
    }
}
