//! What the equations are written in: one trait for plain numbers, duals and SIMD lanes.

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number that the equations of motion can be evaluated in.
///
/// `f64` gives one jump, [`Dual`](crate::Dual) one jump with its exact derivatives,
/// [`Lanes`](crate::Lanes) several jumps at a time. Angles given to [`sin_cos`](Scalar::sin_cos)
/// are leans: any size is right, those below a right angle are fast.
pub trait Scalar:
    Copy
    + Debug
    + Send
    + Sync
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The number without its derivatives.
    type Value: Scalar<Value = Self::Value, Mask = Self::Mask>;
    /// A yes or no for each lane.
    type Mask: Copy + Debug;

    /// Whether one number is so much code that sums of many are better a loop than written out: to
    /// compile duals written out takes ten times as long, and the code outgrows the cache.
    const IS_WIDE: bool = false;

    /// The constant `x`.
    fn of(x: f64) -> Self;
    /// The number without its derivatives.
    fn value(self) -> Self::Value;
    /// `self * a + b`. Plain numbers round twice, on every processor; lanes round once.
    fn mul_add(self, a: Self, b: Self) -> Self;
    /// Square root, for arguments ≥ 0.
    fn sqrt(self) -> Self;
    /// Sine and cosine.
    fn sin_cos(self) -> (Self, Self);
    /// `self` to the power `n`, for `self` > 0.
    fn pow(self, n: Self) -> Self;
    /// The greater of the two, by value.
    fn max(self, other: Self) -> Self;
    /// Magnitude.
    fn abs(self) -> Self;
    /// Where the value is less than that of `other`.
    fn less(self, other: Self) -> Self::Mask;
    /// `yes` where the mask holds, `no` elsewhere; plain numbers evaluate only one of the two.
    fn select(mask: Self::Mask, yes: impl FnOnce() -> Self, no: impl FnOnce() -> Self) -> Self;

    /// Does `work`, equations that stand in many places, such as the stages of a step. Numbers of
    /// much code, such as duals, make a function of it: their compilation takes a tenth of the time.
    #[inline(always)]
    fn apart<R>(work: impl FnOnce() -> R) -> R {
        work()
    }
}

/// A scalar that stands for one jump, so that it can decide a branch.
pub trait Single: Scalar<Value = f64, Mask = bool> {}
impl<S: Scalar<Value = f64, Mask = bool>> Single for S {}

/// Greatest magnitude of an angle (rad) for which [`series_sin_cos`] is good to round-off.
pub(crate) const SERIES_LIMIT: f64 = 1.6;

/// Sine and cosine for |x| ≤ [`SERIES_LIMIT`]: their Taylor series to x²¹ and x²², which is exact
/// to round-off there and, unlike a library's, needs no reduction of the argument.
#[inline(always)]
pub(crate) fn series_sin_cos<S: Scalar>(x: S) -> (S, S) {
    // Coefficients 1/n! with alternating sign, lowest power first.
    const SIN: [f64; 10] = [
        -1.0 / 6.0,
        1.0 / 120.0,
        -1.0 / 5_040.0,
        1.0 / 362_880.0,
        -1.0 / 39_916_800.0,
        1.0 / 6_227_020_800.0,
        -1.0 / 1_307_674_368_000.0,
        1.0 / 355_687_428_096_000.0,
        -1.0 / 121_645_100_408_832_000.0,
        1.0 / 51_090_942_171_709_440_000.0,
    ];
    const COS: [f64; 11] = [
        -1.0 / 2.0,
        1.0 / 24.0,
        -1.0 / 720.0,
        1.0 / 40_320.0,
        -1.0 / 3_628_800.0,
        1.0 / 479_001_600.0,
        -1.0 / 87_178_291_200.0,
        1.0 / 20_922_789_888_000.0,
        -1.0 / 6_402_373_705_728_000.0,
        1.0 / 2_432_902_008_176_640_000.0,
        -1.0 / 1_124_000_727_777_607_680_000.0,
    ];
    let z = x * x;
    let z2 = z * z;
    let z4 = z2 * z2;
    let pair = |c: &[f64], i: usize| z.mul_add(S::of(c[i + 1]), S::of(c[i]));
    let quad = |c: &[f64], i: usize| z2.mul_add(pair(c, i + 2), pair(c, i));
    let s = z4.mul_add(z4.mul_add(pair(&SIN, 8), quad(&SIN, 4)), quad(&SIN, 0));
    let high = z2.mul_add(S::of(COS[10]), pair(&COS, 8));
    let c = z4.mul_add(z4.mul_add(high, quad(&COS, 4)), quad(&COS, 0));
    ((x * z).mul_add(s, x), z.mul_add(c, S::of(1.0)))
}

impl Scalar for f64 {
    type Value = f64;
    type Mask = bool;

    #[inline(always)]
    fn of(x: f64) -> f64 {
        x
    }
    #[inline(always)]
    fn value(self) -> f64 {
        self
    }
    #[inline(always)]
    fn mul_add(self, a: f64, b: f64) -> f64 {
        self * a + b
    }
    #[inline(always)]
    fn sqrt(self) -> f64 {
        f64::sqrt(self)
    }
    #[inline(always)]
    fn sin_cos(self) -> (f64, f64) {
        if self.abs() <= SERIES_LIMIT {
            series_sin_cos(self)
        } else {
            f64::sin_cos(self)
        }
    }
    #[inline(always)]
    fn pow(self, n: f64) -> f64 {
        f64::powf(self, n)
    }
    #[inline(always)]
    fn max(self, other: f64) -> f64 {
        f64::max(self, other)
    }
    #[inline(always)]
    fn abs(self) -> f64 {
        f64::abs(self)
    }
    #[inline(always)]
    fn less(self, other: f64) -> bool {
        self < other
    }
    #[inline(always)]
    fn select(mask: bool, yes: impl FnOnce() -> f64, no: impl FnOnce() -> f64) -> f64 {
        if mask { yes() } else { no() }
    }
}
