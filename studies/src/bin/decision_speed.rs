//! How long a look-up, a quadratic program and a decision take, each waiting for the one before.
//!
//!     cd studies && cargo run --release --bin decision_speed

use std::hint::black_box;
use std::time::Instant;

use saltus_controller::qp::{self, HalfPlane};
use saltus_controller::{Obstacle, Rule, Sensed, Task};

#[rustfmt::skip]
#[path = "../../../controller/examples/rats_planar/tables.rs"]
mod tables;

use tables::RATS_PLANAR;

/// Inputs gone through in turn.
const INPUTS: usize = 4096;

/// Numbers from 0 to 1, the same each time.
struct Draw(u32);

impl Draw {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(2_891_336_453).wrapping_add(12345);
        f64::from(self.0 >> 8) / f64::from(1 << 24)
    }

    fn between(&mut self, low: f32, high: f32) -> f32 {
        #[allow(clippy::cast_possible_truncation)]
        let part = self.next() as f32;
        low + (high - low) * part
    }

    /// Normally distributed, nearly: by the sum of twelve.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.next()).sum::<f64>() - 6.0
    }
}

/// Median, least and greatest over 101 rounds of the time (ns) that `call` takes for an input and
/// the answer before.
fn latency<R: Copy + Default>(what: &str, call: impl Fn(usize, R) -> R) {
    let rounds = if cfg!(debug_assertions) { 2 } else { 10 };
    let mut times: Vec<f64> = (0..101)
        .map(|_| {
            let start = Instant::now();
            let mut last = R::default();
            for _ in 0..rounds {
                for k in 0..INPUTS {
                    last = call(black_box(k), last);
                }
            }
            black_box(last);
            start.elapsed().as_secs_f64() * 1e9 / (rounds * INPUTS) as f64
        })
        .collect();
    times.sort_by(f64::total_cmp);
    println!(
        "{what:46} {:7.1} ns [{:.1}..{:.1}]",
        times[50], times[0], times[100]
    );
}

/// H, g and constraints of a quadratic program.
type Program = ([f64; 3], [f64; 2], [HalfPlane<f64>; 8]);

/// Problems: H = L Lᵀ + 0.1, constraints about a point inside.
fn programs(draw: &mut Draw) -> Vec<Program> {
    (0..INPUTS)
        .map(|_| {
            let [a, b, c, d] = std::array::from_fn(|_| draw.normal());
            let h = [a * a + b * b + 0.1, a * c + b * d, c * c + d * d + 0.1];
            let g = std::array::from_fn(|_| 3.0 * draw.normal());
            let inside: [f64; 2] = std::array::from_fn(|_| draw.normal());
            let constraints = std::array::from_fn(|_| {
                let normal: [f64; 2] = std::array::from_fn(|_| draw.normal());
                HalfPlane {
                    normal,
                    bound: normal[0] * inside[0] + normal[1] * inside[1] + 0.05 + draw.next(),
                }
            });
            (h, g, constraints)
        })
        .collect()
}

fn main() {
    let mut draw = Draw(1);
    let Rule::Table(table) = RATS_PLANAR.rule else {
        return;
    };
    // Where the table answers: a reason is quicker.
    let spots: Vec<[f32; 2]> =
        std::iter::repeat_with(|| [draw.between(3.0, 6.0), draw.between(0.2, 0.8)])
            .filter(|[rate, distance]| table.firing_angle(*rate, *distance).is_ok())
            .take(INPUTS)
            .collect();
    latency("table look-up (f32)", |k, last: f32| {
        table
            .firing_angle(spots[k][0] + last * 1e-20, spots[k][1])
            .unwrap_or(0.0)
    });

    let problems = programs(&mut draw);
    latency(
        "QP of 2 variables and 8 constraints (f64)",
        |k, last: f64| {
            let (h, g, constraints) = &problems[k];
            qp::two(*h, [g[0] + last * 1e-20, g[1]], constraints).map_or(0.0, |x| x[0])
        },
    );

    let jumps: Vec<(Sensed<f32>, Task<f32>, Obstacle<f32>)> = std::iter::repeat_with(|| {
        let sensed = Sensed {
            lean: draw.between(-0.5, 0.0),
            rate: draw.between(3.0, 6.0),
        };
        let front = draw.between(0.26, 0.4);
        let obstacle = Obstacle {
            front,
            back: front + draw.between(0.01, 0.1),
            height: draw.between(0.0, 0.1),
            clearance: 0.01,
        };
        let task = Task {
            distance: draw.between(0.25, 0.6),
            landing_height: 0.24,
            obstacle: None,
            guess: None,
        };
        (sensed, task, obstacle)
    })
    .filter(|(sensed, task, obstacle)| {
        let over = Task {
            obstacle: Some(*obstacle),
            ..*task
        };
        RATS_PLANAR.decide(sensed, task).is_ok() && RATS_PLANAR.decide(sensed, &over).is_ok()
    })
    .take(INPUTS)
    .collect();
    let decide = |k: usize, last: f32, with_obstacle: bool| {
        let (mut sensed, mut task, obstacle) = jumps[k];
        sensed.rate += last * 1e-20;
        task.obstacle = with_obstacle.then_some(obstacle);
        RATS_PLANAR
            .decide(&sensed, &task)
            .map_or(0.0, |d| d.firing_angle)
    };
    latency("decision: table, Newton step, instant (f32)", |k, last| {
        decide(k, last, false)
    });
    latency("decision over an obstacle: QP of 2 variables", |k, last| {
        decide(k, last, true)
    });
}
