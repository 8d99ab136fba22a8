//! Periodic gaits and their multipliers.

use nalgebra::{DMatrix, DVector};
use saltus_gait::GaitError;
use saltus_studies::analysis::branch::{Parameter, follow};
use saltus_studies::analysis::periodic::{CLOSED, Periodic, find, settle, settled};
use saltus_studies::analysis::stride::{Firing, Strides};

use crate::{planar, robot};

fn from_speed(strides: &Strides) -> Result<Periodic, GaitError> {
    let found = settle(strides, &strides.standing(0.0, 12.0)?, 60, 5)?;
    Ok(found.found().unwrap_or_else(|| panic!("a periodic gait")))
}

/// Newton's method and its multipliers, where both are known in closed form: rats-planar, unfired,
/// rolls down a slope. Here the foot stands on the section: of four numbers one is free.
#[test]
fn the_rolling_wheel_is_a_periodic_gait_with_the_known_multiplier() -> Result<(), GaitError> {
    let mut wheel = robot("rats-planar");
    wheel.ground.tilt = -0.25;
    let strides = Strides::new(&wheel, Firing::new(0.1, 0.0))?;
    let found = find(&strides, &strides.standing(0.0, 2.3)?, 1)?;
    let gait = found.found().unwrap_or_else(|| panic!("a periodic gait"));
    assert_eq!(gait.multipliers.len(), 1);
    let (multiplier, error) = gait.greatest();
    // ω² is what an impact multiplies by η²; so it is on any section.
    // By hand, and as `gait/tests/all/passive.rs` has it in closed form.
    let off = (multiplier - 0.290893).abs();
    assert!(off < 1e-5 && error < 1e-5, "{multiplier} ± {error:e}");
    assert!(gait.is_stable());
    Ok(())
}

/// The two greatest multipliers from runs in one go from both sides of `gait`: their differences
/// d after period upon period obey d'' = (λ₁ + λ₂) d' − λ₁ λ₂ d.
fn from_runs(strides: &Strides, gait: &Periodic, periods: usize) -> Result<[f64; 2], GaitError> {
    let spin = strides.rig().lean_velocity();
    let run = |sign: f64| {
        let mut state = gait.state.clone();
        state.velocities[spin] += sign * 1e-4;
        strides.strides(&state, gait.legs * periods)
    };
    let [up, down] = [run(1.0)?, run(-1.0)?];
    let difference = |period: usize| -> Vec<f64> {
        let at = |run: &[saltus_studies::analysis::stride::Stride]| {
            run[gait.legs * period - 1].state.velocities[..=spin].to_vec()
        };
        at(&up).iter().zip(at(&down)).map(|(a, b)| a - b).collect()
    };
    let (mut rows, mut right) = (Vec::new(), Vec::new());
    for period in 3..=periods - 2 {
        let [d, next, last] = [0, 1, 2].map(|k| difference(period + k));
        for k in 0..=spin {
            rows.extend([next[k], -d[k]]);
            right.push(last[k]);
        }
    }
    let matrix = DMatrix::from_row_slice(right.len(), 2, &rows);
    let solution = matrix.svd(true, true).solve(&DVector::from_vec(right), 0.0);
    let solution = solution.unwrap_or_else(|e| panic!("{e}"));
    Ok([solution[0], solution[1]])
}

/// The targets: a stable periodic gait, and multipliers to 1 %. Here of the sum and the product
/// of the complex pair that is greatest, of which the next multiplier is a fifteenth.
#[test]
fn rats_run_has_a_stable_gait_whose_multipliers_are_those_of_full_runs() -> Result<(), GaitError> {
    let strides = Strides::new(&robot("rats-run"), Firing::new(0.1, 0.04))?;
    let gait = from_speed(&strides)?;
    assert_eq!(gait.legs, 2);
    assert!(gait.residual < CLOSED && gait.is_stable(), "{gait:?}");
    // 3.438 m/s and 0.451 g/m when this was written.
    assert!((gait.speed - 3.438).abs() < 0.01, "{}", gait.speed);
    assert!((gait.gas * 1e3 - 0.451).abs() < 0.002, "{}", gait.gas);
    let [a, b] = [gait.multipliers[0].value, gait.multipliers[1].value];
    let [sum, product] = from_runs(&strides, &gait, 9)?;
    println!("{} and {sum}, {} and {product}", a + b, a * b);
    assert!(((a + b).re - sum).abs() < 0.01 * a.norm());
    assert!(((a * b).re / product - 1.0).abs() < 0.01);
    Ok(())
}

/// Fired at 0.1 rad, a slow start comes to another gait than a fast one, at half its speed. Of four
/// legs it is not stable: it has doubled its period, and runs go on around it by eight.
#[test]
fn slow_and_fast_starts_come_to_different_gaits() -> Result<(), GaitError> {
    let strides = Strides::new(&robot("rats-run"), Firing::new(0.1, 0.04))?;
    let gaits = settled(&strides, &[4.0, 12.0], [60, 4])?;
    let speeds: Vec<f64> = gaits.iter().map(|gait| gait.speed).collect();
    assert_eq!(gaits.len(), 2, "{speeds:?}");
    assert!(
        (speeds[0] - 1.742).abs() < 0.01 && (speeds[1] - 3.438).abs() < 0.01,
        "{speeds:?}"
    );
    Ok(())
}

/// A slope that helps makes it faster; a branch says where it was lost.
#[test]
fn a_gait_is_followed_over_the_slope() -> Result<(), GaitError> {
    let (flat, firing) = (planar(), Firing::new(0.3, 0.04));
    let gait = from_speed(&Strides::new(&flat, firing)?)?;
    assert_eq!(gait.legs, 1);
    let values = [-0.005, -0.01];
    let branch = follow((&flat, firing), &gait, Parameter::Slope, &values)?;
    assert!(branch.lost.is_none(), "{:?}", branch.lost);
    let mut before = gait.speed;
    for (_, gait) in &branch.gaits {
        assert!(gait.speed > before, "{} after {before}", gait.speed);
        before = gait.speed;
    }
    assert_eq!(branch.gaits.len(), 2);
    Ok(())
}
