//! The drill of `firmware/drill.c` in Rust: the same inputs, and a hash of the answers.
//!
//!     cargo run --release -p saltus-controller --example drill -- [DECISIONS [AT_FIRING]]
//!
//! With 1 for `AT_FIRING`, approach rates count at the firing angle.

use saltus_controller::qp::{self, HalfPlane};
use saltus_controller::{Approach, Decision, Obstacle, Reason, Sensed, TakeOff, Task, Timing};

#[rustfmt::skip]
#[path = "rats_planar/tables.rs"]
mod tables;

use tables::RATS_PLANAR;

/// Inputs, the same on every machine.
struct Draw(u32);

impl Draw {
    /// From low to high, in steps of the difference over 2²⁴.
    fn between(&mut self, low: f32, high: f32) -> f32 {
        self.0 = self.0.wrapping_mul(2_891_336_453).wrapping_add(12345);
        low + (high - low) * ((self.0 >> 8) as f32 / 16_777_216.0)
    }

    fn decision(&mut self) -> (Sensed<f32>, Task<f32>) {
        let sensed = Sensed {
            lean: self.between(-0.55, 0.35),
            rate: self.between(2.0, 6.5),
        };
        let distance = self.between(0.15, 0.85);
        let front = self.between(0.2, 0.5);
        let back = front + self.between(0.0, 0.2);
        let obstacle = Obstacle {
            front,
            back,
            height: self.between(0.0, 0.15),
            clearance: self.between(0.0, 0.02),
        };
        let obstacle = (self.between(0.0, 1.0) < 0.75).then_some(obstacle);
        (
            sensed,
            Task {
                distance,
                landing_height: 0.24,
                obstacle,
                guess: None,
            },
        )
    }

    fn approach(&mut self) -> Approach<f32> {
        Approach {
            distance: self.between(0.1, 1.6),
            height: self.between(0.0, 0.15),
            length: self.between(0.01, 0.2),
            speed: self.between(0.7, 1.5),
            clearance: self.between(0.0, 0.02),
        }
    }

    fn program(&mut self) -> ([f32; 3], [f32; 2], [HalfPlane<f32>; 8]) {
        let [a, b, c] = std::array::from_fn(|_| self.between(-1.0, 1.0));
        let h = [a * a + 0.1, a * b, b * b + c * c + 0.1];
        let g = std::array::from_fn(|_| self.between(-1.0, 1.0));
        let constraints = std::array::from_fn(|_| HalfPlane {
            normal: std::array::from_fn(|_| self.between(-1.0, 1.0)),
            bound: self.between(-0.25, 1.0),
        });
        (h, g, constraints)
    }
}

/// FNV-1a over words, least byte first.
struct Hash(u32);

impl Hash {
    fn word(&mut self, word: u32) {
        for byte in word.to_le_bytes() {
            self.0 = (self.0 ^ u32::from(byte)).wrapping_mul(16_777_619);
        }
    }

    fn numbers(&mut self, numbers: &[f32]) {
        for x in numbers {
            self.word(x.to_bits());
        }
    }

    fn decision(&mut self, answer: &Decision<f32>) {
        let (timing, time) = match answer.timing {
            Timing::Wait(time) => (0, time),
            Timing::Fire(time) => (1, time),
            Timing::Late(time) => (2, time),
        };
        self.numbers(&[
            answer.approach_rate,
            answer.firing_angle,
            answer.valve_open,
            time,
        ]);
        self.word(timing);
        self.word(u32::from(answer.settled));
    }

    fn take_off(&mut self, answer: &TakeOff<f32>) {
        self.word(answer.touch_down);
        self.numbers(&[
            answer.approach_rate,
            answer.firing_angle,
            answer.distance,
            answer.clearance,
        ]);
    }
}

/// Runs `calls` of them and prints what the firmware prints.
fn drill<A>(
    what: &str,
    seed: u32,
    calls: u32,
    call: impl Fn(&mut Draw) -> Result<A, Reason>,
    put: impl Fn(&mut Hash, &A),
) {
    let (mut draw, mut hash, mut answered) = (Draw(seed), Hash(2_166_136_261), 0);
    for _ in 0..calls {
        let answer = call(&mut draw);
        hash.word(answer.as_ref().map_or_else(|reason| *reason as u32, |_| 0));
        if let Ok(answer) = answer {
            answered += 1;
            put(&mut hash, &answer);
        }
    }
    println!(
        "{what}: {calls} calls, {answered} answered, hash {:08x}",
        hash.0
    );
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let decisions: u32 = arguments
        .next()
        .map_or(10_000, |text| text.parse().expect("a number of decisions"));
    let mut controller = RATS_PLANAR;
    controller.rates.at_firing = arguments.next().is_some_and(|text| text == "1");
    let decide = |draw: &mut Draw, with_obstacle: bool| {
        let (sensed, mut task) = draw.decision();
        if !with_obstacle {
            task.obstacle = None;
        }
        controller.decide(&sensed, &task)
    };
    drill(
        "decisions without an obstacle",
        1,
        decisions,
        |draw| decide(draw, false),
        Hash::decision,
    );
    drill(
        "decisions",
        1,
        decisions,
        |draw| decide(draw, true),
        Hash::decision,
    );
    let take_off = |draw: &mut Draw| {
        controller
            .take_off(&draw.approach())
            .map_err(|no| no.reason)
    };
    drill("take-offs", 2, decisions / 50, take_off, Hash::take_off);
    let solve = |draw: &mut Draw| {
        let (h, g, constraints) = draw.program();
        qp::two(h, g, &constraints)
    };
    drill(
        "programs of 8 constraints",
        3,
        decisions / 2,
        solve,
        |hash, x| hash.numbers(x),
    );
}
