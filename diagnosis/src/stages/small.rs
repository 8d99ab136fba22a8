//! What is visible, and within the model's own error.

use saltus_numeric::statistics::rms;

use crate::evidence::Evidence;
use crate::finding::{Candidate, Small};
use crate::fit::{self, Fit};
use crate::policy::POLICY;

/// What of `tried`, causes alone beside `before`, noise alone would not explain; none where that is
/// nothing.
pub(crate) fn small(evidence: &Evidence, before: &Fit, tried: &[Candidate]) -> Option<Small> {
    let is_visible = |c: &&Candidate| {
        let gain = c.gain / evidence.inflation(&c.fit);
        evidence.gain_beyond_chance(c.cause, gain) > POLICY.rival_loss
    };
    let causes: Vec<Candidate> = tried
        .iter()
        .filter(is_visible)
        .take(1 + POLICY.most_rivals)
        .cloned()
        .collect();
    let sizes = sizes(evidence, before, &causes.first()?.fit);
    let (channel, sigmas) = (0..sizes.len())
        .map(|c| (c, sizes[c]))
        .max_by(|a, b| a.1.total_cmp(&b.1))?;
    let about = &evidence.kind.channels()[channel];
    Some(Small {
        channel: about.name.clone(),
        rms: sigmas * about.noise,
        sigmas,
        causes,
    })
}

/// Root mean square (σ) of what two models say differently of each channel.
fn sizes(evidence: &Evidence, a: &Fit, b: &Fit) -> Vec<f64> {
    let kind = evidence.kind;
    let mut differences = vec![Vec::new(); kind.channels().len()];
    for (run, log) in kind.logs().iter().enumerate() {
        let of = |model: &Fit| fit::predicted(kind, run, &model.terms, &model.unknowns[run]);
        let (Some(a), Some(b)) = (of(a), of(b)) else {
            continue;
        };
        for (reading, (a, b)) in log.readings.iter().zip(a.iter().zip(&b)) {
            differences[reading.channel].push((a - b) / reading.weight.sqrt());
        }
    }
    differences.iter().map(|all| rms(all)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;
    use crate::stages::candidates::candidates_beside;
    use crate::toy::{ALL, Toy, noise, sum, wave};

    fn found(size: f64) -> Option<Small> {
        let data = sum(&[(size, &wave(0)), (1.0, &noise(1))]);
        let toy = Toy::new(&data, vec![wave(0), wave(1)]).with_discrepancy(0.4);
        let settings = Settings::default();
        let evidence = toy.evidence(&settings);
        let tried = candidates_beside(&evidence, &toy.before());
        small(&evidence, &toy.before(), &tried)
    }

    #[test]
    fn noise_shows_nothing() {
        assert!(found(0.0).is_none());
    }

    /// A unit wave of 9 has a root mean square of 9/√400.
    #[test]
    fn what_shows_has_its_size() {
        let found = found(9.0).expect("something");
        assert_eq!((found.channel.as_str(), found.causes[0].cause), ("y_m", 0));
        assert_eq!(found.causes.len(), 1);
        assert!(
            (found.sigmas * (ALL as f64).sqrt() - 9.0).abs() < 2.0,
            "{found:?}"
        );
        assert_eq!(found.rms, found.sigmas);
    }
}
