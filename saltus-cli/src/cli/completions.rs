//! `saltus completions`: what a shell needs to complete the others.

use clap::{Args, CommandFactory};
use clap_complete::Shell;

use super::{Cli, Status};
use crate::error::CliError;
use crate::output;

/// Print a completion script for a shell
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  saltus completions bash > ~/.local/share/bash-completion/completions/saltus
  saltus completions zsh > ~/.zfunc/_saltus
  saltus completions fish > ~/.config/fish/completions/saltus.fish")]
pub(crate) struct Completions {
    /// The shell
    #[arg(value_name = "SHELL")]
    shell: Shell,
}

impl Completions {
    pub(crate) fn run(self) -> Result<Status, CliError> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut Cli::command(), "saltus", &mut script);
        output::print(&String::from_utf8_lossy(&script))?;
        Ok(Status::Done)
    }
}
