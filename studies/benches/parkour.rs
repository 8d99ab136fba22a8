//! Time to plan the published parkour problems: all of them, an empty one, and one of the hardest.

use criterion::{Criterion, criterion_group, criterion_main};
use saltus_planner::course::{Settings, plan};
use saltus_tests::parkour::{Hopper, published};

fn parkour(c: &mut Criterion) {
    let (problems, hopper, settings) = (published(), Hopper::default(), Settings::default());
    c.bench_function("parkour/all 58", |b| {
        b.iter(|| {
            problems
                .iter()
                .map(|problem| plan(&hopper, &problem.course, &settings))
                .collect::<Vec<_>>()
        });
    });
    for id in ["static-00", "static-06", "disturbances-05"] {
        let Some(problem) = problems.iter().find(|p| p.course.id == id) else {
            continue;
        };
        c.bench_function(&format!("parkour/{id}"), |b| {
            b.iter(|| plan(&hopper, &problem.course, &settings));
        });
    }
}

criterion_group!(benches, parkour);
criterion_main!(benches);
