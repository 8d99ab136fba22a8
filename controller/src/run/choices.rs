//! What was learnt, as a table: which of a few choices is the best in what state.

use crate::Real;

/// Equal steps along a number that is observed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steps<R> {
    /// Where the first begins.
    pub from: R,
    /// Where the last ends, above `from`.
    pub to: R,
    /// How many there are, from 1 to 65,535.
    pub count: u16,
}

impl<R: Real> Steps<R> {
    /// The step in which `x` is. What is outside counts to the nearest step, what is not a number to the first.
    #[inline]
    pub fn of(&self, x: R) -> usize {
        let count = usize::from(self.count);
        let place = (x - self.from) / (self.to - self.from) * R::of_index(count);
        let last = count.saturating_sub(1);
        if !place.is_at_least_zero() {
            return 0;
        }
        if place >= R::of_index(last) {
            return last;
        }
        // The whole number is one next to it; the rest says which is below.
        let (near, rest) = place.split(last);
        if rest < R::ZERO {
            near.wrapping_sub(1)
        } else if rest >= R::ONE {
            near.wrapping_add(1)
        } else {
            near
        }
    }
}

/// A choice for each state.
///
/// Source: thesis 6.3.1, tables 6.1 and 6.3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choices<'a, R> {
    /// Steps of each number that is observed.
    pub axes: &'a [Steps<R>],
    /// The choice in each state; the last number's steps are neighbours.
    pub choices: &'a [u8],
}

impl<R: Real> Choices<'_, R> {
    /// The choice where `observed` is; none where numbers or states are missing.
    #[inline]
    pub fn at(&self, observed: &[R]) -> Option<u8> {
        if observed.len() != self.axes.len() {
            return None;
        }
        let mut state: usize = 0;
        for (steps, x) in self.axes.iter().zip(observed) {
            let count = usize::from(steps.count);
            state = state.wrapping_mul(count).wrapping_add(steps.of(*x));
        }
        self.choices.get(state).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all_is_as_by_rounding_down<R: Real>(as_f64: fn(R) -> f64) {
        let steps = Steps {
            from: R::of(-3.0),
            to: R::of(4.0),
            count: 31,
        };
        for k in -400..1100_i32 {
            // Beside and on the borders of steps.
            for by in [-1e-6, 0.0, 1e-6, 0.37] {
                let x = R::of(f64::from(k) * 7.0 / 31.0 / 8.0 - 3.0 + by);
                let place = as_f64((x - R::of(-3.0)) / (R::of(4.0) - R::of(-3.0)) * R::of(31.0));
                let below = (0..31).rev().find(|k| f64::from(*k) <= place).unwrap_or(0);
                assert_eq!(steps.of(x), usize::try_from(below).unwrap_or(0), "{x:?}");
            }
        }
        for (x, step) in [
            (f64::NAN, 0),
            (f64::INFINITY, 30),
            (f64::NEG_INFINITY, 0),
            (1e300, 30),
        ] {
            assert_eq!(steps.of(R::of(x)), step);
        }
    }

    #[test]
    fn steps_are_those_of_rounding_down() {
        all_is_as_by_rounding_down::<f32>(f64::from);
        all_is_as_by_rounding_down::<f64>(|x| x);
    }

    #[test]
    fn a_choice_stands_where_its_state_is() {
        let steps = |count| Steps {
            from: 0.0,
            to: 1.0,
            count,
        };
        let axes = [steps(2), steps(3)];
        let table = Choices {
            axes: &axes,
            choices: &[10, 11, 12, 13, 14],
        };
        assert_eq!(table.at(&[0.1, 0.9]), Some(12));
        assert_eq!(table.at(&[0.6, 0.5]), Some(14));
        assert_eq!(table.at(&[0.6, 0.9]), None);
        assert_eq!(table.at(&[0.6]), None);
    }
}
