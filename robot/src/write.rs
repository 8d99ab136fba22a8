//! A robot as a robot file.

use std::fmt::{self, Formatter};

use crate::{
    Body, Boom, Cylinder, Drive, Environment, Errors, Foot, ForceTable, Ground, Leg, LegBody, Robot,
};

impl Robot {
    /// The robot file, in SI units, that [`Robot::parse`] reads as this very robot, to the last
    /// bit.
    ///
    /// A force table is written into it, so that the file stands alone. A value outside its domain
    /// is written as it is, for the reader to refuse.
    ///
    /// # Example
    /// ```
    /// # use std::path::Path;
    /// use saltus_robot::Robot;
    /// let mut robot = Robot::rats_planar();
    /// robot.body.mass = 3.0;
    /// assert_eq!(Robot::parse(&robot.to_toml(), "heavy.toml", Path::new("."))?, robot);
    /// # Ok::<(), saltus_robot::RobotError>(())
    /// ```
    pub fn to_toml(&self) -> String {
        RobotFile(self).to_string()
    }
}

/// A robot whose display is its file.
struct RobotFile<'a>(&'a Robot);

impl fmt::Display for RobotFile<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write_robot(f, self.0)
    }
}

fn write_robot(f: &mut Formatter<'_>, robot: &Robot) -> fmt::Result {
    let Robot {
        name,
        body,
        leg,
        boom,
        foot,
        ground,
        environment,
        errors,
    } = robot;
    writeln!(f, "name = {}", quoted(name))?;
    write_body(f, body)?;
    write_leg(f, leg)?;
    if let Some(boom) = boom {
        write_boom(f, boom)?;
    }
    if *foot != Foot::default() {
        writeln!(f, "\n[foot]")?;
        writeln!(f, "radius_m = {:?}", foot.radius)?;
    }
    if *ground != Ground::default() {
        write_ground(f, ground)?;
    }
    write_environment(f, environment)?;
    write_errors(f, errors)
}

fn write_body(f: &mut Formatter<'_>, body: &Body) -> fmt::Result {
    writeln!(f, "\n[body]")?;
    writeln!(f, "mass_kg = {:?}", body.mass)?;
    writeln!(f, "inertia_kg_m2 = {:?}", body.inertia)?;
    writeln!(f, "wheel_radius_m = {:?}", body.radius)?;
    writeln!(f, "legs = {}", body.legs)?;
    if (body.imbalance, body.imbalance_angle) != (0.0, 0.0) {
        writeln!(f, "imbalance_m = {:?}", body.imbalance)?;
        writeln!(f, "imbalance_angle_rad = {:?}", body.imbalance_angle)?;
    }
    if body.axle_friction != 0.0 {
        writeln!(f, "axle_friction_n_m = {:?}", body.axle_friction)?;
    }
    Ok(())
}

fn write_boom(f: &mut Formatter<'_>, boom: &Boom) -> fmt::Result {
    writeln!(f, "\n[boom]")?;
    writeln!(f, "mass_kg = {:?}", boom.mass)?;
    writeln!(f, "length_m = {:?}", boom.length)?;
    writeln!(f, "radius_m = {:?}", boom.radius)?;
    if let Some(stiffness) = boom.flex {
        writeln!(f, "bending_stiffness_n_m_per_rad = {stiffness:?}")?;
    }
    if let Some(counterweight) = &boom.counterweight {
        writeln!(f, "\n[boom.counterweight]")?;
        writeln!(f, "mass_kg = {:?}", counterweight.mass)?;
        writeln!(f, "distance_m = {:?}", counterweight.distance)?;
    }
    Ok(())
}

fn write_ground(f: &mut Formatter<'_>, ground: &Ground) -> fmt::Result {
    writeln!(f, "\n[ground]")?;
    writeln!(f, "static_friction = {:?}", ground.static_friction)?;
    writeln!(f, "kinetic_friction = {:?}", ground.kinetic_friction)?;
    writeln!(f, "across_friction = {:?}", ground.across_friction)?;
    writeln!(f, "restitution = {:?}", ground.restitution)?;
    if let Some(stiffness) = ground.stiffness {
        writeln!(f, "stiffness_n_per_m = {stiffness:?}")?;
    }
    writeln!(f, "damping_n_s_per_m = {:?}", ground.damping)?;
    writeln!(f, "slope_rad = {:?}", ground.slope)
}

fn write_leg(f: &mut Formatter<'_>, leg: &Leg) -> fmt::Result {
    let (kind, delay) = match leg.drive {
        Drive::Pneumatic(_) => ("pneumatic", "valve_delay_s"),
        Drive::Spring { .. } => ("spring", "release_delay_s"),
        Drive::Constant { .. } => ("constant", "release_delay_s"),
        Drive::Table(_) => ("table", "release_delay_s"),
    };
    writeln!(f, "\n[leg]")?;
    writeln!(f, "kind = {}", quoted(kind))?;
    writeln!(f, "stroke_m = {:?}", leg.stroke)?;
    writeln!(f, "{delay} = {:?}", leg.delay)?;
    writeln!(f, "viscous_friction_n_s_per_m = {:?}", leg.viscous_friction)?;
    writeln!(f, "coulomb_friction_n = {:?}", leg.coulomb_friction)?;
    if leg.body != LegBody::default() {
        writeln!(f, "mass_kg = {:?}", leg.body.mass)?;
        writeln!(f, "center_m = {:?}", leg.body.center)?;
        writeln!(f, "rod_length_m = {:?}", leg.body.length)?;
        writeln!(f, "rod_radius_m = {:?}", leg.body.radius)?;
    }
    match &leg.drive {
        Drive::Pneumatic(cylinder) => write_cylinder(f, cylinder)?,
        Drive::Spring {
            stiffness,
            compression,
        } => {
            writeln!(f, "stiffness_n_per_m = {stiffness:?}")?;
            writeln!(f, "compression_m = {compression:?}")?;
        }
        Drive::Constant { force } => writeln!(f, "force_n = {force:?}")?,
        Drive::Table(table) => write_table(f, table)?,
    }
    if let Some(spring) = &leg.return_spring {
        writeln!(f, "\n[leg.return_spring]")?;
        writeln!(f, "stiffness_n_per_m = {:?}", spring.stiffness)?;
        writeln!(f, "preload_n = {:?}", spring.preload)?;
    }
    if let Some(cushion) = &leg.cushion {
        writeln!(f, "\n[leg.cushion]")?;
        writeln!(f, "length_m = {:?}", cushion.length)?;
        writeln!(f, "stiffness_n_per_m = {:?}", cushion.stiffness)?;
        writeln!(f, "damping_n_s_per_m = {:?}", cushion.damping)?;
    }
    Ok(())
}

fn write_cylinder(f: &mut Formatter<'_>, cylinder: &Cylinder) -> fmt::Result {
    let gas = cylinder.gas;
    writeln!(f, "bore_m = {:?}", cylinder.bore)?;
    writeln!(f, "dead_volume_m3 = {:?}", cylinder.dead_volume)?;
    writeln!(f, "supply_pressure_gauge_pa = {:?}", cylinder.supply.0)?;
    writeln!(
        f,
        "discharge_coefficient = {:?}",
        cylinder.discharge_coefficient
    )?;
    writeln!(f, "orifice_radius_m = {:?}", cylinder.orifice_radius)?;
    writeln!(
        f,
        "gas = {{ heat_ratio = {:?}, constant_j_per_kg_k = {:?} }}",
        gas.heat_ratio, gas.constant
    )?;
    writeln!(f, "gas_temperature_k = {:?}", cylinder.temperature)?;
    writeln!(f, "supply_droop_pa_s_per_kg = {:?}", cylinder.supply_droop)?;
    writeln!(f, "leak_area_m2 = {:?}", cylinder.leak_area)?;
    writeln!(f, "seal_friction_n_per_pa = {:?}", cylinder.seal_friction)?;
    if let Some(exponent) = cylinder.polytropic_exponent {
        writeln!(f, "polytropic_exponent = {exponent:?}")?;
    }
    if let Some(port) = &cylinder.exhaust_port {
        writeln!(f, "\n[leg.exhaust_port]")?;
        writeln!(f, "position_m = {:?}", port.position)?;
        writeln!(f, "area_m2 = {:?}", port.area)?;
    }
    Ok(())
}

fn write_table(f: &mut Formatter<'_>, table: &ForceTable) -> fmt::Result {
    writeln!(f, "\n[leg.table]")?;
    writeln!(f, "extensions_m = {:?}", table.extensions)?;
    writeln!(f, "speeds_m_s = {:?}", table.speeds)?;
    writeln!(f, "forces_n = [")?;
    // No speeds make no table; the reader says so.
    for row in table.forces.chunks(table.speeds.len().max(1)) {
        writeln!(f, "    {row:?},")?;
    }
    writeln!(f, "]")
}

fn write_environment(f: &mut Formatter<'_>, environment: &Environment) -> fmt::Result {
    writeln!(f, "\n[environment]")?;
    writeln!(f, "gravity_m_s2 = {:?}", environment.gravity)?;
    writeln!(f, "ambient_pressure_pa = {:?}", environment.ambient.0)?;
    writeln!(f, "drag_per_m = {:?}", environment.drag)
}

fn write_errors(f: &mut Formatter<'_>, errors: &Errors) -> fmt::Result {
    writeln!(f, "\n[errors]")?;
    writeln!(f, "rate_rad_s = {:?}", errors.rate)?;
    writeln!(f, "firing_angle_rad = {:?}", errors.firing_angle)?;
    writeln!(f, "valve_open_s = {:?}", errors.valve_open)?;
    writeln!(f, "supply_pressure_pa = {:?}", errors.supply)
}

/// `text` as a TOML string.
fn quoted(text: &str) -> toml::Value {
    toml::Value::String(text.into())
}
