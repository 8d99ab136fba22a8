//! Random jumps: accuracy and speed of the batch.
use saltus_lagrangian::*;
use saltus_robot::Robot;
use std::time::Instant;
fn main() {
    let r = Robot::rats_planar();
    let mut seed = 7u64;
    let mut u = || {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        (seed >> 11) as f64 / (1u64 << 53) as f64
    };
    let jumps: Vec<Launch> = (0..20000)
        .map(|_| {
            let rate = 3.0 + 3.0 * u();
            let firing_angle = -0.25 + 0.35 * u();
            let lean = if u() < 0.5 { firing_angle } else { -0.35 };
            Launch { rate, lean, firing_angle, valve_open: 0.02 + 0.08 * u() }
        })
        .collect();
    let fine = Stance::<f64>::new(&r, |_, x| x).with_tolerance(1e-13);
    let land = |e: &LiftOff| {
        let (x, y) = e.position();
        let (vx, vy) = e.velocity();
        let g = 9.80665;
        [
            y + vy * vy / 2.0 / g,
            x + vx * (vy + (vy * vy + 2.0 * g * (y - 0.24)).sqrt()) / g,
            x + vx * (vy + (vy * vy + 2.0 * g * y).sqrt()) / g,
        ]
    };
    let reference: Vec<LiftOff> = jumps.iter().map(|l| fine.jump(l).unwrap()).collect();
    for tol in [4e-9, 3e-9, 2e-9, 1e-9] {
        let stance = fine.clone().with_tolerance(tol);
        let b = Batch::new(&r, tol);
        let report = |name: &str, f: &dyn Fn() -> Vec<LiftOff>| {
            let ends = f();
            let mut e: Vec<f64> = ends
                .iter()
                .zip(&reference)
                .map(|(a, b)| {
                    if a.outcome != b.outcome {
                        return 1.0;
                    }
                    land(a)
                        .iter()
                        .zip(land(b))
                        .map(|(x, y)| (x - y).abs() / y.abs().max(0.01))
                        .fold(0.0, f64::max)
                })
                .collect();
            e.sort_by(f64::total_cmp);
            let mut t: Vec<f64> = (0..5)
                .map(|_| {
                    let t = Instant::now();
                    std::hint::black_box(f());
                    t.elapsed().as_secs_f64() / 20000.0 * 1e6
                })
                .collect();
            t.sort_by(f64::total_cmp);
            println!(
                "{name} tol {tol:e}: median {:.1e} 99% {:.1e} max {:.1e}, beyond 1e-9: {}; {:.2} us [{:.2}..{:.2}]",
                e[10000],
                e[19800],
                e[19999],
                e.iter().filter(|x| **x > 1e-9).count(),
                t[2],
                t[0],
                t[4]
            );
        };
        report("single", &|| jumps.iter().map(|l| stance.jump(l).unwrap()).collect());
        report("batch ", &|| b.jumps(&jumps).into_iter().map(Result::unwrap).collect());
    }
}
