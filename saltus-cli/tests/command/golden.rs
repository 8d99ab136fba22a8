//! What every command prints, as it stands in the files of `tests/golden`: one file for each command.
//!
//! A file is a transcript. The lines before the first command are remarks, then come commands
//! (`$ saltus …`, and `$ cat FILE` for a file that one of them has written), each with what it
//! prints: standard output, then standard error (`! `) and the exit code (`? `) unless it is 0. A
//! test runs the commands of its file, in a folder with the files of `tests/golden/inputs`, and
//! compares. A new case is a line with its command. This writes what is printed now:
//!
//! ```sh
//! SNAPSHOTS=overwrite cargo test -p saltus-cli --test command golden
//! ```
//!
//! The files hold on every processor, although sines differ in their last bit: numbers are rounded to
//! six digits (`digits: 3` in the remarks says otherwise) and to 1e-9, in SI units round-off; smaller
//! ones are `~0`. Hashes and the version are replaced by their names.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use snapbox::{Assert, Data};

use crate::common::Folder;

/// A command of a transcript and what it prints.
#[derive(Debug)]
pub(crate) struct Case {
    /// The words after `$ `.
    pub(crate) line: String,
    /// Standard output.
    pub(crate) out: String,
}

/// Where the transcripts are.
pub(crate) fn place() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden")
}

/// Names of the transcripts: commands.
pub(crate) fn names() -> BTreeSet<String> {
    std::fs::read_dir(place())
        .unwrap()
        .filter_map(|entry| {
            let name = entry.unwrap().file_name().into_string().unwrap();
            name.strip_suffix(".txt").map(str::to_owned)
        })
        .collect()
}

/// The cases of the transcript `name`.
pub(crate) fn cases(name: &str) -> Vec<Case> {
    let text = std::fs::read_to_string(place().join(format!("{name}.txt"))).unwrap();
    let mut cases: Vec<Case> = Vec::new();
    for line in text.lines() {
        if let Some(words) = line.strip_prefix("$ ") {
            cases.push(Case {
                line: words.to_owned(),
                out: String::new(),
            });
        } else if let (Some(case), false) = (cases.last_mut(), line.starts_with(['!', '?'])) {
            case.out += line;
            case.out.push('\n');
        }
    }
    cases
}

/// A new folder with what the commands read.
pub(crate) fn furnished(test: &str) -> Folder {
    let folder = Folder::new(&format!("golden-{test}"));
    for entry in std::fs::read_dir(place().join("inputs")).unwrap() {
        let path = entry.unwrap().path();
        std::fs::copy(
            &path,
            folder.path(path.file_name().unwrap().to_str().unwrap()),
        )
        .unwrap();
    }
    folder
}

/// Runs the commands of the transcript `name` and compares what they print.
fn check(name: &str) {
    let path = place().join(format!("{name}.txt"));
    let old = std::fs::read_to_string(&path).unwrap();
    let remarks: String = old
        .split_inclusive('\n')
        .take_while(|line| !line.starts_with("$ "))
        .collect();
    let digits = remarks
        .split_once("digits: ")
        .map_or(6, |(_, rest)| rest[..1].parse().unwrap());
    let folder = furnished(name);
    let mut new = remarks;
    for (k, case) in cases(name).iter().enumerate() {
        if k > 0 {
            new.push('\n');
        }
        let _ = writeln!(new, "$ {}", case.line);
        if let Some(file) = case.line.strip_prefix("cat ") {
            new += &settled(&folder.read(file), digits);
            continue;
        }
        let words = case.line.strip_prefix("saltus").unwrap();
        let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/reference");
        let words = words.replace("REFERENCE", data.to_str().unwrap());
        let run = folder.run(&words.split_whitespace().collect::<Vec<_>>());
        new += &settled(&run.out, digits);
        if !new.ends_with('\n') {
            new.push('\n');
        }
        for line in run.err.lines() {
            let _ = writeln!(new, "{}", format!("! {}", settled(line, digits)).trim_end());
        }
        if run.code != Some(0) {
            let _ = writeln!(new, "? {}", run.code.unwrap());
        }
    }
    Assert::new()
        .action_env("SNAPSHOTS")
        .normalize_paths(false)
        .eq(new, Data::read_from(&path, None).raw());
}

/// `text` with what differs between machines and versions taken out.
fn settled(text: &str, digits: usize) -> String {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/reference");
    let text = text
        .replace(data.to_str().unwrap(), "REFERENCE")
        .replace(env!("CARGO_PKG_VERSION"), "VERSION");
    let mut settled = String::new();
    let mut rest = text.as_str();
    while let Some(first) = rest.chars().next() {
        let before = settled.chars().next_back();
        let starts = !before.is_some_and(|c| c.is_alphanumeric() || "_.".contains(c));
        let word = if starts { word_of(rest) } else { "" };
        let (taken, written) = if let Some(name) = hash_of(word) {
            (word.len(), name.to_owned())
        } else if let Some(number) = starts.then(|| number_of(rest)).flatten() {
            (number.len(), rounded(number, digits))
        } else {
            (first.len_utf8(), first.into())
        };
        settled += &written;
        rest = &rest[taken..];
    }
    settled
}

/// What stands for `word` if it is a hash: of a file, or of data whose last bits differ.
fn hash_of(word: &str) -> Option<&'static str> {
    let is_hash = word.chars().all(|c| c.is_ascii_hexdigit());
    match word.len() {
        64 if is_hash => Some("SHA256"),
        16 if is_hash => Some("HASH"),
        _ => None,
    }
}

/// The letters and digits with which `text` begins.
fn word_of(text: &str) -> &str {
    let end = text.find(|c: char| !c.is_ascii_alphanumeric());
    &text[..end.unwrap_or(text.len())]
}

/// The number with a fraction or an exponent with which `text` begins.
fn number_of(text: &str) -> Option<&str> {
    let digits =
        |text: &str| text.len() - text.trim_start_matches(|c: char| c.is_ascii_digit()).len();
    let mut end = usize::from(text.starts_with('-'));
    let whole = digits(&text[end..]);
    if whole == 0 {
        return None;
    }
    end += whole;
    let mut is_real = false;
    if text[end..].starts_with('.') && digits(&text[end + 1..]) > 0 {
        end += 1 + digits(&text[end + 1..]);
        is_real = true;
    }
    if text[end..].starts_with('e') {
        let sign = usize::from(text[end + 1..].starts_with(['-', '+']));
        let power = digits(&text[end + 1 + sign..]);
        if power > 0 {
            end += 1 + sign + power;
            is_real = true;
        }
    }
    // Of a file's name.
    let next = text[end..].strip_prefix(['.', '_']);
    let is_word = next.is_some_and(|rest| rest.starts_with(char::is_alphanumeric));
    (is_real && !is_word).then(|| &text[..end])
}

/// The number `text` with at most so many significant digits.
fn rounded(text: &str, digits: usize) -> String {
    let value: f64 = text.parse().unwrap();
    if value != 0.0 && value.abs() < 1e-9 {
        return "~0".into();
    }
    let mantissa = text.split('e').next().unwrap_or_default();
    let shown = mantissa.trim_start_matches(['-', '0', '.']);
    let count = shown.chars().filter(char::is_ascii_digit).count();
    // Digits down to 1e-9.
    let places = (value.abs().log10().floor() + 10.0).clamp(1.0, 17.0);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let kept = digits.min(places as usize);
    if count <= kept {
        return text.into();
    }
    let value: f64 = format!("{value:.*e}", kept - 1).parse().unwrap();
    if (1e-4..1e7).contains(&value.abs()) {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}

macro_rules! golden {
    ($($name:ident)*) => {
        $(#[test]
        fn $name() {
            check(stringify!($name));
        })*

        /// Commands of which there is a test.
        const CHECKED: &[&str] = &[$(stringify!($name)),*];
    };
}

golden! {
    simulate table law map plan verify run filling jump learn diagnose design inject fit parkour export completions
}

/// Each command that `saltus --help` lists has a transcript, in every format that it has.
#[test]
fn every_command_has_a_transcript() {
    let help = Folder::new("golden-help").done("--help", 0);
    let listed: BTreeSet<String> = commands(&help).into_iter().collect();
    let checked: BTreeSet<String> = CHECKED.iter().map(|&name| name.to_owned()).collect();
    assert_eq!(checked, listed);
    assert_eq!(checked, names());
    for name in listed {
        let lines: Vec<String> = cases(&name).into_iter().map(|case| case.line).collect();
        let own = format!("saltus {name}");
        assert!(
            lines.iter().any(|line| line.starts_with(&own)),
            "{name}: {lines:?}"
        );
        let help = Folder::new("golden-help").done(&format!("{name} --help"), 0);
        for format in ["json", "csv"] {
            let is_offered = help.contains("--format <FORMAT>");
            let is_there = lines
                .iter()
                .any(|line| line.contains(&format!("--format {format}")));
            assert!(is_there || !is_offered, "{name} as {format} has no case");
        }
        let text = std::fs::read_to_string(place().join(format!("{name}.txt"))).unwrap();
        assert!(
            text.lines().any(|line| line == "? 2"),
            "{name}: no bad input"
        );
    }
}

/// Names of the commands that `--help` lists.
pub(crate) fn commands(help: &str) -> Vec<String> {
    help.lines()
        .skip_while(|line| *line != "Commands:")
        .skip(1)
        .take_while(|line| !line.is_empty())
        .filter(|line| !line.starts_with("   "))
        .filter_map(|line| line.split_whitespace().next())
        .filter(|name| *name != "help")
        .map(str::to_owned)
        .collect()
}

#[test]
fn only_what_differs_between_machines_is_taken_out() {
    let check = |text: &str, settled_text: &str| assert_eq!(settled(text, 6), settled_text);
    check("0.12345678901 m", "0.123457 m");
    check("[-330207.28781036998,", "[-330207,");
    check("\"a\": 3.1e-17,", "\"a\": ~0,");
    check("-4.9e-324", "~0");
    check(
        "5.17134e-7 m, 7.307e-9, -0.000123456789",
        "5.17e-7 m, 7e-9, -0.000123457",
    );
    check("within 0.29999999999999999.", "within 0.3.");
    check("1.2345678e-05", "1.2346e-5");
    check(
        "1234567 rows, run-12.3456789.csv",
        "1234567 rows, run-12.3456789.csv",
    );
    check("10.403 J, 1e5, 0, 2.50", "10.403 J, 1e5, 0, 2.50");
    check(
        "rats2.1234567, 1.5x, v0.1.0",
        "rats2.1234567, 1.5x, vVERSION",
    );
    check(&"0a".repeat(32), "SHA256");
    check("\"20170059b62f1e51\"", "\"HASH\"");
}
