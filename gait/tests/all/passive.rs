//! Rolling without drive, against its closed form.

use proptest::prelude::*;
use saltus_gait::GaitError;
use saltus_gait::analysis::passive::{
    Rolling, least_slope, roll, simulated_rolling, steady_rolling,
};
use saltus_robot::Robot;
use saltus_sim_check::Stepping;

use crate::robot;

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
fn rolling_by_events_is_the_closed_form() -> Result<(), GaitError> {
    let planar = robot("rats-planar");
    let wanted = steady_rolling(&planar, SLOPE).unwrap_or_else(|| panic!("rolls"));
    let got = simulated_rolling(&planar, SLOPE, 2.0, 30, Stepping::Adaptive)?;
    // The tolerance; what is found is far below it.
    check(got.unwrap_or_else(|| panic!("rolls")), wanted, 1e-6);
    Ok(())
}

#[test]
fn rolling_in_steps_of_1_ms_is_the_closed_form_to_1e_3() -> Result<(), GaitError> {
    let planar = robot("rats-planar");
    let wanted = steady_rolling(&planar, SLOPE).unwrap_or_else(|| panic!("rolls"));
    let got = simulated_rolling(&planar, SLOPE, 2.0, 30, Stepping::USUAL)?;
    check(got.unwrap_or_else(|| panic!("rolls")), wanted, 1e-3);
    Ok(())
}

/// From well above the cycle's rate, so that a stop is the slope's doing.
#[test]
fn it_comes_to_a_stop_where_the_closed_form_says_so() -> Result<(), GaitError> {
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
        prop_assume!(slope < std::f64::consts::PI / f64::from(legs));
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
