//! Courses: the decisions of several jumps over obstacles, by search and quadratic programming.
//!
//! 1. `terrain` turns obstacles and no-landing areas into grounds to land on and edges to clear.
//! 2. `search` decides which jump clears which obstacle: branch and bound over the grounds of the
//!    landings, with lower bounds from `envelope`. `choices` grows the sequences of grounds in the
//!    order of their bounds, which it gets by dynamic programming. The first plan, and where the
//!    solver starts, come from `lattice`: dynamic programming over a lattice of footholds.
//! 3. `problem` writes the jumps of one choice as a nonlinear program, and [`sqp`] solves it, each
//!    step a quadratic program in `qp`, the only place that knows `clarabel`.
//! 4. `nearest` answers for a course that has no plan: what blocks it, and by how much it would
//!    have to give.
//!
//! What a robot can do is a [`Jumper`]. Not promised here: that the jumper is right; whoever calls
//! [`plan`] flies the plan in the full model afterwards.

mod choices;
mod envelope;
#[cfg(test)]
pub(crate) mod exhaustive;
mod jumper;
mod lattice;
mod nearest;
mod problem;
mod qp;
mod search;
mod span;
pub mod sqp;
mod task;
mod terrain;

pub use envelope::Envelope;
pub use jumper::{Edge, Flight, Jumper, Leap, Limit, Margin, Push, Side, Sketch, Slope};
pub use nearest::{FRICTION, Give, Relief};
pub use search::{Answer, Jump, Plan, Settings, Standing, Watch, plan, plan_watched};
pub use span::Span;
pub use task::{Course, CourseError, MAX_JUMPS, Obstacle};

#[cfg(test)]
mod tests;
