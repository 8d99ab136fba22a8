//! Eight numbers side by side in SIMD registers.

use wide::f64x8;

use crate::scalar::{SERIES_LIMIT, Scalar, series_sin_cos};

/// Eight numbers side by side: eight jumps in one go.
pub type Lanes = f64x8;

/// Numbers in a [`Lanes`].
pub const LANES: usize = 8;

impl Scalar for Lanes {
    type Value = Lanes;
    type Mask = Lanes;

    #[inline(always)]
    fn of(x: f64) -> Lanes {
        Lanes::splat(x)
    }
    #[inline(always)]
    fn value(self) -> Lanes {
        self
    }
    #[inline(always)]
    fn mul_add(self, a: Lanes, b: Lanes) -> Lanes {
        f64x8::mul_add(self, a, b)
    }
    #[inline(always)]
    fn sqrt(self) -> Lanes {
        f64x8::sqrt(self)
    }
    #[inline(always)]
    fn sin_cos(self) -> (Lanes, Lanes) {
        let (sin, cos) = series_sin_cos(self);
        let far = f64x8::abs(self).simd_gt(Lanes::splat(SERIES_LIMIT));
        if !far.any() {
            return (sin, cos);
        }
        // Lane by lane, so that no lane's result depends on its neighbours.
        let (far_sin, far_cos) = f64x8::sin_cos(self);
        (far.select(far_sin, sin), far.select(far_cos, cos))
    }
    #[inline(always)]
    fn pow(self, n: Lanes) -> Lanes {
        self.powf_simd(n)
    }
    #[inline(always)]
    fn max(self, other: Lanes) -> Lanes {
        self.fast_max(other)
    }
    #[inline(always)]
    fn abs(self) -> Lanes {
        f64x8::abs(self)
    }
    #[inline(always)]
    fn less(self, other: Lanes) -> Lanes {
        self.simd_lt(other)
    }
    #[inline(always)]
    fn select(mask: Lanes, yes: impl FnOnce() -> Lanes, no: impl FnOnce() -> Lanes) -> Lanes {
        mask.select(yes(), no())
    }
}
