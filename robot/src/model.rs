//! A robot as the models see it: plain numbers in SI units.

use saltus_numeric::Scalar;

use crate::{Gas, Space, Term};

/// Absolute pressure (Pa), > 0. Gauge pressures are [`GaugePressure`]; the two never mix without an
/// ambient pressure.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct AbsolutePressure(pub f64);

/// Pressure above the ambient one (Pa).
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct GaugePressure(pub f64);

impl GaugePressure {
    /// Absolute pressure (Pa) where the surroundings are at `ambient`.
    pub fn absolute(self, ambient: AbsolutePressure) -> AbsolutePressure {
        AbsolutePressure(self.0 + ambient.0)
    }
}

/// A robot that rolls onto a leg and fires it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Robot {
    /// What it is called.
    pub name: String,
    /// The wheel with all that turns with it.
    pub body: Body,
    /// The leg that jumps.
    pub leg: Leg,
    /// What it has that moves freely in space; none: it moves in its plane.
    pub space: Option<Space>,
    /// The tank that feeds all its legs; none: a regulated supply, which does not empty.
    pub tank: Option<Tank>,
    /// The boom that holds the axle; none: the robot moves freely in its plane, or in space.
    pub boom: Option<Boom>,
    /// The bars between the tubes of neighbouring legs, if there are any.
    pub struts: Option<Struts>,
    /// The tip of each leg.
    pub foot: Foot,
    /// What the feet stand on.
    pub ground: Ground,
    /// What surrounds the robot.
    pub environment: Environment,
    /// Measurement and actuation errors, one standard deviation each, behind the error bands.
    pub errors: Errors,
    /// What a running robot measures with; none: its file does not say, and
    /// [`Sensors::default`] stands in.
    pub sensors: Option<Sensors>,
}

impl Robot {
    /// Mass (kg) that the axle accelerates, and gravity (m/s²) that pulls at it, ≥ 0: m and g, and
    /// with a boom M = m + m_b/3 + m_c (l/L)² and g (m + m_b/2 − m_c l/L)/M.
    ///
    /// The boom is taken as level: docs/model.md says what that leaves out. The axle falls at that
    /// gravity, and their product is what stands on a foot at rest. `lift` turns the value of a term
    /// into a number of the wanted kind.
    pub fn at_axle<S: Scalar>(&self, lift: impl Fn(Term, f64) -> S) -> (S, S) {
        let mass = lift(Term::Mass, self.body.mass);
        let gravity = lift(Term::Gravity, self.environment.gravity);
        let Some(boom) = &self.boom else {
            return (mass, gravity);
        };
        let beam = lift(Term::BoomMass, boom.mass);
        let (mut inertial, mut weighing) = (beam / S::of(3.0), beam / S::of(2.0));
        if let Some(weight) = &boom.counterweight {
            let lever = lift(Term::CounterweightDistance, weight.distance)
                / lift(Term::BoomLength, boom.length);
            let weight = lift(Term::CounterweightMass, weight.mass);
            inertial = inertial + weight * (lever * lever);
            weighing = weighing - weight * lever;
        }
        let inertial = mass + inertial;
        // A counterweight that balances the robot may be off by round-off, and nothing falls
        // upwards.
        let weight = mass + weighing.max(-mass);
        (inertial, gravity * (weight / inertial))
    }

    /// Mass (kg) that the axle accelerates: see [`at_axle`](Self::at_axle).
    pub fn axle_mass(&self) -> f64 {
        self.at_axle(|_, x| x).0
    }

    /// Gravity (m/s²) that pulls at the axle, ≥ 0: see [`at_axle`](Self::at_axle).
    pub fn axle_gravity(&self) -> f64 {
        self.at_axle(|_, x| x).1
    }

    /// c = m g r_s/(I + m r_s²) (1/s²): on a retracted leg a lean φ accelerates by c sin φ.
    ///
    /// Source: docs/model.md, Stance.
    pub fn pendulum(&self) -> f64 {
        let (mass, radius) = (self.axle_mass(), self.body.radius);
        mass * self.axle_gravity() * radius / (self.body.inertia + mass * radius * radius)
    }

    /// Mass (kg) of the wheel without its legs, > 0.
    pub fn wheel_mass(&self) -> f64 {
        self.body.mass - f64::from(self.body.legs) * self.leg.body.mass
    }

    /// Moment of inertia (kg m²) about the axle of the wheel without its legs, ≥ 0.
    pub fn wheel_inertia(&self) -> f64 {
        self.body.inertia - f64::from(self.body.legs) * self.leg.body.inertia_about_axle()
    }
}

/// The wheel with all its legs, retracted, which turn with it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Body {
    /// Mass m (kg), > 0; of it, the legs' part is [`Leg::body`].
    pub mass: f64,
    /// Moment of inertia I about the wheel's centre (kg m²), ≥ 0; in space the mean about three axes.
    pub inertia: f64,
    /// Foot to wheel centre with the leg retracted, r_s (m), > 0; also the wheel's radius.
    pub radius: f64,
    /// Legs, evenly spaced around the wheel, or in space as [`Space::directions`] says, ≥ 1.
    pub legs: u32,
    /// Distance of the wheel's centre of mass from the axle (m), ≥ 0.
    pub imbalance: f64,
    /// Where around the axle that centre is (rad), forwards from the leg that jumps.
    pub imbalance_angle: f64,
    /// Dry friction torque of the axle against the wheel's spin (N m), ≥ 0.
    pub axle_friction: f64,
}

/// A telescoping leg: what drives it and what resists.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Leg {
    /// Greatest extension d (m), > 0.
    pub stroke: f64,
    /// From the command to the first flow or force, t_d (s), ≥ 0; the same on closing, unless
    /// `closing_delay` says otherwise.
    pub delay: f64,
    /// From the end of the command to the end of the flow (s), ≥ 0; none: as `delay`.
    pub closing_delay: Option<f64>,
    /// Shortest command that the valve follows (s), ≥ 0: a shorter one does nothing.
    pub least_pulse: f64,
    /// Mass (kg) at rest on the ground that the robot picks up as its leg reaches its stop, ≥ 0;
    /// for the planar model, which has no other mass of a leg.
    pub picked_up: f64,
    /// Viscous friction β (N s/m), ≥ 0.
    pub viscous_friction: f64,
    /// Coulomb friction F_f (N), ≥ 0.
    pub coulomb_friction: f64,
    /// Spring that pulls the leg back in: −(k d + preload).
    pub return_spring: Option<ReturnSpring>,
    /// Cushion before the end of the stroke.
    pub cushion: Option<Cushion>,
    /// What pushes.
    pub drive: Drive,
    /// Mass and shape of the part that moves.
    pub body: LegBody,
}

/// The moving part of a leg, rod and foot, as a solid cylinder along the leg; of no mass by
/// default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LegBody {
    /// Mass (kg), ≥ 0.
    pub mass: f64,
    /// Distance of its centre of mass from the axle with the leg retracted (m), ≥ 0.
    pub center: f64,
    /// Length L of the cylinder (m), ≥ 0.
    pub length: f64,
    /// Radius r of the cylinder (m), ≥ 0.
    pub radius: f64,
}

impl LegBody {
    /// Moment of inertia (kg m²) about its centre of mass, across the leg: m (3 r² + L²)/12.
    pub fn inertia(&self) -> f64 {
        self.mass * (3.0 * self.radius * self.radius + self.length * self.length) / 12.0
    }

    /// Moment of inertia (kg m²) about the axle with the leg retracted.
    pub fn inertia_about_axle(&self) -> f64 {
        self.inertia() + self.mass * self.center * self.center
    }
}

impl Leg {
    /// From the command to the first flow into the chamber, or the first force (s): the delay of the
    /// valve, and the time that a pressure wave takes through the tube.
    pub fn opening_delay(&self) -> f64 {
        self.delay + self.travel_time()
    }

    /// From the end of the command to the end of the flow (s), the same way.
    pub fn shutting_delay(&self) -> f64 {
        self.closing_delay.unwrap_or(self.delay) + self.travel_time()
    }

    /// Time (s) that a pressure wave takes through the tube between valve and chamber; 0 without.
    fn travel_time(&self) -> f64 {
        self.cylinder().map_or(0.0, Cylinder::travel_time)
    }

    /// Its cylinder, if it is pneumatic.
    pub fn cylinder(&self) -> Option<&Cylinder> {
        match &self.drive {
            Drive::Pneumatic(cylinder) => Some(cylinder),
            _ => None,
        }
    }

    /// As [`cylinder`](Self::cylinder), to change it.
    pub fn cylinder_mut(&mut self) -> Option<&mut Cylinder> {
        match &mut self.drive {
            Drive::Pneumatic(cylinder) => Some(cylinder),
            _ => None,
        }
    }
}

/// Return spring: the force −(k d + preload) on the leg's force.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReturnSpring {
    /// Stiffness k (N/m), ≥ 0.
    pub stiffness: f64,
    /// Force at d = 0 (N), ≥ 0.
    pub preload: f64,
}

/// End-stop cushion: −(k (d − d_c) + c ḋ) over the last `length` = stroke − d_c.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cushion {
    /// Length (m), in (0, stroke).
    pub length: f64,
    /// Stiffness k (N/m), ≥ 0.
    pub stiffness: f64,
    /// Damping c (N s/m), ≥ 0.
    pub damping: f64,
}

/// What pushes the leg out.
#[derive(Clone, Debug, PartialEq)]
pub enum Drive {
    /// A pneumatic cylinder behind a three-way valve.
    Pneumatic(Cylinder),
    /// A spring released from compression: k (compression − d), while positive.
    Spring {
        /// Stiffness k (N/m), > 0.
        stiffness: f64,
        /// Compression at d = 0 (m), > 0.
        compression: f64,
    },
    /// A constant force while commanded, none afterwards.
    Constant {
        /// Force (N), > 0.
        force: f64,
    },
    /// A measured force over extension and speed while commanded, none afterwards.
    Table(ForceTable),
}

/// No force.
impl Default for Drive {
    fn default() -> Drive {
        Drive::Constant { force: 0.0 }
    }
}

impl Drive {
    /// Whether the drive is commanded for a time, the valve opening time: a cylinder through its
    /// valve, a motor through its current. A spring is released once and not caught again, so that
    /// no valve opening time belongs to it.
    pub fn has_valve(&self) -> bool {
        !matches!(self, Drive::Spring { .. })
    }
}

/// A pneumatic cylinder: chamber, valve, supply, and the effects that a plain one leaves out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cylinder {
    /// Bore diameter (m), > 0.
    pub bore: f64,
    /// Chamber volume at d = 0, V_0 (m³), > 0.
    pub dead_volume: f64,
    /// Supply pressure above ambient, ≥ 0.
    pub supply: GaugePressure,
    /// Discharge coefficient of the valve's orifice C_f, in (0, 1].
    pub discharge_coefficient: f64,
    /// Radius of the valve's orifice (m), > 0.
    pub orifice_radius: f64,
    /// Gas constants.
    pub gas: Gas,
    /// Gas temperature T (K), > 0.
    pub temperature: f64,
    /// Fall of the supply pressure with the mass flow drawn (Pa s/kg), ≥ 0; 0 is off.
    pub supply_droop: f64,
    /// Effective area C_f A of an orifice from the chamber to the atmosphere, always open (m²), ≥
    /// 0; 0 is off.
    pub leak_area: f64,
    /// Opening to the atmosphere once d passes it.
    pub exhaust_port: Option<ExhaustPort>,
    /// Exponent n in the chamber's equation in place of κ, in [1, κ]; none: adiabatic.
    pub polytropic_exponent: Option<f64>,
    /// Coulomb friction of the seal for each pascal of the chamber's gauge pressure (N/Pa), ≥ 0; 0
    /// is off.
    pub seal_friction: f64,
    /// Time constant of the valve's spool (s), ≥ 0; 0: it switches at once.
    pub spool_time: f64,
    /// The tube between valve and chamber; none: they are one piece.
    pub tube: Option<Tube>,
    /// The muscle in place of a piston; none: a cylinder of that bore.
    pub muscle: Option<Muscle>,
}

impl Cylinder {
    /// Time (s) that a pressure wave takes through the tube: its length over the speed of sound
    /// √(κ R T).
    pub fn travel_time(&self) -> f64 {
        let sound = (self.gas.heat_ratio * self.gas.constant * self.temperature).sqrt();
        self.tube.map_or(0.0, |tube| tube.length / sound)
    }
}

/// A pneumatic muscle that drives a leg: it contracts as the leg extends.
///
/// At full length its pull is `force` p, and falls there by `slope` p for each metre of contraction;
/// it ends, with a slope of 0, at the free contraction, a polynomial in the gauge pressure p.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Muscle {
    /// Force at full length for each pascal (N/Pa), > 0.
    pub force: f64,
    /// Its fall there with the contraction for each pascal (N/(Pa m)), ≥ 0.
    pub slope: f64,
    /// Coefficients of the free contraction (m), lowest power of the gauge pressure (Pa) first; the
    /// first is > 0.
    pub free_contraction: [f64; 5],
    /// Contraction of muscle and tendon for each metre that the leg extends, > 0.
    pub lever: f64,
    /// Stiffness of the tendon in series (N/m), > 0; infinite: none.
    pub tendon_stiffness: f64,
}

/// One without numbers, on a lever of 1 and without a tendon.
impl Default for Muscle {
    fn default() -> Muscle {
        Muscle {
            force: 0.0,
            slope: 0.0,
            free_contraction: [0.0; 5],
            lever: 1.0,
            tendon_stiffness: f64::INFINITY,
        }
    }
}

impl Muscle {
    /// Greatest free contraction (m) between no pressure and a gauge pressure (Pa): on a thousand
    /// points.
    pub fn greatest_free_contraction(&self, pressure: f64) -> f64 {
        const POINTS: u32 = 1000;
        let at = |k: u32| {
            let p = pressure * f64::from(k) / f64::from(POINTS);
            self.free_contraction
                .iter()
                .rev()
                .fold(0.0, |sum, c| sum * p + c)
        };
        (0..=POINTS).map(at).fold(0.0, f64::max)
    }
}

/// A tube between the valve of a leg and its chamber.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tube {
    /// Length (m), ≥ 0; 0: no tube.
    pub length: f64,
    /// Inner diameter (m), > 0.
    pub diameter: f64,
    /// Height of the roughness of its wall (m), ≥ 0; 0: smooth.
    pub roughness: f64,
}

impl Tube {
    /// Volume inside (m³).
    pub fn volume(&self) -> f64 {
        0.25 * std::f64::consts::PI * self.diameter * self.diameter * self.length
    }
}

/// A tank that a robot carries its gas in; at the start it has the leg's supply pressure and gas
/// temperature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tank {
    /// Volume (m³), > 0; infinite: its pressure does not fall.
    pub volume: f64,
    /// Thermal resistance between the gas and the wall, which keeps the gas temperature (K/W), ≥ 0:
    /// 0, the gas is always as warm as the wall; infinite, no heat passes.
    pub wall_resistance: f64,
}

/// One that does not empty.
impl Default for Tank {
    fn default() -> Tank {
        Tank {
            volume: f64::INFINITY,
            wall_resistance: f64::INFINITY,
        }
    }
}

/// An opening to the atmosphere short of the end of the stroke.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ExhaustPort {
    /// Extension from which it is open (m), in (0, stroke).
    pub position: f64,
    /// Effective area C_f A (m²), > 0.
    pub area: f64,
}

/// Measured force over extension and speed, on a full grid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ForceTable {
    /// Extensions (m), strictly increasing, from 0 to at least the stroke; at least 2.
    pub extensions: Vec<f64>,
    /// Speeds (m/s), strictly increasing, from 0; at least 2.
    pub speeds: Vec<f64>,
    /// Force (N) at `extensions[i]`, `speeds[j]`: `forces[i * speeds.len() + j]`.
    pub forces: Vec<f64>,
}

/// A boom that holds the axle at its end: a solid cylinder, on a universal joint at its base.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Boom {
    /// Mass m_b (kg), ≥ 0.
    pub mass: f64,
    /// Length L from the base to the axle (m), > 0.
    pub length: f64,
    /// Radius of the cylinder (m), ≥ 0.
    pub radius: f64,
    /// A mass behind the base.
    pub counterweight: Option<Counterweight>,
    /// Bending stiffness, as that of a hinge halfway (N m/rad), > 0; none: rigid.
    pub flex: Option<f64>,
    /// Damping of the bend over its stiffness (s), ≥ 0.
    pub flex_time: f64,
}

/// A point mass on the boom's line, behind its base.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Counterweight {
    /// Mass m_c (kg), ≥ 0; at most what the robot and its boom weigh there.
    pub mass: f64,
    /// Distance l behind the base (m), > 0.
    pub distance: f64,
}

/// The bars between the tubes of neighbouring legs: solid cylinders, one for each pair, whose mass
/// is part of the wheel's. They turn with the wheel, and nothing of them moves with a leg.
///
/// Source: thesis 3.1 has them without a dimension.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Struts {
    /// Distance of their joints from the axle, along each leg (m), in (0, r_s].
    pub distance: f64,
    /// Radius of a bar (m), ≥ 0; 0: a line.
    pub radius: f64,
}

/// The tip of a leg.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Foot {
    /// Radius of the sphere that touches the ground (m), ≥ 0; 0: a point.
    pub radius: f64,
}

/// What the feet stand on; by default it is rigid, level, inelastic, and lets nothing slip along
/// the travel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// Friction coefficient along the travel until a foot slips, ≥ 0; infinite: no slip.
    pub static_friction: f64,
    /// Friction coefficient along the travel while a foot slips, ≥ 0; infinite: no slip.
    pub kinetic_friction: f64,
    /// Friction coefficient across the travel, slipping or not, ≥ 0.
    pub across_friction: f64,
    /// Coefficient of restitution of a foot's impact, in [0, 1).
    pub restitution: f64,
    /// Stiffness (N/m), > 0; none: rigid.
    pub stiffness: Option<f64>,
    /// Damping (N s/m), ≥ 0, where it is not rigid.
    pub damping: f64,
    /// Slope along the travel (rad), uphill positive, in (−π/4, π/4), under a level boom.
    pub slope: f64,
    /// Slope (rad), uphill positive, in (−π/4, π/4), of the ground with all that is bolted to it:
    /// the boom's base, and the zero of all angles and heights. The direction is that of the
    /// travel at the start.
    pub tilt: f64,
}

impl Default for Ground {
    fn default() -> Ground {
        Ground {
            static_friction: f64::INFINITY,
            kinetic_friction: f64::INFINITY,
            across_friction: 0.0,
            restitution: 0.0,
            stiffness: None,
            damping: 0.0,
            slope: 0.0,
            tilt: 0.0,
        }
    }
}

/// What surrounds the robot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Environment {
    /// Gravity g (m/s²), ≥ 0.
    pub gravity: f64,
    /// Ambient pressure P_a.
    pub ambient: AbsolutePressure,
    /// Drag per mass in flight, c in −c |v| v (1/m), ≥ 0; 0 is off.
    pub drag: f64,
}

/// One standard deviation of what is measured or commanded in a jump; 0 is exact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Errors {
    /// Approach rate ω (rad/s), ≥ 0.
    pub rate: f64,
    /// Firing angle α_f (rad), ≥ 0.
    pub firing_angle: f64,
    /// Valve opening time (s), ≥ 0.
    pub valve_open: f64,
    /// Supply pressure (Pa), ≥ 0.
    pub supply: f64,
}

/// The sensors of a running robot and the loop that reads them.
///
/// By default they are those of the thesis without noise and bias: they count and saturate, and
/// read nothing wrong. Where the thesis gives no number, the field says what stands in.
///
/// Source: thesis 3.2 with table 3.1, and 3.3 for the loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensors {
    /// Counts of the wheel's encoder in a turn, after quadrature, > 0. Default 800: 200 lines.
    pub wheel_counts: f64,
    /// Counts of the encoder of the boom's turn about the vertical (the thesis' radius encoder) in
    /// a turn, after quadrature, > 0. Default 1600: 400 lines.
    pub radius_counts: f64,
    /// Counts of the encoder of the boom's pivot in a turn, after quadrature, > 0. Default 1600.
    pub pivot_counts: f64,
    /// Greatest rate that the fine gyro reads, in either direction (rad/s), > 0. Default 573 °/s.
    pub fine_gyro_range: f64,
    /// The same of the coarse gyro (rad/s), > 0. Default 1500 °/s.
    pub coarse_gyro_range: f64,
    /// Noise of both gyros, one standard deviation of a sample (rad/s), ≥ 0. Default 0; the thesis
    /// gives none.
    pub gyro_noise: f64,
    /// What both gyros read at rest (rad/s), finite. Default 0.
    pub gyro_bias: f64,
    /// Greatest acceleration that the fine accelerometer reads, in either direction (m/s²), > 0.
    /// Default 2 g.
    pub fine_accelerometer_range: f64,
    /// The same of the coarse accelerometer (m/s²), > 0. Default 50 g.
    pub coarse_accelerometer_range: f64,
    /// Distance of both accelerometers from the axle (m), ≥ 0. Default 0; the thesis gives none.
    pub accelerometer_radius: f64,
    /// Noise of both accelerometers, one standard deviation of a sample (m/s²), ≥ 0. Default 0; the
    /// thesis gives none.
    pub accelerometer_noise: f64,
    /// What both accelerometers read beside the acceleration (m/s²), finite. Default 0.
    pub accelerometer_bias: f64,
    /// Bits of the converter that reads gyros and accelerometers, whole, in [4, 24]. Default 16.
    pub converter_bits: f64,
    /// Cycles from the reading to the output that follows from it: 0, in the same cycle, or 1.
    /// Default 0, the sequence of 3.3.
    pub output_delay_cycles: f64,
    /// Period of the loop (s), in (0, 0.1]. Default 1 ms.
    pub period: f64,
    /// Distance of the farthest obstacle that the range sensor sees (m), > 0. The thesis proposes
    /// such a sensor (8.3.1) without a number; default 4 m, an ordinary ultrasonic one.
    pub range_reach: f64,
    /// Noise of the range sensor, one standard deviation of a reading (m), ≥ 0. Default 0.
    pub range_noise: f64,
    /// Time from one reading of the range sensor to the next (s), > 0. Default 50 ms, twice what an
    /// echo takes from 4 m.
    pub range_period: f64,
}

impl Default for Sensors {
    fn default() -> Sensors {
        /// Standard gravity (m/s²), in which makers state the ranges of accelerometers.
        const G: f64 = 9.806_65;
        Sensors {
            wheel_counts: 800.0,
            radius_counts: 1600.0,
            pivot_counts: 1600.0,
            fine_gyro_range: 573_f64.to_radians(),
            coarse_gyro_range: 1500_f64.to_radians(),
            gyro_noise: 0.0,
            gyro_bias: 0.0,
            fine_accelerometer_range: 2.0 * G,
            coarse_accelerometer_range: 50.0 * G,
            accelerometer_radius: 0.0,
            accelerometer_noise: 0.0,
            accelerometer_bias: 0.0,
            converter_bits: 16.0,
            output_delay_cycles: 0.0,
            period: 1e-3,
            range_reach: 4.0,
            range_noise: 0.0,
            range_period: 0.05,
        }
    }
}
