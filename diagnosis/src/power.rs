//! What an experiment can tell, before it is done: how often a diagnosis would name an effect of a
//! given size, and what it would take it for.
//!
//! For each effect the data are made without noise, and every promising cause is fitted to them as
//! in a diagnosis. Where the causes end, noise moves their losses as in the linear model: the loss
//! of a cause is that of what it leaves and of the noise together, less what its own parameters take
//! of the noise. Each draw of noise is then judged by the rules of a diagnosis.

use nalgebra::DMatrix;
use rand_pcg::Pcg64;
use saltus_numeric::parallel;
use saltus_numeric::statistics::dot;

use crate::evidence::Evidence;
use crate::finding::Candidate;
use crate::fit::{self, Fit, huber};
use crate::kind::{Cause, Kind, Parameter, Terms};
use crate::policy::POLICY;
use crate::settings::Settings;
use crate::stages::candidates::candidates;
use crate::stages::screen;
use crate::tangent::{Direction, Tangent};
use crate::view::View;

/// Least part of the range of a parameter that is tried, and how often the part is halved (on a
/// logarithmic scale) between two that are a factor of four apart.
const LEAST_PART: f64 = 1e-7;
const HALVINGS: usize = 8;

/// What an experiment can tell of one effect.
#[derive(Clone, Debug, PartialEq)]
pub struct Power {
    /// Id of the cause.
    pub id: &'static str,
    /// The measured column that it is about, if it is about one.
    pub column: Option<String>,
    /// Its parameters as they are reported: names and values.
    pub values: Vec<(String, f64)>,
    /// By how many standard deviations of the noise all readings together show it.
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
/// cause and the values of its parameters. `progress` is told what is being done. None of an effect
/// with which the model has no answer.
pub fn power(
    kind: &dyn Kind,
    effects: &[(usize, Vec<f64>)],
    settings: &Settings,
    progress: &(dyn Fn(&str) + Sync),
) -> Vec<Option<Power>> {
    parallel::map(effects.len(), |k| {
        let (cause, values) = &effects[k];
        progress(kind.causes()[*cause].id);
        of_effect(kind, *cause, values, settings)
    })
}

fn of_effect(kind: &dyn Kind, cause: usize, values: &[f64], settings: &Settings) -> Option<Power> {
    let view = View::exact(kind, settings, &on(kind, cause, values))?;
    let silent = |_: &str| ();
    let evidence = Evidence::new(&view, settings, &silent, false);
    let before = fit::fit_none(&view, &evidence.runs)?;
    let tangent = Tangent::new(&view, &before, true)?;
    let mut random = Pcg64::new(u128::from(settings.seed), 13);
    let threshold = screen::threshold(&evidence, &tangent, &mut random);
    let mut fitted = candidates(&evidence, &before, Some(&tangent));
    if !fitted.iter().any(|c| c.cause == cause) {
        let fit = evidence.with(&before, cause)?;
        fitted.push(Candidate::new(&view, cause, &before, fit));
    }
    let judge = Judge {
        evidence: &evidence,
        threshold,
        before: Tangent::residuals(&view, &before)?,
        all: fitted
            .into_iter()
            .map(|candidate| Contender::new(&evidence, &before, &tangent, candidate))
            .collect::<Option<_>>()?,
    };
    let judge = judge.compared();
    let draws: Vec<Vec<f64>> = (0..settings.draws)
        .map(|_| tangent.noise(&view, &mut random))
        .collect();
    let answers = parallel::map(draws.len(), |k| judge.1.answer(&judge.0, &draws[k]));
    let id = kind.causes()[cause].id;
    let share = |is: &dyn Fn(&Vec<&'static str>) -> bool| {
        answers.iter().filter(|a| is(a)).count() as f64 / answers.len() as f64
    };
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
        column: kind.causes()[cause].column.clone(),
        values: kind.causes()[cause].report(values),
        visible: dot(&judge.1.before, &judge.1.before).sqrt(),
        named: share(&|a| a.contains(&id)),
        alone: share(&|a| a[..] == [id]),
        nothing: share(&|a| a.is_empty()),
        others,
    })
}

/// The terms with one cause on.
fn on(kind: &dyn Kind, cause: usize, values: &[f64]) -> Terms {
    let mut terms = Terms::off(kind.causes());
    for (p, value) in values.iter().enumerate() {
        terms.set(cause, p, *value);
    }
    terms
}

/// A cause as it explains data without noise.
struct Contender<'a> {
    candidate: Candidate,
    /// What it leaves (σ).
    left: Vec<f64>,
    /// What it can do to noise.
    direction: Option<&'a Direction>,
    /// Variance inflation by the model's own error.
    inflation: f64,
    /// Whether it changes readings by enough to be claimed.
    counts: bool,
    /// Cost of its parameters and of what is known of them.
    cost: f64,
}

impl<'a> Contender<'a> {
    fn new(
        evidence: &Evidence,
        before: &Fit,
        tangent: &'a Tangent,
        candidate: Candidate,
    ) -> Option<Contender<'a>> {
        let (cause, fit) = (candidate.cause, &candidate.fit);
        let mut of_cause = tangent.candidates.iter().filter(|d| d.cause == cause);
        Some(Contender {
            left: Tangent::residuals(evidence.kind, fit)?,
            direction: of_cause.next(),
            inflation: evidence.inflation_between(before, fit, 1.0),
            counts: evidence.effect(before, fit) >= evidence.least_effect(cause, 0),
            cost: 2.0 * evidence.degrees(cause) as f64 + evidence.prior_penalty(&candidate),
            candidate,
        })
    }
}

/// What a diagnosis decides by.
struct Judge<'a> {
    evidence: &'a Evidence<'a>,
    threshold: f64,
    /// What the model as it is leaves (σ).
    before: Vec<f64>,
    all: Vec<Contender<'a>>,
}

/// Variance inflation between every two contenders.
struct Between(Vec<Vec<f64>>);

impl<'a> Judge<'a> {
    /// With the variance inflation between every two contenders.
    fn compared(self) -> (Between, Judge<'a>) {
        let fits: Vec<&Fit> = self.all.iter().map(|c| &c.candidate.fit).collect();
        let between = |a: &&Fit| {
            let row = fits.iter();
            row.map(|b| self.evidence.inflation_between(a, b, 1.0))
                .collect()
        };
        let between = Between(fits.iter().map(between).collect());
        (between, self)
    }

    /// Ids that would be named, the cause first, then its rivals.
    fn answer(&self, between: &Between, noise: &[f64]) -> Vec<&'static str> {
        let loss = |left: &[f64]| {
            let both = left.iter().zip(noise);
            both.map(|(a, b)| huber(a + b)).sum::<f64>()
        };
        let before = loss(&self.before);
        let gains: Vec<f64> = self
            .all
            .iter()
            .map(|c| before - loss(&c.left) + c.direction.map_or(0.0, |d| d.gain(noise)))
            .collect();
        let passes = |k: &usize| {
            let gain = gains[*k] / self.all[*k].inflation;
            let cause = self.all[*k].candidate.cause;
            self.evidence.gain_beyond_chance(cause, gain) > self.threshold
        };
        let every = || 0..self.all.len();
        let worth = |k: usize| gains[k] - self.all[k].cost;
        let best = every().max_by(|a, b| worth(*a).total_cmp(&worth(*b)));
        let Some(best) = best.filter(|k| every().any(|k| passes(&k)) && self.all[*k].counts) else {
            return Vec::new();
        };
        let needed = self.threshold.max(0.0) + self.all[best].cost
            - 2.0 * self.evidence.degrees(self.all[best].candidate.cause) as f64
            + self.evidence.gain_by_chance(self.all[best].candidate.cause);
        if gains[best] / self.all[best].inflation < needed {
            return Vec::new();
        }
        let named = &self.all[best].candidate;
        let mut rivals: Vec<usize> = every()
            .filter(|k| *k != best && self.is_rival(between, &gains, best, *k))
            .filter(|k| {
                !self.evidence.contradicts(&self.all[*k].candidate)
                    || self.evidence.contradicts(named)
            })
            .collect();
        rivals.sort_by(|a, b| worth(*b).total_cmp(&worth(*a)));
        let mut ids = vec![named.id];
        for rival in rivals {
            let id = self.all[rival].candidate.id;
            if !ids.contains(&id) && ids.len() <= POLICY.most_rivals {
                ids.push(id);
            }
        }
        ids
    }

    /// Whether data do not tell `other` from `best`.
    fn is_rival(&self, between: &Between, gains: &[f64], best: usize, other: usize) -> bool {
        let degrees = |k: usize| self.evidence.degrees(self.all[k].candidate.cause) as f64;
        let lead = gains[best] - gains[other];
        let behind = (lead + 2.0 * (degrees(other) - degrees(best))) / between.0[best][other];
        lead.abs() < POLICY.equal_gain * gains[best].abs() + 0.5 || behind < POLICY.rival_loss
    }
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
    let tangent = Tangent::new(&view, &before, false)?;
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

    /// How well effects with these ids are told apart, from 0 to 1: the mean over all of them of the
    /// distance between what one does and the nearest multiple of what another does, where so many
    /// standard deviations as tell two predictions apart are enough.
    pub fn apart(&self, ids: &[&str]) -> f64 {
        let products = &self.0;
        let of = |i: usize| {
            let whole = products[(i, i)];
            let others = (0..ids.len()).filter(|j| ids[*j] != ids[i] && products[(*j, *j)] > 0.0);
            let left = others.map(|j| whole - products[(i, j)].powi(2) / products[(j, j)]);
            let nearest = left.fold(whole, f64::min).max(0.0).sqrt();
            (nearest / POLICY.told_apart).min(1.0)
        };
        (0..ids.len()).map(of).sum::<f64>() / ids.len().max(1) as f64
    }
}

/// For every listed cause, values with which all readings together show it by each of `sigmas`
/// standard deviations of their noise. One parameter goes from none towards its bound; the others
/// are as they are without the effect, or where a search starts. Left out are causes of which no
/// value that physics allows does so much.
pub fn visible(kind: &dyn Kind, sigmas: &[f64], settings: &Settings) -> Vec<(usize, Vec<f64>)> {
    let off = Terms::off(kind.causes());
    let Some(view) = View::exact(kind, settings, &off) else {
        return Vec::new();
    };
    let runs: Vec<usize> = (0..view.logs().len()).collect();
    let before = fit::fit_none(&view, &runs);
    let Some(tangent) = before.and_then(|before| Tangent::new(&view, &before, false)) else {
        return Vec::new();
    };
    let found = parallel::map(kind.listed(), |cause| {
        let seen = |values: &[f64]| {
            let change = tangent.change(&view, &on(kind, cause, values))?;
            Some(dot(&change, &change).sqrt())
        };
        let each = sigmas.iter();
        each.filter_map(|sigmas| Some((cause, value_seen(&kind.causes()[cause], *sigmas, &seen)?)))
            .collect::<Vec<_>>()
    });
    found.into_iter().flatten().collect()
}

/// Values of the parameters of `cause` that are seen by `sigmas`.
fn value_seen(
    cause: &Cause,
    sigmas: f64,
    seen: &dyn Fn(&[f64]) -> Option<f64>,
) -> Option<Vec<f64>> {
    let parameters = &cause.parameters;
    let neutral: Vec<f64> = parameters.iter().map(|p| p.neutral).collect();
    let started = parameters
        .iter()
        .map(|p| p.starts.first().unwrap_or(&p.neutral));
    let started: Vec<f64> = started.copied().collect();
    let ways = [&neutral, &started].into_iter().flat_map(|rest| {
        (0..parameters.len()).flat_map(move |k| [true, false].map(|up| (rest, k, up)))
    });
    let mut found = ways.filter_map(|(rest, k, up)| {
        let Parameter {
            neutral, bounds, ..
        } = parameters[k];
        let none = neutral.clamp(bounds.0, bounds.1);
        let reach = if up { bounds.1 } else { bounds.0 } - none;
        let with = |part: f64| {
            let mut values = rest.clone();
            values[k] = none + reach * part;
            values
        };
        let is_seen = |part: f64| seen(&with(part)).is_some_and(|x| x >= sigmas);
        if is_seen(LEAST_PART) {
            // The others do it; of a cause apart from none, its least value does.
            return cause.is_apart().then(|| with(LEAST_PART));
        }
        let grown = |part: &f64| Some((4.0 * part).min(1.0)).filter(|next| next > part);
        let parts = std::iter::successors(Some(LEAST_PART), grown);
        let mut more = parts.into_iter().find(|part| is_seen(*part))?;
        let mut less = 0.25 * more;
        for _ in 0..HALVINGS {
            let middle = (less * more).sqrt();
            if is_seen(middle) {
                more = middle;
            } else {
                less = middle;
            }
        }
        Some(with(more))
    });
    found.next()
}
