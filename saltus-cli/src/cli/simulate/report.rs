//! Jumps as rows and as JSON.

use saltus::Robot;
use serde_json::{Map, Value, json};

use super::compute::{Answer, Bearing};
use crate::output::{self, Cell, Table};

/// The columns of the reference file.
const COLUMNS: &[&str] = &[
    "omega0_rad_s",
    "phi0_rad",
    "alpha_f_rad",
    "valve_open_s",
    "outcome",
    "t_fire_s",
    "t_liftoff_s",
    "phi_rad",
    "omega_rad_s",
    "d_m",
    "d_dot_m_s",
    "pressure_pa",
    "x_m",
    "y_m",
    "vx_m_s",
    "vy_m_s",
    "apex_m",
    "land_rs_m",
    "land_0_m",
];

/// One row for each jump.
pub(super) fn table(answers: &[Answer], robot: &Robot) -> Table {
    let mut table = Table::new(COLUMNS);
    for answer in answers {
        table.push(row(answer, robot));
    }
    table
}

fn row(answer: &Answer, robot: &Robot) -> Vec<Cell> {
    let (launch, end, flight) = (
        &answer.jump.launch,
        &answer.jump.stance,
        answer.jump.exact_flight(),
    );
    let [x, y] = end.axle;
    let [vx, vy] = flight.map_or(end.axle_rates, |flight| {
        [flight.vacuum.vx, flight.vacuum.vy]
    });
    let mut row: Vec<Cell> = [launch.rate, launch.lean, launch.firing_angle]
        .map(Cell::from)
        .into();
    row.push(
        robot
            .leg
            .drive
            .has_valve()
            .then_some(launch.valve_open)
            .into(),
    );
    row.extend([Cell::Word(end.outcome.name()), Cell::from(end.time_fire)]);
    let motion = [
        end.time,
        end.lean,
        end.rate,
        end.extension,
        end.extension_rate,
        end.pressure,
        x,
        y,
        vx,
        vy,
    ];
    row.extend(motion.map(|number| Cell::from(flight.map(|_| number))));
    row.push(Cell::from(answer.jump.apex()));
    row.extend([robot.body.radius, 0.0].map(|height| Cell::from(answer.jump.distance(height))));
    row
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
