//! A linear measurement model, whose answers are known in closed form, for the tests of the stages;
//! and small experiments for those of the kinds.

use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

use crate::experiment::{Experiment, Run, Sort};
use crate::fit::{self, Fit};
use crate::kind::{Cause, Channel, Data, Kind, Log, Parameter, Reading, Terms};

/// Runs, and readings in each.
pub(crate) const RUNS: usize = 8;
pub(crate) const READINGS: usize = 50;
/// Readings in all.
pub(crate) const ALL: usize = RUNS * READINGS;

/// y = Σ θ_k a_k + noise of one σ: a cause for each column a_k, off at θ_k = 0.
pub(crate) struct Toy {
    data: Data,
    columns: Vec<Vec<f64>>,
    discrepancy: f64,
}

/// `ALL` numbers with unit length, one of an orthonormal set for each `k`: waves over all readings.
pub(crate) fn wave(k: usize) -> Vec<f64> {
    let phase = |i: usize| std::f64::consts::PI * (k as f64 + 1.0) * (i as f64 + 0.5) / ALL as f64;
    let size = f64::sqrt(2.0 / ALL as f64);
    (0..ALL).map(|i| size * phase(i).cos()).collect()
}

/// Independent noise of one σ.
pub(crate) fn noise(seed: u128) -> Vec<f64> {
    let mut random = Pcg64::new(seed, 9);
    (0..ALL)
        .map(|_| StandardNormal.sample(&mut random))
        .collect()
}

/// Σ c_k v_k.
pub(crate) fn sum(parts: &[(f64, &[f64])]) -> Vec<f64> {
    let at = |i: usize| parts.iter().map(|(c, v)| c * v[i]).sum();
    (0..parts[0].1.len()).map(at).collect()
}

impl Toy {
    /// Readings `values` with a cause for each of `columns`, the first of them called `"a"`.
    pub(crate) fn new(values: &[f64], columns: Vec<Vec<f64>>) -> Toy {
        const IDS: [&str; 12] = ["a", "b", "c", "d", "e", "f", "g", "h", "i", "j", "k", "l"];
        let reading = |(k, value): (usize, &f64)| Reading {
            channel: 0,
            time: k as f64,
            value: *value,
            weight: 1.0,
        };
        let log = |(run, values): (usize, &[f64])| Log {
            name: format!("run-{run}"),
            readings: values.iter().enumerate().map(reading).collect(),
        };
        let cause = |(k, _): (usize, &Vec<f64>)| {
            let name = format!("{}_n", IDS[k]);
            Cause::one(IDS[k], Parameter::new(&name, 0.0, (-1e6, 1e6), 1.0))
        };
        Toy {
            data: Data {
                channels: vec![Channel {
                    name: "y_m".into(),
                    noise: 1.0,
                    step: 0.0,
                    is_given: true,
                }],
                logs: values.chunks(READINGS).enumerate().map(log).collect(),
                causes: columns.iter().enumerate().map(cause).collect(),
                listed: columns.len(),
                ..Data::default()
            },
            columns,
            discrepancy: 0.0,
        }
    }

    /// With all readings in one run.
    pub(crate) fn in_one_run(mut self) -> Toy {
        let readings = self.data.logs.drain(..).flat_map(|log| log.readings);
        let readings = readings.collect();
        self.data.logs = vec![Log {
            name: "run-0".into(),
            readings,
        }];
        self
    }

    /// With a smooth error of the model in the noise (σ).
    pub(crate) fn with_discrepancy(mut self, amplitude: f64) -> Toy {
        self.discrepancy = amplitude;
        self
    }

    /// With readings that are rounded to so many σ.
    pub(crate) fn rounded_to(mut self, step: f64) -> Toy {
        self.data.channels[0].step = step;
        self
    }

    /// With a cause changed.
    pub(crate) fn with(mut self, cause: usize, change: impl FnOnce(&mut Cause)) -> Toy {
        change(&mut self.data.causes[cause]);
        self
    }

    /// Without a cause.
    pub(crate) fn before(&self) -> Fit {
        fit::fit_none(self, &(0..RUNS).collect::<Vec<_>>()).expect("an answer")
    }

    /// With these causes, fitted.
    pub(crate) fn fitted(&self, causes: &[usize]) -> Fit {
        let fit = causes.iter().try_fold(self.before(), |base, &cause| {
            fit::fit_with(self, &base, cause, &(0..RUNS).collect::<Vec<_>>())
        });
        fit.expect("an answer")
    }
}

impl Kind for Toy {
    fn data(&self) -> &Data {
        &self.data
    }

    fn unknowns(&self, _: usize) -> Vec<Parameter> {
        Vec::new()
    }

    fn discrepancy(&self) -> f64 {
        self.discrepancy
    }

    fn predict(&self, run: usize, terms: &Terms, _: &[f64]) -> Option<Vec<f64>> {
        let at = |i: usize| {
            let columns = self.columns.iter().enumerate();
            columns.map(|(k, a)| terms.get(k, 0) * a[i]).sum()
        };
        Some((run * READINGS..(run + 1) * READINGS).map(at).collect())
    }
}

/// The terms of `kind` with parameters set: of the cause with an id, about a column if one is named,
/// the parameter of a number.
pub(crate) fn terms(kind: &dyn Kind, on: &[(&str, usize, f64)]) -> Terms {
    let mut terms = Terms::off(kind.causes());
    for (name, parameter, value) in on {
        let (id, column) = name.split_once('@').unwrap_or((name, ""));
        let is_it =
            |c: &Cause| c.id == id && (column.is_empty() || c.column.as_deref() == Some(column));
        let cause = kind.causes().iter().position(is_it);
        terms.set(cause.expect("a cause"), *parameter, *value);
    }
    terms
}

/// An experiment of one run, of columns with their values, whose noise is 1e-6 of their units.
pub(crate) fn measured(
    kind: Sort,
    settings: &[(&str, f64)],
    time: &[f64],
    columns: &[(&str, Vec<f64>)],
) -> Experiment {
    Experiment {
        kind,
        mechanism: None,
        columns: columns.iter().map(|(name, _)| (*name).into()).collect(),
        noise: vec![Some(1e-6); columns.len()],
        resolution: vec![None; columns.len()],
        runs: vec![Run {
            settings: settings
                .iter()
                .map(|(key, x)| ((*key).into(), *x))
                .collect(),
            time: time.to_vec(),
            values: columns.iter().map(|(_, values)| values.clone()).collect(),
            ..Run::default()
        }],
    }
}
