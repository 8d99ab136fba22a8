//! Numbers that are held against what they may be.

/// The first of some numbers that is not allowed: its name, its value, and what is allowed; none if
/// all are. Each has a line: name, value, whether it is allowed, and what is.
///
/// ```
/// use saltus_numeric::refused;
/// let (mass, tilt) = (2.0, 3.0);
/// let wrong = refused! {
///     "mass (kg)", mass, mass > 0.0 => "above 0 kg";
///     "tilt (rad)", tilt, f64::abs(tilt) < 1.5 => "between -1.5 and 1.5 rad";
/// };
/// assert_eq!(wrong, Some(("tilt (rad)", 3.0, "between -1.5 and 1.5 rad")));
/// ```
#[macro_export]
macro_rules! refused {
    ($($name:expr, $value:expr, $holds:expr => $allowed:expr;)+) => {
        $(if !$holds {
            Some(($name, $value, $allowed))
        } else)+ {
            None
        }
    };
}
