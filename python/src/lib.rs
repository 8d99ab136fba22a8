//! The module `saltus._saltus` of the Python package: robots, jumps, and every verb of the command.
//!
//! `saltus/_saltus.pyi` says what each name is for.

// PyO3 hands arguments over by value.
#![allow(clippy::needless_pass_by_value)]

mod command;
mod detached;
mod episodes;
mod error;
mod jump;
mod robot;
mod toml_value;

#[pyo3::pymodule(gil_used = false)]
mod _saltus {
    #[pymodule_export]
    use crate::command::command;
    #[pymodule_export]
    use crate::episodes::Episodes;
    #[pymodule_export]
    use crate::error::SaltusError;
    #[pymodule_export]
    use crate::jump::{Jump, flight, jump, jumps};
    #[pymodule_export]
    use crate::robot::Robot;
    #[pymodule_export]
    use crate::toml_value::to_toml;

    /// The version of the library.
    #[pymodule_export]
    #[allow(non_upper_case_globals)]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
