//! The model's own error: what a simulation that has every cause right would still leave of the
//! data.
//!
//! Kennedy and O'Hagan (Bayesian calibration of computer models, 2001) add to the noise a smooth
//! random process. Without it, a shift of a quarter of a standard deviation in many readings has to
//! be the work of some cause, and intervals shrink without limit around a wrong value (Brynjarsdóttir
//! and O'Hagan, 2014). Here the process of each channel is a sum of cosines over the time of
//! a run, of which one half is the same in every run and the other half is each run's own.

use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use saltus_numeric::statistics::dot;

use crate::kind::Kind;
use crate::likelihood::{SHARED, share};
use crate::series::{SHAPES, series};

/// The process, in standard deviations of a reading.
pub(crate) struct Discrepancy {
    /// Unit waves: readings (their places among all) and how much each gives to them.
    waves: Vec<Wave>,
    channels: usize,
}

/// One cosine of one run and channel.
struct Wave {
    channel: usize,
    shape: usize,
    places: Vec<usize>,
    /// For one standard deviation of its coefficient.
    values: Vec<f64>,
}

impl Discrepancy {
    /// Of the experiment's own amplitude.
    pub(crate) fn new(kind: &dyn Kind) -> Discrepancy {
        let amplitudes = kind.amplitudes();
        let mut weights = Vec::new();
        for reading in kind.logs().iter().flat_map(|log| &log.readings) {
            weights.push(reading.weight.sqrt());
        }
        let series = if amplitudes.iter().any(|a| *a > 0.0) {
            series(kind)
        } else {
            Vec::new()
        };
        let mut waves = Vec::new();
        for s in series {
            let size = (s.places.len() as f64).sqrt();
            for (shape, unit) in s.shapes().iter().enumerate() {
                let deviation = amplitudes[s.channel] * size * share(shape).sqrt();
                let weighted = unit.iter().zip(&s.places);
                waves.push(Wave {
                    channel: s.channel,
                    shape,
                    values: weighted.map(|(x, i)| deviation * x * weights[*i]).collect(),
                    places: s.places.clone(),
                });
            }
        }
        Discrepancy {
            waves,
            channels: kind.channels().len(),
        }
    }

    /// Coordinates of a direction in the space of all readings, whose products are the covariances
    /// that the process gives to parts of residuals.
    pub(crate) fn coordinates(&self, direction: &[f64]) -> Vec<f64> {
        let mut shared = vec![0.0; self.channels * SHAPES];
        let mut all = Vec::with_capacity(self.waves.len() + shared.len());
        for wave in &self.waves {
            let along = wave.places.iter().zip(&wave.values);
            let part: f64 = along.map(|(i, x)| x * direction[*i]).sum();
            shared[wave.channel * SHAPES + wave.shape] += part;
            all.push((1.0 - SHARED).sqrt() * part);
        }
        all.extend(shared.into_iter().map(|part| SHARED.sqrt() * part));
        all
    }

    /// By how much more than noise residuals scatter along a direction: variance inflation, ≥ 1.
    pub(crate) fn inflation(&self, direction: &[f64]) -> f64 {
        let noise = dot(direction, direction);
        let coordinates = self.coordinates(direction);
        if noise > 0.0 {
            1.0 + dot(&coordinates, &coordinates) / noise
        } else {
            1.0
        }
    }

    /// Adds one draw of the process to residuals.
    pub(crate) fn add(&self, residuals: &mut [f64], random: &mut Pcg64) {
        let mut normal = || -> f64 { StandardNormal.sample(random) };
        let shared: Vec<f64> = (0..self.channels * SHAPES).map(|_| normal()).collect();
        for wave in &self.waves {
            let own = (1.0 - SHARED).sqrt() * normal();
            let all = own + SHARED.sqrt() * shared[wave.channel * SHAPES + wave.shape];
            for (i, x) in wave.places.iter().zip(&wave.values) {
                residuals[*i] += all * x;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::toy::{ALL, READINGS, RUNS, Toy, sum, wave};

    fn toy(amplitude: f64) -> Toy {
        Toy::new(&[0.0; ALL], vec![wave(0)]).with_discrepancy(amplitude)
    }

    fn drawn(amplitude: f64, count: usize) -> Vec<Vec<f64>> {
        let process = Discrepancy::new(&toy(amplitude));
        let mut random = Pcg64::new(1, 1);
        let mut draw = || {
            let mut all = vec![0.0; ALL];
            process.add(&mut all, &mut random);
            all
        };
        (0..count).map(|_| draw()).collect()
    }

    fn mean_square(all: &[Vec<f64>], of: impl Fn(&[f64]) -> f64) -> f64 {
        all.iter().map(|x| of(x).powi(2)).sum::<f64>() / all.len() as f64
    }

    #[test]
    fn a_draw_has_its_amplitude_and_is_smooth() {
        let all = drawn(0.3, 2000);
        let level = mean_square(&all, |x| (dot(x, x) / ALL as f64).sqrt());
        assert!((level.sqrt() / 0.3 - 1.0).abs() < 0.03, "{level}");
        let middle = READINGS / 2;
        let step = mean_square(&all, |x| x[middle + 1] - x[middle]);
        assert!(step.sqrt() < 0.06, "{step}");
    }

    #[test]
    fn runs_share_one_half() {
        let all = drawn(1.0, 4000);
        let place = READINGS / 3;
        let product = |a: usize, b: usize| all.iter().map(|x| x[a] * x[b]).sum::<f64>();
        let correlation = product(place, place + READINGS) / product(place, place);
        assert!((correlation - SHARED).abs() < 0.06, "{correlation}");
    }

    /// What coordinates say of a direction is what draws do along it.
    #[test]
    fn coordinates_give_the_variance_of_draws() {
        let same: Vec<f64> = (0..ALL).map(|i| (i % READINGS) as f64 / 50.0).collect();
        for direction in [wave(0), wave(40), sum(&[(1.0, &same), (2.0, &wave(7))])] {
            let seen = mean_square(&drawn(0.4, 4000), |x| dot(x, &direction));
            let process = Discrepancy::new(&toy(0.4));
            let coordinates = process.coordinates(&direction);
            let said = dot(&coordinates, &coordinates);
            assert!((seen / said - 1.0).abs() < 0.1, "{seen} {said}");
            let inflation = process.inflation(&direction) - 1.0;
            assert!((inflation * dot(&direction, &direction) / said - 1.0).abs() < 1e-9);
        }
    }

    /// A constant shift of all readings of all runs is what the process does most.
    #[test]
    fn a_shift_of_all_readings_weighs_most() {
        let process = Discrepancy::new(&toy(0.2));
        let each = 0.04 * READINGS as f64 * share(0);
        let closed = 1.0 + each * (SHARED * RUNS as f64 + 1.0 - SHARED);
        assert!((process.inflation(&[1.0; ALL]) / closed - 1.0).abs() < 1e-9);
        assert_eq!(Discrepancy::new(&toy(0.0)).inflation(&[1.0; ALL]), 1.0);
    }
}
