//! Rotations in space.

use core::f64::consts::{FRAC_PI_2, PI};

use crate::Real;

/// A rotation from one frame's axes to another's: a unit quaternion w, x, y, z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotation<R>(pub [R; 4]);

pub(super) fn dot<R: Real>(a: &[R; 3], b: &[R; 3]) -> R {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross<R: Real>(a: &[R; 3], b: &[R; 3]) -> [R; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// a + s b.
pub(super) fn plus<R: Real>(a: &[R; 3], s: R, b: &[R; 3]) -> [R; 3] {
    [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]]
}

impl<R: Real> Rotation<R> {
    /// None at all.
    pub const NONE: Rotation<R> = Rotation([R::ONE, R::ZERO, R::ZERO, R::ZERO]);

    /// `v` of the first frame in the second.
    #[inline]
    pub fn turn(&self, v: &[R; 3]) -> [R; 3] {
        let [w, x, y, z] = self.0;
        let u = [x, y, z];
        let t = cross(&u, v);
        let t = plus(&t, R::ONE, &t);
        plus(&plus(v, w, &t), R::ONE, &cross(&u, &t))
    }

    /// The rotation back.
    #[inline]
    pub fn back(&self) -> Rotation<R> {
        let [w, x, y, z] = self.0;
        Rotation([w, -x, -y, -z])
    }

    /// First `other`, then this.
    #[inline]
    pub fn after(&self, other: &Rotation<R>) -> Rotation<R> {
        let [w, x, y, z] = self.0;
        let [a, b, c, d] = other.0;
        Rotation([
            w * a - x * b - y * c - z * d,
            w * b + x * a + y * d - z * c,
            w * c - x * d + y * a + z * b,
            w * d + x * c - y * b + z * a,
        ])
    }

    /// By a small rotation vector (rad), to its fourth power; of unit length again.
    #[inline]
    pub fn small(vector: &[R; 3]) -> Rotation<R> {
        let s = dot(vector, vector) * R::of(0.25);
        let cosine = R::ONE - s * R::of(0.5) + s * s * R::of(1.0 / 24.0);
        let sine = R::of(0.5) - s * R::of(1.0 / 12.0);
        let part = |k: usize| sine * vector[k];
        Rotation([cosine, part(0), part(1), part(2)]).unit()
    }

    /// That of unit length along it; none for what has no length.
    #[inline]
    pub fn unit(&self) -> Rotation<R> {
        let [w, x, y, z] = self.0;
        let length = (w * w + x * x + y * y + z * z).sqrt();
        if !length.is_positive() || !length.is_finite() {
            return Rotation::NONE;
        }
        Rotation([w / length, x / length, y / length, z / length])
    }
}

/// The angle (rad) of the point (x, y) from the x axis, in [−π, π], to 1e-11; 0 at the origin, and for what is not a number.
///
/// The arc tangent after three halvings, by the Taylor polynomial of degree 11.
#[inline]
pub(super) fn angle<R: Real>(y: R, x: R) -> R {
    let (height, width) = (y.magnitude(), x.magnitude());
    let is_steep = height > width;
    let (short, long) = if is_steep {
        (width, height)
    } else {
        (height, width)
    };
    if !long.is_positive() {
        return R::ZERO;
    }
    let mut t = short / long;
    for _ in 0..3 {
        t = t / (R::ONE + (R::ONE + t * t).sqrt());
    }
    let s = t * t;
    let mut sum = R::ZERO;
    for k in [11_i32, 9, 7, 5, 3, 1] {
        sum = R::ONE / R::of_count(k) - s * sum;
    }
    let mut angle = R::of(8.0) * t * sum;
    if is_steep {
        angle = R::of(FRAC_PI_2) - angle;
    }
    if x < R::ZERO {
        angle = R::of(PI) - angle;
    }
    if y < R::ZERO { -angle } else { angle }
}
