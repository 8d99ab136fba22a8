//! Tables: exact on bicubics, monotone where they should be, and a reason everywhere else.

use proptest::prelude::*;
use saltus_controller::{Axis, Controller, FiringTable, Law, Reason, Rule};

#[rustfmt::skip]
#[path = "../examples/rats_planar/tables.rs"]
mod tables;

use tables::RATS_PLANAR;

const CONTROLLER: Controller<'static, f32> = RATS_PLANAR;

fn table() -> FiringTable<'static, f32> {
    match CONTROLLER.rule {
        Rule::Table(table) => table,
        Rule::Law(_) => panic!("the example is a table"),
    }
}

/// A polynomial of degree 3 in either variable, its derivatives by both, and the mixed one.
fn polynomial(x: f64, y: f64) -> [f64; 4] {
    let (f, f_x) = (1.0 - x + 0.5 * x * x * x, -1.0 + 1.5 * x * x);
    let (g, g_y) = (0.3 + y * y - 0.2 * y * y * y, 2.0 * y - 0.6 * y * y);
    [f * g, f_x * g, f * g_y, f_x * g_y]
}

#[test]
fn a_bicubic_is_reproduced() {
    let (rates, distances) = (Axis::new(1.0, 3.0, 5), Axis::new(-1.0, 2.0, 7));
    let (dx, dy) = (0.5, 0.5);
    let nodes: Vec<[f64; 4]> = (0..35)
        .map(|k| {
            let [f, f_x, f_y, f_xy] = polynomial(rates.node(k / 7), distances.node(k % 7));
            [f, f_x * dx, f_y * dy, f_xy * dx * dy]
        })
        .collect();
    let table = FiringTable { rates, distances, nodes: &nodes, open: &[1; 24] };
    for k in 0..=400 {
        let (x, y) = (1.0 + 2.0 * f64::from(k % 21) / 20.0, -1.0 + 3.0 * f64::from(k / 21) / 20.0);
        if y > 2.0 {
            continue;
        }
        // Values are below 20; round-off of some thirty operations.
        let error = table.firing_angle(x, y).expect("inside") - polynomial(x, y)[0];
        assert!(error.abs() < 1e-13, "{x} {y}: {error}");
    }
}

#[test]
fn nodes_are_met_to_the_bit_and_borders_belong() {
    let table = table();
    for i in 0..table.rates.count {
        for j in 0..table.distances.count {
            let (rate, distance) = (table.rates.node(i), table.distances.node(j));
            if let Ok(angle) = table.firing_angle(rate, distance) {
                // A node's place is rounded, so that its neighbour's weight is not quite 0.
                let exact = table.nodes[i * table.distances.count + j][0];
                assert!((angle - exact).abs() < 1e-6, "{i} {j}: {angle} {exact}");
            }
        }
    }
    let (first, last) = (table.rates.first, table.rates.last);
    assert!(table.firing_angle(first, 0.55).is_ok() && table.firing_angle(last, 0.55).is_ok());
}

#[test]
fn reasons_are_told_apart() {
    let check = |rate: f32, distance: f32, reason: Reason| {
        assert_eq!(table().firing_angle(rate, distance), Err(reason), "{rate} {distance}");
        assert_eq!(CONTROLLER.firing_angle(rate, distance, 0.24), Err(reason), "{rate} {distance}");
    };
    check(2.749, 0.4, Reason::OutOfTable);
    check(6.251, 0.4, Reason::OutOfTable);
    check(4.0, 0.199, Reason::OutOfTable);
    check(4.0, f32::MAX, Reason::OutOfTable);
    check(f32::INFINITY, 0.4, Reason::SensorInvalid);
    check(4.0, f32::NAN, Reason::SensorInvalid);
    // The robot does not jump 0.8 m at 3 rad/s with its valve open for 40 ms.
    check(3.0, 0.8, Reason::Infeasible);
    // Another landing height needs Newton steps.
    let mut plain = CONTROLLER;
    plain.limits.newton_steps = 0;
    assert_eq!(plain.firing_angle(4.0, 0.4, 0.2), Err(Reason::OutOfTable));
    assert_eq!(plain.firing_angle(4.0, 0.4, f32::NAN), Err(Reason::SensorInvalid));
    assert!(CONTROLLER.firing_angle(4.0, 0.4, 0.2).is_ok());
}

#[test]
fn a_table_that_is_not_what_it_says_gives_reasons() {
    let whole = table();
    let cut = FiringTable { nodes: &whole.nodes[..20], ..whole };
    assert_eq!(cut.firing_angle(5.5, 0.5), Err(Reason::OutOfTable));
    let closed = FiringTable { open: &whole.open[..3], ..whole };
    assert_eq!(closed.firing_angle(5.5, 0.5), Err(Reason::OutOfTable));
    let empty = FiringTable { rates: Axis { count: 0, ..whole.rates }, ..whole };
    assert_eq!(empty.firing_angle(5.5, 0.5), Err(Reason::OutOfTable));
    let vast = FiringTable { distances: Axis { count: usize::MAX, ..whole.distances }, ..whole };
    assert!(vast.firing_angle(5.5, 0.5).is_err());
}

#[test]
fn a_law_holds_for_its_distance_and_rates() {
    let law = Law { slope: -0.5, intercept: 2.0, least_rate: 3.0, greatest_rate: 6.0, distance: 0.5_f32 };
    assert_eq!(law.firing_angle(4.0, 0.5), Ok(0.0));
    assert_eq!(law.firing_angle(4.0, 0.6), Err(Reason::OutOfTable));
    assert_eq!(law.firing_angle(2.9, 0.5), Err(Reason::OutOfTable));
    assert_eq!(law.firing_angle(f32::NAN, 0.5), Err(Reason::SensorInvalid));
    let controller = Controller { rule: Rule::Law(law), ..CONTROLLER };
    // The Newton step takes the law's error away: what is left of this one, 0.1 rad at 4 rad/s, is its square.
    let angle = controller.firing_angle(4.0, 0.5, 0.24).expect("in reach");
    let exact = CONTROLLER.firing_angle(4.0, 0.5, 0.24).expect("in reach");
    assert!((angle - exact).abs() < 0.02 && angle != 0.0, "{angle} {exact}");
}

proptest! {
    /// Farther means later: along the distances the table rises as its nodes do.
    #[test]
    fn farther_is_later(rate in 3.0_f32..6.0, distance in 0.2_f32..0.8, step in 1e-4_f32..0.05) {
        if let (Ok(near), Ok(far)) = (table().firing_angle(rate, distance), table().firing_angle(rate, distance + step)) {
            prop_assert!(far >= near - 1e-7, "{near} {far}");
        }
    }
}
