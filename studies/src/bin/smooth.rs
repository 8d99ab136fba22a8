//! Searches for one smooth law, α_f and t_v over the rate, on drawn robots, and scores it on others
//! beside the thesis' two lines.
//!
//! ```text
//! cd studies && cargo run --release --bin smooth -- time 12 20
//! ```
//!
//! The aim is time (to 1.6 m), speed (in the end) or gas (a metre at 3.2 m/s or more); then come how
//! many robots it is sought on, and for how many generations: 2 and 1 where nothing is given.

use saltus_gait::{
    Draw, Ensemble, Lines, Program, Search, Setup, Summary, drawn_robot, run, search,
};
use saltus_numeric::parallel::available;
use saltus_robot::Robot;
use saltus_studies::laws::{BOUNDS, smooth as law};

/// Seeds of the robots that a law is sought on, and of those it is scored on.
const SOUGHT: u64 = 100;
const HELD_OUT: u64 = 200;

fn setup(robot: Robot, program: Program, seconds: f64) -> Setup {
    let mut setup = Setup::new(robot, program, seconds);
    setup.zone = -0.3;
    setup
}

fn worth(aim: &str, s: &Summary) -> f64 {
    match aim {
        "time" => -s.time_to_1_6_m.unwrap_or(5.0 - s.travel.clamp(0.0, 1.6)),
        "speed" => s.late_speed(),
        _ if s.late_speed() < 3.2 => -1.0 + 0.1 * s.late_speed(),
        _ => -1e3 * s.gas / s.travel,
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [aim, robots, generations] = match &arguments[..] {
        [] => ["time", "2", "1"],
        [aim, robots, generations] => [aim, robots, generations].map(String::as_str),
        _ => return Err("give time, speed or gas; robots; generations".into()),
    };
    let (robots, generations): (usize, usize) = (robots.parse()?, generations.parse()?);
    let base = saltus_robot::resolve("rats-run", &[])?;
    let seconds = if aim == "time" { 3.0 } else { 9.0 };
    let one = |x: &[f64], k: usize| {
        let robot = drawn_robot(&base, &Draw::default(), SOUGHT, k)?;
        let setup = Setup {
            seed: SOUGHT + k as u64,
            ..setup(robot, law(x).program(), seconds)
        };
        run(&setup, &mut ())
    };
    let score = |x: &[f64]| -> f64 {
        let worths = (0..robots).map(|k| one(x, k).map_or(-10.0, |s| worth(aim, &s)));
        worths.sum::<f64>() / robots as f64
    };
    let settings = Search {
        bounds: BOUNDS.to_vec(),
        start: vec![0.4, -0.1, 7.0, 0.06, 0.045, 7.0],
        spread: 0.25,
        candidates: 40,
        best: 8,
        generations,
        seed: 1,
    };
    let (x, best) = search(&settings, available(), score, |generation, best, x| {
        eprintln!("{generation} {best:.4} {x:.4?}");
    });
    println!("{aim}: {best:.4} with {x:.4?}");
    let two = Lines::Two {
        first: 0.35,
        slope: -0.01,
        switch: 5.0,
        last: -0.1,
        at: 13.3,
        jumps: false,
    };
    for (name, program) in [
        ("smooth", law(&x).program()),
        ("two lines", Program::ClosedLoop(two)),
    ] {
        let ensemble = Ensemble {
            setup: setup(base.clone(), program, 9.0),
            draw: Draw::default(),
            robots: 100,
            seed: HELD_OUT,
        };
        let all: Result<Vec<Summary>, _> = ensemble.run(available(), &|| ()).into_iter().collect();
        let all = all?;
        let runs = all.iter().filter(|s| s.late_speed() > 1.5).count();
        let median = |values: Vec<f64>| {
            let mut values = values;
            values.sort_by(f64::total_cmp);
            values[values.len() / 2]
        };
        let time = median(
            all.iter()
                .map(|s| s.time_to_1_6_m.unwrap_or(99.0))
                .collect(),
        );
        let fast = median(all.iter().map(|s| s.reached_3_2.unwrap_or(99.0)).collect());
        let speed = median(all.iter().map(saltus_gait::Summary::late_speed).collect());
        let gas = median(
            all.iter()
                .map(|s| 1e3 * s.gas / s.travel.max(0.01))
                .collect(),
        );
        println!(
            "{name}: {runs} of 100 run; medians: 1.6 m after {time:.2} s, 3.2 m/s after {fast:.2} \
             s, {speed:.2} m/s in the end, {gas:.3} g/m"
        );
    }
    Ok(())
}
