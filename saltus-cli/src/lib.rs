//! The `saltus` command: it parses, calls and prints; what is computed is computed in the library
//! [`saltus`]. Other programs run it by [`ask`], as the Python package does.

#![cfg_attr(test, allow(clippy::unwrap_used))]

mod animation;
mod ask;
mod cli;
mod columns;
mod error;
mod identity;
mod input;
mod interrupt;
mod output;
mod plot;
mod progress;
mod quantity;
mod range;
mod session;
mod slip;

pub use ask::{Answer, Refused, ask};
pub use cli::main;
pub use session::Stop;
