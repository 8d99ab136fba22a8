//! Many drawn robots, each run.

use saltus::Robot;
use saltus::gait::{Draw, Ending, Ensemble, GaitError, Setup, Summary, drawn_robot};
use saltus::running::{RUNS_FROM, Together};
use serde_json::{Value, json};

use super::InPlane;
use super::report::{Disturbed, head};
use crate::cli::Status;
use crate::cli::refused::refused;
use crate::error::CliError;
use crate::output::{
    self, Column, Files, Format, Table, columns, counted, digits, in_words, joined, measured, share,
};
use crate::progress::Progress;

/// A drawn robot and what became of it.
struct Ran<'a> {
    number: usize,
    robot: Robot,
    run: &'a Result<Summary, GaitError>,
}

impl Ran<'_> {
    /// A number of its run, if it was simulated.
    fn of<T>(&self, number: impl Fn(&Summary) -> T) -> Option<T> {
        self.run.as_ref().ok().map(number)
    }

    fn stalled(&self, number: impl Fn(f64, f64) -> f64) -> Option<f64> {
        match self.of(|run| run.ending)? {
            Ending::Ran => None,
            Ending::Stalled { since, at } => Some(number(since, at)),
        }
    }
}

fn columns<'a>() -> [Column<Ran<'a>>; 24] {
    columns! {
        "robot", "", |it| it.number;
        "coulomb_friction_n", "", |it| it.robot.leg.coulomb_friction;
        "spring_stiffness_n_per_m", "", |it| it.robot.leg.return_spring.map(|spring| spring.stiffness);
        "spring_preload_n", "", |it| it.robot.leg.return_spring.map(|spring| spring.preload);
        "supply_pressure_gauge_pa", "", |it| it.robot.leg.cylinder().map(|cylinder| cylinder.supply.0);
        "friction_along", "", |it| it.robot.ground.static_friction;
        "ending", "", |it| it.of(|run| if run.ending == Ending::Ran { "ran" } else { "stalled" });
        "stalled_since_s", "", |it| it.stalled(|since, _| since.max(0.0));
        "stalled_at_m", "", |it| it.stalled(|_, at| at);
        "travel_m", "", |it| it.of(|run| run.travel);
        "mean_speed_m_s", "", |it| it.of(|run| run.mean_speed);
        "mean_speed_last_4_s_m_s", "", |it| it.of(|run| run.mean_speed_last_4_s);
        "speed_at_end_m_s", "", |it| it.of(|run| run.speed_at_end);
        "top_speed_m_s", "", |it| it.of(|run| run.top_speed);
        "reached_3_2_m_s_s", "", |it| it.of(|run| run.reached_3_2);
        "speed_at_1_6_s_m_s", "", |it| it.of(|run| run.speed_at_1_6);
        "time_to_1_6_m_s", "", |it| it.of(|run| run.time_to_1_6_m);
        "firings", "", |it| it.of(|run| run.firings);
        "touch_downs", "", |it| it.of(|run| run.touch_downs);
        "other_contacts", "", |it| it.of(|run| run.bump_count);
        "gas_kg", "", |it| it.of(|run| run.gas);
        "drives_j", "", |it| it.of(|run| run.ledger.drive);
        "residual_j", "", |it| it.of(|run| -run.residual);
        "error", "", |it| it.run.as_ref().err().map(GaitError::to_string);
    }
}

/// The runs and where they come from.
struct Many<'a> {
    ensemble: &'a Ensemble,
    run: &'a InPlane,
    runs: &'a [Result<Summary, GaitError>],
}

impl InPlane {
    /// Runs drawn robots and reports their shares.
    pub(super) fn many(&self, setup: &Setup) -> Result<Status, CliError> {
        if setup.robot.leg.cylinder().is_none() {
            let allowed = "used with a robot with pneumatic legs, whose supply is drawn";
            return Err(CliError::flag("--robots", "", allowed));
        }
        let robots = self.flags.robots.map_or(1, std::num::NonZeroUsize::get);
        let mut files = Files::default();
        files.extend(self.flags.output.out().map(|out| ("--out", out)));
        files.check()?;
        let ensemble = Ensemble {
            setup: setup.clone(),
            draw: Draw {
                across: self.plane.drawn_across,
                ..Draw::around(&setup.robot)
            },
            robots,
            seed: self.flags.seed,
        };
        // What is wrong with all of them is bad input, and said before they run.
        let mut first = setup.clone();
        first.robot = drawn_robot(&setup.robot, &ensemble.draw, self.flags.seed, 0)
            .map_err(|error| refused(error, &setup.robot, self.angles))?;
        first.seconds = setup.sensors().period.min(setup.seconds);
        saltus::gait::run(&first, &mut ())
            .map_err(|error| refused(error, &setup.robot, self.angles))?;
        let progress = Progress::new("robots", robots);
        let runs = ensemble.run(self.flags.threads.count().get(), &|| {
            progress.advance(1);
        });
        drop(progress);
        let many = Many {
            ensemble: &ensemble,
            run: self,
            runs: &runs,
        };
        let report = match self.flags.output.format() {
            Format::Csv => many.table()?.csv(),
            Format::Json => many.json()?,
            Format::Text => many.text(),
        };
        self.flags.output.write_report(report)?;
        Ok(Status::Done)
    }
}

impl Many<'_> {
    fn sign(&self) -> f64 {
        if self.ensemble.setup.forwards {
            1.0
        } else {
            -1.0
        }
    }

    fn together(&self) -> Together {
        Together::of(&self.runs.iter().flatten(), self.sign())
    }

    /// Whether each disturbance was there in any run.
    fn met(&self) -> Vec<bool> {
        let is_met = |k: usize| self.runs.iter().flatten().any(|run| run.disturbed[k]);
        (0..self.run.plane.disturb.len()).map(is_met).collect()
    }

    /// Those that could not be simulated, with the first reason.
    fn failures(&self) -> (usize, Option<String>) {
        let failed = || self.runs.iter().enumerate();
        let first = failed().find_map(|(k, run)| Some((k, run.as_ref().err()?)));
        let count = failed().filter(|(_, run)| run.is_err()).count();
        (count, first.map(|(k, error)| format!("robot {k}: {error}")))
    }

    fn stalled(&self) -> usize {
        let runs = self.runs.iter().flatten();
        runs.filter(|run| run.ending != Ending::Ran).count()
    }

    fn text(&self) -> String {
        let all = self.together();
        let setup = &self.ensemble.setup;
        let head = format!(
            "{}: {}, {} s, {}, seed {}",
            setup.robot.name,
            self.run.words,
            digits(setup.seconds, 6),
            counted(self.ensemble.robots, "drawn robot"),
            self.ensemble.seed
        );
        let mut lines: Vec<(String, String)> = Vec::new();
        let mut line = |name: &str, text: String| lines.push((name.into(), text));
        let disturbed = Disturbed::of(&self.run.plane.disturb, &self.met());
        for (name, text) in disturbed.lines(setup.seconds) {
            line(name, text);
        }
        line("drawn", self.drawn());
        for (least, share) in RUNS_FROM.iter().zip(&all.running) {
            line(&format!("over {least} m/s in the end"), in_words(share));
        }
        let short = |x: f64| measured(x, 3);
        line("stalled in the end", self.stalled().to_string());
        let none = || "–".to_owned();
        let speed = all.speed.map(|it| it.map(short));
        let speed =
            speed.map(|[from, median, to]| format!("median {median}, from {from} to {to} m/s"));
        line("speed of those that run", speed.unwrap_or_else(none));
        line("3.2 m/s reached by", in_words(&all.reached));
        let time = all.time_to_3_2.map(|it| it.map(short));
        let time = time.map(|[best, median]| format!("median {median}, best {best} s"));
        line("3.2 m/s reached at", time.unwrap_or_else(none));
        line("3.2 m/s within 3 s", in_words(&all.within_3_s));
        let start = all.speed_at_1_6.map(|it| it.map(short));
        let start = start.map(|[median, best]| format!("median {median}, best {best} m/s"));
        line("speed at 1.6 s", start.unwrap_or_else(none));
        let gas = all
            .gas_per_metre
            .map(|gas| format!("median {} g/m", short(gas * 1e3)));
        line("gas of those that run", gas.unwrap_or_else(none));
        if let (count, Some(first)) = self.failures() {
            line("not simulated", format!("{count}, {first}"));
        }
        output::lines(&head, 24, &lines)
    }

    fn drawn(&self) -> String {
        let draw = &self.ensemble.draw;
        let short = |x: f64| digits(x, 4);
        format!(
            "dry friction {} to {} N; spring up to {} N/m, the rest of {} N at mid stroke; \
             supply ± {} psi; friction {} to {} along, {} across",
            short(draw.friction[0]),
            short(draw.friction[1]),
            short(draw.stiffness[1]),
            short(draw.total),
            short(draw.supply / 6_894.757_293_168),
            short(draw.along[0]),
            short(draw.along[1]),
            short(draw.across)
        )
    }

    fn table(&self) -> Result<Table, CliError> {
        let around = &self.ensemble.setup.robot;
        let row = |(number, run)| {
            let robot = drawn_robot(around, &self.ensemble.draw, self.ensemble.seed, number);
            Ok(Ran {
                number,
                robot: robot.map_err(|error| refused(error, around, self.run.angles))?,
                run,
            })
        };
        let rows: Result<Vec<_>, CliError> = self.runs.iter().enumerate().map(row).collect();
        Ok(Table::of(&columns(), rows?))
    }

    fn json(&self) -> Result<String, CliError> {
        let all = self.together();
        let setup = &self.ensemble.setup;
        let draw = &self.ensemble.draw;
        let (failures, first_failure) = self.failures();
        let running = |k: usize| {
            let mut value = share(&all.running[k]);
            value["from_m_s"] = json!(RUNS_FROM[k]);
            value
        };
        let entries = |names: &[&str], values: Option<&[f64]>| {
            let values = values.map(|values| {
                let pairs = names.iter().zip(values);
                pairs
                    .map(|(name, value)| ((*name).to_owned(), json!(value)))
                    .collect::<serde_json::Map<_, _>>()
            });
            values.map_or(Value::Null, Value::Object)
        };
        let answer = json!({
            "drawn": {
                "coulomb_friction_n": draw.friction,
                "spring_stiffness_n_per_m": draw.stiffness,
                "friction_and_spring_at_mid_stroke_n": draw.total,
                "supply_standard_deviation_pa": draw.supply,
                "friction_along": draw.along,
                "friction_across": draw.across,
            },
            "robots": self.ensemble.robots,
            "not_simulated": failures,
            "first_not_simulated": first_failure,
            "stalled": self.stalled(),
            "running": [running(0), running(1)],
            "speed_of_runners_m_s": entries(&["least", "median", "greatest"], all.speed.as_ref().map(|s| &s[..])),
            "reached_3_2_m_s": share(&all.reached),
            "reached_3_2_m_s_within_3_s": share(&all.within_3_s),
            "time_to_3_2_m_s_s": entries(&["best", "median"], all.time_to_3_2.as_ref().map(|s| &s[..])),
            "speed_at_1_6_s_m_s": entries(&["median", "best"], all.speed_at_1_6.as_ref().map(|s| &s[..])),
            "gas_of_runners_kg_per_m": all.gas_per_metre,
            "runs": self.table()?.json(),
        });
        let head = head(setup, self.run, &self.met());
        Ok(output::json(&joined([head, answer])))
    }
}
