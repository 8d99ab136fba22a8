//! What disturbs a run: `WHAT=VALUE@FROM:TO`.

use std::f64::consts::PI;

use saltus::Robot;
use saltus::gait::{Disturbance, What, When};

use crate::error::{CliError, cut};
use crate::output::digits;

/// Pascals in a psi.
const PSI: f64 = 6_894.757_293_168;

/// What can disturb.
struct Sort {
    name: &'static str,
    /// Units, the usual one first, with what each is in SI.
    units: &'static [(&'static str, f64)],
    /// From and to what it may be, in SI.
    allowed: [f64; 2],
    make: fn(f64) -> What,
}

const SORTS: [Sort; 5] = [
    Sort {
        name: "slope",
        units: &[("deg", PI / 180.0), ("rad", 1.0)],
        allowed: [-0.7, 0.7],
        make: What::Slope,
    },
    Sort {
        name: "force",
        units: &[("N", 1.0)],
        allowed: [-1e4, 1e4],
        make: What::Force,
    },
    Sort {
        name: "torque",
        units: &[("Nm", 1.0), ("N m", 1.0)],
        allowed: [-1e4, 1e4],
        make: What::Torque,
    },
    Sort {
        name: "supply",
        units: &[("psi", PSI), ("kPa", 1e3), ("bar", 1e5), ("Pa", 1.0)],
        allowed: [0.0, 1e8],
        make: What::Supply,
    },
    Sort {
        name: "friction",
        units: &[],
        allowed: [0.0, 1e4],
        make: What::Friction,
    },
];

/// A disturbance as it was typed, and what it is.
#[derive(Clone, Debug)]
pub(super) struct Typed {
    pub(super) text: String,
    pub(super) disturbance: Disturbance,
}

impl Sort {
    /// What is allowed in place of `value`.
    fn refused(&self, value: &str) -> String {
        let (unit, size) = self.units.first().copied().unwrap_or(("", 1.0));
        let names: Vec<&str> = self.units.iter().map(|(unit, _)| *unit).collect();
        let known = if names.len() > 1 {
            let names = names.join(", ");
            format!(", with one of the units {names} or without a unit")
        } else {
            String::new()
        };
        let [low, high] = self.allowed.map(|end| digits(end / size, 4));
        let range = format!("from {low} to {high} {unit}");
        format!(
            "{} {:?} must be a number {}{known}",
            self.name,
            cut(value),
            range.trim_end()
        )
    }
}

/// Parser of the flag.
pub(crate) fn disturb(text: &str) -> Result<Typed, String> {
    let shape = || {
        format!(
            "{:?} must be WHAT=VALUE@FROM:TO, as in torque=5@0.5:0.7s or slope=3@2:4m",
            cut(text)
        )
    };
    let (what, rest) = text.split_once('=').ok_or_else(shape)?;
    let (value, span) = rest.split_once('@').ok_or_else(shape)?;
    let what = what.trim();
    let Some(sort) = SORTS.iter().find(|sort| sort.name == what) else {
        let names = SORTS.map(|sort| sort.name).join(", ");
        return Err(format!("{:?} must be one of {names}", cut(what)));
    };
    let [low, high] = sort.allowed;
    let number = number(value, sort.units).filter(|x| (low..=high).contains(x));
    let number = number.ok_or_else(|| sort.refused(value))?;
    let when = when(span)?;
    Ok(Typed {
        text: text.trim().into(),
        disturbance: Disturbance {
            when,
            what: (sort.make)(number),
        },
    })
}

/// A number in SI, of the first of `units` where it has none.
fn number(text: &str, units: &[(&str, f64)]) -> Option<f64> {
    let text = text.trim();
    let with_unit = units.iter().find_map(|(unit, size)| {
        let number = text.strip_suffix(unit)?.trim_end().parse::<f64>().ok()?;
        Some(number * size)
    });
    let plain = || Some(text.parse::<f64>().ok()? * units.first().map_or(1.0, |(_, size)| *size));
    with_unit.or_else(plain).filter(|x| x.is_finite())
}

/// From when to when, or from where to where.
fn when(text: &str) -> Result<When, String> {
    let refused = || {
        format!(
            "{:?} must be FROM:TO in s or m with TO above FROM, as in 0.5:0.7s or 2:3m",
            cut(text)
        )
    };
    let (from, to) = text.split_once(':').ok_or_else(refused)?;
    let (from, to) = (from.trim(), to.trim());
    let (unit, make): (char, fn(f64, f64) -> When) = match to.chars().last() {
        Some('s') => ('s', When::Time),
        Some('m') => ('m', When::Place),
        _ => return Err(refused()),
    };
    let end = |text: &str| {
        let text = text.strip_suffix(unit).unwrap_or(text).trim_end();
        text.parse::<f64>().ok().filter(|x| x.abs() <= 1e6)
    };
    match (end(from), end(to)) {
        (Some(from), Some(to)) if from < to => Ok(make(from, to)),
        _ => Err(refused()),
    }
}

/// Refuses disturbances that do not go with `robot`.
pub(super) fn check(all: &[Typed], robot: &Robot) -> Result<(), CliError> {
    const MOST: usize = 10;
    if all.len() > MOST {
        let allowed = format!("given {MOST} times at most, not {}", all.len());
        return Err(CliError::flag("--disturb", "", allowed));
    }
    for typed in all {
        let refused = |allowed: &str| Err(CliError::flag("--disturb", &typed.text, allowed));
        match typed.disturbance.what {
            What::Slope(angle) if (robot.ground.tilt + angle).abs() >= 0.7 => {
                return refused("a slope within 0.7 rad (40.1 deg) together with ground.tilt_deg");
            }
            What::Supply(_) if robot.leg.cylinder().is_none() => {
                return refused("of a robot with pneumatic legs, which this one is not");
            }
            What::Supply(_) if robot.tank.is_some_and(|tank| tank.volume.is_finite()) => {
                return refused("of a robot without a tank, whose pressure is that of its gas");
            }
            _ => {}
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_and_spans_are_read() {
        let check = |text: &str, what: What, when: When| {
            let typed = disturb(text).unwrap();
            assert_eq!(typed.disturbance, Disturbance { what, when }, "{text}");
        };
        check("torque=5@0.5:0.7s", What::Torque(5.0), When::Time(0.5, 0.7));
        check(
            "torque=-5 N m@0.5s:0.7s",
            What::Torque(-5.0),
            When::Time(0.5, 0.7),
        );
        check("force=2N@-1:3m", What::Force(2.0), When::Place(-1.0, 3.0));
        check(
            "slope=90e-1deg@2:3m",
            What::Slope(9.0 * PI / 180.0),
            When::Place(2.0, 3.0),
        );
        check("slope=0.1rad@2:3m", What::Slope(0.1), When::Place(2.0, 3.0));
        check(
            "supply=100@0:1s",
            What::Supply(100.0 * PSI),
            When::Time(0.0, 1.0),
        );
        check("supply=5bar@0:1s", What::Supply(5e5), When::Time(0.0, 1.0));
        check(
            "friction=0.3@0:1s",
            What::Friction(0.3),
            When::Time(0.0, 1.0),
        );
    }
}
