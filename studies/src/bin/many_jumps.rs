//! Jumps of the library alone, as `bench/python_speed.py` asks Python for them:
//! `cd studies && cargo run --release --bin many_jumps -- COUNT`.
//!
//! Prints the seconds of `COUNT` jumps on one thread and on two, and of one jump, the least of several rounds.

use std::hint::black_box;
use std::time::Instant;

use saltus_lagrangian::{Batch, FINE, Launch};
use saltus_numeric::parallel::in_chunks;
use saltus_robot::Robot;

/// Jumps that are computed side by side, as by `saltus simulate`.
const SIDE_BY_SIDE: usize = 256;
/// Calls for one jump that are timed together, and how often: the least counts.
const CALLS: u32 = 100;
const ROUNDS: u32 = 30;

fn main() {
    let count: u32 = std::env::args()
        .nth(1)
        .map_or(20_000, |count| count.parse().expect("a number of jumps"));
    let launches: Vec<Launch> = (0..count)
        .map(|k| Launch {
            rate: 3.0 + 3.0 * f64::from(k) / f64::from(count),
            lean: -0.1,
            firing_angle: -0.1,
            valve_open: 0.1,
        })
        .collect();
    let batch = Batch::new(&Robot::rats_planar(), FINE);
    for threads in [1, 2] {
        let start = Instant::now();
        black_box(in_chunks(&launches, SIDE_BY_SIDE, threads, |part| {
            batch.jumps(part)
        }));
        println!("{threads} threads: {} s", start.elapsed().as_secs_f64());
    }
    let one = || {
        let start = Instant::now();
        for _ in 0..CALLS {
            black_box(batch.jumps(black_box(&launches[..1])));
        }
        start.elapsed().as_secs_f64() / f64::from(CALLS)
    };
    let least = (0..ROUNDS).map(|_| one()).fold(f64::INFINITY, f64::min);
    println!("one jump: {least} s");
}
