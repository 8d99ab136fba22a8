//! The drill of learnt tables: what `controller/firmware/policy.c` does in C, in Rust. The lines that both print are the same.
//!
//! `cd studies && cargo run --release --bin policy_drill -- 1000000 float`

use saltus_controller::Real;
use saltus_controller::run::{Choices, Steps};

/// States asked of each table.
const EACH: u32 = 1000;

struct Words(u32);

impl Words {
    fn word(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(2_891_336_453).wrapping_add(12_345);
        self.0 >> 8
    }

    fn below(&mut self, count: u32) -> u16 {
        u16::try_from(self.word() % count).unwrap_or(0)
    }

    fn between<R: Real>(&mut self, low: R, high: R) -> R {
        low + (high - low) * (R::of(f64::from(self.word())) / R::of(16_777_216.0))
    }
}

fn drawn<R: Real>(words: &mut Words) -> (usize, Vec<Steps<R>>, Vec<u8>) {
    let axes = 2 + words.word() % 3;
    let steps = (0..4).map(|k| {
        let from = words.between(R::of(-20.0), R::of(1.0));
        let to = from + words.between(R::of(0.1), R::of(40.0));
        let count = 1 + words.below(if k < 2 { 31 } else { 4 });
        Steps { from, to, count }
    });
    let steps = steps.collect();
    let choices = (0..31 * 31 * 4 * 4).map(|_| u8::try_from(words.word() % 6).unwrap_or(0));
    let choices = choices.collect();
    (axes as usize, steps, choices)
}

fn observed<R: Real>(steps: &Steps<R>, words: &mut Words) -> R {
    let width = steps.to - steps.from;
    match words.word() % 8 {
        0 => words.between(R::of(-1e6), R::of(1e6)),
        1 => {
            let border = words.below(u32::from(steps.count) + 1);
            let of = |count: u16| R::of(f64::from(count));
            steps.from + width * of(border) / of(steps.count)
        }
        2 => R::of(f64::NAN),
        _ => {
            let out = width / R::of(10.0);
            words.between(steps.from - out, steps.to + out)
        }
    }
}

fn drill<R: Real>(states: u32) -> u32 {
    let mut words = Words(1);
    let mut hash: u32 = 2_166_136_261;
    let (mut axes, mut steps, mut choices) = (0, Vec::new(), Vec::new());
    for k in 0..states {
        if k % EACH == 0 {
            (axes, steps, choices) = drawn::<R>(&mut words);
        }
        let seen: Vec<R> = steps.iter().map(|it| observed(it, &mut words)).collect();
        let table = Choices {
            axes: &steps[..axes],
            choices: &choices,
        };
        let choice = table.at(&seen[..axes]).unwrap_or(255);
        hash = (hash ^ u32::from(choice)).wrapping_mul(16_777_619);
    }
    hash
}

fn main() -> Result<(), std::num::ParseIntError> {
    let mut arguments = std::env::args().skip(1);
    let states = arguments.next().map_or(Ok(10_000), |text| text.parse())?;
    let hash = match arguments.next().as_deref() {
        Some("double") => drill::<f64>(states),
        _ => drill::<f32>(states),
    };
    println!("choices: {states} calls, {states} answered, hash {hash:08x}");
    Ok(())
}
