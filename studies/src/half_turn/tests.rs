//! Half a turn of a rolling ball as a map.

// What fails here fails the test.
#![allow(clippy::unwrap_used)]

use saltus_gait::space::Stable;
use saltus_robot::{Robot, resolve};

use super::{IN_PLANE, LATERAL, Roller, State};

/// Time step (s).
const STEP: f64 = 2e-4;

fn twelve() -> Robot {
    resolve("rats-twelve", &[]).unwrap()
}

fn roller() -> (Roller, State) {
    let roller = Roller::new(&twelve(), &Stable::default(), STEP).unwrap();
    let start = roller.periodic().unwrap().unwrap();
    (roller, start)
}

#[test]
fn half_a_turn_is_the_same_from_the_opposite_leg() {
    let (roller, mut start) = roller();
    start.lateral = [0.1, 0.2, 0.003, 0.01, 0.05, -0.02];
    let one = roller.half_turn(&start, 1e-3).unwrap().unwrap().0;
    let other = roller.opposite();
    let two = other.half_turn(&start, 1e-3).unwrap().unwrap().0;
    for (a, b) in one
        .in_plane
        .iter()
        .chain(&one.lateral)
        .zip(two.in_plane.iter().chain(&two.lateral))
    {
        assert!((a - b).abs() < 1e-7, "{one:?} {two:?}");
    }
    // So the map of a whole turn is this one twice, and a start mirrored in the plane ends mirrored.
    let mut mirrored = start;
    mirrored.lateral = start.lateral.map(|x| -x);
    let end = other.half_turn(&mirrored, -1e-3).unwrap().unwrap().0;
    for (a, b) in two.lateral.iter().zip(end.lateral) {
        assert!((a + b).abs() < 1e-7, "{two:?} {end:?}");
    }
}

#[test]
fn a_plain_roll_repeats_and_pays_for_what_it_loses() {
    let (roller, start) = roller();
    let (mut state, mut work, mut lost) = (start, 0.0, 0.0);
    for _ in 0..8 {
        let (next, cost) = roller.half_turn(&state, 0.0).unwrap().unwrap();
        work += cost.work;
        lost += cost.legs + cost.ground + cost.stops;
        assert!(next.lateral.iter().all(|x| x.abs() < 1e-9), "{next:?}");
        assert!(
            (next.in_plane[3] / start.in_plane[3] - 1.0).abs() < 0.02,
            "{next:?}"
        );
        state = next;
    }
    assert!((lost / work - 1.0).abs() < 0.05, "{work} {lost}");
}

#[test]
fn what_does_not_matter_is_neutral_and_small_rolls_come_back() {
    let (roller, start) = roller();
    let slopes = roller.slopes(&start, 0.05).unwrap().unwrap();
    assert!(slopes.neutral() < 1e-5, "{}", slopes.neutral());
    assert!(slopes.mixed < 1e-5, "{}", slopes.mixed);
    let all = slopes.multipliers();
    assert_eq!(all.len(), IN_PLANE + LATERAL);
    let neutral = all
        .iter()
        .filter(|one| (one.value.norm() - 1.0).abs() < 1e-5)
        .count();
    assert_eq!(neutral, 2, "{all:?}");
    // All others come back: with both twins on their rubber the roll is stable.
    assert!(all[2..].iter().all(|one| one.value.norm() < 0.9), "{all:?}");
    // So half a milliradian of roll comes back. Four lift a twin off, and the ball falls.
    let after = |lean: f64| {
        let mut state = start;
        state.lateral[2] = lean;
        for _ in 0..8 {
            match roller.half_turn(&state, 0.0).unwrap() {
                Some((next, _)) if next.lateral[2].abs() < 0.3 => state = next,
                _ => return f64::INFINITY,
            }
        }
        state.lateral[2].abs()
    };
    assert!(after(5e-4) < 5e-5 && after(4e-3) > 0.1);
}

/// The regulator makes the map that it is for stable, as the theory says; with no twins it would not be.
#[test]
fn the_regulator_holds_the_linear_map() {
    let (roller, start) = roller();
    let slopes = roller.slopes(&start, 1.0).unwrap().unwrap();
    let radius = |matrix: &nalgebra::SMatrix<f64, LATERAL, LATERAL>| {
        let values = matrix.complex_eigenvalues();
        values.iter().map(|value| value.norm()).fold(0.0, f64::max)
    };
    assert!(radius(&slopes.lateral) > 5.0);
    let held = slopes.lateral - slopes.twins * slopes.regulator().transpose();
    assert!(radius(&held) < 1.0, "{}", radius(&held));
    assert!(slopes.reach().iter().all(|one| *one > 0.0));
}

#[test]
fn what_cannot_be_is_refused() {
    let refused = |robot: &Robot, step: f64| {
        Roller::new(robot, &Stable::default(), step)
            .unwrap_err()
            .to_string()
    };
    assert!(refused(&twelve(), 1e-7).contains("time step"));
    assert!(refused(&twelve(), f64::NAN).contains("time step"));
    let flat = resolve("rats-run", &[]).unwrap();
    assert!(refused(&flat, STEP).contains("of a robot in space"));
}
