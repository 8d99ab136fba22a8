//! Jumps per second on one thread over the reference rows.
use saltus_lagrangian::*;
use saltus_robot::Robot;
use std::time::Instant;
fn main() {
    let tol: f64 = std::env::args().nth(1).map_or(2e-9, |s| s.parse().unwrap());
    let s = Stance::<f64>::new(&Robot::rats_planar(), |_, x| x).with_tolerance(tol);
    let rows: Vec<(Launch, [f64; 2])> = std::fs::read_to_string(std::env::var("JUMPS").unwrap())
        .unwrap()
        .lines()
        .skip(1)
        .map(|line| {
            let f: Vec<&str> = line.split(',').collect();
            let n = |k: usize| f[k].parse::<f64>().unwrap();
            (Launch { rate: n(0), lean: n(1), firing_angle: n(2), valve_open: n(3) }, [n(16), n(17)])
        })
        .collect();
    let mut worst = 0.0f64;
    for (l, r) in &rows {
        let e = s.jump(l).unwrap();
        let (x, y) = e.position();
        let (vx, vy) = e.velocity();
        let apex = y + vy * vy / 2.0 / 9.80665;
        let land = x + vx * (vy + (vy * vy + 2.0 * 9.80665 * (y - 0.24)).sqrt()) / 9.80665;
        worst = worst
            .max((apex - r[0]).abs() / r[0].abs().max(0.01))
            .max((land - r[1]).abs() / r[1].abs().max(0.01));
    }
    let mut best: Vec<f64> = (0..9)
        .map(|_| {
            let t = Instant::now();
            let mut n = 0;
            let mut acc = 0.0;
            while t.elapsed().as_secs_f64() < 0.2 {
                for (l, _) in &rows {
                    acc += s.jump(l).unwrap().time;
                }
                n += rows.len();
            }
            std::hint::black_box(acc);
            n as f64 / t.elapsed().as_secs_f64()
        })
        .collect();
    best.sort_by(f64::total_cmp);
    println!(
        "tol {tol:e}: err {worst:.1e}; {:.0} jumps/s [{:.0}..{:.0}]  {:.2} us",
        best[4],
        best[0],
        best[8],
        1e6 / best[4]
    );
}
