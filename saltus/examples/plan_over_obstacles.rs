//! A plan over the thesis' box, 21 cm square, with every limit held against the full model.
//!
//! `cargo run -p saltus --example plan_over_obstacles`

use std::error::Error;

use saltus::planner::course::{Course, Obstacle, Span};
use saltus::planner::{Crossing, CrossingAnswer};
use saltus::{Planner, Robot};

fn main() -> Result<(), Box<dyn Error>> {
    let planner = Planner::new(Robot::rats_planar());
    let course = Course {
        id: "a box".into(),
        start: 0.0,
        start_height: 0.0,
        jumps: 1,
        goal: Span::new(0.8, 1.0),
        obstacles: vec![Obstacle {
            center: 0.435,
            width: 0.21,
            height: 0.21,
        }],
        no_landing: Vec::new(),
    };
    // At 5.5 rad/s; the wheel stays a centimetre clear of the box, and the foot must hold on
    // rubber.
    let crossing = Crossing {
        clearance: 0.01,
        friction: Some(0.8),
        ..Crossing::new(course, 5.5)
    };

    match planner.cross(&crossing)? {
        CrossingAnswer::Plan(plan) => {
            for (number, planned) in plan.jumps.iter().enumerate() {
                let launch = planned.jump.launch;
                println!(
                    "jump {}: from {:.3} m, fire at {:.4} rad, valve open {:.1} ms, land at {:.3} \
                     ± {:.3} m",
                    number + 1,
                    planned.foot[0],
                    launch.firing_angle,
                    1e3 * launch.valve_open,
                    planned.landing[0],
                    planned.deviation,
                );
            }
            for check in &plan.checks {
                let verdict = if check.holds() { "holds" } else { "FAILS" };
                let Span { low, high } = check.allowed;
                println!(
                    "{verdict}: {} = {:.4}, from {low:.4} to {high:.4}",
                    check.what, check.value
                );
            }
            println!("holds in the planar model: {}", plan.holds());
        }
        CrossingAnswer::Infeasible { relief, .. } => println!("there is no plan: {relief:?}"),
        CrossingAnswer::Undecided { nodes, .. } => println!("none found in {nodes} nodes"),
    }
    Ok(())
}
