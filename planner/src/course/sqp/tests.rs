//! Programs whose solutions are known.

use super::*;

/// A program whose derivatives are written out.
struct Known {
    bounds: Vec<Span>,
    equalities: usize,
    evaluate: fn(&[f64], &mut Evaluation),
}

impl Nlp for Known {
    fn bounds(&self) -> Vec<Span> {
        self.bounds.clone()
    }
    fn equalities(&self) -> usize {
        self.equalities
    }
    fn evaluate(&self, x: &[f64], at: &mut Evaluation) {
        (self.evaluate)(x, at);
    }
}

fn set(at: &mut Evaluation, cost: f64, gradient: &[f64], rows: &[(f64, &[f64])]) {
    at.cost = cost;
    at.gradient = gradient.to_vec();
    at.values = rows.iter().map(|r| r.0).collect();
    at.jacobian = rows.iter().flat_map(|r| r.1.iter().copied()).collect();
}

/// Rosenbrock's function on a disc of radius √2 about the origin: (1, 1), where the disc just
/// touches.
fn rosenbrock(x: &[f64], at: &mut Evaluation) {
    let (a, b) = (x[0], x[1]);
    let r = b - a * a;
    let gradient = [-2.0 * (1.0 - a) - 400.0 * a * r, 200.0 * r];
    set(
        at,
        (1.0 - a).powi(2) + 100.0 * r * r,
        &gradient,
        &[(2.0 - a * a - b * b, &[-2.0 * a, -2.0 * b])],
    );
}

/// Problem 71 of Hock and Schittkowski: 17.0140173 at (1, 4.7429994, 3.8211503, 1.3794082).
fn hock_schittkowski_71(x: &[f64], at: &mut Evaluation) {
    let [a, b, c, d] = [x[0], x[1], x[2], x[3]];
    let sum = a + b + c;
    let squares = [2.0 * a, 2.0 * b, 2.0 * c, 2.0 * d];
    let product = [b * c * d, a * c * d, a * b * d, a * b * c];
    let gradient = [d * sum + a * d, a * d, a * d + 1.0, a * sum];
    let rows: [(f64, &[f64]); 2] = [
        (a * a + b * b + c * c + d * d - 40.0, &squares),
        (a * b * c * d - 25.0, &product),
    ];
    set(at, a * d * sum + c, &gradient, &rows);
}

/// x ≥ 1 and x ≤ −1 at once: the least greatest violation is 1, at 0.
fn impossible(x: &[f64], at: &mut Evaluation) {
    set(
        at,
        x[0],
        &[1.0],
        &[(x[0] - 1.0, &[1.0]), (-1.0 - x[0], &[-1.0])],
    );
}

fn check(known: &Known, start: &[f64], x: &[f64], cost: f64, tolerance: f64) {
    let report = solve(known, start, &Settings::default());
    assert_eq!(report.status, Status::Converged, "{report:?}");
    assert!((report.cost - cost).abs() < tolerance, "{report:?}");
    assert!(
        report
            .x
            .iter()
            .zip(x)
            .all(|(a, b)| (a - b).abs() < 1e3 * tolerance),
        "{report:?}"
    );
    // A step that promises 1e-10 under curvatures to 1e4 leaves slopes of 1e-3.
    assert!(
        report.violation < 1e-9 && report.kkt_residual < 1e-3,
        "{report:?}"
    );
}

#[test]
fn rosenbrock_on_a_disc() {
    let known = Known {
        bounds: vec![Span::new(-1.5, 1.5); 2],
        equalities: 0,
        evaluate: rosenbrock,
    };
    // The promise of the last step is below 1e-10.
    check(&known, &[-1.2, 1.0], &[1.0, 1.0], 0.0, 1e-8);
    check(&known, &[0.0, 0.0], &[1.0, 1.0], 0.0, 1e-8);
}

#[test]
fn hock_schittkowski_problem_71() {
    let known = Known {
        bounds: vec![Span::new(1.0, 5.0); 4],
        equalities: 1,
        evaluate: hock_schittkowski_71,
    };
    // The published digits.
    check(
        &known,
        &[1.0, 5.0, 5.0, 1.0],
        &[1.0, 4.742_999_4, 3.821_150_3, 1.379_408_2],
        17.014_017_3,
        1e-7,
    );
}

#[test]
fn an_impossible_program_says_which_row_and_by_how_much() {
    let known = Known {
        bounds: vec![Span::new(-5.0, 5.0)],
        equalities: 0,
        evaluate: impossible,
    };
    let report = solve(&known, &[3.0], &Settings::default());
    let Status::Infeasible { violation, .. } = report.status else {
        panic!("{report:?}")
    };
    // The solver's.
    assert!((violation - 1.0).abs() < 1e-6, "{report:?}");
}
