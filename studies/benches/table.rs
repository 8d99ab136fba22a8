//! The firing table of 61 approach rates and 36 distances.

use criterion::{Criterion, criterion_group, criterion_main};
use saltus_planner::{FIRING_ANGLES, Measure, Planner, Roots, TableRequest};
use saltus_robot::Robot;

fn tables(c: &mut Criterion) {
    let planner = Planner::new(Robot::rats_planar());
    let grid = |low: f64, step: f64, n: u32| (0..n).map(|i| low + step * f64::from(i)).collect();
    let mut request = TableRequest {
        rates: grid(3.0, 0.05, 61),
        measure: Measure::Distance {
            landing_height: 0.0,
        },
        targets: grid(0.3, 0.02, 36),
        valve_open: 0.1,
        start_lean: None,
        firing_angles: FIRING_ANGLES,
        roots: Roots::Least,
        sensitivities: false,
        threads: 1,
    };
    c.bench_function("table 61 x 36", |b| b.iter(|| planner.table(&request)));
    request.threads = 2;
    c.bench_function("table 61 x 36, two threads", |b| {
        b.iter(|| planner.table(&request));
    });
    request.roots = Roots::All;
    c.bench_function("table 61 x 36, both roots, two threads", |b| {
        b.iter(|| planner.table(&request));
    });
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(10);
    targets = tables
}
criterion_main!(benches);
