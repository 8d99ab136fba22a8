//! The valve's command: when it opened, and when it closed.

use super::error::Error;
use super::instant::Instant;

/// When the valve opened, and when it closed if it did.
pub(super) type Opening = (Instant, Option<Instant>);

/// The command as seen so far.
#[derive(Debug, Default)]
pub(super) struct Valve {
    state: State,
    /// Line of the first of the missing commands just before, if there are any.
    missing: Option<u64>,
    notes: Vec<String>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum State {
    /// Nothing was seen.
    #[default]
    Unseen,
    /// Not open yet.
    Before,
    /// Open since that instant.
    Open(Instant),
    /// It was open between these instants.
    Closed(Instant, Instant),
}

impl Valve {
    /// Takes in a row: its line, its instant, and the command; messages call the file `file` and
    /// the run `name`.
    pub(super) fn add(
        &mut self,
        (file, name): (&str, &str),
        line: u64,
        time: Instant,
        command: Option<f64>,
    ) -> Result<(), Error> {
        let Some(command) = command else {
            self.missing.get_or_insert(line);
            return Ok(());
        };
        let missing = self.missing.take();
        let next = match (self.state, command != 0.0) {
            (State::Unseen, true) => {
                self.notes.push(format!(
                    "{name}:{line}: valve is 1 from the start, which is taken for the command"
                ));
                State::Open(time)
            }
            (State::Unseen | State::Before, false) => State::Before,
            (State::Before, true) => State::Open(time),
            (State::Open(open), false) => State::Closed(open, time),
            (State::Closed(..), true) => {
                return Err(Error::signal(
                    format!("{file}:{line}"),
                    "valve",
                    "opens a second time: a run has one opening",
                ));
            }
            (same, _) => same,
        };
        if let Some(from) = missing.filter(|_| next != self.state && self.state != State::Unseen) {
            self.notes.push(format!(
                "{name}:{line}: valve switched at some time since line {from}, where it is empty"
            ));
        }
        self.state = next;
        Ok(())
    }

    /// When it opened, if it did.
    pub(super) fn opened(&self) -> Option<Instant> {
        match self.state {
            State::Open(open) | State::Closed(open, _) => Some(open),
            State::Unseen | State::Before => None,
        }
    }

    /// When it opened and closed, and what is odd about it.
    pub(super) fn times(self, file: &str) -> Result<(Opening, Vec<String>), Error> {
        match self.state {
            State::Open(open) => Ok(((open, None), self.notes)),
            State::Closed(open, closed) => Ok(((open, Some(closed)), self.notes)),
            State::Unseen => Err(Error::signal(file, "valve", "is empty in all rows")),
            State::Before => Err(Error::signal(
                file,
                "valve",
                "is 0 in all rows: it never opens",
            )),
        }
    }
}
