//! Learning to run: chapter 6 of the thesis, and the firing angles that 8.3.2 recommends.
//!
//! An [`Environment`] is a robot with a task. An [`Episode`] of it goes on a step at a time. [`Bins`] make
//! one state of what is observed, and [`Tabular`] learns what to do in each, by the four algorithms of
//! 6.2.2 to 6.2.5. [`train`] brings them together.

mod bins;
mod gridded;
mod legs;
mod plant;
mod process;
mod reward;
mod stride;
mod tabular;
mod training;
mod zone;

pub use bins::{Bin, Bins};
pub use gridded::Gridded;
pub use legs::Legs;
pub use plant::Plant;
pub use process::{Act, Actions, Axis, Environment, Episode, Outcome, Step};
pub use reward::{Reward, Term};
pub use stride::Stride;
pub use tabular::{Algorithm, Rates, Seen, Tabular};
pub use training::{Schedule, Score, Training, greedy, train};
pub use zone::{Task, Zone};
