//! The figures of the thesis, and its linear law.

use saltus_lagrangian::{Launch, Outcome};
use saltus_planner::{Planner, TableRequest};
use saltus_robot::Robot;
use saltus_tests::reference::firings;

/// Apex and landing at y = 0 (m) of a jump that starts at its firing angle.
fn jump(planner: &Planner, rate: f64, firing_angle: f64) -> (f64, f64) {
    let jump = planner
        .jump(&Launch::at_firing(rate, firing_angle, 0.1))
        .expect("a stance");
    (
        jump.apex().expect("a flight"),
        jump.distance(0.0).expect("a landing"),
    )
}

fn request(rates: Vec<f64>, targets: Vec<f64>) -> TableRequest {
    TableRequest {
        targets,
        sensitivities: false,
        ..TableRequest::distance(0.0).rates(rates)
    }
}

/// Figure 5.9: at 5 rad/s, fired from −0.25 to 0.05 rad, later firing travels farther and rises
/// less.
#[test]
fn figure_5_9_later_is_farther_and_lower() {
    let planner = Planner::new(Robot::rats_planar());
    let family: Vec<(f64, f64)> = (0..=30)
        .map(|k| jump(&planner, 5.0, -0.25 + 0.01 * f64::from(k)))
        .collect();
    for (earlier, later) in family.iter().zip(&family[1..]) {
        assert!(
            later.0 < earlier.0 && later.1 > earlier.1,
            "{earlier:?} {later:?}"
        );
    }
}

/// Figure 5.2: hopping on one upright leg with a third of the boom added, the pivot angle rises
/// from 0.042 rad at 20 ms to 0.158 rad, with no gain past 55 ms.
#[test]
fn figure_5_2_a_longer_opening_hops_higher_until_55_ms() {
    let mut robot = Robot::rats_planar();
    robot.body.mass += 0.5 / 3.0;
    let radius = robot.body.radius;
    let planner = Planner::new(robot);
    let pivot = |milliseconds: i32| {
        let launch = Launch::at_firing(0.0, 0.0, f64::from(milliseconds) / 1000.0);
        let jump = planner.jump(&launch).expect("a stance");
        ((jump.apex().expect("a hop") - radius) / 2.12).asin()
    };
    // The figure is read to a thousandth.
    assert!((pivot(20) - 0.042).abs() < 1e-3, "{}", pivot(20));
    assert!((pivot(55) - 0.158).abs() < 1e-3, "{}", pivot(55));
    for milliseconds in 20..55 {
        // Once the leg is off the ground before the valve closes, only the steps' lengths change.
        assert!(
            pivot(milliseconds) <= pivot(milliseconds + 1) + 1e-9,
            "{milliseconds} ms"
        );
    }
    assert!((pivot(55) - pivot(100)).abs() < 1e-9);
    assert!(pivot(55) > pivot(50));
}

/// The linear law of §5.2.3 for 1 m, from five rates. The thesis has −0.1 s and 0.46 rad and does
/// not say from where it measures; with the stance starting at the firing angle and the landing at
/// y = 0 the reference page has about −0.14 s and 0.68 rad. Five even rates from 3 to 6 rad/s give
/// −0.146 s and 0.704 rad, from 4 to 6 rad/s −0.144 s and 0.692 rad: the relation bends a little,
/// and so the rates decide the last digit.
#[test]
fn the_law_for_one_metre_is_linear() {
    let planner = Planner::new(Robot::rats_planar());
    let rates = [3.0, 3.75, 4.5, 5.25, 6.0];
    let angles = rates.map(|rate| least_angle(&planner, rate, 1.0));
    let (slope, intercept) = line(&rates, &angles);
    // The choice of the five rates moves the slope by 0.004 s and the intercept by 0.02 rad.
    assert!((slope + 0.14).abs() < 0.01, "{slope}");
    assert!((intercept - 0.68).abs() < 0.03, "{intercept}");
    // The reference table's own angles for 1 m at these rates, on a line.
    assert!((slope + 0.146_043_2).abs() < 1e-6 && (intercept - 0.703_858_7).abs() < 1e-6);
    for (rate, angle) in rates.into_iter().zip(angles) {
        let miss = angle - (slope * rate + intercept);
        assert!(miss.abs() < 0.01, "{rate} rad/s: {miss} rad off the line");
    }
    let laws = planner
        .laws(&request(rates.to_vec(), vec![1.0]))
        .expect("a request");
    let law = laws[0].as_ref().expect("within reach");
    // The same five points, each to a few times the planner's tolerance.
    assert!(
        (law.slope - slope).abs() < 1e-7 && (law.intercept - intercept).abs() < 1e-7,
        "{law:?}"
    );
}

/// The least firing angle (rad) for `distance`, by halving: the distance grows along the first
/// branch.
fn least_angle(planner: &Planner, rate: f64, distance: f64) -> f64 {
    let (mut low, mut high) = (-0.3, -0.3);
    while jump(planner, rate, high).1 < distance {
        (low, high) = (high, high + 0.02);
    }
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if jump(planner, rate, middle).1 < distance {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

/// Slope and intercept of the least-squares line.
fn line(x: &[f64], y: &[f64]) -> (f64, f64) {
    let n = x.len() as f64;
    let (mx, my) = (x.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
    let covariance: f64 = x.iter().zip(y).map(|(x, y)| (x - mx) * (y - my)).sum();
    let slope = covariance / x.iter().map(|x| (x - mx).powi(2)).sum::<f64>();
    (slope, my - slope * mx)
}

/// §5.2.3: at a run, the wheel of a jump of 1 m rises over a square box of 0.21 m. (At 3 rad/s it
/// is 2 mm short.)
#[test]
fn a_jump_of_one_metre_rises_over_the_box() {
    let planner = Planner::new(Robot::rats_planar());
    for rate in [3.5, 4.5, 6.0] {
        let (apex, _) = jump(&planner, rate, least_angle(&planner, rate, 1.0));
        assert!(
            apex > 0.21 + planner.robot().body.radius,
            "{rate} rad/s: {apex} m"
        );
    }
}

/// Every firing angle of the reference table, in one request.
#[test]
fn the_firing_table_is_the_reference() {
    let reference = firings();
    assert_eq!(reference.len(), 2196);
    let distinct = |of: fn(&saltus_tests::reference::Firing) -> f64| {
        let mut values: Vec<f64> = reference.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        values
    };
    let (rates, distances) = (distinct(|f| f.rate), distinct(|f| f.distance));
    let planner = Planner::new(Robot::rats_planar());
    let table = planner
        .table(&request(rates, distances))
        .expect("a request");
    for firing in &reference {
        let cell = table
            .cells
            .iter()
            .find(|cell| cell.rate == firing.rate && cell.target == firing.distance)
            .expect("each rate with each distance");
        let entry = cell
            .entries
            .first()
            .unwrap_or_else(|| panic!("{firing:?}: out of reach"));
        let found = entry.jump.launch.firing_angle;
        // What the reference page asks for.
        assert!(
            (found - firing.firing_angle).abs() < 1e-8,
            "{firing:?}: {found}"
        );
        assert_eq!(entry.jump.stance.outcome, Outcome::Stroke);
    }
    // The table has a row for each cell that is within reach, and none else.
    let within = table
        .cells
        .iter()
        .filter(|cell| !cell.entries.is_empty())
        .count();
    assert_eq!(within, reference.len());
}
