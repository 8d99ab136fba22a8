//! What a diagnosis says: causes with their parameters, what else could be, and what is unknown.

use nalgebra::DMatrix;

use crate::fit::Fit;
use crate::fitness::{self, Fitness};
use crate::gain::Gain;
use crate::kind::{Kind, Parameter, Terms};
use crate::next::NextExperiment;
use crate::parallel;
use crate::profile::{Interval, Profile};
use crate::tangent::Tangent;

/// A cause as a candidate, fitted with those before it.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// Index of the cause.
    pub cause: usize,
    /// By how much the loss falls with it, where white noise would make it fall by about one for
    /// each parameter.
    pub gain: f64,
    /// The model with it.
    pub fit: Fit,
    /// Its parameters as they are reported.
    pub reported: Vec<Reported>,
}

/// A parameter of a cause as it is reported.
#[derive(Clone, Debug, PartialEq)]
pub struct Reported {
    /// Its name, which ends with its unit.
    pub name: String,
    /// What the data say.
    pub value: f64,
    /// One standard error; not a number where it rests at a bound at which it does nothing.
    pub error: f64,
    /// Its 95 % interval by profile likelihood; of causes that were found, where it does not depend
    /// on several parameters of the fit.
    pub interval: Option<Interval>,
}

/// A cause that was found.
#[derive(Clone, Debug)]
pub struct Finding {
    /// The cause in the model.
    pub best: Candidate,
    /// Those that the data cannot tell from it, each in its place: the two nearest.
    pub rivals: Vec<Candidate>,
    /// Those after them that the data do not exclude either.
    pub less_likely: Vec<Candidate>,
    /// A term without an id that explains the data as well.
    pub unlisted: Option<Candidate>,
    /// By how much the loss of data left out falls with it.
    pub held_out: f64,
    /// A direction of its parameters that the data do not tell, as the part of each.
    pub undetermined: Option<Vec<f64>>,
    /// Whether the data limit how strong it is. If not, a stronger one predicts the same readings,
    /// or physics allows no stronger one.
    pub is_identifiable: bool,
    /// Where there are rivals, the experiment that would tell them apart.
    pub next: Option<NextExperiment>,
}

/// What the data say.
#[derive(Clone, Debug)]
pub struct Diagnosis {
    /// The causes, the most telling first.
    pub findings: Vec<Finding>,
    /// Something that is wrong beyond them.
    pub unknown: Option<fitness::Unknown>,
    /// The term of the state that describes it best, if one does on data left out too; it has no id
    /// of a cause.
    pub term: Option<Candidate>,
    /// Every cause alone, the best first.
    pub tried: Vec<Candidate>,
    /// The model as it is.
    pub before: Fit,
    /// The model with all findings.
    pub after: Fit,
    /// How well they fit.
    pub fitness: (Fitness, Fitness),
    /// By how much more than white noise the residuals weigh: variance times correlation time, at
    /// least 1.
    pub inflation: f64,
    /// Held-out gain of each channel.
    pub gains: Vec<Gain>,
}

/// Whether nothing limits a parameter, found to be `value`, on the side away from neutral: there
/// its interval with these ends has no end, and physics allows far more than the least that
/// explains the data.
fn is_unlimited(parameter: &Parameter, value: f64, [low, high]: [Option<f64>; 2]) -> bool {
    /// How far, in terms of that least.
    const FAR: f64 = 2.0;
    let Parameter {
        neutral, bounds, ..
    } = parameter;
    let (inner, outer, bound) = if value > *neutral {
        (low, high, bounds.1)
    } else {
        (high, low, bounds.0)
    };
    let least = inner.map_or(0.0, |x| (x - neutral).abs());
    outer.is_none() && (bound - neutral).abs() > FAR * least
}

/// What the data do not tell of a cause.
pub(crate) struct Told {
    /// A direction of its parameters that the data do not tell, if there is one.
    pub(crate) undetermined: Option<Vec<f64>>,
    /// Whether nothing limits how strong it is; false without intervals.
    pub(crate) is_open: bool,
}

/// Fills in what is reported of a candidate's cause, with standard errors by first differences of
/// what is reported.
pub(crate) fn report(
    kind: &dyn Kind,
    candidate: &mut Candidate,
    inflation: f64,
    with_intervals: bool,
) -> Told {
    let (fit, cause) = (&candidate.fit, candidate.cause);
    let parameters = &kind.causes()[cause].parameters;
    let known = Tangent::new(kind, fit, false).map(|t| t.known(kind));
    let offset: usize = fit
        .causes
        .iter()
        .take_while(|c| **c != cause)
        .map(|c| kind.causes()[*c].parameters.len())
        .sum();
    let n = parameters.len();
    let covariance = known.as_ref().map_or_else(
        || DMatrix::from_element(n, n, f64::NAN),
        |k| k.covariance.view((offset, offset), (n, n)).into_owned() * inflation,
    );
    let values = fit.terms.of(cause).to_vec();
    let reported = kind.causes()[cause].report(&values);
    let slopes: Vec<Vec<f64>> = (0..n)
        .map(|p| {
            let mut moved = values.clone();
            let step = 1e-4 * parameters[p].scale;
            moved[p] += step;
            let there = kind.causes()[cause].report(&moved);
            reported
                .iter()
                .zip(&there)
                .map(|(a, b)| (b.1 - a.1) / step * parameters[p].scale)
                .collect()
        })
        .collect();
    // The parameter of the fit that a reported one depends on, where it is one.
    let only = |k: usize| {
        let mut by = (0..n).filter(|&p| slopes[p][k] != 0.0);
        by.next().filter(|_| by.next().is_none())
    };
    let ends = match &known {
        Some(known) if with_intervals => {
            let profile = Profile {
                kind,
                fit,
                known,
                inflation,
            };
            parallel::map(2 * reported.len(), |k| {
                let parameter = only(k / 2)?;
                Some(profile.end(cause, parameter, k % 2 == 1))
            })
        }
        _ => vec![None; 2 * reported.len()],
    };
    let opens: Vec<bool> = (0..reported.len())
        .filter_map(|k| {
            let p = only(k).filter(|p| values[*p] != parameters[*p].neutral)?;
            let at = |end: &Option<Terms>| end.as_ref().map(|terms| terms.get(cause, p));
            Some(match (&ends[2 * k], &ends[2 * k + 1]) {
                (Some(low), Some(high)) => {
                    is_unlimited(&parameters[p], values[p], [at(low), at(high)])
                }
                _ => false,
            })
        })
        .collect();
    let is_open = !opens.is_empty() && opens.iter().all(|open| *open);
    candidate.reported = reported
        .into_iter()
        .enumerate()
        .map(|(k, (name, value))| {
            let mut variance = 0.0;
            for i in 0..n {
                for j in 0..n {
                    variance += slopes[i][k] * slopes[j][k] * covariance[(i, j)];
                }
            }
            let at = |end: &Option<Terms>| {
                Some(kind.causes()[cause].report(end.as_ref()?.of(cause))[k].1)
            };
            let interval = match (&ends[2 * k], &ends[2 * k + 1]) {
                // What is reported may grow as the parameter of the fit falls.
                (Some(a), Some(b)) if slopes.iter().any(|by| by[k] < 0.0) => Some(Interval {
                    low: at(b),
                    high: at(a),
                }),
                (Some(a), Some(b)) => Some(Interval {
                    low: at(a),
                    high: at(b),
                }),
                _ => None,
            };
            // One that rests where it does nothing has none.
            let error = if variance > 0.0 && variance.is_finite() {
                variance.sqrt()
            } else {
                f64::NAN
            };
            Reported {
                name,
                value,
                error,
                interval,
            }
        })
        .collect();
    let undetermined = known
        .and_then(|k| (k.least < 1e-6 && n > 1).then(|| k.direction[offset..offset + n].to_vec()));
    Told {
        undetermined,
        is_open,
    }
}
