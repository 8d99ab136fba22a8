//! What the tests of this crate share: random flights, tolerances, finite differences.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use saltus_numeric::Dual;

use crate::Flight;

/// The same cases on every run.
pub(crate) fn config() -> ProptestConfig {
    ProptestConfig {
        rng_seed: RngSeed::Fixed(2),
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

/// Flights over far more than a robot's range: from a crawl to a cannon, from an asteroid's to
/// Jupiter's gravity.
pub(crate) fn flights() -> impl Strategy<Value = Flight<f64>> {
    (
        -10.0..10.0,
        -1.0..10.0,
        -50.0..50.0,
        -50.0..50.0,
        -3.0..1.5_f64,
    )
        .prop_map(|(x, y, vx, vy, magnitude)| Flight {
            x,
            y,
            vx,
            vy,
            gravity: 10_f64.powf(magnitude),
        })
}

/// |a − b| ≤ `tolerance` relative to the larger of 1 and |b|.
pub(crate) fn close(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance * b.abs().max(1.0)
}

/// The flight with each number of its state as a variable of its own.
pub(crate) fn dual(flight: Flight<f64>) -> Flight<Dual<5>> {
    let Flight {
        x,
        y,
        vx,
        vy,
        gravity,
    } = flight;
    let v = Dual::variable;
    Flight {
        x: v(x, 0),
        y: v(y, 1),
        vx: v(vx, 2),
        vy: v(vy, 3),
        gravity: v(gravity, 4),
    }
}

/// Compares the slopes of `exact` with central differences of `f` over each number of the flight.
pub(crate) fn check_slopes(flight: Flight<f64>, exact: Dual<5>, f: impl Fn(Flight<f64>) -> f64) {
    for (i, slope) in exact.slope.into_iter().enumerate() {
        let moved = |by: f64| {
            let mut moved = flight;
            *[
                &mut moved.x,
                &mut moved.y,
                &mut moved.vx,
                &mut moved.vy,
                &mut moved.gravity,
            ][i] += by;
            f(moved)
        };
        // Richardson's combination of steps h and h/2: truncation h⁴, round-off 1e-15/h.
        let h = 1e-5 * [1.0, 1.0, 1.0, 1.0, flight.gravity][i];
        let central = |h: f64| (moved(h) - moved(-h)) / (2.0 * h);
        let numeric = (4.0 * central(h / 2.0) - central(h)) / 3.0;
        assert!(
            close(slope, numeric, 1e-6),
            "direction {i}: {slope} exact, {numeric} by differences"
        );
    }
}
