//! What decides on a running robot, as C: the code, and the robot's constants.

use saltus_controller::c_source::{RUNNING as SOURCE, RUNNING_HEADER as HEADER};
use saltus_controller::run::{Gait, Hold, Law, Leap};
use saltus_gait::{GaitError, Setup};

use super::c::{comment, fill, number_words};
use super::fingerprint;
use super::numbers::Number;

/// What is written for a running robot.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Running {
    /// What heads every file.
    pub about: Vec<String>,
    /// `saltus_running.h` and `saltus_running.c`, in C99 with no other dependency than `math.h`'s
    /// square root, and `running_tables.h` with the robot's constants: names and texts.
    pub files: [(&'static str, String); 3],
}

impl Running {
    /// The code that decides in `setup`, with numbers `R`.
    ///
    /// # Errors
    /// [`GaitError`] for a run that cannot be.
    pub fn new<R: Number>(setup: &Setup) -> Result<Running, GaitError> {
        let gravity = setup.robot.environment.gravity;
        let tables = setup.flashed(|gait| tables::<R>(gait, gravity))?;
        let about = about::<R>(setup);
        let head = comment(&about);
        let filled = |text| {
            let head = ("HEADER", head.clone());
            fill(text, number_words::<R>().into_iter().chain([head]))
        };
        let files = [
            ("saltus_running.h", filled(HEADER)),
            ("saltus_running.c", filled(SOURCE)),
            ("running_tables.h", format!("{head}\n{tables}")),
        ];
        Ok(Running { about, files })
    }
}

fn about<R: Number>(setup: &Setup) -> Vec<String> {
    let (name, hash) = (&setup.robot.name, fingerprint(&setup.robot));
    vec![
        format!(
            "What decides on the running robot {}, whose file's SHA-256 begins {hash}.",
            name.escape_default()
        ),
        format!(
            "Written by saltus {}; to change it, write it anew. Numbers: {}.",
            env!("CARGO_PKG_VERSION"),
            R::C_TYPE
        ),
    ]
}

fn tables<R: Number>(gait: &Gait<'_, f64>, gravity: f64) -> String {
    let c = |x: f64| R::of(x).c();
    let list = |all: &[f64]| all.iter().map(|x| c(*x)).collect::<Vec<_>>().join(", ");
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

/// Whether a speed is held, and how.
fn hold<R: Number>(hold: Option<Hold<f64>>) -> (u8, String) {
    let numbers = hold.map_or([0.0; 6], |h| {
        [h.way, h.renewed, h.ahead, h.by_error, h.by_sum, h.most_sum]
    });
    let numbers = numbers.map(|x| R::of(x).c()).join(", ");
    (u8::from(hold.is_some()), numbers)
}

/// Whether it leaps, and how.
fn leap<R: Number>(leap: Option<Leap<f64>>) -> (u8, String) {
    let numbers = leap.map_or([0.0; 5], |l| {
        [l.slope, l.level, l.least, l.most, l.valve_open]
    });
    let numbers = numbers.map(|x| R::of(x).c()).join(", ");
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
    let row = |firing: &[f64; 2]| format!("    {{{}}},\n", firing.map(|x| R::of(x).c()).join(", "));
    let rows = first.iter().map(row).collect::<String>();
    let data = format!(
        "/* Firing angle (rad), valve opening time (s) of the first firings. */\n\
         static const saltus_real running_first[{count}][2] = {{\n{rows}}};\n"
    );
    (data, format!("running_first, {count}"))
}

/// The data that a law refers to, and the law.
fn law<R: Number>(law: &Law<'_, f64>) -> (String, String) {
    let c = |x: f64| R::of(x).c();
    match law {
        Law::OverTime {
            amplitude,
            slope,
            shift,
            level,
            valve_open,
        } => {
            let numbers = [*amplitude, *slope, *shift, *level, *valve_open].map(c);
            let numbers = numbers.join(", ");
            let law = format!("{{SALTUS_OVER_TIME, {numbers}, 0, 0}}");
            (String::new(), law)
        }
        Law::Lines(knots) => {
            let row = |k: &saltus_controller::run::Knot<f64>| {
                let knot = [k.rate, k.firing_angle, k.valve_open].map(c);
                format!("    {{{}}},\n", knot.join(", "))
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
