//! Random robots and launches.
//!
//! [`ordinary`] robots can jump, or nearly: their numbers are drawn around scales that fit
//! together. [`legal`] robots are anything that a robot file admits.

use std::f64::consts::{FRAC_PI_2, PI};

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use saltus_lagrangian::Launch;
use saltus_robot::terms::Plane;
use saltus_robot::{
    AbsolutePressure, Body, Boom, Counterweight, Cushion, Cylinder, Drive, Environment,
    ExhaustPort, ForceTable, Gas, GaugePressure, Leg, ReturnSpring, Robot, Term,
};

/// What pushes, and which of the optional terms may be on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A pneumatic leg without optional terms.
    Plain,
    /// A pneumatic leg with any of them.
    Pneumatic,
    /// A released spring, with the leg's optional terms.
    Spring,
    /// A constant force, with the leg's optional terms.
    Constant,
    /// A force table, with the leg's optional terms.
    Table,
}

impl Kind {
    /// Every kind.
    pub const ALL: [Kind; 5] = [
        Kind::Plain,
        Kind::Pneumatic,
        Kind::Spring,
        Kind::Constant,
        Kind::Table,
    ];
}

/// `cases` cases from a fixed seed.
pub fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig {
        rng_seed: RngSeed::Fixed(1),
        failure_persistence: None,
        ..ProptestConfig::with_cases(cases)
    }
}

/// Numbers in [0, 1), taken one after the other; after the last come halves.
struct Draw(std::vec::IntoIter<f64>);

impl Draw {
    fn unit(&mut self) -> f64 {
        self.0.next().unwrap_or(0.5)
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// From 2 to 4.
    fn count(&mut self) -> usize {
        let thirds = self.unit();
        2 + [1.0 / 3.0, 2.0 / 3.0]
            .iter()
            .filter(|third| thirds > **third)
            .count()
    }

    /// Evenly distributed in the logarithm.
    fn scale(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.unit())
    }

    /// 0 as often as not, else up to `most`.
    fn perhaps(&mut self, most: f64) -> f64 {
        let on = self.unit() < 0.5;
        let x = self.unit();
        if on { 0.0 } else { most * x }
    }

    fn option<T>(&mut self, some: impl FnOnce(&mut Draw) -> T) -> Option<T> {
        let on = self.unit() < 0.4;
        let x = some(self);
        on.then_some(x)
    }
}

/// A robot of `kind` that can jump, or nearly, from any of its parameters at 0.
pub fn ordinary(kind: Kind) -> impl Strategy<Value = Robot> {
    prop::collection::vec(0.0..1.0, 64)
        .prop_map(move |units| robot(kind, &mut Draw(units.into_iter())))
}

/// As [`ordinary`], of any kind.
pub fn any_ordinary() -> impl Strategy<Value = Robot> {
    prop::sample::select(&Kind::ALL[..]).prop_flat_map(ordinary)
}

/// `robots` on booms of up to three times their mass, some with a counterweight that takes part of
/// the weight.
pub fn on_boom(robots: impl Strategy<Value = Robot>) -> impl Strategy<Value = Robot> {
    (robots, prop::collection::vec(0.0..1.0, 8)).prop_map(|(mut robot, units)| {
        let mut draw = Draw(units.into_iter());
        let mass = draw.between(0.0, 3.0) * robot.body.mass;
        let length = draw.scale(1.0, 30.0) * robot.body.radius;
        let counterweight = draw.option(|d| {
            let distance = d.scale(0.1, 1.0) * length;
            let moment = (robot.body.mass + 0.5 * mass) * length;
            Counterweight {
                mass: d.between(0.0, 0.7) * moment / distance,
                distance,
            }
        });
        robot.boom = Some(Boom {
            mass,
            length,
            counterweight,
            ..Boom::default()
        });
        robot
    })
}

/// A launch that suits `robot`: from rest to a little faster than the ground can hold, leans of all
/// sizes, mostly small.
pub fn launch(robot: &Robot) -> impl Strategy<Value = Launch> + use<> {
    let top = (robot.axle_gravity() / robot.body.radius).sqrt();
    let time = stroke_time(robot);
    let lean = || prop_oneof![3 => -0.4..0.4, 1 => -1.5..1.5];
    let rate = prop_oneof![1 => Just(0.0), 6 => 0.0..1.1 * top];
    let firing = prop_oneof![1 => Just(None), 2 => lean().prop_map(Some)];
    (rate, lean(), firing, 0.0..4.0 * time).prop_map(|(rate, lean, firing, valve_open)| Launch {
        rate,
        lean,
        firing_angle: firing.unwrap_or(lean),
        valve_open,
    })
}

/// A robot with a launch that suits it.
pub fn jump(robots: impl Strategy<Value = Robot>) -> impl Strategy<Value = (Robot, Launch)> {
    robots.prop_flat_map(|robot| {
        let launch = launch(&robot);
        (Just(robot), launch)
    })
}

/// About the time (s) that the drive needs for a stroke.
pub fn stroke_time(robot: &Robot) -> f64 {
    let force = match &robot.leg.drive {
        Drive::Pneumatic(c) => c.supply.0 * PI / 4.0 * c.bore * c.bore,
        Drive::Spring {
            stiffness,
            compression,
        } => stiffness * compression,
        Drive::Constant { force } => *force,
        Drive::Table(table) => table.forces.iter().copied().fold(0.0, f64::max),
    };
    (2.0 * robot.leg.stroke * robot.axle_mass() / force).sqrt()
}

/// Numbers of a robot that fit together, by which its other numbers are measured.
struct Scales {
    stroke: f64,
    /// Force of the drive (N), and the time (s) that it needs for a stroke.
    force: f64,
    time: f64,
    /// Gauge pressure (Pa) of the supply, area (m²) of a piston that gives the force, effective
    /// area (m²) of the valve, and the flow (kg/s) through it.
    supply: f64,
    piston: f64,
    valve: f64,
    flow: f64,
}

impl Scales {
    /// What is natural for a quantity, by its SI unit.
    fn natural(&self, unit: &str) -> f64 {
        match unit {
            "s" => self.time,
            "N" => self.force,
            "N/m" => self.force / self.stroke,
            "N s/m" => self.force * self.time / self.stroke,
            "m²" => self.valve,
            "N/Pa" => self.piston,
            "Pa s/kg" => self.supply / self.flow,
            _ => panic!("no natural size in {unit}"),
        }
    }
}

fn robot(kind: Kind, draw: &mut Draw) -> Robot {
    let (mass, radius) = (draw.scale(0.05, 200.0), draw.scale(0.05, 1.0));
    let gravity = draw.scale(1.6, 25.0);
    let inertia = draw.perhaps(1.5) * mass * radius * radius;
    let stroke = radius * draw.scale(0.03, 0.9);
    // The force of the drive from three times the weight on, and the time that it needs for a
    // stroke.
    let force = mass * gravity * draw.scale(3.0, 150.0);
    let time = (2.0 * stroke * mass / force).sqrt();
    let is_plain = kind == Kind::Plain;
    let return_spring = draw.option(|_| ReturnSpring::default());
    let cushion = draw.option(|d| Cushion {
        length: d.between(0.05, 0.5) * stroke,
        ..Cushion::default()
    });
    let ambient = AbsolutePressure(draw.scale(1e4, 3e5));
    let mut scales = Scales {
        stroke,
        force,
        time,
        supply: draw.scale(3e4, 3e6),
        piston: f64::NAN,
        valve: f64::NAN,
        flow: f64::NAN,
    };
    let mut robot = Robot {
        name: "random".into(),
        body: Body {
            mass,
            inertia,
            radius,
            legs: 1,
            ..Body::default()
        },
        leg: Leg {
            stroke,
            return_spring: return_spring.filter(|_| !is_plain),
            cushion: cushion.filter(|_| !is_plain),
            drive: match kind {
                Kind::Plain | Kind::Pneumatic => {
                    Drive::Pneumatic(cylinder(is_plain, draw, &mut scales, ambient))
                }
                Kind::Spring => {
                    let compression = stroke * draw.between(0.5, 3.0);
                    Drive::Spring {
                        stiffness: force / compression,
                        compression,
                    }
                }
                Kind::Constant => Drive::Constant { force },
                Kind::Table => Drive::Table(force_table(draw, stroke, force, time)),
            },
            ..Leg::default()
        },
        environment: Environment {
            gravity,
            ambient,
            drag: 0.0,
        },
        ..Robot::default()
    };
    for term in Term::ALL.iter().filter(|t| t.spec().drawn_to > 0.0) {
        let is_optional = term.off(&robot).is_some();
        if term.of(&robot).is_some() && !(is_plain && is_optional) {
            let most = term.spec().drawn_to * scales.natural(term.spec().quantity.si);
            term.set(&mut robot, draw.perhaps(most));
        }
    }
    robot
}

/// A cylinder of about the force in `scales`, which learn of it.
fn cylinder(
    is_plain: bool,
    draw: &mut Draw,
    scales: &mut Scales,
    ambient: AbsolutePressure,
) -> Cylinder {
    let supply = scales.supply;
    let area = scales.force / supply;
    let dead_volume = area * scales.stroke * draw.scale(0.02, 2.0);
    let gas = match draw.unit() {
        x if x < 0.3 => Gas::AIR,
        x if x < 0.5 => Gas::CO2,
        x if x < 0.7 => Gas::NITROGEN,
        _ => Gas {
            heat_ratio: draw.between(1.05, 1.67),
            constant: draw.scale(50.0, 4000.0),
        },
    };
    let temperature = draw.between(150.0, 600.0);
    // The valve fills the extended leg in about the time of a stroke.
    let volume = dead_volume + area * scales.stroke;
    let heat = gas.constant * temperature;
    let effective =
        draw.scale(0.2, 5.0) * supply * volume / (scales.time * heat.sqrt() * (supply + ambient.0));
    let discharge_coefficient = draw.between(0.2, 1.0);
    scales.piston = area;
    scales.valve = effective;
    scales.flow = effective * (supply + ambient.0) / heat.sqrt();
    let exhaust_port = draw.option(|d| ExhaustPort {
        position: d.between(0.2, 0.95) * scales.stroke,
        area: d.scale(0.3, 5.0) * effective,
    });
    let polytropic_exponent = draw.option(|d| d.between(1.0, gas.heat_ratio));
    Cylinder {
        bore: (4.0 * area / PI).sqrt(),
        dead_volume,
        supply: GaugePressure(supply),
        discharge_coefficient,
        orifice_radius: (effective / discharge_coefficient / PI).sqrt(),
        gas,
        temperature,
        exhaust_port: exhaust_port.filter(|_| !is_plain),
        polytropic_exponent: polytropic_exponent.filter(|_| !is_plain),
        ..Cylinder::default()
    }
}

#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "0, 1 or 2"
)]
fn force_table(draw: &mut Draw, stroke: f64, force: f64, time: f64) -> ForceTable {
    let rows = draw.count();
    let columns = draw.count();
    let reach = draw.between(1.0, 1.3) * stroke;
    let extensions: Vec<f64> = (0..rows)
        .map(|i| reach * (i as f64 / (rows - 1) as f64).powf(1.2))
        .collect();
    let speeds: Vec<f64> = (0..columns)
        .map(|j| 2.0 * stroke / time * j as f64 / (columns - 1) as f64)
        .collect();
    let forces = extensions
        .iter()
        .flat_map(|_| {
            let start = draw.between(0.6, 1.2);
            let fall = draw.between(0.0, 0.5);
            let last = (columns - 1) as f64;
            (0..columns).map(move |j| force * (start - fall * j as f64 / last))
        })
        .collect();
    ForceTable {
        extensions,
        speeds,
        forces,
    }
}

/// Any finite number > 0, from the smallest to the greatest.
fn positive() -> impl Strategy<Value = f64> {
    use proptest::num::f64::{NORMAL, POSITIVE, SUBNORMAL};
    prop_oneof![
        2 => (POSITIVE | NORMAL | SUBNORMAL).prop_map(f64::abs),
        3 => (-12.0..12.0_f64).prop_map(|exponent| 10_f64.powf(exponent)),
    ]
}

/// Any robot that a robot file admits: an ordinary one, in which from one number to all are
/// replaced by any legal ones.
pub fn legal() -> impl Strategy<Value = Robot> {
    let chance = prop_oneof![Just(0.05), Just(0.3), Just(1.0)];
    // Some more than there are terms, for a force table.
    let wild = prop::collection::vec(
        (0.0..1.0_f64, prop_oneof![1 => Just(0.0), 6 => positive()]),
        Term::ALL.len() + 16,
    );
    (any_ordinary(), chance, wild).prop_map(|(mut robot, chance, wild)| {
        let (terms, table) = wild.split_at(Term::ALL.len());
        let lucky = |(luck, x): &(f64, f64)| (*luck < chance).then_some(*x);
        for (term, wild) in Term::ALL.iter().zip(terms) {
            let (spec, now) = (term.spec(), term.of(&robot));
            // A part that is not there stays away, and errors have no place in a jump.
            if spec.plane != Plane::In || spec.section() == "errors" || now.is_none() {
                continue;
            }
            let domain = term.domain(&robot);
            let legal = lucky(wild).filter(|x| domain.contains(*x));
            // What depends on other numbers is moved with them.
            let moved = now.filter(|now| !domain.contains(*now)).map(|_| {
                let (low, high) = domain.bounds();
                low.midpoint(high)
            });
            legal
                .or(moved)
                .into_iter()
                .for_each(|x| term.set(&mut robot, x));
        }
        let stroke = robot.leg.stroke;
        if let Drive::Table(forces) = &mut robot.leg.drive {
            forces.extensions = vec![0.0, stroke];
            forces.forces.truncate(2 * forces.speeds.len());
            for (i, (force, wild)) in forces.forces.iter_mut().zip(table).enumerate() {
                let sign = if i % 3 == 1 { -1.0 } else { 1.0 };
                *force = sign * lucky(wild).unwrap_or(*force);
            }
        }
        if let (Some(mass), Some(length)) = (lucky(&table[14]), lucky(&table[15]))
            && length > 0.0
        {
            robot.boom = Some(Boom {
                mass,
                length,
                ..Boom::default()
            });
        }
        robot
    })
}

/// Any launch at all: also such as no robot can be given.
pub fn any_launch() -> impl Strategy<Value = Launch> {
    let number = || {
        prop_oneof![
            2 => any::<f64>(),
            1 => prop::num::f64::ANY,
            1 => prop::sample::select(&ODD[..]),
            3 => -2.0..2.0,
        ]
    };
    (number(), number(), number(), number()).prop_map(|(rate, lean, firing_angle, valve_open)| {
        Launch {
            rate,
            lean,
            firing_angle,
            valve_open,
        }
    })
}

/// A launch inside its domain, also at its edges.
pub fn legal_launch() -> impl Strategy<Value = Launch> {
    let edge = FRAC_PI_2.next_down();
    let angle = move || {
        prop_oneof![
            8 => -FRAC_PI_2..FRAC_PI_2,
            1 => prop::sample::select(vec![0.0, -0.0, edge, -edge, 1e-300, -1e-300, 5e-324, 1e-9]),
        ]
    };
    let positive = || {
        prop_oneof![
            4 => 0.0..10.0,
            2 => (-300.0..3.0_f64).prop_map(|exponent| 10_f64.powf(exponent)),
            1 => prop::sample::select(vec![0.0, -0.0, 5e-324, 1e3]),
        ]
    };
    (positive(), angle(), prop::option::of(angle()), positive()).prop_map(
        |(rate, lean, angle, valve_open)| Launch {
            rate,
            lean,
            firing_angle: angle.unwrap_or(lean),
            valve_open,
        },
    )
}

/// Numbers that break things.
const ODD: [f64; 12] = [
    0.0,
    -0.0,
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MAX,
    f64::MIN,
    f64::MIN_POSITIVE,
    5e-324,
    FRAC_PI_2,
    -FRAC_PI_2,
    1e3,
];
