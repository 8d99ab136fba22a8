//! One jump of the thesis' robot: lift-off, landing, demands on the ground, and their errors.
//!
//! `cargo run -p saltus --example one_jump`

use std::error::Error;

use saltus::planner::Sensitivity;
use saltus::{Launch, Planner, Robot};

fn main() -> Result<(), Box<dyn Error>> {
    let planner = Planner::new(Robot::rats_planar());

    // It rolls at 5 rad/s, fires the leg 0.1 rad before the upright and holds the valve open for
    // 100 ms.
    let launch = Launch::at_firing(5.0, -0.1, 0.1);
    let jump = planner.jump(&launch)?;
    let end = jump.stance;
    println!("outcome     {}", end.outcome.name());
    println!(
        "lift-off    {:.4} s after firing, lean {:.4} rad",
        end.time - end.time_fire,
        end.lean
    );
    let (Some(apex), Some(distance)) = (jump.apex(), jump.distance(0.0)) else {
        println!("no flight");
        return Ok(());
    };
    println!("apex        {apex:.4} m");
    println!("distance    {distance:.4} m, to where the wheel's centre comes down to y = 0");

    // The whole stance: the ground's reaction and the energy.
    let trace = planner.stance().trace(&launch)?;
    println!(
        "friction    a coefficient of {:.3} keeps the foot still",
        trace.contact.friction_needed
    );
    println!(
        "work        {:.3} J by the gas, {:.3} J lost",
        trace.energy.drive, trace.energy.losses
    );

    // Exact derivatives of the distance, and the error that follows from the robot's measurement
    // errors.
    let jump = planner.sensitive_jump(&launch)?;
    if let Some(distance) = jump.distance(0.0) {
        let sensitivity = Sensitivity::new(distance);
        println!("by ω        {:.4} m per rad/s", sensitivity.by_rate);
        println!("by α_f      {:.4} m per rad", sensitivity.by_firing_angle);
        let deviation = sensitivity.standard_deviation(&planner.robot().errors);
        println!("deviation   {deviation:.4} m, one standard deviation");
    }
    Ok(())
}
