//! Forward derivatives: a number and its slopes along N directions.

use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::scalar::Scalar;

/// A number with its derivatives along `N` directions.
///
/// ```
/// use saltus_numeric::{Dual, Scalar};
/// let x = Dual::<2>::variable(3.0, 0);
/// let y = Dual::<2>::variable(2.0, 1);
/// let f = x * x * y;
/// assert_eq!((f.value, f.slope), (18.0, [12.0, 9.0]));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual<const N: usize> {
    /// The number.
    pub value: f64,
    /// Its derivative along each direction.
    pub slope: [f64; N],
}

/// An array from its elements. Unlike that of [`std::array::from_fn`], its closure is inlined for
/// every `N`: a jump with derivatives takes a quarter less time.
#[inline(always)]
fn each<const N: usize>(element: impl Fn(usize) -> f64) -> [f64; N] {
    let mut all = [0.0; N];
    for (i, one) in all.iter_mut().enumerate() {
        *one = element(i);
    }
    all
}

impl<const N: usize> Dual<N> {
    /// The variable of direction `i`, at `value`.
    ///
    /// # Panics
    /// If `i` ≥ `N`.
    pub fn variable(value: f64, i: usize) -> Self {
        let mut slope = [0.0; N];
        slope[i] = 1.0;
        Dual { value, slope }
    }

    /// `value` = f(self), whose derivative at `self` is `slope`.
    #[inline(always)]
    pub fn chain(self, value: f64, slope: f64) -> Self {
        Dual {
            value,
            slope: each(|i| self.slope[i] * slope),
        }
    }

    /// A two-argument function's `value`, with the derivatives `by_self` and `by_other`.
    #[inline(always)]
    fn chain2(self, other: Self, value: f64, by_self: f64, by_other: f64) -> Self {
        let slope =
            each(|i| <f64 as Scalar>::mul_add(self.slope[i], by_self, other.slope[i] * by_other));
        Dual { value, slope }
    }
}

impl<const N: usize> Add for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Dual {
            value: self.value + o.value,
            slope: each(|i| self.slope[i] + o.slope[i]),
        }
    }
}

impl<const N: usize> Sub for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Dual {
            value: self.value - o.value,
            slope: each(|i| self.slope[i] - o.slope[i]),
        }
    }
}

impl<const N: usize> Mul for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        self.chain2(o, self.value * o.value, o.value, self.value)
    }
}

impl<const N: usize> Div for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn div(self, o: Self) -> Self {
        let q = 1.0 / o.value;
        let value = self.value / o.value;
        self.chain2(o, value, q, -value * q)
    }
}

impl<const N: usize> Neg for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.chain(-self.value, -1.0)
    }
}

impl<const N: usize> Scalar for Dual<N> {
    type Value = f64;
    type Mask = bool;
    const IS_WIDE: bool = true;

    #[inline(always)]
    fn of(x: f64) -> Self {
        Dual {
            value: x,
            slope: [0.0; N],
        }
    }
    #[inline(always)]
    fn value(self) -> f64 {
        self.value
    }
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        let f = <f64 as Scalar>::mul_add;
        let slope = each(|i| {
            f(
                self.slope[i],
                a.value,
                f(self.value, a.slope[i], b.slope[i]),
            )
        });
        Dual {
            value: f(self.value, a.value, b.value),
            slope,
        }
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        let r = self.value.sqrt();
        self.chain(r, 0.5 / r)
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (s, c) = Scalar::sin_cos(self.value);
        (self.chain(s, c), self.chain(c, -s))
    }
    #[inline(always)]
    fn pow(self, n: Self) -> Self {
        let p = self.value.powf(n.value);
        self.chain2(n, p, n.value * p / self.value, p * self.value.ln())
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self.value >= other.value {
            self
        } else {
            other
        }
    }
    #[inline(always)]
    fn abs(self) -> Self {
        if self.value < 0.0 { -self } else { self }
    }
    #[inline(always)]
    fn less(self, other: Self) -> bool {
        self.value < other.value
    }
    #[inline(always)]
    fn select(mask: bool, yes: impl FnOnce() -> Self, no: impl FnOnce() -> Self) -> Self {
        if mask { yes() } else { no() }
    }
    #[inline(never)]
    fn apart<R>(work: impl FnOnce() -> R) -> R {
        work()
    }
}
