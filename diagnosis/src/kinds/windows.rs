//! Runs cut into short windows: what begins anew every moment from what is measured stays near the data,
//! whatever its friction, so that small steps lead from any guess to the truth (multiple shooting: Bock,
//! Recent advances in parameter identification for ODE, 1983).

use saltus_robot::Robot;

use crate::experiment::{Experiment, Run};
use crate::kind::{Data, Kind, Parameter};

/// An experiment of a kind whose runs may begin anywhere.
pub(super) struct Restarting {
    pub(super) whole: Box<dyn Kind>,
    pub(super) experiment: Experiment,
    pub(super) robot: Option<Robot>,
}

impl Kind for Restarting {
    fn data(&self) -> &Data {
        self.whole.data()
    }

    fn inner(&self) -> Option<&dyn Kind> {
        Some(self.whole.as_ref())
    }

    fn unknowns(&self, run: usize) -> Vec<Parameter> {
        self.whole.unknowns(run)
    }

    fn windows(&self, count: usize) -> Option<Box<dyn Kind>> {
        let runs = self
            .experiment
            .runs
            .iter()
            .flat_map(|run| cut(run, count))
            .collect();
        let experiment = Experiment {
            runs,
            ..self.experiment.clone()
        };
        let model = experiment.kind.spec().model;
        let windows = model(&experiment, self.robot.as_ref()).ok()?;
        let ids = |kind: &dyn Kind| -> Vec<(&str, usize)> {
            kind.causes()
                .iter()
                .map(|c| (c.id, c.parameters.len()))
                .collect()
        };
        (ids(windows.as_ref()) == ids(self.whole.as_ref())).then_some(windows)
    }
}

/// `count` windows of a run, of 20 rows at least.
fn cut(run: &Run, count: usize) -> Vec<Run> {
    const LEAST: usize = 20;
    let rows = run.time.len();
    let count = count.min(rows / LEAST).max(1);
    let window = |k: usize| {
        let rows = k * rows / count..(k + 1) * rows / count;
        Run {
            time: run.time[rows.clone()].to_vec(),
            values: run
                .values
                .iter()
                .map(|column| column[rows.clone()].to_vec())
                .collect(),
            ..run.clone()
        }
    };
    (0..count).map(window).collect()
}
