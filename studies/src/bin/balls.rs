//! Drawn balls that are kept in their plane: how many run 30 m within 1 m of their line, and how well each knows its motion.
//!
//! ```text
//! cd studies && cargo run --release --bin balls -- 100 sensors
//! ```
//!
//! The second word is `sensors`, `truth`, or `blind`, where twins correct nothing. After it may come the scatter of forces,
//! the radius (m) within which the centre of mass lies, and friction from and to.

type Failed = Box<dyn std::error::Error>;
use saltus_gait::space::{Ball, DrawnBalls, Gait, Knows, Roll, Stable, drawn_ball, roll};
use saltus_numeric::parallel;
use saltus_sim_check::Stepping;

/// How far (m) a run has to come, and within which way (m) of its line.
const FAR: f64 = 30.0;
const WIDE: f64 = 1.0;
/// Longest run (s).
const LONG: f64 = 60.0;

/// What became of a ball.
#[derive(Clone, Copy, Debug, Default)]
struct Came {
    time: f64,
    travel: f64,
    aside: f64,
    roll: f64,
    /// Sums of squares of the errors of its attitude across and along the vertical (rad²), and of its way aside (m).
    errors: [f64; 2],
    aside_error: f64,
    cycles: f64,
}

/// Runs ball `k`.
fn run(setup: &Roll, draw: &DrawnBalls, k: usize) -> Result<Came, Failed> {
    let mut setup = setup.clone();
    setup.robot = drawn_ball(&setup.robot, draw, 1, k)?;
    if let Knows::Sensors(seed) = &mut setup.knows {
        *seed += k as u64;
    }
    let mut came = Came::default();
    let mut last = (0, 0.0);
    roll(&setup, |ball| {
        (came.time, came.travel) = (ball.time, ball.place[0]);
        came.aside = came.aside.max(ball.place[1].abs());
        came.roll = ball.rolling.roll;
        known(&mut came, ball);
        if ball.passed > last.0 {
            last = (ball.passed, ball.time);
        }
        let upright = came.aside <= WIDE && came.roll.abs() < 0.8;
        upright && came.travel < FAR && ball.time < last.1 + 3.0
    })?;
    Ok(came)
}

/// How far what it knows is from the truth.
fn known(came: &mut Came, ball: &Ball) {
    let Some(estimate) = ball.estimate else {
        return;
    };
    let truth = saltus_controller::ball::Rotation(ball.attitude);
    let [_, x, y, z] = estimate.attitude.after(&truth.back()).0;
    came.errors[0] += 4.0 * (x * x + y * y);
    came.errors[1] = 2.0 * z;
    came.aside_error = estimate.place[1] - ball.place[1];
    came.cycles += 1.0;
}

fn main() -> Result<(), Failed> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let word = |k: usize| words.get(k).map_or("", String::as_str);
    let robots: usize = word(0).parse().unwrap_or(20);
    let mut setup = Roll::new(saltus_robot::resolve("rats-twelve", &[])?, LONG);
    setup.stepping = Stepping::Fixed(1e-3);
    let mut stable = Stable::default();
    match word(1) {
        "sensors" => setup.knows = Knows::Sensors(1),
        // Twins fire alike, whatever is off.
        "blind" => {
            let s = &mut stable.steer;
            (s.roll, s.roll_rate, s.heading, s.heading_rate) = (0.0, 0.0, 0.0, 0.0);
            (s.aside, s.aside_rate, s.sum) = (0.0, 0.0, 0.0);
        }
        _ => {}
    }
    setup.gait = Gait::Stable(stable);
    let number = |k: usize, default: f64| word(k).parse().unwrap_or(default);
    let usual = DrawnBalls::default();
    let draw = DrawnBalls {
        force: number(2, usual.force),
        center: number(3, usual.center),
        friction: [number(4, usual.friction[0]), number(5, usual.friction[1])],
    };
    let one = |k: usize| run(&setup, &draw, k).map_err(|error| error.to_string());
    let all: Vec<Came> = parallel::map_on(2, robots, one)
        .into_iter()
        .collect::<Result<_, _>>()?;
    for (k, came) in all.iter().enumerate() {
        let error = (came.errors[0] / came.cycles.max(1.0)).sqrt();
        println!(
            "{k}: {:.2} s, {:.2} m, at most {:.2} m aside, roll {:.2} rad; level to {:.4} rad rms, heading off by {:.4} rad, aside by {:.2} m",
            came.time, came.travel, came.aside, came.roll, error, came.errors[1], came.aside_error
        );
    }
    let far = all.iter().filter(|came| came.travel >= FAR).count();
    println!("{far} of {robots} came {FAR} m within {WIDE} m");
    Ok(())
}
