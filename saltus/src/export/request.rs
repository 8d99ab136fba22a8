//! What tables are asked for, and why there are none.

use saltus_lagrangian::StanceError;
use saltus_planner::TableError;

/// What tables are to hold.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// Least and greatest approach rate ω (rad/s), and how many nodes, ≥ 2; they count where
    /// `start_lean` says.
    pub rates: (f64, f64, usize),
    /// Least and greatest distance (m), and how many nodes; one distance with one node gives a
    /// curve over the approach rate.
    pub distances: (f64, f64, usize),
    /// Firing angles α_f (rad) of the lift-off map; none: those that the table holds, and a tenth
    /// of a radian more.
    pub firing_angles: Option<(f64, f64)>,
    /// Nodes of the lift-off map over them, ≥ 2.
    pub angles: usize,
    /// Height (m) of the wheel's centre above the foothold at the landing; none: the wheel's
    /// radius, where it touches.
    pub landing_height: Option<f64>,
    /// Valve opening time t_v (s).
    pub valve_open: f64,
    /// Valve opening times (s) to choose from over an obstacle; none: that one.
    pub valve_range: Option<(f64, f64)>,
    /// Lean (rad) at which a stance starts and approach rates count; none: the firing angle.
    pub start_lean: Option<f64>,
    /// Control period (s).
    pub period: f64,
    /// By how much the valve answers later than the robot file's delay (s).
    pub extra_delay: f64,
    /// Newton steps that refine a firing angle, 0 to 3.
    pub newton_steps: u8,
    /// Cost of a squared second of open valve (m²/s²), > 0.
    pub effort: f64,
    /// Greatest error of a landing (m): a cell that misses by more is closed.
    pub tolerance: f64,
    /// Threads to work with, ≥ 1.
    pub threads: usize,
}

impl Default for Request {
    fn default() -> Request {
        Request {
            rates: (3.0, 6.0, 13),
            distances: (0.3, 0.8, 11),
            firing_angles: None,
            angles: 11,
            landing_height: None,
            valve_open: 0.1,
            valve_range: None,
            start_lean: None,
            period: 1e-3,
            extra_delay: 0.0,
            newton_steps: 0,
            effort: 0.01,
            tolerance: 0.002,
            threads: 1,
        }
    }
}

/// Tables that cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// A number is outside its domain.
    #[error("{name} = {value}: must be {allowed}")]
    Input {
        /// What was given, with its unit.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// The robot flies through air that slows it.
    #[error("environment.drag_per_m = {drag}: must be 0: a controller's flight is a parabola")]
    Drag {
        /// Its drag (1/m).
        drag: f64,
    },
    /// No cell of the table can be reached, or none is as exact as asked.
    #[error("no cell of the {what} is open: nothing there is reached within {tolerance} m{}", remedy(*least))]
    Empty {
        /// Which table.
        what: &'static str,
        /// The error that is allowed (m).
        tolerance: f64,
        /// The least error (m) with which a cell would be open; none where none is reached at all.
        least: Option<f64>,
    },
    /// What the planner does not take.
    #[error(transparent)]
    Planner(#[from] TableError),
    /// A stance cannot be computed.
    #[error(transparent)]
    Stance(#[from] StanceError),
}

fn remedy(least: Option<f64>) -> String {
    least.map_or(String::new(), |least| {
        format!(
            "; the best cell misses by {least:.1e} m: allow more than that, or ask for more rates \
             or a Newton step",
        )
    })
}

/// So many nodes from the first to the last.
pub(super) fn spread((first, last, count): (f64, f64, usize)) -> Vec<f64> {
    let last_index = count.saturating_sub(1).max(1) as f64;
    (0..count)
        .map(|i| first + (last - first) * i as f64 / last_index)
        .collect()
}
