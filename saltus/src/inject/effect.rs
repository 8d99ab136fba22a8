//! Effects as a user asks for them, and as the model of a kind takes them.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use saltus_diagnosis::spec::Source;
use saltus_diagnosis::{Kind, Sort};

use super::Error;

/// An effect to hide: `CAUSE=VALUE`, or `CAUSE=NAME:VALUE` with the name of a column, or of a
/// parameter where a cause has more than one form.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// The cause's id.
    pub id: String,
    /// The column that it is about, or the parameter that is meant.
    pub name: Option<String>,
    /// Values of its parameters in their units, as a diagnosis reports them; those at the end may
    /// be left out.
    pub values: Vec<f64>,
}

impl FromStr for Effect {
    type Err = Error;

    fn from_str(text: &str) -> Result<Effect, Error> {
        let words = || Error::Words {
            text: text.chars().take(80).collect(),
        };
        let (id, rest) = text.split_once('=').ok_or_else(words)?;
        let (name, values) = match rest.rsplit_once(':') {
            Some((name, values)) => (Some(name.trim().to_owned()), values),
            None => (None, rest),
        };
        let number = |value: &str| value.trim().parse().ok().filter(|x: &f64| x.is_finite());
        let values: Option<Vec<f64>> = values.split(',').map(number).collect();
        Ok(Effect {
            id: id.trim().to_owned(),
            name,
            values: values.ok_or_else(words)?,
        })
    }
}

impl fmt::Display for Effect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let values: Vec<String> = self.values.iter().map(f64::to_string).collect();
        let name = self
            .name
            .as_ref()
            .map_or(String::new(), |name| format!("{name}:"));
        write!(f, "{}={name}{}", self.id, values.join(","))
    }
}

/// Names of the parameters of a cause as they are reported, with what they are without the effect.
fn parameters(kind: &dyn Kind, cause: usize) -> Vec<(String, f64)> {
    let neutral: Vec<f64> = kind.causes()[cause]
        .parameters
        .iter()
        .map(|p| p.neutral)
        .collect();
    kind.causes()[cause].report(&neutral)
}

/// How the cause is asked for, without its values; whether it is the first of its id and column.
fn asked_by(kind: &dyn Kind, cause: usize) -> String {
    let spec = &kind.causes()[cause];
    let is_first = !kind.causes()[kind.common()..cause]
        .iter()
        .any(|c| c.id == spec.id && c.column == spec.column);
    match &spec.column {
        Some(column) => format!("{}={column}:", spec.id),
        None if is_first => format!("{}=", spec.id),
        None => format!("{}={}:", spec.id, parameters(kind, cause)[0].0),
    }
}

/// A number with few digits.
fn short(x: f64) -> String {
    let rounded: f64 = format!("{x:.4e}").parse().unwrap_or(x);
    if rounded == 0.0 || (1e-3..1e6).contains(&rounded.abs()) {
        rounded.to_string()
    } else {
        format!("{rounded:e}")
    }
}

/// The causes that can be hidden in data of a kind. Terms without a name are known to its own model alone:
/// no robot has them.
fn hidden(kind: &dyn Kind, sort: Sort) -> Range<usize> {
    let is_own = matches!(sort.spec().synthesis.source, Source::Model);
    let end = if is_own {
        kind.causes().len()
    } else {
        kind.listed()
    };
    kind.common()..end
}

/// Every cause that can be hidden in data of a kind, one a line.
pub(super) fn known(kind: &dyn Kind, sort: Sort) -> String {
    let line = |cause: usize| {
        let parameters = parameters(kind, cause);
        let names: Vec<&str> = parameters.iter().map(|p| p.0.as_str()).collect();
        let of_each = parameters.iter().zip(kind.causes()[cause].ranges());
        let about: Vec<String> = of_each
            .map(|((_, none), (low, high))| {
                format!(
                    "{} without it, {} to {}",
                    short(*none),
                    short(low),
                    short(high)
                )
            })
            .collect();
        format!(
            "  {}{}  ({})",
            asked_by(kind, cause),
            names.join(","),
            about.join("; ")
        )
    };
    // A cause with two terms is asked for in one way.
    let is_first = |cause: &usize| {
        !(kind.common()..*cause).any(|other| asked_by(kind, other) == asked_by(kind, *cause))
    };
    hidden(kind, sort)
        .filter(is_first)
        .map(line)
        .collect::<Vec<_>>()
        .join("\n")
}

/// The cause that is asked for, and the values that the model takes.
pub(super) fn resolve(
    kind: &dyn Kind,
    asked: &Effect,
    sort: Sort,
    known: impl FnOnce() -> String,
) -> Result<(usize, Vec<f64>), Error> {
    let is_meant = |cause: &usize| {
        let spec = &kind.causes()[*cause];
        let is_named = match (&asked.name, &spec.column) {
            (None, None) => true,
            (Some(name), Some(column)) => name == column,
            (Some(name), None) => parameters(kind, *cause)[0].0 == *name,
            (None, Some(_)) => false,
        };
        spec.id == asked.id && is_named
    };
    let Some(cause) = hidden(kind, sort).find(is_meant) else {
        return Err(Error::Cause {
            effect: asked.to_string(),
            kind: sort.spec().id,
            known: known(),
        });
    };
    let (parameters, ranges) = (parameters(kind, cause), kind.causes()[cause].ranges());
    let refused = |allowed: String| {
        Err(Error::Value {
            effect: asked.to_string(),
            allowed,
        })
    };
    if asked.values.len() > parameters.len() {
        let names: Vec<&str> = parameters.iter().map(|p| p.0.as_str()).collect();
        return refused(format!(
            "at most {} with commas: {}",
            parameters.len(),
            names.join(",")
        ));
    }
    let mut values = asked.values.clone();
    for ((name, none), (k, (low, high))) in parameters.iter().zip(ranges.iter().enumerate()) {
        let value = *values.get(k).unwrap_or(none);
        if !(value >= *low && value <= *high) {
            return refused(format!(
                "{name} from {} to {}, and not {}",
                short(*low),
                short(*high),
                short(value)
            ));
        }
        if k >= values.len() {
            values.push(value);
        }
    }
    let is_without = |((_, none), value): (&(String, f64), &f64)| {
        value == none || (none.is_finite() && (value - none).abs() <= 1e-9 * none.abs())
    };
    if parameters.iter().zip(&values).all(is_without) {
        let none: Vec<String> = parameters
            .iter()
            .map(|(name, none)| format!("{name} = {}", short(*none)))
            .collect();
        return refused(format!(
            "other than it is without the effect ({}), or nothing is hidden",
            none.join(", ")
        ));
    }
    Ok((cause, kind.causes()[cause].taken(&values)))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use saltus_diagnosis::kinds;

    use super::*;
    use saltus_diagnosis::layout::{Draw, Layout};

    #[test]
    fn effects_read_back() {
        for text in [
            "air-drag=0.1",
            "sensor-offset=x_m:-0.01",
            "exhaust-port=0.04,0.00002",
        ] {
            assert_eq!(text.parse::<Effect>().unwrap().to_string(), text);
        }
        for text in [
            "",
            "none",
            "air-drag",
            "air-drag=",
            "air-drag=much",
            "air-drag=1;2",
            "air-drag=nan",
        ] {
            assert!(text.parse::<Effect>().is_err(), "{text}");
        }
    }

    /// What is taken is what is reported, for every cause of every kind.
    #[test]
    fn taken_and_reported_are_inverse() {
        for sort in [
            Sort::Bench,
            Sort::Hop,
            Sort::Jump,
            Sort::Outcomes,
            Sort::Flight,
            Sort::Vessel,
        ] {
            let layout = Layout::new(sort, true, Some(1), &mut Draw::new(0));
            let robot = saltus_robot::resolve("rats-boom", &[]).unwrap();
            let kind = kinds::build(&layout.experiment, Some(&robot)).unwrap();
            for cause in kind.causes() {
                let inside = |(low, high): (f64, f64)| {
                    let (low, high) = (low.max(-1e3), high.min(1e3));
                    low + 0.3 * (high - low)
                };
                let values: Vec<f64> = cause.parameters.iter().map(|p| inside(p.bounds)).collect();
                let reported: Vec<f64> = cause.report(&values).iter().map(|r| r.1).collect();
                for (a, b) in cause.taken(&reported).iter().zip(&values) {
                    assert!((a - b).abs() <= 1e-12 * b.abs(), "{}: {a} {b}", cause.id);
                }
            }
        }
    }
}
