//! What a diagnosis says: causes with their parameters, what else could be, and what is unknown.

use crate::fit::Fit;
use crate::gain::Gain;
use crate::kind::{Kind, Terms};
use crate::known::{self, Deviation};
use crate::named::meaning_of;
use crate::next::NextExperiment;
use crate::profile::{Interval, NORMAL};

/// A cause as a candidate, fitted with those before it.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// Id of the cause, or what a term without a name is.
    pub id: &'static str,
    /// The measured column that it is about, if it is about one.
    pub column: Option<String>,
    /// Names (each ends with its unit) and values of its parameters.
    pub values: Vec<(String, f64)>,
    /// Index of the cause in its kind.
    pub cause: usize,
    /// Logarithm (natural) of the odds for it, beside the same causes without it.
    pub log_odds: f64,
    /// The model with it.
    pub fit: Fit,
    /// What is known of its parameters apart from the data.
    pub deviations: Vec<Deviation>,
    /// Its parameters as they are reported.
    pub reported: Vec<Reported>,
}

impl Candidate {
    /// `fit`, which is `base` with `cause`.
    pub(crate) fn new(kind: &dyn Kind, cause: usize, base: &Fit, fit: Fit) -> Candidate {
        let spec = &kind.causes()[cause];
        Candidate {
            id: spec.id,
            column: spec.column.clone(),
            values: spec.report(fit.terms.of(cause)),
            cause,
            deviations: known::deviations(kind.causes(), cause, &fit.terms),
            log_odds: 0.5 * (base.loss - fit.loss),
            fit,
            reported: Vec::new(),
        }
    }

    /// Whether what is reported of its one parameter allows that it is not there.
    pub(crate) fn may_be_none(&self, kind: &dyn Kind) -> bool {
        let spec = &kind.causes()[self.cause];
        let ([parameter], [found]) = (&spec.parameters[..], &self.reported[..]) else {
            return false;
        };
        let none = spec.report(&[parameter.neutral])[0].1;
        let half = NORMAL * found.error;
        let Interval { low, high } = found.interval.unwrap_or(Interval {
            low: Some(found.value - half),
            high: Some(found.value + half),
        });
        !spec.is_apart()
            && low.is_none_or(|low| low <= none)
            && high.is_none_or(|high| high >= none)
    }

    /// What the cause means, in the form that fits; of a term without a name, that it stands for something unknown.
    pub fn meaning(&self) -> &'static str {
        let form = self.values.first().map_or("", |(name, _)| name);
        meaning_of(self.id, form).unwrap_or("an effect that the simulation leaves out")
    }

    /// Its id, with the column that it is about.
    pub fn title(&self) -> String {
        let id = self.id;
        self.column
            .as_ref()
            .map_or(id.to_owned(), |column| format!("{id} of {column}"))
    }
}

/// A parameter of a cause as it is reported.
#[derive(Clone, Debug, PartialEq)]
pub struct Reported {
    /// Its name, which ends with its unit.
    pub name: String,
    /// What the data say.
    pub value: f64,
    /// One standard error; not a number where it rests at a bound at which it does nothing.
    pub error: f64,
    /// Its 95 % interval by profile likelihood; of causes that were found, where it does not depend
    /// on several parameters of the fit.
    pub interval: Option<Interval>,
    /// Whether the runs disagree about it: error and interval are then by its scatter where each run
    /// in turn is left out.
    pub runs_disagree: bool,
}

/// A cause that was found.
#[derive(Clone, Debug)]
pub struct Finding {
    /// The cause in the model.
    pub best: Candidate,
    /// Those that the data cannot tell from it, each in its place: the two nearest.
    pub rivals: Vec<Candidate>,
    /// Those after them that the data do not exclude either.
    pub less_likely: Vec<Candidate>,
    /// Those that the data do not exclude, and what is known apart from them does.
    pub contradicting: Vec<Candidate>,
    /// A term without an id that explains the data as well.
    pub unlisted: Option<Candidate>,
    /// By how much the loss of data left out falls with it.
    pub held_out: f64,
    /// A direction of its parameters that the data do not tell, as the part of each.
    pub undetermined: Option<Vec<f64>>,
    /// Whether the data limit how strong it is. If not, a stronger one predicts the same readings,
    /// or physics allows no stronger one.
    pub is_identifiable: bool,
    /// Where there are rivals, the experiment that would tell them apart.
    pub next: Option<NextExperiment>,
}

/// Noise and model error in the residuals of a model, channel by channel.
#[derive(Clone, Debug, PartialEq)]
pub struct Fitness {
    /// White noise of each channel, in terms of the noise as it is stated or estimated beforehand.
    pub noise: Vec<f64>,
    /// Correlation of the noise of each reading of a channel with that of the one before; 0 where it is
    /// white.
    pub follows: Vec<f64>,
    /// The model's own error in each channel, root mean square, in standard deviations of a reading.
    pub own_error: Vec<f64>,
    /// Whether what is left of each channel is noise, and no more of the model's own error than is
    /// expected.
    pub is_noise: Vec<bool>,
}

/// A misfit that no listed cause explains.
#[derive(Clone, Debug, PartialEq)]
pub struct Unknown {
    /// The channel that shows it most.
    pub channel: String,
    /// Where in a run its mean square is greatest: the phase, or a part of the time.
    pub phase: String,
    /// Root mean square there, in the channel's unit.
    pub rms: f64,
}

/// The cause that explains most by itself, where several were found.
#[derive(Clone, Debug)]
pub struct Alone {
    /// The cause.
    pub cause: Candidate,
    /// What the model with it leaves of each channel on data left out, root mean square (the
    /// channel's unit).
    pub rms: Vec<f64>,
}

/// A set of causes that was fitted, with how probable the data are with it.
#[derive(Clone, Debug, PartialEq)]
pub struct Competitor {
    /// Indices of its causes in the kind.
    pub causes: Vec<usize>,
    /// Parameters of all causes where the data are most probable.
    pub terms: Terms,
    /// Logarithm (natural) of the odds for it, beside the model as it is, where only its causes are at work.
    pub log_odds: f64,
    /// The same where something that is not on the list is at work, too.
    pub log_odds_unlisted: f64,
    /// Whether it is the answer.
    pub is_answer: bool,
}

impl Competitor {
    /// The greater of the two.
    pub fn best(&self) -> f64 {
        self.log_odds.max(self.log_odds_unlisted)
    }
}

/// What the data say.
#[derive(Clone, Debug)]
pub struct Diagnosis {
    /// The causes, the most telling first.
    pub findings: Vec<Finding>,
    /// What nobody knows of the machine, and is the same in all runs, as it is estimated beside them.
    pub common: Vec<Reported>,
    /// Something that is wrong beyond them.
    pub unknown: Option<Unknown>,
    /// The term of the state that describes it best, if one does on data left out too; it has no id
    /// of a cause.
    pub term: Option<Candidate>,
    /// Every cause alone, the best first.
    pub tried: Vec<Candidate>,
    /// Where several causes were found, the best of them alone.
    pub alone: Option<Alone>,
    /// The model as it is.
    pub before: Fit,
    /// The model with all findings.
    pub after: Fit,
    /// Residuals of these two models.
    pub fitness: (Fitness, Fitness),
    /// Held-out gain of each channel.
    pub gains: Vec<Gain>,
    /// All sets of causes that were fitted, the most probable first.
    pub sets: Vec<Competitor>,
}
