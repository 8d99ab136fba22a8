//! A robot in space, which rolls as a disc.

mod beside;
mod film;

use std::fmt::Write as _;
use std::ops::ControlFlow;

use saltus::Robot;
use saltus::gait::space::{
    Ball, DrawnBalls, FALLS, Fires, Gait, Knows, Left, Roll, Rolled, Stable, drawn_ball, roll,
};
use saltus::gait::{Centre, GaitError, Program};
use saltus::numeric::parallel;
use saltus::running::Share;
use saltus::sim_check::Stepping;
use serde_json::{Value, json};

use super::Run;
use super::ensemble::in_words;
use super::gait::{Direction, GaitFlags, Kind, Reading};
use super::rows::Rows;
use crate::cli::Status;
use crate::error::CliError;
use crate::interrupt::Interrupt;
use crate::output::{self, Cell, Files, Format, Table, digits, full, message};
use crate::progress::Progress;
use beside::{Beside, Places, Said};

/// How far (m) a drawn robot has to come, and within which way (m) of its line.
const FAR: f64 = 30.0;
const WIDE: f64 = 1.0;

const COLUMNS: &[&str] = &[
    "robot",
    "time_s",
    "travel_m",
    "most_aside_m",
    "ending",
    "fell_s",
    "fell_roll_rad",
    "firings",
    "error",
];

/// A run, and how far it was aside at most.
#[derive(Clone, Debug, Default)]
struct Came {
    rolled: Rolled,
    aside: f64,
    /// Heading (rad) at the end.
    heading: f64,
    /// Since when (s) no station came any more.
    stands: Option<f64>,
    /// Whether it came [`FAR`] along its line before it was [`WIDE`] aside of it.
    is_far: bool,
}

/// For how long (s) no station may come into the zone before a robot counts as standing.
const STANDS: f64 = 2.0;

impl Run {
    /// Runs the robot in space that the flags name.
    pub(super) fn ball(&self, robot: &Robot) -> Result<Status, CliError> {
        self.meant_for_a_ball()?;
        let mut setup = Roll {
            gait: self.gait.rolls()?,
            knows: if self.gait.truth || self.gait.is_thesis() {
                Knows::Truth
            } else {
                Knows::Sensors(self.seed)
            },
            stepping: match (self.exact, self.step) {
                (true, _) => Stepping::Adaptive,
                (false, Some(step)) => Stepping::Fixed(step),
                (false, None) => Stepping::USUAL,
            },
            ..Roll::new(robot.clone(), self.seconds)
        };
        if self.robots.is_some() {
            return self.many_balls(&setup);
        }
        self.places()?;
        let interrupt = Interrupt::listen()?;
        // A length is at most 100,000 s.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let progress = Progress::new("simulated seconds", self.seconds.ceil() as usize);
        let mut rows = match self.output.format() {
            Format::Csv => Some(Rows::lines("--out", self.output.out(), header(robot))?),
            _ => None,
        };
        let mut beside = Beside::open(self.beside(), self.seed, &mut setup)?;
        let mut whole = 0.0;
        let came = follow(&setup, |ball| {
            if let Some(rows) = &mut rows {
                rows.line(|text| write(ball, text));
            }
            beside.push(ball);
            if ball.time >= whole + 1.0 {
                whole += 1.0;
                progress.advance(1);
            }
            let is_read = rows.as_ref().is_none_or(Rows::is_open) && beside.is_open();
            if interrupt.came() || !is_read {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        })
        .map_err(|error| refused(error, robot))?;
        drop(progress);
        if interrupt.came() {
            let at = digits(came.rolled.time, 6);
            message(&format!(
                "interrupted at {at} s: the answer is of the run up to there"
            ));
        }
        let mut files = Files::default();
        match (rows, self.output.format()) {
            (Some(rows), _) => {
                if let Some(stream) = rows.finish()? {
                    files.written(stream)?;
                }
                if let Some(what) = came.failure() {
                    message(&format!("the robot {what}"));
                }
            }
            (None, Format::Json) => {
                files.report(self.output.out(), output::json(&self.report(robot, &came)));
            }
            (None, _) => files.report(self.output.out(), self.text(robot, &came)),
        }
        beside.add_to(&mut files, &setup, self.said(robot, &came))?;
        files.write()?;
        Ok(match (interrupt.came(), came.failure()) {
            (true, _) => Status::Interrupted,
            (false, None) => Status::Done,
            (false, Some(_)) => Status::No,
        })
    }

    /// Where what is beside the report goes.
    fn beside(&self) -> Places<'_> {
        Places {
            animate: self.animate.as_deref(),
            mcap: self.mcap.path(),
            telemetry: self.telemetry.as_deref(),
        }
    }

    /// What is said there of a run.
    fn said(&self, robot: &Robot, came: &Came) -> Said<'_> {
        Said {
            title: self.head(robot),
            ended: came.failure().unwrap_or_else(|| "rolled to the end".into()),
            rolled: came.failure().is_none(),
            gait: self.gait.rolling().name(),
        }
    }

    /// Refuses what only a robot in its plane does.
    fn meant_for_a_ball(&self) -> Result<(), CliError> {
        let given = [
            ("--policy", self.gait.policy.is_some()),
            ("--disturb", !self.disturb.is_empty()),
            ("--analyse", self.analyse.is_some()),
            ("--plot", self.plot.is_set()),
            ("--believed", self.believed.is_some()),
            ("--drawn-across", self.drawn_across != 0.0),
        ];
        match given.into_iter().find(|(_, is_given)| *is_given) {
            Some((flag, _)) => Err(in_its_plane(flag)),
            None => Ok(()),
        }
    }

    /// The robot and its gait in words.
    fn head(&self, robot: &Robot) -> String {
        let knows = if self.gait.is_thesis() || self.gait.truth {
            "its motion known exactly"
        } else {
            "by its sensors"
        };
        let seconds = digits(self.seconds, 6);
        let kind = self.gait.rolling().name();
        format!("{}: {kind}, {knows}, {seconds} s", robot.name)
    }

    fn text(&self, robot: &Robot, came: &Came) -> String {
        let rolled = &came.rolled;
        let mut text = self.head(robot) + "\n";
        let mut line = |name: &str, what: String| {
            let _ = writeln!(text, "  {name:<24} {what}");
        };
        let ending = came.failure().unwrap_or_else(|| "rolled to the end".into());
        line("ending", ending);
        line("time", format!("{} s", digits(rolled.time, 6)));
        line("travel", format!("{} m", digits(rolled.travel, 5)));
        let speed = rolled.travel / rolled.time.max(f64::MIN_POSITIVE);
        line("mean speed", format!("{} m/s", digits(speed, 4)));
        line(
            "most aside of its line",
            format!("{} m", digits(came.aside, 3)),
        );
        if self.gait.is_thesis() {
            let left = rolled
                .left
                .map_or_else(|| "never".into(), |left| leaving(&left));
            line("left its plane", left);
        } else {
            let heading = digits(came.heading, 3);
            let wanted = digits(self.gait.heading.unwrap_or(0.0), 3);
            line(
                "heading at the end",
                format!("{heading} rad, line {wanted} rad"),
            );
        }
        line("firings", rolled.firings.to_string());
        line(
            "energy unexplained",
            format!("{} J", digits(rolled.residual, 3)),
        );
        text
    }

    fn report(&self, robot: &Robot, came: &Came) -> Value {
        let rolled = &came.rolled;
        let place = |left: &Left| {
            json!({
                "time_s": left.time, "travel_m": left.travel, "aside_m": left.aside,
                "roll_rad": left.roll, "roll_rate_rad_s": left.roll_rate,
            })
        };
        json!({
            "command": "run",
            "robot": robot.name,
            "gait": self.gait.rolling().name(),
            "by_sensors": !(self.gait.truth || self.gait.is_thesis()),
            "seconds": self.seconds,
            "seed": self.seed,
            "line_rad": self.gait.heading.unwrap_or(0.0),
            "heading_rad": came.heading,
            "ending": came.ending(),
            "time_s": rolled.time,
            "travel_m": rolled.travel,
            "most_aside_m": came.aside,
            "left_its_plane": rolled.left.as_ref().map(place),
            "fell": rolled.fell.as_ref().map(place),
            "stands_since_s": came.stands,
            "firings": rolled.firings,
            "residual_j": -rolled.residual,
        })
    }

    /// Runs drawn balls and reports their shares.
    fn many_balls(&self, setup: &Roll) -> Result<Status, CliError> {
        let robots = self.robots.map_or(1, std::num::NonZeroUsize::get);
        let mut files = Files::default();
        files.extend(self.output.out().map(|out| ("--out", out)));
        files.check()?;
        let draw = DrawnBalls::default();
        // What is wrong with all of them is bad input, and said before they run.
        roll(setup, |_| false).map_err(|error| refused(error, &setup.robot))?;
        let progress = Progress::new("robots", robots);
        let runs = parallel::map_on(self.threads.count().get(), robots, |k| {
            let mut own = setup.clone();
            own.robot = drawn_ball(&setup.robot, &draw, self.seed, k)?;
            if let Knows::Sensors(seed) = &mut own.knows {
                *seed = seed.wrapping_add(k as u64);
            }
            let came = follow(&own, |_| ControlFlow::Continue(()));
            progress.advance(1);
            came
        });
        drop(progress);
        let report = match self.output.format() {
            Format::Csv => table(&runs).csv(),
            Format::Json => output::json(&self.shares(setup, &draw, &runs)),
            Format::Text => self.shares_text(setup, &draw, &runs),
        };
        self.output.write_report(report)?;
        Ok(Status::Done)
    }

    fn shares(&self, setup: &Roll, draw: &DrawnBalls, runs: &[Outcome]) -> Value {
        let share = |share: Share| json!({ "count": share.count, "of": share.of, "share": share.value(), "interval_95": share.interval() });
        json!({
            "command": "run",
            "robot": setup.robot.name,
            "gait": self.gait.rolling().name(),
            "by_sensors": setup.knows != Knows::Truth,
            "seconds": setup.seconds,
            "seed": self.seed,
            "drawn": { "force_factor_standard_deviation": draw.force, "center_of_mass_within_m": draw.center, "friction": draw.friction },
            "rolled_to_the_end": share(together(runs, |came| came.failure().is_none())),
            "came_30_m_within_1_m": share(together(runs, |came| came.is_far)),
            "not_simulated": runs.iter().filter(|run| run.is_err()).count(),
            "runs": table(runs).json(),
        })
    }

    fn shares_text(&self, setup: &Roll, draw: &DrawnBalls, runs: &[Outcome]) -> String {
        let mut text = self.head(&setup.robot);
        let _ = writeln!(text, ", {} drawn robots, seed {}", runs.len(), self.seed);
        let mut line = |name: &str, what: String| {
            let _ = writeln!(text, "  {name:<24} {what}");
        };
        let drawn = format!(
            "forces of legs ± {} %, centre of mass within {} mm, friction {} to {}",
            digits(100.0 * draw.force, 3),
            digits(1e3 * draw.center, 3),
            draw.friction[0],
            draw.friction[1]
        );
        line("drawn", drawn);
        let upright = together(runs, |came| came.failure().is_none());
        line("rolled to the end", in_words(&upright));
        let far = format!("{FAR} m within {WIDE} m");
        line(&far, in_words(&together(runs, |came| came.is_far)));
        let middle = |of: &dyn Fn(&Came) -> f64| {
            let mut all: Vec<f64> = runs.iter().flatten().map(of).collect();
            saltus::numeric::statistics::median(&mut all)
        };
        line(
            "median travel",
            format!("{} m", digits(middle(&|came| came.rolled.travel), 4)),
        );
        line(
            "median way aside",
            format!("{} m", digits(middle(&|came| came.aside), 3)),
        );
        if let Some(Err(error)) = runs.iter().find(|run| run.is_err()) {
            let count = runs.iter().filter(|run| run.is_err()).count();
            line("not simulated", format!("{count}, {error}"));
        }
        text
    }
}

/// What became of a drawn robot.
type Outcome = Result<Came, GaitError>;

/// Rolls until the end, a fall, or as long as `goes_on` says.
fn follow(setup: &Roll, mut goes_on: impl FnMut(&Ball) -> ControlFlow<()>) -> Outcome {
    let line = match &setup.gait {
        Gait::Stable(stable) => stable.line,
        Gait::Disc(_) | Gait::Steered(_) => 0.0,
    };
    let is_stable = matches!(setup.gait, Gait::Stable(_));
    let mut came = Came::default();
    let mut last = (i32::MIN, 0.0);
    came.rolled = roll(setup, |ball| {
        let [x, y, _] = ball.place;
        let (sine, cosine) = line.sin_cos();
        came.aside = came.aside.max(match &setup.gait {
            Gait::Stable(_) => ball.aside.abs(),
            Gait::Disc(_) | Gait::Steered(_) => y.abs(),
        });
        came.heading = ball.rolling.heading;
        came.is_far |= came.aside <= WIDE && cosine * x + sine * y >= FAR;
        if ball.passed > last.0 {
            last = (ball.passed, ball.time);
        }
        let stands = ball.time > last.1 + STANDS;
        came.stands = stands.then_some(last.1);
        let ends = is_stable && (stands || ball.rolling.roll.abs() > FALLS);
        goes_on(ball).is_continue() && !ends
    })?;
    Ok(came)
}

fn together(runs: &[Outcome], did: impl Fn(&Came) -> bool) -> Share {
    Share {
        count: runs.iter().flatten().filter(|came| did(came)).count(),
        of: runs.len(),
    }
}

fn table(runs: &[Outcome]) -> Table {
    let mut table = Table::new(COLUMNS);
    for (k, run) in runs.iter().enumerate() {
        let mut row = vec![Cell::Count(k)];
        match run {
            Ok(came) => row.extend([
                came.rolled.time.into(),
                came.rolled.travel.into(),
                came.aside.into(),
                Cell::Word(came.ending()),
                came.rolled.fell.map(|fell| fell.time).into(),
                came.rolled.fell.map(|fell| fell.roll).into(),
                Cell::Count(came.rolled.firings),
                Cell::Empty,
            ]),
            Err(error) => {
                row.resize(COLUMNS.len() - 1, Cell::Empty);
                row.push(Cell::Text(error.to_string()));
            }
        }
        table.push(row);
    }
    table
}

impl Came {
    fn ending(&self) -> &'static str {
        match (self.rolled.fell, self.stands) {
            (Some(_), _) => "fell",
            (None, Some(_)) => "stands",
            (None, None) => "rolled",
        }
    }

    /// What went wrong, if anything did: when, where, which way.
    fn failure(&self) -> Option<String> {
        match (self.rolled.fell, self.stands) {
            (Some(fell), _) => Some(format!("fell: {}", leaving(&fell))),
            (None, Some(since)) => Some(format!(
                "stands since {} s, at {} m",
                digits(since, 4),
                digits(self.rolled.travel, 4)
            )),
            (None, None) => None,
        }
    }
}

/// When, where and which way.
fn leaving(left: &Left) -> String {
    format!(
        "at {} s and {} m, {} m to the {}; rolled by {} rad to the {}, {} rad/s",
        digits(left.time, 4),
        digits(left.travel, 4),
        digits(left.aside.abs(), 3),
        if left.aside < 0.0 { "right" } else { "left" },
        digits(left.roll.abs(), 3),
        if left.roll < 0.0 { "left" } else { "right" },
        digits(left.roll_rate, 3)
    )
}

/// The names of the columns, which end with their units.
fn header(robot: &Robot) -> String {
    let mut text = String::from(
        "time_s,x_m,y_m,z_m,quaternion_w,quaternion_x,quaternion_y,quaternion_z,vx_m_s,vy_m_s,vz_m_s,\
         spin_x_rad_s,spin_y_rad_s,spin_z_rad_s,lean_rad,rate_rad_s,roll_rad,roll_rate_rad_s,heading_rad,\
         stations_passed,feet_on_ground,fired_leg,valve_open_s,fired_twin,twin_valve_open_s,estimated_x_m,\
         estimated_y_m,estimated_z_m,estimated_quaternion_w,estimated_quaternion_x,estimated_quaternion_y,\
         estimated_quaternion_z",
    );
    for leg in 0..robot.body.legs {
        // Writing to a string does not fail.
        let _ = write!(text, ",extension_{leg}_m");
    }
    text
}

fn write(ball: &Ball, text: &mut String) {
    let mut number = |x: f64| {
        text.push_str(&full(x));
        text.push(',');
    };
    number(ball.time);
    let l = &ball.rolling;
    let lies = [l.lean, l.rate, l.roll, l.roll_rate, l.heading];
    let all = ball
        .place
        .iter()
        .chain(&ball.attitude)
        .chain(&ball.velocity);
    all.chain(&ball.spin).chain(&lies).for_each(|x| number(*x));
    let _ = write!(text, "{},{}", ball.passed, ball.touching.count_ones());
    for k in 0..2 {
        match ball.fired.get(k) {
            Some(firing) => {
                let _ = write!(text, ",{},{}", firing.leg, full(firing.open));
            }
            None => text.push_str(",,"),
        }
    }
    match &ball.estimate {
        Some(estimate) => {
            for x in estimate.place.iter().chain(&estimate.attitude.0) {
                let _ = write!(text, ",{}", full(*x));
            }
        }
        None => text.push_str(",,,,,,,"),
    }
    for x in &ball.extensions {
        let _ = write!(text, ",{}", full(*x));
    }
}

/// A flag that a robot in space does not have.
fn in_its_plane(flag: &'static str) -> CliError {
    CliError::flag(
        flag,
        "",
        "used with a robot in its plane, whose body.shape is wheel",
    )
}

/// What the library refuses of a ball, as what the user typed.
fn refused(error: GaitError, robot: &Robot) -> CliError {
    match error {
        GaitError::Input {
            name,
            value,
            allowed,
        } => {
            let flag = match name.as_str() {
                "legs.directions" => {
                    return CliError::content(&robot.name, format!("{name}: must be {allowed}"));
                }
                "time (s)" => "--seconds",
                "valve opening time (s)" => "--valve-open",
                "firing angle (rad)" => "--from, --to",
                "B (1/s)" => "--steepness",
                _ => {
                    let reason = format!("{name} = {value}: must be {allowed}");
                    return CliError::content(&robot.name, reason);
                }
            };
            CliError::flag(flag, format!("({name} = {value})"), allowed)
        }
        _ => CliError::content(&robot.name, error),
    }
}

impl GaitFlags {
    /// The gait of a robot in space.
    fn rolling(&self) -> Kind {
        self.gait.unwrap_or(Kind::DiscStable)
    }

    /// Whether it rolls as in the thesis, which knows nothing of sensors.
    fn is_thesis(&self) -> bool {
        self.rolling() == Kind::Disc
    }

    /// How a robot in space rolls.
    fn rolls(&self) -> Result<Gait, CliError> {
        let kind = self.rolling();
        if !matches!(kind, Kind::Disc | Kind::DiscStable) {
            return Err(CliError::flag(
                "--gait",
                kind.name(),
                "disc or disc-stable, of a robot in space",
            ));
        }
        let of_the_disc = [
            ("--valve-open", self.valve_open.is_some()),
            ("--from", self.from.is_some()),
            ("--to", self.to.is_some()),
            ("--steepness", self.steepness.is_some()),
            ("--shift", self.shift.is_some()),
            ("--centre", self.centre.is_some()),
            ("--zone", self.zone.is_some()),
        ];
        let of_the_stable = [("--heading", self.heading.is_some())];
        let of_the_plane = [
            ("--firing-angle", self.firing_angle.is_some()),
            ("--lines", self.lines.is_some()),
            ("--switch", self.switch.is_some()),
            ("--first-slope", self.first_slope.is_some()),
            ("--top-rate", self.top_rate.is_some()),
            ("--knots", self.knots.is_some()),
            ("--aim", self.aim.is_some()),
            ("--speed", self.speed.is_some()),
            ("--distance", self.distance.is_some()),
            ("--refinements", self.refinements.is_some()),
            ("--direction", self.direction != Direction::Forwards),
        ];
        let first = |flags: &[(&'static str, bool)]| {
            flags
                .iter()
                .find(|(_, given)| *given)
                .map(|(flag, _)| *flag)
        };
        if let Some(flag) = first(&of_the_plane) {
            return Err(in_its_plane(flag));
        }
        if kind == Kind::DiscStable {
            if let Some(flag) = first(&of_the_disc) {
                return Err(CliError::flag(
                    flag,
                    "",
                    "used with --gait disc, not disc-stable",
                ));
            }
            return Ok(Gait::Stable(Stable {
                line: self.heading.unwrap_or(0.0),
                ..Stable::default()
            }));
        }
        if let Some(flag) = first(&of_the_stable) {
            return Err(CliError::flag(
                flag,
                "",
                "used with --gait disc-stable, not disc",
            ));
        }
        let shift = self.shift.unwrap_or(3.0);
        let program = Program::OpenLoop {
            first: self.from.unwrap_or(0.5),
            last: self.to.unwrap_or(0.0),
            slope: self.steepness.unwrap_or(2.1),
            centre: match self.centre.unwrap_or(Reading::Printed) {
                Reading::Printed => Centre::Printed(shift),
                Reading::Seconds => Centre::Seconds(shift),
            },
        };
        Ok(Gait::Disc(Fires {
            program,
            valve_open: self.valve_open.unwrap_or(0.05),
            zone: self.zone.unwrap_or(-0.3),
        }))
    }
}
