//! What became of a ball.

use saltus::gait::GaitError;
use saltus::gait::space::{Ball, FALLS, Gait, Led, Left, Roll, Rolled, roll};

use crate::output::measured;

/// How far (m) a drawn robot has to come along its line, and within which way (m) of it or of its path.
pub(super) const FAR: f64 = 30.0;
pub(super) const WIDE: f64 = 1.0;
/// A robot stands that has moved by less than this (m) for so long (s), or since the start of a shorter run; of one that is led,
/// which lies still before it chooses a plane.
const STILL: f64 = 0.05;
const STANDS: f64 = 2.0;
const LIES: f64 = 10.0;
/// Stations after which a robot that was thrown down runs again: a whole turn.
const RUNS: i32 = 6;

/// What a run is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Aim {
    /// As far as time allows, of a robot that does not get up.
    Line,
    /// The same of one that chooses its planes.
    Led,
    /// Through so many points.
    Path(usize),
    /// Running again, thrown down.
    Again,
}

/// How a run ended.
#[derive(Clone, Copy, Debug)]
enum End {
    /// At the end of its path.
    Arrived,
    /// By a fall.
    Fell(Left),
    /// Thrown down, without running again.
    Lies,
    /// At rest, since when (s).
    Stands(f64),
    /// Without having set out: none of its planes leads where it shall go, or it never lay still.
    Waits,
    /// Before it came through all points of its path: so many.
    OnItsWay(usize),
    /// When its time was over.
    Rolled,
}

/// A run, and what is seen of it.
#[derive(Clone, Debug)]
pub(super) struct Came {
    pub(super) aim: Aim,
    /// Heading (rad) of its line.
    line: f64,
    pub(super) rolled: Rolled,
    /// How far (m) it was aside at most.
    pub(super) aside: f64,
    /// Heading (rad) at the end.
    pub(super) heading: f64,
    /// Where it is at the end (m).
    pub(super) place: [f64; 3],
    /// How far (m) it came over the ground, and along its line.
    pub(super) way: f64,
    pub(super) along: f64,
    /// Since when (s) it has stood still.
    pub(super) stands: Option<f64>,
    /// Whether it came [`FAR`] along its line, or to the end of its path, before it was [`WIDE`] aside of it.
    pub(super) is_far: bool,
    pub(super) led: Led,
    /// When (s) it first rolled a whole turn in one plane.
    pub(super) again: Option<f64>,
}

/// What became of a robot.
pub(super) type Outcome = Result<Came, GaitError>;

/// Rolls until the end, or as long as `goes_on` says.
pub(super) fn follow(setup: &Roll, aim: Aim, mut goes_on: impl FnMut(&Ball) -> bool) -> Outcome {
    let line = match &setup.gait {
        Gait::Stable(stable) => stable.line,
        Gait::Steered(steered) => steered.path[0][1].atan2(steered.path[0][0]),
        Gait::Disc(_) => 0.0,
    };
    let (sine, cosine) = line.sin_cos();
    let falls = matches!(setup.gait, Gait::Stable(_));
    let patience = if aim == Aim::Line { STANDS } else { LIES };
    let mut came = Came::new(aim, line);
    // Where (m) it was when (s), before it last moved on.
    let mut still = ([0.0; 2], 0.0);
    let mut then = [0.0; 2];
    // How often it had set out, and how many stations had come by then.
    let mut out = (0, 0);
    came.rolled = roll(setup, |ball| {
        let [x, y, _] = ball.place;
        came.way += (x - then[0]).hypot(y - then[1]);
        came.along = cosine * x + sine * y;
        then = [x, y];
        let is_followed = !matches!(setup.gait, Gait::Disc(_));
        let aside = if is_followed { ball.aside } else { y };
        came.aside = came.aside.max(aside.abs());
        (came.heading, came.place, came.led) = (ball.rolling.heading, ball.place, ball.led);
        if ball.led.starts != out.0 {
            out = (ball.led.starts, ball.passed);
        }
        if ball.led.plane.is_some() && ball.passed >= out.1 + RUNS {
            came.again.get_or_insert(ball.time);
        }
        let has_arrived = matches!(aim, Aim::Path(points) if ball.led.reached == points);
        let is_far = has_arrived || came.points().is_none() && came.along >= FAR;
        came.is_far |= is_far && came.aside <= WIDE;
        let (from, since) = still;
        if (x - from[0]).hypot(y - from[1]) > STILL {
            still = ([x, y], ball.time);
        }
        let stands = ball.time > since + patience.min(setup.seconds - 1e-6);
        came.stands = stands.then_some(since);
        let ends = falls && (stands || ball.rolling.roll.abs() > FALLS);
        goes_on(ball) && !ends && !has_arrived
    })?;
    Ok(came)
}

impl Came {
    fn new(aim: Aim, line: f64) -> Came {
        Came {
            aim,
            line,
            rolled: Rolled::default(),
            aside: 0.0,
            heading: 0.0,
            place: [0.0; 3],
            way: 0.0,
            along: 0.0,
            stands: None,
            is_far: false,
            led: Led::default(),
            again: None,
        }
    }

    /// Whether its course still turned at the end to its line, which begins where it has.
    pub(super) fn is_turning(&self) -> bool {
        self.aim == Aim::Line && self.line != 0.0 && self.aside == 0.0
    }

    /// Whether it came to the end of its path.
    fn has_arrived(&self) -> bool {
        matches!(self.aim, Aim::Path(points) if self.led.reached == points)
    }

    /// Points of its path, where it has an end.
    pub(super) fn points(&self) -> Option<usize> {
        match self.aim {
            Aim::Path(points) => Some(points),
            _ => None,
        }
    }

    /// How it was led, as lines of a report.
    pub(super) fn led_in_words(&self) -> Vec<(&'static str, String)> {
        let [x, y, _] = self.place;
        let mut lines = vec![(
            "place at the end",
            format!("({}, {}) m", measured(x, 4), measured(y, 4)),
        )];
        if let Some(points) = self.points() {
            lines.push((
                "points reached",
                format!("{} of {points}", self.led.reached),
            ));
        }
        let times = if self.led.starts == 1 {
            "once".into()
        } else {
            format!("{} times", self.led.starts)
        };
        lines.push(("set out", times));
        if self.aim == Aim::Again {
            let time = self
                .again
                .map_or("never".into(), |time| format!("{} s", measured(time, 3)));
            lines.push(("first rolled a turn by", time));
        }
        lines
    }

    fn end(&self) -> End {
        match (self.aim, self.rolled.fell, self.stands) {
            _ if self.has_arrived() => End::Arrived,
            (Aim::Line, Some(fell), _) => End::Fell(fell),
            (Aim::Again, _, _) if self.again.is_none() => End::Lies,
            (_, _, Some(since)) => End::Stands(since),
            (Aim::Led, _, None) if self.led.starts == 0 => End::Waits,
            (Aim::Path(points), _, None) => End::OnItsWay(points),
            _ => End::Rolled,
        }
    }

    pub(super) fn ending(&self) -> &'static str {
        match self.end() {
            End::Arrived => "arrived",
            End::Fell(_) => "fell",
            End::Lies => "lies",
            End::Stands(_) => "stands",
            End::Waits => "waits",
            End::OnItsWay(_) => "on its way",
            End::Rolled => "rolled",
        }
    }

    /// The ending in words.
    pub(super) fn words(&self) -> String {
        let good = if self.has_arrived() {
            "came to the end of its path"
        } else {
            "rolled to the end"
        };
        self.failure().unwrap_or_else(|| good.into())
    }

    /// What went wrong, if anything did: when, where, which way.
    pub(super) fn failure(&self) -> Option<String> {
        let [x, y, _] = self.place;
        let here = format!("at ({}, {}) m", measured(x, 4), measured(y, 4));
        let time = measured(self.rolled.time, 4);
        match self.end() {
            End::Arrived | End::Rolled => None,
            End::Fell(fell) => Some(format!("fell: {}", leaving(&fell))),
            End::Lies => Some(format!("does not run again in {time} s: {here}")),
            End::Stands(since) => Some(format!("stands since {} s, {here}", measured(since, 4))),
            End::Waits => Some(format!("did not set out in {time} s, {here}")),
            End::OnItsWay(points) => Some(format!(
                "is on its way after {time} s, {here}: {} of {points} points reached",
                self.led.reached
            )),
        }
    }
}

/// When, where and which way.
pub(super) fn leaving(left: &Left) -> String {
    format!(
        "at {} s and {} m, {} m to the {}; rolled by {} rad to the {}, at {} rad/s to the {}",
        measured(left.time, 4),
        measured(left.travel, 4),
        measured(left.aside.abs(), 3),
        if left.aside < 0.0 { "right" } else { "left" },
        measured(left.roll.abs(), 3),
        if left.roll < 0.0 { "left" } else { "right" },
        measured(left.roll_rate.abs(), 3),
        if left.roll_rate < 0.0 {
            "left"
        } else {
            "right"
        }
    )
}
