//! The cubic through values and slopes at two places.

/// Value and slope at the part `s` (0 to 1) of an interval of length `h`, from (value, slope) at
/// its ends `a` and `b`. Where `h` is 0, the slope is that of `a`.
#[inline]
pub fn hermite(a: (f64, f64), b: (f64, f64), h: f64, s: f64) -> (f64, f64) {
    let (da, db) = (a.1 * h, b.1 * h);
    let rise = b.0 - a.0;
    let (c2, c3) = (3.0 * rise - 2.0 * da - db, da + db - 2.0 * rise);
    let value = a.0 + s * (da + s * (c2 + s * c3));
    let slope = da + s * (2.0 * c2 + 3.0 * s * c3);
    (value, if h > 0.0 { slope / h } else { a.1 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_is_itself() {
        let cubic = |x: f64| (((x - 2.0) * x + 0.5) * x - 1.0, (3.0 * x - 4.0) * x + 0.5);
        for s in [0.0, 0.3, 1.0] {
            let (value, slope) = hermite(cubic(0.5), cubic(2.0), 1.5, s);
            let (true_value, true_slope) = cubic(0.5 + 1.5 * s);
            // Round-off of a dozen operations.
            assert!((value - true_value).abs() < 1e-14 && (slope - true_slope).abs() < 1e-14);
        }
        assert_eq!(hermite((1.0, 2.0), (1.0, 3.0), 0.0, 1.0), (1.0, 2.0));
    }
}
