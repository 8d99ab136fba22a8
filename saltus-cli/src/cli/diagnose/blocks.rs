//! A report as a list of blocks, of which the text and the page are made.

use std::fmt::Write;

use saltus::chart::escaped;

use super::steps::Step;
use crate::output::grid;

/// A part of a report.
pub(super) enum Block {
    Heading(&'static str),
    /// A sentence, and where it stands.
    Words(Lead, String),
    /// Lines of cells, of which so many begin in line; the first line is a header.
    Table(Vec<Vec<String>>, usize),
    /// The same without a header, both cells beginning in line.
    List(Vec<Vec<String>>),
    /// What is said under a name.
    Card(String, Vec<Block>),
    Steps(Vec<Step>),
    /// Charts of the page.
    Charts(Charts),
}

/// Where a sentence stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Lead {
    /// Below what is before it.
    Below,
    /// Below, an empty line between.
    Apart,
    /// Below, set in.
    In,
}

/// What the charts are of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Charts {
    Measured,
    Residuals,
}

/// The blocks as text.
pub(super) fn text(blocks: &[Block]) -> String {
    let mut out = String::new();
    for block in blocks {
        match block {
            Block::Heading(heading) => {
                let _ = writeln!(out, "\n{heading}\n");
            }
            Block::Words(Lead::Below, words) => out += &wrapped(words, ""),
            Block::Words(Lead::Apart, words) => {
                let _ = write!(out, "\n{}", wrapped(words, ""));
            }
            Block::Words(Lead::In, words) => out += &wrapped(words, "  "),
            Block::Table(lines, left) => out += &grid(lines, *left),
            Block::List(lines) => out += &grid(lines, 2),
            Block::Card(name, blocks) => {
                let _ = write!(out, "\n{name}\n{}", text(blocks));
            }
            Block::Steps(steps) => {
                for (k, step) in steps.iter().enumerate() {
                    out += &wrapped(&format!("{}. {}", k + 1, step.what), "  ");
                    // A command is one line, to be copied.
                    let command = step.command.iter();
                    out.extend(command.map(|command| format!("     {command}\n")));
                }
            }
            Block::Charts(_) => {}
        }
    }
    out
}

/// The blocks as a part of a page; `charts` has those of the page.
pub(super) fn html(blocks: &[Block], charts: &dyn Fn(Charts) -> String) -> String {
    let mut out = String::new();
    for block in blocks {
        match block {
            Block::Heading(heading) => {
                let _ = writeln!(out, "<h2>{}</h2>", escaped(heading));
            }
            Block::Words(_, words) => {
                let _ = writeln!(out, "<p class=\"small\">{}</p>", escaped(words));
            }
            Block::Table(lines, left) => table(&mut out, lines, *left, "th"),
            Block::List(lines) => table(&mut out, lines, 2, "td"),
            Block::Card(name, blocks) => {
                let name = escaped(name);
                let inner = html(blocks, charts);
                let _ = writeln!(out, "<div class=\"card\"><h3>{name}</h3>\n{inner}</div>");
            }
            Block::Steps(steps) => {
                out += "<ol>\n";
                for step in steps {
                    let command = step.command.as_deref().map(escaped);
                    let command = command.map(|it| format!("<br><code>{it}</code>"));
                    let command = command.unwrap_or_default();
                    let _ = writeln!(out, "<li>{}{command}</li>", escaped(&step.what));
                }
                out += "</ol>\n";
            }
            Block::Charts(which) => out += &charts(*which),
        }
    }
    out
}

/// Lines of cells, the first with the tag `head`; the first `left` columns begin in line.
fn table(out: &mut String, lines: &[Vec<String>], left: usize, head: &str) {
    out.push_str("<table>\n");
    for (k, line) in lines.iter().enumerate() {
        out.push_str("<tr>");
        for (i, cell) in line.iter().enumerate() {
            let tag = if k == 0 { head } else { "td" };
            let is_words = i < left || (i + 1 == line.len() && line.len() > 2);
            let class = match (cell.starts_with('*'), is_words) {
                (true, _) => " class=\"off\"",
                (false, true) => "",
                (false, false) => " class=\"n\"",
            };
            let cell = escaped(cell.trim_start_matches("* ").trim());
            // Writing to a string does not fail.
            let _ = write!(out, "<{tag}{class}>{cell}</{tag}>");
        }
        out.push_str("</tr>\n");
    }
    out.push_str("</table>\n");
}

/// Words in lines of a page's width, each after `lead`.
fn wrapped(text: &str, lead: &str) -> String {
    const WIDTH: usize = 100;
    let mut out = String::new();
    let mut line = String::new();
    for word in text.split_whitespace() {
        if !line.is_empty() && lead.len() + line.chars().count() + 1 + word.chars().count() > WIDTH
        {
            let _ = writeln!(out, "{lead}{line}");
            line.clear();
        }
        if !line.is_empty() {
            line.push(' ');
        }
        line += word;
    }
    out + &format!("{lead}{line}\n")
}
