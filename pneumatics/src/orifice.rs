//! Flow of a perfect gas through an orifice: choked, subsonic, and the border between them.

use saltus_numeric::{Scalar, Single};
use saltus_robot::Gas;

/// The thesis' orifice law for one gas: constants C_1, C_2 and the critical pressure ratio.
///
/// Source: thesis §4.3.1 (which swaps the names of the two pressures in its text), with the
/// conductance C_f A_v/√T taken out.
#[derive(Clone, Copy, Debug)]
pub struct OrificeLaw {
    /// C_1 = √(κ/R) (2/(κ+1))^((κ+1)/(2(κ−1))), (√(kg K/J)).
    pub choked: f64,
    /// C_2 = √(2κ/(R(κ−1))), (√(kg K/J)).
    pub subsonic: f64,
    /// P_cr: downstream over upstream pressure below which the flow is choked.
    pub critical_ratio: f64,
    /// κ, ratio of specific heats.
    pub heat_ratio: f64,
    /// (κ − 1)/κ: the exponent between a pressure ratio and the isentropic temperature ratio.
    pub temperature_exponent: f64,
    /// κ = 7/5, as in air and nitrogen: powers of κ/(κ − 1) are then e³√e.
    is_diatomic: bool,
}

impl OrificeLaw {
    /// The law for `gas`.
    pub fn new(gas: Gas) -> OrificeLaw {
        let (k, r) = (gas.heat_ratio, gas.constant);
        OrificeLaw {
            choked: (k / r).sqrt() * (2.0 / (k + 1.0)).powf((k + 1.0) / (2.0 * (k - 1.0))),
            subsonic: (2.0 * k / (r * (k - 1.0))).sqrt(),
            critical_ratio: (2.0 / (k + 1.0)).powf(k / (k - 1.0)),
            heat_ratio: k,
            temperature_exponent: (k - 1.0) / k,
            is_diatomic: k == 1.4,
        }
    }

    /// Mass flow over conductance (Pa √(kg K/J)) from `upstream` to `downstream` (Pa, absolute);
    /// negative backwards.
    pub fn flow<S: Single>(&self, upstream: S, downstream: S) -> S {
        if downstream.value() > upstream.value() {
            return -self.flow(downstream, upstream);
        }
        let ratio = downstream / upstream;
        if ratio.value() <= self.critical_ratio {
            return upstream * S::of(self.choked);
        }
        let cooling = ratio.pow(S::of(self.temperature_exponent));
        let headroom = S::of(1.0) - cooling;
        if headroom.value() <= 0.0 {
            return S::of(0.0);
        }
        upstream * S::of(self.subsonic) * (ratio / cooling) * headroom.sqrt()
    }

    /// e = (downstream/upstream)^((κ−1)/κ): ratio of the temperatures across an isentropic
    /// expansion.
    pub fn temperature_ratio<S: Scalar>(&self, downstream: S, upstream: S) -> S {
        (downstream / upstream).pow(S::of(self.temperature_exponent))
    }

    /// The pressure ratio e^(κ/(κ−1)) that belongs to the temperature ratio `e`.
    #[inline(always)]
    pub fn pressure_ratio<S: Scalar>(&self, e: S) -> S {
        if self.is_diatomic {
            e * e * e * e.sqrt()
        } else {
            e.pow(S::of(1.0 / self.temperature_exponent))
        }
    }
}
