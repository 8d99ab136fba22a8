//! The page of keys: a robot file with every key, and what each means.

use std::fmt::Write;
use std::path::Path;

use saltus_robot::terms::{Plane, SECTIONS};
use saltus_robot::{Gas, Robot, Term};

/// A table of a robot file.
struct Section {
    /// Its dotted name.
    name: &'static str,
    /// What the page says of it.
    note: &'static str,
    /// Lines of the page before those of its terms, each with what is said of it.
    first: &'static [(&'static str, &'static str)],
}

const fn section(name: &'static str, note: &'static str) -> Section {
    Section {
        name,
        note,
        first: &[],
    }
}

/// The tables of a robot file.
const NOTED: &[Section] = &[
    Section {
        first: &[("legs = 5", "evenly spaced; commands take 1000 at most")],
        ..section("body", "")
    },
    Section {
        first: &[
            (
                "kind = \"pneumatic\"",
                "or muscle, spring, constant, table: below",
            ),
            (
                "gas = { heat_ratio = 1.4, constant_j_per_kg_k = 287.05 }",
                "or a name, such as \"air\" or \"co2\": below",
            ),
        ],
        ..section("leg", "")
    },
    section("leg.gas", ""),
    section("leg.return_spring", "optional: −(stiffness d + preload)"),
    section(
        "leg.exhaust_port",
        "optional: opens to the atmosphere at position",
    ),
    section(
        "leg.cushion",
        "optional: over the last length of the stroke",
    ),
    section("leg.muscle", ""),
    section("leg.tube", "optional: between the valve and the chamber"),
    section(
        "tank",
        "optional: the robot carries its gas; full, it has the leg's supply pressure",
    ),
    section(
        "boom",
        "optional: holds the axle; a cylinder on a universal joint at its base",
    ),
    section("boom.counterweight", "optional: a point behind the base"),
    section(
        "struts",
        "optional: bars between the tubes of neighbouring legs, which turn with the wheel",
    ),
    section("foot", "optional"),
    section("ground", "optional, as is each key"),
    section("environment", ""),
    section("errors", "optional, as is each key: one standard deviation"),
    section(
        "sensors",
        "optional, as is each key: what a running robot measures with",
    ),
];

/// Column in which the notes begin.
const NOTES: usize = 38;

/// A robot file in which every key of a pneumatic robot stands, with what it means: the page of
/// `robots/README.md`. Keys that the planar model leaves out are marked †.
fn page() -> String {
    let plain = Robot::rats_planar();
    let mut page = String::from("name = \"everything\"\n");
    for section in NOTED {
        let terms: Vec<Term> = Term::ALL
            .iter()
            .copied()
            .filter(|term| term.spec().section() == section.name && !term.spec().example.is_empty())
            .collect();
        if terms.is_empty() {
            continue;
        }
        page.push('\n');
        line(&mut page, &format!("[{}]", section.name), section.note);
        for (text, note) in section.first {
            line(&mut page, text, note);
        }
        let all_optional = section.note.contains("as is each key");
        for term in terms {
            let spec = term.spec();
            let optional = term.off(&plain).is_some() && !all_optional;
            let mark = match (optional, spec.plane != Plane::In) {
                (true, true) => "optional †",
                (true, false) => "optional",
                (false, true) => "†",
                (false, false) => "",
            };
            let between = if mark.is_empty() || spec.note.is_empty() {
                ""
            } else {
                ": "
            };
            line(
                &mut page,
                spec.example,
                &format!("{mark}{between}{}", spec.note),
            );
        }
    }
    page
}

/// A line of the page, with its note in its column.
fn line(page: &mut String, text: &str, note: &str) {
    let result = if note.is_empty() {
        writeln!(page, "{text}")
    } else {
        writeln!(
            page,
            "{text:width$}# {note}",
            width = NOTES.max(text.chars().count() + 1)
        )
    };
    result.expect("writing to a string never fails");
}

/// The first example of robots/README.md is the page of keys, and each is a sound robot file.
#[test]
fn the_examples_of_the_readme_are_sound() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../robots");
    let readme = include_str!("../../robots/README.md");
    let examples: Vec<&str> = readme
        .split("```toml\n")
        .skip(1)
        .filter_map(|rest| rest.split("```").next())
        .collect();
    assert_eq!(examples.len(), 7);
    if std::env::var_os("SALTUS_WRITE_PAGES").is_some() {
        let readme = readme.replacen(examples[0], &page(), 1);
        std::fs::write(folder.join("README.md"), readme).expect("robots/README.md is writable");
        return;
    }
    assert_eq!(examples[0], page(), "SALTUS_WRITE_PAGES=1 writes it anew");
    for example in examples {
        Robot::parse(example, "README.md", &folder).unwrap_or_else(|error| panic!("{error}"));
    }
}

/// The page has the table of gases, to the digits that it shows.
#[test]
fn the_page_has_the_gases() {
    let readme = include_str!("../../robots/README.md");
    let table = readme.split("| --- | --- | --- | --- |\n").nth(1);
    let rows = table
        .expect("a table")
        .lines()
        .take_while(|row| row.starts_with('|'));
    let mut names = Vec::new();
    for row in rows {
        let cells: Vec<&str> = row.trim_matches('|').split('|').map(str::trim).collect();
        let own: Vec<&str> = cells[0]
            .split(" or ")
            .map(|name| name.trim_matches(['`', '"']))
            .collect();
        let of = |name: &str| Gas::NAMED.iter().find(|(known, _)| *known == name);
        for name in &own {
            let (_, gas) = of(name).unwrap_or_else(|| panic!("{name}"));
            let known = [gas.heat_ratio, gas.constant, 1e3 * gas.molar_mass()];
            for (cell, known) in cells[1..].iter().zip(known) {
                let shown: f64 = cell.parse().expect("a number");
                // Four digits and more are shown.
                assert!(
                    (shown / known - 1.0).abs() < 1e-4,
                    "{name}: {cell}, {known}"
                );
            }
        }
        names.extend(own);
    }
    let known: Vec<&str> = Gas::NAMED.iter().map(|(name, _)| *name).collect();
    assert_eq!(names, known);
}

/// The page of keys has every table and every key of a pneumatic robot, each with an effect.
#[test]
fn the_page_of_keys_is_whole() {
    let names: Vec<&str> = NOTED.iter().map(|section| section.name).collect();
    assert_eq!(names, SECTIONS);
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../robots");
    let robot = Robot::parse(&page(), "page", &folder).expect("sound");
    for term in Term::ALL.iter().filter(|term| term.applies(&robot)) {
        let value = term.of(&robot);
        assert!(value.is_some() && value != term.off(&robot), "{term:?}");
    }
}
