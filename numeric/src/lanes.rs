//! Several numbers side by side, in as many SIMD registers as they take.

use std::ops::{Add, BitAnd, BitAndAssign, BitOr, BitOrAssign, Div, Mul, Neg, Not, Sub, SubAssign};

use crate::scalar::{SERIES_LIMIT, Scalar, series_sin_cos};

/// Numbers in a [`Lanes`].
pub const LANES: usize = 8;

/// Several numbers side by side, so that many jumps go at once: one register of 512 bits, two of
/// 256 or four of 128, as the function they are inlined into is compiled for (see
/// [`Width`](crate::Width)).
///
/// Comparisons give masks: lanes of all ones (which is a NaN) where they hold, of 0 elsewhere.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct Lanes([f64; LANES]);

/// A mask's lane.
#[inline(always)]
fn ones(yes: bool) -> f64 {
    f64::from_bits(if yes { u64::MAX } else { 0 })
}

impl Lanes {
    /// Lane by lane.
    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Lanes {
        let mut out = self;
        for x in &mut out.0 {
            *x = f(*x);
        }
        out
    }

    /// Lane by lane, of two.
    #[inline(always)]
    fn zip(self, other: Lanes, f: impl Fn(f64, f64) -> f64) -> Lanes {
        let mut out = self;
        for (x, y) in out.0.iter_mut().zip(&other.0) {
            *x = f(*x, *y);
        }
        out
    }

    #[inline(always)]
    fn bits(self, other: Lanes, f: impl Fn(u64, u64) -> u64) -> Lanes {
        self.zip(other, |x, y| f64::from_bits(f(x.to_bits(), y.to_bits())))
    }

    /// The numbers.
    pub fn to_array(self) -> [f64; LANES] {
        self.0
    }

    /// The numbers, to read.
    pub fn as_array(&self) -> &[f64; LANES] {
        &self.0
    }

    /// The numbers, to change.
    pub fn as_mut_array(&mut self) -> &mut [f64; LANES] {
        &mut self.0
    }

    /// The lesser of the two; the other where one is not a number.
    #[inline(always)]
    pub fn min(self, other: Lanes) -> Lanes {
        self.zip(other, |x, y| if x < y { x } else { y })
    }

    /// Where this is less: a mask.
    #[inline(always)]
    pub fn lt(self, other: Lanes) -> Lanes {
        self.zip(other, |x, y| ones(x < y))
    }

    /// Where this is less or equal: a mask.
    #[inline(always)]
    pub fn le(self, other: Lanes) -> Lanes {
        self.zip(other, |x, y| ones(x <= y))
    }

    /// Where this is greater: a mask.
    #[inline(always)]
    pub fn gt(self, other: Lanes) -> Lanes {
        other.lt(self)
    }

    /// Where this is greater or equal: a mask.
    #[inline(always)]
    pub fn ge(self, other: Lanes) -> Lanes {
        other.le(self)
    }

    /// Where the two are equal: a mask.
    #[inline(always)]
    pub fn equal(self, other: Lanes) -> Lanes {
        self.zip(other, |x, y| ones(x == y))
    }

    /// As a mask: `yes` where it holds, `no` elsewhere.
    #[inline(always)]
    pub fn choose(self, yes: Lanes, no: Lanes) -> Lanes {
        let mut out = no;
        for i in 0..LANES {
            out.0[i] = if self.0[i].to_bits() == 0 {
                no.0[i]
            } else {
                yes.0[i]
            };
        }
        out
    }

    /// As a mask: whether it holds in any lane.
    #[inline(always)]
    pub fn any(self) -> bool {
        self.0.iter().fold(0, |all, x| all | x.to_bits()) != 0
    }

    /// As a mask: whether it holds in every lane.
    #[inline(always)]
    pub fn all(self) -> bool {
        self.0.iter().fold(u64::MAX, |all, x| all & x.to_bits()) != 0
    }
}

impl From<[f64; LANES]> for Lanes {
    fn from(numbers: [f64; LANES]) -> Lanes {
        Lanes(numbers)
    }
}

/// The operators that work lane by lane.
macro_rules! operators {
    ($($name:ident $method:ident $apply:expr;)*) => {$(
        impl $name for Lanes {
            type Output = Lanes;
            #[inline(always)]
            fn $method(self, other: Lanes) -> Lanes {
                $apply(self, other)
            }
        }
    )*};
}

operators! {
    Add add |a: Lanes, b| a.zip(b, |x, y| x + y);
    Sub sub |a: Lanes, b| a.zip(b, |x, y| x - y);
    Mul mul |a: Lanes, b| a.zip(b, |x, y| x * y);
    Div div |a: Lanes, b| a.zip(b, |x, y| x / y);
    BitAnd bitand |a: Lanes, b| a.bits(b, |x, y| x & y);
    BitOr bitor |a: Lanes, b| a.bits(b, |x, y| x | y);
}

impl Neg for Lanes {
    type Output = Lanes;
    #[inline(always)]
    fn neg(self) -> Lanes {
        self.map(|x| -x)
    }
}
impl Not for Lanes {
    type Output = Lanes;
    #[inline(always)]
    fn not(self) -> Lanes {
        self.map(|x| f64::from_bits(!x.to_bits()))
    }
}
impl SubAssign for Lanes {
    #[inline(always)]
    fn sub_assign(&mut self, other: Lanes) {
        *self = *self - other;
    }
}
impl BitAndAssign for Lanes {
    #[inline(always)]
    fn bitand_assign(&mut self, other: Lanes) {
        *self = *self & other;
    }
}
impl BitOrAssign for Lanes {
    #[inline(always)]
    fn bitor_assign(&mut self, other: Lanes) {
        *self = *self | other;
    }
}

impl Scalar for Lanes {
    type Value = Lanes;
    type Mask = Lanes;

    #[inline(always)]
    fn of(x: f64) -> Lanes {
        Lanes([x; LANES])
    }
    #[inline(always)]
    fn value(self) -> Lanes {
        self
    }
    /// In one rounding, whatever the processor: lanes give the same bits on each.
    #[inline(always)]
    fn mul_add(self, a: Lanes, b: Lanes) -> Lanes {
        let mut out = self;
        for i in 0..LANES {
            out.0[i] = self.0[i].mul_add(a.0[i], b.0[i]);
        }
        out
    }
    #[inline(always)]
    fn sqrt(self) -> Lanes {
        self.map(f64::sqrt)
    }
    #[inline(always)]
    fn sin_cos(self) -> (Lanes, Lanes) {
        let (sin, cos) = series_sin_cos(self);
        let far = self.abs().gt(Lanes::of(SERIES_LIMIT));
        if !far.any() {
            return (sin, cos);
        }
        // Lane by lane, so that no lane's result depends on its neighbours.
        (
            far.choose(self.map(f64::sin), sin),
            far.choose(self.map(f64::cos), cos),
        )
    }
    #[inline(always)]
    fn pow(self, n: Lanes) -> Lanes {
        self.zip(n, f64::powf)
    }
    #[inline(always)]
    fn max(self, other: Lanes) -> Lanes {
        self.zip(other, |x, y| if x > y { x } else { y })
    }
    #[inline(always)]
    fn abs(self) -> Lanes {
        self.map(f64::abs)
    }
    #[inline(always)]
    fn less(self, other: Lanes) -> Lanes {
        self.lt(other)
    }
    #[inline(always)]
    fn select(mask: Lanes, yes: impl FnOnce() -> Lanes, no: impl FnOnce() -> Lanes) -> Lanes {
        mask.choose(yes(), no())
    }
}
