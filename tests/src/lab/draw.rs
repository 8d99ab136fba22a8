//! Random numbers from a seed.

use rand_distr::{Distribution, StandardNormal, Uniform};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;

/// A stream of random numbers.
pub(super) struct Draw(Pcg64);

impl Draw {
    /// The stream `stream` of `seed`: what is drawn from one does not move another.
    pub(super) fn new(seed: u64, stream: u64) -> Draw {
        Draw(Pcg64::seed_from_u64(
            seed.wrapping_mul(0x9e37_79b9_7f4a_7c15)
                .wrapping_add(stream),
        ))
    }

    /// Between `low` and `high`.
    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        Uniform::new(low, high).map_or(low, |range| range.sample(&mut self.0))
    }

    /// Between `low` and `high`, evenly in the logarithm.
    pub(super) fn scale(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.between(0.0, 1.0))
    }

    /// True with this chance.
    pub(super) fn chance(&mut self, chance: f64) -> bool {
        self.between(0.0, 1.0) < chance
    }

    /// One of `all`, which are not none.
    pub(super) fn one<T: Copy>(&mut self, all: &[T]) -> T {
        // The index is below the length: the upper end is excluded.
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a small index"
        )]
        let index = self.between(0.0, all.len() as f64) as usize;
        all[index.min(all.len() - 1)]
    }

    /// Normal, with this standard deviation.
    pub(super) fn normal(&mut self, deviation: f64) -> f64 {
        let x: f64 = StandardNormal.sample(&mut self.0);
        deviation * x
    }
}
