//! Jumps of rats-twelve from rest: firings to a few places, and how many of 50 other robots land within 10 cm.
//!
//! ```text
//! cd studies && cargo run --release --bin ball_jump -- 0.3 60
//! ```
//!
//! Distance (m) and heading (degrees); where nothing is given, a few of them.

use saltus_gait::space::DrawnBalls;
use saltus_gait::space::jump::{Planner, Standing, landed};
use saltus_numeric::parallel::{available, map_on};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let numbers: Vec<f64> = std::env::args()
        .skip(1)
        .map(|x| x.parse())
        .collect::<Result<_, _>>()?;
    let all = match numbers[..] {
        [] => vec![[0.15, 0.0], [0.4, 20.0], [0.6, 0.0], [0.9, 0.0]],
        [distance, heading] => vec![[distance, heading]],
        _ => return Err("give two numbers".into()),
    };
    let robot = saltus_robot::resolve("rats-twelve", &[])?;
    let standing = Standing::on(&robot, 0)?;
    let planner = Planner::new(
        &robot,
        standing,
        &DrawnBalls::default(),
        (16, 1),
        available(),
    )?;
    println!("distance (m), heading (°): miss (m); reached; within 10 cm; firings (leg@ms:ms)");
    for [distance, heading] in all {
        let (sine, cosine) = f64::to_radians(heading).sin_cos();
        let target = [distance * cosine, distance * sine];
        let plan = planner.to(target, available())?;
        let others = map_on(available(), 50, |k| planner.other(&plan, (77, k), 0.0));
        let mut near = 0;
        for flown in others {
            let miss = landed(&flown?).map(|[x, y]| (x - target[0]).hypot(y - target[1]));
            near += usize::from(miss.is_some_and(|miss| miss <= 0.1));
        }
        let firings: Vec<String> = (plan.jump.commands.iter())
            .map(|it| format!("{}@{:.0}:{:.1}", it.leg, it.at * 1e3, it.open * 1e3))
            .collect();
        println!(
            "{distance} {heading}: {:.4}; {}; {near} of 50; {}",
            plan.miss,
            plan.is_reached(),
            firings.join(" ")
        );
    }
    Ok(())
}
