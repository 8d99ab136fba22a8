//! Plans of the hopper as a drawing.

use saltus::planner::course::{Answer, Course, Jump, Span};
use saltus::planner::parkour::Hopper;

use super::{hopper, jumps, launches, total_time};
use crate::output::digits;
use crate::plot::ground::Ground;
use crate::plot::hops::{Hop, Hops, Panel};

/// Each course with its plan, if there is one.
pub(super) fn hops(answers: &[(&Course, Answer)], hopper: &Hopper) -> Hops {
    Hops {
        panels: answers
            .iter()
            .map(|(course, answer)| panel(course, answer, hopper))
            .collect(),
    }
}

fn panel(course: &Course, answer: &Answer, hopper: &Hopper) -> Panel {
    let ends = |span: &Span| (span.low, span.high);
    let (said, hops) = match answer {
        Answer::Plan(plan) => {
            let total = total_time(&launches(plan, hopper));
            let said = format!("{}, {total:.4} s in flight", jumps(plan.jumps.len()));
            (
                said,
                plan.jumps.iter().map(|jump| hop(jump, hopper)).collect(),
            )
        }
        Answer::Infeasible(_) => ("no plan".into(), Vec::new()),
        Answer::Undecided { .. } => ("undecided".into(), Vec::new()),
    };
    Panel {
        title: format!("{}: {}: {said}", hopper::NAME, course.id),
        start: (course.start, course.start_height),
        ground: Ground {
            obstacles: course
                .obstacles
                .iter()
                .map(|it| (ends(&it.span()), it.height))
                .collect(),
            avoid: course.no_landing.iter().map(ends).collect(),
            land: Vec::new(),
            goal: None,
            target: Some(0.5 * (course.goal.low + course.goal.high)),
            target_name: "goal",
            missed: Vec::new(),
        },
        hops,
    }
}

fn hop(jump: &Jump, hopper: &Hopper) -> Hop {
    const POINTS: u32 = 400;
    let launch = hopper.launch(jump);
    let (sin, cos) = launch.angle.sin_cos();
    let foot = (jump.foot, jump.leap.from);
    let hip = (foot.0 + hopper.leg * cos, foot.1 + hopper.leg * sin);
    let from = (hip.0 + hopper.foot[0], hip.1 + hopper.foot[1]);
    let at = |i: u32| {
        let time = launch.flight_time * f64::from(i) / f64::from(POINTS);
        let up = launch.speed * sin * time - 0.5 * hopper.gravity * time * time;
        (from.0 + launch.speed * cos * time, from.1 + up)
    };
    let arc: Vec<(f64, f64)> = (0..=POINTS).map(at).collect();
    Hop {
        foot,
        hip,
        knee: arc
            .iter()
            .map(|(x, y)| (x + hopper.knee[0], y + hopper.knee[1]))
            .collect(),
        arc,
        label: [
            format!("{} s", digits(launch.flight_time, 4)),
            format!(
                "{} m/s at {} rad",
                digits(launch.speed, 4),
                digits(launch.angle, 4)
            ),
        ],
    }
}
