//! A diagnosis of data as they were read, and what it is worth: the extended robot, and firing
//! tables before and after.

use std::fmt::{self, Write};

use saltus_diagnosis::kinds::{self, Problem};
use saltus_diagnosis::rig::Rig;
use saltus_diagnosis::{
    Diagnosis, Experiment, Interval, Kind, Known, KnownError, Misstated, Reported, Settings, Sort,
    Stage, Terms, check_known, disbelieve, misstated,
};
use saltus_numeric::statistics::{line, rms};
use saltus_planner::{Planner, TableRequest};
use saltus_robot::{Robot, RobotError};

use crate::experiment::{Folder, plausible};

/// A diagnosis with the model that it is of.
pub struct Study {
    /// The experiment, with the noise that its readings are judged by.
    pub kind: Box<dyn Kind>,
    /// What was found.
    pub diagnosis: Diagnosis,
    /// Columns whose stated noise is far from what the data scatter. Where it is stated far too
    /// large, the seen scatter took its place.
    pub misstated: Vec<Misstated>,
    /// What is known, and is about no cause of this kind of experiment.
    pub unused: Vec<String>,
}

/// Why data have no diagnosis.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StudyError {
    /// Data and robot do not go together.
    #[error(transparent)]
    Problem(#[from] Problem),
    /// The model has no motion like that of a run, at its first guesses.
    #[error("{0}")]
    NoMotion(NoMotion),
    /// Something that cannot be known.
    #[error(transparent)]
    Known(#[from] KnownError),
    /// Data whose sizes cannot be those of the robot.
    #[error(transparent)]
    Data(#[from] crate::experiment::Error),
    /// The robot that the folder names.
    #[error(transparent)]
    Robot(#[from] RobotError),
}

impl Folder {
    /// Says what is wrong with the model of the robot that the folder names, or of what else was
    /// measured.
    ///
    /// # Errors
    /// [`StudyError`] where the robot cannot be read, or data and robot do not go together.
    pub fn diagnose(&self, settings: &Settings) -> Result<Study, StudyError> {
        let robot = self.robot()?;
        plausible(self, robot.as_ref())?;
        let settings = self.settings(settings);
        study(&self.experiment, robot.as_ref(), &settings, &|_| ())
    }

    /// `settings` with what the folder knows, where they do not know otherwise.
    pub fn settings(&self, settings: &Settings) -> Settings {
        let mut all = settings.clone();
        let own = self.known.iter();
        let is_new = |known: &&Known| settings.known.iter().all(|k| k.name != known.name);
        all.known.extend(own.filter(is_new).cloned());
        all
    }
}

/// Says what is wrong with the model of an experiment, of `robot` where it is one with a robot;
/// `progress` receives the share of the work that is done.
///
/// # Errors
/// [`StudyError`] where data and robot do not go together, or the model has no such motion.
pub fn study(
    experiment: &Experiment,
    robot: Option<&Robot>,
    settings: &Settings,
    progress: &(dyn Fn(Stage) + Sync),
) -> Result<Study, StudyError> {
    /// Looks at the noise: what a cause explains that is found with less of it may show that there
    /// is less still.
    const MOST: usize = 4;
    /// Ratio of stated to seen noise from which on fits are made by the seen one.
    const FAR: f64 = 5.0;
    let mut experiment = experiment.clone();
    let mut doubted = disbelieve(&mut experiment);
    let mut rounds = 0;
    loop {
        let kind = kinds::build(&experiment, robot)?;
        let unused = check_known(kind.causes(), &settings.known)?;
        let diagnosis = saltus_diagnosis::diagnose(kind.as_ref(), settings, progress);
        let Some(diagnosis) = diagnosis else {
            return Err(StudyError::NoMotion(NoMotion::of(
                kind.as_ref(),
                &experiment,
            )));
        };
        let found = misstated(&experiment, kind.as_ref(), &diagnosis);
        let mut is_overstated = false;
        for now in found {
            if now.stated > FAR * now.seen {
                is_overstated = true;
                let column = experiment
                    .columns
                    .iter()
                    .position(|column| *column == now.column);
                if let Some(k) = column {
                    experiment.noise[k] = Some(now.seen);
                }
            }
            match doubted
                .iter_mut()
                .find(|before| before.column == now.column)
            {
                Some(before) => before.seen = now.seen,
                None => doubted.push(now),
            }
        }
        rounds += 1;
        if !is_overstated || rounds == MOST {
            return Ok(Study {
                kind,
                diagnosis,
                misstated: doubted,
                unused: unused.into_iter().map(str::to_owned).collect(),
            });
        }
    }
}

/// What a firing table is off by when the robot that was measured jumps from it.
#[derive(Clone, Debug, PartialEq)]
pub struct Worth {
    /// Distance (m) that is planned for, landing with the axle at its height on a retracted leg.
    pub distance: f64,
    /// For each approach rate (rad/s): firing angles (rad) before and after, and by how far (m) the
    /// extended robot lands off with each.
    pub rows: Vec<Row>,
    /// The linear law α_f = A ω + B (s, rad) through the angles, before and after.
    pub laws: [Option<(f64, f64)>; 2],
}

/// One approach rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Approach rate (rad/s).
    pub rate: f64,
    /// Firing angle (rad) before and after; none where no angle gets so far.
    pub angles: [Option<f64>; 2],
    /// Landing error (m) of the extended robot; none where it does not jump.
    pub errors: [Option<f64>; 2],
}

impl Worth {
    /// Root mean square of the landing errors (m) before and after, over the rates at which both
    /// tables have an angle.
    pub fn rms(&self) -> Option<[f64; 2]> {
        let pairs: Vec<[f64; 2]> = self
            .rows
            .iter()
            .filter_map(|r| Some([r.errors[0]?, r.errors[1]?]))
            .collect();
        let of = |k: usize| rms(&pairs.iter().map(|p| p[k]).collect::<Vec<_>>());
        (!pairs.is_empty()).then(|| [of(0), of(1)])
    }
}

/// Valve opening time (s) of the tables.
const OPEN: f64 = 0.1;

/// The first run for which the model has no motion.
#[derive(Clone, Debug, PartialEq)]
pub struct NoMotion {
    /// The run, if it is one of them.
    pub run: Option<String>,
    /// Of a jump, the time (s) from its first valid row to the command.
    pub before_command: Option<f64>,
}

impl NoMotion {
    fn of(kind: &dyn Kind, experiment: &Experiment) -> NoMotion {
        let terms = Terms::off(kind.causes());
        let stands = |run: &usize| {
            let guess: Vec<f64> = kind
                .unknowns(*run)
                .iter()
                .map(|unknown| unknown.neutral)
                .collect();
            kind.predict(*run, &terms, &guess).is_none()
        };
        let run = (0..kind.logs().len()).find(stands);
        let valve = run
            .filter(|_| experiment.kind == Sort::Jump)
            .and_then(|run| experiment.runs.get(run)?.valve);
        NoMotion {
            run: run.map(|run| kind.logs()[run].name.clone()),
            before_command: valve.map(|(open, _)| open),
        }
    }
}

impl fmt::Display for NoMotion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(run) = &self.run {
            write!(f, "{run}: ")?;
        }
        f.write_str("the model has no such motion")?;
        match self.before_command {
            Some(open) => write!(
                f,
                " from the first valid row, which is {open:.3} s before the command. The log of a \
                 jump starts just after the jumping leg touched down: set valid_from_s to that \
                 time. Or is it another robot that was measured?"
            ),
            None => f.write_str(": is what the file says what was measured, with its units?"),
        }
    }
}

impl Study {
    /// The robot with the terms that were found and that the data tell the size of; none where
    /// nothing of a robot was found.
    pub fn extended(&self) -> Option<Robot> {
        let (kind, diagnosis) = (self.kind.as_ref(), &self.diagnosis);
        let off = Terms::off(kind.causes());
        let mut terms = diagnosis.after.terms.clone();
        for finding in diagnosis
            .findings
            .iter()
            .filter(|finding| !finding.is_identifiable)
        {
            for (p, neutral) in off.of(finding.best.cause).iter().enumerate() {
                terms.set(finding.best.cause, p, *neutral);
            }
        }
        let (believed, mut robot) = (kind.robot(&off)?, kind.robot(&terms)?);
        if robot == believed {
            return None;
        }
        robot.name = format!("{} as measured", robot.name);
        Some(robot)
    }

    /// The robot file of the extended robot: values, standard errors and the data's hash are in
    /// comments at its head.
    pub fn robot_file(&self, robot: &Robot, hash: &str) -> String {
        let diagnosis = &self.diagnosis;
        let mut text = String::from("# Written by saltus diagnose from measured data, ");
        let _ = writeln!(text, "hash {hash}.");
        for finding in &diagnosis.findings {
            let _ = write!(text, "# {}", finding.best.id);
            if let Some(column) = &finding.best.column {
                let _ = write!(text, " of {column}, not a property of the robot");
            }
            let _ = writeln!(text, ":");
            for Reported {
                name,
                value,
                error,
                interval,
                runs_disagree,
            } in &finding.best.reported
            {
                let _ = write!(text, "#   {name} = {value:?}");
                if error.is_finite() {
                    let _ = write!(text, ", standard error {error:.2e}");
                }
                if let Some(Interval { low, high }) = interval {
                    let end = |end: &Option<f64>| end.map_or("open".into(), |x| format!("{x:.4e}"));
                    let _ = write!(text, ", 95 % interval {} to {}", end(low), end(high));
                }
                if *runs_disagree {
                    text.push_str(", runs disagree");
                }
                text.push('\n');
            }
            if !finding.rivals.is_empty() {
                let rivals: Vec<&str> = finding.rivals.iter().map(|r| r.id).collect();
                let _ = writeln!(
                    text,
                    "#   the data cannot tell it from: {}",
                    rivals.join(", ")
                );
            }
        }
        text.push('\n');
        text.push_str(&robot.to_toml());
        text
    }
}

/// Firing tables for a distance that both robots reach, made with the robot as believed and as
/// `extended`, and where the extended robot lands when it jumps from each.
///
/// It jumps in the model that was fitted, which knows what the planar model of the tables leaves
/// out: so the error after is that of the planar model alone.
pub fn worth(believed: &Robot, extended: &Robot) -> Option<Worth> {
    let rates: Vec<f64> = (0..7).map(|k| 3.0 + 0.5 * f64::from(k)).collect();
    let rig = Rig::new(extended);
    [0.8, 0.6, 0.4, 0.3].into_iter().find_map(|distance| {
        let tables = [believed, extended].map(|robot| angles(robot, &rates, distance));
        let [Some(before), Some(after)] = tables else {
            return None;
        };
        let lands = |rate: f64, angle: Option<f64>| {
            rig.outcome(angle?, rate, OPEN).map(|(_, x)| x - distance)
        };
        let rows: Vec<Row> = rates
            .iter()
            .zip(before.iter().zip(&after))
            .map(|(&rate, (&b, &a))| Row {
                rate,
                angles: [b, a],
                errors: [lands(rate, b), lands(rate, a)],
            })
            .collect();
        let count = rows
            .iter()
            .filter(|r| r.errors.iter().all(Option::is_some))
            .count();
        let points = |k: usize| {
            rows.iter()
                .filter_map(move |r| Some((r.rate, r.angles[k]?)))
        };
        let laws = [0, 1].map(|k| line(&points(k).collect::<Vec<_>>()));
        (count >= 4).then_some(Worth {
            distance,
            rows,
            laws,
        })
    })
}

fn angles(robot: &Robot, rates: &[f64], distance: f64) -> Option<Vec<Option<f64>>> {
    let request = TableRequest {
        valve_open: OPEN,
        sensitivities: false,
        ..TableRequest::distance(distance)
            .rates(rates)
            .landing_height(robot.body.radius)
    };
    let table = Planner::new(robot.clone()).table(&request).ok()?;
    Some(
        table
            .cells
            .iter()
            .map(|cell| cell.entries.first().map(|e| e.jump.launch.firing_angle))
            .collect(),
    )
}
