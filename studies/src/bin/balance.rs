//! Seeks a better balance of the rolling ball: the cross-entropy method on drawn robots with sensors, from the present one. By several
//! such searches, each from the last one's answer, the present one was found.
//!
//! ```text
//! cd studies && cargo run --release --bin balance -- 14 10
//! ```
//!
//! The words are how many robots and how many generations; without any 2 and 1, which shows only that it works.

type Failed = Box<dyn std::error::Error>;
use saltus_gait::space::{DrawnBalls, FALLS, Gait, Knows, Roll, Stable, drawn_ball, roll};
use saltus_gait::{Search, search};
use saltus_numeric::parallel::available;
use saltus_robot::Robot;
use saltus_sim_check::Stepping;

/// How far (m) a robot should come, within which way (m) of its line, and seed of the robots: none that are scored elsewhere.
const FAR: f64 = 25.0;
const WIDE: f64 = 1.0;
const SEED: u64 = 77;

/// Every number of a balance, in one order.
fn numbers(stable: &mut Stable) -> [&mut f64; 19] {
    let s = &mut stable.steer;
    let ([a, b], [c, d], [e, f], [g, h]) = (
        &mut stable.angles,
        &mut stable.opens,
        &mut stable.by_rate,
        &mut stable.first,
    );
    [
        a,
        b,
        c,
        d,
        e,
        f,
        g,
        h,
        &mut stable.rate,
        &mut s.roll,
        &mut s.roll_rate,
        &mut s.heading,
        &mut s.heading_rate,
        &mut s.aside,
        &mut s.aside_rate,
        &mut s.sum,
        &mut s.most,
        &mut s.from,
        &mut s.rest,
    ]
}

/// Least and greatest value of each, in the same order.
const BOUNDS: [[f64; 2]; 19] = [
    [0.2, 0.6],
    [0.0, 0.55],
    [0.006, 0.024],
    [0.0, 0.006],
    [0.0, 0.012],
    [0.0, 0.006],
    [0.01, 0.035],
    [0.0, 0.02],
    [2.4, 5.5],
    [-0.1, 0.2],
    [-0.01, 0.03],
    [-0.01, 0.01],
    [-0.005, 0.005],
    [-0.01, 0.01],
    [-0.01, 0.01],
    [-0.002, 0.002],
    [0.0005, 0.015],
    [-0.25, 0.6],
    [0.012, 0.03],
];

fn with(values: &[f64]) -> Stable {
    let mut stable = Stable::default();
    for (number, value) in numbers(&mut stable).into_iter().zip(values) {
        *number = *value;
    }
    stable
}

/// The part of the way that `robot` comes; more if it comes all of it, the closer to its line.
fn score(robot: &Robot, stable: &Stable) -> f64 {
    let mut setup = Roll::new(robot.clone(), 2.5 * FAR);
    setup.gait = Gait::Stable(stable.clone());
    setup.knows = Knows::Sensors(1);
    setup.stepping = Stepping::Fixed(1e-3);
    let (mut far, mut wide, mut last) = (0.0, 0.0_f64, (0, 0.0));
    let rolled = roll(&setup, |ball| {
        far = ball.place[0];
        wide = wide.max(ball.aside.abs());
        if ball.passed > last.0 {
            last = (ball.passed, ball.time);
        }
        let upright = ball.rolling.roll.abs() < FALLS && wide < WIDE;
        upright && far < FAR && ball.time < last.1 + 1.5
    });
    match rolled {
        Ok(_) if far >= FAR => 1.6 - 0.4 * wide,
        Ok(_) => (far / FAR).max(0.0),
        Err(_) => 0.0,
    }
}

fn main() -> Result<(), Failed> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let count = |k: usize, usual: usize| {
        words
            .get(k)
            .and_then(|word| word.parse().ok())
            .unwrap_or(usual)
    };
    let base = saltus_robot::resolve("rats-twelve", &[])?;
    let draw = DrawnBalls::default();
    let robots: Vec<Robot> = (0..count(0, 2))
        .map(|k| drawn_ball(&base, &draw, SEED, k))
        .collect::<Result<_, _>>()?;
    let start = numbers(&mut Stable::default())
        .map(|number| *number)
        .to_vec();
    let setup = Search {
        bounds: BOUNDS.to_vec(),
        start,
        spread: 0.06,
        candidates: 32,
        best: 6,
        generations: count(1, 1),
        seed: 11,
    };
    let mean = |values: &[f64]| {
        let stable = with(values);
        robots
            .iter()
            .map(|robot| score(robot, &stable))
            .sum::<f64>()
            / robots.len() as f64
    };
    let told =
        |generation: usize, best: f64, _: &[f64]| println!("generation {generation}: {best:.4}");
    let (best, _) = search(&setup, available(), mean, told);
    println!("{:#?}", with(&best));
    Ok(())
}
