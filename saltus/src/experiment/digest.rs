//! Which files a data folder has, by their bytes.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use hmac_sha256::Hash;

use super::error::{Error, shown};
use super::files;

/// SHA-256 of each file of a data folder, in hexadecimal digits, by its name in the folder.
///
/// # Errors
/// [`Error`] where a file cannot be read.
pub fn digests(folder: &Path) -> Result<BTreeMap<String, String>, Error> {
    let of = |path: &PathBuf| {
        let name = shown(path.strip_prefix(folder).unwrap_or(path));
        let file = File::open(path).map_err(|source| Error::read(path, source))?;
        // A device may have no end.
        if !path.is_file() {
            return Err(Error::content(shown(path), "is not a file"));
        }
        let digest = digest(file).map_err(|source| Error::read(path, source))?;
        Ok((name, digest))
    };
    files(folder).iter().map(of).collect()
}

fn digest(mut file: impl Read) -> io::Result<String> {
    let mut hash = Hash::new();
    let mut part = vec![0; 1 << 16];
    loop {
        match file.read(&mut part)? {
            0 => break,
            count => hash.update(&part[..count]),
        }
    }
    let hex = |mut hex: String, byte| {
        let _ = write!(hex, "{byte:02x}");
        hex
    };
    Ok(hash.finalize().into_iter().fold(String::new(), hex))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_digest_is_the_published_one() {
        // FIPS 180-4, examples: one block, and a million bytes.
        let check = |text: &[u8], hex: &str| assert_eq!(digest(text).unwrap(), hex);
        check(
            b"abc",
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad",
        );
        check(
            &vec![b'a'; 1_000_000],
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0",
        );
    }
}
