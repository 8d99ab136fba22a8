//! Roots inside a bracket, and extremes inside an interval, of functions without derivatives.

/// Two places between which a continuous function has a root, made narrower by regula falsi with
/// the Illinois rule: where the same end stays for the second time, its value counts half.
#[derive(Clone, Copy, Debug)]
pub struct Bracket {
    a: (f64, f64),
    b: (f64, f64),
    /// Whether the last place became `a`; none at first.
    last_was_a: Option<bool>,
}

impl Bracket {
    /// Between (place, value) `a` and `b`, with values of different signs; that of `b` may be 0.
    pub fn new(a: (f64, f64), b: (f64, f64)) -> Bracket {
        Bracket {
            a,
            b,
            last_was_a: None,
        }
    }

    /// Where the straight line through both ends is 0.
    #[inline]
    pub fn secant(&self) -> f64 {
        let ((a, fa), (b, fb)) = (self.a, self.b);
        (a * fb - b * fa) / (fb - fa)
    }

    /// Takes `place`, where the function has this `value`, for the end on its side. A value of 0,
    /// and one that is not a number, is on the side of `b`.
    #[inline]
    pub fn take(&mut self, place: f64, value: f64) {
        let is_a = value * self.a.1 > 0.0;
        let (moved, stays) = if is_a {
            (&mut self.a, &mut self.b)
        } else {
            (&mut self.b, &mut self.a)
        };
        *moved = (place, value);
        if self.last_was_a == Some(is_a) {
            stays.1 *= 0.5;
        }
        self.last_was_a = Some(is_a);
    }

    /// The places at both ends.
    #[inline]
    pub fn places(&self) -> (f64, f64) {
        (self.a.0, self.b.0)
    }
}

/// From the bracket of (place, value) `a` and `b`, `a` below `b`: the place just past the root, on
/// the side of `b`, as near as `resolution`. Regula falsi, with bisection where it is slow.
pub fn past_root(
    a: (f64, f64),
    b: (f64, f64),
    resolution: f64,
    mut value: impl FnMut(f64) -> f64,
) -> f64 {
    /// Values after which bisection goes on alone: it comes to the root whatever the values are.
    const ENOUGH: usize = 80;
    let mut bracket = Bracket::new(a, b);
    for i in 0.. {
        let (a, b) = bracket.places();
        if b - a <= resolution || bracket.b.1 == 0.0 {
            break;
        }
        let mut s = bracket.secant();
        // Once one end has converged, the other comes to it at once.
        let margin = 0.5 * resolution;
        if s - a < margin {
            s = a + margin;
        } else if b - s < margin {
            s = b - margin;
        }
        if i % 8 == 7 || i >= ENOUGH || !(s > a && s < b) {
            s = 0.5 * (a + b);
        }
        if s <= a || s >= b {
            break;
        }
        bracket.take(s, value(s));
    }
    bracket.places().1
}

/// The ends of the bracket `inside`, `outside` after so many `halvings`; the first is inside.
pub fn bisect(
    mut inside: f64,
    mut outside: f64,
    halvings: u32,
    is_inside: impl Fn(f64) -> bool,
) -> (f64, f64) {
    for _ in 0..halvings {
        let middle = 0.5 * (inside + outside);
        if is_inside(middle) {
            inside = middle;
        } else {
            outside = middle;
        }
    }
    (inside, outside)
}

/// Where in [a, b] a function with one maximum is greatest, by so many golden `sections`. Forty come
/// to 5e-9 of the interval, closer than which a function is flat to round-off.
pub fn greatest(mut a: f64, mut b: f64, sections: u32, f: impl Fn(f64) -> f64) -> f64 {
    let golden = (5.0_f64.sqrt() - 1.0) / 2.0;
    let (mut x, mut y) = (b - golden * (b - a), a + golden * (b - a));
    let (mut fx, mut fy) = (f(x), f(y));
    for _ in 0..sections {
        if fx < fy {
            (a, x, fx) = (x, y, fy);
            y = a + golden * (b - a);
            fy = f(y);
        } else {
            (b, y, fy) = (y, x, fx);
            x = b - golden * (b - a);
            fx = f(x);
        }
    }
    0.5 * (a + b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    /// A function and its root.
    type Case = (fn(f64) -> f64, f64);

    /// A line, a gentle and a steep curve, a step, and a root at the end.
    #[test]
    fn past_root_is_past_the_root_by_less_than_the_resolution() {
        let cases: [Case; 5] = [
            (|x| 0.3 - x, 0.3),
            (|x| (-x).exp() - 0.5, 0.5_f64.ln().abs()),
            (|x| 0.4_f64.powi(9) - x.powi(9), 0.4),
            (|x| if x < 0.7 { 1.0 } else { -1.0 }, 0.7),
            (|x| 1.0 - x, 1.0),
        ];
        for (f, root) in cases {
            let calls = Cell::new(0);
            let found = past_root((0.0, f(0.0)), (1.0, f(1.0)), 1e-12, |x| {
                calls.set(calls.get() + 1);
                f(x)
            });
            assert!(f(found) <= 0.0 && (found - root).abs() < 2e-12, "{found}");
            assert!(calls.get() < 80, "{} calls for {root}", calls.get());
        }
    }

    /// A root so near one end that values there are nothing beside those at the other: regula falsi hardly moves.
    #[test]
    fn past_root_comes_to_a_root_beside_an_end() {
        for start in [1e-14, 1e-11, 1e-8] {
            let f = |x: f64| start - 1e-5 * x - x * x;
            let root = 2.0 * start / (1e-5 + (1e-10 + 4.0 * start).sqrt());
            let found = past_root((0.0, f(0.0)), (1.0, f(1.0)), 1e-15, f);
            assert!(
                f(found) <= 0.0 && (found - root).abs() < 2e-15,
                "{found} {root}"
            );
        }
    }

    /// x³ − 1/2 on [0, 1]: the end at 0 stays, so plain regula falsi takes 40 steps to 1e-12.
    #[test]
    fn the_illinois_rule_moves_the_end_that_stays() {
        let f = |x: f64| x.powi(3) - 0.5;
        let mut bracket = Bracket::new((0.0, f(0.0)), (1.0, f(1.0)));
        let steps = (1..40).find(|_| {
            let x = bracket.secant();
            bracket.take(x, f(x));
            f(x).abs() < 1e-12
        });
        assert!(steps.is_some_and(|n| n <= 10), "{steps:?}");
        let (a, b) = bracket.places();
        assert!(f(a) < 0.0 && f(b) >= 0.0);
    }

    #[test]
    fn bisection_keeps_its_side() {
        for (inside, outside) in [(0.0, 2.0), (2.0, 0.0)] {
            let root = 2.0_f64.sqrt();
            let (inside, outside) = bisect(inside, outside, 50, |x| (x < root) == (inside < root));
            assert!((inside - root).abs() < 1e-14 && (outside - inside).abs() < 1e-14);
        }
    }

    #[test]
    fn the_greatest_of_a_parabola() {
        let found = greatest(-1.0, 3.0, 40, |x| -(x - 0.7).powi(2));
        // The parabola is flat to round-off over 1e-8.
        assert!((found - 0.7).abs() < 3e-8, "{found}");
    }
}
