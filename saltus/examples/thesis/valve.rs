//! Section 5.1, figure 5.2: how high a hop goes with the time that the valve is open.

use std::fmt::Write;

use saltus::chart::{COLORS, Chart, Ink};
use saltus::{Launch, Planner};

use crate::jumper::{BOOM, BOOM_LENGTH, planner, range};
use crate::{Outcome, Section, claim};

/// Figure 5.2: its horizontal axis (ms), its vertical one (rad), and the time (ms) past which its
/// text sees no gain.
const TIMES: (f64, f64) = (20.0, 60.0);
const ANGLES: (f64, f64) = (0.04, 0.16);
const NO_GAIN: f64 = 55.0;
/// Valve time (ms) of the running gait, 5.1.2.
const RUNNING: f64 = 40.0;

/// Pivot angle (rad) of the boom at the top of a hop on one upright leg, the valve open for `time`
/// (ms).
fn pivot(planner: &Planner, time: f64) -> Outcome<f64> {
    let jump = planner.jump(&Launch::at_firing(0.0, 0.0, 1e-3 * time))?;
    let apex = jump.apex().ok_or("no hop")?;
    Ok(((apex - planner.robot().body.radius) / BOOM_LENGTH).asin())
}

/// Time (ms) from the first flow to the end of the stroke, the valve being open all along.
fn stroke_time(planner: &Planner) -> Outcome<f64> {
    let end = planner.jump(&Launch::at_firing(0.0, 0.0, 1.0))?.stance;
    Ok(1e3 * (end.time - end.time_fire - planner.robot().leg.delay))
}

pub(crate) fn section() -> Outcome<Section> {
    let with_boom = |bore: &[&'static str]| [&BOOM, bore].concat();
    let robots: [(&str, Vec<&str>); 5] = [
        ("nominal bore, with the boom", with_boom(&[])),
        ("no boom", vec![]),
        ("bore 16 mm", with_boom(&["leg.bore_mm=16"])),
        ("bore 22 mm", with_boom(&["leg.bore_mm=22"])),
        ("bore 27 mm", with_boom(&["leg.bore_mm=27"])),
    ];
    let mut chart = Chart::new(
        (760.0, 392.0),
        ("valve opening time (ms)", (15.0, 80.0)),
        ("greatest pivot angle of the boom (rad)", (0.0, 0.28)),
    );
    chart.block(
        Ink::Solid("#f1efe6"),
        (TIMES.0, ANGLES.0),
        (TIMES.1, ANGLES.1),
    );
    chart.text(Ink::Solid(COLORS[6]), (53.5, 0.05), "axes of figure 5.2");
    let mut rows = String::new();
    for (i, (name, overrides)) in robots.iter().enumerate() {
        let planner = planner(overrides)?;
        let curve = range(15.0, 80.0, 66)
            .into_iter()
            .filter_map(|t| Some((t, pivot(&planner, t).ok()?)));
        let ink = if i == 0 { Ink::Solid } else { Ink::Dotted };
        chart.line(ink(COLORS[i]), &curve.collect::<Vec<_>>());
        chart.key(Ink::Solid(COLORS[i]), name);
        let at = |time: f64| {
            pivot(&planner, time).map_or("none".to_owned(), |angle| format!("{angle:.4}"))
        };
        writeln!(
            rows,
            "| {name} | {} | {} | {} | {} | {:.1} |",
            at(TIMES.0),
            at(RUNNING),
            at(NO_GAIN),
            at(TIMES.1),
            stroke_time(&planner)?
        )?;
    }
    let nominal = planner(&robots[0].1)?;
    let [least, running, late, most] =
        [TIMES.0, RUNNING, NO_GAIN, TIMES.1].map(|t| pivot(&nominal, t));
    let (least, running, late, most) = (least?, running?, late?, most?);
    claim(late == most, "figure 5.2: no gain past its 55 ms")?;
    claim(
        least > ANGLES.0 && most < ANGLES.1,
        "figure 5.2: inside its axis",
    )?;
    // sin(pivot) is the height won.
    let share = 100.0 * running.sin() / most.sin();
    let full = stroke_time(&nominal)?;
    let text = format!(
        "## Valve times (5.1, figure 5.2)\n\nThe robot hops on one upright leg, from rest. The \
         boom swings about its far end. Its greatest pivot angle is asin((apex − \
         r_s)/{BOOM_LENGTH} m).\n\n![Pivot angle over valve opening \
         time](thesis/valve-times.svg)\n\n| | thesis | Saltus |\n| --- | --- | --- |\n| pivot \
         angle at {low:.0} ms | the axis begins at {a0} rad | {least:.4} rad |\n| pivot angle at \
         {high:.0} ms | the axis ends at {a1} rad | {most:.4} rad |\n| no gain past | {NO_GAIN:.0} \
         ms | {full:.1} ms, where the stroke ends |\n| valve time of the running gait, 5.1.2 | \
         {RUNNING:.0} ms, by trial and error | gives {share:.0} % of the height that an open valve \
         gives |\n\nThe agreement at the ends of the axis is no evidence: the thesis does not give \
         the bore, and the bore was chosen to fit this figure. The shape of the curve and the time \
         at which the gain ends are evidence. The thesis explains the end of the gain by exhaust \
         ports that the piston passes. In the model, the stroke ends at that time and the robot \
         leaves the ground. The table shows other bores, and the robot without its boom:\n\n| \
         robot | {low:.0} ms | {RUNNING:.0} ms | {NO_GAIN:.0} ms | {high:.0} ms | stroke ends (ms) \
         |\n| --- | --- | --- | --- | --- | --- |\n{rows}",
        low = TIMES.0,
        high = TIMES.1,
        a0 = ANGLES.0,
        a1 = ANGLES.1,
    );
    Ok(Section {
        text,
        drawings: vec![("valve-times.svg", chart.file())],
    })
}
