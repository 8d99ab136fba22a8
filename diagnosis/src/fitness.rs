//! Whether what a model leaves of the data is noise: its level, its smoothness, patterns in it, and
//! what repeats in every run.

use rand_distr::{Bernoulli, Distribution};
use rand_pcg::Pcg64;
use saltus_numeric::parallel;
use saltus_numeric::statistics::{dot, mean, median, percentile};

use crate::fit::{self, Fit};
use crate::kind::Kind;
use crate::patterns::{self, Patterns};
use crate::policy::POLICY;
use crate::series::{self, SHAPES, Series, lag_correlation, runs_of, series};
use crate::tangent::Tangent;

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
    /// The most telling statistic in terms of its threshold: noise exceeds 1 as rarely as stated.
    pub alarm: f64,
    /// Whether what is left of each channel is noise.
    pub is_noise: Vec<bool>,
    /// Whether so much is left, and so smooth, that it is not the instruments, however they drift.
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
    /// Of a model that has no answer.
    fn none(channels: usize) -> Fitness {
        Fitness {
            level: vec![f64::NAN; channels],
            whiteness: vec![f64::NAN; channels],
            smooth: vec![f64::NAN; channels],
            squares: f64::INFINITY,
            alarm: f64::INFINITY,
            is_noise: vec![false; channels],
            is_gross: true,
            is_sure: false,
        }
    }

    /// What is wrong, if something is.
    pub(crate) fn unknown(&self, kind: &dyn Kind, model: &Fit) -> Option<Unknown> {
        if self.is_noise.iter().all(|is_noise| *is_noise) {
            None
        } else {
            self.worst(kind, model)
        }
    }

    /// Where `model` is most off.
    pub(crate) fn worst(&self, kind: &dyn Kind, model: &Fit) -> Option<Unknown> {
        let misfit = |c: &usize| self.level[*c] + self.smooth[*c];
        let worst = (0..self.level.len()).max_by(|a, b| misfit(a).total_cmp(&misfit(b)))?;
        let mut parts: Vec<Part> = Vec::new();
        for run in 0..kind.logs().len() {
            add_parts(&mut parts, kind, model, run, worst)?;
        }
        let mean = |part: &Part| part.squares / part.count;
        let part = parts
            .into_iter()
            .max_by(|a, b| mean(a).total_cmp(&mean(b)))?;
        let channel = &kind.channels()[worst];
        Some(Unknown {
            channel: channel.name.clone(),
            rms: mean(&part).sqrt() * channel.noise,
            phase: part.name,
        })
    }
}

/// Residuals of a channel in a phase of all runs.
struct Part {
    name: String,
    /// Sum of their squares (σ²).
    squares: f64,
    count: f64,
}

/// Adds the residuals of a channel in a run to the parts of their phases.
fn add_parts(
    parts: &mut Vec<Part>,
    kind: &dyn Kind,
    model: &Fit,
    run: usize,
    channel: usize,
) -> Option<()> {
    let (unknowns, readings) = (&model.unknowns[run], &kind.logs()[run].readings);
    let residuals = fit::residuals(kind, run, &model.terms, unknowns)?;
    let phases = kind.phases(run, &model.terms, unknowns);
    let (first, last) = (readings.first()?.time, readings.last()?.time);
    let third = |time: f64| {
        let third = 3.0 * (time - first) / (last - first).max(f64::MIN_POSITIVE);
        ["first third", "second third", "last third"]
            [usize::from(third >= 1.0) + usize::from(third >= 2.0)]
    };
    for (reading, r) in readings.iter().zip(residuals) {
        if reading.channel != channel {
            continue;
        }
        let mut begun = phases.iter().rev().filter(|(_, at)| *at <= reading.time);
        let name = begun.next().map_or_else(|| third(reading.time), |p| p.0);
        let square = (r / reading.weight.sqrt()).powi(2);
        match parts.iter_mut().find(|p| p.name == name) {
            Some(part) => (part.squares, part.count) = (part.squares + square, part.count + 1.0),
            None => parts.push(Part {
                name: name.to_owned(),
                squares: square,
                count: 1.0,
            }),
        }
    }
    Some(())
}

/// Statistics of residuals, of each channel: level, smooth part, the part that repeats in every
/// run, and patterns.
type Measured = Vec<Vec<f64>>;

/// Level and smooth part among the statistics; the patterns come last.
const LEVEL: usize = 0;
const SMOOTH: usize = 1;
const REPEATS: usize = 2;
const PART: usize = REPEATS + 1;
/// Statistics of a channel.
const STATISTICS: usize = PART + patterns::COUNT;

/// What is measured of residuals.
struct Measure {
    series: Vec<Series>,
    patterns: Patterns,
    /// Readings of each channel, as they count.
    counts: Vec<f64>,
}

impl Measure {
    fn new(kind: &dyn Kind, predicted: &[f64]) -> Measure {
        let mut counts = vec![0.0; kind.channels().len()];
        for reading in kind.logs().iter().flat_map(|log| &log.readings) {
            counts[reading.channel] += reading.weight;
        }
        Measure {
            series: series(kind),
            patterns: Patterns::new(kind, predicted),
            counts,
        }
    }

    fn channels(&self) -> usize {
        self.counts.len()
    }

    fn of(&self, residuals: &[f64]) -> Measured {
        let mut all = vec![vec![0.0; PART]; self.channels()];
        let mut repeats = vec![[0.0; SHAPES]; self.channels()];
        for s in &self.series {
            let values = s.of(residuals);
            all[s.channel][LEVEL] += dot(&values, &values);
            let parts = s.smooth_parts(residuals);
            for (part, sum) in parts.iter().zip(&mut repeats[s.channel]) {
                all[s.channel][SMOOTH] += part * part;
                *sum += part;
            }
        }
        let patterns = self.patterns.find(residuals);
        for ((all, repeats), patterns) in all.iter_mut().zip(&repeats).zip(patterns) {
            all[REPEATS] = repeats.iter().map(|p| p * p).sum();
            all.extend(patterns.iter().map(|p| p.statistic));
        }
        all
    }

    /// The smooth part of each channel beyond that of chance, for one of its readings.
    fn smooth(&self, found: &Measured, chance: &Chance) -> Vec<f64> {
        let beyond = |c: usize| (found[c][SMOOTH] - chance.moments[c][SMOOTH].0).max(0.0);
        (0..self.channels())
            .map(|c| self.for_each(c, beyond(c)))
            .collect()
    }

    /// A sum over a channel for one of its readings.
    fn for_each(&self, channel: usize, sum: f64) -> f64 {
        sum / self.counts[channel].max(1.0)
    }
}

/// What chance does to the statistics.
struct Chance {
    /// Mean and standard deviation of each statistic of each channel.
    moments: Vec<Vec<(f64, f64)>>,
    /// What the most telling of all reaches in noise as rarely as stated.
    threshold: f64,
}

impl Chance {
    /// From what was measured of residuals drawn by chance.
    fn new(drawn: &[Measured], channels: usize, level: f64) -> Chance {
        let moments = |c: usize, k: usize| {
            let n = drawn.len() as f64;
            let values: Vec<f64> = drawn.iter().map(|x| x[c][k]).collect();
            let mean = mean(&values);
            let square = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n;
            (mean, square.sqrt().max(1e-9 * mean.abs()).max(1e-12))
        };
        let mut chance = Chance {
            moments: (0..channels)
                .map(|c| (0..STATISTICS).map(|k| moments(c, k)).collect())
                .collect(),
            threshold: f64::NAN,
        };
        let mut most: Vec<f64> = drawn.iter().map(|x| chance.most(x)).collect();
        most.sort_by(f64::total_cmp);
        // The level is finer than the draws.
        chance.threshold = (percentile(&most, 1.0 - level) * POLICY.beyond_draws).max(1e-9);
        chance
    }

    /// A statistic in standard deviations of its own.
    fn beyond(&self, x: &Measured, c: usize, k: usize) -> f64 {
        let (mean, deviation) = self.moments[c][k];
        (x[c][k] - mean) / deviation
    }

    /// The most telling of all.
    fn most(&self, x: &Measured) -> f64 {
        let all = (0..x.len()).flat_map(|c| (0..STATISTICS).map(move |k| (c, k)));
        all.map(|(c, k)| self.beyond(x, c, k))
            .fold(f64::NEG_INFINITY, f64::max)
    }
}

/// How well `model` fits; `level` is the part of cases in which noise is said not to be noise.
pub(crate) fn fitness(
    kind: &dyn Kind,
    model: &Fit,
    draws: usize,
    level: f64,
    random: &mut Pcg64,
) -> Fitness {
    let residuals = Tangent::residuals(kind, model).unwrap_or_default();
    let channels = kind.channels().len();
    let Some(tangent) = Tangent::new(kind, model, false)
        .filter(|t| *t.bounds().last().unwrap_or(&0) == residuals.len())
    else {
        return Fitness::none(channels);
    };
    let measure = Measure::new(kind, &tangent.predicted);
    let drawn: Vec<Vec<f64>> = (0..draws.max(POLICY.least_draws))
        .map(|_| tangent.drawn(kind, random))
        .collect();
    let drawn = parallel::map(drawn.len(), |k| measure.of(&drawn[k]));
    let chance = Chance::new(&drawn, channels, level);
    let found = measure.of(&residuals);
    let smooth = measure.smooth(&found, &chance);
    let is_sure = (0..channels)
        .all(|c| kind.channels()[c].is_given || is_as_estimated(&measure.series, c, &residuals));
    let is_noise = if is_sure && runs_of(&measure.series) != 2 {
        let sizes = measure.patterns.find(&residuals);
        let test = NoiseTest {
            kind,
            measure: &measure,
            chance: &chance,
            found: &found,
            smooth: &smooth,
            sizes: &sizes,
        };
        (0..channels).map(|c| test.is_noise(c)).collect()
    } else {
        vec![!repeats(&measure.series, channels, &residuals, level, random); channels]
    };
    let whiteness = lag_correlation(&measure.series, channels, &residuals);
    // Independent residuals may scatter as they like: jumps of a robot do.
    let is_gross = scatter(kind, model)
        .iter()
        .zip(&whiteness)
        .any(|(s, w)| *s > POLICY.gross && *w > POLICY.smooth);
    let raw = raw_residuals(kind, model);
    Fitness {
        level: (0..channels)
            .map(|c| measure.for_each(c, found[c][LEVEL]))
            .collect(),
        whiteness,
        smooth,
        squares: (dot(&raw, &raw) - raw.len() as f64).max(0.0),
        alarm: chance.most(&found) / chance.threshold,
        is_noise,
        is_gross,
        is_sure,
    }
}

/// The test whether residuals are noise.
struct NoiseTest<'a> {
    kind: &'a dyn Kind,
    measure: &'a Measure,
    chance: &'a Chance,
    found: &'a Measured,
    smooth: &'a [f64],
    sizes: &'a [[patterns::Pattern; patterns::COUNT]],
}

impl NoiseTest<'_> {
    /// Whether no statistic of channel `c` is beyond chance and large enough to matter.
    fn is_noise(&self, c: usize) -> bool {
        // Estimated noise is not as sure: that of inputs adds up to something smooth.
        let is_given = self.kind.channels().iter().all(|c| c.is_given);
        let factor = if is_given {
            1.0
        } else {
            POLICY.estimated_noise_factor
        };
        let threshold = factor * self.chance.threshold;
        !(0..STATISTICS)
            .any(|k| self.chance.beyond(self.found, c, k) > threshold && self.matters(c, k))
    }

    /// Whether statistic `k` of channel `c` is large enough to matter, and not the error of the
    /// model.
    fn matters(&self, c: usize, k: usize) -> bool {
        let trust = self.kind.trust();
        let least = POLICY.least_misfit.max(trust.powi(2));
        let pattern = |k: usize| self.sizes[c][k - PART].size;
        match k {
            LEVEL => {
                let beyond = self.found[c][LEVEL] - self.chance.moments[c][LEVEL].0;
                let least = if self.kind.channels()[c].is_given {
                    least
                } else {
                    POLICY.least_misfit_estimated
                };
                self.measure.for_each(c, beyond) > least
            }
            SMOOTH | REPEATS => self.smooth[c] > least,
            PART => {
                let of_model = POLICY.least_mean_of_model_error * trust;
                pattern(k) > POLICY.least_mean.max(of_model)
            }
            _ => pattern(k) > least,
        }
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
    squares.len() >= 3 && median(&mut squares) < 1.0 + POLICY.least_misfit_estimated
}

/// Whether the residuals of every channel are independent of each other.
pub(crate) fn is_white(kind: &dyn Kind, model: &Fit) -> bool {
    let residuals = Tangent::residuals(kind, model).unwrap_or_default();
    lag_correlation(&series(kind), kind.channels().len(), &residuals)
        .iter()
        .all(|correlation| correlation.abs() < POLICY.smooth)
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
    let white = lag_correlation(&series(kind), kind.channels().len(), &residuals);
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
            is_white: white < POLICY.smooth,
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

/// Whether the same smooth shape repeats in the residuals of every run more than if the sign of each
/// run's were drawn: what can be told where the noise is not known.
fn repeats(
    series: &[Series],
    channels: usize,
    residuals: &[f64],
    level: f64,
    random: &mut Pcg64,
) -> bool {
    /// Draws of signs.
    const DRAWS: usize = 1000;
    let runs = runs_of(series);
    if runs < POLICY.repeating_runs {
        return false;
    }
    let mut parts = vec![vec![[0.0; SHAPES]; channels]; runs];
    for s in series {
        parts[s.run][s.channel] = s.smooth_parts(residuals);
    }
    let found = repeating(&parts, &vec![1.0; runs]);
    let Ok(coin) = Bernoulli::new(0.5) else {
        return false;
    };
    let mut by_chance: Vec<f64> = (0..DRAWS)
        .map(|_| {
            let signs: Vec<f64> = (0..runs)
                .map(|_| if coin.sample(random) { 1.0 } else { -1.0 })
                .collect();
            repeating(&parts, &signs)
        })
        .collect();
    by_chance.sort_by(f64::total_cmp);
    found > percentile(&by_chance, 1.0 - level)
        && found / runs as f64 > POLICY.repeating_part * dot(residuals, residuals)
}

/// Square of what repeats in every run, with the sign of each run's parts as given.
fn repeating(parts: &[Vec<[f64; SHAPES]>], signs: &[f64]) -> f64 {
    let channels = parts.first().map_or(0, Vec::len);
    let all = (0..channels).flat_map(|c| (0..SHAPES).map(move |k| (c, k)));
    all.map(|(c, k)| {
        let sum = parts.iter().zip(signs).map(|(p, sign)| sign * p[c][k]);
        sum.sum::<f64>().powi(2)
    })
    .sum()
}

/// Variance inflation of what `model` leaves: the greatest over channels.
pub(crate) fn inflation(kind: &dyn Kind, model: &Fit) -> f64 {
    inflations(kind, model).into_iter().fold(1.0, f64::max)
}

/// Variance inflation of what `model` leaves of each channel: variance times correlation time, at
/// least 1.
pub(crate) fn inflations(kind: &dyn Kind, model: &Fit) -> Vec<f64> {
    // Outliers are cut; what is off by less than that everywhere is not made of outliers.
    let raw = raw_residuals(kind, model);
    let mut sizes: Vec<f64> = raw.iter().map(|r| r.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let cut = (2.0 * percentile(&sizes, 0.95)).max(3.0);
    let residuals: Vec<f64> = raw.iter().map(|r| r.clamp(-cut, cut)).collect();
    let all = series(kind);
    let of = |channel: usize| {
        let these = all.iter().filter(|s| s.channel == channel);
        series::inflation(&these.map(|s| s.of(&residuals)).collect::<Vec<_>>())
    };
    (0..kind.channels().len()).map(|c| of(c).max(1.0)).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::toy::{ALL, READINGS, Toy, noise, sum, wave};

    const RARE: f64 = 0.01;

    fn tested(values: &[f64]) -> Fitness {
        let toy = Toy::new(values, vec![wave(0)]);
        fitness(&toy, &toy.before(), 400, RARE, &mut Pcg64::new(1, 1))
    }

    /// The same wave of amplitude `a` in every run.
    fn swinging(a: f64) -> Vec<f64> {
        let at = |i: usize| a * (TAU * 3.0 * (i % READINGS) as f64 / READINGS as f64).sin();
        (0..ALL).map(at).collect()
    }

    #[test]
    fn noise_is_noise_as_often_as_stated() {
        let wrong = (0..100).filter(|seed| !tested(&noise(*seed)).is_noise[0]);
        // Of 100 at 1 %, more than 4 come once in 270 times.
        assert!(wrong.count() <= 4);
    }

    #[test]
    fn what_swings_in_every_run_is_no_noise() {
        let found = tested(&sum(&[(1.0, &swinging(0.6)), (1.0, &noise(3))]));
        assert!(!found.is_noise[0] && found.alarm > 1.0, "{found:?}");
        // A mean square of a²/2.
        assert!((found.smooth[0] - 0.18).abs() < 0.1, "{found:?}");
        assert!(!found.is_gross);
    }

    #[test]
    fn what_is_far_larger_than_the_noise_is_gross() {
        let found = tested(&sum(&[(1.0, &swinging(60.0)), (1.0, &noise(3))]));
        assert!(found.is_gross && !found.is_noise[0], "{found:?}");
        // Noise of that size is not: it scatters one by one.
        let found = tested(&sum(&[(60.0, &noise(3))]));
        assert!(!found.is_gross, "{found:?}");
    }

    #[test]
    fn squares_and_excess_are_what_is_beyond_the_number_of_readings() {
        let values = sum(&[(1.0, &swinging(2.0)), (0.2, &noise(3))]);
        let beyond = dot(&values, &values) - ALL as f64;
        assert!((tested(&values).squares - beyond).abs() < 1e-9 * beyond);
        let toy = Toy::new(&values, vec![wave(0)]);
        // No residual is beyond Huber's bound.
        assert!((excess(&toy, &toy.before()) - beyond).abs() < 1e-6 * beyond);
    }

    #[test]
    fn noise_that_drags_on_is_inflated_by_its_correlation() {
        let (rho, mut x) = (0.7, 0.0);
        // Each run begins anew, as residuals of runs are not related.
        let drag = |(i, e): (usize, f64)| {
            x = if i % READINGS == 0 {
                e
            } else {
                rho * x + f64::sqrt(1.0 - rho * rho) * e
            };
            x
        };
        let values: Vec<f64> = noise(4).into_iter().enumerate().map(drag).collect();
        let toy = Toy::new(&values, vec![wave(0)]);
        let closed = (1.0 + rho) / (1.0 - rho);
        let found = inflation(&toy, &toy.before());
        assert!(
            (0.5 * closed..1.8 * closed).contains(&found),
            "{found} {closed}"
        );
        assert!(!is_white(&toy, &toy.before()));
        let white = Toy::new(&noise(4), vec![wave(0)]);
        assert!(is_white(&white, &white.before()));
        assert!(inflation(&white, &white.before()) < 1.5);
    }

    #[test]
    fn levels_tell_how_large_the_noise_is() {
        let toy = Toy::new(&sum(&[(3.0, &noise(2))]), vec![wave(0)]);
        let level = &levels(&toy, &toy.before()).expect("an answer")[0];
        assert_eq!(level.count, ALL as f64);
        assert!(
            (level.square / 9.0 - 1.0).abs() < 0.2 && level.is_white,
            "{}",
            level.square
        );
        let scatter = scatter(&toy, &toy.before())[0];
        assert!((2.0..3.2).contains(&scatter), "{scatter}");
    }
}
