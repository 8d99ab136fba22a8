//! Several numbers side by side in a SIMD register.

#[cfg(not(target_feature = "avx512f"))]
use wide::f64x4 as Register;
#[cfg(target_feature = "avx512f")]
use wide::f64x8 as Register;

use crate::scalar::{SERIES_LIMIT, Scalar, series_sin_cos};

/// Several numbers side by side, as many as the processor's registers hold: so many jumps go at once.
pub type Lanes = Register;

/// Numbers in a [`Lanes`].
pub const LANES: usize = if cfg!(target_feature = "avx512f") { 8 } else { 4 };

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
        Register::mul_add(self, a, b)
    }
    #[inline(always)]
    fn sqrt(self) -> Lanes {
        Register::sqrt(self)
    }
    #[inline(always)]
    fn sin_cos(self) -> (Lanes, Lanes) {
        let (sin, cos) = series_sin_cos(self);
        let far = Register::abs(self).simd_gt(Lanes::splat(SERIES_LIMIT));
        if !far.any() {
            return (sin, cos);
        }
        // Lane by lane, so that no lane's result depends on its neighbours.
        let (far_sin, far_cos) = Register::sin_cos(self);
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
        Register::abs(self)
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
