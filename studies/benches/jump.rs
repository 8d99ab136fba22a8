//! One stance, by each route.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use saltus_lagrangian::{Batch, Launch, Stance};
use saltus_numeric::{Dual, Scalar};
use saltus_robot::Robot;

/// Error tolerance of the planner.
const TOLERANCE: f64 = 2e-9;

fn jumps(c: &mut Criterion) {
    let robot = Robot::rats_planar();
    let launch = Launch {
        rate: 5.0,
        lean: -0.35,
        firing_angle: -0.1,
        valve_open: 0.1,
    };
    let stance = Stance::<f64>::new(&robot, |_, x| x).with_tolerance(TOLERANCE);
    c.bench_function("jump", |b| b.iter(|| stance.jump(black_box(&launch))));
    c.bench_function("trace", |b| b.iter(|| stance.trace(black_box(&launch))));

    let dual = Stance::<Dual<4>>::new(&robot, |_, x| Dual::of(x)).with_tolerance(TOLERANCE);
    let sensitive = Launch {
        rate: Dual::variable(5.0, 0),
        lean: Dual::of(-0.35),
        firing_angle: Dual::variable(-0.1, 1),
        valve_open: Dual::variable(0.1, 2),
    };
    c.bench_function("jump with four derivatives", |b| {
        b.iter(|| dual.jump(black_box(&sensitive)));
    });

    let batch = Batch::new(&robot, TOLERANCE);
    let many: Vec<Launch> = (0..1000)
        .map(|i| Launch {
            rate: 3.0 + 0.003 * f64::from(i),
            ..launch
        })
        .collect();
    let mut group = c.benchmark_group("batch");
    group.throughput(Throughput::Elements(1000));
    group.bench_function("1000 jumps in SIMD lanes", |b| {
        b.iter(|| batch.jumps(black_box(&many)));
    });
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = jumps
}
criterion_main!(benches);
