//! A controller in the loop: the multi-body simulation behind an encoder, read at 1 kHz.

use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg64;
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

/// A step of the encoder (rad): 200 counts a turn in quadrature.
///
/// Source: the thesis, table 3.1.
pub const COUNT: f64 = std::f64::consts::TAU / 800.0;
/// Control period (s).
///
/// Source: the thesis, 3.3.
pub const PERIOD: f64 = 1e-3;
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

/// A jump in the simulation under `control`, which is given each reading of the lean (rad): where
/// it lands (m); none where it does not jump.
///
/// # Errors
/// [`SimError`] for a motion that cannot go on.
pub fn jump(
    robot: &Robot,
    start: [f64; 2],
    height: f64,
    encoder: Encoder,
    mut control: impl FnMut(f64) -> Command,
) -> Result<Option<f64>, SimError> {
    let [lean, rate] = start;
    let rig = Rig::new(robot, &[])?;
    let (q, v) = rig.stand(lean, rate)?;
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
                return fly(&rig, sim, height);
            }
            if pause == Some(Pause::Time) {
                break;
            }
        }
        if fired {
            continue;
        }
        if let Command::Fire { after, valve_open } =
            control(encoder.read(sim.coordinates()[rig.lean_coordinate()]))
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
