//! An obstacle ahead: what the table says where, how the distance is carried on, and the run-up.

// Counts are made of doubles.

use std::f64::consts::TAU;

use saltus_controller::Axis;
use saltus_controller::run::{
    Action, Ahead, Gait, Instruments, Knot, Law, Readings, Runner, Stall,
};

/// Counts of a turn of the wheel, and way (m) of a count of the boom.
const TURN: i32 = 800;
const WAY: f64 = 1e-3;

/// By the law: at 0.1 rad for 40 ms.
const LAW: [Knot<f64>; 1] = [Knot {
    rate: 0.0,
    firing_angle: 0.1,
    valve_open: 0.04,
}];
/// Not at all; at 0.2 rad for 30 ms; a jump at −0.2 rad for 100 ms.
const CHOICES: [[f64; 2]; 3] = [[0.6, 0.0], [0.2, 0.03], [-0.2, 0.1]];
/// Rates 0 to 4 and 4 to 8 rad/s; heights below and above 50 mm; distances −0.5 to 0.5, to 1.5 and to
/// 2.5 m.
const CELLS: [u8; 12] = [0, 1, 1, 0, 0, 0, 0, 2, 1, 1, 0, 2];

fn ahead(room: f64) -> Ahead<'static, f64> {
    Ahead {
        way: WAY,
        climb: 1e-3,
        least_weight: 0.1,
        same: 0.3,
        room,
        rates: Axis::new(0.0, 8.0, 3),
        heights: Axis::new(0.0, 0.1, 3),
        distances: Axis::new(-0.5, 2.5, 4),
        cells: &CELLS,
        choices: &CHOICES,
        first_leap: 2,
    }
}

fn gait(room: f64) -> Gait<'static, f64> {
    Gait {
        law: Law::Lines(&LAW),
        zone: -0.5,
        legs: 5,
        period: 1e-3,
        instruments: Instruments {
            wheel: TAU / f64::from(TURN),
            wheel_turn: TURN,
            radius: 1.0,
            pivot: 1.0,
            fine_gyro: 1e-3,
            fine_limit: 30000,
            coarse_gyro: 1.0,
            fine_accelerometer: 1.0,
            accelerometer_limit: 30000,
        },
        taps: &[1.0],
        hold: None,
        stall: Stall {
            rate: 0.5,
            time: 0.1,
            restarts: true,
        },
        first: &[],
        leap: None,
        ahead: Some(ahead(room)),
    }
}

/// The wheel at `wheel`, which turns at `rate` (rad/s), the boom at `radius`.
fn readings(wheel: i32, radius: i32, rate: f64) -> Readings {
    Readings {
        wheel,
        radius,
        fine_gyro: (rate * 1e3) as i32,
        ..Readings::default()
    }
}

/// Angle and opening time with which leg 1 fires, if it does, where it enters the zone at `rate`
/// (rad/s), `distance` (m) from the obstacle.
fn fires(rate: f64, distance: f64) -> Option<[f64; 2]> {
    let mut runner = Runner::new(gait(0.0), 0, 0, true);
    // Leg 0 leans by 36°, 80 counts; leg 1 enters at 0.757 rad, 97 counts, and leaves 160 later.
    for wheel in 0..160 {
        if wheel == 10 {
            runner.sense(distance);
        }
        let action = runner.step(&readings(wheel, 0, rate));
        if wheel > 17 && action.leg == Some(1) {
            return Some([action.firing_angle, action.valve_open]);
        }
    }
    None
}

#[test]
fn each_cell_has_its_choice_and_the_law_holds_beyond() {
    for (rate, distance, should) in [
        (2.0, 0.2, None),
        (2.0, 1.0, Some(CHOICES[1])),
        (6.0, 0.2, None),
        (6.0, 1.4, Some(CHOICES[2])),
        (6.0, 1.6, Some(CHOICES[1])),
        // Beyond the last rate and before the first one, the last cell and the first.
        (29.0, 1.4, Some(CHOICES[2])),
        (-3.0, 1.4, Some(CHOICES[1])),
        // Too far yet, and no reading.
        (6.0, 2.6, Some([0.1, 0.04])),
        (6.0, -1.0, Some([0.1, 0.04])),
        (6.0, 0.0, Some([0.1, 0.04])),
        (6.0, f64::NAN, Some([0.1, 0.04])),
        (6.0, f64::INFINITY, Some([0.1, 0.04])),
    ] {
        assert_eq!(fires(rate, distance), should, "{rate} rad/s, {distance} m");
    }
}

#[test]
fn the_height_of_the_axle_counts_from_the_stand() {
    for (height, distance, should) in [
        (49, 1.0, -0.2),
        (51, 0.2, 0.2),
        (51, 2.0, -0.2),
        (900, 0.2, 0.2),
        (-900, 1.0, -0.2),
    ] {
        let mut runner = Runner::new(gait(0.0), 0, 0, true);
        let pivot = |height: i32, wheel: i32| Readings {
            pivot: i32::MAX.wrapping_add(height),
            ..readings(wheel, 0, 6.0)
        };
        runner.step(&pivot(0, 0));
        runner.sense(distance);
        let angle = runner.step(&pivot(height, 20)).firing_angle;
        assert_eq!(angle, should, "{height} mm, {distance} m");
    }
}

#[test]
fn a_cell_of_no_choice_leaves_it_to_the_law() {
    let mut gait = gait(0.0);
    let bad = [7_u8; 12];
    gait.ahead = Some(Ahead {
        cells: &bad,
        ..ahead(0.0)
    });
    let mut runner = Runner::new(gait, 0, 0, true);
    runner.sense(1.0);
    assert_eq!(runner.step(&readings(0, 0, 2.0)).firing_angle, 0.1);
}

/// The firing angle of leg 1, which enters the zone once all is sensed and the boom is at `radius`.
fn angle_after(sensed: &[f64], radius: i32) -> f64 {
    let mut runner = Runner::new(gait(0.0), 0, 0, true);
    // The rear leg fires by the law, as nothing is seen yet.
    runner.step(&readings(0, 0, 6.0));
    for distance in sensed {
        runner.sense(*distance);
        runner.step(&readings(0, 0, 6.0));
    }
    runner.step(&readings(0, radius, 6.0));
    runner.step(&readings(20, radius, 6.0)).firing_angle
}

#[test]
fn the_encoder_carries_the_distance_on() {
    // From 1.6 m: 90 mm on it is still beyond 1.5 m, and at 110 mm no more.
    assert_eq!(angle_after(&[1.6], 90), 0.2);
    assert_eq!(angle_after(&[1.6], 110), -0.2);
    // Backwards it gets farther.
    assert_eq!(angle_after(&[1.4], -90), -0.2);
    assert_eq!(angle_after(&[1.4], -110), 0.2);
    // Behind, the law holds again.
    assert_eq!(angle_after(&[1.6], 2110), 0.1);
}

#[test]
fn readings_are_averaged_unless_another_obstacle_is_seen() {
    // The mean of 1.4, 1.5 and 1.58 m is 1.4933 m.
    assert_eq!(angle_after(&[1.4, 1.5, 1.58], 0), -0.2);
    assert_eq!(angle_after(&[1.4, 1.5, 1.61], 0), 0.2);
    // 0.3 m and more from what is known, the last one counts.
    assert_eq!(angle_after(&[1.0, 1.0, 1.0, 1.55], 0), 0.2);
    // What is no reading changes nothing.
    assert_eq!(angle_after(&[1.4, f64::NAN, -2.0, 0.0], 0), -0.2);
}

#[test]
fn after_a_jump_no_leg_fires_until_the_obstacle_is_behind() {
    let mut runner = Runner::new(gait(0.0), 0, 0, true);
    runner.sense(1.45);
    let mut fired = Vec::new();
    for cycle in 0..4000 {
        // A wheel that rolls on: 1 mm of way and a third of a count a cycle.
        if cycle == 1600 {
            // The next obstacle, which is seen over the one that is jumped over.
            runner.sense(9.0);
        }
        let action = runner.step(&readings(cycle / 3, cycle, 6.0));
        fired.extend(action.leg.map(|_| (cycle, action.valve_open)));
    }
    assert_eq!(fired[0], (0, 0.1), "the rear leg jumps at once");
    // Behind from 1.95 m on.
    assert!(fired[1].0 > 1950 && fired[1].0 < 1950 + 500, "{fired:?}");
    assert!(fired[1..].iter().all(|(_, open)| *open == 0.04));
}

#[test]
fn a_robot_with_too_little_room_backs_off_first() {
    let mut runner = Runner::new(gait(2.0), 0, 0, true);
    runner.sense(1.2);
    let act = |runner: &mut Runner<'_, f64>, wheel, radius, rate| -> Action<f64> {
        runner.step(&readings(wheel, radius, rate))
    };
    // Backwards the front leg is the rear one, and fires by the law.
    let first = act(&mut runner, 0, 0, 0.0);
    assert_eq!((first.leg, first.valve_open), (Some(1), 0.04));
    let (mut fired, mut last) = (Vec::new(), 0);
    for cycle in 0..1500 {
        let action = act(&mut runner, -cycle, -cycle, -6.0);
        assert!(action.rate > 0.0, "rates count in the direction of the run");
        if action.leg.is_some() {
            fired.push(cycle);
        }
        last = cycle;
    }
    // 0.8 m farther it has room, and no leg fires any more.
    assert!(
        fired.len() >= 3 && fired.iter().all(|at| *at < 800),
        "{fired:?}"
    );
    // It comes to stand on two feet and turns; 2.7 m away, the law holds yet.
    let wheel = -(last / 160) * 160;
    let mut firings = Vec::new();
    for _ in 0..150 {
        let action = act(&mut runner, wheel, -last, 0.0);
        firings.extend(action.leg.map(|leg| (leg, action.valve_open)));
    }
    assert_eq!(firings.first().map(|firing| firing.1), Some(0.04));
    // Forwards again, and by the table once it is near.
    for cycle in 0..250 {
        let action = act(&mut runner, wheel + cycle / 3, -last + 6 * cycle, 2.0);
        assert!(action.rate > 0.0);
    }
    assert_eq!(
        act(&mut runner, wheel + 84, -last + 1500, 2.0).firing_angle,
        0.2
    );
}
