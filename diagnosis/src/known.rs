//! What is known of parameters apart from the data, and what that does to a cause.

use saltus_robot::section::edits;
use saltus_robot::terms::Term;

use crate::kind::{Cause, Terms};
use crate::policy::POLICY;
use crate::prior::{Prior, Source};

/// What a user says to know.
#[derive(Clone, Debug, PartialEq)]
pub struct Known {
    /// The parameter: its name, or the last part of it; of a sensor `COLUMN.NAME`; or the id of a
    /// cause that has one parameter.
    pub name: String,
    /// What it is believed to be (the unit of its name).
    pub value: f64,
    /// One standard deviation; > 0.
    pub error: f64,
}

/// Why something cannot be known.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum KnownError {
    /// No cause of the kind has such a parameter.
    #[error("known {name}: no cause has that parameter; the nearest is {nearest}")]
    Unknown {
        /// The name.
        name: String,
        /// The nearest name.
        nearest: String,
    },
    /// Several have.
    #[error("known {name}: could be {could}: give all of the name")]
    Ambiguous {
        /// The name.
        name: String,
        /// Which ones.
        could: String,
    },
    /// Physics forbids it.
    #[error("known {name} = {value}: must be from {low} to {high}")]
    Impossible {
        /// The name.
        name: String,
        /// The value.
        value: f64,
        /// Least that physics allows.
        low: f64,
        /// Greatest that physics allows.
        high: f64,
    },
}

impl Cause {
    /// How many standard deviations lie between what is known and what is reported where the
    /// parameters are `values`; 0 where nothing is known.
    pub(crate) fn deviations(&self, values: &[f64]) -> f64 {
        let reported = self.report(values);
        let square =
            |(k, prior): &(usize, Prior)| ((reported[*k].1 - prior.value) / prior.error).powi(2);
        self.priors.iter().map(square).sum::<f64>().sqrt()
    }

    /// Logarithm of the probability of `values` of its parameters by what is known: half the square of
    /// the standard deviations. What is known may be wrong itself: beyond a contradiction it counts in
    /// proportion (Huber).
    pub(crate) fn by_prior(&self, values: &[f64]) -> f64 {
        let away = self.deviations(values);
        let near = away.min(POLICY.contradiction);
        -near * (away - 0.5 * near)
    }

    /// The names by which what is reported can be known.
    fn names(&self) -> Vec<String> {
        let neutral: Vec<f64> = self.parameters.iter().map(|p| p.neutral).collect();
        let name = |(name, _): (String, f64)| match &self.column {
            Some(column) => format!("{column}.{name}"),
            None => name,
        };
        self.report(&neutral).into_iter().map(name).collect()
    }
}

/// `causes` with what is known of their parameters, in place of what common sense knows of these;
/// and the names that are parameters of a robot, and of none of these causes.
///
/// # Errors
/// [`KnownError`] where a name is of no parameter, or of several, or physics forbids the value.
pub(crate) fn inform<'k>(
    causes: &[Cause],
    known: &'k [Known],
) -> Result<(Vec<Cause>, Vec<&'k str>), KnownError> {
    let (mut causes, mut unused) = (causes.to_vec(), Vec::new());
    for one in known {
        let (cause, parameter) = match place(&causes, &one.name) {
            Err(KnownError::Unknown { .. }) if is_of_robots(&one.name) => {
                unused.push(one.name.as_str());
                continue;
            }
            place => place?,
        };
        let (low, high) = causes[cause].ranges()[parameter];
        if !(low..=high).contains(&one.value) {
            return Err(KnownError::Impossible {
                name: one.name.clone(),
                value: one.value,
                low,
                high,
            });
        }
        let priors = &mut causes[cause].priors;
        priors.retain(|(k, _)| *k != parameter);
        let prior = Prior {
            value: one.value,
            error: one.error,
            source: Source::Stated,
        };
        priors.push((parameter, prior));
    }
    Ok((causes, unused))
}

/// Whether `name` is a parameter that robots have, in SI: its whole key or the last part of it.
fn is_of_robots(name: &str) -> bool {
    let last = name.rsplit('.').next().unwrap_or(name);
    Term::ALL.iter().any(|term| {
        let spec = term.spec();
        let own = spec.stem().rsplit('.').next().unwrap_or(spec.stem());
        let unit = last.strip_prefix(own);
        unit.is_some_and(|unit| unit == spec.quantity.units[0].0)
    })
}

/// The key in SI of the robot's number that `name` gives in another unit, if it does.
fn in_si(name: &str) -> Option<String> {
    let (before, last) = name
        .rsplit_once('.')
        .map_or(("", name), |(a, _)| name.split_at(a.len() + 1));
    let of = |term: &Term| {
        let spec = term.spec();
        let own = spec.stem().rsplit('.').next().unwrap_or(spec.stem());
        let unit = last.strip_prefix(own)?;
        let is_unit = spec.quantity.units.iter().any(|(known, ..)| *known == unit);
        is_unit.then(|| format!("{before}{own}{}", spec.quantity.units[0].0))
    };
    Term::ALL.iter().find_map(of)
}

/// That every name of `known` is of one parameter of `causes`, and physics allows its value; the
/// names that are parameters of a robot, and of none of these causes.
///
/// # Errors
/// [`KnownError`] of the first where it is not so.
pub fn check_known<'k>(causes: &[Cause], known: &'k [Known]) -> Result<Vec<&'k str>, KnownError> {
    inform(causes, known).map(|told| told.1)
}

/// The cause and its parameter that `name` means.
fn place(causes: &[Cause], name: &str) -> Result<(usize, usize), KnownError> {
    let mut all: Vec<(String, (usize, usize))> = Vec::new();
    for (c, cause) in causes.iter().enumerate() {
        let names = cause.names();
        if let ([_], None) = (&names[..], &cause.column) {
            all.push((cause.id.to_owned(), (c, 0)));
        }
        all.extend(names.into_iter().zip((0..).map(|k| (c, k))));
    }
    let ends = |own: &String| {
        own.strip_suffix(name)
            .is_some_and(|rest| rest.ends_with('.'))
    };
    let mut found: Vec<&(String, (usize, usize))> = all.iter().filter(|n| n.0 == name).collect();
    if found.is_empty() {
        found = all.iter().filter(|n| ends(&n.0)).collect();
    }
    found.dedup_by_key(|n| n.1);
    match found[..] {
        [one] => Ok(one.1),
        [] => {
            let near = all.iter().min_by_key(|n| edits(&n.0, name));
            let nearest = in_si(name).or_else(|| near.map(|n| n.0.clone()));
            Err(KnownError::Unknown {
                name: name.to_owned(),
                nearest: nearest.unwrap_or_default(),
            })
        }
        _ => {
            let names: Vec<&str> = found.iter().map(|n| n.0.as_str()).collect();
            Err(KnownError::Ambiguous {
                name: name.to_owned(),
                could: names.join(" or "),
            })
        }
    }
}

/// What of a cause's parameters is known, and how far from it a model has them.
#[derive(Clone, Debug, PartialEq)]
pub struct Deviation {
    /// The parameter, as it is reported.
    pub name: String,
    /// What the model makes of it.
    pub value: f64,
    /// What is known of it.
    pub prior: Prior,
}

impl Deviation {
    /// Standard deviations from what is known.
    pub fn size(&self) -> f64 {
        (self.value - self.prior.value).abs() / self.prior.error
    }
}

/// What is known of the parameters of cause number `cause`, beside what `terms` have.
pub(crate) fn deviations(causes: &[Cause], cause: usize, terms: &Terms) -> Vec<Deviation> {
    let reported = causes[cause].report(terms.of(cause));
    let of = |(k, prior): &(usize, Prior)| Deviation {
        name: reported[*k].0.clone(),
        value: reported[*k].1,
        prior: prior.clone(),
    };
    causes[cause].priors.iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kind::Parameter;

    fn cause(id: &'static str, column: Option<&str>, name: &str) -> Cause {
        let parameter = Parameter {
            name: name.into(),
            neutral: 1.0,
            bounds: (0.1, 10.0),
            scale: 0.01,
            starts: Vec::new(),
        };
        Cause {
            column: column.map(Into::into),
            ..Cause::one(id, parameter)
        }
    }

    fn known(name: &str, value: f64) -> Known {
        Known {
            name: name.into(),
            value,
            error: 0.02,
        }
    }

    fn causes() -> Vec<Cause> {
        vec![
            cause("gravity", None, "environment.gravity_m_s2"),
            cause("mass", None, "body.mass_kg"),
            cause("boom-inertia", None, "boom.mass_kg"),
            cause("encoder-scale", Some("y_m"), "gain"),
        ]
    }

    #[test]
    fn a_name_is_whole_or_its_last_part_or_an_id() {
        for (name, cause) in [
            ("environment.gravity_m_s2", 0),
            ("gravity_m_s2", 0),
            ("gravity", 0),
            ("mass", 1),
            ("boom.mass_kg", 2),
            ("y_m.gain", 3),
        ] {
            let known = [known(name, 2.0)];
            let told = inform(&causes(), &known).expect(name).0;
            let with: Vec<usize> = (0..4).filter(|c| !told[*c].priors.is_empty()).collect();
            assert_eq!(with, [cause], "{name}");
        }
    }

    #[test]
    fn what_cannot_be_known_is_refused() {
        let refused = |name, value| {
            let known = [known(name, value)];
            let refused = check_known(&causes(), &known);
            refused.expect_err("an error").to_string()
        };
        assert!(refused("gravty", 1.0).ends_with("the nearest is gravity"));
        let both = "known mass_kg: could be body.mass_kg or boom.mass_kg: give all of the name";
        assert_eq!(refused("mass_kg", 1.0), both);
        assert!(refused("gravity", -9.8).ends_with("must be from 0.1 to 10"));
        // Another kind of experiment would use it.
        let unused = [known("leg.bore_m", 0.02), known("mass", 2.0)];
        assert_eq!(check_known(&causes(), &unused), Ok(vec!["leg.bore_m"]));
    }

    #[test]
    fn what_is_known_counts_as_a_square_and_beyond_a_contradiction_in_proportion() {
        let known = [known("gravity", 2.0)];
        let told = &inform(&causes(), &known).expect("known").0[0];
        let far = POLICY.contradiction * (10.0 - 0.5 * POLICY.contradiction);
        for (value, log) in [(2.0, 0.0), (2.06, -4.5), (2.2, -far)] {
            assert!((told.by_prior(&[value]) - log).abs() < 1e-9, "{value}");
        }
    }
}
