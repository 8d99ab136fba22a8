//! A course from a file, its plan, and its trial in the multi-body simulation with drawn errors.
//!
//! `cargo run --release -p saltus --example verify_a_course`

use saltus::planner::CrossingAnswer;
use saltus::verify::{Plant, Subject, Verification};
use saltus::{Planner, course, resolve};

const COURSE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/box.toml");

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let planner = Planner::new(resolve("rats-planar", &[])?);
    let plant = Plant::new(planner.robot().clone(), 1e-9);
    let crossing = course::load(COURSE)?;
    let CrossingAnswer::Plan(plan) = planner.cross(&crossing)? else {
        return Err("no plan crosses this course".into());
    };
    let how = Verification {
        samples: 20,
        ..Verification::default()
    };
    let verdict = how.verdict(&Subject::plan(crossing, plan), &planner, &plant)?;
    println!("passes: {}, misses: {:?}", verdict.passes, verdict.failures);
    Ok(())
}
