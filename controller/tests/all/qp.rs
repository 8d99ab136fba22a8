//! The small QPs against every active set tried in turn.

use proptest::prelude::*;
use saltus_controller::Reason;
use saltus_controller::qp::{self, HalfLine, HalfPlane};

/// The best of all points with at most two active constraints that keep the others, by Cramer's
/// rule for each.
fn oracle(h: [f64; 3], g: [f64; 2], constraints: &[HalfPlane<f64>]) -> Option<[f64; 2]> {
    let cost = |x: [f64; 2]| {
        0.5 * (h[0] * x[0] * x[0] + 2.0 * h[1] * x[0] * x[1] + h[2] * x[1] * x[1])
            + g[0] * x[0]
            + g[1] * x[1]
    };
    let keeps = |x: [f64; 2]| {
        constraints
            .iter()
            .all(|c| c.normal[0] * x[0] + c.normal[1] * x[1] <= c.bound + 1e-9)
    };
    let determinant = h[0] * h[2] - h[1] * h[1];
    let mut points = vec![[
        (h[1] * g[1] - h[2] * g[0]) / determinant,
        (h[1] * g[0] - h[0] * g[1]) / determinant,
    ]];
    for (i, a) in constraints.iter().enumerate() {
        // H x + g + λ a = 0 and a x = b, by elimination along the line.
        let n2 = a.normal[0].powi(2) + a.normal[1].powi(2);
        let foot = [a.normal[0] * a.bound / n2, a.normal[1] * a.bound / n2];
        let way = [-a.normal[1], a.normal[0]];
        let slope = |d: [f64; 2]| {
            way[0] * (h[0] * d[0] + h[1] * d[1]) + way[1] * (h[1] * d[0] + h[2] * d[1])
        };
        let t = -(slope(foot) + way[0] * g[0] + way[1] * g[1]) / slope(way);
        points.push([foot[0] + t * way[0], foot[1] + t * way[1]]);
        for b in &constraints[..i] {
            let d = a.normal[0] * b.normal[1] - a.normal[1] * b.normal[0];
            points.push([
                (a.bound * b.normal[1] - b.bound * a.normal[1]) / d,
                (a.normal[0] * b.bound - b.normal[0] * a.bound) / d,
            ]);
        }
    }
    points
        .into_iter()
        .filter(|x| keeps(*x))
        .min_by(|x, y| cost(*x).total_cmp(&cost(*y)))
}

fn half_plane() -> impl Strategy<Value = HalfPlane<f64>> {
    ([-1.0..1.0, -1.0..1.0], -0.5..1.5).prop_map(|(normal, bound)| HalfPlane { normal, bound })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20_000))]

    #[test]
    fn two_is_the_best_of_all_active_sets(
        l in [0.3_f64..2.0, -2.0..2.0, 0.3..2.0],
        g in [-3.0..3.0, -3.0..3.0],
        constraints in prop::collection::vec(half_plane(), 0..9),
    ) {
        let h = [l[0] * l[0], l[0] * l[1], l[1] * l[1] + l[2] * l[2]];
        match (qp::two(h, g, &constraints), oracle(h, g, &constraints)) {
            (Ok(ours), Some(theirs)) => {
                // Vertices of lines that meet at a small angle are known to less.
                let error = (ours[0] - theirs[0]).abs().max((ours[1] - theirs[1]).abs());
                prop_assert!(error < 1e-5 * (1.0 + theirs[0].abs() + theirs[1].abs()), "{ours:?} {theirs:?}");
            }
            (Err(Reason::Infeasible), None) => {}
            // Where nothing but a point is left, to the oracle's tolerance.
            (Err(Reason::Infeasible), Some(point)) => {
                let tight = |x: [f64; 2]| constraints.iter().filter(|c| c.normal[0] * x[0] + c.normal[1] * x[1] > c.bound - 1e-7).count();
                prop_assert!(tight(point) >= 3, "{point:?}");
            }
            other => prop_assert!(false, "{other:?}"),
        }
    }

    #[test]
    fn one_is_a_clamp(h in 0.1_f64..3.0, g in -3.0_f64..3.0, low in -2.0_f64..1.0, width in 0.0_f64..2.0) {
        let free = -g / h;
        let constraints = [HalfLine { slope: -2.0, bound: -2.0 * low }, HalfLine { slope: 0.5, bound: 0.5 * (low + width) }];
        let x = qp::one(h, g, &constraints).expect("an interval");
        prop_assert!((x - free.clamp(low, low + width)).abs() < 1e-12);
    }
}

#[test]
fn contradictions_and_nonsense_are_told_apart() {
    let h = [1.0, 0.0, 1.0];
    let plane = |a: f64, b: f64, bound: f64| HalfPlane {
        normal: [a, b],
        bound,
    };
    let check = |constraints: &[HalfPlane<f64>], answer: Result<[f64; 2], Reason>| {
        assert_eq!(
            qp::two(h, [0.0, 0.0], constraints),
            answer,
            "{constraints:?}"
        );
    };
    check(&[], Ok([0.0, 0.0]));
    // Parallel lines, apart, upon each other, and as an equation.
    check(
        &[plane(1.0, 0.0, -1.0), plane(-1.0, 0.0, -1.0)],
        Err(Reason::Infeasible),
    );
    check(
        &[plane(1.0, 0.0, -1.0), plane(3.0, 0.0, -3.0)],
        Ok([-1.0, 0.0]),
    );
    check(
        &[plane(1.0, 0.0, -1.0), plane(-1.0, 0.0, 1.0)],
        Ok([-1.0, 0.0]),
    );
    // 0 ≤ b.
    check(&[plane(0.0, 0.0, 1.0)], Ok([0.0, 0.0]));
    check(&[plane(0.0, 0.0, -1.0)], Err(Reason::Infeasible));
    check(&[plane(f64::NAN, 0.0, 1.0)], Err(Reason::SensorInvalid));
    check(
        &[plane(1.0, 0.0, f64::INFINITY)],
        Err(Reason::SensorInvalid),
    );
    for h in [
        [0.0, 0.0, 1.0],
        [1.0, 1.0, 1.0],
        [1.0, 2.0, 1.0],
        [f64::NAN, 0.0, 1.0],
        [-1.0, 0.0, 1.0],
    ] {
        assert_eq!(
            qp::two(h, [0.0, 0.0], &[]),
            Err(Reason::SensorInvalid),
            "{h:?}"
        );
    }
    assert_eq!(qp::one(0.0, 1.0, &[]), Err(Reason::SensorInvalid));
    assert_eq!(
        qp::one(
            1.0,
            -3.0,
            &[HalfLine {
                slope: 0.0,
                bound: -1.0
            }]
        ),
        Err(Reason::Infeasible)
    );
    assert_eq!(qp::one(1.0, -3.0, &[]), Ok(3.0));
}

#[test]
fn the_work_is_bounded() {
    assert_eq!([0, 1, 2, 8].map(qp::most_cuts), [0, 0, 1, 28]);
    assert_eq!(qp::most_cuts(usize::MAX), usize::MAX / 2);
}
