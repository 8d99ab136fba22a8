//! The robot at rest, upright on one leg, fired once.

use super::robot;
use crate::experiment::Sort;
use crate::layout::TICK;
use crate::plausible::{HEIGHT, PIVOT, SUPPLY as SUPPLIED};
use crate::spec::{
    LEAP, LOGGED, Rest, SUPPLY, Source, Spec, Synthesis, TILT, counting, lively, noisy, required,
    without,
};

/// Step (rad) of the encoders of the boom.
pub(super) const BOOM_COUNT: f64 = 3.927e-3;

/// Standard deviation (m) of a place that cameras see.
pub(super) const TRACKED: f64 = 2e-3;

/// The kind.
pub(super) const SPEC: Spec = Spec {
    sort: Sort::Hop,
    id: "hop",
    description: "The robot at rest on one leg, fired",
    robot: Some("rats-boom"),
    // It stands until it is fired; after the landing it does what nobody models.
    rest: [Rest::Thin, Rest::Cut],
    channels: &[
        without(lively("pivot_angle_rad", TILT)),
        without(lively("y_m", LEAP)),
    ],
    settings: &[required("supply_pressure_gauge_pa", SUPPLY)],
    checks: &[SUPPLIED, PIVOT, HEIGHT],
    // Nothing pivots before the command.
    phase: |phase| if phase == "pivot" { "at rest" } else { phase },
    model: robot::model,
    synthesis: Synthesis {
        instruments: &[counting("pivot_angle_rad", BOOM_COUNT)],
        without_boom: Some(&[noisy("y_m", TRACKED)]),
        runs: 12,
        // The simulation says how long they are.
        lay_out: |layout, runs, _| {
            (0..runs).for_each(|_| layout.add(&[], 3, TICK, Vec::new()));
        },
        source: Source::Robot,
    },
    ..LOGGED
};
