//! The documents: every page is in the site, every block says what it holds, what is TOML can be
//! read, and the programs that a text names are there.

use std::fs;
use std::path::{Path, PathBuf};

/// What a block may be, and what checks it.
///
/// `console`: saltus-cli/tests/command. `rust`: rustdoc, by `src/lib.rs`. `toml`: here. `csv`:
/// saltus/tests/experiment. `c`: the command's and the controller's tests. `python`: the tests of
/// the Python package. `sh`: saltus-cli/tests/command runs its lines with `saltus`. `text`: nothing
/// can.
const LANGUAGES: [&str; 8] = [
    "console", "rust", "toml", "csv", "c", "python", "sh", "text",
];

fn docs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs")
}

/// The Markdown below `folder`, as paths from docs/.
fn pages(folder: &Path) -> Vec<String> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).expect("docs/ can be read") {
        let path = entry.expect("its entries, too").path();
        if path.is_dir() {
            found.extend(pages(&path));
        } else if path.extension().is_some_and(|ending| ending == "md") {
            let name = path.strip_prefix(docs()).expect("it is below docs/");
            found.push(name.to_string_lossy().into_owned());
        }
    }
    found.sort();
    found
}

fn text(page: &str) -> String {
    fs::read_to_string(docs().join(page)).expect("the page can be read")
}

/// The blocks of a page: what stands after the backquotes, and the text.
fn blocks(page: &str) -> Vec<(String, String)> {
    let text = text(page);
    let mut lines = text.lines();
    let mut found = Vec::new();
    while let Some(line) = lines.next() {
        if let Some(kind) = line.strip_prefix("```") {
            let block: Vec<&str> = lines.by_ref().take_while(|line| *line != "```").collect();
            found.push((kind.to_owned(), block.join("\n")));
        }
    }
    found
}

fn language(kind: &str) -> &str {
    kind.split([' ', ',']).next().unwrap_or_default()
}

#[test]
fn every_page_is_in_the_site() {
    let summary = text("SUMMARY.md");
    let all = pages(&docs());
    assert!(all.len() > 20, "{all:?}");
    for page in all.iter().filter(|page| *page != "SUMMARY.md") {
        let link = format!("({page})");
        assert!(summary.contains(&link), "docs/SUMMARY.md lacks {page}");
    }
}

#[test]
fn every_block_says_what_it_holds() {
    for page in pages(&docs()) {
        for (kind, block) in blocks(&page) {
            let known = LANGUAGES.contains(&language(&kind));
            assert!(known, "docs/{page}: a block of kind {kind:?}:\n{block}");
        }
    }
}

#[test]
fn every_toml_block_can_be_read() {
    let mut read = 0;
    for page in pages(&docs()) {
        for (_, block) in blocks(&page)
            .iter()
            .filter(|(kind, _)| language(kind) == "toml")
        {
            if let Err(error) = block.parse::<toml::Table>() {
                panic!("docs/{page}: {error}\n{block}");
            }
            read += 1;
        }
    }
    assert!(read > 10, "only {read} blocks of TOML");
}

/// rustdoc runs the Rust of a page only if `src/lib.rs` names the page.
#[test]
fn rustdoc_reads_every_page_with_rust() {
    let library = include_str!("../../src/lib.rs");
    let with_rust = |page: &String| {
        blocks(page)
            .iter()
            .any(|(kind, _)| language(kind) == "rust")
    };
    let found: Vec<String> = pages(&docs()).into_iter().filter(with_rust).collect();
    assert!(!found.is_empty());
    for page in found {
        let named = format!("../../docs/{page}\"");
        assert!(
            library.contains(&named),
            "tests/src/lib.rs lacks docs/{page}"
        );
    }
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Documents and sources below `folder`.
fn texts(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).expect("a folder of the repository") {
        let path = entry.expect("its entries, too").path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if path.is_dir() {
            if name != "target" && !name.starts_with('.') {
                found.extend(texts(&path));
            }
        } else if [".md", ".rs", ".py", ".c"]
            .iter()
            .any(|end| name.ends_with(end))
        {
            found.push(path);
        }
    }
    found
}

/// Sources of the programs that `text` names: examples by `--example` after their package, studies
/// by `--bin` or by a name in backquotes.
fn programs(text: &str) -> Vec<String> {
    let is_end = |c: char| !c.is_alphanumeric() && c != '_' && c != '-';
    let named = |word: &str| word.split(is_end).next().unwrap_or_default().to_owned();
    let words: Vec<&str> = text.split_whitespace().collect();
    let mut found = Vec::new();
    for three in words.windows(3) {
        match three {
            // The command, and the name that a template leaves open.
            ["--bin", name, _] if *name == "saltus" || name.starts_with('{') => {}
            ["--bin", name, _] => found.push(format!("studies/src/bin/{}.rs", named(name))),
            ["study", name, _] if name.starts_with('`') => {
                found.push(format!("studies/src/bin/{}.rs", named(&name[1..])));
            }
            [package, "--example", name] => {
                let crate_folder = package.strip_prefix("saltus-").unwrap_or(package);
                found.push(format!("{crate_folder}/examples/{}.rs", named(name)));
            }
            _ => {}
        }
    }
    found
}

#[test]
fn programs_that_texts_name_are_there() {
    let mut looked_at = 0;
    for path in texts(&root()) {
        let text = fs::read_to_string(&path).expect("a text");
        for source in programs(&text) {
            let there = root().join(&source).exists();
            assert!(there, "{}: there is no {source}", path.display());
            looked_at += 1;
        }
    }
    assert!(looked_at > 80, "only {looked_at} programs are named");
}

/// The table of studies/README.md begins a row for each study.
#[test]
fn every_study_has_its_row() {
    let page = fs::read_to_string(root().join("studies/README.md")).expect("the page of studies");
    let rows = page.lines().filter_map(|line| line.strip_prefix("| `"));
    let mut rows: Vec<&str> = rows.filter_map(|row| row.split('`').next()).collect();
    rows.sort_unstable();
    let folder = fs::read_dir(root().join("studies/src/bin")).expect("studies");
    let mut studies: Vec<String> = folder
        .map(|entry| entry.expect("its entries, too").path())
        .filter_map(|path| Some(path.file_stem()?.to_str()?.to_owned()))
        .collect();
    studies.sort_unstable();
    assert_eq!(rows, studies);
}
