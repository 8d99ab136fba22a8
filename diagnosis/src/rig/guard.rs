//! What may end a mode.

/// A function that is above 0 while the mode lasts, and ends it as it comes to 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Guard {
    Lift,
    /// A foot in the air comes down.
    Land,
    /// A leg without mass has nothing left to push with: its foot leaves the ground.
    Slack,
    Slip,
    Grip,
    Extend,
    Retract,
    Halt,
    /// Dry friction lets the axle go, or holds it.
    Turn,
    Brake,
    Stroke,
    Stop,
    Above,
    Below,
    Cushion,
    Port,
}

impl Guard {
    /// Whether it may be below 0 at the start of a step, after a jump in a force.
    pub(super) fn is_of_forces(self) -> bool {
        matches!(
            self,
            Guard::Lift | Guard::Slack | Guard::Slip | Guard::Extend | Guard::Retract | Guard::Turn
        )
    }
}

/// Guards with their values.
pub(super) type Guards = Vec<(Guard, f64)>;

/// A force (N) that counts as none.
pub(super) const TINY: f64 = 1e-7;
