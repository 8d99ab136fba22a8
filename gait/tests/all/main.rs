//! Tests of running robots, in one binary: linking is what takes time.

mod commanded;
mod energy;
mod learn;
mod learn_tasks;
mod passive;
mod rest;
mod sensed;
mod space;

use saltus_gait::{Disturbance, Program, Setup, What, When};
use saltus_robot::{Robot, resolve};

/// The robot of that name.
fn robot(name: &str) -> Robot {
    let path = format!("{}/../robots/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    resolve(&path, &[] as &[String]).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// The robot that runs, fired at 0.1 rad, pushed at 0.5 s: thesis 5.1.2.
fn pushed(seconds: f64) -> Setup {
    let program = Program::Fixed { firing_angle: 0.1 };
    let mut setup = Setup::new(robot("rats-run"), program, seconds);
    setup.disturbances.push(Disturbance {
        when: When::Time(0.5, 0.7),
        what: What::Torque(5.0),
    });
    setup
}
