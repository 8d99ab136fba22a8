//! scratch
type Failed = Box<dyn std::error::Error>;
use saltus_gait::Obstacle;
use saltus_gait::space::jump::Over;

fn main() -> Result<(), Failed> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let number = |k: usize, usual: f64| words.get(k).and_then(|w| w.parse().ok()).unwrap_or(usual);
    let robot = saltus_robot::resolve("rats-twelve", &[])?;
    let obstacle = Obstacle { front: 2.0, length: 0.21, height: number(0, 0.21) };
    let over = Over::new(&robot, obstacle, 3.4)?;
    if words.len() > 3 { return debug(&over); }
    let now = std::time::Instant::now();
    let leap = over.plan((number(1, 12.0) as usize, number(2, 10.0) as usize), 1, |k, score, x| println!("{k} {score:.4} {x:.3?}"))?;
    println!("{leap:.4?} {:.1?}", now.elapsed());
    let passed = over.try_on(&leap, (100, 1001), 1)?;
    for (k, p) in passed.iter().enumerate() {
        println!("{k} front {:.3} jumped {:.3?} legs {} clear {:.3} cleared {} on {} speed {:.2} apex {:.2}", p.front, p.jumped, p.legs, p.clearance, p.cleared, p.ran_on, p.speed, p.apex);
    }
    println!("cleared {} on {} of {}", passed.iter().filter(|p| p.cleared).count(), passed.iter().filter(|p| p.ran_on).count(), passed.len());
    Ok(())
}
#[allow(dead_code)]
fn debug(over: &Over) -> Result<(), Failed> {
    use saltus_gait::space::jump::Leap;
    for from in [0.4, 0.6] {
        let leap = Leap { from: [from; 3], behind: [0.04, 0.05, 0.04], ahead: [0.04, 0.03, 0.04], by_speed: 0.2, rate: 5.4 };
        for k in 0..3 {
            let mut line = 0;
            let p = over.pass(&leap, 1, k, |ball, clear| {
                line += 1;
                if !ball.fired.is_empty() || (clear < 1.0 && line % 20 == 0) {
                    println!("{:.3} x {:.3} z {:.3} v {:.2?} w {:.1?} lean {:.2} roll {:.2} touch {:b} fired {:?} clear {clear:.3}", ball.time, ball.place[0], ball.place[2], ball.velocity, ball.spin, ball.rolling.lean, ball.rolling.roll, ball.touching, ball.fired.iter().map(|f| (f.leg, f.open)).collect::<Vec<_>>());
                }
                true
            })?;
            println!("{p:.3?}");
        }
    }
    Ok(())
}
