//! x
use saltus_gait::*;
use saltus_numeric::parallel::available;
struct Until(f64);
impl Run for Until {
    fn row(&mut self, r: &Row<'_>) {
        self.0 = r.axle[0];
    }
    fn footfall(&mut self, _: &Footfall) {}
    fn goes_on(&mut self) -> bool {
        self.0 < 1.6
    }
}
fn main() {
    let a: Vec<f64> = std::env::args()
        .skip(1)
        .map(|x| x.parse().unwrap())
        .collect();
    let mut base = saltus_robot::resolve("rats-run", &[]).unwrap();
    if a.len() > 1 {
        base.ground.static_friction = a[1];
        base.ground.kinetic_friction = a[1];
    }
    let d = if a.len() > 2 { a[2] } else { 1.6 };
    let mut s = Setup::new(base.clone(), Program::Fixed { firing_angle: 0.0 }, 3.0);
    s.zone = -0.3;
    let t = std::time::Instant::now();
    let o = optimal(
        &s,
        Quest {
            distance: d,
            levels: a[0] as usize,
        },
        available(),
        |_, _| (),
    )
    .unwrap();
    println!("wall {:.1}", t.elapsed().as_secs_f64());
    for l in &o.levels {
        println!("{l:?}");
    }
    println!(
        "time {} seq {:.3?} {} rows {} x {} rates {:?}",
        o.time,
        o.sequence,
        o.sequence_time,
        o.table.nodes.len() / o.table.count,
        o.table.count,
        o.table.rates
    );
    s.program = Program::Policy(o.table.clone());
    let mut q = vec![];
    for seed in 0..20 {
        s.seed = seed;
        let r = run(&s, &mut Until(0.0)).unwrap();
        q.push(r.time_to_1_6_m.unwrap_or(9.0));
    }
    println!("flown {q:.3?}");
    s.robot.sensors.as_mut().unwrap().gyro_noise = 0.0;
    println!(
        "quiet {:?}",
        run(&s, &mut Until(0.0)).unwrap().time_to_1_6_m
    );
    for (n, p, z) in [
        ("table", Program::Policy(o.table.clone()), -0.3),
        ("smooth", Smooth::QUICK.program(), -0.3),
    ] {
        let mut setup = Setup::new(base.clone(), p, 3.0);
        setup.zone = z;
        let e = Ensemble {
            setup,
            draw: Draw::default(),
            robots: 100,
            seed: 200,
        };
        let all = e.run(available(), &|| ()).unwrap();
        let mut v: Vec<f64> = all
            .iter()
            .map(|s| s.time_to_1_6_m.unwrap_or(99.0))
            .collect();
        v.sort_by(f64::total_cmp);
        println!(
            "{n}: {:.3} {:.3} {:.3} {:.3}, reached {}",
            v[0],
            v[25],
            v[50],
            v[75],
            v.iter().filter(|x| **x < 9.0).count()
        );
    }
}
