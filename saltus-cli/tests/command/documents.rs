//! The commands of the documents, run in their order, print what the documents show.
//!
//! In a block ```` ```console ```` a line `$ saltus …` is a command, and the lines up to the next one
//! are what it prints; `...` stands for any lines. A block ```` ```toml ```` after a line that ends
//! with a file's name in backquotes and a colon is that file.

use crate::common::Folder;
use crate::named::named;

/// What a document asks for, in its order.
pub(crate) enum Step {
    File { name: String, text: String },
    Command { line: String, prints: Vec<String> },
}

pub(crate) fn steps(document: &str) -> Vec<Step> {
    let mut steps = Vec::new();
    let mut before = "";
    let mut lines = document.lines();
    while let Some(line) = lines.next() {
        if let Some(language) = line.strip_prefix("```").filter(|word| !word.is_empty()) {
            let block: Vec<&str> = lines.by_ref().take_while(|line| *line != "```").collect();
            match language {
                "console" => steps.extend(commands(&block)),
                "toml" | "csv" => steps.extend(file_name(before).map(|name| Step::File {
                    name,
                    text: block.join("\n"),
                })),
                _ => {}
            }
        }
        if !line.is_empty() {
            before = line;
        }
    }
    steps
}

fn file_name(line: &str) -> Option<String> {
    let name = line.strip_suffix("`:")?.rsplit('`').next()?;
    Some(name.to_owned())
}

pub(crate) fn commands(block: &[&str]) -> Vec<Step> {
    let mut all = Vec::new();
    for line in block {
        match (line.strip_prefix("$ saltus "), all.last_mut()) {
            (Some(words), _) => all.push(Step::Command {
                line: words.to_owned(),
                prints: Vec::new(),
            }),
            (None, Some(Step::Command { prints, .. })) => prints.push((*line).to_owned()),
            _ => panic!("{line}: no command before it"),
        }
    }
    all
}

/// Whether `printed` are the lines `shown`, of which each `...` stands for any lines.
fn is_shown(shown: &[String], printed: &[&str]) -> bool {
    match shown.split_first() {
        None => printed.is_empty(),
        Some((first, rest)) if first == "..." => {
            (0..=printed.len()).any(|skipped| is_shown(rest, &printed[skipped..]))
        }
        Some((first, rest)) => printed
            .split_first()
            .is_some_and(|(line, others)| is_alike(first, line) && is_shown(rest, others)),
    }
}

/// Whether two lines have the same words, numbers alike to one unit of their last digit: other
/// processors round otherwise.
fn is_alike(shown: &str, printed: &str) -> bool {
    let (a, b) = (shown.split_whitespace(), printed.split_whitespace());
    a.clone().count() == b.clone().count()
        && a.zip(b).all(|(a, b)| a == b || are_close_numbers(a, b))
}

fn are_close_numbers(a: &str, b: &str) -> bool {
    let number = |text: &str| {
        text.trim_end_matches([';', ',', '.', ':'])
            .parse::<f64>()
            .ok()
    };
    let (Some(x), Some(y)) = (number(a), number(b)) else {
        return false;
    };
    let exponent: i32 = a
        .split_once('e')
        .map_or(0, |(_, power)| power.parse().unwrap());
    let mantissa = a.split('e').next().unwrap_or(a);
    let digits = mantissa.split_once('.').map_or(0, |(_, part)| part.len());
    let unit = 10_f64.powi(exponent - i32::try_from(digits).unwrap());
    (x - y).abs() <= 1.01 * unit
}

/// Runs the steps of `document` in `folder`, and compares what each command prints with what is shown.
pub(crate) fn check_steps(document: &str, folder: &Folder) {
    let steps = steps(document);
    assert!(!steps.is_empty(), "no step");
    for step in steps {
        match step {
            Step::File { name, text } => std::fs::write(folder.path(&name), text).unwrap(),
            Step::Command { line, prints } => {
                let run = folder.run(&line.split_whitespace().collect::<Vec<_>>());
                assert!(matches!(run.code, Some(0 | 1)), "{line}: {}", run.err);
                let printed: Vec<&str> = run.out.lines().collect();
                assert!(is_shown(&prints, &printed), "{line} prints\n{}", run.out);
            }
        }
    }
}

/// The same command with fewer robots: whether it can be typed does not hang on how many.
fn lighter(mut words: Vec<String>) -> Vec<String> {
    if let Some(k) = words.iter().position(|word| word == "--robots") {
        words[k + 1] = "2".into();
    }
    words
}

/// A folder with the files that the documents' commands read.
pub(crate) fn furnished(name: &str) -> Folder {
    let folder = Folder::new(name);
    let places = ["saltus/examples", "docs", "src"];
    for place in places {
        std::fs::create_dir_all(folder.path(place)).unwrap();
    }
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    for file in ["saltus/examples/box.toml", "saltus/examples/low_box.toml"] {
        std::fs::copy(root.join(file), folder.path(file)).unwrap();
    }
    let drops = "tests/reference/ball-drops/green-basketball";
    std::fs::create_dir_all(folder.path(drops)).unwrap();
    for file in std::fs::read_dir(root.join(drops)).unwrap() {
        let file = file.unwrap();
        std::fs::copy(file.path(), folder.path(drops).join(file.file_name())).unwrap();
    }
    std::fs::write(folder.path("points.csv"), "x_m,y_m\n3,0\n").unwrap();
    let readme = include_str!("../../../README.md");
    let spring = readme.split("```toml\n").nth(1).unwrap();
    std::fs::write(
        folder.path("spring.toml"),
        spring.split("```").next().unwrap(),
    )
    .unwrap();
    for step in steps(include_str!("../../../docs/commands/design.md")) {
        if let Step::File { name, text } = step {
            std::fs::write(folder.path(&name), text).unwrap();
        }
    }
    for logs in ["logs/monday", "logs/bench"] {
        let line = format!("inject viscous-friction=25 --kind bench --out {logs}");
        assert_eq!(
            folder
                .run(&line.split_whitespace().collect::<Vec<_>>())
                .code,
            Some(0)
        );
    }
    folder
}

/// Commands of the documents whose answer is no.
const ANSWERS_NO: &[&str] = &[
    // A cause is found.
    "diagnose synthetic",
    "diagnose synthetic-mcap",
    "diagnose tests/reference/ball-drops/green-basketball",
    "diagnose logs/monday --report monday.html --extend rats-monday.toml",
    "diagnose logs/monday --replan saltus/examples/box.toml",
    // The thesis' robot stalls from rest.
    "run closed-loop --seconds 5 --mcap run.mcap",
    "run closed-loop --seconds 5 --plot run.svg --animate run.html",
    "run fixed --seconds 3",
    // The box is a centimetre too high for nine robots in ten, and for the boom.
    "jump --obstacle 0.16x0.21@1.3",
    "plan saltus/examples/box.toml --plant rats-boom",
];

/// Flags that name a file or folder to be written.
const WRITES: [&str; 7] = [
    "--out",
    "--plot",
    "--report",
    "--animate",
    "--mcap",
    "--robot-out",
    "--telemetry",
];

/// Faults of a command's run: another exit code than the documents lead one to expect, an error
/// beside an answer, no output, a number that is none, a file that is named and not written.
fn faults(folder: &Folder, words: &[String]) -> Vec<String> {
    let run = folder.run(&words.iter().map(String::as_str).collect::<Vec<_>>());
    let line = words.join(" ");
    let mut faults = Vec::new();
    let expected = i32::from(ANSWERS_NO.contains(&line.as_str()));
    if run.code != Some(expected) {
        faults.push(format!(
            "exit code {:?}, not {expected}: {}",
            run.code, run.err
        ));
    }
    let files: Vec<&String> = words
        .windows(2)
        .filter(|pair| WRITES.contains(&pair[0].as_str()) && !pair[1].starts_with("--"))
        .map(|pair| &pair[1])
        .collect();
    if run.out.trim().is_empty() && files.is_empty() {
        faults.push("prints nothing".into());
    }
    let is_no_number =
        |word: &str| ["nan", "inf", "-inf"].contains(&word.to_ascii_lowercase().as_str());
    let separators = |c: char| c.is_whitespace() || ",;:()[]\"".contains(c);
    if let Some(line) = run
        .out
        .lines()
        .find(|line| line.split(separators).any(is_no_number))
    {
        faults.push(format!("a number that is none: {line}"));
    }
    for file in files {
        let path = folder.path(file);
        let is_there = path.is_dir() || std::fs::metadata(&path).is_ok_and(|data| data.len() > 0);
        if !is_there {
            faults.push(format!("{file} is not written"));
        }
    }
    faults
        .into_iter()
        .map(|fault| format!("saltus {line}: {fault}"))
        .collect()
}

/// The unit tests of the command line parse the same commands at every change.
#[test]
#[ignore = "nightly: 128 s"]
fn every_command_in_the_documents_runs() {
    let documents = [
        include_str!("../../../README.md"),
        include_str!("../../../CONTRIBUTING.md"),
        include_str!("../../../robots/README.md"),
        include_str!("../../../docs/controller.md"),
        include_str!("../../../docs/diagnosis.md"),
        include_str!("../../../docs/logs.md"),
        include_str!("../../../docs/model.md"),
        include_str!("../../../docs/running.md"),
        include_str!("../../../docs/space.md"),
        include_str!("../../../docs/thesis.md"),
        include_str!("../../../docs/viewers.md"),
    ];
    let folder = furnished("documents");
    let mut done: Vec<Vec<String>> = Vec::new();
    let mut wrong = Vec::new();
    // Blocks come before sentences, and so does what writes a folder before what reads it.
    for words in documents.into_iter().flat_map(named).map(lighter) {
        if !done.contains(&words) {
            wrong.extend(faults(&folder, &words));
            done.push(words);
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(done.len() > 60, "{} commands", done.len());
}

#[test]
fn a_wrong_number_or_line_is_seen() {
    let shown = |text: &str| text.lines().map(str::to_owned).collect::<Vec<_>>();
    let printed = ["one 1.24 m", "two", "three 3e-4"];
    assert!(is_shown(&shown("one 1.23 m\n...\nthree 4e-4"), &printed));
    for wrong in ["one 1.2 m\ntwo", "one 1.26 m\n...", "one 1.24 m\n...\ntwo"] {
        assert!(!is_shown(&shown(wrong), &printed), "{wrong}");
    }
}
