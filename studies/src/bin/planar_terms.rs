//! What planar terms are worth: jumps of `rats-boom` by the planar model, by the same with the mass
//! of the leg that it picks up, and with the arc of the boom in flight, against the multi-body
//! simulation.
//!
//! `cd studies && cargo run --release --bin planar_terms` prints mean, root mean square and
//! the greatest of the differences of apex and landing (mm).

use saltus::ballistic::Flight;
use saltus::planner::{JumpModel, Planar};
use saltus::simulated::Simulated;
use saltus::{Launch, Robot, resolve};

/// Apex (m) and landing (m, at the height of the wheel's radius) of a jump.
type Result = [f64; 2];

fn main() {
    let (full, massless) = (
        resolve("rats-boom", &[]).expect("built in"),
        resolve(
            "rats-boom",
            &["leg.mass_kg=0".into(), "leg.center_m=0".into()],
        )
        .expect("sound"),
    );
    for (what, robot) in [("rats-boom", &full), ("its legs without mass", &massless)] {
        for valve_open in [0.1, 0.03] {
            compare(what, robot, valve_open);
        }
    }
}

/// Prints how far the planar model with each term is from `robot` as the multi-body simulation has
/// it.
fn compare(what: &str, robot: &Robot, valve_open: f64) {
    let truth = Simulated::new(robot.clone()).expect("a robot that can be simulated");
    let plain = Planar::new(robot.clone());
    let mut heavy = robot.clone();
    heavy.leg.picked_up = robot.leg.body.mass;
    let heavy = Planar::new(heavy);
    let boom = robot.boom.expect("a boom").length;
    let radius = robot.body.radius;
    let of =
        |flight: Flight<f64>| Some([flight.apex_height(), flight.range_to_height(radius).ok()?]);
    let arc = |flight: Flight<f64>| on_the_arc(flight, boom, radius);
    let mut off: [Vec<Result>; 4] = Default::default();
    for launch in launches(valve_open) {
        let result = truth.jump(&launch).ok();
        let result = result.and_then(|jump| Some([jump.apex()?, jump.distance(radius)?]));
        let flight = |model: &Planar| Some(model.jump(&launch).ok()?.exact_flight()?.vacuum);
        let (Some(truth), Some(plain), Some(heavy)) = (result, flight(&plain), flight(&heavy))
        else {
            continue;
        };
        let all = [of(plain), of(heavy), Some(arc(plain)), Some(arc(heavy))];
        for (off, answer) in off.iter_mut().zip(all) {
            off.extend(answer.map(|x| [0, 1].map(|k| 1e3 * (x[k] - truth[k]))));
        }
    }
    println!(
        "{what}, valve open for {valve_open} s: {} jumps",
        off[0].len()
    );
    for (term, off) in ["planar", "with pick-up", "with arc", "with both"]
        .iter()
        .zip(&off)
    {
        let [apex, landing] =
            [0, 1].map(|k| summary(&off.iter().map(|x| x[k]).collect::<Vec<_>>()));
        println!("  {term:12}  apex {apex}   landing {landing}");
    }
}

/// Approach rates and firing angles of the thesis' tables.
fn launches(valve_open: f64) -> impl Iterator<Item = Launch> {
    (0..7).flat_map(move |i| {
        (0..9).map(move |j| {
            let (rate, angle) = (3.0 + 0.5 * f64::from(i), -0.4 + 0.1 * f64::from(j));
            Launch::at_firing(rate, angle, valve_open)
        })
    })
}

/// Mean, root mean square and the greatest of `off` (mm).
fn summary(off: &[f64]) -> String {
    let n = off.len() as f64;
    let mean = off.iter().sum::<f64>() / n;
    let rms = (off.iter().map(|x| x * x).sum::<f64>() / n).sqrt();
    let worst = off.iter().map(|x| x.abs()).fold(0.0, f64::max);
    format!("{mean:6.2} {rms:6.2} {worst:6.2} mm")
}

/// The flight of a point on a boom of `length` (m): its base keeps the moment of momentum about the
/// vertical, and pulls the point down as it turns. By the midpoint rule.
fn on_the_arc(start: Flight<f64>, length: f64, radius: f64) -> Result {
    let mut pivot = ((start.y - radius) / length).asin();
    let mut rate = start.vy / (length * pivot.cos());
    let moment = start.vx / length * pivot.cos().powi(2);
    let turn = |pivot: f64| moment / pivot.cos().powi(2);
    let acceleration = |pivot: f64| {
        -start.gravity / length * pivot.cos() - turn(pivot).powi(2) * pivot.sin() * pivot.cos()
    };
    let h = 1e-5;
    let (mut x, mut apex) = (start.x, start.y);
    while rate > 0.0 || pivot > 0.0 {
        let middle = pivot + 0.5 * h * rate;
        x += h * turn(middle) * length;
        pivot += h * (rate + 0.5 * h * acceleration(pivot));
        rate += h * acceleration(middle);
        apex = apex.max(radius + length * pivot.sin());
    }
    [apex, x]
}
