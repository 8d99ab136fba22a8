//! Ctrl-C: the first one asks for the best answer so far, the second ends the command. In another
//! program its flag does.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use saltus::input::InputError;
use signal_hook::consts::SIGINT;
use signal_hook::flag;

use crate::error::CliError;
use crate::session;

/// Exit code of a command that SIGINT ends, as shells report it.
const EXIT: i32 = 128 + SIGINT;

/// Whether Ctrl-C was pressed.
#[derive(Debug)]
pub(crate) struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Listens from now on.
    pub(crate) fn listen() -> Result<Interrupt, CliError> {
        if let Some(stop) = session::stop() {
            return Ok(Interrupt(stop));
        }
        let came = Arc::new(AtomicBool::new(false));
        // In this order: the first signal finds the flag down and raises it, the second finds it
        // up.
        flag::register_conditional_shutdown(SIGINT, EXIT, Arc::clone(&came))
            .and_then(|_| flag::register(SIGINT, Arc::clone(&came)))
            .map_err(|source| InputError::Read {
                file: "SIGINT".into(),
                source,
            })?;
        Ok(Interrupt(came))
    }

    /// Whether it came.
    pub(crate) fn came(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
