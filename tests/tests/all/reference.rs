//! The reference solutions, which were computed independently: every row, every column, by each
//! route through the code.

use saltus_lagrangian::{Batch, FINE, Launch, LiftOff, Stance};
use saltus_planner::PLANNING_TOLERANCE;
use saltus_robot::Robot;
use saltus_tests::reference::{Hop, JUMP_COLUMNS, Row, columns, hops, jumps};

/// What the reference data's README asks of a correct implementation.
const RELATIVE: f64 = 1e-8;
/// Near 0: the lean and the landing pass through it, and the file gives 14 digits of numbers
/// about 1.
const ABSOLUTE: f64 = 1e-10;
/// At the planner's tolerance of 2e-9 a step's error may be that much of 1 + |state|; a stance has
/// some ten steps, and the least columns are about 0.01, the least scale that relative errors are
/// taken by.
const PLANNED: f64 = 1e-8;

/// Every row of `jumps.csv` as `solve` computes it, within `allowed(reference)`.
fn check_jumps(
    route: &str,
    solve: impl Fn(&[Launch]) -> Vec<LiftOff>,
    allowed: impl Fn(f64) -> f64,
) {
    let robot = Robot::rats_planar();
    let rows = jumps();
    assert_eq!(rows.len(), 192);
    let launches: Vec<Launch> = rows.iter().map(|row| row.launch).collect();
    let ends = solve(&launches);
    assert_eq!(ends.len(), rows.len());
    for (
        number,
        (
            Row {
                outcome,
                values,
                launch,
            },
            end,
        ),
    ) in rows.iter().zip(&ends).enumerate()
    {
        let place = || format!("{route}, row {}, {launch:?}", number + 1);
        assert_eq!(end.outcome.name(), outcome, "{}", place());
        for ((name, expected), found) in JUMP_COLUMNS.iter().zip(values).zip(columns(&robot, end)) {
            let error = (found - expected).abs();
            assert!(
                error <= allowed(*expected),
                "{}: {name} = {found}, not {expected}: {error:e}",
                place()
            );
        }
    }
}

fn strict(expected: f64) -> f64 {
    (RELATIVE * expected.abs()).max(ABSOLUTE)
}

fn planned(expected: f64) -> f64 {
    PLANNED * expected.abs().max(0.01)
}

fn stance(tolerance: f64) -> Stance<f64> {
    Stance::new(&Robot::rats_planar(), |_, x| x).with_tolerance(tolerance)
}

fn one_by_one(stance: &Stance<f64>, launches: &[Launch]) -> Vec<LiftOff> {
    launches
        .iter()
        .map(|launch| stance.jump(launch).expect("sound launch"))
        .collect()
}

fn traced(stance: &Stance<f64>, launches: &[Launch]) -> Vec<LiftOff> {
    launches
        .iter()
        .map(|launch| stance.trace(launch).expect("sound launch").lift_off)
        .collect()
}

fn side_by_side(robot: &Robot, tolerance: f64, launches: &[Launch]) -> Vec<LiftOff> {
    let ends = Batch::new(robot, tolerance).jumps(launches);
    ends.into_iter()
        .map(|end| end.expect("sound launch"))
        .collect()
}

#[test]
fn jumps_by_closed_forms() {
    check_jumps(
        "jump",
        |launches| one_by_one(&stance(FINE), launches),
        strict,
    );
}

#[test]
fn jumps_step_by_step() {
    check_jumps("trace", |launches| traced(&stance(FINE), launches), strict);
}

#[test]
fn jumps_eight_at_a_time() {
    check_jumps(
        "batch",
        |launches| side_by_side(&Robot::rats_planar(), FINE, launches),
        strict,
    );
}

#[test]
fn jumps_at_the_planners_tolerance() {
    check_jumps(
        "jump",
        |launches| one_by_one(&stance(PLANNING_TOLERANCE), launches),
        planned,
    );
    let robot = Robot::rats_planar();
    check_jumps(
        "batch",
        |launches| side_by_side(&robot, PLANNING_TOLERANCE, launches),
        planned,
    );
}

/// The robot of `hop.csv`: a third of the boom's 0.5 kg added in weight and inertia alike.
fn hopper() -> Robot {
    let mut robot = Robot::rats_planar();
    robot.body.mass += 0.5 / 3.0;
    robot
}

/// Length of the boom (m).
const BOOM: f64 = 2.12;

fn check_hops(route: &str, solve: impl Fn(&[Launch]) -> Vec<LiftOff>) {
    let robot = hopper();
    let rows = hops();
    assert_eq!(rows.len(), 11);
    let launches: Vec<Launch> = rows
        .iter()
        .map(|row| Launch::at_firing(0.0, 0.0, row.0))
        .collect();
    for ((valve_open, outcome, apex, pivot), end) in rows.iter().zip(solve(&launches)) {
        let (valve_open, apex, pivot): (f64, f64, f64) = (*valve_open, *apex, *pivot);
        assert_eq!(end.outcome.name(), outcome, "{route}, {valve_open} s");
        assert_eq!(
            end.lean, 0.0,
            "{route}, {valve_open} s: an upright hop stays upright"
        );
        let found = columns(&robot, &end)[11];
        let found_pivot = ((found - robot.body.radius) / BOOM).asin();
        for (name, found, expected) in [("apex", found, apex), ("pivot", found_pivot, pivot)] {
            assert!(
                (found - expected).abs() <= strict(expected),
                "{route}, {valve_open} s: {name} = {found}, not {expected}"
            );
        }
    }
}

#[test]
fn hops_by_each_route() {
    let robot = hopper();
    let stance = Stance::new(&robot, |_, x| x);
    check_hops("jump", |launches| one_by_one(&stance, launches));
    check_hops("trace", |launches| traced(&stance, launches));
    check_hops("batch", |launches| side_by_side(&robot, FINE, launches));
    let [first, .., last]: [Hop; 11] = hops().try_into().expect("eleven rows");
    assert!(first.2 < last.2, "a longer opening hops higher");
}
