//! Statistics over seeds.

use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg64;
use saltus_numeric::statistics::{mean, percentile};

/// Resamples of a bootstrap.
const RESAMPLES: usize = 2000;

/// A value with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// The value.
    pub value: f64,
    /// From and to.
    pub interval: [f64; 2],
}

/// Mean of the middle half of `values`, with its 95 % interval by bootstrap over them; none of none.
///
/// Source: Agarwal and others, Deep reinforcement learning at the edge of the statistical precipice, 2021.
pub fn interquartile(values: &[f64]) -> Option<Interval> {
    let uniform = Uniform::new(0, values.len()).ok()?;
    let mut random = Pcg64::new(1, 0xb007);
    let mut means: Vec<f64> = (0..RESAMPLES)
        .map(|_| {
            let mut drawn: Vec<f64> = values
                .iter()
                .map(|_| values[uniform.sample(&mut random)])
                .collect();
            middle_half(&mut drawn)
        })
        .collect();
    means.sort_by(f64::total_cmp);
    Some(Interval {
        value: middle_half(&mut values.to_vec()),
        interval: [percentile(&means, 0.025), percentile(&means, 0.975)],
    })
}

/// Mean of the middle half: a quarter of the values, rounded down, is left out at each end.
fn middle_half(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    let out = values.len() / 4;
    mean(&values[out..values.len() - out])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_half_leaves_out_the_ends() {
        let it = interquartile(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 1e9]).unwrap();
        assert_eq!(it.value, 4.5);
        assert!(it.interval[0] < 4.5 && it.interval[1] > 4.5);
        assert_eq!(interquartile(&[3.0]).unwrap().interval, [3.0, 3.0]);
        assert!(interquartile(&[]).is_none());
    }

    #[test]
    fn intervals_hold_as_often_as_they_say() {
        // Of the mean of the middle half of 30 numbers from 0 to 1, which is 0.5.
        let uniform = Uniform::new(0.0, 1.0).unwrap();
        let mut random = Pcg64::new(3, 3);
        let holds = (0..200).filter(|_| {
            let values: Vec<f64> = (0..30).map(|_| uniform.sample(&mut random)).collect();
            let [low, high] = interquartile(&values).unwrap().interval;
            (low..=high).contains(&0.5)
        });
        assert!((176..=199).contains(&holds.count()));
    }
}
