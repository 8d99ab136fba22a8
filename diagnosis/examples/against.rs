//! Scratch: rig against the multi-body simulation.
use saltus_diagnosis::rig::{Rig, Start};
use saltus_sim_check as sc;
use std::time::Instant;
fn main() {
    let sets: Vec<Vec<&str>> = vec![
        vec![], vec!["leg.supply_pressure_gauge_psi=100"], vec!["leg.supply_droop_pa_s_per_kg=1e7"], vec!["leg.valve_delay_ms=14"],
        vec!["leg.discharge_coefficient=0.4"], vec!["leg.leak_area_mm2=0.5"], vec!["leg.dead_volume_cm3=9"], vec!["leg.viscous_friction_n_s_per_m=20"],
        vec!["leg.coulomb_friction_n=25"], vec!["leg.seal_friction_n_per_pa=3e-5"], vec!["leg.return_spring.stiffness_n_per_m=200","leg.return_spring.preload_n=4"],
        vec!["leg.gas=\"co2\""], vec!["leg.exhaust_port.position_mm=45","leg.exhaust_port.area_mm2=20"], vec!["leg.polytropic_exponent=1.1"],
        vec!["body.mass_kg=3.2"], vec!["body.inertia_kg_m2=0.1"], vec!["body.imbalance_mm=8","body.imbalance_angle_deg=60"], vec!["boom.mass_kg=0.8"],
        vec!["boom.bending_stiffness_n_m_per_rad=2000"], vec!["body.axle_friction_n_m=0.2"],
        vec!["ground.static_friction=0.35"], vec!["ground.stiffness_n_per_m=3e4","ground.damping_n_s_per_m=60"],
        vec!["foot.radius_m=0.02"], vec!["ground.slope_deg=3"], vec!["environment.drag_per_m=0.1"], vec!["environment.gravity_m_s2=8"],
        vec!["boom.counterweight.mass_kg=1","boom.counterweight.distance_m=0.7"],
    ];
    for base in ["rats-boom", "rats-planar"] {
    for set in &sets {
        let overrides: Vec<String> = set.iter().map(|s| s.to_string()).collect();
        if base == "rats-planar" && set.iter().any(|s| s.contains("port") || s.contains("gas")) { continue; }
        if base == "rats-planar" && set.iter().any(|s| s.contains("boom")) { continue; }
        let robot = saltus_robot::resolve(base, &overrides).unwrap();
        let rig = Rig::new(&robot);
        let whole = sc::Rig::new(&robot, &[]).unwrap();
        let mut worst = [0.0f64; 4];
        let (mut mine, mut theirs) = (0.0, 0.0);
        for (lean, rate, fire, open) in [(-0.35, 4.5, -0.05, 0.08), (-0.3, 5.5, 0.15, 0.05), (-0.2, 3.3, 0.0, 0.1)] {
            let t = Instant::now();
            let plan = sc::Plan { sample: 1e-3, landing_height: robot.body.radius - 0.02, ..sc::Plan::default() };
            let report = whole.jump(&sc::Launch { lean, rate, firing_angle: fire, valve_open: open }, &plan);
            let Ok(report) = report else { println!("sim-check: {report:?}"); continue };
            theirs += t.elapsed().as_secs_f64();
            let Some(lift) = report.lift_off else { println!("{:?}", report.end); continue };
            let end = report.samples.last().unwrap().time;
            let t = Instant::now();
            let course = rig.jump(Start::Rolling { lean, rate }, lift.time_fire, lift.time_fire + open, Some(end));
            mine += t.elapsed().as_secs_f64();
            let Some(course) = course else { println!("none"); continue };
            let mut place = 0;
            for s in &report.samples {
                if s.time <= 0.0 { continue; }
                let p = course.at(s.time, &mut place);
                let turn = p.turn.0 * robot.boom.map_or(1.0, |b| b.length);
                worst[0] = worst[0].max((p.lean.0 - s.lean).abs());
                worst[1] = worst[1].max((p.height.0 - s.axle[1]).abs());
                worst[2] = worst[2].max((turn - s.axle[0]).abs());
            }
            worst[3] = worst[3].max((course.leaves.unwrap_or(9.0) - lift.time).abs());
        }
        println!("{base} {set:?}: lean {:.1e} height {:.1e} travel {:.1e} leaves {:.1e}  {:.2} ms against {:.2}", worst[0], worst[1], worst[2], worst[3], mine*333.0, theirs*333.0);
    }}
}
