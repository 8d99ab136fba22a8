//! What a distance and an approach rate mean: the flags that all commands on tables share, and the
//! words of their reports.

use clap::Args;
use saltus::Robot;
use serde_json::{Map, Value, json};

use super::common::note_valve;
use crate::output::{Cell, Table, digits};
use crate::quantity;

/// Flags that say where a jump starts and ends.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct TermFlags {
    /// Where a distance ends: `wheel`, where the wheel touches level ground, or the height (m)
    /// above the foothold to which the wheel's centre comes down; 0 is the thesis' reading [default: wheel]
    #[arg(long, value_name = "wheel|HEIGHT", value_parser = landing_height, allow_hyphen_values = true)]
    pub(crate) landing_height: Option<LandingHeight>,

    /// Valve opening time t_v (s); of no effect for a spring, which has no valve [default: 0.1]
    #[arg(long, value_name = "TIME", value_parser = quantity::time, allow_hyphen_values = true)]
    pub(crate) valve_open: Option<f64>,

    /// Where the stance starts and the approach rate counts: `firing`, at the firing angle, or at
    /// this lean φ₀ (rad) [default: firing]
    #[arg(long, value_name = "firing|ANGLE", value_parser = start_lean, allow_hyphen_values = true)]
    pub(crate) start_lean: Option<StartLean>,
}

/// Where a distance ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum LandingHeight {
    /// Where the wheel touches level ground: its centre is a radius above the foothold.
    Wheel,
    /// Where the wheel's centre comes down to this height (m) above the foothold.
    At(f64),
}

/// Where a stance starts and its approach rate counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum StartLean {
    /// At the firing angle.
    Firing,
    /// At this lean (rad).
    At(f64),
}

impl LandingHeight {
    /// The height (m) of the wheel's centre.
    pub(crate) fn of(self, robot: &Robot) -> f64 {
        match self {
            LandingHeight::Wheel => robot.body.radius,
            LandingHeight::At(height) => height,
        }
    }
}

impl StartLean {
    /// The lean (rad); none at the firing angle.
    pub(crate) fn fixed(self) -> Option<f64> {
        match self {
            StartLean::Firing => None,
            StartLean::At(lean) => Some(lean),
        }
    }
}

impl TermFlags {
    /// Says so where a valve opening time was given for a leg without a valve.
    pub(crate) fn note_valve(self, robot: &Robot) {
        note_valve(robot, self.valve_open.map(|_| "--valve-open"));
    }

    /// The terms for `robot`.
    pub(crate) fn of(self, robot: &Robot) -> Terms {
        Terms::new(
            robot,
            self.landing_height.unwrap_or(LandingHeight::Wheel),
            self.valve_open.unwrap_or(VALVE_OPEN),
            self.start_lean.unwrap_or(StartLean::Firing),
        )
    }
}

/// Valve opening time (s) that is taken where none is given.
pub(crate) const VALVE_OPEN: f64 = 0.1;

/// Columns that say in every row what a table was made for; columns survive every program that
/// reads CSV.
const COLUMNS: [&str; 6] = [
    "valve_open_s",
    "start_lean_rad",
    "landing_height_m",
    "robot",
    "robot_sha256",
    "saltus_version",
];

/// The same of the plant on which the answers hold.
const PLANT_COLUMNS: [&str; 2] = ["plant", "plant_sha256"];

/// Where the jumps of a report start and end.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Terms {
    robot: String,
    fingerprint: String,
    has_valve: bool,
    /// Height of the wheel's centre where the wheel touches level ground (m).
    pub(crate) radius: f64,
    /// Height of the wheel's centre at the landing (m).
    pub(crate) landing_height: f64,
    /// Valve opening time t_v (s).
    pub(crate) valve_open: f64,
    /// Lean at which the stance starts (rad); none: the firing angle.
    pub(crate) start_lean: Option<f64>,
    /// Name and fingerprint of the plant, if there is one.
    plant: Option<[String; 2]>,
}

impl Terms {
    pub(crate) fn new(
        robot: &Robot,
        landing_height: LandingHeight,
        valve_open: f64,
        start: StartLean,
    ) -> Terms {
        Terms {
            robot: robot.name.clone(),
            fingerprint: saltus::export::fingerprint(robot),
            has_valve: robot.leg.drive.has_valve(),
            radius: robot.body.radius,
            landing_height: landing_height.of(robot),
            valve_open,
            start_lean: start.fixed(),
            plant: None,
        }
    }

    /// Of answers that hold on `plant`, if there is one.
    pub(crate) fn on(self, plant: Option<&Robot>) -> Terms {
        let words = |plant: &Robot| [plant.name.clone(), saltus::export::fingerprint(plant)];
        Terms {
            plant: plant.map(words),
            ..self
        }
    }

    /// `table`, whose rows have these firing angles, with the columns that say in every row what it was
    /// made for.
    pub(crate) fn told(
        &self,
        table: Table,
        angles: impl IntoIterator<Item = Option<f64>>,
    ) -> Table {
        let plant = self.plant.iter().flat_map(|_| PLANT_COLUMNS);
        let columns: Vec<&str> = COLUMNS.into_iter().chain(plant).collect();
        let cells = |angle: Option<f64>| {
            let mut cells = vec![
                Cell::from(self.has_valve.then_some(self.valve_open)),
                Cell::from(angle.map(|angle| self.start_lean.unwrap_or(angle))),
                Cell::from(self.landing_height),
                Cell::Text(self.robot.clone()),
                Cell::Text(self.fingerprint.clone()),
                Cell::Word(env!("CARGO_PKG_VERSION")),
            ];
            let plant = self.plant.iter().flatten();
            cells.extend(plant.map(|word| Cell::Text(word.clone())));
            cells
        };
        table.with(&columns, angles.into_iter().map(cells))
    }

    /// What heads a JSON document: the command, and what its numbers were made for.
    pub(crate) fn json(&self, command: &str) -> Map<String, Value> {
        let start = self.start_lean.map_or(json!("firing"), |lean| json!(lean));
        let head = json!({
            "command": command,
            "robot": self.robot,
            "robot_sha256": self.fingerprint,
            "saltus_version": env!("CARGO_PKG_VERSION"),
            "landing_height_m": self.landing_height,
            "start_lean_rad": start,
            "valve_open_s": self.has_valve.then_some(self.valve_open),
        });
        let mut head = head.as_object().cloned().unwrap_or_default();
        for (key, word) in PLANT_COLUMNS.iter().zip(self.plant.iter().flatten()) {
            head.insert((*key).into(), json!(word));
        }
        head
    }

    /// The terms in one line: what a distance and an approach rate are.
    pub(crate) fn line(&self) -> String {
        format!(
            "distance: from the foot to {}; approach rate ω: at {}",
            self.landing(),
            self.start()
        )
    }

    /// Where a distance ends.
    pub(crate) fn landing(&self) -> String {
        let height = digits(self.landing_height, 5);
        let below = self.radius - self.landing_height;
        if below == 0.0 {
            return format!("where the wheel touches (its centre {height} m above the foothold)");
        }
        let side = if below > 0.0 { "below" } else { "above" };
        let off = digits(below.abs(), 5);
        format!(
            "where the wheel's centre is {height} m above the foothold ({off} m {side} where the \
             wheel touches)"
        )
    }

    /// Where a distance ends, for a title.
    pub(crate) fn landing_title(&self) -> String {
        let height = digits(self.landing_height, 4);
        let touches = if self.landing_height == self.radius {
            " (the wheel touches)"
        } else {
            ""
        };
        format!("landing height {height} m{touches}")
    }

    /// Where an approach rate counts.
    pub(crate) fn start(&self) -> String {
        match self.start_lean {
            None => "the firing angle".into(),
            Some(lean) => format!("the start lean {} rad", digits(lean, 5)),
        }
    }
}

/// Parser of a flag.
pub(crate) fn landing_height(text: &str) -> Result<LandingHeight, String> {
    match text {
        "wheel" => Ok(LandingHeight::Wheel),
        _ => quantity::height(text)
            .map(LandingHeight::At)
            .map_err(|error| format!("{error}, or `wheel`")),
    }
}

/// Parser of a flag.
pub(crate) fn start_lean(text: &str) -> Result<StartLean, String> {
    match text {
        "firing" => Ok(StartLean::Firing),
        _ => quantity::angle(text)
            .map(StartLean::At)
            .map_err(|error| format!("{error}, or `firing`")),
    }
}
