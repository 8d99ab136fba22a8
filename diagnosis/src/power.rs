//! What an experiment can tell, before it is done: how often a diagnosis would name an effect of a
//! given size, and what it would take it for.
//!
//! What an effect does to the readings is computed by the full model. What each other cause can
//! explain of that and of the noise follows from the model linearised without an effect; of one that
//! explains most of it, from what the full model does at the values found. Each draw of noise is
//! judged by the rules of a diagnosis, of which no fit is made.

use nalgebra::{DMatrix, DVector};
use rand_pcg::Pcg64;
use saltus_numeric::parallel;
use saltus_numeric::statistics::dot;

use crate::discrepancy::Discrepancy;
use crate::evidence::Evidence;
use crate::fit;
use crate::kind::{Cause, Kind, Parameter, Terms};
use crate::policy::POLICY;
use crate::settings::Settings;
use crate::stages::screen;
use crate::tangent::{Direction, Tangent};
use crate::view::View;

/// Least and greatest change of a parameter that is tried, in its scales, within its bounds; and how
/// often the step between two that are a factor of four apart is halved on a logarithmic scale.
const LEAST: f64 = 1e-4;
const GREATEST: f64 = 1e4;
const HALVINGS: usize = 8;
/// Part of a change that a cause explains by its direction, from which its model is asked how it
/// bends.
const NEAR: f64 = 0.5;

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
    let Some(view) = View::exact(kind, settings, &Terms::off(kind.causes())) else {
        return Vec::new();
    };
    let evidence = Evidence::new(&view, settings, progress, false);
    let Some(outlook) = Outlook::new(&evidence) else {
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

/// An experiment without an effect, and what noise does in it.
struct Outlook<'a> {
    evidence: &'a Evidence<'a>,
    tangent: Tangent,
    threshold: f64,
    /// Draws of the noise (σ), clear of the unknowns.
    noise: Vec<Vec<f64>>,
    /// For each candidate of the tangent its parts of the draws.
    parts: Vec<Vec<DVector<f64>>>,
}

impl<'a> Outlook<'a> {
    fn new(evidence: &'a Evidence<'a>) -> Option<Outlook<'a>> {
        let before = fit::fit_none(evidence.kind, &evidence.runs)?;
        let tangent = Tangent::new(evidence.kind, &before, true)?;
        let mut random = Pcg64::new(u128::from(evidence.settings.seed), 13);
        let threshold = screen::threshold(evidence, &tangent, &mut random);
        let draws = 0..evidence.settings.draws;
        let noise = draws.map(|_| tangent.noise(evidence.kind, &mut random));
        let noise: Vec<Vec<f64>> = noise.collect();
        let parts = parallel::map(tangent.candidates.len(), |k| {
            let of = |noise: &Vec<f64>| tangent.candidates[k].parts(noise);
            noise.iter().map(of).collect()
        });
        Some(Outlook {
            evidence,
            tangent,
            threshold,
            noise,
            parts,
        })
    }

    fn of_effect(&self, cause: usize, values: &[f64]) -> Option<Power> {
        let spec = &self.evidence.kind.causes()[cause];
        let terms = on(self.evidence.kind, cause, values);
        let change = self.tangent.change(self.evidence.kind, &terms)?;
        let answers = self.answers(cause, values, &change);
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
            visible: seen(&self.evidence.discrepancy, &change),
            named: share(&|a| a.contains(&id)),
            alone: share(&|a| a[..] == [id]),
            nothing: share(&|a| a.is_empty()),
            others,
        })
    }

    /// What would be named in each draw of an experiment with `values` of `cause`, which do
    /// `change`.
    fn answers(&self, cause: usize, values: &[f64], change: &[f64]) -> Vec<Vec<&'static str>> {
        let mut all: Vec<Contender> = (0..self.tangent.candidates.len())
            .filter(|k| self.tangent.candidates[*k].cause != cause)
            .map(|k| self.rival(k, change))
            .collect();
        all.push(self.itself(cause, values, change));
        let judge = Judge::new(self.evidence, self.threshold, all);
        (0..self.noise.len())
            .map(|draw| judge.answer(draw))
            .collect()
    }

    /// The cause that is at work: it explains all of the change, and of the noise what its
    /// parameters can.
    fn itself(&self, cause: usize, values: &[f64], change: &[f64]) -> Contender {
        let candidates = &self.tangent.candidates;
        let own = candidates.iter().position(|d| d.cause == cause);
        let whole = dot(change, change);
        let gain = |draw: usize| {
            let by_chance = own.map_or(0.0, |k| candidates[k].gain_of(&self.parts[k][draw]));
            whole + 2.0 * dot(change, &self.noise[draw]) + by_chance
        };
        let gains = (0..self.noise.len()).map(gain).collect();
        Contender::new(self.evidence, cause, values, change.to_vec(), gains)
    }

    /// Candidate `k` in the place of the cause: it explains what lies along its direction.
    fn rival(&self, k: usize, change: &[f64]) -> Contender {
        let direction = &self.tangent.candidates[k];
        let values = self.nearest(direction, change);
        let of = |direction: &Direction, noise: &dyn Fn(usize) -> DVector<f64>| {
            let own = direction.parts(change);
            let gains = (0..self.noise.len()).map(|draw| direction.gain_of(&(&own + noise(draw))));
            let explained = direction.explained(change);
            Contender::new(
                self.evidence,
                direction.cause,
                &values,
                explained,
                gains.collect(),
            )
        };
        // Where it comes near to the change, it matters how the model bends.
        let is_near = direction.gain(change) > NEAR * dot(change, change);
        let is_apart = self.evidence.kind.causes()[direction.cause].is_apart();
        if is_near && !is_apart {
            let terms = on(self.evidence.kind, direction.cause, &values);
            let bent = self
                .tangent
                .bent(self.evidence.kind, direction, &terms, change);
            if let Some(bent) = bent {
                return of(&bent, &|draw| bent.parts(&self.noise[draw]));
            }
        }
        of(direction, &|draw| self.parts[k][draw].clone())
    }

    /// Values of the parameters of a cause that explain most of `change` by its direction.
    fn nearest(&self, direction: &Direction, change: &[f64]) -> Vec<f64> {
        let parameters = &self.evidence.kind.causes()[direction.cause].parameters;
        let mut values: Vec<f64> = parameters.iter().map(|p| p.neutral).collect();
        for (p, scales) in direction.steps(change) {
            let Parameter { scale, bounds, .. } = parameters[p];
            values[p] = (values[p] + scale * scales).clamp(bounds.0, bounds.1);
        }
        values
    }
}

/// A cause as it explains the data.
struct Contender {
    cause: usize,
    id: &'static str,
    /// What it explains of the change (σ), and the coordinates of that in the model's own error.
    explained: Vec<f64>,
    coordinates: Vec<f64>,
    /// By how much it lowers the loss in each draw.
    gains: Vec<f64>,
    /// Whether it changes readings by enough to be claimed.
    counts: bool,
    /// Cost of what is known of its parameters.
    penalty: f64,
    /// Whether its values contradict what is known.
    contradicts: bool,
}

impl Contender {
    fn new(
        evidence: &Evidence,
        cause: usize,
        values: &[f64],
        explained: Vec<f64>,
        gains: Vec<f64>,
    ) -> Contender {
        let spec = &evidence.kind.causes()[cause];
        Contender {
            cause,
            id: spec.id,
            coordinates: evidence.discrepancy.coordinates(&explained),
            counts: evidence.effect_of(&explained) >= evidence.least_effect(cause, 0),
            penalty: spec.penalty(values),
            contradicts: spec.contradicts(values),
            explained,
            gains,
        }
    }

    /// Variance inflation by the model's own error where it is compared with `other`, or with
    /// nothing.
    fn inflation(&self, other: Option<&Contender>) -> f64 {
        let square = |a: &[f64], b: Option<&Vec<f64>>| match b {
            Some(b) => a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum(),
            None => dot(a, a),
        };
        let noise: f64 = square(&self.explained, other.map(|c| &c.explained));
        let model: f64 = square(&self.coordinates, other.map(|c| &c.coordinates));
        if noise > 0.0 {
            1.0 + model / noise
        } else {
            1.0
        }
    }
}

/// What a diagnosis decides by.
struct Judge<'a> {
    evidence: &'a Evidence<'a>,
    threshold: f64,
    all: Vec<Contender>,
    /// Variance inflation of each contender, and between every two.
    inflation: Vec<f64>,
    between: Vec<Vec<f64>>,
}

impl<'a> Judge<'a> {
    fn new(evidence: &'a Evidence<'a>, threshold: f64, all: Vec<Contender>) -> Judge<'a> {
        let between = |a: &Contender| all.iter().map(|b| a.inflation(Some(b))).collect();
        Judge {
            inflation: all.iter().map(|c| c.inflation(None)).collect(),
            between: all.iter().map(between).collect(),
            evidence,
            threshold,
            all,
        }
    }

    /// Ids that would be named in a draw: the cause first, then its rivals.
    fn answer(&self, draw: usize) -> Vec<&'static str> {
        let evidence = self.evidence;
        let (every, gain) = (0..self.all.len(), |k: usize| self.all[k].gains[draw]);
        let degrees = |k: usize| evidence.degrees(self.all[k].cause) as f64;
        let worth = |k: usize| gain(k) - 2.0 * degrees(k) - self.all[k].penalty;
        let passes = |k: usize| {
            let gain = gain(k) / self.inflation[k];
            evidence.gain_beyond_chance(self.all[k].cause, gain) > self.threshold
        };
        let best = every.clone().max_by(|a, b| worth(*a).total_cmp(&worth(*b)));
        let Some(best) = best.filter(|k| self.all[*k].counts && every.clone().any(passes)) else {
            return Vec::new();
        };
        let named = &self.all[best];
        let needed = self.threshold.max(0.0) + named.penalty + evidence.gain_by_chance(named.cause);
        if gain(best) / self.inflation[best] < needed {
            return Vec::new();
        }
        let is_rival = |k: usize| {
            let lead = gain(best) - gain(k);
            let behind = (lead + 2.0 * (degrees(k) - degrees(best))) / self.between[best][k];
            let is_equal = lead.abs() < POLICY.equal_gain * gain(best).abs() + 0.5;
            (is_equal || behind < POLICY.rival_loss)
                && (named.contradicts || !self.all[k].contradicts)
        };
        let mut rivals: Vec<usize> = every.filter(|k| *k != best && is_rival(*k)).collect();
        rivals.sort_by(|a, b| worth(*b).total_cmp(&worth(*a)));
        let mut ids = vec![named.id];
        for rival in rivals {
            let id = self.all[rival].id;
            if !ids.contains(&id) && ids.len() <= POLICY.most_rivals {
                ids.push(id);
            }
        }
        ids
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

    /// How well the first `asked` of effects with these ids are told from the others, from 0 to 1: the
    /// mean over them of the distance between what one does and the nearest multiple of what another
    /// does, where so many standard deviations as tell two predictions apart are enough.
    pub fn apart(&self, ids: &[&str], asked: usize) -> f64 {
        let products = &self.0;
        let of = |i: usize| {
            let whole = products[(i, i)];
            let others = (0..ids.len()).filter(|j| ids[*j] != ids[i] && products[(*j, *j)] > 0.0);
            let left = others.map(|j| whole - products[(i, j)].powi(2) / products[(j, j)]);
            let nearest = left.fold(whole, f64::min).max(0.0).sqrt();
            (nearest / POLICY.told_apart).min(1.0)
        };
        (0..asked).map(of).sum::<f64>() / asked.max(1) as f64
    }
}

/// For every listed cause, values with which all readings together show it by each of `sigmas`
/// standard deviations of noise and of the model's own error. One parameter goes from none towards its bound; the others
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
        let each = sigmas.iter();
        let mut found: Vec<(usize, Vec<f64>)> = each
            .filter_map(|sigmas| Some((cause, value_seen(&kind.causes()[cause], *sigmas, &seen)?)))
            .collect();
        found.dedup();
        found
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
            return cause.is_apart().then(|| with(LEAST));
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
        Some(with(more))
    });
    found.next()
}
