//! Analyses the robot that runs, fired at 0.1 rad for 40 ms after a push: energy, periodic gaits,
//! which starts run, speed against gas; then its gaits over the firing angle.
//!
//!     cd studies && cargo run --release --bin analyse [ROBOTS]

use std::error::Error;

use saltus_gait::{Disturbance, Draw, Program, Setup, What, When};
use saltus_studies::analysis::basin::{Basin, Fate};
use saltus_studies::analysis::branch::{Parameter, follow};
use saltus_studies::analysis::periodic::Periodic;
use saltus_studies::analysis::stride::Firing;
use saltus_studies::analysis::{Effort, report};

fn main() -> Result<(), Box<dyn Error>> {
    let robots = std::env::args()
        .nth(1)
        .map_or(Ok(0), |n| n.parse::<usize>())?;
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../robots/rats-run.toml");
    let robot = saltus_robot::resolve(path, &[] as &[String])?;
    let program = Program::Fixed { firing_angle: 0.1 };
    let mut setup = Setup::new(robot.clone(), program, 10.0);
    setup.disturbances.push(Disturbance {
        when: When::Time(0.5, 0.7),
        what: What::Torque(5.0),
    });
    let mut effort = Effort {
        threads: saltus_numeric::parallel::available(),
        ..Effort::default()
    };
    if robots > 0 {
        effort = effort.with_robots(Draw::default(), robots, 7);
    }
    let report = report(&setup, &effort)?;
    println!("{:#?}", report.energy);
    println!("unexplained: {:.3e} J", report.energy.unexplained());
    report.gaits.iter().for_each(print_gait);
    report.basins.iter().for_each(print_basin);
    println!("alpha_f (rad)  t_v (s)  speed (m/s)  gas (g/m)  running");
    for c in &report.frontier {
        let (gas, running) = (1e3 * c.gas, format!("{}/{}", c.running, c.robots));
        println!(
            "{:13} {:8} {:12.3} {gas:10.4}  {running}",
            c.angle, c.opening, c.speed
        );
    }
    let angles: Vec<f64> = (0..=9).map(|k| 0.1 - 0.01 * f64::from(k)).collect();
    if let Some(gait) = report.gaits.last() {
        let firing = Firing::new(0.1, 0.04);
        let branch = follow((&robot, firing), gait, Parameter::FiringAngle, &angles)?;
        for (angle, gait) in &branch.gaits {
            print!("alpha_f {angle:.2} rad: ");
            print_gait(gait);
        }
        if let Some((angle, _)) = branch.lost {
            println!("alpha_f {angle:.2} rad: no periodic gait found");
        }
    }
    Ok(())
}

fn print_gait(gait: &Periodic) {
    let (most, error) = gait.greatest();
    println!(
        "{} legs in {:.5} s, {:.4} m/s, {:.4} g/m, greatest multiplier {most:.4} ± {error:.0e}",
        gait.legs,
        gait.period,
        gait.speed,
        1e3 * gait.gas
    );
}

fn print_basin(basin: &Basin) {
    println!(
        "{0} x {0}: {1:.4} runs, boundary {2:.3}",
        basin.size, basin.share, basin.boundary
    );
    for lean in 0..basin.size {
        let sign = |rate: usize| match basin.fate(lean, rate) {
            Fate::Runs => '#',
            Fate::Stalls => '.',
            Fate::Fails => '!',
        };
        println!("{}", (0..basin.size).map(sign).collect::<String>());
    }
}
