//! Section 5.1: running, figures 5.3, 5.5 and 5.6.

use std::fmt::Write;

use saltus::chart::{COLORS, Chart, Ink};
use saltus::gait::{Centre, Ending, Program, Smooth, Summary};
use saltus::numeric::statistics::median;
use saltus::running::{Share, Together};

use crate::runner::{
    AT_REST, CLOSED_END, Point, ROBOTS, Ran, SPEED, Trace, chart, drawn, fixed, middle_and_best,
    nominal, one_line, open_loop, push, runs, smooth, stacked, two_lines,
};
use crate::{Outcome, Section, claim, limits, signed};

/// Figure 5.3: its axes (s, rad, rad/s), when the robot is pushed (s), and its firing angle (rad).
const FIXED_END: f64 = 15.0;
const ANGLES: (f64, f64) = (-50.0, 150.0);
const RATES: (f64, f64) = (-5.0, 15.0);
const PUSHED_AT: f64 = 5.0;
const FIRING_ANGLE: f64 = 0.1;
/// Torques (N m) of a push of 0.2 s: the thesis does not say how hard the hand pushed.
const PUSHES: [f64; 2] = [10.0, 12.0];
/// Figures 5.5 and 5.6: their axes (s, m/s, rad).
const END: f64 = 5.0;
const SPEEDS: (f64, f64) = (0.0, 3.5);
const OPEN_ANGLES: (f64, f64) = (0.0, 0.35);
const CLOSED_ANGLES: (f64, f64) = (-0.2, 0.5);
/// How long the robots of the table run (s).
const TABLE: f64 = 9.0;
/// Figure 6.7, table 8.1: speed (m/s) of the closed loop at 1.6 s.
const AT_1_6: f64 = 2.9;

/// A gait of the table: its name, and what became of the drawn robots.
struct Gait {
    name: &'static str,
    all: Vec<Ran>,
}

impl Gait {
    fn new(name: &'static str, program: &Program, is_pushed: bool) -> Outcome<Gait> {
        let pushes = if is_pushed {
            vec![push(PUSHES[1], 0.5)]
        } else {
            Vec::new()
        };
        let all = drawn(program, TABLE, &pushes, &|_| ())?;
        Ok(Gait { name, all })
    }

    fn summaries(&self) -> impl Iterator<Item = &Summary> + Clone {
        self.all.iter().map(|(summary, _)| summary)
    }

    fn together(&self) -> Together {
        Together::of(&self.summaries(), 1.0)
    }

    fn end_speed(&self) -> f64 {
        self.together().speed.map_or(0.0, |[_, middle, _]| middle)
    }

    /// Speed (m/s) at the end of the figure, median of those that run in the end.
    fn at_end(&self) -> f64 {
        let runners = self.all.iter().filter(|(summary, _)| runs(summary));
        let at = |(_, trace): &Ran| {
            trace
                .points
                .iter()
                .find(|p| p.time >= END - 1e-9)
                .map(|p| p.speed)
        };
        median(&mut runners.filter_map(at).collect::<Vec<_>>())
    }

    /// Speed (m/s) at 1.6 s of those that run in the end: median and greatest.
    fn at_1_6(&self) -> Option<[f64; 2]> {
        Together::of(&self.summaries().filter(|s| runs(s)), 1.0).speed_at_1_6
    }

    fn row(&self) -> String {
        let t = self.together();
        let pair = |pair: Option<[f64; 2]>, digits: usize| {
            pair.map_or("–".to_owned(), |[a, b]| {
                format!("{a:.digits$} ({b:.digits$})")
            })
        };
        let speed = t.speed.map_or("–".to_owned(), |[least, middle, most]| {
            format!("{middle:.1} ({least:.1}, {most:.1})")
        });
        format!(
            "| {} | {} | {speed} | {} | {} | {} |",
            self.name,
            t.running[0].count,
            t.within_3_s.count,
            pair(t.time_to_3_2.map(|[least, middle]| [middle, least]), 2),
            pair(self.at_1_6(), 1),
        )
    }
}

/// The gaits of the table, in its order: fixed from rest and pushed, the open loop with C a number
/// and in seconds, the closed loop with one line, two that meet, two as printed, and smooth.
fn gaits() -> Outcome<[Gait; 8]> {
    Ok([
        Gait::new("fixed, 0.1 rad", &fixed(FIRING_ANGLE), false)?,
        Gait::new("fixed, pushed", &fixed(FIRING_ANGLE), true)?,
        Gait::new(
            "open loop, C a number",
            &open_loop(Centre::Printed(3.0)),
            false,
        )?,
        Gait::new(
            "open loop, C in seconds",
            &open_loop(Centre::Seconds(3.0)),
            false,
        )?,
        Gait::new("closed loop, one line", &one_line(), false)?,
        Gait::new("closed loop, two lines that meet", &two_lines(false), false)?,
        Gait::new("closed loop, two lines as printed", &two_lines(true), false)?,
        Gait::new("closed loop, smooth", &smooth(), false)?,
    ])
}

fn running(gait: &Gait) -> Share {
    gait.together().running[0]
}

/// How many run above 2.5 m/s.
fn fast(gait: &Gait) -> usize {
    gait.together().running[1].count
}

/// How many reach 3.2 m/s within 3 s.
fn quick(gait: &Gait) -> usize {
    gait.together().within_3_s.count
}

fn check([_, fixed_pushed, printed, seconds, one, two, jump, smooth]: &[Gait; 8]) -> Outcome<()> {
    claim(
        running(fixed_pushed).count == ROBOTS,
        "5.1.2: runs after a push",
    )?;
    claim(running(smooth).count == ROBOTS, "the smooth law starts")?;
    claim(
        running(seconds).count > running(printed).count,
        "5.1.3: more robots start with C in seconds",
    )?;
    claim(
        jump.end_speed() > seconds.end_speed(),
        "figure 5.6: the closed loop is faster",
    )?;
    claim(quick(smooth) == ROBOTS, "8.1.1: 3.2 m/s within 3 s")?;
    claim(fast(one) < fast(two), "5.1.3: one line rarely gets fast")?;
    claim(
        quick(printed) > 0 && quick(seconds) == 0,
        "5.1.3: only C as a number is quick enough",
    )?;
    claim(
        Smooth::QUICK.firing_angle[0] > CLOSED_ANGLES.1,
        "figure 5.6: the smooth law begins above its axis",
    )?;
    claim(
        running(one) == running(two),
        "5.1.3: as many start under one line as under two",
    )
}

pub(crate) fn section() -> Outcome<Section> {
    let mut drawings = Vec::new();
    let still = fixed_gait(&mut drawings)?;
    let gaits = gaits()?;
    check(&gaits)?;
    let [_, _, printed, seconds, _, two, jump, smooth] = &gaits;
    drawings.push((
        "open-loop.svg",
        loops(
            OPEN_ANGLES,
            &[("C a number", &printed.all), ("C in seconds", &seconds.all)],
        )?,
    ));
    drawings.push((
        "closed-loop.svg",
        loops(
            CLOSED_ANGLES,
            &[
                ("two lines that meet", &two.all),
                ("two lines as printed", &jump.all),
                ("smooth", &smooth.all),
            ],
        )?,
    ));
    let text = format!(
        "## Running (5.1)\n\nThe robot `rats-run` runs under the controller of Saltus in the \
         multi-body simulation. [running.md](running.md) describes the gaits and how the thesis' \
         formulas are read, and has shares of 200 robots. Single runs are chaotic. Therefore most \
         numbers here are of {ROBOTS} drawn robots, and a curve shows the middle robot of those \
         that run in the end, or the fastest one.\n\n### The fixed gait (5.1.2, figure \
         5.3)\n\n{still}\n### The open loop (5.1.3, figure 5.5)\n\n![Open loop: firing angle and \
         speed](thesis/open-loop.svg)\n\nThe firing angle is A tanh(B t − C) + D with B = 2.1 and \
         \"C = 3.0 seconds\". As printed, C is a number, and the middle of the change is at 1.43 \
         s; as seconds it is at 3 s. With C as a number {} of {ROBOTS} robots run, with C in \
         seconds {}. The thesis' robot has {SPEED} m/s in less than 3 s. Only the first reading \
         allows that: {} robots are as quick under it, none under the second. Both readings end \
         above the axis of the figure.\n\n### The closed loop (5.1.3, figure 5.6)\n\n![Closed \
         loop: firing angle and speed](thesis/closed-loop.svg)\n\nThe thesis gives no numbers of \
         these lines. They are read as going from {AT_REST} to {} rad, inside the figure's axis. The \
         smooth law begins above that axis, at {} rad. All laws end above the axis of the \
         speeds.\n\n{}\n### What limits the speed\n\n{}",
        running(printed).count,
        running(seconds).count,
        quick(printed),
        signed(CLOSED_END, 1),
        Smooth::QUICK.firing_angle[0],
        statements(&gaits)?,
        limits::text()?,
    );
    Ok(Section { text, drawings })
}

fn statements(gaits: &[Gait; 8]) -> Outcome<String> {
    let [fixed_rest, fixed_pushed, _, seconds, one, two, jump, smooth] = gaits;
    let mut rows = String::new();
    for gait in gaits {
        writeln!(rows, "{}", gait.row())?;
    }
    Ok(format!(
        "### The statements of 5.1 and 8.1\n\nThese are {ROBOTS} drawn robots, {TABLE:.0} \
         s from rest; the pushed ones get {} N m for 0.2 s at 0.5 s. A robot runs if it is faster \
         than 1.5 m/s over its last 4 s.\n\n| gait | run | speed in the end, median (least, \
         greatest) (m/s) | {SPEED} m/s within 3 s | {SPEED} m/s after, median (best) (s) | speed at \
         1.6 s, median of those that run (best) (m/s) |\n| --- | --- | --- | --- | --- | --- \
         |\n{rows}\n| thesis | Saltus |\n| --- | --- |\n| from rest to {SPEED} m/s in less than 3 s \
         (8.1.1) | two lines that meet: {}; smooth law: {} |\n| {AT_1_6} m/s at 1.6 s with the \
         closed loop (figure 6.7, table 8.1) | two lines that meet: {}; smooth law: {} |\n| the \
         fixed gait cannot start itself (5.1.2) | holds but for {} |\n| after an impulse by hand it \
         runs smoothly (5.1.2) | holds after {} N m: {} run, {} of them above 2.5 m/s |\n| top \
         speed at a firing angle of about 0° (5.1.2) | {} |\n| open loop: about {SPEED} m/s in the \
         end (figure 5.5) | C in seconds: {:.1} m/s at {END} s, {:.1} m/s in the end (medians of \
         those that run) |\n| a single line \"did not work\": the robot fires a couple of legs, then \
         stalls (5.1.3) | {} run, {} of them above 2.5 m/s |\n| two lines work (5.1.3) | {} \
         run, {} of them above 2.5 m/s: faster, but as few start |\n| the closed loop is \
         faster than the open one (figure 5.6) | holds for two lines as printed: {:.1} m/s against \
         {:.1} m/s. Two lines that meet: {:.1} m/s over the few that run, of which some bounce; \
         the median of 200 robots is in running.md, and there it holds |\n",
        PUSHES[1],
        first(two),
        first(smooth),
        second(two),
        second(smooth),
        share(running(fixed_rest)),
        PUSHES[1],
        share(running(fixed_pushed)),
        fast(fixed_pushed),
        firing_angles()?,
        seconds.at_end(),
        seconds.end_speed(),
        share(running(one)),
        fast(one),
        share(running(two)),
        fast(two),
        jump.end_speed(),
        seconds.end_speed(),
        two.end_speed(),
    ))
}

fn share(share: Share) -> String {
    format!("{} of {}", share.count, share.of)
}

/// How soon 3.2 m/s is reached.
fn first(gait: &Gait) -> String {
    let t = gait.together();
    let best = t.time_to_3_2.map_or(String::new(), |[best, middle]| {
        format!(", after {middle:.2} s (median), {best:.2} s (best)")
    });
    format!("{} robots{best}", share(t.within_3_s))
}

/// The speed at 1.6 s.
fn second(gait: &Gait) -> String {
    gait.at_1_6().map_or("none".to_owned(), |[middle, best]| {
        format!("{middle:.1} m/s (median of those that run), {best:.1} m/s (best)")
    })
}

/// Figure 5.3.
fn fixed_gait(drawings: &mut Vec<(&'static str, String)>) -> Outcome<String> {
    let from_rest = nominal(fixed(FIRING_ANGLE), FIXED_END, Vec::new())?.0;
    let Ending::Stalled { since, at } = from_rest.ending else {
        return claim(false, "5.1.2: stalls from rest").map(|()| String::new());
    };
    let mut ran = Vec::new();
    for torque in PUSHES {
        ran.push(nominal(
            fixed(FIRING_ANGLE),
            FIXED_END,
            vec![push(torque, PUSHED_AT)],
        )?);
    }
    let [bounces, fast] = [&ran[0].0, &ran[1].0];
    claim(from_rest.firings == 1, "5.1.2: fires once")?;
    claim(
        runs(bounces) && bounces.late_speed() < 2.5 && fast.late_speed() > 2.5,
        "5.1.2: two modes after a push",
    )?;
    let of = |value: fn(&Point) -> f64| {
        let lines = ran.iter().zip(COLORS);
        let line = |((_, trace), color): (&Ran, &'static str)| {
            (Ink::Solid(color), points(trace, FIXED_END, value))
        };
        lines.map(line).collect::<Vec<_>>()
    };
    let mut angle = chart(
        302.0,
        FIXED_END,
        ("wheel angle (rad)", ANGLES),
        &of(|p| p.angle),
    );
    let rate = chart(302.0, FIXED_END, ("rate (rad/s)", RATES), &of(|p| p.rate));
    for (torque, color) in PUSHES.iter().zip(COLORS) {
        angle.key(
            Ink::Solid(color),
            &format!("{torque} N m for 0.2 s at {PUSHED_AT} s"),
        );
    }
    angle.key(Ink::Solid(COLORS[6]), "shaded: the axes of figure 5.3");
    drawings.push(("fixed-gait.svg", stacked(&[(302.0, angle), (302.0, rate)])));
    let rates = || ran[1].1.points.iter().map(|p| (p.time, p.rate));
    let late = rates().filter(|p| p.0 >= FIXED_END - 4.0).map(|p| p.1);
    let late: Vec<f64> = late.collect();
    let steady = late.iter().sum::<f64>() / late.len() as f64;
    let peak = rates().map(|p| p.1).fold(0.0, f64::max);
    let end = ran[1].1.points.last().map_or(0.0, |p| p.angle);
    claim(
        steady < RATES.1 && end < ANGLES.1 && peak > RATES.1,
        "figure 5.3: the fast mode stays inside its axes",
    )?;
    Ok(format!(
        "![Wheel angle and rate of the fixed gait](thesis/fixed-gait.svg)\n\nFrom rest the robot \
         fires once, rocks, and stands still since {since:.2} s, at {at:.2} m. A push at \
         {PUSHED_AT} s makes it run. The thesis does not say how hard its push was, and the mode \
         depends on it: after {} N m for 0.2 s the robot bounces at {:.2} m/s, after {} N m it runs \
         at {:.2} m/s. The fast mode agrees with the \
         figure: over the last 4 s its mean rate is {steady:.1} rad/s, and its wheel has turned by \
         {end:.0} rad at {FIXED_END} s, where the axes end at {} rad/s and {} rad. (A second after \
         the push the rate has peaks of {peak:.0} rad/s, above the axis.) It is also about as fast \
         as the thesis' robot in the end, {SPEED} m/s. The drawn robots are faster, as the table \
         below shows.\n",
        PUSHES[0],
        bounces.late_speed(),
        PUSHES[1],
        fast.late_speed(),
        RATES.1,
        ANGLES.1,
    ))
}

fn points(trace: &Trace, end: f64, value: fn(&Point) -> f64) -> Vec<(f64, f64)> {
    let points = trace.points.iter().take_while(|p| p.time <= end + 1e-9);
    points.map(|p| (p.time, value(p))).collect()
}

/// A line of a chart.
type Line = (Ink<'static>, Vec<(f64, f64)>);

/// Figures 5.5 and 5.6: firing angle and speed of the middle robot and the fastest.
fn loops(angles: (f64, f64), gaits: &[(&str, &Vec<Ran>)]) -> Outcome<String> {
    let of = |value: fn(&Point) -> f64| -> Outcome<Vec<Line>> {
        let mut lines = Vec::new();
        for ((name, all), color) in gaits.iter().zip(COLORS) {
            let Some([middle, best]) = middle_and_best(all) else {
                return Err(format!("{name}: none runs").into());
            };
            lines.push((Ink::Solid(color), points(middle, END, value)));
            lines.push((Ink::Dotted(color), points(best, END, value)));
        }
        Ok(lines)
    };
    let mut angle = chart(
        302.0,
        END,
        ("firing angle (rad)", angles),
        &of(|p| p.firing_angle)?,
    );
    let speed: Chart = chart(362.0, END, ("speed (m/s)", SPEEDS), &of(|p| p.speed)?);
    for ((name, _), color) in gaits.iter().zip(COLORS) {
        angle.key(Ink::Solid(color), name);
    }
    angle.key(
        Ink::Solid(COLORS[6]),
        "solid: middle robot; dotted: fastest; shaded: the thesis' axes",
    );
    Ok(stacked(&[(302.0, angle), (362.0, speed)]))
}

/// The pushed fixed gait's speed (m/s) over its firing angle.
fn firing_angles() -> Outcome<String> {
    let (mut cells, mut medians) = (Vec::new(), Vec::new());
    for angle in [-0.2, -0.1, 0.0, 0.1, 0.2] {
        let all = drawn(&fixed(angle), TABLE, &[push(PUSHES[1], 0.5)], &|_| ())?;
        let mut speeds: Vec<f64> = all.iter().map(|(s, _)| s.late_speed()).collect();
        let middle = median(&mut speeds);
        medians.push(middle);
        cells.push(format!("{middle:.1} m/s at {} rad", signed(angle, 1)));
    }
    let fastest = medians.iter().copied().fold(0.0, f64::max);
    claim(medians[1] == fastest, "5.1.2: fastest at -0.1 rad")?;
    Ok(format!(
        "at −0.1 rad, −6°: pushed, medians {}",
        cells.join(", ")
    ))
}
