//! One state of several numbers, by steps along each.

use crate::GaitError;
use crate::error::require;

/// Most values that a table may have: 1 GiB of numbers.
pub(crate) const MOST: usize = 1 << 27;

/// Equal steps along an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bin {
    /// Where the first begins.
    pub from: f64,
    /// Where the last ends.
    pub to: f64,
    /// How many there are.
    pub count: usize,
}

impl Bin {
    /// The step in which `x` is, and whether `x` is outside and was taken to the nearest.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    pub fn of(&self, x: f64) -> (usize, bool) {
        let place = (x - self.from) / (self.to - self.from) * self.count as f64;
        let last = self.count - 1;
        if place < 0.0 || place.is_nan() {
            (0, true)
        } else if place < self.count as f64 {
            ((place as usize).min(last), false)
        } else {
            (last, x > self.to)
        }
    }
}

/// Steps along every axis of an observation.
#[derive(Clone, Debug, PartialEq)]
pub struct Bins(Vec<Bin>);

impl Bins {
    /// Of `bins`, one for each number observed.
    ///
    /// # Errors
    /// [`GaitError::Input`] for no steps, for ranges upside down, and where a table of their states
    /// would be above 1 GiB.
    pub fn new(bins: Vec<Bin>) -> Result<Bins, GaitError> {
        for bin in &bins {
            let count = bin.count as f64;
            require(bin.count > 0, "steps of a state", count, "1 or more")?;
            let (from, to) = (bin.from, bin.to);
            let allowed = format!("a finite number above {from}");
            let sound = from.is_finite() && to.is_finite() && to > from;
            require(sound, "end of a state's range", to, allowed)?;
        }
        let states = bins.iter().fold(1.0, |all, bin| all * bin.count as f64);
        let allowed = format!("at most {MOST} in all");
        require(states <= MOST as f64, "states", states, allowed)?;
        Ok(Bins(bins))
    }

    /// Of table 6.1 of the thesis: wheel angle, rate, pivot angle, pivot rate.
    ///
    /// The third never changes: the pivot stays within 0.12 rad, and its two steps meet at -0.95 rad.
    pub fn of_table_6_1() -> Bins {
        use std::f64::consts::PI;
        let bin = |from, to, count| Bin { from, to, count };
        Bins(vec![
            bin(-PI, PI, 31),
            bin(-10.1, 21.0, 31),
            bin(-2.0, 0.1, 2),
            bin(-2.0, 2.0, 2),
        ])
    }

    /// Of table 6.3 of the thesis: wheel angle, rate.
    pub fn of_table_6_3() -> Bins {
        use std::f64::consts::PI;
        let bin = |from, to, count| Bin { from, to, count };
        Bins(vec![bin(-PI, PI, 31), bin(-15.1, 21.0, 31)])
    }

    /// The steps along each axis.
    pub fn axes(&self) -> &[Bin] {
        &self.0
    }

    /// How many states there are.
    pub fn states(&self) -> usize {
        self.0.iter().map(|bin| bin.count).product()
    }

    /// The state of what is observed, and whether any number was outside its range.
    pub fn state(&self, observation: &[f64]) -> (usize, bool) {
        let mut outside = false;
        let state = self.0.iter().zip(observation).fold(0, |state, (bin, x)| {
            let (step, is_out) = bin.of(*x);
            outside |= is_out;
            state * bin.count + step
        });
        (state, outside)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_are_counted_and_ends_are_taken_in() -> Result<(), GaitError> {
        assert_eq!(Bins::of_table_6_1().states(), 3844);
        assert_eq!(Bins::of_table_6_3().states(), 961);
        let bin = |from, to, count| Bin { from, to, count };
        let bins = Bins::new(vec![bin(0.0, 1.0, 4), bin(-1.0, 1.0, 2)])?;
        assert_eq!(bins.state(&[0.3, 0.5]), (3, false));
        assert_eq!(bins.state(&[1.0, 1.0]), (7, false));
        assert_eq!(bins.state(&[-0.1, 7.0]), (1, true));
        assert!(Bins::new(vec![bin(1.0, 0.0, 3)]).is_err());
        assert!(Bins::new(vec![bin(0.0, 1.0, 0)]).is_err());
        assert!(Bins::new(vec![bin(0.0, 1.0, 1 << 20); 2]).is_err());
        Ok(())
    }
}
