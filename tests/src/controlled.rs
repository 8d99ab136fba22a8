//! Sensors of a controller in the loop: an encoder, and the approach rate that it gives.

use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg64;

/// A step of the encoder (rad): 200 counts a turn in quadrature.
///
/// Source: the thesis, table 3.1.
pub const COUNT: f64 = std::f64::consts::TAU / 800.0;
/// Time (s) between the two readings that an approach rate is taken from.
pub const BASELINE: f64 = 0.05;

/// The sensors of one jump.
#[derive(Clone, Copy, Debug)]
pub struct Encoder {
    /// Where in a step the encoder's zero is, 0 to 1; none: an encoder without steps.
    pub phase: Option<f64>,
}

impl Encoder {
    /// One that is put on at random.
    pub fn drawn(random: &mut Pcg64) -> Encoder {
        Encoder {
            phase: Uniform::new(0.0, 1.0)
                .ok()
                .map(|range| range.sample(random)),
        }
    }

    /// The lean (rad) that it reads: the middle of the step.
    pub fn read(&self, lean: f64) -> f64 {
        match self.phase {
            Some(phase) => ((lean / COUNT + phase).floor() + 0.5 - phase) * COUNT,
            None => lean,
        }
    }

    /// The approach rate (rad/s) that two readings give, of a robot that rolled at `rate` up to
    /// `lean`.
    pub fn approach_rate(&self, lean: f64, rate: f64) -> f64 {
        (self.read(lean) - self.read(lean - rate * BASELINE)) / BASELINE
    }
}

/// Mean, standard deviation and greatest size of `errors`.
pub fn spread(errors: &[f64]) -> [f64; 3] {
    let n = errors.len().max(1) as f64;
    let mean = errors.iter().sum::<f64>() / n;
    let square = errors.iter().map(|e| (e - mean) * (e - mean)).sum::<f64>() / (n - 1.0).max(1.0);
    [
        mean,
        square.sqrt(),
        errors.iter().fold(0.0, |worst, e| worst.max(e.abs())),
    ]
}
