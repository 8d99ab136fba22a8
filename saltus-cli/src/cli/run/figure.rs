//! A run as the thesis' figures 5.3, 5.5 and 5.6 show one.

use saltus::gait::Program;

use super::follow::Thinned;
use super::report::Report;
use crate::plot::line::{Line, Mark};
use crate::plot::palette::BLUE;
use crate::plot::sheet::{Panel, Sheet};

/// Wheel angle, rate, firing angle and speed over time, each on the thesis' axis at least.
pub(super) fn drawing(report: &Report<'_>, line: &Thinned) -> Sheet {
    let end = report.setup.seconds;
    // Where no leg was to fire, the line of its angle is cut.
    let stretches = |column: usize| {
        let cut = line.points.split(move |p| p[column].is_nan());
        let lines = cut.filter(|points| !points.is_empty()).map(|points| Line {
            label: None,
            points: points.iter().map(|p| (p[0], p[column])).collect(),
            color: BLUE,
            mark: Mark::Solid,
        });
        lines.collect()
    };
    let panel = |title: &str, y: &'static str, column: usize, least: [f64; 2]| Panel {
        title: title.into(),
        x: "time (s)",
        y,
        lines: stretches(column),
        least: Some([[0.0, end], least]),
        ..Panel::default()
    };
    let angles = match report.setup.program {
        Program::OpenLoop { .. } => [0.0, 0.35],
        _ => [-0.2, 0.5],
    };
    let sign = if report.setup.forwards { 1.0 } else { -1.0 };
    let [low, high] = [sign * 0.0_f64, sign * 3.5];
    Sheet {
        title: report.title(),
        panels: vec![
            panel("Wheel angle", "wheel angle (rad)", 1, [-50.0, 150.0]),
            panel("Filtered rate", "rate (rad/s)", 2, [-5.0, 15.0]),
            panel("Firing angle", "α_f (rad)", 3, angles),
            panel(
                "Speed, mean over 0.15 s",
                "speed (m/s)",
                4,
                [low.min(high), low.max(high)],
            ),
        ],
        ..Sheet::default()
    }
}
