//! What the tests of the command share: running it, in a folder of its own.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

pub(crate) use crate::folder::Folder;

impl Folder {
    /// Runs `saltus` with these words in this folder.
    pub(crate) fn run(&self, words: &[&str]) -> Run {
        let output = Command::new(env!("CARGO_BIN_EXE_saltus"))
            .args(words)
            .current_dir(self.path("."))
            .stdin(Stdio::null())
            .output()
            .unwrap();
        Run {
            code: output.status.code(),
            out: String::from_utf8(output.stdout).unwrap(),
            err: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// Runs `saltus` with the words of `line`, which must end with this exit code, and gives back
    /// what it printed.
    #[track_caller]
    pub(crate) fn done(&self, line: &str, code: i32) -> String {
        let run = self.run(&line.split_whitespace().collect::<Vec<_>>());
        assert_eq!(run.code, Some(code), "{line}: {}", run.err);
        assert_eq!(run.err, "", "{line}");
        run.out
    }

    /// As [`done`](Folder::done), with notes on standard error.
    pub(crate) fn noted(&self, line: &str, code: i32) -> String {
        let run = self.run(&line.split_whitespace().collect::<Vec<_>>());
        assert_eq!(run.code, Some(code), "{line}: {}", run.err);
        let other = run.err.lines().find(|line| !line.starts_with("note: "));
        assert_eq!(other, None, "{line}");
        run.out
    }
}

/// How a run ended.
#[derive(Debug)]
pub(crate) struct Run {
    pub(crate) code: Option<i32>,
    pub(crate) out: String,
    pub(crate) err: String,
}

/// A reference file.
pub(crate) fn reference(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/reference")
        .join(name)
}

/// Header and rows of a CSV text.
pub(crate) fn rows(text: &str) -> (Vec<String>, Vec<Vec<String>>) {
    let mut lines = text
        .lines()
        .map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
    (lines.next().unwrap(), lines.collect())
}
