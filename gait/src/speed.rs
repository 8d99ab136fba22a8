//! A commanded speed: which firing angle runs how fast, and what holds it.

use std::f64::consts::TAU;

use saltus_controller::run::{Hold, Stall};
use saltus_numeric::parallel;
use saltus_robot::Robot;

use crate::error::ensure;
use crate::run::{Setup, run};
use crate::{GaitError, Program};

/// Firing angles (rad) whose speeds are measured, and the valve opening time (s) of all.
const ANGLES: [f64; 9] = [0.6, 0.55, 0.5, 0.45, 0.4, 0.3, 0.2, 0.1, 0.0];
const VALVE_OPEN: f64 = 0.05;
/// Firing angle (rad) and valve opening time (s) from rest, and by how much (rad) the angle falls for
/// each rad/s until it is the one that is measured.
const FROM_REST: [f64; 2] = [0.6, 0.065];
const FALLS: f64 = 0.05;
/// How long (s) a speed is measured; the last 4 s count.
const MEASURED: f64 = 9.0;
/// Below this speed (m/s) it does not run.
const RUNS: f64 = 0.5;

/// What holds a speed.
///
/// Found by trial on drawn robots: the study `hold_speed` measures what it comes to.
const TIME: f64 = 0.5;
const AHEAD: f64 = 0.5;
const BY_ERROR: f64 = 0.05;
const BY_SUM: f64 = 0.15;
const MOST_SUM: f64 = 2.0;

/// The speed (m/s) at which `robot` runs under each firing angle (rad), rising: speed, firing angle,
/// valve opening time (s).
///
/// # Errors
/// [`GaitError`] for a robot that cannot run, or that none of the angles keeps running.
pub fn speed_law(robot: &Robot, threads: usize) -> Result<Vec<[f64; 3]>, GaitError> {
    let one = |k: usize| {
        let angle = ANGLES[k];
        let at = ((FROM_REST[0] - angle) / FALLS).max(1e-3);
        let program = Program::Curve(vec![
            [0.0, FROM_REST[0], FROM_REST[1]],
            [at, angle, VALVE_OPEN],
        ]);
        let summary = run(&Setup::new(robot.clone(), program, MEASURED), &mut ())?;
        Ok([summary.late_speed(), angle, VALVE_OPEN])
    };
    let measured: Vec<[f64; 3]> = parallel::map_on(threads, ANGLES.len(), one)
        .into_iter()
        .collect::<Result<_, GaitError>>()?;
    let mut law: Vec<[f64; 3]> = Vec::new();
    for knot in measured.into_iter().filter(|knot| knot[0] > RUNS) {
        if law.last().is_none_or(|last| knot[0] > last[0]) {
            law.push(knot);
        }
    }
    let slowest = law.first().map_or(f64::NAN, |knot| knot[0]);
    let allowed = "a robot that runs under a fixed firing angle from 0 to 0.6 rad";
    ensure! { "speeds measured (m/s)", slowest, law.len() >= 2 => allowed; }
    // From rest to the slowest: the angle at which a robot at rest still fires.
    law.insert(0, [0.7 * slowest, 0.55, VALVE_OPEN]);
    Ok(law)
}

impl Setup {
    /// `robot` at commanded `speeds`: from each time (s) on, a speed (m/s), negative backwards. The
    /// firing angles are those of [`speed_law`], measured on this robot.
    ///
    /// # Errors
    /// As [`speed_law`]; [`GaitError::Input`] for a robot without a boom, whose encoder measures the
    /// way.
    pub fn at_speeds(
        robot: &Robot,
        speeds: &[[f64; 2]],
        seconds: f64,
        threads: usize,
    ) -> Result<Setup, GaitError> {
        Setup::holding(robot, speed_law(robot, threads)?, speeds, seconds)
    }

    /// The same with a law at hand: speed (m/s), firing angle (rad), valve opening time (s).
    ///
    /// # Errors
    /// [`GaitError::Input`] for a robot without a boom.
    pub fn holding(
        robot: &Robot,
        law: Vec<[f64; 3]>,
        speeds: &[[f64; 2]],
        seconds: f64,
    ) -> Result<Setup, GaitError> {
        let length = robot.boom.map_or(0.0, |boom| boom.length);
        ensure! {
            "length of the boom (m)", length, length > 0.0
                => "that of a boom, whose turn measures the way";
        }
        let program = Program::Curve(law);
        let sensors = robot.sensors.unwrap_or_default();
        Ok(Setup {
            speeds: speeds.to_vec(),
            first: vec![FROM_REST, [FROM_REST[0], 0.06]],
            hold: Some(Hold {
                way: length * TAU / sensors.radius_counts.round(),
                renewed: sensors.period / TIME,
                ahead: AHEAD,
                by_error: BY_ERROR,
                by_sum: BY_SUM,
                most_sum: MOST_SUM,
            }),
            stall: Stall {
                rate: 0.5,
                time: 0.5,
                restarts: true,
            },
            ..Setup::new(robot.clone(), program, seconds)
        })
    }
}
