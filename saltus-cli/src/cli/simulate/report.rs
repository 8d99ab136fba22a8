//! Jumps as rows and as JSON.

use saltus::{LiftOff, Robot};
use serde_json::{Map, Value, json};

use super::compute::{Answer, Bearing};
use crate::cli::common::opening;
use crate::output::{self, Column, Table, columns};

/// One row for each jump, with the columns of the reference file.
pub(super) fn table(answers: &[Answer], robot: &Robot) -> Table {
    Table::of(&columns(), answers.iter().map(|answer| (answer, robot)))
}

/// A jump, and the robot that makes it.
type Row<'a> = (&'a Answer, &'a Robot);

fn columns<'a>() -> [Column<Row<'a>>; 19] {
    columns! {
        "omega0_rad_s", "ω₀", |(it, _)| it.jump.launch.rate;
        "phi0_rad", "φ₀", |(it, _)| it.jump.launch.lean;
        "alpha_f_rad", "α_f", |(it, _)| it.jump.launch.firing_angle;
        "valve_open_s", "valve open", |(it, robot)| opening(robot, &it.jump.launch);
        "outcome", "outcome", |(it, _)| it.jump.stance.outcome.name();
        "t_fire_s", "", |(it, _)| it.jump.stance.time_fire;
        "t_liftoff_s", "lift-off", |row| in_flight(row, |end| end.time);
        "phi_rad", "", |row| in_flight(row, |end| end.lean);
        "omega_rad_s", "", |row| in_flight(row, |end| end.rate);
        "d_m", "", |row| in_flight(row, |end| end.extension);
        "d_dot_m_s", "", |row| in_flight(row, |end| end.extension_rate);
        "pressure_pa", "", |row| in_flight(row, |end| end.pressure);
        "x_m", "", |row| in_flight(row, |end| end.axle[0]);
        "y_m", "", |row| in_flight(row, |end| end.axle[1]);
        "vx_m_s", "", |(it, _)| it.jump.exact_flight().map(|flight| flight.vacuum.vx);
        "vy_m_s", "", |(it, _)| it.jump.exact_flight().map(|flight| flight.vacuum.vy);
        "apex_m", "apex", |(it, _)| it.jump.apex();
        "land_rs_m", "landing at r_s", |(it, robot)| it.jump.distance(robot.body.radius);
        "land_0_m", "landing at 0", |(it, _)| it.jump.distance(0.0);
    }
}

/// A number of the lift-off, if the robot takes off.
fn in_flight((answer, _): &Row<'_>, of: fn(&LiftOff) -> f64) -> Option<f64> {
    let flight = answer.jump.exact_flight();
    flight.map(|_| of(&answer.jump.stance))
}

/// The document.
pub(super) fn json(answers: &[Answer], robot: &Robot) -> String {
    let mut jumps = table(answers, robot).json();
    jumps
        .iter_mut()
        .zip(answers)
        .for_each(|(jump, answer)| add_stance(jump, answer));
    output::json(&json!({ "command": "simulate", "robot": robot.name, "jumps": jumps }))
}

/// Adds what the ground bears and where the energy goes.
fn add_stance(jump: &mut Map<String, Value>, answer: &Answer) {
    let Some(Bearing { contact, energy }) = &answer.bearing else {
        return;
    };
    let contact = json!({
        "least_normal_n": contact.least_normal,
        "least_normal_time_s": contact.least_normal_time,
        "friction_needed": contact.friction_needed,
        "friction_needed_time_s": contact.friction_needed_time,
    });
    let energy = json!({
        "drive_j": energy.drive,
        "losses_j": energy.losses,
        "kinetic_j": energy.kinetic,
        "potential_j": energy.potential,
    });
    jump.extend([
        ("contact".to_owned(), contact),
        ("energy".to_owned(), energy),
    ]);
}
