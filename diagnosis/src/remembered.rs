//! An experiment that remembers what its model said: searches come back to the same places.

use std::collections::VecDeque;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::{Arc, Mutex, PoisonError};

use saltus_robot::Robot;

use crate::kind::{Cause, Channel, Kind, Log, Parameter, Terms};
use crate::next::Proposal;

/// Most answers of a run that are kept, and most of their readings.
const ANSWERS: usize = 400;
const READINGS: usize = 2_000_000;

/// What was asked of the model of a run: all its parameters.
#[derive(Clone, PartialEq)]
struct Question {
    terms: Terms,
    unknowns: Vec<f64>,
}

/// A question by its hash, and the answer.
type Known = (u64, Question, Option<Arc<[f64]>>);

/// An experiment with what its model said of each run, the latest last.
pub(crate) struct Remembered<'a> {
    kind: &'a dyn Kind,
    runs: Vec<Mutex<VecDeque<Known>>>,
}

impl<'a> Remembered<'a> {
    pub(crate) fn new(kind: &'a dyn Kind) -> Remembered<'a> {
        Remembered { kind, runs: kind.logs().iter().map(|_| Mutex::default()).collect() }
    }
}

impl Question {
    fn hash(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        for x in self.terms.all().chain(&self.unknowns) {
            x.to_bits().hash(&mut hasher);
        }
        hasher.finish()
    }
}

impl Kind for Remembered<'_> {
    fn predict(&self, run: usize, terms: &Terms, unknowns: &[f64]) -> Option<Vec<f64>> {
        let question = Question { terms: terms.clone(), unknowns: unknowns.to_vec() };
        let hash = question.hash();
        let known = || self.runs[run].lock().unwrap_or_else(PoisonError::into_inner);
        let answer = known().iter().rev().find(|k| k.0 == hash && k.1 == question).map(|k| k.2.clone());
        if let Some(answer) = answer {
            return answer.map(|values| values.to_vec());
        }
        let answer = self.kind.predict(run, terms, unknowns);
        let most = ANSWERS.min(READINGS / self.logs()[run].readings.len().max(1));
        let mut known = known();
        known.push_back((hash, question, answer.as_deref().map(Arc::from)));
        while known.len() > most {
            known.pop_front();
        }
        answer
    }

    fn channels(&self) -> &[Channel] {
        self.kind.channels()
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

    fn input_noise(&self, run: usize, normal: &mut dyn FnMut() -> f64) -> Option<Vec<f64>> {
        self.kind.input_noise(run, normal)
    }

    fn phases(&self, run: usize, terms: &Terms, unknowns: &[f64]) -> Vec<(&'static str, f64)> {
        self.kind.phases(run, terms, unknowns)
    }

    fn report(&self, cause: usize, values: &[f64]) -> Vec<(String, f64)> {
        self.kind.report(cause, values)
    }

    fn robot(&self, terms: &Terms) -> Option<Robot> {
        self.kind.robot(terms)
    }

    fn proposals(&self) -> Vec<Proposal> {
        self.kind.proposals()
    }
}
