//! SARSA(λ) with tile coding: a value is a sum over tables that are shifted against each other.
//!
//! Source: Sutton and Barto, Reinforcement Learning, 2nd edition, 9.5.4 and 12.7 (replacing traces); the shifts of tiling k
//! are k times 1, 3, 5, ... parts of a step, after Miller and Glanz.

use rand_pcg::Pcg64;
use saltus_gait::GaitError;
use saltus_gait::learn::{Act, Bin, Environment, Outcome, Rates, Schedule, Training};

use crate::{below, unit};

/// Traces below this are dropped: their part of a value is below round-off.
const FADED: f64 = 1e-18;

/// Steps along every axis of an observation, in several tilings that are shifted against each other.
#[derive(Clone, Debug)]
pub struct Tiles {
    axes: Vec<Bin>,
    tilings: usize,
}

impl Tiles {
    /// The steps `axes` in so many `tilings`.
    pub fn new(axes: Vec<Bin>, tilings: usize) -> Tiles {
        Tiles { axes, tilings }
    }

    /// Steps of a tiling along an axis: one more than is asked for where tilings are shifted.
    fn places(&self, bin: &Bin) -> usize {
        bin.count + usize::from(self.tilings > 1 && bin.count > 1)
    }

    /// How many states there are in all tilings.
    pub fn states(&self) -> usize {
        let places = self.axes.iter().map(|bin| self.places(bin));
        places.product::<usize>() * self.tilings
    }

    /// The states of what is observed, one in each tiling.
    pub fn states_of(&self, observation: &[f64]) -> Vec<usize> {
        let of = |tiling: usize| {
            let axes = self.axes.iter().zip(observation).enumerate();
            axes.fold(tiling, |state, (axis, (bin, x))| {
                let places = self.places(bin);
                let step = if places == bin.count {
                    bin.of(*x).0
                } else {
                    // The tiling begins the less before the axis, the farther it is shifted.
                    let shift = (tiling * (2 * axis + 1)) % self.tilings;
                    shifted(bin, *x, shift as f64 / self.tilings as f64)
                };
                state * places + step
            })
        };
        (0..self.tilings).map(of).collect()
    }
}

/// Index of the step of `x` in a grid that begins `shift` of a step later than one that has a step more.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn shifted(bin: &Bin, x: f64, shift: f64) -> usize {
    let place = (x - bin.from) / (bin.to - bin.from) * bin.count as f64;
    let within = place.clamp(0.0, bin.count as f64) + (1.0 - shift);
    (within as usize).min(bin.count)
}

/// Values over tiles, and how they are learnt.
pub struct Tiled<'e> {
    environment: &'e dyn Environment,
    tiles: &'e Tiles,
    rates: Rates,
    actions: usize,
    values: Vec<f64>,
    /// The trace of each place in the table, and the places where it is not 0.
    traces: Vec<f64>,
    eligible: Vec<usize>,
}

impl<'e> Tiled<'e> {
    /// Values of 0 in the task of `environment`, whose actions are choices.
    pub fn new(environment: &'e dyn Environment, tiles: &'e Tiles, rates: Rates) -> Tiled<'e> {
        let actions = environment.actions().choices().unwrap_or(0);
        let size = tiles.states() * actions;
        Tiled {
            environment,
            tiles,
            rates,
            actions,
            values: vec![0.0; size],
            traces: vec![0.0; size],
            eligible: Vec::new(),
        }
    }

    fn value(&self, states: &[usize], action: usize) -> f64 {
        let one = |state: &usize| self.values[state * self.actions + action];
        states.iter().map(one).sum()
    }

    /// The actions of the greatest value.
    fn best(&self, states: &[usize]) -> Vec<usize> {
        let value = |action: &usize| self.value(states, *action);
        let actions = 0..self.actions;
        let most = actions
            .clone()
            .map(|it| value(&it))
            .fold(f64::NEG_INFINITY, f64::max);
        actions.filter(|action| value(action) >= most).collect()
    }

    fn choose(&self, states: &[usize], epsilon: f64, random: &mut Pcg64) -> usize {
        if epsilon > 0.0 && unit(random) < epsilon {
            return below(self.actions, random);
        }
        let best = self.best(states);
        best[if best.len() > 1 {
            below(best.len(), random)
        } else {
            0
        }]
    }

    /// Learns for the episodes of `schedule` with `seed`; what each came to.
    ///
    /// # Errors
    /// [`GaitError`] for a motion that cannot go on.
    pub fn learn(&mut self, schedule: &Schedule, seed: u64) -> Result<Vec<Outcome>, GaitError> {
        let one = |episode: usize| {
            let exponent = i32::try_from(episode).unwrap_or(i32::MAX);
            let epsilon = schedule.epsilon * schedule.decay.powi(exponent);
            self.episode((seed, episode), Some(epsilon))
        };
        (0..schedule.episodes).map(one).collect()
    }

    /// An episode without exploration or learning: in each state the best action, of equal ones the first.
    ///
    /// # Errors
    /// [`GaitError`] for a motion that cannot go on.
    pub fn trial(&mut self, seed: (u64, usize)) -> Result<Outcome, GaitError> {
        self.episode(seed, None)
    }

    fn episode(
        &mut self,
        (seed, episode): (u64, usize),
        epsilon: Option<f64>,
    ) -> Result<Outcome, GaitError> {
        let mut random = Pcg64::new(u128::from(seed), 2 * episode as u128);
        let mut running = self
            .environment
            .start(Training::start_of((seed, episode)))?;
        let mut choose = |it: &Tiled<'_>, states: &[usize]| match epsilon {
            Some(share) => it.choose(states, share, &mut random),
            None => it.best(states)[0],
        };
        for place in self.eligible.drain(..) {
            self.traces[place] = 0.0;
        }
        let mut states = self.tiles.states_of(running.observation());
        let mut action = choose(self, &states);
        loop {
            let step = running.step(Act::Choice(action))?;
            let next = self.tiles.states_of(running.observation());
            let after = choose(self, &next);
            if epsilon.is_some() {
                let value = if step.terminated {
                    0.0
                } else {
                    self.value(&next, after)
                };
                self.update(&states, action, step.reward + self.rates.gamma * value);
            }
            (states, action) = (next, after);
            if step.is_over() {
                return Ok(running.outcome());
            }
        }
    }

    /// Moves the value of `action` in `states` towards `wanted`, and what led there.
    fn update(&mut self, states: &[usize], action: usize, wanted: f64) {
        let delta = wanted - self.value(states, action);
        // Each tiling takes its part of the step.
        let step = self.rates.alpha / states.len() as f64 * delta;
        for place in states.iter().map(|state| state * self.actions + action) {
            if self.traces[place] == 0.0 {
                self.eligible.push(place);
            }
            self.traces[place] = 1.0;
        }
        let fade = self.rates.gamma * self.rates.lambda;
        let (values, traces) = (&mut self.values, &mut self.traces);
        self.eligible.retain(|place| {
            let trace = &mut traces[*place];
            values[*place] += step * *trace;
            *trace = if *trace * fade < FADED {
                0.0
            } else {
                *trace * fade
            };
            *trace != 0.0
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tilings_part_an_axis_in_finer_steps() {
        let bin = |from, to, count| Bin { from, to, count };
        let tiles = Tiles::new(vec![bin(0.0, 1.0, 5), bin(0.0, 1.0, 1)], 4);
        assert_eq!(tiles.states(), 4 * 6);
        let of = |x: f64| {
            let states = tiles.states_of(&[x, 0.3]);
            assert!(states.iter().all(|state| *state < tiles.states()));
            states
        };
        // Within a twentieth all is one; from one to the next, one tiling of the four differs.
        for k in 0..19 {
            let [a, b, c] = [0.1, 0.9, 1.1].map(|part| of((f64::from(k) + part) / 20.0));
            assert_eq!(a, b);
            let differ = b.iter().zip(&c).filter(|(b, c)| b != c);
            assert_eq!(differ.count(), 1, "{b:?} {c:?}");
        }
        assert_eq!(of(1.5), of(1.0));
    }
}
