//! A controller of one's own in the loop of the multi-body simulation.

use saltus_robot::Robot;
use saltus_sim_check::{Happening, Pause, Rig, Settings, Sim, SimError, Stepping};

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
    let (q, v) = rig.stand(start.lean, start.rate)?;
    let settings = Settings {
        tolerance: 1e-8,
        stepping: Stepping::Adaptive,
        ..Settings::default()
    };
    let mut sim = Sim::new(&rig.mechanism, &q, &v, settings)?;
    let mut fired = false;
    // The start is known; readings begin a period later.
    for tick in 1..1500_u32 {
        let next = f64::from(tick) * PERIOD;
        while sim.time() < next {
            let pause = sim.run_eventwise(next, &[])?;
            if sim
                .events()
                .iter()
                .any(|e| e.what == Happening::LiftOff(0, 0))
            {
                return fly(&rig, sim, landing_height);
            }
            if pause == Some(Pause::Time) {
                break;
            }
        }
        if fired {
            continue;
        }
        if let Command::Fire { after, valve_open } =
            control(sim.coordinates()[rig.lean_coordinate()])
        {
            let at = sim.time() + after;
            sim.run(at, &[])?;
            sim.fire(0, valve_open)?;
            fired = true;
        }
    }
    Ok(None)
}

/// The rest of a jump, from lift-off.
fn fly(rig: &Rig, mut sim: Sim<'_>, height: f64) -> Result<Option<f64>, SimError> {
    sim.stop_touching();
    let rising = |_: f64, q: &[f64], v: &[f64]| rig.axle_rates(q, v)[1];
    let until = sim.time() + 2.0;
    if rig.axle_rates(sim.coordinates(), sim.velocities())[1] > 0.0 {
        sim.run(until, &[&rising])?;
    }
    let above = |_: f64, q: &[f64], _: &[f64]| rig.axle(q)[1] - height;
    if rig.axle(sim.coordinates())[1] <= height {
        return Ok(None);
    }
    Ok(match sim.run(until, &[&above])? {
        Pause::Watch(_) => Some(rig.axle(sim.coordinates())[0]),
        Pause::Time => None,
    })
}
