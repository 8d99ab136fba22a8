//! An experiment whose instruments wander: the scatter that is seen in place of the stated noise.

use crate::fit::Fit;
use crate::fitness;
use crate::kind::{Cause, Channel, Kind, Log, Parameter, Terms};
use crate::next::Proposal;

/// An experiment whose readings scatter more than was stated.
pub(crate) struct Rescaled<'a> {
    kind: &'a dyn Kind,
    channels: Vec<Channel>,
}

/// Scatter in terms of the stated one up to which it is taken as stated.
const AS_STATED: f64 = 1.5;

impl<'a> Rescaled<'a> {
    /// With the scatter that `model` leaves; none where that is about what was stated.
    pub(crate) fn new(kind: &'a dyn Kind, model: &Fit) -> Option<Rescaled<'a>> {
        let scatter = fitness::scatter(kind, model);
        let scale = |(channel, seen): (&Channel, &f64)| Channel {
            noise: channel.noise * if *seen > AS_STATED { *seen } else { 1.0 },
            ..channel.clone()
        };
        let is_more = scatter.iter().any(|s| *s > AS_STATED);
        is_more
            .then(|| Rescaled { kind, channels: kind.channels().iter().zip(&scatter).map(scale).collect() })
    }
}

impl Kind for Rescaled<'_> {
    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn logs(&self) -> &[Log] {
        self.kind.logs()
    }

    fn unknowns(&self, run: usize) -> Vec<Parameter> {
        self.kind.unknowns(run)
    }

    fn causes(&self) -> &[Cause] {
        self.kind.causes()
    }

    fn listed(&self) -> usize {
        self.kind.listed()
    }

    fn trust(&self) -> f64 {
        self.kind.trust()
    }

    fn least_effect(&self, cause: usize) -> f64 {
        self.kind.least_effect(cause)
    }

    fn predict(&self, run: usize, terms: &Terms, unknowns: &[f64]) -> Option<Vec<f64>> {
        self.kind.predict(run, terms, unknowns)
    }

    fn input_noise(&self, run: usize, normal: &mut dyn FnMut() -> f64) -> Option<Vec<f64>> {
        self.kind.input_noise(run, normal)
    }

    fn phases(&self, run: usize, terms: &Terms, unknowns: &[f64]) -> Vec<(&'static str, f64)> {
        self.kind.phases(run, terms, unknowns)
    }

    fn report(&self, cause: usize, values: &[f64]) -> Vec<(String, f64)> {
        self.kind.report(cause, values)
    }

    fn proposals(&self) -> Vec<Proposal> {
        self.kind.proposals()
    }
}
