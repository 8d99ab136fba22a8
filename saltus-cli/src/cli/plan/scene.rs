//! Plans as a drawing.

use std::path::Path;

use saltus::Jump;
use saltus::course::ANYWHERE;
use saltus::planner::course::Span;
use saltus::planner::{
    Check, Corrected, Crossing, CrossingAnswer, JumpModel, PlannedJump, Planner,
};

use super::report::{Answer, off_target};
use crate::output::{digits, file_name, measured};
use crate::plot::ground::{CELLAR, Ground};
use crate::plot::line::{Line, Mark};
use crate::plot::palette::{BLUE, GREY, INK, RED};
use crate::plot::sheet::{Label, Panel, Sheet, Side};
use crate::plot::span;

/// Wheels drawn along a flight.
const WHEELS: usize = 6;

/// The course with the plan, if there is one.
pub(super) fn scene(
    answer: &Answer,
    crossing: &Crossing,
    planner: &Planner<Corrected>,
    file: &str,
) -> Sheet {
    let (jumps, checks) = match answer {
        CrossingAnswer::Plan(plan) => (plan.jumps.as_slice(), plan.checks.as_slice()),
        _ => (&[][..], &[][..]),
    };
    let missed: Vec<&Check> = checks.iter().filter(|check| !check.holds()).collect();
    let course = &crossing.course;
    let is_bounded = course.goal.low > ANYWHERE.low || course.goal.high < ANYWHERE.high;
    let boxes = course.obstacles.iter();
    let ground = Ground {
        obstacles: boxes.map(|it| (ends(&it.span()), it.height)).collect(),
        avoid: course.no_landing.iter().map(ends).collect(),
        land: crossing.zones.iter().flatten().map(ends).collect(),
        goal: is_bounded.then(|| ends(&course.goal)),
        target: Some(crossing.target),
        missed: Vec::new(),
    };
    let radius = planner.robot().body.radius;
    let mut panel = Panel {
        least: Some([
            [course.start - radius, course.start + radius],
            [-CELLAR, 3.0 * radius],
        ]),
        notes: missed.iter().map(|check| (why(check), RED)).collect(),
        ..ground.panel()
    };
    let words = "wheel's centre: stance solid, flight dotted";
    panel.lines.push(Line::note(words, INK));
    let mut flights = Vec::new();
    for (i, jump) in jumps.iter().enumerate() {
        let fails = missed.iter().any(|check| check.jump == i);
        flights.push(leap(jump, planner, fails, &mut panel));
    }
    let firings = jumps.iter().map(|jump| firing(jump, planner));
    let labels = labels(firings, &flights, radius, &panel.lines);
    panel.labels.extend(labels);
    let file = file_name(Path::new(file));
    let plan = match jumps {
        [] => format!("no plan for {file}"),
        [.., last] => format!(
            "plan for {file}: lands {}",
            off_target(last.landing[0], crossing.target)
        ),
    };
    Sheet {
        title: format!("{}: {plan}", planner.robot().name),
        wide: vec![panel],
        ..Sheet::default()
    }
}

fn why(check: &Check) -> String {
    let number = check.jump + 1;
    let value = measured(check.value, 4);
    format!("FAILS: jump {number}: {} {value}", check.what)
}

fn ends(span: &Span) -> (f64, f64) {
    (span.low, span.high)
}

/// The path of the axle (m) from the foothold in a jump of `planner`: while the foot stands, and from lift-off to the landing
/// at `height` (m); empty where there is none.
pub(crate) fn path(jump: &Jump, height: f64, planner: &Planner<Corrected>) -> [Vec<(f64, f64)>; 2] {
    const POINTS: usize = 200;
    let traced = planner.model().traced(&jump.launch);
    let way = traced.map_or(Vec::new(), |traced| traced.way);
    let stance = way.iter().map(|at| (at.centre[0], at.centre[1]));
    let flight = jump.flight.as_ref();
    let flight = flight.and_then(|flight| Some((flight.time_to_height(height).ok()?, flight)));
    let flight = flight.map_or(Vec::new(), |(time, flight)| {
        let at = |k: usize| flight.motion(time * k as f64 / POINTS as f64)[0].into();
        (0..=POINTS).map(at).collect()
    });
    [stance.collect(), flight]
}

/// Half the width of a firing's label, in widths of the chart.
const HALF_LABEL: f64 = 0.1;
/// Distance of a label's next place above, in widths of the chart.
const NEXT_LABEL: f64 = 0.02;

/// The words of each firing over its flight, above every wheel that they would lie on.
fn labels(
    firings: impl Iterator<Item = String>,
    flights: &[Vec<(f64, f64)>],
    radius: f64,
    lines: &[Line],
) -> Vec<Label> {
    let places = lines.iter().flat_map(|line| &line.points);
    let (low, high) = span(places.map(|(x, _)| *x));
    let width = high - low;
    let label = |(words, flight): (String, &Vec<(f64, f64)>)| {
        let apex = flight.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let is_near = |at: &&(f64, f64)| (at.0 - apex.0).abs() < radius + HALF_LABEL * width;
        let centres = flights.iter().flatten().filter(is_near);
        let top = centres.fold(apex.1, |top, at| top.max(at.1)) + radius;
        let rows = [0.0, 1.0, 2.0];
        Some(Label {
            words,
            places: rows
                .map(|row| (apex.0, top + row * NEXT_LABEL * width))
                .into(),
            side: Side::Above,
            color: INK,
        })
    };
    firings.zip(flights).filter_map(label).collect()
}

/// How a jump is fired.
fn firing(planned: &PlannedJump, planner: &Planner<Corrected>) -> String {
    let launch = &planned.jump.launch;
    let angle = digits(launch.firing_angle, 3);
    let mut words = format!("α_f = {angle} rad");
    if planner.robot().leg.drive.has_valve() {
        let open = digits(1e3 * launch.valve_open, 3);
        words = format!("{words}, valve {open} ms");
    }
    words.replace('-', "−")
}

/// Adds a jump: the wheel along its path, the leg at lift-off and the foothold. Returns the path of the
/// flight.
fn leap(
    planned: &PlannedJump,
    planner: &Planner<Corrected>,
    fails: bool,
    panel: &mut Panel,
) -> Vec<(f64, f64)> {
    let (foot, radius) = (planned.foot, planner.robot().body.radius);
    let moved = |points: Vec<(f64, f64)>| -> Vec<(f64, f64)> {
        let points = points.into_iter();
        points.map(|(x, y)| (foot[0] + x, foot[1] + y)).collect()
    };
    let height = radius + planned.landing[1] - foot[1];
    let [stance, flight] = path(&planned.jump, height, planner).map(moved);
    let color = if fails { RED } else { BLUE };
    let last = flight.len().saturating_sub(1);
    for i in 0..=WHEELS {
        let Some(&centre) = flight.get(i * last / WHEELS) else {
            continue;
        };
        let (opacity, rim) = match i {
            0 | WHEELS => (0.10, INK),
            _ => (0.05, GREY),
        };
        let disc = disc(centre, radius);
        panel.lines.extend([
            Line::new(Mark::Shape(opacity), color, disc.clone()),
            Line::new(Mark::Stroke(1), rim, disc),
        ]);
    }
    let leg = stance
        .last()
        .into_iter()
        .flat_map(|end| [foot.into(), *end]);
    panel.lines.extend([
        Line::new(Mark::Stroke(3), INK, leg),
        Line::new(Mark::Stroke(3), color, stance.clone()),
        Line::new(Mark::Dotted, color, flight.clone()),
        Line::new(Mark::Disc(4), INK, [foot.into()]),
    ]);
    flight
}

/// The rim of a wheel.
fn disc((x, y): (f64, f64), radius: f64) -> Vec<(f64, f64)> {
    const SIDES: u32 = 72;
    let turn = |i: u32| std::f64::consts::TAU * f64::from(i) / f64::from(SIDES);
    (0..=SIDES)
        .map(turn)
        .map(|angle| (x + radius * angle.cos(), y + radius * angle.sin()))
        .collect()
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
        let drawn = |plan| {
            scene(
                &CrossingAnswer::Plan(plan),
                &crossing,
                &planner,
                "some/long/path/two.toml",
            )
        };
        // The paths and wheels of jumps that fail.
        let red = |sheet: &Sheet| {
            let lines = sheet.wide[0].lines.iter();
            lines
                .filter(|line| line.mark == Mark::Dotted && line.color == RED)
                .count()
        };
        let good = drawn(plan.clone());
        // No wheel is under the words of a firing, and the title has no folder.
        let radius = planner.robot().body.radius;
        let tops = good.wide[0].lines.iter();
        let tops = tops.filter(|line| line.mark == Mark::Dotted);
        let tops: Vec<(f64, f64)> = tops.flat_map(|line| line.points.clone()).collect();
        let labels = good.wide[0].labels.iter();
        let labels: Vec<&Label> = labels.filter(|it| it.words.starts_with("α_f")).collect();
        assert_eq!(labels.len(), 2);
        for (x, y) in labels.iter().map(|label| label.places[0]) {
            let is_under = |at: &&(f64, f64)| (at.0 - x).abs() < radius;
            assert!(tops.iter().filter(is_under).all(|at| y >= at.1 + radius));
        }
        assert!(good.title.starts_with("rats-planar: plan for two.toml: "));
        assert_eq!((good.wide[0].notes.len(), red(&good)), (0, 0));
        let words = |sheet: &Sheet| {
            sheet.wide[0]
                .lines
                .iter()
                .filter_map(|line| line.label.clone())
                .collect::<Vec<_>>()
        };
        assert!(words(&good).contains(&"strip: the goal".to_owned()));
        let allowed = Span::new(0.01, f64::INFINITY);
        plan.checks.push(Check {
            jump: 1,
            what: "clearance (m)".into(),
            value: 0.004,
            allowed,
            round_off: 1e-6,
        });
        let bad = drawn(plan);
        assert_eq!(bad.wide[0].notes[0].0, "FAILS: jump 2: clearance (m) 0.004");
        assert_eq!(red(&bad), 1);
    }
}
