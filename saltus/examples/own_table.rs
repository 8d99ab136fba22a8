//! A firing table for a robot of one's own, described in TOML: angles by distance and approach rate.
//!
//! `cargo run -p saltus --example own_table`

use std::error::Error;
use std::path::Path;

use saltus::planner::TableRequest;
use saltus::{Planner, Robot};

/// A file would do as well: `Robot::load("my-robot.toml")`. `robots/README.md` lists every key.
const ROBOT: &str = r#"
name = "spring wheel"
environment = { gravity_m_s2 = 9.80665, ambient_pressure_kpa = 101.325 }

[body]
mass_kg = 0.9
inertia_kg_m2 = 0.013
wheel_radius_mm = 170
legs = 4

[leg]
kind = "spring"
stroke_mm = 70
release_delay_ms = 3
viscous_friction_n_s_per_m = 1.2
coulomb_friction_n = 2
stiffness_n_per_m = 2400
compression_mm = 80

[errors]
rate_rad_s = 0.05
firing_angle_deg = 0.1
"#;

fn main() -> Result<(), Box<dyn Error>> {
    let planner = Planner::new(Robot::parse(ROBOT, "spring wheel", Path::new("."))?);
    let request = TableRequest {
        targets: vec![0.4, 0.6, 5.0],
        ..TableRequest::distance(0.4).landing_height(planner.robot().body.radius)
    };
    let table = planner.table(&request.rates([3.0, 4.0, 5.0, 6.0]))?;

    println!("ω (rad/s)  distance (m)  α_f (rad)  apex (m)  deviation (m)");
    for cell in &table.cells {
        print!("{:9.2} {:13.2}", cell.rate, cell.target);
        match (cell.entries.first(), cell.nearest) {
            (Some(entry), _) => {
                let angle = entry.jump.launch.firing_angle;
                let apex = entry.jump.apex().unwrap_or(f64::NAN);
                let errors = &planner.robot().errors;
                let deviation = entry
                    .sensitivity
                    .map_or(f64::NAN, |s| s[0].standard_deviation(errors));
                println!(" {angle:10.4} {apex:9.4} {deviation:14.4}");
            }
            (None, Some(nearest)) => {
                println!(
                    "  out of reach: {:.3} m at {:.4} rad",
                    nearest.value, nearest.firing_angle
                );
            }
            (None, None) => println!("  no angle jumps"),
        }
    }
    Ok(())
}
