//! scratch
type Failed = Box<dyn std::error::Error>;
use saltus_gait::Obstacle;
use saltus_gait::space::jump::Over;

fn main() -> Result<(), Failed> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let number = |k: usize, usual: f64| words.get(k).and_then(|w| w.parse().ok()).unwrap_or(usual);
    let robot = saltus_robot::resolve("rats-twelve", &[])?;
    let obstacle = Obstacle {
        front: 2.0,
        length: 0.21,
        height: number(0, 0.21),
    };
    let over = Over::new(&robot, obstacle, 3.4)?;
    let now = std::time::Instant::now();
    let leap = over.plan(
        (number(1, 12.0) as usize, number(2, 10.0) as usize),
        1,
        |k, score, x| println!("{k} {score:.4} {x:.3?}"),
    )?;
    println!("{leap:.4?} {:.1?}", now.elapsed());
    let passed = over.try_on(&leap, (100, 1001), 1)?;
    for (k, p) in passed.iter().enumerate() {
        println!(
            "{k} front {:.3} jumped {:.3?} legs {} clear {:.3} cleared {} on {} speed {:.2} apex {:.2}",
            p.front, p.jumped, p.by_twins, p.clearance, p.cleared, p.ran_on, p.speed, p.apex
        );
    }
    println!(
        "cleared {} on {} of {}",
        passed.iter().filter(|p| p.cleared).count(),
        passed.iter().filter(|p| p.ran_on).count(),
        passed.len()
    );
    Ok(())
}
