//! What is known apart from the data, in words.

use saltus::diagnosis::{Candidate, Deviation, Finding, Kind, POLICY, Source};
use serde_json::{Value, json};

use super::words::slip_of;
use crate::output::{digits, unit, with_unit};

/// What is known against a finding and its rivals, a sentence for each.
pub(super) fn against(kind: &dyn Kind, finding: &Finding) -> Vec<String> {
    let of_best = far(&finding.best).map(|said| format!("It contradicts what is known: {said}."));
    let rivals = finding.rivals.iter().filter_map(|rival| {
        let said = far(rival)?;
        Some(format!("So does {}: {said}.", rival.title()))
    });
    let others = finding.contradicting.iter().filter_map(|other| {
        let (verb, said) = match far(other) {
            Some(said) => ("contradicts", said),
            None => ("is less likely by", farthest(other)?),
        };
        let slips = (0..other.reported.len()).filter_map(|k| slip_of(kind, other, k));
        let said: Vec<String> = std::iter::once(said).chain(slips).collect();
        Some(format!(
            "{} would explain the data as well, and {verb} what is known: {}.",
            other.title(),
            said.join("; ")
        ))
    });
    of_best.into_iter().chain(rivals).chain(others).collect()
}

/// How far a candidate is from what is known; none where it does not contradict that.
pub(super) fn far(candidate: &Candidate) -> Option<String> {
    let far = |d: &&Deviation| d.size() > POLICY.contradiction;
    let said: Vec<String> = candidate.deviations.iter().filter(far).map(said).collect();
    (!said.is_empty()).then(|| said.join("; "))
}

/// What is farthest from what is known.
fn farthest(candidate: &Candidate) -> Option<String> {
    let all = candidate.deviations.iter();
    let farthest = all.max_by(|a, b| a.size().total_cmp(&b.size()));
    farthest.map(said)
}

fn said(deviation: &Deviation) -> String {
    let (prior, unit) = (&deviation.prior, unit(&deviation.name));
    let source = match prior.source {
        Source::Stated => "as stated",
        Source::Common(why) => why,
    };
    format!(
        "{} would be {}, {} standard deviations from {} ({source})",
        deviation.name,
        with_unit(deviation.value, 3, unit),
        digits(deviation.size(), 2),
        with_unit(
            prior.value,
            4,
            &format!("± {} {unit}", digits(prior.error, 2))
        ),
    )
}

/// Candidates with what is known of their parameters, for programs.
pub(super) fn json(candidates: &[Candidate]) -> Vec<Value> {
    let deviation = |d: &Deviation| {
        let source = match d.prior.source {
            Source::Stated => "stated",
            Source::Common(why) => why,
        };
        json!({
            "parameter": d.name,
            "value": d.value,
            "known": d.prior.value,
            "standard_deviation": d.prior.error,
            "source": source,
            "standard_deviations_away": d.size(),
        })
    };
    let one = |c: &Candidate| {
        let deviations: Vec<Value> = c.deviations.iter().map(deviation).collect();
        json!({ "id": c.id, "column": c.column, "deviations": deviations })
    };
    candidates.iter().map(one).collect()
}
