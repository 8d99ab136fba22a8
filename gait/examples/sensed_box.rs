//! temp
use saltus_gait::*;
use saltus_numeric::parallel::available;
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let a: Vec<f64> = std::env::args().skip(1).map(|x| x.parse().unwrap()).collect();
    let psi = a[0];
    let robot = saltus_robot::resolve("rats-run", &[format!("leg.supply_pressure_gauge_psi={psi}"), "sensors.range_noise_mm=10".into()])?;
    let s = Sensed { robot, draw: Draw::default(), height: a[1], length: 0.21, room: a[6], fronts: [a[4], a[5]], law: Smooth::QUICK, runs: a[2] as usize, rounds: a[3] as usize, seed: 500 };
    let t0 = std::time::Instant::now();
    let table = s.plan(available(), |n, share| eprintln!("{n} strides, expects {share:.3}, {:.1} s", t0.elapsed().as_secs_f64()))?;
    let all = s.try_on(&table, 100, 900, available())?;
    let n = all.iter().filter(|f| f.cleared).count();
    let on = all.iter().filter(|f| f.cleared && f.speed_after > 1.0).count();
    println!("{psi} psi, {} m: {n} of 100, run on {on}; {:.1} s", a[1], t0.elapsed().as_secs_f64());
    for f in all.iter().filter(|f| !f.cleared) { println!("  front {:.2} clearance {:.3} passed {:?}", f.front, f.clearance, f.passed); }
    Ok(())
}
