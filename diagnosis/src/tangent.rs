//! The model near a fit: what small changes would do, what chance alone does, and how surely
//! parameters are known.

use nalgebra::{DMatrix, DVector};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use saltus_numeric::parallel;
use saltus_numeric::statistics::dot;

use crate::between::{Between, Part, Wider};
use crate::discrepancy::Discrepancy;
use crate::fit::{Fit, Place, derivative, parameters_of, predicted, residuals, weight};
use crate::identifiability::Identifiability;
use crate::kind::{Kind, Parameter, Terms};

/// Directions in the space of all readings, in standard deviations, one value for each reading of
/// each run in turn.
pub(crate) struct Tangent {
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
    /// The model's own error.
    discrepancy: Discrepancy,
}

/// How surely the parameters of the causes that are on are known, in units of their scales.
pub(crate) struct Known {
    /// Covariance that noise of the readings and of measured inputs gives.
    pub(crate) covariance: DMatrix<f64>,
    /// The part of the readings alone.
    pub(crate) by_readings: DMatrix<f64>,
    /// What the model's own error adds.
    by_model: DMatrix<f64>,
    /// How much they scatter between runs.
    between: Between,
    /// Least eigenvalue of the information when each parameter alone has information 1.
    pub(crate) least: f64,
    /// Its direction.
    pub(crate) direction: Vec<f64>,
}

impl Known {
    /// By how much more than `covariance` a parameter scatters, by the model's own error.
    pub(crate) fn inflation(&self, index: usize) -> f64 {
        let place = (index, index);
        let by_model = 1.0 + self.by_model[place] / self.covariance[place];
        if by_model.is_finite() { by_model } else { 1.0 }
    }

    /// Where the runs disagree more than that allows, how far a parameter scatters between them.
    pub(crate) fn wider(&self, index: usize) -> Option<Wider> {
        let variance = self.inflation(index) * self.covariance[(index, index)];
        let all = (0..self.covariance.nrows()).map(|i| self.inflation(i));
        self.between.wider(index, variance, all.fold(1.0, f64::max))
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

/// Products of every two columns.
fn products(columns: &[Vec<f64>]) -> DMatrix<f64> {
    let n = columns.len();
    DMatrix::from_fn(n, n, |i, j| dot(&columns[i], &columns[j]))
}

/// The model at a fit, with what the unknowns of each run can do.
struct Around<'a> {
    kind: &'a dyn Kind,
    fit: &'a Fit,
    /// Predictions of each run (σ).
    here: Vec<Vec<f64>>,
    bounds: Vec<usize>,
    own: Vec<Vec<Vec<f64>>>,
}

impl<'a> Around<'a> {
    fn new(kind: &'a dyn Kind, fit: &'a Fit) -> Option<Around<'a>> {
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
        Some(Around {
            own: own.into_iter().collect::<Option<_>>()?,
            kind,
            fit,
            here,
            bounds,
        })
    }

    /// Change of the predictions for one scale of a parameter of a cause, clear of the unknowns.
    fn column(&self, cause: usize, p: usize) -> Option<Vec<f64>> {
        let parameter = &self.kind.causes()[cause].parameters[p];
        self.of_runs(|run| {
            let unknowns = &self.fit.unknowns[run];
            let place = (Place::Shared(cause, p), parameter);
            derivative(
                self.kind,
                run,
                &self.fit.terms,
                unknowns,
                &self.here[run],
                place,
            )
        })
    }

    fn of_runs(&self, of: impl Fn(usize) -> Option<Vec<f64>>) -> Option<Vec<f64>> {
        let mut all = Vec::with_capacity(self.bounds[self.here.len()]);
        for run in 0..self.here.len() {
            all.extend(of(run)?);
        }
        clear_own(&mut all, &self.own, &self.bounds);
        Some(all)
    }

    /// Whether a parameter among several rests at a bound where it does nothing.
    fn rests(&self, (cause, p): (usize, usize)) -> bool {
        let spec = &self.kind.causes()[cause].parameters;
        let x = self.fit.terms.get(cause, p);
        let Parameter {
            neutral, bounds, ..
        } = spec[p];
        spec.len() > 1 && x == neutral && (x == bounds.0 || x == bounds.1)
    }
}

impl Tangent {
    /// Around `fit`.
    pub(crate) fn new(kind: &dyn Kind, fit: &Fit) -> Option<Tangent> {
        let around = Around::new(kind, fit)?;
        let places = parameters_of(kind, &fit.causes);
        let on = parallel::map(places.len(), |k| around.column(places[k].0, places[k].1));
        let on: Vec<Vec<f64>> = on.into_iter().collect::<Option<_>>()?;
        Some(Tangent {
            clear: orthonormal(on.clone()),
            on,
            rests: places
                .into_iter()
                .map(|place| around.rests(place))
                .collect(),
            own: around.own,
            predicted: around.here.concat(),
            bounds: around.bounds,
            discrepancy: Discrepancy::new(kind),
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

    /// What `terms` do to the readings (standard deviations), clear of the unknowns at their first
    /// guesses and of the causes that are on; none where the model has no answer.
    pub(crate) fn change(&self, kind: &dyn Kind, terms: &Terms) -> Option<Vec<f64>> {
        let mut all = Vec::with_capacity(self.predicted.len());
        for run in 0..kind.logs().len() {
            let unknowns: Vec<f64> = kind.unknowns(run).iter().map(|p| p.neutral).collect();
            all.extend(predicted(kind, run, terms, &unknowns)?);
        }
        for (there, here) in all.iter_mut().zip(&self.predicted) {
            *there -= here;
        }
        self.clear(&mut all);
        Some(all)
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
        products(&self.on)
    }

    /// How surely the parameters of the causes that are on are known.
    pub(crate) fn known(&self, kind: &dyn Kind, fit: &Fit) -> Known {
        let n = self.on.len();
        if n == 0 {
            let nothing = DMatrix::zeros(0, 0);
            return Known {
                by_readings: nothing.clone(),
                by_model: nothing.clone(),
                between: Between::default(),
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
        let found = Identifiability::new(&information);
        let least = found.least();
        let mut by_readings = found.covariance(|_| true);
        for k in (0..n).filter(|k| self.rests[*k]) {
            by_readings.row_mut(k).fill(0.0);
            by_readings.column_mut(k).fill(0.0);
        }
        Known {
            covariance: &by_readings + self.by_inputs(kind, &by_readings),
            by_model: self.by_model(&by_readings),
            between: self.between(kind, fit).unwrap_or_default(),
            by_readings,
            least: found.information[least],
            direction: found.direction(least).iter().copied().collect(),
        }
    }

    /// How much the parameters of the causes that are on, those of `fit`, scatter between runs; none
    /// where each run is of a machine of its own.
    pub(crate) fn between(&self, kind: &dyn Kind, fit: &Fit) -> Option<Between> {
        if kind.is_apart() {
            return None;
        }
        let residuals = Tangent::residuals(kind, fit)?;
        let n = self.on.len();
        let free = |i: usize| f64::from(u8::from(!self.rests[i]));
        let mut parts: Vec<(usize, Part)> = Vec::new();
        for (run, ends) in self.bounds.windows(2).enumerate() {
            let here = |i: usize| &self.on[i][ends[0]..ends[1]];
            let information =
                DMatrix::from_fn(n, n, |i, j| free(i) * free(j) * dot(here(i), here(j)));
            let score = DVector::from_fn(n, |i, _| {
                free(i) * dot(here(i), &residuals[ends[0]..ends[1]])
            });
            let group = kind.group(run);
            match parts.iter_mut().find(|part| part.0 == group) {
                Some((_, part)) => {
                    part.information += information;
                    part.score += score;
                }
                None => parts.push((group, Part { information, score })),
            }
        }
        let parts: Vec<Part> = parts.into_iter().map(|(_, part)| part).collect();
        let range = |place: &(usize, usize)| {
            let value = fit.terms.get(place.0, place.1);
            let spec = &kind.causes()[place.0].parameters[place.1];
            let (low, high) = spec.bounds;
            ((low - value) / spec.scale, (high - value) / spec.scale)
        };
        let ranges: Vec<(f64, f64)> = parameters_of(kind, &fit.causes).iter().map(range).collect();
        Some(Between::new(&parts, &ranges))
    }

    /// What the model's own error adds to the covariance that noise of the readings gives.
    fn by_model(&self, covariance: &DMatrix<f64>) -> DMatrix<f64> {
        let of = |column: &Vec<f64>| self.discrepancy.coordinates(column);
        let coordinates: Vec<Vec<f64>> = self.on.iter().map(of).collect();
        covariance * products(&coordinates) * covariance
    }

    /// What noise of measured inputs adds to the covariance that noise of the readings gives: the
    /// scatter of the parameters over draws.
    fn by_inputs(&self, kind: &dyn Kind, covariance: &DMatrix<f64>) -> DMatrix<f64> {
        const DRAWS: usize = 200;
        let n = self.on.len();
        let mut sum = DMatrix::zeros(n, n);
        let mut random = Pcg64::new(1, 11);
        for _ in 0..DRAWS {
            let Some(score) = self.drawn_score(kind, &mut random) else {
                return sum;
            };
            let step = covariance * score;
            sum += &step * step.transpose();
        }
        sum / DRAWS as f64
    }

    /// Derivative of half the loss by each parameter where noise of measured inputs is drawn; none
    /// where no input is measured.
    fn drawn_score(&self, kind: &dyn Kind, random: &mut Pcg64) -> Option<DVector<f64>> {
        let mut score = DVector::zeros(self.on.len());
        for (run, log) in kind.logs().iter().enumerate() {
            let moved = kind.input_noise(run, &mut || StandardNormal.sample(random))?;
            for (k, column) in self.on.iter().enumerate() {
                let readings = log.readings.iter().zip(&moved);
                let parts = readings
                    .zip(&column[self.bounds[run]..])
                    .map(|((r, m), c)| r.weight.sqrt() * m / kind.channels()[r.channel].noise * c);
                score[k] += parts.sum::<f64>();
            }
        }
        Some(score)
    }
}
