use saltus_controller::run::{Hold, Stall};
use saltus_gait::*;
fn main() {
    let a: Vec<f64> = std::env::args()
        .skip(1)
        .map(|x| x.parse().unwrap())
        .collect();
    let (ke, ki, tau, most, tv) = (a[0], a[1], a[2], a[3], a[4]);
    let robot = saltus_robot::resolve("rats-run", &[]).unwrap();
    let boom = robot.boom.unwrap().length;
    let knots = vec![
        [0.9, 0.8, tv],
        [1.27, 0.6, tv],
        [1.46, 0.55, tv],
        [1.6, 0.5, tv],
        [1.98, 0.4, tv],
        [2.2, 0.3, tv],
        [2.95, 0.2, tv],
        [3.4, 0.1, tv],
        [4.45, 0.0, tv],
    ];
    for v in [1.0, 1.5, 2.0, 2.5, 3.0] {
        let n = 40;
        let rs = saltus_numeric::parallel::map(n, |k| {
            let u = |j: usize| ((k * 7919 + j * 104729) % 1000) as f64 / 999.0 * 2.0 - 1.0;
            let mut r = robot.clone();
            if let Some(c) = r.leg.cylinder_mut() {
                c.supply.0 *= 1.0 + 0.2 * u(1);
            }
            r.ground.tilt = 3f64.to_radians() * u(2);
            let mut s = Setup::new(r, Program::Curve(knots.clone()), 16.0);
            s.seed = k as u64;
            s.first = vec![[a[5], a[6]], [a[7], a[8]]];
            s.speeds = vec![[0.0, v], [14.0, 0.0]];
            s.stall = Stall {
                rate: a[9],
                time: a[10],
                restarts: true,
            };
            s.hold = Some(Hold {
                way: boom * std::f64::consts::TAU / 1600.0,
                renewed: 1e-3 / tau,
                by_error: ke,
                by_sum: ki,
                most_sum: most,
            });
            struct F {
                x4: f64,
                x14: f64,
                stalls: usize,
                was: bool,
            }
            impl Run for F {
                fn row(&mut self, r: &Row<'_>) {
                    if r.time <= 4.0 {
                        self.x4 = r.axle[0];
                        self.was = r.action.stalled;
                    } else if r.time <= 14.0 {
                        self.x14 = r.axle[0];
                        if r.action.stalled && !self.was {
                            self.stalls += 1
                        }
                        self.was = r.action.stalled;
                    }
                }
                fn footfall(&mut self, _: &Footfall) {}
            }
            let mut f = F {
                x4: 0.0,
                x14: 0.0,
                stalls: 0,
                was: false,
            };
            match run(&s, &mut f) {
                Ok(sum) => (
                    (f.x14 - f.x4) / 10.0,
                    f.stalls,
                    sum.travel - f.x14,
                    sum.ending == Ending::Ran,
                ),
                Err(e) => {
                    println!("{e}");
                    (f64::NAN, 0, 0.0, false)
                }
            }
        });
        if std::env::var("SHOW").is_ok() {
            for (k, r) in rs.iter().enumerate() {
                let u = |j: usize| ((k * 7919 + j * 104729) % 1000) as f64 / 999.0 * 2.0 - 1.0;
                println!(
                    "supply {:+.2} slope {:+.2} v {:.2} stalls {}",
                    0.2 * u(1),
                    3.0 * u(2),
                    r.0,
                    r.1
                );
            }
        }
        let within = rs.iter().filter(|r| (r.0 / v - 1.0).abs() < 0.05).count();
        let mut m: Vec<f64> = rs.iter().map(|r| r.0).collect();
        m.sort_by(f64::total_cmp);
        let stalls = rs.iter().filter(|r| r.1 > 0).count();
        let stop = rs.iter().map(|r| r.2).fold(0.0, f64::max);
        println!(
            "v {v}: within 5%: {within}/{n}; min {:.2} 10% {:.2} med {:.2} max {:.2}; stalled {stalls}; stop {stop:.2} m; still moving {}",
            m[0],
            m[n / 10],
            m[n / 2],
            m[n - 1],
            rs.iter().filter(|r| r.3).count()
        );
    }
}
