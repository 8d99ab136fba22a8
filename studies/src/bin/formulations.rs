//! Three ways to hold a foot on the ground, on the same jumps: rigid contact whose events are
//! located, a compliant ground under which a foot sticks truly, and impulses in fixed steps.
//!
//! `cd studies && cargo run --release --bin formulations` prints the worst over the
//! launches: differences of apex and landing from the first formulation at a friction coefficient
//! of 1, how far the foot that should stick has crept along the travel by lift-off, and CPU time a
//! jump.

use std::error::Error;
use std::time::Instant;

use saltus_sim_check::{Launch, Plan, Pose, Report, Rig, Settings, Stepping};

const RATES: [f64; 3] = [2.5, 3.0, 3.5];
const CALLS: u32 = if cfg!(debug_assertions) { 2 } else { 20 };

fn main() -> Result<(), Box<dyn Error>> {
    println!(
        "robot,formulation,setting,apex_m,landing_m,apex_difference_m,landing_difference_m,creep_m,cpu_ms"
    );
    let adaptive = Settings {
        tolerance: 1e-8,
        ..Settings::default()
    };
    let fixed = |h| Settings {
        stepping: Stepping::Fixed(h),
        ..Settings::default()
    };
    for name in ["rats-boom", "rats-planar"] {
        let friction = |coefficient: &str| {
            [
                format!("ground.static_friction={coefficient}"),
                format!("ground.kinetic_friction={coefficient}"),
            ]
        };
        let rigid = Rig::new(&saltus_robot::resolve(name, &friction("1.0"))?, &[])?;
        let best = jumps(&rigid, adaptive)?;
        row(name, "rigid by events", "tolerance 1e-8", &best, &best);
        for exponent in 4..=7 {
            let stiffness = 10_f64.powi(exponent);
            // A quarter of critical damping under the robot's 2.75 kg.
            let damping = 0.5 * (stiffness * 2.75).sqrt();
            let ground = |coefficient: &str| {
                let [standing, slipping] = friction(coefficient);
                let stiffness = format!("ground.stiffness_n_per_m={stiffness:.1}");
                [
                    standing,
                    slipping,
                    stiffness,
                    format!("ground.damping_n_s_per_m={damping:.3}"),
                ]
            };
            let soft = Rig::new(&saltus_robot::resolve(name, &ground("1.0"))?, &[])?;
            let setting = format!("1e{exponent} N/m");
            row(
                name,
                "compliant by events",
                &setting,
                &jumps(&soft, adaptive)?,
                &best,
            );
            row(
                name,
                "compliant in steps of 1 ms",
                &setting,
                &jumps(&soft, fixed(1e-3))?,
                &best,
            );
            let sticky = Rig::new(&saltus_robot::resolve(name, &ground("inf"))?, &[])?;
            row(
                name,
                "compliant by events and no slip ever",
                &setting,
                &jumps(&sticky, adaptive)?,
                &best,
            );
        }
        for h in [4e-3, 1e-3, 2.5e-4] {
            let setting = format!("{} ms", h * 1e3);
            row(
                name,
                "rigid in fixed steps",
                &setting,
                &jumps(&rigid, fixed(h))?,
                &best,
            );
        }
    }
    Ok(())
}

struct Jumps {
    reports: Vec<Report>,
    /// Greatest travel (m) of the standing foot from start to lift-off.
    creep: f64,
    /// CPU time of one (s).
    time: f64,
}

fn jumps(rig: &Rig, settings: Settings) -> Result<Jumps, Box<dyn Error>> {
    let clock = Instant::now();
    let mut found = Jumps {
        reports: Vec::new(),
        creep: 0.0,
        time: 0.0,
    };
    for rate in RATES {
        let launch = Launch {
            rate,
            lean: 0.0,
            firing_angle: 0.15,
            valve_open: 0.04,
        };
        let plan = Plan {
            sample: 1.0,
            settings,
            ..Plan::default()
        };
        let began = cpu(&clock);
        for _ in 1..CALLS {
            rig.jump(&launch, &plan)?;
        }
        let report = rig.jump(&launch, &plan)?;
        found.time += (cpu(&clock) - began) / f64::from(CALLS) / RATES.len() as f64;
        let at = |q: &[f64]| {
            let mut pose = Pose::default();
            pose.set(
                &rig.mechanism.tree,
                q,
                &vec![0.0; rig.mechanism.tree.velocities()],
            );
            let foot = &rig.mechanism.points[0];
            rig.travel_of(&pose.frames[foot.body].point(&foot.center))
        };
        let lift_off = report.lift_off.map_or(f64::NAN, |l| l.time);
        if let (Some(first), Some(last)) = (
            report.samples.first(),
            report.samples.iter().find(|s| s.time == lift_off),
        ) {
            found.creep = found
                .creep
                .max((at(&last.coordinates) - at(&first.coordinates)).abs());
        }
        found.reports.push(report);
    }
    Ok(found)
}

fn row(robot: &str, formulation: &str, setting: &str, found: &Jumps, best: &Jumps) {
    let worst = |of: fn(&Report) -> f64| {
        let pairs = found.reports.iter().zip(&best.reports);
        pairs
            .map(|(a, b)| (of(a) - of(b)).abs())
            .fold(
                0.0,
                |worst: f64, x| if x.is_nan() { x } else { worst.max(x) },
            )
    };
    println!(
        "{robot},{formulation},{setting},{:.6},{:.6},{:.1e},{:.1e},{:.1e},{:.3}",
        found.reports[1].apex,
        found.reports[1].landing,
        worst(|r| r.apex),
        worst(|r| r.landing),
        found.creep,
        found.time * 1e3,
    );
}

/// CPU time (s) of this thread; where the system does not tell, that of the clock.
fn cpu(since: &Instant) -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanoseconds = text.split(' ').next().and_then(|n| n.parse::<f64>().ok());
    nanoseconds.map_or_else(|| since.elapsed().as_secs_f64(), |n| n * 1e-9)
}
