//! `saltus export c --gait`: what decides on a running robot.

use clap::{Args, ValueEnum};
use saltus::Robot;
use saltus::export::{BallFiles, Number, Running};
use saltus::gait::space::{Stable, Steered};
use saltus::gait::{Centre, Lines, Program, Setup};

use crate::cli::common::note_valve;
use crate::cli::refused::refused;
use crate::cli::run::Aim;
use crate::cli::run::values::{Knots, Taps, knots, taps};
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
    /// Given knots over the rate
    Curve,
    /// One smooth curve over the rate
    Smooth,
    /// A commanded speed, which saltus_runner_demand sets; the speed of each firing angle is measured first
    Speed,
    /// A robot in space kept in its plane, as by `saltus run`
    DiscStable,
    /// A robot in space led along a path, as by `saltus run`
    Steer,
}

/// Lines of a closed loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum LinesKind {
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
        "start_lean", "valve_range", "newton", "extra_delay", "tolerance", "plant",
        "plant_overrides"])]
    gait: Option<Kind>,

    /// Lines of `closed-loop` [default: two]
    #[arg(long, value_enum)]
    lines: Option<LinesKind>,

    /// Firing angle (rad) of `fixed` [default: 0.1]
    #[arg(long, value_name = "ANGLE", value_parser = quantity::angle, allow_hyphen_values = true)]
    firing_angle: Option<f64>,

    /// Firing angle (rad) at rest, of `open-loop` and `closed-loop` [default: 0.35]
    #[arg(long, value_name = "ANGLE", value_parser = quantity::angle, allow_hyphen_values = true)]
    from: Option<f64>,

    /// Firing angle (rad) in the end [default: 0 for `open-loop`, -0.1 for `closed-loop`]
    #[arg(long, value_name = "ANGLE", value_parser = quantity::angle, allow_hyphen_values = true)]
    to: Option<f64>,

    /// Knots of `curve`, RATE:ANGLE:TIME with commas between them
    #[arg(long, value_name = "RATE:ANGLE:TIME,…", value_parser = knots, allow_hyphen_values = true)]
    knots: Option<Knots>,

    /// What the law of `smooth` is best at [default: quick]
    #[arg(long, value_enum)]
    aim: Option<Aim>,

    /// Lean z₀ (rad) at which the active zone begins; it is one pitch of the legs wide [default: 0
    /// for `fixed`, `open-loop` and `speed`, -0.3 for the others]
    #[arg(long, value_name = "ANGLE", value_parser = quantity::angle, allow_hyphen_values = true)]
    zone: Option<f64>,

    /// Weights of the filter on the rate, the newest first, divided by their sum [default: a mean of five]
    #[arg(long, value_name = "WEIGHTS", value_parser = taps, allow_hyphen_values = true)]
    taps: Option<Taps>,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Kind::Fixed => "fixed",
            Kind::OpenLoop => "open-loop",
            Kind::ClosedLoop => "closed-loop",
            Kind::Curve => "curve",
            Kind::Smooth => "smooth",
            Kind::Speed => "speed",
            Kind::DiscStable => "disc-stable",
            Kind::Steer => "steer",
        }
    }

    /// Whether the law says how long a valve opens.
    fn has_times(self) -> bool {
        !matches!(self, Kind::Fixed | Kind::OpenLoop | Kind::ClosedLoop)
    }
}

impl RunningFlags {
    /// What is written for a ball, if one is asked for; its valves' times are its gait's own, without `valve_open`.
    pub(super) fn ball<R: Number>(
        &self,
        robot: impl FnOnce() -> Result<Robot, CliError>,
        valve_open: Option<f64>,
    ) -> Result<Option<BallFiles>, CliError> {
        let Some(gait @ (Kind::DiscStable | Kind::Steer)) = self.gait else {
            return Ok(None);
        };
        self.meant(valve_open)?;
        let robot = robot()?;
        let written = if gait == Kind::Steer {
            BallFiles::steered::<R>(&robot, &Steered::towards(0.0))
        } else {
            BallFiles::new::<R>(&robot, &Stable::default())
        };
        let wrong = |error| CliError::content(&robot.name, error);
        written.map(Some).map_err(wrong)
    }

    /// What is written for a robot whose valve opens for `valve_open` (s), if a gait is asked for; speeds
    /// are measured on so many `threads`.
    pub(super) fn written<R: Number>(
        &self,
        robot: impl FnOnce() -> Result<Robot, CliError>,
        valve_open: Option<f64>,
        threads: usize,
    ) -> Result<Option<Running>, CliError> {
        self.meant(valve_open)?;
        let Some(gait) = self.gait else {
            return Ok(None);
        };
        let robot = robot()?;
        note_valve(&robot, valve_open.map(|_| "--valve-open"));
        let mut setup = self.setup(gait, robot, threads)?;
        setup.valve_open = valve_open.unwrap_or(setup.valve_open);
        let written = Running::new::<R>(&setup);
        written
            .map(Some)
            .map_err(|error| CliError::content(&setup.robot.name, error))
    }

    fn setup(&self, gait: Kind, robot: Robot, threads: usize) -> Result<Setup, CliError> {
        let mut setup = if gait == Kind::Speed {
            let held = Setup::at_speeds(&robot, &[], 1.0, threads);
            held.map_err(|error| refused(error, &robot))?
        } else {
            Setup::new(robot, self.program(gait)?, 1.0)
        };
        let begins = match gait {
            Kind::Fixed | Kind::OpenLoop | Kind::Speed => 0.0,
            _ => -0.3,
        };
        setup.zone = self.zone.unwrap_or(begins);
        if let Some(taps) = &self.taps {
            setup.taps.clone_from(&taps.0);
        }
        Ok(setup)
    }

    /// Refuses flags that only other gaits have.
    fn meant(&self, valve_open: Option<f64>) -> Result<(), CliError> {
        use Kind::{ClosedLoop, Curve, Fixed, OpenLoop, Smooth, Speed};
        let all = [Fixed, OpenLoop, ClosedLoop, Curve, Smooth, Speed];
        let given: [(&'static str, bool, &[Kind]); 8] = [
            ("--lines", self.lines.is_some(), &[ClosedLoop]),
            ("--firing-angle", self.firing_angle.is_some(), &[Fixed]),
            ("--from", self.from.is_some(), &[OpenLoop, ClosedLoop]),
            ("--to", self.to.is_some(), &[OpenLoop, ClosedLoop]),
            ("--knots", self.knots.is_some(), &[Curve]),
            ("--aim", self.aim.is_some(), &[Smooth]),
            ("--zone", self.zone.is_some(), &all),
            ("--taps", self.taps.is_some(), &all),
        ];
        for (flag, is_given, kinds) in given {
            if is_given && !self.gait.is_some_and(|gait| kinds.contains(&gait)) {
                let names: Vec<&str> = kinds.iter().map(|kind| kind.name()).collect();
                let allowed = format!("used with --gait {}", names.join(" or "));
                return Err(CliError::flag(flag, "", allowed));
            }
        }
        if let Some(gait) = self
            .gait
            .filter(|gait| gait.has_times() && valve_open.is_some())
        {
            let name = gait.name();
            let allowed = format!("left out with --gait {name}, whose law says the time");
            return Err(CliError::flag("--valve-open", "", allowed));
        }
        Ok(())
    }

    /// The law.
    fn program(&self, gait: Kind) -> Result<Program, CliError> {
        let first = self.from.unwrap_or(0.35);
        let (last, at) = (self.to.unwrap_or(-0.1), 13.3);
        Ok(match (gait, self.lines) {
            (Kind::Curve, _) => {
                let knots = self.knots.as_ref().ok_or(CliError::Missing {
                    flag: "--knots",
                    allowed: "--gait curve needs RATE:ANGLE:TIME, as in 0:0.35:40ms,13.3:-0.1:40ms",
                })?;
                Program::Curve(knots.0.clone())
            }
            (Kind::Smooth | Kind::Speed, _) => self.aim.unwrap_or(Aim::Quick).law().program(),
            // Of a ball nothing of this is used: see `ball`.
            (Kind::DiscStable | Kind::Steer, _) => Program::Fixed {
                firing_angle: self.zone.unwrap_or(-0.3),
            },
            (Kind::Fixed, _) => Program::Fixed {
                firing_angle: self.firing_angle.unwrap_or(0.1),
            },
            (Kind::OpenLoop, _) => Program::OpenLoop {
                first,
                last: self.to.unwrap_or(0.0),
                slope: 2.1,
                centre: Centre::Seconds(3.0),
            },
            (Kind::ClosedLoop, Some(LinesKind::One)) => {
                Program::ClosedLoop(Lines::One { first, last, at })
            }
            (Kind::ClosedLoop, lines) => Program::ClosedLoop(Lines::Two {
                first,
                slope: -0.01,
                switch: 5.0,
                last,
                at,
                jumps: lines == Some(LinesKind::Jump),
            }),
        })
    }
}
