//! What clearance needs to know of a path, with drag or without.

use saltus_numeric::Single;

use crate::Flight;
use crate::polynomial::Polynomial;
use crate::state::State;

/// A path of the wheel's centre: its exact state at any time, and the parabolas that it consists of
/// or nearly so.
///
/// Times are searched for on the parabolas, where they are roots of polynomials, and then settled
/// on the exact path.
pub(crate) trait Path<S: Single> {
    /// The state at time `t` (s) after lift-off.
    fn state(&self, t: S) -> State<S>;
    /// The path from time `from` to `to` (s) as parabolas, one after another.
    fn arcs(&self, from: f64, to: f64) -> impl Iterator<Item = Arc>;
}

/// A piece of a parabola, over its own time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arc {
    /// Forward position (m).
    pub(crate) x: Polynomial,
    /// Height (m).
    pub(crate) y: Polynomial,
    /// Time (s) after lift-off at which the arc's own time is 0.
    pub(crate) start: f64,
    /// From when to when it is followed (s after lift-off).
    pub(crate) span: [f64; 2],
}

impl Arc {
    /// The times (s after lift-off) at which `polynomial`, over the arc's own time, changes its
    /// sign.
    pub(crate) fn roots(&self, polynomial: &Polynomial) -> impl Iterator<Item = f64> {
        let [from, to] = self.span.map(|t| t - self.start);
        let roots = polynomial.roots(from, to);
        let start = self.start;
        (0..roots.as_slice().len()).map(move |i| start + roots.as_slice()[i])
    }
}

impl<S: Single> Path<S> for Flight<S> {
    fn state(&self, t: S) -> State<S> {
        State {
            position: self.position(t),
            velocity: self.velocity(t),
            acceleration: [S::of(0.0), -self.gravity],
        }
    }

    fn arcs(&self, from: f64, to: f64) -> impl Iterator<Item = Arc> {
        let Flight {
            x,
            y,
            vx,
            vy,
            gravity,
        } = self.values();
        std::iter::once(Arc {
            x: Polynomial::quadratic(x, vx, 0.0),
            y: Polynomial::quadratic(y, vy, -0.5 * gravity),
            start: 0.0,
            span: [from, to],
        })
    }
}

/// The root near `t` (s) in `span` of a path's function, given as its value and its slope in time.
///
/// Two steps of Newton's method: they take the root from the arc to the path, and give it its
/// derivatives. Where the function is flat, or the root is not near, `t` itself.
pub(crate) fn settle<S: Single>(t: f64, span: [f64; 2], function: impl Fn(S) -> [S; 2]) -> S {
    /// How near, as a share of the span: far above the error of an arc.
    const NEAR: f64 = 1e-3;
    let near = NEAR * (span[1] - span[0]);
    let low = span[0].max(t - near);
    let high = span[1].min(t + near);
    let mut settled = S::of(t);
    for _ in 0..2 {
        let at = S::of(settled.value());
        let [value, slope] = function(at);
        let next = at - value / S::of(slope.value());
        // False where the slope was zero, too.
        if !(low <= next.value() && next.value() <= high) {
            return S::of(t);
        }
        settled = next;
    }
    settled
}
