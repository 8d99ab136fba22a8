//! Rolling without drive, against its closed form.

use std::f64::consts::PI;

use proptest::prelude::*;
use saltus_robot::Robot;
use saltus_sim_check::{Event, Happening, Pause, Rig, Settings, Sim, SimError, Stepping};

use crate::robot;

/// The steady rolling of a wheel of legs: every step is like the one before.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Rolling {
    /// Rate (rad/s) just before a foot comes down.
    before: f64,
    /// Rate (rad/s) just after.
    after: f64,
    /// By how much a small difference of rate is multiplied from one step to the next.
    multiplier: f64,
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
fn steady_rolling(robot: &Robot, slope: f64) -> Option<Rolling> {
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
fn least_slope(robot: &Robot) -> Option<f64> {
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
struct Step {
    /// Rate (rad/s) before.
    before: f64,
    /// Rate (rad/s) after.
    after: f64,
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
fn roll(
    robot: &Robot,
    slope: f64,
    rate: f64,
    steps: usize,
    stepping: Stepping,
) -> Result<Vec<Step>, SimError> {
    let mut tilted = robot.clone();
    tilted.ground.tilt = -slope;
    let rig = Rig::new(&tilted, &[])?;
    let half = PI / f64::from(robot.body.legs);
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
            before,
            after: sim.velocities()[spin],
        });
    }
    Ok(done)
}

/// Goes on until a foot comes down; whether one did.
fn touch_down(sim: &mut Sim<'_>) -> Result<bool, SimError> {
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
fn simulated_rolling(
    robot: &Robot,
    slope: f64,
    rate: f64,
    steps: usize,
    stepping: Stepping,
) -> Result<Option<Rolling>, SimError> {
    let rolled = roll(robot, slope, rate, steps, stepping)?;
    let Some(last) = rolled.last().filter(|_| rolled.len() == steps) else {
        return Ok(None);
    };
    let next = |rate: f64| -> Result<Option<f64>, SimError> {
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

const SLOPE: f64 = 0.25;

/// Holds `got` against `wanted`.
fn check(got: Rolling, wanted: Rolling, tolerance: f64) {
    for (what, got, wanted) in [
        ("before", got.before, wanted.before),
        ("after", got.after, wanted.after),
        ("multiplier", got.multiplier, wanted.multiplier),
    ] {
        let error = (got - wanted).abs();
        assert!(error <= tolerance, "{what}: {got}, not {wanted}: {error:e}");
    }
}

/// The closed form's numbers, worked out by hand before the simulation.
#[test]
fn the_closed_form_has_the_known_numbers() {
    let planar = robot("rats-planar");
    let rolling = steady_rolling(&planar, SLOPE).unwrap_or_else(|| panic!("rolls"));
    let known = Rolling {
        before: 4.72711,
        after: 2.54954,
        multiplier: 0.290893,
    };
    check(rolling, known, 6e-6);
    let least = least_slope(&planar).unwrap_or_else(|| panic!("rolls on some slope"));
    assert!((least - 0.194).abs() < 5e-4, "{least}");
}

/// 30 steps take 0.29^30 of the start's difference from the cycle, less than round-off.
#[test]
fn rolling_by_events_is_the_closed_form() -> Result<(), SimError> {
    let planar = robot("rats-planar");
    let wanted = steady_rolling(&planar, SLOPE).unwrap_or_else(|| panic!("rolls"));
    let got = simulated_rolling(&planar, SLOPE, 2.0, 30, Stepping::Adaptive)?;
    // The tolerance; what is found is far below it.
    check(got.unwrap_or_else(|| panic!("rolls")), wanted, 1e-6);
    Ok(())
}

#[test]
fn rolling_in_steps_of_1_ms_is_the_closed_form_to_1e_3() -> Result<(), SimError> {
    let planar = robot("rats-planar");
    let wanted = steady_rolling(&planar, SLOPE).unwrap_or_else(|| panic!("rolls"));
    let got = simulated_rolling(&planar, SLOPE, 2.0, 30, Stepping::USUAL)?;
    check(got.unwrap_or_else(|| panic!("rolls")), wanted, 1e-3);
    Ok(())
}

/// From well above the cycle's rate, so that a stop is the slope's doing.
#[test]
fn it_comes_to_a_stop_where_the_closed_form_says_so() -> Result<(), SimError> {
    let planar = robot("rats-planar");
    let least = least_slope(&planar).unwrap_or_else(|| panic!("rolls on some slope"));
    for (slope, rolls) in [(least - 1e-4, false), (least + 1e-4, true)] {
        assert_eq!(steady_rolling(&planar, slope).is_some(), rolls);
        let steps = roll(&planar, slope, 3.0, 40, Stepping::Adaptive)?;
        assert_eq!(steps.len() == 40, rolls, "slope {slope}: {}", steps.len());
    }
    Ok(())
}

fn wheel(legs: u32, spread: f64) -> Robot {
    let mut wheel = robot("rats-planar");
    wheel.body.legs = legs;
    wheel.body.inertia *= spread;
    wheel
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    /// Any wheel of legs, on any slope down which it rolls without flying.
    #[test]
    fn any_wheel_rolls_as_its_closed_form(
        legs in 4_u32..=12,
        spread in 0.7..1.8,
        slope in 0.01..0.6_f64,
    ) {
        let wheel = wheel(legs, spread);
        prop_assume!(slope < PI / f64::from(legs));
        let Some(wanted) = steady_rolling(&wheel, slope) else {
            // Either it stops, or it flies, which the closed form does not tell apart.
            return Ok(());
        };
        // Below the cycle's rate, so that it flies in no step before.
        let start = 0.9 * wanted.after;
        let steps = roll(&wheel, slope, start, 6, Stepping::Adaptive);
        let steps = steps.map_err(|e| TestCaseError::fail(e.to_string()))?;
        prop_assume!(steps.len() == 6);
        // ω² of every impact follows from that of the one before.
        let mut after = start;
        for step in steps {
            let gain = wanted.before.powi(2) - wanted.after.powi(2);
            let before = (after * after + gain).sqrt();
            after = before * wanted.multiplier.sqrt();
            prop_assert!((step.before - before).abs() < 1e-7, "{} {before}", step.before);
            prop_assert!((step.after - after).abs() < 1e-7, "{} {after}", step.after);
        }
    }
}
