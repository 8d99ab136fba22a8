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
        for distance in [0.4, 0.5] {
            let now = std::time::Instant::now();
            let (s, c) = heading.to_radians().sin_cos();
            let target = [distance * c, distance * s];
            let plan = planner.to(target, 1)?;
            let time = now.elapsed();
            let mut good = 0;
            for k in 0..50 {
                let own = drawn_ball(&robot, &draw, 77, k)?;
                let flown = fly(&own, planner.standing(), &plan.commands, 0.0, |_| {})?;
                let miss = landed(&flown).map_or(1.0, |at| (at[0] - target[0]).hypot(at[1] - target[1]));
                if miss > 0.06 {
                    let t = flown.touch.unwrap_or_default();
                    let l = flown.lift.unwrap_or_default();
                    println!("    {k} mu {:.3} miss {miss:.3} lift {:.3} v {:.3?} w {:.3?} touch {:.3} {:.3?} forces {:.3?}", own.ground.static_friction, l.time, l.velocity, l.spin, t.time, t.place,
                        planner.standing().rest.legs.iter().map(|k| own.space.as_ref().map_or(0.0, |s| s.legs[*k].force)).collect::<Vec<_>>());
                }
                good += usize::from(miss < 0.1);
            }
            let words: Vec<String> = plan.commands.iter().map(|c| format!("{}@{:.0}:{:.1}", c.leg, c.at * 1e3, c.open * 1e3)).collect();
            println!("{heading:4} {distance} miss {:.4} scatter {:.4} off {:.4} good {good}/50 {time:.2?} {}", plan.miss, plan.scatter, plan.off, words.join(" "));
        }
    }
    Ok(())
}
