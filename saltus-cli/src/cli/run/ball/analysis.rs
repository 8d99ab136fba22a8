//! A plain roll of a ball as a map of half a turn: its report.

use std::fmt::Write as _;

use saltus::Robot;
use saltus::gait::GaitError;
use saltus::gait::space::Stable;
use saltus::gait::space::stride::{Cost, Multiplier, Roller, Slopes};
use serde_json::{Value, json};

use super::refused;
use crate::cli::Status;
use crate::cli::run::Run;
use crate::cli::run::analysis::Depth;
use crate::error::CliError;
use crate::output::{self, Format, digits};

/// Time steps (s) of a quick and of a full analysis.
const STEPS: [f64; 2] = [2e-4, 2.5e-5];
/// Part of the sizes of what is off, in differences: with both twins on the ground, as near to none as steps allow.
const SMALL: f64 = 0.05;

/// What is told of a plain roll.
struct Analysis {
    step: f64,
    /// Of ten half turns.
    cost: Cost,
    /// Greatest roll (rad) from which it comes back.
    basin: f64,
    slopes: Slopes,
}

impl Run {
    /// Analyses the plain roll of `robot`.
    pub(super) fn analysed_ball(&self, robot: &Robot, depth: Depth) -> Result<Status, CliError> {
        self.can_analyse_a_ball()?;
        let step = STEPS[usize::from(depth == Depth::Full)];
        let found = analysis(robot, step).map_err(|error| refused(error, robot))?;
        let status = if found.is_some() {
            Status::Done
        } else {
            Status::No
        };
        let report = match (self.output.format(), found) {
            (Format::Json, Some(found)) => output::json(&found.report(robot)),
            (Format::Json, None) => output::json(&json!({
                "command": "run",
                "robot": robot.name,
                "analysis": "plain roll",
                "rolls_on": false,
            })),
            (_, Some(found)) => found.text(robot),
            (_, None) => format!(
                "{}: does not roll on by disc-stable with twins alike: there is nothing to analyse\n",
                robot.name
            ),
        };
        self.output.write_report(report)?;
        Ok(status)
    }
}

/// That of `robot` in steps of `step` (s); none if it does not roll on.
fn analysis(robot: &Robot, step: f64) -> Result<Option<Analysis>, GaitError> {
    let roller = Roller::new(robot, &Stable::default(), step)?;
    let Some(start) = roller.periodic()? else {
        return Ok(None);
    };
    let (Some(cost), Some(slopes)) = (roller.costs(&start)?, roller.slopes(&start, SMALL)?) else {
        return Ok(None);
    };
    Ok(Some(Analysis {
        step,
        cost,
        basin: roller.basin(&start)?,
        slopes,
    }))
}

impl Analysis {
    /// Each part of the energy of a metre (J), with its name.
    fn a_metre(&self) -> [(&'static str, f64); 4] {
        let Cost {
            way,
            work,
            legs,
            ground,
            stops,
            ..
        } = self.cost;
        [
            ("work of the legs", work / way),
            ("lost in legs", legs / way),
            ("lost in feet and ground", ground / way),
            ("lost at ends of strokes", stops / way),
        ]
    }

    fn text(&self, robot: &Robot) -> String {
        let step = digits(1e3 * self.step, 3);
        let mut text = format!(
            "{}: a plain roll by disc-stable, twins alike, steps of {step} ms\n",
            robot.name
        );
        let mut line = |name: &str, what: String| {
            let _ = writeln!(text, "  {name:<24} {what}");
        };
        line(
            "speed",
            format!("{} m/s", digits(self.cost.way / self.cost.time, 4)),
        );
        for (name, energy) in self.a_metre() {
            line(name, format!("{} J a metre", digits(energy, 3)));
        }
        line(
            "comes back from",
            format!("rolls of up to {} mrad", digits(1e3 * self.basin, 2)),
        );
        line(
            "off 1 by symmetry",
            format!("{:.1e}", self.slopes.neutral()),
        );
        let _ = writeln!(
            text,
            "  multipliers of half a turn, of what is so little off that both twins touch:"
        );
        for Multiplier { value, kind } in self.slopes.multipliers() {
            let turns = if value.im == 0.0 {
                String::new()
            } else {
                format!(" {:+.4} i", value.im)
            };
            let _ = writeln!(text, "    {kind:<22} {:.4}{turns}", value.re);
        }
        text
    }

    fn report(&self, robot: &Robot) -> Value {
        let all = self.slopes.multipliers();
        let each =
            |one: &Multiplier| json!({ "of": one.kind, "re": one.value.re, "im": one.value.im });
        let energies: serde_json::Map<String, Value> = self
            .a_metre()
            .iter()
            .map(|(name, energy)| {
                (
                    format!("{}_j_per_m", name.replace(' ', "_")),
                    (*energy).into(),
                )
            })
            .collect();
        json!({
            "command": "run",
            "robot": robot.name,
            "analysis": "plain roll",
            "rolls_on": true,
            "step_s": self.step,
            "speed_m_s": self.cost.way / self.cost.time,
            "energy": energies,
            "comes_back_from_rad": self.basin,
            "neutral_off_1": self.slopes.neutral(),
            "multipliers_of_half_a_turn": all.iter().map(each).collect::<Vec<Value>>(),
            "twins": self.slopes.twins.as_slice(),
        })
    }
}
