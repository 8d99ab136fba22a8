//! The thesis' firing laws, by their names.

use saltus_controller::run::{Knot, Law};

use crate::GaitError;
use crate::error::{ensure, require};
use crate::learnt::Learnt;

/// How a robot's firing angle is found.
#[derive(Clone, Debug, PartialEq)]
pub enum Program {
    /// One firing angle (rad).
    ///
    /// Source: thesis 5.1.2.
    Fixed {
        /// α_f (rad).
        firing_angle: f64,
    },
    /// From one firing angle to another over time: A tanh(B t − C) + D.
    ///
    /// Source: thesis 5.1.3, open loop; figure 5.5.
    OpenLoop {
        /// α_f at the start (rad), nearly.
        first: f64,
        /// α_f in the end (rad).
        last: f64,
        /// B (1/s).
        slope: f64,
        /// How the thesis' C = 3.0 is read.
        centre: Centre,
    },
    /// Lines over the rate.
    ///
    /// Source: thesis 5.1.3, closed loop; figure 5.6.
    ClosedLoop(Lines),
    /// A curve over the rate through these knots: rate (rad/s), α_f (rad), t_v (s).
    Curve(Vec<[f64; 3]>),
    /// A table that was learnt; setup's filter, first firings, speeds and jumps have no part in it.
    Learnt(Learnt),
}

/// The reading of C = 3.0 in A tanh(B t − C) + D.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Centre {
    /// As printed, a number: the middle of the change is at C/B, 1.43 s.
    Printed(f64),
    /// As the text says, seconds: tanh(B (t − C)).
    Seconds(f64),
}

/// A closed loop: α_f over the rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lines {
    /// One line from rest.
    One {
        /// α_f at rest (rad).
        first: f64,
        /// α_f (rad) at the rate `at` (rad/s) and beyond.
        last: f64,
        /// That rate (rad/s).
        at: f64,
    },
    /// Two lines.
    Two {
        /// α_f at rest (rad).
        first: f64,
        /// Slope of the first line (s).
        slope: f64,
        /// Rate ω_s (rad/s) at which the second begins.
        switch: f64,
        /// α_f (rad) at the rate `at` and beyond.
        last: f64,
        /// That rate (rad/s).
        at: f64,
        /// Whether the second line is E ω + F as printed, with E = (α_ff − α_fi)/ω_f and F = C ω_s + D,
        /// where D = α_fi, which makes a jump at ω_s; else both meet there.
        jumps: bool,
    },
}

impl Lines {
    /// The knots: rate (rad/s) and α_f (rad).
    pub fn knots(&self) -> Vec<[f64; 2]> {
        match *self {
            Lines::One { first, last, at } => vec![[0.0, first], [at, last]],
            Lines::Two {
                first,
                slope,
                switch,
                last,
                at,
                jumps,
            } => {
                let meets = first + slope * switch;
                if jumps {
                    let line = |rate: f64| (last - first) / at * rate + slope * switch + first;
                    vec![
                        [0.0, first],
                        [switch, meets],
                        [switch, line(switch)],
                        [at, line(at)],
                    ]
                } else {
                    vec![[0.0, first], [switch, meets], [at, last]]
                }
            }
        }
    }
}

/// Legs of the robots on which [`Smooth`] was sought.
const SOUGHT_WITH: u32 = 5;

/// One smooth law of six parameters: α_f and t_v each go from their value at rest to that at speed
/// as 1/(1 + (ω/w)²) falls.
///
/// Source: thesis 8.3.2 and the end of 5.1.3, which propose one curve in place of two lines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Smooth {
    /// α_f at rest (rad), at speed (rad), and the rate (rad/s) at which it is half way.
    pub firing_angle: [f64; 3],
    /// t_v at rest (s), at speed (s), and the rate (rad/s) at which it is half way.
    pub valve_open: [f64; 3],
}

impl Smooth {
    /// The quickest from rest over 1.6 m, and the most sparing of gas, on robots drawn around
    /// `rats-run`: the study `smooth` finds them, and scores them on others.
    pub const QUICK: Smooth = Smooth {
        firing_angle: [0.6, -0.3, 10.5114],
        valve_open: [0.0637, 0.0284, 10.9578],
    };
    /// The most sparing.
    pub const SPARING: Smooth = Smooth {
        firing_angle: [0.5357, -0.1553, 6.8582],
        valve_open: [0.0529, 0.02, 5.3142],
    };

    /// α_f (rad) and t_v (s) at a rate (rad/s).
    pub fn at(&self, rate: f64) -> [f64; 2] {
        let of =
            |[first, last, half]: [f64; 3]| last + (first - last) / (1.0 + (rate / half).powi(2));
        [of(self.firing_angle), of(self.valve_open)]
    }

    /// The law as a curve of straight lines between rates 0.5 rad/s apart, for a robot with five legs.
    pub fn program(&self) -> Program {
        self.for_legs(SOUGHT_WITH)
    }

    /// The same for a robot with so many `legs`. Of more than five, which are closer, leans are smaller in proportion: the
    /// rear leg of a robot that stands leans by half a pitch, and would never come to the firing angle of one with five.
    pub fn for_legs(&self, legs: u32) -> Program {
        let closer = (f64::from(SOUGHT_WITH) / f64::from(legs)).min(1.0);
        let knot = |k: u32| {
            let rate = 0.5 * f64::from(k);
            let [angle, open] = self.at(rate);
            [rate, closer * angle, open]
        };
        Program::Curve((0..=80).map(knot).collect())
    }
}

/// A program as the controller takes it, with what it refers to.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Compiled {
    Time(Law<'static, f64>),
    Knots(Vec<Knot<f64>>),
}

impl Compiled {
    pub(crate) fn law(&self) -> Law<'_, f64> {
        match self {
            Compiled::Time(law) => *law,
            Compiled::Knots(knots) => Law::Lines(knots),
        }
    }
}

impl Program {
    /// The program with the valve opening time `valve_open` (s), where it does not say one itself;
    /// its angles lie in the zone that begins at `zone` (rad) and is `pitch` (rad) wide.
    pub(crate) fn compile(
        &self,
        valve_open: f64,
        (zone, pitch): (f64, f64),
    ) -> Result<Compiled, GaitError> {
        open_time(valve_open)?;
        let angle = |x: f64| {
            let inside = (zone..zone + pitch).contains(&x);
            let allowed = format!(
                "in the active zone, from {zone} to below {:.4} rad",
                zone + pitch
            );
            require(inside, "firing angle (rad)", x, allowed)
        };
        let knot = |rate: f64, firing_angle: f64, valve_open: f64| Knot {
            rate,
            firing_angle,
            valve_open,
        };
        match self {
            Program::Fixed { firing_angle } => {
                angle(*firing_angle)?;
                Ok(Compiled::Knots(vec![knot(0.0, *firing_angle, valve_open)]))
            }
            Program::OpenLoop {
                first,
                last,
                slope,
                centre,
            } => {
                angle(*first)?;
                angle(*last)?;
                ensure! { "B (1/s)", *slope, *slope > 0.0 && slope.is_finite() => "above 0"; }
                let shift = match *centre {
                    Centre::Printed(c) => c,
                    Centre::Seconds(c) => slope * c,
                };
                require(shift.is_finite(), "C", shift, "a number")?;
                Ok(Compiled::Time(Law::OverTime {
                    amplitude: 0.5 * (last - first),
                    slope: *slope,
                    shift,
                    level: 0.5 * (last + first),
                    valve_open,
                }))
            }
            Program::ClosedLoop(lines) => {
                let knots = lines.knots();
                knots.iter().try_for_each(|k| angle(k[1]))?;
                rising(knots.iter().map(|k| k[0]))?;
                let knots = knots.into_iter().map(|[rate, a]| knot(rate, a, valve_open));
                Ok(Compiled::Knots(knots.collect()))
            }
            Program::Curve(knots) => {
                let count = knots.len() as f64;
                require(!knots.is_empty(), "knots of a law", count, "at least one")?;
                for [_, firing_angle, open] in knots {
                    angle(*firing_angle)?;
                    open_time(*open)?;
                }
                rising(knots.iter().map(|k| k[0]))?;
                let knots = knots.iter().map(|&[rate, a, open]| knot(rate, a, open));
                Ok(Compiled::Knots(knots.collect()))
            }
            Program::Learnt(learnt) => {
                learnt.check()?;
                // Without knots no leg is fired but by what was learnt.
                Ok(Compiled::Knots(Vec::new()))
            }
        }
    }
}

fn open_time(valve_open: f64) -> Result<(), GaitError> {
    let sound = (0.0..=1.0).contains(&valve_open);
    require(sound, "valve opening time (s)", valve_open, "from 0 to 1 s")
}

fn rising(mut rates: impl Iterator<Item = f64>) -> Result<(), GaitError> {
    let mut before = f64::NEG_INFINITY;
    rates.try_for_each(|rate| {
        let sound = rate >= before && rate.is_finite();
        let allowed = format!("a number not below the one before it, {before}");
        require(sound, "rate of a law's knot (rad/s)", rate, allowed)?;
        before = rate;
        Ok(())
    })
}
