//! The parameters that a model can be differentiated by.

use crate::{Drive, Robot};

/// A parameter of a robot, as a direction to differentiate along; SI units, as in [`Robot`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Parameter {
    /// Mass m (kg).
    Mass,
    /// Moment of inertia I (kg m²).
    Inertia,
    /// Foot to wheel centre r_s (m).
    Radius,
    /// Gravity g (m/s²).
    Gravity,
    /// Stroke of the leg (m).
    Stroke,
    /// Delay t_d (s).
    Delay,
    /// Viscous friction β (N s/m).
    ViscousFriction,
    /// Coulomb friction F_f (N).
    CoulombFriction,
    /// Supply pressure P_s (Pa).
    Supply,
    /// Chamber volume at d = 0 (m³).
    DeadVolume,
    /// Effective area of the valve C_f A_v (m²).
    ValveArea,
}

impl Parameter {
    /// Every parameter.
    pub const ALL: [Parameter; 11] = [
        Parameter::Mass,
        Parameter::Inertia,
        Parameter::Radius,
        Parameter::Gravity,
        Parameter::Stroke,
        Parameter::Delay,
        Parameter::ViscousFriction,
        Parameter::CoulombFriction,
        Parameter::Supply,
        Parameter::DeadVolume,
        Parameter::ValveArea,
    ];

    /// Its value in `robot` (absolute for the supply pressure); none where the robot's drive has no
    /// such parameter.
    pub fn of(self, robot: &Robot) -> Option<f64> {
        let (body, leg) = (&robot.body, &robot.leg);
        let cylinder = match &leg.drive {
            Drive::Pneumatic(cylinder) => Some(cylinder),
            _ => None,
        };
        match self {
            Parameter::Mass => Some(body.mass),
            Parameter::Inertia => Some(body.inertia),
            Parameter::Radius => Some(body.radius),
            Parameter::Gravity => Some(robot.environment.gravity),
            Parameter::Stroke => Some(leg.stroke),
            Parameter::Delay => Some(leg.delay),
            Parameter::ViscousFriction => Some(leg.viscous_friction),
            Parameter::CoulombFriction => Some(leg.coulomb_friction),
            Parameter::Supply => cylinder.map(|c| c.supply.absolute(robot.environment.ambient).0),
            Parameter::DeadVolume => cylinder.map(|c| c.dead_volume),
            Parameter::ValveArea => cylinder.map(crate::Cylinder::valve_area),
        }
    }

    /// Its name with its unit, as printed.
    pub fn name(self) -> &'static str {
        match self {
            Parameter::Mass => "mass_kg",
            Parameter::Inertia => "inertia_kg_m2",
            Parameter::Radius => "wheel_radius_m",
            Parameter::Gravity => "gravity_m_s2",
            Parameter::Stroke => "stroke_m",
            Parameter::Delay => "valve_delay_s",
            Parameter::ViscousFriction => "viscous_friction_n_s_per_m",
            Parameter::CoulombFriction => "coulomb_friction_n",
            Parameter::Supply => "supply_pressure_absolute_pa",
            Parameter::DeadVolume => "dead_volume_m3",
            Parameter::ValveArea => "valve_area_m2",
        }
    }
}
