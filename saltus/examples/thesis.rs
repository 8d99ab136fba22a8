//! Writes `docs/thesis.md`: chapter 5 of the thesis, running and jumping, the sensors of chapter 3 and
//! the twelve legs of chapter 7, beside what Saltus gets.
//!
//! `cargo run --release -p saltus --example thesis`
//!
//! Numbers of the thesis are constants with their place; all others are computed here. Every claim
//! about ours is held against them first, so that no page is written that is no longer true.

use std::error::Error;
use std::fs;
use std::path::Path;

#[path = "thesis/ball.rs"]
mod ball;
#[path = "thesis/crossing.rs"]
mod crossing;
#[path = "thesis/family.rs"]
mod family;
#[path = "thesis/jumper.rs"]
mod jumper;
#[path = "thesis/law.rs"]
mod law;
#[path = "thesis/limits.rs"]
mod limits;
#[path = "thesis/obstacle.rs"]
mod obstacle;
#[path = "thesis/rig.rs"]
mod rig;
#[path = "thesis/rolling.rs"]
mod rolling;
#[path = "thesis/runner.rs"]
mod runner;
#[path = "thesis/running.rs"]
mod running;
#[path = "thesis/slip.rs"]
mod slip;
#[path = "thesis/valve.rs"]
mod valve;

/// What a section needs or an error.
type Outcome<T> = Result<T, Box<dyn Error>>;

/// A part of the page, with its drawings by name.
struct Section {
    text: String,
    drawings: Vec<(&'static str, String)>,
}

const COMMAND: &str = "cargo run --release -p saltus --example thesis";

/// Valve opening time (s) of jumps: past the end of the stroke, as section 5.2.3 keeps it.
const VALVE_OPEN: f64 = 0.1;

fn main() -> Outcome<()> {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
    fs::create_dir_all(docs.join("thesis"))?;
    let mut page = format!(
        "<!-- Written by `{COMMAND}`: do not edit. -->\n\n# The thesis beside Saltus\n\nThis page \
         compares chapter 5 of the thesis on the robot RATS with Saltus: the valve times and the \
         gaits of section 5.1 and the jumps of section 5.2, before them the sensors of chapter \
         3, and after them the twelve legs of chapter 7. Each figure and number of the thesis stands beside the result of Saltus: for the robot \
         `rats-planar` where it jumps, for `rats-run` where it runs, and for `rats-twelve`. Nothing is tuned to agree. \
         [model.md](model.md) describes the model. This command writes the page and its \
         drawings:\n\n    {COMMAND}\n\nOf the thesis' plots, only axes, captions and text were \
         available. A comparison with a curve is therefore a comparison with the ends of its \
         axes.\n"
    );
    for section in [
        rig::section()?,
        valve::section()?,
        running::section()?,
        family::section()?,
        law::section()?,
        obstacle::section()?,
        crossing::section()?,
        slip::section()?,
        ball::section()?,
        rolling::section()?,
    ] {
        page.push('\n');
        page.push_str(section.text.trim());
        page.push('\n');
        for (name, svg) in section.drawings {
            fs::write(docs.join("thesis").join(name), svg)?;
        }
    }
    fs::write(docs.join("thesis.md"), wrapped(&page))?;
    Ok(())
}

/// Refuses to go on where a claim of the page does not hold.
fn claim(holds: bool, what: &str) -> Outcome<()> {
    if holds {
        Ok(())
    } else {
        Err(format!("the page claims what is not so: {what}").into())
    }
}

/// A negative number with a real minus sign.
fn signed(x: f64, digits: usize) -> String {
    let text = format!("{x:.digits$}");
    // What rounds to nothing has no sign.
    let is_zero = text.chars().all(|c| matches!(c, '-' | '0' | '.'));
    if is_zero {
        text.replace('-', "")
    } else {
        text.replace('-', "−")
    }
}

/// The page with its prose in lines of at most 100 characters.
fn wrapped(page: &str) -> String {
    const WIDTH: usize = 100;
    let mut text = String::new();
    for line in page.lines() {
        let is_prose = !["|", "!", "#", "<", "    "]
            .iter()
            .any(|start| line.starts_with(start));
        let mut width = 0;
        for word in line.split_inclusive(' ') {
            // Markdown takes a line that starts so for a list.
            let is_bullet = matches!(word.trim_end(), "+" | "-" | "*");
            if is_prose && !is_bullet && width + word.trim_end().chars().count() > WIDTH {
                text.truncate(text.trim_end().len());
                text.push('\n');
                width = 0;
            }
            text.push_str(word);
            width += word.chars().count();
        }
        text.push('\n');
    }
    text
}
