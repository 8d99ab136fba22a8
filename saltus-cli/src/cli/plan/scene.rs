//! Plans as a drawing.

use saltus::course::ANYWHERE;
use saltus::planner::course::Span;
use saltus::planner::{
    Check, Corrected, Crossing, CrossingAnswer, JumpModel, PlannedJump, Planner,
};

use super::report::{Answer, off_target};
use crate::output::digits;
use crate::plot::ground::Ground;
use crate::plot::scene::{Leap, Scene};

/// The course with the plan, if there is one.
pub(super) fn scene(
    answer: &Answer,
    crossing: &Crossing,
    planner: &Planner<Corrected>,
    file: &str,
) -> Scene {
    let (jumps, checks) = match answer {
        CrossingAnswer::Plan(plan) => (plan.jumps.as_slice(), plan.checks.as_slice()),
        _ => (&[][..], &[][..]),
    };
    let missed: Vec<&Check> = checks.iter().filter(|check| !check.holds()).collect();
    let goal = (crossing.course.goal.low > ANYWHERE.low
        || crossing.course.goal.high < ANYWHERE.high)
        .then(|| ends(&crossing.course.goal));
    let radius = planner.robot().body.radius;
    let leaps = jumps.iter().enumerate().map(|(i, jump)| Leap {
        fails: missed.iter().any(|check| check.jump == i),
        ..leap(jump, planner)
    });
    let boxes = crossing
        .course
        .obstacles
        .iter()
        .map(|obstacle| (ends(&obstacle.span()), obstacle.height));
    Scene {
        title: match jumps {
            [] => format!("{}: no plan for {file}", planner.robot().name),
            [.., last] => format!(
                "{}: plan for {file}: lands {}",
                planner.robot().name,
                off_target(last.landing[0], crossing.target)
            ),
        },
        missed: missed
            .iter()
            .map(|check| {
                format!(
                    "FAILS: jump {}: {} {}",
                    check.jump + 1,
                    check.what,
                    digits(check.value, 4)
                )
            })
            .collect(),
        radius,
        start: (crossing.course.start, crossing.course.start_height),
        ground: Ground {
            obstacles: boxes.collect(),
            avoid: crossing.course.no_landing.iter().map(ends).collect(),
            land: crossing.zones.iter().flatten().map(ends).collect(),
            goal,
            target: Some(crossing.target),
            target_name: "target",
            missed: Vec::new(),
        },
        leaps: leaps.collect(),
    }
}

fn ends(span: &Span) -> (f64, f64) {
    (span.low, span.high)
}

fn leap(planned: &PlannedJump, planner: &Planner<Corrected>) -> Leap {
    const POINTS: usize = 400;
    let [x, y] = planned.foot;
    let launch = &planned.jump.launch;
    let angle = digits(launch.firing_angle, 3);
    // The plan was flown already, so there is a trace.
    let way = planner.model().traced(launch).map(|traced| traced.way);
    let end = planner.robot().body.radius + planned.landing[1] - y;
    let flight = planned
        .jump
        .flight
        .as_ref()
        .and_then(|flight| Some((flight, flight.time_to_height(end).ok()?)));
    let flight = flight.map_or(Vec::new(), |(flight, time)| {
        let at = |k: usize| {
            let [[dx, dy], _] = flight.motion(time * k as f64 / POINTS as f64);
            (x + dx, y + dy)
        };
        (0..=POINTS).map(at).collect()
    });
    Leap {
        foot: (x, y),
        stance: way
            .unwrap_or_default()
            .iter()
            .map(|at| (x + at.centre[0], y + at.centre[1]))
            .collect(),
        flight,
        fails: false,
        label: if planner.robot().leg.drive.has_valve() {
            format!(
                "α_f = {angle} rad, valve {} ms",
                digits(1e3 * launch.valve_open, 3)
            )
        } else {
            format!("α_f = {angle} rad")
        },
    }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use saltus::Robot;
    use saltus::on_plant::for_crossing;
    use saltus::planner::course::{Course, Standing};

    use super::*;

    #[test]
    fn a_plan_that_fails_is_drawn_in_red_and_says_why() {
        let goal = Span::new(1.6, 1.9);
        let course = Course {
            id: "two".into(),
            start: 0.0,
            start_height: 0.0,
            jumps: 2,
            goal,
            obstacles: vec![],
            no_landing: vec![],
        };
        let crossing = Crossing::new(course, 5.0);
        let go_on = |_: &Standing| ControlFlow::Continue(());
        let crossed = for_crossing(Robot::rats_planar(), None, &crossing, &go_on).unwrap();
        let CrossingAnswer::Plan(mut plan) = crossed.answer else {
            panic!("no plan")
        };
        let planner = crossed.planner;
        let drawn = |plan| scene(&CrossingAnswer::Plan(plan), &crossing, &planner, "two.toml");
        let good = drawn(plan.clone());
        assert!(good.missed.is_empty() && good.leaps.iter().all(|leap| !leap.fails));
        assert_eq!(good.ground.goal, Some((1.6, 1.9)));
        let allowed = Span::new(0.01, f64::INFINITY);
        plan.checks.push(Check {
            jump: 1,
            what: "clearance (m)".into(),
            value: 0.004,
            allowed,
            round_off: 1e-6,
        });
        let bad = drawn(plan);
        assert_eq!(bad.missed, ["FAILS: jump 2: clearance (m) 0.004"]);
        assert_eq!(
            bad.leaps.iter().map(|leap| leap.fails).collect::<Vec<_>>(),
            [false, true]
        );
    }
}
