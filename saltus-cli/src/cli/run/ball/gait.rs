//! How a robot in space rolls: the flags of its gait.

use std::path::Path;

use saltus::gait::space::{Fires, Gait, Stable, Steered};
use saltus::gait::{Centre, Program};

use super::came::Aim;
use super::in_its_plane;
use crate::cli::run::gait::{Direction, GaitFlags, Kind, Reading};
use crate::columns::{self, Column, Need};
use crate::error::CliError;
use crate::input;
use crate::output::full;
use crate::quantity::Quantity;

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

/// The first flag that is given.
fn first(flags: &[(&'static str, bool)]) -> Option<&'static str> {
    let given = flags.iter().find(|(_, is_given)| *is_given);
    given.map(|(flag, _)| *flag)
}

impl GaitFlags {
    /// The gait of a robot in space.
    pub(super) fn rolling(&self) -> Kind {
        let usual = if self.path.is_some() {
            Kind::Steer
        } else {
            Kind::DiscStable
        };
        self.gait.unwrap_or(usual)
    }

    /// Whether it rolls as in the thesis, which knows nothing of sensors.
    pub(super) fn is_thesis(&self) -> bool {
        self.rolling() == Kind::Disc
    }

    /// What it follows.
    pub(super) fn followed(&self) -> &'static str {
        if self.path.is_some() { "path" } else { "line" }
    }

    /// How a robot in space rolls, and what for.
    pub(super) fn rolls(&self) -> Result<(Gait, Aim), CliError> {
        self.suits_a_ball()?;
        let heading = self.heading.unwrap_or(0.0);
        let kind = self.rolling();
        let steered = match &self.path {
            Some(path) => Steered::new(points(path)?),
            None => Steered::towards(heading),
        };
        let led = match (kind, self.path.is_some()) {
            (_, true) => Aim::Path(steered.path.len()),
            (Kind::Recover, false) => Aim::Again,
            (_, false) => Aim::Led,
        };
        Ok(match kind {
            Kind::Steer | Kind::Recover => (Gait::Steered(steered), led),
            Kind::Disc => (Gait::Disc(self.fires()), Aim::Line),
            _ => {
                let stable = Stable {
                    line: heading,
                    ..Stable::default()
                };
                (Gait::Stable(stable), Aim::Line)
            }
        })
    }

    /// Refuses a gait that a robot in space does not have, and the flags of another.
    fn suits_a_ball(&self) -> Result<(), CliError> {
        let kind = self.rolling();
        if !kind.is_in_space() {
            let allowed = "disc, disc-stable, steer or recover, of a robot in space";
            return Err(CliError::flag("--gait", kind.name(), allowed));
        }
        let of_the_disc = [
            ("--valve-open", self.valve_open.is_some()),
            ("--from", self.law.from.is_some()),
            ("--to", self.law.to.is_some()),
            ("--steepness", self.law.steepness.is_some()),
            ("--shift", self.law.shift.is_some()),
            ("--centre", self.law.centre.is_some()),
            ("--zone", self.law.zone.is_some()),
        ];
        let of_the_plane = [
            ("--firing-angle", self.law.firing_angle.is_some()),
            ("--lines", self.law.lines.is_some()),
            ("--switch", self.law.switch.is_some()),
            ("--first-slope", self.law.first_slope.is_some()),
            ("--top-rate", self.law.top_rate.is_some()),
            ("--knots", self.law.knots.is_some()),
            ("--aim", self.law.aim.is_some()),
            ("--speed", self.speed.is_some()),
            ("--direction", self.direction != Direction::Forwards),
            ("--taps", self.law.taps.is_some()),
        ];
        if let Some(flag) = first(&of_the_plane) {
            return Err(in_its_plane(flag));
        }
        let refused = |flag, gaits: &str| {
            let allowed = format!("used with --gait {gaits}, not {}", kind.name());
            Err(CliError::flag(flag, "", allowed))
        };
        if kind != Kind::Disc
            && let Some(flag) = first(&of_the_disc)
        {
            return refused(flag, "disc");
        }
        if self.path.is_some() && !matches!(kind, Kind::Steer | Kind::Recover) {
            return refused("--path", "steer or recover");
        }
        if self.heading.is_some() && kind == Kind::Disc {
            return refused("--heading", "disc-stable, steer or recover");
        }
        Ok(())
    }

    /// The thesis' disc.
    fn fires(&self) -> Fires {
        let shift = self.law.shift.unwrap_or(3.0);
        let program = Program::OpenLoop {
            first: self.law.from.unwrap_or(0.5),
            last: self.law.to.unwrap_or(0.0),
            slope: self.law.steepness.unwrap_or(2.1),
            centre: match self.law.centre.unwrap_or(Reading::Printed) {
                Reading::Printed => Centre::Printed(shift),
                Reading::Seconds => Centre::Seconds(shift),
            },
        };
        Fires {
            program,
            valve_open: self.valve_open.unwrap_or(0.05),
            zone: self.law.zone.unwrap_or(-0.3),
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
