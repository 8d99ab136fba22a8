//! Half a turn of `rats-twelve` as a map: its multipliers, how fast it falls, what its twins can do about it, and what a metre
//! costs.
//!
//! ```text
//! cd studies && cargo run --release --bin ball_analysis -- 2.5e-5 40
//! ```
//!
//! The first number is the time step (s), the second how many drawn robots are kept up by the regulator.

type Failed = Box<dyn std::error::Error>;
use saltus_gait::space::{DrawnBalls, Gait, Knows, Roll, Stable, drawn_ball, roll};
use saltus_numeric::parallel;
use saltus_robot::Robot;
use saltus_sim_check::Stepping;
use saltus_studies::half_turn::{LATERAL, Multiplier, OFF, Roller, Slopes, State};

/// How far (m) a robot has to come, and within which way aside (m).
const FAR: f64 = 30.0;
const WIDE: f64 = 1.0;

/// Prints what a metre costs.
fn costs(roller: &Roller, start: &State) -> Result<(), Failed> {
    let sum = roller.costs(start)?.ok_or("it stops")?;
    let a_metre = |x: f64| x / sum.way;
    println!("speed {:.3} m/s", sum.way / sum.time);
    println!(
        "a metre: work of the legs {:.2} J; lost in legs {:.2} J, feet and ground {:.2} J, ends of strokes {:.2} J",
        a_metre(sum.work),
        a_metre(sum.legs),
        a_metre(sum.ground),
        a_metre(sum.stops)
    );
    Ok(())
}

/// Prints the multipliers of what is off by up to `scale` of [`OFF`].
fn told(roller: &Roller, start: &State, scale: f64) -> Result<(), Failed> {
    println!("off by up to {scale} of {:?}:", &OFF[4..]);
    let Some(slopes) = roller.slopes(start, scale)? else {
        println!("  falls");
        return Ok(());
    };
    for Multiplier { value, kind } in slopes.multipliers() {
        let whole = value * value;
        println!(
            "  {kind:9} {:.4} {:+.4}i, of a whole turn {:.4} {:+.4}i",
            value.re, value.im, whole.re, whole.im
        );
    }
    println!(
        "  offset and heading: off 1 by {:.1e}; across and in the plane mixed by {:.1e}",
        slopes.neutral(),
        slopes.mixed
    );
    Ok(())
}

/// Prints by what falls grow in half a turn, of starts that are off along the vector that grows most.
fn falls(roller: &Roller, start: &State, slopes: &Slopes, scale: f64) -> Result<(), Failed> {
    let Some((value, right, left)) = slopes.growth() else {
        println!("what grows most turns as it grows");
        return Ok(());
    };
    println!("grows by {value:.2} in half a turn");
    for roll in [0.0005, 0.001, 0.002, 0.004, 0.008] {
        let off = right * (scale * roll / right[2].abs());
        let mut state = *start;
        state.lateral = off.into();
        if let Some((next, _)) = roller.half_turn(&state, 0.0)? {
            let part: f64 = left.iter().zip(next.lateral).map(|(l, x)| l * x).sum();
            let times = part / left.dot(&off);
            println!(
                "  a fall with a roll of {} mrad grows by {times:.2}",
                1e3 * scale * roll
            );
        }
    }
    Ok(())
}

/// How far (m) `robot` comes within `WIDE`, from a plain roll, by gains for the twins.
fn kept(robot: &Robot, start: &State, gains: &[f64; LATERAL]) -> Result<f64, Failed> {
    let roller = Roller::new(robot, &Stable::default(), 1e-3)?;
    let mut state = *start;
    while state.along < FAR && state.lateral[0].abs() < WIDE {
        let u: f64 = gains.iter().zip(state.lateral).map(|(k, x)| -k * x).sum();
        let Some((next, _)) = roller.half_turn(&state, u)? else {
            break;
        };
        state = next;
    }
    Ok(state.along)
}

/// The same by the searched gains, from rest, with the truth.
fn searched(robot: &Robot) -> Result<f64, Failed> {
    let mut setup = Roll::new(robot.clone(), 60.0);
    (setup.gait, setup.knows) = (Gait::Stable(Stable::default()), Knows::Truth);
    setup.stepping = Stepping::Fixed(1e-3);
    let mut far = 0.0;
    let mut last = (0, 0.0);
    roll(&setup, |ball| {
        far = ball.place[0];
        if ball.passed > last.0 {
            last = (ball.passed, ball.time);
        }
        far < FAR
            && ball.aside.abs() < WIDE
            && ball.rolling.roll.abs() < 0.8
            && ball.time < last.1 + 2.0
    })?;
    Ok(far)
}

fn main() -> Result<(), Failed> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let step: f64 = words.first().map_or(Ok(2e-4), |word| word.parse())?;
    let robots: usize = words.get(1).map_or(Ok(2), |word| word.parse())?;
    let scale: f64 = words.get(2).map_or(Ok(1.0), |word| word.parse())?;
    let robot = saltus_robot::resolve("rats-twelve", &[])?;
    let roller = Roller::new(&robot, &Stable::default(), step)?;
    let start = roller.periodic()?.ok_or("no plain roll")?;
    println!("plain roll: {:?}", start.in_plane);
    costs(&roller, &start)?;
    println!(
        "comes back from rolls of up to {:.5} rad",
        roller.basin(&start)?
    );
    for scale in [0.03, 0.1, 0.3, 1.0] {
        told(&roller, &start, scale)?;
    }
    let slopes = roller
        .slopes(&start, scale)?
        .ok_or("a half turn does not end")?;
    falls(&roller, &start, &slopes, scale)?;
    println!(
        "twins reach, in the sizes {:?}: {:?}",
        &OFF[4..],
        slopes.reach()
    );
    println!("twins: {:?}", slopes.twins.as_slice());
    let gains: [f64; LATERAL] = slopes.regulator().into();
    println!("regulator, s for each m, rad, rad, m/s, rad/s, rad/s: {gains:?}");
    let draw = DrawnBalls::default();
    let far = parallel::map_on(
        parallel::available(),
        robots,
        |k| -> Result<[f64; 2], String> {
            let drawn = drawn_ball(&robot, &draw, 11, k).map_err(|why| why.to_string())?;
            let both = kept(&drawn, &start, &gains).and_then(|a| Ok([a, searched(&drawn)?]));
            both.map_err(|why| why.to_string())
        },
    );
    let far: Vec<[f64; 2]> = far.into_iter().collect::<Result<_, _>>()?;
    if robots == 0 {
        return Ok(());
    }
    for (k, name) in ["regulator", "searched gains"].iter().enumerate() {
        let whole = far.iter().filter(|far| far[k] >= FAR).count();
        let mut all: Vec<f64> = far.iter().map(|far| far[k]).collect();
        all.sort_by(f64::total_cmp);
        println!(
            "{name}: {whole} of {robots} come {FAR} m within {WIDE} m, median {:.1} m",
            all[all.len() / 2]
        );
    }
    Ok(())
}
