//! Logs of a running robot, by the multi-body simulation under the controller.

use saltus_diagnosis::layout::Layout;
use saltus_diagnosis::{Experiment, Run};
use saltus_gait::{Logged, Logger, Setup, Smooth, run};
use saltus_robot::Robot;

use super::Error;

/// Length (s) of a run.
const LONG: f64 = 6.0;
/// Where the active zone begins (rad) of laws over the rate, as `saltus run` has it.
const ZONE: f64 = -0.3;

/// Fills the runs of a layout with logs of `robot`, which the operator believes to be `believed`:
/// the smooth laws in turn. Its instruments have their noise and their counts.
pub(super) fn fill(
    layout: &mut Layout,
    believed: &Robot,
    robot: &Robot,
    seed: u64,
) -> Result<(), Error> {
    if believed.boom.is_none() {
        let robot = believed.name.clone();
        return Err(Error::NoBoom { robot });
    }
    let wanted = layout.experiment.runs.len();
    let supply = believed.leg.cylinder().map(|cylinder| cylinder.supply.0);
    let mut columns = Vec::new();
    for number in 0..wanted {
        let law = [Smooth::QUICK, Smooth::SPARING][number % 2];
        let setup = Setup {
            zone: ZONE,
            seed: seed.wrapping_add(number as u64),
            ..Setup::new(robot.clone(), law.program(), LONG)
        };
        let mut log = Logged::new(robot);
        if run(&setup, &mut log).is_err() {
            return Err(Error::NoMotion {
                made: number,
                wanted,
                least: wanted,
            });
        }
        columns = log.columns();
        let place = &mut layout.experiment.runs[number];
        place
            .settings
            .extend(supply.map(|supply| ("supply_pressure_gauge_pa".to_owned(), supply)));
        (place.time, place.values) = (log.time, log.values);
    }
    let errors: Vec<_> = columns
        .iter()
        .map(|name| Logger::errors(robot, name))
        .collect();
    let experiment = &mut layout.experiment;
    experiment.noise = errors.iter().map(|error| error.0).collect();
    experiment.resolution = errors.iter().map(|error| error.1).collect();
    experiment.columns = columns;
    Ok(())
}

/// What sensors with gain, offset and delay (s) of each column make of an experiment.
pub(super) fn sensed(experiment: &mut Experiment, of: impl Fn(&str) -> [f64; 3]) {
    let Experiment { columns, runs, .. } = experiment;
    for (k, column) in columns.iter().enumerate() {
        let [gain, offset, delay] = of(column);
        for Run { time, values, .. } in &mut *runs {
            let exact = values[k].clone();
            let late = |row: usize| {
                let then = time[row] - delay + 1e-9;
                let last = time.partition_point(|t| *t <= then);
                let measured = exact[..last].iter().rev().find(|x| x.is_finite());
                *measured.unwrap_or(&exact[row])
            };
            for (row, value) in values[k].iter_mut().enumerate() {
                if value.is_finite() {
                    *value = gain * if delay > 0.0 { late(row) } else { *value } + offset;
                }
            }
        }
    }
}
