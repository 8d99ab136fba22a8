//! The model near a fit: what small changes would do, what chance alone does, and how surely
//! parameters are known.

use nalgebra::{DMatrix, DVector};
use rand_distr::{Distribution, StandardNormal, StandardUniform};
use rand_pcg::Pcg64;
use saltus_numeric::parallel;
use saltus_numeric::statistics::dot;

use crate::between::{Between, Part, Wider};
use crate::discrepancy::Discrepancy;
use crate::fit::{Fit, Place, derivative, parameters_of, predicted, residuals, weight};
use crate::identifiability::Identifiability;
use crate::kind::{Channel, Kind, Parameter, Terms};

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
    /// By how much more than `covariance` a parameter scatters, where residuals weigh `inflation`
    /// times as much as white noise: what they show of the model's own error counts once.
    pub(crate) fn inflation(&self, index: usize, inflation: f64) -> f64 {
        let place = (index, index);
        let by_model = 1.0 + self.by_model[place] / self.covariance[place];
        if by_model.is_finite() {
            inflation.max(by_model)
        } else {
            inflation
        }
    }

    /// Where the runs disagree more than `inflation` allows, how far a parameter scatters between
    /// them.
    pub(crate) fn wider(&self, index: usize, inflation: f64) -> Option<Wider> {
        let variance = self.inflation(index, inflation) * self.covariance[(index, index)];
        let all = (0..self.covariance.nrows()).map(|i| self.inflation(i, inflation));
        self.between
            .wider(index, variance, all.fold(inflation, f64::max))
    }
}

/// Two causes with what they gain together.
pub(crate) struct Pair {
    pub(crate) causes: (usize, usize),
    pub(crate) gain: f64,
}

/// What a candidate could do to the readings.
pub(crate) struct Direction {
    pub(crate) cause: usize,
    /// Of unit size.
    columns: Vec<Vec<f64>>,
    /// For each column its parameter, and the size of what one of its scales does.
    parameters: Vec<(usize, f64)>,
    /// Inverse of the columns' products.
    inverse: DMatrix<f64>,
    /// Inverse of the covariance that noise and the model's own error give to residuals' parts of
    /// the columns.
    precision: DMatrix<f64>,
    /// Whether the first parameter can only grow.
    one_sided: bool,
}

impl Direction {
    /// By how much the loss of `residuals` would fall.
    pub(crate) fn gain(&self, residuals: &[f64]) -> f64 {
        self.gain_of(&self.parts(residuals))
    }

    /// The same, where noise and the model's own error together give about one for each parameter.
    pub(crate) fn score(&self, residuals: &[f64]) -> f64 {
        self.weighed(&self.parts(residuals), &self.precision)
    }

    /// The parts of `residuals` along the columns.
    pub(crate) fn parts(&self, residuals: &[f64]) -> DVector<f64> {
        let parts = self.columns.iter().map(|c| dot(c, residuals));
        DVector::from_iterator(self.columns.len(), parts)
    }

    /// By how much the loss of residuals with these parts would fall.
    pub(crate) fn gain_of(&self, parts: &DVector<f64>) -> f64 {
        self.weighed(parts, &self.inverse)
    }

    fn weighed(&self, parts: &DVector<f64>, inverse: &DMatrix<f64>) -> f64 {
        let step = inverse * parts;
        if self.one_sided && step[0] < 0.0 {
            0.0
        } else {
            parts.dot(&step)
        }
    }

    /// What of `residuals` lies along it.
    pub(crate) fn explained(&self, residuals: &[f64]) -> Vec<f64> {
        let step = self.step(residuals);
        let mut all = vec![0.0; residuals.len()];
        for (column, step) in self.columns.iter().zip(step.iter()) {
            for (x, c) in all.iter_mut().zip(column) {
                *x += step * c;
            }
        }
        all
    }

    /// The parameters that explain most of `residuals`, each with its number of scales.
    pub(crate) fn steps(&self, residuals: &[f64]) -> Vec<(usize, f64)> {
        let step = self.step(residuals);
        let parameters = self.parameters.iter().zip(step.iter());
        parameters.map(|((p, size), x)| (*p, x / size)).collect()
    }

    fn step(&self, residuals: &[f64]) -> DVector<f64> {
        let step = &self.inverse * self.parts(residuals);
        if self.one_sided && step[0] < 0.0 {
            0.0 * step
        } else {
            step
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

/// What `cause` could do by `raw`, its parameters with what one scale of each does, clear of the orthonormal directions `clear`; none where that is
/// nothing.
fn direction(
    cause: usize,
    raw: Vec<(usize, Vec<f64>)>,
    clear: &[Vec<f64>],
    one_sided: bool,
    discrepancy: &Discrepancy,
) -> Option<Direction> {
    let (mut columns, mut parameters) = (Vec::new(), Vec::new());
    for (p, mut column) in raw {
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
            parameters.push((p, size));
        }
    }
    if columns.is_empty() {
        return None;
    }
    let of_model: Vec<Vec<f64>> = columns.iter().map(|c| discrepancy.coordinates(c)).collect();
    let products = products(&columns);
    let covariance = &products + self::products(&of_model);
    Some(Direction {
        cause,
        columns,
        parameters,
        inverse: products.try_inverse()?,
        precision: covariance.try_inverse()?,
        one_sided,
    })
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

    /// Change of the predictions where a cause goes from none to one of its starts, clear of the
    /// unknowns.
    fn away(&self, cause: usize, start: usize) -> Option<Vec<f64>> {
        let mut terms = self.fit.terms.clone();
        for (p, parameter) in self.kind.causes()[cause].parameters.iter().enumerate() {
            let value = parameter.starts.get(start).or(parameter.starts.last());
            terms.set(cause, p, value.copied().unwrap_or(parameter.bounds.0));
        }
        self.of_runs(|run| {
            let mut there = predicted(self.kind, run, &terms, &self.fit.unknowns[run])?;
            for (t, h) in there.iter_mut().zip(&self.here[run]) {
                *t -= h;
            }
            Some(there)
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

    /// What a cause that is not on could do, clear of the directions `clear` too.
    fn directions(
        &self,
        cause: usize,
        clear: &[Vec<f64>],
        discrepancy: &Discrepancy,
    ) -> Vec<Direction> {
        let spec = &self.kind.causes()[cause];
        let parameters = &spec.parameters;
        if spec.is_apart() {
            let starts = parameters.iter().map(|p| p.starts.len()).max().unwrap_or(0);
            let each = (0..starts).filter_map(|start| self.away(cause, start));
            return each
                .filter_map(|raw| direction(cause, vec![(0, raw)], clear, true, discrepancy))
                .collect();
        }
        let raw = (0..parameters.len())
            .filter_map(|p| Some((p, self.column(cause, p)?)))
            .collect();
        let one_sided = parameters.len() == 1 && parameters[0].neutral <= parameters[0].bounds.0;
        direction(cause, raw, clear, one_sided, discrepancy)
            .into_iter()
            .collect()
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

/// Error (σ) of a quantised reading of `value` (σ) with white noise `z`.
fn quantised(channel: &Channel, value: f64, z: f64) -> f64 {
    let step = channel.step / channel.noise;
    let white = (1.0 - step * step / 12.0).max(0.0).sqrt();
    ((value + white * z) / step).round() * step - value
}

impl Tangent {
    /// Around `fit`, with every cause that is not on as a candidate where `with_candidates`.
    pub(crate) fn new(kind: &dyn Kind, fit: &Fit, with_candidates: bool) -> Option<Tangent> {
        let around = Around::new(kind, fit)?;
        let places = parameters_of(kind, &fit.causes);
        let on = parallel::map(places.len(), |k| around.column(places[k].0, places[k].1));
        let on: Vec<Vec<f64>> = on.into_iter().collect::<Option<_>>()?;
        let clear = orthonormal(on.clone());
        let off: Vec<usize> = (kind.common()..kind.listed())
            .filter(|c| with_candidates && !fit.causes.contains(c))
            .collect();
        let discrepancy = Discrepancy::new(kind);
        let candidates = parallel::map(off.len(), |k| {
            around.directions(off[k], &clear, &discrepancy)
        });
        Some(Tangent {
            candidates: candidates.into_iter().flatten().collect(),
            on,
            rests: places
                .into_iter()
                .map(|place| around.rests(place))
                .collect(),
            clear,
            own: around.own,
            predicted: around.here.concat(),
            bounds: around.bounds,
            discrepancy,
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
    pub(crate) fn best_pairs(&self, residuals: &[f64], may: impl Fn(usize) -> bool) -> Vec<Pair> {
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
        let named = |(gain, (i, j)): (f64, &(usize, usize))| Pair {
            causes: (all[*i].cause, all[*j].cause),
            gain,
        };
        let mut found: Vec<Pair> = gains.into_iter().zip(&pairs).map(named).collect();
        found.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        found
    }

    /// Errors of readings (standard deviations) by chance: noise and quantisation as in the data.
    fn chance(&self, kind: &dyn Kind, random: &mut Pcg64) -> Vec<f64> {
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
            let predicted = &self.predicted[self.bounds[run]..];
            for (i, (reading, value)) in log.readings.iter().zip(predicted).enumerate() {
                let channel = &kind.channels()[reading.channel];
                let z: f64 = StandardNormal.sample(random);
                let count = reading.weight.sqrt();
                let drawn = if channel.step > 0.0 {
                    quantised(channel, value / count + places[reading.channel], z)
                } else {
                    z
                };
                let moved = by_input
                    .as_ref()
                    .map_or(0.0, |moved| moved[i] / channel.noise);
                all.push(count * (drawn + moved));
            }
        }
        all
    }

    /// Residuals (standard deviations) that noise and the model's own error would leave, fitted
    /// again.
    pub(crate) fn drawn(&self, kind: &dyn Kind, random: &mut Pcg64) -> Vec<f64> {
        let mut all = self.chance(kind, random);
        self.discrepancy.add(&mut all, random);
        self.clear(&mut all);
        all
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

    /// Noise (standard deviations), clear of the same.
    pub(crate) fn noise(&self, kind: &dyn Kind, random: &mut Pcg64) -> Vec<f64> {
        let mut all = self.chance(kind, random);
        self.clear(&mut all);
        all
    }

    /// `direction` as it is where `terms` have its cause on: what they do takes the place of the
    /// column that explains most of `residuals`; none where they do nothing.
    pub(crate) fn bent(
        &self,
        kind: &dyn Kind,
        direction: &Direction,
        terms: &Terms,
        residuals: &[f64],
    ) -> Option<Direction> {
        let most = direction.step(residuals).iamax();
        let mut raw: Vec<(usize, Vec<f64>)> = direction
            .parameters
            .iter()
            .zip(&direction.columns)
            .map(|((p, _), column)| (*p, column.clone()))
            .collect();
        raw[most].1 = self.change(kind, terms)?;
        raw.swap(0, most);
        let one_sided = raw.len() == 1;
        self::direction(direction.cause, raw, &[], one_sided, &self.discrepancy)
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

    /// Where each run begins among all readings, and the end.
    pub(crate) fn bounds(&self) -> &[usize] {
        &self.bounds
    }
}
