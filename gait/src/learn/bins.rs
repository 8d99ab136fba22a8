//! One state of several numbers, by steps along each.

use saltus_controller::run::Steps;

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

    /// The step in which `x` is, of one more than there are, the first of which ends after `shift` of a step.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    fn shifted(&self, x: f64, shift: f64) -> (usize, bool) {
        let place = (x - self.from) / (self.to - self.from) * self.count as f64;
        let outside = !(0.0..=self.count as f64).contains(&place);
        let within = place.clamp(0.0, self.count as f64) + (1.0 - shift);
        ((within as usize).min(self.count), outside)
    }
}

/// Steps along every axis of an observation, in one tiling or in several that are shifted against each other.
///
/// Source: Sutton and Barto, Reinforcement Learning, 2nd edition, 9.5.4; the shifts of tiling k are k times
/// 1, 3, 5, ... parts of a step, after Miller and Glanz.
#[derive(Clone, Debug, PartialEq)]
pub struct Bins {
    axes: Vec<Bin>,
    tilings: usize,
}

impl Bins {
    /// Of `bins`, one for each number observed. An axis with a single step says nothing.
    ///
    /// # Errors
    /// [`GaitError::Input`] for no steps, for ranges upside down, and where a table of their states
    /// would be above 1 GiB.
    pub fn new(axes: Vec<Bin>) -> Result<Bins, GaitError> {
        for bin in &axes {
            let count = bin.count as f64;
            let sound = (1..=usize::from(u16::MAX)).contains(&bin.count);
            require(sound, "steps of a state", count, "from 1 to 65535")?;
            let (from, to) = (bin.from, bin.to);
            let allowed = format!("a finite number above {from}");
            let sound = from.is_finite() && to.is_finite() && to > from;
            require(sound, "end of a state's range", to, allowed)?;
        }
        let bins = Bins { axes, tilings: 1 };
        bins.check()?;
        Ok(bins)
    }

    /// The same steps in so many `tilings`.
    ///
    /// # Errors
    /// [`GaitError::Input`] for none, for more than 64, and for a table above 1 GiB.
    pub fn tiled(self, tilings: usize) -> Result<Bins, GaitError> {
        let sound = (1..=64).contains(&tilings);
        require(sound, "tilings", tilings as f64, "from 1 to 64")?;
        let bins = Bins { tilings, ..self };
        bins.check()?;
        Ok(bins)
    }

    fn check(&self) -> Result<(), GaitError> {
        let places = |bin: &Bin| self.places(bin) as f64;
        let states: f64 = self.axes.iter().map(places).product::<f64>() * self.tilings as f64;
        let allowed = format!("at most {MOST} in all");
        require(states <= MOST as f64, "states", states, allowed)
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
            tilings: 1,
        }
    }

    /// Of table 6.3 of the thesis: wheel angle, rate.
    pub fn of_table_6_3() -> Bins {
        use std::f64::consts::PI;
        let bin = |from, to, count| Bin { from, to, count };
        Bins {
            axes: vec![bin(-PI, PI, 31), bin(-15.1, 21.0, 31)],
            tilings: 1,
        }
    }

    /// The steps along each axis.
    pub fn axes(&self) -> &[Bin] {
        &self.axes
    }

    /// How many tilings there are: of so many states is an observation.
    pub fn tilings(&self) -> usize {
        self.tilings
    }

    /// How many states there are in all tilings.
    pub fn states(&self) -> usize {
        self.axes
            .iter()
            .map(|bin| self.places(bin))
            .product::<usize>()
            * self.tilings
    }

    /// Steps of a tiling along an axis: one more than is asked for, where tilings are shifted.
    fn places(&self, bin: &Bin) -> usize {
        bin.count + usize::from(self.tilings > 1 && bin.count > 1)
    }

    /// The states of what is observed, one in each tiling, and whether any number was outside its range.
    pub fn states_of(&self, observation: &[f64], states: &mut Vec<usize>) -> bool {
        states.clear();
        let mut outside = false;
        for tiling in 0..self.tilings {
            let mut state = tiling;
            for (axis, (bin, x)) in self.axes.iter().zip(observation).enumerate() {
                let places = self.places(bin);
                let (step, is_out) = if places == bin.count {
                    bin.of(*x)
                } else {
                    // The tiling begins the less before the axis, the farther it is shifted.
                    let shift = (tiling * (2 * axis + 1)) % self.tilings;
                    bin.shifted(*x, shift as f64 / self.tilings as f64)
                };
                outside |= is_out;
                state = state * places + step;
            }
            states.push(state);
        }
        outside
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
        let mut states = Vec::new();
        for (seen, state, outside) in [
            ([0.3, 0.5], 3, false),
            ([1.0, 1.0], 7, false),
            ([-0.1, 7.0], 1, true),
            ([f64::NAN, -1.0], 0, true),
        ] {
            assert_eq!(bins.states_of(&seen, &mut states), outside);
            assert_eq!(states, [state]);
        }
        assert!(Bins::new(vec![bin(1.0, 0.0, 3)]).is_err());
        assert!(Bins::new(vec![bin(0.0, 1.0, 0)]).is_err());
        assert!(Bins::new(vec![bin(0.0, 1.0, 1 << 15); 2]).is_err());
        Ok(())
    }

    #[test]
    fn tilings_part_an_axis_in_finer_steps() -> Result<(), GaitError> {
        let bin = |from, to, count| Bin { from, to, count };
        let bins = Bins::new(vec![bin(0.0, 1.0, 5), bin(0.0, 1.0, 1)])?.tiled(4)?;
        assert_eq!(bins.states(), 4 * 6);
        let of = |x: f64| {
            let mut states = Vec::new();
            assert!(!bins.states_of(&[x, 0.3], &mut states));
            assert!(states.iter().all(|state| *state < bins.states()));
            states
        };
        // Within a twentieth all is one; from one to the next, one tiling of the four differs.
        for k in 0..19 {
            let [a, b, c] = [0.1, 0.9, 1.1].map(|part| of((f64::from(k) + part) / 20.0));
            assert_eq!(a, b);
            let differ = b.iter().zip(&c).filter(|(b, c)| b != c);
            assert_eq!(differ.count(), 1, "{b:?} {c:?}");
        }
        let mut states = Vec::new();
        assert!(bins.states_of(&[1.5, 0.3], &mut states) && states == of(1.0));
        assert!(bins.states_of(&[f64::NAN, 0.3], &mut states));
        assert!(bins.clone().tiled(0).is_err() && bins.tiled(65).is_err());
        Ok(())
    }
}
