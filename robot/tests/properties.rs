//! Any sound robot survives being written and read; any other text is refused without a panic.

use std::path::Path;

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use saltus_robot::{
    AbsolutePressure, Body, Boom, Counterweight, Cushion, Cylinder, Drive, Environment, Errors,
    ExhaustPort, Foot, ForceTable, Gas, GaugePressure, Ground, Leg, LegBody, ReturnSpring, Robot,
    RobotError, resolve,
};

fn parse(text: &str) -> Result<Robot, RobotError> {
    Robot::parse(text, "robot.toml", Path::new("."))
}

/// Any finite number > 0, down to the smallest and up to the largest.
fn positive() -> impl Strategy<Value = f64> {
    use proptest::num::f64::{NORMAL, POSITIVE, SUBNORMAL};
    (POSITIVE | NORMAL | SUBNORMAL).prop_map(f64::abs)
}

fn non_negative() -> impl Strategy<Value = f64> {
    prop_oneof![1 => Just(0.0), 3 => positive()]
}

/// A stroke and a length short of it.
fn stroke_and_part() -> impl Strategy<Value = (f64, f64)> {
    (positive(), positive())
        .prop_map(|(a, b)| (a.max(b), a.min(b)))
        .prop_filter("a part short of the stroke", |(stroke, part)| part < stroke)
}

/// Two to five numbers, strictly increasing from 0 to at least `reach`.
fn axis(reach: f64) -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(positive(), 0..4).prop_map(move |mut axis| {
        axis.extend([0.0, reach]);
        axis.sort_by(f64::total_cmp);
        axis.dedup();
        axis
    })
}

fn force_table(stroke: f64) -> impl Strategy<Value = ForceTable> {
    (axis(stroke), axis(1.0)).prop_flat_map(|(extensions, speeds)| {
        let force = prop_oneof![positive(), positive().prop_map(|force| -force)];
        prop::collection::vec(force, extensions.len() * speeds.len()).prop_map(move |forces| {
            ForceTable {
                extensions: extensions.clone(),
                speeds: speeds.clone(),
                forces,
            }
        })
    })
}

fn gas() -> impl Strategy<Value = Gas> {
    let any = (
        positive()
            .prop_map(|x| 1.0 + x)
            .prop_filter("κ > 1", |&x| x > 1.0),
        positive(),
    )
        .prop_map(|(heat_ratio, constant)| Gas {
            heat_ratio,
            constant,
        });
    prop_oneof![Just(Gas::AIR), Just(Gas::CO2), Just(Gas::NITROGEN), any]
}

fn cylinder(port: f64) -> impl Strategy<Value = Cylinder> {
    let sizes = (positive(), positive(), non_negative(), positive());
    let gas = (gas(), positive(), prop::option::of(0.0..=1.0));
    let effects = (
        non_negative(),
        non_negative(),
        prop::option::of(positive()),
        non_negative(),
    );
    (sizes, gas, effects, 1e-300..=1.0).prop_map(
        move |(
            (bore, dead_volume, supply, orifice_radius),
            (gas, temperature, n),
            effects,
            coefficient,
        )| {
            let (supply_droop, leak_area, area, seal_friction) = effects;
            Cylinder {
                bore,
                dead_volume,
                supply: GaugePressure(supply),
                discharge_coefficient: coefficient,
                orifice_radius,
                gas,
                temperature,
                supply_droop,
                leak_area,
                exhaust_port: area.map(|area| ExhaustPort {
                    position: port,
                    area,
                }),
                polytropic_exponent: n
                    .map(|n: f64| (1.0 + n * (gas.heat_ratio - 1.0)).min(gas.heat_ratio)),
                seal_friction,
            }
        },
    )
}

fn leg() -> impl Strategy<Value = Leg> {
    stroke_and_part().prop_flat_map(|(stroke, part)| {
        let drive = prop_oneof![
            cylinder(part).prop_map(Drive::Pneumatic),
            (positive(), positive()).prop_map(|(stiffness, compression)| Drive::Spring {
                stiffness,
                compression
            }),
            positive().prop_map(|force| Drive::Constant { force }),
            force_table(stroke).prop_map(Drive::Table),
        ];
        let spring = prop::option::of((non_negative(), non_negative()));
        let cushion = prop::option::of((non_negative(), non_negative()));
        (
            non_negative(),
            non_negative(),
            non_negative(),
            spring,
            cushion,
            drive,
        )
            .prop_map(
                move |(delay, viscous_friction, coulomb_friction, spring, cushion, drive)| Leg {
                    stroke,
                    delay,
                    viscous_friction,
                    coulomb_friction,
                    return_spring: spring
                        .map(|(stiffness, preload)| ReturnSpring { stiffness, preload }),
                    cushion: cushion.map(|(stiffness, damping)| Cushion {
                        length: part,
                        stiffness,
                        damping,
                    }),
                    drive,
                    body: LegBody::default(),
                },
            )
    })
}

/// Any robot in its domain.
fn robot() -> impl Strategy<Value = Robot> {
    let size = (positive(), non_negative(), positive(), 1..=u32::MAX);
    let (angle, torque) = (
        prop_oneof![positive().prop_map(|angle| -angle), non_negative()],
        non_negative(),
    );
    let body = (size, non_negative(), angle, torque).prop_map(
        |((mass, inertia, radius, legs), imbalance, imbalance_angle, axle_friction)| Body {
            mass,
            inertia,
            radius,
            legs,
            imbalance,
            imbalance_angle,
            axle_friction,
        },
    );
    let environment =
        (non_negative(), positive(), non_negative()).prop_map(|(gravity, ambient, drag)| {
            Environment {
                gravity,
                ambient: AbsolutePressure(ambient),
                drag,
            }
        });
    let errors = (
        non_negative(),
        non_negative(),
        non_negative(),
        non_negative(),
    )
        .prop_map(|(rate, firing_angle, valve_open, supply)| Errors {
            rate,
            firing_angle,
            valve_open,
            supply,
        });
    ("(?s).+", body, leg(), (rod(), rig()), environment, errors).prop_map(
        |(name, body, mut leg, (rod, (boom, radius, ground)), environment, errors)| {
            // Not every rod leaves the wheel something, nor every counterweight the robot some
            // weight.
            leg.body = rod;
            let robot = Robot {
                name,
                body,
                leg,
                boom,
                foot: Foot { radius },
                ground,
                environment,
                errors,
            };
            if fits(&robot) { robot } else { stripped(robot) }
        },
    )
}

/// Any moving part of a leg; half of them weigh nothing.
fn rod() -> impl Strategy<Value = LegBody> {
    (
        non_negative(),
        non_negative(),
        non_negative(),
        non_negative(),
    )
        .prop_map(|(mass, center, length, radius)| LegBody {
            mass,
            center,
            length,
            radius,
        })
}

/// Any boom, foot radius and ground.
fn rig() -> impl Strategy<Value = (Option<Boom>, f64, Ground)> {
    let counterweight =
        (non_negative(), positive()).prop_map(|(mass, distance)| Counterweight { mass, distance });
    let sizes = (non_negative(), positive(), non_negative());
    let boom = (
        sizes,
        prop::option::of(counterweight),
        prop::option::of(positive()),
    )
        .prop_map(|((mass, length, radius), counterweight, flex)| Boom {
            mass,
            length,
            radius,
            counterweight,
            flex,
        });
    let friction = || prop_oneof![1 => Just(f64::INFINITY), 3 => non_negative()];
    let soft = (prop::option::of(positive()), non_negative());
    let ground = (
        friction(),
        friction(),
        non_negative(),
        0.0..1.0,
        soft,
        -0.78..0.78,
    )
        .prop_map(
            |(
                static_friction,
                kinetic_friction,
                across_friction,
                restitution,
                (stiffness, damping),
                slope,
            )| {
                Ground {
                    static_friction,
                    kinetic_friction,
                    across_friction,
                    restitution,
                    stiffness,
                    damping,
                    // Files have no −0.
                    slope: slope + 0.0,
                }
            },
        );
    (prop::option::of(boom), non_negative(), ground)
}

/// Whether the legs leave the wheel mass and inertia, and a counterweight the robot its weight.
fn fits(robot: &Robot) -> bool {
    let Robot {
        body, leg, boom, ..
    } = robot;
    let legs = f64::from(body.legs);
    let unit = LegBody {
        mass: 1.0,
        ..leg.body
    };
    let moment = |boom: &Boom| (body.mass + 0.5 * boom.mass) * boom.length;
    let light = leg.body.mass == 0.0
        || leg.body.mass < body.mass / legs
            && (unit.inertia_about_axle() == 0.0
                || leg.body.mass < body.inertia / (legs * unit.inertia_about_axle()));
    light
        && boom.iter().all(|boom| {
            boom.counterweight
                .is_none_or(|c| c.mass <= moment(boom) / c.distance)
        })
}

/// `robot` without what does not fit.
fn stripped(mut robot: Robot) -> Robot {
    robot.leg.body.mass = 0.0;
    if let Some(boom) = &mut robot.boom {
        boom.counterweight = None;
    }
    robot
}

/// Each domain of model.rs, written out again.
fn is_sound(robot: &Robot) -> bool {
    let positive = |x: f64| x.is_finite() && x > 0.0;
    let non_negative = |x: f64| x.is_finite() && x >= 0.0;
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
    let drive = match &leg.drive {
        Drive::Pneumatic(c) => {
            [
                c.bore,
                c.dead_volume,
                c.orifice_radius,
                c.temperature,
                c.gas.constant,
            ]
            .into_iter()
            .all(positive)
                && [c.supply.0, c.supply_droop, c.leak_area, c.seal_friction]
                    .into_iter()
                    .all(non_negative)
                && positive(c.discharge_coefficient)
                && c.discharge_coefficient <= 1.0
                && c.gas.heat_ratio.is_finite()
                && c.gas.heat_ratio > 1.0
                && c.polytropic_exponent
                    .is_none_or(|n| (1.0..=c.gas.heat_ratio).contains(&n))
                && c.exhaust_port.is_none_or(|port| {
                    positive(port.position) && port.position < leg.stroke && positive(port.area)
                })
        }
        Drive::Spring {
            stiffness,
            compression,
        } => positive(*stiffness) && positive(*compression),
        Drive::Constant { force } => positive(*force),
        Drive::Table(ForceTable {
            extensions,
            speeds,
            forces,
        }) => {
            let axis = |axis: &[f64]| {
                axis.len() >= 2 && axis[0] == 0.0 && axis.windows(2).all(|w| w[0] < w[1])
            };
            axis(extensions)
                && axis(speeds)
                && extensions.last().is_some_and(|&last| last >= leg.stroke)
                && forces.len() == extensions.len() * speeds.len()
                && [extensions, speeds, forces]
                    .into_iter()
                    .flatten()
                    .all(|x| x.is_finite())
        }
    };
    let rod = &leg.body;
    let rig = [rod.mass, rod.center, rod.length, rod.radius, foot.radius]
        .into_iter()
        .all(non_negative)
        && boom.is_none_or(|boom| {
            non_negative(boom.mass)
                && positive(boom.length)
                && non_negative(boom.radius)
                && boom
                    .counterweight
                    .is_none_or(|c| non_negative(c.mass) && positive(c.distance))
                && boom.flex.is_none_or(positive)
        })
        && [ground.static_friction, ground.kinetic_friction]
            .into_iter()
            .all(|x| x >= 0.0)
        && [ground.across_friction, ground.damping]
            .into_iter()
            .all(non_negative)
        && (0.0..1.0).contains(&ground.restitution)
        && ground.stiffness.is_none_or(positive)
        && ground.slope.abs() < std::f64::consts::FRAC_PI_4
        && fits(robot);
    drive
        && rig
        && [body.imbalance, body.axle_friction]
            .into_iter()
            .all(non_negative)
        && body.imbalance_angle.is_finite()
        && !name.is_empty()
        && body.legs >= 1
        && [body.mass, body.radius, leg.stroke, environment.ambient.0]
            .into_iter()
            .all(positive)
        && [
            body.inertia,
            leg.delay,
            leg.viscous_friction,
            leg.coulomb_friction,
        ]
        .into_iter()
        .all(non_negative)
        && [environment.gravity, environment.drag]
            .into_iter()
            .all(non_negative)
        && [
            errors.rate,
            errors.firing_angle,
            errors.valve_open,
            errors.supply,
        ]
        .into_iter()
        .all(non_negative)
        && leg
            .return_spring
            .is_none_or(|s| non_negative(s.stiffness) && non_negative(s.preload))
        && leg.cushion.is_none_or(|c| {
            positive(c.length)
                && c.length < leg.stroke
                && non_negative(c.stiffness)
                && non_negative(c.damping)
        })
}

/// Files to mutate: each kind of leg, as people and as the program write it.
fn sound_files() -> Vec<String> {
    let mut files: Vec<String> = Robot::builtin_names()
        .map(|name| Robot::builtin(name).expect("built in").to_toml())
        .collect();
    files.push(include_str!("../../robots/rats-planar.toml").into());
    files.push(include_str!("../../robots/spring-hopper.toml").into());
    files
}

/// What may stand in the place of a number.
const ODD_NUMBERS: [&str; 20] = [
    "nan",
    "-nan",
    "inf",
    "-inf",
    "1e400",
    "-1e400",
    "1e-400",
    "-0",
    "0",
    "-0.0",
    "1e308",
    "-1",
    "0x10",
    "1_000",
    "9223372036854775808",
    "340282366920938463463374607431768211456",
    "0xffffffffffffffffffffffffffffffffff",
    "1e99999999999999999999",
    "\"1\"",
    "[]",
];

/// `text` with its `index`-th number (modulo their count) replaced.
fn with_number(text: &str, index: usize, number: &str) -> String {
    let starts: Vec<usize> = text.match_indices("= ").map(|(at, _)| at + 2).collect();
    let start = starts[index % starts.len()];
    let end = text[start..]
        .find([' ', ',', '\n'])
        .map_or(text.len(), |length| start + length);
    format!("{}{number}{}", &text[..start], &text[end..])
}

/// Reading `text` does not panic and gives nothing unsound.
fn check_reading(text: &str) -> Result<(), TestCaseError> {
    match parse(text) {
        Ok(robot) => prop_assert!(is_sound(&robot), "{:?}", robot),
        Err(error) => prop_assert!(!error.to_string().is_empty()),
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig {
        rng_seed: RngSeed::Fixed(1),
        failure_persistence: None,
        ..ProptestConfig::with_cases(512)
    })]

    #[test]
    fn a_written_robot_reads_as_itself(robot in robot()) {
        prop_assert!(is_sound(&robot), "{:?}", robot);
        let read = parse(&robot.to_toml());
        prop_assert_eq!(read.map_err(|error| error.to_string()), Ok(robot));
    }

    #[test]
    fn arbitrary_text_is_refused(text in any::<String>()) {
        prop_assert!(parse(&text).is_err());
    }

    #[test]
    fn arbitrary_toml_is_refused(text in "([\\[\\]a-z.=\"'#{},0-9 -]{0,12}\n){0,8}") {
        prop_assert!(parse(&text).is_err());
    }

    #[test]
    fn flipped_bytes(file in 0..6_usize, flips in prop::collection::vec((any::<usize>(), any::<u8>()), 1..4)) {
        let mut bytes = sound_files()[file].clone().into_bytes();
        for (at, byte) in flips {
            let at = at % bytes.len();
            bytes[at] = byte;
        }
        check_reading(&String::from_utf8_lossy(&bytes))?;
    }

    #[test]
    fn truncated_files(file in 0..6_usize, end in any::<usize>()) {
        let text = sound_files()[file].clone().into_bytes();
        check_reading(&String::from_utf8_lossy(&text[..end % text.len()]))?;
    }

    #[test]
    fn odd_numbers(file in 0..6_usize, index in any::<usize>(), number in prop::sample::select(&ODD_NUMBERS[..])) {
        check_reading(&with_number(&sound_files()[file], index, number))?;
    }

    #[test]
    fn arbitrary_overrides(text in any::<String>(), key in "(leg|body|name|errors)(\\.[a-z_]{0,8}){0,2}", value in any::<String>()) {
        for text in [text, format!("{key}={value}"), format!("leg.bore_mm={value}")] {
            match resolve("rats-planar", std::slice::from_ref(&text)) {
                Ok(robot) => prop_assert!(is_sound(&robot), "{}: {:?}", text, robot),
                Err(error) => {
                    let named = format!("--set {text}");
                    prop_assert!(error.to_string().contains(&named), "{}", error);
                }
            }
        }
    }
}
