//! probe
use saltus_robot::Robot;
use saltus_sim_check::*;
fn cpu() -> f64 {
    std::fs::read_to_string("/proc/thread-self/schedstat")
        .ok()
        .and_then(|s| s.split(' ').next().and_then(|n| n.parse::<f64>().ok()))
        .unwrap_or(0.0)
        * 1e-9
}
fn main() -> Result<(), Box<dyn std::error::Error>> {
    for name in ["rats-boom", "rats-planar"] {
        let rig = Rig::new(&Robot::builtin(name).expect("built in"), &[])?;
        let launch = Launch { rate: 3.0, lean: 0.0, firing_angle: 0.15, valve_open: 0.04 };
        let best = rig.jump(
            &launch,
            &Plan {
                sample: 1.0,
                settings: Settings { tolerance: 1e-12, ..Settings::default() },
                ..Plan::default()
            },
        )?;
        println!("{name} {:?}", best.lift_off);
        let mut all: Vec<(String, Settings)> = [1e-4, 1e-6, 1e-8, 1e-10, 1e-12]
            .iter()
            .map(|t| (format!("tol {t:e}"), Settings { tolerance: *t, ..Settings::default() }))
            .collect();
        all.extend([4e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5].iter().map(|h| {
            (format!("h {h:e}"), Settings { stepping: Stepping::Fixed(*h), ..Settings::default() })
        }));
        for (what, settings) in all {
            let plan = Plan { sample: 1.0, settings, ..Plan::default() };
            let began = cpu();
            let n = 20;
            for _ in 1..n {
                rig.jump(&launch, &plan)?;
            }
            let r = rig.jump(&launch, &plan)?;
            println!(
                "{what:10} land {:9.2e} apex {:9.2e} res {:9.2e} {:.3} ms {:?} {:?}",
                r.landing - best.landing,
                r.apex - best.apex,
                r.residual,
                (cpu() - began) / f64::from(n) * 1e3,
                r.end,
                r.lift_off.map(|l| (l.time, l.at_end_stop))
            );
        }
    }
    Ok(())
}
