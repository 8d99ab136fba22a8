//! scratch
type Failed = Box<dyn std::error::Error>;
use saltus_gait::space::jump::{Planner, fly, landed};
use saltus_gait::space::{DrawnBalls, drawn_ball};

fn main() -> Result<(), Failed> {
    let robot = saltus_robot::resolve("rats-twelve", &[])?;
    let draw = DrawnBalls::default();
    let now = std::time::Instant::now();
    let planner = Planner::new(&robot, 0, &draw, (16, 1), 1)?;
    println!("known {} in {:?}", planner.known().count(), now.elapsed());
    let mut most = [0.0_f64; 24];
    for [x, y] in planner.known() {
        let k = ((y.atan2(x).to_degrees() + 360.0) / 15.0).round() as usize % 24;
        most[k] = most[k].max(x.hypot(y));
    }
    println!("{most:.3?}");
    for heading in [0.0_f64, 20.0, 60.0] {
        for distance in [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7] {
            let now = std::time::Instant::now();
            let (s, c) = heading.to_radians().sin_cos();
            let target = [distance * c, distance * s];
            let plan = planner.to(target, 1)?;
            let time = now.elapsed();
            let mut good = 0;
            for k in 0..50 {
                let own = drawn_ball(&robot, &draw, 77, k)?;
                let flown = fly(
                    &own,
                    planner.standing(),
                    &plan.jump.by_sensors(k as u64),
                    0.0,
                    |_| {},
                )?;
                let miss =
                    landed(&flown).map_or(1.0, |at| (at[0] - target[0]).hypot(at[1] - target[1]));
                good += usize::from(miss < 0.1);
            }
            let words: Vec<String> = plan
                .jump
                .commands
                .iter()
                .map(|c| format!("{}@{:.0}:{:.1}", c.leg, c.at * 1e3, c.open * 1e3))
                .collect();
            println!(
                "{heading:4} {distance} miss {:.4} scatter {:.4} off {:.4} good {good}/50 {time:.2?} {}",
                plan.miss,
                plan.scatter,
                plan.off,
                words.join(" ")
            );
        }
    }
    Ok(())
}
