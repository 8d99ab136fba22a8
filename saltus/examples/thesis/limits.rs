//! What could bring the end speed of the closed loop down to that of the thesis' robot.

use std::fmt::Write;

use saltus::gait::{Program, Smooth};
use saltus::numeric::statistics::median;
use saltus::robot::{ExhaustPort, ReturnSpring};
use saltus::{Robot, resolve};

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

/// Droops (Pa s/kg) of the supply, and the one of the robot with all terms.
const DROOPS: [f64; 3] = [1e7, 4e7, 1e8];
const DROOP: f64 = DROOPS[1];

/// Supply (psi above ambient) while the open valve of `robot` draws all that it can under `droop`
/// (Pa s/kg): P = P_s − K ṁ with the choked flow ṁ = c P.
fn at_full_flow(robot: &Robot, droop: f64) -> Outcome<f64> {
    let cylinder = robot.leg.cylinder().ok_or("a leg without gas")?;
    let (ratio, gas) = (cylinder.gas.heat_ratio, cylinder.gas.constant);
    let choked = (2.0 / (ratio + 1.0)).powf(0.5 * (ratio + 1.0) / (ratio - 1.0));
    let orifice = std::f64::consts::PI * cylinder.orifice_radius.powi(2);
    let area = cylinder.discharge_coefficient * orifice;
    let flow = area * choked * (ratio / (gas * cylinder.temperature)).sqrt();
    let ambient = robot.environment.ambient.0;
    let left = (cylinder.supply.0 + ambient) / (1.0 + droop * flow) - ambient;
    Ok(left / 6894.757293168)
}

fn terms() -> Outcome<Vec<Term>> {
    let robot = resolve("rats-run", &[])?;
    let mut all = Vec::new();
    for x in DROOPS {
        let value = format!("to {:.0} psi at full flow", at_full_flow(&robot, x)?);
        all.push(term("supply droop", value, move |r| droop(r, x)));
    }
    for [mm, mm2] in [[55.0, 20.0], [50.0, 20.0], [50.0, 60.0]] {
        let value = format!("{mm} mm out, {mm2} mm²");
        all.push(term("exhaust ports", value, move |r| {
            port(r, 1e-3 * mm, 1e-6 * mm2);
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
            r.foot.radius = 1e-3 * mm;
        }));
    }
    for x in [0.1, 0.3, 1.0] {
        let value = format!("{x} N m");
        all.push(term("friction of the axle", value, move |r| {
            r.body.axle_friction = x;
        }));
    }
    let value = format!(
        "to {:.0} psi, 50 mm and 20 mm², 500 N m/rad, no spring, 14 mm, 0.3 N m",
        at_full_flow(&robot, DROOP)?
    );
    all.push(term("all together", value, |r| {
        droop(r, DROOP);
        port(r, 0.05, 20e-6);
        flex(r, 500.0);
        r.leg.return_spring = Some(ReturnSpring {
            stiffness: 0.0,
            preload: 0.0,
        });
        r.foot.radius = 0.014;
        r.body.axle_friction = 0.3;
    }));
    Ok(all)
}

/// How many start from rest, and the end speeds (m/s) after the push: least, median, greatest.
fn speeds(program: &Program, set: &(impl Fn(&mut Robot) + Sync)) -> Outcome<(usize, [f64; 3])> {
    let from_rest = drawn(program, SECONDS, &[], set)?;
    let start = from_rest.iter().filter(|(s, _)| runs(s)).count();
    let pushed = drawn(program, SECONDS, &[push(PUSH, 0.5)], set)?;
    let mut ends: Vec<f64> = pushed.iter().map(|(s, _)| s.late_speed()).collect();
    ends.sort_by(f64::total_cmp);
    let (least, most) = (ends[0], ends[ends.len() - 1]);
    Ok((start, [least, median(&mut ends), most]))
}

/// Firing angles (rad) at speed in place of the smooth law's.
const AT_SPEED: [f64; 4] = [-0.1, 0.0, 0.1, 0.2];

pub(crate) fn text() -> Outcome<String> {
    let (start, [least, base, most]) = speeds(&smooth(), &|_| ())?;
    let mut rows = format!("| none | | {base:.2} ({least:.2}, {most:.2}) | | {start} |\n");
    let mut slowest = (base, "none", String::new());
    let mut together = base;
    for Term { name, value, set } in terms()? {
        let (start, [least, middle, most]) = speeds(&smooth(), &|robot: &mut Robot| set(robot))?;
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
    claim(
        slowest.0 > 1.2 * SPEED && together > 1.2 * SPEED,
        "no term explains the speed",
    )?;
    let mut speeds_at = Vec::new();
    for angle in AT_SPEED {
        let mut law = Smooth::QUICK;
        law.firing_angle[1] = angle;
        let (start, [least, middle, most]) = speeds(&law.program(), &|_| ())?;
        writeln!(
            rows,
            "| firing angle at speed | {} rad in place of {} rad | {middle:.2} ({least:.2}, \
             {most:.2}) | {} | {start} |",
            signed(angle, 1),
            signed(Smooth::QUICK.firing_angle[1], 1),
            signed(middle - base, 2)
        )?;
        speeds_at.push(middle);
    }
    let [as_lines, .., latest] = speeds_at[..] else {
        return Err("no firing angle at speed".into());
    };
    claim(
        as_lines < slowest.0 && latest < as_lines,
        "the firing angle does more than any term",
    )?;
    Ok(format!(
        "The closed loop ends at about twice the speed of the thesis' robot, {SPEED} m/s. Terms of \
         the robot file that `rats-run` leaves off, or guesses, are candidates for the difference. \
         Each is switched on by itself, for {ROBOTS} drawn robots under the smooth law. The speed \
         is that over the last 4 of {SECONDS:.0} s. As some terms stop the start, all robots get a \
         push of {PUSH:.0} N m for 0.2 s at 0.5 s; the last column has how many run without \
         it.\n\n| term | value | end speed, median (least, greatest) (m/s) | change (m/s) | run \
         from rest |\n| --- | --- | --- | --- | --- |\n{rows}\nNo single term of the robot explains \
         the difference. The strongest one, {} ({}), leaves {:.1} m/s; all together leave \
         {together:.1} m/s, with the second value of the droop. The firing angle at speed does \
         more: {} rad, where the two lines of the last section end, gives {as_lines:.1} m/s, and \
         {} rad {latest:.1} m/s. (The two lines themselves end faster: their valve stays open for \
         40 ms, that of the smooth law ever more briefly, {:.0} ms in the end.) The thesis gives \
         neither the angle at which its closed loop ends nor its valve time at speed. What limits \
         the thesis' robot is therefore open.\n",
        slowest.1,
        slowest.2,
        slowest.0,
        signed(AT_SPEED[0], 1),
        AT_SPEED[3],
        1e3 * Smooth::QUICK.valve_open[1],
    ))
}
