//! Why there is no answer.

use core::fmt;

/// Why there is no answer. It is never a clamped value instead.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Reason {
    /// A rate, an angle, a distance or a landing height lies outside what table, curve or map was
    /// made for.
    OutOfTable = 1,
    /// It lies inside, but no jump does what is asked: not reached, not cleared, or the robot comes
    /// to rest before its firing angle.
    Infeasible = 2,
    /// A number given is not a number, infinite, or no such quantity: a lean beyond the horizontal,
    /// a negative width.
    SensorInvalid = 3,
    /// The obstacle is farther than the coming touch-downs that are looked at: ask again at the
    /// next touch-down.
    AskLater = 4,
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Reason::OutOfTable => "outside the table",
            Reason::Infeasible => "infeasible",
            Reason::SensorInvalid => "not a measurement",
            Reason::AskLater => "too far yet: ask again at the next touch-down",
        })
    }
}

impl core::error::Error for Reason {}
