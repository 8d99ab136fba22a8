//! The gas in a vessel: which one the operator says it is, and how far it is from a perfect one.

use saltus_robot::Gas;
use saltus_robot::gas::MOLAR_CONSTANT;

use crate::experiment::Run;
use crate::kinds::Problem;

/// Keys of a run.
pub(super) const NAME: &str = "gas";
pub(super) const MOLAR_MASS: &str = "molar_mass_kg_mol";
pub(super) const HEAT_RATIO: &str = "heat_ratio";
/// Distance of the compressibility factor from 1 from which on a note says it: those of the equation of
/// state are true to 1 %.
const REAL: f64 = 0.03;

/// A gas with what carries heat to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Contents {
    /// As a perfect gas.
    pub(super) gas: Gas,
    /// Thermal conductivity (W/(m K)).
    pub(super) conductivity: f64,
    /// Viscosity (Pa s).
    pub(super) viscosity: f64,
    /// Heat capacity at constant pressure (J/(kg K)).
    pub(super) capacity: f64,
}

/// A gas that has a name, as a real one.
struct Substance {
    gas: Gas,
    /// Conductivity (W/(m K)) and viscosity (Pa s) at 300 K.
    transport: [f64; 2],
    /// Constants A₀ (kPa m⁶/kmol²), a, B₀, b (m³/kmol) and c (m³ K³/kmol) of Beattie and Bridgeman.
    state: [f64; 5],
}

/// Conductivities and viscosities: CRC Handbook of Chemistry and Physics; those of air near 280 K.
/// Constants of state: Beattie and Bridgeman (1928), as in Çengel and Boles, Thermodynamics, table 3–4;
/// of methane those of their paper.
const KNOWN: [Substance; 8] = [
    Substance {
        gas: Gas::AIR,
        transport: [0.0246, 1.75e-5],
        state: [131.8441, 0.01931, 0.04611, -0.001_101, 4.34e4],
    },
    Substance {
        gas: Gas::NITROGEN,
        transport: [0.0260, 1.79e-5],
        state: [136.2315, 0.02617, 0.05046, -0.00691, 4.20e4],
    },
    Substance {
        gas: Gas::OXYGEN,
        transport: [0.0265, 2.08e-5],
        state: [151.0857, 0.02562, 0.04624, 0.004_208, 4.80e4],
    },
    Substance {
        gas: Gas::ARGON,
        transport: [0.0179, 2.29e-5],
        state: [130.7802, 0.02328, 0.03931, 0.0, 5.99e4],
    },
    Substance {
        gas: Gas::HELIUM,
        transport: [0.1567, 2.00e-5],
        state: [2.1886, 0.05984, 0.01400, 0.0, 40.0],
    },
    Substance {
        gas: Gas::HYDROGEN,
        transport: [0.1869, 9.0e-6],
        state: [20.0117, -0.00506, 0.02096, -0.04359, 504.0],
    },
    Substance {
        gas: Gas::CO2,
        transport: [0.0168, 1.50e-5],
        state: [507.2836, 0.07132, 0.10476, 0.07235, 6.60e5],
    },
    Substance {
        gas: Gas::METHANE,
        transport: [0.0344, 1.12e-5],
        state: [230.7069, 0.01855, 0.05587, -0.01587, 1.283e5],
    },
];

/// The names, each with its number.
pub(super) const WORDS: &[(&str, f64)] = &{
    let mut words = [("", 0.0); Gas::NAMED.len()];
    let mut k = 0;
    while k < words.len() {
        words[k] = (Gas::NAMED[k].0, k as f64);
        k += 1;
    }
    words
};

/// The substance of a run; none of a gas without a name.
fn substance(run: &Run) -> Option<&'static Substance> {
    if run.settings.contains_key(MOLAR_MASS) {
        return None;
    }
    let number = run.settings.get(NAME).copied().unwrap_or(0.0);
    let place = WORDS.iter().position(|word| word.1 == number);
    let (_, gas) = Gas::NAMED[place.unwrap_or(0)];
    KNOWN.iter().find(|own| own.gas == gas)
}

/// The gas of a run: air where nothing else is said.
///
/// Conduction to a gas without a name follows from Eucken's Prandtl number, 4 κ/(9 κ − 5), and the
/// viscosity of air.
pub(super) fn contents(run: &Run) -> Contents {
    let of = |key: &str| run.settings.get(key).copied();
    if let (Some(molar_mass), Some(heat_ratio)) = (of(MOLAR_MASS), of(HEAT_RATIO)) {
        let gas = Gas::of_molar_mass(molar_mass, heat_ratio);
        let [_, viscosity] = KNOWN[0].transport;
        let capacity = heat_ratio * gas.constant / (heat_ratio - 1.0);
        let prandtl = 4.0 * heat_ratio / (9.0 * heat_ratio - 5.0);
        return Contents {
            gas,
            conductivity: viscosity * capacity / prandtl,
            viscosity,
            capacity,
        };
    }
    let own = substance(run).unwrap_or(&KNOWN[0]);
    let gas = own.gas;
    let [conductivity, viscosity] = own.transport;
    Contents {
        gas,
        conductivity,
        viscosity,
        capacity: gas.heat_ratio * gas.constant / (gas.heat_ratio - 1.0),
    }
}

/// Whether a run is of air.
pub(super) fn is_air(run: &Run) -> bool {
    substance(run).is_some_and(|own| own.gas == Gas::AIR)
}

/// Refuses a gas that is said twice, or half.
///
/// # Errors
/// [`Problem::Gas`].
pub(super) fn is_one(run: &Run) -> Result<(), Problem> {
    let [name, mass, ratio] =
        [NAME, MOLAR_MASS, HEAT_RATIO].map(|key| run.settings.contains_key(key));
    let what = match (name, mass, ratio) {
        (true, true, _) => format!("{NAME} and {MOLAR_MASS}"),
        (true, _, true) => format!("{NAME} and {HEAT_RATIO}"),
        (_, true, false) => format!("{MOLAR_MASS} without {HEAT_RATIO}"),
        (_, false, true) => format!("{HEAT_RATIO} without {MOLAR_MASS}"),
        _ => return Ok(()),
    };
    Err(Problem::Gas {
        run: run.name.clone(),
        what,
    })
}

/// The note on a run whose gas, at its highest pressure (Pa) and first temperature (K), is far from a
/// perfect gas; none for other runs.
pub(super) fn note(run: &Run, pressure: f64, temperature: f64) -> Option<String> {
    let own = substance(run)?;
    let shown = |x: f64| (10.0 * x).round() / 10.0;
    let place = format!(
        "{}: {} at {} bar and {} K is no perfect gas, as which it is computed: \
         its compressibility factor p V/(n R T) is",
        run.name,
        own.gas.name().unwrap_or(NAME),
        shown(pressure / 1e5),
        shown(temperature)
    );
    match own.compressibility(pressure, temperature) {
        Some(z) if (z - 1.0).abs() < REAL => None,
        Some(z) => Some(format!(
            "{place} {z:.2} by the equation of Beattie and Bridgeman"
        )),
        None => Some(format!(
            "{place} far from 1, as it is nearly liquid or solid"
        )),
    }
}

impl Substance {
    /// Compressibility factor p v/(R T) of the gas, by
    /// p = R T/v² (1 − c/(v T³)) (v + B₀ (1 − b/v)) − A₀/v² (1 − a/v).
    ///
    /// None where the gas would be so dense that the equation has no such volume.
    ///
    /// Source: Beattie and Bridgeman, Proc. Am. Acad. Arts Sci. 63 (1928) 229.
    fn compressibility(&self, pressure: f64, temperature: f64) -> Option<f64> {
        let [a0, a, b0, b, c] = self.state;
        // kJ/(kmol K) and kPa, m³/kmol.
        let heat = MOLAR_CONSTANT * temperature;
        let mut factor = 1.0_f64;
        for _ in 0..200 {
            let volume = factor * heat / (1e-3 * pressure);
            let repelled = b0 * (1.0 - b / volume);
            let attracted = a0 * (1.0 - a / volume);
            let next = (1.0 - c / (volume * temperature.powi(3))) * (1.0 + repelled / volume)
                - attracted / (volume * heat);
            if !(0.2..=5.0).contains(&next) {
                return None;
            }
            if (next - factor).abs() < 1e-9 {
                return Some(next);
            }
            factor = next;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compressibility factors as handbooks have them, to 1 %. They were written down from memory, and are
    /// not yet compared with a table.
    #[test]
    fn compressibility_is_that_of_tables() {
        let check = |name: &str, bar: f64, temperature: f64, factor: f64| {
            let own = KNOWN
                .iter()
                .find(|own| own.gas.name() == Some(name))
                .expect("known");
            let found = own.compressibility(1e5 * bar, temperature).expect("a gas");
            // The equation is true to 1 %.
            assert!(
                (found / factor - 1.0).abs() < 0.012,
                "{name} {bar}: {found}"
            );
        };
        // Each gas that a file may name has a substance.
        for (name, gas) in Gas::NAMED {
            assert!(KNOWN.iter().any(|own| own.gas == gas), "{name}");
        }
        check("hydrogen", 150.0, 293.15, 1.09);
        check("hydrogen", 100.0, 300.0, 1.06);
        check("nitrogen", 100.0, 300.0, 1.005);
        check("air", 10.0, 300.0, 0.997);
        check("helium", 150.0, 293.15, 1.07);
        check("carbon dioxide", 10.0, 300.0, 0.95);
        // Carbon dioxide is liquid above 57 bar at room temperature.
        let own = KNOWN.iter().find(|own| own.gas == Gas::CO2);
        assert_eq!(own.and_then(|own| own.compressibility(1e7, 293.15)), None);
    }

    /// 29 g/mol and 7/5 are air, within what its name has more digits for.
    #[test]
    fn a_gas_is_named_or_described() {
        let run = |settings: &[(&str, f64)]| Run {
            settings: settings
                .iter()
                .map(|(k, v)| ((*k).to_owned(), *v))
                .collect(),
            ..Run::default()
        };
        let air = contents(&run(&[]));
        assert_eq!(air.gas, Gas::AIR);
        let described = contents(&run(&[(MOLAR_MASS, 0.028_965), (HEAT_RATIO, 1.4)]));
        assert!((described.gas.constant / air.gas.constant - 1.0).abs() < 1e-4);
        assert!((described.conductivity / air.conductivity - 1.0).abs() < 0.05);
        assert!(is_one(&run(&[(MOLAR_MASS, 0.03)])).is_err());
        assert!(is_one(&run(&[(NAME, 1.0), (HEAT_RATIO, 1.4)])).is_err());
        let hydrogen = run(&[(NAME, WORDS[5].1)]);
        let note = note(&hydrogen, 150e5, 293.0).expect("a note");
        assert!(
            note.contains("hydrogen at 150 bar") && note.contains("1.10"),
            "{note}"
        );
        assert_eq!(super::note(&hydrogen, 20e5, 293.0), None);
    }
}
