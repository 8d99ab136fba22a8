//! The reference solutions in `reference/`, and what a computed jump says in their columns.

use saltus_ballistic::Flight;
use saltus_lagrangian::{Launch, LiftOff};
use saltus_robot::Robot;

/// A row of `jumps.csv`.
#[derive(Clone, Debug)]
pub struct Row {
    /// The launch.
    pub launch: Launch,
    /// Name of the outcome.
    pub outcome: String,
    /// [`JUMP_COLUMNS`] in their order.
    pub values: [f64; 14],
}

/// The columns of `jumps.csv` that hold answers.
pub const JUMP_COLUMNS: [&str; 14] = [
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

/// A row of `hop.csv`: valve opening time (s), outcome, apex (m), pivot angle (rad).
pub type Hop = (f64, String, f64, f64);

/// A row of `table.csv`.
#[derive(Clone, Copy, Debug)]
pub struct Firing {
    /// Approach rate (rad/s).
    pub rate: f64,
    /// Distance asked for (m), to y = 0.
    pub distance: f64,
    /// Smallest firing angle (rad) that reaches it.
    pub firing_angle: f64,
}

/// `jumps.csv`.
///
/// # Panics
/// If the file is not what its README says.
pub fn jumps() -> Vec<Row> {
    let (header, rows) = table(include_str!("../reference/jumps.csv"));
    assert_eq!(header[5..], JUMP_COLUMNS);
    rows.iter()
        .map(|cells| Row {
            launch: Launch {
                rate: number(&cells[0]),
                lean: number(&cells[1]),
                firing_angle: number(&cells[2]),
                valve_open: number(&cells[3]),
            },
            outcome: cells[4].clone(),
            values: std::array::from_fn(|i| number(&cells[5 + i])),
        })
        .collect()
}

/// `hop.csv`.
pub fn hops() -> Vec<Hop> {
    let (_, rows) = table(include_str!("../reference/hop.csv"));
    rows.iter()
        .map(|c| (number(&c[0]), c[1].clone(), number(&c[2]), number(&c[3])))
        .collect()
}

/// `table.csv`.
pub fn firings() -> Vec<Firing> {
    let (_, rows) = table(include_str!("../reference/table.csv"));
    rows.iter()
        .map(|c| Firing {
            rate: number(&c[0]),
            distance: number(&c[1]),
            firing_angle: number(&c[2]),
        })
        .collect()
}

/// A computed jump of `robot` in [`JUMP_COLUMNS`].
///
/// # Panics
/// If the wheel does not come down to y = r_s: no row of the reference is such a jump.
pub fn columns(robot: &Robot, end: &LiftOff) -> [f64; 14] {
    let ([x, y], [vx, vy]) = (end.axle, end.axle_rates);
    let flight = Flight {
        x,
        y,
        vx,
        vy,
        gravity: robot.axle_gravity(),
    };
    let landing = |height: f64| {
        flight
            .range_to_height(height)
            .expect("the wheel comes down")
    };
    [
        end.time_fire,
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
        flight.apex_height(),
        landing(robot.body.radius),
        landing(0.0),
    ]
}

fn number(text: &str) -> f64 {
    text.parse().expect("a number")
}

fn table(text: &str) -> (Vec<String>, Vec<Vec<String>>) {
    let mut lines = text
        .lines()
        .map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
    (lines.next().unwrap_or_default(), lines.collect())
}
