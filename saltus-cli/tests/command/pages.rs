//! The pages of `docs/` with blocks ```` ```console ````: what they show is what the command prints.
//!
//! `SALTUS_WRITE_PAGES=1 cargo test -p saltus-cli --test command pages -- --include-ignored` writes into the pages what is printed now;
//! where `...` leaves something out, the numbers of the lines that stay.

use std::path::{Path, PathBuf};

use crate::common::Folder;
use crate::documents::{Step, check_steps, commands, furnished, steps};

fn docs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs")
}

/// A line without its numbers and its width.
fn form(line: &str) -> String {
    let is_number =
        |word: &str| word.starts_with(|c: char| c.is_ascii_digit() || "-+±".contains(c));
    let words = line.split_whitespace();
    let words: Vec<&str> = words.map(|w| if is_number(w) { "#" } else { w }).collect();
    words.join(" ")
}

/// The lines `shown` of a command with the numbers that it prints now. The words of lines between two `...` tell where they
/// are in `printed`; lines that are no longer printed stay, and the check then names them.
fn renewed(shown: &[String], printed: &[String]) -> Vec<String> {
    let (mut from, mut renewed) = (0, Vec::new());
    for (k, lines) in shown.split(|line| line == "...").enumerate() {
        if k > 0 {
            renewed.push("...".to_owned());
        }
        let here = |at: usize| lines.iter().zip(&printed[at..at + lines.len()]);
        let places = from..(printed.len() + 1).saturating_sub(lines.len());
        // Several places may have the same words: the first with the most equal numbers is taken.
        let same = |at: &usize| {
            let words = here(*at).flat_map(|(a, b)| a.split_whitespace().zip(b.split_whitespace()));
            words.filter(|(a, b)| a == b).count()
        };
        let at = places
            .rev()
            .filter(|at| here(*at).all(|(a, b)| form(a) == form(b)))
            .max_by_key(same);
        renewed.extend_from_slice(at.map_or(lines, |at| &printed[at..at + lines.len()]));
        from = at.map_or(from, |at| at + lines.len());
    }
    renewed
}

#[test]
fn numbers_of_a_line_that_stays_are_renewed() {
    let own = |lines: &[&str]| -> Vec<String> { lines.iter().map(|&l| l.to_owned()).collect() };
    let printed = own(&["head", "lands 60.1 mm short", "slip   -3 m", "end"]);
    assert_eq!(
        renewed(&own(&["...", "lands 7 mm short", "...", "end"]), &printed),
        own(&["...", "lands 60.1 mm short", "...", "end"])
    );
    let printed_twice = own(&["over 1 m/s 10 of 10", "over 2 m/s 3 of 10"]);
    assert_eq!(
        renewed(&own(&["...", "over 2 m/s 4 of 10"]), &printed_twice),
        own(&["...", "over 2 m/s 3 of 10"])
    );
    // A line that is not printed stays.
    assert_eq!(
        renewed(&own(&["...", "gone", "slip 4 m"]), &printed),
        own(&["...", "gone", "slip 4 m"])
    );
    assert_eq!(
        renewed(&own(&["head", "..."]), &own(&[])),
        own(&["head", "..."])
    );
}

/// The page `text` with each command as it prints in `folder`. The files that the page gives are written first.
fn written(text: &str, folder: &Folder) -> String {
    for step in steps(text) {
        if let Step::File { name, text } = step {
            std::fs::write(folder.path(&name), text).expect("the file can be written");
        }
    }
    let mut lines = text.lines();
    let mut page = Vec::new();
    while let Some(line) = lines.next() {
        page.push(line.to_owned());
        if line != "```console" {
            continue;
        }
        let block: Vec<&str> = lines.by_ref().take_while(|line| *line != "```").collect();
        for step in commands(&block) {
            let Step::Command { line, prints } = step else {
                continue;
            };
            let run = folder.run(&line.split_whitespace().collect::<Vec<_>>());
            page.push(format!("$ saltus {line}"));
            let printed: Vec<String> = run
                .out
                .lines()
                .map(|line| line.trim_end().to_owned())
                .collect();
            page.extend(if prints.iter().any(|line| line == "...") {
                renewed(&prints, &printed)
            } else {
                printed
            });
        }
        page.push("```".to_owned());
    }
    page.join("\n") + "\n"
}

/// Checks a page, or writes it anew where that is asked for.
fn check(file: &str) {
    let path = docs().join(file);
    let text = std::fs::read_to_string(&path).expect("the page is there");
    let name = file.replace(['/', '.'], "-");
    if std::env::var_os("SALTUS_WRITE_PAGES").is_some() {
        let folder = furnished(&format!("write-{name}"));
        std::fs::write(&path, written(&text, &folder)).expect("the page can be written");
    } else {
        check_steps(&text, &furnished(&name));
    }
}

#[test]
fn the_first_page_shows_what_commands_print() {
    check("start.md");
}

#[test]
#[ignore = "nightly: 16 s"]
fn the_page_for_your_robot_shows_what_commands_print() {
    check("your-robot.md");
}

#[test]
#[ignore = "nightly: 45 s"]
fn the_tutorial_shows_what_commands_print() {
    check("tutorial.md");
}

#[test]
fn the_tutorial_of_machines_shows_what_commands_print() {
    check("machines.md");
}

#[test]
#[ignore = "nightly: 166 s"]
fn the_page_of_learning_shows_what_commands_print() {
    check("learning.md");
}

#[test]
#[ignore = "nightly: 10 s"]
fn the_page_of_runs_shows_what_commands_print() {
    check("running.md");
}

#[test]
#[ignore = "nightly: 17 s"]
fn the_page_of_robots_in_space_shows_what_commands_print() {
    check("space.md");
}

/// Each command's name and its page.
fn pages_of_commands() -> Vec<(String, String)> {
    let help = Folder::new("commands").run(&["--help"]).out;
    let names: Vec<&str> = help
        .lines()
        .skip_while(|line| *line != "Commands:")
        .skip(1)
        .take_while(|line| !line.is_empty())
        .filter(|line| !line.starts_with("   "))
        .filter_map(|line| line.split_whitespace().next())
        .filter(|name| *name != "help")
        .collect();
    assert!(names.len() > 10, "{names:?}");
    let of = |name: &&str| ((*name).to_owned(), format!("commands/{name}.md"));
    names.iter().map(of).collect()
}

/// Each command has a page, which shows all of its help.
#[test]
fn each_command_has_a_page_that_shows_its_help() {
    let folder = Folder::new("commands-help");
    for (name, file) in pages_of_commands() {
        let page = std::fs::read_to_string(docs().join(&file))
            .unwrap_or_else(|error| panic!("docs/{file}: {error}"));
        let asks = format!("$ saltus {name} --help");
        let shown = page.split_once(&asks).map(|(_, rest)| rest);
        let shown = shown.unwrap_or_else(|| panic!("docs/{file} does not show {asks}"));
        let shown = shown.split("```").next().unwrap_or_default().trim();
        let help = folder.run(&[&name, "--help"]).out;
        let help: Vec<&str> = help.lines().map(str::trim_end).collect();
        assert_eq!(shown, help.join("\n").trim(), "docs/{file}");
    }
}

/// The page of each command shows an example and what it prints.
#[test]
#[ignore = "nightly: 9 s"]
fn each_command_has_a_page_that_shows_what_it_prints() {
    for (_, file) in pages_of_commands() {
        check(&file);
    }
}
