//! Closed intervals of a line.

use std::ops::{Add, Sub};

/// All numbers from `low` to `high`; empty where `low` > `high`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Least.
    pub low: f64,
    /// Greatest.
    pub high: f64,
}

impl Span {
    /// Every number.
    pub const ALL: Span = Span {
        low: f64::NEG_INFINITY,
        high: f64::INFINITY,
    };
    /// No number.
    pub const NONE: Span = Span {
        low: f64::INFINITY,
        high: f64::NEG_INFINITY,
    };

    /// From `low` to `high`.
    pub const fn new(low: f64, high: f64) -> Span {
        Span { low, high }
    }

    /// The one number `x`.
    pub const fn point(x: f64) -> Span {
        Span { low: x, high: x }
    }

    /// From the least to the greatest of `numbers`.
    pub fn hull_of(numbers: &[f64]) -> Span {
        let points = numbers.iter().copied().map(Span::point);
        points.fold(Span::NONE, Span::hull)
    }

    /// Length, negative where empty.
    pub fn width(self) -> f64 {
        self.high - self.low
    }

    /// Whether no number is in it.
    pub fn is_empty(self) -> bool {
        self.low > self.high
    }

    /// What both hold.
    #[must_use]
    pub fn meet(self, other: Span) -> Span {
        Span {
            low: self.low.max(other.low),
            high: self.high.min(other.high),
        }
    }

    /// The least span that holds both.
    #[must_use]
    pub fn hull(self, other: Span) -> Span {
        Span {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }

    /// The same with both ends moved outward by `by`; inward where that is negative.
    #[must_use]
    pub fn widened(self, by: f64) -> Span {
        Span {
            low: self.low - by,
            high: self.high + by,
        }
    }

    /// The number in it that is nearest to `x`; `low` where empty.
    pub fn clamp(self, x: f64) -> f64 {
        x.min(self.high).max(self.low)
    }
}

impl Add for Span {
    type Output = Span;
    fn add(self, o: Span) -> Span {
        Span {
            low: self.low + o.low,
            high: self.high + o.high,
        }
    }
}

impl Sub for Span {
    type Output = Span;
    fn sub(self, o: Span) -> Span {
        Span {
            low: self.low - o.high,
            high: self.high - o.low,
        }
    }
}
