//! What the simulator's answers cost: steps a second, error over CPU time, and robots of many legs.
//!
//! `cd studies && cargo run --release --bin work_precision` prints three tables,
//! comma-separated. Times are CPU time of this thread.

use std::error::Error;
use std::time::Instant;

use saltus_robot::Robot;
use saltus_sim_check::{Launch, Plan, Report, Rig, Settings, Sim, Stepping};

const LAUNCH: Launch = Launch {
    rate: 3.0,
    lean: 0.0,
    firing_angle: 0.15,
    valve_open: 0.04,
};
/// CPU time (s) to spend on each row, at the least.
const BUDGET: f64 = if cfg!(debug_assertions) { 0.02 } else { 0.2 };

fn main() -> Result<(), Box<dyn Error>> {
    steps_a_second()?;
    work_and_precision()?;
    many_legs()
}

/// CPU time (s) of this thread; where the system does not tell, that of the clock.
fn cpu(since: &Instant) -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanoseconds = text.split(' ').next().and_then(|n| n.parse::<f64>().ok());
    nanoseconds.map_or_else(|| since.elapsed().as_secs_f64(), |n| n * 1e-9)
}

/// CPU time (s) of one call of `work`, the mean of as many as the budget allows.
fn time<T, E>(mut work: impl FnMut() -> Result<T, E>) -> Result<(T, f64), E> {
    let clock = Instant::now();
    let began = cpu(&clock);
    let mut calls = 0;
    loop {
        let last = work()?;
        calls += 1;
        let spent = cpu(&clock) - began;
        if spent >= BUDGET {
            return Ok((last, spent / f64::from(calls)));
        }
    }
}

fn fixed(h: f64) -> Settings {
    Settings {
        stepping: Stepping::Fixed(h),
        ..Settings::default()
    }
}

fn tolerance(tolerance: f64) -> Settings {
    Settings {
        tolerance,
        ..Settings::default()
    }
}

/// From standing, fired at once: a stance of 0.1 s, whose leg extends for the last half, and a
/// flight of 0.4 s.
fn steps_a_second() -> Result<(), Box<dyn Error>> {
    println!("robot,phase,step_s,steps_per_s,microseconds_per_step");
    for name in ["rats-boom", "rats-planar"] {
        let rig = Rig::new(&saltus_robot::resolve(name, &[])?, &[])?;
        let (q, v) = rig.stand(0.1, 3.0)?;
        let mut spent = [0.0; 2];
        let mut steps = [0; 2];
        let clock = Instant::now();
        while spent[0] + spent[1] < 5.0 * BUDGET {
            let mut sim = Sim::new(&rig.mechanism, &q, &v, fixed(1e-3))?;
            sim.fire(0, 0.04)?;
            for (phase, until) in [0.06, 0.4].into_iter().enumerate() {
                let (began, before) = (cpu(&clock), sim.effort().0);
                sim.run(until, &[])?;
                spent[phase] += cpu(&clock) - began;
                steps[phase] += sim.effort().0 - before;
            }
        }
        let rows = [("stance", 0..1), ("flight", 1..2), ("both", 0..2)];
        for (phase, part) in rows {
            let rate =
                steps[part.clone()].iter().sum::<usize>() as f64 / spent[part].iter().sum::<f64>();
            println!("{name},{phase},0.001,{rate:.0},{:.2}", 1e6 / rate);
        }
    }
    Ok(())
}

fn work_and_precision() -> Result<(), Box<dyn Error>> {
    println!("\nrobot,stepping,setting,landing_error_m,apex_error_m,cpu_ms");
    for name in ["rats-boom", "rats-planar"] {
        let rig = Rig::new(&saltus_robot::resolve(name, &[])?, &[])?;
        // Samples are for plots: none here.
        let jump = |settings| {
            rig.jump(
                &LAUNCH,
                &Plan {
                    sample: 1.0,
                    settings,
                    ..Plan::default()
                },
            )
        };
        let limit = jump(tolerance(1e-13))?;
        let row = |stepping: &str, setting: f64, report: &Report, time: f64| {
            let (landing, apex) = (report.landing - limit.landing, report.apex - limit.apex);
            println!(
                "{name},{stepping},{setting:e},{landing:.2e},{apex:.2e},{:.3}",
                time * 1e3
            );
        };
        for h in [4e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5] {
            let (report, time) = time(|| jump(fixed(h)))?;
            row("fixed step (s)", h, &report, time);
        }
        for tol in [1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12] {
            let (report, time) = time(|| jump(tolerance(tol)))?;
            row("adaptive", tol, &report, time);
        }
    }
    Ok(())
}

/// A jump of 0.4 s, its landing on the other legs included.
fn many_legs() -> Result<(), Box<dyn Error>> {
    println!("\nlegs,stepping,cpu_ms_per_simulated_s");
    for legs in [5, 12] {
        let robot: Robot = saltus_robot::resolve("rats-boom", &[format!("body.legs={legs}")])?;
        let rig = Rig::new(&robot, &[])?;
        let (q, v) = rig.stand(0.1, 3.0)?;
        for (name, settings) in [
            ("fixed 1e-3 s", fixed(1e-3)),
            ("adaptive 1e-6", tolerance(1e-6)),
        ] {
            let (_, time) = time(|| {
                let mut sim = Sim::new(&rig.mechanism, &q, &v, settings)?;
                sim.fire(0, 0.04)?;
                sim.run(0.4, &[])
            })?;
            println!("{legs},{name},{:.2}", time * 1e3 / 0.4);
        }
    }
    Ok(())
}
