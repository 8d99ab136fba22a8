//! A box that the robot senses while it runs, and the greatest box by supply pressure.

use std::fmt::Write as _;

use clap::Args;
use saltus::Robot;
use saltus::gait::{BoxTable, Draw, Faced, Sensed, Smooth};
use saltus::robot::{Drive, GaugePressure};
use saltus::running::Share;
use serde_json::{Value, json};

use super::super::Status;
use super::super::common::OutputFlags;
use super::margin::{Margin, Passage};
use super::{Course, ENOUGH, Jump, refused};
use crate::error::CliError;
use crate::output::{Files, Format, digits};
use crate::plot::Drawing;
use crate::plot::line::{Line, Mark};
use crate::plot::palette::BLUE;
use crate::plot::sheet::{Panel, Sheet};
use crate::progress::Progress;

/// How the table for a sensed box is made.
#[derive(Args, Debug)]
pub(super) struct Learning {
    /// Runs in a round from which the table for a sensed box is made [default: 1500]
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    runs: Option<u32>,

    /// Rounds [default: 5]
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u8).range(1..=50))]
    rounds: Option<u8>,

    /// Least distance to run up (m); nearer to a sensed box than this, the robot backs off first; 0:
    /// never [default: 2.6]
    #[arg(long, value_name = "M", value_parser = room, allow_hyphen_values = true)]
    room: Option<f64>,

    /// Seek the greatest box, up to the height of --obstacle, at these supply pressures (psi)
    #[arg(long, value_name = "FROM:TO:COUNT", value_parser = pressures, allow_hyphen_values = true)]
    greatest: Option<Pressures>,
}

/// Supply pressures above ambient (psi), evenly spaced.
#[derive(Clone, Debug)]
struct Pressures(Vec<f64>);

/// What is done without flags.
const RUNS: u32 = 1500;
const ROUNDS: u8 = 5;
const ROOM: f64 = 2.6;
/// From height to height (m) of the boxes among which the greatest is sought.
const STEP: f64 = 0.02;
/// A psi in Pa.
const PSI: f64 = 6894.757293168;
/// Speed (m/s) from which a robot runs on.
const RUNS_ON: f64 = 1.0;

impl Learning {
    /// Whether one box is asked for, and not the greatest.
    pub(super) fn finds_one(&self) -> bool {
        self.greatest.is_none()
    }

    /// Refuses the flags of a sensed box where it is not sensed.
    pub(super) fn refuse(&self) -> Result<(), CliError> {
        for (flag, is_given) in [
            ("--runs", self.runs.is_some()),
            ("--rounds", self.rounds.is_some()),
            ("--room", self.room.is_some()),
            ("--greatest", self.greatest.is_some()),
        ] {
            if is_given {
                let allowed = "used with a box that is sensed: --obstacle HEIGHTxLENGTH@FROM:TO";
                return Err(CliError::flag(flag, "", allowed));
            }
        }
        Ok(())
    }
}

impl Jump {
    /// Over a box whose front is anywhere between two distances (m).
    pub(super) fn sensed(
        &self,
        robot: &Robot,
        course: Course,
        fronts: [f64; 2],
    ) -> Result<Status, CliError> {
        for (flag, is_given) in [
            ("--legs", self.legs.is_some()),
            ("--constant", self.constant),
            ("--sought-on", self.sought_on.is_some()),
            ("--generations", self.generations.is_some()),
        ] {
            if is_given {
                let allowed = "used with a box at one distance: --obstacle HEIGHTxLENGTH@FRONT";
                return Err(CliError::flag(flag, "", allowed));
            }
        }
        let learning = &self.learning;
        let sensed = Sensed {
            robot: robot.clone(),
            draw: Draw::around(robot),
            heights: vec![course.height],
            length: course.length,
            fronts,
            room: learning.room.unwrap_or(ROOM),
            law: Smooth::QUICK,
            runs: learning.runs.unwrap_or(RUNS) as usize,
            rounds: usize::from(learning.rounds.unwrap_or(ROUNDS)),
            seed: self.seed,
        };
        match &learning.greatest {
            None => self.one_height(&sensed),
            Some(pressures) => self.greatest(&sensed, &pressures.0),
        }
    }

    fn one_height(&self, sensed: &Sensed) -> Result<Status, CliError> {
        let tables = self.learn(sensed, &Progress::new("rounds", sensed.rounds))?;
        let tried = self.tried(sensed, &tables[0])?;
        let answer = Answer {
            sensed,
            table: &tables[0],
            tried: &tried,
        };
        let report = match self.output.format() {
            Format::Json => format!("{:#}\n", answer.json(self.seed)),
            _ => answer.text(),
        };
        self.output.write_report(report)?;
        Ok(answer.status())
    }

    fn learn(&self, sensed: &Sensed, progress: &Progress) -> Result<Vec<BoxTable>, CliError> {
        let threads = self.threads.count().get();
        let tables = sensed.plan(threads, |_| progress.advance(1));
        tables.map_err(|error| refused(error, &sensed.robot))
    }

    /// Other robots than those of the table try it.
    fn tried(&self, sensed: &Sensed, table: &BoxTable) -> Result<Vec<Faced>, CliError> {
        let seed = self.seed.wrapping_add(1 << 32);
        let threads = self.threads.count().get();
        let tried = sensed.try_on(table, usize::from(self.robots), seed, threads);
        tried.map_err(|error| refused(error, &sensed.robot))
    }

    /// The greatest box at each of `pressures` (psi).
    fn greatest(&self, sensed: &Sensed, pressures: &[f64]) -> Result<Status, CliError> {
        let mut sensed = sensed.clone();
        let most = sensed.heights[0];
        let mut heights = vec![most];
        while heights.last().is_some_and(|last| last - STEP > 0.5 * STEP) {
            heights.push(most - heights.len() as f64 * STEP);
        }
        heights.reverse();
        sensed.heights = heights;
        let progress = Progress::new("rounds", sensed.rounds * pressures.len());
        let mut found = Vec::new();
        for psi in pressures {
            if let Drive::Pneumatic(cylinder) = &mut sensed.robot.leg.drive {
                cylinder.supply = GaugePressure(psi * PSI);
            }
            let tables = self.learn(&sensed, &progress)?;
            found.push((*psi, self.among(&sensed, &tables)?));
        }
        drop(progress);
        let answer = Greatest {
            sensed: &sensed,
            found: &found,
        };
        let mut files = Files::default();
        let report = match self.output.format() {
            Format::Json => format!("{:#}\n", answer.json(self.seed)),
            _ => answer.text(),
        };
        files.report(OutputFlags::out(&self.output), report);
        self.plot.add_to(&mut files, || Ok(answer.drawing()))?;
        files.write()?;
        Ok(if found.iter().all(|(_, best)| best.is_some()) {
            Status::Done
        } else {
            Status::No
        })
    }

    /// Among tables of rising heights the last that enough robots clear: its height (m) and their
    /// share. Shares are taken to fall with the height, so that half of the rest is looked at each
    /// time.
    fn among(
        &self,
        sensed: &Sensed,
        tables: &[BoxTable],
    ) -> Result<Option<(f64, Share)>, CliError> {
        let (mut low, mut high) = (0, tables.len());
        let mut best = None;
        while low < high {
            let middle = usize::midpoint(low, high);
            let table = &tables[middle];
            let share = share(&self.tried(sensed, table)?);
            if share.value() >= ENOUGH {
                best = Some((table.height, share));
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        Ok(best)
    }
}

fn share(tried: &[Faced]) -> Share {
    Share {
        count: tried.iter().filter(|faced| faced.cleared).count(),
        of: tried.len(),
    }
}

/// A share with its interval, as a sentence has it.
fn said(share: Share) -> String {
    let [low, high] = share.interval().map(|x| digits(100.0 * x, 3));
    let value = digits(100.0 * share.value(), 3);
    format!(
        "{} of {}, {value} % (95 %: {low} to {high} %)",
        share.count, share.of
    )
}

/// What came of one height.
struct Answer<'a> {
    sensed: &'a Sensed,
    table: &'a BoxTable,
    tried: &'a [Faced],
}

impl Answer<'_> {
    fn status(&self) -> Status {
        if share(self.tried).value() >= ENOUGH {
            Status::Done
        } else {
            Status::No
        }
    }

    /// Of those that cleared it, how many run on.
    fn on(&self) -> Share {
        let cleared = self.tried.iter().filter(|faced| faced.cleared);
        Share {
            count: cleared.clone().filter(|f| f.speed_after > RUNS_ON).count(),
            of: cleared.count(),
        }
    }

    fn margin(&self) -> Margin {
        Margin::of(self.tried.iter().map(|faced| Passage {
            is_over: faced.passed.is_some(),
            clearance: faced.clearance,
        }))
    }

    fn text(&self) -> String {
        let short = |x: f64| digits(x, 4);
        let sensed = self.sensed;
        let reach = sensed.robot.sensors.unwrap_or_default().range_reach;
        let mut text = format!(
            "{}: a box {} m high and {} m long, its front {} to {} m from the axle at rest, sensed \
             from {} m on\n",
            sensed.robot.name,
            short(self.table.height),
            short(sensed.length),
            short(sensed.fronts[0]),
            short(sensed.fronts[1]),
            short(reach),
        );
        let _ = writeln!(
            text,
            "  table              {} cells, of {} runs",
            self.table.cells.len(),
            sensed.runs * sensed.rounds
        );
        if sensed.room > 0.0 {
            let _ = writeln!(
                text,
                "  room to run up     {} m; nearer, it backs off first",
                short(sensed.room)
            );
        }
        let _ = writeln!(text, "  cleared            {}", said(share(self.tried)));
        let on = self.on();
        if on.of > 0 {
            let _ = writeln!(
                text,
                "  run on             {} of these, over {RUNS_ON} m/s 3 s later",
                said(on)
            );
        }
        text += &self
            .margin()
            .lines(self.table.height, share(self.tried), ENOUGH);
        text
    }

    fn json(&self, seed: u64) -> Value {
        let (cleared, on) = (share(self.tried), self.on());
        json!({
            "command": "jump",
            "robot": self.sensed.robot.name,
            "obstacle": {
                "height_m": self.table.height,
                "length_m": self.sensed.length,
                "fronts_m": self.sensed.fronts,
            },
            "room_m": self.sensed.room,
            "runs": self.sensed.runs * self.sensed.rounds,
            "robots": cleared.of,
            "cleared": cleared.count,
            "cleared_share": cleared.value(),
            "cleared_share_95": cleared.interval(),
            "run_on": on.count,
            "clearance_m": self.margin().json(),
            "nearer_height_m": self.margin().nearer(self.table.height, ENOUGH),
            "seed": seed,
        })
    }
}

/// The greatest boxes by supply pressure.
struct Greatest<'a> {
    sensed: &'a Sensed,
    found: &'a [(f64, Option<(f64, Share)>)],
}

impl Greatest<'_> {
    fn text(&self) -> String {
        let [from, to] = self.sensed.fronts.map(|x| digits(x, 4));
        let lowest = digits(self.sensed.heights[0], 3);
        let mut text = format!(
            "{}: the greatest box that 95 % clear, {} m long, its front {from} to {to} m from the axle \
             at rest\n",
            self.sensed.robot.name,
            digits(self.sensed.length, 4),
        );
        for (psi, best) in self.found {
            let said = best.map_or_else(
                || format!("none of {lowest} m or more"),
                |(height, share)| format!("{} m, {}", digits(height, 3), said(share)),
            );
            let _ = writeln!(text, "  {:<18} {said}", format!("{} psi", digits(*psi, 4)));
        }
        text
    }

    fn json(&self, seed: u64) -> Value {
        let row = |(psi, best): &(f64, Option<(f64, Share)>)| {
            json!({
                "supply_pressure_gauge_psi": psi,
                "height_m": best.map(|(height, _)| height),
                "cleared": best.map(|(_, share)| share.count),
                "cleared_share_95": best.map(|(_, share)| share.interval()),
            })
        };
        json!({
            "command": "jump",
            "robot": self.sensed.robot.name,
            "length_m": self.sensed.length,
            "fronts_m": self.sensed.fronts,
            "greatest": self.found.iter().map(row).collect::<Vec<_>>(),
            "seed": seed,
        })
    }

    fn drawing(&self) -> Drawing {
        let point = |(psi, best): &(f64, Option<(f64, Share)>)| {
            (*psi, best.map_or(0.0, |(height, _)| height))
        };
        let ends = |at: Option<&(f64, _)>| at.map_or(0.0, |(psi, _)| *psi);
        let reach = [ends(self.found.first()), ends(self.found.last())];
        let high = self.sensed.heights.last().copied().unwrap_or(0.0);
        Drawing::Sheet(Sheet {
            title: format!(
                "{}: the greatest box that 95 % of the drawn robots clear",
                self.sensed.robot.name
            ),
            course: None,
            panels: vec![Panel {
                title: format!("Boxes {} m long", digits(self.sensed.length, 4)),
                x: "supply pressure (psi)",
                y: "height (m)",
                lines: vec![Line {
                    label: None,
                    points: self.found.iter().map(point).collect(),
                    color: BLUE,
                    mark: Mark::Solid,
                }],
                least: Some([reach, [0.0, high]]),
            }],
        })
    }
}

/// Parser of a flag.
fn room(text: &str) -> Result<f64, String> {
    let number = text.trim().trim_end_matches('m').parse::<f64>().ok();
    number
        .filter(|x| (0.0..=5.0).contains(x))
        .ok_or_else(|| "must be from 0 to 5 m".to_owned())
}

/// Parser of a flag.
fn pressures(text: &str) -> Result<Pressures, String> {
    let said =
        || "must be FROM:TO:COUNT in psi, from 20 to 400 psi, at most 50, as 80:200:7".to_owned();
    let parts: Vec<&str> = text.split(':').collect();
    let [from, to, count] = parts[..] else {
        return Err(said());
    };
    let psi = |text: &str| {
        let number = text.trim().parse::<f64>().ok();
        number
            .filter(|x| (20.0..=400.0).contains(x))
            .ok_or_else(said)
    };
    let (from, to) = (psi(from)?, psi(to)?);
    let count = count.trim().parse::<u8>().ok();
    let count = count
        .filter(|count| (1..=50).contains(count))
        .ok_or_else(said)?;
    if to < from || (count == 1 && to > from) {
        return Err(said());
    }
    let steps = f64::from(count.saturating_sub(1).max(1));
    let at = |k: u8| from + (to - from) * f64::from(k) / steps;
    Ok(Pressures((0..count).map(at).collect()))
}
