//! Reading the terms of one table of a robot file.

use crate::domain::Domain;
use crate::section::Section;
use crate::terms::SUPPLY;
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
        let ways = [
            (stem, domain),
            ("supply_pressure_absolute", Domain::at_least(ambient)),
        ];
        let (way, pressure) = s.one_of(&ways, spec.quantity);
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
