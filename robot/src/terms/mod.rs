//! The table of terms: every number of a robot file, once.
//!
//! Reading and writing robot files, overrides, the page of keys in `robots/README.md`, the causes
//! that a diagnosis can name, the effects that the tests hide and the robots that they draw all
//! follow from it. A new term is an entry there, a field in [`Robot`], and its equation.

mod spec;

pub use spec::{Cause, Fit, Form, Plane, Spec};

use std::f64::consts::FRAC_PI_4;

use spec::{Lens, direct, inverse};

use crate::domain::Domain;
use crate::gas::HEAT_RATIOS;
use crate::units::{
    self, ACCELERATION, ANGLE, ANGULAR_RATE, ANGULAR_STIFFNESS, AREA, CAPACITY, DAMPING, FORCE,
    FORCE_PER_PRESSURE, FORCE_PER_PRESSURE_LENGTH, INERTIA, LENGTH, MASS, NUMBER, PER_LENGTH,
    PRESSURE, PRESSURE_PER_FLOW, STIFFNESS, TEMPERATURE, THERMAL_RESISTANCE, TIME, TORQUE, VOLUME,
};
use crate::{Drive, LegBody, Robot, Sensors};

/// The tables of a robot file, in the order in which files are written.
pub const SECTIONS: [&str; 17] = [
    "body",
    "leg",
    "leg.gas",
    "leg.return_spring",
    "leg.exhaust_port",
    "leg.cushion",
    "leg.muscle",
    "leg.tube",
    "tank",
    "boom",
    "boom.counterweight",
    "struts",
    "foot",
    "ground",
    "environment",
    "errors",
    "sensors",
];

/// Key of the coefficients of a muscle's free contraction (m; the gauge pressure in Pa).
pub(crate) const FREE_CONTRACTION: &str = "free_contraction_m";

/// Counts of an encoder in a turn: a counter of 32 bits holds two thousand turns of the most.
const COUNTS: Domain = Domain::at_least(1.0).up_to(1e6).whole();

/// The part of a robot that a term belongs to, if the robot has it.
macro_rules! part {
    ($r:ident: robot) => {
        Some($r)
    };
    ($r:ident: boom) => {
        $r.boom.as_ref()
    };
    ($r:ident: cylinder) => {
        $r.leg.cylinder()
    };
    ($r:ident: mut robot) => {
        Some($r)
    };
    ($r:ident: mut boom) => {
        $r.boom.as_mut()
    };
    ($r:ident: mut cylinder) => {
        $r.leg.cylinder_mut()
    };
}

/// How a term is found in a robot: whether the robot has the part that it belongs to, its value,
/// and how it is set. Setting a term switches on what is optional on the way to it.
macro_rules! at {
    // A number of a part.
    ($part:ident, $($field:tt).+) => {
        Lens {
            has: |r| part!(r: $part).is_some(),
            get: |r| part!(r: $part).map(|part| part.$($field).+),
            set: |r, x| if let Some(part) = part!(r: mut $part) { part.$($field).+ = x },
        }
    };
    // A number of an optional part of it.
    ($part:ident, $($field:tt).+ => $inner:ident) => {
        Lens {
            has: |r| part!(r: $part).is_some(),
            get: |r| part!(r: $part)?.$($field).+.map(|inner| inner.$inner),
            set: |r, x| if let Some(part) = part!(r: mut $part) {
                part.$($field).+.get_or_insert_default().$inner = x;
            },
        }
    };
    // An optional number.
    (optional $part:ident, $($field:tt).+) => {
        Lens {
            has: |r| part!(r: $part).is_some(),
            get: |r| part!(r: $part)?.$($field).+,
            set: |r, x| if let Some(part) = part!(r: mut $part) { part.$($field).+ = Some(x) },
        }
    };
    // A number of one kind of drive.
    (drive, $pattern:pat => $number:ident) => {
        Lens {
            has: |r| if let $pattern = &r.leg.drive { let _ = $number; true } else { false },
            get: |r| if let $pattern = &r.leg.drive { Some(*$number) } else { None },
            set: |r, x| if let $pattern = &mut r.leg.drive { *$number = x },
        }
    };
}

/// A number of the sensors, which no jump in the plane feels; left out, it is that of
/// [`Sensors::default`].
macro_rules! sensor {
    ($name:ident, $quantity:ident) => {
        Spec::needed(
            concat!("sensors.", stringify!($name)),
            $quantity,
            at!(robot, sensors => $name),
        )
        .without(|_| Some(Sensors::default().$name))
        .beside_plane()
    };
}

macro_rules! terms {
    ($($(#[$doc:meta])+ $name:ident = $spec:expr;)+) => {
        /// A number of a robot file.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[non_exhaustive]
        pub enum Term { $($(#[$doc])+ $name),+ }

        /// What there is to know of each term, in the order in which files are read and written.
        static TABLE: &[Spec] = &[$($spec),+];

        impl Term {
            /// Every term.
            pub const ALL: &[Term] = &[$(Term::$name),+];
        }
    };
}

terms! {
    /// Mass m (kg), with all legs.
    Mass = Spec::positive("body.mass", MASS, at!(robot, body.mass))
        .shown("mass_kg = 2.75", "with all legs")
        .cause("mass", "the mass differs", |r, now| {
            let legs = f64::from(r.body.legs) * r.leg.body.mass;
            direct(now, (0.2 * now + legs, 10.0 * now), 0.01, &[0.85 * now, 1.2 * now])
        })
        .hidden(&[1.9, 3.75]);
    /// Moment of inertia I about the wheel's centre (kg m²), with all legs retracted.
    Inertia = Spec::needed("body.inertia", INERTIA, at!(robot, body.inertia))
        .shown("inertia_kg_m2 = 0.0792", "about the wheel's centre")
        .cause("inertia", "the moment of inertia differs", |r, now| {
            let least = f64::from(r.body.legs) * r.leg.body.inertia_about_axle();
            direct(now, (least + 0.02 * now, 20.0 * now), 5e-4, &[0.7 * now, 1.4 * now])
        })
        .hidden(&[0.03, 0.16]);
    /// Foot to wheel centre with the leg retracted, r_s (m).
    Radius = Spec::positive("body.wheel_radius", LENGTH, at!(robot, body.radius))
        .shown("wheel_radius_m = 0.24", "foot to wheel centre with the leg retracted");
    /// Distance of the wheel's centre of mass from the axle (m).
    Imbalance = Spec::optional("body.imbalance", LENGTH, at!(robot, body.imbalance))
        .shown("imbalance_mm = 1", "centre of mass of the wheel, off the axle")
        .out_of_plane()
        .hidden(&[0.04]);
    /// Direction of that distance (rad), forwards from the leg that jumps.
    ImbalanceAngle = Spec::optional("body.imbalance_angle", ANGLE, at!(robot, body.imbalance_angle))
        .within(|_| Domain::FINITE)
        .shown("imbalance_angle_deg = 30", "where it is, forwards from the leg that jumps")
        .beside_plane();
    /// Dry friction torque of the axle against the wheel's spin (N m).
    AxleFriction = Spec::optional("body.axle_friction", TORQUE, at!(robot, body.axle_friction))
        .shown("axle_friction_n_m = 0.01", "dry torque against the wheel's spin")
        .out_of_plane()
        .cause("axle-friction", "dry friction in the axle brakes the spin", |_, now| {
            direct(now, (0.0, 10.0), 5e-3, &[0.1])
        })
        .hidden(&[1.5]);

    /// Greatest extension of the leg (m).
    Stroke = Spec::positive("leg.stroke", LENGTH, at!(robot, leg.stroke))
        .shown("stroke_m = 0.06", "");
    /// From the command to the first flow or force, t_d (s).
    Delay = Spec::needed("leg.valve_delay", TIME, at!(robot, leg.delay))
        .shown("valve_delay_ms = 10", "on opening, and on closing unless the next key is given")
        .cause("valve-delay", "the valve answers earlier or later than believed", |_, now| {
            direct(now, (0.0, 0.2), 3e-4, &[0.5 * now, now + 4e-3, now + 0.012])
        })
        .hidden(&[0.001, 0.025])
        .drawn_to(1.0);
    /// From the end of the command to the end of the flow (s).
    ClosingDelay = Spec::optional(
        "leg.valve_closing_delay",
        TIME,
        Lens { has: |r| r.leg.cylinder().is_some(), ..at!(optional robot, leg.closing_delay) },
    )
    .without(|r| Some(r.leg.delay))
    .shown("valve_closing_delay_ms = 14", "on closing; left out: as valve_delay")
    .cause("valve-delay", "", |_, now| {
        direct(now, (0.0, 0.2), 3e-4, &[0.5 * now, now + 4e-3, now + 0.012])
    })
    .seen_in(|r| r.leg.closing_delay.is_some());
    /// Time constant of the valve's spool (s).
    SpoolTime = Spec::optional("leg.valve_time_constant", TIME, at!(cylinder, spool_time))
        .shown("valve_time_constant_ms = 1", "of the valve's spool; 0: it switches at once")
        .cause("valve-delay", "the valve's spool takes another time to open and to close", |_, now| {
            direct(now, (0.0, 0.1), 2e-4, &[0.3 * now, 3.0 * now + 1e-3, 5e-3, 0.02])
        })
        .seen_in(|r| r.leg.cylinder().is_some());
    /// Shortest command that the valve follows (s).
    LeastPulse = Spec::optional(
        "leg.least_pulse",
        TIME,
        Lens { has: |r| r.leg.drive.has_valve(), ..at!(robot, leg.least_pulse) },
    )
    .shown("least_pulse_ms = 5", "shortest command that the valve follows; a shorter one does nothing")
    .drawn_to(0.5);
    /// Viscous friction β (N s/m).
    ViscousFriction = Spec::needed("leg.viscous_friction", DAMPING, at!(robot, leg.viscous_friction))
        .shown("viscous_friction_n_s_per_m = 5.28", "")
        .cause("viscous-friction", "friction that grows with speed differs", |_, now| {
            direct(now, (0.0, 2e3), 0.5, &[3.0 * now + 10.0])
        })
        .hidden(&[0.0, 60.0, 60.0])
        .drawn_to(0.3);
    /// Coulomb friction F_f (N).
    CoulombFriction = Spec::needed("leg.coulomb_friction", FORCE, at!(robot, leg.coulomb_friction))
        .shown("coulomb_friction_n = 9.7", "")
        .cause("coulomb-friction", "dry friction differs", |_, now| {
            direct(now, (0.0, 1e3), 0.5, &[2.0 * now + 10.0])
        })
        .hidden(&[0.0, 50.0, 50.0])
        .drawn_to(0.2);
    /// Ratio of specific heats κ.
    HeatRatio = Spec::needed("leg.gas.heat_ratio", NUMBER, at!(cylinder, gas.heat_ratio))
        .within(|_| HEAT_RATIOS);
    /// Specific gas constant R_g (J/(kg K)).
    GasConstant = Spec::positive(GAS_CONSTANT, units::GAS_CONSTANT, at!(cylinder, gas.constant));
    /// Bore diameter (m).
    Bore = Spec::positive("leg.bore", LENGTH, Lens { has: has_piston, ..at!(cylinder, bore) })
        .shown("bore_mm = 19.05", "");
    /// Chamber volume at d = 0, V_0 (m³).
    DeadVolume = Spec::positive("leg.dead_volume", VOLUME, at!(cylinder, dead_volume))
        .shown("dead_volume_cm3 = 5.4", "of the chamber, leg retracted")
        .cause("dead-volume", "the volume of the chamber at rest differs", |_, now| {
            direct(now, (1e-8, 1e-3), 1e-7, &[0.5 * now, 2.0 * now])
        })
        .hidden(&[1.5e-6, 2e-5]);
    /// Supply pressure above ambient (Pa).
    Supply = Spec::needed(SUPPLY, PRESSURE, at!(cylinder, supply.0))
        .within(|_| SUPPLIES.called("a gauge pressure"))
        .shown(
            "supply_pressure_gauge_psi = 120",
            "above ambient; or supply_pressure_absolute_pa",
        );
    /// Discharge coefficient of the valve's orifice C_f.
    DischargeCoefficient =
        Spec::needed("leg.discharge_coefficient", NUMBER, at!(cylinder, discharge_coefficient))
            .within(|_| Domain::POSITIVE.up_to(1.0))
            .shown("discharge_coefficient = 0.54", "of the valve, in (0, 1]")
            .cause("valve-discharge", "the valve lets more or less gas through", |_, now| {
                let starts = [0.75 * now, (1.3 * now).min(1.0)];
                direct(now, (0.02, 1.0), 5e-3, &starts)
            })
            .hidden(&[0.25, 0.95]);
    /// Radius of the valve's orifice (m).
    OrificeRadius = Spec::positive("leg.orifice_radius", LENGTH, at!(cylinder, orifice_radius))
        .shown("orifice_radius_mm = 1.02", "of the valve");
    /// Gas temperature T (K).
    Temperature = Spec::positive("leg.gas_temperature", TEMPERATURE, at!(cylinder, temperature))
        .shown("gas_temperature_k = 293.15", "");
    /// Fall of the supply pressure with the mass flow drawn (Pa s/kg).
    SupplyDroop = Spec::optional("leg.supply_droop", PRESSURE_PER_FLOW, at!(cylinder, supply_droop))
        .shown("supply_droop_pa_s_per_kg = 1e6", "fall of the supply pressure with the mass flow drawn")
        .cause("supply-droop", "the supply pressure falls with the flow that is drawn", |_, now| {
            direct(now, (0.0, 1e9), 1e6, &[5e6, 5e7])
        })
        .hidden(&[1.2e8])
        .drawn_to(0.3);
    /// Effective area of an orifice from the chamber to the atmosphere, always open (m²).
    LeakArea = Spec::optional("leg.leak_area", AREA, at!(cylinder, leak_area))
        .shown("leak_area_mm2 = 0.1", "effective area, chamber to atmosphere, always open")
        .cause("chamber-leak", "the chamber leaks to the atmosphere", |_, now| {
            direct(now, (0.0, 1e-4), 2e-8, &[2e-7, 1e-6])
        })
        .hidden(&[5e-7])
        .drawn_to(0.3);
    /// Exponent n in the chamber's equation in place of κ.
    PolytropicExponent =
        Spec::optional("leg.polytropic_exponent", NUMBER, at!(optional cylinder, polytropic_exponent))
            .within(|r| Domain::at_least(1.0).up_to(heat_ratio(r)))
            .without(|r| Some(heat_ratio(r)))
            .shown("polytropic_exponent = 1.3", "in [1, heat_ratio]; left out: adiabatic")
            .cause("heat-transfer", "gas and wall exchange heat", |r, now| {
                direct(now, (1.0, heat_ratio(r)), 5e-3, &[1.2])
            })
            .hidden(&[1.0]);
    /// Coulomb friction of the seal for each pascal of the chamber's gauge pressure (N/Pa).
    SealFriction = Spec::optional(
        "leg.seal_friction",
        FORCE_PER_PRESSURE,
        Lens { has: has_piston, ..at!(cylinder, seal_friction) },
    )
        .shown(
            "seal_friction_n_per_pa = 1e-5",
            "or in _mm2: Coulomb friction for each pascal of gauge pressure",
        )
        .cause(
            "seal-friction",
            "friction of the seal grows with the pressure in the chamber",
            |_, now| direct(now, (0.0, 1e-2), 1e-6, &[1e-5]),
        )
        .hidden(&[1.4e-4])
        .drawn_to(0.2);
    /// Stiffness of a spring leg (N/m).
    SpringStiffness = Spec::positive(
        "leg.stiffness",
        STIFFNESS,
        at!(drive, Drive::Spring { stiffness, .. } => stiffness),
    );
    /// Compression of a spring leg at d = 0 (m).
    Compression = Spec::positive(
        "leg.compression",
        LENGTH,
        at!(drive, Drive::Spring { compression, .. } => compression),
    );
    /// Force of a leg of constant force (N).
    Force = Spec::positive("leg.force", FORCE, at!(drive, Drive::Constant { force } => force));
    /// Length of a leg's moving part (m), a cylinder along the leg.
    RodLength = Spec::optional("leg.rod_length", LENGTH, at!(robot, leg.body.length))
        .shown("rod_length_m = 0.1", "of its moving part, a cylinder along the leg")
        .beside_plane();
    /// Radius of a leg's moving part (m).
    RodRadius = Spec::optional("leg.rod_radius", LENGTH, at!(robot, leg.body.radius))
        .shown("rod_radius_mm = 7", "")
        .beside_plane();
    /// From the axle to the centre of mass of a leg's moving part (m), leg retracted.
    LegCenter = Spec::optional("leg.center", LENGTH, at!(robot, leg.body.center))
        .without(|r| (r.leg.body.mass == 0.0).then_some(0.0))
        .shown(
            "center_m = 0.19",
            "from the axle to that part's centre of mass, leg retracted; needed with a mass",
        )
        .beside_plane();
    /// Mass of a leg's moving part (kg).
    LegMass = Spec::optional("leg.mass", MASS, at!(robot, leg.body.mass))
        .within(leg_mass)
        .shown("mass_kg = 0.05", "mass of that part, counted in body.mass")
        .out_of_plane();

    /// Mass of the leg that the robot picks up at the end of the stroke, in the planar model (kg).
    PickedUp = Spec::optional("leg.picked_up_mass", MASS, at!(robot, leg.picked_up))
        .within(|r| Domain::NON_NEGATIVE.below(r.body.mass))
        .shown(
            "picked_up_mass_kg = 0.05",
            "what lies on the ground until the leg reaches its stop; only for the planar model",
        );

    /// Stiffness of the spring that pulls the leg back in (N/m).
    ReturnStiffness = Spec::needed(
        "leg.return_spring.stiffness",
        STIFFNESS,
        at!(robot, leg.return_spring => stiffness),
    )
    .shown("stiffness_n_per_m = 50", "")
    .cause("return-spring", "a spring pulls the rod back", |_, now| {
        direct(now, (0.0, 1e5), 10.0, &[200.0, 20.0])
    })
    .drawn_to(0.3);
    /// Force of that spring at d = 0 (N).
    ReturnPreload =
        Spec::needed("leg.return_spring.preload", FORCE, at!(robot, leg.return_spring => preload))
            .shown("preload_n = 2", "")
            .cause("return-spring", "", |_, now| direct(now, (0.0, 500.0), 0.5, &[1.0, 10.0]))
            .drawn_to(0.2);

    /// Extension from which the exhaust port is open (m).
    PortPosition = Spec::needed(
        "leg.exhaust_port.position",
        LENGTH,
        Lens { has: has_piston, ..at!(cylinder, exhaust_port => position) },
    )
    .within(|r| Domain::POSITIVE.below(r.leg.stroke))
    .shown("position_mm = 55", "")
    .cause(
        "exhaust-port",
        "the chamber opens to the atmosphere before the end of the stroke",
        |r, _| {
            let stroke = r.leg.stroke;
            let starts = [0.9, 0.8, 0.65, 0.45].map(|part| part * stroke);
            direct(stroke, (0.05 * stroke, 0.999 * stroke), 5e-4, &starts)
        },
    )
    .seen_in(|r| r.leg.cylinder().is_some_and(|c| c.exhaust_port.is_none()));
    /// Effective area of the exhaust port (m²).
    PortArea = Spec::positive("leg.exhaust_port.area", AREA, Lens { has: has_piston, ..at!(cylinder, exhaust_port => area) })
        .shown("area_mm2 = 20", "effective")
        .cause("exhaust-port", "", |_, _| direct(0.0, (1e-8, 1e-3), 5e-6, &[2e-5]))
    .seen_in(|r| r.leg.cylinder().is_some_and(|c| c.exhaust_port.is_none()));

    /// Force of a muscle at full length for each pascal (N/Pa).
    MuscleForce = Spec::positive(
        "leg.muscle.force",
        FORCE_PER_PRESSURE,
        Lens { has: has_muscle, ..at!(cylinder, muscle => force) },
    );
    /// Its fall with the contraction at full length, for each pascal (N/(Pa m)).
    MuscleSlope = Spec::needed(
        "leg.muscle.slope",
        FORCE_PER_PRESSURE_LENGTH,
        Lens { has: has_muscle, ..at!(cylinder, muscle => slope) },
    )
    .within(muscle_slope);
    /// Contraction of muscle and tendon for each metre that the leg extends.
    MuscleLever = Spec::optional(
        "leg.muscle.lever",
        NUMBER,
        Lens { has: has_muscle, ..at!(cylinder, muscle => lever) },
    )
    .within(|_| Domain::POSITIVE)
    .without(|_| Some(1.0));
    /// Stiffness of the tendon in series with the muscle (N/m).
    TendonStiffness = Spec::optional(
        "leg.muscle.tendon_stiffness",
        STIFFNESS,
        Lens { has: has_muscle, ..at!(cylinder, muscle => tendon_stiffness) },
    )
    .within(|_| Domain::POSITIVE.or_infinite())
    .without(|_| Some(f64::INFINITY))
    .cause("series-spring", "what is in series with the actuator is softer or stiffer", |_, now| {
        let compliance = 1.0 / now;
        Fit {
            neutral: compliance,
            ..inverse("leg.muscle.tendon_m_per_n", (0.0, 0.01), 2e-6, &[3e-5, 3e-4])
        }
    });

    /// Length of the tube between valve and chamber (m).
    TubeLength = Spec::needed("leg.tube.length", LENGTH, at!(cylinder, tube => length))
        .shown("length_m = 0.5", "0: no tube")
        .cause("tube", "the tube between valve and actuator has another volume or resistance", |_, now| {
            direct(now, (0.02 * now, 50.0 * now), 0.02 * now, &[0.5 * now, 2.0 * now])
        })
        .seen_in(has_tube);
    /// Inner diameter of that tube (m).
    TubeDiameter = Spec::positive("leg.tube.diameter", LENGTH, at!(cylinder, tube => diameter))
        .shown("diameter_mm = 4", "inside")
        .cause("tube", "", |_, now| {
            direct(now, (0.25 * now, 4.0 * now), 0.01 * now, &[0.7 * now, 1.4 * now])
        })
        .seen_in(has_tube);
    /// Height of the roughness of its wall (m).
    TubeRoughness = Spec::optional("leg.tube.roughness", LENGTH, at!(cylinder, tube => roughness))
        .within(|r| {
            let diameter = r.leg.cylinder().and_then(|c| c.tube).map_or(0.0, |tube| tube.diameter);
            Domain::NON_NEGATIVE.up_to(0.05 * diameter).because(", a twentieth of its diameter")
        })
        .shown("roughness_mm = 0.01", "of its wall; 0: smooth");

    /// Volume of the tank (m³).
    TankVolume = Spec::needed(
        "tank.volume",
        CAPACITY,
        Lens { has: |r| r.leg.cylinder().is_some(), ..at!(robot, tank => volume) },
    )
    .within(|_| Domain::POSITIVE.or_infinite())
    .shown("volume_l = 0.4", "all legs draw on it; inf: it does not empty")
    .cause("tank", "the pressure of the tank falls otherwise while gas is drawn", |_, now| {
        direct(now, (0.05 * now, 20.0 * now), 0.01 * now, &[0.6 * now, 1.7 * now])
    })
    .seen_in(has_tank);
    /// Thermal resistance between the tank's gas and its wall (K/W).
    TankWall = Spec::optional(
        "tank.wall_resistance",
        THERMAL_RESISTANCE,
        Lens { has: |r| r.leg.cylinder().is_some(), ..at!(robot, tank => wall_resistance) },
    )
    .within(|_| Domain::NON_NEGATIVE.or_infinite())
    .without(|_| Some(f64::INFINITY))
    .shown(
        "wall_resistance_k_per_w = 5",
        "heat from the wall, at gas_temperature; 0: isothermal; inf or left out: adiabatic",
    )
    .cause("tank", "the pressure of the tank falls otherwise while gas is drawn", |_, now| {
        let conductance = 1.0 / now;
        Fit {
            neutral: conductance,
            ..inverse("tank.wall_w_per_k", (0.0, 1e3), 0.05, &[1.0, 10.0])
        }
    })
    .seen_in(|r| has_tank(r) && r.tank.is_some_and(|tank| tank.wall_resistance > 0.0));

    /// Length of the end-stop cushion (m).
    CushionLength =
        Spec::needed("leg.cushion.length", LENGTH, at!(robot, leg.cushion => length))
            .within(|r| Domain::POSITIVE.below(r.leg.stroke))
            .shown("length_mm = 4", "");
    /// Stiffness of the cushion (N/m).
    CushionStiffness =
        Spec::needed("leg.cushion.stiffness", STIFFNESS, at!(robot, leg.cushion => stiffness))
            .shown("stiffness_n_per_m = 1e4", "")
            .drawn_to(2.0);
    /// Damping of the cushion (N s/m).
    CushionDamping =
        Spec::needed("leg.cushion.damping", DAMPING, at!(robot, leg.cushion => damping))
            .shown("damping_n_s_per_m = 30", "")
            .drawn_to(0.5);

    /// Mass of the boom m_b (kg).
    BoomMass = Spec::needed("boom.mass", MASS, at!(boom, mass))
        .shown("mass_kg = 0.5", "")
        .cause("boom-inertia", "the boom has mass and weight", |_, now| {
            direct(now, (0.0, 20.0), 0.01, &[0.5 * now, 2.0 * now])
        })
        .hidden(&[0.05, 1.8]);
    /// Length of the boom from its base to the axle, L (m).
    BoomLength = Spec::positive("boom.length", LENGTH, at!(boom, length))
        .shown("length_m = 2.12", "base to axle");
    /// Radius of the boom's cylinder (m).
    BoomRadius = Spec::optional("boom.radius", LENGTH, at!(boom, radius))
        .shown("radius_mm = 15", "")
        .beside_plane();
    /// Bending stiffness of the boom, as that of a hinge halfway (N m/rad).
    BoomFlex = Spec::optional("boom.bending_stiffness", ANGULAR_STIFFNESS, at!(optional boom, flex))
        .within(|_| Domain::POSITIVE)
        .without(|_| Some(f64::INFINITY))
        .shown("bending_stiffness_n_m_per_rad = 2000", "of a hinge halfway; left out: rigid")
        .out_of_plane()
        .cause("boom-flex", "the boom bends", |_, _| {
            // The boom swings with a phase of its own at each stiffness, so that the loss has many
            // minima.
            let starts: Vec<f64> = (0..20).map(|k| 1e-4 * 1.28_f64.powi(k)).collect();
            inverse("boom_compliance_rad_per_n_m", (5e-5, 0.05), 2e-5, &starts)
        })
    .seen_in(|r| r.boom.is_some_and(|boom| boom.flex.is_none()));
    /// Damping of the bend over its stiffness (s).
    BoomFlexTime = Spec::optional("boom.bending_damping_time", TIME, at!(boom, flex_time))
        .shown("bending_damping_time_ms = 1", "damping of the bend over its stiffness")
        .beside_plane()
        .cause("boom-flex", "", |_, now| direct(now, (0.0, 0.01), 2e-4, &[5e-4; 20]))
    .seen_in(|r| r.boom.is_some_and(|boom| boom.flex.is_none()));
    /// Distance of the counterweight behind the boom's base, l (m).
    CounterweightDistance = Spec::positive(
        "boom.counterweight.distance",
        LENGTH,
        at!(boom, counterweight => distance),
    )
    .shown("distance_m = 0.4", "")
    .cause("counterweight", "a counterweight carries a part of the weight", |_, _| {
        direct(0.5, (0.05, 3.0), 0.05, &[0.5])
    })
    .seen_in(|r| r.boom.is_some_and(|boom| boom.counterweight.is_none()));
    /// Mass of the counterweight, m_c (kg).
    CounterweightMass =
        Spec::needed("boom.counterweight.mass", MASS, at!(boom, counterweight => mass))
            .within(counterweight_mass)
            .shown("mass_kg = 0.2", "at most what balances robot and boom")
            .cause("counterweight", "", |_, _| direct(0.0, (0.0, 20.0), 0.02, &[0.3, 1.5]))
    .seen_in(|r| r.boom.is_some_and(|boom| boom.counterweight.is_none()));

    /// Distance of the struts' joints from the axle, along each leg (m).
    StrutDistance = Spec::needed("struts.distance", LENGTH, at!(robot, struts => distance))
        .within(|r| {
            let domain = Domain::POSITIVE.up_to(r.body.radius);
            domain.because(", which is body.wheel_radius")
        })
        .shown("distance_m = 0.14", "from the axle, along each leg, to their joints")
        .beside_plane();
    /// Radius of a strut (m).
    StrutRadius = Spec::optional("struts.radius", LENGTH, at!(robot, struts => radius))
        .shown("radius_mm = 5", "of a bar")
        .beside_plane();

    /// Radius of the sphere at a foot that touches the ground (m).
    FootRadius = Spec::optional("foot.radius", LENGTH, at!(robot, foot.radius))
        .shown("radius_mm = 7", "of the sphere that touches the ground; 0: a point")
        .out_of_plane()
        .cause(
            "foot-rolling",
            "the foot rolls on the ground instead of turning about a point",
            |_, now| direct(now, (0.0, 0.1), 5e-4, &[0.01]),
        )
        .hidden(&[0.05]);

    /// Friction coefficient along the travel until a foot slips.
    StaticFriction =
        Spec::optional("ground.static_friction", NUMBER, at!(robot, ground.static_friction))
            .within(|_| Domain::NON_NEGATIVE.or_infinite())
            .without(|_| Some(f64::INFINITY))
            .shown("static_friction = 0.9", "coefficient along the travel; inf or left out: no slip")
            .out_of_plane();
    /// Friction coefficient along the travel while a foot slips.
    KineticFriction =
        Spec::optional("ground.kinetic_friction", NUMBER, at!(robot, ground.kinetic_friction))
            .within(|_| Domain::NON_NEGATIVE.or_infinite())
            .without(|r| Some(r.ground.static_friction))
            .shown("kinetic_friction = 0.7", "once it slips; left out: as static")
            .beside_plane();
    /// Friction coefficient across the travel, slipping or not.
    AcrossFriction =
        Spec::optional("ground.across_friction", NUMBER, at!(robot, ground.across_friction))
            .shown("across_friction = 0.1", "coefficient across the travel, slipping or not")
            .beside_plane()
            .cause(
                "across-friction",
                "the ground rubs on the foot across the travel",
                |_, now| direct(now, (0.0, 5.0), 0.02, &[0.1, 0.5]),
            )
            .seen_in(|r| r.boom.is_some())
            .hidden(&[2.0]);
    /// Coefficient of restitution of a foot's impact.
    Restitution = Spec::optional("ground.restitution", NUMBER, at!(robot, ground.restitution))
        .within(|_| Domain::NON_NEGATIVE.below(1.0))
        .shown("restitution = 0.2", "of a foot's impact, in [0, 1)")
        .beside_plane();
    /// Stiffness of the ground (N/m).
    GroundStiffness =
        Spec::optional("ground.stiffness", STIFFNESS, at!(optional robot, ground.stiffness))
            .within(|_| Domain::POSITIVE)
            .without(|_| Some(f64::INFINITY))
            .shown("stiffness_n_per_m = 1e5", "left out: rigid")
            .out_of_plane()
            .cause("ground-compliance", "the ground gives way under the foot", |_, _| {
                // A robot of 3 kg sinks in by 1 cm at most.
                let starts = [1e-4, 1e-4, 3e-5, 3e-5, 1e-5, 1e-5, 3e-6, 3e-6, 1e-6, 1e-6];
                inverse("ground_compliance_m_per_n", (5e-7, 3e-4), 2e-6, &starts)
            });
    /// Damping of the ground where it is not rigid (N s/m).
    GroundDamping = Spec::optional("ground.damping", DAMPING, at!(robot, ground.damping))
        .shown("damping_n_s_per_m = 100", "where it is not rigid")
        .beside_plane()
        .cause("ground-compliance", "", |_, now| {
            direct(now, (0.0, 600.0), 20.0, &[30.0, 300.0].repeat(5))
        });
    /// Slope along the travel (rad), uphill positive.
    Slope = Spec::optional("ground.slope", ANGLE, at!(robot, ground.slope))
        .within(|_| Domain::above(-FRAC_PI_4).below(FRAC_PI_4))
        .shown("slope_deg = 2", "of the floor under a level boom, uphill positive, less than 45°")
        .out_of_plane()
        .cause("ground-slope", "the floor slopes under a level boom", |_, now| {
            direct(now, (-0.6, 0.6), 2e-3, &[now - 0.05, now + 0.05])
        });
    /// Slope (rad) of the ground with all that is bolted to it, uphill positive.
    Tilt = Spec::optional("ground.tilt", ANGLE, at!(robot, ground.tilt))
        .within(|_| Domain::above(-FRAC_PI_4).below(FRAC_PI_4))
        .shown(
            "tilt_deg = 2",
            "slope of the floor with the boom's base and the zero of all angles",
        )
        .out_of_plane()
        .cause(
            "ground-slope",
            "the floor slopes with all that is bolted to it",
            |_, now| direct(now, (-0.6, 0.6), 2e-3, &[now - 0.05, now + 0.05]),
        )
        .hidden(&[0.1]);

    /// Gravity g (m/s²).
    Gravity = Spec::needed("environment.gravity", ACCELERATION, at!(robot, environment.gravity))
        .shown("gravity_m_s2 = 9.80665", "")
        .cause("gravity", "the acceleration of free fall differs", |_, now| {
            direct(now, (0.2, 40.0), 0.02, &[0.9 * now, 1.1 * now])
        })
        .hidden(&[8.3, 11.3]);
    /// Ambient pressure P_a (Pa).
    Ambient = Spec::positive("environment.ambient_pressure", PRESSURE, at!(robot, environment.ambient.0))
        .shown("ambient_pressure_pa = 101325", "absolute");
    /// Drag per mass in flight, c in −c |v| v (1/m).
    Drag = Spec::optional("environment.drag", PER_LENGTH, at!(robot, environment.drag))
        .shown("drag_per_m = 0.01", "c in −c |v| v")
        .cause("air-drag", "the air brakes the body", |_, now| {
            direct(now, (0.0, 10.0), 5e-3, &[0.1])
        })
        .hidden(&[0.3]);

    /// Standard deviation of the approach rate (rad/s).
    RateError = Spec::optional("errors.rate", ANGULAR_RATE, at!(robot, errors.rate))
        .shown("rate_rad_s = 0.06", "");
    /// Standard deviation of the firing angle (rad).
    FiringAngleError = Spec::optional("errors.firing_angle", ANGLE, at!(robot, errors.firing_angle))
        .shown("firing_angle_deg = 0.15", "");
    /// Standard deviation of the valve opening time (s).
    ValveOpenError = Spec::optional("errors.valve_open", TIME, at!(robot, errors.valve_open))
        .shown("valve_open_ms = 0.3", "");
    /// Standard deviation of the supply pressure (Pa).
    SupplyError = Spec::optional("errors.supply_pressure", PRESSURE, at!(robot, errors.supply))
        .shown("supply_pressure_psi = 2", "");

    /// Counts of the wheel's encoder in a turn, after quadrature.
    WheelCounts = sensor!(wheel_counts, NUMBER)
        .within(|_| COUNTS)
        .shown("wheel_counts = 2000", "of the encoder in a turn, after quadrature, up to 1e6; left out: 800");
    /// Counts of the encoder of the boom's turn in a turn, after quadrature.
    RadiusCounts = sensor!(radius_counts, NUMBER)
        .within(|_| COUNTS)
        .shown("radius_counts = 4000", "the same of the boom's turn; left out: 1600");
    /// Counts of the encoder of the boom's pivot in a turn, after quadrature.
    PivotCounts = sensor!(pivot_counts, NUMBER)
        .within(|_| COUNTS)
        .shown("pivot_counts = 4000", "the same of the boom's pivot; left out: 1600");
    /// Greatest rate that the fine gyro reads (rad/s).
    FineGyroRange = sensor!(fine_gyro_range, ANGULAR_RATE)
        .within(|_| Domain::POSITIVE)
        .shown("fine_gyro_range_deg_s = 300", "it reads up to ± this rate; left out: 573 °/s");
    /// Greatest rate that the coarse gyro reads (rad/s).
    CoarseGyroRange = sensor!(coarse_gyro_range, ANGULAR_RATE)
        .within(|_| Domain::POSITIVE)
        .shown("coarse_gyro_range_deg_s = 2000", "left out: 1500 °/s");
    /// Standard deviation of a sample of the gyros (rad/s).
    GyroNoise = sensor!(gyro_noise, ANGULAR_RATE)
        .shown("gyro_noise_rad_s = 0.1", "one standard deviation of a sample; left out: 0");
    /// What the gyros read at rest (rad/s).
    GyroBias = sensor!(gyro_bias, ANGULAR_RATE)
        .within(|_| Domain::FINITE)
        .shown("gyro_bias_rad_s = 0.02", "what it reads at rest; left out: 0");
    /// Greatest acceleration that the fine accelerometer reads (m/s²).
    FineAccelerometerRange = sensor!(fine_accelerometer_range, ACCELERATION)
        .within(|_| Domain::POSITIVE)
        .shown("fine_accelerometer_range_g = 4", "it reads up to ± this; left out: 2 g");
    /// Greatest acceleration that the coarse accelerometer reads (m/s²).
    CoarseAccelerometerRange = sensor!(coarse_accelerometer_range, ACCELERATION)
        .within(|_| Domain::POSITIVE)
        .shown("coarse_accelerometer_range_g = 100", "left out: 50 g");
    /// Distance of the accelerometers from the axle (m).
    AccelerometerRadius = sensor!(accelerometer_radius, LENGTH)
        .shown("accelerometer_radius_mm = 50", "distance from the axle; left out: 0");
    /// Standard deviation of a sample of the accelerometers (m/s²).
    AccelerometerNoise = sensor!(accelerometer_noise, ACCELERATION)
        .shown("accelerometer_noise_m_s2 = 0.1", "one standard deviation of a sample; left out: 0");
    /// What the accelerometers read beside the acceleration (m/s²).
    AccelerometerBias = sensor!(accelerometer_bias, ACCELERATION)
        .within(|_| Domain::FINITE)
        .shown("accelerometer_bias_m_s2 = 0.05", "left out: 0");
    /// Bits of the converter that reads gyros and accelerometers.
    ConverterBits = sensor!(converter_bits, NUMBER)
        .within(|_| Domain::at_least(4.0).up_to(24.0).whole())
        .shown(
            "converter_bits = 12",
            "of the converter of gyros and accelerometers, from 4 to 24; left out: 16",
        );
    /// Cycles of the loop from a reading to the output that follows from it.
    OutputDelayCycles = sensor!(output_delay_cycles, NUMBER)
        .within(|_| Domain::at_least(0.0).up_to(1.0).whole())
        .shown(
            "output_delay_cycles = 1",
            "cycles from a reading to its output, 0 or 1; left out: 0",
        );
    /// Period of the loop that reads the sensors (s).
    LoopPeriod = sensor!(period, TIME)
        .within(|_| Domain::POSITIVE.up_to(0.1))
        .shown("period_ms = 5", "of the loop, at most 100 ms; left out: 1 ms");
    /// Distance of the farthest obstacle that the range sensor sees (m).
    RangeReach = sensor!(range_reach, LENGTH)
        .within(|_| Domain::POSITIVE)
        .shown("range_reach_m = 3", "farthest obstacle that the range sensor sees; left out: 4 m");
    /// Standard deviation of a reading of the range sensor (m).
    RangeNoise = sensor!(range_noise, LENGTH)
        .shown("range_noise_mm = 10", "one standard deviation of a reading; left out: 0");
    /// Time from one reading of the range sensor to the next (s).
    RangePeriod = sensor!(range_period, TIME)
        .within(|_| Domain::POSITIVE)
        .shown("range_period_ms = 100", "from one reading to the next; left out: 50 ms");
}

/// What a supply pressure may be (Pa): no material holds more.
pub(crate) const SUPPLIES: Domain = Domain::NON_NEGATIVE.up_to(1e10);

/// The key of the supply pressure above ambient; files may give the absolute one in its place.
pub(crate) const SUPPLY: &str = "leg.supply_pressure_gauge";

/// The key of the gas constant; files may give the molar mass in its place.
pub(crate) const GAS_CONSTANT: &str = "leg.gas.constant";

fn heat_ratio(robot: &Robot) -> f64 {
    robot.leg.cylinder().map_or(1.0, |c| c.gas.heat_ratio)
}

fn has_muscle(robot: &Robot) -> bool {
    robot.leg.cylinder().is_some_and(|c| c.muscle.is_some())
}

fn has_piston(robot: &Robot) -> bool {
    robot.leg.cylinder().is_some_and(|c| c.muscle.is_none())
}

fn has_tank(robot: &Robot) -> bool {
    robot.tank.is_some_and(|tank| tank.volume.is_finite())
}

fn has_tube(robot: &Robot) -> bool {
    let cylinder = robot.leg.cylinder();
    cylinder.is_some_and(|c| c.tube.is_some_and(|tube| tube.length > 0.0))
}

/// The slopes of a muscle that does not push before its free contraction.
fn muscle_slope(robot: &Robot) -> Domain {
    let most = robot.leg.cylinder().and_then(|c| {
        let muscle = c.muscle?;
        let end = muscle.greatest_free_contraction(c.supply.0);
        (end > 0.0).then(|| 3.0 * muscle.force / end)
    });
    Domain::NON_NEGATIVE
        .up_to(most.unwrap_or(0.0))
        .because(", 3 times the force over the free contraction: a muscle does not push")
}

/// The masses (kg) that the legs of a robot may have: they leave some mass and inertia to the wheel.
fn leg_mass(robot: &Robot) -> Domain {
    let legs = f64::from(robot.body.legs);
    let unit = LegBody {
        mass: 1.0,
        ..robot.leg.body
    };
    let by_mass = robot.body.mass / legs;
    let by_inertia = robot.body.inertia / (legs * unit.inertia_about_axle());
    // Legs without inertia (0/0) bound nothing.
    let (most, reason) = if by_inertia <= by_mass {
        (by_inertia, ", for all legs to have less than body.inertia")
    } else {
        (by_mass, ", for all legs to have less than body.mass")
    };
    let domain = if most > 0.0 {
        Domain::NON_NEGATIVE.below(most)
    } else {
        Domain::NON_NEGATIVE.up_to(0.0)
    };
    domain.because(reason)
}

/// The masses (kg) of a counterweight that do not lift the robot.
fn counterweight_mass(robot: &Robot) -> Domain {
    let balance = robot.boom.map_or(0.0, |boom| {
        let distance = boom.counterweight.unwrap_or_default().distance;
        (robot.body.mass + 0.5 * boom.mass) * boom.length / distance
    });
    Domain::NON_NEGATIVE
        .up_to(balance)
        .because(", which balances robot and boom")
}
