//! The `saltus` command: it parses, calls and prints; what is computed is computed in the library.

#![cfg_attr(test, allow(clippy::unwrap_used))]

mod animation;
mod cli;
mod columns;
mod error;
mod input;
mod interrupt;
mod output;
mod plot;
mod progress;
mod quantity;
mod range;
mod slip;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::main()
}
