//! What there is to know of one term, and the questions that follow from it.

use std::fmt;

use super::{TABLE, Term};
use crate::Robot;
use crate::domain::Domain;
use crate::units::Quantity;

/// How a term is found in a robot.
#[derive(Clone, Copy)]
pub(super) struct Lens {
    /// Whether the robot has the part that the term belongs to.
    pub(super) has: fn(&Robot) -> bool,
    pub(super) get: fn(&Robot) -> Option<f64>,
    pub(super) set: fn(&mut Robot, f64),
}

/// Whether the planar model of tables, laws, maps and plans has a term.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Plane {
    /// It has.
    In,
    /// Only the multi-body simulation has, and a jump in the plane feels it.
    Out,
    /// Only the multi-body simulation has, and a jump in the plane hardly feels it.
    Beside,
}

/// A cause that a diagnosis can name.
#[derive(Clone, Copy)]
pub struct Cause {
    /// Its id.
    pub id: &'static str,
    /// What is so in the machine and not in the simulation; empty for the later terms of a cause
    /// with several. Terms of one id with a sentence each are forms that the cause may have.
    pub sentence: &'static str,
    /// The robots in which it is looked for.
    pub seen_in: fn(&Robot) -> bool,
    /// How the term is fitted in a robot in which it has a value.
    fit: fn(&Robot, f64) -> Fit,
}

/// How a term is fitted to measured data.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// Value of the parameter without the effect.
    pub neutral: f64,
    /// Least and greatest value of the parameter.
    pub bounds: (f64, f64),
    /// A small change of the parameter, for difference quotients.
    pub scale: f64,
    /// Where searches begin, beside `neutral`.
    pub starts: Vec<f64>,
    /// What the parameter is.
    pub form: Form,
}

/// What a fitted parameter is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// The term itself.
    Direct,
    /// The inverse of the term, of this name with its unit.
    Inverse(&'static str),
}

/// A term that is fitted as it is.
pub(super) fn direct(neutral: f64, bounds: (f64, f64), scale: f64, starts: &[f64]) -> Fit {
    let starts = starts.to_vec();
    Fit {
        neutral,
        bounds,
        scale,
        starts,
        form: Form::Direct,
    }
}

/// A term, infinite without the effect, whose inverse is fitted.
pub(super) fn inverse(name: &'static str, bounds: (f64, f64), scale: f64, starts: &[f64]) -> Fit {
    Fit {
        form: Form::Inverse(name),
        ..direct(0.0, bounds, scale, starts)
    }
}

/// What there is to know of a term.
#[derive(Clone, Copy)]
pub struct Spec {
    /// Dotted key without its unit.
    pub key: &'static str,
    /// What it measures, with the units that a file may use.
    pub quantity: Quantity,
    /// Whether the planar model has it.
    pub plane: Plane,
    /// The cause that it stands for.
    pub cause: Option<Cause>,
    /// Values to which the tests' laboratory turns it, on the thesis' robot on its boom.
    pub hidden: &'static [f64],
    /// How far the tests' random robots turn it, as part of what is natural for its quantity on the
    /// robot: a force as part of that of the drive. 0: by other rules.
    pub drawn_to: f64,
    /// A line of the page of keys, and what is said of it.
    /// A line of a robot file with it; empty: it is no key of a pneumatic robot.
    pub example: &'static str,
    /// What it means.
    pub note: &'static str,
    off: fn(&Robot) -> Option<f64>,
    domain: fn(&Robot) -> Domain,
    lens: Lens,
}

impl Spec {
    pub(super) const fn needed(key: &'static str, quantity: Quantity, lens: Lens) -> Spec {
        Spec {
            key,
            quantity,
            plane: Plane::In,
            cause: None,
            hidden: &[],
            drawn_to: 0.0,
            example: "",
            note: "",
            off: |_| None,
            domain: |_| Domain::NON_NEGATIVE,
            lens,
        }
    }

    pub(super) const fn positive(key: &'static str, quantity: Quantity, lens: Lens) -> Spec {
        Spec::needed(key, quantity, lens).within(|_| Domain::POSITIVE)
    }

    pub(super) const fn optional(key: &'static str, quantity: Quantity, lens: Lens) -> Spec {
        Spec::needed(key, quantity, lens).without(|_| Some(0.0))
    }

    pub(super) const fn within(self, domain: fn(&Robot) -> Domain) -> Spec {
        Spec { domain, ..self }
    }

    pub(super) const fn without(self, off: fn(&Robot) -> Option<f64>) -> Spec {
        Spec { off, ..self }
    }

    pub(super) const fn shown(self, example: &'static str, note: &'static str) -> Spec {
        Spec {
            example,
            note,
            ..self
        }
    }

    pub(super) const fn out_of_plane(self) -> Spec {
        Spec {
            plane: Plane::Out,
            ..self
        }
    }

    pub(super) const fn beside_plane(self) -> Spec {
        Spec {
            plane: Plane::Beside,
            ..self
        }
    }

    pub(super) const fn cause(
        self,
        id: &'static str,
        sentence: &'static str,
        fit: fn(&Robot, f64) -> Fit,
    ) -> Spec {
        Spec {
            cause: Some(Cause {
                id,
                sentence,
                seen_in: |_| true,
                fit,
            }),
            ..self
        }
    }

    /// Only robots for which `seen_in` holds show the cause.
    pub(super) const fn seen_in(self, seen_in: fn(&Robot) -> bool) -> Spec {
        let cause = match self.cause {
            Some(cause) => Some(Cause { seen_in, ..cause }),
            None => None,
        };
        Spec { cause, ..self }
    }

    pub(super) const fn hidden(self, hidden: &'static [f64]) -> Spec {
        Spec { hidden, ..self }
    }

    pub(super) const fn drawn_to(self, drawn_to: f64) -> Spec {
        Spec { drawn_to, ..self }
    }

    /// The table of a robot file that it stands in, dotted.
    pub fn section(&self) -> &'static str {
        self.key.rsplit_once('.').map_or("", |(section, _)| section)
    }

    /// Its key in that table, without its unit.
    pub fn stem(&self) -> &'static str {
        self.key.rsplit_once('.').map_or(self.key, |(_, stem)| stem)
    }
}

impl Term {
    /// What there is to know of it.
    pub fn spec(self) -> &'static Spec {
        &TABLE[self as usize]
    }

    /// Its dotted key in `robot`, with its SI unit.
    pub fn key(self, robot: &Robot) -> String {
        let stem = self.stem(robot);
        let (section, unit) = (self.spec().section(), self.spec().quantity.units[0].0);
        format!("{section}.{stem}{unit}")
    }

    /// Its key in its table of the file of `robot`, without its unit.
    pub(crate) fn stem(self, robot: &Robot) -> &'static str {
        match self {
            Term::Delay if robot.leg.cylinder().is_none() => "release_delay",
            _ => self.spec().stem(),
        }
    }

    /// Whether `robot` has the part that it belongs to.
    pub fn applies(self, robot: &Robot) -> bool {
        (self.spec().lens.has)(robot) && (robot.space.is_none() || !self.is_of_a_plane())
    }

    /// Whether it belongs to a robot in its plane alone: a wheel on an axle, and what is across its way. A robot in space
    /// has six numbers of its inertia, and its centre of mass, elsewhere.
    fn is_of_a_plane(self) -> bool {
        matches!(
            self,
            Term::Inertia
                | Term::Imbalance
                | Term::ImbalanceAngle
                | Term::AxleFriction
                | Term::AcrossFriction
        )
    }

    /// Its value in `robot` (SI); none where the part that it belongs to is not there, or off.
    pub fn of(self, robot: &Robot) -> Option<f64> {
        (self.spec().lens.get)(robot).filter(|_| self.applies(robot))
    }

    /// Sets it in `robot` (SI), with the optional part that it belongs to; nothing where it does
    /// not apply. The value is not checked.
    pub fn set(self, robot: &mut Robot, value: f64) {
        if self.applies(robot) {
            (self.spec().lens.set)(robot, value);
        }
    }

    /// The values that it may have in `robot`.
    pub fn domain(self, robot: &Robot) -> Domain {
        (self.spec().domain)(robot)
    }

    /// Its value in `robot` without its effect, which a file may leave out; none for what no file
    /// leaves out.
    pub fn off(self, robot: &Robot) -> Option<f64> {
        (self.spec().off)(robot)
    }

    /// How it is fitted to what `robot` measured; none if it stands for no cause.
    pub fn fit(self, robot: &Robot) -> Option<Fit> {
        let now = self.of(robot).or(self.off(robot)).unwrap_or(0.0);
        self.spec().cause.map(|cause| (cause.fit)(robot, now))
    }
}

impl fmt::Debug for Spec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.key)
    }
}
