//! How a robot in space rolls: the flags of its gait.

use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use saltus::gait::space::{Fires, Gait, Stable, Steered};

use super::came::Aim;
use crate::cli::run::gait::{Reading, Tanh, Valve, Zone};
use crate::columns::{self, Column, Need};
use crate::error::CliError;
use crate::input;
use crate::output::full;
use crate::quantity::{self, Quantity};

/// Gaits of a robot in space.
#[derive(Debug, Subcommand)]
pub(in crate::cli::run) enum Ball {
    /// A robot in space rolls on the legs near one plane, by the firing angle of `open-loop`: twins fire as one leg
    Disc(Disc),
    /// The same on the legs that touch, kept in its plane and on its line by twins that open for different times
    DiscStable(Line),
    /// A robot in space follows a path by planes that it chooses as it lies, and gets up where it fell
    Steer(Way),
    /// The same, thrown down at an attitude and with a spin that are drawn
    Recover(Way),
}

#[derive(Args, Debug)]
pub(in crate::cli::run) struct Disc {
    #[command(flatten)]
    tanh: Tanh,

    #[command(flatten)]
    zone: Zone,

    #[command(flatten)]
    valve: Valve,
}

#[derive(Args, Debug)]
pub(in crate::cli::run) struct Line {
    /// Heading (rad) of the line, to the left of the first heading
    #[arg(long, value_name = "ANGLE", value_parser = quantity::heading, allow_hyphen_values = true, default_value = "0")]
    heading: f64,

    /// The robot knows its motion exactly, in place of what its sensors say
    #[arg(long)]
    truth: bool,
}

#[derive(Args, Debug)]
pub(in crate::cli::run) struct Way {
    #[command(flatten)]
    line: Line,

    /// Path, from (0, 0): a CSV file with x_m, along the first heading, and y_m, to its left
    #[arg(long, value_name = "FILE.csv", conflicts_with = "heading")]
    path: Option<PathBuf>,
}

/// Greatest size of a file with a path (MiB).
const LIMIT_MIB: u64 = 16;

/// The columns of a path.
const COLUMNS: [Column; 2] = [place("x_m"), place("y_m")];

const fn place(name: &'static str) -> Column {
    Column {
        name,
        others: &[],
        quantity: Quantity::LANDING,
        need: Need::Value,
    }
}

/// The points (m) in the file at `path`.
fn points(path: &Path) -> Result<Vec<[f64; 2]>, CliError> {
    read(&input::bytes(path, LIMIT_MIB)?, &path.display().to_string())
}

/// The points that `source` holds; messages call it `file`.
fn read(source: &[u8], file: &str) -> Result<Vec<[f64; 2]>, CliError> {
    let (mut points, mut before) = (Vec::new(), [0.0; 2]);
    for (line, row) in columns::read(source, file, &COLUMNS)? {
        // Each has a value: see `COLUMNS`.
        let point = row.map(Option::unwrap_or_default);
        let apart = (point[0] - before[0]).hypot(point[1] - before[1]);
        if apart < Steered::LEAST_APART {
            let last = if points.is_empty() {
                "the start, (0, 0)"
            } else {
                "the point before it"
            };
            return Err(CliError::Value {
                file: file.into(),
                line,
                key: "x_m, y_m".into(),
                value: format!("{}, {}", full(point[0]), full(point[1])),
                allowed: format!("{} m or more away from {last}", Steered::LEAST_APART),
            });
        }
        points.push(point);
        before = point;
    }
    if points.is_empty() {
        let what = "no rows: at least one point is needed below the header, x_m,y_m";
        return Err(CliError::content(file, what));
    }
    Ok(points)
}

impl Ball {
    /// Whether it rolls as in the thesis, which knows nothing of sensors.
    pub(super) fn is_thesis(&self) -> bool {
        matches!(self, Ball::Disc(_))
    }

    /// Flags of the line and the path that it follows.
    fn course(&self) -> (Option<&Line>, Option<&Path>) {
        match self {
            Ball::Disc(_) => (None, None),
            Ball::DiscStable(line) => (Some(line), None),
            Ball::Steer(way) | Ball::Recover(way) => (Some(&way.line), way.path.as_deref()),
        }
    }

    /// Whether it knows its motion exactly.
    pub(super) fn knows_truth(&self) -> bool {
        self.course().0.is_none_or(|line| line.truth)
    }

    /// Heading (rad) of its line.
    pub(super) fn heading(&self) -> f64 {
        self.course().0.map_or(0.0, |line| line.heading)
    }

    /// What it follows.
    pub(super) fn followed(&self) -> &'static str {
        self.course().1.map_or("line", |_| "path")
    }

    /// How it rolls, and what for.
    pub(super) fn rolls(&self) -> Result<(Gait, Aim), CliError> {
        let line = self.heading();
        Ok(match self {
            Ball::Disc(disc) => (Gait::Disc(disc.fires()), Aim::Line),
            Ball::DiscStable(_) => {
                let stable = Stable {
                    line,
                    ..Stable::default()
                };
                (Gait::Stable(stable), Aim::Line)
            }
            Ball::Steer(way) | Ball::Recover(way) => {
                let steered = match &way.path {
                    Some(path) => Steered::new(points(path)?),
                    None => Steered::towards(line),
                };
                let aim = match (self, &way.path) {
                    (_, Some(_)) => Aim::Path(steered.path.len()),
                    (Ball::Recover(_), None) => Aim::Again,
                    (_, None) => Aim::Led,
                };
                (Gait::Steered(steered), aim)
            }
        })
    }
}

impl Disc {
    /// The thesis' disc.
    fn fires(&self) -> Fires {
        let first = self.tanh.ends.from.unwrap_or(0.5);
        Fires {
            program: self.tanh.program(first, Reading::Printed),
            valve_open: self.valve.valve_open.unwrap_or(0.05),
            zone: self.zone.zone.unwrap_or(-0.3),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::read;

    #[test]
    fn a_path_is_read_and_what_is_none_is_refused_with_its_line() {
        let good = b"name,y_m,x_m\na,0,10\nb,10,1000cm\n";
        assert_eq!(read(good, "p.csv").unwrap(), [[10.0, 0.0], [10.0, 10.0]]);
        for (text, parts) in [
            ("x_m,y_m\n", &["p.csv", "no rows"][..]),
            ("x_m\n1\n", &["p.csv", "y_m"]),
            (
                "x_m,y_m\n1,0\n1,0\n",
                &[
                    "p.csv:3",
                    "1, 0",
                    "0.1 m or more away from the point before",
                ],
            ),
            ("x_m,y_m\n0,0\n", &["p.csv:2", "away from the start"]),
            ("x_m,y_m\n1,nan\n", &["p.csv:2", "y_m = nan", "1000 m"]),
            ("x_m,y_m\n1,\n", &["p.csv:2", "y_m"]),
            ("x_m,y_m\n1,2e9\n", &["p.csv:2", "y_m = 2e9", "1000 m"]),
        ] {
            let said = read(text.as_bytes(), "p.csv").unwrap_err().to_string();
            for part in parts {
                assert!(said.contains(part), "{said}");
            }
        }
    }
}
