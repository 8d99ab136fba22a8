//! A robot in space, which rolls as a disc.

mod beside;
mod came;
mod drawn;
mod figure;
mod film;
mod gait;

use std::fmt::Write as _;

use saltus::Robot;
use saltus::gait::GaitError;
use saltus::gait::space::{Ball as Cycle, Knows, Left, Roll, Thrown};
use serde_json::{Value, json};

use super::report::approximate;
use super::rows::Rows;
use super::{RunFlags, note_interrupt};
use crate::cli::Status;
use crate::error::CliError;
use crate::interrupt::Interrupt;
use crate::output::{self, Files, Format, digits, full, measured, message};
use crate::progress::Progress;
use beside::Beside;
use came::{Aim, Came, follow, leaving};
use film::About;
pub(super) use gait::Ball;

/// Part of the legs' work from which on energy that is unexplained is said to be.
const UNSOUND: f64 = 0.2;
/// Energy (J) that says nothing, however little the legs did.
const ROUND_OFF: f64 = 5.0;
/// Greatest spin (rad/s) of a robot that is thrown down.
const SPIN: f64 = 5.0;

/// A robot in space that rolls.
pub(super) struct InSpace {
    pub(super) flags: RunFlags,
    /// The name of the gait.
    pub(super) gait: String,
    pub(super) ball: Ball,
}

impl InSpace {
    /// Runs `robot`.
    pub(super) fn run(&self, robot: &Robot) -> Result<Status, CliError> {
        let (gait, aim) = self.ball.rolls()?;
        let mut setup = Roll {
            gait,
            knows: if self.ball.knows_truth() {
                Knows::Truth
            } else {
                Knows::Sensors(self.flags.seed)
            },
            stepping: self.flags.stepping(),
            ..Roll::new(robot.clone(), self.flags.seconds)
        };
        if self.flags.robots.is_some() {
            return self.many_balls(&setup, aim);
        }
        setup.start.thrown = self.thrown(0);
        self.one_ball(robot, setup, aim)
    }

    fn one_ball(&self, robot: &Robot, mut setup: Roll, aim: Aim) -> Result<Status, CliError> {
        self.flags.places()?;
        let interrupt = Interrupt::listen()?;
        // A length is at most 100,000 s.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let progress = Progress::new("simulated seconds", self.flags.seconds.ceil() as usize);
        let mut rows = match self.flags.output.format() {
            Format::Csv => Some(Rows::open("--out", self.flags.output.out(), header(robot))?),
            _ => None,
        };
        let mut beside = Beside::open(&self.flags, &mut setup)?;
        let mut track = figure::Track::new(self.flags.seconds);
        let mut whole = 0.0;
        let came = follow(&setup, aim, |ball| {
            track.push(ball);
            if let Some(rows) = &mut rows {
                rows.line(|text| write(ball, text));
            }
            beside.push(ball);
            if ball.time >= whole + 1.0 {
                whole += 1.0;
                progress.advance(1);
            }
            let is_read = rows.as_ref().is_none_or(Rows::is_open) && beside.is_open();
            is_read && !interrupt.came()
        })
        .map_err(|error| refused(error, robot))?;
        drop(progress);
        note_interrupt(&interrupt, came.rolled.time);
        let unexplained = came.rolled.residual.abs();
        if unexplained > UNSOUND * came.rolled.work + ROUND_OFF {
            let [part, whole] = [unexplained, came.rolled.work].map(|x| digits(x, 3));
            message(&format!(
                "{part} J are unexplained, the legs did {whole} J of work: the steps are too long for this robot; --step 0.1ms has shorter ones"
            ));
        }
        let mut files = Files::default();
        match (rows, self.flags.output.format()) {
            (Some(rows), _) => {
                if let Some(stream) = rows.finish()? {
                    files.written(stream)?;
                }
                if let Some(what) = came.failure().filter(|_| !interrupt.came()) {
                    message(&format!("the robot {what}"));
                }
            }
            (None, Format::Json) => {
                files.report(
                    self.flags.output.out(),
                    output::json(&self.report(robot, &came)),
                );
            }
            (None, _) => files.report(self.flags.output.out(), self.text(robot, &came)),
        }
        let drawing = || Ok(figure::drawing(&setup, self.head(robot), &track));
        self.flags.plot.add_to(&mut files, drawing)?;
        let about = About {
            title: self.head(robot),
            ended: came.words(),
            rolled: came.failure().is_none(),
        };
        beside.add_to(&mut files, &setup, &about)?;
        files.write()?;
        Ok(match (interrupt.came(), came.failure()) {
            (true, _) => Status::Interrupted,
            (false, None) => Status::Done,
            (false, Some(_)) => Status::No,
        })
    }

    /// The robot and its gait in words.
    fn head(&self, robot: &Robot) -> String {
        let knows = if self.ball.knows_truth() {
            "its motion known exactly"
        } else {
            "by its sensors"
        };
        let seconds = digits(self.flags.seconds, 6);
        format!("{}: {}, {knows}, {seconds} s", robot.name, self.gait)
    }

    fn text(&self, robot: &Robot, came: &Came) -> String {
        let rolled = &came.rolled;
        let mut lines = Vec::new();
        let mut line = |name: &str, what: String| lines.push((name.to_owned(), what));
        line("ending", came.words());
        line("time", format!("{} s", measured(rolled.time, 6)));
        let way = if came.aim == Aim::Line {
            line("travel", format!("{} m", measured(rolled.travel, 5)));
            rolled.travel
        } else {
            line("way", format!("{} m", measured(came.way, 5)));
            came.way
        };
        let speed = way / rolled.time.max(f64::MIN_POSITIVE);
        line("mean speed", format!("{} m/s", measured(speed, 4)));
        let most = format!("most aside of its {}", self.ball.followed());
        let aside = if came.is_turning() {
            "its line has not begun: it still turns".into()
        } else {
            format!("{} m", measured(came.aside, 3))
        };
        line(&most, aside);
        if self.ball.is_thesis() {
            let left = rolled
                .left
                .map_or_else(|| "never".into(), |left| leaving(&left));
            line("left its plane", left);
        } else if came.aim == Aim::Line {
            let heading = measured(came.heading, 3);
            let wanted = measured(self.ball.heading(), 3);
            let both = format!("{heading} rad, line {wanted} rad");
            line("heading at the end", both);
        } else {
            for (name, what) in came.led_in_words() {
                line(name, what);
            }
        }
        line("firings", rolled.firings.to_string());
        line(
            "energy unexplained",
            format!("{} J", digits(-rolled.residual, 3)),
        );
        if let Some(words) = approximate(rolled.approximate) {
            line("contacts", words);
        }
        output::lines(&self.head(robot), 24, &lines)
    }

    fn report(&self, robot: &Robot, came: &Came) -> Value {
        let rolled = &came.rolled;
        let place = |left: &Left| {
            json!({
                "time_s": left.time, "travel_m": left.travel, "aside_m": left.aside,
                "roll_rad": left.roll, "roll_rate_rad_s": left.roll_rate,
            })
        };
        let mut answer = json!({
            "command": "run",
            "robot": robot.name,
            "gait": self.gait,
            "by_sensors": !self.ball.knows_truth(),
            "seconds": self.flags.seconds,
            "seed": self.flags.seed,
            "line_rad": self.ball.heading(),
            "heading_rad": came.heading,
            "ending": came.ending(),
            "time_s": rolled.time,
            "travel_m": rolled.travel,
            "most_aside_m": (!came.is_turning()).then_some(came.aside),
            "left_its_plane": rolled.left.as_ref().map(place),
            "fell": rolled.fell.as_ref().map(place),
            "stands_since_s": came.stands,
            "firings": rolled.firings,
            "work_j": rolled.work,
            "residual_j": -rolled.residual,
            "approximate_contacts": rolled.approximate,
        });
        if came.aim != Aim::Line {
            answer["way_m"] = came.way.into();
            answer["place_m"] = came.place.to_vec().into();
            answer["points_reached"] = came.led.reached.into();
            answer["points"] = came.points().into();
            answer["set_out"] = came.led.starts.into();
            answer["rolled_a_turn_s"] = came.again.into();
        }
        answer
    }

    /// How drawn robot `k` is thrown down, if it is.
    fn thrown(&self, k: usize) -> Option<Thrown> {
        matches!(self.ball, Ball::Recover(_)).then(|| Thrown::drawn(self.flags.seed, k, SPIN))
    }
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

fn write(ball: &Cycle, text: &mut String) {
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
