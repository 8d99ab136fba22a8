//! How well drawn balls know their motion by their sensors: attitude, heading, contacts.
//!
//! ```text
//! cd studies && cargo run --release --bin ball_estimate -- [ROBOTS [SECONDS [BIAS]]]
//! ```
//!
//! Gyros read BIAS (rad/s) at rest. The robot's file states it, and the estimator removes it. Each ball runs for all of the SECONDS,
//! also where it has fallen: a heading drifts there, too. Ends with an error where a target is missed.

type Failed = Box<dyn std::error::Error>;
use saltus_gait::space::{DrawnBalls, Gait, Knows, Roll, Stable, drawn_ball, roll};
use saltus_numeric::parallel;
use saltus_sim_check::Stepping;
use saltus_tests::known::Known;

/// Shares of the touch-downs, and errors (degrees; degrees a minute).
const FOUND: f64 = 0.99;
const OFF: f64 = 1.0;
const DRIFT: f64 = 1.0;

/// Runs ball `k`.
fn run(setup: &Roll, k: usize) -> Result<Known, Failed> {
    let mut setup = setup.clone();
    setup.robot = drawn_ball(&setup.robot, &DrawnBalls::default(), 1, k)?;
    setup.knows = Knows::Sensors(1 + k as u64);
    let mut known = Known::default();
    roll(&setup, |ball| {
        known.take(ball);
        true
    })?;
    Ok(known)
}

fn main() -> Result<(), Failed> {
    let words: Vec<f64> = std::env::args()
        .skip(1)
        .map(|word| word.parse())
        .collect::<Result<_, _>>()?;
    let word = |k: usize, usual: f64| words.get(k).copied().unwrap_or(usual);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let robots = word(0, 4.0) as usize;
    let (seconds, bias) = (word(1, 60.0), word(2, 0.01));
    let biased = format!("sensors.gyro_bias_rad_s={bias}");
    let mut setup = Roll::new(saltus_robot::resolve("rats-twelve", &[biased])?, seconds);
    setup.stepping = Stepping::Fixed(1e-3);
    setup.gait = Gait::Stable(Stable::default());
    let one = |k: usize| run(&setup, k).map_err(|error| error.to_string());
    let all: Vec<Known> = parallel::map_on(2, robots, one)
        .into_iter()
        .collect::<Result<_, _>>()?;
    let mut sum = Known::default();
    for known in &all {
        sum.add(known);
    }
    println!(
        "{robots} drawn balls, {seconds} s each, gyros read {bias} rad/s at rest, which is removed"
    );
    let share = |count: usize| count as f64 / sum.touch_downs.max(1) as f64;
    let [fast, found] = sum.found.map(share);
    println!(
        "touch-downs {}: found within 1 ms {:.3} %, within 2 ms {:.3} %",
        sum.touch_downs,
        100.0 * fast,
        100.0 * found
    );
    let [plane, roll, heading] = sum.rms().map(f64::to_degrees);
    println!(
        "attitude over the {:.0} s in which they rolled, rms: in the plane {plane:.3} deg, roll {roll:.3} deg, heading {heading:.3} deg",
        sum.cycles as f64 * 1e-3
    );
    let minutes = seconds / 60.0;
    let drift = |known: &Known| (known.heading / minutes).to_degrees();
    let squares: f64 = all.iter().map(|known| drift(known).powi(2)).sum();
    let drifts = (squares / robots.max(1) as f64).sqrt();
    let most = all
        .iter()
        .map(|known| drift(known).abs())
        .fold(0.0, f64::max);
    println!("heading drift: rms {drifts:.3} deg/min, greatest {most:.3} deg/min");
    let is_met = found >= FOUND && plane < OFF && roll < OFF && drifts < DRIFT;
    is_met
        .then_some(())
        .ok_or_else(|| "a target is missed".into())
}
