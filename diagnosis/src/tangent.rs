//! The model near a fit: what small changes would do, what chance alone does, and how surely
//! parameters are known.

use nalgebra::{DMatrix, DVector};
use rand_distr::{Distribution, StandardNormal, StandardUniform};
use rand_pcg::Pcg64;

use crate::fit::{Fit, Place, derivative, dot, predicted, residuals, weight};
use crate::kind::Kind;
use crate::parallel;

/// Directions in the space of all readings, in standard deviations, one value for each reading of
/// each run in turn.
pub(crate) struct Tangent {
    /// For each candidate, directions clear of what the unknowns and the causes that are on can do;
    /// one that cannot be reached in small steps has one for each of its starts.
    pub(crate) candidates: Vec<Direction>,
    /// Directions of the causes that are on, clear of the unknowns, in units of the parameters'
    /// scales.
    on: Vec<Vec<f64>>,
    /// Which of them rest at a bound where they do nothing: the others are known as if these were
    /// not there.
    rests: Vec<bool>,
    /// The directions of causes that are on, orthonormal.
    clear: Vec<Vec<f64>>,
    /// Orthonormal directions of the unknowns of each run, within the run.
    own: Vec<Vec<Vec<f64>>>,
    /// What the model says, in standard deviations.
    pub(crate) predicted: Vec<f64>,
    /// Where each run begins, and the end.
    bounds: Vec<usize>,
}

/// How surely the parameters of the causes that are on are known, in units of their scales.
pub(crate) struct Known {
    /// Covariance that noise of the readings and of measured inputs gives.
    pub(crate) covariance: DMatrix<f64>,
    /// The part of the readings alone.
    pub(crate) by_readings: DMatrix<f64>,
    /// Least eigenvalue of the information when each parameter alone has information 1.
    pub(crate) least: f64,
    /// Its direction.
    pub(crate) direction: Vec<f64>,
}

/// What a candidate could do to the readings.
pub(crate) struct Direction {
    pub(crate) cause: usize,
    columns: Vec<Vec<f64>>,
    /// Inverse of the columns' products.
    inverse: DMatrix<f64>,
    /// Whether the first parameter can only grow.
    one_sided: bool,
}

impl Direction {
    /// By how much the loss of `residuals` would fall.
    pub(crate) fn gain(&self, residuals: &[f64]) -> f64 {
        let g = DVector::from_iterator(
            self.columns.len(),
            self.columns.iter().map(|c| dot(c, residuals)),
        );
        let step = &self.inverse * &g;
        if self.one_sided && step[0] < 0.0 {
            0.0
        } else {
            g.dot(&step)
        }
    }
}

/// Takes from `column` what the orthonormal directions `own` of each run can do.
fn clear_own(column: &mut [f64], own: &[Vec<Vec<f64>>], bounds: &[usize]) {
    for (run, directions) in own.iter().enumerate() {
        let here = &mut column[bounds[run]..bounds[run + 1]];
        for direction in directions {
            let part = dot(direction, here);
            for (x, d) in here.iter_mut().zip(direction) {
                *x -= part * d;
            }
        }
    }
}

/// Orthonormal directions that span `columns`, those that are not nearly in the span of the ones
/// before.
fn orthonormal(columns: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let mut all: Vec<Vec<f64>> = Vec::new();
    for mut column in columns {
        let whole = dot(&column, &column);
        for _ in 0..2 {
            for other in &all {
                let part = dot(other, &column);
                for (x, o) in column.iter_mut().zip(other) {
                    *x -= part * o;
                }
            }
        }
        let left = dot(&column, &column);
        if left > 1e-12 * whole && left > 0.0 {
            let size = left.sqrt();
            for x in &mut column {
                *x /= size;
            }
            all.push(column);
        }
    }
    all
}

/// What `cause` could do by `raw`, clear of the orthonormal directions `clear`; none where that is
/// nothing.
fn direction(
    cause: usize,
    raw: Vec<Vec<f64>>,
    clear: &[Vec<f64>],
    one_sided: bool,
) -> Option<Direction> {
    let mut columns: Vec<Vec<f64>> = Vec::new();
    for mut column in raw {
        let whole = dot(&column, &column);
        for other in clear {
            let part = dot(other, &column);
            for (x, o) in column.iter_mut().zip(other) {
                *x -= part * o;
            }
        }
        let left = dot(&column, &column);
        if left > 1e-8 * whole && left > 1e-20 {
            let size = left.sqrt();
            for x in &mut column {
                *x /= size;
            }
            columns.push(column);
        }
    }
    let n = columns.len();
    let products = DMatrix::from_fn(n, n, |i, j| dot(&columns[i], &columns[j]));
    let inverse = if n > 0 {
        products.try_inverse()?
    } else {
        return None;
    };
    Some(Direction {
        cause,
        columns,
        inverse,
        one_sided,
    })
}

impl Tangent {
    /// Around `fit`, with every cause that is not on as a candidate where `with_candidates`.
    pub(crate) fn new(kind: &dyn Kind, fit: &Fit, with_candidates: bool) -> Option<Tangent> {
        let runs = kind.logs().len();
        let here: Vec<Vec<f64>> = (0..runs)
            .map(|run| predicted(kind, run, &fit.terms, &fit.unknowns[run]))
            .collect::<Option<_>>()?;
        let mut bounds = vec![0];
        for values in &here {
            bounds.push(bounds[bounds.len() - 1] + values.len());
        }
        let own = parallel::map(runs, |run| {
            let parameters = kind.unknowns(run);
            let columns = parameters.iter().enumerate().map(|(k, p)| {
                let place = (Place::Own(k), p);
                derivative(kind, run, &fit.terms, &fit.unknowns[run], &here[run], place)
            });
            columns.collect::<Option<Vec<_>>>().map(orthonormal)
        });
        let own: Vec<Vec<Vec<f64>>> = own.into_iter().collect::<Option<_>>()?;
        let on: Vec<(usize, usize)> = fit
            .causes
            .iter()
            .flat_map(|&c| (0..kind.causes()[c].parameters.len()).map(move |p| (c, p)))
            .collect();
        let column = |fit: &Fit, here: &[Vec<f64>], c: usize, p: usize| -> Option<Vec<f64>> {
            let parameter = &kind.causes()[c].parameters[p];
            let mut all = Vec::with_capacity(bounds[runs]);
            for run in 0..runs {
                let place = (Place::Shared(c, p), parameter);
                all.extend(derivative(
                    kind,
                    run,
                    &fit.terms,
                    &fit.unknowns[run],
                    &here[run],
                    place,
                )?);
            }
            clear_own(&mut all, &own, &bounds);
            Some(all)
        };
        let rests = |&(c, p): &(usize, usize)| {
            let (spec, x) = (&kind.causes()[c].parameters, fit.terms.get(c, p));
            spec.len() > 1
                && x == spec[p].neutral
                && (x == spec[p].bounds.0 || x == spec[p].bounds.1)
        };
        let rests = on.iter().map(rests).collect();
        let on = parallel::map(on.len(), |k| column(fit, &here, on[k].0, on[k].1));
        let on: Vec<Vec<f64>> = on.into_iter().collect::<Option<_>>()?;
        let clear = orthonormal(on.clone());
        let off: Vec<usize> = (0..kind.listed())
            .filter(|c| with_candidates && !fit.causes.contains(c))
            .collect();
        let candidates = parallel::map(off.len(), |k| {
            let cause = off[k];
            let spec = &kind.causes()[cause];
            let away = |start: usize| -> Option<Vec<f64>> {
                // From none to a start, all at once.
                let mut moved = fit.clone();
                for (p, parameter) in spec.parameters.iter().enumerate() {
                    let value = parameter.starts.get(start).or(parameter.starts.last());
                    moved
                        .terms
                        .set(cause, p, value.copied().unwrap_or(parameter.bounds.0));
                }
                let mut all = Vec::with_capacity(bounds[runs]);
                for run in 0..runs {
                    let there = predicted(kind, run, &moved.terms, &moved.unknowns[run])?;
                    all.extend(there.iter().zip(&here[run]).map(|(t, h)| t - h));
                }
                clear_own(&mut all, &own, &bounds);
                Some(all)
            };
            if spec.is_apart() {
                let most = spec
                    .parameters
                    .iter()
                    .map(|p| p.starts.len())
                    .max()
                    .unwrap_or(0);
                let each = (0..most).filter_map(away);
                return each
                    .filter_map(|raw| direction(cause, vec![raw], &clear, true))
                    .collect();
            }
            let first = &spec.parameters[0];
            let raw = (0..spec.parameters.len())
                .filter_map(|p| column(fit, &here, cause, p))
                .collect();
            let one_sided = spec.parameters.len() == 1 && first.neutral <= first.bounds.0;
            direction(cause, raw, &clear, one_sided)
                .into_iter()
                .collect::<Vec<_>>()
        });
        let candidates = candidates.into_iter().flatten().collect();
        Some(Tangent {
            candidates,
            on,
            rests,
            clear,
            own,
            predicted: here.concat(),
            bounds,
        })
    }

    /// The residuals of `fit` in standard deviations, outliers cut.
    pub(crate) fn residuals(kind: &dyn Kind, fit: &Fit) -> Option<Vec<f64>> {
        let mut all = Vec::new();
        for run in 0..kind.logs().len() {
            all.extend(residuals(kind, run, &fit.terms, &fit.unknowns[run])?);
        }
        for r in &mut all {
            *r *= weight(*r);
        }
        Some(all)
    }

    /// By how much any two candidates among those that `may` be lower the loss of `residuals`
    /// together, the best first.
    pub(crate) fn best_pairs(
        &self,
        residuals: &[f64],
        may: impl Fn(usize) -> bool,
    ) -> Vec<(f64, (usize, usize))> {
        let all: Vec<&Direction> = self.candidates.iter().filter(|d| may(d.cause)).collect();
        let pairs: Vec<(usize, usize)> = (0..all.len())
            .flat_map(|i| (i + 1..all.len()).map(move |j| (i, j)))
            .collect();
        let gains = parallel::map(pairs.len(), |k| {
            let (a, b) = (all[pairs[k].0], all[pairs[k].1]);
            let columns: Vec<&Vec<f64>> = a.columns.iter().chain(&b.columns).collect();
            let n = columns.len();
            let g = DVector::from_iterator(n, columns.iter().map(|c| dot(c, residuals)));
            let products = DMatrix::from_fn(n, n, |i, j| dot(columns[i], columns[j]));
            products.cholesky().map_or(0.0, |c| g.dot(&c.solve(&g)))
        });
        let named = |(gain, (i, j)): (f64, (usize, usize))| (gain, (all[i].cause, all[j].cause));
        let mut found: Vec<_> = gains
            .into_iter()
            .zip(pairs.iter().copied())
            .map(named)
            .collect();
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        found
    }

    /// Residuals (standard deviations) that chance alone would leave: noise and quantisation as in
    /// the data, fitted again.
    pub(crate) fn chance(&self, kind: &dyn Kind, random: &mut Pcg64) -> Vec<f64> {
        let mut all = Vec::with_capacity(self.predicted.len());
        let within = StandardUniform.map(|x: f64| x - 0.5);
        // Where between two steps of a quantised column the readings lie is not known so well; it
        // is the same in runs that are alike.
        let places: Vec<f64> = kind
            .channels()
            .iter()
            .map(|c| c.step / c.noise * within.sample(random))
            .collect();
        for (run, log) in kind.logs().iter().enumerate() {
            let by_input = kind.input_noise(run, &mut || StandardNormal.sample(random));
            for (i, (reading, value)) in log
                .readings
                .iter()
                .zip(&self.predicted[self.bounds[run]..])
                .enumerate()
            {
                let channel = &kind.channels()[reading.channel];
                let z: f64 = StandardNormal.sample(random);
                let count = reading.weight.sqrt();
                let drawn = if channel.step > 0.0 {
                    let (step, value) = (
                        channel.step / channel.noise,
                        value / count + places[reading.channel],
                    );
                    let white = (1.0 - step * step / 12.0).max(0.0).sqrt();
                    ((value + white * z) / step).round() * step - value
                } else {
                    z
                };
                let moved = by_input
                    .as_ref()
                    .map_or(0.0, |moved| moved[i] / channel.noise);
                all.push(count * (drawn + moved));
            }
        }
        self.clear(&mut all);
        all
    }

    /// Takes from residuals what the unknowns and the causes that are on can explain.
    fn clear(&self, residuals: &mut [f64]) {
        clear_own(residuals, &self.own, &self.bounds);
        for direction in &self.clear {
            let part = dot(direction, residuals);
            for (x, d) in residuals.iter_mut().zip(direction) {
                *x -= part * d;
            }
        }
    }

    /// Information on the parameters of the causes that are on, in units of their scales.
    pub(crate) fn information(&self) -> DMatrix<f64> {
        let n = self.on.len();
        DMatrix::from_fn(n, n, |i, j| dot(&self.on[i], &self.on[j]))
    }

    /// How surely the parameters of the causes that are on are known.
    pub(crate) fn known(&self, kind: &dyn Kind) -> Known {
        let n = self.on.len();
        if n == 0 {
            let nothing = DMatrix::zeros(0, 0);
            return Known {
                by_readings: nothing.clone(),
                covariance: nothing,
                least: 1.0,
                direction: Vec::new(),
            };
        }
        let mut information = self.information();
        for k in (0..n).filter(|k| self.rests[*k]) {
            information.row_mut(k).fill(0.0);
            information.column_mut(k).fill(0.0);
            information[(k, k)] = 1.0;
        }
        let sizes: Vec<f64> = (0..n)
            .map(|i| information[(i, i)].sqrt().max(1e-150))
            .collect();
        let scaled = DMatrix::from_fn(n, n, |i, j| information[(i, j)] / (sizes[i] * sizes[j]));
        let eigen = scaled.symmetric_eigen();
        let least = eigen.eigenvalues.imin();
        let mut inverse = DMatrix::zeros(n, n);
        for k in 0..n {
            let v = eigen.eigenvectors.column(k);
            inverse += v * v.transpose() / eigen.eigenvalues[k].max(1e-12);
        }
        let by_readings = DMatrix::from_fn(n, n, |i, j| {
            let is_held = self.rests[i] || self.rests[j];
            if is_held {
                0.0
            } else {
                inverse[(i, j)] / (sizes[i] * sizes[j])
            }
        });
        Known {
            covariance: &by_readings + self.by_inputs(kind, &by_readings),
            by_readings,
            least: eigen.eigenvalues[least],
            direction: eigen.eigenvectors.column(least).iter().copied().collect(),
        }
    }

    /// What noise of measured inputs adds to the covariance that noise of the readings gives: the
    /// scatter of the parameters over draws.
    fn by_inputs(&self, kind: &dyn Kind, covariance: &DMatrix<f64>) -> DMatrix<f64> {
        const DRAWS: usize = 200;
        let n = self.on.len();
        let mut sum = DMatrix::zeros(n, n);
        let mut random = Pcg64::new(1, 11);
        for _ in 0..DRAWS {
            let mut against = DVector::zeros(n);
            for (run, log) in kind.logs().iter().enumerate() {
                let Some(moved) = kind.input_noise(run, &mut || StandardNormal.sample(&mut random))
                else {
                    return sum;
                };
                for (k, column) in self.on.iter().enumerate() {
                    let readings = log
                        .readings
                        .iter()
                        .zip(&moved)
                        .zip(&column[self.bounds[run]..]);
                    let parts = readings.map(|((r, m), c)| {
                        r.weight.sqrt() * m / kind.channels()[r.channel].noise * c
                    });
                    against[k] += parts.sum::<f64>();
                }
            }
            let step = covariance * against;
            sum += &step * step.transpose();
        }
        sum / DRAWS as f64
    }

    /// Where each run begins among all readings, and the end.
    pub(crate) fn bounds(&self) -> &[usize] {
        &self.bounds
    }
}
