//! Subcommands that share flags: each flag is declared once, and stands behind the subcommand.

use clap::error::ErrorKind;
use clap::{ArgMatches, Args, Command, Error, FromArgMatches, Subcommand};

/// A subcommand of `S` by its name, with flags `F` that all of them take.
#[derive(Clone, Debug)]
pub(crate) struct With<S, F> {
    pub(crate) name: String,
    pub(crate) of: S,
    pub(crate) flags: F,
}

impl<S: Subcommand, F: Args> Subcommand for With<S, F> {
    fn augment_subcommands(command: Command) -> Command {
        let own = S::augment_subcommands(Command::new("own"));
        let with = own.get_subcommands().cloned().map(|one| {
            let about = one.get_about().cloned().unwrap_or_default();
            F::augment_args(one.next_help_heading(None::<&str>)).about(about)
        });
        command.subcommands(with)
    }

    fn augment_subcommands_for_update(command: Command) -> Command {
        Self::augment_subcommands(command)
    }

    fn has_subcommand(name: &str) -> bool {
        S::has_subcommand(name)
    }
}

impl<S: Subcommand, F: Args> FromArgMatches for With<S, F> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        let missing = || Error::new(ErrorKind::MissingSubcommand);
        let (name, own) = matches.subcommand().ok_or_else(missing)?;
        Ok(With {
            name: name.into(),
            of: S::from_arg_matches(matches)?,
            flags: F::from_arg_matches(own)?,
        })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}
