//! How a robot in its plane runs: the flags of its gaits.

use std::f64::consts::TAU;
use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};
use saltus::Robot;
use saltus::gait::learn::Task as Course;
use saltus::gait::{Centre, Lines, Obstacle, Program, Smooth, speed_law};
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
    Speed(Speed),
    /// What `saltus learn --out` wrote: its best seed runs, on its robot where --robot names no other
    Policy(Policy),
}

/// Laws by which a robot in its plane fires: those of `saltus export gait`, too.
#[derive(Debug, Subcommand)]
pub(crate) enum Law {
    /// One firing angle
    Fixed(Fixed),
    /// The firing angle goes from one to another over time, A tanh(B t − C) + D
    OpenLoop(OpenLoop),
    /// The firing angle falls with the rate, by one line or two
    ClosedLoop(ClosedLoop),
    /// The firing angle and the valve opening time go through given knots over the rate
    Curve(Curve),
    /// One smooth curve over the rate, found by search to be quick from rest or to save gas
    Smooth(OfSmooth),
    /// The law that holds a speed, which is measured
    #[command(skip)]
    Speed,
}

#[derive(Args, Debug)]
pub(crate) struct Fixed {
    /// Firing angle α_f (rad)
    #[arg(long, visible_alias = "alpha-f", value_name = "ANGLE", value_parser = quantity::angle, allow_hyphen_values = true, default_value = "0.1")]
    firing_angle: f64,

    #[command(flatten)]
    valve: Valve,
}

#[derive(Args, Debug)]
pub(crate) struct OpenLoop {
    #[command(flatten)]
    tanh: Tanh,

    #[command(flatten)]
    valve: Valve,
}

#[derive(Args, Debug)]
pub(crate) struct ClosedLoop {
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

    #[command(flatten)]
    valve: Valve,
}

#[derive(Args, Debug)]
pub(crate) struct Curve {
    /// Knots, RATE:ANGLE:TIME with commas between them, as in 0:0.35:40ms,13.3:-0.1:40ms; straight lines between knots
    #[arg(long, value_name = "RATE:ANGLE:TIME,…", value_parser = knots, allow_hyphen_values = true)]
    knots: Knots,
}

#[derive(Args, Debug)]
pub(crate) struct OfSmooth {
    /// What the law is best at
    #[arg(long, value_enum, default_value = "quick")]
    aim: Aim,
}

#[derive(Args, Debug)]
pub(super) struct Speed {
    /// Speeds, TIME:SPEED in s and m/s: each is held from its time on, a negative one
    /// backwards, as in 0:1.5,4:3,8:-1. Needs a robot on a boom, whose encoder measures the way
    #[arg(long, value_name = "TIME:SPEED,…", value_parser = speeds, allow_hyphen_values = true)]
    speed: Speeds,

    #[command(flatten)]
    senses: Senses,
}

#[derive(Args, Debug)]
pub(super) struct Policy {
    /// The file that `saltus learn --out` wrote
    #[arg(value_name = "FILE.json")]
    file: PathBuf,
}

/// Firing angles from which and to which a law goes.
#[derive(Args, Debug)]
pub(super) struct Ends {
    /// Firing angle (rad) at rest [default: 0.35, of `disc` 0.5, less where legs are close]
    #[arg(long, value_name = "ANGLE", value_parser = quantity::angle, allow_hyphen_values = true)]
    pub(super) from: Option<f64>,

    /// Firing angle (rad) in the end [default: 0, of `closed-loop` -0.1]
    #[arg(long, value_name = "ANGLE", value_parser = quantity::angle, allow_hyphen_values = true)]
    pub(super) to: Option<f64>,
}

/// The law of `open-loop`, A tanh(B t − C) + D.
#[derive(Args, Debug)]
pub(super) struct Tanh {
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

/// How long a valve opens.
#[derive(Args, Debug)]
pub(super) struct Valve {
    /// Valve opening time t_v (s), as in 40ms [default: 0.04, of `disc` 0.05]
    #[arg(long, value_name = "TIME", value_parser = quantity::time, allow_hyphen_values = true)]
    pub(super) valve_open: Option<f64>,
}

/// Where a leg may fire.
#[derive(Args, Debug)]
pub(super) struct Zone {
    /// Lean z₀ (rad) at which the active zone begins; it is one pitch of the legs wide [default: 0
    /// for `fixed`, `open-loop` and `speed`, -0.3 for the others, but at most half a pitch]
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

/// What the flags give.
#[derive(Clone, Debug)]
pub(super) struct Chosen {
    pub(super) program: Program,
    /// Valve opening time (s).
    pub(super) valve_open: f64,
    /// Where the zone begins (rad).
    pub(super) zone: f64,
    pub(super) forwards: bool,
    pub(super) taps: Vec<f64>,
    /// Commanded speeds: from each time (s) on, a speed (m/s).
    pub(super) speeds: Vec<[f64; 2]>,
    /// The gait in words.
    pub(super) words: String,
    /// The boxes of what was learnt.
    pub(super) obstacles: Vec<Obstacle>,
}

impl Plane {
    /// The robot that runs and what it is to do; `robot` says which one, given the one that has learnt.
    pub(super) fn chosen(
        self,
        robot: impl FnOnce(Option<&Robot>) -> Result<Robot, CliError>,
    ) -> Result<(Robot, Chosen), CliError> {
        let (law, senses, direction, speeds) = match self {
            Plane::Law(With { of, flags, .. }) => (of, flags.senses, flags.direction, Vec::new()),
            Plane::Speed(it) => (Law::Speed, it.senses, Direction::Forwards, it.speed.0),
            Plane::Policy(it) => {
                let learned = Learned::load(&it.file)?;
                let robot = robot(Some(learned.robot()))?;
                let chosen = learned.chosen(&robot)?;
                return Ok((robot, chosen));
            }
        };
        let robot = robot(None)?;
        let (program, zone) = law.found(&robot, &senses)?;
        let chosen = Chosen {
            words: law.words(&program),
            valve_open: law.valve_open().unwrap_or(0.04),
            program,
            zone,
            forwards: direction == Direction::Forwards,
            taps: senses.taps.0,
            speeds,
            obstacles: Vec::new(),
        };
        Ok((robot, chosen))
    }
}

impl Learned {
    /// What `robot` is to do.
    pub(super) fn chosen(&self, robot: &Robot) -> Result<Chosen, CliError> {
        let settings = &self.settings;
        let (own, legs) = (self.robot().body.legs, robot.body.legs);
        if own != legs {
            let reason =
                format!("body.legs = {legs}: must be {own}, as the policy was learnt with");
            return Err(CliError::content(&robot.name, reason));
        }
        let program = settings.policy(&self.table).map(Program::Learnt);
        let words = format!(
            "{} by {}, as seed {} learnt it",
            settings.task.name(),
            settings.algorithm.name(),
            self.seed
        );
        Ok(Chosen {
            program: program.map_err(|error| CliError::content("policy", error))?,
            valve_open: 0.04,
            zone: Course::default().zone,
            forwards: true,
            taps: vec![0.2; 5],
            speeds: Vec::new(),
            words,
            obstacles: settings.plant.obstacles.clone(),
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

impl ClosedLoop {
    /// The lines from `first` (rad).
    fn lines(&self, first: f64) -> Result<Lines, CliError> {
        let (last, at) = (self.ends.to.unwrap_or(-0.1), self.top_rate);
        if self.lines == LinesKind::One {
            let given = [
                ("--switch", self.switch.is_some()),
                ("--first-slope", self.first_slope.is_some()),
            ];
            CliError::unused(&given, "used with --lines two or jump, not one")?;
            return Ok(Lines::One { first, last, at });
        }
        let switch = self.switch.unwrap_or(5.0);
        if switch >= at {
            let allowed = format!("below --top-rate, {at} rad/s");
            return Err(CliError::flag("--switch", switch, allowed));
        }
        Ok(Lines::Two {
            first,
            slope: self.first_slope.unwrap_or(-0.01),
            switch,
            last,
            at,
            jumps: self.lines == LinesKind::Jump,
        })
    }
}

impl Senses {
    /// Weights of the rate's filter.
    pub(crate) fn taps(&self) -> Vec<f64> {
        self.taps.0.clone()
    }
}

impl Law {
    /// Valve opening time (s), where a flag says it.
    pub(crate) fn valve_open(&self) -> Option<f64> {
        let valve = match self {
            Law::Fixed(law) => &law.valve,
            Law::OpenLoop(law) => &law.valve,
            Law::ClosedLoop(law) => &law.valve,
            Law::Curve(_) | Law::Smooth(_) | Law::Speed => return None,
        };
        valve.valve_open
    }

    /// The law for `robot`, and where its zone begins (rad).
    pub(crate) fn found(&self, robot: &Robot, senses: &Senses) -> Result<(Program, f64), CliError> {
        let legs = robot.body.legs;
        if !(3..=12).contains(&legs) {
            let reason = format!("body.legs = {legs}: must be from 3 to 12, for a robot that runs");
            return Err(CliError::content(&robot.name, reason));
        }
        let open = self.valve_open();
        if let Some(open) = open.filter(|open| *open > 1.0) {
            let open = format!("{} s", digits(open, 6));
            return Err(CliError::flag("--valve-open", open, "from 0 to 1 s"));
        }
        note_valve(robot, open.map(|_| "--valve-open"));
        let half = 0.5 * TAU / f64::from(legs);
        let zone = senses.zone.zone.unwrap_or(match self {
            Law::Fixed(_) | Law::OpenLoop(_) | Law::Speed => 0.0,
            _ => (-0.3_f64).max(-half),
        });
        if zone.abs() > half {
            let half = digits(half, 4);
            let allowed = format!("from -{half} to {half} rad, half a pitch of the legs");
            return Err(CliError::flag("--zone", format!("{zone} rad"), allowed));
        }
        // The legs of a robot that has many are closer than the thesis' angle.
        let close = 0.35_f64.min(0.9 * (zone + 2.0 * half));
        let program = match self {
            Law::Fixed(Fixed { firing_angle, .. }) => Program::Fixed {
                firing_angle: *firing_angle,
            },
            Law::OpenLoop(law) => {
                let first = law.tanh.ends.from.unwrap_or(close);
                law.tanh.program(first, Reading::Seconds)
            }
            Law::ClosedLoop(law) => Program::ClosedLoop(law.lines(law.ends.from.unwrap_or(close))?),
            Law::Curve(law) => Program::Curve(law.knots.0.clone()),
            Law::Smooth(law) => law.aim.law().program(),
            Law::Speed => {
                let law = speed_law(robot, available());
                Program::Curve(law.map_err(|error| refused(error, robot))?)
            }
        };
        self.within(&program, (zone, 2.0 * half))?;
        Ok((program, zone))
    }

    /// Refuses angles that lie outside the active zone.
    fn within(&self, program: &Program, (zone, pitch): (f64, f64)) -> Result<(), CliError> {
        let angles: Vec<(&'static str, f64)> = match program {
            Program::Fixed { firing_angle } => vec![("--firing-angle", *firing_angle)],
            Program::OpenLoop { first, last, .. }
            | Program::ClosedLoop(Lines::One { first, last, .. }) => {
                vec![("--from", *first), ("--to", *last)]
            }
            Program::ClosedLoop(lines @ Lines::Two { first, last, .. }) => {
                let knots = lines.knots().into_iter();
                let knots = knots.map(|[_, angle]| ("--first-slope, --switch", angle));
                let ends = [("--from", *first), ("--to", *last)];
                ends.into_iter().chain(knots).collect()
            }
            Program::Curve(knots) => {
                let flag = match self {
                    Law::Smooth(_) => "smooth",
                    Law::Speed => "speed",
                    _ => "--knots",
                };
                knots.iter().map(|knot| (flag, knot[1])).collect()
            }
            Program::Learnt(..) => Vec::new(),
        };
        for (flag, angle) in angles {
            if !(zone..zone + pitch).contains(&angle) {
                let allowed = format!(
                    "in the active zone, from {zone} to below {} rad (--zone moves it)",
                    digits(zone + pitch, 5)
                );
                let value = match flag {
                    "--first-slope, --switch" | "smooth" | "speed" => {
                        format!("(α_f {} rad)", digits(angle, 6))
                    }
                    _ => format!("{} rad", digits(angle, 6)),
                };
                return Err(CliError::flag(flag, value, allowed));
            }
        }
        Ok(())
    }

    /// The law in words, and how long its valve opens.
    fn words(&self, program: &Program) -> String {
        let short = |x: f64| digits(x, 4);
        let words = match program {
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
                format!(
                    "open-loop, α_f {} to {} rad around {} s",
                    short(*first),
                    short(*last),
                    short(middle)
                )
            }
            Program::ClosedLoop(Lines::One { first, last, at }) => format!(
                "closed-loop, one line, α_f {} to {} rad at {} rad/s",
                short(*first),
                short(*last),
                short(*at)
            ),
            Program::ClosedLoop(Lines::Two {
                first,
                switch,
                last,
                at,
                jumps,
                ..
            }) => format!(
                "closed-loop, two lines{}, α_f {} to {} rad at {} rad/s, switched at {} rad/s",
                if *jumps { " with a jump" } else { "" },
                short(*first),
                short(*last),
                short(*at),
                short(*switch)
            ),
            Program::Learnt(..) => String::new(),
            Program::Curve(law) => {
                return match self {
                    Law::Smooth(OfSmooth { aim: Aim::Quick }) => "smooth, quick from rest".into(),
                    Law::Smooth(_) => "smooth, sparing of gas".into(),
                    Law::Speed => format!(
                        "speed, by a law measured from {} to {} m/s",
                        short(law.get(1).map_or(0.0, |knot| knot[0])),
                        short(law.last().map_or(0.0, |knot| knot[0]))
                    ),
                    _ => format!("curve of {} knots", law.len()),
                };
            }
        };
        let open = self.valve_open().unwrap_or(0.04);
        format!("{words}, valve open {} ms", digits(open * 1e3, 4))
    }
}
