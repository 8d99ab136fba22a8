//! What a jumping robot is: parameters with units, TOML files, checks.

mod model;
mod parameter;

pub use model::*;
pub use parameter::Parameter;

impl Robot {
    /// The thesis' planar robot without its boom (MODEL.md).
    pub fn rats_planar() -> Robot {
        Robot {
            name: "rats-planar".into(),
            body: Body { mass: 2.75, inertia: 0.0792, radius: 0.24, legs: 5 },
            leg: Leg {
                stroke: 0.06,
                delay: 0.010,
                viscous_friction: 5.2843,
                coulomb_friction: 9.7003,
                return_spring: None,
                cushion: None,
                drive: Drive::Pneumatic(Cylinder {
                    bore: 0.01905,
                    dead_volume: 5.4e-6,
                    supply: GaugePressure(120.0 * 6894.757293168),
                    discharge_coefficient: 0.5378,
                    orifice_radius: 1.0215e-3,
                    gas: Gas::AIR,
                    temperature: 293.15,
                    supply_droop: 0.0,
                    leak_area: 0.0,
                    exhaust_port: None,
                    polytropic_exponent: None,
                    seal_friction: 0.0,
                }),
            },
            environment: Environment { gravity: 9.80665, ambient: AbsolutePressure(101_325.0), drag: 0.0 },
            errors: Errors::default(),
        }
    }
}
