//! `saltus export c --gait`: what decides on a running robot.

use clap::{Args, ValueEnum};
use saltus::Robot;
use saltus::export::{Number, Running};
use saltus::gait::{Centre, Lines, Program, Setup};

use crate::cli::common::note_valve;
use crate::error::CliError;
use crate::quantity;

/// How the firing angle of a running robot is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Kind {
    /// One firing angle
    Fixed,
    /// From one firing angle to another over time, A tanh(B (t − C)) + D with B = 2.1/s, C = 3 s
    OpenLoop,
    /// Lines over the rate
    ClosedLoop,
}

/// Lines of a closed loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Law {
    /// One line from rest to 13.3 rad/s
    One,
    /// Two lines that meet at 5 rad/s; the first falls by 0.01 rad for each rad/s
    Two,
    /// Two lines with the thesis' jump at 5 rad/s
    Jump,
}

/// How a robot runs.
#[derive(Args, Debug)]
#[command(next_help_heading = "Running")]
pub(super) struct RunningFlags {
    /// Write what decides on a running robot, in place of tables of jumps
    #[arg(long, value_enum, value_name = "GAIT", conflicts_with_all = ["distance", "omega", "alpha_f", "landing_height",
        "start_lean", "valve_range", "effort", "newton", "period", "extra_delay", "tolerance", "threads", "plant",
        "plant_overrides"])]
    gait: Option<Kind>,

    /// Lines of `closed-loop` [default: two]
    #[arg(long, value_enum, value_name = "LAW")]
    law: Option<Law>,

    /// Firing angle (rad) of `fixed` [default: 0.1]
    #[arg(long, value_name = "ANGLE", value_parser = quantity::angle, allow_hyphen_values = true)]
    firing_angle: Option<f64>,

    /// Firing angle (rad) at rest, of `open-loop` and `closed-loop` [default: 0.35]
    #[arg(long, value_name = "ANGLE", value_parser = quantity::angle, allow_hyphen_values = true)]
    from: Option<f64>,

    /// Firing angle (rad) in the end [default: 0 for `open-loop`, -0.1 for `closed-loop`]
    #[arg(long, value_name = "ANGLE", value_parser = quantity::angle, allow_hyphen_values = true)]
    to: Option<f64>,

    /// Lean z₀ (rad) at which the active zone begins; it is one pitch of the legs wide [default: 0
    /// for `fixed` and `open-loop`, -0.3 for `closed-loop`]
    #[arg(long, value_name = "ANGLE", value_parser = quantity::angle, allow_hyphen_values = true)]
    zone: Option<f64>,
}

impl RunningFlags {
    /// What is written for a robot whose valve opens for `valve_open` (s); none where no gait is
    /// asked for.
    pub(super) fn written<R: Number>(
        &self,
        robot: impl FnOnce() -> Result<Robot, CliError>,
        valve_open: Option<f64>,
    ) -> Result<Option<Running>, CliError> {
        self.meant()?;
        let Some(gait) = self.gait else {
            return Ok(None);
        };
        let robot = robot()?;
        note_valve(&robot, valve_open.map(|_| "--valve-open"));
        let name = robot.name.clone();
        let mut setup = Setup::new(robot, self.program(gait), 1.0);
        let begins = match gait {
            Kind::Fixed | Kind::OpenLoop => 0.0,
            Kind::ClosedLoop => -0.3,
        };
        setup.zone = self.zone.unwrap_or(begins);
        setup.valve_open = valve_open.unwrap_or(setup.valve_open);
        let written = Running::new::<R>(&setup);
        written
            .map(Some)
            .map_err(|error| CliError::content(name, error))
    }

    /// Refuses flags that only other gaits have.
    fn meant(&self) -> Result<(), CliError> {
        use Kind::{ClosedLoop, Fixed, OpenLoop};
        let given: [(&'static str, bool, &[Kind], &str); 5] = [
            ("--law", self.law.is_some(), &[ClosedLoop], " closed-loop"),
            (
                "--firing-angle",
                self.firing_angle.is_some(),
                &[Fixed],
                " fixed",
            ),
            (
                "--from",
                self.from.is_some(),
                &[OpenLoop, ClosedLoop],
                " open-loop or closed-loop",
            ),
            (
                "--to",
                self.to.is_some(),
                &[OpenLoop, ClosedLoop],
                " open-loop or closed-loop",
            ),
            (
                "--zone",
                self.zone.is_some(),
                &[Fixed, OpenLoop, ClosedLoop],
                "",
            ),
        ];
        for (flag, is_given, kinds, names) in given {
            if is_given && !self.gait.is_some_and(|gait| kinds.contains(&gait)) {
                return Err(CliError::flag(flag, "", format!("used with --gait{names}")));
            }
        }
        Ok(())
    }

    fn program(&self, gait: Kind) -> Program {
        let first = self.from.unwrap_or(0.35);
        let (last, at) = (self.to.unwrap_or(-0.1), 13.3);
        match (gait, self.law) {
            (Kind::Fixed, _) => Program::Fixed {
                firing_angle: self.firing_angle.unwrap_or(0.1),
            },
            (Kind::OpenLoop, _) => Program::OpenLoop {
                first,
                last: self.to.unwrap_or(0.0),
                slope: 2.1,
                centre: Centre::Seconds(3.0),
            },
            (Kind::ClosedLoop, Some(Law::One)) => {
                Program::ClosedLoop(Lines::One { first, last, at })
            }
            (Kind::ClosedLoop, law) => Program::ClosedLoop(Lines::Two {
                first,
                slope: -0.01,
                switch: 5.0,
                last,
                at,
                jumps: law == Some(Law::Jump),
            }),
        }
    }
}
