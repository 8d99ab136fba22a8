use saltus_gait::*;
fn main() {
    let over: Vec<String> = std::env::args().skip(1).collect();
    let robot = saltus_robot::resolve("rats-run", &over).unwrap();
    for zone in [0.0, -0.3] {
        for a in [-0.2, -0.1, 0.0, 0.1, 0.2, 0.3, 0.4, 0.5] {
            if a < zone {
                continue;
            }
            print!("z {zone} a {a:+.1}: ");
            for tv in [0.012, 0.016, 0.02, 0.025, 0.03, 0.035, 0.04, 0.05, 0.06] {
                let mut s = Setup::new(robot.clone(), Program::Fixed { firing_angle: a }, 14.0);
                s.valve_open = tv;
                s.zone = zone;
                s.disturbances.push(Disturbance {
                    when: When::Time(0.5, 1.0),
                    what: What::Torque(5.0),
                });
                match run(&s, &mut ()) {
                    Ok(r) => print!("{:5.2} ", r.last_speed),
                    Err(_) => print!("  err "),
                }
            }
            println!();
        }
    }
}
