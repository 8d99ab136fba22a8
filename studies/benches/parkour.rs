//! Time to plan the published parkour problems: all of them, an empty one, and one of the hardest.

use criterion::{Criterion, criterion_group, criterion_main};
use saltus_planner::course::{Course, Obstacle, Settings, Span, plan};
use saltus_planner::parkour::Hopper;
use serde_json::Value;

fn courses() -> Vec<Course> {
    let text = include_str!("../../tests/reference/parkour-hopper/instances.json");
    let file: Value = serde_json::from_str(text).unwrap_or_default();
    file["instances"]
        .as_array()
        .into_iter()
        .flatten()
        .map(course)
        .collect()
}

fn course(i: &Value) -> Course {
    let number = |v: &Value, key: &str| v[key].as_f64().unwrap_or(f64::NAN);
    let items = |key: &str| i[key].as_array().cloned().unwrap_or_default();
    let obstacle = |o: &Value| Obstacle {
        center: number(o, "center_x_m"),
        width: number(o, "width_m"),
        height: number(o, "height_m"),
    };
    let area = |a: &Value| {
        let (center, half) = (number(a, "center_x_m"), number(a, "width_m") / 2.0);
        Span::new(center - half, center + half)
    };
    Course {
        id: i["id"].as_str().unwrap_or_default().into(),
        start: number(i, "start_x_m"),
        start_height: number(i, "start_height_m"),
        jumps: i["jumps"]
            .as_u64()
            .and_then(|n| usize::try_from(n).ok())
            .unwrap_or(0),
        goal: Span::point(number(i, "goal_x_m")),
        obstacles: items("obstacles").iter().map(obstacle).collect(),
        no_landing: items("no_landing").iter().map(area).collect(),
    }
}

fn parkour(c: &mut Criterion) {
    let (courses, hopper, settings) = (courses(), Hopper::default(), Settings::default());
    c.bench_function("parkour/all 58", |b| {
        b.iter(|| {
            courses
                .iter()
                .map(|course| plan(&hopper, course, &settings))
                .collect::<Vec<_>>()
        });
    });
    for id in ["static-00", "static-06", "disturbances-05"] {
        let Some(course) = courses.iter().find(|c| c.id == id) else {
            continue;
        };
        c.bench_function(&format!("parkour/{id}"), |b| {
            b.iter(|| plan(&hopper, course, &settings));
        });
    }
}

criterion_group!(benches, parkour);
criterion_main!(benches);
