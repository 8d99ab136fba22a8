//! Tests of the supply and of the muscle, in one binary: linking is what takes time.

mod closed_forms;
mod muscle;
mod passage;
mod supply;

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use saltus_robot::Gas;

/// So many cases, the same in each run.
fn cases(count: u32) -> ProptestConfig {
    ProptestConfig {
        rng_seed: RngSeed::Fixed(1),
        failure_persistence: None,
        ..ProptestConfig::with_cases(count)
    }
}

/// From `low` to `high`, each power of ten as likely as the next.
fn decades(low: f64, high: f64) -> impl Strategy<Value = f64> {
    (low.ln()..high.ln()).prop_map(f64::exp)
}

/// Gases of robots, and any other from heavy molecules to helium.
fn gases() -> impl Strategy<Value = Gas> {
    let any = (1.05..1.67, 50.0..2100.0).prop_map(|(heat_ratio, constant)| Gas {
        heat_ratio,
        constant,
    });
    prop_oneof![Just(Gas::AIR), Just(Gas::CO2), Just(Gas::NITROGEN), any]
}

/// Asserts that `a` is `b` to `tolerance`, relative to `b`.
#[track_caller]
fn near(a: f64, b: f64, tolerance: f64) {
    let off = (a - b).abs() / b.abs();
    assert!(off <= tolerance, "{a} is not {b}: off by {off:e}");
}
