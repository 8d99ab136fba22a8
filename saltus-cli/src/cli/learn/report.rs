//! What all seeds learnt, in words, rows, JSON and a curve.

use saltus::gait::learn::Outcome;
use saltus::learning::{Interval, Learnt, PolicyFile, Pupil, Settings, Task, interquartile};
use saltus::running::Share;
use serde_json::{Value, json};

use crate::output::{self, Column, Table, columns, counted, digits, measured};
use crate::plot::line::{Line, Mark};
use crate::plot::palette::BLUE;
use crate::plot::sheet::{Panel, Sheet};

fn columns<'a>() -> [Column<(&'a Report<'a>, &'a Pupil)>; 12] {
    columns! {
        "seed", "", |(_, it)| usize::try_from(it.seed).unwrap_or(usize::MAX);
        "episodes", "", |(_, it)| it.curve.len();
        "reward", "", |(_, it)| it.score.total;
        "angle_rad", "", |(_, it)| it.score.outcome.angle;
        "travel_m", "", |(_, it)| it.score.outcome.travel;
        "arrived_s", "", |(_, it)| it.score.outcome.arrived;
        "time_s", "", |(_, it)| it.score.outcome.time;
        "firings", "", |(_, it)| it.score.outcome.firings;
        "gas_kg", "", |(_, it)| it.score.outcome.gas;
        "outside", "", |(_, it)| outside(it);
        "broken", "", |(_, it)| broken(it);
        "episodes_to_90_percent", "", |(report, it)| report.until_learnt(it);
    }
}

pub(super) struct Report<'a> {
    pub(super) settings: &'a Settings,
    pub(super) learnt: &'a Learnt,
    pub(super) interrupted: bool,
}

impl Report<'_> {
    /// Name, unit and value of what an episode is judged by.
    fn judged(&self, outcome: &Outcome) -> (&'static str, &'static str, f64) {
        let (name, unit) = match self.settings.task {
            Task::RunLegs => ("angle", "rad"),
            _ => ("travel", "m"),
        };
        (name, unit, self.settings.way(outcome))
    }

    fn figures(&self) -> Vec<f64> {
        let pupils = self.learnt.pupils.iter();
        pupils
            .map(|pupil| self.judged(&pupil.score.outcome).2)
            .collect()
    }

    fn arrived(&self) -> Share {
        Share {
            count: self.learnt.arrived(),
            of: self.learnt.pupils.len(),
        }
    }

    fn times(&self) -> Vec<f64> {
        let pupils = self.learnt.pupils.iter();
        pupils
            .filter_map(|pupil| pupil.score.outcome.arrived)
            .collect()
    }

    fn until_learnt(&self, pupil: &Pupil) -> Option<usize> {
        self.settings.episodes_to_90_percent(&pupil.curve)
    }

    pub(super) fn table(&self) -> Table {
        Table::of(&columns(), self.learnt.pupils.iter().map(|it| (self, it)))
    }

    /// Of each episode the mean of the middle half over the seeds, with its interval.
    fn curve(&self) -> Vec<Interval> {
        let episodes = self.learnt.pupils.iter().map(|pupil| pupil.curve.len());
        let shown = |episode: usize| {
            let pupils = self.learnt.pupils.iter();
            let scores = pupils.filter_map(|pupil| pupil.curve.get(episode));
            let values: Vec<f64> = scores.map(|score| self.judged(&score.outcome).2).collect();
            interquartile(&values)
        };
        (0..episodes.min().unwrap_or(0)).filter_map(shown).collect()
    }

    fn waits(&self) -> Vec<f64> {
        let pupils = self.learnt.pupils.iter();
        let counts = pupils.filter_map(|pupil| self.until_learnt(pupil));
        counts.map(|count| count as f64).collect()
    }

    pub(super) fn text(&self) -> String {
        let s = self.settings;
        let mut lines = self.means();
        let mut line = |name: &'static str, says: String| lines.push((name, says));
        let (way, unit, _) = self.judged(&Outcome::default());
        let learnt = if way == "angle" {
            "angle learnt"
        } else {
            "travel learnt"
        };
        line(learnt, said(interquartile(&self.figures()), unit));
        if let Some(best) = self.learnt.best(s) {
            let outcome = &best.score.outcome;
            let (value, unit) = match outcome.arrived {
                Some(time) if s.task != Task::RunLegs => (time, "s"),
                _ => (self.judged(outcome).2, unit),
            };
            line(
                "best",
                format!("{} {unit}, seed {}", short(value), best.seed),
            );
        }
        if s.task != Task::RunLegs {
            let share = self.arrived();
            let [low, high] = share.interval().map(|x| digits(100.0 * x, 3));
            let goal = format!("{} of {} (95 %: {low} to {high} %)", share.count, share.of);
            line("reach the goal", goal);
            line("time to the goal", said(interquartile(&self.times()), "s"));
        }
        line(
            "episodes to 90 % of it",
            said(interquartile(&self.waits()), ""),
        );
        let lost: usize = self.learnt.pupils.iter().map(broken).sum();
        if lost > 0 {
            let all: usize = self.learnt.pupils.iter().map(|it| it.curve.len()).sum();
            let says =
                format!("{lost} of {all} episodes, where the motion could not be computed further");
            line("ended early", says);
        }
        if s.plant.robot.ground.static_friction.is_infinite() {
            let says = "its feet never slip, and of two legs that stand so none can push: give ground.static_friction";
            line("note", says.into());
        }
        if self.interrupted {
            let says = "by Ctrl-C: of the episodes that were done";
            line("interrupted", says.into());
        }
        let all = s.schedule.episodes;
        let mut episodes = counted(all, "episode");
        if self.interrupted {
            episodes = format!("{} of {episodes}", self.done());
        }
        let head = format!(
            "{}: {} by {}, {episodes}, {}",
            s.plant.robot.name,
            s.task.name(),
            s.algorithm.name(),
            counted(self.learnt.pupils.len(), "seed")
        );
        output::lines(&head, 24, &lines)
    }

    /// Episodes that every seed has done.
    fn done(&self) -> usize {
        let done = self.learnt.pupils.iter().map(|it| it.curve.len());
        done.min().unwrap_or(0)
    }

    /// The numbers of what learns.
    fn means(&self) -> Vec<(&'static str, String)> {
        let s = self.settings;
        let terms = s.reward.0.iter();
        let terms: Vec<String> = terms.map(|(term, by)| format!("{term}={by}")).collect();
        let reward = ("reward", terms.join(", "));
        let (rates, schedule) = (&s.rates, &s.schedule);
        let traces = if s.algorithm.has_traces() {
            format!(", lambda {}", short(rates.lambda))
        } else {
            String::new()
        };
        let exploration = format!(
            "{}, times {} an episode",
            short(schedule.epsilon),
            short(schedule.decay)
        );
        vec![
            reward,
            (
                "alpha, gamma",
                format!("{}, {}{traces}", short(rates.alpha), short(rates.gamma)),
            ),
            ("exploration", exploration),
        ]
    }

    pub(super) fn json(&self) -> String {
        let s = self.settings;
        let (name, unit, _) = self.judged(&Outcome::default());
        let interval = |it: Option<Interval>| {
            it.map_or(
                Value::Null,
                |it| json!({ "mean_of_middle_half": it.value, "interval_95": it.interval }),
            )
        };
        let best = self.learnt.best(s);
        let arrived = self.arrived();
        let curve: Vec<Value> = self
            .curve()
            .iter()
            .enumerate()
            .map(|(episode, it)| {
                let [low, high] = it.interval;
                json!({ "episode": episode + 1, "mean_of_middle_half": it.value, "low": low, "high": high })
            })
            .collect();
        output::json(&json!({
            "command": "learn",
            "task": s.task.name(),
            "robot": s.plant.robot.name,
            "algorithm": s.algorithm.name(),
            "episodes": self.done(),
            "seeds": self.learnt.pupils.len(),
            "interrupted": self.interrupted,
            "score": { "name": format!("{name}_{unit}"), "learnt": interval(interquartile(&self.figures())),
                "best": best.map(|best| self.judged(&best.score.outcome).2) },
            "arrived": { "count": arrived.count, "of": arrived.of, "interval_95": arrived.interval() },
            "time_to_the_goal_s": interval(interquartile(&self.times())),
            "episodes_to_90_percent": interval(interquartile(&self.waits())),
            "best_seed": best.map(|best| best.seed),
            "rows": self.table().json(),
            "curve": curve,
            "policy": PolicyFile::of(s, self.learnt).json(),
        }))
    }

    /// The curve with its band.
    pub(super) fn drawing(&self) -> Sheet {
        let curve = self.curve();
        let line = |width, of: fn(&Interval) -> f64| {
            let points = curve.iter().enumerate();
            let points = points.map(|(episode, it)| ((episode + 1) as f64, of(it)));
            Line::new(Mark::Stroke(width), BLUE, points)
        };
        let s = self.settings;
        let panel = Panel {
            x: "episode",
            y: match s.task {
                Task::RunLegs => "angle in the episode (rad)",
                _ => "travel in the episode (m)",
            },
            lines: vec![
                line(3, |it| it.value).called("thick: mean of the middle half"),
                line(1, |it| it.interval[0]).called("thin: 95 % interval"),
                line(1, |it| it.interval[1]),
            ],
            ..Panel::default()
        };
        Sheet {
            title: format!(
                "{}: {} by {}, {}: mean of the middle half, 95 % interval thin",
                s.plant.robot.name,
                s.task.name(),
                s.algorithm.name(),
                counted(self.learnt.pupils.len(), "seed")
            ),
            wide: vec![panel],
            ..Sheet::default()
        }
    }
}

/// Share of the steps of learning in which a number was outside the states' ranges.
fn outside(pupil: &Pupil) -> f64 {
    let steps: usize = pupil.curve.iter().map(|score| score.steps).sum();
    let outside: usize = pupil.curve.iter().map(|score| score.outside).sum();
    outside as f64 / steps.max(1) as f64
}

/// Episodes of learning that ended because the motion could not be computed further.
fn broken(pupil: &Pupil) -> usize {
    let curve = pupil.curve.iter();
    curve.filter(|score| score.outcome.broken).count()
}

fn short(x: f64) -> String {
    measured(x, 4)
}

/// A value with its interval.
fn said(interval: Option<Interval>, unit: &str) -> String {
    interval.map_or_else(
        || "–".into(),
        |it| {
            let [low, high] = it.interval;
            format!(
                "{} {unit} (95 %: {} to {})",
                short(it.value),
                short(low),
                short(high)
            )
        },
    )
}
