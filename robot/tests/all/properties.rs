//! Any sound robot survives being written and read; any other text is refused without a panic.

use std::path::Path;

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use saltus_robot::domain::Domain;
use saltus_robot::{Drive, ForceTable, Gas, Robot, RobotError, Term, resolve};

fn parse(text: &str) -> Result<Robot, RobotError> {
    Robot::parse(text, "robot.toml", Path::new("."))
}

/// Any finite number > 0, down to the smallest and up to the largest.
fn positive() -> impl Strategy<Value = f64> {
    use proptest::num::f64::{NORMAL, POSITIVE, SUBNORMAL};
    (POSITIVE | NORMAL | SUBNORMAL).prop_map(f64::abs)
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

/// A number of `domain`: `x`, with either sign, or one `luck` of the way through.
fn inside(domain: Domain, luck: f64, x: f64) -> f64 {
    let (low, high) = domain.bounds();
    let along = low + luck * (high - low);
    let sign = if luck < 0.5 { 1.0 } else { -1.0 };
    // Files have no −0.
    let candidates = [f64::INFINITY, sign * x, x, along, low.midpoint(high), low];
    let skipped = usize::from(luck > 0.25);
    candidates[skipped..]
        .iter()
        .map(|x| x + 0.0)
        .find(|x| domain.contains(*x))
        .unwrap_or(low)
}

/// The built-in robot of each kind of leg, one of them without its number of legs.
fn kinds() -> impl Strategy<Value = Robot> {
    let built_in = ["rats-boom", "spring-hopper", "table-hopper"];
    let constant = resolve(
        "spring-hopper",
        &[
            "leg={kind='constant', stroke_m=1, release_delay_s=0, viscous_friction_n_s_per_m=0, \
           coulomb_friction_n=0, force_n=1}"
                .into(),
        ],
    );
    let mut robots: Vec<Robot> = built_in.iter().filter_map(|n| Robot::builtin(n)).collect();
    robots.push(constant.expect("sound"));
    let gases = Gas::NAMED.map(|(_, gas)| gas).to_vec();
    let robot = (prop::sample::select(robots), prop::sample::select(gases));
    (robot, "(?s).+", 1..=u32::MAX).prop_map(|((mut robot, gas), name, legs)| {
        robot.name = name;
        robot.body.legs = legs;
        robot
            .leg
            .cylinder_mut()
            .into_iter()
            .for_each(|c| c.gas = gas);
        robot
    })
}

/// Any robot in its domain: every term drawn from its own, or off.
fn robot() -> impl Strategy<Value = Robot> {
    let number = (
        0.0..1.0,
        prop_oneof![1 => Just(0.0), 5 => positive()],
        any::<bool>(),
    );
    let numbers = prop::collection::vec(number, Term::ALL.len());
    (kinds(), numbers, any::<bool>()).prop_flat_map(|(mut robot, numbers, has_boom)| {
        robot.boom = robot.boom.filter(|_| has_boom);
        for (term, (luck, x, is_on)) in Term::ALL.iter().zip(numbers) {
            let is_part = term.of(&robot).is_none();
            let is_gas = term.spec().section() == "leg.gas";
            if (is_part || is_gas) && !is_on {
                continue;
            }
            let value = inside(term.domain(&robot), luck, x);
            term.set(&mut robot, value);
        }
        complete(&mut robot);
        let table = force_table(robot.leg.stroke);
        (Just(robot), table).prop_map(|(mut robot, table)| {
            if let Drive::Table(old) = &mut robot.leg.drive {
                *old = table;
            }
            robot
        })
    })
}

/// Drops what is half there: a port without an area, a counterweight or struts without a distance.
fn complete(robot: &mut Robot) {
    let stroke = robot.leg.stroke;
    robot.leg.cushion = robot.leg.cushion.filter(|cushion| cushion.length > 0.0);
    robot.struts = robot.struts.filter(|struts| struts.distance > 0.0);
    // A file leaves out what is as without it.
    let delay = robot.leg.delay;
    robot.leg.closing_delay = robot.leg.closing_delay.filter(|closing| *closing != delay);
    if let Some(cylinder) = robot.leg.cylinder_mut() {
        cylinder.tube = cylinder.tube.filter(|tube| tube.diameter > 0.0);
        cylinder.exhaust_port = cylinder
            .exhaust_port
            .filter(|port| port.area > 0.0 && port.position > 0.0 && port.position < stroke);
    }
    if let Some(boom) = &mut robot.boom {
        boom.counterweight = boom.counterweight.filter(|weight| weight.distance > 0.0);
    }
}

/// Every number in its domain.
fn is_sound(robot: &Robot) -> bool {
    let is_inside = |term: &Term| {
        term.of(robot)
            .is_none_or(|value| term.domain(robot).contains(value))
    };
    Term::ALL.iter().all(is_inside) && !robot.name.is_empty() && robot.body.legs >= 1
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
    fn flipped_bytes(file in 0..7_usize, flips in prop::collection::vec((any::<usize>(), any::<u8>()), 1..4)) {
        let mut bytes = sound_files()[file].clone().into_bytes();
        for (at, byte) in flips {
            let at = at % bytes.len();
            bytes[at] = byte;
        }
        check_reading(&String::from_utf8_lossy(&bytes))?;
    }

    #[test]
    fn truncated_files(file in 0..7_usize, end in any::<usize>()) {
        let text = sound_files()[file].clone().into_bytes();
        check_reading(&String::from_utf8_lossy(&text[..end % text.len()]))?;
    }

    #[test]
    fn odd_numbers(file in 0..7_usize, index in any::<usize>(), number in prop::sample::select(&ODD_NUMBERS[..])) {
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
