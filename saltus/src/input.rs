//! Text from files.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::error::CliError;

/// The bytes of the file at `path`, which may have `limit_mib` MiB at most.
pub(crate) fn bytes(path: &Path, limit_mib: u64) -> Result<Vec<u8>, CliError> {
    let limit = limit_mib << 20;
    let mut bytes = Vec::new();
    // One byte more than the limit tells a file at the limit from a larger or an endless one.
    File::open(path)
        .and_then(|file| file.take(limit + 1).read_to_end(&mut bytes))
        .map_err(|source| CliError::Read { file: path.into(), source })?;
    if bytes.len() as u64 > limit {
        let reason = format!("larger than {limit_mib} MiB, the most it may have");
        return Err(CliError::content(path.display(), reason));
    }
    Ok(bytes)
}

/// The text of the file at `path`, which may have `limit_mib` MiB at most.
pub(crate) fn text(path: &Path, limit_mib: u64) -> Result<String, CliError> {
    String::from_utf8(bytes(path, limit_mib)?).map_err(|error| {
        let offset = error.utf8_error().valid_up_to();
        CliError::content(path.display(), format!("byte {offset} is not UTF-8 text"))
    })
}
