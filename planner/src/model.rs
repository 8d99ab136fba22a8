//! The seam between a planner and what makes a robot jump.

use saltus_lagrangian::{Launch, LiftOff, Outcome, StanceError};
use saltus_numeric::{Dual, Single};
use saltus_robot::{Leg, Robot};

use crate::course::Slope;
use crate::flight::JumpFlight;
use crate::jump::Jump;

/// Anything that turns a launch into a lift-off, and a lift-off into a flight: the planar model, or
/// a multi-body simulation. A [`Planner`](crate::Planner) of it has tables, laws, maps and plans.
///
/// A robot that chooses its lift-off freely has no launch to choose; it is a
/// [`Jumper`](crate::course::Jumper) at once.
pub trait JumpModel: Sync {
    /// The robot that jumps.
    fn robot(&self) -> &Robot;

    /// c = m g r_s/(I + m r_s²) (1/s²): on a retracted leg a lean φ accelerates by c sin φ.
    ///
    /// Source: docs/model.md, Stance.
    fn pendulum(&self) -> f64 {
        self.robot().pendulum()
    }

    /// Error (m) of a jump's apex and distance; two launches that are near each other differ by
    /// less.
    fn accuracy(&self) -> f64;

    /// One jump.
    ///
    /// # Errors
    /// [`StanceError`] for a launch outside its domain, or a stance that cannot be computed.
    fn jump(&self, launch: &Launch) -> Result<Jump, StanceError>;

    /// Many jumps, each as [`jump`](JumpModel::jump).
    fn jumps(&self, launches: &[Launch]) -> Vec<Result<Jump, StanceError>> {
        launches.iter().map(|launch| self.jump(launch)).collect()
    }

    /// One jump with its derivatives by ω, α_f, t_v and P_s, in this order; a stance that starts at
    /// its firing angle keeps doing so when that angle changes.
    ///
    /// # Errors
    /// As [`jump`](JumpModel::jump).
    fn sensitive_jump(&self, launch: &Launch) -> Result<Jump<Dual<4>>, StanceError>;

    /// How much longer (s) than the stance the valve of a jump is open; negative where it shuts
    /// before the lift-off. Of a leg without a valve it says nothing.
    fn spare(&self, jump: &Jump) -> f64 {
        spare_of(&self.robot().leg, jump.launch.valve_open, &jump.stance)
    }

    /// One jump with the whole of its stance.
    ///
    /// # Errors
    /// As [`jump`](JumpModel::jump).
    fn traced(&self, launch: &Launch) -> Result<Traced, StanceError>;

    /// One jump as the search for a plan sees it, and what friction its stance needs if
    /// `with_friction`; none where the robot does not fly.
    ///
    /// It may be ten times coarser than [`accuracy`](JumpModel::accuracy).
    fn steered(&self, launch: &Launch<Dual<2>>, with_friction: bool) -> Option<Steered>;

    /// The way of the wheel's centre in the stance of [`steered`](JumpModel::steered), from the
    /// start to the lift-off; none without a stance.
    fn steered_way(&self, launch: &Launch<Dual<2>>) -> Option<Vec<Instant<Slope>>>;
}

/// A jump with the whole of its stance.
#[derive(Debug)]
pub struct Traced {
    /// The jump.
    pub jump: Jump,
    /// The way of the wheel's centre, from the start to the lift-off.
    pub way: Vec<Instant<f64>>,
    /// Friction coefficient that the stance needs.
    pub friction_needed: f64,
}

/// A jump with its derivatives by the firing angle (direction 1) and the valve opening time (2);
/// direction 0 is kept for the foothold.
#[derive(Debug)]
pub struct Steered {
    /// The wheel's centre at the lift-off (m from the foot).
    pub axle: [Slope; 2],
    /// Extension of the leg at the lift-off (m).
    pub extension: Slope,
    /// The flight.
    pub flight: JumpFlight<Slope>,
    /// Friction coefficient that the stance needs, where it was asked for.
    pub friction_needed: Option<Slope>,
    /// As [`JumpModel::spare`].
    pub spare: Slope,
}

/// The wheel's centre at an instant of a stance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instant<S> {
    /// Time (s) from the start.
    pub time: S,
    /// Place (m from the foot): forwards and upwards.
    pub centre: [S; 2],
    /// Velocity (m/s).
    pub velocity: [S; 2],
}

/// How much longer (s) than the stance that ended so the valve of `leg` is open; of a leg that has
/// no force once its valve is shut, and so lifts off there, as of one whose valve shuts long before.
pub fn spare_of<S: Single>(leg: &Leg, valve_open: S, end: &LiftOff<S>) -> S {
    let spare = end.time_fire + valve_open + S::of(leg.shutting_delay()) - end.time;
    if end.outcome == Outcome::Force && spare.value().abs() < 1e-9 {
        S::of(-EARLY)
    } else {
        spare
    }
}

/// Longer (s) than stances are.
const EARLY: f64 = 100.0;

/// A number with its slopes by firing angle and valve opening time, as one that could also depend
/// on the foothold.
pub fn widen(x: Dual<2>) -> Slope {
    let [by_angle, by_opening] = x.slope;
    Slope {
        value: x.value,
        slope: [0.0, by_angle, by_opening],
    }
}
