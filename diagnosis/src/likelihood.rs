//! How probable data are where a set of causes is at work.
//!
//! A reading is what the model says, the model's own error and noise. Noise is white, or follows
//! itself (an autoregression of order one). The model's own error (Kennedy and O'Hagan, Bayesian
//! calibration of computer models, 2001) is a sum of cosines over each run, of which one half is the
//! same in all runs; its amplitude is estimated for each channel, with a prior in the unit of the
//! channel. Parameters and what is not known of a run are integrated out around the fit (Laplace).

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use saltus_numeric::parallel;
use saltus_numeric::statistics::dot;

use crate::fit::{self, Fit, Place, Slopes};
use crate::kind::{Kind, Parameter};
use crate::policy::POLICY;

/// Cosines over a run: the shortest has 16 periods.
pub(crate) const WAVES: usize = 32;
/// Part of the model's own error that all runs share.
pub(crate) const SHARED: f64 = POLICY.shared;
/// Standard deviation of the logarithm of the noise about what is stated, and about what is estimated
/// from the data; far from it the prior falls as Cauchy's.
const STATED: f64 = POLICY.stated;
const ESTIMATED: f64 = POLICY.estimated;
/// Information on an unknown of a run that nothing tells of: 300 of its scales.
const VAGUE: f64 = 1e-5;
/// Error of a model of a machine as a part of a column's range.
const FORM: f64 = POLICY.form;

/// Part of the variance that cosine `k` has in the model's own error: it reverses within about a third
/// of a run, and has jumps.
pub(crate) fn share(k: usize) -> f64 {
    let whole: f64 = (0..WAVES).map(spectrum).sum();
    spectrum(k) / whole
}

fn spectrum(k: usize) -> f64 {
    1.0 / (1.0 + (k as f64 / 3.0).powi(4))
}

/// Unit cosines over `n` readings, by the recurrence of Chebyshev's polynomials.
pub(crate) fn cosines(n: usize) -> Vec<Vec<f64>> {
    let size = |k: usize| (if k == 0 { 1.0 } else { 2.0_f64 } / n as f64).sqrt();
    let mut all = vec![Vec::with_capacity(n); WAVES.min(n / 2)];
    for i in 0..n {
        let first = (std::f64::consts::PI * (i as f64 + 0.5) / n as f64).cos();
        let (mut last, mut now) = (first, 1.0);
        for (k, wave) in all.iter_mut().enumerate() {
            wave.push(size(k) * now);
            (last, now) = (now, 2.0 * first * now - last);
        }
    }
    all
}

/// Noise of each channel and error of the model, as far as they are known before a fit.
#[derive(Clone, Debug)]
pub(crate) struct Expected {
    /// Scale of the model's own error (σ of a reading).
    pub(crate) amplitude: Vec<f64>,
    /// Standard deviation of the logarithm of the noise.
    width: Vec<f64>,
    /// Correlation of the noise of a reading with that of the one before.
    pub(crate) follows: Vec<f64>,
    /// Over how many readings what is left is alike: so many count as one.
    pub(crate) alike: Vec<f64>,
    /// Logarithm of the least noise: that of rounding. A column that stands still shows less of it than one
    /// that moves.
    least: Vec<f64>,
}

impl Expected {
    pub(crate) fn new(kind: &dyn Kind) -> Expected {
        /// Logarithm of the least noise of a column that is not rounded, in terms of the stated one.
        const LEAST: f64 = -5.0;
        let channels = kind.channels();
        let mut ends = vec![(f64::INFINITY, f64::NEG_INFINITY); channels.len()];
        for reading in kind.logs().iter().flat_map(|log| &log.readings) {
            let (low, high) = &mut ends[reading.channel];
            (*low, *high) = (low.min(reading.value), high.max(reading.value));
        }
        let by_inputs = by_inputs(kind);
        let amplitude = |(c, channel): (usize, &crate::kind::Channel)| {
            let span = (ends[c].1 - ends[c].0).max(0.0);
            (FORM * span / channel.noise)
                .hypot(kind.discrepancy())
                .hypot(by_inputs[c])
        };
        let width = |c: &crate::kind::Channel| if c.is_given { STATED } else { ESTIMATED };
        let least = |c: &crate::kind::Channel| (c.step / 12f64.sqrt() / c.noise).ln().max(LEAST);
        Expected {
            amplitude: channels.iter().enumerate().map(amplitude).collect(),
            width: channels.iter().map(width).collect(),
            follows: vec![0.0; channels.len()],
            alike: vec![1.0; channels.len()],
            least: channels.iter().map(least).collect(),
        }
    }

    /// How many readings of each channel count as one.
    pub(crate) fn together(&self) -> Vec<f64> {
        let of = |(follows, alike): (&f64, &f64)| alike.max((1.0 + follows) / (1.0 - follows));
        self.follows.iter().zip(&self.alike).map(of).collect()
    }
}

/// Root mean square (σ) of the change that noise of measured inputs makes in each channel.
fn by_inputs(kind: &dyn Kind) -> Vec<f64> {
    use rand_distr::{Distribution, StandardNormal};
    const DRAWS: usize = 8;
    let mut random = rand_pcg::Pcg64::new(1, 11);
    let channels = kind.channels();
    let mut sums = vec![(0.0, 0.0_f64); channels.len()];
    for _ in 0..DRAWS {
        for (run, log) in kind.logs().iter().enumerate() {
            let Some(moved) = kind.input_noise(run, &mut || StandardNormal.sample(&mut random))
            else {
                return vec![0.0; channels.len()];
            };
            for (reading, moved) in log.readings.iter().zip(moved) {
                let sum = &mut sums[reading.channel];
                sum.0 += (moved / channels[reading.channel].noise).powi(2);
                sum.1 += 1.0;
            }
        }
    }
    sums.into_iter()
        .map(|(sum, n)| (sum / n.max(1.0)).sqrt())
        .collect()
}

/// Noise and model error of a channel, in the noise as it is stated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scatter {
    /// White noise.
    pub(crate) noise: f64,
    /// The model's own error.
    pub(crate) amplitude: f64,
}

/// One channel of one run: products of its columns.
struct Part {
    run: usize,
    channel: usize,
    /// How many readings it counts as.
    count: f64,
    /// Products of every two columns.
    gram: DMatrix<f64>,
    /// Parts of the columns along each cosine.
    waves: Vec<DVector<f64>>,
}

/// The readings of a part.
#[derive(Clone)]
struct Series {
    /// Its columns (σ), one number for each reading.
    columns: Vec<Vec<f64>>,
    /// How much each reading counts.
    counts: Vec<f64>,
}

/// A model near a fit: the products of its derivatives and residuals are all that a likelihood needs.
///
/// Its columns are the parameters that all runs share, in turn, then the unknowns of each run, then
/// the residuals.
pub(crate) struct Linear {
    /// Parameters that all runs share.
    pub(crate) shared: Vec<(usize, usize)>,
    own: Vec<usize>,
    parts: Vec<Part>,
    channels: usize,
    /// Logarithm of the determinant of the filter that makes noise white.
    whitening: f64,
    /// The columns of each run as they are, without the residuals.
    columns: Vec<Vec<Vec<f64>>>,
    /// Of each part.
    series: Vec<Series>,
}

/// Removes what each reading's noise has of the one before.
fn whitened(values: &mut [f64], follows: f64) {
    if follows == 0.0 {
        return;
    }
    let size = (1.0 - follows * follows).sqrt();
    for i in (1..values.len()).rev() {
        values[i] = (values[i] - follows * values[i - 1]) / size;
    }
}

impl Linear {
    /// At `fit`, with the parameters of `causes` and of what nobody knows.
    pub(crate) fn new(
        kind: &dyn Kind,
        fit: &Fit,
        causes: &[usize],
        expected: &Expected,
    ) -> Option<Linear> {
        // Of a cause that small steps do not reach, a column for each of its starts.
        let far = |c: usize| kind.causes()[c].is_apart() && !fit.causes.contains(&c);
        let near: Vec<usize> = causes.iter().copied().filter(|c| !far(*c)).collect();
        let mut shared = fit::parameters_of(kind, &near);
        for &c in causes.iter().filter(|c| far(**c)) {
            shared.extend((0..kind.causes()[c].starts().len()).map(|k| (c, k)));
        }
        let runs = kind.logs().len();
        let columns = parallel::map(runs, |run| columns(kind, fit, run, &shared));
        Linear::of(
            kind,
            fit,
            shared,
            columns.into_iter().collect::<Option<_>>()?,
            expected,
        )
    }

    /// At `fit`, with the derivatives there.
    pub(crate) fn with(
        kind: &dyn Kind,
        fit: &Fit,
        slopes: Slopes,
        expected: &Expected,
    ) -> Option<Linear> {
        let shared = fit::parameters_of(kind, &fit.causes);
        // What has no answer nearby does not change.
        let of_run = |(run, slopes): (usize, Vec<Option<Vec<f64>>>)| {
            let none = || vec![0.0; kind.logs()[run].readings.len()];
            slopes
                .into_iter()
                .map(|slope| slope.unwrap_or_else(none))
                .collect()
        };
        let columns = slopes.into_iter().enumerate().map(of_run).collect();
        Linear::of(kind, fit, shared, columns, expected)
    }

    fn of(
        kind: &dyn Kind,
        fit: &Fit,
        shared: Vec<(usize, usize)>,
        columns: Vec<Vec<Vec<f64>>>,
        expected: &Expected,
    ) -> Option<Linear> {
        let runs = kind.logs().len();
        let parts = parallel::map(runs, |run| parts(kind, fit, run, &columns[run], expected));
        let (mut all, mut series) = (Vec::new(), Vec::new());
        for part in parts {
            for (part, columns) in part? {
                series.push(columns);
                all.push(part);
            }
        }
        let whitening = |(part, Series { counts, .. }): (&Part, &Series)| {
            let follows = expected.follows[part.channel];
            (counts.len().saturating_sub(1)) as f64 * (1.0 - follows * follows).ln()
        };
        Some(Linear {
            whitening: all.iter().zip(&series).map(whitening).sum(),
            series,
            shared,
            own: (0..runs).map(|run| fit.unknowns[run].len()).collect(),
            parts: all,
            columns,
            channels: kind.channels().len(),
        })
    }

    /// Root mean square of the residuals (σ) of the channel of which it is the greatest.
    pub(crate) fn left_most(&self) -> f64 {
        let mut sums = vec![(0.0, 0.0); self.channels];
        for part in &self.parts {
            let last = part.gram.nrows() - 1;
            let (square, count) = &mut sums[part.channel];
            *square += part.gram[(last, last)];
            *count += part.count;
        }
        let rms = |(square, count): &(f64, f64)| (square / count.max(1e-300)).sqrt();
        sums.iter().map(rms).fold(0.0, f64::max)
    }

    /// The same where the parameters of some columns have gone back by so many of their scales; without its
    /// series.
    pub(crate) fn without(&self, moves: &[(usize, f64)]) -> Linear {
        let part = |part: &Part| {
            let last = part.gram.nrows() - 1;
            let (mut gram, mut waves) = (part.gram.clone(), part.waves.clone());
            for &(place, back) in moves {
                let column = gram.column(place) * back;
                gram.column_mut(last).zip_apply(&column, |x, c| *x += c);
                let row = gram.row(place) * back;
                gram.row_mut(last).zip_apply(&row, |x, c| *x += c);
                for along in &mut waves {
                    along[last] += back * along[place];
                }
            }
            Part {
                gram,
                waves,
                ..*part
            }
        };
        Linear {
            parts: self.parts.iter().map(part).collect(),
            shared: self.shared.clone(),
            own: self.own.clone(),
            columns: Vec::new(),
            series: Vec::new(),
            ..*self
        }
    }

    /// The same with other residuals: each by so much (σ) in each run.
    pub(crate) fn shifted(&self, by: &[Vec<f64>], kind: &dyn Kind) -> Linear {
        let mut series = self.series.clone();
        let parts = self
            .parts
            .iter()
            .zip(&mut series)
            .map(|(part, Series { columns, .. })| {
                let last = columns.len() - 1;
                let readings = kind.logs()[part.run].readings.iter().zip(&by[part.run]);
                let here = readings.filter(|(reading, _)| reading.channel == part.channel);
                for (x, (_, by)) in columns[last].iter_mut().zip(here) {
                    *x += by;
                }
                let mut gram = part.gram.clone();
                for i in 0..=last {
                    let product = dot(&columns[i], &columns[last]);
                    (gram[(i, last)], gram[(last, i)]) = (product, product);
                }
                let mut waves = part.waves.clone();
                for (along, wave) in waves.iter_mut().zip(cosines(columns[last].len())) {
                    along[last] = dot(&wave, &columns[last]);
                }
                Part {
                    gram,
                    waves,
                    ..*part
                }
            });
        Linear {
            parts: parts.collect(),
            shared: self.shared.clone(),
            own: self.own.clone(),
            columns: Vec::new(),
            series,
            ..*self
        }
    }

    /// The derivatives for a fit of `causes`; none of causes of which only starts were looked at.
    pub(crate) fn slopes(&self, kind: &dyn Kind, fit: &Fit, causes: &[usize]) -> Slopes {
        let is_far = |c: usize| kind.causes()[c].is_apart() && !fit.causes.contains(&c);
        let place = |(c, p): (usize, usize)| {
            let found = self.shared.iter().position(|place| *place == (c, p));
            found.filter(|_| !is_far(c))
        };
        let places: Vec<Option<usize>> = fit::parameters_of(kind, causes)
            .into_iter()
            .map(place)
            .collect();
        let of_run = |columns: &Vec<Vec<f64>>| {
            let shared = places.iter().map(|place| place.map(|k| columns[k].clone()));
            let own = columns[self.shared.len()..]
                .iter()
                .map(|column| Some(column.clone()));
            shared.chain(own).collect()
        };
        self.columns.iter().map(of_run).collect()
    }

    /// The places of `causes` among the columns.
    pub(crate) fn places(&self, has: impl Fn(usize) -> bool) -> Vec<usize> {
        (0..self.shared.len())
            .filter(|k| has(self.shared[*k].0))
            .collect()
    }

    /// How probable the data are with the columns `active`, near the fit: parameters are those of least
    /// squares, which the model's own error does not bend (Tuo and Wu, Efficient calibration for
    /// imperfect computer models, 2015).
    pub(crate) fn evaluate(
        &self,
        active: &[usize],
        expected: &Expected,
        is_free: bool,
    ) -> Option<Likely> {
        let as_stated = vec![
            Scatter {
                noise: 1.0,
                amplitude: 0.0
            };
            self.channels
        ];
        let step = self.solved(active, &as_stated)?.step;
        self.likely(active, expected, is_free, step)
    }

    /// The same where parameters are the most probable ones beside the model's own error.
    pub(crate) fn evaluate_bent(
        &self,
        active: &[usize],
        expected: &Expected,
        is_free: bool,
    ) -> Option<Likely> {
        /// Rounds of estimating parameters and noise in turn.
        const ROUNDS: usize = 4;
        let n = active.len() + self.own.iter().sum::<usize>();
        let mut step = DVector::zeros(n);
        for _ in 0..ROUNDS {
            let scatter = self.scatter(active, &step, expected, is_free);
            step = self.solved(active, &scatter)?.step;
        }
        self.likely(active, expected, is_free, step)
    }

    fn likely(
        &self,
        active: &[usize],
        expected: &Expected,
        is_free: bool,
        step: DVector<f64>,
    ) -> Option<Likely> {
        let scatter = self.scatter(active, &step, expected, is_free);
        let solved = self.solved(active, &scatter)?;
        let off = &step - &solved.step;
        let square = solved.square + off.dot(&(&solved.information * &off));
        let priors: f64 = scatter
            .iter()
            .enumerate()
            .map(|(c, s)| expected.prior(c, *s, is_free))
            .sum();
        Some(Likely {
            log: -0.5 * (square + solved.volume) + priors,
            scatter,
            step,
            variance: solved.variances(active.len()),
        })
    }

    /// Products of the shared columns and the residuals, clear of what the unknowns of each run can do; and
    /// how many readings count.
    pub(crate) fn reduced(&self) -> (DMatrix<f64>, f64) {
        let n = self.shared.len();
        let mut all = DMatrix::zeros(n + 1, n + 1);
        for (run, &own) in self.own.iter().enumerate() {
            let m = n + own + 1;
            let mut gram = DMatrix::zeros(m, m);
            for part in self.parts.iter().filter(|part| part.run == run) {
                gram += &part.gram;
            }
            let kept: Vec<usize> = (0..n).chain([m - 1]).collect();
            let mut of_own = gram.view((n, n), (own, own)).into_owned();
            for i in 0..own {
                of_own[(i, i)] += VAGUE;
            }
            let Some(factor) = of_own.cholesky() else {
                continue;
            };
            let beside = DMatrix::from_fn(own, n + 1, |i, j| gram[(n + i, kept[j])]);
            let head = DMatrix::from_fn(n + 1, n + 1, |i, j| gram[(kept[i], kept[j])]);
            all += head - beside.transpose() * factor.solve(&beside);
        }
        (all, self.parts.iter().map(|part| part.count).sum())
    }

    /// `fit` with `cause` on and all parameters where the linear model with the columns `active` has them.
    pub(crate) fn moved(
        &self,
        kind: &dyn Kind,
        fit: &Fit,
        (cause, active): (usize, &[usize]),
        likely: &Likely,
    ) -> Fit {
        let mut moved = fit.clone();
        if !moved.causes.contains(&cause) {
            moved.causes.push(cause);
        }
        for (k, place) in active.iter().enumerate() {
            let (c, p) = self.shared[*place];
            let spec = &kind.causes()[c].parameters[p];
            let x = fit.terms.get(c, p) + likely.step[k] * spec.scale;
            moved.terms.set(c, p, x.clamp(spec.bounds.0, spec.bounds.1));
        }
        let mut at = active.len();
        for (run, unknowns) in moved.unknowns.iter_mut().enumerate() {
            for (x, spec) in unknowns.iter_mut().zip(kind.unknowns(run)) {
                *x = (*x + likely.step[at] * spec.scale).clamp(spec.bounds.0, spec.bounds.1);
                at += 1;
            }
        }
        moved
    }

    /// What the most probable parameters and the model's own error leave of each channel of each run, in
    /// its noise; slips of the instrument are cut.
    pub(crate) fn left(&self, active: &[usize], likely: &Likely) -> Vec<(usize, Vec<f64>)> {
        let of = |(part, Series { columns, counts }): (&Part, &Series)| {
            let Scatter { noise, amplitude } = likely.scatter[part.channel];
            let (local, global) = self.index(active, part);
            let mut left = vec![0.0; counts.len()];
            for (column, at) in local.iter().zip(&global) {
                let x = likely.step.get(*at).map_or(1.0, |step| -step) / noise;
                for (left, column) in left.iter_mut().zip(&columns[*column]) {
                    *left += x * column;
                }
            }
            for (x, count) in left.iter_mut().zip(counts) {
                if *count < 1.0 {
                    *x = x.clamp(-1.0, 1.0);
                }
            }
            for (k, wave) in cosines(left.len()).iter().enumerate() {
                let variance = (amplitude / noise).powi(2) * part.count * share(k);
                let along: f64 = wave.iter().zip(&left).map(|(a, b)| a * b).sum();
                let along = variance / (1.0 + variance) * along;
                for (x, wave) in left.iter_mut().zip(wave) {
                    *x -= along * wave;
                }
            }
            (part.channel, left)
        };
        self.parts.iter().zip(&self.series).map(of).collect()
    }

    /// Logarithm of the odds of something short in what is left, whatever its shape: the greatest sum of
    /// neighbours, of all windows of 2, 4, 8 … readings (a scan statistic), beyond what the model of each
    /// channel may be off by on average over a window.
    pub(crate) fn bump(left: &[(usize, Vec<f64>)], off: &[f64]) -> f64 {
        /// Logarithm of the odds against it.
        const AGAINST: f64 = 10.0;
        let (mut most, mut windows) = (0.0_f64, 0.0);
        for (channel, left) in left {
            let mut sums = vec![0.0];
            for x in left {
                sums.push(sums[sums.len() - 1] + x);
            }
            let mut length = 2;
            while length <= left.len() / 2 {
                for end in (length..sums.len()).step_by(length / 2) {
                    let mean = (sums[end] - sums[end - length]) / length as f64;
                    let beyond = (mean.abs() - off[*channel]).max(0.0);
                    most = most.max(beyond * beyond * length as f64);
                    windows += 1.0;
                }
                length *= 2;
            }
        }
        0.5 * most - f64::max(windows, 1.0).ln() - AGAINST
    }

    /// Logarithm of the determinant of the information that white noise as stated leaves on the unknowns
    /// of each run.
    fn own_volume(&self) -> f64 {
        let mut volume = 0.0;
        for (run, &own) in self.own.iter().enumerate() {
            let mut information = DMatrix::from_diagonal_element(own, own, VAGUE);
            for part in self.parts.iter().filter(|part| part.run == run) {
                let first = self.shared.len();
                information += part.gram.view((first, first), (own, own));
            }
            if let Some(factor) = information.cholesky() {
                let diagonal = factor.l_dirty().diagonal();
                volume += 2.0 * diagonal.iter().map(|x: &f64| x.ln()).sum::<f64>();
            }
        }
        volume
    }

    /// Where in the whole system the columns of a part are: shared ones of `active`, own ones, and the
    /// residuals last.
    fn index(&self, active: &[usize], part: &Part) -> (Vec<usize>, Vec<usize>) {
        let before: usize = self.own[..part.run].iter().sum();
        let own = self.own[part.run];
        let all = active.len() + self.own.iter().sum::<usize>();
        let local = active
            .iter()
            .copied()
            .chain(self.shared.len()..=self.shared.len() + own);
        let first = active.len() + before;
        let global = (0..active.len()).chain(first..first + own).chain([all]);
        (local.collect(), global.collect())
    }

    /// Noise and model error of each channel, by what a step leaves of the residuals.
    fn scatter(
        &self,
        active: &[usize],
        step: &DVector<f64>,
        expected: &Expected,
        is_free: bool,
    ) -> Vec<Scatter> {
        let mut left: Vec<Left> = (0..self.channels).map(|_| Left::default()).collect();
        for part in &self.parts {
            let (local, global) = self.index(active, part);
            let x = DVector::from_iterator(
                local.len(),
                global.iter().map(|g| step.get(*g).map_or(1.0, |s| -s)),
            );
            let mut square = 0.0;
            for (a, i) in local.iter().enumerate() {
                for (b, j) in local.iter().enumerate() {
                    square += x[a] * x[b] * part.gram[(*i, *j)];
                }
            }
            let along =
                |wave: &DVector<f64>| local.iter().zip(x.iter()).map(|(i, x)| wave[*i] * x).sum();
            let of = &mut left[part.channel];
            of.square += square.max(0.0);
            of.count += part.count;
            of.runs
                .push((part.count, part.waves.iter().map(along).collect()));
        }
        left.iter()
            .enumerate()
            .map(|(c, left)| left.scatter(c, expected, is_free))
            .collect()
    }

    /// The step to the best parameters where noise and model error are known.
    fn solved(&self, active: &[usize], scatter: &[Scatter]) -> Option<Solved> {
        let n = active.len() + self.own.iter().sum::<usize>();
        let mut system = DMatrix::zeros(n + 1, n + 1);
        let mut common: Vec<Vec<(DVector<f64>, f64)>> =
            vec![vec![(DVector::zeros(n + 1), 0.0); WAVES]; self.channels];
        let mut volume = self.whitening;
        for part in &self.parts {
            let Scatter { noise, amplitude } = scatter[part.channel];
            let (local, global) = self.index(active, part);
            let weight = 1.0 / (noise * noise);
            volume += part.count * (noise * noise).ln();
            for (a, i) in local.iter().enumerate() {
                for (b, j) in local.iter().enumerate().take(a + 1) {
                    system[(global[a], global[b])] += weight * part.gram[(*i, *j)];
                }
            }
            if amplitude == 0.0 {
                continue;
            }
            for (k, wave) in part.waves.iter().enumerate() {
                let variance = amplitude * amplitude * part.count * share(k) * weight;
                let (own, all) = ((1.0 - SHARED) * variance, SHARED * variance);
                let less = own / (1.0 + own) * weight;
                for (a, i) in local.iter().enumerate() {
                    for (b, j) in local.iter().enumerate().take(a + 1) {
                        system[(global[a], global[b])] -= less * wave[*i] * wave[*j];
                    }
                }
                volume += (1.0 + own).ln();
                let (sum, size) = &mut common[part.channel][k];
                let factor = (all * weight).sqrt() / (1.0 + own);
                for (i, g) in local.iter().zip(&global) {
                    sum[*g] += factor * wave[*i];
                }
                *size += all / (1.0 + own);
            }
        }
        for (sum, size) in common.iter().flatten().filter(|(_, size)| *size > 0.0) {
            volume += (1.0 + size).ln();
            let less = 1.0 / (1.0 + size);
            for i in 0..=n {
                if sum[i] != 0.0 {
                    for j in 0..=i {
                        system[(i, j)] -= less * sum[i] * sum[j];
                    }
                }
            }
        }
        system.fill_upper_triangle_with_lower_triangle();
        let information = system.view((0, 0), (n, n)).into_owned();
        let slope = system.view((0, n), (n, 1)).column(0).into_owned();
        let mut held = information.clone();
        for i in 0..n {
            // What the data do not tell stays near where it is.
            held[(i, i)] +=
                if i < active.len() { 1e-9 } else { VAGUE } + 1e-10 * information[(i, i)];
        }
        let factor = held.cholesky()?;
        let step = factor.solve(&slope);
        let diagonal = factor.l_dirty().diagonal();
        // How far the unknowns of a run may go by the readings alone is no matter of the causes.
        volume -= self.own_volume();
        volume += 2.0 * diagonal.iter().map(|x: &f64| x.ln()).sum::<f64>();
        Some(Solved {
            square: system[(n, n)] - slope.dot(&step),
            volume,
            step,
            factor,
            information,
        })
    }
}

/// The columns of one run, without the residuals.
fn columns(
    kind: &dyn Kind,
    fit: &Fit,
    run: usize,
    shared: &[(usize, usize)],
) -> Option<Vec<Vec<f64>>> {
    let here = fit::predicted(kind, run, &fit.terms, &fit.unknowns[run])?;
    let of_shared = |&(c, p): &(usize, usize)| {
        let cause = &kind.causes()[c];
        if cause.is_apart() && !fit.causes.contains(&c) {
            return away(kind, run, fit, &here, (c, &cause.starts()[p]));
        }
        let place = (Place::Shared(c, p), &cause.parameters[p]);
        derivative(kind, run, fit, &here, place)
    };
    let own = kind.unknowns(run);
    let of_own = |(k, parameter)| derivative(kind, run, fit, &here, (Place::Own(k), parameter));
    let of_own = own.iter().enumerate().map(of_own);
    Some(shared.iter().map(of_shared).chain(of_own).collect())
}

/// The products of one run.
fn parts(
    kind: &dyn Kind,
    fit: &Fit,
    run: usize,
    columns: &[Vec<f64>],
    expected: &Expected,
) -> Option<Vec<(Part, Series)>> {
    let residuals = fit::residuals(kind, run, &fit.terms, &fit.unknowns[run])?;
    let readings = &kind.logs()[run].readings;
    let columns = || columns.iter().chain([&residuals]);
    let mut all = Vec::new();
    for channel in 0..kind.channels().len() {
        let places: Vec<usize> = (0..readings.len())
            .filter(|i| readings[*i].channel == channel)
            .collect();
        if places.is_empty() {
            continue;
        }
        let left: Vec<f64> = places.iter().map(|i| residuals[*i]).collect();
        let counts = counts(&left, fit.scale(channel));
        let alike = expected.alike[channel];
        let series: Vec<Vec<f64>> = columns()
            .map(|column| {
                let mut series: Vec<f64> = places
                    .iter()
                    .zip(&counts)
                    .map(|(i, w)| column[*i] * (w / alike).sqrt())
                    .collect();
                whitened(&mut series, expected.follows[channel]);
                series
            })
            .collect();
        let n = series.len();
        let mut gram = DMatrix::zeros(n, n);
        for i in 0..n {
            for j in 0..=i {
                gram[(i, j)] = dot(&series[i], &series[j]);
                gram[(j, i)] = gram[(i, j)];
            }
        }
        let waves = cosines(places.len());
        let along =
            |wave: &Vec<f64>| DVector::from_iterator(n, series.iter().map(|s| dot(wave, s)));
        let weights = places.iter().map(|i| readings[*i].weight);
        let part = Part {
            run,
            channel,
            count: weights.zip(&counts).map(|(a, b)| a * b / alike).sum(),
            gram,
            waves: waves.iter().map(along).collect(),
        };
        all.push((
            part,
            Series {
                columns: series,
                counts,
            },
        ));
    }
    Some(all)
}

/// How much each of the residuals of a series counts: one that is far outside, and alone, counts as if it
/// were as far as Huber's loss is quadratic, wherever it is. What neighbours agree on, within the same
/// factor, is no slip of the instrument.
pub(crate) fn counts(residuals: &[f64], scale: f64) -> Vec<f64> {
    let of = |(i, r): (usize, &f64)| {
        let before = i.checked_sub(1).and_then(|k| residuals.get(k));
        let mut beside = before.into_iter().chain(residuals.get(i + 1));
        if beside.any(|x| x * r.signum() * fit::HUBER > r.abs()) {
            1.0
        } else {
            fit::weight_at(*r, scale).powi(2)
        }
    };
    residuals.iter().enumerate().map(of).collect()
}

/// How a prediction changes with a parameter; not at all where the model has no answer.
fn derivative(
    kind: &dyn Kind,
    run: usize,
    fit: &Fit,
    here: &[f64],
    place: (Place, &Parameter),
) -> Vec<f64> {
    let found = fit::derivative(kind, run, &fit.terms, &fit.unknowns[run], here, place);
    found.unwrap_or_else(|| vec![0.0; here.len()])
}

/// How a prediction changes where a cause goes from none to one of its starts.
fn away(
    kind: &dyn Kind,
    run: usize,
    fit: &Fit,
    here: &[f64],
    (cause, start): (usize, &[f64]),
) -> Vec<f64> {
    let mut terms = fit.terms.clone();
    for (p, value) in start.iter().enumerate() {
        terms.set(cause, p, *value);
    }
    let there = fit::predicted(kind, run, &terms, &fit.unknowns[run]);
    there.map_or_else(
        || vec![0.0; here.len()],
        |there| there.iter().zip(here).map(|(t, h)| t - h).collect(),
    )
}

struct Solved {
    step: DVector<f64>,
    information: DMatrix<f64>,
    factor: Cholesky<f64, Dyn>,
    square: f64,
    /// Twice the logarithms of all determinants.
    volume: f64,
}

impl Solved {
    /// Variances of the first `count` parameters.
    fn variances(&self, count: usize) -> Vec<f64> {
        let root = self.factor.l_dirty();
        let n = root.nrows();
        let of = |k: usize| {
            let mut unit = DVector::zeros(n - k);
            unit[0] = 1.0;
            root.view((k, k), (n - k, n - k))
                .solve_lower_triangular_mut(&mut unit);
            unit.norm_squared()
        };
        (0..count).map(of).collect()
    }
}

/// What is left of a channel.
#[derive(Default)]
struct Left {
    square: f64,
    count: f64,
    /// Of each run how many readings it counts as, and the parts along the cosines.
    runs: Vec<(f64, Vec<f64>)>,
}

impl Left {
    /// Twice the negative logarithm of the probability.
    fn cost(&self, scatter: Scatter) -> f64 {
        /// A product that further factors must not make infinite.
        const HUGE: f64 = 1e100;
        let Scatter { noise, amplitude } = scatter;
        let weight = 1.0 / (noise * noise);
        let mut cost = self.square * weight - self.count * weight.ln();
        for k in 0..WAVES {
            let part = amplitude * amplitude * share(k) * weight;
            let (mut sum, mut size, mut product) = (0.0, 0.0, 1.0);
            for (count, waves) in self.runs.iter().filter(|run| run.1.len() > k) {
                let variance = part * count;
                let (own, all) = ((1.0 - SHARED) * variance, SHARED * variance);
                let (z, whole) = (waves[k] * weight.sqrt(), 1.0 / (1.0 + own));
                // One logarithm of many factors.
                product *= 1.0 + own;
                if product > HUGE {
                    cost += product.ln();
                    product = 1.0;
                }
                cost -= own * whole * z * z;
                sum += all.sqrt() * whole * z;
                size += all * whole;
            }
            cost += (product * (1.0 + size)).ln() - sum * sum / (1.0 + size);
        }
        cost
    }

    /// The most probable noise and model error.
    fn scatter(&self, channel: usize, expected: &Expected, is_free: bool) -> Scatter {
        if self.count == 0.0 {
            return Scatter {
                noise: 1.0,
                amplitude: 0.0,
            };
        }
        let cost =
            |scatter: Scatter| self.cost(scatter) - 2.0 * expected.prior(channel, scatter, is_free);
        let most = (self.square / self.count).sqrt().max(1.0);
        let mut best = Scatter {
            noise: 1.0,
            amplitude: 0.0,
        };
        for _ in 0..3 {
            best.noise = least(
                &|x| {
                    cost(Scatter {
                        noise: x.exp(),
                        ..best
                    })
                },
                (expected.least[channel], most.ln() + 0.5),
                best.noise.ln(),
            )
            .exp();
            let low = (1e-3 * expected.amplitude[channel]).max(1e-12).ln();
            let at = least(
                &|x| {
                    cost(Scatter {
                        amplitude: x.exp(),
                        ..best
                    })
                },
                (low, (2.0 * most).ln().max(low) + 3.0),
                best.amplitude.max(1e-300).ln(),
            )
            .exp();
            let with = Scatter {
                amplitude: at,
                ..best
            };
            best = if cost(with)
                < cost(Scatter {
                    amplitude: 0.0,
                    ..best
                }) {
                with
            } else {
                Scatter {
                    amplitude: 0.0,
                    ..best
                }
            };
        }
        best
    }
}

/// Where a function is least: a grid, then a golden section.
fn least(of: &dyn Fn(f64) -> f64, (low, high): (f64, f64), now: f64) -> f64 {
    const GRID: usize = 8;
    const GOLDEN: f64 = 0.618_034;
    let at = |k: usize| low + (high - low) * k as f64 / GRID as f64;
    let values: Vec<f64> = (0..=GRID).map(|k| of(at(k))).collect();
    let k = (0..=GRID)
        .min_by(|a, b| values[*a].total_cmp(&values[*b]))
        .unwrap_or(0);
    let (mut a, mut b) = (at(k.saturating_sub(1)), at((k + 1).min(GRID)));
    let (mut x, mut y) = (b - GOLDEN * (b - a), a + GOLDEN * (b - a));
    let (mut fx, mut fy) = (of(x), of(y));
    for _ in 0..10 {
        if fx < fy {
            (b, y, fy) = (y, x, fx);
            x = b - GOLDEN * (b - a);
            fx = of(x);
        } else {
            (a, x, fx) = (x, y, fy);
            y = a + GOLDEN * (b - a);
            fy = of(y);
        }
    }
    let best = if fx < fy { x } else { y };
    if now >= low && now <= high && of(now) < of(best) {
        now
    } else {
        best
    }
}

impl Expected {
    /// Whether the model's own error is beyond what is expected of it, or what is left follows itself and is
    /// more than noise.
    pub(crate) fn is_beyond(&self, channel: usize, scatter: Scatter) -> bool {
        /// Deviations of a half-normal prior that hold 95 % of it.
        const BEYOND: f64 = 1.96;
        /// Noise in terms of the stated one.
        const MORE: f64 = 1.5;
        let is_noisy = self.alike[channel] > 1.0 && scatter.noise > MORE;
        is_noisy || scatter.amplitude > BEYOND * self.amplitude[channel]
    }

    /// Logarithm of the prior probability of noise and model error; where the model is free to be off,
    /// by the logarithm of its error alone.
    fn prior(&self, channel: usize, scatter: Scatter, is_free: bool) -> f64 {
        /// Logarithm of the factor by which noise that follows itself is more than is stated.
        const FOLLOWS: f64 = 0.2;
        let off = scatter.noise.ln() / self.width[channel];
        let mut noise = -(1.0 + off * off).ln();
        if self.follows[channel] > 0.0 {
            noise -= 0.5 * (scatter.noise.ln() / (FOLLOWS + self.width[channel])).powi(2);
        }
        let scale = self.amplitude[channel].max(1e-9);
        let beyond = scatter.amplitude / scale;
        let half_normal = -0.5 * beyond * beyond;
        if is_free {
            // Flat in the logarithm beyond the scale, over four decades.
            return noise + half_normal.max(-9.2_f64.ln());
        }
        noise + half_normal
    }
}

/// How probable data are with some causes.
#[derive(Clone, Debug)]
pub(crate) struct Likely {
    /// Logarithm, up to a constant of the data; without the prior of parameters.
    pub(crate) log: f64,
    pub(crate) scatter: Vec<Scatter>,
    /// From the fit to the most probable parameters, in their scales: shared ones, then own ones.
    pub(crate) step: DVector<f64>,
    /// Variances of the shared ones.
    pub(crate) variance: Vec<f64>,
}

#[cfg(test)]
mod tests {
    use rand_distr::{Distribution, StandardNormal};
    use rand_pcg::Pcg64;

    use super::*;
    use crate::settings::Settings;
    use crate::toy::{ALL, READINGS, RUNS, Toy, noise, sum, wave};
    use crate::view::View;

    /// Covariance of the readings of all runs of the toy.
    fn covariance(scatter: Scatter) -> DMatrix<f64> {
        let waves = cosines(READINGS);
        DMatrix::from_fn(ALL, ALL, |i, j| {
            let (run, other) = (i / READINGS, j / READINGS);
            let alike = if run == other { 1.0 } else { SHARED };
            let shapes = waves.iter().enumerate();
            let each =
                |(k, wave): (usize, &Vec<f64>)| share(k) * wave[i % READINGS] * wave[j % READINGS];
            let smooth: f64 = shapes.map(each).sum();
            let white = if i == j { scatter.noise.powi(2) } else { 0.0 };
            white + scatter.amplitude.powi(2) * READINGS as f64 * alike * smooth
        })
    }

    /// The toy without a cause, every reading counted in full.
    fn squares(toy: &Toy) -> Fit {
        Fit {
            scales: vec![f64::INFINITY],
            ..toy.before()
        }
    }

    fn volume(matrix: &DMatrix<f64>) -> f64 {
        let factor = matrix.clone().cholesky().expect("positive");
        2.0 * factor
            .l_dirty()
            .diagonal()
            .iter()
            .map(|x| x.ln())
            .sum::<f64>()
    }

    const SCATTERS: [Scatter; 3] = [
        Scatter {
            noise: 1.0,
            amplitude: 0.0,
        },
        Scatter {
            noise: 0.8,
            amplitude: 0.3,
        },
        Scatter {
            noise: 2.0,
            amplitude: 40.0,
        },
    ];

    #[test]
    fn shares_add_up_to_one() {
        assert!(((0..WAVES).map(share).sum::<f64>() - 1.0).abs() < 1e-12);
    }

    /// Noise, model error that runs share, and parameters: as by the whole covariance matrix.
    #[test]
    fn a_likelihood_is_that_of_the_whole_covariance() {
        let data = sum(&[(12.0, &wave(3)), (1.0, &noise(4))]);
        let toy = Toy::new(
            &data,
            vec![wave(3), sum(&[(0.6, &wave(3)), (0.8, &wave(9))])],
        );
        let expected = Expected::new(&toy);
        let linear = Linear::new(&toy, &squares(&toy), &[0, 1], &expected).expect("slopes");
        let values = DVector::from_vec(data);
        for scatter in SCATTERS {
            let whole = covariance(scatter);
            let inverse = whole.clone().try_inverse().expect("regular");
            for active in [vec![], vec![0], vec![0, 1]] {
                let found = linear.solved(&active, &[scatter]).expect("regular");
                let columns: Vec<f64> = active
                    .iter()
                    .flat_map(|k| [wave(3), sum(&[(0.6, &wave(3)), (0.8, &wave(9))])][*k].clone())
                    .collect();
                let columns = DMatrix::from_vec(ALL, active.len(), columns);
                let information = columns.transpose() * &inverse * &columns;
                let slope = columns.transpose() * &inverse * &values;
                let mut square = values.dot(&(&inverse * &values));
                let mut determinants = volume(&whole);
                if !active.is_empty() {
                    let step = information.clone().try_inverse().expect("regular") * &slope;
                    square -= slope.dot(&step);
                    determinants += volume(&information);
                    assert!((&step - &found.step).amax() < 1e-3, "{step} {}", found.step);
                }
                assert!(
                    (found.square - square).abs() < 1e-6 * square,
                    "{} {square}",
                    found.square
                );
                assert!(
                    (found.volume - determinants).abs() < 1e-4,
                    "{} {determinants}",
                    found.volume
                );
            }
        }
    }

    /// What is left of a channel tells its noise and the error of the model.
    #[test]
    fn noise_and_model_error_are_found() {
        const DRAWS: usize = 20;
        let expected = Expected::new(&Toy::new(&[0.0; ALL], vec![]));
        for scatter in [
            Scatter {
                noise: 1.0,
                amplitude: 3.0,
            },
            Scatter {
                noise: 5.0,
                amplitude: 20.0,
            },
        ] {
            let factor = covariance(scatter).cholesky().expect("positive").l();
            let mut random = Pcg64::new(2, 2);
            let (mut white, mut smooth) = (0.0, 0.0);
            for _ in 0..DRAWS {
                let z = DVector::from_fn(ALL, |_, _| StandardNormal.sample(&mut random));
                let toy = Toy::new((&factor * z).as_slice(), vec![]);
                let linear = Linear::new(&toy, &toy.before(), &[], &expected).expect("slopes");
                let found = linear
                    .evaluate(&[], &expected, true)
                    .expect("an answer")
                    .scatter[0];
                white += found.noise.ln() / DRAWS as f64;
                smooth += found.amplitude.ln() / DRAWS as f64;
            }
            assert!(
                (white.exp() / scatter.noise - 1.0).abs() < 0.1,
                "{} {scatter:?}",
                white.exp()
            );
            assert!(
                (smooth.exp() / scatter.amplitude - 1.0).abs() < 0.3,
                "{} {scatter:?}",
                smooth.exp()
            );
        }
    }

    /// Of noise that follows itself the innovations are white.
    #[test]
    fn an_autoregression_is_whitened() {
        let mut random = Pcg64::new(3, 3);
        let mut x = 0.0;
        let mut values: Vec<f64> = (0..100_000)
            .map(|_| {
                let z: f64 = StandardNormal.sample(&mut random);
                x = 0.7 * x + f64::sqrt(1.0 - 0.49) * z;
                x
            })
            .collect();
        whitened(&mut values, 0.7);
        let n = values.len() as f64;
        let square = values.iter().map(|x| x * x).sum::<f64>() / n;
        let next = values.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / n;
        assert!(
            (square - 1.0).abs() < 0.02 && next.abs() < 0.02,
            "{square} {next}"
        );
    }

    /// Counts of a column that mostly stands still scatter less than their step does; noise does not.
    #[test]
    fn rounding_is_the_least_noise() {
        let toy = Toy::new(&[0.0; ALL], vec![]);
        let scatter = |toy: &Toy| {
            let expected = Expected::new(toy);
            let linear = Linear::new(toy, &toy.before(), &[], &expected).expect("slopes");
            linear
                .evaluate(&[], &expected, false)
                .expect("an answer")
                .scatter[0]
                .noise
        };
        assert!(scatter(&toy) < 0.1);
        let counts = toy.rounded_to(0.5 * 12f64.sqrt());
        assert!((scatter(&counts) - 0.5).abs() < 0.05);
    }

    /// One reading far outside counts less; three in a row that agree count in full.
    #[test]
    fn a_slip_of_the_instrument_stands_alone() {
        let counted = counts(&[0.1, 30.0, -0.2, 12.0, 13.0, 12.0, 0.0], 1.0);
        assert!(counted[1] < 0.2, "{counted:?}");
        assert_eq!(counted[3..6], [1.0; 3]);
        assert_eq!(counted[0], 1.0);
    }

    #[test]
    fn something_short_is_seen_and_noise_is_not() {
        let bump_beyond = |height: f64, off: f64| {
            let mut values = noise(6);
            for x in &mut values[110..114] {
                *x += height;
            }
            let toy = Toy::new(&values, vec![]);
            let expected = Expected::new(&toy);
            let linear = Linear::new(&toy, &toy.before(), &[], &expected).expect("slopes");
            let likely = linear.evaluate(&[], &expected, true).expect("an answer");
            Linear::bump(&linear.left(&[], &likely), &[off])
        };
        let bump = |height: f64| bump_beyond(height, 0.0);
        assert!(
            bump_beyond(12.0, 12.0) < 0.0,
            "the model may be off by as much"
        );
        assert!(
            bump(0.0) < 0.0 && bump(12.0) > 0.0,
            "{} {}",
            bump(0.0),
            bump(12.0)
        );
    }

    /// The unknowns of each run taken out beforehand, or solved for with the rest.
    #[test]
    fn reduced_products_are_those_of_the_whole() {
        let toy = Toy::new(
            &sum(&[(5.0, &wave(1)), (1.0, &noise(8))]),
            vec![wave(1), wave(2)],
        );
        let settings = Settings::default();
        let view = View::new(&toy, &settings);
        let linear =
            Linear::new(&view, &squares(&toy), &[0, 1], &Expected::new(&view)).expect("slopes");
        let (products, readings) = linear.reduced();
        assert_eq!(readings, ALL as f64);
        assert!((products[(0, 2)] - 5.0).abs() < 3.0 && (products[(0, 0)] - 1.0).abs() < 1e-9);
        assert_eq!(RUNS * READINGS, ALL);
    }
}
