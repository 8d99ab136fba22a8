//! How much a gait of a robot in space bears: the share of robots that succeed, over what is off.

use std::f64::consts::PI;
use std::fmt::Write as _;
use std::ops::ControlFlow;

use saltus::Robot;
use saltus::gait::space::{Ball, DrawnBalls, Knows, Roll, drawn_ball, roll};
use saltus::numeric::parallel;
use saltus::running::Share;
use serde_json::{Value, json};

use super::came::{Aim, FAR, Outcome, WIDE, follow};
use super::drawn::{SOON, Told, told};
use super::refused;
use crate::cli::Status;
use crate::cli::run::{Run, in_words, share};
use crate::error::CliError;
use crate::output::{self, Cell, Format, Table};
use crate::plot::Drawing;
use crate::plot::line::{Line, Mark};
use crate::plot::palette::{BLUE, GREY};
use crate::plot::sheet::{Panel, Sheet};
use crate::progress::Progress;

/// Friction of the ground where another imperfection is looked at.
const FRICTION: f64 = 0.9;
const DEGREE: f64 = PI / 180.0;

/// Something that is off.
struct Imperfection {
    /// Its name in CSV and JSON, with its unit; and in words, with one that is read easily.
    key: &'static str,
    words: &'static str,
    /// That unit.
    unit: f64,
    /// How much of it, in that unit.
    levels: &'static [f64],
    set: fn(&mut DrawnBalls, &mut Robot, f64),
}

/// What can be off, each by itself.
const ALL: [Imperfection; 4] = [
    Imperfection {
        key: "force_factor_standard_deviation",
        words: "scatter of the legs' forces (%)",
        unit: 0.01,
        levels: &[0.0, 2.0, 5.0, 10.0, 15.0, 20.0],
        set: |draw, _, x| draw.force = x,
    },
    Imperfection {
        key: "center_of_mass_within_m",
        words: "centre of mass within (mm)",
        unit: 1e-3,
        levels: &[0.0, 0.5, 1.0, 2.0, 3.0, 5.0],
        set: |draw, _, x| draw.center = x,
    },
    Imperfection {
        key: "friction",
        words: "friction of the ground",
        unit: 1.0,
        levels: &[0.2, 0.3, 0.4, 0.6, 0.8, 1.2],
        set: |draw, _, x| draw.friction = [x; 2],
    },
    Imperfection {
        key: "slope_rad",
        words: "slope, uphill ahead (deg)",
        unit: DEGREE,
        levels: &[-4.0, -2.0, -1.0, 0.0, 1.0, 2.0, 4.0],
        set: |_, robot, x| robot.ground.slope = x,
    },
];

/// The robots with so much of an imperfection.
struct Level<'a> {
    of: &'a Imperfection,
    value: f64,
    share: Share,
}

impl Run {
    /// Runs `robots` drawn balls for each amount of each imperfection.
    pub(super) fn what_it_bears(
        &self,
        setup: &Roll,
        aim: Aim,
        robots: usize,
    ) -> Result<Status, CliError> {
        self.note_a_short_run(setup, aim);
        // What is wrong with all of them is bad input, and said before they run.
        roll(setup, |_| false).map_err(|error| refused(error, &setup.robot))?;
        let levels = ALL
            .iter()
            .flat_map(|of| of.levels.iter().map(move |level| (of, *level)));
        let levels: Vec<(&Imperfection, f64)> = levels.collect();
        let progress = Progress::new("runs", levels.len() * robots);
        let runs = parallel::map_on(self.threads.count().get(), levels.len() * robots, |i| {
            let (of, level) = levels[i / robots];
            let came = self.with_one(setup, aim, (of, level), i % robots);
            progress.advance(1);
            came
        });
        drop(progress);
        let [_, what] = told(aim, &[]);
        let both = levels.iter().zip(runs.chunks(robots));
        let levels: Vec<Level<'_>> = both
            .map(|((of, value), runs)| {
                let [_, Told { share, .. }] = told(aim, runs);
                let value = *value;
                Level { of, value, share }
            })
            .collect();
        let head = format!(
            "{}, {robots} robots for each number, seed {}",
            self.head(&setup.robot),
            self.seed
        );
        let report = match self.output.format() {
            Format::Csv => table(&what, &levels).csv(),
            Format::Json => output::json(&self.borne(setup, &what, &levels)),
            Format::Text => text(&head, &what, &levels),
        };
        let drawing = || Ok(drawing(head.clone(), &what, &levels));
        self.output.write_with_plot(report, &self.plot, drawing)?;
        Ok(Status::Done)
    }

    /// Runs robot `k` of those with so much of one imperfection.
    fn with_one(
        &self,
        setup: &Roll,
        aim: Aim,
        (of, level): (&Imperfection, f64),
        k: usize,
    ) -> Outcome {
        let mut draw = DrawnBalls {
            force: 0.0,
            center: 0.0,
            friction: [FRICTION; 2],
        };
        let mut own = setup.clone();
        (of.set)(&mut draw, &mut own.robot, level * of.unit);
        own.robot = drawn_ball(&own.robot, &draw, self.seed, k)?;
        if let Knows::Sensors(seed) = &mut own.knows {
            *seed = seed.wrapping_add(k as u64);
        }
        own.start.thrown = self.thrown(k);
        // No longer than until it is known whether it succeeds.
        follow(&own, aim, |ball| {
            if is_decided(ball, aim) {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        })
    }

    fn borne(&self, setup: &Roll, what: &Told, levels: &[Level<'_>]) -> Value {
        let all = levels.iter().map(|level| {
            json!({ "imperfection": level.of.key, "value": level.value * level.of.unit, "share": share(&level.share) })
        });
        json!({
            "command": "run",
            "robot": setup.robot.name,
            "gait": self.gait.rolling().name(),
            "by_sensors": setup.knows != Knows::Truth,
            "seconds": setup.seconds,
            "seed": self.seed,
            "success": what.key,
            "bears": all.collect::<Vec<Value>>(),
        })
    }
}

/// Whether what comes changes nothing any more.
fn is_decided(ball: &Ball, aim: Aim) -> bool {
    let [x, y, _] = ball.place;
    match aim {
        Aim::Again => ball.time > SOON,
        Aim::Path(_) => ball.aside.abs() > WIDE,
        // Within its width it has come that far then.
        Aim::Line | Aim::Led => ball.aside.abs() > WIDE || x.hypot(y) > FAR + WIDE,
    }
}

fn text(head: &str, what: &Told, levels: &[Level<'_>]) -> String {
    let mut text = format!(
        "{head}\nwhat is off, each alone at friction {FRICTION}: {}\n",
        what.words
    );
    for level in levels {
        let name = format!("{} {}", level.of.words, level.value);
        let _ = writeln!(text, "  {name:<38} {}", in_words(&level.share));
    }
    text
}

fn table(what: &Told, levels: &[Level<'_>]) -> Table {
    let mut table = Table::new(&[
        "imperfection",
        "value",
        "count",
        "of",
        "share",
        "low_95",
        "high_95",
        "success",
    ]);
    for Level { of, value, share } in levels {
        let [low, high] = share.interval();
        table.push(vec![
            Cell::Word(of.key),
            (value * of.unit).into(),
            Cell::Count(share.count),
            Cell::Count(share.of),
            share.value().into(),
            low.into(),
            high.into(),
            Cell::Word(what.key),
        ]);
    }
    table
}

fn drawing(title: String, what: &Told, levels: &[Level<'_>]) -> Drawing {
    let panel = |of: &Imperfection| {
        let own = || levels.iter().filter(|level| level.of.key == of.key);
        let line = |label: Option<&str>, color, mark, y: &dyn Fn(&Share) -> f64| Line {
            label: label.map(Into::into),
            points: own().map(|it| (it.value, 100.0 * y(&it.share))).collect(),
            color,
            mark,
        };
        Panel {
            title: what.words.clone(),
            x: of.words,
            y: "robots (%)",
            lines: vec![
                line(Some("share"), BLUE, Mark::Solid, &Share::value),
                line(Some("95 % interval"), GREY, Mark::Dashed, &|it| {
                    it.interval()[0]
                }),
                line(None, GREY, Mark::Dashed, &|it| it.interval()[1]),
            ],
            least: Some([[of.levels[0]; 2], [0.0, 100.0]]),
        }
    };
    Drawing::Sheet(Sheet {
        title,
        course: None,
        panels: ALL.iter().map(panel).collect(),
    })
}
