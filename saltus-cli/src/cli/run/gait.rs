//! How a robot runs: the flags of its gait.

use std::f64::consts::TAU;
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use saltus::Robot;
use saltus::gait::learn::Task as Course;
use saltus::gait::{Centre, Lines, Obstacle, Program, Smooth, speed_law};
use saltus::numeric::parallel::available;

use super::values::{
    Knots, Speeds, Taps, knots, rate, shift, slope, speeds, steepness, taps, top_rate,
};
use crate::cli::common::seed;
use crate::cli::learned::Learned;
use crate::cli::refused::refused;
use crate::error::CliError;
use crate::output::digits;
use crate::quantity;

/// Gaits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Kind {
    /// One firing angle
    Fixed,
    /// The firing angle goes from one to another over time, A tanh(B t − C) + D
    OpenLoop,
    /// The firing angle falls with the rate, by one line or two
    ClosedLoop,
    /// The firing angle and the valve opening time go through given knots over the rate
    Curve,
    /// One smooth curve over the rate, found by search to be quick from rest or to save gas
    Smooth,
    /// A commanded speed is held: the speed of each firing angle is measured first
    Speed,
    /// A robot in space rolls on the legs near one plane, by the firing angle of `open-loop`: twins fire as one leg
    Disc,
    /// The same on the legs that touch, kept in its plane and on its line by twins that open for different times
    DiscStable,
    /// A robot in space follows a path by planes that it chooses as it lies, and gets up where it fell
    Steer,
    /// The same, thrown down at an attitude and with a spin that are drawn
    Recover,
    /// What was learnt
    #[value(skip)]
    Policy,
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

impl Kind {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Kind::Fixed => "fixed",
            Kind::OpenLoop => "open-loop",
            Kind::ClosedLoop => "closed-loop",
            Kind::Curve => "curve",
            Kind::Smooth => "smooth",
            Kind::Speed => "speed",
            Kind::Disc => "disc",
            Kind::DiscStable => "disc-stable",
            Kind::Steer => "steer",
            Kind::Recover => "recover",
            Kind::Policy => "policy",
        }
    }

    /// Whether it is one of a robot in space.
    pub(super) fn is_in_space(self) -> bool {
        matches!(
            self,
            Kind::Disc | Kind::DiscStable | Kind::Steer | Kind::Recover
        )
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

/// Flags of the law by which a robot in its plane fires: those of `saltus export c --gait`, too.
#[derive(Args, Debug)]
#[command(next_help_heading = "Gait")]
pub(crate) struct LawFlags {
    /// Firing angle α_f (rad) of `fixed` [default: 0.1]
    #[arg(long, value_name = "ANGLE", value_parser = quantity::angle, allow_hyphen_values = true)]
    pub(super) firing_angle: Option<f64>,

    /// Firing angle (rad) at rest, of `open-loop` and `closed-loop` [default: 0.35, of `disc` 0.5, less where legs
    /// are close]
    #[arg(long, value_name = "ANGLE", value_parser = quantity::angle, allow_hyphen_values = true)]
    pub(super) from: Option<f64>,

    /// Firing angle (rad) in the end [default: 0 for `open-loop`, -0.1 for `closed-loop`]
    #[arg(long, value_name = "ANGLE", value_parser = quantity::angle, allow_hyphen_values = true)]
    pub(super) to: Option<f64>,

    /// B (1/s) of `open-loop`: how steeply the angle changes [default: 2.1]
    #[arg(long, value_name = "B", value_parser = steepness, allow_hyphen_values = true)]
    pub(super) steepness: Option<f64>,

    /// C of `open-loop`, a number or seconds [default: 3]
    #[arg(long, value_name = "C", value_parser = shift, allow_hyphen_values = true)]
    pub(super) shift: Option<f64>,

    /// How C is read [default: seconds]
    #[arg(long, value_enum)]
    pub(super) centre: Option<Reading>,

    /// Lines of `closed-loop` [default: two]
    #[arg(long, value_enum)]
    pub(super) lines: Option<LinesKind>,

    /// Rate ω_s (rad/s) at which the second line begins [default: 5]
    #[arg(long, value_name = "RATE", value_parser = rate, allow_hyphen_values = true)]
    pub(super) switch: Option<f64>,

    /// Slope of the first of two lines (s, that is rad for each rad/s) [default: -0.01]
    #[arg(long, value_name = "SLOPE", value_parser = slope, allow_hyphen_values = true)]
    pub(super) first_slope: Option<f64>,

    /// Rate ω_f (rad/s) at which the last angle is reached [default: 13.3, which is 3.2 m/s]
    #[arg(long, value_name = "RATE", value_parser = top_rate, allow_hyphen_values = true)]
    pub(super) top_rate: Option<f64>,

    /// Knots of `curve`, RATE:ANGLE:TIME with commas between them; straight lines between knots
    #[arg(long, value_name = "RATE:ANGLE:TIME,…", value_parser = knots, allow_hyphen_values = true)]
    pub(super) knots: Option<Knots>,

    /// What the law of `smooth` is best at [default: quick]
    #[arg(long, value_enum)]
    pub(super) aim: Option<Aim>,

    /// Lean z₀ (rad) at which the active zone begins; it is one pitch of the legs wide [default: 0
    /// for `fixed`, `open-loop` and `speed`, -0.3 for the others, but at most half a pitch]
    #[arg(long, value_name = "ANGLE", value_parser = quantity::angle, allow_hyphen_values = true)]
    pub(super) zone: Option<f64>,

    /// Weights of the rate's filter: of the newest reading, then of those before it; at most 16. They
    /// are divided by their sum [default: a mean of five]
    #[arg(long, value_name = "WEIGHTS", value_parser = taps, allow_hyphen_values = true)]
    pub(super) taps: Option<Taps>,
}

/// Flags of the gait.
#[derive(Args, Debug)]
#[command(next_help_heading = "Gait")]
pub(super) struct GaitFlags {
    /// How the firing angle is found [default: closed-loop; disc-stable for a robot in space, with --path steer]
    #[arg(long, value_enum)]
    pub(super) gait: Option<Kind>,

    /// Heading (rad) of the line of `disc-stable`, `steer` and `recover`, to the left of the first heading [default: 0]
    #[arg(long, value_name = "ANGLE", value_parser = quantity::heading, allow_hyphen_values = true)]
    pub(super) heading: Option<f64>,

    /// Path of `steer` and `recover`, from (0, 0): a CSV file with x_m, along the first heading, and y_m, to its left
    #[arg(long, value_name = "FILE.csv", conflicts_with = "heading")]
    pub(super) path: Option<PathBuf>,

    /// A robot in space knows its motion exactly, in place of what its sensors say
    #[arg(long)]
    pub(super) truth: bool,

    /// What `saltus learn --out` wrote, in place of a gait: its best seed runs, on its robot where --robot names no other
    #[arg(long, value_name = "FILE.json", conflicts_with_all = ["gait", "zone", "taps", "direction", "valve_open"])]
    pub(super) policy: Option<PathBuf>,

    /// The seed of the policy that runs [default: the one that did best]
    #[arg(long, value_name = "SEED", requires = "policy", value_parser = seed)]
    pub(super) policy_seed: Option<u64>,

    /// Valve opening time t_v (s), as in 40ms [default: 0.04]
    #[arg(long, value_name = "TIME", value_parser = quantity::time, allow_hyphen_values = true)]
    pub(super) valve_open: Option<f64>,

    #[command(flatten)]
    pub(super) law: LawFlags,

    /// Speeds of `speed`, TIME:SPEED in s and m/s: each is held from its time on, a negative one
    /// backwards, as in 0:1.5,4:3,8:-1. Needs a robot on a boom, whose encoder measures the way
    #[arg(long, value_name = "TIME:SPEED,…", value_parser = speeds, allow_hyphen_values = true)]
    pub(super) speed: Option<Speeds>,

    /// Which way the robot runs
    #[arg(long, value_enum, default_value = "forwards")]
    pub(super) direction: Direction,
}

/// What the flags give.
#[derive(Clone, Debug)]
pub(super) struct Chosen {
    pub(super) kind: Kind,
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
            kind: Kind::Policy,
            program: program.map_err(|error| CliError::content("--policy", error))?,
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

impl LawFlags {
    /// Weights of the rate's filter.
    pub(crate) fn taps(&self) -> Vec<f64> {
        let taps = self.taps.as_ref();
        taps.map_or_else(|| vec![0.2; 5], |taps| taps.0.clone())
    }

    /// Refuses flags that only other gaits than `kind` have, and a valve's time where the law says it.
    pub(crate) fn meant(&self, kind: Option<Kind>, opens: bool) -> Result<(), CliError> {
        use Kind::{ClosedLoop, Curve, Fixed, OpenLoop, Policy, Smooth, Speed};
        let in_plane = [Fixed, OpenLoop, ClosedLoop, Curve, Smooth, Speed, Policy];
        let given: [(&'static str, bool, &[Kind]); 14] = [
            ("--firing-angle", self.firing_angle.is_some(), &[Fixed]),
            ("--from", self.from.is_some(), &[OpenLoop, ClosedLoop]),
            ("--to", self.to.is_some(), &[OpenLoop, ClosedLoop]),
            ("--steepness", self.steepness.is_some(), &[OpenLoop]),
            ("--shift", self.shift.is_some(), &[OpenLoop]),
            ("--centre", self.centre.is_some(), &[OpenLoop]),
            ("--lines", self.lines.is_some(), &[ClosedLoop]),
            ("--switch", self.switch.is_some(), &[ClosedLoop]),
            ("--first-slope", self.first_slope.is_some(), &[ClosedLoop]),
            ("--top-rate", self.top_rate.is_some(), &[ClosedLoop]),
            ("--knots", self.knots.is_some(), &[Curve]),
            ("--aim", self.aim.is_some(), &[Smooth]),
            ("--zone", self.zone.is_some(), &in_plane),
            ("--taps", self.taps.is_some(), &in_plane),
        ];
        for (flag, is_given, kinds) in given {
            if is_given && !kind.is_some_and(|kind| kinds.contains(&kind)) {
                let names: Vec<&str> = kinds.iter().map(|kind| kind.name()).collect();
                let mut allowed = format!("used with --gait {}", names.join(" or "));
                if let Some(kind) = kind {
                    allowed += ", not ";
                    allowed += kind.name();
                }
                return Err(CliError::flag(flag, "", allowed));
            }
        }
        let is_one = self.lines == Some(LinesKind::One);
        for (flag, is_given) in [
            ("--switch", self.switch.is_some()),
            ("--first-slope", self.first_slope.is_some()),
        ] {
            if is_given && is_one {
                let allowed = "used with --lines two or jump, not one";
                return Err(CliError::flag(flag, "", allowed));
            }
        }
        match kind.filter(|kind| !matches!(kind, Fixed | OpenLoop | ClosedLoop)) {
            Some(kind) if opens => {
                let name = kind.name();
                let allowed = format!("left out with --gait {name}, whose law says the time");
                Err(CliError::flag("--valve-open", "", allowed))
            }
            _ => Ok(()),
        }
    }

    /// The law of `kind` for `robot`, and where its zone begins (rad); speeds are measured on so many
    /// `threads`.
    pub(crate) fn found(
        &self,
        kind: Kind,
        robot: &Robot,
        threads: usize,
    ) -> Result<(Program, f64), CliError> {
        let legs = robot.body.legs;
        if !(3..=12).contains(&legs) {
            let reason = format!("body.legs = {legs}: must be from 3 to 12, for a robot that runs");
            return Err(CliError::content(&robot.name, reason));
        }
        let half = 0.5 * TAU / f64::from(legs);
        let zone = self.zone.unwrap_or(match kind {
            Kind::Fixed | Kind::OpenLoop | Kind::Speed => 0.0,
            _ => (-0.3_f64).max(-half),
        });
        if zone.abs() > half {
            let half = digits(half, 4);
            let allowed = format!("from -{half} to {half} rad, half a pitch of the legs");
            return Err(CliError::flag("--zone", format!("{zone} rad"), allowed));
        }
        let program = self.program(kind, robot, (zone, threads))?;
        LawFlags::within(kind, &program, (zone, 2.0 * half))?;
        Ok((program, zone))
    }

    /// The program.
    fn program(
        &self,
        kind: Kind,
        robot: &Robot,
        (zone, threads): (f64, usize),
    ) -> Result<Program, CliError> {
        // The legs of a robot that has many are closer than the thesis' angle.
        let pitch = TAU / f64::from(robot.body.legs);
        let first = self.from.unwrap_or(0.35_f64.min(0.9 * (zone + pitch)));
        Ok(match kind {
            Kind::Fixed => Program::Fixed {
                firing_angle: self.firing_angle.unwrap_or(0.1),
            },
            Kind::OpenLoop => {
                let shift = self.shift.unwrap_or(3.0);
                Program::OpenLoop {
                    first,
                    last: self.to.unwrap_or(0.0),
                    slope: self.steepness.unwrap_or(2.1),
                    centre: match self.centre.unwrap_or(Reading::Seconds) {
                        Reading::Printed => Centre::Printed(shift),
                        Reading::Seconds => Centre::Seconds(shift),
                    },
                }
            }
            Kind::ClosedLoop => {
                let (last, at) = (self.to.unwrap_or(-0.1), self.top_rate.unwrap_or(13.3));
                let lines = self.lines.unwrap_or(LinesKind::Two);
                if lines == LinesKind::One {
                    return Ok(Program::ClosedLoop(Lines::One { first, last, at }));
                }
                let switch = self.switch.unwrap_or(5.0);
                if switch >= at {
                    let allowed = format!("below --top-rate, {at} rad/s");
                    return Err(CliError::flag("--switch", switch, allowed));
                }
                Program::ClosedLoop(Lines::Two {
                    first,
                    slope: self.first_slope.unwrap_or(-0.01),
                    switch,
                    last,
                    at,
                    jumps: lines == LinesKind::Jump,
                })
            }
            Kind::Curve => {
                let knots = self.knots.as_ref().ok_or(CliError::Missing {
                    flag: "--knots",
                    allowed: "--gait curve needs RATE:ANGLE:TIME, as in 0:0.35:40ms,13.3:-0.1:40ms",
                })?;
                Program::Curve(knots.0.clone())
            }
            Kind::Smooth => self.aim.unwrap_or(Aim::Quick).law().program(),
            Kind::Policy | Kind::Disc | Kind::DiscStable | Kind::Steer | Kind::Recover => {
                Program::Fixed { firing_angle: zone }
            }
            Kind::Speed => {
                let law = speed_law(robot, threads);
                Program::Curve(law.map_err(|error| refused(error, robot))?)
            }
        })
    }

    /// Refuses angles that lie outside the active zone.
    fn within(kind: Kind, program: &Program, (zone, pitch): (f64, f64)) -> Result<(), CliError> {
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
                let flag = match kind {
                    Kind::Smooth => "--gait smooth",
                    Kind::Speed => "--gait speed",
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
                    "--first-slope, --switch" | "--gait smooth" | "--gait speed" => {
                        format!("(α_f {} rad)", digits(angle, 6))
                    }
                    _ => format!("{} rad", digits(angle, 6)),
                };
                return Err(CliError::flag(flag, value, allowed));
            }
        }
        Ok(())
    }
}

impl GaitFlags {
    /// The gait of a robot in its plane.
    fn own(&self) -> Kind {
        self.gait.unwrap_or(Kind::ClosedLoop)
    }

    /// The flag of the valve, where it is given.
    pub(super) fn valve_flag(&self) -> Option<&'static str> {
        self.valve_open.map(|_| "--valve-open")
    }

    /// What the flags give for `robot`.
    pub(super) fn chosen(&self, robot: &Robot) -> Result<Chosen, CliError> {
        let kind = self.own();
        if kind.is_in_space() {
            let allowed = "used with a robot in space, whose body.shape is sphere";
            return Err(CliError::flag("--gait", kind.name(), allowed));
        }
        let in_space = [
            ("--heading", self.heading.is_some()),
            ("--path", self.path.is_some()),
            ("--truth", self.truth),
        ];
        if let Some((flag, _)) = in_space.into_iter().find(|(_, given)| *given) {
            let allowed = "used with a robot in space, whose body.shape is sphere";
            return Err(CliError::flag(flag, "", allowed));
        }
        self.meant()?;
        let valve_open = self.valve_open.unwrap_or(0.04);
        if valve_open > 1.0 {
            let allowed = "from 0 to 1 s";
            return Err(CliError::flag("--valve-open", seconds(valve_open), allowed));
        }
        let (program, zone) = self.law.found(kind, robot, available())?;
        let open = format!("valve open {} ms", digits(valve_open * 1e3, 4));
        let words = match self.own() {
            Kind::Curve | Kind::Smooth | Kind::Speed | Kind::Policy => self.words(&program),
            _ => format!("{}, {open}", self.words(&program)),
        };
        Ok(Chosen {
            kind,
            program,
            valve_open,
            zone,
            forwards: self.direction == Direction::Forwards,
            taps: self.law.taps(),
            speeds: self.speed.clone().map_or_else(Vec::new, |speeds| speeds.0),
            words,
            obstacles: Vec::new(),
        })
    }

    /// What was learnt, where that is to run.
    pub(super) fn learned(&self) -> Result<Option<Learned>, CliError> {
        let load = |path: &PathBuf| Learned::load(path, self.policy_seed);
        self.policy.as_ref().map(load).transpose()
    }

    /// Refuses flags that only other gaits have.
    fn meant(&self) -> Result<(), CliError> {
        let kind = self.own();
        self.law.meant(Some(kind), self.valve_open.is_some())?;
        match (kind, &self.speed) {
            (Kind::Speed, None) => Err(CliError::Missing {
                flag: "--speed",
                allowed: "--gait speed needs TIME:SPEED, as in 0:1.5,4:3,8:-1",
            }),
            (Kind::Speed, _) if self.direction == Direction::Backwards => {
                let allowed = "left out with --gait speed, whose speeds have signs";
                Err(CliError::flag("--direction", "backwards", allowed))
            }
            (kind, Some(_)) if kind != Kind::Speed => {
                let allowed = format!("used with --gait speed, not {}", kind.name());
                Err(CliError::flag("--speed", "", allowed))
            }
            _ => Ok(()),
        }
    }

    fn words(&self, program: &Program) -> String {
        let short = |x: f64| digits(x, 4);
        match program {
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
            Program::Curve(_) if self.own() == Kind::Smooth => format!(
                "smooth, {}",
                match self.law.aim.unwrap_or(Aim::Quick) {
                    Aim::Quick => "quick from rest",
                    Aim::Sparing => "sparing of gas",
                }
            ),
            Program::Curve(law) if self.own() == Kind::Speed => format!(
                "speed, by a law measured from {} to {} m/s",
                short(law.get(1).map_or(0.0, |knot| knot[0])),
                short(law.last().map_or(0.0, |knot| knot[0]))
            ),
            Program::Curve(knots) => format!("curve of {} knots", knots.len()),
            _ => self.own().name().to_owned(),
        }
    }
}

fn seconds(time: f64) -> String {
    format!("{} s", digits(time, 6))
}
