//! Section 5.2.2, figure 5.9: trajectories at one approach rate under different firing angles.

use std::fmt::Write;

use saltus::chart::{COLORS, Chart, Ink};

use crate::jumper::{Reading, path, planner};
use crate::{Outcome, Section, claim, signed};

/// Approach rate (rad/s), and firing angles (rad).
const RATE: f64 = 5.0;
const ANGLES: [f64; 7] = [-0.25, -0.20, -0.15, -0.10, -0.05, 0.0, 0.05];
/// Where the figure's axes end (m).
const AXES: (f64, f64) = (0.5, 0.55);

pub(crate) fn section() -> Outcome<Section> {
    let planner = planner(&[])?;
    let radius = planner.robot().body.radius;
    let mut chart = Chart::to_scale(760.0, ("x (m)", (-0.1, 1.25)), ("y (m)", (-0.11, 0.7)));
    chart.block(Ink::Solid("#f1efe6"), (0.0, 0.1), AXES);
    chart.line(Ink::Solid(COLORS[6]), &[(-0.1, 0.0), (1.25, 0.0)]);
    chart.key(Ink::Solid(COLORS[6]), "shaded: the axes of figure 5.9");
    chart.key(
        Ink::Solid(COLORS[6]),
        "stance solid, flight dotted; below each its firing angle (rad)",
    );
    let mut rows = String::new();
    let mut reached = Vec::new();
    for (i, angle) in ANGLES.into_iter().enumerate() {
        let jump = planner.jump(&Reading::PLAIN.launch(RATE, angle))?;
        let (Some(apex), Some(level), Some(ground)) =
            (jump.apex(), jump.distance(radius), jump.distance(0.0))
        else {
            return Err(format!("no jump at {angle} rad").into());
        };
        let [stance, flight] = path(&planner, &jump, 0.0)?;
        chart.line(Ink::Solid(COLORS[i]), &stance);
        chart.line(Ink::Dotted(COLORS[i]), &flight);
        // Landings lie close together: every other label goes lower.
        let below = if i % 2 == 0 { -0.04 } else { -0.08 };
        chart.text(Ink::Solid(COLORS[i]), (ground, below), &signed(angle, 2));
        reached.push((apex, level, ground));
        let trace = planner.stance().trace(&jump.launch)?;
        writeln!(
            rows,
            "| {} | {} | {apex:.4} | {level:.4} | {ground:.4} | {:.2} |",
            signed(angle, 2),
            jump.stance.outcome.name(),
            trace.contact.friction_needed
        )?;
    }
    claim(
        reached
            .windows(2)
            .all(|w| w[1].0 < w[0].0 && w[1].1 > w[0].1 && w[1].2 > w[0].2),
        "figure 5.9: later is farther and less high",
    )?;
    let highest = reached[0].0;
    claim(highest > AXES.1, "figure 5.9: ours goes above its axis")?;
    let text = format!(
        "## A family of trajectories (5.2.2, figure 5.9)\n\nThe approach rate is {RATE} rad/s, \
         and the firing angles go from {} to {} rad. Each stance starts at its firing angle. The \
         valve stays open past the end of the stroke.\n\n![Trajectories under different firing \
         angles](thesis/family.svg)\n\n| α_f (rad) | outcome | apex (m) | distance to y = r_s (m) \
         | to y = 0 (m) | friction needed |\n| --- | --- | --- | --- | --- | --- |\n{rows}\nThe \
         finding of the thesis holds for all of them: a leg that fires later sends the robot \
         farther and less high. The trajectories of the figure stay below {} m. With the earliest \
         firing angle, the robot of Saltus rises to {highest:.3} m, {:.0} mm more. The cause of \
         the difference is unknown: the thesis gives neither the bore nor the lean at which these \
         stances begin.\n",
        signed(ANGLES[0], 2),
        ANGLES[6],
        AXES.1,
        1e3 * (highest - AXES.1),
    );
    Ok(Section {
        text,
        drawings: vec![("family.svg", chart.file())],
    })
}
