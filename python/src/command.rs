//! Every verb of the command.

use std::collections::BTreeMap;
use std::sync::Arc;

use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::{PyErr, PyResult, Python, pyfunction};
use saltus_cli::{Answer, Refused, ask};

use crate::detached::detached;
use crate::error::bad;

/// Runs the command with these words: whether the answer is yes, the report, the messages.
#[pyfunction]
#[pyo3(signature = (words, files = BTreeMap::new()))]
pub(crate) fn command(
    py: Python<'_>,
    words: Vec<String>,
    files: BTreeMap<String, String>,
) -> PyResult<(bool, String, Vec<String>)> {
    let answer = detached(py, move |stop| ask(&words, files, Arc::clone(stop)))?;
    match answer {
        Ok(Answer {
            yes,
            report,
            messages,
        }) => Ok((yes, report, messages)),
        Err(Refused::Input(text)) => Err(bad(text)),
        Err(Refused::Stopped) => Err(PyErr::new::<PyKeyboardInterrupt, _>(())),
    }
}
