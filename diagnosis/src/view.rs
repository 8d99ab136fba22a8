//! An experiment as a search sees it: the scatter that readings are judged by, and what the model
//! said before.

use std::collections::VecDeque;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::{Arc, Mutex, PoisonError};

use saltus_robot::Robot;

use crate::fit::Fit;
use crate::fitness;
use crate::kind::{Cause, Channel, Data, Kind, Log, Parameter, Proposal, Terms};
use crate::known;
use crate::policy::POLICY;
use crate::settings::Settings;

/// Most answers of a run that are kept, and most readings in all that they have.
const ANSWERS: usize = 400;
const READINGS: usize = 8_000_000;

/// Scatter in terms of the stated one up to which it is taken as stated.
const AS_STATED: f64 = POLICY.noise_as_stated;

/// What was asked of the model of a run: all its parameters.
#[derive(Clone, PartialEq)]
struct Question {
    terms: Terms,
    unknowns: Vec<f64>,
}

/// A question by its hash, and the answer.
type Known = (u64, Question, Option<Arc<[f64]>>);

/// An experiment whose readings may scatter more than was stated, with what its model said of each
/// run, the latest last: searches come back to the same places.
pub(crate) struct View<'a> {
    kind: &'a dyn Kind,
    channels: Vec<Channel>,
    causes: Vec<Cause>,
    discrepancy: f64,
    /// Readings in the place of those that were measured.
    logs: Option<Vec<Log>>,
    said: Arc<[Mutex<VecDeque<Known>>]>,
}

impl<'a> View<'a> {
    /// As it was stated, with what the settings say of the model's own error and of its causes.
    pub(crate) fn new(kind: &'a dyn Kind, settings: &Settings) -> View<'a> {
        let said = kind.logs().iter().map(|_| Mutex::default()).collect();
        View {
            kind,
            channels: kind.channels().to_vec(),
            causes: known::inform(kind.causes(), &settings.known)
                .map_or_else(|_| kind.causes().to_vec(), |told| told.0),
            discrepancy: settings.discrepancy.unwrap_or(kind.discrepancy()),
            logs: None,
            said,
        }
    }

    /// As if every instrument had read exactly what the model says with `terms` on, at the first
    /// guesses of what is not known; none where the model has no answer.
    pub(crate) fn exact(
        kind: &'a dyn Kind,
        settings: &Settings,
        terms: &Terms,
    ) -> Option<View<'a>> {
        let view = View::new(kind, settings);
        let mut logs = kind.logs().to_vec();
        for (run, log) in logs.iter_mut().enumerate() {
            let unknowns: Vec<f64> = kind.unknowns(run).iter().map(|p| p.neutral).collect();
            let values = view.predict(run, terms, &unknowns)?;
            for (reading, value) in log.readings.iter_mut().zip(values) {
                reading.value = value;
            }
        }
        Some(View {
            logs: Some(logs),
            ..view
        })
    }

    /// With the scatter that `model` leaves, which has the model's own error in it; none where that
    /// is about what was stated.
    pub(crate) fn rescaled(&self, model: &Fit) -> Option<View<'a>> {
        let scatter = fitness::scatter(self, model);
        let scale = |(channel, seen): (&Channel, &f64)| Channel {
            noise: channel.noise * if *seen > AS_STATED { *seen } else { 1.0 },
            ..channel.clone()
        };
        let is_more = scatter.iter().any(|s| *s > AS_STATED);
        let channels = self.channels.iter().zip(&scatter).map(scale).collect();
        is_more.then(|| View {
            kind: self.kind,
            channels,
            causes: self.causes.clone(),
            discrepancy: 0.0,
            logs: self.logs.clone(),
            said: Arc::clone(&self.said),
        })
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

impl Kind for View<'_> {
    fn data(&self) -> &Data {
        self.kind.data()
    }

    fn predict(&self, run: usize, terms: &Terms, unknowns: &[f64]) -> Option<Vec<f64>> {
        let question = Question {
            terms: terms.clone(),
            unknowns: unknowns.to_vec(),
        };
        let hash = question.hash();
        let known = || {
            self.said[run]
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
        };
        let is_it = |k: &Known| k.0 == hash && k.1 == question;
        let told = {
            let mut known = known();
            // What is asked again is forgotten last.
            let place = known.iter().rposition(is_it);
            place.and_then(|k| known.remove(k)).map(|told| {
                let answer = told.2.clone();
                known.push_back(told);
                answer
            })
        };
        if let Some(answer) = told {
            return answer.map(|values| values.to_vec());
        }
        let answer = self.kind.predict(run, terms, unknowns);
        let readings: usize = self.logs().iter().map(|log| log.readings.len()).sum();
        let most = ANSWERS.min(READINGS / readings.max(1));
        let mut known = known();
        known.push_back((hash, question, answer.as_deref().map(Arc::from)));
        while known.len() > most {
            known.pop_front();
        }
        answer
    }

    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn logs(&self) -> &[Log] {
        self.logs.as_deref().unwrap_or_else(|| self.kind.logs())
    }

    fn unknowns(&self, run: usize) -> Vec<Parameter> {
        self.kind.unknowns(run)
    }

    fn causes(&self) -> &[Cause] {
        &self.causes
    }

    fn most(&self) -> usize {
        self.kind.most()
    }

    fn is_apart(&self) -> bool {
        self.kind.is_apart()
    }

    fn group(&self, run: usize) -> usize {
        self.kind.group(run)
    }

    fn trust(&self) -> f64 {
        self.kind.trust()
    }

    fn discrepancy(&self) -> f64 {
        self.discrepancy
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

    fn robot(&self, terms: &Terms) -> Option<Robot> {
        self.kind.robot(terms)
    }

    fn stronger(&self) -> String {
        self.kind.stronger()
    }

    fn proposals(&self) -> Vec<Proposal> {
        self.kind.proposals()
    }
}
