//! MCAP files in a build without the feature `telemetry`: each is refused, by name.

use std::io::{self, Write};
use std::path::Path;

use saltus_diagnosis::spec::Spec;

use super::error::{Error, shown};
use super::lines::Table;
use super::manifest::Listed;
use crate::origin::Origin;

const WITHOUT: &str = "is an MCAP file, which this build does not read or write: build saltus with the feature telemetry";

/// Refuses the file at `path`.
pub(super) fn table(path: &Path, _: &Listed, _: &'static Spec) -> Result<Table, Error> {
    Err(Error::content(shown(path), WITHOUT))
}

/// Refuses to write one.
pub(super) fn write(
    _: &mut dyn Write,
    _: &[&str],
    _: impl Iterator<Item = (f64, Vec<f64>)>,
    _: &Origin<'_>,
) -> io::Result<()> {
    Err(io::Error::new(io::ErrorKind::Unsupported, WITHOUT))
}
