//! What is measured of a ball, cycle by cycle, for files.

use super::Ball;

/// What the sensors of a ball say, the switches in its feet, and its valves as they are commanded: a row a cycle.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// Until when (s) the valve of each leg is commanded open.
    open_until: Vec<f64>,
}

impl Measured {
    /// Of a robot with so many legs, all valves shut.
    pub fn new(legs: usize) -> Measured {
        Measured {
            open_until: vec![f64::NEG_INFINITY; legs],
        }
    }

    /// Names of the columns, which end with their unit: the time, rates about the body's axes, specific force along them,
    /// whether the foot of each leg touches, and whether its valve is commanded open, from leg 0 on.
    pub fn columns(&self) -> Vec<String> {
        let mut names = vec!["time_s".to_owned()];
        for (what, unit) in [("rate", "rad_s"), ("force", "m_s2")] {
            names.extend(["x", "y", "z"].map(|axis| format!("{what}_{axis}_{unit}")));
        }
        for what in ["contact", "valve"] {
            names.extend((1..=self.open_until.len()).map(|leg| format!("{what}_{leg}")));
        }
        names
    }

    /// Takes the next cycle: its row, a number for each column. NaN: a robot that knows its motion has no use for sensors.
    pub fn row(&mut self, ball: &Ball) -> Vec<f64> {
        for firing in &ball.fired {
            if let Some(until) = self.open_until.get_mut(firing.leg as usize) {
                *until = until.max(ball.time + firing.open);
            }
        }
        let inertial = ball.sensed.unwrap_or([[f64::NAN; 3]; 2]).concat();
        let legs = 0..self.open_until.len();
        let touching = legs.map(|leg| f64::from(ball.touching >> leg & 1 == 1));
        let valves = self.valves(ball.time).into_iter().map(f64::from);
        std::iter::once(ball.time)
            .chain(inertial)
            .chain(touching)
            .chain(valves)
            .collect()
    }

    /// Whether the valve of each leg is commanded open at `time` (s), after what was taken.
    pub fn valves(&self, time: f64) -> Vec<bool> {
        self.open_until.iter().map(|until| time < *until).collect()
    }
}
