//! Drawn robots in space, and the shares of them that do what they should.

use saltus::gait::space::{DrawnBalls, Knows, Roll, drawn_ball, roll};
use saltus::numeric::parallel;
use saltus::numeric::statistics::median;
use saltus::running::Share;
use serde_json::{Value, json};

use super::came::{Aim, Came, FAR, Outcome, WIDE, follow};
use super::{InSpace, refused};
use crate::cli::Status;
use crate::error::CliError;
use crate::output::{
    self, Column, Files, Format, Table, columns, counted, digits, in_words, measured, share,
};
use crate::progress::Progress;

/// How soon (s) a robot that was thrown down should run again.
const SOON: f64 = 10.0;

fn columns<'a>() -> [Column<(usize, &'a Outcome)>; 13] {
    columns! {
        "robot", "", |it| it.0;
        "time_s", "", |it| came(it, |came| came.rolled.time);
        "travel_m", "", |it| came(it, |came| came.rolled.travel);
        "most_aside_m", "", |it| came(it, |came| came.aside);
        "ending", "", |it| came(it, Came::ending);
        "fell_s", "", |it| came(it, |came| came.rolled.fell.map(|fell| fell.time));
        "fell_roll_rad", "", |it| came(it, |came| came.rolled.fell.map(|fell| fell.roll));
        "firings", "", |it| came(it, |came| came.rolled.firings);
        "way_m", "", |it| came(it, |came| came.way);
        "points_reached", "", |it| came(it, |came| came.led.reached);
        "set_out", "", |it| came(it, |came| came.led.starts as usize);
        "rolled_a_turn_s", "", |it| came(it, |came| came.again);
        "error", "", |it| it.1.as_ref().err().map(ToString::to_string);
    }
}

/// A number of a ball, if it was simulated.
fn came<T>(it: &(usize, &Outcome), number: impl Fn(&Came) -> T) -> Option<T> {
    it.1.as_ref().ok().map(number)
}

/// A share that is told: its key, and its name in words.
struct Told {
    key: &'static str,
    words: String,
    share: Share,
}

impl InSpace {
    /// Runs drawn balls and reports their shares.
    pub(super) fn many_balls(&self, setup: &Roll, aim: Aim) -> Result<Status, CliError> {
        let robots = self.flags.robots.map_or(1, std::num::NonZeroUsize::get);
        let mut files = Files::default();
        files.extend(self.flags.output.out().map(|out| ("--out", out)));
        files.check()?;
        let draw = DrawnBalls::around(&setup.robot);
        // What is wrong with all of them is bad input, and said before they run.
        roll(setup, |_| false).map_err(|error| refused(error, &setup.robot))?;
        let progress = Progress::new("robots", robots);
        let runs = parallel::map_on(self.flags.threads.count().get(), robots, |k| {
            let mut own = setup.clone();
            own.robot = drawn_ball(&setup.robot, &draw, self.flags.seed, k)?;
            if let Knows::Sensors(seed) = &mut own.knows {
                *seed = seed.wrapping_add(k as u64);
            }
            own.start.thrown = self.thrown(k);
            let came = follow(&own, aim, |_| true);
            progress.advance(1);
            came
        });
        drop(progress);
        let report = match self.flags.output.format() {
            Format::Csv => table(&runs).csv(),
            Format::Json => output::json(&self.shares(setup, aim, &draw, &runs)),
            Format::Text => self.shares_text(setup, aim, &draw, &runs),
        };
        self.flags.output.write_report(report)?;
        Ok(Status::Done)
    }

    fn shares(&self, setup: &Roll, aim: Aim, draw: &DrawnBalls, runs: &[Outcome]) -> Value {
        let mut answer = json!({
            "command": "run",
            "robot": setup.robot.name,
            "gait": self.gait,
            "by_sensors": setup.knows != Knows::Truth,
            "seconds": setup.seconds,
            "seed": self.flags.seed,
            "drawn": { "force_factor_standard_deviation": draw.force, "center_of_mass_within_m": draw.center, "friction": draw.friction },
        });
        for told in told(aim, runs) {
            answer[told.key] = share(&told.share);
        }
        answer["not_simulated"] = runs.iter().filter(|run| run.is_err()).count().into();
        answer["runs"] = table(runs).json().into();
        answer
    }

    fn shares_text(&self, setup: &Roll, aim: Aim, draw: &DrawnBalls, runs: &[Outcome]) -> String {
        let (head, count) = (self.head(&setup.robot), runs.len());
        let drawn = counted(count, "drawn robot");
        let head = format!("{head}, {drawn}, seed {}", self.flags.seed);
        let mut lines = Vec::new();
        let mut line = |name: &str, what: String| lines.push((name.to_owned(), what));
        let drawn = format!(
            "forces of legs ± {} %, centre of mass within {} mm, friction {} to {}",
            digits(100.0 * draw.force, 3),
            digits(1e3 * draw.center, 3),
            draw.friction[0],
            draw.friction[1]
        );
        line("drawn", drawn);
        for Told { words, share, .. } in told(aim, runs) {
            line(&words, in_words(&share));
        }
        let middle = |of: &dyn Fn(&Came) -> Option<f64>| {
            median(&mut runs.iter().flatten().filter_map(of).collect::<Vec<f64>>())
        };
        match aim {
            Aim::Again => {
                let time = digits(middle(&|came| came.again), 3);
                line("median until it ran", format!("{time} s"));
            }
            Aim::Path(_) => {
                let time = digits(middle(&|came| Some(came.rolled.time)), 4);
                line("median time", format!("{time} s"));
            }
            Aim::Line | Aim::Led => {
                let travel = measured(middle(&|came| Some(came.along)), 4);
                line("median travel", format!("{travel} m"));
            }
        }
        let aside = measured(middle(&|came| Some(came.aside)), 3);
        line("median way aside", format!("{aside} m"));
        if let Some(Err(error)) = runs.iter().find(|run| run.is_err()) {
            let count = runs.iter().filter(|run| run.is_err()).count();
            line("not simulated", format!("{count}, {error}"));
        }
        output::lines(&head, 24, &lines)
    }
}

/// What is told of robots that ran for `aim`.
fn told(aim: Aim, runs: &[Outcome]) -> [Told; 2] {
    let share = |did: &dyn Fn(&Came) -> bool| Share {
        count: runs.iter().flatten().filter(|came| did(came)).count(),
        of: runs.len(),
    };
    let told = |key, words: &str, share| Told {
        key,
        words: words.into(),
        share,
    };
    let well = share(&|came| came.failure().is_none());
    let far = share(&|came| came.is_far);
    let soon = share(&|came| came.again.is_some_and(|time| time <= SOON));
    let within = format!("within {WIDE} m of it");
    let line = format!("{FAR} m within {WIDE} m");
    match aim {
        Aim::Path(_) => [
            told(
                "came_to_the_end_of_its_path",
                "came to its path's end",
                well,
            ),
            told("within_1_m_of_its_path", &within, far),
        ],
        Aim::Again => [
            told(
                "ran_again",
                "ran again",
                share(&|came| came.again.is_some()),
            ),
            told("ran_again_within_10_s", &format!("within {SOON} s"), soon),
        ],
        Aim::Line | Aim::Led => [
            told("rolled_to_the_end", "rolled to the end", well),
            told("came_30_m_within_1_m", &line, far),
        ],
    }
}

fn table(runs: &[Outcome]) -> Table {
    Table::of(&columns(), runs.iter().enumerate())
}
