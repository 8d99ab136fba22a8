//! Values of a flag: `0.6`, `0.3:1.0:36` (start:stop:count, both ends included), or several of
//! these with commas.

use crate::error::cut;
use crate::quantity::{Quantity, QuantityError};

/// Most values of one flag.
const MOST: usize = 1_000_000;

/// What a flag with several values holds; at least one.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Values(Vec<f64>);

impl std::ops::Deref for Values {
    type Target = [f64];
    fn deref(&self) -> &[f64] {
        &self.0
    }
}

impl From<f64> for Values {
    fn from(value: f64) -> Values {
        Values(vec![value])
    }
}

/// Why a text is no list of values.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum RangeError {
    /// A number in it.
    #[error(transparent)]
    Number(#[from] QuantityError),
    /// Neither a number nor three parts.
    #[error("{0:?} must be a number or start:stop:count, as in 3:6:61")]
    Shape(String),
    /// A count that is none.
    #[error("count {0:?} must be a whole number from 1 to {MOST}")]
    Count(String),
    /// One value for two ends.
    #[error("{0:?} has two ends and one value: a count of 1 needs start = stop")]
    OneOfTwo(String),
    /// More values than anybody needs.
    #[error("{0} values are too many: at most {MOST}")]
    TooMany(usize),
}

impl Values {
    pub(crate) fn parse(text: &str, quantity: &Quantity) -> Result<Values, RangeError> {
        let mut values = Vec::new();
        for part in text.split(',') {
            extend(&mut values, part, quantity)?;
            if values.len() > MOST {
                return Err(RangeError::TooMany(values.len()));
            }
        }
        Ok(Values(values))
    }
}

fn extend(values: &mut Vec<f64>, text: &str, quantity: &Quantity) -> Result<(), RangeError> {
    let parts: Vec<&str> = text.split(':').collect();
    match parts[..] {
        [value] => values.push(quantity.parse(value)?),
        [start, stop, count] => {
            let (start, stop) = (quantity.parse(start)?, quantity.parse(stop)?);
            let Ok(count @ 1..=MOST) = count.trim().parse() else {
                return Err(RangeError::Count(cut(count)));
            };
            if count == 1 && start != stop {
                return Err(RangeError::OneOfTwo(cut(text)));
            }
            values.extend(linspace(start, stop, count));
        }
        _ => return Err(RangeError::Shape(cut(text))),
    }
    Ok(())
}

/// `count` evenly spaced numbers from `start` to `stop`, both included: start + (stop − start)
/// i/(count − 1).
pub(crate) fn linspace(start: f64, stop: f64, count: usize) -> impl Iterator<Item = f64> {
    let last = count - 1;
    (0..count).map(move |i| match i {
        _ if i == last => stop,
        _ => start + (stop - start) * i as f64 / last as f64,
    })
}

macro_rules! parsers {
    ($($name:ident $quantity:ident;)+) => {$(
        /// Parser of a flag.
        pub(crate) fn $name(text: &str) -> Result<Values, RangeError> {
            Values::parse(text, &Quantity::$quantity)
        }
    )+};
}

parsers! {
    rates RATE;
    angles ANGLE;
    times TIME;
    frictions FACTOR;
    distances DISTANCE;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_ranges_and_lists() {
        let check = |text: &str, expected: &[f64]| {
            assert_eq!(&rates(text).unwrap()[..], expected, "{text}");
        };
        check("5", &[5.0]);
        check("3:6:4", &[3.0, 4.0, 5.0, 6.0]);
        check("6:3:2", &[6.0, 3.0]);
        check("5:5:1", &[5.0]);
        check("1,2:3:2, 180deg/s", &[1.0, 2.0, 3.0, std::f64::consts::PI]);
    }

    #[test]
    fn ranges_are_those_of_the_reference_table() {
        let distances = distances("0.3:1.0:36").unwrap();
        assert_eq!(
            (distances[1], distances[7]),
            (0.32, 0.439_999_999_999_999_95)
        );
        assert_eq!(distances.last(), Some(&1.0));
    }

    #[test]
    fn wrong_ranges_are_refused() {
        for text in [
            "", ":", "1:2", "1:2:3:4", "1:2:0", "1:2:1", "1:2:-3", "1:2:2.5", "1:2:1e3", "1,",
            "nan:1:2",
        ] {
            assert!(rates(text).is_err(), "{text}");
        }
        assert!(rates("1:2:1000001").is_err());
        assert!(rates("1:2:1000000,3").is_err());
    }
}
