//! The rolling robot on a course: firing angles and valve opening times over obstacles.
//!
//! [`Planner::cross`] makes the robot a [`Jumper`](course::Jumper): each of its jumps is flown by
//! the planner's model with derivatives, and [`course::plan`] searches and solves. The plan is then
//! flown again, finely, and held against every limit: see [`Check`].

use std::borrow::Cow;
use std::ops::ControlFlow;

use saltus_lagrangian::{Launch, StanceError};
use saltus_robot::Outcome;

use crate::course::{self, Answer, CourseError, Limit, MAX_JUMPS, Relief, Span, Watch};
use crate::jump::Jump;
use crate::model::JumpModel;
use crate::planner::Planner;

mod check;
mod grid;
mod request;
mod roller;
mod stance;

pub use check::Check;
pub use request::{Crossing, EDGE_MARGIN, MARGIN_SIGMAS};
use roller::Roller;

/// Costs are about 1 and a tenth of a millimetre off the target costs 1e-6; the start is within a
/// third of the range of the answer.
const SOLVER: course::sqp::Settings = course::sqp::Settings {
    iterations: 60,
    tolerance: 1e-6,
    feasibility: 5e-7,
    radius: 0.3,
};

/// Nodes that a search may look at.
const NODES: usize = 1000;

/// Jumps in the programs that a search may solve: 20 programs of 12 jumps take some seconds.
const WORK: usize = 240;

/// What crossing a course comes to.
#[derive(Clone, Debug)]
pub enum CrossingAnswer {
    /// A plan, and how it fared in the check.
    Plan(CrossingPlan),
    /// There is none.
    Infeasible {
        /// What blocks, and how the nearest course that has a plan differs.
        relief: Relief,
        /// With how many jumps, up to two more, there is a plan.
        jumps: Option<usize>,
    },
    /// None was found before the search came to its limits or was stopped.
    Undecided {
        /// Nodes of the search that were looked at.
        nodes: usize,
        /// Programs that were solved.
        solves: usize,
    },
}

/// A plan for a course.
#[derive(Clone, Debug)]
pub struct CrossingPlan {
    /// Jump after jump.
    pub jumps: Vec<PlannedJump>,
    /// The search's own account.
    pub search: course::Plan,
    /// Every limit, held against the full model.
    pub checks: Vec<Check>,
}

impl CrossingPlan {
    /// Whether every limit holds in the planner's model.
    pub fn holds(&self) -> bool {
        self.checks.iter().all(Check::holds)
    }
}

/// One jump of a plan, as the full model flies it.
#[derive(Clone, Debug)]
pub struct PlannedJump {
    /// Foothold (m), and the height of its surface (m).
    pub foot: [f64; 2],
    /// The jump; its positions count from the foothold.
    pub jump: Jump,
    /// Landing (m along the course), and the height of its surface (m).
    pub landing: [f64; 2],
    /// Standard deviation of the landing (m), to first order.
    pub deviation: f64,
    /// Friction coefficient that the stance needs.
    pub friction_needed: f64,
}

impl Crossing {
    /// The launches of an answer: those of the plan, or of the nearest course that has one.
    pub fn launches(&self, answer: &CrossingAnswer) -> Vec<Launch> {
        match answer {
            CrossingAnswer::Plan(plan) => plan.jumps.iter().map(|j| j.jump.launch).collect(),
            CrossingAnswer::Infeasible { relief, .. } => {
                let decisions = relief.decisions.iter().enumerate();
                decisions.map(|(k, d)| self.launch(k, *d)).collect()
            }
            CrossingAnswer::Undecided { .. } => Vec::new(),
        }
    }
}

/// A crossing that cannot even be tried.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CrossingError {
    /// The course is wrong.
    #[error(transparent)]
    Course(#[from] CourseError),
    /// A number is outside its domain.
    #[error("{key} = {}: must be {allowed}", saltus_numeric::plain(*value))]
    Input {
        /// Key, as in course files.
        key: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A stance cannot be computed.
    #[error(transparent)]
    Stance(#[from] StanceError),
    /// A truer model does not fly as planned.
    #[error(
        "jump {jump}: robot {robot} does not fly ({}), neither at the planned launch nor at \
         any that was tried", outcome.name()
    )]
    NeverFlies {
        /// Number of the jump, from 1.
        jump: usize,
        /// Name of the truer model's robot.
        robot: String,
        /// What its stance comes to.
        outcome: Outcome,
    },
}

impl Planner<dyn JumpModel> {
    /// Plans `crossing`.
    ///
    /// # Errors
    /// [`CrossingError`] for a value outside its domain. A course without a plan is an answer, not
    /// an error.
    pub fn cross(&self, crossing: &Crossing) -> Result<CrossingAnswer, CrossingError> {
        self.cross_watched(crossing, &|_| ControlFlow::Continue(()))
    }

    /// As [`cross`](Self::cross), with `watch` told how far the search is; it may stop it, and gets
    /// the best answer so far.
    ///
    /// # Errors
    /// As [`cross`](Self::cross).
    pub fn cross_watched(
        &self,
        crossing: &Crossing,
        watch: &Watch<'_>,
    ) -> Result<CrossingAnswer, CrossingError> {
        crossing.check()?;
        let crossing = &self.with_its_valve(crossing);
        Ok(match self.search(crossing, watch)? {
            Answer::Plan(plan) => CrossingAnswer::Plan(self.verify(crossing, plan)?),
            Answer::Infeasible(relief) => {
                let jumps = self.enough_jumps(crossing, &relief, watch)?;
                CrossingAnswer::Infeasible { relief, jumps }
            }
            Answer::Undecided { nodes, solves } => CrossingAnswer::Undecided { nodes, solves },
        })
    }

    /// `crossing` as this robot can choose: without a valve there is no opening time to choose, and
    /// none that costs.
    fn with_its_valve<'a>(&self, crossing: &'a Crossing) -> Cow<'a, Crossing> {
        if self.robot().leg.drive.has_valve() {
            return Cow::Borrowed(crossing);
        }
        let valve_open = Span::point(crossing.valve_open.low);
        Cow::Owned(Crossing {
            valve_open,
            effort_weight: 0.0,
            ..crossing.clone()
        })
    }

    fn search(&self, crossing: &Crossing, watch: &Watch<'_>) -> Result<Answer, CourseError> {
        course::plan_watched(
            &Roller::new(self, crossing),
            &crossing.course,
            &settings(crossing),
            watch,
        )
    }

    /// With how many jumps, one or two more, there is a plan; looked for where one more landing can
    /// help and all jumps have the same rate.
    fn enough_jumps(
        &self,
        crossing: &Crossing,
        relief: &Relief,
        watch: &Watch<'_>,
    ) -> Result<Option<usize>, CrossingError> {
        let helps = |limit: Limit| matches!(limit, Limit::Goal | Limit::Landing(_));
        if crossing.rates.len() > 1 || !relief.gives.iter().any(|give| helps(give.limit)) {
            return Ok(None);
        }
        for jumps in (crossing.course.jumps + 1..=MAX_JUMPS).take(2) {
            let mut more = crossing.clone();
            more.course.jumps = jumps;
            if let Answer::Plan(plan) = self.search(&more, watch)?
                && self.verify(&more, plan)?.holds()
            {
                return Ok(Some(jumps));
            }
        }
        Ok(None)
    }
}

fn settings(crossing: &Crossing) -> course::Settings {
    course::Settings {
        sigmas: crossing.sigmas,
        // One program for each choice of grounds: a choice's distances are smooth in its decisions.
        resolution: f64::INFINITY,
        nodes: NODES,
        work: WORK,
        solver: SOLVER,
        ..course::Settings::default()
    }
}

#[cfg(test)]
mod tests;
