//! Gases: those with a name, and what a gas without one is described by.

use crate::domain::Domain;

/// Molar gas constant (J/(mol K)), exact by the definition of the units of 2019.
pub const MOLAR_CONSTANT: f64 = 8.314_462_618;

/// Domain of a ratio of heat capacities: at most 5/3, that of single atoms, as it is rounded.
pub const HEAT_RATIOS: Domain = Domain::above(1.0)
    .up_to(1.67)
    .called("a ratio of heat capacities");

/// Domain of a molar mass (kg/mol).
pub const MOLAR_MASSES: Domain = Domain::POSITIVE
    .up_to(1.0)
    .called("a molar mass")
    .not("g/mol");

/// A calorically perfect gas.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gas {
    /// Ratio of specific heats κ, in (1, 1.67].
    pub heat_ratio: f64,
    /// Specific gas constant R_g (J/(kg K)), > 0.
    pub constant: f64,
}

impl Gas {
    /// Dry air.
    pub const AIR: Gas = Gas {
        heat_ratio: 1.4,
        constant: 287.05,
    };
    /// Nitrogen.
    pub const NITROGEN: Gas = Gas::of_molar_mass(0.028_013_4, 1.4);
    /// Oxygen.
    pub const OXYGEN: Gas = Gas::of_molar_mass(0.031_998_8, 1.395);
    /// Argon.
    pub const ARGON: Gas = Gas::of_molar_mass(0.039_948, 5.0 / 3.0);
    /// Helium.
    pub const HELIUM: Gas = Gas::of_molar_mass(0.004_002_602, 5.0 / 3.0);
    /// Hydrogen.
    pub const HYDROGEN: Gas = Gas::of_molar_mass(0.002_015_88, 1.405);
    /// Carbon dioxide.
    pub const CO2: Gas = Gas::of_molar_mass(0.044_009_5, 1.289);
    /// Methane.
    pub const METHANE: Gas = Gas::of_molar_mass(0.016_042_5, 1.305);

    /// The gases that files may name; of two names of a gas the first is the one in answers.
    ///
    /// Ratios of heat capacities are those at 300 K and low pressure.
    ///
    /// Source: CRC Handbook of Chemistry and Physics; the gas constant of air is the thesis'.
    pub const NAMED: [(&'static str, Gas); 9] = [
        ("air", Gas::AIR),
        ("nitrogen", Gas::NITROGEN),
        ("oxygen", Gas::OXYGEN),
        ("argon", Gas::ARGON),
        ("helium", Gas::HELIUM),
        ("hydrogen", Gas::HYDROGEN),
        ("carbon dioxide", Gas::CO2),
        ("co2", Gas::CO2),
        ("methane", Gas::METHANE),
    ];

    /// The gas of a molar mass (kg/mol) and a ratio of heat capacities.
    pub const fn of_molar_mass(molar_mass: f64, heat_ratio: f64) -> Gas {
        Gas {
            heat_ratio,
            constant: MOLAR_CONSTANT / molar_mass,
        }
    }

    /// Molar mass (kg/mol).
    pub fn molar_mass(self) -> f64 {
        MOLAR_CONSTANT / self.constant
    }

    /// Its name, if it is one of [`NAMED`](Self::NAMED).
    pub fn name(self) -> Option<&'static str> {
        let named = Gas::NAMED.iter().find(|(_, gas)| *gas == self);
        named.map(|&(name, _)| name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A gas has one name in answers, and molar mass and gas constant are two ways to say one thing.
    #[test]
    fn names_and_molar_masses_are_of_the_gases() {
        assert_eq!(Gas::CO2.name(), Some("carbon dioxide"));
        assert_eq!(Gas::default().name(), None);
        for (_, gas) in Gas::NAMED {
            assert!(HEAT_RATIOS.contains(gas.heat_ratio));
            let again = Gas::of_molar_mass(gas.molar_mass(), gas.heat_ratio);
            // Two roundings.
            assert!((again.constant / gas.constant - 1.0).abs() < 4e-16);
        }
    }
}
