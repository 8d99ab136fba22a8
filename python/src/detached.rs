//! Work without the interpreter's lock, which Ctrl-C ends.

use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use pyo3::{PyErr, PyResult, Python};
use saltus_cli::Stop;

/// Time between two looks for Ctrl-C.
const LOOK: Duration = Duration::from_millis(50);
/// As much as a program's first thread has.
const STACK: usize = 8 << 20;

/// Does `work` on a thread of its own, while this one looks for signals. After Ctrl-C the flag is
/// up, the work is left to end by itself, and its result is lost.
pub(crate) fn detached<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce(&Stop) -> T + Send + 'static,
) -> PyResult<T> {
    let (stop, done) = (Stop::default(), Arc::new(AtomicBool::new(false)));
    let (flag, over, waiting) = (Arc::clone(&stop), Arc::clone(&done), thread::current());
    let worker = thread::Builder::new().stack_size(STACK).spawn(move || {
        // However the work ends.
        let _end = End(over, waiting);
        work(&flag)
    });
    let worker = worker.map_err(PyErr::from)?;
    while !done.load(Ordering::Acquire) {
        py.detach(|| thread::park_timeout(LOOK));
        if let Err(interrupt) = py.check_signals() {
            stop.store(true, Ordering::Relaxed);
            return Err(interrupt);
        }
    }
    let result = py.detach(|| worker.join());
    Ok(result.unwrap_or_else(|panic| resume_unwind(panic)))
}

/// Says that the work is over.
struct End(Arc<AtomicBool>, thread::Thread);

impl Drop for End {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
        self.1.unpark();
    }
}
