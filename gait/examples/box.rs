//! Searches for the firings that take rats-run from rest over a box, on drawn robots.
use saltus_controller::run::Leap;
use saltus_gait::*;
fn main() {
    let a: Vec<f64> = std::env::args()
        .skip(1)
        .map(|x| x.parse().unwrap())
        .collect();
    let (front, height, train, gens, psi, after) = (
        a[0],
        a[1],
        a[2] as usize,
        a[3] as usize,
        a[4],
        a[5] as usize,
    );
    let robot = saltus_robot::resolve(
        "rats-run",
        &[format!("leg.supply_pressure_gauge_psi={psi}")],
    )
    .unwrap();
    let obstacle = Obstacle {
        front,
        length: 0.21,
        height,
    };
    let setup_of = |x: &[f64], robot: saltus_robot::Robot, seed: u64| {
        let mut s = Setup::new(robot, Program::Fixed { firing_angle: 0.1 }, 2.0);
        s.seed = seed;
        s.first = (0..after).map(|k| [x[2 * k], x[2 * k + 1]]).collect();
        let n = 2 * after;
        s.leap = Some(Leap {
            after: after as u32,
            slope: x[n],
            level: x[n + 1],
            least: -0.3,
            most: 0.6,
            valve_open: 0.1,
            shock: (150.0 / (50.0 * 9.80665) * 32767.0) as i32,
        });
        s.zone = -0.3;
        s.obstacles = vec![obstacle];
        s.solid = false;
        s
    };
    let base = robot.clone();
    let one = |x: &[f64], k: usize, seed: u64| -> f64 {
        let robot = drawn_robot(&base, &Draw::default(), seed, k).unwrap();
        match run(&setup_of(x, robot, seed + k as u64), &mut ()) {
            Ok(s) => {
                if s.travel < front + 0.21 + 0.24 {
                    -0.3 + 0.1 * (s.travel - front).min(0.0)
                } else {
                    s.clearances[0].clamp(-0.25, 0.06)
                }
            }
            Err(_) => -1.0,
        }
    };
    let mut bounds = vec![];
    let mut start = vec![];
    for _ in 0..after {
        bounds.push([-0.1, 0.628]);
        bounds.push([0.012, 0.07]);
        start.push(0.3);
        start.push(0.03);
    }
    bounds.push([-0.15, 0.05]);
    start.push(-0.1);
    bounds.push([-0.1, 1.0]);
    start.push(0.46);
    let search_ = Search {
        bounds,
        start,
        spread: 0.3,
        candidates: 64,
        best: 10,
        generations: gens,
        seed: 1,
    };
    let score = |x: &[f64]| {
        (0..train)
            .map(|k| {
                let c = one(x, k, 100);
                c.min(0.03) + if c > 0.0 { 0.05 } else { 0.0 }
            })
            .sum::<f64>()
            / train as f64
    };
    let (x, best) = search(&search_, 2, score, |g, b, x| {
        if g % 5 == 4 {
            println!("{g} {b:.4} {x:.3?}")
        }
    });
    let held: Vec<f64> = saltus_numeric::parallel::map(100, |k| one(&x, k, 200));
    println!(
        "best {best:.4}; held out: cleared {} of 100; {x:.4?}",
        held.iter().filter(|c| **c > 0.0).count()
    );
}
