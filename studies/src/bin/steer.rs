//! Drawn balls with sensors that are led along a path: how many keep to it, turn as they are told, and go on after a fall.
//!
//! ```text
//! cd studies && cargo run --release --bin steer -- line 100
//! ```
//!
//! The first word is `line` (30 m straight on), `turn` (after 5 m by 60° to the left or the right), `path` (four points, 10 m
//! apart, around a square) or `recover` (thrown down at any attitude, with up to 5 rad/s about any axis); the second is how
//! many robots, the third the seed from which they are drawn.

type Failed = Box<dyn std::error::Error>;
use std::f64::consts::FRAC_PI_3;

use saltus_gait::space::{Ball, DrawnBalls, Gait, Knows, Roll, Steered, Thrown, drawn_ball, roll};
use saltus_numeric::parallel;
use saltus_sim_check::Stepping;

/// Longest run (s), and how far (m) a line goes.
const LONG: f64 = 120.0;
const FAR: f64 = 30.0;
/// Where a turn is (m), and how long (m) the way is on which it may be done; its heading is measured on the last part of it.
const TURNS: f64 = 5.0;
const WAY: f64 = 10.0;
const PART: f64 = 2.0;
/// Stations after which a ball that was thrown down runs again: a whole turn.
const RUNS: i32 = 6;
const SPIN: f64 = 5.0;

/// What became of a ball.
#[derive(Clone, Copy, Debug, Default)]
struct Came {
    time: f64,
    starts: u32,
    /// Farthest from its path (m).
    aside: f64,
    /// Whether it came to the end; of a turn, how far (rad) its last heading is off.
    arrived: bool,
    off: f64,
}

/// A trial: a path, and what is seen of it.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Trial {
    Line,
    Turn,
    Path,
    Recover,
}

impl Trial {
    /// The path of ball `k`.
    fn path(self, k: usize) -> Vec<[f64; 2]> {
        match self {
            Trial::Line | Trial::Recover => vec![[100.0, 0.0]],
            Trial::Turn => {
                let heading = turn(k);
                let far = [100.0 * heading.cos(), 100.0 * heading.sin()];
                vec![[TURNS, 0.0], [TURNS + far[0], far[1]]]
            }
            Trial::Path => {
                let side = if k.is_multiple_of(2) { 10.0 } else { -10.0 };
                vec![[10.0, 0.0], [10.0, side], [0.0, side], [0.0, 0.0]]
            }
        }
    }
}

/// The turn (rad) of ball `k`.
fn turn(k: usize) -> f64 {
    if k.is_multiple_of(2) {
        FRAC_PI_3
    } else {
        -FRAC_PI_3
    }
}

/// Runs ball `k`.
fn run(setup: &Roll, trial: Trial, seed: u64, k: usize) -> Result<Came, Failed> {
    let mut setup = setup.clone();
    setup.robot = drawn_ball(&setup.robot, &DrawnBalls::default(), seed, k)?;
    setup.knows = Knows::Sensors(seed + k as u64);
    let path = trial.path(k);
    setup.gait = Gait::Steered(Steered::new(path.clone()));
    if trial == Trial::Recover {
        setup.start.thrown = Some(Thrown::drawn(seed, k, SPIN));
    }
    let mut came = Came::default();
    // Where the last part of the way began, and at the start in this plane the stations so far.
    let (mut part, mut start) = ([0.0; 2], (0, 0));
    roll(&setup, |ball| {
        came.time = ball.time;
        came.aside = came.aside.max(ball.aside);
        came.starts = ball.led.starts;
        if ball.led.starts != start.0 {
            start = (ball.led.starts, ball.passed);
        }
        came.arrived = match trial {
            Trial::Line => ball.place[0] >= FAR,
            Trial::Turn => turned(ball, &mut part, &mut came.off, turn(k)),
            Trial::Path => ball.led.reached == path.len(),
            Trial::Recover => ball.led.plane.is_some() && ball.passed >= start.1 + RUNS,
        };
        !came.arrived
    })?;
    Ok(came)
}

/// Whether a ball has come `WAY` past its turn; then `off` is how far (rad) its last heading is off `told`.
fn turned(ball: &Ball, part: &mut [f64; 2], off: &mut f64, told: f64) -> bool {
    let [x, y, _] = ball.place;
    let gone = (x - TURNS).hypot(y);
    if ball.led.reached == 0 || gone < WAY - PART {
        *part = [x, y];
    }
    *off = ((y - part[1]).atan2(x - part[0]) - told).abs();
    ball.led.reached > 0 && gone >= WAY
}

fn main() -> Result<(), Failed> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let word = |k: usize| words.get(k).map_or("", String::as_str);
    let trial = match word(0) {
        "turn" => Trial::Turn,
        "path" => Trial::Path,
        "recover" => Trial::Recover,
        _ => Trial::Line,
    };
    let robots: usize = word(1).parse().unwrap_or(4);
    let seed: u64 = word(2).parse().unwrap_or(5);
    let mut setup = Roll::new(saltus_robot::resolve("rats-twelve", &[])?, LONG);
    setup.stepping = Stepping::Fixed(1e-3);
    let one = |k: usize| run(&setup, trial, seed, k).map_err(|why| why.to_string());
    let all: Vec<Came> = parallel::map_on(parallel::available(), robots, one)
        .into_iter()
        .collect::<Result<_, _>>()?;
    println!("ball, arrived, s, starts, farthest from its path (m), off its heading (deg)");
    for (k, came) in all.iter().enumerate() {
        let off = came.off.to_degrees();
        let Came {
            time,
            starts,
            aside,
            arrived,
            ..
        } = came;
        println!("{k}, {arrived}, {time:.2}, {starts}, {aside:.2}, {off:.1}");
    }
    let count = |is_so: &dyn Fn(&Came) -> bool| all.iter().filter(|came| is_so(came)).count();
    let mut times: Vec<f64> = all.iter().map(|came| came.time).collect();
    times.sort_by(f64::total_cmp);
    println!("of {robots}:");
    println!("  {} arrived", count(&|came| came.arrived));
    println!(
        "  {} within 1 m of the path",
        count(&|came| came.arrived && came.aside <= 1.0)
    );
    if trial == Trial::Turn {
        let right = |came: &Came| came.arrived && came.off < 10_f64.to_radians();
        println!("  {} with the last heading within 10 deg", count(&right));
    }
    println!(
        "  {} within 10 s",
        count(&|came| came.arrived && came.time <= 10.0)
    );
    println!("  median {:.1} s", times[times.len() / 2]);
    Ok(())
}
