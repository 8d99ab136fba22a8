//! A wheel of legs that rolls down a slope without drive: the rimless wheel, exactly known.

use std::f64::consts::PI;

use saltus_robot::Robot;
use saltus_sim_check::{Event, Happening, Pause, Rig, Settings, Sim, Stepping};

use crate::GaitError;
use crate::error::require;

/// The steady rolling of a wheel of legs: every step is like the one before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rolling {
    /// Rate (rad/s) just before a foot comes down.
    pub before: f64,
    /// Rate (rad/s) just after.
    pub after: f64,
    /// By how much a small difference of rate is multiplied from one step to the next.
    pub multiplier: f64,
}

/// The wheel's constants, on an axle that moves in a plane: m, I, r, and the pitch's half π/n.
#[derive(Clone, Copy, Debug)]
struct Wheel {
    mass: f64,
    inertia: f64,
    radius: f64,
    half: f64,
    gravity: f64,
}

impl Wheel {
    fn of(robot: &Robot) -> Wheel {
        Wheel {
            mass: robot.body.mass,
            inertia: robot.body.inertia,
            radius: robot.body.radius,
            half: PI / f64::from(robot.body.legs),
            gravity: robot.environment.gravity,
        }
    }

    /// J = I + m r² (kg m²), about a foot.
    fn inertia_about_foot(&self) -> f64 {
        self.inertia + self.mass * self.radius * self.radius
    }

    /// Rate after an impact over rate before: angular momentum about the foot that comes down.
    fn impact_ratio(&self) -> f64 {
        let lever = self.mass * self.radius * self.radius * (2.0 * self.half).cos();
        (self.inertia + lever) / self.inertia_about_foot()
    }

    /// ω² (rad²/s²) before an impact on `slope` (rad), in the limit.
    fn square_before(&self, slope: f64) -> f64 {
        let fall = 2.0 * self.radius * self.half.sin() * slope.sin();
        let gain = 2.0 * self.mass * self.gravity * fall / self.inertia_about_foot();
        gain / (1.0 - self.impact_ratio().powi(2))
    }

    /// ω² (rad²/s²) after an impact that just suffices to reach the top of the next step.
    fn square_needed(&self, slope: f64) -> f64 {
        let rise = self.radius * (1.0 - (self.half - slope).cos());
        2.0 * self.mass * self.gravity * rise / self.inertia_about_foot()
    }

    fn passes_the_top(&self, slope: f64) -> bool {
        let ratio = self.impact_ratio();
        ratio > 0.0 && ratio * ratio * self.square_before(slope) >= self.square_needed(slope)
    }

    /// Whether the foot is pressed to the ground at the end of a step, where centrifugal force is
    /// greatest.
    fn stays_on_the_ground(&self, slope: f64) -> bool {
        let fall = self.half + slope;
        let spin = self.mass * self.gravity * self.radius * fall.sin() / self.inertia_about_foot();
        let up =
            -self.radius * (self.square_before(slope) * self.half.cos() + spin * self.half.sin());
        self.gravity * slope.cos() + up > 0.0
    }
}

/// The steady rolling of `robot`, unfired, down a slope (rad, > 0), in closed form; none where it
/// comes to a stop, or flies.
///
/// η = (I + m r² cos 2π/n)/(I + m r²); ω² = 2 ΔE/(J (1 − η²)) with ΔE = 2 m g r sin π/n sin slope;
/// the multiplier is η². For point feet that do not slip, and an axle without a boom.
///
/// Source: McGeer, Passive dynamic walking (1990), §2.
pub fn steady_rolling(robot: &Robot, slope: f64) -> Option<Rolling> {
    let wheel = Wheel::of(robot);
    let rolls = slope > 0.0 && wheel.passes_the_top(slope) && wheel.stays_on_the_ground(slope);
    rolls.then(|| {
        let (before, ratio) = (wheel.square_before(slope).sqrt(), wheel.impact_ratio());
        Rolling {
            before,
            after: ratio * before,
            multiplier: ratio * ratio,
        }
    })
}

/// Least slope (rad) down which `robot` goes on rolling, in closed form, to round-off; none if it
/// does not on any slope up to half a pitch, beyond which it does not stand on one foot.
pub fn least_slope(robot: &Robot) -> Option<f64> {
    let wheel = Wheel::of(robot);
    let (mut stops, mut rolls) = (0.0, wheel.half);
    if !wheel.passes_the_top(rolls) {
        return None;
    }
    for _ in 0..60 {
        let slope = 0.5 * (stops + rolls);
        if wheel.passes_the_top(slope) {
            rolls = slope;
        } else {
            stops = slope;
        }
    }
    Some(rolls)
}

/// A step of a rolling wheel: a foot comes down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// When (s).
    pub time: f64,
    /// Rate (rad/s) before.
    pub before: f64,
    /// Rate (rad/s) after.
    pub after: f64,
}

/// How far (rad) before a foot comes down the rate counts as that before: what the simulation tells
/// apart from the touch-down itself.
fn just_before(stepping: Stepping) -> f64 {
    match stepping {
        Stepping::Adaptive => 1e-9,
        Stepping::Fixed(_) => 1e-6,
    }
}

/// Time (s) in which a step must be done: a wheel slower than that has come to a stop.
const PATIENCE: f64 = 5.0;

/// The steps of `robot`, simulated unfired down `slope` (rad), from an impact after which it turns at
/// `rate` (rad/s): at most so many `steps`, fewer where it comes to a stop.
///
/// # Errors
/// [`GaitError::Input`] for a robot that steps onto more than one foot or does not stand,
/// [`GaitError::Sim`] where the motion cannot go on.
pub fn roll(
    robot: &Robot,
    slope: f64,
    rate: f64,
    steps: usize,
    stepping: Stepping,
) -> Result<Vec<Step>, GaitError> {
    let legs = robot.body.legs;
    let allowed = "at least 3, for a robot that rolls";
    require(legs >= 3, "legs", f64::from(legs), allowed)?;
    let mut tilted = robot.clone();
    tilted.ground.tilt = -slope;
    let rig = Rig::new(&tilted, &[])?;
    let half = PI / f64::from(legs);
    let (q, v) = rig.stand(-half, rate)?;
    let settings = Settings {
        stepping,
        ..Settings::default()
    };
    let mut sim = Sim::new(&rig.mechanism, &q, &v, settings)?;
    let (lean, spin) = (rig.lean_coordinate(), rig.lean_velocity());
    let mut done = Vec::new();
    for k in 0..steps {
        let target = half * (2 * k + 1) as f64 - just_before(stepping);
        let to_go = |_: f64, q: &[f64], _: &[f64]| target - q[lean];
        if sim.run(sim.time() + PATIENCE, &[&to_go])? == Pause::Time {
            break;
        }
        let before = sim.velocities()[spin];
        if !touch_down(&mut sim)? {
            break;
        }
        done.push(Step {
            time: sim.time(),
            before,
            after: sim.velocities()[spin],
        });
    }
    Ok(done)
}

/// Goes on until a foot comes down; whether one did.
fn touch_down(sim: &mut Sim<'_>) -> Result<bool, GaitError> {
    let until = sim.time() + 0.1;
    sim.drain_events();
    loop {
        let pause = sim.run_eventwise(until, &[])?;
        let is_step = |e: &Event| matches!(e.what, Happening::TouchDown(..));
        if sim.drain_events().any(|e| is_step(&e)) {
            return Ok(true);
        }
        if pause.is_some() {
            return Ok(false);
        }
    }
}

/// The steady rolling of `robot` down `slope` (rad) as simulated: the last of so many `steps` from
/// `rate` (rad/s), and the multiplier by differences there; none if it comes to a stop before.
///
/// # Errors
/// As [`roll`].
pub fn simulated_rolling(
    robot: &Robot,
    slope: f64,
    rate: f64,
    steps: usize,
    stepping: Stepping,
) -> Result<Option<Rolling>, GaitError> {
    let rolled = roll(robot, slope, rate, steps, stepping)?;
    let Some(last) = rolled.last().filter(|_| rolled.len() == steps) else {
        return Ok(None);
    };
    let next = |rate: f64| -> Result<Option<f64>, GaitError> {
        Ok(roll(robot, slope, rate, 1, stepping)?
            .first()
            .map(|s| s.after))
    };
    // Differences of two widths, so that what is of third order cancels.
    let mut slopes = [0.0; 2];
    for (k, part) in [0.02, 0.01].into_iter().enumerate() {
        let width = part * last.after;
        let (Some(up), Some(down)) = (next(last.after + width)?, next(last.after - width)?) else {
            return Ok(None);
        };
        slopes[k] = (up - down) / (2.0 * width);
    }
    Ok(Some(Rolling {
        before: last.before,
        after: last.after,
        multiplier: (4.0 * slopes[1] - slopes[0]) / 3.0,
    }))
}
