//! Lean and rate from what counters and converters say.

use crate::Real;

/// What counters and converters say in a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Readings {
    /// Counts of the wheel's encoder, against what carries the axle.
    pub wheel: i32,
    /// Counts of the encoder of the radius, the boom's turn.
    pub radius: i32,
    /// Counts of the encoder of the pivot.
    pub pivot: i32,
    /// Converter counts of the fine gyro on the wheel.
    pub fine_gyro: i32,
    /// Converter counts of the coarse one.
    pub coarse_gyro: i32,
    /// Converter counts of the fine accelerometer on the wheel, along its axes forwards and up at
    /// lean 0.
    pub fine_accelerometer: [i32; 2],
    /// Converter counts of the coarse one.
    pub coarse_accelerometer: [i32; 2],
}

/// What a count is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instruments<R> {
    /// A count of the wheel's encoder (rad).
    pub wheel: R,
    /// Counts of it in a turn.
    pub wheel_turn: i32,
    /// A count of the radius encoder (rad).
    pub radius: R,
    /// A count of the pivot encoder (rad).
    pub pivot: R,
    /// A count of the fine gyro (rad/s).
    pub fine_gyro: R,
    /// Count of it beyond which the coarse one is believed.
    pub fine_limit: i32,
    /// A count of the coarse gyro (rad/s).
    pub coarse_gyro: R,
    /// A count of the fine accelerometer (m/s²).
    pub fine_accelerometer: R,
    /// Count of it from which it is at its end.
    pub accelerometer_limit: i32,
}

/// Most taps of the filter of the rate.
pub const MOST_TAPS: usize = 16;

/// The filtered rate: a finite impulse response over the last readings.
///
/// Source: thesis 5.1.3, which filters the rate by one of fourth order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Signals<'a, R> {
    instruments: Instruments<R>,
    /// Weights of the newest reading, and of each before it.
    taps: &'a [R],
    past: [R; MOST_TAPS],
    /// Where the newest is.
    newest: usize,
    /// How many there are.
    held: usize,
}

impl<'a, R: Real> Signals<'a, R> {
    /// Without readings. Of `taps`, the weights of the newest reading and those before it, the first
    /// [`MOST_TAPS`] count.
    pub fn new(instruments: Instruments<R>, taps: &'a [R]) -> Signals<'a, R> {
        Signals {
            instruments,
            taps,
            past: [R::ZERO; MOST_TAPS],
            newest: 0,
            held: 0,
        }
    }

    /// What a count is.
    pub fn instruments(&self) -> &Instruments<R> {
        &self.instruments
    }

    /// The rate (rad/s) by both gyros: the fine one's, where it is not at its end.
    #[inline]
    pub fn gyro(&self, readings: &Readings) -> R {
        let i = &self.instruments;
        let fine = readings.fine_gyro;
        if fine < i.fine_limit && fine > i.fine_limit.wrapping_neg() {
            R::of_count(fine) * i.fine_gyro
        } else {
            R::of_count(readings.coarse_gyro) * i.coarse_gyro
        }
    }

    /// Takes a cycle's readings; the filtered rate (rad/s). Before there are as many readings as
    /// taps, the first one stands for those before it.
    #[inline]
    pub fn rate(&mut self, readings: &Readings) -> R {
        let rate = self.gyro(readings);
        self.newest = if self.newest == 0 {
            MOST_TAPS - 1
        } else {
            self.newest - 1
        };
        if self.held == 0 {
            self.past = [rate; MOST_TAPS];
            self.held = 1;
        }
        if let Some(place) = self.past.get_mut(self.newest) {
            *place = rate;
        }
        let mut sum = R::ZERO;
        let mut at = self.newest;
        for tap in self.taps.iter().take(MOST_TAPS) {
            if let Some(past) = self.past.get(at) {
                sum = sum + *tap * *past;
            }
            at = if at + 1 == MOST_TAPS { 0 } else { at + 1 };
        }
        sum
    }
}
