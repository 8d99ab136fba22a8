//! One cylinder upright, fired once from rest under a dead load.

use saltus_numeric::statistics::quantile;

use super::robot;
use crate::experiment::Sort;
use crate::layout::{Draw, Layout, TICK, supply};
use crate::plausible::{Check, LENGTHS, MASSES, PRESSURES, SUPPLY as SUPPLIED, TURNED};
use crate::spec::{
    CHAMBER, LOAD, LOGGED, POSITION, Rest, SUPPLY, Source, Spec, Synthesis, lively, noisy,
    required, without,
};

/// The kind.
pub(super) const SPEC: Spec = Spec {
    sort: Sort::Bench,
    id: "bench",
    description: "One leg upright, fired under a dead load",
    robot: Some("rats-planar"),
    rest: [Rest::Thin; 2],
    channels: &[
        lively("position_m", POSITION),
        without(lively("pressure_pa", CHAMBER)),
    ],
    settings: &[
        required("load_mass_kg", LOAD),
        required("supply_pressure_gauge_pa", SUPPLY),
    ],
    checks: &[
        Check {
            name: "position_m",
            sizes: |view| Some((view.travel("position_m")?, view.robot?.leg.stroke)),
            what: "the stroke of the leg",
            allowed: (TURNED, 2.0),
            strict: true,
            units: LENGTHS,
        },
        Check {
            name: "pressure_pa",
            sizes: |view| {
                Some((
                    quantile(view.column("pressure_pa")?, 0.95)?,
                    view.supply()? + view.ambient()?,
                ))
            },
            what: "the absolute supply pressure",
            allowed: (0.02, 5.0),
            strict: false,
            units: PRESSURES,
        },
        Check {
            name: "load_mass_kg",
            sizes: |view| {
                let heaviest = view.thrust()? / view.robot?.environment.gravity;
                Some((view.setting("load_mass_kg")?, 0.1 * heaviest))
            },
            what: "a tenth of the heaviest load that the leg lifts",
            allowed: (TURNED, 50.0),
            strict: false,
            units: MASSES,
        },
        SUPPLIED,
    ],
    // Nothing pivots before the command.
    phase: |phase| if phase == "pivot" { "at rest" } else { phase },
    model: robot::model,
    synthesis: Synthesis {
        instruments: &[noisy("position_m", 1e-4), noisy("pressure_pa", 2e3)],
        without_boom: None,
        runs: 12,
        lay_out: |layout, runs, draw| (0..runs).for_each(|_| fire(layout, draw)),
        source: Source::Model,
    },
    ..LOGGED
};

/// Adds a firing on the bench.
fn fire(layout: &mut Layout, draw: &mut Draw) {
    let load = layout.strength * draw.stepped(1.2, 4.0, 1e-3);
    let supply = supply(layout.supply, 6.0, 12.0, draw);
    layout.add(
        &[("load_mass_kg", load), ("supply_pressure_gauge_pa", supply)],
        151,
        TICK,
        Vec::new(),
    );
    if let Some(run) = layout.experiment.runs.last_mut() {
        run.valve = Some((0.01, None));
    }
}
