//! Learners that need few starts: numbers of a law are tried, each in a run, and the next are chosen by what came of
//! those before.
//!
//! Sources: Jones, Schonlau and Welch, Efficient global optimization of expensive black-box functions (1998); Hansen, The
//! CMA evolution strategy: a tutorial (2016).

use nalgebra::{Cholesky, DMatrix, DVector, Dyn, SymmetricEigen};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

use crate::unit;

/// Something that proposes what to try next. Numbers are from 0 to 1 on each axis, and a greater score is better.
pub trait Learner {
    /// What to try.
    fn ask(&mut self) -> Vec<f64>;
    /// What came of it.
    fn tell(&mut self, tried: &[f64], score: f64);
    /// What it holds for the best.
    fn best(&self) -> Vec<f64>;
}

/// Lengths (of the unit cube) and noise (of the scores' standard deviation) that are compared.
const LENGTHS: [f64; 4] = [0.25, 0.5, 1.0, 2.0];
const NOISES: [f64; 3] = [0.01, 0.1, 0.3];
/// Tries before the first model.
const FIRST: usize = 5;
/// Points among which the next is chosen: anywhere, and near the best.
const ANYWHERE: usize = 1500;
const NEAR: usize = 500;
const NEAR_BY: f64 = 0.08;

/// Bayesian optimisation: a Gaussian process is laid through the scores, and the next try is where the improvement to be
/// expected is greatest.
#[derive(Clone, Debug)]
pub struct Bayes {
    axes: usize,
    start: Vec<f64>,
    tried: Vec<(Vec<f64>, f64)>,
    random: Pcg64,
}

impl Bayes {
    /// From `start`, with `seed`.
    pub fn new(start: Vec<f64>, seed: u64) -> Bayes {
        Bayes {
            axes: start.len(),
            start,
            tried: Vec::new(),
            random: Pcg64::new(u128::from(seed), 0xba1e5),
        }
    }

    fn anywhere(&mut self) -> Vec<f64> {
        (0..self.axes).map(|_| unit(&mut self.random)).collect()
    }

    fn near(&mut self, x: &[f64]) -> Vec<f64> {
        let step = |x: &f64| {
            let normal: f64 = StandardNormal.sample(&mut self.random);
            (x + NEAR_BY * normal).clamp(0.0, 1.0)
        };
        x.iter().map(step).collect()
    }

    /// The likeliest process.
    fn process(&self) -> Option<Process> {
        let settings = LENGTHS.iter().flat_map(|l| NOISES.map(|n| (*l, n)));
        let made = settings.filter_map(|(length, noise)| Process::new(&self.tried, length, noise));
        made.reduce(|best, other| {
            if other.likelihood > best.likelihood {
                other
            } else {
                best
            }
        })
    }
}

impl Learner for Bayes {
    fn ask(&mut self) -> Vec<f64> {
        if self.tried.is_empty() {
            return self.start.clone();
        }
        if self.tried.len() < FIRST {
            // About the start: a law that runs is worth more than a cube of laws that do not.
            let start = self.start.clone();
            let far = self.anywhere();
            return start
                .iter()
                .zip(far)
                .map(|(a, b)| 0.6 * a + 0.4 * b)
                .collect();
        }
        let Some(process) = self.process() else {
            return self.anywhere();
        };
        let best = self.best();
        let most = process.expected(&best).0;
        let mut chosen = (best.clone(), f64::NEG_INFINITY);
        for k in 0..ANYWHERE + NEAR {
            let x = if k < ANYWHERE {
                self.anywhere()
            } else {
                self.near(&best)
            };
            let gain = process.improvement(&x, most);
            if gain > chosen.1 {
                chosen = (x, gain);
            }
        }
        chosen.0
    }

    fn tell(&mut self, tried: &[f64], score: f64) {
        self.tried.push((tried.to_vec(), score));
    }

    /// Of what was tried, the one whose score is the greatest by the process, which knows of the noise.
    fn best(&self) -> Vec<f64> {
        let process = self.process();
        let worth =
            |(x, score): &(Vec<f64>, f64)| process.as_ref().map_or(*score, |it| it.expected(x).0);
        let best = self
            .tried
            .iter()
            .max_by(|a, b| worth(a).total_cmp(&worth(b)));
        best.map_or_else(|| self.start.clone(), |(x, _)| x.clone())
    }
}

/// A Gaussian process with the Matérn kernel of 5/2.
struct Process {
    tried: Vec<Vec<f64>>,
    length: f64,
    factor: Cholesky<f64, Dyn>,
    weights: DVector<f64>,
    mean: f64,
    scale: f64,
    likelihood: f64,
}

impl Process {
    fn new(tried: &[(Vec<f64>, f64)], length: f64, noise: f64) -> Option<Process> {
        let count = tried.len();
        let mean = tried.iter().map(|(_, y)| y).sum::<f64>() / count as f64;
        let variance = tried.iter().map(|(_, y)| (y - mean).powi(2)).sum::<f64>() / count as f64;
        let scale = variance.sqrt().max(1e-9);
        let y = DVector::from_iterator(count, tried.iter().map(|(_, y)| (y - mean) / scale));
        let mut kernel = DMatrix::from_fn(count, count, |i, j| {
            matern(&tried[i].0, &tried[j].0, length)
        });
        for k in 0..count {
            kernel[(k, k)] += noise * noise + 1e-9;
        }
        let factor = kernel.cholesky()?;
        let weights = factor.solve(&y);
        let logs: f64 = factor.l_dirty().diagonal().iter().map(|x| x.ln()).sum();
        Some(Process {
            likelihood: -0.5 * y.dot(&weights) - logs,
            tried: tried.iter().map(|(x, _)| x.clone()).collect(),
            length,
            factor,
            weights,
            mean,
            scale,
        })
    }

    /// Score and its standard deviation.
    fn expected(&self, x: &[f64]) -> (f64, f64) {
        let along = self.tried.iter().map(|it| matern(it, x, self.length));
        let k = DVector::from_iterator(self.tried.len(), along);
        let mean = k.dot(&self.weights);
        let variance = (1.0 - k.dot(&self.factor.solve(&k))).max(1e-12);
        (self.mean + self.scale * mean, self.scale * variance.sqrt())
    }

    /// How much more than `most` is to be expected.
    fn improvement(&self, x: &[f64], most: f64) -> f64 {
        let (mean, deviation) = self.expected(x);
        let z = (mean - most) / deviation;
        // Of the normal distribution: density, and an area to 1e-7 (Abramowitz and Stegun 26.2.17).
        let density = (-0.5 * z * z).exp() / (2.0 * std::f64::consts::PI).sqrt();
        let t = 1.0 / (1.0 + 0.231_641_9 * z.abs());
        let tail = density
            * t
            * (0.319_381_530
                + t * (-0.356_563_782
                    + t * (1.781_477_937 + t * (-1.821_255_978 + t * 1.330_274_429))));
        let area = if z > 0.0 { 1.0 - tail } else { tail };
        deviation * (z * area + density)
    }
}

fn matern(a: &[f64], b: &[f64], length: f64) -> f64 {
    let square: f64 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
    let r = (5.0 * square).sqrt() / length;
    (1.0 + r + r * r / 3.0) * (-r).exp()
}

/// The evolution strategy with adapted covariance.
#[derive(Clone, Debug)]
pub struct Evolution {
    mean: DVector<f64>,
    sigma: f64,
    covariance: DMatrix<f64>,
    path: DVector<f64>,
    step_path: DVector<f64>,
    generation: u32,
    told: Vec<(DVector<f64>, f64)>,
    random: Pcg64,
}

impl Evolution {
    /// From `start`, with steps of `sigma` and `seed`.
    pub fn new(start: Vec<f64>, sigma: f64, seed: u64) -> Evolution {
        let count = start.len();
        Evolution {
            mean: DVector::from_vec(start),
            sigma,
            covariance: DMatrix::identity(count, count),
            path: DVector::zeros(count),
            step_path: DVector::zeros(count),
            generation: 0,
            told: Vec::new(),
            random: Pcg64::new(u128::from(seed), 0xc3a),
        }
    }

    /// Tries in a generation.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    fn offspring(&self) -> usize {
        4 + (3.0 * (self.mean.len() as f64).ln()) as usize
    }

    /// Takes a generation in, in the letters of the tutorial.
    fn adapt(&mut self) {
        let n = self.mean.len() as f64;
        self.told.sort_by(|a, b| b.1.total_cmp(&a.1));
        let parents = self.told.len() / 2;
        let raw: Vec<f64> = (0..parents)
            .map(|k| (parents as f64 + 0.5).ln() - ((k + 1) as f64).ln())
            .collect();
        let sum: f64 = raw.iter().sum();
        let weights: Vec<f64> = raw.iter().map(|w| w / sum).collect();
        let effective = 1.0 / weights.iter().map(|w| w * w).sum::<f64>();
        let cs = (effective + 2.0) / (n + effective + 5.0);
        let damping = 1.0 + cs + 2.0 * (((effective - 1.0) / (n + 1.0)).sqrt() - 1.0).max(0.0);
        let cc = (4.0 + effective / n) / (n + 4.0 + 2.0 * effective / n);
        let c1 = 2.0 / ((n + 1.3).powi(2) + effective);
        let cmu = (2.0 * (effective - 2.0 + 1.0 / effective) / ((n + 2.0).powi(2) + effective))
            .min(1.0 - c1);
        let chi = n.sqrt() * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n));

        let before = self.mean.clone();
        let steps: Vec<DVector<f64>> = self
            .told
            .iter()
            .map(|(x, _)| (x - &before) / self.sigma)
            .collect();
        let step = weights
            .iter()
            .zip(&steps)
            .fold(DVector::zeros(before.len()), |sum, (w, y)| sum + *w * y);
        self.mean = &before + self.sigma * &step;
        let inverse_root = root(&self.covariance, -0.5);
        self.step_path = (1.0 - cs) * &self.step_path
            + (cs * (2.0 - cs) * effective).sqrt() * (inverse_root * &step);
        let exponent = 2.0 * (f64::from(self.generation) + 1.0);
        let grown = self.step_path.norm() / (1.0 - (1.0 - cs).powf(exponent)).sqrt();
        let goes = f64::from(u8::from(grown < (1.4 + 2.0 / (n + 1.0)) * chi));
        self.path = (1.0 - cc) * &self.path + goes * (cc * (2.0 - cc) * effective).sqrt() * &step;
        let kept = 1.0 - c1 - cmu + (1.0 - goes) * c1 * cc * (2.0 - cc);
        let mut covariance = kept * &self.covariance + c1 * &self.path * self.path.transpose();
        for (w, y) in weights.iter().zip(&steps) {
            covariance += cmu * *w * y * y.transpose();
        }
        self.covariance = covariance;
        self.sigma *= ((cs / damping) * (self.step_path.norm() / chi - 1.0)).exp();
        self.generation += 1;
        self.told.clear();
    }
}

/// A power of a symmetric matrix.
fn root(matrix: &DMatrix<f64>, power: f64) -> DMatrix<f64> {
    let eigen = SymmetricEigen::new(matrix.clone());
    let values = eigen.eigenvalues.map(|x| x.max(1e-20).powf(power));
    &eigen.eigenvectors * DMatrix::from_diagonal(&values) * eigen.eigenvectors.transpose()
}

impl Learner for Evolution {
    fn ask(&mut self) -> Vec<f64> {
        let count = self.mean.len();
        let normal = DVector::from_fn(count, |_, _| StandardNormal.sample(&mut self.random));
        let x: DVector<f64> = &self.mean + self.sigma * root(&self.covariance, 0.5) * normal;
        x.iter().map(|x| x.clamp(0.0, 1.0)).collect()
    }

    fn tell(&mut self, tried: &[f64], score: f64) {
        self.told.push((DVector::from_column_slice(tried), score));
        if self.told.len() == self.offspring() {
            self.adapt();
        }
    }

    fn best(&self) -> Vec<f64> {
        self.mean.iter().map(|x| x.clamp(0.0, 1.0)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(learner: &mut dyn Learner, tries: usize, score: impl Fn(&[f64]) -> f64) -> Vec<f64> {
        for _ in 0..tries {
            let x = learner.ask();
            let y = score(&x);
            learner.tell(&x, y);
        }
        learner.best()
    }

    #[test]
    fn a_bowl_has_its_bottom_where_it_is() {
        let bowl = |x: &[f64]| {
            -x.iter()
                .zip([0.3, 0.7, 0.5])
                .map(|(x, y)| (x - y).powi(2))
                .sum::<f64>()
        };
        let start = vec![0.6; 3];
        let by_bayes = found(&mut Bayes::new(start.clone(), 1), 30, bowl);
        assert!(bowl(&by_bayes) > -3e-3, "{by_bayes:?}");
        let by_evolution = found(&mut Evolution::new(start, 0.2, 1), 400, bowl);
        assert!(bowl(&by_evolution) > -1e-6, "{by_evolution:?}");
    }

    #[test]
    fn evolution_follows_a_bent_valley() {
        // Rosenbrock's function on the unit square.
        let valley = |x: &[f64]| {
            let [a, b] = [4.0 * x[0] - 2.0, 4.0 * x[1] - 2.0];
            -((1.0 - a).powi(2) + 100.0 * (b - a * a).powi(2))
        };
        let best = found(&mut Evolution::new(vec![0.2, 0.6], 0.2, 3), 1200, valley);
        assert!(
            (best[0] - 0.75).abs() < 1e-2 && (best[1] - 0.75).abs() < 1e-2,
            "{best:?}"
        );
    }
}
