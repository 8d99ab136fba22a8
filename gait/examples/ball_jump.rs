//! scratch
type Failed = Box<dyn std::error::Error>;
use saltus_gait::space::jump::{Command, Stance, Standing, fly};
use saltus_gait::space::{DrawnBalls, drawn_ball};

fn main() -> Result<(), Failed> {
    let robot = saltus_robot::resolve("rats-twelve", &[])?;
    let standing = Standing::on(&robot, 0)?;
    println!("{standing:?}");
    let legs = &standing.rest.legs;
    let sets: Vec<Vec<Command>> = vec![
        vec![(0, 0.0, 0.05)],
        vec![(1, 0.0, 0.05)],
        vec![(0, 0.0, 0.02)],
        vec![(0, 0.0, 0.05), (1, 0.0, 0.05)],
        vec![(0, 0.0, 0.03), (1, 0.0, 0.02)],
        vec![(0, 0.0, 0.05), (1, 0.0, 0.05), (2, 0.0, 0.05)],
        vec![(0, 0.0, 0.05), (1, 0.0, 0.05), (2, 0.0, 0.01)],
        vec![(0, 0.0, 0.05), (1, 0.01, 0.05)],
        vec![(0, 0.0, 0.05), (1, 0.02, 0.05)],
    ]
    .into_iter()
    .map(|set: Vec<(usize, f64, f64)>| {
        set.into_iter().map(|(k, at, open)| Command { leg: legs[k], at, open }).collect()
    })
    .collect();
    for mu in [0.6, 0.8, 1.0, 1.2] {
        let mut own = robot.clone();
        own.ground.static_friction = mu;
        own.ground.kinetic_friction = mu;
        for set in &sets {
            let words: Vec<String> = set.iter().map(|c| format!("{}@{}:{}", c.leg, c.at, c.open)).collect();
            println!("mu {mu} {}", words.join(" "));
            let now = std::time::Instant::now();
            let model = Stance::new(&own)?.jump(standing.place, saltus(&standing), set);
            let t1 = now.elapsed();
            let now = std::time::Instant::now();
            let flown = fly(&own, &standing, set, 0.0, |_| {})?;
            let t2 = now.elapsed();
            let f = |v: [f64; 3]| format!("{:7.3} {:7.3} {:7.3}", v[0], v[1], v[2]);
            if let Some((l, t)) = model {
                println!("  model {:.4} v {} w {} | land {:.3} {} apex {:.3} {t1:?}", l.time, f(l.velocity), f(l.spin), t.time, f(t.place), t.apex);
            }
            if let (Some(l), Some(t)) = (flown.lift, flown.touch) {
                println!("  sim   {:.4} v {} w {} | land {:.3} {} apex {:.3} {t2:?}", l.time, f(l.velocity), f(l.spin), t.time, f(t.place), t.apex);
            }
        }
    }
    let _ = drawn_ball(&robot, &DrawnBalls::default(), 1, 0)?;
    Ok(())
}
fn saltus(s: &Standing) -> nalgebra::UnitQuaternion<f64> {
    let [w, x, y, z] = s.attitude;
    nalgebra::UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(w, x, y, z))
}
