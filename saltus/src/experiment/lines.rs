//! Lines of a file of any length, in constant memory.

use std::fs::File;
use std::io::{BufRead, BufReader, Cursor, Read};
use std::path::Path;

use super::error::{Error, shown};

/// Longest line (bytes): far more than a row of numbers has, far less than the memory.
const LONGEST: usize = 1 << 16;

/// What a file says as a CSV file would say it.
pub(super) struct Table {
    pub(super) text: Vec<u8>,
    /// What is odd about it, without its name.
    pub(super) notes: Vec<String>,
}

/// Lines of a file.
///
/// A row is a line here, which is less than CSV allows and all that numbers need: no open quote
/// swallows the rest of a file, and lines are counted as an editor counts them.
pub(super) struct Lines {
    source: Box<dyn BufRead>,
    file: String,
    number: u64,
    buffer: Vec<u8>,
    /// Lines that begin with #, which are no rows.
    pub(super) comments: u64,
}

impl Lines {
    /// Opens the file at `path`.
    pub(super) fn open(path: &Path) -> Result<Lines, Error> {
        let failed = |source| Error::read(path, source);
        let file = File::open(path).map_err(failed)?;
        if !file.metadata().map_err(failed)?.is_file() {
            return Err(Error::content(shown(path), "is not a file"));
        }
        let source = Box::new(BufReader::with_capacity(1 << 16, file));
        Ok(Lines::from(source, shown(path)))
    }

    /// Lines of a `text` that was made of the file `file`.
    pub(super) fn of(text: Vec<u8>, file: &str) -> Lines {
        Lines::from(Box::new(Cursor::new(text)), file.into())
    }

    fn from(source: Box<dyn BufRead>, file: String) -> Lines {
        Lines {
            source,
            file,
            number: 0,
            buffer: Vec::new(),
            comments: 0,
        }
    }

    /// The next line that is neither blank nor a comment, with its number from 1.
    pub(super) fn next(&mut self) -> Result<Option<(u64, &[u8])>, Error> {
        loop {
            self.buffer.clear();
            let mut part = (&mut self.source).take(LONGEST as u64);
            part.read_until(b'\n', &mut self.buffer)
                .map_err(|source| Error::read(Path::new(&self.file), source))?;
            self.number += 1;
            if self.buffer.len() == LONGEST && self.buffer.last() != Some(&b'\n') {
                let reason =
                    format!("more than {LONGEST} bytes without a line break: not rows of numbers");
                return Err(Error::content(
                    format!("{}:{}", self.file, self.number),
                    reason,
                ));
            }
            if self.buffer.is_empty() {
                return Ok(None);
            }
            let text = self.buffer.trim_ascii_start();
            if text.starts_with(b"#") {
                self.comments += 1;
            } else if !text.is_empty() {
                return Ok(Some((self.number, self.buffer.trim_ascii_end())));
            }
        }
    }
}

/// Hash of bytes (FNV-1a, 64 bits): the same on every machine and in every version.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Hash(u64);

impl Default for Hash {
    fn default() -> Hash {
        Hash(0xcbf2_9ce4_8422_2325)
    }
}

impl Hash {
    /// Takes in more bytes.
    pub(super) fn add(&mut self, bytes: &[u8]) {
        self.0 = bytes.iter().fold(self.0, |hash, &byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3)
        });
    }

    /// Takes in a number; all that are NaN are alike.
    pub(super) fn number(&mut self, number: f64) {
        let number = if number.is_nan() { f64::NAN } else { number };
        self.add(&number.to_bits().to_le_bytes());
    }

    /// Takes in what was hashed apart.
    pub(super) fn join(&mut self, part: Hash) {
        self.add(&part.0.to_le_bytes());
    }

    /// 16 hexadecimal digits.
    pub(super) fn hex(self) -> String {
        format!("{:016x}", self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_is_the_published_one() {
        // Test vectors of Fowler, Noll and Vo.
        let check = |text: &str, hex: &str| {
            let mut hash = Hash::default();
            hash.add(text.as_bytes());
            assert_eq!(hash.hex(), hex, "{text}");
        };
        check("", "cbf29ce484222325");
        check("a", "af63dc4c8601ec8c");
        check("foobar", "85944171f73967e8");
    }
}
