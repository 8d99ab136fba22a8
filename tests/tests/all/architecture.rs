//! Dependencies point one way: the crates' manifests against the table of the design.
//!
//! A new arrow is a commit of its own and a line in [`MAY_USE`].

use std::fs;
use std::path::{Path, PathBuf};

use toml::{Table, Value};

/// Which of our crates each crate may use. A crate that is not here may not exist.
const MAY_USE: [(&str, &[&str]); 15] = [
    ("numeric", &[]),
    ("robot", &["numeric"]),
    ("pneumatics", &["numeric", "robot"]),
    ("lagrangian", &["numeric", "robot", "pneumatics"]),
    ("ballistic", &["numeric", "robot"]),
    ("planner", &["numeric", "robot", "lagrangian", "ballistic"]),
    // Its equations are derived another way: never lagrangian or ballistic.
    ("sim-check", &["numeric", "robot", "pneumatics"]),
    // The simulation is for its tests alone.
    (
        "diagnosis",
        &["numeric", "robot", "pneumatics", "sim-check"],
    ),
    ("controller", &[]),
    (
        "gait",
        &["numeric", "robot", "planner", "sim-check", "controller"],
    ),
    // It knows files and messages, and no robot.
    ("telemetry", &[]),
    ("saltus", ALL),
    // The command knows the library alone.
    ("saltus-cli", &["saltus"]),
    // Verbs of the command as functions, and jumps of the library.
    ("python", &["saltus", "saltus-cli"]),
    ("tests", ALL),
];

/// What the library and the tests may use.
const ALL: &[&str] = &[
    "numeric",
    "robot",
    "pneumatics",
    "lagrangian",
    "ballistic",
    "planner",
    "sim-check",
    "diagnosis",
    "controller",
    "gait",
    "telemetry",
    "saltus",
];

/// Crates of others that only some of ours may know; the tests may know any.
const KNOWN_TO: [(&str, &[&str]); 15] = [
    ("clarabel", &["planner"]),
    ("clap", &["saltus-cli"]),
    ("clap_complete", &["saltus-cli"]),
    ("csv", &["robot", "saltus-cli"]),
    ("lz4_flex", &["telemetry"]),
    ("mcap", &["telemetry"]),
    ("plotters", &["saltus-cli"]),
    ("numpy", &["python"]),
    ("png", &["saltus-cli"]),
    ("pyo3", &["python"]),
    ("ruzstd", &["telemetry"]),
    ("serde", &["saltus-cli"]),
    ("serde_json", &["saltus", "saltus-cli"]),
    ("signal-hook", &["saltus-cli"]),
    ("toml", &["robot", "saltus", "python"]),
];

/// Crates that read and write files and talk to a person; the others compute.
const SHELLS: [&str; 5] = ["robot", "telemetry", "saltus", "saltus-cli", "tests"];

/// What the source of a crate that computes does not say.
const INPUT_OUTPUT: [&str; 8] = [
    "std::fs",
    "std::io",
    "std::net",
    "std::env",
    "std::process",
    "print!(",
    "println!(",
    "dbg!(",
];

/// A crate of the workspace.
struct Member {
    folder: String,
    manifest: Table,
}

impl Member {
    fn package(&self) -> &str {
        self.manifest["package"]["name"]
            .as_str()
            .expect("a package has a name")
    }

    /// Names of what it depends on to run and to build, and, if `with_tests`, to be tested.
    fn dependencies(&self, with_tests: bool) -> Vec<String> {
        let mut kinds = vec!["dependencies", "build-dependencies"];
        if with_tests {
            kinds.push("dev-dependencies");
        }
        let targets = self.manifest.get("target").and_then(Value::as_table);
        let tables = targets
            .into_iter()
            .flat_map(Table::values)
            .filter_map(Value::as_table);
        std::iter::once(&self.manifest)
            .chain(tables)
            .flat_map(|table| kinds.iter().filter_map(|kind| table.get(*kind)?.as_table()))
            .flat_map(Table::iter)
            .map(|(key, value)| renamed(value).unwrap_or(key).to_owned())
            .collect()
    }
}

/// The package behind a dependency's key, where it is another.
fn renamed(dependency: &Value) -> Option<&str> {
    dependency.get("package")?.as_str()
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn manifest(folder: &Path) -> Table {
    let path = folder.join("Cargo.toml");
    let text =
        fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    text.parse()
        .unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn members() -> Vec<Member> {
    let workspace = manifest(&root());
    let folders = workspace["workspace"]["members"]
        .as_array()
        .expect("a list of members");
    folders
        .iter()
        .map(|folder| folder.as_str().expect("members are folders").to_owned())
        .map(|folder| Member {
            manifest: manifest(&root().join(&folder)),
            folder,
        })
        .collect()
}

/// What `arrows` the table forbids, as `from -> to`.
fn forbidden(arrows: &[(&str, &str)]) -> Vec<String> {
    let allowed = |from: &str, to: &str| {
        MAY_USE
            .iter()
            .any(|(folder, uses)| *folder == from && (uses.contains(&to) || from == to))
    };
    arrows
        .iter()
        .filter(|(from, to)| !allowed(from, to))
        .map(|(from, to)| format!("{from} -> {to}"))
        .collect()
}

#[test]
fn arrows_between_our_crates_are_those_of_the_table() {
    let members = members();
    let folder_of = |package: &str| {
        members
            .iter()
            .find(|member| member.package() == package)
            .map(|member| member.folder.as_str())
    };
    let mut arrows = Vec::new();
    for member in &members {
        assert!(
            MAY_USE.iter().any(|(folder, _)| *folder == member.folder),
            "{} is not in the table",
            member.folder
        );
        // What a controller is tested with does not run on the robot.
        let with_tests = member.folder != "controller";
        for dependency in member.dependencies(with_tests) {
            arrows.extend(folder_of(&dependency).map(|to| (member.folder.as_str(), to)));
        }
    }
    assert!(
        arrows.contains(&("lagrangian", "pneumatics")),
        "no arrows were found: {arrows:?}"
    );
    assert_eq!(forbidden(&arrows), Vec::<String>::new());
}

#[test]
fn the_check_sees_a_wrong_arrow() {
    let arrows = [
        ("planner", "saltus"),
        ("robot", "pneumatics"),
        ("ballistic", "lagrangian"),
        ("saltus", "robot"),
    ];
    assert_eq!(
        forbidden(&arrows),
        [
            "planner -> saltus",
            "robot -> pneumatics",
            "ballistic -> lagrangian"
        ]
    );
}

#[test]
fn crates_of_others_stay_where_they_belong() {
    for member in members().iter().filter(|member| member.folder != "tests") {
        for dependency in member.dependencies(false) {
            let known_to = KNOWN_TO.iter().find(|(name, _)| *name == dependency);
            let allowed =
                known_to.is_none_or(|(_, folders)| folders.contains(&member.folder.as_str()));
            assert!(allowed, "{} knows {dependency}", member.folder);
        }
    }
}

#[test]
fn the_core_does_no_input_or_output() {
    let mut looked_at = 0;
    for member in members()
        .iter()
        .filter(|member| !SHELLS.contains(&member.folder.as_str()))
    {
        for path in rust_files(&root().join(&member.folder).join("src")) {
            let text = fs::read_to_string(&path).expect("a source file");
            looked_at += 1;
            for (number, line) in text.lines().enumerate() {
                let code = line.split("//").next().unwrap_or_default();
                let said = INPUT_OUTPUT.iter().find(|word| code.contains(*word));
                assert!(
                    said.is_none(),
                    "{}:{}: {}",
                    path.display(),
                    number + 1,
                    line.trim()
                );
            }
        }
    }
    assert!(looked_at > 20, "only {looked_at} files were looked at");
}

/// Every `.rs` below `folder`.
fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let entries =
        fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let paths = entries.map(|entry| entry.expect("a readable folder").path());
    paths
        .flat_map(|path| match path.extension() {
            _ if path.is_dir() => rust_files(&path),
            Some(extension) if extension == "rs" => vec![path],
            _ => Vec::new(),
        })
        .collect()
}

/// No file needs one that needs it. A module and its own submodules are one thing, and tests may
/// use what they like.
#[test]
fn files_make_no_circle() {
    for member in members() {
        let files = Files::of(&root().join(&member.folder).join("src"));
        let needs: Vec<Vec<usize>> = (0..files.0.len()).map(|k| files.needed_by(k)).collect();
        for start in 0..needs.len() {
            let (mut seen, mut next) = (vec![false; needs.len()], needs[start].clone());
            while let Some(k) = next.pop() {
                if !std::mem::replace(&mut seen[k], true) {
                    next.extend(&needs[k]);
                }
            }
            let name = files.0[start].0.join("::");
            assert!(!seen[start], "{}: {name} needs itself", member.folder);
        }
    }
}

/// The modules of a crate: path and text without tests.
struct Files(Vec<(Vec<String>, String)>);

impl Files {
    fn of(root: &Path) -> Files {
        let (mut all, mut folders) = (Vec::new(), vec![root.to_path_buf()]);
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(&folder).into_iter().flatten().flatten() {
                let path = entry.path();
                if path.is_dir() {
                    folders.push(path);
                    continue;
                }
                let inside = path.with_extension("");
                let inside = inside.strip_prefix(root).expect("a file of the crate");
                let mut name: Vec<String> = inside
                    .iter()
                    .map(|part| part.to_string_lossy().into_owned())
                    .collect();
                if ["mod", "lib", "main"].contains(&name[name.len() - 1].as_str()) {
                    name.pop();
                }
                let text = fs::read_to_string(&path).unwrap_or_default();
                let tests = text.find("#[cfg(test)]\nmod tests").unwrap_or(text.len());
                all.push((name, text[..tests].to_owned()));
            }
        }
        Files(all)
    }

    /// Files that file `k` imports from, but for its own parents and children.
    fn needed_by(&self, k: usize) -> Vec<usize> {
        let (name, text) = &self.0[k];
        let mut all = Vec::new();
        let mut lines = text.lines();
        while let Some(line) = lines.next() {
            let line = line.trim_start();
            let Some(("" | "pub" | "pub(crate)" | "pub(super)", rest)) = line
                .split_once("use ")
                .map(|(before, rest)| (before.trim_end(), rest))
            else {
                continue;
            };
            let mut import = rest.to_owned();
            while !import.contains(';') {
                let Some(more) = lines.next() else { break };
                import.push_str(more.trim());
            }
            let path: String = import.trim_end_matches(';').split_whitespace().collect();
            for path in flat("", &path) {
                all.extend(self.found(name, &path));
            }
        }
        let is_kin = |other: &usize| {
            let other = &self.0[*other].0;
            other.starts_with(name) || name.starts_with(other)
        };
        all.retain(|other| !is_kin(other));
        all
    }

    /// The file that `path` leads to from the module `name`.
    fn found(&self, name: &[String], path: &str) -> Option<usize> {
        let mut at: Vec<&str> = name.iter().map(String::as_str).collect();
        let mut parts = path.split("::").peekable();
        match *parts.peek()? {
            "crate" => {
                at.clear();
                parts.next();
            }
            "super" => {
                while parts.next_if_eq(&"super").is_some() {
                    at.pop();
                }
            }
            _ => return None,
        }
        at.extend(parts);
        (1..=at.len())
            .rev()
            .find_map(|n| self.0.iter().position(|(name, _)| *name == at[..n]))
    }
}

/// The paths of an import, without braces.
fn flat(prefix: &str, path: &str) -> Vec<String> {
    let Some((before, inside)) = path.split_once('{') else {
        return vec![format!("{prefix}{path}")];
    };
    let prefix = format!("{prefix}{before}");
    let inside = inside.strip_suffix('}').unwrap_or(inside);
    let (mut depth, mut start, mut all) = (0, 0, Vec::new());
    for (i, c) in inside.char_indices().chain([(inside.len(), ',')]) {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                all.extend(flat(&prefix, &inside[start..i]));
                start = i + 1;
            }
            _ => {}
        }
    }
    all
}

/// Rust files below `folder` that belong to the workspace.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        let name = path.file_name().and_then(|name| name.to_str());
        let is_hidden = name.is_none_or(|name| name.starts_with('.') || name == "target");
        if path.is_dir() && !path.is_symlink() && !is_hidden {
            sources(&path, found);
        } else if path.extension().is_some_and(|end| end == "rs") {
            found.push(path);
        }
    }
}

/// An ignored test says how long it takes: `.ci/nightly` runs it, and nobody else.
#[test]
fn every_ignored_test_is_for_the_night_and_says_its_seconds() {
    let mut files = Vec::new();
    sources(
        &Path::new(env!("CARGO_MANIFEST_DIR")).join(".."),
        &mut files,
    );
    let mut count = 0;
    for file in files {
        let text = fs::read_to_string(&file).expect("a source");
        for line in text.lines().map(str::trim_start) {
            let Some(rest) = line.strip_prefix("#[ignore") else {
                continue;
            };
            let reason = rest.strip_prefix(" = \"nightly: ");
            let seconds = reason.and_then(|reason| reason.split(' ').next()?.parse::<u32>().ok());
            assert!(
                seconds.is_some_and(|seconds| seconds > 0),
                "{}: {line}: write #[ignore = \"nightly: 40 s\"]",
                file.display()
            );
            count += 1;
        }
    }
    assert!(count > 20, "{count} ignored tests");
}
