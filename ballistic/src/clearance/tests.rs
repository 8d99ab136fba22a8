//! Clearance against closed forms, dense sampling and finite differences.

use proptest::prelude::*;
use saltus_numeric::{Dual, Scalar};

use super::*;
use crate::DragFlight;
use crate::check::{check_slopes, close, config, dual};

const HOP: Flight<f64> = Flight {
    x: 0.0,
    y: 1.0,
    vx: 1.0,
    vy: 4.0,
    gravity: 8.0,
};

fn block(low: [f64; 2], high: [f64; 2]) -> Obstacle {
    Obstacle::block(low, high).unwrap()
}

#[test]
fn closed_forms() {
    let check = |flight: Flight<f64>, low: [f64; 2], high: [f64; 2], to: f64, expected: f64| {
        let found = flight
            .clearance(&Disc::wheel(0.25), &block(low, high), 0.0, to)
            .unwrap();
        assert!((found + 0.25 - expected).abs() < 1e-15, "{found}");
    };
    // The parabola y = 2 − 4 (x − 1/2)² is nearest to a low box at the start.
    check(HOP, [0.25, 0.0], [0.75, 0.5], 1.0, 0.25 * 5_f64.sqrt());
    // Under a ceiling that the apex comes nearest to.
    check(HOP, [-9.0, 2.5], [9.0, 3.0], 1.0, 0.5);
    // Into a wall, and out: the deepest point is where the top is as far as the side.
    let still = Flight {
        gravity: 0.0,
        vy: 0.0,
        ..HOP
    };
    check(still, [0.5, 0.0], [9.0, 2.0], 0.75, -0.25);
    check(still, [0.5, 0.0], [1.5, 1.125], 2.0, -0.125);
    // Steeply through a long slab: top and bottom. No distance is level inside; only the crossing
    // tells that there is one.
    let steep = Flight {
        x: 3.0,
        y: 4.5,
        vx: 0.5,
        vy: -1.0,
        gravity: 0.0,
    };
    check(steep, [0.0, 0.0], [10.0, 1.0], 8.0, -0.5);
    // A straight, a vertical and no motion past a corner.
    check(still, [2.0, 0.0], [3.0, 0.5], 9.0, 0.5);
    let up = Flight { vx: 0.0, ..HOP };
    check(up, [1.0, 0.0], [2.0, 0.5], 1.0, 1.25_f64.sqrt());
    let rest = Flight { vx: 0.0, ..still };
    check(rest, [3.0, 0.0], [4.0, 1.0], 1.0, 3.0);
    // No time at all.
    check(HOP, [3.0, 0.0], [4.0, 1.0], 0.0, 3.0);
}

#[test]
fn the_leg_counts_until_it_is_in() {
    let obstacle = block([-9.0, 2.5], [9.0, 3.0]);
    let check = |until: f64, expected: f64| {
        let disc = Disc {
            radius: 0.2,
            leg: Some(ExtendedLeg { reach: 0.3, until }),
        };
        let found = HOP.clearance(&disc, &obstacle, 0.0, 1.0).unwrap();
        assert!(close(found, expected, 1e-15), "{found}");
    };
    check(2.0, 0.2);
    check(0.75, 0.2);
    // The leg is in before the apex; 0.3 there outweighs what it adds earlier.
    check(0.25, 0.3);
    // Just before it is in, at 2 − 0.01 m.
    check(0.45, 0.21);
    check(-1.0, 0.3);
}

#[test]
fn a_span_must_be_one() {
    let obstacle = block([0.0, 0.0], [1.0, 1.0]);
    for (from, to) in [(1.0, 0.0), (0.0, f64::INFINITY), (f64::NAN, 1.0)] {
        let error = HOP
            .clearance(&Disc::wheel(0.2), &obstacle, from, to)
            .unwrap_err();
        assert!(matches!(error, FlightError::EmptySpan { .. }));
    }
}

/// Flights, at times without gravity or without forward speed.
fn jumps() -> impl Strategy<Value = Flight<f64>> {
    let gravity = prop_oneof![4 => 1.0..20.0, 1 => Just(0.0), 1 => Just(1e-9)];
    let vx = prop_oneof![4 => -4.0..4.0, 1 => Just(0.0)];
    (-1.0..1.0, 0.0..1.5, vx, -3.0..5.0, gravity).prop_map(|(x, y, vx, vy, gravity)| Flight {
        x,
        y,
        vx,
        vy,
        gravity,
    })
}

fn boxes() -> impl Strategy<Value = Obstacle> {
    (-1.0..1.0, 0.0..1.5, 0.1..1.0, 0.1..1.0)
        .prop_map(|(x, y, wide, high)| block([x, y], [x + wide, y + high]))
}

/// Least gap at `count` evenly spaced times, and the greatest step of the centre between two of
/// them.
fn sampled(
    flight: &Flight<f64>,
    obstacle: &Obstacle,
    from: f64,
    to: f64,
    count: usize,
) -> (f64, f64) {
    let flight = DragFlight {
        vacuum: *flight,
        drag: 0.0,
    };
    let points: Vec<_> = flight
        .samples(from, to, count)
        .map(|(_, x, y)| [x, y])
        .collect();
    let step = points
        .windows(2)
        .map(|p| (p[1][0] - p[0][0]).hypot(p[1][1] - p[0][1]))
        .fold(0.0, f64::max);
    let least = points
        .iter()
        .map(|&p| obstacle.nearest(p).1)
        .fold(f64::INFINITY, f64::min);
    (least, step)
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn no_sample_is_nearer_and_some_are_as_near(
        flight in jumps(), obstacle in boxes(), from in 0.0..0.5, length in 0.0..1.0,
    ) {
        let to = from + length;
        let found = flight.clearance(&Disc::wheel(0.0), &obstacle, from, to).unwrap();
        let (least, step) = sampled(&flight, &obstacle, from, to, 2000);
        prop_assert!(found <= least + 1e-14, "{found}, but a sample at {least}");
        // A distance changes by no more than the centre moves.
        prop_assert!(found >= least - step, "{found}, but the samples stay above {least}");
    }

    #[test]
    fn a_mirror_changes_nothing(flight in jumps(), low in -1.0..1.0, wide in 0.1..1.0, high in 0.1..1.0) {
        let mirrored = Flight { x: -flight.x, vx: -flight.vx, ..flight };
        let here = flight.clearance(&Disc::wheel(0.2), &block([low, 0.0], [low + wide, high]), 0.0, 1.0).unwrap();
        let there = block([-low - wide, 0.0], [-low, high]);
        let there = mirrored.clearance(&Disc::wheel(0.2), &there, 0.0, 1.0).unwrap();
        prop_assert!(close(here, there, 1e-14));
    }

    #[test]
    fn slopes_are_those_of_finite_differences(flight in jumps(), obstacle in boxes(), to in 0.2..1.0) {
        // Differences move gravity, which must stay positive.
        let flight = Flight { gravity: flight.gravity.max(1.0), ..flight };
        let disc = Disc::wheel(0.2);
        let clearance = |f: Flight<f64>| f.clearance(&disc, &obstacle, 0.0, to).unwrap();
        let here = clearance(flight);
        // No derivatives where the centre touches a corner, or falls along a side.
        prop_assume!((here + 0.2).abs() > 0.05 && flight.vx != 0.0);
        let of = Dual::of;
        let exact = dual(flight).clearance(&Disc::wheel(of(0.2)), &obstacle, of(0.0), of(to)).unwrap();
        prop_assert!(close(exact.value, here, 1e-14));
        check_slopes(flight, exact, clearance);
    }
}

#[test]
fn slopes_along_the_ends_the_radius_and_the_leg() {
    type D = Dual<4>;
    let [to, radius, reach, until] = [0.45, 0.2, 0.3, 0.4];
    let obstacle = block([-9.0, 2.5], [9.0, 3.0]);
    let of = |f: f64| D::of(f);
    let flight = Flight {
        x: of(0.0),
        y: of(1.0),
        vx: of(1.0),
        vy: of(4.0),
        gravity: of(8.0),
    };
    let slopes = |until: f64| {
        let leg = ExtendedLeg {
            reach: D::variable(reach, 2),
            until: D::variable(until, 3),
        };
        let disc = Disc {
            radius: D::variable(radius, 1),
            leg: Some(leg),
        };
        flight
            .clearance(&disc, &obstacle, of(0.0), D::variable(to, 0))
            .unwrap()
            .slope
    };
    // Upward speed 4 − 8 t at the end, or when the leg is in.
    let check = |until: f64, expected: [f64; 4]| {
        for (slope, expected) in slopes(until).into_iter().zip(expected) {
            assert!(
                (slope - expected).abs() < 1e-12,
                "{slope} instead of {expected}"
            );
        }
    };
    check(until, [0.0, 0.0, -1.0, -0.8]);
    check(0.1, [-0.4, -1.0, 0.0, 0.0]);
    check(0.5, [-0.4, 0.0, -1.0, 0.0]);
}
