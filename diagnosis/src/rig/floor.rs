//! The ground under the foot.

use saltus_robot::Ground;

/// The ground under the foot.
#[derive(Clone, Copy, Debug)]
pub(super) struct Floor {
    pub(super) slope: f64,
    /// Stiffness (N/m) and damping (N s/m) where it is soft.
    pub(super) soft: Option<(f64, f64)>,
    /// Coefficients of friction along the travel, standing and slipping.
    pub(super) friction: (f64, f64),
    /// Coefficient of friction across the travel.
    pub(super) across: f64,
}

impl Floor {
    pub(super) fn new(ground: &Ground) -> Floor {
        Floor {
            slope: ground.slope,
            soft: ground.stiffness.map(|k| (k, ground.damping)),
            friction: (ground.static_friction, ground.kinetic_friction),
            across: ground.across_friction,
        }
    }

    /// Whether the foot stays on the ground as its leg reaches the end of the stroke. Soft ground
    /// pushes on until its spring is slack. If the foot could not slip meanwhile, it would turn the
    /// robot about itself; then it leaves at once.
    pub(super) fn pushes_on(&self) -> bool {
        self.soft.is_some() && self.friction.0.is_finite()
    }
}
