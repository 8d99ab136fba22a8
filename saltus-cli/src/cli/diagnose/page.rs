//! What was found, as a page to hand on: one file, without scripts and without anything from
//! elsewhere.

use std::fmt::Write;
use std::path::PathBuf;

use saltus::chart::{Chart, Ink, escaped};
use saltus::diagnosis::{Finding, Point, Sort, points};

use super::known;
use super::report::{Report, next_of};
use super::steps::steps;
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
    let mut out = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta \
         name=\"viewport\" content=\"width=device-width, \
         initial-scale=1\">\n<title>{headline}</title>\n\
         <style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n<p class=\"kicker\">Diagnosis of a \
         simulation by measured data · {}</p>\n<h1>{headline}</h1>\n",
        escaped(&report.size())
    );
    for text in report.misstated() {
        let _ = writeln!(
            out,
            "<div class=\"card off\"><p>{}</p></div>",
            escaped(&text)
        );
    }
    for finding in &report.found.diagnosis.findings {
        cause(&mut out, report, finding);
    }
    if let Some(estimated) = report.estimated() {
        sentence(&mut out, &estimated);
    }
    if let Some(left) = report.left() {
        sentence(&mut out, &left);
    }
    if let Some(stopped) = report.stopped() {
        sentence(&mut out, &stopped);
    }
    if let Some(small) = report.small() {
        sentence(&mut out, &small);
    }
    if let Some(unknown) = report.unknown() {
        let _ = writeln!(
            out,
            "<div class=\"card off\"><h3>unknown</h3><p>{}</p></div>",
            escaped(&unknown)
        );
    }
    if report.is_well() {
        let claims = escaped(&report.claims());
        let _ = writeln!(
            out,
            "<div class=\"card well\"><p>No cause on the list lowers the misfit by more than \
             chance does. {claims}</p></div>"
        );
    }
    gains(&mut out, report);
    if let Some(worth) = report.worth() {
        out.push_str("<h2>What knowing it is worth</h2>\n");
        sentence(&mut out, &worth);
    }
    if let Some(replan) = &report.found.replan {
        out.push_str("<h2>What it is worth on a course</h2>\n");
        for line in replan.lines() {
            sentence(&mut out, &line);
        }
    }
    curves.measured(&mut out, report);
    curves.residuals(&mut out, report);
    table(&mut out, &report.residual_lines(), 2);
    sentence(&mut out, Report::MARKS);
    candidates(&mut out, report);
    next(&mut out, report);
    provenance(&mut out, report, folders);
    out + "</main>\n</body>\n</html>\n"
}

fn sentence(out: &mut String, text: &str) {
    // Writing to a string does not fail.
    let _ = writeln!(out, "<p class=\"small\">{}</p>", escaped(text));
}

/// A header, then lines; the first `left` columns begin in line.
fn table(out: &mut String, lines: &[Vec<String>], left: usize) {
    out.push_str("<table>\n");
    for (k, line) in lines.iter().enumerate() {
        out.push_str("<tr>");
        for (i, cell) in line.iter().enumerate() {
            let tag = if k == 0 { "th" } else { "td" };
            let is_words = i < left || (i + 1 == line.len() && line.len() > 2);
            let class = if cell.starts_with('*') {
                " class=\"off\""
            } else if is_words {
                ""
            } else {
                " class=\"n\""
            };
            let cell = escaped(cell.trim_start_matches("* ").trim());
            let _ = write!(out, "<{tag}{class}>{cell}</{tag}>");
        }
        out.push_str("</tr>\n");
    }
    out.push_str("</table>\n");
}

fn cause(out: &mut String, report: &Report<'_>, finding: &Finding) {
    let (name, what) = (escaped(&finding.best.title()), finding.best.meaning());
    let _ = writeln!(
        out,
        "<div class=\"card\"><h3>{name}</h3>\n<p>In the machine {what}.</p>"
    );
    let mut lines = vec![vec![
        "parameter".to_owned(),
        "value ± standard error; interval by profile likelihood".to_owned(),
    ]];
    lines.extend(
        report
            .parameters_of(finding, &finding.best)
            .into_iter()
            .map(|(n, x)| vec![n, x]),
    );
    table(out, &lines, 2);
    if !finding.is_identifiable {
        let _ = writeln!(out, "<p>{}</p>", escaped(Report::OPEN));
    }
    if let Some(text) = report.undetermined(finding) {
        let _ = writeln!(out, "<p>{}</p>", escaped(&text));
    }
    if !finding.rivals.is_empty() || finding.unlisted.is_some() {
        out.push_str("<p>It could as well be:</p>\n");
        let mut lines = vec![vec!["rival".to_owned(), "with".to_owned()]];
        for rival in &finding.rivals {
            lines.push(vec![rival.title(), report.rival(finding, rival)]);
        }
        if finding.rivals.is_empty() {
            lines.clear();
        }
        table(out, &lines, 2);
        if let Some(term) = &finding.unlisted {
            sentence(out, &format!("{}.", Report::unlisted(term)));
        }
        sentence(out, Report::RIVALS);
    }
    let less_likely = Report::less_likely(finding).into_iter();
    for text in less_likely
        .chain(known::against(finding))
        .chain(next_of(finding))
    {
        sentence(out, &text);
    }
    out.push_str("</div>\n");
}

/// What to do next.
fn next(out: &mut String, report: &Report<'_>) {
    out.push_str("<h2>What to do next</h2>\n<ol>\n");
    for step in steps(report.found) {
        let command = step.command.map_or(String::new(), |c| {
            format!("<br><code>{}</code>", escaped(&c))
        });
        let _ = writeln!(out, "<li>{}{command}</li>", escaped(&step.what));
    }
    out.push_str("</ol>\n");
}

fn gains(out: &mut String, report: &Report<'_>) {
    out.push_str("<h2>Prediction of data that were left out of the fit</h2>\n");
    sentence(
        out,
        "Root mean square of measured less predicted. No model does better than the noise.",
    );
    table(out, &report.gains(), 1);
}

fn candidates(out: &mut String, report: &Report<'_>) {
    out.push_str("<h2>Every cause alone</h2>\n");
    sentence(out, Report::MISFIT);
    if !report.found.diagnosis.tried.is_empty() {
        table(out, &report.tried_lines(), 1);
    }
    if let Some(text) = report.silent() {
        sentence(out, &text);
    }
}

fn provenance(out: &mut String, report: &Report<'_>, folders: &[PathBuf]) {
    out.push_str("<h2>Where this comes from</h2>\n");
    let names: Vec<String> = folders.iter().map(|f| f.display().to_string()).collect();
    let mut lines = vec![
        vec!["what".to_owned(), "which".to_owned()],
        vec!["data".to_owned(), names.join(", ")],
    ];
    lines.push(vec![
        "hash of the data".to_owned(),
        report.found.folder.hash.clone(),
    ]);
    lines.push(vec!["size".to_owned(), report.size()]);
    if let Some(robot) = &report.found.robot {
        lines.push(vec!["robot".to_owned(), robot.name.clone()]);
    }
    lines.push(vec![
        "saltus".to_owned(),
        env!("CARGO_PKG_VERSION").to_owned(),
    ]);
    lines.push(vec![
        "seed".to_owned(),
        report.found.settings.seed.to_string(),
    ]);
    table(out, &lines, 2);
    sentence(out, &report.claims());
    if let Some(text) = report.widened() {
        sentence(out, &text);
    }
    if let Some(text) = report.disagree() {
        sentence(out, text);
    }
    for note in &report.found.folder.notes {
        sentence(out, &format!("Note: {note}"));
    }
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
    fn measured(&self, out: &mut String, report: &Report<'_>) {
        let changes = !report.found.diagnosis.findings.is_empty();
        out.push_str("<h2>Measured and predicted</h2>\n");
        sentence(
            out,
            "The runs that the simulation as it is predicts worst, of each channel.",
        );
        out.push_str(
            "<p class=\"key\"><span><i \
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
        out.push_str("</div>\n");
    }

    /// Residuals of all runs, before and after.
    fn residuals(&self, out: &mut String, report: &Report<'_>) {
        out.push_str("<h2>What the simulation leaves</h2>\n");
        sentence(
            out,
            "Measured less predicted of all runs, in standard deviations of the noise (σ). Of \
             noise 95 % lie in the band from −2 to 2, without a pattern.",
        );
        out.push_str("<div class=\"charts\">\n");
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
        out.push_str("</div>\n");
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
