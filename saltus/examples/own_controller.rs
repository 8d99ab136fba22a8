//! A controller of one's own in the loop of the multi-body simulation: it fires at one angle.
//!
//! `cargo run --release -p saltus --example own_controller`

use saltus::Robot;
use saltus::closed_loop::{Command, Start, jump};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let start = Start {
        lean: -0.5,
        rate: 5.0,
    };
    let fire = Command::Fire {
        after: 0.0,
        valve_open: 0.1,
    };
    let landing = jump(&Robot::rats_planar(), start, 0.0, |lean| {
        if lean > -0.1 { fire } else { Command::Wait }
    })?;
    println!("lands {:.3} m ahead", landing.ok_or("does not jump")?);
    Ok(())
}
