//! Whether what a model leaves of the data is noise: its level, its smoothness, and what returns in
//! every run.

use rand_distr::{Bernoulli, Distribution};
use rand_pcg::Pcg64;

use crate::choose::percentile;
use crate::fit::{self, Fit};
use crate::kind::Kind;
use crate::noise::median;
use crate::parallel;
use crate::patterns::{self, Patterns};
use crate::tangent::Tangent;

/// Smooth shapes over a run that residuals are compared with.
const SHAPES: usize = 8;
/// Mean square of residuals beyond 1, or of their smooth part, below which nothing is said to be
/// wrong; or as far as the model is true.
const LEAST: f64 = 0.03;
/// The same of the level where the noise is estimated.
const LEAST_ESTIMATED: f64 = 0.5;
/// Mean of residuals over a part of a run, in standard deviations, below which nothing is said to
/// be wrong.
const LEAST_MEAN: f64 = 0.75;
/// By how much more residuals must stand out where the noise is estimated.
const DOUBT: f64 = 3.0;
/// Scatter in terms of the stated noise above which something is wrong however the instruments may
/// wander.
const GROSS: f64 = 5.0;
/// Correlation of residuals with the next from which on they follow each other.
const SMOOTH: f64 = 0.5;
/// Runs that it takes to tell what returns in each of them.
const RUNS: usize = 6;

/// Statistics of each channel.
type Measured = Vec<Vec<f64>>;

/// How well a model fits.
#[derive(Clone, Debug, PartialEq)]
pub struct Fitness {
    /// Mean square of the residuals of each channel, in its variance.
    pub level: Vec<f64>,
    /// Correlation of each residual with the next, of each channel.
    pub whiteness: Vec<f64>,
    /// Mean square of the part of the residuals of each channel that is smooth over a run, less
    /// what chance gives it.
    pub smooth: Vec<f64>,
    /// Sum of squares of the residuals beyond their number.
    pub squares: f64,
    /// How far the most telling of these is beyond chance: above 1 is less likely than the stated
    /// level.
    pub alarm: f64,
    /// Whether something is left that is not noise.
    pub is_off: bool,
    /// Whether so much is left that it is not the instruments, however they may wander.
    pub is_gross: bool,
    /// Whether the noise was given, or most runs leave what was estimated, so that this can be told
    /// for sure.
    pub is_sure: bool,
}

/// What is wrong, but not by which cause.
#[derive(Clone, Debug, PartialEq)]
pub struct Unknown {
    /// The channel that shows it most.
    pub channel: String,
    /// Where in a run its mean square is greatest: the phase, or a part of the time.
    pub phase: String,
    /// Root mean square there, in the channel's unit.
    pub rms: f64,
}

impl Fitness {
    /// What is wrong, if something is.
    pub(crate) fn unknown(&self, kind: &dyn Kind, model: &Fit) -> Option<Unknown> {
        if self.is_off {
            self.worst(kind, model)
        } else {
            None
        }
    }

    /// Where `model` is most off.
    pub(crate) fn worst(&self, kind: &dyn Kind, model: &Fit) -> Option<Unknown> {
        let worst = (0..self.level.len()).max_by(|a, b| {
            (self.level[*a] + self.smooth[*a]).total_cmp(&(self.level[*b] + self.smooth[*b]))
        })?;
        let mut parts: Vec<(String, f64, f64)> = Vec::new();
        for (run, log) in kind.logs().iter().enumerate() {
            let residuals = fit::residuals(kind, run, &model.terms, &model.unknowns[run])?;
            let phases = kind.phases(run, &model.terms, &model.unknowns[run]);
            let (first, last) = (log.readings.first()?.time, log.readings.last()?.time);
            for (reading, r) in log
                .readings
                .iter()
                .zip(residuals)
                .filter(|(x, _)| x.channel == worst)
            {
                let r = r / reading.weight.sqrt();
                let name = phases
                    .iter()
                    .rev()
                    .find(|(_, from)| *from <= reading.time)
                    .map_or_else(
                        || {
                            let third = 3.0 * (reading.time - first)
                                / (last - first).max(f64::MIN_POSITIVE);
                            let name = ["first third", "second third", "last third"];
                            name[usize::from(third >= 1.0) + usize::from(third >= 2.0)].to_owned()
                        },
                        |(name, _)| (*name).to_owned(),
                    );
                match parts.iter_mut().find(|p| p.0 == name) {
                    Some(part) => {
                        part.1 += r * r;
                        part.2 += 1.0;
                    }
                    None => parts.push((name, r * r, 1.0)),
                }
            }
        }
        let (phase, sum, n) = parts
            .into_iter()
            .max_by(|a, b| (a.1 / a.2).total_cmp(&(b.1 / b.2)))?;
        let channel = &kind.channels()[worst];
        Some(Unknown {
            channel: channel.name.clone(),
            phase,
            rms: (sum / n).sqrt() * channel.noise,
        })
    }
}

/// Legendre's polynomials 0 to `SHAPES` − 1 at x in [−1, 1].
fn legendre(x: f64) -> [f64; SHAPES] {
    let mut p = [1.0; SHAPES];
    p[1] = x;
    for k in 2..SHAPES {
        let n = k as f64;
        p[k] = ((2.0 * n - 1.0) * x * p[k - 1] - (n - 1.0) * p[k - 2]) / n;
    }
    p
}

/// Residuals of each run and channel as a series, with the place of each among all readings.
struct Series {
    channel: usize,
    run: usize,
    places: Vec<usize>,
    shapes: Vec<Vec<f64>>,
}

fn series(kind: &dyn Kind) -> Vec<Series> {
    let mut all = Vec::new();
    let mut start = 0;
    for (run, log) in kind.logs().iter().enumerate() {
        for channel in 0..kind.channels().len() {
            let places: Vec<usize> = (0..log.readings.len())
                .filter(|i| log.readings[*i].channel == channel)
                .map(|i| start + i)
                .collect();
            let n = places.len();
            if n == 0 {
                continue;
            }
            let mut shapes = vec![vec![0.0; n]; SHAPES.min(n / 2)];
            for i in 0..n {
                let at = legendre(2.0 * (i as f64 + 0.5) / n as f64 - 1.0);
                for (shape, value) in shapes.iter_mut().zip(at) {
                    shape[i] = value;
                }
            }
            for shape in &mut shapes {
                let size = fit::dot(shape, shape).sqrt();
                for x in shape {
                    *x /= size;
                }
            }
            all.push(Series {
                channel,
                run,
                places,
                shapes,
            });
        }
        start += log.readings.len();
    }
    all
}

/// What is compared with chance: level, smooth part, and the part that returns in every run, of
/// each channel in turn.
fn statistics(series: &[Series], channels: usize, residuals: &[f64]) -> [Vec<f64>; 3] {
    let (mut level, mut smooth) = (vec![0.0; channels], vec![0.0; channels]);
    let mut returning = vec![[0.0; SHAPES]; channels];
    for s in series {
        let values: Vec<f64> = s.places.iter().map(|&i| residuals[i]).collect();
        level[s.channel] += fit::dot(&values, &values);
        for (k, shape) in s.shapes.iter().enumerate() {
            let part = fit::dot(shape, &values);
            smooth[s.channel] += part * part;
            returning[s.channel][k] += part;
        }
    }
    [
        level,
        smooth,
        returning
            .iter()
            .map(|parts| parts.iter().map(|p| p * p).sum())
            .collect(),
    ]
}

/// How well `model` fits, with a stated `level` of saying that it does not when it does.
pub(crate) fn fitness(
    kind: &dyn Kind,
    model: &Fit,
    draws: usize,
    level: f64,
    random: &mut Pcg64,
) -> Fitness {
    let channels = kind.channels().len();
    let series = series(kind);
    let residuals = Tangent::residuals(kind, model).unwrap_or_default();
    let tangent = Tangent::new(kind, model, false);
    let mut counts = vec![0.0; channels];
    for reading in kind.logs().iter().flat_map(|log| &log.readings) {
        counts[reading.channel] += reading.weight;
    }
    let Some(tangent) = tangent.filter(|t| *t.bounds().last().unwrap_or(&0) == residuals.len())
    else {
        return Fitness {
            level: vec![f64::NAN; channels],
            whiteness: vec![f64::NAN; channels],
            smooth: vec![f64::NAN; channels],
            squares: f64::INFINITY,
            alarm: f64::INFINITY,
            is_off: true,
            is_gross: true,
            is_sure: false,
        };
    };
    let patterns = Patterns::new(kind, &tangent.predicted);
    let measure = |residuals: &[f64]| -> Measured {
        let [level, smooth, returning] = statistics(&series, channels, residuals);
        let found = patterns.find(residuals);
        let of = |c: usize| {
            let known = [level[c], smooth[c], returning[c]];
            known
                .into_iter()
                .chain(found[c].iter().map(|p| p.statistic))
                .collect::<Vec<_>>()
        };
        (0..channels).map(of).collect()
    };
    let found = measure(&residuals);
    let drawn: Vec<Vec<f64>> = (0..draws.max(100))
        .map(|_| tangent.chance(kind, random))
        .collect();
    let chance = parallel::map(drawn.len(), |k| measure(&drawn[k]));
    let is_given = kind.channels().iter().all(|c| c.is_given);
    let is_sure = (0..channels)
        .all(|c| kind.channels()[c].is_given || is_as_estimated(&series, c, &residuals));
    // Each statistic in terms of its own scatter by chance; the most telling of them.
    let scatter = |c: usize, k: usize| {
        let values: Vec<f64> = chance.iter().map(|x| x[c][k]).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let square = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64;
        (mean, square.sqrt().max(1e-9 * mean.abs()).max(1e-12))
    };
    let kinds = 3 + patterns::COUNT;
    let scatters: Vec<Vec<(f64, f64)>> = (0..channels)
        .map(|c| (0..kinds).map(|k| scatter(c, k)).collect())
        .collect();
    let beyond = |x: &Measured, c: usize, k: usize| (x[c][k] - scatters[c][k].0) / scatters[c][k].1;
    let all = || (0..channels).flat_map(|c| (0..kinds).map(move |k| (c, k)));
    let most = |x: &Measured| {
        all()
            .map(|(c, k)| beyond(x, c, k))
            .fold(f64::NEG_INFINITY, f64::max)
    };
    let mut by_chance: Vec<f64> = chance.iter().map(most).collect();
    by_chance.sort_by(f64::total_cmp);
    // Beyond the greatest of what was drawn by a little: the level is finer than the draws tell.
    let threshold = (percentile(&by_chance, 1.0 - level) * 1.25).max(1e-9);
    let alarm = most(&found) / threshold;
    let mean_square: Vec<f64> = (0..channels)
        .map(|c| found[c][0] / counts[c].max(1.0))
        .collect();
    let smooth: Vec<f64> = (0..channels)
        .map(|c| (found[c][1] - scatters[c][1].0).max(0.0) / counts[c].max(1.0))
        .collect();
    let sizes = patterns.find(&residuals);
    let least = LEAST.max(kind.trust().powi(2));
    let matters = |c: usize, k: usize| match k {
        0 => {
            let least = if kind.channels()[c].is_given {
                least
            } else {
                LEAST_ESTIMATED
            };
            (found[c][0] - scatters[c][0].0) / counts[c].max(1.0) > least
        }
        1 | 2 => smooth[c] > least,
        3 => sizes[c][0].size > LEAST_MEAN.max(4.0 * kind.trust()),
        _ => sizes[c][k - 3].size > least,
    };
    // What is estimated is not as sure: the noise of inputs adds up to something smooth.
    let doubt = if is_given { 1.0 } else { DOUBT };
    let is_wrong = all().any(|(c, k)| beyond(&found, c, k) > doubt * threshold && matters(c, k));
    let is_off = if is_sure && runs_of(&series) != 2 {
        is_wrong
    } else {
        returns(&series, channels, &residuals, level, random)
    };
    let whiteness = whiteness(&series, channels, &residuals);
    // One by one they may scatter as they like: jumps of a robot do.
    let is_gross = crate::fitness::scatter(kind, model)
        .iter()
        .zip(&whiteness)
        .any(|(s, w)| *s > GROSS && *w > SMOOTH);
    let raw = raw_residuals(kind, model);
    let squares = (fit::dot(&raw, &raw) - raw.len() as f64).max(0.0);
    Fitness {
        level: mean_square,
        whiteness,
        smooth,
        squares,
        alarm,
        is_off,
        is_gross,
        is_sure,
    }
}

/// Whether most runs leave of a channel about the noise that was estimated for it: what others
/// leave beyond that is then no instrument that wanders.
fn is_as_estimated(series: &[Series], channel: usize, residuals: &[f64]) -> bool {
    let square = |s: &Series| {
        let values = s.places.iter().map(|&i| residuals[i] * residuals[i]);
        values.sum::<f64>() / s.places.len().max(1) as f64
    };
    let mut squares: Vec<f64> = series
        .iter()
        .filter(|s| s.channel == channel)
        .map(square)
        .collect();
    squares.len() >= 3 && median(&mut squares) < 1.0 + LEAST_ESTIMATED
}

/// Correlation of each residual with the next, of each channel.
fn whiteness(series: &[Series], channels: usize, residuals: &[f64]) -> Vec<f64> {
    (0..channels)
        .map(|c| {
            let (mut above, mut below) = (0.0, 1e-300);
            for s in series.iter().filter(|s| s.channel == c) {
                for pair in s.places.windows(2) {
                    above += residuals[pair[0]] * residuals[pair[1]];
                }
                below += s
                    .places
                    .iter()
                    .map(|&i| residuals[i] * residuals[i])
                    .sum::<f64>();
            }
            above / below
        })
        .collect()
}

/// Whether the residuals of every channel scatter one by one, and do not follow each other.
pub(crate) fn is_white(kind: &dyn Kind, model: &Fit) -> bool {
    let residuals = Tangent::residuals(kind, model).unwrap_or_default();
    whiteness(&series(kind), kind.channels().len(), &residuals)
        .iter()
        .all(|w| w.abs() < SMOOTH)
}

/// Loss of a model beyond the number of readings, which is what noise would leave.
pub(crate) fn excess(kind: &dyn Kind, model: &Fit) -> f64 {
    let readings: f64 = kind
        .logs()
        .iter()
        .flat_map(|log| &log.readings)
        .map(|r| r.weight)
        .sum();
    (model.loss - readings).max(0.0)
}

/// What a model leaves of a channel.
pub(crate) struct Level {
    /// Readings as they count.
    pub(crate) count: f64,
    /// Mean square, in the channel's variance.
    pub(crate) square: f64,
    /// Whether the residuals scatter one by one.
    pub(crate) is_white: bool,
}

/// What `model` leaves of each channel; none where it says nothing of some run.
pub(crate) fn levels(kind: &dyn Kind, model: &Fit) -> Option<Vec<Level>> {
    let residuals = raw_residuals(kind, model);
    let readings: Vec<_> = kind.logs().iter().flat_map(|log| &log.readings).collect();
    if residuals.len() != readings.len() {
        return None;
    }
    let white = whiteness(&series(kind), kind.channels().len(), &residuals);
    let level = |(c, white): (usize, f64)| {
        let here = || {
            readings
                .iter()
                .zip(&residuals)
                .filter(|(reading, _)| reading.channel == c)
        };
        let count: f64 = here().map(|(reading, _)| reading.weight).sum();
        let sum: f64 = here().map(|(_, r)| r * r).sum();
        Level {
            count,
            square: sum / count.max(1.0),
            is_white: white < SMOOTH,
        }
    };
    Some(white.into_iter().enumerate().map(level).collect())
}

/// Scatter of the residuals of each channel in standard deviations, the outermost twentieth left
/// out.
pub(crate) fn scatter(kind: &dyn Kind, model: &Fit) -> Vec<f64> {
    let raw = raw_residuals(kind, model);
    let channel_of: Vec<usize> = kind
        .logs()
        .iter()
        .flat_map(|l| l.readings.iter().map(|r| r.channel))
        .collect();
    (0..kind.channels().len())
        .map(|c| {
            let mut sizes: Vec<f64> = raw
                .iter()
                .zip(&channel_of)
                .filter(|(_, k)| **k == c)
                .map(|(r, _)| r.abs())
                .collect();
            sizes.sort_by(f64::total_cmp);
            // Of a normal distribution 95 % are within 1.96.
            percentile(&sizes, 0.95) / 1.96
        })
        .collect()
}

/// Residuals of all readings in standard deviations.
fn raw_residuals(kind: &dyn Kind, model: &Fit) -> Vec<f64> {
    let of = |run: usize| {
        fit::residuals(kind, run, &model.terms, &model.unknowns[run]).unwrap_or_default()
    };
    (0..kind.logs().len()).flat_map(of).collect()
}

fn runs_of(series: &[Series]) -> usize {
    series.iter().map(|s| s.run + 1).max().unwrap_or(0)
}

/// Smooth parts of the residuals: for each run, channel and shape.
fn smooth_parts(series: &[Series], channels: usize, residuals: &[f64]) -> Vec<Vec<[f64; SHAPES]>> {
    let mut parts = vec![vec![[0.0; SHAPES]; channels]; runs_of(series)];
    for s in series {
        let values: Vec<f64> = s.places.iter().map(|&i| residuals[i]).collect();
        for (k, shape) in s.shapes.iter().enumerate() {
            parts[s.run][s.channel][k] = fit::dot(shape, &values);
        }
    }
    parts
}

/// Square of what returns in every run, with the sign of each run's as given.
fn returning(parts: &[Vec<[f64; SHAPES]>], signs: &[f64]) -> f64 {
    let channels = parts.first().map_or(0, Vec::len);
    (0..channels)
        .flat_map(|c| (0..SHAPES).map(move |k| (c, k)))
        .map(|(c, k)| {
            parts
                .iter()
                .zip(signs)
                .map(|(p, sign)| sign * p[c][k])
                .sum::<f64>()
                .powi(2)
        })
        .sum()
}

/// Whether the same smooth shape returns in the residuals of every run more than if the sign of
/// each run's were drawn: what can be told where the noise is not known.
fn returns(
    series: &[Series],
    channels: usize,
    residuals: &[f64],
    level: f64,
    random: &mut Pcg64,
) -> bool {
    let runs = runs_of(series);
    if runs < RUNS {
        return false;
    }
    let parts = smooth_parts(series, channels, residuals);
    let whole = fit::dot(residuals, residuals);
    let found = returning(&parts, &vec![1.0; runs]);
    let Ok(coin) = Bernoulli::new(0.5) else {
        return false;
    };
    let mut by_chance: Vec<f64> = (0..1000)
        .map(|_| {
            let signs: Vec<f64> = (0..runs)
                .map(|_| if coin.sample(random) { 1.0 } else { -1.0 })
                .collect();
            returning(&parts, &signs)
        })
        .collect();
    by_chance.sort_by(f64::total_cmp);
    // Of the residuals' square, the part that returns.
    found > percentile(&by_chance, 1.0 - level) && found / runs as f64 > 0.2 * whole
}

/// By how much more the residuals weigh than white noise of their standard deviation would: the
/// greatest over channels of variance times correlation time, at least 1.
pub(crate) fn inflation(kind: &dyn Kind, model: &Fit) -> f64 {
    // Outliers are cut; what is off by less than that everywhere is not made of outliers.
    let raw = raw_residuals(kind, model);
    let mut sizes: Vec<f64> = raw.iter().map(|r| r.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let cut = (2.0 * percentile(&sizes, 0.95)).max(3.0);
    let residuals: Vec<f64> = raw.iter().map(|r| r.clamp(-cut, cut)).collect();
    let all = series(kind);
    (0..kind.channels().len())
        .map(|channel| {
            let runs: Vec<Vec<f64>> = all
                .iter()
                .filter(|s| s.channel == channel)
                .map(|s| s.places.iter().map(|&i| residuals[i]).collect())
                .collect();
            let n: usize = runs.iter().map(Vec::len).sum();
            if n < 8 {
                return 1.0;
            }
            let covariance = |lag: usize| -> f64 {
                let pairs = runs.iter().flat_map(|s| s.iter().zip(s.iter().skip(lag)));
                pairs.map(|(a, b)| a * b).sum::<f64>() / n as f64
            };
            let variance = covariance(0);
            let mut time = 1.0;
            let longest = runs.iter().map(Vec::len).max().unwrap_or(0) / 3;
            for lag in 1..longest {
                let part = covariance(lag) / variance.max(1e-300);
                // Below what chance gives the tail says nothing.
                if part < 3.0 / (n as f64).sqrt() {
                    break;
                }
                time += 2.0 * part;
            }
            variance.max(1.0) * time
        })
        .fold(1.0, f64::max)
}
