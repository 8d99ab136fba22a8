//! A controller of one's own in the loop of the multi-body simulation.

use saltus_robot::Robot;
use saltus_sim_check::{Pause, Rig, Settings, Shot, SimError};

/// What a controller commands after a reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command {
    /// Nothing yet.
    Wait,
    /// To open the valve so long (s) after the reading, for so long (s).
    Fire {
        /// After the reading (s).
        after: f64,
        /// Valve opening time (s).
        valve_open: f64,
    },
}

/// Control period (s).
///
/// Source: the thesis, 3.3.
pub const PERIOD: f64 = 1e-3;

/// How a robot comes down onto its leg.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// Lean (rad), negative before the upright.
    pub lean: f64,
    /// Rate (rad/s) at which it rolls forward.
    pub rate: f64,
}

/// Distance (m) from the foot at which the wheel's centre comes down to `landing_height` (m), in
/// the simulation under `control`; none where the robot does not jump.
///
/// `control` is given the lean (rad) each [`PERIOD`] after the start, until it fires.
///
/// # Errors
/// [`SimError`] for a motion that cannot go on.
pub fn jump(
    robot: &Robot,
    start: Start,
    landing_height: f64,
    mut control: impl FnMut(f64) -> Command,
) -> Result<Option<f64>, SimError> {
    let rig = Rig::new(robot, &[])?;
    let mut shot = Shot::new(&rig, [start.lean, start.rate], Settings::default())?;
    let mut is_fired = false;
    // The start is known; readings begin a period later.
    for tick in 1..1500_u32 {
        shot.go(f64::from(tick) * PERIOD, &[])?;
        if shot.lift_off().is_some() {
            return fly(&rig, shot, landing_height);
        }
        if is_fired {
            continue;
        }
        if let Command::Fire { after, valve_open } = control(shot.lean()) {
            shot.go(shot.time() + after, &[])?;
            shot.fire(valve_open)?;
            is_fired = true;
        }
    }
    Ok(None)
}

/// The rest of a jump, from lift-off.
fn fly(rig: &Rig, mut shot: Shot<'_>, height: f64) -> Result<Option<f64>, SimError> {
    let rising = |_: f64, q: &[f64], v: &[f64]| rig.axle_rates(q, v)[1];
    let above = |_: f64, q: &[f64], _: &[f64]| rig.axle(q)[1] - height;
    let until = shot.time() + 2.0;
    if rising(0.0, shot.sim().coordinates(), shot.sim().velocities()) > 0.0 {
        shot.go(until, &[&rising])?;
    }
    if rig.axle(shot.sim().coordinates())[1] <= height {
        return Ok(None);
    }
    Ok(match shot.go(until, &[&above])? {
        Pause::Watch(_) => Some(rig.axle(shot.sim().coordinates())[0]),
        Pause::Time => None,
    })
}
