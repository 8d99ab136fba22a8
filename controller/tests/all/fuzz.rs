//! Whatever bits come in, a value or a reason goes out: no panic, and no number that is none.
//!
//! `cargo test --release -p saltus-controller --test all fuzz -- --ignored` takes every f32 there is
//! for a rate.

use saltus_controller::qp::{self, HalfPlane};
use saltus_controller::{Approach, Controller, Guess, Observer, Obstacle, Sensed, Task, Timing};

const CONTROLLER: Controller<'static, f32> = crate::rats_planar::RATS_PLANAR;

/// Bits that break things: zeros, denormals, ends, infinities, NaN with and without payload; and
/// what is usual.
const SPECIAL: [u32; 20] = [
    0x0000_0000,
    0x8000_0000,
    0x0000_0001,
    0x8000_0001,
    0x007F_FFFF,
    0x0080_0000,
    0x7F7F_FFFF,
    0xFF7F_FFFF,
    0x7F80_0000,
    0xFF80_0000,
    0x7FC0_0000,
    0xFFC0_0000,
    0x7F80_0001,
    0xFFFF_FFFF,
    0x3F80_0000,
    0xBF00_0000,
    0x4080_0000,
    0x3ECC_CCCD,
    0x3E80_0000,
    0x4B80_0000,
];

/// Half of them special, half any bits at all.
struct Bits(u64);

impl Bits {
    fn word(&mut self) -> u32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 32) as u32
    }

    fn number(&mut self) -> f32 {
        let pick = self.word();
        match pick % 4 {
            0 => f32::from_bits(self.word()),
            1 => f32::from_bits(SPECIAL[self.word() as usize % SPECIAL.len()]),
            // What a robot may well measure, so that the depths are reached too.
            2 => (self.word() >> 8) as f32 / 16_777_216.0,
            _ => -0.6 + 7.0 * (self.word() >> 8) as f32 / 16_777_216.0,
        }
    }

    fn numbers<const N: usize>(&mut self) -> [f32; N] {
        std::array::from_fn(|_| self.number())
    }
}

fn decide(bits: &mut Bits) -> bool {
    let [
        lean,
        rate,
        distance,
        height,
        front,
        back,
        top,
        clearance,
        angle,
        valve,
    ] = bits.numbers();
    let sensed = Sensed { lean, rate };
    let obstacle = Obstacle {
        front,
        back,
        height: top,
        clearance,
    };
    let kind = bits.word();
    let task = Task {
        distance,
        landing_height: if kind.is_multiple_of(3) { height } else { 0.24 },
        obstacle: kind.is_multiple_of(2).then_some(obstacle),
        guess: kind.is_multiple_of(5).then_some(Guess {
            firing_angle: angle,
            valve_open: valve,
        }),
    };
    let mut controller = CONTROLLER;
    controller.limits.newton_steps = kind.to_le_bytes()[1];
    let Ok(d) = controller.decide(&sensed, &task) else {
        return false;
    };
    let (Timing::Wait(time) | Timing::Fire(time) | Timing::Late(time)) = d.timing;
    for x in [d.approach_rate, d.firing_angle, d.valve_open, time] {
        assert!(x.is_finite(), "{sensed:?} {task:?}: {d:?}");
    }
    assert!(
        time >= 0.0 && (2.75..=6.25).contains(&d.approach_rate),
        "{sensed:?} {task:?}: {d:?}"
    );
    // To round-off of the QP's bounds.
    let angles = controller.map.angles;
    assert!(
        (angles.first - 1e-4..=angles.last + 1e-4).contains(&d.firing_angle),
        "{sensed:?} {task:?}: {d:?}"
    );
    assert!(
        (0.03 - 1e-5..=0.04 + 1e-5).contains(&d.valve_open),
        "{sensed:?} {task:?}: {d:?}"
    );
    true
}

fn take_off(bits: &mut Bits) -> bool {
    let [distance, height, length, speed, clearance] = bits.numbers();
    let approach = Approach {
        distance,
        height,
        length,
        speed,
        clearance,
    };
    let Ok(t) = CONTROLLER.take_off(&approach) else {
        return false;
    };
    assert!(
        t.touch_down < 4 && t.distance.is_finite() && t.clearance >= clearance,
        "{approach:?}: {t:?}"
    );
    true
}

fn program(bits: &mut Bits) -> bool {
    let (h, g) = (bits.numbers(), bits.numbers());
    let constraints: [HalfPlane<f32>; 6] = std::array::from_fn(|_| HalfPlane {
        normal: bits.numbers(),
        bound: bits.number(),
    });
    let Ok(x) = qp::two(h, g, &constraints) else {
        return false;
    };
    assert!(
        x[0].is_finite() && x[1].is_finite(),
        "{h:?} {g:?} {constraints:?}: {x:?}"
    );
    true
}

#[test]
fn any_bits_give_a_value_or_a_reason() {
    let calls = if cfg!(debug_assertions) {
        1_000_000
    } else {
        20_000_000
    };
    let mut bits = Bits(1);
    let mut answered = [0, 0, 0];
    for _ in 0..calls {
        answered[0] += usize::from(decide(&mut bits));
        answered[1] += usize::from(program(&mut bits));
        answered[2] += usize::from(take_off(&mut bits));
    }
    // The drill reaches the answers, too, not only the checks.
    assert!(answered.iter().all(|n| *n > 50), "{answered:?}");
}

#[test]
fn special_bits_in_every_place() {
    let usual = [-0.3, 4.0, 0.4, 0.24, 0.3, 0.35, 0.05, 0.01, -0.1, 0.035];
    for i in 0..usual.len() {
        for j in 0..usual.len() {
            for a in SPECIAL {
                for b in SPECIAL {
                    let mut x = usual;
                    x[i] = f32::from_bits(a);
                    x[j] = f32::from_bits(b);
                    let [
                        lean,
                        rate,
                        distance,
                        landing_height,
                        front,
                        back,
                        height,
                        clearance,
                        firing_angle,
                        valve_open,
                    ] = x;
                    let task = Task {
                        distance,
                        landing_height,
                        obstacle: Some(Obstacle {
                            front,
                            back,
                            height,
                            clearance,
                        }),
                        guess: Some(Guess {
                            firing_angle,
                            valve_open,
                        }),
                    };
                    if let Ok(d) = CONTROLLER.decide(&Sensed { lean, rate }, &task) {
                        assert!(
                            d.firing_angle.is_finite() && d.valve_open.is_finite(),
                            "{x:?}: {d:?}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn an_observer_survives_any_reading() {
    let start = Sensed {
        lean: -0.3_f32,
        rate: 4.0,
    };
    for bits in SPECIAL {
        let mut observer = Observer {
            sensed: start,
            period: 1e-3,
            pendulum: 27.0,
            memory: 0.8,
        };
        observer.update(f32::from_bits(bits));
        let reading = f32::from_bits(bits);
        // A reading that is no number only lets time pass.
        assert!(
            reading.is_finite() || (observer.sensed.rate - start.rate).abs() < 0.1,
            "{reading}"
        );
    }
}

#[test]
#[ignore = "nightly: 300 s in release, section floats"]
fn every_rate_there_is() {
    let mut answered = 0_u32;
    for bits in 0..=u32::MAX {
        let rate = f32::from_bits(bits);
        if let Ok(angle) = CONTROLLER.firing_angle(rate, 0.4, 0.24) {
            assert!(
                angle.is_finite() && (2.75..=6.25).contains(&rate),
                "{bits:08x}"
            );
            answered += 1;
        }
    }
    // f32 from 2.75 to 6.25: 2²² a unit below 4, 2²¹ above.
    assert!(answered > 4_000_000, "{answered}");
}
