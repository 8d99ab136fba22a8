//! Progress of work that takes longer than a second, on stderr when that is a terminal.

use std::io::{IsTerminal, Write, stderr};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::session::{self, Stop};

/// How long work may take unseen.
const PATIENCE: Duration = Duration::from_secs(1);
/// Time between two looks at the counter.
const PACE: Duration = Duration::from_millis(100);

/// A line on the terminal that goes when the work is done.
#[derive(Debug)]
pub(crate) struct Progress {
    done: Arc<AtomicUsize>,
    /// How far work is that has no parts to count.
    note: Arc<Mutex<String>>,
    ended: Arc<AtomicBool>,
    watcher: Mutex<Option<JoinHandle<()>>>,
    /// Ends the work, where another program may.
    stop: Option<Stop>,
}

impl Progress {
    /// Watches work called `what` in `total` parts; 0 where the parts are not counted.
    pub(crate) fn new(what: &'static str, total: usize) -> Progress {
        let (done, ended) = (
            Arc::new(AtomicUsize::new(0)),
            Arc::new(AtomicBool::new(false)),
        );
        let note = Arc::new(Mutex::new(String::new()));
        let seen = (Arc::clone(&done), Arc::clone(&note), Arc::clone(&ended));
        let watch = move || watch(what, total, (&seen.0, &seen.1), &seen.2);
        let stop = session::stop();
        // Another program shows what it likes.
        let shows = stop.is_none() && can_rewrite_lines();
        let watcher = shows.then(|| std::thread::spawn(watch));
        Progress {
            done,
            note,
            ended,
            watcher: Mutex::new(watcher),
            stop,
        }
    }

    /// Counts `parts` more as done.
    pub(crate) fn advance(&self, parts: usize) {
        session::obey(self.stop.as_ref());
        self.done.fetch_add(parts, Ordering::Relaxed);
    }

    /// Says how far work is that has no parts to count.
    pub(crate) fn note(&self, note: &str) {
        session::obey(self.stop.as_ref());
        note.clone_into(&mut self.note.lock().unwrap_or_else(PoisonError::into_inner));
    }

    /// Takes the line away: the work is done, and what is written now stands alone.
    pub(crate) fn end(&self) {
        self.ended.store(true, Ordering::Relaxed);
        if let Some(watcher) = self
            .watcher
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take()
        {
            watcher.thread().unpark();
            // A watcher that died has shown what it could.
            let _ = watcher.join();
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.end();
    }
}

fn watch(
    what: &str,
    total: usize,
    (done, note): (&AtomicUsize, &Mutex<String>),
    ended: &AtomicBool,
) {
    let start = Instant::now();
    let mut shown = false;
    while !ended.load(Ordering::Relaxed) {
        std::thread::park_timeout(PACE);
        if start.elapsed() >= PATIENCE {
            shown = true;
            let note = note.lock().unwrap_or_else(PoisonError::into_inner).clone();
            show(&line(
                what,
                total,
                done.load(Ordering::Relaxed),
                &note,
                start.elapsed(),
            ));
        }
    }
    if shown {
        show("");
    }
}

/// Whether standard error is a terminal that takes back what it has shown.
fn can_rewrite_lines() -> bool {
    stderr().is_terminal() && std::env::var_os("TERM").is_none_or(|term| term != "dumb")
}

fn line(what: &str, total: usize, done: usize, note: &str, elapsed: Duration) -> String {
    let seconds = elapsed.as_secs();
    match (100 * done).checked_div(total) {
        Some(percent) => format!("{what}: {done} of {total} ({percent} %), {seconds} s"),
        None if note.is_empty() => format!("{what}: {seconds} s"),
        None => format!("{what}: {note}, {seconds} s"),
    }
}

fn show(line: &str) {
    // Nobody waits for the progress of a lost terminal.
    let _ = write!(stderr(), "\r\x1b[K{line}").and_then(|()| stderr().flush());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_say_how_far_the_work_is() {
        let elapsed = Duration::from_millis(2500);
        assert_eq!(
            line("jumps", 200, 50, "", elapsed),
            "jumps: 50 of 200 (25 %), 2 s"
        );
        assert_eq!(line("plan", 0, 0, "", elapsed), "plan: 2 s");
        assert_eq!(
            line("plan", 0, 0, "12 % of its limit", elapsed),
            "plan: 12 % of its limit, 2 s"
        );
    }
}
