//! Flight, firing instant and observer against other implementations.

use proptest::prelude::*;
use saltus_ballistic::Flight;
use saltus_controller::{Controller, LiftOff, Observer, Sensed, Timing};

const CONTROLLER: Controller<'static, f32> = crate::rats_planar::RATS_PLANAR;
const GRAVITY: f64 = 9.80665;

fn lift_off(state: [f64; 4]) -> LiftOff<f64> {
    LiftOff {
        state,
        by_angle: [0.1, -0.2, 0.3, -0.4],
        by_valve: [0.05, 0.1, 2.0, 7.0],
    }
}

fn moved(state: [f64; 4], by: [f64; 4], step: f64) -> LiftOff<f64> {
    lift_off(std::array::from_fn(|k| state[k] + step * by[k]))
}

proptest! {
    #[test]
    fn landings_are_those_of_ballistic(
        x in -0.2_f64..0.2, y in 0.2_f64..0.4, vx in -1.0_f64..4.0, vy in -1.0_f64..4.0, height in -0.5_f64..1.0,
    ) {
        let here = lift_off([x, y, vx, vy]);
        let flight = Flight { x, y, vx, vy, gravity: GRAVITY };
        match (here.landing(GRAVITY, height), flight.range_to_height(height)) {
            (Ok(ours), Ok(theirs)) => {
                prop_assert!((ours.value - theirs).abs() < 1e-12 * (1.0 + theirs.abs()));
                // The derivative by central differences, away from the apex, where it is infinite.
                prop_assume!(vy * vy + 2.0 * GRAVITY * (y - height) > 0.05);
                let step = 1e-6;
                let value = |by, step| moved(here.state, by, step).landing(GRAVITY, height).map_or(f64::NAN, |l| l.value);
                for (by, ours) in [(here.by_angle, ours.by_angle), (here.by_valve, ours.by_valve)] {
                    let slope = (value(by, step) - value(by, -step)) / (2.0 * step);
                    prop_assert!((ours - slope).abs() < 1e-6 * (1.0 + slope.abs()), "{ours} {slope}");
                }
            }
            (Err(_), Err(_)) => {}
            other => prop_assert!(false, "{other:?}"),
        }
    }

    #[test]
    fn distances_are_those_of_ballistic(
        y in 0.2_f64..0.4, vx in 0.2_f64..4.0, vy in -1.0_f64..4.0, cx in -1.0_f64..1.5, cy in 0.0_f64..0.5,
    ) {
        let here = lift_off([0.0, y, vx, vy]);
        let [ours, other] = here.distances_to(GRAVITY, [cx, cx + 0.2], cy);
        prop_assert_eq!(other, here.distances_to(GRAVITY, [cx + 0.2, cx], cy)[0]);
        let flight = Flight { x: 0.0, y, vx, vy, gravity: GRAVITY };
        // The whole parabola, as ours: from long before to long after.
        let theirs = flight.distance_to_point([cx, cy], -3.0, 3.0);
        prop_assume!(theirs > 0.1);
        // Four Newton steps: within 0.13 mm for wheels of 0.1 m and above, and never below.
        prop_assert!((-1e-9..2e-4).contains(&(ours.value.abs() - theirs)), "{} {theirs}", ours.value);
        // A path below the point is not clear of it.
        let time = cx / vx;
        let passes_above = y + vy * time - 0.5 * GRAVITY * time * time > cy;
        prop_assert_eq!(ours.value > 0.0, passes_above, "{}", ours.value);
        let step = 1e-6;
        let value = |by, step| moved(here.state, by, step).distances_to(GRAVITY, [cx; 2], cy)[0].value;
        let slope = (value(here.by_angle, step) - value(here.by_angle, -step)) / (2.0 * step);
        // Beside the evolute of the parabola the nearest point, and so the derivative, jumps or
        // nearly does.
        let curvature = (vx * vx - GRAVITY * (y + 0.5 * vy * vy / GRAVITY - cy)).abs();
        prop_assume!(curvature > 0.5);
        prop_assert!((ours.by_angle - slope).abs() < 0.02 * (1.0 + slope.abs()), "{} {slope}", ours.by_angle);
    }

    /// The instant against the pendulum's own motion in small steps.
    #[test]
    fn instants_are_those_of_the_pendulum(lean in -0.6_f64..0.4, rate in 1.5_f64..7.0, ahead in 0.0_f64..0.02) {
        let c = f64::from(CONTROLLER.robot.pendulum);
        let (mut phi, mut omega, steps) = (lean, rate, 2000_u32);
        let h = ahead / f64::from(steps);
        for _ in 0..steps {
            let middle = phi + 0.5 * h * omega;
            omega += h * c * middle.sin();
            phi = middle + 0.5 * h * omega;
        }
        let mut controller = CONTROLLER;
        controller.limits.period = 0.0;
        #[allow(clippy::cast_possible_truncation)]
        let sensed = Sensed { lean: lean as f32, rate: rate as f32 };
        #[allow(clippy::cast_possible_truncation)]
        let timing = controller.timing(&sensed, phi as f32).expect("it gets there");
        let (Timing::Wait(time) | Timing::Fire(time)) = timing else {
            prop_assert!(ahead < 1e-6, "late");
            return Ok(());
        };
        // A lean's acceleration changes by c ω t: c ω t³/6 of the lean, and a fifth of that again,
        // over ω; and f32.
        let bound = 0.25 * c * ahead.powi(3) + 2e-7;
        prop_assert!((f64::from(time) - ahead).abs() < bound, "{time} {ahead}");
    }
}

#[test]
fn the_valve_is_commanded_by_its_extra_delay_sooner() {
    let sensed = Sensed {
        lean: -0.1,
        rate: 5.0,
    };
    let plain = CONTROLLER.timing(&sensed, 0.1);
    let mut slow = CONTROLLER;
    slow.limits.extra_delay = 0.004;
    let (Ok(Timing::Wait(plain)), Ok(Timing::Wait(sooner))) = (plain, slow.timing(&sensed, 0.1))
    else {
        panic!("{plain:?}");
    };
    assert!((plain - sooner - 0.004).abs() < 1e-8);
    // 40 ms ahead; within a period of the instant it fires, and past it it says by how much.
    assert!((plain - 0.04).abs() < 2e-3);
    assert!(
        matches!(CONTROLLER.timing(&Sensed { lean: 0.0999, rate: 5.0 }, 0.1), Ok(Timing::Fire(t)) if t < 1e-3)
    );
    assert!(
        matches!(CONTROLLER.timing(&Sensed { lean: 0.105, rate: 5.0 }, 0.1), Ok(Timing::Late(t)) if (t - 1e-3).abs() < 1e-4)
    );
}

#[test]
fn an_approach_rate_is_the_same_all_the_way() {
    // Energy: ω² + 2 c cos φ stays, in f64 and by other functions.
    let c = f64::from(CONTROLLER.robot.pendulum);
    let rate_at = |lean: f64| (4.0 * 4.0 + 2.0 * c * ((-0.5_f64).cos() - lean.cos())).sqrt();
    for lean in [-0.5, -0.3, 0.0, 0.2, 0.6, 1.2] {
        #[allow(clippy::cast_possible_truncation)]
        let sensed = Sensed {
            lean: lean as f32,
            rate: rate_at(lean) as f32,
        };
        let rate = CONTROLLER
            .rate_at(&sensed, -0.5)
            .expect("a lean above the ground");
        assert!((rate - 4.0).abs() < 5e-6, "{lean}: {rate}");
    }
}

#[test]
fn an_observer_follows_an_encoder() {
    let c = f64::from(CONTROLLER.robot.pendulum);
    let step = std::f64::consts::TAU / 800.0;
    let mut worst = 0.0_f64;
    for k in 0..50 {
        let (mut lean, mut rate) = (-0.5, 3.5 + 0.05 * f64::from(k));
        #[allow(clippy::cast_possible_truncation)]
        let mut observer = Observer {
            sensed: Sensed {
                lean: -0.5_f32,
                rate: rate as f32 + 0.1,
            },
            period: 1e-3,
            pendulum: c as f32,
            memory: 0.9,
        };
        for _ in 0..60 {
            for _ in 0..10 {
                rate += 1e-4 * c * (lean + 0.5e-4 * rate).sin();
                lean += 1e-4 * rate;
            }
            #[allow(clippy::cast_possible_truncation)]
            observer.update(((lean / step).round() * step) as f32);
        }
        worst = worst.max((f64::from(observer.sensed.rate) - rate).abs());
    }
    // It began 0.1 rad/s off. One count is 7.9 mrad; over the 20 ms that it remembers that is some
    // 0.1 rad/s, and less on the mean.
    assert!(worst < 0.1, "{worst}");
}
