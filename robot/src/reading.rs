//! Reading the terms of one table of a robot file.

use crate::domain::Domain;
use crate::gas::{Gas, MOLAR_MASSES};
use crate::section::Section;
use crate::terms::{GAS_CONSTANT, SUPPLIES, SUPPLY};
use crate::units::MOLAR_MASS;
use crate::{Robot, Term};

/// Reads the terms of the table `path` that `robot` has.
pub(crate) fn terms(s: &mut Section, path: &str, robot: &mut Robot) {
    for &term in Term::ALL {
        if term.spec().section() == path && term.applies(robot) {
            read(s, term, robot);
        }
    }
}

/// Reads one term.
fn read(s: &mut Section, term: Term, robot: &mut Robot) {
    let (spec, stem, domain) = (term.spec(), term.stem(robot), term.domain(robot));
    if spec.key == SUPPLY {
        let ambient = robot.environment.ambient.0;
        let (_, most) = SUPPLIES.bounds();
        let absolute = Domain::at_least(ambient)
            .up_to(most)
            .called("an absolute pressure");
        let ways = [
            (stem, spec.quantity, domain),
            ("supply_pressure_absolute", spec.quantity, absolute),
        ];
        let (way, pressure) = s.one_of(&ways);
        term.set(
            robot,
            if way == 0 {
                pressure
            } else {
                pressure - ambient
            },
        );
        return;
    }
    if spec.key == GAS_CONSTANT {
        let ways = [
            (stem, spec.quantity, domain),
            ("molar_mass", MOLAR_MASS, MOLAR_MASSES),
        ];
        let constant = match s.one_of(&ways) {
            (0, constant) => constant,
            (_, molar_mass) => Gas::of_molar_mass(molar_mass, f64::NAN).constant,
        };
        term.set(robot, constant);
        return;
    }
    let value = match term.off(robot) {
        None => Some(s.number(stem, spec.quantity, domain)),
        Some(off) => s
            .optional(stem, spec.quantity, domain)
            .or(term.of(robot).map(|_| off)),
    };
    if let Some(value) = value {
        term.set(robot, value);
    }
}
