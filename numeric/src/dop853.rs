//! One step of DOP853, the explicit Runge–Kutta method of order 8 with error estimates of orders 5
//! and 3.
//!
//! Source: Hairer, Nørsett, Wanner, Solving Ordinary Differential Equations I, 2nd ed., §II.5 and
//! its program `dop853`.

use std::borrow::Borrow;

use crate::scalar::Scalar;

/// Stages of a step.
pub const STAGES: usize = 12;

/// Weights of the earlier stages in each stage's argument.
pub const A: [[f64; STAGES]; STAGES] = [
    after([]),
    after([0.05260015195876773]),
    after([0.0197250569845379, 0.0591751709536137]),
    after([0.02958758547680685, 0.0, 0.08876275643042054]),
    after([
        0.2413651341592667,
        0.0,
        -0.8845494793282861,
        0.924834003261792,
    ]),
    after([
        0.037037037037037035,
        0.0,
        0.0,
        0.17082860872947386,
        0.12546768756682242,
    ]),
    after([
        0.037109375,
        0.0,
        0.0,
        0.17025221101954405,
        0.06021653898045596,
        -0.017578125,
    ]),
    after([
        0.03709200011850479,
        0.0,
        0.0,
        0.17038392571223998,
        0.10726203044637328,
        -0.015319437748624402,
        0.008273789163814023,
    ]),
    after([
        0.6241109587160757,
        0.0,
        0.0,
        -3.3608926294469414,
        -0.868219346841726,
        27.59209969944671,
        20.154067550477894,
        -43.48988418106996,
    ]),
    after([
        0.47766253643826434,
        0.0,
        0.0,
        -2.4881146199716677,
        -0.590290826836843,
        21.230051448181193,
        15.279233632882423,
        -33.28821096898486,
        -0.020331201708508627,
    ]),
    after([
        -0.9371424300859873,
        0.0,
        0.0,
        5.186372428844064,
        1.0914373489967295,
        -8.149787010746927,
        -18.52006565999696,
        22.739487099350505,
        2.4936055526796523,
        -3.0467644718982196,
    ]),
    after([
        2.273310147516538,
        0.0,
        0.0,
        -10.53449546673725,
        -2.0008720582248625,
        -17.9589318631188,
        27.94888452941996,
        -2.8589982771350235,
        -8.87285693353063,
        12.360567175794303,
        0.6433927460157636,
    ]),
];

/// The weights of a stage's argument: `earlier`, and 0 for itself and all after it.
const fn after<const N: usize>(earlier: [f64; N]) -> [f64; STAGES] {
    let mut weights = [0.0; STAGES];
    let mut k = 0;
    while k < N {
        weights[k] = earlier[k];
        k += 1;
    }
    weights
}

/// Weights of the stages in the result.
pub const B: [f64; STAGES] = [
    0.054293734116568765,
    0.0,
    0.0,
    0.0,
    0.0,
    4.450312892752409,
    1.8915178993145003,
    -5.801203960010585,
    0.3111643669578199,
    -0.1521609496625161,
    0.20136540080403034,
    0.04471061572777259,
];

/// Error estimate of order 5.
pub const E5: [f64; STAGES] = [
    0.01312004499419488,
    0.0,
    0.0,
    0.0,
    0.0,
    -1.2251564463762044,
    -0.4957589496572502,
    1.6643771824549864,
    -0.35032884874997366,
    0.3341791187130175,
    0.08192320648511571,
    -0.022355307863886294,
];

/// Error estimate of order 3.
pub const E3: [f64; STAGES] = [
    -0.18980075407240762,
    0.0,
    0.0,
    0.0,
    0.0,
    4.450312892752409,
    1.8915178993145003,
    -5.801203960010585,
    -0.4226823213237919,
    -0.1521609496625161,
    0.20136540080403034,
    0.02265179219836082,
];

/// The result of one step.
#[derive(Clone, Copy, Debug)]
pub struct Step<S: Scalar, const N: usize> {
    /// State after the step.
    pub state: [S; N],
    /// Error estimate as a multiple of the tolerance: the step is good where it is ≤ 1; a NaN is
    /// bad.
    pub error: S::Value,
}

/// A derivative of the state with respect to the independent variable, whatever that is: time, or
/// the value of an event function (Hénon's trick: then a step ends on the event, to round-off, with
/// no root to search).
pub trait Derivative<S, const N: usize> {
    /// The derivative at the state `y`.
    fn at(&self, y: &[S; N]) -> [S; N];
}

impl<S, const N: usize, F: Fn(&[S; N]) -> [S; N]> Derivative<S, N> for F {
    #[inline(always)]
    fn at(&self, y: &[S; N]) -> [S; N] {
        self(y)
    }
}

/// One step of length `h` from `y`, where `k0` is the derivative there. The
/// first `checked` components enter the error estimate, each relative to 1 + |y|.
///
/// Not promised: that a step which the estimate accepts contains no kink.
#[inline(always)]
pub fn step<S: Scalar, const N: usize>(
    f: &(impl Derivative<S, N> + ?Sized),
    y: &[S; N],
    k0: &[S; N],
    h: S,
    checked: usize,
    tolerance: f64,
) -> Step<S, N> {
    if S::IS_WIDE {
        let mut k = [*k0; STAGES];
        for n in 1..STAGES {
            k[n] = f.at(&along(y, h, &weighted(&A[n], &k[..n])));
        }
        return finished(&k.each_ref(), y, h, checked, tolerance);
    }
    // Written out, so that each stage's weights are constants, the zeros among them cost nothing,
    // and no stage is copied.
    macro_rules! stages {
        ($($n:literal: $k:ident from $($earlier:ident)*;)*) => {
            $(let $k = f.at(&along(y, h, &weighted(&A[$n], &[$($earlier),*])));
            let $k = &$k;)*
        };
    }
    stages! {
        1: k1 from k0;
        2: k2 from k0 k1;
        3: k3 from k0 k1 k2;
        4: k4 from k0 k1 k2 k3;
        5: k5 from k0 k1 k2 k3 k4;
        6: k6 from k0 k1 k2 k3 k4 k5;
        7: k7 from k0 k1 k2 k3 k4 k5 k6;
        8: k8 from k0 k1 k2 k3 k4 k5 k6 k7;
        9: k9 from k0 k1 k2 k3 k4 k5 k6 k7 k8;
        10: k10 from k0 k1 k2 k3 k4 k5 k6 k7 k8 k9;
        11: k11 from k0 k1 k2 k3 k4 k5 k6 k7 k8 k9 k10;
    }
    let k = [k0, k1, k2, k3, k4, k5, k6, k7, k8, k9, k10, k11];
    finished(&k, y, h, checked, tolerance)
}

/// The step of length `h` from `y` with the stages `k`.
#[inline(always)]
fn finished<S: Scalar, const N: usize>(
    k: &[&[S; N]; STAGES],
    y: &[S; N],
    h: S,
    checked: usize,
    tolerance: f64,
) -> Step<S, N> {
    let state = along(y, h, &weighted(&B, k));
    Step {
        error: error(k, y, &state, h.value(), checked, tolerance),
        state,
    }
}

/// y + h k.
#[inline(always)]
fn along<S: Scalar, const N: usize>(y: &[S; N], h: S, k: &[S; N]) -> [S; N] {
    let mut z = *y;
    for i in 0..N {
        z[i] = h.mul_add(k[i], z[i]);
    }
    z
}

/// Σ weights[j] k[j] over the stages in `k`, in two chains so that they overlap.
#[inline(always)]
fn weighted<S: Scalar, const N: usize>(
    weights: &[f64; STAGES],
    k: &[impl Borrow<[S; N]>],
) -> [S; N] {
    let mut sums = [[S::of(0.0); N]; 2];
    for j in 0..k.len() {
        if weights[j] != 0.0 {
            let w = S::of(weights[j]);
            let sum = &mut sums[j % 2];
            for i in 0..N {
                sum[i] = k[j].borrow()[i].mul_add(w, sum[i]);
            }
        }
    }
    let [mut even, odd] = sums;
    for i in 0..N {
        even[i] = even[i] + odd[i];
    }
    even
}

/// Hairer's combined estimate |h| e₅² / √(n (e₅² + e₃²/100)), over the first `checked` components.
#[inline(always)]
fn error<S: Scalar, const N: usize>(
    k: &[&[S; N]; STAGES],
    y: &[S; N],
    state: &[S; N],
    h: S::Value,
    checked: usize,
    tolerance: f64,
) -> S::Value {
    let of = S::Value::of;
    let (mut e5, mut e3) = ([of(0.0); N], [of(0.0); N]);
    for j in 0..STAGES {
        if E5[j] != 0.0 {
            for i in 0..N {
                let slope = k[j][i].value();
                e5[i] = slope.mul_add(of(E5[j]), e5[i]);
                e3[i] = slope.mul_add(of(E3[j]), e3[i]);
            }
        }
    }
    let mut squares = [of(0.0); 2];
    for i in 0..checked {
        let scale = of(1.0) / (of(1.0) + y[i].value().abs().max(state[i].value().abs()));
        let (high, low) = (e5[i] * scale, e3[i] * scale);
        squares = [high.mul_add(high, squares[0]), low.mul_add(low, squares[1])];
    }
    let [e5, e3] = squares;
    // The least number keeps 0/0 out where nothing moves.
    let denominator = (e3.mul_add(of(0.01), e5) + of(f64::MIN_POSITIVE)) * of(checked as f64);
    h.abs() * e5 / denominator.sqrt() * of(1.0 / tolerance)
}

/// Factor by which the next step may be longer (or must be shorter) after one with this `error`.
///
/// 0.85 error^(−1/8), in [0.2, 5]; a NaN error gives 0.2.
#[inline(always)]
pub fn step_factor<S: Scalar>(error: S) -> S {
    let factor = || {
        let root = error.max(S::of(1e-12)).sqrt().sqrt().sqrt();
        let at_least = (S::of(0.85) * (S::of(1.0) / root)).max(S::of(0.2));
        -(-at_least).max(S::of(-5.0))
    };
    S::select(error.less(S::of(f64::INFINITY)), factor, || S::of(0.2))
}
