//! How a robot in its plane runs: the flags of its gaits.

use std::f64::consts::TAU;
use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};
use saltus::Robot;
use saltus::gait::learn::Task as Course;
use saltus::gait::{Centre, Lines, Program, Setup, Smooth, speed_law};
use saltus::numeric::parallel::available;

use super::values::{
    Knots, Speeds, Taps, knots, rate, shift, slope, speeds, steepness, taps, top_rate,
};
use crate::cli::common::note_valve;
use crate::cli::learned::Learned;
use crate::cli::refused::refused;
use crate::cli::with::With;
use crate::error::CliError;
use crate::output::digits;
use crate::quantity;

/// Gaits of a robot in its plane.
#[derive(Debug, Subcommand)]
pub(super) enum Plane {
    #[command(flatten)]
    Law(With<Law, OfLaw>),
    /// A commanded speed is held: the speed of each firing angle is measured first
    Speed {
        /// Speeds, TIME:SPEED in s and m/s: each is held from its time on, a negative one
        /// backwards, as in 0:1.5,4:3,8:-1. Needs a robot on a boom, whose encoder measures the way
        #[arg(long, value_name = "TIME:SPEED,…", value_parser = speeds, allow_hyphen_values = true)]
        speed: Speeds,

        #[command(flatten)]
        senses: Senses,
    },
    /// What `saltus learn --out` wrote: its best seed runs, on its robot where --robot names no other
    Policy {
        /// The file that `saltus learn --out` wrote
        #[arg(value_name = "FILE.json")]
        file: PathBuf,
    },
}

/// Laws by which a robot in its plane fires: those of `saltus export gait`, too.
#[derive(Debug, Subcommand)]
pub(crate) enum Law {
    /// One firing angle
    Fixed {
        /// Firing angle α_f (rad)
        #[arg(long, visible_alias = "alpha-f", value_name = "ANGLE", value_parser = quantity::angle, allow_hyphen_values = true, default_value = "0.1")]
        firing_angle: f64,

        #[command(flatten)]
        valve: Valve,
    },
    /// The firing angle goes from one to another over time, A tanh(B t − C) + D
    OpenLoop {
        #[command(flatten)]
        tanh: Tanh,

        #[command(flatten)]
        valve: Valve,
    },
    /// The firing angle falls with the rate, by one line or two
    ClosedLoop {
        #[command(flatten)]
        falls: Falls,

        #[command(flatten)]
        valve: Valve,
    },
    /// The firing angle and the valve opening time go through given knots over the rate
    Curve {
        /// Knots, RATE:ANGLE:TIME with commas between them, as in 0:0.35:40ms,13.3:-0.1:40ms; straight lines between knots
        #[arg(long, value_name = "RATE:ANGLE:TIME,…", value_parser = knots, allow_hyphen_values = true)]
        knots: Knots,
    },
    /// One smooth curve over the rate, found by search to be quick from rest or to save gas
    Smooth {
        /// What the law is best at
        #[arg(long, value_enum, default_value = "quick")]
        aim: Aim,
    },
    /// The law that holds a speed, which is measured
    #[command(skip)]
    Speed(Vec<[f64; 2]>),
}

/// Firing angles from which and to which a law goes.
#[derive(Args, Debug)]
pub(crate) struct Ends {
    /// Firing angle (rad) at rest [default: 0.35, of `disc` 0.5, less where legs are close]
    #[arg(long, value_name = "ANGLE", value_parser = quantity::angle, allow_hyphen_values = true)]
    pub(super) from: Option<f64>,

    /// Firing angle (rad) in the end [default: 0, of `closed-loop` -0.1]
    #[arg(long, value_name = "ANGLE", value_parser = quantity::angle, allow_hyphen_values = true)]
    to: Option<f64>,
}

/// The law of `open-loop`, A tanh(B t − C) + D.
#[derive(Args, Debug)]
pub(crate) struct Tanh {
    #[command(flatten)]
    pub(super) ends: Ends,

    /// B (1/s): how steeply the angle changes
    #[arg(long, value_name = "B", value_parser = steepness, allow_hyphen_values = true, default_value = "2.1")]
    steepness: f64,

    /// C, a number or seconds
    #[arg(long, value_name = "C", value_parser = shift, allow_hyphen_values = true, default_value = "3")]
    shift: f64,

    /// How C is read [default: seconds, of `disc` printed]
    #[arg(long, value_enum)]
    centre: Option<Reading>,
}

/// The lines of `closed-loop`.
#[derive(Args, Debug)]
pub(crate) struct Falls {
    #[command(flatten)]
    ends: Ends,

    /// Lines of the firing angle
    #[arg(long, value_enum, default_value = "two")]
    lines: LinesKind,

    /// Rate ω_s (rad/s) at which the second line begins [default: 5]
    #[arg(long, value_name = "RATE", value_parser = rate, allow_hyphen_values = true)]
    switch: Option<f64>,

    /// Slope of the first of two lines (s, that is rad for each rad/s) [default: -0.01]
    #[arg(long, value_name = "SLOPE", value_parser = slope, allow_hyphen_values = true)]
    first_slope: Option<f64>,

    /// Rate ω_f (rad/s) at which the last angle is reached; 13.3 is 3.2 m/s
    #[arg(long, value_name = "RATE", value_parser = top_rate, allow_hyphen_values = true, default_value = "13.3")]
    top_rate: f64,
}

/// How long a valve opens.
#[derive(Args, Debug)]
pub(crate) struct Valve {
    /// Valve opening time t_v (s), as in 40ms [default: 0.04, of `disc` 0.05]
    #[arg(long, value_name = "TIME", value_parser = quantity::time, allow_hyphen_values = true)]
    pub(super) valve_open: Option<f64>,
}

/// Where a leg may fire.
#[derive(Args, Debug)]
pub(crate) struct Zone {
    /// Lean z₀ (rad) at which the active zone begins; it is one pitch of the legs wide [default: 0
    /// for `fixed`, `open-loop` and `speed`, -0.3 for the others, of more than nine legs less]
    #[arg(long, value_name = "ANGLE", value_parser = quantity::angle, allow_hyphen_values = true)]
    pub(super) zone: Option<f64>,
}

/// Where a leg may fire, and how the rate is filtered.
#[derive(Args, Debug)]
pub(crate) struct Senses {
    #[command(flatten)]
    zone: Zone,

    /// Weights of the rate's filter: of the newest reading, then of those before it; at most 16. They
    /// are divided by their sum
    #[arg(long, value_name = "WEIGHTS", value_parser = taps, allow_hyphen_values = true, default_value = "1,1,1,1,1")]
    taps: Taps,
}

/// Flags of a run by a law.
#[derive(Args, Debug)]
pub(super) struct OfLaw {
    #[command(flatten)]
    senses: Senses,

    /// Which way the robot runs
    #[arg(long, value_enum, default_value = "forwards")]
    direction: Direction,
}

/// What a smooth law is best at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Aim {
    /// 1.6 m from rest in the least time
    Quick,
    /// The least gas a metre at 3.2 m/s or more
    Sparing,
}

impl Aim {
    /// The law.
    pub(crate) fn law(self) -> Smooth {
        match self {
            Aim::Quick => Smooth::QUICK,
            Aim::Sparing => Smooth::SPARING,
        }
    }
}

/// How the thesis' C is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Reading {
    /// As a number, tanh(B t − C): the middle of the change is at C/B
    Printed,
    /// As seconds, tanh(B (t − C)): the middle of the change is at C
    Seconds,
}

/// Lines of a closed loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum LinesKind {
    /// One line from rest to the top rate
    One,
    /// Two lines that meet at the switching rate
    Two,
    /// Two lines as printed in the thesis, with a jump at the switching rate
    Jump,
}

/// Direction of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Direction {
    /// Towards positive travel
    Forwards,
    /// The mirror image
    Backwards,
}

/// A run as the flags of its gait set it.
pub(super) struct Chosen {
    pub(super) setup: Setup,
    /// The gait in words.
    pub(super) words: String,
    /// The flags that say its firing angles.
    pub(super) angles: &'static str,
}

impl Plane {
    /// The run for so many `seconds` of the robot that `robot` says, given the one that has learnt.
    pub(super) fn chosen(
        self,
        robot: impl FnOnce(Option<&Robot>) -> Result<Robot, CliError>,
        seconds: f64,
    ) -> Result<Chosen, CliError> {
        let (law, senses, direction) = match self {
            Plane::Law(With { of, flags, .. }) => (of, flags.senses, flags.direction),
            Plane::Speed { speed, senses } => (Law::Speed(speed.0), senses, Direction::Forwards),
            Plane::Policy { file } => {
                let learned = Learned::load(&file)?;
                let robot = robot(Some(learned.robot()))?;
                return learned.chosen(robot, seconds);
            }
        };
        let mut setup = law.setup(robot(None)?, &senses, seconds)?;
        setup.forwards = direction == Direction::Forwards;
        Ok(Chosen {
            words: law.words(&setup),
            angles: law.angles(),
            setup,
        })
    }
}

impl Learned {
    /// What `robot` is to do.
    fn chosen(&self, robot: Robot, seconds: f64) -> Result<Chosen, CliError> {
        let settings = &self.settings;
        let (own, legs) = (self.robot().body.legs, robot.body.legs);
        if own != legs {
            let reason =
                format!("body.legs = {legs}: must be {own}, as the policy was learnt with");
            return Err(CliError::content(&robot.name, reason));
        }
        let program = settings.policy(&self.table).map(Program::Learnt);
        let program = program.map_err(|error| CliError::content("policy", error))?;
        let mut setup = Setup::new(robot, program, seconds);
        setup.zone = Course::default().zone;
        setup.obstacles.clone_from(&settings.plant.obstacles);
        let words = format!(
            "{} by {}, as seed {} learnt it",
            settings.task.name(),
            settings.algorithm.name(),
            self.seed
        );
        Ok(Chosen {
            setup,
            words,
            angles: "policy",
        })
    }
}

impl Tanh {
    /// The program from `first` (rad), where C is read as `usual` unless a flag says otherwise.
    pub(super) fn program(&self, first: f64, usual: Reading) -> Program {
        Program::OpenLoop {
            first,
            last: self.ends.to.unwrap_or(0.0),
            slope: self.steepness,
            centre: match self.centre.unwrap_or(usual) {
                Reading::Printed => Centre::Printed(self.shift),
                Reading::Seconds => Centre::Seconds(self.shift),
            },
        }
    }
}

impl Falls {
    /// The lines from `first` (rad).
    fn program(&self, first: f64) -> Result<Program, CliError> {
        let (last, at) = (self.ends.to.unwrap_or(-0.1), self.top_rate);
        if self.lines == LinesKind::One {
            let given = [
                ("--switch", self.switch.is_some()),
                ("--first-slope", self.first_slope.is_some()),
            ];
            CliError::unused(&given, "used with --lines two or jump, not one")?;
            return Ok(Program::ClosedLoop(Lines::One { first, last, at }));
        }
        let switch = self.switch.unwrap_or(5.0);
        if switch >= at {
            let allowed = format!("below --top-rate, {at} rad/s");
            return Err(CliError::flag("--switch", switch, allowed));
        }
        Ok(Program::ClosedLoop(Lines::Two {
            first,
            slope: self.first_slope.unwrap_or(-0.01),
            switch,
            last,
            at,
            jumps: self.lines == LinesKind::Jump,
        }))
    }
}

impl Law {
    /// The run of `robot` for so many `seconds`.
    pub(crate) fn setup(
        &self,
        robot: Robot,
        senses: &Senses,
        seconds: f64,
    ) -> Result<Setup, CliError> {
        let pitch = TAU / f64::from(robot.body.legs);
        let zone = senses.zone.zone.unwrap_or(match self {
            Law::Fixed { .. } | Law::OpenLoop { .. } | Law::Speed(_) => 0.0,
            // Not half a pitch: the rear leg of a robot that stands would lean by just where the zone ends.
            _ => (-0.3_f64).max(-0.45 * pitch),
        });
        // The legs of a robot that has many are closer than the thesis' angle.
        let from = |ends: &Ends| ends.from.unwrap_or(0.35_f64.min(0.9 * (zone + pitch)));
        let program = match self {
            Law::Fixed { firing_angle, .. } => Program::Fixed {
                firing_angle: *firing_angle,
            },
            Law::OpenLoop { tanh, .. } => tanh.program(from(&tanh.ends), Reading::Seconds),
            Law::ClosedLoop { falls, .. } => falls.program(from(&falls.ends))?,
            Law::Curve { knots } => Program::Curve(knots.0.clone()),
            Law::Smooth { aim } => aim.law().for_legs(robot.body.legs),
            Law::Speed(_) => {
                let law = speed_law(&robot, available());
                Program::Curve(law.map_err(|error| refused(error, &robot, self.angles()))?)
            }
        };
        let mut setup = match (program, self) {
            (Program::Curve(law), Law::Speed(speeds)) => {
                let setup = Setup::holding(&robot, law, speeds, seconds);
                setup.map_err(|error| refused(error, &robot, self.angles()))?
            }
            (program, _) => Setup::new(robot, program, seconds),
        };
        setup.zone = zone;
        setup.taps.clone_from(&senses.taps.0);
        if let Law::Fixed { valve, .. }
        | Law::OpenLoop { valve, .. }
        | Law::ClosedLoop { valve, .. } = self
            && let Some(open) = valve.valve_open
        {
            setup.valve_open = open;
            note_valve(&setup.robot, Some("--valve-open"));
        }
        Ok(setup)
    }

    /// The flags that say its firing angles.
    pub(crate) fn angles(&self) -> &'static str {
        match self {
            Law::Fixed { .. } => "--firing-angle",
            Law::OpenLoop { .. } => "--from, --to",
            Law::ClosedLoop { .. } => "--from, --to, --first-slope, --switch",
            Law::Curve { .. } => "--knots",
            Law::Smooth { .. } => "smooth",
            Law::Speed(_) => "speed",
        }
    }

    /// The law of `setup` in words.
    fn words(&self, setup: &Setup) -> String {
        let short = |x: f64| digits(x, 4);
        let words = match &setup.program {
            Program::Fixed { firing_angle } => {
                format!("fixed, α_f {} rad", short(*firing_angle))
            }
            Program::OpenLoop {
                first,
                last,
                slope,
                centre,
            } => {
                let middle = match centre {
                    Centre::Printed(c) => c / slope,
                    Centre::Seconds(c) => *c,
                };
                let [first, last, middle] = [*first, *last, middle].map(short);
                format!("open-loop, α_f {first} to {last} rad around {middle} s")
            }
            Program::ClosedLoop(Lines::One { first, last, at }) => {
                let [first, last, at] = [*first, *last, *at].map(short);
                format!("closed-loop, one line, α_f {first} to {last} rad at {at} rad/s")
            }
            Program::ClosedLoop(Lines::Two {
                first,
                switch,
                last,
                at,
                jumps,
                ..
            }) => {
                let [first, last, at, switch] = [*first, *last, *at, *switch].map(short);
                let jump = if *jumps { " with a jump" } else { "" };
                format!(
                    "closed-loop, two lines{jump}, α_f {first} to {last} rad at {at} rad/s, switched at {switch} rad/s"
                )
            }
            Program::Learnt(..) => String::new(),
            Program::Curve(law) => {
                return match self {
                    Law::Smooth { aim: Aim::Quick } => "smooth, quick from rest".into(),
                    Law::Smooth { .. } => "smooth, sparing of gas".into(),
                    Law::Speed(_) => format!(
                        "speed, by a law measured from {} to {} m/s",
                        short(law.get(1).map_or(0.0, |knot| knot[0])),
                        short(law.last().map_or(0.0, |knot| knot[0]))
                    ),
                    _ => format!("curve of {} knots", law.len()),
                };
            }
        };
        format!("{words}, valve open {} ms", short(setup.valve_open * 1e3))
    }
}
