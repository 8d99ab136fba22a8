//! Accuracy and speed together: reference rows, random jumps, the 61 × 36 firing table, a plan over
//! a box.
//!
//! `cd studies && cargo run --release --bin speed`

use std::error::Error;
use std::time::Instant;

use saltus_lagrangian::{Launch, LiftOff};
use saltus_planner::course::{Course, Obstacle, Span};
use saltus_planner::{
    Crossing, CrossingAnswer, FIRING_ANGLES, Jump, Measure, PLANNING_TOLERANCE, Planner, Roots,
    TableRequest, flight_after,
};
use saltus_robot::Robot;

fn main() -> Result<(), Box<dyn Error>> {
    let planner = Planner::new(Robot::rats_planar());
    let rows: Vec<Launch> = read("jumps.csv")?
        .iter()
        .map(|row| Launch {
            rate: row[0],
            lean: row[1],
            firing_angle: row[2],
            valve_open: row[3],
        })
        .collect();
    compare("192 reference rows", &planner, &rows);
    compare("20000 random jumps", &planner, &random(20_000));
    table(&planner)?;
    plan(&planner)
}

/// Accuracy of the planner's jumps against fine ones, and the time of each.
fn compare(name: &str, planner: &Planner, launches: &[Launch]) {
    let fine = planner.stance().clone().with_tolerance(1e-13);
    let exact: Vec<[f64; 3]> = launches
        .iter()
        .map(|launch| {
            let end = fine.jump(launch).expect("a legal launch");
            results(planner.robot(), &end)
        })
        .collect();
    let single = || -> Vec<Jump> {
        launches
            .iter()
            .filter_map(|l| planner.jump(l).ok())
            .collect()
    };
    let batch = || -> Vec<Jump> {
        planner
            .jumps(launches)
            .into_iter()
            .filter_map(Result::ok)
            .collect()
    };
    for (route, jumps) in [
        ("one at a time", &single as &dyn Fn() -> Vec<Jump>),
        ("in SIMD lanes", &batch),
    ] {
        let worst = jumps()
            .iter()
            .zip(&exact)
            .flat_map(|(jump, exact)| {
                let got = results(planner.robot(), &jump.stance);
                std::array::from_fn::<f64, 3, _>(|k| {
                    (got[k] - exact[k]).abs() / exact[k].abs().max(0.01)
                })
            })
            .fold(0.0, f64::max);
        let [least, median, most] = time(|| jumps().len()).map(|s| s / launches.len() as f64 * 1e6);
        println!(
            "saltus {name}, {route}: error at most {worst:.1e}; {median:.2} us a jump \
             [{least:.2}..{most:.2}], {:.0} jumps/s",
            1e6 / median
        );
    }
    println!("       (tolerance {PLANNING_TOLERANCE:e})");
}

/// Apex and both landings (m) of a stance's end.
fn results(robot: &Robot, end: &LiftOff) -> [f64; 3] {
    let Some(flight) = flight_after(robot, end) else {
        return [f64::NAN; 3];
    };
    let land = |height| flight.range_to_height(height).unwrap_or(f64::NAN);
    [flight.apex_height(), land(0.24), land(0.0)]
}

/// The firing table, against its reference.
fn table(planner: &Planner) -> Result<(), Box<dyn Error>> {
    let grid = |low: f64, high: f64, n: usize| {
        (0..n)
            .map(|i| low + (high - low) * i as f64 / (n - 1) as f64)
            .collect::<Vec<_>>()
    };
    let mut request = TableRequest {
        rates: grid(3.0, 6.0, 61),
        measure: Measure::Distance {
            landing_height: 0.0,
        },
        targets: grid(0.3, 1.0, 36),
        valve_open: 0.1,
        start_lean: None,
        firing_angles: FIRING_ANGLES,
        roots: Roots::Least,
        sensitivities: false,
        threads: 1,
    };
    let reference = read("table.csv")?;
    for threads in [1, 2] {
        request.threads = threads;
        let table = planner.table(&request)?;
        let worst = table
            .cells
            .iter()
            .zip(&reference)
            .map(|(cell, row)| {
                let angle = cell
                    .entries
                    .first()
                    .map_or(f64::NAN, |e| e.jump.launch.firing_angle);
                (angle - row[2]).abs()
            })
            .fold(0.0, f64::max);
        let [least, median, most] =
            time(|| planner.table(&request).map_or(0, |t| t.cells.len())).map(|s| s * 1e3);
        println!(
            "saltus table 61 x 36, every cell checked by a jump: {threads} thread(s) {median:.2} \
             ms [{least:.2}..{most:.2}]; max |d alpha| {worst:.1e} rad in {} cells",
            table.cells.len()
        );
    }
    Ok(())
}

/// The 21 cm box of thesis §5.2.3, 46 cm before the foot at 5 rad/s, with and without friction as a
/// limit.
fn plan(planner: &Planner) -> Result<(), Box<dyn Error>> {
    let course = Course {
        id: "box".into(),
        start: 0.0,
        start_height: 0.0,
        jumps: 1,
        goal: Span::new(0.7, 1.1),
        obstacles: vec![Obstacle {
            center: 0.46,
            width: 0.21,
            height: 0.21,
        }],
        no_landing: Vec::new(),
    };
    for friction in [None, Some(0.5)] {
        let crossing = Crossing {
            friction,
            ..Crossing::new(course.clone(), 5.0)
        };
        let CrossingAnswer::Plan(plan) = planner.cross(&crossing)? else {
            return Err("no plan".into());
        };
        let [least, median, most] =
            time(|| usize::from(planner.cross(&crossing).is_ok())).map(|s| s * 1e3);
        let limit = friction.map_or("no friction limit".into(), |mu| {
            format!("friction at most {mu}")
        });
        println!(
            "saltus plan over a 21 cm box, {limit}: {median:.3} ms [{least:.3}..{most:.3}], holds \
             in the planar model: {}",
            plan.holds()
        );
    }
    Ok(())
}

/// Least, median and greatest time (s) of nine runs, each long enough to be measured.
fn time(run: impl Fn() -> usize) -> [f64; 3] {
    let mut times: Vec<f64> = (0..9)
        .map(|_| {
            let (start, mut runs) = (Instant::now(), 0);
            while start.elapsed().as_secs_f64() < 0.1 {
                std::hint::black_box(run());
                runs += 1;
            }
            start.elapsed().as_secs_f64() / f64::from(runs)
        })
        .collect();
    times.sort_by(f64::total_cmp);
    [times[0], times[4], times[8]]
}

/// Random jumps over the range of the reference rows, from a fixed seed.
fn random(count: usize) -> Vec<Launch> {
    let mut seed = 7_u64;
    let mut uniform = move || {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        (seed >> 11) as f64 / (1_u64 << 53) as f64
    };
    (0..count)
        .map(|_| {
            let (rate, firing_angle) = (3.0 + 3.0 * uniform(), -0.25 + 0.35 * uniform());
            let lean = if uniform() < 0.5 { firing_angle } else { -0.35 };
            Launch {
                rate,
                lean,
                firing_angle,
                valve_open: 0.02 + 0.08 * uniform(),
            }
        })
        .collect()
}

/// The numbers of a CSV file of the reference; its words become NaN.
fn read(name: &str) -> Result<Vec<Vec<f64>>, Box<dyn Error>> {
    let path = format!("{}/../tests/reference/{name}", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).map_err(|error| format!("{path}: {error}"))?;
    Ok(text
        .lines()
        .skip(1)
        .map(|l| {
            l.split(',')
                .map(|x| x.parse().unwrap_or(f64::NAN))
                .collect()
        })
        .collect())
}
