//! Plans every problem of a parkour file and prints the time of each and of all: `parkour
//! [INSTANCES.json [PLANS.json]]`; without a file the 58 problems of the reference.

use std::time::Instant;

use saltus_planner::course::{Answer, Course, Obstacle, Settings, Span, plan};
use saltus_planner::parkour::Hopper;
use serde::Deserialize;
use serde_json::{Value, json};

#[derive(Deserialize)]
struct File {
    instances: Vec<Instance>,
}

#[derive(Deserialize)]
struct Instance {
    id: String,
    start_x_m: f64,
    start_height_m: f64,
    jumps: usize,
    goal_x_m: f64,
    obstacles: Vec<Item>,
    no_landing: Vec<Item>,
    published: Value,
}

#[derive(Deserialize)]
#[expect(
    clippy::struct_field_names,
    reason = "the file's keys carry their unit"
)]
struct Item {
    center_x_m: f64,
    width_m: f64,
    #[serde(default)]
    height_m: f64,
}

impl From<&Instance> for Course {
    fn from(i: &Instance) -> Course {
        let obstacle = |o: &Item| Obstacle {
            center: o.center_x_m,
            width: o.width_m,
            height: o.height_m,
        };
        let area = |a: &Item| {
            Span::new(
                a.center_x_m - a.width_m / 2.0,
                a.center_x_m + a.width_m / 2.0,
            )
        };
        Course {
            id: i.id.clone(),
            start: i.start_x_m,
            start_height: i.start_height_m,
            jumps: i.jumps,
            goal: Span::point(i.goal_x_m),
            obstacles: i.obstacles.iter().map(obstacle).collect(),
            no_landing: i.no_landing.iter().map(area).collect(),
        }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let file = args.next().unwrap_or(
        concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../tests/reference/parkour-hopper/instances.json"
        )
        .into(),
    );
    let file: File = serde_json::from_str(&std::fs::read_to_string(file)?)?;
    let (hopper, settings) = (Hopper::default(), Settings::default());
    let mut plans = Vec::new();
    let mut times = Vec::new();
    for instance in &file.instances {
        let course = Course::from(instance);
        let mut best = f64::INFINITY;
        let mut answer = plan(&hopper, &course, &settings)?;
        for _ in 0..20 {
            let begin = Instant::now();
            answer = plan(&hopper, &course, &settings)?;
            best = best.min(begin.elapsed().as_secs_f64());
        }
        times.push(best);
        let published = instance.published["total_flight_time_s"]
            .as_f64()
            .unwrap_or(f64::NAN);
        let Answer::Plan(plan) = answer else {
            println!("{:18} {:8.1} µs  {answer:?}", instance.id, best * 1e6);
            continue;
        };
        println!(
            "{:18} {:8.1} µs  {:6} nodes {:4} solves {:3} QPs  {:?} kkt {:.1e} violation {:.1e}  \
             {:.6} s, bound {:.6}, gain {:+.6}",
            instance.id,
            best * 1e6,
            plan.nodes,
            plan.solves,
            plan.report.iterations,
            plan.report.status,
            plan.report.kkt_residual,
            plan.report.violation,
            plan.cost,
            plan.bound,
            published - plan.cost
        );
        let launches: Vec<_> = plan.jumps.iter().map(|j| hopper.launch(j)).collect();
        plans.push(json!({
            "id": instance.id,
            "flight_time_s": launches.iter().map(|l| l.flight_time).collect::<Vec<_>>(),
            "launch_speed_m_s": launches.iter().map(|l| l.speed).collect::<Vec<_>>(),
            "launch_angle_rad": launches.iter().map(|l| l.angle).collect::<Vec<_>>(),
        }));
    }
    times.sort_by(f64::total_cmp);
    let middle = times.len() / 2;
    println!(
        "median {:.1} µs, worst {:.1} µs",
        times[middle] * 1e6,
        times[times.len() - 1] * 1e6
    );
    if let Some(out) = args.next() {
        std::fs::write(out, serde_json::to_string(&json!({ "plans": plans }))?)?;
    }
    Ok(())
}
