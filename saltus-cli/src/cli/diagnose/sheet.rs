//! What the simulation leaves, as a plot.

use saltus::diagnosis::{Fit, points};

use super::report::Report;
use crate::output::split;
use crate::plot::Drawing;
use crate::plot::line::{Line, Mark};
use crate::plot::palette::{BLUE, GREY, RED};
use crate::plot::sheet::{Panel, Sheet};

/// Residuals of each channel, before and after.
pub(super) fn sheet(report: &Report<'_>) -> Drawing {
    let found = report.found;
    let x = if found.folder.experiment.kind.spec().timed {
        "time (s)"
    } else {
        "row"
    };
    let all = |model: &Fit| points(found.kind.as_ref(), model);
    let mut both = vec![("as simulated", RED, all(&found.diagnosis.before))];
    if !found.diagnosis.findings.is_empty() {
        both.push(("with the causes found", BLUE, all(&found.diagnosis.after)));
    }
    let mut panels = Vec::new();
    for (channel, about) in found.kind.channels().iter().enumerate() {
        for (what, color, points) in &both {
            let dots: Vec<(f64, f64)> = points
                .iter()
                .filter(|p| p.channel == channel)
                .map(|p| (p.time, p.residual))
                .collect();
            let ends = [
                dots.iter().map(|p| p.0).fold(f64::INFINITY, f64::min),
                dots.iter().map(|p| p.0).fold(0.0, f64::max),
            ];
            let limit = |y: f64| Line {
                label: None,
                points: ends
                    .iter()
                    .filter(|x| x.is_finite())
                    .map(|x| (*x, y))
                    .collect(),
                color: GREY,
                mark: Mark::Dashed,
            };
            let lines = vec![
                Line {
                    label: None,
                    points: dots,
                    color: *color,
                    mark: Mark::Dots,
                },
                limit(-2.0),
                limit(2.0),
            ];
            panels.push(Panel {
                title: format!("{} {what}", split(&about.name).0),
                x,
                y: "residual (σ)",
                lines,
                least: None,
            });
        }
    }
    let causes: Vec<&str> = found.diagnosis.findings.iter().map(|f| f.best.id).collect();
    let unknown = found.diagnosis.unknown.as_ref().map(|_| "unknown");
    let causes: Vec<&str> = causes.into_iter().chain(unknown).collect();
    let found = if causes.is_empty() {
        "nothing is wrong".to_owned()
    } else {
        causes.join(", ")
    };
    let title = format!("Measured less predicted, with ±2 σ: {found}");
    Drawing::Sheet(Sheet {
        title,
        course: None,
        panels,
    })
}
