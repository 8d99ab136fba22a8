//! One row a jump: what was asked for and where it went.

use saltus_numeric::statistics::quantile;

use super::robot;
use crate::experiment::Sort;
use crate::plausible::{Check, JUMPS, RATES};
use crate::spec::{LEAP, OPENING, PART, RATE, Source, Spec, Synthesis, TILT, asked, lively, noisy};

/// The kind.
pub(super) const SPEC: Spec = Spec {
    sort: Sort::Outcomes,
    id: "outcomes",
    description: "What was asked of jumps and where they went",
    robot: Some("rats-boom"),
    channels: &[
        asked("omega_rad_s", RATE),
        asked("alpha_f_rad", TILT),
        asked("valve_open_s", OPENING),
        lively("distance_m", LEAP),
        lively("apex_m", LEAP),
    ],
    timed: false,
    least: 3,
    checks: &[
        Check {
            name: "omega_rad_s",
            sizes: |view| {
                let robot = view.robot?;
                let lifts = (robot.environment.gravity / robot.body.radius).sqrt();
                Some((quantile(view.column("omega_rad_s")?, 0.5)?, lifts))
            },
            what: "the rate at which a wheel on a rigid leg lifts off",
            allowed: (0.05, 4.0),
            strict: false,
            units: RATES,
        },
        Check {
            name: "apex_m",
            sizes: |view| {
                Some((
                    quantile(view.column("apex_m")?, 0.5)?,
                    view.rise()? + view.robot?.body.radius,
                ))
            },
            what: "the height that the work of the leg is good for",
            allowed: (0.02, 3.0),
            strict: false,
            units: JUMPS,
        },
        Check {
            name: "distance_m",
            sizes: |view| {
                let throw = view.throw(quantile(view.column("omega_rad_s")?, 0.5)?)?;
                Some((quantile(view.column("distance_m")?, 0.5)?, throw))
            },
            what: "the distance that the work of the leg is good for",
            allowed: (0.02, 3.0),
            strict: false,
            units: JUMPS,
        },
    ],
    model: robot::model,
    synthesis: Synthesis {
        instruments: &[
            noisy("omega_rad_s", 0.0),
            noisy("alpha_f_rad", 0.0),
            noisy("valve_open_s", 0.0),
            noisy("distance_m", 3e-3),
            noisy("apex_m", 2e-3),
        ],
        without_boom: None,
        runs: 50,
        // One run, and so many rows of it.
        lay_out: |layout, rows, _| layout.add(&[], rows, 1.0, Vec::new()),
        source: Source::Robot,
    },
    ..PART
};
