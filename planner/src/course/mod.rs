//! Courses: the decisions of several jumps over obstacles, by search and quadratic programming.
//!
//! 1. `terrain` turns obstacles and no-landing areas into grounds to land on and edges to clear.
//! 2. `search` decides which jump clears which obstacle: branch and bound over the grounds of the landings, with
//!    lower bounds from `envelope`; nothing is dropped but by a bound.
//! 3. `problem` writes the jumps of one choice as a nonlinear program, and [`sqp`] solves it, each step a quadratic
//!    program in `qp`, the only place that knows `clarabel`.
//! 4. `nearest` answers for a course that has no plan: what blocks it, and by how much it would have to give.
//!
//! What a robot can do is a [`Jumper`]. Not promised here: that the jumper is right; whoever calls [`plan`] flies the
//! plan in the full model afterwards.

mod choices;
mod envelope;
mod jumper;
mod nearest;
mod problem;
mod qp;
mod search;
mod span;
pub mod sqp;
mod task;
mod terrain;

pub use envelope::Envelope;
pub use jumper::{Edge, Flight, Jumper, Leap, Limit, Margin, Side, Slope};
pub use nearest::{Give, Relief};
pub use search::{Answer, Jump, Plan, Settings, plan};
pub use span::Span;
pub use task::{Course, CourseError, MAX_JUMPS, Obstacle};

#[cfg(test)]
mod tests;
