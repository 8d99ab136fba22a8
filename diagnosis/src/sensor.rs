//! What an instrument makes of the truth, the same for what is predicted and for what drives a model.

/// An instrument: its reading is gain · truth + offset, of the truth some time before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensor {
    /// Reading for each unit of the truth, > 0.
    pub gain: f64,
    /// Reading (the column's unit) where the truth is 0.
    pub offset: f64,
    /// How late (s) it is; before the first row the motion went on as it does there.
    pub delay: f64,
    /// How late (s) it is where it shows the first row's truth until then.
    pub held: f64,
}

/// In which way a sensor is off: what the parameter of a cause is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// [`Sensor::gain`].
    Gain,
    /// [`Sensor::offset`].
    Offset,
    /// [`Sensor::delay`].
    Delay,
    /// [`Sensor::held`].
    Held,
}

impl Default for Sensor {
    /// One that reads the truth.
    fn default() -> Sensor {
        Sensor {
            gain: 1.0,
            offset: 0.0,
            delay: 0.0,
            held: 0.0,
        }
    }
}

impl Sensor {
    /// With a fault of this size.
    #[must_use]
    pub fn with(mut self, fault: Fault, size: f64) -> Sensor {
        *match fault {
            Fault::Gain => &mut self.gain,
            Fault::Offset => &mut self.offset,
            Fault::Delay => &mut self.delay,
            Fault::Held => &mut self.held,
        } = size;
        self
    }

    /// What it reads of a truth.
    pub fn reading(&self, truth: f64) -> f64 {
        self.gain * truth + self.offset
    }

    /// The truth that it reads so.
    pub fn truth(&self, reading: f64) -> f64 {
        (reading - self.offset) / self.gain
    }

    /// When (s) the truth was that it shows at `time`; its log begins at `first` (s).
    pub fn shows(&self, time: f64, first: f64) -> f64 {
        (time - self.held).max(first) - self.delay
    }

    /// When (s) it shows the truth of `time`.
    pub fn shown(&self, time: f64) -> f64 {
        time + self.delay + self.held
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_and_reading_are_inverse() {
        let sensor = Sensor {
            gain: 1.2,
            offset: -3.0,
            delay: 0.1,
            held: 0.2,
        };
        assert!((sensor.truth(sensor.reading(7.0)) - 7.0).abs() < 1e-12);
        assert!((sensor.shows(sensor.shown(5.0), 0.0) - 5.0).abs() < 1e-12);
        // Until then it shows the first row's truth.
        assert_eq!(
            Sensor::default().with(Fault::Held, 0.2).shows(0.1, 0.0),
            0.0
        );
        assert_eq!(
            Sensor::default().with(Fault::Delay, 0.2).shows(0.1, 0.0),
            -0.1
        );
    }
}
