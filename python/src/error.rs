//! The one exception.

use pyo3::exceptions::PyValueError;
use pyo3::{PyErr, create_exception};

// The whole path: without it the exception does not pickle.
create_exception!(
    saltus._saltus,
    SaltusError,
    PyValueError,
    "Bad input. The text names what is wrong, its value and what is allowed."
);

/// What the caller gave is wrong.
pub(crate) fn bad(text: impl std::fmt::Display) -> PyErr {
    SaltusError::new_err(text.to_string())
}
