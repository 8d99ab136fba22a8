//! What a command has around it: where it prints, whom it tells what, which files it has read, and
//! whether it has to stop. In a shell that is the process. Another program has a session for each
//! [`ask`](crate::ask).

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::identity::Identity;

/// Raised by another thread to end a command.
pub type Stop = Arc<AtomicBool>;

/// The payload with which work unwinds that had to stop.
#[derive(Debug)]
pub(crate) struct Stopped;

/// Of the command that this thread runs.
#[derive(Debug, Default)]
pub(crate) struct Session {
    /// The words of the command line, without the program.
    pub(crate) words: Vec<String>,
    /// What was said beside the answer, each once.
    pub(crate) said: BTreeSet<String>,
    /// The files that were read.
    pub(crate) read: Vec<Identity>,
    /// The files that are going to be written, each with the flag that names it.
    pub(crate) outputs: Vec<(&'static str, PathBuf, Identity)>,
    /// Set in another program.
    pub(crate) embedded: Option<Embedded>,
}

/// A command in another program.
#[derive(Debug, Default)]
pub(crate) struct Embedded {
    /// Robots, courses and tables by the name that the words have for these files.
    pub(crate) files: BTreeMap<String, String>,
    /// What would be printed.
    pub(crate) screen: Vec<u8>,
    /// What was said beside it, in order.
    pub(crate) messages: Vec<String>,
    pub(crate) stop: Stop,
}

thread_local! {
    static SESSION: RefCell<Session> = RefCell::default();
}

/// Looks at the session, or changes it.
pub(crate) fn with<T>(act: impl FnOnce(&mut Session) -> T) -> T {
    SESSION.with(|session| act(&mut session.borrow_mut()))
}

/// The flag that ends this command, where another program may raise it.
pub(crate) fn stop() -> Option<Stop> {
    with(|session| session.embedded.as_ref().map(|it| Arc::clone(&it.stop)))
}

/// Unwinds if the flag is up.
pub(crate) fn obey(stop: Option<&Stop>) {
    if stop.is_some_and(|stop| stop.load(Ordering::Relaxed)) {
        std::panic::resume_unwind(Box::new(Stopped));
    }
}

/// The text of the file that the words call `name`, where another program gave it.
pub(crate) fn file(name: &str) -> Option<String> {
    with(|session| session.embedded.as_ref()?.files.get(name).cloned())
}

/// Says something beside the answer, on standard error: once, however often it is said.
pub(crate) fn tell(text: &str) {
    with(|session| {
        if !session.said.insert(text.to_owned()) {
            return;
        }
        match &mut session.embedded {
            Some(embedded) => embedded.messages.push(text.to_owned()),
            // Where standard error is closed, nobody wants to know.
            None => drop(writeln!(io::stderr(), "{text}")),
        }
    });
}

/// Where answers are printed.
#[derive(Debug)]
pub(crate) struct Screen;

impl Write for Screen {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        with(|session| match &mut session.embedded {
            Some(embedded) => embedded.screen.write(bytes),
            None => io::stdout().write(bytes),
        })
    }

    fn flush(&mut self) -> io::Result<()> {
        with(|session| match session.embedded {
            Some(_) => Ok(()),
            None => io::stdout().flush(),
        })
    }
}
