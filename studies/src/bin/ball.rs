//! The thesis' run of the twelve-legged robot (7.2.2), and how soon what 7.3 names throws it out of its plane.
//!
//! ```text
//! cd studies && cargo run --release --bin ball
//! ```

type Failed = Box<dyn std::error::Error>;
use saltus_gait::space::{DrawnBalls, Gait, Roll, Rolled, drawn_ball, roll};
use saltus_sim_check::Stepping;

/// Runs of each kind, of which the median counts.
const RUNS: usize = 20;

fn twelve(force: f64) -> Result<saltus_robot::Robot, Failed> {
    let overrides = [format!("leg.force_n={force}")];
    Ok(saltus_robot::resolve("rats-twelve", &overrides)?)
}

fn go(setup: &Roll, open: f64, step: f64) -> Result<Rolled, Failed> {
    let mut setup = setup.clone();
    if let Gait::Disc(fires) = &mut setup.gait {
        fires.valve_open = open;
    }
    setup.stepping = Stepping::Fixed(step);
    Ok(roll(&setup, |_| true)?)
}

/// The least, the middle one and the greatest of all.
fn spread(mut all: Vec<f64>) -> [f64; 3] {
    all.sort_by(f64::total_cmp);
    [all[0], all[all.len() / 2], all[all.len() - 1]]
}

/// Prints when runs of a kind leave their plane.
fn leaving(
    kind: &str,
    change: impl Fn(&mut Roll, usize) -> Result<(), Failed>,
) -> Result<(), Failed> {
    let mut times = Vec::new();
    for k in 0..RUNS {
        let mut setup = Roll::new(twelve(250.0)?, 8.0);
        change(&mut setup, k)?;
        // A heading that does not matter makes each run another one.
        setup.start.yaw += 1e-3 * k as f64;
        let rolled = go(&setup, 0.05, 5e-4)?;
        times.push(rolled.left.map_or(f64::INFINITY, |left| left.time));
    }
    let [least, middle, most] = spread(times);
    println!("{kind}: leaves its plane after {middle:.2} s, from {least:.2} to {most:.2} s");
    Ok(())
}

fn main() -> Result<(), Failed> {
    for (force, open) in [(250.0, 0.05), (200.0, 0.03), (150.0, 0.05), (100.0, 0.05)] {
        for step in [1e-3, 5e-4, 2.5e-4] {
            let mut travels = Vec::new();
            for k in 0..RUNS {
                let mut setup = Roll::new(twelve(force)?, 5.0);
                setup.start.yaw = 1e-6 * k as f64;
                travels.push(go(&setup, open, step)?.travel);
            }
            let [least, middle, most] = spread(travels);
            println!(
                "{force} N, {open} s, step {step} s: {middle:.1} m in 5 s, from {least:.1} to {most:.1} m"
            );
        }
    }
    leaving("heading", |setup, _| {
        setup.start.yaw = 0.01;
        Ok(())
    })?;
    leaving("roll 0.01 rad", |setup, _| {
        setup.start.roll = 0.01;
        Ok(())
    })?;
    for (kind, force, center) in [
        ("centre of mass within 0.2 mm", 0.0, 2e-4),
        ("centre of mass within 2 mm", 0.0, 2e-3),
        ("forces of legs ± 1 %", 0.01, 0.0),
        ("forces of legs ± 5 %", 0.05, 0.0),
    ] {
        leaving(kind, |setup, k| {
            let draw = DrawnBalls {
                force,
                center,
                friction: [1.0, 1.0],
            };
            setup.robot = drawn_ball(&setup.robot, &draw, 1, k)?;
            Ok(())
        })?;
    }
    Ok(())
}
