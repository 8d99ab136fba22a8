//! Experiments with a robot that could be done.

use std::collections::BTreeMap;

use saltus_robot::Robot;

use super::Firings;
use crate::experiment::{Experiment, Run, Sort};
use crate::kind::Proposal;

/// A run of `length` (s), sampled every 2 ms, whose columns read 0 but for the first rows of what
/// starts it.
fn run(
    columns: usize,
    length: f64,
    settings: &[(&str, f64)],
    valve: (f64, f64),
    first: &[f64],
) -> Run {
    // The number of rows.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let rows = (length / 2e-3) as usize;
    Run {
        name: "proposal".into(),
        settings: settings
            .iter()
            .map(|(k, v)| ((*k).to_owned(), *v))
            .collect::<BTreeMap<_, _>>(),
        valve: Some((valve.0, Some(valve.0 + valve.1))),
        time: (0..rows).map(|i| i as f64 * 2e-3).collect(),
        values: (0..columns)
            .map(|c| vec![first.get(c).copied().unwrap_or(0.0); rows])
            .collect(),
    }
}

fn experiment(kind: Sort, columns: &[(&str, f64)], run: Run) -> Experiment {
    Experiment {
        kind,
        mechanism: None,
        columns: columns.iter().map(|c| c.0.to_owned()).collect(),
        noise: columns.iter().map(|c| Some(c.1)).collect(),
        resolution: vec![None; columns.len()],
        runs: vec![run],
    }
}

/// Benchtop firings, hops and jumps of `robot` over its range of pressures, loads, opening times
/// and approach rates.
pub(super) fn of(robot: &Robot) -> Vec<Proposal> {
    let Some(cylinder) = robot.leg.cylinder() else {
        return Vec::new();
    };
    let full = cylinder.supply.0;
    let supplies = [0.5 * full, full].into_iter();
    let all = supplies.flat_map(|supply| firings(supply).into_iter().chain(hops(supply)));
    all.chain(jumps(full))
        .filter_map(|(what, experiment)| {
            let kind = Box::new(Firings::new(&experiment, robot).ok()?);
            Some(Proposal { what, kind })
        })
        .collect()
}

/// Firings on the bench at the gauge pressure `supply` (Pa).
fn firings(supply: f64) -> [(String, Experiment); 3] {
    [0.5, 2.25, 4.5].map(|load| {
        let settings = [("load_mass_kg", load), ("supply_pressure_gauge_pa", supply)];
        let columns = [("position_m", 1e-4), ("pressure_pa", 2e3)];
        let what = format!(
            "fire the leg on the bench under {load} kg at {:.0} kPa gauge",
            supply / 1e3
        );
        let run = run(2, 0.2, &settings, (5e-3, 1.0), &[]);
        (what, experiment(Sort::Bench, &columns, run))
    })
}

/// Hops at the gauge pressure `supply` (Pa).
fn hops(supply: f64) -> [(String, Experiment); 3] {
    [0.02, 0.04, 0.08].map(|open| {
        let settings = [("supply_pressure_gauge_pa", supply)];
        let what = format!(
            "hop upright with the valve open for {:.0} ms at {:.0} kPa gauge",
            1e3 * open,
            supply / 1e3
        );
        let run = run(1, 0.5, &settings, (5e-3, open), &[]);
        (
            what,
            experiment(Sort::Hop, &[("pivot_angle_rad", 1.13e-3)], run),
        )
    })
}

/// Jumps at the gauge pressure `supply` (Pa).
fn jumps(supply: f64) -> impl Iterator<Item = (String, Experiment)> {
    let columns = [
        ("wheel_angle_rad", 2.27e-3),
        ("pivot_angle_rad", 1.13e-3),
        ("radius_angle_rad", 1.13e-3),
        ("wheel_rate_rad_s", 0.03),
    ];
    let starts = [(-0.35, 0.05), (-0.2, 0.1), (-0.2, 0.2)];
    let all = [3.0, 4.5, 6.0]
        .into_iter()
        .flat_map(move |rate| starts.map(|(lean, fire)| (rate, lean, fire)));
    all.map(move |(rate, lean, fire)| {
        let settings = [("supply_pressure_gauge_pa", supply)];
        let what = format!(
            "jump from a lean of {lean} rad at {rate} rad/s, {:.0} ms later",
            1e3 * fire
        );
        let first = [lean, 0.0, 0.0, rate];
        let run = run(4, 0.6, &settings, (fire, 0.08), &first);
        (what, experiment(Sort::Jump, &columns, run))
    })
}
