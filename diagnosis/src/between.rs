//! How far what is estimated moves when a run is left out.
//!
//! Standard errors from the residuals of a fit allow for noise, its correlation, and an error of
//! the model that is alike in all readings. They do not where the model is off in another way in
//! each run: then the runs ask for different parameters, and the parameters of all runs together
//! are a compromise that more readings do not improve. The jackknife shows this: each run in turn is left out, and the parameters scatter by
//! what the runs disagree about. It is taken with the derivatives at the fit, a step of Gauss and
//! Newton for each run, which costs no prediction of the model.
//!
//! Source: Efron and Stein, The jackknife estimate of variance, 1981; MacKinnon, Nielsen and Webb,
//! Fast and reliable jackknife and bootstrap methods for cluster-robust inference, 2023.

use nalgebra::{DMatrix, DVector};

use crate::identifiability::Identifiability;
use crate::statistics::{chi_square, student};

/// How often chance alone makes the runs disagree as much.
const CHANCE: f64 = 0.05;
/// Without a run that holds more than all but this part of the information on a parameter, the rest
/// does not tell the parameter.
const LEAST_LEFT: f64 = 0.01;

/// How much each parameter scatters between runs.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Between {
    /// Variance of each parameter; 0 where the runs that are left do not tell it.
    variances: Vec<f64>,
    /// How many runs, or groups of them, were left out in turn.
    groups: usize,
}

impl Between {
    /// Of the information (n × n) that each group of runs has on `n` parameters, and its part of the
    /// derivative of half the loss.
    pub(crate) fn new(parts: &[(DMatrix<f64>, DVector<f64>)]) -> Between {
        let n = parts.first().map_or(0, |(of_one, _)| of_one.nrows());
        let mut variances = vec![0.0; n];
        if n > 0 && parts.len() > 1 {
            let zero = DMatrix::zeros(n, n);
            let all = parts.iter().fold(zero, |sum, (of_one, _)| sum + of_one);
            let known = covariance(&all);
            let share = (parts.len() - 1) as f64 / parts.len() as f64;
            for (of_one, score) in parts {
                let left = covariance(&(&all - of_one));
                let moved = &left * score;
                for (i, variance) in variances.iter_mut().enumerate() {
                    *variance += share * moved[i] * moved[i];
                    let rest = known[(i, i)] / left[(i, i)];
                    if rest.is_nan() || rest <= LEAST_LEFT {
                        *variance = f64::NAN;
                    }
                }
            }
        }
        for variance in variances.iter_mut().filter(|v| !v.is_finite()) {
            *variance = 0.0;
        }
        Between {
            variances,
            groups: parts.len(),
        }
    }

    /// How far parameter `i` scatters between runs, where its variance by the readings is `variance`;
    /// none where that is no more than chance makes it in 95 % of cases.
    pub(crate) fn wider(&self, i: usize, variance: f64) -> Option<Wider> {
        let degrees = self.groups.saturating_sub(1);
        let own = *self.variances.get(i)?;
        let chance = chi_square(degrees, 1.0 - CHANCE) / degrees as f64;
        (degrees > 0 && variance > 0.0 && own / variance > chance.max(1.0)).then(|| Wider {
            deviation: own.sqrt(),
            half: student(degrees) * own.sqrt(),
        })
    }
}

/// How far a parameter scatters between runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Wider {
    /// One standard error.
    pub(crate) deviation: f64,
    /// Half of its 95 % interval: of few runs more than two errors, by Student's t.
    pub(crate) half: f64,
}

/// Covariance of parameters by what is identifiable of an information matrix.
fn covariance(information: &DMatrix<f64>) -> DMatrix<f64> {
    let found = Identifiability::new(information);
    found.covariance(|k| found.is_identifiable(k))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs whose readings of one number have these means; each with ten readings of unit noise.
    fn of_means(means: &[f64]) -> Between {
        let all = means.iter().sum::<f64>() / means.len() as f64;
        let part = |mean: &f64| {
            (
                DMatrix::from_element(1, 1, 10.0),
                DVector::from_element(1, 10.0 * (mean - all)),
            )
        };
        Between::new(&means.iter().map(part).collect::<Vec<_>>())
    }

    /// The jackknife of a mean is the textbook's standard error from the scatter of what is averaged.
    #[test]
    fn of_a_mean_it_is_the_scatter_of_the_runs() {
        let means: [f64; 5] = [1.0, 2.0, 4.0, 4.0, 9.0];
        let scatter = means.iter().map(|x| (x - 4.0).powi(2)).sum::<f64>() / 4.0 / 5.0;
        let found = of_means(&means);
        assert!((found.variances[0] - scatter).abs() < 1e-12 * scatter);
        let noise = 1.0 / 50.0;
        let wider = found.wider(0, noise).expect("no chance");
        assert!((wider.deviation - scatter.sqrt()).abs() < 1e-12);
        // t of four degrees, from its table.
        assert!((wider.half / wider.deviation - 2.776_445).abs() < 1e-5);
    }

    #[test]
    fn runs_that_agree_as_chance_has_it_change_nothing() {
        // χ² of two degrees: 5.99 at 5 %.
        let noise = 1.0 / 30.0;
        let with_square = |square: f64| {
            let off = (square / 20.0).sqrt();
            of_means(&[-off, 0.0, off]).wider(0, noise)
        };
        assert_eq!(with_square(5.9), None);
        let wider = with_square(6.1).expect("more than chance");
        assert!((wider.deviation.powi(2) / noise - 3.05).abs() < 1e-9);
        assert_eq!(of_means(&[3.0]).wider(0, noise), None);
    }

    /// What one run alone tells cannot be told without it.
    #[test]
    fn what_one_run_tells_alone_is_not_judged() {
        let part = |of_second: f64, score: f64| {
            (
                DMatrix::from_row_slice(2, 2, &[10.0, 0.0, 0.0, of_second]),
                DVector::from_vec(vec![score, 0.0]),
            )
        };
        let found = Between::new(&[part(10.0, 30.0), part(0.0, -30.0), part(0.0, 0.0)]);
        assert_eq!(found.wider(1, 1e-9), None);
        assert!(found.wider(0, 0.1).is_some());
    }
}
