//! What a kind of experiment has to say for itself: what was measured, what is not known, what could be wrong.

/// A measured column.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Its name, which ends with its unit.
    pub name: &'static str,
    /// Standard deviation of its noise, in its unit; > 0.
    pub noise: f64,
}

/// One measured number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Index of its channel.
    pub channel: usize,
    /// When (s).
    pub time: f64,
    /// In the channel's unit.
    pub value: f64,
}

/// One run.
#[derive(Clone, Debug, PartialEq)]
pub struct Log {
    /// Its file.
    pub name: String,
    /// What was measured, in the order of time.
    pub readings: Vec<Reading>,
}

/// A number that is estimated.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Its name, which ends with its unit.
    pub name: &'static str,
    /// Its value in the model as it is; for an unknown of a run, a first guess.
    pub neutral: f64,
    /// Least and greatest that physics allows.
    pub bounds: (f64, f64),
    /// A change that matters.
    pub scale: f64,
    /// Where its search starts, beside `neutral`.
    pub starts: Vec<f64>,
}

/// A named effect that may be at work: a term of the model, off where each parameter is neutral.
#[derive(Clone, Debug, PartialEq)]
pub struct Cause {
    /// Its id.
    pub id: &'static str,
    /// What is estimated.
    pub parameters: Vec<Parameter>,
}

/// Values of the parameters of every cause.
#[derive(Clone, Debug, PartialEq)]
pub struct Terms(Vec<Vec<f64>>);

impl Terms {
    /// All off.
    pub fn off(causes: &[Cause]) -> Terms {
        Terms(causes.iter().map(|c| c.parameters.iter().map(|p| p.neutral).collect()).collect())
    }

    /// Parameter `parameter` of cause `cause`.
    pub fn get(&self, cause: usize, parameter: usize) -> f64 {
        self.0[cause][parameter]
    }

    /// Sets it.
    pub fn set(&mut self, cause: usize, parameter: usize, value: f64) {
        self.0[cause][parameter] = value;
    }
}

/// An experiment of a kind: its data, and the model of it.
pub trait Kind: Sync {
    /// What was measured.
    fn channels(&self) -> &[Channel];

    /// The runs.
    fn logs(&self) -> &[Log];

    /// What is not known of a run, its start above all.
    fn unknowns(&self, run: usize) -> Vec<Parameter>;

    /// What could be wrong.
    fn causes(&self) -> &[Cause];

    /// What the model says of each reading of a run; none where it has no answer.
    fn predict(&self, run: usize, terms: &Terms, unknowns: &[f64]) -> Option<Vec<f64>>;
}
