//! The parabola against its invariants, its symmetries and finite differences.

use proptest::prelude::*;
use saltus_numeric::{Dual, LANES, Lanes};

use super::*;
use crate::DragFlight;
use crate::check::{check_slopes, close, config, dual, flights};

#[test]
fn known_flights() {
    let check = |flight: Flight<f64>, height: f64, expected: Result<f64, FlightError>| {
        assert_eq!(flight.time_to_height(height), expected);
    };
    let base = Flight {
        x: 0.0,
        y: 1.0,
        vx: 3.0,
        vy: 0.0,
        gravity: 8.0,
    };
    check(base, 0.0, Ok(0.5));
    check(base, 1.0, Ok(0.0));
    check(
        base,
        2.0,
        Err(FlightError::AboveApex {
            height: 2.0,
            apex: 1.0,
        }),
    );
    check(Flight { vy: 4.0, ..base }, 1.0, Ok(1.0));
    check(Flight { vy: 4.0, ..base }, 2.0, Ok(0.5));
    check(Flight { vy: -3.0, ..base }, 0.0, Ok(0.25));
    // The parabola was that high, but before lift-off.
    check(
        Flight { vy: -4.0, ..base },
        1.5,
        Err(FlightError::AboveApex {
            height: 1.5,
            apex: 1.0,
        }),
    );
}

#[test]
fn without_gravity() {
    let rising = Flight {
        x: 0.0,
        y: 1.0,
        vx: 3.0,
        vy: 2.0,
        gravity: 0.0,
    };
    assert_eq!(rising.apex_height(), f64::INFINITY);
    assert_eq!(
        rising.time_to_height(0.0),
        Err(FlightError::NoGravity {
            height: 0.0,
            speed: 2.0
        })
    );
    let level = Flight { vy: 0.0, ..rising };
    assert_eq!(level.apex_height(), 1.0);
    assert_eq!(
        level.time_to_height(0.0),
        Err(FlightError::NoGravity {
            height: 0.0,
            speed: 0.0
        })
    );
    let falling = Flight { vy: -2.0, ..rising };
    assert_eq!(falling.range_to_height(0.0), Ok(1.5));
}

#[test]
fn numbers_that_are_none_are_named() {
    let flight = Flight {
        x: 0.0,
        y: f64::NAN,
        vx: 1.0,
        vy: 1.0,
        gravity: 9.8,
    };
    assert!(matches!(
        flight.time_to_height(0.0),
        Err(FlightError::NotFinite { .. })
    ));
    let deep = Flight { y: 0.0, ..flight }.time_to_height(f64::NEG_INFINITY);
    assert_eq!(
        deep,
        Err(FlightError::HeightNotFinite {
            height: f64::NEG_INFINITY
        })
    );
}

#[test]
fn the_later_root_keeps_its_digits_where_the_textbook_formula_loses_them() {
    // Falling fast, 1e-9 m above the ground: t = h/v (1 − g h/(2 v²)) to second order.
    let flight = Flight {
        x: 0.0,
        y: 1e-9,
        vx: 0.0,
        vy: -40.0,
        gravity: 9.8,
    };
    let expected = 1e-9 / 40.0 * (1.0 - 9.8e-9 / 3200.0);
    let time = flight.time_to_height(0.0).unwrap();
    assert!(
        (time / expected - 1.0).abs() < 1e-15,
        "{time} instead of {expected}"
    );
}

#[test]
fn flights_side_by_side_are_the_same() {
    let [vy, heights] = [
        [-3.0, -1.0, 0.0, 0.5, 1.0, 2.0, 3.0, 4.0],
        [0.9, 0.5, 0.1, 1.5, 0.0, 1.0, 0.2, -1.0],
    ];
    let of = Lanes::of;
    let first = |all: [f64; 8]| Lanes::from(std::array::from_fn::<f64, LANES, _>(|i| all[i]));
    let lanes = Flight {
        x: of(0.0),
        y: of(1.0),
        vx: of(2.0),
        vy: first(vy),
        gravity: of(9.8),
    };
    let (apex, time) = (lanes.apex_height(), lanes.descent_time(first(heights)));
    for i in 0..LANES {
        let flight = Flight {
            x: 0.0,
            y: 1.0,
            vx: 2.0,
            vy: vy[i],
            gravity: 9.8,
        };
        assert_eq!(apex.to_array()[i], flight.apex_height());
        let one = flight.descent_time(heights[i]);
        // Out of reach is not a number in both.
        assert!(time.to_array()[i] == one || one.is_nan() && time.to_array()[i].is_nan());
    }
}

#[test]
fn samples_include_both_ends() {
    let vacuum = Flight {
        x: 0.0,
        y: 1.0,
        vx: 3.0,
        vy: 4.0,
        gravity: 8.0,
    };
    let flight = DragFlight { vacuum, drag: 0.0 };
    let points: Vec<_> = flight.samples(0.0, 1.0, 3).collect();
    assert_eq!(points, [(0.0, 0.0, 1.0), (0.5, 1.5, 2.0), (1.0, 3.0, 1.0)]);
    assert_eq!(flight.samples(0.25, 1.0, 1).next().map(|p| p.0), Some(0.25));
    assert_eq!(flight.samples(0.0, 1.0, 0).count(), 0);
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn energy_is_conserved(flight in flights(), t in 0.0..10.0) {
        let energy = |t| {
            let ([_, y], [vx, vy]) = (flight.position(t), flight.velocity(t));
            [vx * vx / 2.0, vy * vy / 2.0, flight.gravity * y]
        };
        // Round-off of the largest term.
        let scale = energy(t).iter().fold(1.0_f64, |a, b| a.max(b.abs()));
        prop_assert!((energy(t).iter().sum::<f64>() - energy(0.0).iter().sum::<f64>()).abs() <= 1e-13 * scale);
    }

    #[test]
    fn apex_is_the_highest_point(flight in flights(), t in 0.0..10.0) {
        let apex = flight.apex_height();
        prop_assert!(apex >= flight.y);
        prop_assert!(close(flight.position(flight.apex_time())[1], apex, 1e-14));
        prop_assert!(flight.position(t)[1] <= apex + 1e-13 * apex.abs().max(1.0));
    }

    #[test]
    fn comes_down_at_the_height_asked_for(flight in flights(), share in 0.0..1.0) {
        let height = flight.apex_height() - share * 20.0;
        match flight.time_to_height(height) {
            Ok(t) => {
                prop_assert!(close(flight.position(t)[1], height, 1e-12));
                prop_assert!(flight.velocity(t)[1] <= 1e-7);
            }
            Err(error) => prop_assert!(height > flight.apex_height(), "{error}"),
        }
    }

    #[test]
    fn the_apex_itself_is_reached(flight in flights()) {
        let time = flight.time_to_height(flight.apex_height()).unwrap();
        // A height's round-off ε moves the time by √(2ε/g).
        let slack = (4.0 * f64::EPSILON * flight.apex_height().abs().max(1.0) / flight.gravity).sqrt();
        prop_assert!((time - flight.apex_time()).abs() <= 4.0 * slack);
    }

    #[test]
    fn a_mirror_mirrors_the_range(flight in flights()) {
        let height = flight.y - 1.0;
        let mirrored = Flight { x: -flight.x, vx: -flight.vx, ..flight };
        prop_assert_eq!(flight.range_to_height(height).unwrap(), -mirrored.range_to_height(height).unwrap());
    }

    #[test]
    fn time_runs_both_ways(flight in flights(), t in 0.0..5.0) {
        let ([x, y], [vx, vy]) = (flight.position(t), flight.velocity(t));
        let back = Flight { x, y, vx: -vx, vy: -vy, ..flight };
        let [x, y] = back.position(t);
        // Positions reach 1e3 m and take that round-off.
        prop_assert!((x - flight.x).abs() < 1e-11 && (y - flight.y).abs() < 1e-11);
    }

    #[test]
    fn a_moving_observer_sees_the_same_flight(flight in flights(), (u, w) in (-9.0..9.0_f64, -9.0..9.0_f64), t in 0.0..5.0_f64) {
        let seen = Flight { vx: flight.vx - u, vy: flight.vy - w, ..flight };
        let ([x, y], [seen_x, seen_y]) = (flight.position(t), seen.position(t));
        prop_assert!((x - seen_x - u * t).abs() < 1e-11 && (y - seen_y - w * t).abs() < 1e-11);
    }

    #[test]
    fn froude_scaling(flight in flights(), scale in 0.01..100.0_f64) {
        let speed = scale.sqrt();
        let scaled = Flight {
            x: flight.x * scale,
            y: flight.y * scale,
            vx: flight.vx * speed,
            vy: flight.vy * speed,
            gravity: flight.gravity,
        };
        let height = flight.y - 1.0;
        let range = flight.range_to_height(height).unwrap();
        prop_assert!(close(scaled.range_to_height(height * scale).unwrap() / scale, range, 1e-11));
        prop_assert!(close(scaled.apex_height() / scale, flight.apex_height(), 1e-13));
    }

    #[test]
    fn units_do_not_matter(flight in flights(), metre in 0.01..100.0, second in 0.01..100.0) {
        let speed = metre / second;
        let other = Flight {
            x: flight.x * metre,
            y: flight.y * metre,
            vx: flight.vx * speed,
            vy: flight.vy * speed,
            gravity: flight.gravity * speed / second,
        };
        let height = flight.y - 1.0;
        let time = flight.time_to_height(height).unwrap();
        prop_assert!(close(other.time_to_height(height * metre).unwrap() / second, time, 1e-12));
        prop_assert!(close(other.apex_height() / metre, flight.apex_height(), 1e-13));
    }

    #[test]
    fn slopes_are_those_of_finite_differences(
        // Differences must stay clear of vy = 0 and of the apex, where the functions bend.
        (x, y, vx, vy, gravity) in (-1.0..1.0, 0.3..2.0, -5.0..5.0, 0.5..5.0_f64, 3.0..20.0),
        down in any::<bool>(),
        t in 0.0..1.0,
    ) {
        let flight = Flight { x, y, vx, vy: if down { -vy } else { vy }, gravity };
        let d = dual(flight);
        let of = Dual::of;
        for i in 0..2 {
            check_slopes(flight, d.position(of(t))[i], |f| f.position(t)[i]);
            check_slopes(flight, d.velocity(of(t))[i], |f| f.velocity(t)[i]);
        }
        check_slopes(flight, d.apex_height(), |f| f.apex_height());
        check_slopes(flight, d.apex_time(), |f| f.apex_time());
        check_slopes(flight, d.descent_time(of(0.1)), |f| f.descent_time(0.1));
        check_slopes(flight, d.time_to_height(of(0.1)).unwrap(), |f| f.time_to_height(0.1).unwrap());
        check_slopes(flight, d.range_to_height(of(0.1)).unwrap(), |f| f.range_to_height(0.1).unwrap());
    }
}

#[test]
fn distance_to_a_corner_is_the_clearance_of_a_box_passed_above() {
    let flight = Flight {
        x: 0.02,
        y: 0.3,
        vx: 1.4,
        vy: 2.6,
        gravity: 9.8,
    };
    let landing = flight.time_to_height(0.24).unwrap();
    for x in [0.2, 0.4, 0.7] {
        // A box that begins or ends at x is nearest with one of its corners.
        let block = crate::Obstacle::block([x, 0.0], [x + 1e-9, 0.2]).unwrap();
        let clearance = flight
            .clearance(&crate::Disc::wheel(0.0), &block, 0.0, landing)
            .unwrap();
        let distance = flight.distance_to_point([x, 0.2], 0.0, landing);
        // The box is a nanometre wide.
        assert!(
            (distance - clearance).abs() < 2e-9,
            "{x}: {distance} {clearance}"
        );
    }
}

#[test]
fn distance_to_a_point_has_exact_derivatives() {
    let at = |v: [f64; 4]| {
        let [x, y, vx, vy] = std::array::from_fn(|i| Dual::<4>::variable(v[i], i));
        let flight = Flight {
            x,
            y,
            vx,
            vy,
            gravity: Dual::of(9.8),
        };
        let landing = flight.time_to_height(Dual::of(0.24)).unwrap();
        // The second point is nearest at the landing, whose time depends on everything.
        [[0.4, 0.2], [3.0, 0.0]]
            .map(|point| flight.distance_to_point(point, Dual::of(0.0), landing))
    };
    let start = [0.02, 0.3, 1.4, 2.6];
    for i in 0..4 {
        let shifted = |h: f64| {
            at(std::array::from_fn(|k| {
                start[k] + if k == i { h } else { 0.0 }
            }))
        };
        let (up, down, here) = (shifted(1e-5), shifted(-1e-5), at(start));
        for k in 0..2 {
            let difference = (up[k].value - down[k].value) / 2e-5;
            // Central differences: 1e-10 of curvature, 1e-16/1e-5 of round-off.
            assert!(
                (here[k].slope[i] - difference).abs() < 1e-8,
                "{i} {k}: {:?} {difference}",
                here[k]
            );
        }
    }
}
