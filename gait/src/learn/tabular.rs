//! The four algorithms of the thesis, in its letters.
//!
//! Source: thesis 6.2.2 (SARSA), 6.2.3 (Q-learning), 6.2.4 (SARSA(λ)), 6.2.5 (Watkins' Q(λ)).

use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg64;

use crate::GaitError;
use crate::error::{ensure, require};

use super::bins::MOST;

/// An algorithm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Algorithm {
    /// On-policy, one step.
    Sarsa,
    /// Off-policy, one step.
    Q,
    /// On-policy, with eligibility traces.
    SarsaLambda,
    /// Off-policy, with traces that end where an action was not greedy.
    QLambda,
}

impl Algorithm {
    /// Every algorithm, in the order of the thesis.
    pub const ALL: [Algorithm; 4] = [
        Algorithm::Sarsa,
        Algorithm::Q,
        Algorithm::SarsaLambda,
        Algorithm::QLambda,
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Algorithm::Sarsa => "sarsa",
            Algorithm::Q => "q",
            Algorithm::SarsaLambda => "sarsa-lambda",
            Algorithm::QLambda => "q-lambda",
        }
    }

    /// Whether it has traces.
    pub fn has_traces(self) -> bool {
        matches!(self, Algorithm::SarsaLambda | Algorithm::QLambda)
    }
}

/// The numbers of an algorithm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rates {
    /// Learning rate α.
    pub alpha: f64,
    /// Discount γ.
    pub gamma: f64,
    /// Decay λ of traces; without effect in one-step algorithms.
    pub lambda: f64,
}

impl Rates {
    fn check(&self) -> Result<(), GaitError> {
        let named = [
            ("alpha", self.alpha),
            ("gamma", self.gamma),
            ("lambda", self.lambda),
        ];
        named.into_iter().try_for_each(|(name, value)| {
            require((0.0..=1.0).contains(&value), name, value, "from 0 to 1")
        })
    }
}

/// Traces below this share of a new one are dropped: their part of a value is below round-off.
const FADED: f64 = 1e-18;

/// Values Q(s, a), and how they are learnt.
#[derive(Clone, Debug)]
pub struct Tabular {
    algorithm: Algorithm,
    rates: Rates,
    actions: usize,
    values: Vec<f64>,
    /// Places in the table with a trace, and the traces.
    eligible: Vec<(usize, f64)>,
    /// Where in `eligible` a place of the table is, plus 1; 0: nowhere.
    slots: Vec<u32>,
}

/// What came of an action, and what comes next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// State before.
    pub state: usize,
    /// What was done.
    pub action: usize,
    /// What it gave.
    pub reward: f64,
    /// State after, and what is going to be done there; none after the end.
    pub next: Option<(usize, usize)>,
}

impl Tabular {
    /// A table of zeros.
    ///
    /// # Errors
    /// [`GaitError::Input`] for rates outside 0 to 1, and for a table above 1 GiB.
    pub fn new(
        algorithm: Algorithm,
        rates: Rates,
        (states, actions): (usize, usize),
    ) -> Result<Tabular, GaitError> {
        rates.check()?;
        let size = states.saturating_mul(actions);
        ensure! {
            "states times actions", size as f64, (1..=MOST).contains(&size)
                => format!("from 1 to {MOST}, a table of 1 GiB");
        }
        Ok(Tabular {
            algorithm,
            rates,
            actions,
            values: vec![0.0; size],
            eligible: Vec::new(),
            slots: vec![0; if algorithm.has_traces() { size } else { 0 }],
        })
    }

    /// The values, by state and then action.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The same algorithm with values learnt before.
    ///
    /// # Errors
    /// [`GaitError::Input`] for another number of values.
    pub fn with_values(mut self, values: Vec<f64>) -> Result<Tabular, GaitError> {
        let (count, own) = (values.len(), self.values.len());
        ensure! { "values", count as f64, count == own => format!("{own}, as the table has"); }
        self.values = values;
        Ok(self)
    }

    /// Value of an action in `state`.
    pub fn value(&self, state: usize, action: usize) -> f64 {
        self.values[state * self.actions + action]
    }

    fn greatest(&self, state: usize) -> f64 {
        let values = &self.values[state * self.actions..][..self.actions];
        values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
    }

    /// The best action in `state`; of several, one at random.
    pub fn greedy(&self, state: usize, random: &mut Pcg64) -> usize {
        let best = self.greatest(state);
        let is_best = |action: &usize| self.value(state, *action) >= best;
        let count = (0..self.actions).filter(is_best).count();
        let chosen = if count > 1 { below(count, random) } else { 0 };
        (0..self.actions).filter(is_best).nth(chosen).unwrap_or(0)
    }

    /// The best action in `state`; of several, the first: what a robot does with a table that it was given.
    pub fn best(&self, state: usize) -> usize {
        let best = self.greatest(state);
        let mut actions = 0..self.actions;
        actions
            .find(|action| self.value(state, *action) >= best)
            .unwrap_or(0)
    }

    /// An action: with probability `epsilon` any one, else the best.
    pub fn choose(&self, state: usize, epsilon: f64, random: &mut Pcg64) -> usize {
        if epsilon > 0.0 && unit(random) < epsilon {
            below(self.actions, random)
        } else {
            self.greedy(state, random)
        }
    }

    /// Forgets all traces: at the begin of an episode.
    pub fn begin(&mut self) {
        for (place, _) in self.eligible.drain(..) {
            self.slots[place] = 0;
        }
    }

    /// Learns from a step.
    pub fn learn(&mut self, seen: &Seen) {
        let Rates { alpha, gamma, .. } = self.rates;
        let after = seen
            .next
            .map_or(0.0, |(state, action)| match self.algorithm {
                Algorithm::Sarsa | Algorithm::SarsaLambda => self.value(state, action),
                Algorithm::Q | Algorithm::QLambda => self.greatest(state),
            });
        let delta = seen.reward + gamma * after - self.value(seen.state, seen.action);
        let place = seen.state * self.actions + seen.action;
        if !self.algorithm.has_traces() {
            self.values[place] += alpha * delta;
            return;
        }
        // Watkins: what follows an action that is not greedy says nothing of the best policy. Greedy by
        // the table before this step, as in the thesis (6.2.5).
        let is_greedy =
            |(state, action): (usize, usize)| self.value(state, action) >= self.greatest(state);
        let is_cut = self.algorithm == Algorithm::QLambda && !seen.next.is_some_and(is_greedy);
        self.visit(place);
        self.credit(alpha * delta);
        if is_cut {
            self.begin();
        }
    }

    fn visit(&mut self, place: usize) {
        match self.slots[place] {
            0 => {
                self.eligible.push((place, 1.0));
                self.slots[place] = u32::try_from(self.eligible.len()).unwrap_or(0);
            }
            slot => self.eligible[slot as usize - 1].1 += 1.0,
        }
    }

    /// Gives `step` to all that is eligible, and lets it fade.
    fn credit(&mut self, step: f64) {
        let fade = self.rates.gamma * self.rates.lambda;
        let mut k = 0;
        while k < self.eligible.len() {
            let (place, trace) = &mut self.eligible[k];
            self.values[*place] += step * *trace;
            *trace *= fade;
            if *trace < FADED {
                self.slots[*place] = 0;
                self.eligible.swap_remove(k);
                if let Some((moved, _)) = self.eligible.get(k) {
                    self.slots[*moved] = u32::try_from(k + 1).unwrap_or(0);
                }
            } else {
                k += 1;
            }
        }
    }
}

/// A number from 0 to 1, without 1.
pub(crate) fn unit(random: &mut Pcg64) -> f64 {
    Uniform::new(0.0, 1.0).map_or(0.0, |uniform| uniform.sample(random))
}

/// A whole number below `count`.
pub(crate) fn below(count: usize, random: &mut Pcg64) -> usize {
    Uniform::new(0, count).map_or(0, |uniform| uniform.sample(random))
}
