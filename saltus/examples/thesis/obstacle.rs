//! Section 5.2.3, figures 5.10 and 5.11: the box with a square profile of 21 cm.

use std::fmt::Write;

use saltus::Planner;
use saltus::ballistic::{Disc, Obstacle};
use saltus::chart::{COLORS, Chart, Ink};
use saltus::planner::{Jump, Roots};

use crate::jumper::{Reading, path, planner, range};
use crate::law::{DISTANCE, RATES};
use crate::{Outcome, Section, claim, signed};

/// Side of the box (m), figure 5.10.
pub(crate) const SIDE: f64 = 0.21;
/// Approach rates (rad/s) between which the least that clears the box is looked for.
const SLOW: f64 = 1.0;
const FAST: f64 = 6.0;

/// A jump over the box.
#[derive(Clone)]
pub(crate) struct Over {
    pub(crate) jump: Jump,
    /// From the foot to the front of the box (m).
    pub(crate) front: f64,
    /// Least distance of the wheel from the box (m), negative inside.
    pub(crate) margin: f64,
}

pub(crate) fn section() -> Outcome<Section> {
    let planner = planner(&[])?;
    let radius = planner.robot().body.radius;
    let mut chart = Chart::to_scale(760.0, ("x (m)", (-0.35, 1.35)), ("y (m)", (-0.03, 0.95)));
    chart.line(Ink::Solid(COLORS[6]), &[(-0.35, 0.0), (1.35, 0.0)]);
    let (mut rows, mut metre_rows, mut metre_margins) = (String::new(), String::new(), Vec::new());
    for rate in RATES {
        let best = best_at(&planner, rate)?;
        rows += &row(&planner, rate, &best, radius)?;
        let table = planner.table(&Reading::PLAIN.request(&[rate], DISTANCE, Roots::Least))?;
        let entry = table.cells[0]
            .entries
            .first()
            .ok_or("one metre is out of reach")?;
        let metre = best_front(&planner, entry.jump.clone())?;
        metre_rows += &row(&planner, rate, &metre, radius)?;
        metre_margins.push(metre.margin);
    }
    let least = least_rate(&planner)?;
    let slow = best_at(&planner, least)?;
    let fast = best_at(&planner, RATES[4])?;
    draw(
        &mut chart,
        &planner,
        &slow,
        COLORS[1],
        &format!("{least:.2} rad/s: just clears the box"),
    )?;
    draw(
        &mut chart,
        &planner,
        &fast,
        COLORS[0],
        &format!("{} rad/s", RATES[4]),
    )?;
    let metre_clears = metre_margins.iter().any(|margin| *margin > 0.0);
    let text = format!(
        "## The box of 21 cm (5.2.3, figures 5.10 and 5.11)\n\nThe thesis' robot jumps a \
         cardboard box with a square profile of {:.0} cm \"without touching it\". The thesis gives \
         neither the approach rate nor the distance from the foot to the box. Here the firing \
         angle and that distance are chosen for the greatest clearance of the wheel, from the \
         firing until its centre comes down to y = r_s. The margin is that clearance.\n\n![Jumps \
         over the box](thesis/box.svg)\n\n| ω (rad/s) | α_f (rad) | foot to box (m) | margin (mm) \
         | apex (m) | distance to y = r_s (m) | to y = 0 (m) | friction needed |\n| --- | --- | \
         --- | --- | --- | --- | --- | --- |\n{rows}\nThe robot clears the box from ω = {least:.2} \
         rad/s on ({:.2} m/s of the wheel's centre), with the foot {:.2} m before it. The next \
         table is for the jumps of one metre to y = 0, where only the place of the box is \
         free:\n\n| ω (rad/s) | α_f (rad) | foot to box (m) | margin (mm) | apex (m) | distance to \
         y = r_s (m) | to y = 0 (m) | friction needed |\n| --- | --- | --- | --- | --- | --- | --- \
         | --- |\n{metre_rows}\n{} In the model the foot does not slip; the last column has the \
         friction that this needs. The margins do not include the fired leg, which sticks out \
         below the wheel until its air is exhausted. The thesis does not say where its legs \
         were.\n",
        100.0 * SIDE,
        least * radius,
        slow.front,
        if metre_clears {
            "A jump of one metre clears the box where the margin is positive."
        } else {
            "So one metre to y = 0 does not clear the box at any of these rates: under this \
             reading the robot of the thesis must have gone farther, or faster, than its law asks."
        },
    );
    Ok(Section {
        text,
        drawings: vec![("box.svg", chart.file())],
    })
}

fn row(planner: &Planner, rate: f64, over: &Over, radius: f64) -> Outcome<String> {
    let trace = planner.stance().trace(&over.jump.launch)?;
    let (apex, level, ground) = (
        over.jump.apex(),
        over.jump.distance(radius),
        over.jump.distance(0.0),
    );
    let mut out = String::new();
    writeln!(
        out,
        "| {rate} | {} | {:.3} | {} | {:.3} | {:.3} | {:.3} | {:.2} |",
        signed(over.jump.launch.firing_angle, 3),
        over.front,
        signed(1e3 * over.margin, 1),
        apex.ok_or("no apex")?,
        level.ok_or("no landing")?,
        ground.ok_or("no landing")?,
        trace.contact.friction_needed,
    )?;
    Ok(out)
}

/// Clearance (m) of the wheel from the box at `front`, in stance and flight.
fn margin(planner: &Planner, jump: &Jump, stance: &[(f64, f64)], front: f64) -> Outcome<f64> {
    let radius = planner.robot().body.radius;
    let flight = jump.exact_flight().ok_or("no flight")?;
    let solid = Obstacle::block([front, 0.0], [front + SIDE, SIDE])?;
    let landing = flight.time_to_height(radius)?;
    let flying = flight.clearance(&Disc::wheel(radius), &solid, 0.0, landing)?;
    // On its foot the wheel is in front of the box.
    let gap = |(x, y): &(f64, f64)| (front - x).max(0.0).hypot((y - SIDE).max(0.0)) - radius;
    // It comes down behind the box, and not before it.
    let behind = flight.range_to_height(radius)? - front - SIDE - radius;
    Ok(stance.iter().map(gap).fold(flying.min(behind), f64::min))
}

/// The best place of the box for `jump`.
fn best_front(planner: &Planner, jump: Jump) -> Outcome<Over> {
    let [stance, _] = path(planner, &jump, planner.robot().body.radius)?;
    let of = |front: f64| margin(planner, &jump, &stance, front);
    let (front, margin) = greatest(0.1, 0.9, 33, of)?;
    Ok(Over {
        jump,
        front,
        margin,
    })
}

/// The best firing angle and place of the box at `rate`.
pub(crate) fn best_at(planner: &Planner, rate: f64) -> Outcome<Over> {
    let over = |angle: f64| best_front(planner, planner.jump(&Reading::PLAIN.launch(rate, angle))?);
    let (angle, _) = greatest(-0.5, 0.3, 33, |angle| {
        Ok(over(angle).map_or(-1.0, |over| over.margin))
    })?;
    over(angle)
}

/// The least rate at which the margin is not negative.
fn least_rate(planner: &Planner) -> Outcome<f64> {
    let (mut low, mut high) = (SLOW, FAST);
    claim(
        best_at(planner, low)?.margin < 0.0,
        "the slowest touches the box",
    )?;
    claim(
        best_at(planner, high)?.margin > 0.0,
        "the fastest clears the box",
    )?;
    // A tenth of what is printed.
    while high - low > 1e-3 {
        let middle = f64::midpoint(low, high);
        if best_at(planner, middle)?.margin < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    Ok(high)
}

/// Where `f` is greatest between `low` and `high`, and its value there: the best of `count` points,
/// then ever finer around it.
fn greatest(
    low: f64,
    high: f64,
    count: u32,
    f: impl Fn(f64) -> Outcome<f64>,
) -> Outcome<(f64, f64)> {
    let (mut best, mut width) = ((low, f64::NEG_INFINITY), 0.5 * (high - low));
    let mut points = range(low, high, count);
    let mut step = (high - low) / f64::from(count - 1);
    while width > 1e-6 {
        for x in points {
            let value = f(x)?;
            if value > best.1 {
                best = (x, value);
            }
        }
        width = step;
        points = range((best.0 - width).max(low), (best.0 + width).min(high), 9);
        step = width / 4.0;
    }
    Ok(best)
}

fn draw(chart: &mut Chart, planner: &Planner, over: &Over, color: &str, key: &str) -> Outcome<()> {
    let radius = planner.robot().body.radius;
    // The box stands still; feet stand where each jump wants them.
    let shift = 0.5 - over.front;
    let moved = |points: Vec<(f64, f64)>| {
        points
            .into_iter()
            .map(|(x, y)| (x + shift, y))
            .collect::<Vec<_>>()
    };
    let [stance, flight] = path(planner, &over.jump, radius)?.map(moved);
    chart.block(Ink::Solid("#beb4a5"), (0.5, 0.0), (0.5 + SIDE, SIDE));
    for i in 0..5 {
        let (x, y) = flight[i * (flight.len() - 1) / 4];
        let rim = range(0.0, std::f64::consts::TAU, 73);
        let rim: Vec<_> = rim
            .iter()
            .map(|t| (x + radius * t.cos(), y + radius * t.sin()))
            .collect();
        chart.line(Ink::Faint(color), &rim);
    }
    chart.line(Ink::Solid(color), &stance);
    chart.line(Ink::Dotted(color), &flight);
    chart.dots(Ink::Solid(color), &[(shift, 0.0)]);
    chart.key(Ink::Solid(color), key);
    Ok(())
}
