//! A step of DOP853 for a state whose size is known at run time only.

use saltus_numeric::dop853::{A, B, E3, E5, STAGES};

/// Room for the stages of a step.
#[derive(Clone, Debug)]
pub(crate) struct Stages {
    k: Vec<Vec<f64>>,
    argument: Vec<f64>,
}

impl Stages {
    pub(crate) fn new(size: usize) -> Stages {
        Stages {
            k: vec![vec![0.0; size]; STAGES],
            argument: vec![0.0; size],
        }
    }

    /// The derivative at the start of the step, to be set before it.
    pub(crate) fn start(&mut self) -> &mut [f64] {
        &mut self.k[0]
    }

    /// One step of length `h` from `y` to `next`; the error estimate over the first `checked`
    /// components as a multiple of `tolerance`, each relative to 1 + |y|. NaN is a step that cannot
    /// be.
    pub(crate) fn step(
        &mut self,
        mut f: impl FnMut(&[f64], &mut [f64]),
        y: &[f64],
        h: f64,
        (checked, tolerance): (usize, f64),
        next: &mut [f64],
    ) -> f64 {
        for stage in 1..STAGES {
            let (done, rest) = self.k.split_at_mut(stage);
            combine(&A[stage][..stage], done, y, h, &mut self.argument);
            f(&self.argument, &mut rest[0]);
        }
        combine(&B, &self.k, y, h, next);
        self.error(y, next, h, checked, tolerance)
    }

    /// Hairer's combined estimate |h| e₅² / √(n (e₅² + e₃²/100)).
    fn error(&self, y: &[f64], next: &[f64], h: f64, checked: usize, tolerance: f64) -> f64 {
        let (mut fifth, mut third) = (0.0, 0.0);
        for i in 0..checked {
            let scale = 1.0 / (1.0 + y[i].abs().max(next[i].abs()));
            let sum = |weights: &[f64; STAGES]| -> f64 {
                weights
                    .iter()
                    .zip(&self.k)
                    .map(|(w, k)| w * k[i])
                    .sum::<f64>()
                    * scale
            };
            fifth += sum(&E5).powi(2);
            third += sum(&E3).powi(2);
        }
        let denominator = (fifth + 0.01 * third + f64::MIN_POSITIVE) * checked as f64;
        h.abs() * fifth / denominator.sqrt() / tolerance
    }
}

/// y + h Σ weights k.
fn combine(weights: &[f64], k: &[Vec<f64>], y: &[f64], h: f64, sum: &mut [f64]) {
    sum.copy_from_slice(y);
    for (w, k) in weights.iter().zip(k) {
        if *w != 0.0 {
            let factor = h * w;
            for (s, k) in sum.iter_mut().zip(k) {
                *s += factor * k;
            }
        }
    }
}
