//! How far what is estimated moves when a run is left out.
//!
//! Standard errors from the residuals of a fit allow for noise, its correlation, and an error of
//! the model that is alike in all readings. They do not where the model is off in another way in
//! each run: then the runs ask for different parameters, and the parameters of all runs together
//! are a compromise that more readings do not improve. Cochran's test says whether the runs disagree
//! more than chance has it. If so, the jackknife says how far the parameters scatter: each run in
//! turn is left out. Both are taken with the derivatives at the fit, and cost no prediction of the
//! model.
//!
//! Source: Cochran, The combination of estimates from different experiments, 1954; Efron and Stein,
//! The jackknife estimate of variance, 1981.

use nalgebra::{DMatrix, DVector};

use crate::identifiability::Identifiability;
use crate::statistics::{chi_square, student};

/// How often chance alone makes the runs disagree as much.
const CHANCE: f64 = 0.05;

/// What a run, or a group of runs that belong together, says of the parameters.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    /// Its information (n × n).
    pub(crate) information: DMatrix<f64>,
    /// Its part of the derivative of half the loss.
    pub(crate) score: DVector<f64>,
}

/// How much each parameter scatters between runs.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Between {
    /// Variance of each parameter.
    variances: Vec<f64>,
    /// Cochran's sum, and how many degrees of freedom it has.
    disagreement: (f64, usize),
    /// How many runs, or groups of them, were left out in turn.
    groups: usize,
}

impl Between {
    /// Of the parts of all runs, where each parameter may move down and up by so much.
    pub(crate) fn new(parts: &[Part], ranges: &[(f64, f64)]) -> Between {
        let n = ranges.len();
        let mut variances = vec![0.0; n];
        let (mut sum, mut told) = (0.0, 0);
        let zero = DMatrix::zeros(n, n);
        let all = parts.iter().fold(zero, |sum, part| sum + &part.information);
        let share = (parts.len().saturating_sub(1)) as f64 / parts.len().max(1) as f64;
        for part in parts.iter().filter(|_| n > 0) {
            let own = known(&part.information);
            sum += part.score.dot(&(&own.0 * &part.score));
            told += own.1;
            let moved = known(&(&all - &part.information)).0 * &part.score;
            for ((variance, moved), range) in variances.iter_mut().zip(&moved).zip(ranges) {
                *variance += share * (-moved).clamp(range.0, range.1).powi(2);
            }
        }
        for variance in variances.iter_mut().filter(|v| !v.is_finite()) {
            *variance = 0.0;
        }
        Between {
            variances,
            disagreement: (sum, told.saturating_sub(n)),
            groups: parts.len(),
        }
    }

    /// How far parameter `i` scatters between runs, where its variance by the readings is `variance`.
    /// None where that is less, and where the runs disagree no more than chance makes them in 95 % of
    /// cases, if residuals weigh `inflation` times as much as white noise.
    pub(crate) fn wider(&self, i: usize, variance: f64, inflation: f64) -> Option<Wider> {
        let (sum, degrees) = self.disagreement;
        let own = *self.variances.get(i)?;
        let disagrees = degrees > 0 && sum > inflation * chi_square(degrees, 1.0 - CHANCE);
        (disagrees && variance > 0.0 && own > variance).then(|| Wider {
            deviation: own.sqrt(),
            half: student(self.groups - 1) * own.sqrt(),
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

/// Covariance of parameters by what is identifiable of an information matrix, and how many directions
/// are.
fn known(information: &DMatrix<f64>) -> (DMatrix<f64>, usize) {
    let found = Identifiability::new(information);
    let is_known = |k: usize| found.is_identifiable(k);
    let count = (0..information.nrows()).filter(|k| is_known(*k)).count();
    (found.covariance(is_known), count)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FREE: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

    fn part(information: &[f64], score: &[f64]) -> Part {
        let n = score.len();
        Part {
            information: DMatrix::from_row_slice(n, n, information),
            score: DVector::from_row_slice(score),
        }
    }

    /// Runs whose readings of one number have these means; each with so many readings of unit noise.
    fn of_means(means: &[(f64, f64)], range: (f64, f64)) -> Between {
        let all = means.iter().map(|(mean, n)| mean * n).sum::<f64>();
        let all = all / means.iter().map(|(_, n)| n).sum::<f64>();
        let part = |(mean, n): &(f64, f64)| part(&[*n], &[n * (mean - all)]);
        Between::new(&means.iter().map(part).collect::<Vec<_>>(), &[range])
    }

    /// The jackknife of a mean is the textbook's standard error from the scatter of what is averaged.
    #[test]
    fn of_a_mean_it_is_the_scatter_of_the_runs() {
        let means = [1.0, 2.0, 4.0, 4.0, 9.0].map(|mean| (mean, 10.0));
        let scatter = means
            .iter()
            .map(|x: &(f64, f64)| (x.0 - 4.0).powi(2))
            .sum::<f64>()
            / 4.0
            / 5.0;
        let found = of_means(&means, FREE);
        assert!((found.variances[0] - scatter).abs() < 1e-12 * scatter);
        let wider = found.wider(0, 1.0 / 50.0, 1.0).expect("no chance");
        assert!((wider.deviation - scatter.sqrt()).abs() < 1e-12);
        // t of four degrees, from its table.
        assert!((wider.half / wider.deviation - 2.776_445).abs() < 1e-5);
    }

    #[test]
    fn runs_that_agree_as_chance_has_it_change_nothing() {
        // χ² of two degrees: 5.99 at 5 %.
        let noise = 1.0 / 30.0;
        let with_square = |square: f64, inflation: f64| {
            let off = (square / 20.0).sqrt();
            let means = [-off, 0.0, off].map(|mean| (mean, 10.0));
            of_means(&means, FREE).wider(0, noise, inflation)
        };
        assert_eq!(with_square(5.9, 1.0), None);
        let wider = with_square(6.1, 1.0).expect("more than chance");
        assert!((wider.deviation.powi(2) / noise - 3.05).abs() < 1e-9);
        assert_eq!(with_square(6.1, 1.1), None);
        assert_eq!(of_means(&[(3.0, 10.0)], FREE).wider(0, noise, 1.0), None);
    }

    /// One run has nearly all readings: the mean of the others is far from its own by chance alone.
    #[test]
    fn a_run_with_nearly_all_readings_does_not_disagree_by_chance() {
        let means = |off: f64| [(0.0, 1000.0), (off, 1.0), (0.0, 1.0)];
        let found = |off: f64| of_means(&means(off), FREE).wider(0, 1e-3, 1.0);
        assert_eq!(found(2.0), None);
        assert!(found(3.0).is_some());
    }

    #[test]
    fn a_run_left_out_moves_nothing_out_of_its_range() {
        let means = [1.0, 2.0, 4.0, 4.0, 9.0].map(|mean| (mean, 10.0));
        let found = of_means(&means, (-1.0, 0.5));
        // Without them the mean of 4 moves by 0.75, 0.5, 0, 0 and −1.25.
        let known = 0.8 * (0.25 + 0.25 + 1.0);
        assert!((found.variances[0] - known).abs() < 1e-12, "{found:?}");
    }

    /// What one run alone tells cannot be told without it.
    #[test]
    fn what_one_run_tells_alone_is_not_judged() {
        let parts = [
            part(&[10.0, 0.0, 0.0, 10.0], &[30.0, 0.0]),
            part(&[10.0, 0.0, 0.0, 0.0], &[-30.0, 0.0]),
            part(&[10.0, 0.0, 0.0, 0.0], &[0.0, 0.0]),
        ];
        let found = Between::new(&parts, &[FREE; 2]);
        assert_eq!(found.wider(1, 1e-9, 1.0), None);
        assert!(found.wider(0, 0.1, 1.0).is_some());
        assert_eq!(found.disagreement, (180.0, 2));
    }
}
