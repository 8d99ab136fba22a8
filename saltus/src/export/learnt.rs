//! A table that was learnt, as C.

use saltus_controller::c_source::POLICY as HEADER;
use saltus_gait::learn::{Actions, Axis, Tabular, Task};
use saltus_gait::{Decides, GaitError};

use super::c::{comment, fill, number_words};
use super::fingerprint;
use super::numbers::Number;
use crate::learning::Settings;

/// What is written of a table that was learnt.
#[derive(Clone, Debug)]
pub struct LearntTable {
    /// What heads the file.
    pub about: Vec<String>,
    learnt: saltus_gait::Learnt,
}

/// Choices in a line.
const LINE: usize = 48;

impl LearntTable {
    /// `table`, which was learnt with `seed` under `settings`.
    ///
    /// # Errors
    /// [`GaitError`] for a robot that cannot run.
    pub fn new(table: &Tabular, settings: &Settings, seed: u64) -> Result<LearntTable, GaitError> {
        let learnt = settings.policy(table)?;
        let robot = &settings.plant.robot;
        let mut about = vec![
            format!(
                "What seed {seed} learnt in {} by {} on the robot {}, whose file's SHA-256 begins {}.",
                settings.task.name(),
                settings.algorithm.name(),
                robot.name.escape_default(),
                fingerprint(robot)
            ),
            format!(
                "Written by saltus {}; to change it, write it anew.",
                env!("CARGO_PKG_VERSION")
            ),
        ];
        let environment = settings.environment()?;
        let axes = environment.observed().iter();
        let observed: Vec<String> = axes
            .map(|it| format!("{} ({})", it.name, unit(it)))
            .collect();
        about.push(format!("Observed, in this order: {}.", observed.join(", ")));
        about.extend(choices(&learnt.decides, environment.actions()));
        Ok(LearntTable { about, learnt })
    }

    /// `saltus_policy.h`, in C99 with nothing else.
    pub fn c<R: Number>(&self) -> String {
        let steps = self
            .steps::<R>(|from, to, count| format!("    {{{}, {}, {count}}},\n", from.c(), to.c()));
        let firings = self.firings().map_or_else(String::new, |firings| {
            let row = |x: &[f64; 2]| format!("    {{{}, {}}},\n", R::of(x[0]).c(), R::of(x[1]).c());
            format!(
                "\n/* Of each choice: firing angle (rad), valve opening time (s). */\nstatic const saltus_policy_real \
                 saltus_policy_firings[{}][2] = {{\n{}}};\n",
                firings.len(),
                firings.iter().map(row).collect::<String>()
            )
        });
        let data = format!(
            "\nstatic const saltus_policy_steps saltus_policy_axes[{}] = {{\n{steps}}};\nstatic const uint8_t \
             saltus_policy_choices[{}] = {{\n{}}};\nstatic const saltus_policy saltus_policy_learnt = {{saltus_policy_axes, {}, \
             saltus_policy_choices}};\n{firings}",
            self.learnt.axes.len(),
            self.learnt.choices.len(),
            self.rows("    "),
            self.learnt.axes.len()
        );
        let words = [("HEADER", comment(&self.about)), ("DATA", data)];
        fill(HEADER, words.into_iter().chain(number_words::<R>()))
    }

    fn steps<R: Number>(&self, line: impl Fn(R, R, u16) -> String) -> String {
        let axes = self.learnt.axes.iter();
        axes.map(|it| line(R::of(it.from), R::of(it.to), it.count))
            .collect()
    }

    fn rows(&self, indent: &str) -> String {
        let row = |choices: &[u8]| {
            let choices: Vec<String> = choices.iter().map(u8::to_string).collect();
            format!("{indent}{},\n", choices.join(", "))
        };
        self.learnt.choices.chunks(LINE).map(row).collect()
    }

    fn firings(&self) -> Option<&[[f64; 2]]> {
        match &self.learnt.decides {
            Decides::Stride { firings, .. } => Some(firings),
            _ => None,
        }
    }
}

fn unit(axis: &Axis) -> String {
    axis.unit.replace('_', "/")
}

/// What a wheel's angle and rate are.
const LEAN: &str = "The wheel's angle is the lean of leg 0, 0 upright, positive forwards, from -pi to pi; its rate the mean of five readings.";

fn zone() -> String {
    let from = Task::default().zone;
    format!(
        "The leg in the active zone leans from {from} rad to a pitch of the legs more; leg k leans by the angle less k pitches."
    )
}

/// What the choices are.
fn choices(decides: &Decides, actions: &Actions) -> Vec<String> {
    match (decides, actions) {
        (Decides::Zone { period }, _) => vec![
            format!(
                "Asked each {} ms. Choices: 0 no valve is open; 1 the valve of the leg in the active zone is open until asked again.",
                1e3 * period
            ),
            LEAN.into(),
            zone(),
        ],
        (Decides::Stride { .. }, _) => vec![
            "Asked as a leg enters the active zone. A choice is a firing angle (rad), at which lean that leg fires, and a valve".into(),
            "opening time (s), listed below; the leg does not fire where that is 0. The speed is a mean over 20 ms.".into(),
            LEAN.into(),
            zone(),
        ],
        (Decides::Legs, Actions::Choices(names)) => {
            let named = names.iter().enumerate();
            let named: Vec<String> = named.map(|(k, name)| format!("{k} {name}")).collect();
            vec![
                format!("Asked each cycle. Choices, whose valve is open: {}.", named.join(", ")),
                LEAN.into(),
                "An observed number with one step has no part in the choice.".into(),
            ]
        }
        (Decides::Legs, Actions::Values(_)) => Vec::new(),
    }
}
