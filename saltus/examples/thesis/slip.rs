//! What section 5.2.2 leaves open: what a foot that slips costs; and what the boom does.

use std::fmt::Write;

use saltus::chart::{COLORS, Chart, Ink};
use saltus::verify::{Flown, Plant, Task};
use saltus::{Launch, Planner, resolve};

use crate::jumper::{Reading, planner};
use crate::law::{DISTANCE, RATES};
use crate::obstacle::{SIDE, best_at};
use crate::{Outcome, Section, claim, signed};

/// Error that the integrator may make in a step.
const TOLERANCE: f64 = 1e-9;
/// Approach rate (rad/s) and firing angles (rad) of figure 5.9.
const RATE: f64 = 5.0;
const ANGLES: [f64; 4] = [-0.25, -0.15, -0.05, 0.05];
/// Friction coefficients of the ground; 0.8 is dry rubber.
const FRICTIONS: [f64; 7] = [0.2, 0.25, 0.3, 0.35, 0.4, 0.6, 0.8];

pub(crate) fn section() -> Outcome<Section> {
    let planar = planner(&[])?;
    let (rows, chart, [least, most]) = slipping(&planar)?;
    let text = format!(
        "## Slip and the boom (what 5.2.2 leaves open)\n\n\"The main drawback of this model is \
         that it assumes there is no slipping of the foot … It is important as future work to \
         measure the effect of the slipping to decide if it is relevant enough to be modeled.\" \
         Here the effect is measured in the multi-body simulation (`saltus verify`), which shares \
         no equation of motion with the planner.\n\n### A foot that slips\n\nThese are the jumps \
         of figure 5.9 (ω = {RATE} rad/s) on ground of different friction. Each cell has the \
         change of the landing at y = 0 against a foot that holds, and how far the foot slips \
         until lift-off (forward positive):\n\n![Landing error over \
         friction](thesis/slip.svg)\n\n| friction | {} |\n| --- |{}\n{rows}\nThese jumps need a \
         friction coefficient of {least:.2} to {most:.2}; the late ones need the most. On ground \
         with more friction slip costs nothing: the simulated jump is the planned one to {} mm. On \
         ground with less friction a jump lands shorter, and more so the later its leg fires: by \
         millimetres where the friction is a little too small, and by more than a decimetre where \
         it is less than half of what is needed. The foot itself slips only a tenth of that \
         distance. What is lost is thrust along the travel, which the ground does not give. So the \
         assumption of the thesis costs nothing on dry rubber (0.8), and it matters on a smooth \
         floor. Every plan and map of Saltus states the friction that it needs, and a course can \
         limit it.\n\n### The boom\n\n{}\n### The box\n\n{}",
        ANGLES
            .map(|angle| format!("α_f = {} rad", signed(angle, 2)))
            .join(" | "),
        " --- |".repeat(ANGLES.len()),
        signed(1e3 * AGREES, 2),
        boom(&planar)?,
        obstacle(&planar)?,
    );
    Ok(Section {
        text,
        drawings: vec![("slip.svg", chart.file())],
    })
}

/// How near (m) two derivations of the same jump have to be.
const AGREES: f64 = 1e-5;

fn task(launch: Launch) -> Task {
    Task {
        launch,
        landing_height: 0.0,
        obstacles: Vec::new(),
        leg_out: 0.0,
    }
}

fn landing(flown: &Flown) -> Outcome<f64> {
    flown
        .landing
        .ok_or_else(|| "a jump without a landing".into())
}

/// Rows of landing errors and slips over friction, their chart, and the least and greatest friction
/// that the jumps need.
fn slipping(planar: &Planner) -> Outcome<(String, Chart, [f64; 2])> {
    let plant = Plant::new(planar.robot().clone(), TOLERANCE);
    let mut chart = Chart::new(
        (760.0, 362.0),
        ("friction coefficient", (0.15, 0.85)),
        ("landing error (mm)", (-140.0, 40.0)),
    );
    let mut columns = Vec::new();
    let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
    for (i, angle) in ANGLES.into_iter().enumerate() {
        let task = task(Reading::PLAIN.launch(RATE, angle));
        let planned = planar
            .jump(&task.launch)?
            .distance(0.0)
            .ok_or("no landing")?;
        let holds = landing(&plant.fly(&task)?)?;
        claim(
            (holds - planned).abs() < AGREES,
            "a foot that holds flies as planned",
        )?;
        let needed = planar.stance().trace(&task.launch)?.contact.friction_needed;
        (least, most) = (least.min(needed), most.max(needed));
        let mut column = Vec::new();
        for friction in FRICTIONS {
            let flown = plant.on_friction(friction).fly(&task)?;
            claim(
                flown.report.slips_at.is_some() == (friction < needed),
                "slip where the ground gives way",
            )?;
            column.push((
                friction,
                landing(&flown).ok().map(|x| x - holds),
                flown.slip(),
            ));
        }
        chart.key(Ink::Solid(COLORS[i]), &format!("{} rad", signed(angle, 2)));
        let points: Vec<(f64, f64)> = column
            .iter()
            .filter_map(|(mu, error, _)| Some((*mu, 1e3 * (*error)?)))
            .collect();
        chart.line(Ink::Solid(COLORS[i]), &points);
        chart.dots(Ink::Solid(COLORS[i]), &points);
        columns.push(column);
    }
    let mut rows = String::new();
    for (k, friction) in FRICTIONS.into_iter().enumerate() {
        write!(rows, "| {friction} |")?;
        for column in &columns {
            let (_, error, slip) = column[k];
            match error {
                Some(error) if slip.abs() < 1e-6 => {
                    write!(rows, " {} mm, holds |", signed(1e3 * error, 0))?;
                }
                Some(error) => {
                    write!(
                        rows,
                        " {} mm, slips {} mm |",
                        signed(1e3 * error, 0),
                        signed(1e3 * slip, 0)
                    )?;
                }
                None => write!(rows, " does not jump |")?,
            }
        }
        rows.push('\n');
    }
    Ok((rows, chart, [least, most]))
}

/// The law for one metre on the robot with its boom, planned without and with the boom's term.
fn boom(planar: &Planner) -> Outcome<String> {
    let plant = Plant::new(resolve("rats-boom", &[])?, TOLERANCE);
    let with_term = Planner::new(plant.robot().clone());
    let mut text = String::from(
        "The robot `rats-boom` has the thesis' boom, and its legs have mass. Its jumps of one \
         metre to y = 0 are planned twice: without the boom, and with the boom as a term of the \
         planar model (inertia and weight at the axle). The whole robot then flies both \
         plans:\n\n| ω (rad/s) | planned without: lands (m) | apex off (mm) | planned with: lands \
         (m) | apex off (mm) |\n| --- | --- | --- | --- | --- |\n",
    );
    let (mut without, mut with) = (Vec::new(), Vec::new());
    for rate in RATES {
        write!(text, "| {rate} |")?;
        for (planner, misses) in [(planar, &mut without), (&with_term, &mut with)] {
            let law = Reading::PLAIN.law(planner, &[rate, rate + 1e-3], DISTANCE)?;
            let angle = law
                .and_then(|law| law.points.first().map(|p| p.exact))
                .ok_or("out of reach")?;
            let task = task(Reading::PLAIN.launch(rate, angle));
            let flown = plant.fly(&task)?;
            let planned = planner.jump(&task.launch)?.apex().ok_or("no apex")?;
            let (land, apex) = (landing(&flown)?, flown.apex.ok_or("no apex")?);
            misses.push(land - DISTANCE);
            write!(text, " {land:.4} | {} |", signed(1e3 * (apex - planned), 1))?;
        }
        text.push('\n');
    }
    // What the legs' mass does: the same with legs of none.
    let massless = Plant::new(resolve("rats-boom", &["leg.mass_kg=0".into()])?, TOLERANCE);
    let mut arc = Vec::new();
    for rate in RATES {
        let law = Reading::PLAIN.law(&with_term, &[rate, rate + 1e-3], DISTANCE)?;
        let angle = law
            .and_then(|law| law.points.first().map(|p| p.exact))
            .ok_or("out of reach")?;
        arc.push(landing(&massless.fly(&task(Reading::PLAIN.launch(rate, angle)))?)? - DISTANCE);
    }
    let rms =
        |misses: &[f64]| (misses.iter().map(|m| m * m).sum::<f64>() / misses.len() as f64).sqrt();
    let (before, after) = (rms(&without), rms(&with));
    let arc = rms(&arc);
    claim(after < 0.5 * before, "the boom's term is worth having")?;
    claim(arc < 0.3 * after, "most of what remains is the legs' mass")?;
    write!(
        text,
        "\nBoom and legs together shorten the landing by {:.1} cm (RMS). With the boom as a term, \
         {:.1} cm remain. Most of this is due to the mass of the jumping leg, which the planar \
         model neglects: the leg stands while the wheel rises, and is picked up at the end of its \
         stroke. With massless legs {:.1} cm remain. They are due to the arc that the robot \
         follows, and to the tilt of the wheel.\n",
        100.0 * before,
        100.0 * after,
        100.0 * arc
    )?;
    Ok(text)
}

/// The jumps over the box, margins as planned and as simulated.
fn obstacle(planar: &Planner) -> Outcome<String> {
    let radius = planar.robot().body.radius;
    let plants = [
        (
            "as planned for",
            Plant::new(planar.robot().clone(), TOLERANCE),
        ),
        (
            "on its boom",
            Plant::new(resolve("rats-boom", &[])?, TOLERANCE),
        ),
    ];
    let mut text = String::from(
        "These are the jumps over the box of 21 cm with the greatest margin, from the table \
         above, planned without the boom:\n\n| ω (rad/s) | margin planned (mm) | simulated as \
         planned for | on its boom | on its boom, friction 0.3 |\n| --- | --- | --- | --- | --- \
         |\n",
    );
    let mut lost = Vec::new();
    for rate in RATES {
        let best = best_at(planar, rate)?;
        let task = Task {
            launch: best.jump.launch,
            landing_height: radius,
            obstacles: vec![[best.front, best.front + SIDE, SIDE]],
            leg_out: 0.0,
        };
        write!(text, "| {rate} | {} |", signed(1e3 * best.margin, 1))?;
        let slippery = plants[1].1.on_friction(0.3);
        for plant in plants.iter().map(|(_, plant)| plant).chain([&slippery]) {
            let flown = plant.fly(&task)?;
            // Behind the box it has to come down behind, as in the plan's margin.
            let behind = flown.landing.map(|x| x - best.front - SIDE - radius);
            let margin = flown.clearances[0].least().min(behind.ok_or("no landing")?);
            write!(text, " {} |", signed(1e3 * margin, 1))?;
            lost.push(best.margin - margin);
        }
        text.push('\n');
    }
    let (same, boom): (Vec<f64>, Vec<f64>) = (
        lost.iter().step_by(3).copied().collect(),
        lost.iter().skip(1).step_by(3).copied().collect(),
    );
    claim(
        same.iter().all(|l| l.abs() < 1e-4),
        "the simulated margin is the planned one without a boom",
    )?;
    let most = boom.iter().copied().fold(0.0, f64::max);
    write!(
        text,
        "\nWithout the boom the simulation confirms every margin to a tenth of a millimetre. The \
         boom costs up to {:.0} mm of the margin, which is more than the slower jumps have. A plan \
         for the real robot must include its boom (`--robot rats-boom`).\n",
        1e3 * most
    )?;
    Ok(text)
}
