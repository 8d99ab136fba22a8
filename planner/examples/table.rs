//! scratch
use saltus_planner::*;
use saltus_robot::Robot;
use std::time::Instant;
fn main() {
    let p = Planner::new(Robot::rats_planar());
    let lin = |a: f64, b: f64, n: usize| {
        (0..n).map(|i| a + (b - a) * i as f64 / (n - 1) as f64).collect::<Vec<_>>()
    };
    let mut req = TableRequest {
        rates: lin(3.0, 6.0, 61),
        measure: Measure::Distance { landing_height: 0.0 },
        targets: lin(0.3, 1.0, 36),
        valve_open: 0.1,
        start_lean: None,
        firing_angles: FIRING_ANGLES,
        roots: Roots::Least,
        sensitivities: false,
        threads: 1,
    };
    let t = p.table(&req).unwrap();
    let text = std::fs::read_to_string("/tmp/reference/table.csv").unwrap();
    let mut worst = 0.0f64;
    for (c, line) in t.cells.iter().zip(text.lines().skip(1)) {
        let f: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
        let a = c.entries[0].jump.launch.firing_angle;
        if (c.rate - f[0]).abs() > 1e-9 || (c.target - f[1]).abs() > 1e-9 {
            panic!("{c:?} {line}")
        }
        worst = worst.max((a - f[2]).abs());
    }
    println!("cells {} worst {worst:e}", t.cells.len());
    for (roots, threads, sens) in
        [(Roots::Least, 1, false), (Roots::Least, 2, false), (Roots::All, 1, false), (Roots::All, 1, true)]
    {
        req.roots = roots;
        req.threads = threads;
        req.sensitivities = sens;
        let mut v: Vec<f64> = (0..9)
            .map(|_| {
                let t0 = Instant::now();
                let t = p.table(&req).unwrap();
                std::hint::black_box(t.cells.len());
                t0.elapsed().as_secs_f64() * 1e3
            })
            .collect();
        v.sort_by(f64::total_cmp);
        let t = p.table(&req).unwrap();
        println!(
            "{roots:?} {threads} sens {sens}: {:.2} ms [{:.2}..{:.2}] entries {}",
            v[4],
            v[0],
            v[8],
            t.cells.iter().map(|c| c.entries.len()).sum::<usize>()
        );
    }
}
