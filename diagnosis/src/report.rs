//! What is reported of a cause's parameters: values in the units of a robot file, standard errors,
//! intervals.

use nalgebra::DMatrix;
use saltus_numeric::parallel;

use crate::between::Wider;
use crate::finding::{Candidate, Reported};
use crate::fit::{self, parameters_of};
use crate::identifiability::LEAST;
use crate::kind::{Cause, Kind, Parameter, Terms};
use crate::profile::{Interval, NORMAL, Profile};
use crate::tangent::Tangent;

/// A parameter is unlimited if its bound is farther than so many times the least that explains the data.
const UNLIMITED: f64 = 2.0;

/// What the data do not tell of a cause.
pub(crate) struct NotTold {
    /// A direction of its parameters that is not identifiable, if there is one.
    pub(crate) undetermined: Option<Vec<f64>>,
    /// Whether nothing limits how strong it is; false without intervals.
    pub(crate) is_unlimited: bool,
}

/// Fills in what is reported of a candidate's cause; intervals take a profile of the likelihood for
/// each end. `bias` is by how much each parameter may be off (its scales) besides.
pub(crate) fn report(
    kind: &dyn Kind,
    candidate: &mut Candidate,
    bias: &[f64],
    with_intervals: bool,
) -> NotTold {
    let (fit, cause) = (&candidate.fit, candidate.cause);
    let known = Tangent::new(kind, fit).map(|t| t.known(kind, fit));
    let places = parameters_of(kind, &fit.causes);
    let offset = places.iter().take_while(|place| place.0 != cause).count();
    let spec = &kind.causes()[cause];
    let n = spec.parameters.len();
    let law = Law::new(spec, fit.terms.of(cause));
    let slopes = with_intervals.then(|| fit::slopes(kind, fit)).flatten();
    let ends = match known.as_ref().zip(slopes.as_ref()) {
        Some((known, slopes)) => {
            let profile = Profile {
                kind,
                fit,
                known,
                slopes,
            };
            law.ends(cause, &profile)
        }
        None => vec![None; law.reported.len()],
    };
    let between: Vec<Option<Wider>> = (offset..offset + n)
        .map(|i| known.as_ref().and_then(|known| known.wider(i)))
        .collect();
    let biased = |p: usize| {
        let deviation = bias.get(p).copied().filter(|x| *x > 0.0 && x.is_finite());
        deviation.map(|deviation| Wider {
            deviation,
            half: NORMAL * deviation,
        })
    };
    let wider: Vec<Option<Wider>> = (0..n)
        .map(|p| match (between[p], biased(p)) {
            (Some(a), Some(b)) => Some(Wider {
                deviation: a.deviation.max(b.deviation),
                half: a.half.max(b.half),
            }),
            (a, b) => a.or(b),
        })
        .collect();
    let covariance = known.as_ref().map_or_else(
        || DMatrix::from_element(n, n, f64::NAN),
        |known| {
            let of_readings = known.covariance.view((offset, offset), (n, n));
            let factor = |i: usize| {
                let own = known.inflation(offset + i).sqrt();
                let wide = wider[i].map(|w| w.deviation / of_readings[(i, i)].sqrt());
                wide.filter(|x| x.is_finite())
                    .map_or(own, |wide| own.max(wide))
            };
            DMatrix::from_fn(n, n, |i, j| of_readings[(i, j)] * factor(i) * factor(j))
        },
    );
    let of = |(k, ends): (usize, &Option<Ends>)| {
        let mut reported = Reported {
            name: law.reported[k].0.clone(),
            value: law.reported[k].1,
            error: law.error(k, &covariance),
            interval: ends.as_ref().map(|ends| {
                let ends = law.widened((cause, k), ends.clone(), &wider);
                law.interval(cause, k, &ends)
            }),
            runs_disagree: (0..n).any(|p| law.slopes[p][k] != 0.0 && between[p].is_some()),
        };
        let by_profile = by_profile(&reported);
        if let Some(error) = by_profile {
            reported.error = error;
        }
        (reported, by_profile.is_some())
    };
    let is_unlimited = law.is_unlimited(cause, &ends);
    let told: Vec<(Reported, bool)> = ends.iter().enumerate().map(of).collect();
    let undetermined = known.as_ref().and_then(|k| {
        let is_vague = k.least < LEAST && n > 1 && !told.iter().all(|told| told.1);
        is_vague.then(|| k.direction[offset..offset + n].to_vec())
    });
    candidate.reported = told.into_iter().map(|told| told.0).collect();
    NotTold {
        undetermined,
        is_unlimited,
    }
}

/// The standard error that the interval of a parameter tells, where derivatives tell far less: a direction
/// in which the data change with the square of the parameter alone.
fn by_profile(reported: &Reported) -> Option<f64> {
    /// Ratio of the two.
    const LESS: f64 = 3.0;
    let interval = reported.interval.as_ref()?;
    let ends = [interval.low, interval.high].into_iter().flatten();
    let farthest = ends
        .map(|end| (end - reported.value).abs())
        .reduce(f64::max)?;
    let error = farthest / NORMAL;
    (error > 0.0 && reported.error > LESS * error).then_some(error)
}

/// Lower and upper end of a profile; each is none where nothing limits the parameter.
type Ends = [Option<Terms>; 2];

/// How what is reported of a cause depends on the parameters of the fit.
struct Law<'a> {
    cause: &'a Cause,
    values: &'a [f64],
    /// Name and value of each reported parameter.
    reported: Vec<(String, f64)>,
    /// For each parameter of the fit, the change of each reported one for one of its scale.
    slopes: Vec<Vec<f64>>,
}

impl<'a> Law<'a> {
    fn new(cause: &'a Cause, values: &'a [f64]) -> Law<'a> {
        /// Step of a difference quotient, in terms of a parameter's scale.
        const STEP: f64 = 1e-4;
        let reported = cause.report(values);
        let slope = |(p, parameter): (usize, &Parameter)| {
            let mut moved = values.to_vec();
            let step = STEP * parameter.scale;
            moved[p] += step;
            let there = cause.report(&moved);
            let pairs = reported.iter().zip(&there);
            pairs
                .map(|(a, b)| (b.1 - a.1) / step * parameter.scale)
                .collect()
        };
        Law {
            slopes: cause.parameters.iter().enumerate().map(slope).collect(),
            cause,
            values,
            reported,
        }
    }

    /// The parameter of the fit that reported one `k` depends on, where it is one.
    fn only(&self, k: usize) -> Option<usize> {
        let mut by = (0..self.slopes.len()).filter(|&p| self.slopes[p][k] != 0.0);
        by.next().filter(|_| by.next().is_none())
    }

    /// Ends of the profile of each reported parameter; none of one that depends on several of the
    /// fit.
    fn ends(&self, cause: usize, profile: &Profile) -> Vec<Option<Ends>> {
        let ends = parallel::map(2 * self.reported.len(), |k| {
            let parameter = self.only(k / 2)?;
            Some(profile.end(cause, parameter, k % 2 == 1))
        });
        let both = |pair: &[Option<Option<Terms>>]| Some([pair[0].clone()?, pair[1].clone()?]);
        ends.chunks(2).map(both).collect()
    }

    /// The ends of reported parameter `k` of a cause, as far from it at least as it scatters between
    /// runs.
    fn widened(&self, (cause, k): (usize, usize), ends: Ends, wider: &[Option<Wider>]) -> Ends {
        let Some((p, wider)) = self.only(k).and_then(|p| Some((p, wider[p]?))) else {
            return ends;
        };
        let parameter = &self.cause.parameters[p];
        let half = wider.half * parameter.scale;
        let [low, high] = ends;
        let moved = |end: Option<Terms>, at: f64, is_within: bool| {
            let mut end = end.filter(|_| is_within)?;
            let now = end.get(cause, p);
            let is_further = (at - self.values[p]).abs() > (now - self.values[p]).abs();
            end.set(cause, p, if is_further { at } else { now });
            Some(end)
        };
        let (below, above) = (self.values[p] - half, self.values[p] + half);
        [
            moved(low, below, below > parameter.bounds.0),
            moved(high, above, above < parameter.bounds.1),
        ]
    }

    /// Standard error of reported parameter `k`; not a number where it rests at a bound at which it
    /// does nothing.
    fn error(&self, k: usize, covariance: &DMatrix<f64>) -> f64 {
        let mut variance = 0.0;
        for i in 0..self.slopes.len() {
            for j in 0..self.slopes.len() {
                variance += self.slopes[i][k] * self.slopes[j][k] * covariance[(i, j)];
            }
        }
        if variance > 0.0 && variance.is_finite() {
            variance.sqrt()
        } else {
            f64::NAN
        }
    }

    /// Interval of reported parameter `k`.
    fn interval(&self, cause: usize, k: usize, [below, above]: &Ends) -> Interval {
        let at = |end: &Option<Terms>| Some(self.cause.report(end.as_ref()?.of(cause))[k].1);
        // What is reported may grow as the parameter of the fit falls.
        let falls = self.slopes.iter().any(|by| by[k] < 0.0);
        let (low, high) = if falls {
            (above, below)
        } else {
            (below, above)
        };
        Interval {
            low: at(low),
            high: at(high),
        }
    }

    /// Whether nothing limits any of the reported parameters that are not neutral.
    fn is_unlimited(&self, cause: usize, ends: &[Option<Ends>]) -> bool {
        let of = |(k, ends): (usize, &Option<Ends>)| {
            let spec = &self.cause.parameters;
            let p = self
                .only(k)
                .filter(|p| self.values[*p] != spec[*p].neutral)?;
            let at = |end: &Option<Terms>| end.as_ref().map(|terms| terms.get(cause, p));
            Some(ends.as_ref().is_some_and(|[low, high]| {
                is_unlimited(&spec[p], self.values[p], [at(low), at(high)])
            }))
        };
        let mut all = ends.iter().enumerate().filter_map(of).peekable();
        all.peek().is_some() && all.all(|is_unlimited| is_unlimited)
    }
}

/// Whether nothing limits a parameter, found to be `value`, on the side away from neutral: there
/// its interval with these ends is open, and physics allows far more than the least that explains
/// the data.
fn is_unlimited(parameter: &Parameter, value: f64, [low, high]: [Option<f64>; 2]) -> bool {
    let Parameter {
        neutral, bounds, ..
    } = parameter;
    let (inner, outer, bound) = if value > *neutral {
        (low, high, bounds.1)
    } else {
        (high, low, bounds.0)
    };
    let least = inner.map_or(0.0, |x| (x - neutral).abs());
    outer.is_none() && (bound - neutral).abs() > UNLIMITED * least
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::toy::{ALL, READINGS, RUNS, Toy, noise};

    /// What is reported of the mean of readings with these means of runs beside noise.
    fn mean_of(means: [f64; RUNS], least: f64) -> Reported {
        let noise = noise(4);
        let values: Vec<f64> = (0..ALL).map(|k| noise[k] + means[k / READINGS]).collect();
        let toy = Toy::new(&values, vec![vec![1.0; ALL]])
            .with(0, |cause| cause.parameters[0].bounds.0 = least);
        let mut candidate = Candidate::new(&toy, 0, &toy.before(), toy.fitted(&[0]));
        report(&toy, &mut candidate, &[], true);
        candidate.reported.remove(0)
    }

    #[test]
    fn where_runs_agree_noise_alone_counts() {
        let found = mean_of([5.0; RUNS], -1e6);
        assert!(!found.runs_disagree);
        let error = 1.0 / (ALL as f64).sqrt();
        assert!((found.error / error - 1.0).abs() < 1e-6, "{found:?}");
        let high = found.interval.and_then(|i| i.high).expect("an end");
        assert!(
            (high - found.value - 1.96 * error).abs() < 0.01 * error,
            "{found:?}"
        );
    }

    /// The mean of eight runs is as uncertain as their scatter, √(Σ (m − m̄)² / 7 / 8), and an end
    /// beyond what is possible is none.
    #[test]
    fn where_runs_disagree_their_scatter_counts() {
        let means = [2.0, 8.0, 5.0, 5.0, 1.0, 9.0, 4.0, 6.0].map(|mean| 0.25 * (mean - 3.5));
        let scatter = 0.25 * f64::sqrt(52.0 / 7.0 / 8.0);
        let found = mean_of(means, 0.0);
        assert!(found.runs_disagree);
        assert!((found.error / scatter - 1.0).abs() < 0.05, "{found:?}");
        let interval = found.interval.expect("an interval");
        // Student's t of seven degrees: 2.365.
        let high = found.value + 2.365 * found.error;
        assert!(interval.low.is_none(), "{found:?}");
        assert!(
            (interval.high.expect("an end") - high).abs() < 0.01 * scatter,
            "{found:?}"
        );
    }
}
