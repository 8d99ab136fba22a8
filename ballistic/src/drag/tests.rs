//! Drag against closed forms, the vacuum, energy, tiny steps and finite differences.

use proptest::prelude::*;
use saltus_numeric::{Dual, Scalar};

use super::*;
use crate::ExtendedLeg;
use crate::check::{check_slopes, close, config, dual};
use crate::path::Path;

const HOP: Flight<f64> = Flight {
    x: 0.0,
    y: 1.0,
    vx: 2.0,
    vy: 4.0,
    gravity: 9.8,
};

fn block(low: [f64; 2], high: [f64; 2]) -> Obstacle {
    Obstacle::block(low, high).unwrap()
}

/// Flights of a robot, and drags from a ball of lead's to a feather's.
fn flights() -> impl Strategy<Value = DragFlight<f64>> {
    (
        -1.0..1.0,
        0.3..2.0,
        -8.0..8.0,
        -6.0..6.0,
        1.0..20.0,
        -4.0..1.0_f64,
    )
        .prop_map(|(x, y, vx, vy, gravity, magnitude)| DragFlight {
            vacuum: Flight {
                x,
                y,
                vx,
                vy,
                gravity,
            },
            drag: 10_f64.powf(magnitude),
        })
}

#[test]
fn bad_questions_say_why() {
    let flight = DragFlight {
        vacuum: HOP,
        drag: 0.1,
    };
    assert!(
        matches!(flight.time_to_height(9.0), Err(FlightError::AboveApex { apex, .. }) if apex < 1.82)
    );
    let negative = DragFlight {
        drag: -1.0,
        ..flight
    }
    .time_to_height(0.0);
    assert_eq!(negative, Err(FlightError::BadDrag { drag: -1.0 }));
    let early = flight.clearance(&Disc::wheel(0.2), &block([0.0, 0.0], [1.0, 0.5]), -0.1, 1.0);
    assert_eq!(early, Err(FlightError::BeforeLiftOff { time: -0.1 }));
    assert!(flight.position(-0.1)[0].is_nan());
    let rising = DragFlight {
        vacuum: Flight {
            gravity: 0.0,
            ..HOP
        },
        ..flight
    };
    assert_eq!(rising.apex_height(), f64::INFINITY);
    assert_eq!(
        rising.time_to_height(0.0),
        Err(FlightError::NoGravity {
            height: 0.0,
            speed: 4.0
        })
    );
    // So fast that its square is no number any more.
    let fast = DragFlight {
        vacuum: Flight { vy: 1e200, ..HOP },
        ..flight
    };
    assert!(matches!(
        fast.time_to_height(0.0),
        Err(FlightError::NotFinite { .. })
    ));
}

/// Up and down through the apex, where |v| v has a kink.
fn check_vertical_jump(drag: f64, gravity: f64, vy: f64) {
    let terminal = f64::sqrt(gravity / drag);
    let flight = DragFlight {
        vacuum: Flight {
            x: 0.0,
            y: 1.0,
            vx: 0.0,
            vy,
            gravity,
        },
        drag,
    };
    let (apex, rise) = (flight.apex_height(), flight.apex_time());
    assert!(close(
        apex,
        1.0 + (vy / terminal).powi(2).ln_1p() / (2.0 * drag),
        1e-12
    ));
    assert!(close(
        rise,
        terminal / gravity * (vy / terminal).atan(),
        1e-12
    ));
    let fall = vy / gravity;
    let height = apex - (gravity * fall / terminal).cosh().ln() / drag;
    assert!(close(flight.position(rise + fall)[1], height, 1e-12));
    // The well-known speed back at the height of lift-off, v / √(1 + v²/v_t²).
    let down = flight.velocity(flight.time_to_height(1.0).unwrap())[1];
    assert!(close(
        down,
        -vy / (1.0 + (vy / terminal).powi(2)).sqrt(),
        1e-12
    ));
}

#[test]
fn vertical_jumps_that_steps_across_the_apex_got_wrong() {
    check_vertical_jump(
        0.283_457_439_187_988_7,
        9.267_007_540_876_671,
        5.966_996_482_718_977,
    );
    check_vertical_jump(
        7.523_427_566_230_847,
        1.344_922_813_793_219,
        3.724_619_374_048_160_6,
    );
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn no_drag_is_vacuum_bit_for_bit(flight in flights(), t in 0.0..1.0, low in -1.0..1.0) {
        let vacuum = flight.vacuum;
        let still = DragFlight { drag: 0.0, ..flight };
        let (disc, obstacle) = (Disc::wheel(0.2), block([low, 0.0], [low + 0.3, 0.5]));
        prop_assert_eq!(still.position(t), vacuum.position(t));
        prop_assert_eq!(still.velocity(t), vacuum.velocity(t));
        prop_assert_eq!(still.apex_height(), vacuum.apex_height());
        prop_assert_eq!(still.apex_time(), vacuum.apex_time());
        prop_assert_eq!(still.time_to_height(0.2), vacuum.time_to_height(0.2));
        prop_assert_eq!(still.range_to_height(0.2), vacuum.range_to_height(0.2));
        prop_assert_eq!(still.clearance(&disc, &obstacle, 0.0, t), vacuum.clearance(&disc, &obstacle, 0.0, t));
    }

    #[test]
    fn a_drop_is_that_of_the_closed_form(drag in 1e-3..10.0_f64, gravity in 1.0..20.0_f64, t in 0.0..3.0_f64) {
        let terminal = f64::sqrt(gravity / drag);
        let vacuum = Flight { x: 0.0, y: 1.0, vx: 0.0, vy: 0.0, gravity };
        let flight = DragFlight { vacuum, drag };
        let height = 1.0 - (gravity * t / terminal).cosh().ln() / drag;
        prop_assert!(close(flight.velocity(t)[1], -terminal * (gravity * t / terminal).tanh(), 1e-12));
        prop_assert!(close(flight.position(t)[1], height, 1e-12));
        // A height given to round-off fixes the time only to ε/(g t).
        prop_assert!(t < 1e-2 || close(flight.time_to_height(height).unwrap(), t, 1e-12));
    }

    #[test]
    fn a_vertical_jump_is_that_of_the_closed_form(
        drag in 1e-3..10.0_f64, gravity in 1.0..20.0_f64, vy in 0.1..10.0_f64,
    ) {
        check_vertical_jump(drag, gravity, vy);
    }

    #[test]
    fn without_gravity_it_coasts_straight(drag in 1e-3..10.0_f64, (vx, vy) in (-5.0..5.0_f64, -5.0..-0.5_f64), t in 0.0..3.0_f64) {
        let vacuum = Flight { x: 0.0, y: 1.0, vx, vy, gravity: 0.0 };
        let flight = DragFlight { vacuum, drag };
        let speed = f64::hypot(vx, vy);
        let way = (drag * speed * t).ln_1p() / drag;
        let [x, y] = flight.position(t);
        prop_assert!(close(x, vx / speed * way, 1e-12) && close(y, 1.0 + vy / speed * way, 1e-12));
        prop_assert!(close(flight.range_to_height(0.5).unwrap(), -0.5 * vx / vy, 1e-12));
    }

    #[test]
    fn energy_falls(flight in flights()) {
        let mut last = f64::INFINITY;
        for i in 0..50 {
            let t = 0.02 * f64::from(i);
            let ([_, y], [vx, vy]) = (flight.position(t), flight.velocity(t));
            let energy = 0.5 * (vx * vx + vy * vy) + flight.vacuum.gravity * y;
            // Steps are good to 1e-13 of what may be 1e2.
            prop_assert!(energy <= last + 1e-11, "{energy} after {last} at {t}");
            last = energy;
        }
    }

    #[test]
    fn the_vacuum_is_the_limit_and_the_bound(flight in flights()) {
        // Near the top a height to round-off is no range to round-off.
        prop_assume!(flight.vacuum.vx.abs() > 0.1 && flight.vacuum.vy.abs() > 0.1);
        let flight = DragFlight { vacuum: Flight { x: 0.0, ..flight.vacuum }, ..flight };
        let height = flight.vacuum.y;
        let vacuum = flight.vacuum.range_to_height(height);
        match (flight.range_to_height(height), vacuum) {
            (Ok(range), Ok(vacuum)) => prop_assert!(range.abs() <= vacuum.abs()),
            (range, vacuum) => prop_assert!(range.is_err() == vacuum.is_err()),
        }
        prop_assert!(flight.apex_height() <= flight.vacuum.apex_height());
        // Half the drag, half the loss, but for the second order.
        let below = height - 1.0;
        let loss = |drag: f64| {
            DragFlight { drag, ..flight }.range_to_height(below).unwrap() - flight.vacuum.range_to_height(below).unwrap()
        };
        prop_assert!(close(loss(1e-4) / loss(5e-5), 2.0, 1e-2));
    }

    #[test]
    fn a_mirror_mirrors(flight in flights()) {
        let Flight { x, vx, .. } = flight.vacuum;
        let mirrored = DragFlight { vacuum: Flight { x: -x, vx: -vx, ..flight.vacuum }, ..flight };
        prop_assert_eq!(flight.range_to_height(0.2).unwrap(), -mirrored.range_to_height(0.2).unwrap());
    }

    #[test]
    fn froude_scaling(flight in flights(), scale in 0.1..10.0_f64) {
        let Flight { x, y, vx, vy, gravity } = flight.vacuum;
        let speed = scale.sqrt();
        let vacuum = Flight { x: x * scale, y: y * scale, vx: vx * speed, vy: vy * speed, gravity };
        let scaled = DragFlight { vacuum, drag: flight.drag / scale };
        let range = scaled.range_to_height(0.1 * scale).unwrap() / scale;
        // A step's tolerance is relative to 1 m and 1 m/s, whatever the scale, so that the steps
        // differ.
        prop_assert!(close(range, flight.range_to_height(0.1).unwrap(), 1e-12));
    }

    #[test]
    fn tiny_steps_come_to_the_same(flight in flights(), low in -1.0..1.0, wide in 0.1..0.5, high in 0.1..1.5) {
        let obstacle = block([low, 0.0], [low + wide, high]);
        let to = flight.time_to_height(0.1).unwrap();
        let found = flight.clearance(&Disc::wheel(0.2), &obstacle, 0.0, to).unwrap();
        let points: Vec<_> = flight.samples(0.0, to, 1000).map(|(_, x, y)| [x, y]).collect();
        let step = points.windows(2).map(|p| (p[1][0] - p[0][0]).hypot(p[1][1] - p[0][1])).fold(0.0, f64::max);
        let least = points.iter().map(|&p| obstacle.nearest(p).1).fold(f64::INFINITY, f64::min) - 0.2;
        prop_assert!(found <= least + 1e-8, "{found}, but a sample at {least}");
        prop_assert!(found >= least - step, "{found}, but the samples stay above {least}");
    }

    #[test]
    fn arcs_keep_to_the_path(flight in flights()) {
        let track = Track::new(&flight, 1.0);
        for arc in track.arcs(0.0, 1.0) {
            let [from, to] = arc.span;
            for share in [0.2, 0.8] {
                let t = from + share * (to - from);
                let [x, y] = track.node(t).position();
                let miss = (arc.x.at(t - arc.start) - x).hypot(arc.y.at(t - arc.start) - y);
                prop_assert!(miss < 1e-8, "{miss} at {t} on {arc:?}");
            }
        }
    }

    #[test]
    fn slopes_are_those_of_finite_differences(flight in flights(), t in 0.1..1.0) {
        // Differences must stay clear of vy = 0, where the functions bend.
        prop_assume!(flight.vacuum.vy.abs() > 0.1);
        let d = DragFlight { vacuum: dual(flight.vacuum), drag: Dual::of(flight.drag) };
        let of = Dual::of;
        let with = |vacuum| DragFlight { vacuum, ..flight };
        for i in 0..2 {
            check_slopes(flight.vacuum, d.position(of(t))[i], |f| with(f).position(t)[i]);
            check_slopes(flight.vacuum, d.velocity(of(t))[i], |f| with(f).velocity(t)[i]);
        }
        check_slopes(flight.vacuum, d.apex_height(), |f| with(f).apex_height());
        check_slopes(flight.vacuum, d.apex_time(), |f| with(f).apex_time());
        check_slopes(flight.vacuum, d.time_to_height(of(0.1)).unwrap(), |f| with(f).time_to_height(0.1).unwrap());
        check_slopes(flight.vacuum, d.range_to_height(of(0.1)).unwrap(), |f| with(f).range_to_height(0.1).unwrap());
    }

    #[test]
    fn slopes_along_drag_and_time(flight in flights(), t in 0.1..1.0) {
        let constant = |f: f64| Dual::<2>::of(f);
        let Flight { x, y, vx, vy, gravity } = flight.vacuum;
        let [x, y, vx, vy, gravity] = [x, y, vx, vy, gravity].map(constant);
        let vacuum = Flight { x, y, vx, vy, gravity };
        let d = DragFlight { vacuum, drag: Dual::variable(flight.drag, 0) };
        let h = 1e-2 * flight.drag;
        let range = |drag: f64| DragFlight { drag, ..flight }.range_to_height(0.1).unwrap();
        let central = |h: f64| (range(flight.drag + h) - range(flight.drag - h)) / (2.0 * h);
        let numeric = (4.0 * central(h / 2.0) - central(h)) / 3.0;
        // Round-off 1e-13 over steps down to 1e-6.
        prop_assert!(close(d.range_to_height(constant(0.1)).unwrap().slope[0], numeric, 1e-6));
        let position = d.position(Dual::variable(t, 1));
        for (position, velocity) in position.into_iter().zip(flight.velocity(t)) {
            prop_assert!(close(position.slope[1], velocity, 1e-10));
        }
    }
}

#[test]
fn a_drop_from_rest_has_slopes() {
    let vacuum = Flight {
        vx: 0.0,
        vy: 0.0,
        ..HOP
    };
    let d = DragFlight {
        vacuum: dual(vacuum),
        drag: Dual::of(0.1),
    };
    for i in 0..2 {
        let at = |vacuum| DragFlight { vacuum, drag: 0.1 }.position(0.3)[i];
        check_slopes(vacuum, d.position(Dual::of(0.3))[i], at);
    }
}

#[test]
fn slopes_of_clearance() {
    let with = |vacuum| DragFlight { vacuum, drag: 0.1 };
    let d = DragFlight {
        vacuum: dual(HOP),
        drag: Dual::of(0.1),
    };
    let of = Dual::of;
    let check = |obstacle: Obstacle| {
        let exact = d
            .clearance(&Disc::wheel(of(0.2)), &obstacle, of(0.0), of(0.7))
            .unwrap();
        let clearance = |f: Flight<f64>| {
            with(f)
                .clearance(&Disc::wheel(0.2), &obstacle, 0.0, 0.7)
                .unwrap()
        };
        check_slopes(HOP, exact, clearance);
    };
    // A corner, a side, the end, a tie inside.
    check(block([1.0, 0.0], [1.2, 1.2]));
    check(block([-9.0, 2.5], [9.0, 3.0]));
    check(block([3.0, 0.0], [4.0, 2.0]));
    check(block([0.5, 0.0], [1.2, 2.2]));
}

#[test]
fn the_leg_counts_until_it_is_in() {
    let flight = DragFlight {
        vacuum: HOP,
        drag: 0.1,
    };
    let disc = Disc {
        radius: 0.2,
        leg: Some(ExtendedLeg {
            reach: 0.3,
            until: 0.2,
        }),
    };
    let ceiling = block([-9.0, 2.5], [9.0, 3.0]);
    let found = flight.clearance(&disc, &ceiling, 0.0, 1.0).unwrap();
    assert!(close(found, 2.3 - flight.apex_height(), 1e-14));
}
