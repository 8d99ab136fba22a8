//! Numbers that a robot may have and that look like a slip of unit.

use std::f64::consts::PI;
use std::fmt;

use crate::terms::Plane;
use crate::{Cylinder, Drive, Robot, Term};

/// A number of a robot that is legal and hardly meant.
#[derive(Clone, Debug, PartialEq)]
pub struct Implausible {
    /// Dotted key of the robot file.
    pub key: &'static str,
    /// Its value (the unit that the key ends with).
    pub value: f64,
    /// What is odd about it.
    pub why: String,
    /// The unit in which it would not be odd, or several.
    pub units: &'static str,
}

impl fmt::Display for Implausible {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Implausible {
            key,
            value,
            why,
            units,
        } = self;
        write!(f, "{key} = {} {why}: is it in {units}?", short(*value))
    }
}

/// Density (kg/m³) above that of every metal.
const DENSEST: f64 = 23_000.0;
/// Supply pressures (Pa, gauge) between which pneumatic legs are: weaker than a breath, stronger
/// than a full gas bottle.
const SUPPLY: (f64, f64) = (1e3, 2e7);
/// Pressures (Pa) of the surroundings: of Mars, of ten atmospheres.
const AMBIENT: (f64, f64) = (500.0, 1e6);
/// Gravity (m/s²) that no planet of the sun has.
const GRAVITY: f64 = 50.0;
/// Delay (s) of the slowest valve.
const DELAY: f64 = 1.0;
/// Gas temperature (K) at which air is nearly liquid.
const COLD: f64 = 100.0;
/// Length (m) of a boom, and radius (m) of a wheel, that no laboratory holds.
const HALL: f64 = 50.0;

/// Adds each number that is odd: key, value, whether it is, and why, and in which unit it would not
/// be.
macro_rules! odd {
    ($all:ident, $($key:expr, $value:expr, $is_odd:expr => $why:expr, $units:expr;)+) => {
        $(if $is_odd {
            $all.push(Implausible { key: $key, value: $value, why: $why.into(), units: $units });
        })+
    };
}

/// Volume (m³) of a ball.
fn ball(radius: f64) -> f64 {
    4.0 / 3.0 * PI * radius.powi(3)
}

impl Robot {
    /// Numbers that look like a slip of unit; none for most robots.
    ///
    /// All of them are legal: a model takes what is written.
    ///
    /// # Example
    /// ```
    /// use saltus_robot::resolve;
    /// let robot = resolve("rats-planar", &["leg.stroke_m=5".into()])?;
    /// assert_eq!(
    ///     robot.implausible()[0].to_string(),
    ///     "leg.stroke_m = 5 is longer than the wheel is wide (0.48 m): is it in cm or mm?",
    /// );
    /// # Ok::<(), saltus_robot::RobotError>(())
    /// ```
    pub fn implausible(&self) -> Vec<Implausible> {
        let mut all = Vec::new();
        self.body_and_leg(&mut all);
        self.surroundings(&mut all);
        if let Drive::Pneumatic(cylinder) = &self.leg.drive {
            self.cylinder(cylinder, &mut all);
        }
        all
    }

    fn body_and_leg(&self, all: &mut Vec<Implausible>) {
        let foot = self.foot.radius;
        let (mass, radius, inertia) = (self.body.mass, self.body.radius, self.body.inertia);
        let (stroke, delay, width) = (self.leg.stroke, self.leg.delay, 2.0 * radius);
        let rim = mass * radius * radius;
        let heavy = format!(
            "is more than a wheel of {} m radius can hold",
            short(radius)
        );
        let beyond = format!(
            "is more than that of all mass on the rim ({} kg m²)",
            short(rim)
        );
        let long = format!("is longer than the wheel is wide ({} m)", short(width));
        odd! { all,
            "body.wheel_radius_m", radius, radius > HALL => "is larger than any hall", "cm or mm";
            "body.mass_kg", mass, mass > DENSEST * ball(radius) => heavy, "g";
            // The margin is for rounding of a hoop.
            "body.inertia_kg_m2", inertia, inertia > (1.0 + 1e-6) * rim
                => beyond, "g m², kg mm² or g cm²";
            "leg.stroke_m", stroke, stroke > width => long, "cm or mm";
            "foot.radius_m", foot, foot > 0.5 * radius => "is more than half of a leg", "mm";
            self.delay_key(), delay, delay > DELAY => "is slow for a valve or latch", "ms";
        }
    }

    fn surroundings(&self, all: &mut Vec<Implausible>) {
        let (gravity, ambient) = (self.environment.gravity, self.environment.ambient.0);
        let is_thick = !(AMBIENT.0..=AMBIENT.1).contains(&ambient);
        let length = self.boom.map_or(0.0, |boom| boom.length);
        odd! { all,
            "environment.gravity_m_s2", gravity, gravity > GRAVITY
                => "is more than on any planet", "cm/s²";
            "environment.ambient_pressure_pa", ambient, is_thick
                => "is far from one atmosphere (101325 Pa)", "kPa, bar or psi";
            "boom.length_m", length, length > HALL => "is longer than any hall", "cm or mm";
        }
    }

    fn cylinder(&self, cylinder: &Cylinder, all: &mut Vec<Implausible>) {
        let (supply, bore, kelvin) = (cylinder.supply.0, cylinder.bore, cylinder.temperature);
        let (orifice, volume) = (cylinder.orifice_radius, cylinder.dead_volume);
        let radius = self.body.radius;
        let has_bore = cylinder.muscle.is_none();
        let (key, is_weak) = (
            "leg.supply_pressure_gauge_pa",
            supply > 0.0 && supply < SUPPLY.0,
        );
        odd! { all,
            key, supply, is_weak => "is too weak to push", "kPa, bar or psi";
            key, supply, supply > SUPPLY.1 => "is more than a gas bottle holds", "a smaller unit";
            "leg.bore_m", bore, bore > 2.0 * radius => "is wider than the wheel", "mm";
            "leg.orifice_radius_m", orifice, has_bore && orifice > bore
                => "is wider than the cylinder", "mm";
            "leg.dead_volume_m3", volume, volume > ball(radius)
                => "is more than the wheel holds", "cm³";
            "leg.gas_temperature_k", kelvin, kelvin < COLD => "is colder than gas", "°C";
        }
    }

    fn delay_key(&self) -> &'static str {
        if matches!(self.leg.drive, Drive::Pneumatic(_)) {
            "leg.valve_delay_s"
        } else {
            "leg.release_delay_s"
        }
    }

    /// Keys of the robot file that are set and that the planar model of a planner leaves out; the
    /// multi-body simulation has them.
    ///
    /// Not named are those that a jump in the plane hardly feels. The length of a boom is named for the arc on
    /// which it leads the robot; its mass at the axle is in the planar model.
    pub fn beyond_the_plane(&self) -> Vec<String> {
        let is_on = |term: &&Term| {
            let value = term.of(self);
            term.spec().plane == Plane::Out && value.is_some() && value != term.off(self)
        };
        let terms = Term::ALL.iter().filter(is_on);
        let arc = self.boom.map(|_| Term::BoomLength.key(self));
        terms.map(|term| term.key(self)).chain(arc).collect()
    }
}

/// A number with few digits.
fn short(x: f64) -> String {
    let rounded: f64 = format!("{x:.3e}").parse().unwrap_or(x);
    if (1e-4..1e6).contains(&rounded.abs()) {
        rounded.to_string()
    } else {
        format!("{rounded:e}")
    }
}

#[cfg(test)]
mod tests {
    use crate::{Robot, resolve};

    #[test]
    fn a_slip_of_unit_is_seen() {
        let check = |set: &str, key: &str| {
            let robot = resolve("rats-boom", &[set.into()]).expect("a legal robot");
            let keys: Vec<&str> = robot.implausible().iter().map(|odd| odd.key).collect();
            assert_eq!(keys, [key], "{set}");
        };
        check("body.mass_kg=2750", "body.mass_kg");
        check("body.inertia_kg_m2=13000", "body.inertia_kg_m2");
        check("leg.stroke_m=6", "leg.stroke_m");
        check("leg.valve_delay_s=10", "leg.valve_delay_s");
        check(
            "leg.supply_pressure_gauge_psi=1e6",
            "leg.supply_pressure_gauge_pa",
        );
        check(
            "leg.supply_pressure_gauge_pa=120",
            "leg.supply_pressure_gauge_pa",
        );
        check("leg.bore_m=19.05", "leg.bore_m");
        check("leg.orifice_radius_m=1.0215", "leg.orifice_radius_m");
        check("leg.dead_volume_m3=5.4", "leg.dead_volume_m3");
        check("leg.gas_temperature_k=20", "leg.gas_temperature_k");
        check("environment.gravity_m_s2=981", "environment.gravity_m_s2");
        check(
            "environment.ambient_pressure_pa=101.325",
            "environment.ambient_pressure_pa",
        );
        check("boom.length_m=2120", "boom.length_m");
    }

    #[test]
    fn built_in_robots_are_plausible_and_mostly_planar() {
        for name in Robot::builtin_names() {
            let robot = Robot::builtin(name).expect("built in");
            let beyond: &[&str] = match name {
                "rats-boom" => &["leg.mass_kg", "boom.length_m"],
                "rats-run" => &[
                    "leg.mass_kg",
                    "foot.radius_m",
                    "ground.static_friction",
                    "boom.length_m",
                ],
                "rats-twelve" => &[
                    "leg.mass_kg",
                    "foot.radius_m",
                    "ground.static_friction",
                    "ground.stiffness_n_per_m",
                ],
                _ => &[],
            };
            assert_eq!(robot.implausible(), vec![], "{name}");
            assert_eq!(robot.beyond_the_plane(), beyond, "{name}");
        }
    }

    #[test]
    fn a_hoop_is_plausible() {
        let rim = 2.75 * 0.24 * 0.24;
        let robot =
            resolve("rats-planar", &[format!("body.inertia_kg_m2={rim}")]).expect("a legal robot");
        assert_eq!(robot.implausible(), vec![]);
    }
}
