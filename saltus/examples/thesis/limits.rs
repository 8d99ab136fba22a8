//! What could bring the end speed of the closed loop down to that of the thesis' robot.

use std::fmt::Write;

use saltus::Robot;
use saltus::numeric::statistics::median;
use saltus::robot::{ExhaustPort, ReturnSpring};

use crate::runner::{ROBOTS, SPEED, drawn, push, runs, smooth};
use crate::{Outcome, claim, signed};

/// How long the robots run (s), and the push (N m, at 0.5 s) that all of them start with.
const SECONDS: f64 = 12.0;
const PUSH: f64 = 10.0;

/// A term of the robot file, and how it gets into a robot.
struct Term {
    name: &'static str,
    value: String,
    set: Box<dyn Fn(&mut Robot) + Sync>,
}

fn term(name: &'static str, value: String, set: impl Fn(&mut Robot) + Sync + 'static) -> Term {
    Term {
        name,
        value,
        set: Box::new(set),
    }
}

fn droop(robot: &mut Robot, droop: f64) {
    if let Some(cylinder) = robot.leg.cylinder_mut() {
        cylinder.supply_droop = droop;
    }
}

fn port(robot: &mut Robot, position: f64, area: f64) {
    if let Some(cylinder) = robot.leg.cylinder_mut() {
        cylinder.exhaust_port = Some(ExhaustPort { position, area });
    }
}

fn flex(robot: &mut Robot, stiffness: f64) {
    if let Some(boom) = &mut robot.boom {
        boom.flex = Some(stiffness);
        boom.flex_time = 1e-3;
    }
}

fn terms() -> Vec<Term> {
    let mut all = Vec::new();
    // The open valve draws about 4 g/s, so 1e7 Pa s/kg takes about 6 psi of 120.
    for x in [1e7, 4e7, 1e8] {
        let value = format!("{:.0} psi for each g/s", x * 1e-3 / 6894.757293168);
        all.push(term("supply droop", value, move |r| droop(r, x)));
    }
    for [mm, mm2] in [[55.0, 20.0], [50.0, 20.0], [50.0, 60.0]] {
        let value = format!("{mm} mm out, {mm2} mm²");
        all.push(term("exhaust ports", value, move |r| {
            port(r, 1e-3 * mm, 1e-6 * mm2)
        }));
    }
    for x in [2000.0, 500.0] {
        let value = format!("{x} N m/rad");
        all.push(term("boom flex", value, move |r| flex(r, x)));
    }
    for [preload, stiffness] in [[2.0, 20.0], [0.0, 0.0]] {
        let value = format!("{preload} N + {stiffness} N/m");
        all.push(term("weak spring", value, move |r| {
            r.leg.return_spring = Some(ReturnSpring { stiffness, preload });
        }));
    }
    for mm in [0.0, 14.0, 20.0] {
        let value = format!("{mm} mm in place of 7 mm");
        all.push(term("radius of the rolling feet", value, move |r| {
            r.foot.radius = 1e-3 * mm
        }));
    }
    for x in [0.1, 0.3, 1.0] {
        let value = format!("{x} N m");
        all.push(term("friction of the axle", value, move |r| {
            r.body.axle_friction = x
        }));
    }
    let value = "10 psi for each g/s, 50 mm and 20 mm², 500 N m/rad, no spring, 14 mm, 0.3 N m"
        .replace("10 psi", &format!("{:.0} psi", 4e7 * 1e-3 / 6894.757293168));
    all.push(term("all together", value, |r| {
        droop(r, 4e7);
        port(r, 0.05, 20e-6);
        flex(r, 500.0);
        r.leg.return_spring = Some(ReturnSpring {
            stiffness: 0.0,
            preload: 0.0,
        });
        r.foot.radius = 0.014;
        r.body.axle_friction = 0.3;
    }));
    all
}

/// How many start from rest, and the end speeds (m/s) after the push: least, median, greatest.
fn speeds(set: &(impl Fn(&mut Robot) + Sync)) -> Outcome<(usize, [f64; 3])> {
    let from_rest = drawn(&smooth(), SECONDS, &[], set)?;
    let start = from_rest
        .iter()
        .filter(|(summary, _)| runs(summary))
        .count();
    let pushed = drawn(&smooth(), SECONDS, &[push(PUSH, 0.5)], set)?;
    let mut ends: Vec<f64> = pushed
        .iter()
        .map(|(summary, _)| summary.last_speed)
        .collect();
    ends.sort_by(f64::total_cmp);
    let (least, most) = (ends[0], ends[ends.len() - 1]);
    Ok((start, [least, median(&mut ends), most]))
}

pub(crate) fn text() -> Outcome<String> {
    let (start, [least, base, most]) = speeds(&|_| ())?;
    let mut rows = format!("| none | | {base:.2} ({least:.2}, {most:.2}) | | {start} |\n");
    let mut slowest = (base, "none", String::new());
    let mut together = base;
    for Term { name, value, set } in terms() {
        let (start, [least, middle, most]) = speeds(&|robot: &mut Robot| set(robot))?;
        writeln!(
            rows,
            "| {name} | {value} | {middle:.2} ({least:.2}, {most:.2}) | {} | {start} |",
            signed(middle - base, 2)
        )?;
        if name == "all together" {
            together = middle;
        } else if middle < slowest.0 {
            slowest = (middle, name, value);
        }
    }
    claim(slowest.0 > 1.2 * SPEED, "no single term explains the speed")?;
    Ok(format!(
        "The closed loop ends at about twice the speed of the thesis' robot, {SPEED} m/s. Terms of \
         the robot file that `rats-run` leaves off, or guesses, are candidates for the difference. \
         Each is switched on by itself, for {ROBOTS} drawn robots under the smooth law: speed over \
         the last 4 of {SECONDS:.0} s after a push of {PUSH:.0} N m for 0.2 s at 0.5 s, with which all start, and how \
         many run without it.\n\n| term | value | end speed, median (least, greatest) (m/s) | \
         change (m/s) | start from rest |\n| --- | --- | --- | --- | --- |\n{rows}\nNo single term \
         explains the difference. The strongest one, {} ({}), leaves {:.1} m/s; all together leave \
         {together:.1} m/s. Axle friction, larger feet and large ports stop the start rather than \
         the run. The firing angle alone does more: the pushed fixed gait has the thesis' speed at \
         0.1 rad. So the thesis' closed loop may end at a larger firing angle than is read off the \
         axis of figure 5.6 here. Nothing is tuned to agree.\n",
        slowest.1, slowest.2, slowest.0
    ))
}
