//! Plans every problem of a parkour file and prints the time of each and of all: `parkour
//! [INSTANCES.json [PLANS.json]]`; without a file the 58 problems of the reference.

use std::time::Instant;

use saltus_planner::course::{Answer, Settings, plan};
use saltus_tests::parkour::{Hopper, problems, published};
use serde_json::json;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let problems = match args.next() {
        Some(file) => problems(&std::fs::read_to_string(file)?),
        None => published(),
    };
    let (hopper, settings) = (Hopper::default(), Settings::default());
    let mut plans = Vec::new();
    let mut times = Vec::new();
    for problem in &problems {
        let course = &problem.course;
        let mut best = f64::INFINITY;
        let mut answer = plan(&hopper, course, &settings)?;
        for _ in 0..20 {
            let begin = Instant::now();
            answer = plan(&hopper, course, &settings)?;
            best = best.min(begin.elapsed().as_secs_f64());
        }
        times.push(best);
        let Answer::Plan(plan) = answer else {
            println!("{:18} {:8.1} µs  {answer:?}", course.id, best * 1e6);
            continue;
        };
        println!(
            "{:18} {:8.1} µs  {:6} nodes {:4} solves {:3} QPs  {:?} kkt {:.1e} violation {:.1e}  \
             {:.6} s, bound {:.6}, gain {:+.6}",
            course.id,
            best * 1e6,
            plan.nodes,
            plan.solves,
            plan.report.iterations,
            plan.report.status,
            plan.report.kkt_residual,
            plan.report.violation,
            plan.cost,
            plan.bound,
            problem.published - plan.cost
        );
        let launches: Vec<_> = plan.jumps.iter().map(|j| hopper.launch(j)).collect();
        plans.push(json!({
            "id": course.id,
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
