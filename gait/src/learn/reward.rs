//! What is rewarded.

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

/// What a step was, for its reward.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Stepped {
    /// Rate of the wheel (rad/s), forwards.
    pub rate: f64,
    /// Speed of the axle (m/s), forwards.
    pub speed: f64,
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
