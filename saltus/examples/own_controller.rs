//! A controller of one's own in the loop of the multi-body simulation: it fires at one angle.
//!
//! `cargo run --release -p saltus --example own_controller`

use saltus::Robot;
use saltus::sim_check::{Rig, Settings, Shot};

/// Firing angle (rad).
const FIRING_ANGLE: f64 = -0.1;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let rig = Rig::new(&Robot::rats_planar(), &[])?;
    // Comes down onto its leg 0.5 rad before the upright, at 5 rad/s.
    let mut shot = Shot::new(&rig, [-0.5, 5.0], Settings::default())?;
    // The controller reads the lean each millisecond.
    while shot.lean() <= FIRING_ANGLE {
        shot.go(shot.time() + 1e-3, &[])?;
    }
    shot.fire(0.1)?;
    // To the apex, and down to the foot's height.
    let until = shot.time() + 2.0;
    let rising = |_: f64, q: &[f64], v: &[f64]| rig.axle_rates(q, v)[1];
    let above = |_: f64, q: &[f64], _: &[f64]| rig.axle(q)[1];
    shot.go(until, &[&rising])?;
    shot.go(until, &[&above])?;
    println!("lands {:.3} m ahead", rig.axle(shot.sim().coordinates())[0]);
    Ok(())
}
