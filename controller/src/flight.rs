//! The flight that follows a lift-off: a parabola.

use crate::{Real, Reason};

/// Lift-off of the wheel's centre, counted from the foot, with its derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LiftOff<R> {
    /// x, y (m), v_x, v_y (m/s).
    pub state: [R; 4],
    /// Their derivatives by the firing angle (1/rad).
    pub by_angle: [R; 4],
    /// Their derivatives by the valve opening time (1/s).
    pub by_valve: [R; 4],
}

/// A length with its derivatives by the decisions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linear<R> {
    /// The length (m).
    pub value: R,
    /// By the firing angle (m/rad).
    pub by_angle: R,
    /// By the valve opening time (m/s).
    pub by_valve: R,
}

/// Newton steps to the nearest point of a parabola; the start is beyond it and the function convex,
/// so that none overshoots.
const STEPS: usize = 4;

impl<R: Real> LiftOff<R> {
    /// Distance (m) from the foot to where the wheel's centre comes down to `height` (m).
    ///
    /// # Errors
    /// [`Reason::Infeasible`] if it never does.
    #[inline]
    pub fn landing(&self, gravity: R, height: R) -> Result<Linear<R>, Reason> {
        let [x, y, vx, vy] = self.state;
        let fall = y - height;
        let square = vy * vy + (gravity + gravity) * fall;
        if !square.is_at_least_zero() {
            return Err(Reason::Infeasible);
        }
        let speed = square.sqrt();
        let inverse = R::ONE / gravity;
        let time = (vy + speed) * inverse;
        if !time.is_at_least_zero() {
            return Err(Reason::Infeasible);
        }
        // Grazing the apex, the landing has no derivative; nothing is asked of it there.
        let slow = if speed > R::ZERO {
            R::ONE / speed
        } else {
            R::ZERO
        };
        let by = |[x, y, sx, sy]: [R; 4]| {
            let later = sy * inverse + (vy * sy * inverse + y) * slow;
            x + sx * time + vx * later
        };
        Ok(Linear {
            value: x + vx * time,
            by_angle: by(self.by_angle),
            by_valve: by(self.by_valve),
        })
    }

    /// Least distances (m) from the parabola of the wheel's centre to the points (`xs`, `y`) (m),
    /// negative where it passes below the point.
    ///
    /// The parabola counts whole, before lift-off and after landing too: this is never more than
    /// the flight's. It is concave, so that a point above it has its nearest point below itself,
    /// and one under it, above.
    ///
    /// With s the time from the apex, (X, Y) the apex as the point sees it, P = 2 (v_x² − g Y)/g²
    /// and Q = 2 v_x X/g², the derivative of the squared distance is that of s³ + P s + Q up to a
    /// factor. Of its minima the lower has the sign that Q has not, and with r = |s| it is the only
    /// positive root of r³ + P r − |Q|, which Newton's steps reach from above. cbrt |Q| is at most
    /// (|Q|/b² + 2 b)/3 for any b.
    ///
    /// Both points go side by side: a step waits for its division, and the other's need not.
    #[inline]
    pub fn distances_to(&self, gravity: R, xs: [R; 2], y: R) -> [Linear<R>; 2] {
        let [x0, y0, vx, vy] = self.state;
        let per_gravity = R::ONE / gravity;
        let rise = vy * per_gravity;
        let apex = (x0 + vx * rise, y0 + R::of(0.5) * vy * rise - y);
        let scale = R::of(2.0) * (per_gravity * per_gravity);
        let p = scale * (vx * vx - gravity * apex.1);
        let qs = xs.map(|x| scale * (vx * (apex.0 - x)));
        let reach = if p < R::ZERO { (-p).sqrt() } else { R::ZERO };
        let mut roots =
            qs.map(|q| reach + (R::of(16.0) * q.magnitude() + R::of(0.5)) * R::of(0.33333334));
        for _ in 0..STEPS {
            let [a, b] = roots;
            let [q, o] = qs;
            roots = [step(a, p, q.magnitude()), step(b, p, o.magnitude())];
        }
        let nearest = |x: R, q: R, r: R| {
            let s = if q > R::ZERO { -r } else { r };
            let (across, up) = (apex.0 - x + vx * s, apex.1 - R::of(0.5) * gravity * (s * s));
            let size = (across * across + up * up).sqrt();
            let distance = if up < R::ZERO { -size } else { size };
            let time = s + rise;
            let inverse = if size > R::ZERO {
                R::ONE / distance
            } else {
                R::ZERO
            };
            let by = |[x, y, sx, sy]: [R; 4]| {
                (across * (x + sx * time) + up * (y + sy * time)) * inverse
            };
            Linear {
                value: distance,
                by_angle: by(self.by_angle),
                by_valve: by(self.by_valve),
            }
        };
        [
            nearest(xs[0], qs[0], roots[0]),
            nearest(xs[1], qs[1], roots[1]),
        ]
    }
}

/// Newton's step from `r` towards the root of r³ + p r − `lever`; r where the cubic does not rise.
#[inline]
fn step<R: Real>(r: R, p: R, lever: R) -> R {
    let square = r * r;
    let slope = R::of(3.0) * square + p;
    let next = (R::of(2.0) * square * r + lever) / slope;
    if slope.is_positive() { next } else { r }
}
