//! One state of several numbers, by steps along each.

use saltus_controller::run::Steps;

use crate::GaitError;
use crate::error::ensure;

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
    pub fn of(&self, x: f64) -> (usize, bool) {
        let inside = (self.from..=self.to).contains(&x);
        (self.steps().of(x), !inside)
    }

    /// The same steps, as a robot has them.
    pub fn steps(&self) -> Steps<f64> {
        Steps {
            from: self.from,
            to: self.to,
            count: u16::try_from(self.count).unwrap_or(u16::MAX),
        }
    }
}

/// Steps along every axis of an observation.
#[derive(Clone, Debug, PartialEq)]
pub struct Bins {
    axes: Vec<Bin>,
}

impl Bins {
    /// Of `bins`, one for each number observed. An axis with a single step says nothing.
    ///
    /// # Errors
    /// [`GaitError::Input`] for no steps, for ranges upside down, and where a table of their states
    /// would be above 1 GiB.
    pub fn new(axes: Vec<Bin>) -> Result<Bins, GaitError> {
        for bin in &axes {
            let (from, to, most) = (bin.from, bin.to, usize::from(u16::MAX));
            let is_ordered = from.is_finite() && to.is_finite() && to > from;
            ensure! {
                "steps of a state", bin.count as f64, (1..=most).contains(&bin.count)
                    => "from 1 to 65535";
                "end of a state's range", to, is_ordered => format!("a finite number above {from}");
            }
        }
        let states: f64 = axes.iter().map(|bin| bin.count as f64).product();
        ensure! { "states", states, states <= MOST as f64 => format!("at most {MOST} in all"); }
        Ok(Bins { axes })
    }

    /// Of table 6.1 of the thesis: wheel angle, rate, pivot angle, pivot rate; of the leg below, extension, pressure
    /// and time since it fired; time. The thesis leaves out all from the extension on.
    ///
    /// The third never changes: the pivot stays within 0.12 rad, and its two steps meet at -0.95 rad.
    pub fn of_table_6_1() -> Bins {
        use std::f64::consts::PI;
        let bin = |from, to, count| Bin { from, to, count };
        Bins {
            axes: vec![
                bin(-PI, PI, 31),
                bin(-10.1, 21.0, 31),
                bin(-2.0, 0.1, 2),
                bin(-2.0, 2.0, 2),
                bin(0.0, 0.1, 1),
                bin(0.0, 1e6, 1),
                bin(0.0, 0.1, 1),
                bin(0.0, 2.0, 1),
            ],
        }
    }

    /// Of table 6.3 of the thesis: wheel angle, rate.
    pub fn of_table_6_3() -> Bins {
        use std::f64::consts::PI;
        let bin = |from, to, count| Bin { from, to, count };
        Bins {
            axes: vec![bin(-PI, PI, 31), bin(-15.1, 21.0, 31)],
        }
    }

    /// The steps along each axis.
    pub fn axes(&self) -> &[Bin] {
        &self.axes
    }

    /// How many states there are.
    pub fn states(&self) -> usize {
        self.axes.iter().map(|bin| bin.count).product()
    }

    /// The state of what is observed, and whether any number was outside its range.
    pub fn state_of(&self, observation: &[f64]) -> (usize, bool) {
        let steps = self.axes.iter().zip(observation);
        steps.fold((0, false), |(state, outside), (bin, x)| {
            let (step, is_out) = bin.of(*x);
            (state * bin.count + step, outside | is_out)
        })
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
        for (seen, state, outside) in [
            ([0.3, 0.5], 3, false),
            ([1.0, 1.0], 7, false),
            ([-0.1, 7.0], 1, true),
            ([f64::NAN, -1.0], 0, true),
        ] {
            assert_eq!(bins.state_of(&seen), (state, outside));
        }
        assert!(Bins::new(vec![bin(1.0, 0.0, 3)]).is_err());
        assert!(Bins::new(vec![bin(0.0, 1.0, 0)]).is_err());
        assert!(Bins::new(vec![bin(0.0, 1.0, 1 << 15); 2]).is_err());
        Ok(())
    }
}
