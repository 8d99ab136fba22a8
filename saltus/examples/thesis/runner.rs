//! Runs of drawn robots, with what figures of section 5.1 show of them.

use std::collections::VecDeque;

use saltus::Robot;
use saltus::chart::{Chart, Ink};
use saltus::gait::{
    Centre, Disturbance, Draw, Footfall, Lines, Program, Row, Run, Setup, Smooth, Summary, What,
    When, drawn_robot, run,
};
use saltus::numeric::parallel;
use saltus::resolve;
use saltus::running::RUNS_FROM;

use crate::Outcome;

/// Robots drawn, and their seed: the first of those of docs/running.md.
pub(crate) const ROBOTS: usize = 20;
const SEED: u64 = 7;
/// The steady speed of the thesis' gaits (m/s).
pub(crate) const SPEED: f64 = 3.2;

/// Firing angles (rad) of open and closed loop: at rest, in the end. Source: the ends of the axes
/// of figures 5.5 and 5.6, read as running.md says.
pub(crate) const AT_REST: f64 = 0.35;
const OPEN_END: f64 = 0.0;
pub(crate) const CLOSED_END: f64 = -0.1;
/// Rate (rad/s) at which the closed loop's end is reached: 3.2 m/s.
const TOP_RATE: f64 = 13.3;

/// The gait of 5.1.2.
pub(crate) fn fixed(firing_angle: f64) -> Program {
    Program::Fixed { firing_angle }
}

/// The open loop of 5.1.3, B and C printed.
pub(crate) fn open_loop(centre: Centre) -> Program {
    Program::OpenLoop {
        first: AT_REST,
        last: OPEN_END,
        slope: 2.1,
        centre,
    }
}

/// The single line of 5.1.3.
pub(crate) fn one_line() -> Program {
    Program::ClosedLoop(Lines::One {
        first: AT_REST,
        last: CLOSED_END,
        at: TOP_RATE,
    })
}

/// Its two lines.
pub(crate) fn two_lines(jumps: bool) -> Program {
    Program::ClosedLoop(Lines::Two {
        first: AT_REST,
        slope: -0.01,
        switch: 5.0,
        last: CLOSED_END,
        at: TOP_RATE,
        jumps,
    })
}

/// The law that 8.3.2 proposes, found by search.
pub(crate) fn smooth() -> Program {
    Smooth::QUICK.program()
}

/// A push: a torque (N m) on the wheel for 0.2 s from `at` (s).
pub(crate) fn push(torque: f64, at: f64) -> Disturbance {
    Disturbance {
        when: When::Time(at, at + 0.2),
        what: What::Torque(torque),
    }
}

/// `robot` under `program`, where the active zone begins as `saltus run` has it.
pub(crate) fn setup(
    robot: Robot,
    program: Program,
    seconds: f64,
    pushes: Vec<Disturbance>,
) -> Setup {
    let zone = match &program {
        Program::Fixed { firing_angle } if *firing_angle < 0.0 => -0.3,
        Program::Fixed { .. } | Program::OpenLoop { .. } => 0.0,
        _ => -0.3,
    };
    Setup {
        zone,
        disturbances: pushes,
        ..Setup::new(robot, program, seconds)
    }
}

/// What is drawn of a run: a point every 50 ms.
#[derive(Clone, Debug, Default)]
pub(crate) struct Trace {
    pub(crate) points: Vec<Point>,
    recent: VecDeque<f64>,
    cycle: usize,
}

/// A point of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Point {
    pub(crate) time: f64,
    /// Wheel angle (rad) since the start.
    pub(crate) angle: f64,
    /// Filtered rate (rad/s).
    pub(crate) rate: f64,
    pub(crate) firing_angle: f64,
    /// Mean over 0.15 s (m/s).
    pub(crate) speed: f64,
}

/// Cycles of the mean speed, and from one point to the next.
const MEAN: usize = 150;
const EVERY: usize = 50;

impl Run for Trace {
    fn row(&mut self, row: &Row<'_>) {
        self.recent.push_back(row.axle[0]);
        if self.recent.len() > MEAN + 1 {
            self.recent.pop_front();
        }
        if self.cycle.is_multiple_of(EVERY) {
            let first = self.recent.front().copied().unwrap_or(row.axle[0]);
            let time = 1e-3 * (self.recent.len() - 1).max(1) as f64;
            self.points.push(Point {
                time: row.time,
                angle: row.lean,
                rate: row.action.rate,
                firing_angle: row.action.firing_angle,
                speed: (row.axle[0] - first) / time,
            });
        }
        self.cycle += 1;
    }

    fn footfall(&mut self, _: &Footfall) {}
}

/// A run with its trace.
pub(crate) type Ran = (Summary, Trace);

/// The nominal `rats-run`.
pub(crate) fn nominal(program: Program, seconds: f64, pushes: Vec<Disturbance>) -> Outcome<Ran> {
    let mut trace = Trace::default();
    let summary = run(
        &setup(resolve("rats-run", &[])?, program, seconds, pushes),
        &mut trace,
    )?;
    Ok((summary, trace))
}

/// The drawn robots, each changed by `change`.
pub(crate) fn drawn(
    program: &Program,
    seconds: f64,
    pushes: &[Disturbance],
    change: &(impl Fn(&mut Robot) + Sync),
) -> Outcome<Vec<Ran>> {
    let base = resolve("rats-run", &[])?;
    let one = |k: usize| {
        let mut robot = drawn_robot(&base, &Draw::default(), SEED, k)?;
        change(&mut robot);
        let mut trace = Trace::default();
        let setup = Setup {
            seed: SEED + k as u64,
            ..setup(robot, program.clone(), seconds, pushes.to_vec())
        };
        run(&setup, &mut trace).map(|summary| (summary, trace))
    };
    let runs = parallel::map_on(parallel::available(), ROBOTS, one);
    Ok(runs.into_iter().collect::<Result<Vec<_>, _>>()?)
}

/// Whether it ran in the end.
pub(crate) fn runs(summary: &Summary) -> bool {
    summary.late_speed() > RUNS_FROM[0]
}

/// The trace of the middle robot, and of the fastest, of those that run in the end.
pub(crate) fn middle_and_best(all: &[Ran]) -> Option<[&Trace; 2]> {
    let mut runners: Vec<&Ran> = all.iter().filter(|(summary, _)| runs(summary)).collect();
    runners.sort_by(|a, b| a.0.late_speed().total_cmp(&b.0.late_speed()));
    let middle = runners.get(runners.len().saturating_sub(1) / 2)?;
    Some([&middle.1, &runners.last()?.1])
}

/// A chart of `height` (px) whose vertical axis is the thesis', grown to hold `lines`, with the
/// thesis' axes shaded.
pub(crate) fn chart(
    height: f64,
    end: f64,
    (name, axis): (&str, (f64, f64)),
    lines: &[(Ink<'_>, Vec<(f64, f64)>)],
) -> Chart {
    let values = || {
        lines
            .iter()
            .flat_map(|(_, points)| points.iter().map(|p| p.1))
    };
    let step = 0.1 * (axis.1 - axis.0);
    let low = (values().fold(axis.0, f64::min) / step - 1e-9).floor() * step;
    let high = (values().fold(axis.1, f64::max) / step + 1e-9).ceil() * step;
    let (low, high) = (low.min(axis.0), high.max(axis.1));
    let mut chart = Chart::new(
        (760.0, height),
        ("time (s)", (0.0, end)),
        (name, (low, high)),
    );
    chart.block(Ink::Solid("#f1efe6"), (0.0, axis.0), (end, axis.1));
    for (ink, points) in lines {
        chart.line(*ink, points);
    }
    chart
}

/// Charts below each other, as one file.
pub(crate) fn stacked(charts: &[(f64, Chart)]) -> String {
    let total: f64 = charts.iter().map(|(height, _)| height).sum();
    let mut top = 0.0;
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 760 {total}\" width=\"760\" \
         height=\"{total}\">\n"
    );
    for (height, chart) in charts {
        text.push_str(
            &chart
                .file()
                .replacen("<svg ", &format!("<svg y=\"{top}\" "), 1),
        );
        top += height;
    }
    text + "</svg>\n"
}
