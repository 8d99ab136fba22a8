//! From just after touch-down of the jumping leg, through the flight.

use super::hop::{BOOM_COUNT, TRACKED};
use super::robot;
use crate::experiment::Sort;
use crate::layout::TICK;
use crate::plausible::{Check, HEIGHT, LENGTHS, PIVOT, RATES, SUPPLY as SUPPLIED};
use crate::spec::{
    LEAP, LOGGED, RATE, Rest, SUPPLY, Source, Spec, Synthesis, TILT, TURN, YAW, counting, lively,
    noisy, required, without,
};

/// Step (rad) of the encoder of the wheel.
const WHEEL_COUNT: f64 = 7.854e-3;

/// The kind.
pub(super) const SPEC: Spec = Spec {
    sort: Sort::Jump,
    id: "jump",
    description: "From touch-down through the flight",
    robot: Some("rats-boom"),
    rest: [Rest::Cut; 2],
    channels: &[
        lively("wheel_angle_rad", TURN),
        without(lively("pivot_angle_rad", TILT)),
        without(lively("radius_angle_rad", YAW)),
        without(lively("wheel_rate_rad_s", RATE)),
        without(lively("x_m", LEAP)),
        without(lively("y_m", LEAP)),
    ],
    settings: &[required("supply_pressure_gauge_pa", SUPPLY)],
    checks: &[
        SUPPLIED,
        PIVOT,
        HEIGHT,
        Check {
            name: "x_m",
            sizes: |view| {
                let rate = view.span("wheel_angle_rad")? / view.length()?;
                Some((view.span("x_m")?, view.throw(rate)?))
            },
            what: "the distance that the work of the leg is good for",
            allowed: (0.0, 3.0),
            strict: false,
            units: LENGTHS,
        },
        Check {
            name: "wheel_rate_rad_s",
            sizes: |view| view.rates(),
            what: "the slope of wheel_angle_rad before the command",
            allowed: (0.25, 4.0),
            strict: false,
            units: RATES,
        },
    ],
    model: robot::model,
    synthesis: Synthesis {
        instruments: &[
            counting("wheel_angle_rad", WHEEL_COUNT),
            counting("pivot_angle_rad", BOOM_COUNT),
            counting("radius_angle_rad", BOOM_COUNT),
            noisy("wheel_rate_rad_s", 0.03),
        ],
        without_boom: Some(&[
            counting("wheel_angle_rad", WHEEL_COUNT),
            noisy("wheel_rate_rad_s", 0.03),
            noisy("x_m", TRACKED),
            noisy("y_m", TRACKED),
        ]),
        runs: 12,
        // The simulation says how long they are.
        lay_out: |layout, runs, _| {
            (0..runs).for_each(|_| layout.add(&[], 3, TICK, Vec::new()));
        },
        source: Source::Robot,
    },
    ..LOGGED
};
