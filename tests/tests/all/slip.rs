//! The friction at which a foot begins to slip: the stance's closed demand against feet that do
//! slip.

use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use saltus_lagrangian::{Launch, Outcome, Stance};
use saltus_robot::Robot;
use saltus_sim_check::{Plan, Rig, SimError};

/// Whether a foot on ground of this friction coefficient slips before it lifts off.
fn slips(friction: f64, launch: &Launch) -> Result<bool, SimError> {
    let mut robot = Robot::rats_planar();
    (robot.ground.static_friction, robot.ground.kinetic_friction) = (friction, friction);
    let rig = Rig::new(&robot, &[])?;
    let launch = saltus_sim_check::Launch {
        rate: launch.rate,
        lean: launch.lean,
        firing_angle: launch.firing_angle,
        valve_open: launch.valve_open,
    };
    Ok(rig
        .jump(
            &launch,
            &Plan {
                sample: 0.02,
                ..Plan::default()
            },
        )?
        .slips_at
        .is_some())
}

/// A boom leads the foot on an arc: friction across the travel is overcome while that along it holds.
#[test]
fn a_foot_that_slips_across_the_travel_alone_does_not_slip_along_it() {
    let mut robot = Robot::builtin("rats-boom").expect("built in");
    assert_eq!(robot.ground.static_friction, f64::INFINITY);
    robot.ground.across_friction = 0.1;
    let rig = Rig::new(&robot, &[]).expect("a rig");
    let launch = saltus_sim_check::Launch::at_firing(5.0, -0.1, 0.1);
    let report = rig.jump(&launch, &Plan::default()).expect("a jump");
    assert_eq!(report.slips_at, None);
    // The arc of a boom of 2 m goes aside by 1 mm in a stance of 6 cm.
    assert!(report.slipped[1].abs() > 1e-4, "{:?}", report.slipped);
    assert!(report.slipped[0].abs() < 1e-9, "{:?}", report.slipped);
}

/// The least friction coefficient without slip, to 1e-5, by bisection between 0 and 3.
fn least_friction(launch: &Launch) -> Result<f64, SimError> {
    let (mut low, mut high) = (0.0, 3.0);
    assert!(!slips(high, launch)?, "{launch:?}");
    while high - low > 1e-5 {
        let middle = 0.5 * (low + high);
        if slips(middle, launch)? {
            low = middle;
        } else {
            high = middle;
        }
    }
    Ok(high)
}

/// Jumps that end at the stroke. Where the leg's force ends the stance, the normal force goes to 0
/// before the tangential one does: the demand grows without bound in the last instants, so that
/// every foot slips there, and there is no coefficient to compare.
#[test]
fn feet_slip_where_the_stance_says_that_they_would() -> Result<(), Box<dyn std::error::Error>> {
    let stance = Stance::new(&Robot::rats_planar(), |_, x| x);
    let mut runner = TestRunner::new_with_rng(
        Config::default(),
        TestRng::from_seed(RngAlgorithm::ChaCha, &[7; 32]),
    );
    let (mut count, mut worst, mut range) = (0, 0.0_f64, (f64::INFINITY, 0.0_f64));
    while count < 12 {
        let draws = (3.0..6.0_f64, -0.25..0.1_f64, 0.0..0.15_f64);
        let (rate, firing_angle, before) = draws
            .new_tree(&mut runner)
            .map(|tree| tree.current())
            .expect("ranges give numbers");
        let launch = Launch {
            rate,
            lean: firing_angle - before,
            firing_angle,
            valve_open: 0.1,
        };
        let (lift_off, contact) = stance.contact(&launch)?;
        if lift_off.outcome != Outcome::Stroke || contact.least_normal <= 0.0 {
            continue;
        }
        let least = least_friction(&launch)?;
        let traced = stance.trace(&launch)?.contact.friction_needed;
        let error = (least - contact.friction_needed)
            .abs()
            .max((least - traced).abs());
        assert!(
            error < 1e-3,
            "{least} of {} (traced: {traced}) in {launch:?}",
            contact.friction_needed
        );
        worst = worst.max(error);
        range = (range.0.min(least), range.1.max(least));
        count += 1;
    }
    println!(
        "{count} jumps, μ from {:.3} to {:.3}, worst {worst:.1e}",
        range.0, range.1
    );
    Ok(())
}
