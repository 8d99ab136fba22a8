//! What is measured in a run: its firings, and the wheel and the height row by row.

use saltus_robot::Robot;

use crate::experiment::{Experiment, Run};
use crate::spec::Problem;

/// Time (s) after a touch-down in which its impact is over, and before the next one.
pub(super) const MARGIN: f64 = 4e-3;

/// A stride within a run.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    /// Its first and its last row.
    pub(super) from: usize,
    pub(super) to: usize,
    /// Wheel angle less lean (rad).
    pub(super) base: f64,
    /// Where it begins in the air, the last row there.
    pub(super) air: Option<usize>,
}

/// A firing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Firing {
    pub(super) leg: usize,
    pub(super) open: f64,
    pub(super) shut: f64,
}

/// The columns of the valves, leg by leg.
pub(super) fn valves(experiment: &Experiment, robot: &Robot) -> Result<Vec<usize>, Problem> {
    let legs = robot.body.legs as usize;
    let of = |leg: usize| experiment.column(&format!("valve_{leg}"));
    let refused = |leg: usize, is_missing| Problem::Valves {
        robot: robot.name.clone(),
        legs,
        column: format!("valve_{leg}"),
        is: if is_missing {
            "missing"
        } else {
            "one too many"
        },
    };
    if let Some(leg) = (legs + 1..=12).find(|leg| of(*leg).is_some()) {
        return Err(refused(leg, false));
    }
    (1..=legs)
        .map(|leg| of(leg).ok_or_else(|| refused(leg, true)))
        .collect()
}

/// The firings of a run in the order of time.
pub(super) fn firings(run: &Run, valves: &[usize]) -> Result<Vec<Firing>, Problem> {
    let mut all = Vec::new();
    for (leg, &column) in valves.iter().enumerate() {
        let mut before: Option<f64> = None;
        let mut open = None;
        for (time, &output) in run.time.iter().zip(&run.values[column]) {
            if output.is_nan() {
                continue;
            }
            if output != 0.0 && output != 1.0 {
                return Err(Problem::Output {
                    run: run.name.clone(),
                    column: format!("valve_{}", leg + 1),
                    value: output,
                    time: *time,
                });
            }
            if output == 1.0 && before == Some(0.0) {
                open = Some(*time);
            }
            if output == 0.0
                && let Some(open) = open.take()
            {
                all.push(Firing {
                    leg,
                    open,
                    shut: *time,
                });
            }
            before = Some(output);
        }
    }
    if all.is_empty() {
        return Err(Problem::NeverFires {
            run: run.name.clone(),
            last: valves.len(),
        });
    }
    all.sort_by(|a, b| a.open.total_cmp(&b.open));
    Ok(all)
}

/// What is measured in a run, row by row where both wheel and height are.
pub(super) struct Track<'a> {
    pub(super) experiment: &'a Experiment,
    pub(super) time: Vec<f64>,
    pub(super) wheel: Vec<f64>,
    pub(super) height: Vec<f64>,
}

impl Track<'_> {
    /// The row at `time`, or the next one.
    pub(super) fn row(&self, time: f64) -> usize {
        self.time.partition_point(|t| *t < time - 1e-9)
    }

    /// The readings of a stride from and to a time (s), as a run of kind jump.
    pub(super) fn run(&self, run: &Run, firing: Firing, window: &Window) -> Run {
        let (from, to) = (self.time[window.from], self.time[window.to]);
        let rows: Vec<usize> = (0..run.time.len())
            .filter(|&row| (from..=to).contains(&run.time[row]))
            .collect();
        let value = |column: usize| {
            let name = self.experiment.columns[column].as_str();
            let measured = || rows.iter().map(|&row| run.values[column][row]);
            let zero = match name {
                "wheel_angle_rad" => window.base,
                "radius_angle_rad" | "x_m" => measured().find(|x| x.is_finite()).unwrap_or(0.0),
                _ => 0.0,
            };
            measured().map(|x| x - zero).collect()
        };
        Run {
            name: format!(
                "{} leg {} at {:.3} s",
                run.name,
                firing.leg + 1,
                firing.open
            ),
            settings: run.settings.clone(),
            valve: Some((firing.open, Some(firing.shut))),
            time: rows.iter().map(|&row| run.time[row]).collect(),
            values: measured(self.experiment).map(value).collect(),
        }
    }
}

/// The columns that a stride keeps.
pub(super) fn measured(experiment: &Experiment) -> impl Iterator<Item = usize> + '_ {
    let is_kept = |name: &String| !name.starts_with("valve_");
    (0..experiment.columns.len()).filter(move |k| is_kept(&experiment.columns[*k]))
}
