//! What an experiment can tell, before it is done: how often a diagnosis would name an effect of a
//! given size, and what it would take it for.
//!
//! What an effect does to the readings is computed by the full model, and so is the best fit of each
//! cause that the model linearised without an effect says to come near. Of each of these fits, what
//! noise does to it follows from the model linearised there. Each draw of noise is weighed as a
//! diagnosis weighs sets of causes.

use std::collections::BTreeMap;

use nalgebra::DMatrix;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use saltus_numeric::parallel;
use saltus_numeric::statistics::dot;

use crate::diagnose::MOST_RIVALS;
use crate::discrepancy::Discrepancy;
use crate::fit::{self, Fit};
use crate::kind::{Cause, Channel, Kind, Parameter, Terms};
use crate::likelihood::{Expected, Linear};
use crate::next::APART;
use crate::policy::POLICY;
use crate::search::{Set, promise};
use crate::settings::Settings;
use crate::tangent::Tangent;
use crate::view::View;

/// Least and greatest change of a parameter that is tried, in its scales, within its bounds; and how
/// often the step between two that are a factor of four apart is halved on a logarithmic scale.
const LEAST: f64 = 1e-4;
const GREATEST: f64 = 1e4;
const HALVINGS: usize = 8;
/// Causes that are fitted to an effect beside itself, and the logarithm of the odds beyond which none is.
const RIVALS: usize = 4;
const HOPELESS: f64 = 20.0;

/// What an experiment can tell of one effect.
#[derive(Clone, Debug, PartialEq)]
pub struct Power {
    /// Id of the cause.
    pub id: &'static str,
    /// The measured column that it is about, if it is about one.
    pub column: Option<String>,
    /// Its parameters as they are reported: names and values.
    pub values: Vec<(String, f64)>,
    /// By how many standard deviations of noise and of the model's own error all readings together
    /// show it.
    pub visible: f64,
    /// Share of experiments in which it is named, alone or with rivals.
    pub named: f64,
    /// Share in which it is named alone.
    pub alone: f64,
    /// Share in which nothing is named.
    pub nothing: f64,
    /// Ids that are named with it or in its place, each with its share; the most frequent first.
    pub others: Vec<(&'static str, f64)>,
}

/// What the experiment of `kind`, whose measured values do not count, can tell of each effect: a
/// cause and the values of its parameters. `progress` is told what is being done. Left out are
/// effects with which the model has no answer.
pub fn power(
    kind: &dyn Kind,
    effects: &[(usize, Vec<f64>)],
    settings: &Settings,
    progress: &(dyn Fn(&str) + Sync),
) -> Vec<Power> {
    let Some(outlook) = Outlook::new(kind, settings) else {
        return Vec::new();
    };
    let found = parallel::map(effects.len(), |k| {
        let (cause, values) = &effects[k];
        progress(kind.causes()[*cause].id);
        outlook.of_effect(*cause, values)
    });
    found.into_iter().flatten().collect()
}

/// By how many standard deviations of noise and of the model's own error readings show a change.
fn seen(discrepancy: &Discrepancy, change: &[f64]) -> f64 {
    (dot(change, change) / discrepancy.inflation(change)).sqrt()
}

/// The terms with one cause on.
fn on(kind: &dyn Kind, cause: usize, values: &[f64]) -> Terms {
    let mut terms = Terms::off(kind.causes());
    for (p, value) in values.iter().enumerate() {
        terms.set(cause, p, *value);
    }
    terms
}

/// Error (σ) of a quantised reading of `value` (σ) with white noise `z`.
fn quantised(channel: &Channel, value: f64, z: f64) -> f64 {
    let step = channel.step / channel.noise;
    let white = (1.0 - step * step / 12.0).max(0.0).sqrt();
    ((value + white * z) / step).round() * step - value
}

/// An experiment without an effect, and what noise does in it.
struct Outlook<'a> {
    kind: &'a dyn Kind,
    settings: &'a Settings,
    discrepancy: Discrepancy,
    tangent: Tangent,
    expected: Expected,
    before: Fit,
    linear: Linear,
    /// What that leaves of the first draw (σ), of each run.
    left: Vec<Vec<f64>>,
    /// Draws of the noise (σ), of each run.
    draws: Vec<Vec<Vec<f64>>>,
}

impl<'a> Outlook<'a> {
    fn new(kind: &'a dyn Kind, settings: &'a Settings) -> Option<Outlook<'a>> {
        let view = View::exact(kind, settings, &Terms::off(kind.causes()))?;
        let discrepancy = Discrepancy::new(&view);
        let mut random = Pcg64::new(u128::from(settings.seed), 13);
        let draws = (0..settings.draws.max(1)).map(|_| drawn(&view, &discrepancy, &mut random));
        let draws: Vec<Vec<Vec<f64>>> = draws.collect();
        let runs: Vec<usize> = (0..view.logs().len()).collect();
        let exact = fit::fit_none(&view, &runs)?;
        let noisy = view.with_noise(&draws[0]);
        let before = fit::refit(&noisy, exact.clone(), &runs, &None, fit::STEPS)?;
        let all: Vec<usize> = (kind.common()..kind.causes().len()).collect();
        let expected = Expected::new(&noisy);
        Some(Outlook {
            tangent: Tangent::new(&view, &exact)?,
            linear: Linear::new(&noisy, &before, &all, &expected)?,
            left: left(&noisy, &before)?,
            before,
            expected,
            kind,
            settings,
            discrepancy,
            draws,
        })
    }

    fn of_effect(&self, cause: usize, values: &[f64]) -> Option<Power> {
        let spec = &self.kind.causes()[cause];
        let terms = on(self.kind, cause, values);
        let visible = seen(&self.discrepancy, &self.tangent.change(self.kind, &terms)?);
        let answers = self.answers(cause, values, &terms)?;
        let share = |is: &dyn Fn(&Vec<&'static str>) -> bool| {
            answers.iter().filter(|a| is(a)).count() as f64 / answers.len() as f64
        };
        let id = spec.id;
        let mut others: Vec<&'static str> = answers.iter().flatten().copied().collect();
        others.sort_unstable();
        others.dedup();
        others.retain(|other| *other != id);
        let mut others: Vec<(&'static str, f64)> = others
            .into_iter()
            .map(|other| (other, share(&|a| a.contains(&other))))
            .collect();
        others.sort_by(|a, b| b.1.total_cmp(&a.1));
        Some(Power {
            id,
            column: spec.column.clone(),
            values: spec.report(values),
            visible,
            named: share(&|a| a.contains(&id)),
            alone: share(&|a| a[..] == [id]),
            nothing: share(&|a| a.is_empty()),
            others,
        })
    }

    /// What would be named in each draw of an experiment with `values` of `cause`.
    fn answers(
        &self,
        cause: usize,
        values: &[f64],
        terms: &Terms,
    ) -> Option<Vec<Vec<&'static str>>> {
        let view = View::exact(self.kind, self.settings, terms)?.with_noise(&self.draws[0]);
        let runs: Vec<usize> = (0..view.logs().len()).collect();
        let change: Vec<Vec<f64>> = left(&view, &self.before)?
            .iter()
            .zip(&self.left)
            .map(|(now, then)| now.iter().zip(then).map(|(a, b)| a - b).collect())
            .collect();
        let linear = self.linear.shifted(&change, &view);
        let others: Vec<usize> = (view.common()..view.causes().len())
            .filter(|c| *c != cause)
            .collect();
        let guesses = others.iter().map(|other| {
            let (log, fit) = promise(&view, &self.expected, &linear, &self.before, *other);
            (log, fit)
        });
        let mut guesses: Vec<(f64, Option<Fit>)> = guesses.collect();
        guesses.sort_by(|a, b| b.0.total_cmp(&a.0));
        let itself = fit::begun(&self.before, cause, values);
        let begun = guesses
            .into_iter()
            .take(RIVALS)
            .filter_map(|(_, fit)| fit)
            .chain([itself, self.before.clone()]);
        let begun: Vec<Fit> = begun.collect();
        let weighed = |from: &Fit| {
            let slopes = self.linear.slopes(&view, &self.before, &from.causes);
            let (fit, slopes) =
                fit::refit_near(&view, from.clone(), slopes, &runs, fit::ROUGH_STEPS)?;
            let linear = Linear::with(&view, &fit, slopes, &self.expected)?;
            let set = Set::weighed(&view, &self.expected, fit, &linear)?;
            Some((set, linear))
        };
        let mut all: Vec<(Set, Linear)> = begun.iter().filter_map(weighed).collect();
        let best = all
            .iter()
            .map(|(set, _)| set.best())
            .fold(f64::NEG_INFINITY, f64::max);
        all.retain(|(set, _)| set.fit.causes.is_empty() || set.best() > best - HOPELESS);
        let answer = |draw: &Vec<Vec<f64>>| {
            let by: Vec<Vec<f64>> = draw
                .iter()
                .zip(&self.draws[0])
                .map(|(now, then)| now.iter().zip(then).map(|(a, b)| a - b).collect())
                .collect();
            let logs = all.iter().filter_map(|(set, linear)| {
                let linear = linear.shifted(&by, &view);
                let set = Set::weighed(&view, &self.expected, set.fit.clone(), &linear)?;
                Some((set.fit.causes.first().copied(), set.best()))
            });
            self.named(logs.collect())
        };
        Some(self.draws.iter().map(answer).collect())
    }

    /// Ids that would be named: the most probable cause first, then its rivals.
    fn named(&self, mut logs: Vec<(Option<usize>, f64)>) -> Vec<&'static str> {
        logs.sort_by(|a, b| b.1.total_cmp(&a.1));
        let none = logs.iter().find(|(cause, _)| cause.is_none());
        let none = none.map_or(f64::NEG_INFINITY, |(_, log)| *log);
        let mut ids = Vec::new();
        for (cause, log) in &logs {
            let Some(cause) = cause else { continue };
            let is_claimed = logs[0].1 > none + POLICY.strong.ln();
            let is_near = *log > logs[0].1 - POLICY.strong.ln();
            let id = if *cause < self.kind.listed() {
                self.kind.causes()[*cause].id
            } else {
                "unknown"
            };
            if is_claimed && is_near && !ids.contains(&id) && ids.len() <= MOST_RIVALS {
                ids.push(id);
            }
        }
        ids
    }
}

/// What `fit` leaves of each run (σ).
fn left(kind: &dyn Kind, fit: &Fit) -> Option<Vec<Vec<f64>>> {
    let of = |run: usize| fit::residuals(kind, run, &fit.terms, &fit.unknowns[run]);
    (0..kind.logs().len()).map(of).collect()
}

/// Noise (σ) of every reading of each run: that of the instruments, of measured inputs, and the model's
/// own error.
fn drawn(kind: &dyn Kind, discrepancy: &Discrepancy, random: &mut Pcg64) -> Vec<Vec<f64>> {
    let mut all: Vec<Vec<f64>> = Vec::new();
    for (run, log) in kind.logs().iter().enumerate() {
        let by_inputs = kind.input_noise(run, &mut || StandardNormal.sample(random));
        let mut values = Vec::with_capacity(log.readings.len());
        for (i, reading) in log.readings.iter().enumerate() {
            let channel = &kind.channels()[reading.channel];
            let z: f64 = StandardNormal.sample(random);
            let size = fit::scatter(kind, reading);
            let noise = if channel.step > 0.0 {
                quantised(channel, reading.value / channel.noise, z) * channel.noise
            } else {
                z * channel.noise
            };
            let by_input = by_inputs.as_ref().map_or(0.0, |moved| moved[i]);
            values.push((noise + by_input) / size);
        }
        all.push(values);
    }
    let mut flat = all.concat();
    discrepancy.add(&mut flat, random);
    let mut rest = &flat[..];
    for values in &mut all {
        let (here, after) = rest.split_at(values.len());
        values.copy_from_slice(here);
        rest = after;
    }
    all
}

/// How much readings show each of several effects: products of what they do, in squares of standard
/// deviations of the noise, clear of what is not known of each run.
#[derive(Clone, Debug)]
pub struct Shown(DMatrix<f64>);

/// What the readings of `kind` show of each effect; none where the model has no answer.
pub fn shown(kind: &dyn Kind, effects: &[(usize, Vec<f64>)], settings: &Settings) -> Option<Shown> {
    let view = View::exact(kind, settings, &Terms::off(kind.causes()))?;
    let runs: Vec<usize> = (0..view.logs().len()).collect();
    let before = fit::fit_none(&view, &runs)?;
    let tangent = Tangent::new(&view, &before)?;
    let change = |(cause, values): &(usize, Vec<f64>)| {
        let terms = on(kind, *cause, values);
        // What does not jump with an effect shows nothing that can be counted on.
        let change = tangent.change(&view, &terms);
        change.unwrap_or_else(|| vec![0.0; tangent.predicted.len()])
    };
    let all: Vec<Vec<f64>> = effects.iter().map(change).collect();
    let n = all.len();
    Some(Shown(DMatrix::from_fn(n, n, |i, j| dot(&all[i], &all[j]))))
}

impl Shown {
    /// What several experiments show together.
    pub fn sum<'a>(all: impl Iterator<Item = &'a Shown>) -> Shown {
        all.fold(Shown(DMatrix::zeros(0, 0)), |sum, one| sum.with(one))
    }

    /// What this and another experiment show together.
    #[must_use]
    pub fn with(&self, other: &Shown) -> Shown {
        if self.0.is_empty() {
            return other.clone();
        }
        Shown(&self.0 + &other.0)
    }

    /// How well the first `asked` of effects of these sources (number and id of the cause) are told from the others,
    /// from 0 to 1: the mean over them of the distance between what one does and the nearest sum of multiples of what
    /// another source does, where so many standard deviations as tell two predictions apart are enough.
    pub fn apart(&self, sources: &[(usize, &str)], asked: usize) -> f64 {
        let mut groups: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (k, (number, _)) in sources.iter().enumerate() {
            groups.entry(*number).or_default().push(k);
        }
        let of = |i: usize| {
            let others = groups
                .values()
                .filter(|all| sources[all[0]].1 != sources[i].1);
            let left = others.map(|all| self.beyond(i, all));
            let nearest = left.fold(self.0[(i, i)], f64::min).max(0.0).sqrt();
            (nearest / APART).min(1.0)
        };
        (0..asked).map(of).sum::<f64>() / asked.max(1) as f64
    }

    /// Square of the distance between effect `i` and the nearest sum of multiples of the effects `all`.
    fn beyond(&self, i: usize, all: &[usize]) -> f64 {
        /// Part of an effect below which it does nothing but what those before it do.
        const NOTHING: f64 = 1e-9;
        let products = &self.0;
        // Gram and Schmidt, by products alone: each row is orthogonal to those before, its last product is with `i`.
        let mut rows: Vec<Vec<f64>> = Vec::new();
        let mut left = products[(i, i)];
        for (n, &k) in all.iter().enumerate() {
            let mut row: Vec<f64> = all.iter().chain([&i]).map(|j| products[(k, *j)]).collect();
            for (m, before) in rows.iter().enumerate().filter(|(_, row)| !row.is_empty()) {
                let part = before[n] / before[m];
                row.iter_mut().zip(before).for_each(|(x, b)| *x -= part * b);
            }
            if row[n] > NOTHING * products[(k, k)] {
                left -= row[all.len()].powi(2) / row[n];
                rows.push(row);
            } else {
                rows.push(Vec::new());
            }
        }
        left
    }
}

/// For every listed cause, values with which all readings together show it by each of `sigmas`
/// standard deviations of noise and of the model's own error. One parameter goes from none towards its bound; the others
/// are as they are without the effect, or where a search starts. Left out are causes of which no
/// value that physics allows does so much.
pub fn visible(kind: &dyn Kind, sigmas: &[f64], settings: &Settings) -> Vec<(usize, Vec<f64>)> {
    found(kind, settings, &|cause, seen| {
        let each = sigmas.iter();
        each.filter_map(|sigmas| values_seen(cause, *sigmas, seen).next())
            .collect()
    })
}

/// The same by `sigmas` for each parameter of a cause in turn: together they say what it can do.
pub fn visible_by_each(
    kind: &dyn Kind,
    sigmas: f64,
    settings: &Settings,
) -> Vec<(usize, Vec<f64>)> {
    found(kind, settings, &|cause, seen| {
        let mut all: Vec<(usize, Vec<f64>)> = Vec::new();
        for (parameter, values) in values_seen(cause, sigmas, seen) {
            if all.iter().all(|(other, _)| *other != parameter) {
                all.push((parameter, values));
            }
        }
        all
    })
}

/// A parameter of a cause, and values of all of them with which it is seen.
type Seen = (usize, Vec<f64>);

/// By how many standard deviations readings show values of a cause's parameters, if the model has an answer.
type Sigmas<'a> = dyn Fn(&[f64]) -> Option<f64> + 'a;

/// What `of` finds of every listed cause, by how many standard deviations the readings show its values.
fn found(
    kind: &dyn Kind,
    settings: &Settings,
    of: &(dyn Fn(&Cause, &Sigmas<'_>) -> Vec<Seen> + Sync),
) -> Vec<(usize, Vec<f64>)> {
    let off = Terms::off(kind.causes());
    let Some(view) = View::exact(kind, settings, &off) else {
        return Vec::new();
    };
    let runs: Vec<usize> = (0..view.logs().len()).collect();
    let before = fit::fit_none(&view, &runs);
    let Some(tangent) = before.and_then(|before| Tangent::new(&view, &before)) else {
        return Vec::new();
    };
    let discrepancy = Discrepancy::new(&view);
    // Two terms for one effect are asked about once.
    let about = |cause: &Cause| {
        let names = cause.parameters.iter().map(|p| p.name.clone());
        (cause.id, cause.column.clone(), names.collect::<Vec<_>>())
    };
    let causes = &kind.causes()[..kind.listed()];
    let first: Vec<usize> = (kind.common()..causes.len())
        .filter(|k| causes[..*k].iter().all(|c| about(c) != about(&causes[*k])))
        .collect();
    let found = parallel::map(first.len(), |k| {
        let cause = first[k];
        let seen = |values: &[f64]| {
            let change = tangent.change(&view, &on(kind, cause, values))?;
            Some(self::seen(&discrepancy, &change))
        };
        let each = of(&kind.causes()[cause], &seen).into_iter();
        let mut found: Vec<(usize, Vec<f64>)> = each.map(|(_, values)| (cause, values)).collect();
        found.dedup();
        found
    });
    found.into_iter().flatten().collect()
}

/// Values of the parameters of `cause` that are seen by `sigmas`, each with the parameter that was changed.
fn values_seen<'a>(
    cause: &'a Cause,
    sigmas: f64,
    seen: &'a Sigmas<'a>,
) -> impl Iterator<Item = Seen> + 'a {
    let parameters = &cause.parameters;
    let neutral: Vec<f64> = parameters.iter().map(|p| p.neutral).collect();
    let started = parameters
        .iter()
        .map(|p| p.starts.first().unwrap_or(&p.neutral));
    let started: Vec<f64> = started.copied().collect();
    let ways = [neutral, started].into_iter().flat_map(|rest| {
        let both = (0..parameters.len()).flat_map(|k| [(k, true), (k, false)]);
        both.map(move |(k, up)| (rest.clone(), k, up))
    });
    ways.filter_map(move |(rest, k, up)| {
        let Parameter {
            neutral,
            bounds,
            scale,
            ..
        } = parameters[k];
        let none = neutral.clamp(bounds.0, bounds.1);
        let end = if up { bounds.1 } else { bounds.0 };
        let most = ((end - none).abs() / scale).min(GREATEST);
        let with = |scales: f64| {
            let mut values = rest.clone();
            values[k] = none + if up { scales } else { -scales } * scale;
            values
        };
        let is_seen = |scales: f64| seen(&with(scales)).is_some_and(|x| x >= sigmas);
        if most < LEAST {
            return None;
        }
        if is_seen(LEAST) {
            // The others do it; of a cause apart from none, its least value does.
            return cause.is_apart().then(|| (k, with(LEAST)));
        }
        let grown = |scales: &f64| Some((4.0 * scales).min(most)).filter(|next| next > scales);
        let mut all = std::iter::successors(Some(LEAST), grown);
        let mut more = all.find(|scales| is_seen(*scales))?;
        let mut less = 0.25 * more;
        for _ in 0..HALVINGS {
            let middle = (less * more).sqrt();
            if is_seen(middle) {
                more = middle;
            } else {
                less = middle;
            }
        }
        Some((k, with(more)))
    })
}
