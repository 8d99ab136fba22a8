//! A controller in the loop of the multi-body simulation, and its sensors: an encoder, and the
//! approach rate that it gives.

use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg64;
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

/// A step of the encoder (rad): 200 counts a turn in quadrature.
///
/// Source: the thesis, table 3.1.
pub const COUNT: f64 = std::f64::consts::TAU / 800.0;
/// Time (s) between the two readings that an approach rate is taken from.
pub const BASELINE: f64 = 0.05;

/// The sensors of one jump.
#[derive(Clone, Copy, Debug)]
pub struct Encoder {
    /// Where in a step the encoder's zero is, 0 to 1; none: an encoder without steps.
    pub phase: Option<f64>,
}

impl Encoder {
    /// One that is put on at random.
    pub fn drawn(random: &mut Pcg64) -> Encoder {
        Encoder {
            phase: Uniform::new(0.0, 1.0)
                .ok()
                .map(|range| range.sample(random)),
        }
    }

    /// The lean (rad) that it reads: the middle of the step.
    pub fn read(&self, lean: f64) -> f64 {
        match self.phase {
            Some(phase) => ((lean / COUNT + phase).floor() + 0.5 - phase) * COUNT,
            None => lean,
        }
    }

    /// The approach rate (rad/s) that two readings give, of a robot that rolled at `rate` up to
    /// `lean`.
    pub fn approach_rate(&self, lean: f64, rate: f64) -> f64 {
        (self.read(lean) - self.read(lean - rate * BASELINE)) / BASELINE
    }
}

/// Mean, standard deviation and greatest size of `errors`.
pub fn spread(errors: &[f64]) -> [f64; 3] {
    let n = errors.len().max(1) as f64;
    let mean = errors.iter().sum::<f64>() / n;
    let square = errors.iter().map(|e| (e - mean) * (e - mean)).sum::<f64>() / (n - 1.0).max(1.0);
    [
        mean,
        square.sqrt(),
        errors.iter().fold(0.0, |worst, e| worst.max(e.abs())),
    ]
}
