//! A box that the robot senses while it runs, and the greatest box by supply pressure.

use clap::Args;
use saltus::Robot;
use saltus::gait::{BoxTable, Draw, Faced, Sensed, Smooth};
use saltus::running::Share;
use serde_json::{Value, json};

use super::super::Status;
use super::margin::{Margin, Passage};
use super::{Course, ENOUGH, Jump, refused};
use crate::error::CliError;
use crate::output::{self, Format, counted, in_words, measured};
use crate::progress::Progress;

/// How the table for a sensed box is made.
#[derive(Args, Debug)]
pub(super) struct Learning {
    /// Runs in a round from which the table for a sensed box is made [default: 1500]
    #[arg(long, value_name = "COUNT", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    runs: Option<u32>,

    /// Rounds [default: 5]
    #[arg(long, value_name = "COUNT", allow_negative_numbers = true, value_parser = clap::value_parser!(u8).range(1..=50))]
    rounds: Option<u8>,

    /// Least distance to run up (m); nearer to a sensed box than this, the robot backs off first; 0:
    /// never [default: 2.6]
    #[arg(long, value_name = "M", value_parser = room, allow_hyphen_values = true)]
    room: Option<f64>,
}

/// What is done without flags.
const RUNS: u32 = 1500;
const ROUNDS: u8 = 5;
const ROOM: f64 = 2.6;
/// Speed (m/s) from which a robot runs on.
const RUNS_ON: f64 = 1.0;

impl Learning {
    /// Refuses the flags of a sensed box where it is not sensed.
    pub(super) fn refuse(&self) -> Result<(), CliError> {
        let given = [
            ("--runs", self.runs.is_some()),
            ("--rounds", self.rounds.is_some()),
            ("--room", self.room.is_some()),
        ];
        let allowed = "used with a box that is sensed: --obstacle HEIGHTxLENGTH@FROM:TO";
        CliError::unused(&given, allowed)
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
        let given = [
            ("--legs", self.legs.is_some()),
            ("--sought-on", self.sought_on.is_some()),
            ("--generations", self.generations.is_some()),
        ];
        let allowed = "used with a box at one distance: --obstacle HEIGHTxLENGTH@FRONT";
        CliError::unused(&given, allowed)?;
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
            seed: self.seed.seed,
        };
        let threads = self.threads.count().get();
        let refused = |error| refused(error, robot);
        let progress = Progress::new("rounds", sensed.rounds);
        let tables = sensed.plan(threads, |_| progress.advance(1));
        drop(progress);
        let tables = tables.map_err(refused)?;
        // Other robots than those of the table.
        let seed = self.seed.seed.wrapping_add(1 << 32);
        let tried = sensed.try_on(&tables[0], usize::from(self.robots), seed, threads);
        let answer = Answer {
            sensed: &sensed,
            table: &tables[0],
            tried: &tried.map_err(refused)?,
        };
        let report = match self.output.format() {
            Format::Json => format!("{:#}\n", answer.json(self.seed.seed)),
            _ => answer.text(),
        };
        self.output.write_report(report)?;
        Ok(answer.status())
    }
}

fn share(tried: &[Faced]) -> Share {
    Share {
        count: tried.iter().filter(|faced| faced.cleared).count(),
        of: tried.len(),
    }
}

/// What came of one height.
struct Answer<'a> {
    sensed: &'a Sensed,
    table: &'a BoxTable,
    tried: &'a [Faced],
}

impl Answer<'_> {
    fn status(&self) -> Status {
        Status::of(share(self.tried).value() >= ENOUGH)
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
        let short = |x: f64| measured(x, 4);
        let sensed = self.sensed;
        let reach = sensed.robot.sensors.unwrap_or_default().range_reach;
        let head = format!(
            "{}: a box {} m high and {} m long, its front {} to {} m from the axle at rest, sensed \
             from {} m on",
            sensed.robot.name,
            short(self.table.height),
            short(sensed.length),
            short(sensed.fronts[0]),
            short(sensed.fronts[1]),
            short(reach),
        );
        let (cells, runs) = (self.table.cells.len(), sensed.runs * sensed.rounds);
        let mut lines = vec![(
            "table".to_owned(),
            format!("{}, of {}", counted(cells, "cell"), counted(runs, "run")),
        )];
        if sensed.room > 0.0 {
            let room = format!("{} m; nearer, it backs off first", short(sensed.room));
            lines.push(("room to run up".into(), room));
        }
        let (share, on) = (share(self.tried), self.on());
        lines.push(("cleared".into(), in_words(&share)));
        if on.of > 0 {
            let on = format!("{} of these, over {RUNS_ON} m/s 3 s later", in_words(&on));
            lines.push(("run on".into(), on));
        }
        lines.extend(self.margin().lines(self.table.height, share, ENOUGH));
        output::lines(&head, 18, &lines)
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

/// Parser of a flag.
fn room(text: &str) -> Result<f64, String> {
    let number = text.trim().trim_end_matches('m').parse::<f64>().ok();
    number
        .filter(|x| (0.0..=5.0).contains(x))
        .ok_or_else(|| "must be from 0 to 5 m".to_owned())
}
