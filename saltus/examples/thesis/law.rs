//! Section 5.2.3: the linear law that jumps one metre from any approach rate.

use std::fmt::Write;

use saltus::Planner;
use saltus::chart::{COLORS, Chart, Ink};
use saltus::planner::{Entry, Law, LawPoint, Measure, Roots};

use crate::jumper::{BOOM, Reading, planner, range};
use crate::{Outcome, Section, claim, signed};

/// The thesis' law: A (s), B (rad), and the distance (m) that it is for.
const A: f64 = -0.1;
const B: f64 = 0.46;
pub(crate) const DISTANCE: f64 = 1.0;
/// Approach rates (rad/s): the thesis names none of its five, so these are ours; figure 5.9 has 5.
pub(crate) const RATES: [f64; 5] = [3.0, 3.75, 4.5, 5.25, 6.0];
/// What a linear relation may miss (rad) to be called one.
const LINEAR: f64 = 0.01;

/// The most that a law costs at the landing (m).
const COST: f64 = 0.015;

/// Leans (rad) at which a stance may start.
const STARTS: [Option<f64>; 3] = [None, Some(-0.25), Some(-0.35)];

pub(crate) fn section() -> Outcome<Section> {
    let nominal = planner(&[])?;
    let (readings, chart, plain) = readings(&nominal)?;
    let (angle_off, miss) = plain.misfit();
    let radius = nominal.robot().body.radius;
    // Here the retracted leg of an upright robot no longer presses on the ground.
    let fastest = (nominal.robot().environment.gravity / radius).sqrt();
    let text = format!(
        "## The law for one metre (5.2.3)\n\nAt each of five approach rates, the thesis varies \
         α_f until the jump covers {DISTANCE:.0} m. It finds α_f = A ω + B with A = {} s and B = \
         {B} rad. It does not give the five rates, the lean at which the stance starts, or the \
         height at which a jump ends. Here the rates are {} rad/s. The table has a row for each \
         reading: the stance starts at the firing angle or at a touch-down lean, and the jump ends \
         where the wheel's centre comes down to y = 0 or to y = r_s. The residual is the \
         difference between the straight line and the exact angle. The miss is the error of the \
         landing that results.\n\n![Firing angle over approach rate](thesis/law.svg)\n\n| stance \
         starts at | lands at | A (s) | B (rad) | greatest residual (mrad) | RMS (mrad) | greatest \
         miss (mm) |\n| --- | --- | --- | --- | --- | --- | --- |\n{readings}\nThe finding of the \
         thesis holds: for landings at y = 0 the relation is linear to {:.0} mrad under every \
         reading, and the straight line costs less than {:.1} cm at the landing. At these rates \
         the robot cannot reach one metre at y = r_s. So the thesis means y = 0, or its leg is \
         stronger. The numbers differ: all slopes are steeper and all intercepts are larger than \
         those of the thesis. The next table is for the plain reading (first row). There the \
         firing angles of the thesis' law differ from the exact ones by up to {:.2} rad, and its \
         jumps miss by up to {:.0} cm:\n\n{}\nThe relation is slightly curved, so the slope also \
         depends on the rates. (Above √(g/r_s) = {fastest:.1} rad/s an upright robot leaves the \
         ground before its leg fires. For this reason some rates have no angle.)\n\n{}\nIt also \
         depends on properties of the robot that the thesis does not give (plain \
         reading):\n\n{}\nShorter jumps have flatter laws. These jumps land at y = r_s, and each \
         stance starts at its firing angle:\n\n{}\nNo choice above gives A = {} and B = {B} \
         together. The text of the thesis does not tell what would flatten the slope, and nothing \
         here is tuned to hide the difference.\n\n### Early and late\n\nWhere the robot can reach \
         {DISTANCE:.0} m, two firing angles usually do so. The early one is that of the law. The \
         late one is past the angle of the farthest jump; with it the robot flies low. The thesis \
         mentions only the early one, and it is right: the late jumps never rise to y = r_s = \
         {radius} m, so the wheel would touch the ground. (The wheel also touches the ground \
         before every landing at y = 0. That height is a reading of the thesis' metre, not a place \
         to land.) Where there is no late angle, a robot that is so fast and leans so far forward \
         leaves the ground before the pressure pushes.\n\n{}",
        signed(A, 1),
        list(&RATES),
        1e3 * LINEAR,
        100.0 * COST,
        angle_off,
        100.0 * miss,
        thesis_law(&nominal)?,
        rate_ranges(&nominal)?,
        robots()?,
        distances(&nominal)?,
        signed(A, 1),
        roots(&nominal)?,
    );
    Ok(Section {
        text,
        drawings: vec![("law.svg", chart.file())],
    })
}

/// The law of the plain reading, held against the thesis'.
struct Plain {
    law: Law,
    misses: Vec<f64>,
}

impl Plain {
    /// Greatest difference of the thesis' angle from the exact one (rad), and of its landing from
    /// the target (m).
    fn misfit(&self) -> (f64, f64) {
        let angle = |rate: f64| A * rate + B;
        let off = self
            .law
            .points
            .iter()
            .map(|p| (angle(p.rate) - p.exact).abs())
            .fold(0.0, f64::max);
        (
            off,
            self.misses
                .iter()
                .fold(0.0, |most, miss| miss.abs().max(most)),
        )
    }
}

fn list(numbers: &[f64]) -> String {
    numbers
        .iter()
        .map(f64::to_string)
        .collect::<Vec<_>>()
        .join(", ")
}

/// A, B and what they miss, as columns; without a law, how far the robot comes.
fn columns(
    law: Option<&Law>,
    reading: Reading,
    planner: &Planner,
    rates: &[f64],
) -> Outcome<String> {
    let Some(law) = law else {
        let farthest = reading.farthest(planner, rates)?;
        return Ok(format!("out of reach: {farthest:.3} m at most | | | | |"));
    };
    let ((residual, rms), (miss, _)) = (law.residuals(), law.misses());
    let few = if law.points.len() < rates.len() {
        format!(" ({} rates)", law.points.len())
    } else {
        String::new()
    };
    Ok(format!(
        "{}{few} | {} | {:.1} | {:.1} | {:.0} |",
        signed(law.slope, 4),
        signed(law.intercept, 4),
        1e3 * residual,
        1e3 * rms,
        1e3 * miss
    ))
}

fn readings(planner: &Planner) -> Outcome<(String, Chart, Plain)> {
    let radius = planner.robot().body.radius;
    let mut rows = String::new();
    let mut chart = Chart::new(
        (760.0, 422.0),
        ("approach rate ω (rad/s)", (2.8, 6.2)),
        ("firing angle α_f (rad)", (-0.4, 0.45)),
    );
    let mut colors = COLORS.iter();
    let mut color = || colors.next().copied().unwrap_or("#000000");
    chart.key(
        Ink::Solid(color()),
        &format!("thesis: {} ω + {B}", signed(A, 1)),
    );
    chart.line(
        Ink::Solid(COLORS[0]),
        &[3.0, 6.0].map(|rate| (rate, A * rate + B)),
    );
    for start_lean in STARTS {
        for landing_height in [0.0, radius] {
            let reading = Reading {
                start_lean,
                landing_height,
            };
            let law = reading.law(planner, &RATES, DISTANCE)?;
            let start = start_lean.map_or("the firing angle".into(), |lean| {
                format!("{} rad", signed(lean, 2))
            });
            let end = if landing_height > 0.0 {
                "y = r_s"
            } else {
                "y = 0"
            };
            writeln!(
                rows,
                "| {start} | {end} | {}",
                columns(law.as_ref(), reading, planner, &RATES)?
            )?;
            claim(
                law.is_some() == (landing_height == 0.0),
                "one metre is in reach to y = 0 and not to y = r_s",
            )?;
            let Some(law) = law else { continue };
            claim(
                law.points.len() == RATES.len(),
                "every rate reaches one metre to y = 0",
            )?;
            claim(
                law.residuals().0 < LINEAR,
                "the relation is linear under every reading",
            )?;
            claim(law.misses().0 < COST, "what the law costs")?;
            claim(
                law.slope < A && law.intercept > B,
                "slopes are steeper, intercepts larger",
            )?;
            let color = color();
            chart.key(
                Ink::Solid(color),
                &format!("start {}, {end}", start.replace("the ", "")),
            );
            let ends = [RATES[0], RATES[4]].map(|rate| (rate, law.firing_angle(rate)));
            chart.line(Ink::Dotted(color), &ends);
            let exact: Vec<_> = law.points.iter().map(|p| (p.rate, p.exact)).collect();
            chart.dots(Ink::Solid(color), &exact);
        }
    }
    let law = Reading::PLAIN
        .law(planner, &RATES, DISTANCE)?
        .ok_or("one metre is out of reach")?;
    let misses = RATES
        .iter()
        .map(|rate| Ok(thesis_distance(planner, *rate)? - DISTANCE))
        .collect::<Outcome<_>>()?;
    Ok((rows, chart, Plain { law, misses }))
}

/// Where the thesis' law sends the robot (m), under the plain reading.
fn thesis_distance(planner: &Planner, rate: f64) -> Outcome<f64> {
    let jump = planner.jump(&Reading::PLAIN.launch(rate, A * rate + B))?;
    let distance = Measure::Distance {
        landing_height: 0.0,
    }
    .of(planner.robot(), &jump);
    distance.ok_or_else(|| format!("the thesis' law does not jump at {rate} rad/s").into())
}

fn thesis_law(planner: &Planner) -> Outcome<String> {
    let law = Reading::PLAIN
        .law(planner, &RATES, DISTANCE)?
        .ok_or("one metre is out of reach")?;
    let mut rows = String::from(
        "| ω (rad/s) | exact α_f (rad) | our law's α_f (rad) | goes (m) | the thesis' α_f (rad) | \
         goes (m) |\n| --- | --- | --- | --- | --- | --- |\n",
    );
    for point in &law.points {
        let value = point.value.ok_or("our law does not jump")?;
        writeln!(
            rows,
            "| {} | {} | {} | {value:.3} | {} | {:.3} |",
            point.rate,
            signed(point.exact, 4),
            signed(point.fitted, 4),
            signed(A * point.rate + B, 4),
            thesis_distance(planner, point.rate)?
        )?;
    }
    Ok(rows)
}

/// Greatest difference (rad) between the exact angles of two laws, at the rates that both have.
fn greatest_change(law: &Law, other: &Law) -> f64 {
    let same = |p: &LawPoint| {
        other
            .points
            .iter()
            .find(|q| q.rate == p.rate)
            .map(|q| (p.exact - q.exact).abs())
    };
    law.points.iter().filter_map(same).fold(0.0, f64::max)
}

/// Laws for other distances to y = r_s.
fn distances(planner: &Planner) -> Outcome<String> {
    let mut rows = String::from(
        "| distance to y = r_s (m) | A (s) | B (rad) | greatest residual (mrad) | RMS (mrad) | \
         greatest miss (mm) |\n| --- | --- | --- | --- | --- | --- |\n",
    );
    let reading = Reading {
        start_lean: None,
        landing_height: planner.robot().body.radius,
    };
    for distance in [0.5, 0.6, 0.7, 0.8] {
        let law = reading.law(planner, &RATES, distance)?;
        writeln!(
            rows,
            "| {distance} | {}",
            columns(law.as_ref(), reading, planner, &RATES)?
        )?;
    }
    Ok(rows)
}

fn rate_ranges(planner: &Planner) -> Outcome<String> {
    let mut rows = String::from(
        "| five rates from | to (rad/s) | A (s) | B (rad) | greatest residual (mrad) | RMS (mrad) \
         | greatest miss (mm) |\n| --- | --- | --- | --- | --- | --- | --- |\n",
    );
    for (low, high) in [(2.0, 4.0), (3.0, 6.0), (4.0, 6.0), (5.0, 7.0)] {
        let (reading, rates) = (Reading::PLAIN, range(low, high, 5));
        let law = reading.law(planner, &rates, DISTANCE)?;
        writeln!(
            rows,
            "| {low} | {high} | {}",
            columns(law.as_ref(), reading, planner, &rates)?
        )?;
    }
    Ok(rows)
}

fn robots() -> Outcome<String> {
    let mut rows = String::from(
        "| robot | greatest change of α_f (mrad) | A (s) | B (rad) | greatest residual (mrad) | \
         RMS (mrad) | greatest miss (mm) |\n| --- | --- | --- | --- | --- | --- | --- |\n",
    );
    let nominal = planner(&[])?;
    let body = nominal.robot().body;
    // ⅖ m r²: table 4.1's solid sphere in place of the thin disc.
    let sphere = format!(
        "body.inertia_kg_m2={}",
        0.4 * body.mass * body.radius * body.radius
    );
    let robots: [(&str, &[&str]); 6] = [
        ("nominal: thin disc, bore 19.05 mm, no boom", &[]),
        ("solid sphere", &[&sphere]),
        ("with the boom", &BOOM),
        ("bore 16 mm", &["leg.bore_mm=16"]),
        ("bore 22 mm", &["leg.bore_mm=22"]),
        ("bore 27 mm", &["leg.bore_mm=27"]),
    ];
    let plain = Reading::PLAIN
        .law(&nominal, &RATES, DISTANCE)?
        .ok_or("one metre is out of reach")?;
    for (name, overrides) in robots {
        let planner = planner(overrides)?;
        let law = Reading::PLAIN.law(&planner, &RATES, DISTANCE)?;
        let is_thesis =
            |law: &Law| (law.slope - A).abs() < 0.02 && (law.intercept - B).abs() < 0.05;
        claim(
            !law.as_ref().is_some_and(is_thesis),
            "no robot has the thesis' law",
        )?;
        let change = law
            .as_ref()
            .map_or(f64::NAN, |law| 1e3 * greatest_change(law, &plain));
        writeln!(
            rows,
            "| {name} | {change:.0} | {}",
            columns(law.as_ref(), Reading::PLAIN, &planner, &RATES)?
        )?;
    }
    Ok(rows)
}

fn roots(planner: &Planner) -> Outcome<String> {
    let mut rows = String::from(
        "| ω (rad/s) | early α_f (rad) | apex (m) | late α_f (rad) | apex (m) | farthest (m) | at \
         α_f (rad) |\n| --- | --- | --- | --- | --- | --- | --- |\n",
    );
    let radius = planner.robot().body.radius;
    let table = planner.table(&Reading::PLAIN.request(&RATES, DISTANCE, Roots::All))?;
    // The nearest to a distance that nobody reaches is the farthest jump.
    let farthest = planner.table(&Reading::PLAIN.request(&RATES, 100.0, Roots::All))?;
    for (cell, far) in table.cells.iter().zip(&farthest.cells) {
        let (early, late) = match cell.entries.as_slice() {
            [early, late] => (early, Some(late)),
            [early] => (early, None),
            others => return Err(format!("{} angles for one distance", others.len()).into()),
        };
        let far = far.nearest.ok_or("no farthest jump")?;
        claim(
            early.jump.launch.firing_angle < far.firing_angle,
            "the early angle is before the farthest",
        )?;
        claim(
            early.jump.apex() > Some(radius),
            "the early jump flies high",
        )?;
        let write = |entry: &Entry| -> Outcome<String> {
            let apex = entry.jump.apex().ok_or("no apex")?;
            Ok(format!(
                " {} | {apex:.4} |",
                signed(entry.jump.launch.firing_angle, 4)
            ))
        };
        let late = match late {
            Some(late) => {
                claim(
                    late.jump.launch.firing_angle > far.firing_angle,
                    "the late angle is past the farthest",
                )?;
                claim(late.jump.apex() < Some(radius), "the late jump flies low")?;
                write(late)?
            }
            None => " none | |".to_owned(),
        };
        write!(rows, "| {} |{}{late}", cell.rate, write(early)?)?;
        writeln!(
            rows,
            " {:.3} | {} |",
            far.value,
            signed(far.firing_angle, 3)
        )?;
    }
    Ok(rows)
}
