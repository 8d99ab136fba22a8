//! Which files a data folder has, by their bytes.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use hmac_sha256::Hash;

use super::error::{Error, shown};
use super::files;

/// SHA-256 of each file of a data folder, in hexadecimal digits, by its name in the folder.
///
/// # Errors
/// [`Error`] where a file cannot be read.
pub fn digests(folder: &Path) -> Result<BTreeMap<String, String>, Error> {
    let of = |path: &std::path::PathBuf| {
        let name = shown(path.strip_prefix(folder).unwrap_or(path));
        let digest = digest(path).map_err(|source| Error::read(path, source))?;
        Ok((name, digest))
    };
    files(folder).iter().map(of).collect()
}

fn digest(path: &Path) -> io::Result<String> {
    let mut file = File::open(path)?;
    let mut hash = Hash::new();
    let mut part = vec![0; 1 << 16];
    loop {
        match file.read(&mut part)? {
            0 => break,
            count => hash.update(&part[..count]),
        }
    }
    let bytes = hash.finalize();
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::temporary::Temporary;

    #[test]
    fn a_digest_is_the_published_one() {
        // FIPS 180-4, examples: one block, and a million bytes.
        let check = |text: &[u8], hex: &str| {
            let file = Temporary::beside(&std::env::temp_dir().join("digest")).unwrap();
            std::fs::write(file.path(), text).unwrap();
            assert_eq!(digest(file.path()).unwrap(), hex);
        };
        check(
            b"abc",
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad",
        );
        check(
            &[b'a'; 1_000_000],
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0",
        );
    }
}
