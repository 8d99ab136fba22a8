//! What decides on a running robot, as C: the code, and the robot's constants.

use saltus_controller::c_source::{RUNNING as SOURCE, RUNNING_HEADER as HEADER};
use saltus_controller::run::{Gait, Hold, Law, Leap};
use saltus_gait::{GaitError, Setup};

use super::files::CFiles;
use super::numbers::Number;

impl CFiles {
    /// The code that decides in `setup`, with numbers `R`.
    ///
    /// # Errors
    /// [`GaitError`] for a run that cannot be.
    pub fn running<R: Number>(setup: &Setup) -> Result<CFiles, GaitError> {
        let gravity = setup.robot.environment.gravity;
        let tables = setup.flashed(|gait| tables::<R>(gait, gravity))?;
        let code = [("saltus_running.h", HEADER), ("saltus_running.c", SOURCE)];
        let tables = ("running_tables.h", tables);
        Ok(CFiles::of::<R>(
            &setup.robot,
            "running robot",
            code,
            (tables.0, &tables.1),
        ))
    }
}

fn tables<R: Number>(gait: &Gait<'_, f64>, gravity: f64) -> String {
    let c = |x: f64| R::of(x).c();
    let list = list::<R>;
    let (taps, tap_count) = (list(gait.taps), gait.taps.len());
    let (data, law) = law::<R>(&gait.law);
    let i = &gait.instruments;
    let (wheel, turn) = (c(i.wheel), i.wheel_turn);
    let (boom, fine) = (list(&[i.radius, i.pivot]), c(i.fine_gyro));
    let (coarse, acceleration) = (c(i.coarse_gyro), c(i.fine_accelerometer));
    let (fine_limit, limit) = (i.fine_limit, i.accelerometer_limit);
    let (holds, hold) = hold::<R>(gait.hold);
    let (leaps, leap) = leap::<R>(gait.leap);
    let (first_data, first) = first::<R>(gait.first);
    let stall = list(&[gait.stall.rate, gait.stall.time]);
    let restarts = u8::from(gait.stall.restarts);
    let (zone, legs, period, gravity) = (c(gait.zone), gait.legs, c(gait.period), c(gravity));
    format!(
        "\
#ifndef RUNNING_TABLES_H
#define RUNNING_TABLES_H

#include \"saltus_running.h\"

/* m/s^2 */
static const saltus_real running_gravity = {gravity};
/* Weights of the rate's filter, the newest reading's first. */
static const saltus_real running_taps[{tap_count}] = {{{taps}}};
{data}{first_data}
static const saltus_gait running_gait = {{
    {law},
    {zone}, /* zone */
    {legs}, /* legs */
    {period}, /* period */
    {{{wheel}, {turn}, {boom}, {fine}, {fine_limit}, {coarse}, {acceleration}, {limit}}}, /* instruments */
    running_taps, {tap_count},
    {holds}, {{{hold}}}, /* hold */
    {{{stall}, {restarts}}}, /* stall */
    {first}, /* first firings */
    {leaps}, {{{leap}}}, /* leap */
    0, /* nothing ahead */
}};

#endif
"
    )
}

/// Numbers as constants of C.
fn list<R: Number>(numbers: &[f64]) -> String {
    let numbers: Vec<R> = numbers.iter().map(|x| R::of(*x)).collect();
    super::c::list(&numbers)
}

/// Whether a speed is held, and how.
fn hold<R: Number>(hold: Option<Hold<f64>>) -> (u8, String) {
    let numbers = hold.map_or([0.0; 6], |h| {
        [h.way, h.renewed, h.ahead, h.by_error, h.by_sum, h.most_sum]
    });
    (u8::from(hold.is_some()), list::<R>(&numbers))
}

/// Whether it leaps, and how.
fn leap<R: Number>(leap: Option<Leap<f64>>) -> (u8, String) {
    let numbers = leap.map_or([0.0; 5], |l| {
        [l.slope, l.level, l.least, l.most, l.valve_open]
    });
    let numbers = list::<R>(&numbers);
    let (after, shock) = leap.map_or((0, 0), |l| (l.after, l.shock));
    (
        u8::from(leap.is_some()),
        format!("{after}, {numbers}, {shock}"),
    )
}

/// The data of the first firings, and what refers to them.
fn first<R: Number>(first: &[[f64; 2]]) -> (String, String) {
    let count = first.len();
    if count == 0 {
        return (String::new(), "0, 0".to_owned());
    }
    let row = |firing: &[f64; 2]| format!("    {{{}}},\n", list::<R>(firing));
    let rows = first.iter().map(row).collect::<String>();
    let data = format!(
        "/* Firing angle (rad), valve opening time (s) of the first firings. */\n\
         static const saltus_real running_first[{count}][2] = {{\n{rows}}};\n"
    );
    (data, format!("running_first, {count}"))
}

/// The data that a law refers to, and the law.
fn law<R: Number>(law: &Law<'_, f64>) -> (String, String) {
    match law {
        Law::OverTime {
            amplitude,
            slope,
            shift,
            level,
            valve_open,
        } => {
            let numbers = list::<R>(&[*amplitude, *slope, *shift, *level, *valve_open]);
            let law = format!("{{SALTUS_OVER_TIME, {numbers}, 0, 0}}");
            (String::new(), law)
        }
        Law::Lines(knots) => {
            let row = |k: &saltus_controller::run::Knot<f64>| {
                let knot = list::<R>(&[k.rate, k.firing_angle, k.valve_open]);
                format!("    {{{knot}}},\n")
            };
            let (count, rows) = (knots.len(), knots.iter().map(row).collect::<String>());
            let before = vec![R::ZERO.c(); 5].join(", ");
            (
                format!(
                    "/* Rate (rad/s), firing angle (rad), valve opening time (s). */\n\
                     static const saltus_knot running_knots[{count}] = {{\n{rows}}};\n"
                ),
                format!("{{SALTUS_LINES, {before}, running_knots, {count}}}"),
            )
        }
    }
}
