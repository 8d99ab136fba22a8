//! Parameters from data: Levenberg–Marquardt on Huber's loss, with bounds.

use std::time::{Duration, Instant};

use nalgebra::{DMatrix, DVector};
use saltus_numeric::parallel;
use saltus_numeric::statistics::{dot, median};

use crate::kind::{Channel, Kind, Parameter, Reading, Terms, is_of};
use crate::sensor::Fault;

/// Residuals beyond so many standard deviations count in proportion to their size only (Huber's
/// loss).
pub(crate) const HUBER: f64 = 3.0;
/// Most steps of a fit.
pub(crate) const STEPS: usize = 40;
/// Most steps of a rough fit, by derivatives from nearby.
pub(crate) const ROUGH_STEPS: usize = 15;
/// Fall of the loss below which a fit is done.
const DONE: f64 = 1e-2;
/// The same as a part of the loss beyond that of noise.
const DONE_PART: f64 = 1e-4;
/// Fall of the loss in terms of what corrected derivatives tell, below which they are taken anew.
const GOOD: f64 = 0.7;
const ROUGH: f64 = 0.3;
/// Starts of a cause from which steps are made.
const MOST_STARTS: usize = 4;
/// Step of a difference quotient, in terms of a parameter's scale.
pub(crate) const DIFFERENCE: f64 = 1e-3;

/// Predictions of all runs that take longer are shared among processors.
const SLOW: Duration = Duration::from_millis(2);

/// Which readings count: for each run, one flag for each reading; none: all of them.
pub(crate) type Mask = Option<Vec<Vec<bool>>>;

/// A model with its parameters fitted.
#[derive(Clone, Debug)]
pub struct Fit {
    /// Indices of the causes that are on, in the order in which they were found.
    pub causes: Vec<usize>,
    /// Parameters of all causes.
    pub terms: Terms,
    /// Unknowns of each run.
    pub unknowns: Vec<Vec<f64>>,
    /// Twice the negative log-likelihood up to a constant: the sum of Huber's loss of the residuals
    /// in standard deviations.
    pub loss: f64,
    /// Robust standard deviation of the residuals of each channel (σ, 1 at least): residuals beyond
    /// three of it count in proportion to their size only.
    pub(crate) scales: Vec<f64>,
}

impl Fit {
    /// Nothing wrong, and the unknowns at their first guesses.
    pub(crate) fn first(kind: &dyn Kind) -> Fit {
        let first = |run| kind.unknowns(run).iter().map(|p| p.neutral).collect();
        Fit {
            causes: Vec::new(),
            terms: Terms::off(kind.causes()),
            unknowns: (0..kind.logs().len()).map(first).collect(),
            loss: f64::INFINITY,
            scales: vec![1.0; kind.channels().len()],
        }
    }

    /// See [`Fit::scales`].
    pub(crate) fn scale(&self, channel: usize) -> f64 {
        self.scales[channel]
    }
}

/// Robust standard deviation of the residuals of `fit` in each channel (σ, 1 at least).
pub(crate) fn scales(kind: &dyn Kind, fit: &Fit) -> Option<Vec<f64>> {
    let mut sizes = vec![Vec::new(); kind.channels().len()];
    for (run, log) in kind.logs().iter().enumerate() {
        let all = residuals(kind, run, &fit.terms, &fit.unknowns[run])?;
        for (reading, r) in log.readings.iter().zip(all) {
            sizes[reading.channel].push(r.abs());
        }
    }
    let scale = |sizes: &mut Vec<f64>| (median(sizes) / 0.6745).max(1.0);
    Some(sizes.iter_mut().map(scale).collect())
}

/// Huber's loss of a residual in a channel with a scale (σ).
pub(crate) fn huber_at(r: f64, scale: f64) -> f64 {
    if scale.is_infinite() {
        return r * r;
    }
    scale * scale * huber(r / scale)
}

/// Weight of a residual in a channel with a scale (σ).
pub(crate) fn weight_at(r: f64, scale: f64) -> f64 {
    (HUBER * scale / r.abs()).min(1.0)
}

pub(crate) fn huber(r: f64) -> f64 {
    let size = r.abs();
    if size <= HUBER {
        r * r
    } else {
        2.0 * HUBER * size - HUBER * HUBER
    }
}

/// Weight of a residual in a step of least squares that lowers Huber's loss.
pub(crate) fn weight(r: f64) -> f64 {
    (HUBER / r.abs()).min(1.0)
}

/// Standard deviation of a reading as far as it counts.
pub(crate) fn scatter(kind: &dyn Kind, reading: &Reading) -> f64 {
    kind.channels()[reading.channel].noise / reading.weight.sqrt()
}

/// What the model says of the readings of a run, in standard deviations of each; none where it has
/// no answer.
pub(crate) fn predicted(
    kind: &dyn Kind,
    run: usize,
    terms: &Terms,
    unknowns: &[f64],
) -> Option<Vec<f64>> {
    let mut values = kind.predict(run, terms, unknowns)?;
    for (value, reading) in values.iter_mut().zip(&kind.logs()[run].readings) {
        *value /= scatter(kind, reading);
    }
    values.iter().all(|x| x.is_finite()).then_some(values)
}

/// Residuals in standard deviations, of all readings of a run.
pub(crate) fn residuals(
    kind: &dyn Kind,
    run: usize,
    terms: &Terms,
    unknowns: &[f64],
) -> Option<Vec<f64>> {
    let mut values = predicted(kind, run, terms, unknowns)?;
    for (value, reading) in values.iter_mut().zip(&kind.logs()[run].readings) {
        *value = reading.value / scatter(kind, reading) - *value;
    }
    Some(values)
}

/// One parameter of a fit: of a cause, or an unknown of the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    /// Parameter of a cause.
    Shared(usize, usize),
    /// An unknown of the run.
    Own(usize),
}

/// How the prediction of a run (in standard deviations) changes with a parameter, for one of its
/// scale: a difference quotient that stays within the bounds.
pub(crate) fn derivative(
    kind: &dyn Kind,
    run: usize,
    terms: &Terms,
    unknowns: &[f64],
    here: &[f64],
    (place, parameter): (Place, &Parameter),
) -> Option<Vec<f64>> {
    if let Place::Shared(cause, _) = place
        && let Some(exact) = of_sensor(kind, run, terms, here, cause)
    {
        return Some(exact.into_iter().map(|x| x * parameter.scale).collect());
    }
    let (mut terms, mut unknowns) = (terms.clone(), unknowns.to_vec());
    let x = match place {
        Place::Shared(c, p) => terms.get(c, p),
        Place::Own(p) => unknowns[p],
    };
    let step = DIFFERENCE * parameter.scale;
    for step in [step, -step] {
        let moved = x + step;
        if moved < parameter.bounds.0 || moved > parameter.bounds.1 {
            continue;
        }
        match place {
            Place::Shared(c, p) => terms.set(c, p, moved),
            Place::Own(p) => unknowns[p] = moved,
        }
        if let Some(mut there) = predicted(kind, run, &terms, &unknowns) {
            for (t, h) in there.iter_mut().zip(here) {
                *t = (*t - h) * parameter.scale / step;
            }
            return Some(there);
        }
    }
    None
}

/// How the prediction of a run (in standard deviations) changes with the gain or the offset of a
/// measured column's sensor; none of other causes.
fn of_sensor(
    kind: &dyn Kind,
    run: usize,
    terms: &Terms,
    here: &[f64],
    cause: usize,
) -> Option<Vec<f64>> {
    let spec = &kind.causes()[cause];
    let (fault, own) = (spec.fault?, spec.column.as_deref()?);
    let is_own = |c: &Channel| is_of(&c.name, own);
    let is_exact = matches!(fault, Fault::Gain | Fault::Offset);
    if !is_exact || !kind.channels().iter().any(is_own) {
        return None;
    }
    let of = |(reading, here): (&Reading, &f64)| {
        let channel = &kind.channels()[reading.channel];
        if !is_own(channel) {
            return 0.0;
        }
        let noise = scatter(kind, reading);
        let sensor = kind.data().sensor(&channel.name, terms);
        match fault {
            Fault::Gain => sensor.truth(here * noise) / noise,
            _ => 1.0 / noise,
        }
    };
    Some(kind.logs()[run].readings.iter().zip(here).map(of).collect())
}

/// The parameters of a fit in a row: those of causes, then the unknowns of each run.
struct Problem<'a> {
    kind: &'a dyn Kind,
    shared: Vec<(usize, usize)>,
    runs: &'a [usize],
    mask: &'a Mask,
    parameters: Vec<Parameter>,
    fit: Fit,
    /// Derivatives of the predictions of each run, for one of each parameter's scale: taken once,
    /// and then corrected by what every step has shown (Broyden).
    slopes: Slopes,
    /// Whether predictions take long.
    is_slow: bool,
}

/// Derivatives of each run by each parameter it depends on; none where they are not known.
pub(crate) type Slopes = Vec<Vec<Option<Vec<f64>>>>;

/// How surely a fit ends where the loss is least.
#[derive(Clone, Copy, PartialEq, Eq)]
enum End {
    /// Derivatives that were taken there say so.
    Sure,
    /// Corrected derivatives may say so.
    Rough,
}

/// A point of a search: predictions and residuals of each run, and the loss.
struct Point {
    predicted: Vec<Vec<f64>>,
    residuals: Vec<Vec<f64>>,
    loss: f64,
}

impl Point {
    /// Fall of the loss below which a fit is done: where much is left that is not noise, the last
    /// digit of it tells nothing.
    fn done(&self, end: End) -> f64 {
        let readings: usize = self.residuals.iter().map(Vec::len).sum();
        let part = match end {
            End::Sure => DONE_PART,
            End::Rough => 10.0 * DONE_PART,
        };
        DONE.max(part * (self.loss - readings as f64))
    }
}

impl<'a> Problem<'a> {
    fn new(
        kind: &'a dyn Kind,
        fit: Fit,
        shared: Vec<(usize, usize)>,
        runs: &'a [usize],
        mask: &'a Mask,
    ) -> Problem<'a> {
        let mut parameters: Vec<Parameter> = shared
            .iter()
            .map(|&(c, p)| kind.causes()[c].parameters[p].clone())
            .collect();
        for &run in runs {
            parameters.extend(kind.unknowns(run));
        }
        let places = |run: &usize| vec![None; shared.len() + fit.unknowns[*run].len()];
        Problem {
            slopes: runs.iter().map(places).collect(),
            kind,
            shared,
            runs,
            mask,
            parameters,
            fit,
            is_slow: false,
        }
    }

    /// Has derivatives taken anew.
    fn forget(&mut self) {
        for slope in self.slopes.iter_mut().flatten() {
            *slope = None;
        }
    }

    fn read(&self) -> Vec<f64> {
        let shared = self.shared.iter().map(|&(c, p)| self.fit.terms.get(c, p));
        shared
            .chain(
                self.runs
                    .iter()
                    .flat_map(|&run| self.fit.unknowns[run].iter().copied()),
            )
            .collect()
    }

    fn write(&mut self, x: &[f64]) {
        for (&(c, p), value) in self.shared.iter().zip(x) {
            self.fit.terms.set(c, p, *value);
        }
        let mut rest = &x[self.shared.len()..];
        for &run in self.runs {
            let (here, after) = rest.split_at(self.fit.unknowns[run].len());
            self.fit.unknowns[run].copy_from_slice(here);
            rest = after;
        }
    }

    fn at(&mut self, x: &[f64]) -> Option<Point> {
        self.at_most(x, f64::INFINITY)
    }

    /// The point at `x`; none where its loss is more than `most`.
    fn at_most(&mut self, x: &[f64], most: f64) -> Option<Point> {
        self.write(x);
        let mut point = Point {
            predicted: Vec::new(),
            residuals: Vec::new(),
            loss: 0.0,
        };
        let started = Instant::now();
        let of = |k: usize| {
            let run = self.runs[k];
            let predicted = predicted(self.kind, run, &self.fit.terms, &self.fit.unknowns[run])?;
            let readings = &self.kind.logs()[run].readings;
            let residuals: Vec<f64> = readings
                .iter()
                .zip(&predicted)
                .enumerate()
                .map(|(i, (reading, value))| {
                    let counts = self.mask.as_ref().is_none_or(|m| m[run][i]);
                    if counts {
                        reading.value / scatter(self.kind, reading) - value
                    } else {
                        0.0
                    }
                })
                .collect();
            let each = readings.iter().zip(&residuals);
            let loss = each.map(|(reading, r)| huber_at(*r, self.fit.scale(reading.channel)));
            Some((loss.sum::<f64>(), predicted, residuals))
        };
        let mut add = |of_run: Option<(f64, Vec<f64>, Vec<f64>)>| {
            let (loss, predicted, residuals) = of_run?;
            point.loss += loss;
            point.predicted.push(predicted);
            point.residuals.push(residuals);
            (point.loss <= most).then_some(())
        };
        if self.is_shared() {
            parallel::map(self.runs.len(), of)
                .into_iter()
                .try_for_each(add)?;
        } else {
            (0..self.runs.len()).try_for_each(|k| add(of(k)))?;
        }
        self.is_slow |= started.elapsed() > SLOW;
        Some(point)
    }

    /// What each run depends on: its places, and their indices among all parameters.
    fn places(&self) -> Vec<(Vec<Place>, Vec<usize>)> {
        let n = self.shared.len();
        let mut next = n;
        self.runs
            .iter()
            .map(|&run| {
                let own = self.fit.unknowns[run].len();
                let shared = self.shared.iter().map(|&(c, p)| Place::Shared(c, p));
                let indices = (0..n).chain(next..next + own).collect();
                next += own;
                (shared.chain((0..own).map(Place::Own)).collect(), indices)
            })
            .collect()
    }

    /// Takes the derivatives at `point` that are not known.
    fn look(&mut self, point: &Point) -> Option<()> {
        let all = self.places();
        let is_new = |(k, i): &(usize, usize)| self.slopes[*k][*i].is_none();
        let every = (0..all.len()).flat_map(|k| (0..all[k].0.len()).map(move |i| (k, i)));
        let new: Vec<(usize, usize)> = every.filter(is_new).collect();
        let of = |at: usize| {
            let (k, i) = new[at];
            let run = self.runs[k];
            let place = (all[k].0[i], &self.parameters[all[k].1[i]]);
            let (terms, unknowns) = (&self.fit.terms, &self.fit.unknowns[run]);
            derivative(self.kind, run, terms, unknowns, &point.predicted[k], place)
        };
        let found: Vec<Option<Vec<f64>>> = self.over(new.len(), of);
        let mut has_all = true;
        for ((k, i), slope) in new.into_iter().zip(found) {
            has_all &= slope.is_some();
            self.slopes[k][i] = slope;
        }
        has_all.then_some(())
    }

    /// Whether work is shared among processors: they have no other, and it takes long.
    fn is_shared(&self) -> bool {
        self.is_slow && !parallel::is_shared()
    }

    /// `work` of each run, on all processors where that pays.
    fn over<R: Send>(&self, count: usize, work: impl Fn(usize) -> R + Sync) -> Vec<R> {
        if self.is_shared() {
            parallel::map(count, work)
        } else {
            (0..count).map(work).collect()
        }
    }

    /// Corrects the derivatives by what `step` (in the parameters' scales) did to the predictions.
    fn correct(&mut self, step: &[f64], before: &[Vec<f64>], after: &[Vec<f64>]) {
        for (k, (_, indices)) in self.places().into_iter().enumerate() {
            let mut slopes: Vec<&mut Vec<f64>> = self.slopes[k].iter_mut().flatten().collect();
            let size: f64 = indices.iter().map(|i| step[*i] * step[*i]).sum();
            if size < 1e-12 || slopes.len() < indices.len() {
                continue;
            }
            let told = |i: usize| {
                slopes
                    .iter()
                    .zip(&indices)
                    .map(|(s, at)| s[i] * step[*at])
                    .sum::<f64>()
            };
            let missed: Vec<f64> = (0..before[k].len())
                .map(|i| (after[k][i] - before[k][i] - told(i)) / size)
                .collect();
            for (slope, at) in slopes.iter_mut().zip(&indices) {
                for (s, missed) in slope.iter_mut().zip(&missed) {
                    *s += missed * step[*at];
                }
            }
        }
    }

    /// Normal equations in units of the parameters' scales. The present parameters are those of
    /// `point`.
    fn normal(&mut self, point: &Point) -> Option<(DMatrix<f64>, DVector<f64>)> {
        self.look(point)?;
        let n = self.parameters.len();
        let (mut matrix, mut slope) = (DMatrix::zeros(n, n), DVector::zeros(n));
        for (k, (_, columns)) in self.places().into_iter().enumerate() {
            let run = self.runs[k];
            let jacobian: Vec<&Vec<f64>> = self.slopes[k].iter().flatten().collect();
            let weights: Vec<f64> = point.residuals[k]
                .iter()
                .enumerate()
                .map(|(i, r)| {
                    if self.mask.as_ref().is_none_or(|m| m[run][i]) {
                        let channel = self.kind.logs()[run].readings[i].channel;
                        weight_at(*r, self.fit.scale(channel))
                    } else {
                        0.0
                    }
                })
                .collect();
            for (a, &row) in columns.iter().enumerate() {
                let weighted: Vec<f64> = jacobian[a]
                    .iter()
                    .zip(&weights)
                    .map(|(j, w)| j * w)
                    .collect();
                slope[row] += dot(&weighted, &point.residuals[k]);
                for (b, &column) in columns.iter().enumerate().take(a + 1) {
                    let sum = dot(&weighted, jacobian[b]);
                    matrix[(row, column)] += sum;
                    if row != column {
                        matrix[(column, row)] += sum;
                    }
                }
            }
        }
        Some((matrix, slope))
    }

    /// Levenberg–Marquardt from where the fit is, at most `steps` of it.
    fn solve(&mut self, steps: usize, end: End) -> Option<()> {
        let mut x = self.read();
        for (x, p) in x.iter_mut().zip(&self.parameters) {
            if !(p.neutral < p.bounds.0 || p.neutral > p.bounds.1) || *x != p.neutral {
                *x = x.clamp(p.bounds.0, p.bounds.1);
            }
        }
        let mut point = self.at(&x)?;
        let mut damping = 1e-3;
        let good = if end == End::Rough { ROUGH } else { GOOD };
        let mut is_new = self.slopes.iter().flatten().all(Option::is_none);
        for _ in 0..steps {
            self.write(&x);
            let Some((matrix, slope)) = self.normal(&point) else {
                break;
            };
            let done = point.done(end);
            let (from, before) = (x.clone(), point.predicted.clone());
            let (fall, as_told) =
                self.step(&mut x, &mut point, (&matrix, &slope), (&mut damping, done));
            if fall < done {
                if is_new || (end == End::Rough && as_told >= good) || self.parameters.len() == 1 {
                    break;
                }
                // What hindered may have been the old ones.
                self.forget();
                damping = 1e-3;
            } else if as_told < good {
                self.forget();
            } else {
                let moved = x
                    .iter()
                    .zip(from)
                    .zip(&self.parameters)
                    .map(|((x, from), p)| (x - from) / p.scale);
                self.correct(&moved.collect::<Vec<_>>(), &before, &point.predicted);
            }
            is_new = fall < done;
        }
        self.write(&x);
        self.fit.loss = point.loss;
        Some(())
    }

    /// One step; by how much it lowers the loss, and in terms of what the derivatives told.
    fn step(
        &mut self,
        x: &mut Vec<f64>,
        point: &mut Point,
        (matrix, slope): (&DMatrix<f64>, &DVector<f64>),
        (damping, done): (&mut f64, f64),
    ) -> (f64, f64) {
        // What a bound holds does not move.
        let held: Vec<bool> = self
            .parameters
            .iter()
            .zip(x.iter().zip(slope.iter()))
            .map(|(p, (x, s))| (*x <= p.bounds.0 && *s < 0.0) || (*x >= p.bounds.1 && *s > 0.0))
            .collect();
        let blocks: Vec<usize> = self
            .runs
            .iter()
            .map(|run| self.fit.unknowns[*run].len())
            .collect();
        for _ in 0..10 {
            let (mut damped, mut slope) = (matrix.clone(), slope.clone());
            for i in 0..x.len() {
                damped[(i, i)] += *damping * matrix[(i, i)] + 1e-9;
                if held[i] {
                    damped.row_mut(i).fill(0.0);
                    damped.column_mut(i).fill(0.0);
                    damped[(i, i)] = 1.0;
                    slope[i] = 0.0;
                }
            }
            let Some(step) = arrow(&damped, &slope, self.shared.len(), &blocks) else {
                *damping *= 10.0;
                continue;
            };
            let moved: Vec<f64> = x
                .iter()
                .zip(step.iter().zip(&self.parameters))
                .map(|(x, (s, p))| (x + s * p.scale).clamp(p.bounds.0, p.bounds.1))
                .collect();
            match self.at_most(&moved, point.loss + done) {
                Some(there) if there.loss < point.loss => {
                    let fall = point.loss - there.loss;
                    (*x, *point) = (moved, there);
                    *damping = (*damping * 0.2).max(1e-12);
                    let told = 2.0 * slope.dot(&step) - step.dot(&(&damped * &step));
                    return (fall, fall / told);
                }
                Some(_) => return (0.0, 1.0),
                None => *damping *= 8.0,
            }
        }
        (0.0, 0.0)
    }
}

/// Solves A x = b of a positive A that is an arrow: after the first `shared` rows, only blocks of
/// these sizes along the diagonal, as no run depends on what is unknown of another one. None where A
/// is not positive.
fn arrow(
    a: &DMatrix<f64>,
    b: &DVector<f64>,
    shared: usize,
    blocks: &[usize],
) -> Option<DVector<f64>> {
    let mut head = a.view((0, 0), (shared, shared)).into_owned();
    let mut right = b.rows(0, shared).into_owned();
    let mut solved = Vec::with_capacity(blocks.len());
    let mut at = shared;
    for &size in blocks {
        let block = a.view((at, at), (size, size)).into_owned().cholesky()?;
        let beside = a.view((at, 0), (size, shared));
        let (own, by_head) = (block.solve(&b.rows(at, size)), block.solve(&beside));
        head -= beside.transpose() * &by_head;
        right -= beside.transpose() * &own;
        solved.push((own, by_head));
        at += size;
    }
    let x = head.cholesky()?.solve(&right);
    let mut all = DVector::zeros(a.nrows());
    all.rows_mut(0, shared).copy_from(&x);
    let mut at = shared;
    for (own, by_head) in solved {
        let rest = own - by_head * &x;
        all.rows_mut(at, rest.len()).copy_from(&rest);
        at += rest.len();
    }
    Some(all)
}

/// Every parameter that all runs share: what nobody knows, then those of `causes`, in turn.
pub(crate) fn parameters_of(kind: &dyn Kind, causes: &[usize]) -> Vec<(usize, usize)> {
    (0..kind.common())
        .chain(causes.iter().copied())
        .flat_map(|c| (0..kind.causes()[c].parameters.len()).map(move |p| (c, p)))
        .collect()
}

/// The model as it is, with the unknowns fitted; none where it has no answer at its first guesses.
pub(crate) fn fit_none(kind: &dyn Kind, runs: &[usize]) -> Option<Fit> {
    refit(kind, Fit::first(kind), runs, &None, STEPS)
}

/// Fits the causes of `from` and the unknowns of `runs` anew, from where they are, to the readings
/// that count.
pub(crate) fn refit(
    kind: &dyn Kind,
    from: Fit,
    runs: &[usize],
    mask: &Mask,
    steps: usize,
) -> Option<Fit> {
    let shared = parameters_of(kind, &from.causes);
    let mut problem = Problem::new(kind, from, shared, runs, mask);
    problem.solve(steps, End::Sure)?;
    Some(problem.fit)
}

/// The same to all readings, where `slopes` are derivatives not far from there: with those at the end, as
/// far as its steps tell.
pub(crate) fn refit_near(
    kind: &dyn Kind,
    from: Fit,
    slopes: Slopes,
    runs: &[usize],
    steps: usize,
) -> Option<(Fit, Slopes)> {
    let shared = parameters_of(kind, &from.causes);
    let mut problem = Problem::new(kind, from, shared, runs, &None);
    problem.slopes = slopes;
    problem.solve(steps, End::Rough)?;
    let point = problem.at(&problem.read())?;
    problem.look(&point);
    Some((problem.fit, problem.slopes))
}

/// Puts the unknowns of a run at its first guesses where they leave less: unknowns that are bent to
/// another model may be no better.
pub(crate) fn begin_afresh(kind: &dyn Kind, fit: &mut Fit, run: usize) {
    let first: Vec<f64> = kind.unknowns(run).iter().map(|p| p.neutral).collect();
    let loss = |unknowns: &[f64]| -> f64 {
        let all = residuals(kind, run, &fit.terms, unknowns);
        let readings = &kind.logs()[run].readings;
        all.map_or(f64::INFINITY, |all| {
            let each = readings.iter().zip(all);
            each.map(|(reading, r)| huber_at(r, fit.scale(reading.channel)))
                .sum()
        })
    };
    if loss(&first) < loss(&fit.unknowns[run]) {
        fit.unknowns[run] = first;
    }
}

/// Slopes of all runs of which none is known.
pub(crate) fn no_slopes(kind: &dyn Kind, fit: &Fit) -> Slopes {
    let shared = parameters_of(kind, &fit.causes).len();
    let of = |own: &Vec<f64>| vec![None; shared + own.len()];
    fit.unknowns.iter().map(of).collect()
}

/// The derivatives of all runs at `fit`; none where there are none.
pub(crate) fn slopes(kind: &dyn Kind, fit: &Fit) -> Option<Slopes> {
    let runs: Vec<usize> = (0..kind.logs().len()).collect();
    let shared = parameters_of(kind, &fit.causes);
    let mut problem = Problem::new(kind, fit.clone(), shared, &runs, &None);
    let point = problem.at(&problem.read())?;
    problem.look(&point)?;
    Some(problem.slopes)
}

/// Fits the causes of `from` but for one of their parameters, which is `held` where it is, and all
/// unknowns. `slopes` are the derivatives not far from there.
pub(crate) fn refit_but(
    kind: &dyn Kind,
    held: (usize, usize),
    from: Fit,
    slopes: &Slopes,
    steps: usize,
) -> Option<Fit> {
    let runs: Vec<usize> = (0..kind.logs().len()).collect();
    let mut shared = parameters_of(kind, &from.causes);
    let index = shared.iter().position(|place| *place == held)?;
    shared.remove(index);
    let mut problem = Problem::new(kind, from, shared, &runs, &None);
    let but = |of_run: &Vec<Option<Vec<f64>>>| {
        let mut columns = of_run.clone();
        columns.remove(index);
        columns
    };
    problem.slopes = slopes.iter().map(but).collect();
    problem.solve(steps, End::Rough)?;
    Some(problem.fit)
}

/// Fits the unknowns of `runs` alone to the readings that count; the loss on them.
pub(crate) fn refit_unknowns(
    kind: &dyn Kind,
    model: &Fit,
    runs: &[usize],
    mask: &Mask,
) -> Option<Fit> {
    let mut problem = Problem::new(kind, model.clone(), Vec::new(), runs, mask);
    problem.solve(STEPS, End::Sure)?;
    Some(problem.fit)
}

/// Fits `base` with `cause` added, from where it is and from every start of the cause.
pub(crate) fn fit_with(kind: &dyn Kind, base: &Fit, cause: usize, runs: &[usize]) -> Option<Fit> {
    fit_if(kind, base, cause, runs, 0.0)
}

/// The same; none where the first steps do not gain `enough`.
pub(crate) fn fit_if(
    kind: &dyn Kind,
    base: &Fit,
    cause: usize,
    runs: &[usize],
    enough: f64,
) -> Option<Fit> {
    fit_from(kind, base, starts(kind, base, cause, runs), runs, enough)
}

/// `base` with `cause` where fits of it begin.
fn starts(kind: &dyn Kind, base: &Fit, cause: usize, runs: &[usize]) -> Vec<Fit> {
    let parameters = &kind.causes()[cause].parameters;
    let mut starts: Vec<Vec<f64>> = Vec::new();
    let is_apart = kind.causes()[cause].is_apart();
    if !is_apart {
        starts.push(parameters.iter().map(|p| p.neutral).collect());
    }
    if is_apart || parameters.len() > 1 {
        starts.extend(kind.causes()[cause].starts());
    }
    let mut from: Vec<Fit> = starts.iter().map(|s| begun(base, cause, s)).collect();
    from.extend(valleys(kind, base, cause, runs));
    from
}

/// `base` with `cause` at `values`.
pub(crate) fn begun(base: &Fit, cause: usize, values: &[f64]) -> Fit {
    let mut from = base.clone();
    from.causes.push(cause);
    for (p, value) in values.iter().enumerate() {
        from.terms.set(cause, p, *value);
    }
    from
}

/// Where `base` is far off, the bottoms of the valleys of the loss along each parameter of `cause` over
/// its whole range: small steps from none need not lead there.
fn valleys(kind: &dyn Kind, base: &Fit, cause: usize, runs: &[usize]) -> Vec<Fit> {
    /// Valleys that are looked at.
    const MOST: usize = 3;
    /// Loss for each reading from which on slopes tell nothing.
    const FAR: f64 = 25.0;
    let logs = runs.iter().map(|run| &kind.logs()[*run]);
    let readings: usize = logs.map(|log| log.readings.len()).sum();
    if base.loss < FAR * readings as f64 {
        return Vec::new();
    }
    // Unknowns that are bent to another model are no better than first guesses.
    let first = Fit::first(kind).unknowns;
    let tried = |values: &Vec<f64>| {
        let from = begun(base, cause, values);
        let unknowns = first.clone();
        let afresh = Fit {
            unknowns,
            ..from.clone()
        };
        let here = |fit| refit(kind, fit, runs, &None, 0);
        let both = [from, afresh].into_iter().filter_map(here);
        both.min_by(|a, b| a.loss.total_cmp(&b.loss))
    };
    let mut found = Vec::new();
    for ladder in kind.causes()[cause].ladders() {
        let fits: Vec<Option<Fit>> = ladder.iter().map(tried).collect();
        let loss = |k: Option<usize>| {
            let fit = k.and_then(|k| fits.get(k)?.as_ref());
            fit.map_or(f64::INFINITY, |fit| fit.loss)
        };
        let is_bottom = |k: &usize| {
            let here = loss(Some(*k));
            here < loss(k.checked_sub(1)) && here <= loss(Some(k + 1))
        };
        let bottoms = (0..fits.len()).filter(is_bottom);
        found.extend(bottoms.filter_map(|k| fits[k].clone()));
    }
    found.sort_by(|a, b| a.loss.total_cmp(&b.loss));
    found.truncate(MOST);
    found
}

/// `fit` with residuals that are far outside counted by what is left of their channel, and with the
/// derivatives there; `slopes` are derivatives not far from it.
pub(crate) fn settled(
    kind: &dyn Kind,
    mut fit: Fit,
    mut slopes: Slopes,
    runs: &[usize],
) -> Option<(Fit, Slopes)> {
    /// Change of a scale that matters, and rounds.
    const MATTERS: f64 = 0.2;
    const ROUNDS: usize = 3;
    for _ in 0..ROUNDS {
        let now = scales(kind, &fit)?;
        let is_as_before = now
            .iter()
            .zip(&fit.scales)
            .all(|(a, b)| (a / b).ln().abs() < MATTERS);
        if is_as_before {
            break;
        }
        fit.scales = now;
        (fit, slopes) = refit_near(kind, fit, slopes, runs, ROUGH_STEPS)?;
    }
    Some((fit, slopes))
}

/// Fits each of `from`, which are `base` with one cause more, and gives the best; none where the
/// first steps do not gain `enough`.
fn fit_from(
    kind: &dyn Kind,
    base: &Fit,
    mut from: Vec<Fit>,
    runs: &[usize],
    enough: f64,
) -> Option<Fit> {
    /// Causes at a time that are many.
    const MANY: usize = 3;
    /// Steps after which starts are compared.
    const FIRST: usize = 4;
    if from.len() > MOST_STARTS {
        // The best as they are.
        let loss =
            |fit: &Fit| refit(kind, fit.clone(), runs, &None, 0).map_or(f64::INFINITY, |f| f.loss);
        let mut all: Vec<(f64, Fit)> = from.into_iter().map(|fit| (loss(&fit), fit)).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        from = all
            .into_iter()
            .take(MOST_STARTS)
            .map(|(_, fit)| fit)
            .collect();
    }
    let begun = |fit: Fit| {
        let shared = parameters_of(kind, &fit.causes);
        let mut problem = Problem::new(kind, fit, shared, runs, &None);
        problem.solve(FIRST, End::Rough)?;
        Some(problem)
    };
    let mut tried: Vec<Problem> = from.into_iter().filter_map(begun).collect();
    tried.sort_by(|a, b| a.fit.loss.total_cmp(&b.fit.loss));
    let least = tried.first()?.fit.loss;
    if base.loss - least < enough {
        return None;
    }
    // Starts that stay behind are given up.
    tried.retain(|t| t.fit.loss <= least + 0.1 * (base.loss - least).max(10.0));
    // Of a machine with so many parts, fits take long, and what is chosen is fitted again.
    let end = if kind.most() > MANY {
        End::Rough
    } else {
        End::Sure
    };
    let done = tried.into_iter().take(2).filter_map(|mut problem| {
        problem.solve(STEPS, end)?;
        Some(problem.fit)
    });
    done.min_by(|a, b| a.loss.total_cmp(&b.loss))
}

#[cfg(test)]
mod tests {
    use saltus_numeric::statistics::dot;

    use super::*;
    use crate::kind::Cause;
    use crate::toy::{ALL, READINGS, RUNS, Toy, noise, sum, wave};

    fn every_run() -> Vec<usize> {
        (0..RUNS).collect()
    }

    #[test]
    fn hubers_loss_is_smooth_and_its_weight_is_its_slope() {
        let slope = |r: f64| (huber(r + 1e-6) - huber(r - 1e-6)) / 2e-6;
        for r in [-20.0, -HUBER, -1.0, 0.5, HUBER - 1e-3, HUBER + 1e-3, 50.0] {
            assert!((slope(r) - 2.0 * weight(r) * r).abs() < 1e-5, "{r}");
            assert_eq!(huber(r), huber(-r));
        }
    }

    #[test]
    fn an_arrow_is_solved_as_any_matrix() {
        let blocks = [2, 0, 3, 1];
        for shared in [0, 1, 3] {
            let n = shared + blocks.iter().sum::<usize>();
            let owner = |i: usize| {
                let mut end = shared;
                let within = |size: &usize| {
                    end += size;
                    i < end
                };
                (i >= shared).then(|| blocks.iter().position(within))
            };
            let entry = |i: usize, j: usize| match (owner(i), owner(j)) {
                _ if i == j => 5.0 + i as f64,
                (Some(a), Some(b)) if a != b => 0.0,
                _ => ((i * j + i + j) as f64).sin(),
            };
            let a = DMatrix::from_fn(n, n, entry);
            let b = DVector::from_fn(n, |i, _| (i as f64).cos());
            let whole = a.clone().cholesky().expect("positive").solve(&b);
            let parts = arrow(&a, &b, shared, &blocks).expect("positive");
            assert!((whole - parts).amax() < 1e-13);
            assert!(arrow(&-a, &b, shared, &blocks).is_none());
        }
    }

    #[test]
    fn a_linear_fit_is_a_projection() {
        // Columns that lean on each other: the normal equations of two.
        let (a, e) = (wave(0), wave(1));
        let b = sum(&[(0.6, &a), (0.8, &e)]);
        let values = sum(&[(7.0, &a), (-4.0, &b), (0.2, &noise(5))]);
        let fit = Toy::new(&values, vec![a.clone(), b.clone()]).fitted(&[0, 1]);
        let (ya, yb) = (dot(&values, &a), dot(&values, &b));
        let closed = [(ya - 0.6 * yb) / 0.64, (yb - 0.6 * ya) / 0.64];
        for (k, closed) in closed.into_iter().enumerate() {
            assert!(
                (fit.terms.get(k, 0) - closed).abs() < 1e-2,
                "{k}: {fit:?} {closed}"
            );
        }
        let left = sum(&[(1.0, &values), (-closed[0], &a), (-closed[1], &b)]);
        let loss: f64 = left.iter().map(|r| huber(*r)).sum();
        assert!((fit.loss - loss).abs() < 1e-4 * loss, "{} {loss}", fit.loss);
    }

    #[test]
    fn a_bound_holds() {
        let a = wave(0);
        let values = sum(&[(-9.0, &a), (1.0, &noise(6))]);
        let bounded = |cause: &mut Cause| cause.parameters[0].bounds = (0.0, 5.0);
        let toy = Toy::new(&values, vec![a.clone()]).with(0, bounded);
        let fit = toy.fitted(&[0]);
        assert_eq!(fit.terms.get(0, 0), 0.0);
        assert!((fit.loss - toy.before().loss).abs() < 1e-9);
        let values = sum(&[(9.0, &a), (1.0, &noise(6))]);
        let fit = Toy::new(&values, vec![a]).with(0, bounded).fitted(&[0]);
        assert_eq!(fit.terms.get(0, 0), 5.0);
    }

    #[test]
    fn an_outlier_counts_no_more_the_farther_it_is() {
        let a = wave(0);
        let found = |outlier: f64| {
            let mut values = sum(&[(9.0, &a), (1.0, &noise(7))]);
            values[3] = outlier;
            Toy::new(&values, vec![a.clone()])
                .fitted(&[0])
                .terms
                .get(0, 0)
        };
        let [near, far] = [found(30.0), found(3e4)];
        assert!((near - far).abs() < 1e-3, "{near} {far}");
        // Least squares would put it at a[3] times 3e4, which is 2,100.
        assert!((far - 9.0).abs() < 4.0, "{far}");
    }

    #[test]
    fn only_readings_that_count_are_fitted() {
        let a = wave(0);
        let mut values = sum(&[(9.0, &a)]);
        let mut counts = vec![vec![true; READINGS]; RUNS];
        for (i, value) in values.iter_mut().enumerate().filter(|(i, _)| i % 3 == 0) {
            *value += 4.0;
            counts[i / READINGS][i % READINGS] = false;
        }
        let toy = Toy::new(&values, vec![a]);
        let mut from = toy.before();
        from.causes.push(0);
        let fit = refit(&toy, from, &every_run(), &Some(counts), STEPS).expect("an answer");
        assert!((fit.terms.get(0, 0) - 9.0).abs() < 1e-4, "{fit:?}");
        assert!(fit.loss < 1e-6, "{}", fit.loss);
    }

    #[test]
    fn a_parameter_that_is_held_stays() {
        let (a, b) = (wave(0), wave(1));
        let values = sum(&[(7.0, &a), (-4.0, &b), (1.0, &noise(8))]);
        let toy = Toy::new(&values, vec![a, b]);
        let mut from = toy.fitted(&[0, 1]);
        let free = from.terms.get(1, 0);
        from.terms.set(0, 0, 5.0);
        let slopes = slopes(&toy, &from).expect("derivatives");
        let fit = refit_but(&toy, (0, 0), from, &slopes, STEPS).expect("an answer");
        // Orthogonal to the one that is held.
        assert_eq!(fit.terms.get(0, 0), 5.0);
        assert!((fit.terms.get(1, 0) - free).abs() < 0.05, "{fit:?} {free}");
    }

    #[test]
    fn a_cause_that_gains_too_little_is_given_up() {
        let a = wave(0);
        let values = sum(&[(6.0, &a), (1.0, &noise(9))]);
        let toy = Toy::new(&values, vec![a]);
        let before = toy.before();
        let gain = before.loss - toy.fitted(&[0]).loss;
        let with = |enough| fit_if(&toy, &before, 0, &every_run(), enough);
        assert!(with(0.9 * gain).is_some() && with(1.1 * gain).is_none());
    }

    #[test]
    fn a_derivative_stays_within_bounds() {
        let a = wave(0);
        let toy = Toy::new(&noise(1), vec![a.clone()])
            .with(0, |cause| cause.parameters[0].bounds = (-1.0, 0.0));
        let terms = Terms::off(toy.causes());
        let parameter = &toy.causes()[0].parameters[0];
        let here = predicted(&toy, 2, &terms, &[]).expect("an answer");
        let place = (Place::Shared(0, 0), parameter);
        // From the upper bound it can only go down.
        let found = derivative(&toy, 2, &terms, &[], &here, place).expect("an answer");
        for (found, a) in found.iter().zip(&a[2 * READINGS..]) {
            assert!((found - a).abs() < 1e-9, "{found} {a}");
        }
        assert_eq!(RUNS * READINGS, ALL);
    }
}
