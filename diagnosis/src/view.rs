//! An experiment as a search sees it: the scatter that readings are judged by, and what the model
//! said before.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

use crate::fit;
use crate::kind::{Cause, Channel, Data, Kind, Log, Parameter, Terms};
use crate::known;
use crate::likelihood::Scatter;
use crate::recent::Recent;
use crate::settings::Settings;

/// Most answers of a run that are kept, and most readings in all that they have.
const ANSWERS: usize = 400;
const READINGS: usize = 8_000_000;

/// What was asked of the model of a run: all its parameters.
#[derive(PartialEq)]
struct Question {
    /// Of the others.
    hash: u64,
    terms: Terms,
    unknowns: Vec<f64>,
}

/// What the model said of a run.
type Said = Recent<Question, Option<Arc<[f64]>>>;

/// An experiment whose readings may scatter more than was stated, with what its model said of each
/// run, the latest last: searches come back to the same places.
pub(crate) struct View<'a> {
    kind: &'a dyn Kind,
    channels: Vec<Channel>,
    causes: Vec<Cause>,
    discrepancy: f64,
    amplitudes: Vec<f64>,
    /// Readings in the place of those that were measured.
    logs: Option<Vec<Log>>,
    said: Arc<[Said]>,
}

impl<'a> View<'a> {
    /// As it was stated, with what the settings say of the model's own error and of its causes.
    pub(crate) fn new(kind: &'a dyn Kind, settings: &Settings) -> View<'a> {
        let said = kind.logs().iter().map(|_| Said::default()).collect();
        View {
            kind,
            channels: kind.channels().to_vec(),
            causes: known::inform(kind.causes(), &settings.known)
                .map_or_else(|_| kind.causes().to_vec(), |told| told.0),
            discrepancy: settings.discrepancy.unwrap_or(kind.discrepancy()),
            amplitudes: vec![
                settings.discrepancy.unwrap_or(kind.discrepancy());
                kind.channels().len()
            ],
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

    /// With each reading of each run off by so many of its standard deviations.
    pub(crate) fn with_noise(&self, noise: &[Vec<f64>]) -> View<'a> {
        let mut logs = self.logs().to_vec();
        for (log, noise) in logs.iter_mut().zip(noise) {
            for (reading, z) in log.readings.iter_mut().zip(noise) {
                reading.value += z * fit::scatter(self, reading);
            }
        }
        View {
            kind: self.kind,
            channels: self.channels.clone(),
            causes: self.causes.clone(),
            discrepancy: self.discrepancy,
            amplitudes: self.amplitudes.clone(),
            logs: Some(logs),
            said: Arc::clone(&self.said),
        }
    }

    /// With noise and model error as they were found, where so many readings of each channel count as
    /// one.
    pub(crate) fn scattering(&self, scatter: &[Scatter], alike: &[f64]) -> View<'a> {
        let noise = |k: usize| scatter[k].noise * alike[k].sqrt();
        let scale = |(k, channel): (usize, &Channel)| Channel {
            noise: channel.noise * noise(k),
            ..channel.clone()
        };
        let amplitudes = scatter.iter().enumerate();
        View {
            kind: self.kind,
            channels: self.channels.iter().enumerate().map(scale).collect(),
            causes: self.causes.clone(),
            discrepancy: self.discrepancy,
            amplitudes: amplitudes.map(|(k, s)| s.amplitude / noise(k)).collect(),
            logs: self.logs.clone(),
            said: Arc::clone(&self.said),
        }
    }
}

impl Question {
    fn new(terms: &Terms, unknowns: &[f64]) -> Question {
        let mut hasher = DefaultHasher::new();
        for x in terms.all().chain(unknowns) {
            x.to_bits().hash(&mut hasher);
        }
        Question {
            hash: hasher.finish(),
            terms: terms.clone(),
            unknowns: unknowns.to_vec(),
        }
    }
}

impl Kind for View<'_> {
    fn data(&self) -> &Data {
        self.kind.data()
    }

    fn inner(&self) -> Option<&dyn Kind> {
        Some(self.kind)
    }

    fn predict(&self, run: usize, terms: &Terms, unknowns: &[f64]) -> Option<Vec<f64>> {
        let readings: usize = self.logs().iter().map(|log| log.readings.len()).sum();
        let most = ANSWERS.min(READINGS / readings.max(1));
        let predict = |_: &Question| {
            let values = self.kind.predict(run, terms, unknowns);
            values.map(Arc::<[f64]>::from)
        };
        let answer = self.said[run].ask(Question::new(terms, unknowns), most, predict);
        answer.map(|values| values.to_vec())
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

    fn discrepancy(&self) -> f64 {
        self.discrepancy
    }

    fn amplitudes(&self) -> Vec<f64> {
        self.amplitudes.clone()
    }
}
