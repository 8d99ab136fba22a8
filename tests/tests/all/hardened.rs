//! No robot that a file admits and no launch at all makes the stance panic or hang, and
//! all routes come to the same outcome.

use std::path::Path;

use proptest::prelude::*;
use saltus_lagrangian::{Batch, FINE, Launch, LiftOff, Stance, StanceError};
use saltus_numeric::{Dual, Scalar};
use saltus_robot::Robot;
use saltus_tests::robots::{any_launch, any_ordinary, cases, jump, legal, legal_launch};

/// Samples of a trace at most: 8 for each of 10,000 steps, more of which are an error, and the first.
const MOST_SAMPLES: usize = 8 * 10_000 + 1;

/// Solves by every route: the same outcome or the same error, within the range of a stance.
fn try_every_way(robot: &Robot, launch: &Launch) -> Result<(), TestCaseError> {
    let stance = Stance::new(robot, |_, x| x);
    let end = stance.jump(launch);
    let trace = stance.trace(launch);
    let dual: Stance<Dual<2>> = Stance::new(robot, |_, x| Dual::of(x));
    let of = Dual::of;
    let dual = dual.jump(&Launch {
        rate: Dual::variable(launch.rate, 0),
        lean: of(launch.lean),
        firing_angle: of(launch.firing_angle),
        valve_open: of(launch.valve_open),
    });
    prop_assert_eq!(end.is_ok(), dual.is_ok(), "{:?} {:?}", end, dual);
    // Step by step a stance may take too long where a closed form has its end.
    match &trace {
        Ok(_) => prop_assert!(end.is_ok(), "{:?}", end),
        Err(error) => prop_assert!(
            end.is_err() || !matches!(error, StanceError::Input { .. }),
            "{:?} {:?}",
            end,
            error
        ),
    }
    for other in Batch::new(robot, FINE).jumps(&[*launch; 3]) {
        prop_assert_eq!(outcome(&end), outcome(&other), "{:?} {:?}", end, other);
    }
    if let (Ok(end), Ok(trace)) = (end, trace) {
        let stroke = robot.leg.stroke;
        prop_assert!(end.time.is_finite() && end.time >= 0.0, "{:?}", end);
        // Where the stroke ends is found to round-off, but for strokes under a micrometre, which the
        // first step passes by up to 0.1 mm.
        prop_assert!(
            stroke < 1e-6 || (-1e-9..=1.0 + 1e-9).contains(&(end.extension / stroke)),
            "{:?}",
            end
        );
        prop_assert!(
            trace.samples.len() <= MOST_SAMPLES,
            "{}",
            trace.samples.len()
        );
        let increases = trace
            .samples
            .windows(2)
            .all(|pair| pair[0].time <= pair[1].time);
        prop_assert!(increases, "time goes back");
    }
    Ok(())
}

/// The outcome, or the error without its numbers.
fn outcome(end: &Result<LiftOff, StanceError>) -> String {
    match end {
        Ok(end) => format!("{:?}", end.outcome),
        Err(error) => format!("{:?}", std::mem::discriminant(error)),
    }
}

proptest! {
    #![proptest_config(cases(3000))]

    #[test]
    fn the_generator_makes_legal_robots(robot in legal(), ordinary in any_ordinary()) {
        for robot in [robot, ordinary] {
            let read = Robot::parse(&robot.to_toml(), "random.toml", Path::new("."));
            prop_assert_eq!(read.map_err(|error| error.to_string()), Ok(robot));
        }
    }

    #[test]
    fn any_launch_of_the_thesis_robot(launch in any_launch()) {
        try_every_way(&Robot::rats_planar(), &launch)?;
    }

    #[test]
    fn any_legal_launch_of_the_thesis_robot(launch in legal_launch()) {
        try_every_way(&Robot::rats_planar(), &launch)?;
    }

    #[test]
    fn any_legal_robot(robot in legal(), launch in prop_oneof![legal_launch(), any_launch()]) {
        try_every_way(&robot, &launch)?;
    }

    #[test]
    fn an_ordinary_robot_has_an_outcome((robot, launch) in jump(any_ordinary())) {
        let end = Stance::new(&robot, |_, x| x).jump(&launch);
        prop_assert!(end.is_ok(), "{:?}", end);
    }
}
