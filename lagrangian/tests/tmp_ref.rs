use saltus_lagrangian::*;
use saltus_robot::Robot;
#[test]
fn rows() {
    let s = Stance::<f64>::new(&Robot::rats_planar(), |_, x| x);
    for tol in [1e-12, 2e-9] {
        let s = s.clone().with_tolerance(tol);
        let mut worst = 0.0f64;
        let mut wr = 0;
        let mut bad = 0;
        for (i, line) in
            std::fs::read_to_string("/tmp/reference/jumps.csv").unwrap().lines().enumerate().skip(1)
        {
            let f: Vec<&str> = line.split(',').collect();
            let n = |k: usize| f[k].parse::<f64>().unwrap();
            let l = s.jump(&Launch { rate: n(0), lean: n(1), firing_angle: n(2), valve_open: n(3) }).unwrap();
            if l.outcome.name() != f[4] {
                bad += 1;
                println!("row {i} {} {}", l.outcome.name(), f[4]);
                continue;
            }
            let (x, y) = l.position();
            let (vx, vy) = l.velocity();
            let got = [
                l.time_fire,
                l.time,
                l.lean,
                l.rate,
                l.extension,
                l.extension_rate,
                l.pressure,
                x,
                y,
                vx,
                vy,
            ];
            for (k, g) in got.iter().enumerate() {
                let r = n(5 + k);
                let e = (g - r).abs() / r.abs().max(0.01);
                if e > worst {
                    worst = e;
                    wr = i * 100 + k;
                }
            }
        }
        println!("tol {tol}: worst {worst:e} at {wr}, bad {bad}");
    }
}
#[test]
fn worst_rows() {
    let s = Stance::<f64>::new(&Robot::rats_planar(), |_, x| x).with_tolerance(2e-9);
    let mut v = vec![];
    for (i, line) in std::fs::read_to_string("/tmp/reference/jumps.csv").unwrap().lines().enumerate().skip(1)
    {
        let f: Vec<&str> = line.split(',').collect();
        let n = |k: usize| f[k].parse::<f64>().unwrap();
        let l = s.jump(&Launch { rate: n(0), lean: n(1), firing_angle: n(2), valve_open: n(3) }).unwrap();
        let (x, y) = l.position();
        let (vx, vy) = l.velocity();
        let got =
            [l.time_fire, l.time, l.lean, l.rate, l.extension, l.extension_rate, l.pressure, x, y, vx, vy];
        let mut w = (0.0f64, 0);
        for (k, g) in got.iter().enumerate() {
            let r = n(5 + k);
            let e = (g - r).abs() / r.abs().max(0.01);
            if e > w.0 {
                w = (e, k);
            }
        }
        v.push((w.0, w.1, line[..40].to_string()));
    }
    v.sort_by(|a, b| b.0.total_cmp(&a.0));
    for x in v.iter().step_by(8) {
        println!("W {x:?}");
    }
}
#[test]
fn trace() {
    let s = Stance::<f64>::new(&Robot::rats_planar(), |_, x| x);
    let t0 = std::time::Instant::now();
    let t = s.trace(&Launch { rate: 5.0, lean: -0.35, firing_angle: -0.1, valve_open: 0.1 }).unwrap();
    println!(
        "T {:?} {:?} {:?} res {:e} n {} {:?}",
        t.lift_off,
        t.contact,
        t.energy,
        t.energy.residual(),
        t.samples.len(),
        t0.elapsed()
    );
    println!("T {:?}", s.jump(&Launch { rate: 5.0, lean: -0.35, firing_angle: -0.1, valve_open: 0.1 }));
}
