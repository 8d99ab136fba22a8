//! What is rewarded.

use std::fmt::{Display, Formatter};

/// A part of a reward, for each step unless it says otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Term {
    /// 1 where the wheel's rate is above this one (rad/s), -1 where not.
    ///
    /// Source: thesis 6.2.1.
    Threshold(f64),
    /// The wheel's rate (rad/s).
    ///
    /// Source: thesis 6.1.
    Rate,
    /// The way of the axle (m): in steps of one length proportional to its speed, as in the thesis before a box.
    ///
    /// Source: thesis 6.3.1.
    Travel,
    /// -1 for each second: the less time to the goal, the better.
    Time,
    /// -1 for each kilogram of gas from the supply.
    Gas,
    /// Minus the distance (m/s) of the speed from this one.
    Speed(f64),
    /// -1 at the end where the robot has stalled.
    Stall,
    /// 1 at the end where the goal was reached.
    Arrival,
}

impl Term {
    /// How the terms are written.
    pub const WRITTEN: &'static str =
        "threshold:RATE, rate, travel, time, gas, speed:SPEED, stall or arrival";

    /// The term that is written so, as in `rate` and `threshold:2`.
    pub fn written(text: &str) -> Option<Term> {
        let (name, number) = match text.split_once(':') {
            Some((name, number)) => {
                let number = number.trim().parse().ok().filter(|x: &f64| x.is_finite());
                (name, Some(number?))
            }
            None => (text, None),
        };
        Some(match (name.trim(), number) {
            ("threshold", Some(rate)) => Term::Threshold(rate),
            ("speed", Some(speed)) => Term::Speed(speed),
            ("rate", None) => Term::Rate,
            ("travel", None) => Term::Travel,
            ("time", None) => Term::Time,
            ("gas", None) => Term::Gas,
            ("stall", None) => Term::Stall,
            ("arrival", None) => Term::Arrival,
            _ => return None,
        })
    }
}

impl Display for Term {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        match self {
            Term::Threshold(rate) => write!(f, "threshold:{rate}"),
            Term::Speed(speed) => write!(f, "speed:{speed}"),
            Term::Rate => f.write_str("rate"),
            Term::Travel => f.write_str("travel"),
            Term::Time => f.write_str("time"),
            Term::Gas => f.write_str("gas"),
            Term::Stall => f.write_str("stall"),
            Term::Arrival => f.write_str("arrival"),
        }
    }
}

/// What a step was, for its reward.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Stepped {
    /// Rate of the wheel (rad/s), forwards.
    pub rate: f64,
    /// Speed of the axle (m/s), forwards.
    pub speed: f64,
    /// Way of the axle (m) in it.
    pub way: f64,
    /// How long it took (s).
    pub seconds: f64,
    /// Gas that came from the supply (kg).
    pub gas: f64,
    /// Whether the goal was reached.
    pub arrived: bool,
    /// Whether it is over, and the robot stands.
    pub stalled: bool,
}

/// Terms with their coefficients.
#[derive(Clone, Debug, PartialEq)]
pub struct Reward(pub Vec<(Term, f64)>);

impl Reward {
    pub(crate) fn of(&self, step: &Stepped) -> f64 {
        let one = |term: &Term| match *term {
            Term::Threshold(rate) => {
                if step.rate > rate {
                    1.0
                } else {
                    -1.0
                }
            }
            Term::Rate => step.rate,
            Term::Travel => step.way,
            Term::Time => -step.seconds,
            Term::Gas => -step.gas,
            Term::Speed(wanted) => -(step.speed - wanted).abs(),
            Term::Stall => -f64::from(u8::from(step.stalled)),
            Term::Arrival => f64::from(u8::from(step.arrived)),
        };
        self.0.iter().map(|(term, by)| by * one(term)).sum()
    }

    pub(crate) fn needs_gas(&self) -> bool {
        self.0.iter().any(|(term, _)| *term == Term::Gas)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terms_are_read_as_they_are_written() {
        let all = "threshold:2 rate travel time gas speed:-1.5 stall arrival";
        for text in all.split(' ') {
            assert_eq!(
                Term::written(text).map(|term| term.to_string()).as_deref(),
                Some(text)
            );
        }
        for text in [
            "",
            "threshold",
            "rate:1",
            "speed:nan",
            "speed:inf",
            "speed:x",
            "way",
        ] {
            assert_eq!(Term::written(text), None, "{text}");
        }
    }
}
