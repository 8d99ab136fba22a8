//! Numbers for messages.

/// Significant digits beyond which a sum or a product of decimals has round-off.
const DIGITS: usize = 12;
/// Size of a sum that is 0 but for round-off, where its terms are of the size 1.
const ROUND_OFF: f64 = 1e-15;

/// `x` without round-off: to 12 significant digits, and 0 below 1e-15. For messages alone.
///
/// ```
/// use saltus_numeric::plain;
/// // A wheel of 7 inches.
/// assert_eq!((7.0_f64 * 0.0254).to_string(), "0.17779999999999999");
/// assert_eq!(plain(7.0 * 0.0254).to_string(), "0.1778");
/// assert_eq!(plain(-6.2e-20).to_string(), "0");
/// ```
pub fn plain(x: f64) -> f64 {
    if x.abs() < ROUND_OFF {
        return 0.0;
    }
    format!("{x:.*e}", DIGITS - 1).parse().unwrap_or(x)
}
