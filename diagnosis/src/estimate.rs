//! Chosen parameters from data, all at once: values, standard errors, and what the data do not
//! tell.

use nalgebra::{DMatrix, DVector};

use crate::fit::{self, Fit};
use crate::identifiability::Identifiability;
use crate::kind::{Kind, Parameter};
use crate::series::inflation;
use crate::tangent::Tangent;

/// Parameters fitted at the same time.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// The model as it is.
    pub before: Fit,
    /// The model with the parameters fitted.
    pub after: Fit,
    /// The parameters, in the order of the causes.
    pub parameters: Vec<Estimated>,
    /// Correlation of their errors; where the data do not tell a parameter, 0 beside its own 1.
    pub correlation: Vec<Vec<f64>>,
    /// Directions of the parameters that the data do not tell.
    pub undetermined: Vec<Undetermined>,
    /// What is left of each channel.
    pub residuals: Vec<Residual>,
    /// By how much more than white noise of the stated size the residuals weigh, ≥ 1: variances are
    /// larger by as much.
    pub inflation: f64,
}

/// A parameter that was fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimated {
    /// Its name, which ends with its unit.
    pub name: String,
    /// What it is in the model as it is.
    pub believed: f64,
    /// What the data say.
    pub value: f64,
    /// One standard error; none where the data do not tell it.
    pub error: Option<f64>,
    /// Whether it is the least or the greatest that physics allows.
    pub is_at_bound: bool,
}

/// A direction that the data do not tell.
#[derive(Clone, Debug, PartialEq)]
pub struct Undetermined {
    /// Indices of the parameters that change together without showing, each with its part: relative
    /// to its value, or to its scale where it is 0.
    pub parts: Vec<(usize, f64)>,
    /// What is known of them nevertheless, where they are two.
    pub known: Option<Combination>,
}

/// A product of powers of parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Combination {
    /// Indices of the parameters, with their exponents; the first is 1.
    pub exponents: Vec<(usize, f64)>,
    /// Its value.
    pub value: f64,
    /// One standard error.
    pub error: f64,
}

/// Root mean square of what a channel's readings differ from the model (the channel's unit).
#[derive(Clone, Debug, PartialEq)]
pub struct Residual {
    /// Name of the channel.
    pub channel: String,
    /// With the model as it is.
    pub before: f64,
    /// With the parameters fitted.
    pub after: f64,
    /// One standard deviation of its noise.
    pub noise: f64,
}

/// Loss for each reading above which a fit is tried from other starts.
const POOR: f64 = 1.5;
/// Square of a parameter's part in a unit direction below which it has no part.
const NO_PART: f64 = 0.01;
/// Most steps of a fit.
const STEPS: usize = 60;
/// Exponents this near to a whole number are whole.
const WHOLE: f64 = 0.03;

/// Fits every parameter of `causes`; none where the model has no answer.
pub fn estimate(kind: &dyn Kind, causes: &[usize]) -> Option<Estimate> {
    let runs: Vec<usize> = (0..kind.logs().len()).collect();
    let before = fit::fit_none(kind, &runs)?;
    let after = fitted(kind, &before, causes, &runs)?;
    let places: Vec<(usize, usize)> = causes
        .iter()
        .flat_map(|&c| (0..kind.causes()[c].parameters.len()).map(move |p| (c, p)))
        .collect();
    let specs: Vec<&Parameter> = places
        .iter()
        .map(|&(c, p)| &kind.causes()[c].parameters[p])
        .collect();
    let values: Vec<f64> = places.iter().map(|&(c, p)| after.terms.get(c, p)).collect();
    let inflation = inflation(kind, &after);
    let tangent = Tangent::new(kind, &after)?;
    let known = Uncertainty::new(&tangent.information(), &specs, &values, inflation);
    let parameters = specs
        .iter()
        .zip(&values)
        .enumerate()
        .map(|(i, (spec, &value))| Estimated {
            name: spec.name.clone(),
            believed: spec.neutral,
            value,
            error: known.error(i),
            is_at_bound: value <= spec.bounds.0 || value >= spec.bounds.1,
        });
    Some(Estimate {
        parameters: parameters.collect(),
        correlation: known.correlation(),
        undetermined: known.undetermined(&values),
        residuals: residuals(kind, &before, &after)?,
        inflation,
        before,
        after,
    })
}

/// The fit from where the model is, and where that is poor from every start of every parameter.
fn fitted(kind: &dyn Kind, before: &Fit, causes: &[usize], runs: &[usize]) -> Option<Fit> {
    let mut first = Fit {
        causes: causes.to_vec(),
        ..before.clone()
    };
    for &cause in causes {
        for (p, spec) in kind.causes()[cause].parameters.iter().enumerate() {
            if spec.neutral < spec.bounds.0 || spec.neutral > spec.bounds.1 {
                first
                    .terms
                    .set(cause, p, *spec.starts.first().unwrap_or(&spec.bounds.0));
            }
        }
    }
    let mut best = again(kind, first.clone(), runs);
    let readings: usize = kind.logs().iter().map(|log| log.readings.len()).sum();
    for &cause in causes {
        for (p, spec) in kind.causes()[cause].parameters.iter().enumerate() {
            for &start in &spec.starts {
                if best
                    .as_ref()
                    .is_some_and(|fit| fit.loss < POOR * readings as f64)
                {
                    return best;
                }
                let mut from = first.clone();
                from.terms.set(cause, p, start);
                let Some(there) = again(kind, from, runs) else {
                    continue;
                };
                if best.as_ref().is_none_or(|fit| there.loss < fit.loss) {
                    best = Some(there);
                }
            }
        }
    }
    best
}

/// A fit that is started again where it ends, until that changes nothing.
fn again(kind: &dyn Kind, from: Fit, runs: &[usize]) -> Option<Fit> {
    let mut fit = fit::refit(kind, from, runs, &None, STEPS)?;
    for _ in 0..5 {
        let next = fit::refit(kind, fit.clone(), runs, &None, STEPS)?;
        let fall = fit.loss - next.loss;
        fit = next;
        if fall < 1e-3 {
            break;
        }
    }
    Some(fit)
}

fn residuals(kind: &dyn Kind, before: &Fit, after: &Fit) -> Option<Vec<Residual>> {
    let rms = |fit: &Fit| -> Option<Vec<f64>> {
        let mut sums = vec![(0.0, 0.0); kind.channels().len()];
        for (run, log) in kind.logs().iter().enumerate() {
            let values = kind.predict(run, &fit.terms, &fit.unknowns[run])?;
            for (reading, value) in log.readings.iter().zip(values) {
                let sum: &mut (f64, f64) = &mut sums[reading.channel];
                sum.0 += (reading.value - value).powi(2);
                sum.1 += 1.0;
            }
        }
        Some(
            sums.into_iter()
                .map(|(sum, n)| (sum / f64::max(n, 1.0)).sqrt())
                .collect(),
        )
    };
    let of_each = kind
        .channels()
        .iter()
        .zip(rms(before)?.into_iter().zip(rms(after)?));
    let residual = |(channel, (before, after)): (&crate::kind::Channel, (f64, f64))| Residual {
        channel: channel.name.clone(),
        before,
        after,
        noise: channel.noise,
    };
    Some(of_each.map(residual).collect())
}

/// How surely parameters are known, in terms of relative changes.
struct Uncertainty {
    /// One unit of each parameter: its value, or its scale where that is 0.
    units: Vec<f64>,
    /// Square root of each parameter's own information.
    sizes: Vec<f64>,
    /// Unit directions, in terms of `sizes`, that are not identifiable.
    unidentified: Vec<DVector<f64>>,
    /// Covariance in units, of what is identifiable.
    covariance: DMatrix<f64>,
}

impl Uncertainty {
    fn new(
        information: &DMatrix<f64>,
        specs: &[&Parameter],
        values: &[f64],
        inflation: f64,
    ) -> Uncertainty {
        let n = values.len();
        let is_relative = |i: usize| values[i].abs() > specs[i].scale;
        let unit = |i: usize| {
            if is_relative(i) {
                values[i].abs()
            } else {
                specs[i].scale
            }
        };
        let units: Vec<f64> = (0..n).map(unit).collect();
        let in_units = DMatrix::from_fn(n, n, |i, j| {
            information[(i, j)] * units[i] / specs[i].scale * units[j] / specs[j].scale / inflation
        });
        let found = Identifiability::new(&in_units);
        let is_known = |k: usize| {
            let (part, v) = (found.information[k], found.direction(k));
            // A change by all of a parameter that is within one standard error.
            let is_vague =
                |i: usize| is_relative(i) && v[i].abs() > found.sizes[i] * part.max(1e-300).sqrt();
            found.is_identifiable(k) && !(0..n).any(|i| v[i] * v[i] > NO_PART && is_vague(i))
        };
        Uncertainty {
            units,
            unidentified: (0..n)
                .filter(|k| !is_known(*k))
                .map(|k| found.direction(k))
                .collect(),
            covariance: found.covariance(is_known),
            sizes: found.sizes,
        }
    }

    fn is_identifiable(&self, i: usize) -> bool {
        self.unidentified.iter().all(|v| v[i] * v[i] < NO_PART)
    }

    fn error(&self, i: usize) -> Option<f64> {
        self.is_identifiable(i)
            .then(|| self.units[i] * self.covariance[(i, i)].max(0.0).sqrt())
    }

    fn correlation(&self) -> Vec<Vec<f64>> {
        let n = self.units.len();
        let c = &self.covariance;
        let one =
            |i: usize, j: usize| match (i == j, self.is_identifiable(i) && self.is_identifiable(j))
            {
                (true, _) => 1.0,
                (false, true) => c[(i, j)] / (c[(i, i)] * c[(j, j)]).sqrt().max(1e-300),
                (false, false) => 0.0,
            };
        (0..n)
            .map(|i| (0..n).map(|j| one(i, j)).collect())
            .collect()
    }

    fn undetermined(&self, values: &[f64]) -> Vec<Undetermined> {
        let direction = |v: &DVector<f64>| {
            let involved: Vec<usize> = (0..v.len()).filter(|&i| v[i] * v[i] > NO_PART).collect();
            let changes: Vec<f64> = involved.iter().map(|&i| v[i] / self.sizes[i]).collect();
            let most = changes.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            let sign = changes.first().map_or(1.0, |x| x.signum());
            let parts = involved
                .iter()
                .zip(&changes)
                .map(|(&i, x)| (i, sign * x / most))
                .collect();
            Undetermined {
                parts,
                known: self.combination(&involved, &changes, values),
            }
        };
        self.unidentified.iter().map(direction).collect()
    }

    /// The product of two parameters' powers that stays as it is where they change by `changes`.
    fn combination(
        &self,
        involved: &[usize],
        changes: &[f64],
        values: &[f64],
    ) -> Option<Combination> {
        let (&[a, b], &[x, y]) = (involved, changes) else {
            return None;
        };
        let alone = |i: usize| {
            self.unidentified
                .iter()
                .filter(|v| v[i] * v[i] > NO_PART)
                .count()
                == 1
        };
        let is_product = [a, b]
            .iter()
            .all(|&i| values[i] > 0.0 && self.units[i] == values[i] && alone(i));
        if !is_product || y == 0.0 || x == 0.0 {
            return None;
        }
        let slope = -x / y;
        let exponent = if (slope - slope.round()).abs() < WHOLE {
            slope.round()
        } else {
            slope
        };
        if exponent == 0.0 {
            return None;
        }
        let c = &self.covariance;
        let variance = c[(a, a)] + 2.0 * exponent * c[(a, b)] + exponent * exponent * c[(b, b)];
        let value = values[a] * values[b].powf(exponent);
        Some(Combination {
            exponents: vec![(a, 1.0), (b, exponent)],
            value,
            error: value * variance.max(0.0).sqrt(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameter(name: &str) -> Parameter {
        Parameter {
            name: name.into(),
            neutral: 1.0,
            bounds: (0.0, 1e3),
            scale: 1e-2,
            starts: Vec::new(),
        }
    }

    /// Readings of a b² and of c: the product is known as well as its readings, and c alone.
    #[test]
    fn a_product_is_told_and_its_factors_are_not() {
        let specs = [parameter("a"), parameter("b"), parameter("c")];
        let specs: Vec<&Parameter> = specs.iter().collect();
        let values = [2.0, 3.0, 5.0];
        // Ten readings of ln(a b²) with an error of 0.1, and one of c with an error of 0.5.
        let rows = [[1.0 / 2.0, 2.0 / 3.0, 0.0], [0.0, 0.0, 1.0]];
        let weights = [10.0 / 0.01, 1.0 / 0.25];
        let information = DMatrix::from_fn(3, 3, |i, j| {
            let sum: f64 = rows.iter().zip(weights).map(|(r, w)| r[i] * r[j] * w).sum();
            sum * 1e-4
        });
        let known = Uncertainty::new(&information, &specs, &values, 1.0);
        assert_eq!((known.error(0), known.error(1)), (None, None));
        assert!(known.error(2).is_some_and(|e| (e - 0.5).abs() < 1e-9));
        let all = known.undetermined(&values);
        assert_eq!(all.len(), 1);
        let found = all[0].known.as_ref();
        assert!(
            found.is_some_and(
                |k| k.exponents == [(0, 1.0), (1, 2.0)] && (k.value - 18.0).abs() < 1e-12
            )
        );
        assert!(found.is_some_and(|k| (k.error / k.value - 0.1 / 10_f64.sqrt()).abs() < 1e-9));
    }
}
