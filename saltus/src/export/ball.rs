//! What decides on a ball, as C: the code, and the robot's constants.

use std::fmt::Write as _;

use saltus_controller::ball::{Balance, Lead, Station};
use saltus_controller::c_source::{BALL as SOURCE, BALL_HEADER as HEADER};
use saltus_gait::GaitError;
use saltus_gait::space::{Flashed, FlashedPlane, Stable, Steered};
use saltus_robot::Robot;

use super::c::list;
use super::files::CFiles;
use super::numbers::Number;

impl CFiles {
    /// The code that keeps `robot` in its plane by `stable`, with numbers `R`.
    ///
    /// # Errors
    /// [`GaitError`] for a robot that is not in space, and numbers that cannot be.
    pub fn stable<R: Number>(robot: &Robot, stable: &Stable) -> Result<CFiles, GaitError> {
        let flashed = Flashed::new(robot, stable)?.rounded::<R>();
        Ok(ball(robot, &flashed))
    }

    /// The code that leads `robot` along a path as `steered`, with numbers `R`. The path itself is no part of it.
    ///
    /// # Errors
    /// As [`CFiles::stable`], and for a path that is none.
    pub fn steered<R: Number>(robot: &Robot, steered: &Steered) -> Result<CFiles, GaitError> {
        let flashed = Flashed::steered(robot, steered)?.rounded::<R>();
        Ok(ball(robot, &flashed))
    }
}

fn ball<R: Number>(robot: &Robot, flashed: &Flashed<R>) -> CFiles {
    let code = [("saltus_ball.h", HEADER), ("saltus_ball.c", SOURCE)];
    let tables = ("ball_tables.h", tables(flashed));
    CFiles::of::<R>(robot, "ball", code, (tables.0, &tables.1))
}

fn tables<R: Number>(ball: &Flashed<R>) -> String {
    let (legs, directions) = (ball.directions.len(), rows(&ball.directions));
    let (f, s) = (&ball.filter, &ball.scales);
    let bias = list(&f.bias);
    let times = list(&[f.by_foot, f.tilt, f.settles, f.returns]);
    let (period, gravity) = (f.period.c(), f.gravity.c());
    let counts = list(&[
        s.fine_gyro,
        s.coarse_gyro,
        s.fine_accelerometer,
        s.coarse_accelerometer,
    ]);
    let (limit, feet) = (s.limit, list(&[ball.reach, ball.radius]));
    let balance = balance(&ball.balance);
    let lead = ball.lead.as_ref().map(lead).unwrap_or_default();
    let (count, stations, planes) = planes(&ball.planes);
    format!(
        "\
#ifndef BALL_TABLES_H
#define BALL_TABLES_H

#include \"saltus_ball.h\"

/* Where each leg points, in the body's axes. */
static const saltus_real ball_directions[{legs}][3] = {{
{directions}}};

static const saltus_senses ball_senses = {{
    {{{period}, {gravity}, {{{bias}}}, {times}}}, /* filter */
    {{{counts}, {limit}}}, /* scales */
    {{ball_directions, {legs}, {feet}}}, /* feet */
}};

static const saltus_balance ball_balance = {{
{balance}}};
{lead}
/* What comes onto the ground in each plane, in its order: the legs, of twins first the left one, and the angle (rad). */
{stations}
#define BALL_PLANES {count}

/* The planes, each forwards and then backwards: across, along the first station's leg, ahead, in the body's axes. */
static const saltus_plane ball_planes[BALL_PLANES] = {{
{planes}}};

#endif
"
    )
}

fn rows<R: Number>(vectors: &[[R; 3]]) -> String {
    let row = |vector: &[R; 3]| format!("    {{{}}},\n", list(vector));
    vectors.iter().map(row).collect()
}

fn balance<R: Number>(b: &Balance<R>) -> String {
    let (pair, s) = (|pair: &[R; 2]| format!("{{{}}}", list(pair)), &b.steer);
    let steer = [
        s.roll,
        s.roll_rate,
        s.heading,
        s.heading_rate,
        s.aside,
        s.aside_rate,
        s.sum,
        s.most,
        s.from,
        s.rest,
    ];
    let lines = [
        (b.period.c(), "period"),
        (b.zone.c(), "zone"),
        (pair(&b.angles), "angles"),
        (pair(&b.opens), "opens"),
        (pair(&b.by_rate), "by_rate"),
        (b.rate.c(), "rate"),
        (pair(&b.first), "first"),
        (
            list(&[b.slow, b.stall, b.lead, b.least]),
            "slow, stall, lead, least",
        ),
        (format!("{{{}}}", list(&steer)), "steer"),
    ];
    let line = |(value, name): (String, &str)| format!("    {value}, /* {name} */\n");
    lines.map(line).concat()
}

fn lead<R: Number>(l: &Lead<R>) -> String {
    let lines = [
        (list(&[l.ahead, l.slew]), "ahead, slew"),
        (
            list(&[l.tips, l.astray, l.turn, l.near]),
            "tips, astray, turn, near",
        ),
        (
            list(&[l.still, l.rests, l.patience]),
            "still, rests, patience",
        ),
    ];
    let line = |(value, name): (String, &str)| format!("    {value}, /* {name} */\n");
    let lines = lines.map(line).concat();
    format!(
        "\n#define BALL_LEAD\nstatic const saltus_lead ball_lead = {{\n    &ball_balance,\n{lines}}};\n"
    )
}

/// How many planes, their stations, and the planes.
fn planes<R: Number>(planes: &[FlashedPlane<R>]) -> (usize, String, String) {
    let station =
        |Station {
             legs: [left, right],
             angle,
         }: &Station<R>| { format!("    {{{{{left}, {right}}}, {}}},\n", angle.c()) };
    let (mut stations, mut rows) = (String::new(), String::new());
    for (k, plane) in planes.iter().enumerate() {
        let count = plane.stations.len();
        let all: String = plane.stations.iter().map(station).collect();
        let axes = plane.axes.map(|axis| format!("{{{}}}", list(&axis)));
        let axes = axes.join(", ");
        // Writing to a string does not fail.
        let _ = writeln!(
            stations,
            "static const saltus_station ball_stations_{k}[{count}] = {{\n{all}}};"
        );
        let _ = writeln!(rows, "    {{{axes}, ball_stations_{k}, {count}}},");
    }
    (planes.len(), stations, rows)
}
