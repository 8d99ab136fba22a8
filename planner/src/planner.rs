//! A robot, ready to plan its jumps.

use std::ops::Deref;

use saltus_lagrangian::{Drawn, Launch, Stance, StanceError, TankState};
use saltus_numeric::Dual;
use saltus_robot::Robot;

use crate::jump::Jump;
use crate::model::JumpModel;
use crate::planar::Planar;

/// A robot, ready to plan its jumps: by the planar model, or by another [`JumpModel`].
///
/// What it answers is written once for all models, and is compiled here: `Planner<dyn JumpModel>`,
/// which every planner is by reference.
#[derive(Clone, Debug)]
pub struct Planner<M: ?Sized = Planar> {
    model: M,
}

impl Planner {
    /// A planner for `robot` by the planar model.
    pub fn new(robot: Robot) -> Planner {
        Planner::by(Planar::new(robot))
    }

    /// The robot's stance.
    pub fn stance(&self) -> &Stance<f64> {
        self.model.stance()
    }

    /// One jump with the tank as it is, and what it takes from it; none for a robot that does not carry
    /// its gas.
    ///
    /// # Errors
    /// As [`Stance::jump_from`].
    pub fn jump_from(
        &self,
        launch: &Launch,
        tank: &TankState,
    ) -> Result<Option<(Jump, Drawn)>, StanceError> {
        self.model.jump_from(launch, tank)
    }
}

impl<M: JumpModel> Planner<M> {
    /// A planner by `model`.
    pub fn by(model: M) -> Planner<M> {
        Planner { model }
    }

    /// The same, to change.
    pub(crate) fn model_mut(&mut self) -> &mut M {
        &mut self.model
    }
}

impl<M: ?Sized> Planner<M> {
    /// What makes the robot jump.
    pub fn model(&self) -> &M {
        &self.model
    }
}

impl<M: JumpModel + 'static> Deref for Planner<M> {
    type Target = Planner<dyn JumpModel>;

    fn deref(&self) -> &Self::Target {
        self
    }
}

impl Planner<dyn JumpModel> {
    /// The robot.
    pub fn robot(&self) -> &Robot {
        self.model.robot()
    }

    /// c = m g r_s/(I + m r_s²) (1/s²): on a retracted leg a lean φ accelerates by c sin φ.
    ///
    /// Source: docs/model.md, Stance.
    pub fn pendulum(&self) -> f64 {
        self.model.pendulum()
    }

    /// The rate (rad/s) at the lean `to` (rad) of a robot that pivots on its retracted leg with
    /// `rate` at the lean `from`; 0 where it does not get there.
    ///
    /// √(ω² + 2 c (cos from − cos to)).
    pub fn pivoted(&self, rate: f64, from: f64, to: f64) -> f64 {
        (rate * rate + 2.0 * self.pendulum() * (from.cos() - to.cos()))
            .max(0.0)
            .sqrt()
    }

    /// One jump.
    ///
    /// # Errors
    /// As [`JumpModel::jump`].
    pub fn jump(&self, launch: &Launch) -> Result<Jump, StanceError> {
        self.model.jump(launch)
    }

    /// Many jumps, several side by side where the model can.
    ///
    /// # Errors
    /// Each as [`JumpModel::jump`].
    pub fn jumps(&self, launches: &[Launch]) -> Vec<Result<Jump, StanceError>> {
        self.model.jumps(launches)
    }

    /// One jump with its derivatives by ω, α_f, t_v and P_s; a stance that starts at its firing
    /// angle keeps doing so when that angle changes.
    ///
    /// # Errors
    /// As [`JumpModel::jump`].
    pub fn sensitive_jump(&self, launch: &Launch) -> Result<Jump<Dual<4>>, StanceError> {
        self.model.sensitive_jump(launch)
    }
}
