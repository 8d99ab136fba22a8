//! The numbers by which a diagnosis decides, in one place, each with its source. Constants of numerical
//! methods (steps of a fit, of a difference quotient, how many sets are fitted) stand beside the methods.

/// The numbers by which a diagnosis decides. σ is the standard deviation of a reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Policy {
    /// Expected number of causes at work, before anything is measured. Chosen: a machine that is looked
    /// at has one fault on average.
    pub causes: f64,
    /// Probability of an effect that no cause on the list explains, before anything is measured. Chosen:
    /// once in twenty machines.
    pub unlisted: f64,
    /// Decades over which the size of an effect may be, each as probable as the others. Chosen: from
    /// what is just seen to a hundred times as much.
    pub decades: f64,
    /// Error of a model of a machine as a part of a column's range. Chosen: the form of the law, its
    /// integration and the geometry are not better than that.
    pub form: f64,
    /// Standard deviation of the logarithm of the noise about what is stated. Chosen: a standard
    /// deviation is stated to two digits.
    pub stated: f64,
    /// The same about what is estimated from differences of readings. By 12 readings or more, whose
    /// sample standard deviation scatters by 1/√(2 n) and by what the motion adds.
    pub estimated: f64,
    /// Part of the model's own error that all runs share. Chosen: a fault of the equations repeats, one
    /// of a single run does not.
    pub shared: f64,
    /// Odds beyond which a cause is claimed, and below which one is a rival of another: evidence is
    /// "strong" from there on (Kass and Raftery, Bayes factors, 1995).
    pub strong: f64,
    /// Part of the loss on data left out that a cause must save where something unknown is left beside
    /// it. Chosen: less is within what the unknown may do.
    pub worth: f64,
    /// Standard deviations from what is known beyond which a cause contradicts it. Chosen: once in two
    /// million times by chance.
    pub contradiction: f64,
    /// The same that all of them must save together. Chosen: else most of what is wrong is unknown.
    pub explained: f64,
}

/// The policy of every diagnosis.
pub const POLICY: Policy = Policy {
    causes: 1.0,
    unlisted: 0.05,
    decades: 2.0,
    form: 1e-4,
    stated: 0.05,
    estimated: 0.3,
    shared: 0.5,
    strong: 20.0,
    worth: 0.1,
    contradiction: 5.0,
    explained: 0.5,
};
