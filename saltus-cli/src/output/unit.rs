//! Units by the ends of names.

use super::number::digits;

/// Endings of names, and the units that they stand for; a longer one before its own end.
const UNITS: [(&str, &str); 30] = [
    ("_pa_s_per_kg", "Pa s/kg"),
    ("_n_m_s2_per_rad2", "N m s²/rad²"),
    ("_n_m_s_per_rad", "N m s/rad"),
    ("_n_m_per_rad", "N m/rad"),
    ("_n_s2_per_m2", "N s²/m²"),
    ("_rad_per_n_m", "rad/(N m)"),
    ("_n_s_per_m", "N s/m"),
    ("_n_per_pa", "N/Pa"),
    ("_n_per_m", "N/m"),
    ("_m_per_n", "m/N"),
    ("_kg_m2", "kg m²"),
    ("_per_m", "1/m"),
    ("_rad_s", "rad/s"),
    ("_m_s2", "m/s²"),
    ("_m_s", "m/s"),
    ("_m2_per_m", "m²/m"),
    ("_per_s", "1/s"),
    ("_n_m", "N m"),
    ("_nm", "N m"),
    ("_rad", "rad"),
    ("_m2", "m²"),
    ("_m3", "m³"),
    ("_pa", "Pa"),
    ("_kg", "kg"),
    ("_k", "K"),
    ("_n", "N"),
    ("_s", "s"),
    ("_m", "m"),
    ("_psi", "psi"),
    ("_deg", "°"),
];

/// Unit that a name ends with; empty where it has none.
pub(crate) fn unit(name: &str) -> &'static str {
    UNITS
        .iter()
        .find(|(end, _)| name.ends_with(end))
        .map_or("", |(_, unit)| unit)
}

/// A name without its unit, and the unit.
pub(crate) fn split(name: &str) -> (&str, &'static str) {
    UNITS
        .iter()
        .find_map(|(end, unit)| Some((name.strip_suffix(end)?, *unit)))
        .unwrap_or((name, ""))
}

/// A number with so many digits and its unit.
pub(crate) fn with_unit(x: f64, count: usize, unit: &str) -> String {
    format!("{} {unit}", digits(x, count)).trim_end().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_end_with_their_units() {
        assert_eq!(split("leg.valve_delay_s"), ("leg.valve_delay", "s"));
        assert_eq!(split("stiffness_n_per_m"), ("stiffness", "N/m"));
        assert_eq!(split("environment.drag_per_m"), ("environment.drag", "1/m"));
        assert_eq!(
            split("body.axle_friction_n_m"),
            ("body.axle_friction", "N m")
        );
        assert_eq!(split("gain"), ("gain", ""));
        assert_eq!(unit("wheel_rate_rad_s"), "rad/s");
    }
}
