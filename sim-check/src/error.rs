//! What can be wrong with a mechanism, or with where it starts.

use std::fmt::Display;

use saltus_numeric::plain;

/// A mechanism that cannot be, a start that cannot be, or a motion that cannot go on.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SimError {
    /// A number is outside its domain.
    #[error("{name} = {}: must be {allowed}", plain(*value))]
    Input {
        /// What was given, with its unit.
        name: String,
        /// Its value.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A list has the wrong length.
    #[error("{name}: {given} numbers given, {wanted} wanted")]
    Length {
        /// What was given.
        name: &'static str,
        /// How many there are.
        given: usize,
        /// How many there must be.
        wanted: usize,
    },
    /// A joint can move nothing: the bodies beyond it have no mass, or no inertia about it.
    #[error(
        "joint of body '{body}': what it moves has no inertia along it; give the bodies beyond it \
         mass"
    )]
    NoInertia {
        /// The body that the joint carries.
        body: String,
    },
    /// The start has a point inside the ground or an obstacle.
    #[error(
        "point '{point}' starts {} m inside {surface}; a start must not penetrate by more \
         than {} m",
        plain(*depth),
        plain(*allowed)
    )]
    Penetration {
        /// Name of the contact point.
        point: String,
        /// Name of the surface.
        surface: String,
        /// How deep it is (m).
        depth: f64,
        /// Greatest depth (m) that counts as touching.
        allowed: f64,
    },
    /// A joint starts beyond an end stop.
    #[error("joint of body '{body}' starts at {}, outside its stops {} to {}", plain(*value), plain(*low), plain(*high))]
    BeyondStop {
        /// The body that the joint carries.
        body: String,
        /// Position (m or rad).
        value: f64,
        /// Lower stop (m or rad).
        low: f64,
        /// Upper stop (m or rad).
        high: f64,
    },
    /// No contact forces agree with Coulomb's law and rigid bodies.
    #[error(
        "t = {} s: the contact cannot be solved: no forces were found that obey the laws of motion with {}. \
         On rigid ground there may be none (Painlevé's paradox): set ground.static_friction to a smaller \
         number, such as 0.8, or make the ground compliant: ground.stiffness_n_per_m. On compliant ground take shorter steps",
        plain(*time),
        limit_of(*friction)
    )]
    Inconsistent {
        /// When (s).
        time: f64,
        /// Greatest friction coefficient of the ground.
        friction: f64,
    },
    /// More events than a motion can have.
    #[error("t = {} s: more than {limit} events within {span} s; the last was: {last}", plain(*time))]
    TooManyEvents {
        /// When (s).
        time: f64,
        /// The greatest number that is allowed.
        limit: usize,
        /// In which time (s).
        span: f64,
        /// The last of them.
        last: String,
    },
    /// More steps than were allowed.
    #[error("t = {} s: {limit} steps were not enough; what moves is too stiff or too fast", plain(*time))]
    TooManySteps {
        /// When (s).
        time: f64,
        /// The number of steps allowed.
        limit: usize,
    },
    /// The integrator cannot go on.
    #[error(
        "t = {} s: the motion cannot be integrated further (step of {} s); a number is \
         infinite or not one",
        plain(*time),
        plain(*step)
    )]
    Stuck {
        /// When (s).
        time: f64,
        /// The step (s).
        step: f64,
    },
    /// A fixed step has led to numbers that are none, or beyond all bounds.
    #[error(
        "t = {} s: the motion diverges in fixed steps of {} s; take shorter ones, or \
         adaptive ones",
        plain(*time),
        plain(*step)
    )]
    Diverged {
        /// When (s).
        time: f64,
        /// The step (s).
        step: f64,
    },
}

/// A friction coefficient in words.
fn limit_of(friction: f64) -> String {
    if friction.is_finite() {
        format!("a friction coefficient of {friction}")
    } else {
        "no limit of friction".into()
    }
}

/// [`SimError::Input`] unless `holds`.
pub(crate) fn require(
    holds: bool,
    name: impl Display,
    value: f64,
    allowed: &'static str,
) -> Result<(), SimError> {
    if holds {
        return Ok(());
    }
    Err(SimError::Input {
        name: name.to_string(),
        value,
        allowed,
    })
}

/// [`SimError::Length`] unless a list is as long as it must be.
pub(crate) fn length(name: &'static str, given: usize, wanted: usize) -> Result<(), SimError> {
    if given == wanted {
        return Ok(());
    }
    Err(SimError::Length {
        name,
        given,
        wanted,
    })
}

/// [`SimError::Input`] for numbers that must be finite.
pub(crate) fn finite(name: impl Display, values: &[f64]) -> Result<(), SimError> {
    match values.iter().find(|x| !x.is_finite()) {
        Some(x) => require(false, name, *x, "finite"),
        None => Ok(()),
    }
}

/// The same for a number that must be finite and > 0.
pub(crate) fn positive(name: impl Display, x: f64) -> Result<(), SimError> {
    require(x > 0.0 && x.is_finite(), name, x, "a finite number > 0")
}

/// The same for a number that must be finite and ≥ 0.
pub(crate) fn not_negative(name: impl Display, x: f64) -> Result<(), SimError> {
    require(x >= 0.0 && x.is_finite(), name, x, "a finite number ≥ 0")
}

/// Returns the error of the first number that is not allowed. Each has a row: name, value, whether
/// it is allowed, and what is.
macro_rules! ensure {
    ($($name:expr, $value:expr, $holds:expr => $allowed:expr;)+) => {{
        $($crate::error::require($holds, $name, $value, $allowed)?;)+
    }};
}
pub(crate) use ensure;
