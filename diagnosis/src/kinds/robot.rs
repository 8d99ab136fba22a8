//! Experiments with a robot or its leg: the bench, hops, jumps, and their outcomes.

mod proposals;
mod terms;

use std::sync::Arc;

use saltus_numeric::statistics::median;
use saltus_robot::{Drive, GaugePressure, Robot};
use terms::Effect;

use super::unknown;
use crate::experiment::{Experiment, Run, Sort};
use crate::kind::{Asked, Cause, Data, Kind, Log, Parameter, Proposal, Reading, Terms};
use crate::noise;
use crate::recent::Recent;
use crate::rig::{Course, Extra, Flight, Others, Pose, Rig, Start};
use crate::sensor::Fault;
use crate::spec::Problem;

/// Firings of a robot, or of one of its legs.
#[derive(Clone, Debug)]
pub struct Firings {
    sort: Sort,
    robot: Robot,
    pub(super) data: Data,
    columns: Vec<Column>,
    runs: Vec<Setting>,
    effects: Vec<Effect>,
    /// Whether the radius angle, or the travel, is 0 where the axle starts, and not where the foot
    /// stands.
    from_axle: bool,
    /// Of strides of a run, which of them begin in the air, and their other legs.
    aloft: Option<Vec<(bool, Arc<Others>)>>,
    /// Courses of each run, the latest last: sensors that are off look at the same one.
    courses: Vec<Courses>,
}

/// Courses by what a robot has of the causes, and by the start.
type Courses = Recent<[Vec<f64>; 2], Option<Arc<Course>>>;
/// How many of them are kept.
const KEPT: usize = 6;

/// What the operator did.
#[derive(Clone, Debug)]
struct Setting {
    load: f64,
    supply: Option<f64>,
    /// Slope of the ground (rad) that the operator knows, uphill forward positive.
    slope: f64,
    open: f64,
    shut: f64,
    /// Approach rate (rad/s), firing angle (rad) and valve opening (s) of each row of an outcome.
    asked: Vec<[f64; 3]>,
    /// Its number, which need not count from 0.
    rows: Vec<f64>,
}

/// What a column measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Column {
    Position,
    Pressure,
    Lean,
    Pivot,
    Turn,
    Travel,
    Height,
    Rate,
    Distance,
    Apex,
}

impl Column {
    fn named(name: &str) -> Option<Column> {
        Some(match name {
            "position_m" => Column::Position,
            "pressure_pa" => Column::Pressure,
            "wheel_angle_rad" => Column::Lean,
            "pivot_angle_rad" => Column::Pivot,
            "radius_angle_rad" => Column::Turn,
            "x_m" => Column::Travel,
            "y_m" => Column::Height,
            "wheel_rate_rad_s" => Column::Rate,
            "distance_m" => Column::Distance,
            "apex_m" => Column::Apex,
            _ => return None,
        })
    }
}

/// Longest time (s) for which a hop is simulated before its command.
const STANDS: f64 = 0.05;
/// Index of the gyro's tilt among the unknowns of a jump.
const GYRO: usize = 2;

impl Firings {
    /// The experiment as firings of what the operator believes is `robot`.
    ///
    /// # Errors
    /// [`Problem`] where the data and the robot do not go together.
    pub fn new(experiment: &Experiment, robot: &Robot) -> Result<Firings, Problem> {
        let is_pneumatic = matches!(robot.leg.drive, Drive::Pneumatic(_));
        if experiment.kind == Sort::Bench && !is_pneumatic {
            return Err(Problem::NotPneumatic {
                robot: robot.name.clone(),
            });
        }
        let of_boom =
            |name: &&String| matches!(Column::named(name), Some(Column::Pivot | Column::Turn));
        if let (None, Some(column)) = (robot.boom, experiment.columns.iter().find(of_boom)) {
            return Err(Problem::NoBoom {
                robot: robot.name.clone(),
                column: column.clone(),
            });
        }
        let measured: Vec<(usize, Column)> = experiment
            .columns
            .iter()
            .enumerate()
            .filter_map(|(i, name)| Some((i, Column::named(name)?)))
            .collect();
        let columns: Vec<Column> = measured.iter().map(|m| m.1).collect();
        let indices: Vec<usize> = measured.iter().map(|m| m.0).collect();
        let requests =
            ["omega_rad_s", "alpha_f_rad", "valve_open_s"].map(|name| experiment.column(name));
        let runs: Vec<Run> = match experiment.kind {
            Sort::Outcomes => experiment.runs.iter().flat_map(parts).collect(),
            _ => experiment.runs.clone(),
        };
        let runs: Vec<Run> = runs
            .into_iter()
            .map(|run| from_start(run, experiment.kind))
            .collect();
        let log = |run| noise::log(experiment, run, &indices);
        let mut data = Data {
            channels: noise::channels(experiment, &indices),
            logs: runs.iter().map(log).collect(),
            ..Data::default()
        };
        let courses = runs.iter().map(|_| Courses::default()).collect();
        let runs = runs.iter().map(|run| setting(run, &requests)).collect();
        let effects = terms::causes(&mut data, experiment.kind, robot, &columns);
        let mut firings = Firings {
            sort: experiment.kind,
            robot: robot.clone(),
            data,
            columns,
            runs,
            effects,
            from_axle: false,
            aloft: None,
            courses,
        };
        firings.from_axle = firings.starts_at_axle();
        Ok(firings)
    }

    /// Strides of a run as jumps, of which some begin in the air: none has a zero of its radius angle
    /// or travel, or begins with its log.
    ///
    /// # Errors
    /// [`Problem`] where the data and the robot do not go together.
    pub(super) fn of_strides(
        strides: &Experiment,
        aloft: Vec<(bool, Arc<Others>)>,
        robot: &Robot,
    ) -> Result<Firings, Problem> {
        let mut firings = Firings::new(strides, robot)?;
        firings.aloft = Some(aloft);
        firings.from_axle = false;
        let is_there = |cause: &Cause| match cause.fault {
            Some(Fault::Held) => false,
            Some(Fault::Offset) => {
                let column = cause.column.as_deref().and_then(Column::named);
                !matches!(column, Some(Column::Turn | Column::Travel))
            }
            _ => true,
        };
        let data = &mut firings.data;
        let kept: Vec<bool> = data.causes.iter().map(is_there).collect();
        data.listed = kept[..data.listed].iter().filter(|is| **is).count();
        data.causes.retain(is_there);
        let mut kept = kept.into_iter();
        firings.effects.retain(|_| kept.next().unwrap_or(true));
        Ok(firings)
    }

    /// Radius angle (rad), or travel (m), of the axle from its foot at a lean (rad).
    pub(super) fn start_turn(&self, lean: f64) -> f64 {
        let is_angle = self.columns.contains(&Column::Turn);
        self.robot.body.radius * lean.sin() / if is_angle { self.arm() } else { 1.0 }
    }

    /// Whether the radius angle, or else the travel, starts nearer to 0 than where the axle is with
    /// the foot at 0.
    fn starts_at_axle(&self) -> bool {
        let of = |column: Column| self.columns.iter().position(|c| *c == column);
        let turn = of(Column::Turn).map(|turn| (turn, self.arm()));
        let (Some((turn, arm)), Some(lean)) = (
            turn.or(of(Column::Travel).map(|travel| (travel, 1.0))),
            of(Column::Lean),
        ) else {
            return false;
        };
        let first = |log: &Log, channel: usize| {
            let first = log.of(channel).take(5);
            median(&mut first.map(|r| r.value).collect::<Vec<f64>>())
        };
        let votes = self.data.logs.iter().map(|log| {
            let (turn, lean) = (first(log, turn), first(log, lean));
            let foot_at_0 = self.robot.body.radius * lean.sin() / arm;
            if turn.abs() < (turn - foot_at_0).abs() {
                1
            } else {
                -1
            }
        });
        votes.sum::<i32>() > 0
    }

    /// Travel of the axle (m) for each unit of a pose's turn.
    fn arm(&self) -> f64 {
        self.robot.boom.map_or(1.0, |boom| boom.length)
    }

    /// The robot of a run with the terms on.
    fn at_work(&self, run: usize, terms: &Terms) -> (Robot, f64) {
        let setting = &self.runs[run];
        let mut robot = self.robot.clone();
        let mut load = setting.load;
        if let (Drive::Pneumatic(cylinder), Some(supply)) = (&mut robot.leg.drive, setting.supply) {
            cylinder.supply = GaugePressure(supply);
        }
        self.switch_on(&mut robot, &mut load, terms);
        robot.ground.slope += setting.slope;
        (robot, load)
    }

    fn switch_on(&self, robot: &mut Robot, load: &mut f64, terms: &Terms) {
        for (k, (effect, cause)) in self.effects.iter().zip(&self.data.causes).enumerate() {
            let values = terms.of(k);
            if values
                .iter()
                .zip(&cause.parameters)
                .all(|(v, p)| *v == p.neutral)
            {
                continue;
            }
            match effect {
                Effect::Terms(all) => terms::set(robot, all, values),
                Effect::Robot(apply) => apply(robot, values),
                Effect::LoadFactor => *load *= values[0],
                Effect::LoadAdded => *load = (*load + values[0]).max(1e-3),
                Effect::Extra(_) | Effect::None => {}
            }
        }
    }

    /// The terms that no listed cause has.
    fn extra(&self, terms: &Terms) -> Extra {
        let mut extra = Extra::default();
        for (k, effect) in self.effects.iter().enumerate().skip(self.data.listed) {
            if let Effect::Extra(set) = effect {
                set(&mut extra, terms.get(k, 0));
            }
        }
        extra
    }

    fn course(&self, run: usize, terms: &Terms, unknowns: &[f64]) -> Option<Arc<Course>> {
        let parts = self.effects.iter().enumerate();
        let of_robot = parts.filter(|(_, effect)| !matches!(effect, Effect::None));
        let of_robot = of_robot.flat_map(|(k, _)| terms.of(k).iter().copied());
        let start = match self.aloft {
            Some(_) => unknowns,
            None => unknowns.get(..GYRO).unwrap_or(unknowns),
        };
        let question = [of_robot.collect(), start.to_vec()];
        self.courses[run].ask(question, KEPT, |_| {
            self.simulated(run, terms, unknowns).map(Arc::new)
        })
    }

    fn simulated(&self, run: usize, terms: &Terms, unknowns: &[f64]) -> Option<Course> {
        let setting = &self.runs[run];
        let (robot, load) = self.at_work(run, terms);
        let end = self.data.logs[run].readings.last()?.time;
        let extra = self.extra(terms);
        match self.sort {
            Sort::Bench => Rig::bench(&robot, load).with(extra).jump(
                Start::Rest,
                setting.open,
                setting.shut,
                Some(end),
            ),
            Sort::Hop => Rig::new(&robot).with(extra).jump(
                Start::Rest,
                setting.open,
                setting.shut,
                Some(end),
            ),
            _ => {
                let stride = self.aloft.as_ref().map(|aloft| aloft[run].clone());
                let (is_aloft, others) = stride.unwrap_or_default();
                let start = if is_aloft {
                    Start::Flying(Flight {
                        lean: (unknowns[0], unknowns[1]),
                        pivot: (unknowns[2], unknowns[3]),
                        turn_rate: unknowns[4],
                    })
                } else {
                    Start::Rolling {
                        lean: unknowns[0],
                        rate: unknowns[1],
                    }
                };
                Rig::new(&robot).with(extra).beside(others).jump(
                    start,
                    setting.open,
                    setting.shut,
                    Some(end),
                )
            }
        }
    }

    /// When (s) the foot of a stride that begins in the air comes down.
    pub(super) fn lands(&self, run: usize, terms: &Terms, unknowns: &[f64]) -> Option<f64> {
        self.course(run, terms, unknowns)?.lands
    }

    fn outcomes(&self, run: usize, terms: &Terms) -> Vec<f64> {
        let (robot, _) = self.at_work(run, terms);
        let rig = Rig::new(&robot).with(self.extra(terms));
        let mut last: Option<(f64, (f64, f64))> = None;
        let mut out = Vec::with_capacity(self.data.logs[run].readings.len());
        for reading in &self.data.logs[run].readings {
            let outcome = match last {
                Some((time, outcome)) if time == reading.time => outcome,
                _ => {
                    let setting = &self.runs[run];
                    let [rate, lean, open] =
                        setting.asked[setting.rows.partition_point(|row| *row < reading.time)];
                    // One that does not jump lands where it stands.
                    rig.outcome(lean, rate, open)
                        .unwrap_or((robot.body.radius, 0.0))
                }
            };
            last = Some((reading.time, outcome));
            out.push(if self.columns[reading.channel] == Column::Apex {
                outcome.0
            } else {
                outcome.1
            });
        }
        out
    }
}

/// The true value of `column` in a pose; `gyro` is the sign with which the gyro feels the boom's turn.
fn sensed(column: Column, pose: &Pose, gyro: f64) -> f64 {
    let boom = pose.boom.unwrap_or_default();
    match column {
        Column::Position => pose.extension.0,
        Column::Pressure => pose.pressure.0,
        Column::Lean => pose.lean.0,
        Column::Pivot => boom.pivot.0,
        Column::Turn => boom.turn.0,
        Column::Travel => pose.travel.0,
        Column::Height => pose.height.0,
        // The wheel turns with the boom, which stands still where there is none.
        Column::Rate => pose.lean.1 + gyro * boom.turn.1 * boom.pivot.0.sin(),
        Column::Distance | Column::Apex => f64::NAN,
    }
}

/// The model of the kinds that are firings.
pub(super) fn model(data: &Experiment, robot: Option<&Robot>) -> Result<Box<dyn Kind>, Problem> {
    Ok(Box::new(Firings::new(
        data,
        robot.ok_or(Problem::NoRobot)?,
    )?))
}

/// Every tenth jump of a run of outcomes, from each of the first ten on: parts that can be left
/// out.
fn parts(run: &Run) -> Vec<Run> {
    let count = run.time.len().min(10);
    let every =
        |values: &[f64], first: usize| values.iter().copied().skip(first).step_by(count).collect();
    (0..count)
        .map(|first| {
            let values: Vec<Vec<f64>> = run.values.iter().map(|v| every(v, first)).collect();
            let rows: Vec<f64> = every(&run.time, first);
            Run {
                name: format!("{}, jumps {} and on", run.name, first + 1),
                time: (0..rows.len()).map(|row| row as f64).collect(),
                values,
                ..run.clone()
            }
        })
        .collect()
}

/// The run with times (s) that count from where its motion starts.
///
/// On the bench that is the command, before which the rod rests under its load. A hop stands still
/// from its first row on, of which the last moments before the command tell: a robot that is put
/// down sways on its boom. A jump starts at its first row, or at the command where that is earlier:
/// a leg that fills before the first row does so from a start that can be estimated.
fn from_start(mut run: Run, kind: Sort) -> Run {
    let first = run.time.first().copied().unwrap_or(0.0);
    let Some((open, shut)) = run.valve else {
        return run;
    };
    let start = match kind {
        Sort::Bench => open,
        Sort::Hop => first.clamp(open - STANDS, open),
        _ => first.min(open),
    };
    run.time.iter_mut().for_each(|time| *time -= start);
    run.valve = Some((open - start, shut.map(|shut| shut - start)));
    run
}

fn setting(run: &Run, asked: &[Option<usize>; 3]) -> Setting {
    let of = |key: &str| run.settings.get(key).copied();
    let (open, shut) = run.valve.unwrap_or((0.0, None));
    let rows = match asked {
        [Some(a), Some(b), Some(c)] => (0..run.time.len())
            .map(|row| [a, b, c].map(|k| run.values[*k][row]))
            .collect(),
        _ => Vec::new(),
    };
    Setting {
        load: of("load_mass_kg").unwrap_or(1.0),
        supply: of("supply_pressure_gauge_pa"),
        slope: of("slope_rad").unwrap_or(0.0),
        open,
        shut: shut.unwrap_or(1e6),
        asked: rows,
        rows: run.time.clone(),
    }
}

impl Kind for Firings {
    fn data(&self) -> &Data {
        &self.data
    }

    /// Lean and rate of a jump at its start, and on which side the gyro of a tilted boom feels its
    /// turn: by the geometry −1, by the description of the data 1.
    fn unknowns(&self, run: usize) -> Vec<Parameter> {
        if self.sort != Sort::Jump {
            return Vec::new();
        }
        let readings = &self.data.logs[run].readings;
        let first = |column: Column| -> Option<(f64, f64)> {
            let channel = self.columns.iter().position(|c| *c == column)?;
            let here: Vec<_> = self.data.logs[run].of(channel).take(30).collect();
            let mut values: Vec<f64> = here.iter().take(5).map(|r| r.value).collect();
            let (a, b) = (here.first()?, here.last()?);
            let slope = (b.value - a.value) / (b.time - a.time).max(1e-3);
            Some((median(&mut values), slope))
        };
        let rate = first(Column::Rate)
            .map(|f| f.0)
            .or_else(|| first(Column::Lean).map(|f| f.1))
            .unwrap_or(4.0);
        let late = readings.first().map_or(0.0, |r| r.time);
        let lean = first(Column::Lean).map_or(-0.2, |f| f.0 - rate * late);
        let mut all = vec![
            unknown("start_lean_rad", lean.clamp(-1.4, 1.4), (-1.5, 1.5), 1e-3),
            unknown(
                "start_rate_rad_s",
                rate.clamp(0.1, 50.0),
                (0.01, 60.0),
                0.02,
            ),
        ];
        if self.columns.contains(&Column::Rate) && self.robot.boom.is_some() {
            all.push(unknown("gyro_tilt", 1.0, (-1.0, 1.0), 0.2));
        }
        all
    }

    /// Joints, valves and contacts are never quite as they are modelled.
    fn discrepancy(&self) -> f64 {
        0.4
    }

    fn truths(&self, asked: &Asked<'_>) -> Option<Vec<f64>> {
        let (run, terms, unknowns) = asked.parts();
        if self.sort == Sort::Outcomes {
            return Some(self.outcomes(run, terms));
        }
        let course = self.course(run, terms, unknowns)?;
        let gyro = match self.aloft {
            Some(_) => -1.0,
            None => unknowns.get(GYRO).copied().unwrap_or(1.0),
        };
        let start = course.at(0.0, &mut 0);
        let from = if self.from_axle {
            start
        } else {
            Pose::default()
        };
        let mut places = vec![0; self.data.channels.len()];
        let truth = |(reading, time): (&Reading, &f64)| {
            let pose = course.at(*time, &mut places[reading.channel]);
            let column = self.columns[reading.channel];
            let zero = match column {
                Column::Turn => from.boom.unwrap_or_default().turn.0,
                Column::Travel => from.travel.0,
                _ => 0.0,
            };
            sensed(column, &pose, gyro) - zero
        };
        let readings = self.data.logs[run].readings.iter();
        Some(readings.zip(&asked.times).map(truth).collect())
    }

    fn phases(&self, run: usize, terms: &Terms, unknowns: &[f64]) -> Vec<(&'static str, f64)> {
        if self.sort == Sort::Outcomes {
            return Vec::new();
        }
        let Some(course) = self.course(run, terms, unknowns) else {
            return Vec::new();
        };
        let mut all = vec![
            ("pivot", f64::NEG_INFINITY),
            ("filling", self.runs[run].open),
        ];
        all.extend(course.breaks_away.map(|t| ("extension", t)));
        all.extend(course.leaves.map(|t| ("flight", t)));
        all
    }

    fn stronger(&self) -> String {
        match self.sort {
            Sort::Bench => {
                "firings at a higher supply pressure or under a lighter load, so that \
                the leg extends"
            }
            Sort::Hop => {
                "hops at a higher supply pressure or with the valve open longer, so that \
                the robot leaves the ground"
            }
            _ => {
                "jumps over a wider range of approach rates and firing angles, at several supply \
                pressures"
            }
        }
        .into()
    }

    fn proposals(&self) -> Vec<Proposal> {
        proposals::of(&self.robot)
    }

    fn robot(&self, terms: &Terms) -> Option<Robot> {
        let mut robot = self.robot.clone();
        self.switch_on(&mut robot, &mut 1.0, terms);
        Some(robot)
    }
}
