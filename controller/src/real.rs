//! The numbers of a controller: `f32` and `f64`, by operations that round the same everywhere.

use core::ops::{Add, Div, Mul, Neg, Sub};

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// `f32` or `f64`.
pub trait Real:
    sealed::Sealed
    + Copy
    + PartialOrd
    + core::fmt::Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;
    /// Relative error that counts as round-off: 64 times that of one operation.
    const ROUND_OFF: Self;
    /// The greatest finite number.
    const GREATEST: Self;

    /// `x`, rounded.
    fn of(x: f64) -> Self;

    /// √x, correctly rounded; not a number for x < 0.
    fn sqrt(self) -> Self;

    /// A whole number next to x, at most 1 away and at most `most`, and x less it; for 0 ≤ x < 2²².
    ///
    /// By adding a number so great that only whole ones lie beside it, which takes a third of the
    /// time of converting.
    fn split(self, most: usize) -> (usize, Self);

    /// `index` as a number.
    fn of_index(index: usize) -> Self;

    /// Neither infinite nor not a number.
    #[inline]
    fn is_finite(self) -> bool {
        self.magnitude() <= Self::GREATEST
    }

    /// `count` as a number, rounded.
    fn of_count(count: i32) -> Self;

    /// |x|.
    fn magnitude(self) -> Self;

    /// The lesser of two.
    #[inline]
    fn lesser(self, other: Self) -> Self {
        if other < self { other } else { self }
    }

    /// The greater of two.
    #[inline]
    fn greater(self, other: Self) -> Self {
        if other > self { other } else { self }
    }

    /// Whether x ≥ 0; false for what is not a number.
    #[inline]
    fn is_at_least_zero(self) -> bool {
        self >= Self::ZERO
    }

    /// Whether x > 0; false for what is not a number.
    #[inline]
    fn is_positive(self) -> bool {
        self > Self::ZERO
    }

    /// Whether low ≤ x ≤ high; false for what is not a number.
    #[inline]
    fn within(self, low: Self, high: Self) -> bool {
        self >= low && self <= high
    }
}

macro_rules! real {
    ($type:ty, $sqrt:path, $great:literal, $bits:literal) => {
        impl Real for $type {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const ROUND_OFF: Self = 64.0 * <$type>::EPSILON;
            const GREATEST: Self = <$type>::MAX;

            #[inline]
            #[allow(clippy::cast_possible_truncation, clippy::cast_lossless)]
            fn of(x: f64) -> Self {
                x as $type
            }

            #[inline]
            fn sqrt(self) -> Self {
                $sqrt(self)
            }

            #[inline]
            #[allow(clippy::cast_possible_truncation)]
            fn split(self, most: usize) -> (usize, Self) {
                let beside = (self - 0.5) + $great;
                let index = (beside.to_bits() & $bits) as usize;
                let whole = (beside - $great).lesser(Self::of_index(most));
                (if index > most { most } else { index }, self - whole)
            }

            #[inline]
            #[allow(clippy::cast_possible_truncation, clippy::cast_lossless)]
            fn of_index(index: usize) -> Self {
                index as u32 as $type
            }

            #[inline]
            #[allow(clippy::cast_possible_truncation, clippy::cast_lossless)]
            fn of_count(count: i32) -> Self {
                count as $type
            }

            #[inline]
            fn magnitude(self) -> Self {
                <$type>::abs(self)
            }
        }
    };
}

// 1.5 · 2²³ and 1.5 · 2⁵², whose last bits count ones.
real!(f32, root::single, 12582912.0, 0x3F_FFFF);
real!(f64, root::double, 6755399441055744.0, 0x3F_FFFF);

/// √x, correctly rounded by either.
#[cfg(feature = "std")]
mod root {
    extern crate std;

    #[inline]
    pub(super) fn single(x: f32) -> f32 {
        x.sqrt()
    }

    #[inline]
    pub(super) fn double(x: f64) -> f64 {
        x.sqrt()
    }
}

#[cfg(not(feature = "std"))]
mod root {
    pub(super) use libm::{sqrt as double, sqrtf as single};
}

/// sin x for |x| ≤ π/2, to 4e-6 there and 2e-10 for |x| ≤ 0.63: the Taylor polynomial of degree 9.
#[inline]
pub(crate) fn sine<R: Real>(x: R) -> R {
    let s = x * x;
    let series = R::of(-0.16666667)
        + s * (R::of(0.008333334) + s * (R::of(-0.00019841270) + s * R::of(0.0000027557319)));
    x + x * s * series
}

/// tanh x, to round-off of the numbers: 0 and ±1 exactly.
///
/// By (e²ˣ − 1)/(e²ˣ + 1): e − 1 by the Taylor polynomial of degree 9 at 2x/256, then eight
/// doublings of the argument, each p → p (p + 2), which keep what is small.
#[inline]
pub(crate) fn tanh<R: Real>(x: R) -> R {
    // Beyond, ±1 to round-off; and what is not a number stays so.
    if x.magnitude() > R::of(20.0) {
        return if x > R::ZERO { R::ONE } else { -R::ONE };
    }
    let y = (x + x) / R::of(256.0);
    let mut p = R::ONE;
    for k in 0..8 {
        p = R::ONE + p * (y / R::of_index(9 - k));
    }
    p = p * y;
    for _ in 0..8 {
        p = p * (p + R::of(2.0));
    }
    p / (p + R::of(2.0))
}

/// cos x for |x| ≤ π/2, to 5e-7 there: the Taylor polynomial of degree 10.
#[inline]
pub(crate) fn cosine<R: Real>(x: R) -> R {
    let s = x * x;
    let series = R::of(0.041666668)
        + s * (R::of(-0.0013888889) + s * (R::of(0.000024801588) + s * R::of(-0.00000027557319)));
    R::ONE + s * (R::of(-0.5) + s * series)
}
