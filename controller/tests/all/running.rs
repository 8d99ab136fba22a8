//! Running: the firing laws, the state machine on synthetic wheel counts, and what stands at rest.

// Counts and singles are made of doubles.

use std::f64::consts::{PI, TAU};

use proptest::prelude::*;
use saltus_controller::run::{
    Action, Ahead, Gait, Hold, Instruments, Knot, Law, Leap, MOST_TAPS, Readings, Runner, Signals,
    Stall, Standing, Unsure,
};
use saltus_controller::{Axis, Real};

/// Counts of a turn, of which every pitch from 3 to 12 legs but 7, 9 and 11 is a whole number.
const TURN: i32 = 2400;
/// Counts of the gyros in 1 rad/s.
const GYRO: f64 = 1000.0;

fn instruments<R: Real>() -> Instruments<R> {
    Instruments {
        wheel: R::of(TAU / f64::from(TURN)),
        wheel_turn: TURN,
        radius: R::of(TAU / 1600.0),
        pivot: R::of(TAU / 1600.0),
        fine_gyro: R::of(1.0 / GYRO),
        fine_limit: 9800,
        coarse_gyro: R::of(4.0 / GYRO),
        fine_accelerometer: R::of(2.0 * 9.81 / 32767.0),
        accelerometer_limit: 32767,
    }
}

const fn knot<R>(rate: R, firing_angle: R, valve_open: R) -> Knot<R> {
    Knot {
        rate,
        firing_angle,
        valve_open,
    }
}

const FIXED: [Knot<f64>; 1] = [knot(0.0, 0.1, 0.04)];

fn gait(legs: u32) -> Gait<'static, f64> {
    Gait {
        law: Law::Lines(&FIXED),
        // No count is so near an end of it that round-off would decide.
        zone: 1e-4,
        legs,
        period: 1e-3,
        instruments: instruments(),
        taps: &[1.0],
        hold: None,
        stall: Stall {
            rate: 0.5,
            time: 0.5,
            restarts: false,
        },
        first: &[],
        leap: None,
        ahead: None,
    }
}

/// The wheel at `wheel`, its rate `rate` (rad/s).
fn readings(wheel: i32, rate: f64) -> Readings {
    Readings {
        wheel,
        fine_gyro: (rate * GYRO) as i32,
        coarse_gyro: (rate * GYRO / 4.0) as i32,
        ..Readings::default()
    }
}

/// The legs that fire, with the count at which each does, as the wheel rolls on by `step` counts.
fn fired(
    runner: &mut Runner<'_, f64>,
    from: i32,
    step: i32,
    cycles: i32,
) -> (Vec<(u32, i32)>, i32) {
    let mut all = Vec::new();
    for k in 0..cycles {
        let wheel = from + k * step;
        let rate = f64::from(step.signum()) * 5.0;
        all.extend(
            runner
                .step(&readings(wheel, rate))
                .leg
                .map(|leg| (leg, wheel)),
        );
    }
    (all, from + cycles * step)
}

/// α_f by the open loop tanh(t).
fn by_time<R: Real>(x: R) -> R {
    let law = Law::OverTime {
        amplitude: R::ONE,
        slope: R::ONE,
        shift: R::ZERO,
        level: R::ZERO,
        valve_open: R::ONE,
    };
    law.at(x, R::ZERO)[0]
}

#[test]
fn tanh_is_that_of_the_standard_library_to_round_off() {
    // Eight doublings and nine steps of the series, each rounded: 8 units are less than their sum, and
    // the greatest that was seen is below 4.
    for k in -40_000..=40_000 {
        let x = f64::from(k) * 1e-3;
        let (is, should) = (by_time(x), x.tanh());
        assert!(
            (is - should).abs() <= 8.0 * f64::EPSILON * should.abs(),
            "{x}: {is} {should}"
        );
        let x = x as f32;
        let (is, should) = (by_time(x), x.tanh());
        assert!(
            (is - should).abs() <= 8.0 * f32::EPSILON * should.abs(),
            "{x}: {is} {should}"
        );
    }
    for k in 0..300 {
        let x = 10_f64.powi(-k);
        for x in [x, -x] {
            assert!((by_time(x) / x.tanh() - 1.0).abs() < 8.0 * f64::EPSILON);
        }
    }
    assert_eq!(by_time(0.0), 0.0);
    for x in [20.1, 1e10, f64::MAX, f64::INFINITY] {
        assert_eq!([by_time(x), by_time(-x)], [1.0, -1.0]);
    }
    assert!(by_time(f64::NAN).is_nan() && by_time(f32::NAN).is_nan());
}

#[test]
fn at_rest_the_rear_leg_fires_at_once_and_once() {
    for legs in 3..=12 {
        for rear in 0..legs {
            for forwards in [true, false] {
                let mut runner = Runner::new(gait(legs), rear, -77, forwards);
                let first = runner.step(&readings(-77, 0.0));
                // Backwards the leg in front is the rear one.
                let pushes = if forwards { rear } else { (rear + 1) % legs };
                assert_eq!(
                    first.leg,
                    Some(pushes),
                    "{legs} legs, on {rear}, {forwards}"
                );
                assert!((first.lean - PI / f64::from(legs)).abs() < 1e-12);
                for _ in 0..10 {
                    assert_eq!(runner.step(&readings(-77, 0.0)).leg, None);
                }
            }
        }
    }
}

#[test]
fn a_rolling_wheel_fires_its_legs_in_their_order_once_each() {
    let mut runner = Runner::new(gait(5), 3, 1000, true);
    let (all, _) = fired(&mut runner, 1000, 1, TURN * 3 + TURN / 4);
    let legs: Vec<u32> = all.iter().map(|(leg, _)| *leg).collect();
    assert_eq!(legs, [3, 4, 0, 1, 2, 3, 4, 0, 1, 2, 3, 4, 0, 1, 2, 3, 4]);
    // Leg 3 leans by 36°, 240 counts, at count 1000; each next one leans by 0.1 rad, 38.2 counts,
    // 480 counts later.
    let at: Vec<i32> = all[1..].iter().map(|(_, at)| *at).collect();
    let should: Vec<i32> = (0..16).map(|k| 1000 - 240 + 480 * (k + 1) + 39).collect();
    assert_eq!(at, should);
}

#[test]
fn a_million_turns_lose_nothing() {
    for forwards in [true, false] {
        let mut runner = Runner::new(gait(5), 2, 0, forwards);
        let sign = if forwards { 1 } else { -1 };
        let wheel = |turns: i32, part: i32| sign * (turns * TURN + part);
        let of_turn = |runner: &mut Runner<'_, f64>, turns: i32| -> Vec<Action<f64>> {
            (0..TURN)
                .map(|part| runner.step(&readings(wheel(turns, part), f64::from(sign) * 5.0)))
                .collect()
        };
        // The first turn starts at rest and the second does not.
        of_turn(&mut runner, 0);
        let early = of_turn(&mut runner, 1);
        // A cycle may not turn the wheel further than it can follow: half a pitch is enough.
        for k in 20..10 * 799_999 {
            runner.step(&readings(sign * k * (TURN / 10), f64::from(sign) * 5.0));
        }
        of_turn(&mut runner, 799_999);
        assert!(of_turn(&mut runner, 800_000) == early);
    }
}

/// The counter goes round: 2³² counts are no whole number of turns, and do not matter.
#[test]
fn a_counter_may_overflow() {
    let start = i32::MAX - 700;
    let mut runner = Runner::new(gait(5), 0, start, true);
    let mut low = Runner::new(gait(5), 0, 0, true);
    for k in 0..5000 {
        let (a, b) = (
            runner.step(&readings(start.wrapping_add(k), 5.0)),
            low.step(&readings(k, 5.0)),
        );
        assert_eq!(a, b);
    }
}

#[test]
fn rocking_back_rearms_only_where_the_leg_in_the_zone_changes() {
    let mut runner = Runner::new(gait(5), 0, 0, true);
    assert_eq!(runner.step(&readings(0, 0.0)).leg, Some(0));
    // Leg 0 leans by 240 counts; back to 10, below α_f, and forwards again: it has fired.
    for wheel in (-230..=230).rev().chain(-230..=230) {
        let action = runner.step(&readings(wheel, 0.0));
        assert_eq!((action.leg, action.in_zone), (None, 0), "{wheel}");
    }
    // Leg 1 enters at 240 counts, and leg 0 is in the zone again as it rocks back: it fires.
    assert_eq!(runner.step(&readings(241, 0.0)).in_zone, 1);
    let back = runner.step(&readings(235, 0.0));
    assert_eq!((back.leg, back.in_zone), (Some(0), 0));
    assert_eq!(runner.step(&readings(236, 0.0)).leg, None);
}

/// Where a count lies on the border of two zones, round-off does not arm a leg once more.
fn fires_once_each<R: Real>() {
    for legs in 3..=12 {
        for forwards in [true, false] {
            let lines = [knot(R::ZERO, R::ZERO, R::ONE)];
            let gait = Gait {
                law: Law::Lines(&lines),
                zone: R::ZERO,
                legs,
                period: R::of(1e-3),
                instruments: instruments(),
                taps: &[],
                hold: None,
                stall: Stall {
                    rate: R::ZERO,
                    time: R::ONE,
                    restarts: false,
                },
                first: &[],
                leap: None,
                ahead: None,
            };
            let mut runner = Runner::new(gait, 0, 0, forwards);
            let sign = if forwards { 1 } else { -1 };
            let mut firings = Vec::new();
            for cycle in 0..4 * 4 * TURN {
                let action = runner.step(&readings(sign * (cycle / 4), 0.0));
                firings.extend(action.leg);
            }
            // Four turns, which begin and end within a zone.
            assert_eq!(firings.len(), 4 * legs as usize + 1, "{legs} {forwards}");
            assert!(firings.windows(2).all(|pair| pair[0] != pair[1]));
        }
    }
}

#[test]
fn a_wheel_on_the_border_of_two_zones_fires_once() {
    fires_once_each::<f32>();
    fires_once_each::<f64>();
}

#[test]
fn a_stall_is_told_and_may_fire_once_more() {
    for restarts in [false, true] {
        let mut slow = gait(5);
        slow.stall.restarts = restarts;
        let mut runner = Runner::new(slow, 0, 0, true);
        let all: Vec<Action<f64>> = (0..1100).map(|_| runner.step(&readings(0, 0.3))).collect();
        let first = all.iter().position(|action| action.stalled);
        assert_eq!(first, Some(499));
        let firings = all.iter().filter(|action| action.leg.is_some()).count();
        // After 0.5 s each: in the cycles 499 and 999 it is let go.
        assert_eq!(firings, if restarts { 3 } else { 1 });
    }
}

proptest! {
    /// Backwards, the mirrored legs do at mirrored counts what they do forwards.
    #[test]
    fn backwards_is_forwards_in_a_mirror(
        legs in 3_u32..=12,
        rear in 0_u32..12,
        zone in -0.5_f64..0.5,
        start in -100_000_i32..100_000,
        steps in prop::collection::vec(-40_i32..80, 1..400),
    ) {
        let rear = rear % legs;
        let mut gait = gait(legs);
        gait.zone = zone * PI / f64::from(legs);
        let lines = [knot(0.0, 0.2, 0.04), knot(6.0, gait.zone, 0.02)];
        gait.law = Law::Lines(&lines);
        // The mirrored wheel stands on the mirrored legs: the rear one there is in front here.
        let mirror = |leg: u32| (legs - leg) % legs;
        let mut forwards = Runner::new(gait, rear, start, true);
        let mut backwards = Runner::new(gait, mirror((rear + 1) % legs), -start, false);
        let mut wheel = start;
        for step in steps {
            wheel += step;
            let rate = f64::from(step) * 0.1;
            let (a, b) = (
                forwards.step(&readings(wheel, rate)),
                backwards.step(&readings(-wheel, -rate)),
            );
            // Leans are sums of the same angles in another order.
            prop_assert!((a.lean - b.lean).abs() < 1e-12);
            // At the zone's ends round-off decides; no count is so near another one's.
            if (a.lean - a.firing_angle).abs() > 1e-12 && (a.lean - gait.zone).abs() > 1e-12 {
                let mirrored = (a.leg.map(mirror), mirror(a.in_zone), a.rate, a.valve_open);
                prop_assert_eq!(mirrored, (b.leg, b.in_zone, b.rate, b.valve_open));
            }
        }
    }

    /// Turned round twice, it is as it was, and leans by as much the other way in between.
    #[test]
    fn turning_round_loses_nothing(
        legs in 3_u32..=12,
        steps in prop::collection::vec(-150_i32..150, 1..200),
        turns in 1_u32..20,
    ) {
        let mut runner = Runner::new(gait(legs), 0, 0, true);
        let mut wheel = 0;
        for step in steps {
            wheel += step;
            let before = runner.step(&readings(wheel, 0.0));
            for _ in 0..turns {
                runner.turn_round(wheel);
                let turned = runner.step(&readings(wheel, 0.0));
                let pitch = TAU / f64::from(legs);
                let whole = (turned.lean + before.lean) / pitch;
                prop_assert!((whole - whole.round()).abs() < 1e-12);
                runner.turn_round(wheel);
                let again = runner.step(&readings(wheel, 0.0));
                prop_assert_eq!((again.lean, again.in_zone), (before.lean, before.in_zone));
            }
        }
    }
}

#[test]
fn lines_hold_between_knots_and_jump_where_two_are_at_one_rate() {
    let knots = [
        knot(1.0, 0.4, 0.03),
        knot(5.0, 0.2, 0.05),
        knot(5.0, -0.1, 0.06),
        knot(9.0, -0.3, 0.02),
    ];
    let below = 5.0 - 4.0 * f64::EPSILON;
    for (rate, angle, open) in [
        (-3.0, 0.4, 0.03),
        (1.0, 0.4, 0.03),
        (3.0, 0.3, 0.04),
        (below, 0.2, 0.05),
        (5.0, -0.1, 0.06),
        (7.0, -0.2, 0.04),
        (9.0, -0.3, 0.02),
        (1e9, -0.3, 0.02),
    ] {
        let is = Law::Lines(&knots).at(0.0, rate);
        assert!((is[0] - angle).abs() < 1e-12, "{rate}: {is:?}");
        assert!((is[1] - open).abs() < 1e-12, "{rate}: {is:?}");
    }
    for rate in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(Law::Lines(&knots).at(0.0, rate)[1], 0.0);
    }
    assert_eq!(Law::<f64>::Lines(&[]).at(0.0, 1.0)[1], 0.0);
}

/// A millimetre a count, and a mean of the speed over 10 ms.
const HOLD: Hold<f64> = Hold {
    way: 1e-3,
    renewed: 0.1,
    ahead: 10.0,
    by_error: 0.05,
    by_sum: 0.02,
    most_sum: 0.5,
};

/// At 1 m/s 0.3 rad, at 3 m/s 0.1 rad.
const OVER_SPEED: [Knot<f64>; 2] = [knot(1.0, 0.3, 0.03), knot(3.0, 0.1, 0.05)];

fn holding() -> Gait<'static, f64> {
    Gait {
        law: Law::Lines(&OVER_SPEED),
        hold: Some(HOLD),
        ..gait(5)
    }
}

/// The wheel at `wheel`, the boom's encoder at `radius`.
fn both(wheel: i32, radius: i32, rate: f64) -> Readings {
    Readings {
        radius,
        ..readings(wheel, rate)
    }
}

#[test]
fn a_speed_is_held_by_the_firing_angle() {
    // Lean 0.1 rad or less, at which no leg fires.
    let angle = |demand: f64, counts: i32, cycles: i32| -> f64 {
        let mut runner = Runner::new(holding(), 0, 0, true);
        runner.demand(demand);
        let step = |k: i32| runner.step(&both(-230, i32::MAX.wrapping_add(k * counts), 5.0));
        (0..=cycles)
            .map(step)
            .last()
            .map_or(f64::NAN, |action| action.firing_angle)
    };
    // At the first cycle nothing is measured: 2 m/s and 2 mm are lacking.
    assert!((angle(2.0, 2, 0) - (0.2 - 0.05 * 2.0 - 0.02 * 2e-3)).abs() < 1e-12);
    // A tenth of a first way of 3 mm in 1 ms is 0.3 m/s.
    let should = 0.2 - 0.05 * 1.7 - 0.02 * (2.0 + 1.7) * 1e-3;
    assert!((angle(2.0, 3, 1) - should).abs() < 1e-12);
    // As fast as demanded; slower is sooner, and faster later, by the sum of what was lacking too.
    let [slow, right, fast] = [1, 2, 3].map(|counts| angle(2.0, counts, 300));
    let lacked = 2.0 * 10.0 * 1e-3;
    assert!((right - (0.2 - 0.02 * lacked)).abs() < 1e-9, "{right}");
    let lacked = 0.3 + 10.0 * 1e-3 + 1e-3;
    assert!((slow - (0.15 - 0.02 * lacked)).abs() < 1e-3, "{slow}");
    assert!(slow < right && right < fast);
    // The sum is bounded either way, and the angle by the zone.
    assert!((angle(2.0, 1, 3000) - (0.2 - 0.05 - 0.01)).abs() < 1e-9);
    assert!((angle(2.0, 3, 3000) - (0.2 + 0.05 + 0.01)).abs() < 1e-9);
    assert_eq!(angle(3.0, 0, 10), gait(5).zone);
    // What would never fire does not, however much is lacking.
    let mut none = holding();
    none.law = Law::Lines(&[]);
    let mut runner = Runner::new(none, 0, 0, true);
    runner.demand(100.0);
    assert_eq!(runner.step(&both(0, 0, 0.0)).leg, None);
}

#[test]
fn a_faster_demand_fires_by_its_own_law() {
    for (demand, open) in [(1.0, 0.03), (2.0, 0.04), (3.0, 0.05)] {
        let mut runner = Runner::new(holding(), 0, 0, true);
        runner.demand(demand);
        let action = runner.step(&both(0, 0, 0.0));
        assert_eq!(action.leg, Some(0));
        assert!((action.valve_open - open).abs() < 1e-12);
    }
}

#[test]
fn without_a_demand_no_leg_fires() {
    for demand in [None, Some(0.0), Some(-0.0), Some(f64::NAN)] {
        let mut restless = holding();
        restless.stall.restarts = true;
        let mut runner = Runner::new(restless, 0, 0, true);
        if let Some(speed) = demand {
            runner.demand(speed);
        }
        for k in 0..2 * TURN {
            assert_eq!(runner.step(&both(k, k, 5.0)).leg, None);
        }
        for _ in 0..2000 {
            assert_eq!(runner.step(&both(2 * TURN, 0, 0.0)).leg, None);
        }
        // And then on.
        runner.demand(2.0);
        let goes = |k: i32| runner.step(&both(2 * TURN + k, k, 5.0)).leg.is_some();
        assert!((0..TURN).any(goes));
    }
}

#[test]
fn the_other_way_begins_where_it_stands_still_and_is_a_mirror() {
    for restarts in [false, true] {
        for forwards in [true, false] {
            let sign = if forwards { 1 } else { -1 };
            let mut gait = holding();
            gait.stall.restarts = restarts;
            // Leg 0 in the zone, leaning by half a pitch, either way.
            let rear = if forwards { 0 } else { 4 };
            let mut runner = Runner::new(gait, rear, 0, forwards);
            runner.demand(f64::from(sign) * 2.0);
            let first = runner.step(&both(0, 0, 0.0));
            assert_eq!(first.leg, Some(0));
            // It rolls on for 10 legs, with no more firing.
            runner.demand(f64::from(-sign) * 2.0);
            for k in 0..=2 * TURN {
                let rate = f64::from(sign) * 5.0;
                assert_eq!(runner.step(&both(sign * k, sign * k, rate)).leg, None);
            }
            let stands = both(sign * 2 * TURN, sign * 2 * TURN, 0.0);
            for k in 0..500 {
                let action = runner.step(&stands);
                assert_eq!((action.leg, action.in_zone), (None, 0), "{k}");
                assert_eq!(action.stalled, k == 499);
            }
            // Now the other one of the two that stand is the rear one; from here on it is as if it
            // had been started so.
            let start = sign * 2 * TURN;
            let rear = if forwards { 0 } else { 4 };
            let mut anew = Runner::new(gait, rear, start, !forwards);
            anew.demand(f64::from(-sign) * 2.0);
            let mut fired = Vec::new();
            for k in 0..TURN {
                let (wheel, rate) = (start - sign * k, f64::from(-sign) * 5.0);
                let (a, b) = (
                    runner.step(&both(wheel, wheel, rate)),
                    anew.step(&both(wheel, wheel, rate)),
                );
                assert_eq!((a.leg, a.in_zone), (b.leg, b.in_zone), "{k}");
                assert!((a.lean - b.lean).abs() < 1e-9);
                assert!((a.firing_angle - b.firing_angle).abs() < 1e-9);
                fired.extend(a.leg);
            }
            let should = if forwards {
                [1, 0, 4, 3, 2, 1]
            } else {
                [4, 0, 1, 2, 3, 4]
            };
            assert_eq!(fired, should, "{restarts} {forwards}");
        }
    }
}

#[test]
fn first_firings_come_in_their_order_and_again_after_a_restart() {
    let first = [[0.5, 0.01], [-0.05, 0.02], [0.3, 0.0], [0.2, 0.03]];
    let mut gait = gait(5);
    (gait.first, gait.zone, gait.stall.restarts) = (&first[..2], -0.1, true);
    let mut runner = Runner::new(gait, 0, 0, true);
    let roll = |runner: &mut Runner<'_, f64>, from: i32| -> Vec<(u32, i32, f64)> {
        let firing = |k: i32| {
            let action = runner.step(&readings(from + k, 5.0));
            action.leg.map(|leg| (leg, k, action.valve_open))
        };
        (0..1000).filter_map(firing).collect()
    };
    // Leg 1 leans by −240 counts at the start, leg 2 by −720: −0.05 rad are −19.1 counts, 0.1 rad 38.2.
    let should = [(0, 0, 0.01), (1, 240 - 19, 0.02), (2, 720 + 39, 0.04)];
    assert_eq!(roll(&mut runner, 0), should);
    // On leg 2 it stands until it is let go, which fires that leg at once: the first firing.
    for k in 0..499 {
        assert_eq!(runner.step(&readings(1000, 0.0)).leg, None, "{k}");
    }
    let restart = runner.step(&readings(1000, 0.0));
    assert!(restart.stalled);
    assert_eq!((restart.leg, restart.valve_open), (Some(2), 0.01));
    let should = [(3, 200 - 19, 0.02), (4, 680 + 39, 0.04)];
    assert_eq!(roll(&mut runner, 1000), should);
    // A first firing that opens no valve never comes, and nothing after it.
    gait.first = &first[2..];
    let mut runner = Runner::new(gait, 0, 0, true);
    assert_eq!(roll(&mut runner, 0), []);
}

const LEAP: Leap<f64> = Leap {
    after: 1,
    slope: -0.1,
    level: 0.8,
    least: 0.05,
    most: 0.5,
    valve_open: 0.07,
    shock: 1000,
};

/// The firing angle in each cycle of a wheel that does not turn on, and at whose cycle 10 a foot
/// comes down; the rate is 2 rad/s until then, 4 rad/s for three cycles, and then 6 rad/s, 7 rad/s
/// and so on.
fn after_a_shock(gait: &Gait<'_, f64>, coarse: [i32; 2]) -> Vec<f64> {
    let mut runner = Runner::new(*gait, 0, 0, true);
    assert!(runner.step(&readings(0, 2.0)).leg.is_some());
    let of_cycle = |k: i32| {
        let rate = match k {
            ..10 => 2.0,
            10..13 => 4.0,
            _ => f64::from(k - 7),
        };
        let reading = Readings {
            coarse_accelerometer: if k == 10 { coarse } else { [999, -999] },
            ..readings(230, rate)
        };
        runner.step(&reading).firing_angle
    };
    (0..16).map(of_cycle).collect()
}

#[test]
fn a_leap_follows_from_the_rate_after_the_shock() {
    let mut gait = gait(5);
    (gait.leap, gait.taps) = (Some(LEAP), &[0.5, 0.5, 0.0]);
    for coarse in [[1000, 0], [0, -1000], [i32::MIN, 3], [7, i32::MAX]] {
        let angles = after_a_shock(&gait, coarse);
        let near = |k: usize, rate: f64| {
            let should = (0.8 - 0.1 * rate).clamp(0.05, 0.5);
            assert!((angles[k] - should).abs() < 1e-12, "{k}: {angles:?}");
        };
        // The rate now, until the third cycle after the shock: its mean is (4 + 6)/2 rad/s.
        (1..10).for_each(|k| near(k, 2.0));
        near(10, 3.0);
        (11..13).for_each(|k| near(k, 4.0));
        (13..16).for_each(|k| near(k, 5.0));
    }
    // Without a shock the rate is that of now, up to the least angle.
    for (shock, coarse) in [
        (1000, [999, -999]),
        (0, [5000, 0]),
        (-1, [5000, 0]),
        (i32::MIN, [i32::MIN; 2]),
    ] {
        gait.leap = Some(Leap { shock, ..LEAP });
        let angles = after_a_shock(&gait, coarse);
        assert!((angles[15] - 0.05).abs() < 1e-12, "{shock}: {angles:?}");
        assert!((angles[13] - 0.3).abs() < 1e-12, "{shock}: {angles:?}");
    }
}

#[test]
fn a_leap_is_one_firing_whatever_speed_is_held() {
    for hold in [None, Some(HOLD)] {
        let mut gait = gait(5);
        (gait.hold, gait.leap) = (hold, Some(LEAP));
        let mut runner = Runner::new(gait, 0, 0, true);
        runner.demand(3.0);
        let mut fired = Vec::new();
        for wheel in 0..1150 {
            let reading = Readings {
                coarse_accelerometer: [if wheel == 250 { 1000 } else { 0 }, 0],
                // 7 rad/s a cycle after the shock, as there is one tap; later another.
                ..readings(wheel, if wheel <= 251 { 7.0 } else { 2.0 })
            };
            let action = runner.step(&reading);
            fired.extend(
                action
                    .leg
                    .map(|leg| (leg, action.valve_open, action.firing_angle)),
            );
        }
        let legs: Vec<u32> = fired.iter().map(|(leg, _, _)| *leg).collect();
        let opens: Vec<f64> = fired.iter().map(|(_, open, _)| *open).collect();
        assert_eq!((legs, opens), (vec![0, 1, 2], vec![0.04, 0.07, 0.04]));
        assert!((fired[1].2 - 0.1).abs() < 1e-12, "{fired:?}");
    }
}

#[test]
fn no_tap_and_too_many_leap_too() {
    let many = [1.0 / MOST_TAPS as f64; MOST_TAPS + 4];
    for taps in [&[][..], &many[..]] {
        let mut gait = gait(5);
        (gait.leap, gait.taps) = (Some(LEAP), taps);
        let mut runner = Runner::new(gait, 0, 0, true);
        let of_cycle = |k: i32| {
            let shock = if k == 5 { 1000 } else { 0 };
            let reading = Readings {
                coarse_accelerometer: [shock, 0],
                ..readings(230, if k <= 5 + 16 { 4.0 } else { 7.0 })
            };
            runner.step(&reading).firing_angle
        };
        let angles: Vec<f64> = (0..60).map(of_cycle).collect();
        let should = if taps.is_empty() { 0.5 } else { 0.4 };
        assert!((angles[59] - should).abs() < 1e-12, "{angles:?}");
    }
}

#[test]
fn the_filter_is_the_weighted_sum_of_the_last_readings() {
    let taps = [0.5, 0.25, -0.125, 0.0625, 1.0];
    let mut signals = Signals::new(instruments::<f64>(), &taps);
    let rates: Vec<f64> = (0..60)
        .map(|k| f64::from((k * 37) % 19 - 9) * 0.25)
        .collect();
    for (k, rate) in rates.iter().enumerate() {
        let is = signals.rate(&readings(0, *rate));
        // Before the first reading it counts as the first one.
        let past = |j: usize| rates[k.saturating_sub(j)];
        let should: f64 = taps.iter().enumerate().map(|(j, tap)| tap * past(j)).sum();
        assert!((is - should).abs() < 1e-12, "{k}: {is} {should}");
    }
    // Taps beyond the most do not count.
    let many = [1.0; MOST_TAPS + 4];
    let mut signals = Signals::new(instruments::<f64>(), &many);
    assert!((signals.rate(&readings(0, 1.0)) - MOST_TAPS as f64).abs() < 1e-12);
}

#[test]
fn the_coarse_gyro_is_believed_where_the_fine_one_is_at_its_end() {
    let signals = Signals::new(instruments::<f64>(), &[]);
    for (fine, coarse, rate) in [
        (0, 1000, 0.0),
        (9799, 0, 9.799),
        (-9799, 0, -9.799),
        (9800, 3000, 12.0),
        (-9800, -3000, -12.0),
        (i32::MIN, -5, -0.02),
        (i32::MAX, 5, 0.02),
    ] {
        let readings = Readings {
            fine_gyro: fine,
            coarse_gyro: coarse,
            ..Readings::default()
        };
        assert!((signals.gyro(&readings) - rate).abs() < 1e-12);
    }
}

/// Noise, the same every time.
struct Noise(u64);

impl Noise {
    fn word(&mut self) -> u32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 32) as u32
    }

    /// From −most to most.
    fn up_to(&mut self, most: i32) -> i32 {
        ((i64::from(self.word()) * i64::from(2 * most + 1)) >> 32) as i32 - most
    }
}

/// What a wheel at rest says whose leg 0 leans by `lean` (rad), with noise up to `noise` counts.
fn at_rest(lean: f64, noise: i32, random: &mut Noise) -> Readings {
    let g = 32767.0 / 2.0;
    Readings {
        fine_gyro: random.up_to(noise / 4),
        fine_accelerometer: [
            (-g * lean.sin()) as i32 + random.up_to(noise),
            (g * lean.cos()) as i32 + random.up_to(noise),
        ],
        ..Readings::default()
    }
}

fn found<R: Real>(legs: u32, mut reading: impl FnMut(usize) -> Readings) -> Result<u32, Unsure> {
    let signals = Signals::new(instruments::<R>(), &[]);
    let mut standing = Standing::new();
    for k in 0..200 {
        standing.take(&signals, &reading(k));
    }
    standing.rear_leg(&signals, legs, R::of(9.81))
}

#[test]
fn the_rear_leg_is_found_in_every_pose_on_every_slope() {
    let mut random = Noise(1);
    for legs in 3..=12 {
        let half = PI / f64::from(legs);
        for rear in 0..legs {
            for degrees in -15..=15 {
                let slope = f64::from(degrees).to_radians();
                for noise in [0, 300, 2000] {
                    let lean = half + 2.0 * half * f64::from(rear) + slope;
                    let answers = [
                        found::<f64>(legs, |_| at_rest(lean, noise, &mut random)),
                        found::<f32>(legs, |_| at_rest(lean, noise, &mut random)),
                    ];
                    // The mean of 200 readings with noise up to 2000 of 16384 counts turns by 5 mrad
                    // at one standard deviation; four are 20.
                    let near = (0.8 * half).min(0.45);
                    for answer in answers {
                        let says =
                            format!("{legs} legs on {rear}, {degrees}°, {noise}: {answer:?}");
                        if slope.abs() < near - 0.02 {
                            assert_eq!(answer, Ok(rear), "{says}");
                        } else if slope.abs() > near + 0.02 {
                            assert_eq!(answer, Err(Unsure::Between), "{says}");
                        } else {
                            assert!([Ok(rear), Err(Unsure::Between)].contains(&answer), "{says}");
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn a_robot_that_cannot_tell_says_why() {
    let mut random = Noise(2);
    let lean = PI / 5.0;
    let usual = at_rest(lean, 0, &mut random);
    let between = at_rest(2.0 * lean, 0, &mut random);
    let moving = Readings {
        fine_gyro: 900,
        ..usual
    };
    let shaken = Readings {
        fine_accelerometer: usual.fine_accelerometer.map(|x| x + x / 5),
        ..usual
    };
    let saturated = Readings {
        fine_accelerometer: [32767, 0],
        ..usual
    };
    let once = |odd: Readings| move |k: usize| if k == 77 { odd } else { usual };
    assert_eq!(found::<f64>(5, |_| usual), Ok(0));
    assert_eq!(found::<f64>(5, |_| between), Err(Unsure::Between));
    assert_eq!(found::<f64>(5, once(moving)), Err(Unsure::Moving));
    assert_eq!(found::<f64>(5, |_| shaken), Err(Unsure::Moving));
    assert_eq!(found::<f64>(5, once(saturated)), Err(Unsure::Saturated));
    for legs in [0, 1, 2, 13, 1000, u32::MAX] {
        assert_eq!(found::<f64>(legs, |_| usual), Err(Unsure::Between));
    }
    let signals = Signals::new(instruments::<f64>(), &[]);
    let mut standing = Standing::new();
    for _ in 0..99 {
        standing.take(&signals, &usual);
    }
    assert_eq!(standing.rear_leg(&signals, 5, 9.81), Err(Unsure::AskLater));
    // Converters of 24 bits, read for long: the sums do not overflow.
    let mut fine = instruments::<f64>();
    fine.fine_accelerometer = 2.0 * 9.81 / 8_388_607.0;
    fine.accelerometer_limit = 8_388_607;
    let signals = Signals::new(fine, &[]);
    let up = Readings {
        fine_accelerometer: usual.fine_accelerometer.map(|x| x * 256),
        ..usual
    };
    let mut standing = Standing::new();
    for _ in 0..5000 {
        standing.take(&signals, &up);
    }
    assert_eq!(standing.rear_leg(&signals, 5, 9.81), Ok(0));
}

/// Numbers that break things, and usual ones.
fn number(random: &mut Noise) -> f32 {
    const SPECIAL: [u32; 8] = [
        0x0000_0000,
        0x8000_0001,
        0x7F7F_FFFF,
        0x7F80_0000,
        0xFF80_0000,
        0x7FC0_0000,
        0x3F80_0000,
        0x0080_0000,
    ];
    match random.word() % 4 {
        0 => f32::from_bits(random.word()),
        1 => f32::from_bits(SPECIAL[random.word() as usize % 8]),
        _ => random.up_to(1000) as f32 * 1e-3,
    }
}

fn whole(random: &mut Noise) -> i32 {
    match random.word() % 4 {
        0 => random.word().cast_signed(),
        1 => [i32::MIN, i32::MAX, -1, 0][random.word() as usize % 4],
        _ => random.up_to(3000),
    }
}

fn any_readings(random: &mut Noise) -> Readings {
    Readings {
        wheel: whole(random),
        radius: whole(random),
        pivot: whole(random),
        fine_gyro: whole(random),
        coarse_gyro: whole(random),
        fine_accelerometer: [whole(random), whole(random)],
        coarse_accelerometer: [whole(random), whole(random)],
    }
}

/// A gait of which nothing can be said.
fn any_gait<'a>(
    random: &mut Noise,
    knots: &'a [Knot<f32>],
    nodes: &'a [[f32; 2]],
    (taps, first): (&'a [f32], &'a [[f32; 2]]),
) -> Gait<'a, f32> {
    let [a, b, c, d, e] = std::array::from_fn(|_| number(random));
    let law = if random.word().is_multiple_of(2) {
        Law::OverTime {
            amplitude: a,
            slope: b,
            shift: c,
            level: d,
            valve_open: e,
        }
    } else {
        Law::Lines(knots)
    };
    let mut instruments = instruments::<f32>();
    if random.word().is_multiple_of(2) {
        instruments.wheel = number(random);
        instruments.wheel_turn = whole(random);
        instruments.fine_gyro = number(random);
        instruments.fine_limit = whole(random);
        instruments.coarse_gyro = number(random);
        instruments.accelerometer_limit = whole(random);
    }
    let legs = [0, 1, 2, 3, 5, 12, 13, 100, u32::MAX];
    let hold = Hold {
        way: number(random),
        renewed: number(random),
        ahead: number(random),
        by_error: number(random),
        by_sum: number(random),
        most_sum: number(random),
    };
    let leap = Leap {
        after: random.word() % 3,
        slope: number(random),
        level: number(random),
        least: number(random),
        most: number(random),
        valve_open: number(random),
        shock: whole(random),
    };
    Gait {
        law,
        zone: number(random),
        legs: legs[random.word() as usize % legs.len()],
        period: number(random),
        instruments,
        taps,
        hold: random.word().is_multiple_of(2).then_some(hold),
        stall: Stall {
            rate: number(random),
            time: number(random),
            restarts: random.word().is_multiple_of(2),
        },
        first,
        leap: random.word().is_multiple_of(2).then_some(leap),
        ahead: random.word().is_multiple_of(2).then(|| Ahead {
            way: number(random),
            climb: number(random),
            least_weight: number(random),
            same: number(random),
            room: number(random),
            rates: any_axis(random),
            heights: any_axis(random),
            distances: any_axis(random),
            cells: &[0, 1, 2, 3, 4, 5, 6],
            choices: nodes,
            first_leap: 3,
        }),
    }
}

/// Ends of cells of which nothing can be said.
fn any_axis(random: &mut Noise) -> Axis<f32> {
    let counts = [0, 1, 2, 3, 5, usize::MAX];
    Axis {
        first: number(random),
        last: number(random),
        per_unit: number(random),
        count: counts[random.word() as usize % counts.len()],
    }
}

#[test]
fn any_bits_do_not_panic_and_fire_no_nan() {
    let runs = if cfg!(debug_assertions) {
        20_000
    } else {
        200_000
    };
    let mut random = Noise(3);
    let mut fired = 0;
    for _ in 0..runs {
        let knots: Vec<Knot<f32>> = (0..random.word() % 5)
            .map(|_| {
                knot(
                    number(&mut random),
                    number(&mut random),
                    number(&mut random),
                )
            })
            .collect();
        let nodes: Vec<[f32; 2]> = (0..random.word() % 9)
            .map(|_| [number(&mut random), number(&mut random)])
            .collect();
        let taps: Vec<f32> = (0..random.word() % 20)
            .map(|_| number(&mut random))
            .collect();
        let first: Vec<[f32; 2]> = (0..random.word() % 3)
            .map(|_| [number(&mut random), number(&mut random)])
            .collect();
        let gait = any_gait(&mut random, &knots, &nodes, (&taps, &first));
        let rear = random.word() % 16;
        let rear = if rear == 15 { u32::MAX } else { rear };
        let forwards = random.word().is_multiple_of(2);
        let mut runner = Runner::new(gait, rear, whole(&mut random), forwards);
        let signals = Signals::new(gait.instruments, &taps);
        let mut standing = Standing::new();
        for _ in 0..300 {
            let readings = any_readings(&mut random);
            standing.take(&signals, &readings);
        }
        if let Ok(leg) = standing.rear_leg(&signals, gait.legs, number(&mut random)) {
            assert!(leg < gait.legs);
        }
        for _ in 0..40 {
            match random.word() % 20 {
                0 => runner.turn_round(whole(&mut random)),
                1 => runner.demand(number(&mut random)),
                2 => runner.sense(number(&mut random)),
                _ => {}
            }
            let action = runner.step(&any_readings(&mut random));
            assert!(!action.valve_open.is_nan() && action.valve_open >= 0.0);
            if let Some(leg) = action.leg {
                assert!(
                    (3..=12).contains(&gait.legs) && leg < gait.legs,
                    "{action:?}"
                );
                assert!(action.lean >= action.firing_angle && action.valve_open > 0.0);
                fired += 1;
            }
        }
    }
    assert!(fired > runs / 10, "{fired}");
}
