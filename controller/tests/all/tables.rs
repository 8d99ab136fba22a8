//! Tables: exact on bicubics, monotone where they should be, and a reason everywhere else.

use proptest::prelude::*;
use saltus_controller::{
    Approach, Axis, Controller, FiringCurve, FiringTable, Input, Rates, Reason, Rule, Sensed, Task,
};

use crate::rats_planar::RATS_PLANAR;

const CONTROLLER: Controller<'static, f32> = RATS_PLANAR;

fn table() -> FiringTable<'static, f32> {
    match CONTROLLER.rule {
        Rule::Table(table) => table,
        Rule::Curve(_) => panic!("the example is a table"),
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
    let table = FiringTable {
        rates,
        distances,
        nodes: &nodes,
        open: &[1; 24],
    };
    for k in 0..=400 {
        let (x, y) = (
            1.0 + 2.0 * f64::from(k % 21) / 20.0,
            -1.0 + 3.0 * f64::from(k / 21) / 20.0,
        );
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
        assert_eq!(
            table().firing_angle(rate, distance),
            Err(reason),
            "{rate} {distance}"
        );
        assert_eq!(
            CONTROLLER.firing_angle(rate, distance, 0.24),
            Err(reason),
            "{rate} {distance}"
        );
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
    assert_eq!(
        plain.firing_angle(4.0, 0.4, f32::NAN),
        Err(Reason::SensorInvalid)
    );
    assert!(CONTROLLER.firing_angle(4.0, 0.4, 0.2).is_ok());
}

#[test]
fn a_table_that_is_not_what_it_says_gives_reasons() {
    let whole = table();
    let cut = FiringTable {
        nodes: &whole.nodes[..20],
        ..whole
    };
    assert_eq!(cut.firing_angle(5.5, 0.5), Err(Reason::OutOfTable));
    let closed = FiringTable {
        open: &whole.open[..3],
        ..whole
    };
    assert_eq!(closed.firing_angle(5.5, 0.5), Err(Reason::OutOfTable));
    let empty = FiringTable {
        rates: Axis {
            count: 0,
            ..whole.rates
        },
        ..whole
    };
    assert_eq!(empty.firing_angle(5.5, 0.5), Err(Reason::OutOfTable));
    let vast = FiringTable {
        distances: Axis {
            count: usize::MAX,
            ..whole.distances
        },
        ..whole
    };
    assert!(vast.firing_angle(5.5, 0.5).is_err());
}

#[test]
fn a_curve_holds_for_its_distance_and_rates() {
    // α_f = 2 − 0.5 ω, which a cubic is exact on.
    let rates = Axis::new(3.0, 6.0, 4);
    let nodes = [[0.5, -0.5], [0.0, -0.5], [-0.5, -0.5], [-1.0, -0.5]];
    let curve = FiringCurve {
        rates,
        distance: 0.5_f32,
        nodes: &nodes,
        open: &[1, 1, 0],
    };
    assert_eq!(curve.firing_angle(4.0, 0.5), Ok(0.0));
    assert_eq!(curve.firing_angle(3.5, 0.5), Ok(0.25));
    assert_eq!(curve.firing_angle(4.0, 0.6), Err(Reason::OutOfTable));
    assert_eq!(curve.firing_angle(2.9, 0.5), Err(Reason::OutOfTable));
    assert_eq!(curve.firing_angle(5.5, 0.5), Err(Reason::Infeasible));
    assert_eq!(
        curve.firing_angle(f32::NAN, 0.5),
        Err(Reason::SensorInvalid)
    );
    assert_eq!(
        curve.firing_angle(4.0, f32::NAN),
        Err(Reason::SensorInvalid)
    );
    let controller = Controller {
        rule: Rule::Curve(curve),
        ..CONTROLLER
    };
    // The Newton step takes the curve's error away: what is left of this one, 0.1 rad at 4 rad/s,
    // is its square.
    let angle = controller.firing_angle(4.0, 0.5, 0.24).expect("in reach");
    let exact = CONTROLLER.firing_angle(4.0, 0.5, 0.24).expect("in reach");
    assert!(
        (angle - exact).abs() < 0.02 && angle != 0.0,
        "{angle} {exact}"
    );
}

/// The example's tables for a robot whose approach rates count at the firing angle.
fn at_firing() -> Controller<'static, f32> {
    Controller {
        rates: Rates {
            least: 1.5,
            greatest: 6.0,
            at_firing: true,
            ..CONTROLLER.rates
        },
        ..CONTROLLER
    }
}

#[test]
fn rates_at_the_firing_angle_are_those_of_decisions() {
    let (controller, mut answered) = (at_firing(), 0);
    for k in 0_u8..200 {
        let (rate, distance) = (
            2.75 + 0.0175 * f32::from(k),
            0.25 + 0.05 * f32::from(k % 10),
        );
        let sensed = Sensed { lean: -0.5, rate };
        let task = Task {
            distance,
            landing_height: 0.24,
            obstacle: None,
            guess: None,
        };
        let (Ok(there), Ok(d)) = (
            CONTROLLER.decide(&sensed, &task),
            controller.decide(&sensed, &task),
        ) else {
            continue;
        };
        // One decision, whatever its rate is called.
        assert_eq!(
            (there.firing_angle, there.timing),
            (d.firing_angle, d.timing)
        );
        let Ok(angle) = controller.firing_angle(d.approach_rate, distance, 0.24) else {
            continue;
        };
        answered += 1;
        // Round-off of a root and a cosine, and secants that end there.
        assert!(
            (angle - d.firing_angle).abs() < 2e-5,
            "{rate} {distance}: {angle} {d:?}"
        );
    }
    assert!(answered > 50, "{answered}");
    assert_eq!(
        controller.firing_angle(1.49, 0.4, 0.24),
        Err(Reason::OutOfTable)
    );
    assert_eq!(
        controller.firing_angle(6.01, 0.4, 0.24),
        Err(Reason::OutOfTable)
    );
    assert_eq!(
        controller.firing_angle(f32::NAN, 0.4, 0.24),
        Err(Reason::SensorInvalid)
    );
    assert_eq!(
        controller.firing_angle(4.0, f32::NAN, 0.24),
        Err(Reason::SensorInvalid)
    );
    assert_eq!(
        controller.firing_angle(4.0, 0.4, f32::NAN),
        Err(Reason::SensorInvalid)
    );
}

#[test]
#[expect(clippy::too_many_lines, reason = "a list of cases")]
fn no_take_off_says_which_input_it_is_and_when_to_ask_again() {
    let usual = Approach {
        distance: 0.5,
        height: 0.05,
        length: 0.1,
        speed: 1.2,
        clearance: 0.01,
    };
    let check = |approach: Approach<f32>, reason: Reason, input: Option<Input>| {
        let no = CONTROLLER.take_off(&approach).expect_err("no take-off");
        assert_eq!((no.reason, no.input), (reason, input), "{approach:?}");
    };
    assert!(CONTROLLER.take_off(&usual).is_ok());
    check(
        Approach {
            distance: f32::NAN,
            ..usual
        },
        Reason::SensorInvalid,
        Some(Input::Distance),
    );
    check(
        Approach {
            height: -0.1,
            ..usual
        },
        Reason::SensorInvalid,
        Some(Input::Height),
    );
    check(
        Approach {
            length: 0.0,
            ..usual
        },
        Reason::SensorInvalid,
        Some(Input::Length),
    );
    check(
        Approach {
            speed: f32::INFINITY,
            ..usual
        },
        Reason::SensorInvalid,
        Some(Input::Speed),
    );
    check(
        Approach {
            clearance: -1.0,
            ..usual
        },
        Reason::SensorInvalid,
        Some(Input::Clearance),
    );
    for speed in [0.3, 1.6] {
        check(
            Approach { speed, ..usual },
            Reason::OutOfTable,
            Some(Input::Speed),
        );
    }
    // Against it, and farther than four strides.
    check(
        Approach {
            distance: 0.2,
            ..usual
        },
        Reason::Infeasible,
        Some(Input::Distance),
    );
    check(
        Approach {
            distance: 3.0,
            ..usual
        },
        Reason::AskLater,
        Some(Input::Distance),
    );
    check(
        Approach {
            height: 1.0,
            ..usual
        },
        Reason::Infeasible,
        None,
    );
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
