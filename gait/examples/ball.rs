//! The thesis' run of the twelve-legged robot (7.2.2), and what of 7.3 throws it out of its plane.
//!
//! ```text
//! cargo run --release -p saltus-gait --example ball
//! ```

type Failed = Box<dyn std::error::Error>;
use saltus_gait::space::{Gait, Roll, Rolled, roll};
use saltus_sim_check::Stepping;

fn go(overrides: &[&str], change: impl FnOnce(&mut Roll)) -> Result<Rolled, Failed> {
    let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
    let robot = saltus_robot::resolve("rats-twelve", &overrides)?;
    let mut setup = Roll::new(robot, 5.0);
    change(&mut setup);
    Ok(roll(&setup, |_| true)?)
}

fn main() -> Result<(), Failed> {
    for (force, open) in [(250, 0.05), (200, 0.03), (150, 0.05), (100, 0.05)] {
        for step in [1e-3, 5e-4, 2.5e-4] {
            let rolled = go(&[&format!("leg.force_n={force}")], |setup| {
                if let Gait::Disc(fires) = &mut setup.gait {
                    fires.valve_open = open;
                }
                setup.stepping = Stepping::Fixed(step);
            })?;
            println!("{force} N, {open} s, step {step}: {rolled:?}");
        }
    }
    Ok(())
}
