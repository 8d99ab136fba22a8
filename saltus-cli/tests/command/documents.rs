//! The commands of the documents, run in their order, print what the documents show.
//!
//! In a block ```` ```console ```` a line `$ saltus …` is a command, and the lines up to the next one
//! are what it prints; `...` stands for any lines. A block ```` ```toml ```` after a line that ends
//! with a file's name in backquotes and a colon is that file.

use crate::common::Folder;

/// What a document asks for, in its order.
enum Step {
    File { name: String, text: String },
    Command { line: String, prints: Vec<String> },
}

fn steps(document: &str) -> Vec<Step> {
    let mut steps = Vec::new();
    let mut before = "";
    let mut lines = document.lines();
    while let Some(line) = lines.next() {
        if let Some(language) = line.strip_prefix("```").filter(|word| !word.is_empty()) {
            let block: Vec<&str> = lines.by_ref().take_while(|line| *line != "```").collect();
            match language {
                "console" => steps.extend(commands(&block)),
                "toml" => steps.extend(file_name(before).map(|name| Step::File {
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

fn commands(block: &[&str]) -> Vec<Step> {
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

/// Runs what `document` shows in a folder of its own.
fn check(name: &str, document: &str) {
    let folder = Folder::new(name);
    let steps = steps(document);
    assert!(steps.len() > 5, "{name} shows hardly anything");
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

#[test]
fn the_tutorial_shows_what_commands_print() {
    check("tutorial", include_str!("../../../docs/tutorial.md"));
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
