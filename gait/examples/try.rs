use saltus_gait::*;
use saltus_sim_check::Stepping;
use std::time::Instant;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let h: f64 = a[1].parse().unwrap();
    let secs: f64 = a[2].parse().unwrap();
    let kind = a[3].as_str();
    let over: Vec<String> = a[4..]
        .iter()
        .filter(|x| x.contains('=') && !x.starts_with("k="))
        .cloned()
        .collect();
    let robot = saltus_robot::resolve("/work/main/robots/rats-run.toml", &over).unwrap();
    let program = match kind {
        "fixed" | "push" => Program::Fixed { firing_angle: 0.1 },
        "open" => Program::OpenLoop {
            first: 0.35,
            last: 0.0,
            slope: 2.1,
            centre: Centre::Seconds(3.0),
        },
        "printed" => Program::OpenLoop {
            first: 0.35,
            last: 0.0,
            slope: 2.1,
            centre: Centre::Printed(3.0),
        },
        "one" => Program::ClosedLoop(Lines::One {
            first: 0.35,
            last: -0.1,
            at: 13.3,
        }),
        "jump" => Program::ClosedLoop(Lines::Two {
            first: 0.35,
            slope: -0.01,
            switch: 5.0,
            last: -0.1,
            at: 13.3,
            jumps: true,
        }),
        _ => Program::ClosedLoop(Lines::Two {
            first: 0.35,
            slope: -0.01,
            switch: 5.0,
            last: -0.1,
            at: 13.3,
            jumps: false,
        }),
    };
    let mut s = Setup::new(robot, program, secs);
    if h > 0.0 {
        s.stepping = Stepping::Fixed(h)
    } else {
        s.stepping = Stepping::Adaptive
    }
    if ["one", "two", "jump"].contains(&kind) {
        s.zone = -0.3
    }
    if kind == "push" {
        s.disturbances.push(Disturbance {
            when: When::Time(0.5, 0.7),
            what: What::Torque(5.0),
        })
    }
    if a.iter().any(|x| x == "ens") {
        let n = 40;
        let e = Ensemble {
            setup: s,
            draw: Draw::default(),
            robots: n,
            seed: 7,
        };
        let t = Instant::now();
        let r: Vec<_> = (0..n)
            .map(|k| {
                let setup = Setup {
                    robot: drawn_robot(&e.setup.robot, &e.draw, e.seed, k).unwrap(),
                    seed: k as u64,
                    ..e.setup.clone()
                };
                run(&setup, &mut ()).map_err(|x| x.to_string())
            })
            .collect();
        for (k, x) in r
            .iter()
            .enumerate()
            .filter_map(|(k, x)| x.as_ref().err().map(|x| (k, x)))
            .take(4)
        {
            println!("{k} {x}")
        }
        let ok: Vec<_> = r.iter().filter_map(|x| x.as_ref().ok()).collect();
        let runs = ok.iter().filter(|s| s.last_speed > 1.5).count();
        let mut sp: Vec<f64> = ok
            .iter()
            .filter(|s| s.last_speed > 1.5)
            .map(|s| s.last_speed)
            .collect();
        sp.sort_by(f64::total_cmp);
        println!(
            "{kind}: ok {} runs {} median {:?} min {:?} max {:?}; {:?}",
            ok.len(),
            runs,
            sp.get(sp.len() / 2),
            sp.first(),
            sp.last(),
            t.elapsed()
        );
        return;
    }
    struct P(bool);
    impl Run for P {
        fn row(&mut self, r: &Row<'_>) {
            if self.0 {
                println!(
                    "{:.3} x {:.5} z {:.6} vz {:+.5} lean {:.6} rate {:+.5} ext {:?}",
                    r.time,
                    r.axle[0],
                    r.axle[1],
                    r.axle_rates[1],
                    r.lean,
                    r.rate,
                    r.extensions
                        .iter()
                        .map(|x| (x * 1e6).round() / 1e3)
                        .collect::<Vec<_>>()
                );
            }
        }
        fn footfall(&mut self, f: &Footfall) {
            if self.0 {
                println!("   foot {} {:.6}", f.leg, f.time);
            }
        }
    }
    if let Some(k) = a
        .iter()
        .find_map(|x| x.strip_prefix("k="))
        .and_then(|k| k.parse::<usize>().ok())
    {
        s.robot = drawn_robot(&s.robot, &Draw::default(), 7, k).unwrap();
        s.seed = k as u64;
    }
    let t = Instant::now();
    match run(&s, &mut P(a.iter().any(|x| x == "rows"))) {
        Ok(r) => {
            println!("{r:#?}");
        }
        Err(e) => println!("error {e}"),
    }
    println!(
        "{:?}  {} us/step",
        t.elapsed(),
        t.elapsed().as_secs_f64() * 1e6 / (secs / h)
    );
}
