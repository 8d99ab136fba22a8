//! A rolling ball: whatever is given it answers, and its estimate follows what turns it.

use std::f64::consts::{FRAC_PI_2, TAU};

use proptest::prelude::*;
use saltus_controller::Real;
use saltus_controller::ball::{
    AtRest, Balance, Balancer, Estimator, Feet, Filter, Inertial, Plane, Rotation, Scales, Sight,
    Station, Steer, Unsettled,
};

const STATIONS: [Station<f32>; 3] = [
    Station {
        legs: [0, 0],
        angle: 0.0,
    },
    Station {
        legs: [1, 2],
        angle: 2.0,
    },
    Station {
        legs: [3, 63],
        angle: 4.0,
    },
];

fn plane() -> Plane<'static, f32> {
    Plane {
        axis: [0.0, 1.0, 0.0],
        first: [0.0, 0.0, -1.0],
        ahead: [1.0, 0.0, 0.0],
        stations: &STATIONS,
    }
}

fn balance() -> Balance<f32> {
    Balance {
        period: 1e-3,
        zone: -0.3,
        angles: [0.4, 0.3],
        opens: [0.012, 0.006],
        by_rate: [0.004, 0.002],
        rate: 5.0,
        first: [0.03, 0.01],
        slow: 1.0,
        stall: 0.3,
        lead: 0.01,
        least: 5e-4,
        steer: Steer {
            roll: 0.01,
            roll_rate: 0.004,
            heading: -0.002,
            heading_rate: 0.0,
            aside: -0.001,
            aside_rate: 0.0,
            sum: 1e-4,
            most: 0.004,
            from: 0.2,
            rest: 0.015,
        },
    }
}

/// Any bits at all, or a number of a usual size.
fn any_number() -> impl Strategy<Value = f32> {
    prop_oneof![any::<u32>().prop_map(f32::from_bits), -10.0_f32..10.0]
}

prop_compose! {
    fn any_sight()(
        q in prop::array::uniform4(any_number()),
        spin in prop::array::uniform3(any_number()),
        aside in any_number(),
        aside_rate in any_number(),
        course in any_number(),
        touching in any::<u64>(),
    ) -> Sight<f32> {
        Sight { attitude: Rotation(q), spin, aside, aside_rate, course, touching }
    }
}

proptest! {
    #[test]
    fn whatever_is_seen_what_fires_opens_for_a_time(sights in prop::collection::vec(any_sight(), 1..40)) {
        let mut balancer = Balancer::new(balance(), plane());
        for sight in &sights {
            let (_, fired) = balancer.step(sight);
            for firing in fired.into_iter().flatten() {
                prop_assert!(firing.leg < 64 && firing.open >= 5e-4, "{firing:?}");
            }
        }
    }

    #[test]
    fn twins_push_back_what_leans(roll in -0.2_f32..0.2) {
        prop_assume!(roll.abs() > 0.02);
        // The twins of the second station, 0.35 rad past upright, both on the ground.
        let turn = |axis: [f64; 3], angle: f64| {
            let (sine, cosine) = (0.5 * angle).sin_cos();
            Rotation([cosine, axis[0] * sine, axis[1] * sine, axis[2] * sine].map(f32::of))
        };
        let rolled = turn([1.0, 0.0, 0.0], f64::from(roll)).after(&turn([0.0, 1.0, 0.0], 2.35));
        let sight = Sight {
            attitude: rolled,
            spin: [0.0, 5.0, 0.0],
            aside: 0.0,
            aside_rate: 0.0,
            course: 0.0,
            touching: 0b110,
        };
        let (lying, fired) = Balancer::new(balance(), plane()).step(&sight);
        prop_assert!((lying.roll - roll).abs() < 1e-5 && (lying.lean - 0.35).abs() < 1e-5, "{lying:?}");
        let open = fired.map(|firing| firing.map_or(0.0, |firing| firing.open));
        // To the right: the right one, which is the second, pushes longer.
        prop_assert!((open[1] - open[0]) * roll > 0.0, "{fired:?}");
    }
}

fn estimator<R: Real>(directions: &[[R; 3]], attitude: Rotation<R>) -> Estimator<'_, R> {
    let filter = Filter {
        period: R::of(1e-3),
        gravity: R::of(9.8),
        bias: [R::ZERO; 3],
        by_foot: R::of(40.0),
        tilt: R::of(0.1),
        settles: R::of(0.03),
        returns: R::of(0.25),
    };
    let scales = Scales {
        fine_gyro: R::of(1e-4),
        coarse_gyro: R::of(1e-3),
        fine_accelerometer: R::of(1e-3),
        coarse_accelerometer: R::of(1e-2),
        limit: 32_000,
    };
    let feet = Feet {
        directions,
        reach: R::of(0.233),
        radius: R::of(0.007),
    };
    Estimator::new(filter, scales, feet, (attitude, [R::ZERO; 3]))
}

#[test]
fn a_ball_that_stands_knows_that_it_does() {
    let down = [[0.0_f64, 0.0, -1.0]];
    let mut known = estimator(&down, Rotation::NONE);
    let readings = Inertial {
        fine_accelerometer: [0, 0, 9800],
        touching: 1,
        ..Inertial::default()
    };
    for _ in 0..60_000 {
        known.take(&readings);
    }
    let e = known.estimate();
    assert!((e.attitude.0[0] - 1.0).abs() < 1e-12, "{e:?}");
    assert!(
        e.place.iter().chain(&e.velocity).all(|x| x.abs() < 1e-9),
        "{e:?}"
    );
}

/// What it takes for the vertical is off at first: standing, its foot and its accelerometers tell.
#[test]
fn a_ball_that_stands_finds_the_vertical() {
    let down = [[0.0_f64, 0.0, -1.0]];
    let readings = Inertial {
        fine_accelerometer: [0, 0, 9800],
        touching: 1,
        ..Inertial::default()
    };
    for axis in [[0.05, 0.0, 0.0], [0.0, -0.05, 0.0], [0.03, 0.04, 0.0]] {
        let mut known = estimator(&down, Rotation::small(&axis));
        let off = |e: &Estimator<'_, f64>| {
            let [_, x, y, _] = e.estimate().attitude.0;
            2.0 * x.hypot(y)
        };
        assert!((off(&known) - 0.05).abs() < 1e-4);
        for _ in 0..200_000 {
            known.take(&readings);
        }
        // It falls by e in 41 s: v = g δ/40 while the foot draws it back, and δ falls by 0.1 v.
        let expected = 0.05 * (-200.0 * 0.1 * 9.8 / 40.0_f64).exp();
        assert!(
            (off(&known) - expected).abs() < 0.1 * expected,
            "{} {expected}",
            off(&known)
        );
    }
}

#[test]
fn it_turns_as_its_gyros_say_and_the_coarse_ones_beyond_the_fine() {
    // 3.2 rad/s is the end of the fine ones; 2 and 20 rad/s about z, in free fall.
    for (fine, coarse, rate) in [(20_000, 2_000, 2.0), (32_000, 20_000, 20.0)] {
        let mut known = estimator::<f64>(&[], Rotation::NONE);
        let readings = Inertial {
            fine_gyro: [0, 0, fine],
            coarse_gyro: [0, 0, coarse],
            ..Inertial::default()
        };
        for _ in 0..1000 {
            known.take(&readings);
        }
        let e = known.estimate();
        let (sine, cosine) = (0.5 * rate % TAU).sin_cos();
        let [w, x, y, z] = e.attitude.0;
        let off = (w - cosine).abs().min((w + cosine).abs());
        assert!(off < 1e-9 && x.abs() < 1e-12 && y.abs() < 1e-12, "{e:?}");
        assert!((z.abs() - f64::abs(sine)).abs() < 1e-9, "{e:?}");
        assert!((e.velocity[2] + 9.8).abs() < 1e-9 && (e.place[2] + 4.9).abs() < 1e-9);
    }
}

#[test]
fn single_precision_follows_double() {
    let (down, single) = ([[0.0, 0.0, -1.0]], [[0.0_f32, 0.0, -1.0]]);
    let (mut double, mut short) = (
        estimator(&down, Rotation::NONE),
        estimator(&single, Rotation::NONE),
    );
    for k in 0..20_000_i32 {
        let wave = |period: f64, most: f64| {
            let x = most * (TAU * f64::from(k) / period + FRAC_PI_2).sin();
            // Counts of a converter.
            #[allow(clippy::cast_possible_truncation)]
            let counts = x as i32;
            counts
        };
        let readings = Inertial {
            fine_gyro: [
                wave(700.0, 9_000.0),
                wave(1100.0, 20_000.0),
                wave(900.0, 5_000.0),
            ],
            fine_accelerometer: [wave(500.0, 3_000.0), 0, 9_800],
            touching: u64::from(k % 400 < 200),
            ..Inertial::default()
        };
        double.take(&readings);
        short.take(&readings);
    }
    let (a, b) = (double.estimate().attitude.0, short.estimate().attitude.0);
    let dot: f64 = a.iter().zip(&b).map(|(a, b)| a * f64::from(*b)).sum();
    assert!((dot.abs() - 1.0).abs() < 1e-6, "{a:?} {b:?}");
}

/// Any attitude, with 2 % of noise (1.2 % rms, of 200 readings 0.05°): up is up to 0.25°, whatever the heading; head over as well as upright.
#[test]
fn a_ball_at_rest_knows_which_way_is_up() {
    let scales = Scales {
        fine_gyro: 3e-4,
        coarse_gyro: 8e-4,
        fine_accelerometer: 6e-4,
        coarse_accelerometer: 1.5e-2,
        limit: 32_111,
    };
    let gravity = 9.8_f64;
    let (mut state, mut known) = (1_u64, 0);
    let mut draw = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005) + 1;
        (state >> 33) as f64 / f64::from(1_u32 << 30) - 1.0
    };
    let mut ups: Vec<[f64; 3]> = (0..500).map(|_| [draw(), draw(), draw()]).collect();
    ups.extend([
        [0.0, 0.0, 1.0],
        [0.0, 0.0, -1.0],
        [1.0, 0.0, 0.0],
        [0.0, -1.0, -1e-9],
    ]);
    for up in ups {
        let length = up.iter().map(|x| x * x).sum::<f64>().sqrt();
        let mut rest = AtRest::new();
        assert_eq!(rest.attitude(&scales, gravity), Err(Unsettled::AskLater));
        for _ in 0..200 {
            // Counts of a converter.
            #[allow(clippy::cast_possible_truncation)]
            let count = |x: f64, noise: f64| ((x / length + 0.02 * noise) * gravity / 6e-4) as i32;
            let fine_accelerometer = up.map(|x| count(x, draw()));
            rest.take(
                &scales,
                &Inertial {
                    fine_accelerometer,
                    ..Inertial::default()
                },
            );
        }
        let attitude = rest.attitude(&scales, gravity).expect("it lies still");
        let [x, y, z] = attitude.turn(&up.map(|x| x / length));
        assert!(
            z > 0.0 && x.hypot(y) < 0.25_f64.to_radians(),
            "{up:?}: {x} {y} {z}"
        );
        known += 1;
    }
    assert_eq!(known, 504);
    // Turning, shaken, at the end of its range.
    let said = |gyro: i32, up: i32| {
        let mut rest = AtRest::new();
        for _ in 0..200 {
            let readings = Inertial {
                fine_gyro: [0, gyro, 0],
                fine_accelerometer: [0, up, 0],
                ..Inertial::default()
            };
            rest.take(&scales, &readings);
        }
        rest.attitude(&scales, gravity).err()
    };
    assert_eq!(said(100, 16_333), None);
    assert_eq!(said(-2700, 16_333), Some(Unsettled::Moving));
    assert_eq!(said(0, 13_000), Some(Unsettled::Moving));
    assert_eq!(said(0, 32_111), Some(Unsettled::Saturated));
    assert_eq!(said(0, i32::MIN), Some(Unsettled::Saturated));
}
