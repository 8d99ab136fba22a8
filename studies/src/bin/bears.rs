//! How much a gait of `rats-twelve` bears: the share of drawn robots that come 30 m within 1 m of their line in 60 s, by their
//! sensors, where one thing at a time is off.
//!
//! ```text
//! cd studies && cargo run --release --bin bears -- steer 40 bears-steer.svg
//! ```
//!
//! `steer` or `disc-stable`, robots for each number, and where the curves go. Prints a row for each number, in SI units, with
//! the 95 % interval (Wilson). Where nothing is given, one robot for each of a few numbers.

use std::f64::consts::PI;

use saltus::chart::{COLORS, Chart, Ink};
use saltus::running::Share;
use saltus_gait::GaitError;
use saltus_gait::space::{
    DrawnBalls, FALLS, Gait, Knows, Roll, Stable, Steered, drawn_ball, roll,
};
use saltus_numeric::parallel::{available, map_on};
use saltus_robot::Robot;

type Failed = Box<dyn std::error::Error>;

/// How far (m) a robot has to come, within which way (m) of its line, and in which time (s).
const FAR: f64 = 30.0;
const WIDE: f64 = 1.0;
const LONG: f64 = 60.0;
/// A robot stands that has moved by less than this (m) for so long (s).
const STILL: f64 = 0.05;
const STANDS: f64 = 2.0;
/// Friction of the ground where another imperfection is looked at.
const FRICTION: f64 = 0.9;
/// Seed of the robots.
const SEED: u64 = 1;
/// Size of a chart (px).
const SIZE: (f64, f64) = (500.0, 320.0);

/// Something that is off.
struct Imperfection {
    /// Its name with its unit, in rows and in curves.
    key: &'static str,
    words: &'static str,
    /// The unit of curves.
    unit: f64,
    /// How much of it, in that unit.
    levels: &'static [f64],
    set: fn(&mut DrawnBalls, &mut Robot, f64),
}

/// What can be off, each by itself.
const ALL: [Imperfection; 4] = [
    Imperfection {
        key: "force_factor_standard_deviation",
        words: "scatter of the legs' forces (%)",
        unit: 0.01,
        levels: &[0.0, 2.0, 5.0, 10.0, 15.0, 20.0],
        set: |draw, _, x| draw.force = x,
    },
    Imperfection {
        key: "center_of_mass_within_m",
        words: "centre of mass within (mm)",
        unit: 1e-3,
        levels: &[0.0, 0.5, 1.0, 2.0, 3.0, 5.0],
        set: |draw, _, x| draw.center = x,
    },
    Imperfection {
        key: "friction",
        words: "friction of the ground",
        unit: 1.0,
        levels: &[0.2, 0.3, 0.4, 0.6, 0.8, 1.2],
        set: |draw, _, x| draw.friction = [x; 2],
    },
    Imperfection {
        key: "slope_rad",
        words: "slope, uphill ahead (deg)",
        unit: PI / 180.0,
        levels: &[-4.0, -2.0, -1.0, 0.0, 1.0, 2.0, 4.0],
        set: |_, robot, x| robot.ground.slope = x,
    },
];

/// Whether robot `k` of those with `level` of one imperfection comes so far.
fn comes(setup: &Roll, of: &Imperfection, level: f64, k: usize) -> Result<bool, GaitError> {
    let mut draw = DrawnBalls {
        force: 0.0,
        center: 0.0,
        friction: [FRICTION; 2],
    };
    let mut own = setup.clone();
    (of.set)(&mut draw, &mut own.robot, level * of.unit);
    own.robot = drawn_ball(&own.robot, &draw, SEED, k)?;
    own.knows = Knows::Sensors(SEED + k as u64);
    // One that chooses its plane gets up, and lies still before it does.
    let gets_up = matches!(own.gait, Gait::Steered(_));
    let (mut is_far, mut still) = (false, ([0.0; 2], 0.0));
    roll(&own, |ball| {
        let [x, y, _] = ball.place;
        let ([from_x, from_y], since) = still;
        if (x - from_x).hypot(y - from_y) > STILL {
            still = ([x, y], ball.time);
        }
        let stands = ball.time > since + STANDS;
        let is_over = stands || ball.rolling.roll.abs() > FALLS;
        let is_near = ball.aside.abs() <= WIDE;
        is_far = x >= FAR && is_near;
        !is_far && is_near && (gets_up || !is_over)
    })?;
    Ok(is_far)
}

/// The curves of `all`: how much of what is off, and the share.
fn curves(all: &[(&Imperfection, f64, Share)]) -> String {
    let (width, height) = SIZE;
    let charts = ALL.iter().enumerate().map(|(k, of)| {
        let own = || all.iter().filter(|it| it.0.key == of.key);
        let line = |y: &dyn Fn(&Share) -> f64| -> Vec<(f64, f64)> {
            own().map(|it| (it.1, 100.0 * y(&it.2))).collect()
        };
        let (low, high) = (of.levels[0], of.levels[of.levels.len() - 1]);
        let mut chart = Chart::new(SIZE, (of.words, (low, high)), ("robots (%)", (0.0, 104.0)));
        for end in 0..2 {
            chart.line(Ink::Dotted(COLORS[6]), &line(&|it| it.interval()[end]));
        }
        chart.line(Ink::Solid(COLORS[0]), &line(&Share::value));
        let (x, y) = (width * (k % 2) as f64, height * (k / 2) as f64);
        let place = format!("<svg x=\"{x}\" y=\"{y}\" ");
        chart.file().replacen("<svg ", &place, 1)
    });
    let (width, height) = (2.0 * width, 2.0 * height);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\">\n{}</svg>\n",
        charts.collect::<String>()
    )
}

fn main() -> Result<(), Failed> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let gait = match words.first().map(String::as_str) {
        None | Some("steer") => Gait::Steered(Steered::towards(0.0)),
        Some("disc-stable") => Gait::Stable(Stable::default()),
        Some(_) => return Err("give steer or disc-stable".into()),
    };
    let robots: usize = words.get(1).map_or(Ok(1), |word| word.parse())?;
    let mut setup = Roll::new(saltus_robot::resolve("rats-twelve", &[])?, LONG);
    setup.gait = gait;
    let levels = |of: &'static Imperfection| of.levels.iter().map(move |level| (of, *level));
    let mut levels: Vec<(&Imperfection, f64)> = ALL.iter().flat_map(levels).collect();
    if words.is_empty() {
        levels.truncate(4);
    }
    let runs = map_on(available(), levels.len() * robots, |i| {
        let (of, level) = levels[i / robots];
        comes(&setup, of, level, i % robots)
    });
    let runs: Vec<bool> = runs.into_iter().collect::<Result<_, _>>()?;
    println!("imperfection,value,count,of,share,low_95,high_95");
    let mut all = Vec::new();
    for ((of, level), runs) in levels.into_iter().zip(runs.chunks(robots)) {
        let count = runs.iter().filter(|is_far| **is_far).count();
        let share = Share { count, of: robots };
        let ([low, high], value) = (share.interval(), share.value());
        println!(
            "{},{},{count},{robots},{value},{low},{high}",
            of.key,
            level * of.unit
        );
        all.push((of, level, share));
    }
    if let Some(path) = words.get(2) {
        std::fs::write(path, curves(&all))?;
    }
    Ok(())
}
