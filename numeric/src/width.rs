//! Which registers lanes go through, chosen where the program runs.

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
use fearless_simd::{Level, Simd};

/// The registers that [`Lanes`](crate::Lanes) go through. All that have fused multiply-add give the
/// same bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Width {
    /// What every processor of the target has.
    Base,
    /// 256 bits with fused multiply-add: x86-64 since 2013.
    Avx2,
    /// 512 bits: x86-64 servers since 2019, and Zen 4.
    Avx512,
}

impl Width {
    /// All of them, the narrowest first.
    pub const ALL: [Width; 3] = [Width::Base, Width::Avx2, Width::Avx512];

    /// The widest that this processor has.
    pub fn best() -> Width {
        Width::ALL
            .into_iter()
            .rev()
            .find(|width| width.is_here())
            .unwrap_or(Width::Base)
    }

    /// Whether this processor has it.
    pub fn is_here(self) -> bool {
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        return match self {
            Width::Base => true,
            Width::Avx2 => Level::new().as_avx2().is_some(),
            Width::Avx512 => Level::new().as_avx512().is_some(),
        };
        #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
        return self == Width::Base;
    }

    /// Whether a multiply-add is one instruction. Where it is a call, lanes cost more than jumps
    /// one by one.
    pub fn fuses(self) -> bool {
        FUSES_EVERYWHERE || self > Width::Base
    }

    /// What `work` gives, compiled with all that is inlined into it for this width; none where a
    /// multiply-add is a call on this processor, so that no code is made for it.
    #[inline(always)]
    pub fn run_fused<R>(self, work: impl FnOnce() -> R) -> Option<R> {
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        match (self, Level::new().as_avx2(), Level::new().as_avx512()) {
            (Width::Avx512, _, Some(simd)) => return Some(simd.vectorize(work)),
            (Width::Avx2, Some(simd), _) => return Some(simd.vectorize(work)),
            _ => {}
        }
        if FUSES_EVERYWHERE { Some(work()) } else { None }
    }
}

/// Whether every processor of the target has fused multiply-add.
const FUSES_EVERYWHERE: bool = cfg!(any(target_feature = "fma", target_arch = "aarch64"));
