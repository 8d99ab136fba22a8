//! No robot that a file admits and no launch at all makes the stance panic or hang.

use std::path::Path;
use std::time::{Duration, Instant};

use proptest::prelude::*;
use saltus_lagrangian::{Batch, FINE, Launch, Stance};
use saltus_numeric::{Dual, Scalar};
use saltus_robot::Robot;
use saltus_tests::robots::{any_launch, any_ordinary, cases, jump, legal, legal_launch};

/// Longer than this (on a slow machine, in a debug build) is a hang: a jump takes microseconds.
const HANG: Duration = Duration::from_secs(5);

/// Solves in every way there is.
fn try_every_way(robot: &Robot, launch: &Launch) -> Result<(), TestCaseError> {
    let begin = Instant::now();
    let stance = Stance::new(robot, |_, x| x);
    let end = stance.jump(launch);
    let trace = stance.trace(launch);
    let batch = Batch::new(robot, FINE).jumps(&[*launch; 3]);
    let dual: Stance<Dual<2>> = Stance::new(robot, |_, x| Dual::of(x));
    let of = Dual::of;
    let dual = dual.jump(&Launch {
        rate: Dual::variable(launch.rate, 0),
        lean: of(launch.lean),
        firing_angle: of(launch.firing_angle),
        valve_open: of(launch.valve_open),
    });
    prop_assert!(
        begin.elapsed() < HANG,
        "{:?} for {:?}",
        begin.elapsed(),
        end
    );
    prop_assert_eq!(end.is_ok(), dual.is_ok(), "{:?} {:?}", end, dual);
    prop_assert_eq!(batch.len(), 3);
    let _ = trace;
    Ok(())
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
