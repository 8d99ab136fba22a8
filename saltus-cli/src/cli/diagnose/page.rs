//! What was found, as a page to hand on: one file, without scripts and without anything from
//! elsewhere.

use std::fmt::Write;
use std::path::PathBuf;

use saltus::chart::{Chart, Ink, escaped};
use saltus::diagnosis::{Point, Sort, points};

use super::blocks::{self, Charts};
use super::report::Report;
use crate::output::split;
use crate::plot::span;

const STYLE: &str = include_str!("page.css");
/// Size of a chart, of which two stand in a row.
const CHART: (f64, f64) = (460.0, 290.0);
/// Charts of measured and predicted, about; of each channel the runs that the model as it is
/// predicts worst.
const RUNS: usize = 8;
/// Most points that are drawn of one line, and of one chart of residuals.
const LINE: usize = 500;
const CLOUD: usize = 1500;

/// The page.
pub(super) fn html(report: &Report<'_>, folders: &[PathBuf]) -> String {
    let curves = Curves::of(report);
    let headline = escaped(&report.headline());
    let names: Vec<String> = folders.iter().map(|f| f.display().to_string()).collect();
    let robot = report.found.robot.as_ref();
    let provenance = format!(
        "{}{}; saltus {}, seed {}",
        names.join(", "),
        robot.map_or(String::new(), |robot| format!("; robot {}", robot.name)),
        env!("CARGO_PKG_VERSION"),
        report.found.settings.seed
    );
    let body = blocks::html(&report.blocks(), &|charts| match charts {
        Charts::Measured => curves.measured(report),
        Charts::Residuals => curves.residuals(report),
    });
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta \
         name=\"viewport\" content=\"width=device-width, \
         initial-scale=1\">\n<title>{headline}</title>\n\
         <style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n<p class=\"kicker\">Diagnosis of a \
         simulation by measured data · {}</p>\n<h1>{headline}</h1>\n{body}<p class=\"small\">{}</p>\n\
         </main>\n</body>\n</html>\n",
        escaped(&report.size()),
        escaped(&provenance)
    )
}

/// Readings beside both models.
struct Curves {
    before: Vec<Point>,
    after: Vec<Point>,
    /// Whether rows are measured, and not courses.
    is_rows: bool,
    kind: Sort,
}

impl Curves {
    fn of(report: &Report<'_>) -> Curves {
        let of = |model| points(report.found.kind.as_ref(), model);
        Curves {
            before: of(&report.found.diagnosis.before),
            after: of(&report.found.diagnosis.after),
            is_rows: !report.found.folder.experiment.kind.spec().timed,
            kind: report.found.folder.experiment.kind,
        }
    }

    fn x(&self) -> &'static str {
        if self.is_rows { "row" } else { "time (s)" }
    }

    /// Runs, those that the model as it is predicts worst first.
    fn worst(&self, channel: usize) -> Vec<usize> {
        let mut runs: Vec<(usize, f64)> = Vec::new();
        for point in self.before.iter().filter(|p| p.channel == channel) {
            let square = point.weight * point.residual.powi(2);
            match runs.last_mut().filter(|(run, _)| *run == point.run) {
                Some((_, sum)) => *sum += square,
                None => runs.push((point.run, square)),
            }
        }
        runs.sort_by(|a, b| b.1.total_cmp(&a.1));
        runs.into_iter().map(|(run, _)| run).collect()
    }

    /// Measured and predicted of the worst runs.
    fn measured(&self, report: &Report<'_>) -> String {
        let changes = !report.found.diagnosis.findings.is_empty();
        let mut out = String::from(
            "<h2>Measured and predicted</h2>\n<p class=\"small\">The runs that the simulation as it is \
             predicts worst, of each channel.</p>\n<p class=\"key\"><span><i \
            style=\"border-top-style:dotted;border-color:#3c444e\"></i>measured</span>",
        );
        out.push_str(
            "<span><i style=\"border-top-style:dashed;border-color:#c83228\"></i>simulation as it \
             is</span>",
        );
        if changes {
            out.push_str(
                "<span><i style=\"border-color:#1f63a8\"></i>with the causes found</span>",
            );
        }
        out.push_str("</p>\n<div class=\"charts\">\n");
        for (channel, about) in report.found.kind.channels().iter().enumerate() {
            let shown = (RUNS / report.found.kind.channels().len().max(1)).clamp(2, 4);
            for run in self.worst(channel).into_iter().take(shown) {
                let of = |points: &[Point], value: fn(&Point) -> f64| {
                    let all: Vec<(f64, f64)> = points
                        .iter()
                        .filter(|p| p.channel == channel && p.run == run)
                        .map(|p| (p.time, value(p)))
                        .collect();
                    thinned(&all, LINE)
                };
                let measured = of(&self.before, |p| p.measured);
                let (before, after) = (
                    of(&self.before, |p| p.predicted),
                    of(&self.after, |p| p.predicted),
                );
                let all = || measured.iter().chain(&before).chain(&after);
                let (x, y) = (span(all().map(|p| p.0)), span(all().map(|p| p.1)));
                let name = &report.found.kind.logs()[run].name;
                let mut chart = Chart::new(
                    CHART,
                    (self.x(), padded(x, 0.02)),
                    (&axis(&about.name), padded(y, 0.06)),
                );
                chart.title(&format!("{name}: {}", split(&about.name).0));
                self.phases(&mut chart, run);
                chart.dots(Ink::Class("measured"), &measured);
                if self.is_rows {
                    chart.dots(Ink::Class("before"), &before);
                } else {
                    chart.line(Ink::Class("before"), &before);
                }
                match (changes, self.is_rows) {
                    (false, _) => {}
                    (true, true) => chart.dots(Ink::Class("after"), &after),
                    (true, false) => chart.line(Ink::Class("after"), &after),
                }
                let _ = writeln!(out, "<div>{}</div>", chart.svg());
            }
        }
        out + "</div>\n"
    }

    /// Residuals of all runs, before and after.
    fn residuals(&self, report: &Report<'_>) -> String {
        let mut out = String::from(
            "<p class=\"small\">Of noise 95 % lie in the band from −2 to 2, without a pattern.</p>\n\
             <div class=\"charts\">\n",
        );
        let mut both = vec![("before", "as simulated", &self.before)];
        if !report.found.diagnosis.findings.is_empty() {
            both.push(("after", "with the causes found", &self.after));
        }
        for (channel, about) in report.found.kind.channels().iter().enumerate() {
            for (class, what, points) in &both {
                let all: Vec<(f64, f64)> = points
                    .iter()
                    .filter(|p| p.channel == channel)
                    .map(|p| (p.time, p.residual))
                    .collect();
                let (x, y) = (span(all.iter().map(|p| p.0)), span(all.iter().map(|p| p.1)));
                let name = format!("{} {what}", split(&about.name).0);
                let y = (y.0.min(-3.0), y.1.max(3.0));
                let mut chart = Chart::new(
                    CHART,
                    (self.x(), padded(x, 0.02)),
                    ("residual (σ)", padded(y, 0.06)),
                );
                chart.title(&name);
                chart.block(
                    Ink::Class("band"),
                    (f64::NEG_INFINITY, -2.0),
                    (f64::INFINITY, 2.0),
                );
                if let Some(run) = self.worst(channel).first() {
                    self.phases(&mut chart, *run);
                }
                chart.dots(Ink::Class(class), &thinned(&all, CLOUD));
                let _ = writeln!(out, "<div>{}</div>", chart.svg());
            }
        }
        out + "</div>\n"
    }

    /// Marks where the phases of a run begin, if it has several.
    fn phases(&self, chart: &mut Chart, run: usize) {
        let mut begins: Vec<(f64, &'static str)> = Vec::new();
        let points = if self.after.is_empty() {
            &self.before
        } else {
            &self.after
        };
        let mut all: Vec<&Point> = points.iter().filter(|p| p.run == run).collect();
        all.sort_by(|a, b| a.time.total_cmp(&b.time));
        for point in all {
            if begins.last().is_none_or(|(_, name)| *name != point.phase) {
                begins.push((point.time, point.phase));
            }
        }
        if begins.len() > 1 {
            for (row, (time, name)) in begins.into_iter().enumerate() {
                chart.begin(time, (self.kind.spec().phase)(name), row % 4);
            }
        }
    }
}

/// A span grown by a share of its width on both sides; never empty.
fn padded((low, high): (f64, f64), share: f64) -> (f64, f64) {
    let padded = crate::plot::padded(low, high, share);
    (padded.start, padded.end)
}

/// Every k-th, so that at most `most` are left.
fn thinned(points: &[(f64, f64)], most: usize) -> Vec<(f64, f64)> {
    points
        .iter()
        .step_by(points.len().div_ceil(most).max(1))
        .copied()
        .collect()
}

fn axis(name: &str) -> String {
    match split(name) {
        (name, "") => name.to_owned(),
        (name, unit) => format!("{name} ({unit})"),
    }
}
