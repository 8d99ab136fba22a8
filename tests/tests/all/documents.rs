//! The documents: every page is in the site, every block says what it holds, and what is TOML can
//! be read.

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
