//! How strong a hidden effect is: dials from off to as far as physics goes.

use std::borrow::Cow;

/// How a number depends on the strength s of an effect, from 0, off, to 1.
#[derive(Clone, Copy, Debug)]
pub(super) enum Way {
    /// `neutral` + s (`most` − `neutral`).
    Linear {
        /// Off.
        neutral: f64,
        /// As far as it goes.
        most: f64,
    },
    /// `most`/s: a stiffness or a coefficient that is infinite where the effect is off.
    Inverse(f64),
    /// `most`/√s: the damper beside such a stiffness.
    Root(f64),
    /// Whatever the strength.
    Fixed(f64),
}

/// A number that an effect changes.
#[derive(Clone, Debug)]
pub(super) struct Dial {
    /// What it is called: a key of the robot file, or a column and what is done to it.
    pub key: Cow<'static, str>,
    /// How it depends on the strength.
    pub way: Way,
}

impl Dial {
    /// From `neutral` to `most`.
    pub(super) fn linear(key: impl Into<Cow<'static, str>>, neutral: f64, most: f64) -> Dial {
        Dial {
            key: key.into(),
            way: Way::Linear { neutral, most },
        }
    }

    /// Off at 0.
    pub(super) fn up_to(key: impl Into<Cow<'static, str>>, most: f64) -> Dial {
        Dial::linear(key, 0.0, most)
    }

    /// Infinite where off.
    pub(super) fn inverse(key: impl Into<Cow<'static, str>>, most: f64) -> Dial {
        Dial {
            key: key.into(),
            way: Way::Inverse(most),
        }
    }

    /// The damper of an inverse stiffness.
    pub(super) fn root(key: impl Into<Cow<'static, str>>, most: f64) -> Dial {
        Dial {
            key: key.into(),
            way: Way::Root(most),
        }
    }

    /// Always `value`.
    pub(super) fn fixed(key: impl Into<Cow<'static, str>>, value: f64) -> Dial {
        Dial {
            key: key.into(),
            way: Way::Fixed(value),
        }
    }

    /// Its value at strength `s`.
    pub(super) fn at(&self, s: f64) -> f64 {
        match self.way {
            Way::Linear { neutral, most } => neutral + s * (most - neutral),
            Way::Inverse(most) => most / s,
            Way::Root(most) => most / s.sqrt(),
            Way::Fixed(value) => value,
        }
    }
}

/// Values of dials by their key; what is not there is off.
#[derive(Clone, Debug, Default)]
pub(super) struct Hidden(Vec<(Cow<'static, str>, f64)>);

impl Hidden {
    /// Each of `dials` at strength `s`.
    pub(super) fn of(dials: &[Dial], s: f64) -> Hidden {
        Hidden(
            dials
                .iter()
                .map(|dial| (dial.key.clone(), dial.at(s)))
                .collect(),
        )
    }

    /// Adds what `other` has.
    pub(super) fn add(&mut self, other: &Hidden) {
        self.0.extend_from_slice(&other.0);
    }

    /// The value of `key`, `off` where it is not hidden.
    pub(super) fn get(&self, key: &str, off: f64) -> f64 {
        self.0
            .iter()
            .find(|(known, _)| *known == key)
            .map_or(off, |(_, value)| *value)
    }

    /// The value of `key`, 0 where it is not hidden.
    pub(super) fn or_zero(&self, key: &str) -> f64 {
        self.get(key, 0.0)
    }

    /// All of them.
    pub(super) fn all(&self) -> &[(Cow<'static, str>, f64)] {
        &self.0
    }
}
