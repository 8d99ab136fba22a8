//! Which experiment would tell causes apart that the data cannot.

use saltus_numeric::parallel;

use crate::fit::Fit;
use crate::kind::{Kind, Proposal};

/// The proposal that tells most rivals apart.
#[derive(Clone, Debug, PartialEq)]
pub struct NextExperiment {
    /// What to do, at which settings.
    pub what: String,
    /// The column that tells most.
    pub channel: String,
    /// By how many standard deviations of a reading there two rivals differ, at most.
    pub sigmas: f64,
    /// Ids of causes that it tells apart, two by two.
    pub apart: Vec<(&'static str, &'static str)>,
}

/// Standard deviations by which two causes are told apart for sure.
pub(crate) const APART: f64 = 5.0;

/// Of `proposals`, the one that tells most of the `rivals` apart (their causes and models); none
/// where none would show a difference of a standard deviation.
pub(crate) fn next(
    kind: &dyn Kind,
    rivals: &[(usize, &Fit)],
    proposals: &[Proposal],
) -> Option<NextExperiment> {
    let id = |k: usize| {
        if rivals[k].0 < kind.listed() {
            kind.causes()[rivals[k].0].id
        } else {
            "unknown"
        }
    };
    let tried = parallel::map(proposals.len(), |k| {
        let there = proposals[k].kind.as_ref();
        let all: Option<Vec<Vec<f64>>> = rivals
            .iter()
            .map(|(_, fit)| predicted(kind, &proposals[k], fit))
            .collect();
        let all = all?;
        let (mut score, mut most, mut apart) = (0.0, (0.0, 0), Vec::new());
        for a in 0..all.len() {
            for b in a + 1..all.len() {
                let (sigmas, channel) = difference(there, &all[a], &all[b]);
                score += sigmas.min(APART);
                if sigmas > most.0 {
                    most = (sigmas, channel);
                }
                if sigmas >= APART {
                    apart.push((id(a), id(b)));
                }
            }
        }
        Some((score, most, apart))
    });
    let mut best: Option<(usize, f64, f64)> = None;
    for (k, found) in tried.iter().enumerate() {
        let Some((score, (sigmas, _), _)) = found else {
            continue;
        };
        if best.is_none_or(|(_, s, m)| *score > s + 1e-9 || (*score > s - 1e-9 && *sigmas > m)) {
            best = Some((k, *score, *sigmas));
        }
    }
    let (k, ..) = best?;
    let (_, (sigmas, channel), apart) = tried[k].clone()?;
    (sigmas >= 1.0).then(|| NextExperiment {
        what: proposals[k].what.clone(),
        channel: proposals[k].kind.channels()[channel].name.clone(),
        sigmas,
        apart,
    })
}

/// What the model `fit` of `kind` says of a proposal, in standard deviations.
fn predicted(kind: &dyn Kind, proposal: &Proposal, fit: &Fit) -> Option<Vec<f64>> {
    let there = proposal.kind.as_ref();
    let mut terms = crate::kind::Terms::off(there.causes());
    // A cause is the same where its id, its column and its parameters are; one that is not there
    // does not show there.
    for (c, cause) in kind
        .causes()
        .iter()
        .enumerate()
        .filter(|(c, _)| fit.causes.contains(c))
    {
        let is_it = |other: &&crate::kind::Cause| {
            other.id == cause.id
                && other.column == cause.column
                && other.parameters[0].name == cause.parameters[0].name
        };
        if let Some(other) = there.causes().iter().position(|o| is_it(&o)) {
            for (p, value) in fit.terms.of(c).iter().enumerate() {
                terms.set(other, p, *value);
            }
        }
    }
    let unknowns: Vec<f64> = there.unknowns(0).iter().map(|p| p.neutral).collect();
    crate::fit::predicted(there, 0, &terms, &unknowns)
}

/// The greatest difference, and its channel.
fn difference(kind: &dyn Kind, a: &[f64], b: &[f64]) -> (f64, usize) {
    let readings = &kind.logs()[0].readings;
    let mut most = (0.0, 0);
    for ((a, b), reading) in a.iter().zip(b).zip(readings) {
        if (a - b).abs() > most.0 {
            most = ((a - b).abs(), reading.channel);
        }
    }
    most
}
