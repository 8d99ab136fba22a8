//! Search among laws: the cross-entropy method.

use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use saltus_numeric::parallel;

/// How to search.
///
/// Source: Rubinstein, The cross-entropy method for combinatorial and continuous optimization (1999).
#[derive(Clone, Debug)]
pub struct Search {
    /// Least and greatest value of each parameter.
    pub bounds: Vec<[f64; 2]>,
    /// Where to begin.
    pub start: Vec<f64>,
    /// Standard deviation of the first candidates, as a part of each parameter's range.
    pub spread: f64,
    /// Candidates in a generation.
    pub candidates: usize,
    /// Of these, how many shape the next generation.
    pub best: usize,
    /// Generations.
    pub generations: usize,
    /// Seed.
    pub seed: u64,
}

/// Weight of the last generation's mean and spread in the next.
const KEPT: f64 = 0.3;

/// The parameters of the greatest `score` found, and that score. `score` of NaN counts as the
/// least; `told` hears of each generation's best. The same on any number of `threads`.
pub fn search(
    search: &Search,
    threads: usize,
    score: impl Fn(&[f64]) -> f64 + Sync,
    mut told: impl FnMut(usize, f64, &[f64]),
) -> (Vec<f64>, f64) {
    let width = |k: usize| search.bounds[k][1] - search.bounds[k][0];
    let count = search.bounds.len();
    let mut mean = search.start.clone();
    let mut spread: Vec<f64> = (0..count).map(|k| search.spread * width(k)).collect();
    let mut best = (mean.clone(), f64::NEG_INFINITY);
    for generation in 0..search.generations {
        let mut random = Pcg64::new(u128::from(search.seed), generation as u128 + 1);
        let mut candidates: Vec<Vec<f64>> = (1..search.candidates)
            .map(|_| {
                let draw = |k: usize, random: &mut Pcg64| {
                    let normal: f64 = StandardNormal.sample(random);
                    let [low, high] = search.bounds[k];
                    (mean[k] + spread[k] * normal).clamp(low, high)
                };
                (0..count).map(|k| draw(k, &mut random)).collect()
            })
            .collect();
        candidates.push(mean.clone());
        let scores = parallel::map_on(threads, candidates.len(), |i| score(&candidates[i]));
        let worth = |i: usize| {
            if scores[i].is_nan() {
                f64::NEG_INFINITY
            } else {
                scores[i]
            }
        };
        let mut order: Vec<usize> = (0..candidates.len()).collect();
        order.sort_by(|&a, &b| worth(b).total_cmp(&worth(a)));
        if worth(order[0]) > best.1 {
            best = (candidates[order[0]].clone(), worth(order[0]));
        }
        told(generation, best.1, &best.0);
        let elite = &order[..search.best.min(order.len())];
        for k in 0..count {
            let values = elite.iter().map(|&i| candidates[i][k]);
            let middle = values.clone().sum::<f64>() / elite.len() as f64;
            let variance = values.map(|x| (x - middle).powi(2)).sum::<f64>() / elite.len() as f64;
            mean[k] = KEPT * mean[k] + (1.0 - KEPT) * middle;
            spread[k] = KEPT * spread[k] + (1.0 - KEPT) * variance.sqrt();
        }
    }
    best
}
