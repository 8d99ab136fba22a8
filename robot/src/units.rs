//! Units at the boundary: which suffixes a quantity's key may carry, and their conversion to SI.

use std::f64::consts::PI;

/// How a number in some unit becomes SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Unit {
    /// SI times a power of ten.
    Decimal(i64),
    /// SI times a factor.
    Times(f64),
}

impl Unit {
    /// The SI unit itself.
    pub const SI: Unit = Unit::Decimal(0);

    /// A number in SI as one of this unit, to six digits if it has more; the second is whether it has.
    pub(crate) fn written(self, number: f64) -> (String, bool) {
        match self {
            Unit::Decimal(power) => (shifted(&number.to_string(), -power).to_string(), false),
            Unit::Times(factor) => {
                let shown: f64 = format!("{:.5e}", number / factor)
                    .parse()
                    .unwrap_or(f64::NAN);
                // A factor and its inverse round twice.
                let is_cut = (shown * factor - number).abs() > 1e-15 * number.abs();
                (shown.to_string(), is_cut)
            }
        }
    }

    /// The decimal `literal` in SI, infinite for `inf`; NaN where it is anything else or too large.
    pub fn si(self, literal: &str) -> f64 {
        if matches!(literal, "inf" | "+inf") {
            return f64::INFINITY;
        }
        let number = match self {
            Unit::Decimal(power) => shifted(literal, power),
            Unit::Times(factor) => literal.parse().unwrap_or(f64::NAN) * factor,
        };
        // Adding 0 turns −0 into 0: an effect that is off is off with the same bits.
        if number.is_finite() {
            0.0 + number
        } else {
            f64::NAN
        }
    }
}

/// The number nearest to `literal` × 10^`power`.
///
/// The decimal is shifted before it is rounded, so that 19.05 mm and 0.01905 m are the same number
/// to the last bit.
fn shifted(literal: &str, power: i64) -> f64 {
    if power == 0 {
        return literal.parse().unwrap_or(f64::NAN);
    }
    let (mantissa, exponent) = literal.split_once(['e', 'E']).unwrap_or((literal, "0"));
    exponent
        .parse()
        .ok()
        .and_then(|e: i64| {
            format!("{mantissa}e{}", e.saturating_add(power))
                .parse()
                .ok()
        })
        .unwrap_or(f64::NAN)
}

/// A kind of quantity: its SI unit and the suffixes of the units that files may use, the SI one
/// first.
#[derive(Clone, Copy, Debug)]
pub struct Quantity {
    /// SI unit as messages write it.
    pub si: &'static str,
    /// Powers of mass, length and time in it.
    pub dimension: [i32; 3],
    /// Key suffix and unit.
    pub units: &'static [(&'static str, Unit)],
}

impl Quantity {
    /// One of its units as messages write it.
    pub fn symbol(&self, unit: Unit) -> String {
        let same = |(_, own): &&(&str, Unit)| *own == unit;
        let suffix = self
            .units
            .iter()
            .find(same)
            .map_or("", |(suffix, _)| suffix);
        match suffix.strip_prefix('_') {
            _ if unit == Unit::SI => self.si,
            None => suffix,
            Some("mm2") => "mm²",
            Some("cm3") => "cm³",
            Some("us") => "µs",
            Some("kpa") => "kPa",
            Some("deg_s") => "deg/s",
            Some("n_per_mm") => "N/mm",
            Some("g_mol") => "g/mol",
            Some(plain) => plain,
        }
        .into()
    }
}

const MILLI: Unit = Unit::Decimal(-3);
/// One pound (kg): the international avoirdupois pound.
const POUND: Unit = Unit::Times(0.453_592_37);
/// One inch (m).
const INCH: Unit = Unit::Times(0.0254);
/// One pound-force per square inch (Pa).
const PSI: Unit = Unit::Times(6_894.757_293_168);
const DEGREE: Unit = Unit::Times(PI / 180.0);
/// Standard gravity (m/s²), which makers of accelerometers call g.
const STANDARD_GRAVITY: Unit = Unit::Times(9.806_65);

macro_rules! quantities {
    ($($name:ident, $si:literal, $dimension:tt: $($suffix:literal $unit:expr),+;)+) => {
        $(
            #[doc = concat!("SI unit: ", $si, "; suffixes of its keys:", $(" `", $suffix, "`",)+ ".")]
            pub const $name: Quantity = Quantity {
                si: $si,
                dimension: $dimension,
                units: &[$(($suffix, $unit)),+],
            };
        )+
    };
}

quantities! {
    NUMBER, "", [0, 0, 0]: "" Unit::SI;
    MASS, "kg", [1, 0, 0]: "_kg" Unit::SI, "_g" MILLI, "_lb" POUND;
    INERTIA, "kg m²", [1, 2, 0]: "_kg_m2" Unit::SI;
    LENGTH, "m", [0, 1, 0]: "_m" Unit::SI, "_mm" MILLI, "_cm" Unit::Decimal(-2), "_in" INCH, "_ft" Unit::Times(0.3048);
    AREA, "m²", [0, 2, 0]: "_m2" Unit::SI, "_mm2" Unit::Decimal(-6);
    VOLUME, "m³", [0, 3, 0]: "_m3" Unit::SI, "_cm3" Unit::Decimal(-6);
    CAPACITY, "m³", [0, 3, 0]: "_m3" Unit::SI, "_cm3" Unit::Decimal(-6), "_l" MILLI;
    TIME, "s", [0, 0, 1]: "_s" Unit::SI, "_ms" MILLI, "_us" Unit::Decimal(-6), "_ns" Unit::Decimal(-9), "_min" Unit::Times(60.0);
    ACCELERATION, "m/s²", [0, 1, -2]: "_m_s2" Unit::SI, "_g" STANDARD_GRAVITY;
    ANGLE, "rad", [0, 0, 0]: "_rad" Unit::SI, "_deg" DEGREE;
    ANGULAR_RATE, "rad/s", [0, 0, -1]: "_rad_s" Unit::SI, "_deg_s" DEGREE, "_rpm" Unit::Times(PI / 30.0);
    FORCE, "N", [1, 1, -2]: "_n" Unit::SI;
    STIFFNESS, "N/m", [1, 0, -2]: "_n_per_m" Unit::SI, "_n_per_mm" Unit::Decimal(3);
    TORQUE, "N m", [1, 2, -2]: "_n_m" Unit::SI;
    ANGULAR_STIFFNESS, "N m/rad", [1, 2, -2]: "_n_m_per_rad" Unit::SI;
    DAMPING, "N s/m", [1, 0, -1]: "_n_s_per_m" Unit::SI;
    PRESSURE, "Pa", [1, -1, -2]: "_pa" Unit::SI, "_kpa" Unit::Decimal(3), "_bar" Unit::Decimal(5), "_psi" PSI;
    PRESSURE_PER_FLOW, "Pa s/kg", [0, -1, -1]: "_pa_s_per_kg" Unit::SI;
    FORCE_PER_PRESSURE, "N/Pa", [0, 2, 0]: "_n_per_pa" Unit::SI, "_mm2" Unit::Decimal(-6);
    FORCE_PER_PRESSURE_LENGTH, "N/(Pa m)", [0, 1, 0]: "_n_per_pa_m" Unit::SI;
    TEMPERATURE, "K", [0, 0, 0]: "_k" Unit::SI;
    THERMAL_RESISTANCE, "K/W", [-1, -2, 3]: "_k_per_w" Unit::SI;
    GAS_CONSTANT, "J/(kg K)", [0, 2, -2]: "_j_per_kg_k" Unit::SI;
    MOLAR_MASS, "kg/mol", [1, 0, 0]: "_kg_mol" Unit::SI, "_g_mol" MILLI;
    PER_LENGTH, "1/m", [0, -1, 0]: "_per_m" Unit::SI;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimal_units_round_once() {
        let check = |power: i64, literal: &str, si: f64| {
            assert_eq!(
                Unit::Decimal(power).si(literal),
                si,
                "{literal} shifted by {power}"
            );
        };
        check(-3, "19.05", 0.01905);
        check(-3, "1.0215", 1.0215e-3);
        check(-3, "10", 0.010);
        check(-3, "+1.5e3", 1.5);
        check(-3, "61.7", 0.0617);
        check(-6, "5.4", 5.4e-6);
        check(5, "8.3", 830_000.0);
        check(3, "1E-400", 0.0);
        check(-3, "1e310", 1e307);
    }

    #[test]
    fn what_is_no_finite_decimal_stays_not_finite() {
        for literal in [
            "nan",
            "-inf",
            "1e400",
            "1e99999999999999999999",
            "",
            "e",
            "0x10",
            "1_0",
        ] {
            assert!(!Unit::Decimal(-3).si(literal).is_finite(), "{literal}");
            assert!(
                !PSI.si(literal).is_finite() || literal.is_empty(),
                "{literal}"
            );
        }
    }

    #[test]
    fn only_inf_is_infinite() {
        for unit in [Unit::SI, MILLI, PSI] {
            assert_eq!(unit.si("inf"), f64::INFINITY);
            assert_eq!(unit.si("+inf"), f64::INFINITY);
            for literal in ["-inf", "1e400", "nan", "infinity"] {
                assert!(unit.si(literal).is_nan(), "{literal}");
            }
        }
    }

    #[test]
    fn negative_zero_is_zero() {
        for unit in [Unit::SI, PSI] {
            assert_eq!(unit.si("-0.0").to_bits(), 0);
        }
    }

    #[test]
    fn other_units_are_one_product() {
        assert_eq!(PSI.si("120"), 120.0 * 6_894.757_293_168);
        assert_eq!(DEGREE.si("30"), 30.0_f64.to_radians());
    }
}
