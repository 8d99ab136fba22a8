//! What is known of a number apart from the data.

/// What is known of a number apart from the data.
#[derive(Clone, Debug, PartialEq)]
pub struct Prior {
    /// What it is believed to be (the unit of its name).
    pub value: f64,
    /// One standard deviation; > 0.
    pub error: f64,
    /// Who says so.
    pub source: Source,
}

/// Who knows a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// The user.
    Stated,
    /// Common sense: in a few words, what makes it known.
    Common(&'static str),
}

impl Prior {
    /// What common sense knows.
    pub(crate) fn common(value: f64, error: f64, why: &'static str) -> Prior {
        Prior {
            value,
            error,
            source: Source::Common(why),
        }
    }
}
