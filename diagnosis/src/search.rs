//! Which set of causes explains the data: sets are fitted, the most promising first, and weighed by how
//! probable the data are with them.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{DMatrix, DVector};
use saltus_numeric::parallel;

use crate::fit::{self, Fit, Slopes};
use crate::kind::{Cause, Kind, Parameter};
use crate::likelihood::{Expected, Likely, Linear, Scatter};
use crate::policy::POLICY;
use crate::settings::Settings;
use crate::stage::Stage;
use crate::view::View;

/// Difference in the logarithm of a probability by which a cause may promise to make the best set less
/// probable.
const NEAR: f64 = 8.0;
/// The same by which it may promise to make its own base less probable; and by which a fit may stay
/// behind what was promised.
const WORTH: f64 = 1.0;
const BEHIND: f64 = 2.0;
/// Part of the best fall of the loss below which a cause with many starts is given up.
const GIVEN_UP: f64 = 0.3;
/// Root mean square (σ) of what is left beyond which a model is far off.
const FAR: f64 = 5.0;
/// Sets of each size that are taken further.
const WIDTH: usize = 2;
/// Runs that tell which causes to fit where a model is far off.
const FEW: usize = 4;
/// Pairs that are fitted.
const PAIRS: usize = 4;
/// Causes that are fitted beside each.
const FITTED: usize = 6;
/// Causes of a set that are many.
const MANY: usize = 3;
/// Difference in the logarithm of a probability beyond which a linear model gives a cause up.
const HOPELESS: f64 = 30.0;

/// A set of causes, fitted and weighed.
#[derive(Clone, Debug)]
pub(crate) struct Set {
    pub(crate) fit: Fit,
    /// Logarithm of its probability where only listed causes are at work, and where something else is,
    /// too.
    pub(crate) listed: f64,
    pub(crate) free: f64,
    /// The part of them that is known apart from the data.
    pub(crate) known: f64,
    /// Whether the model's own error is beyond 95 % of what is expected.
    is_beyond: bool,
    /// Noise and model error, of the more probable of the two.
    pub(crate) likely: Likely,
    /// Root mean square of the residuals (σ) of the channel of which it is the greatest.
    left_most: f64,
    /// Whether derivatives that were taken at the fit say that it is the best.
    is_sure: bool,
}

impl Set {
    /// The greater of the two.
    pub(crate) fn best(&self) -> f64 {
        self.listed.max(self.free)
    }

    /// Whether so much is left that slopes do not tell what a cause can do.
    fn is_far(&self) -> bool {
        self.left_most > FAR
    }

    /// Whether it leaves something that is not on the list.
    pub(crate) fn is_short(&self) -> bool {
        self.free > self.listed || self.is_beyond
    }
}

/// How what is left of a channel follows itself.
struct Following {
    /// Correlation of a reading with the one before; 0 where chance may have it.
    follows: f64,
    /// Over how many readings it is alike.
    alike: f64,
    /// Root mean square, in the noise as it is stated.
    level: f64,
}

/// A cause that promises something beside a set.
#[derive(Clone, Debug)]
struct Guess {
    cause: usize,
    /// Logarithm of the probability, by the linear model.
    log: f64,
    /// Where the linear model has the parameters; none of causes that small steps do not reach.
    fit: Option<Fit>,
    /// Whether that is far from the set.
    is_far: bool,
}

impl Guess {
    /// One of which no linear model tells anything.
    fn far(cause: usize) -> Guess {
        Guess {
            cause,
            log: f64::INFINITY,
            fit: None,
            is_far: true,
        }
    }
}

/// An experiment in short windows, near a fit.
struct Near {
    /// Parameters of its columns.
    shared: Vec<(usize, usize)>,
    /// Products of its columns and residuals, clear of where each window begins.
    products: DMatrix<f64>,
    readings: f64,
    fit: Fit,
    causes: Vec<Cause>,
}

impl Near {
    /// In windows as long as leave the model without a cause not far off.
    fn new(kind: &dyn Kind, settings: &Settings) -> Option<Near> {
        const COUNTS: [usize; 2] = [24, 200];
        for count in COUNTS {
            let windows = kind.windows(count)?;
            let view = View::new(windows.as_ref(), settings);
            let runs: Vec<usize> = (0..view.logs().len()).collect();
            let fit = fit::refit(&view, Fit::first(&view), &runs, &None, fit::STEPS)?;
            if count != COUNTS[1] && fit::scales(&view, &fit)?.iter().any(|s| *s > FAR) {
                continue;
            }
            let all: Vec<usize> = (view.common()..view.listed()).collect();
            let linear = Linear::new(&view, &fit, &all, &Expected::new(&view))?;
            return Some(Near::of(&view, linear, fit));
        }
        None
    }

    fn of(kind: &dyn Kind, linear: Linear, fit: Fit) -> Near {
        let (products, readings) = linear.reduced();
        Near {
            shared: linear.shared,
            products,
            readings,
            fit,
            causes: kind.causes().to_vec(),
        }
    }

    /// Where the windows have the parameters of `causes` and of what nobody knows, beside the unknowns of
    /// `whole`; and how probable they are.
    fn with(&self, causes: &[usize], common: usize, whole: &Fit) -> Option<(f64, Fit)> {
        let n = self.shared.len();
        let is_on = |k: &usize| self.shared[*k].0 < common || causes.contains(&self.shared[*k].0);
        let mut on: Vec<usize> = (0..n).filter(is_on).collect();
        loop {
            let m = on.len();
            let mut matrix = DMatrix::from_fn(m, m, |i, j| self.products[(on[i], on[j])]);
            for i in 0..m {
                matrix[(i, i)] *= 1.0 + 1e-9;
                matrix[(i, i)] += 1e-9;
            }
            let slope = DVector::from_fn(m, |i, _| self.products[(on[i], n)]);
            let step = matrix.cholesky()?.solve(&slope);
            let value = |k: usize| {
                let (c, p) = self.shared[on[k]];
                let spec = &self.causes[c].parameters[p];
                (self.fit.terms.get(c, p) + step[k] * spec.scale, spec.bounds)
            };
            let is_beyond = |k: &usize| {
                let (x, bounds) = value(*k);
                x < bounds.0 || x > bounds.1
            };
            if let Some(k) = (0..m).find(is_beyond) {
                on.remove(k);
                continue;
            }
            let mut fit = whole.clone();
            fit.causes = causes.to_vec();
            for (k, place) in on.iter().enumerate() {
                let (c, p) = self.shared[*place];
                fit.terms.set(c, p, value(k).0);
            }
            let left = (self.products[(n, n)] - slope.dot(&step)).max(1.0);
            return Some((-0.5 * self.readings * (left / self.readings).ln(), fit));
        }
    }
}

/// All sets that were fitted, by their causes in order.
pub(crate) struct Search<'a> {
    pub(crate) kind: &'a dyn Kind,
    pub(crate) expected: Expected,
    pub(crate) sets: BTreeMap<Vec<usize>, Set>,
    /// Causes that were fitted beside each set from all their starts.
    searched: BTreeSet<(Vec<usize>, usize)>,
    /// What was fitted beside each set.
    expanded: BTreeMap<Vec<usize>, Vec<Vec<usize>>>,
    /// The model as it is, linearised.
    around: Option<Near>,
    /// The same experiment in short windows, linearised, where runs may begin anywhere and the model as
    /// it is is far off.
    near: Option<Near>,
    most: usize,
    runs: Vec<usize>,
    progress: &'a (dyn Fn(Stage) + Sync),
    /// Share of the work that is done.
    share: f64,
}

impl<'a> Search<'a> {
    /// With the model as it is; none where that has no answer.
    pub(crate) fn new(
        kind: &'a dyn Kind,
        settings: &Settings,
        progress: &'a (dyn Fn(Stage) + Sync),
    ) -> Option<Search<'a>> {
        let runs: Vec<usize> = (0..kind.logs().len()).collect();
        let mut search = Search {
            kind,
            expected: Expected::new(kind),
            sets: BTreeMap::new(),
            searched: BTreeSet::new(),
            expanded: BTreeMap::new(),
            around: None,
            near: None,
            most: settings.most.unwrap_or(kind.most()),
            runs,
            progress,
            share: 0.0,
        };
        let none = search.none()?;
        let near: Vec<usize> = (kind.common()..kind.listed())
            .filter(|c| !kind.causes()[*c].is_apart())
            .collect();
        search.around = Linear::new(kind, &none.fit, &near, &search.expected)
            .map(|linear| Near::of(kind, linear, none.fit.clone()));
        search.sets.insert(Vec::new(), none);
        Some(search)
    }

    /// Where the model as it is is far off, looks at short windows, in which it is not.
    pub(crate) fn start_near(&mut self, settings: &Settings) {
        if self.sets[&Vec::new()].is_far() {
            self.near = Near::new(self.kind, settings);
        }
    }

    fn tell(&self, doing: &str) {
        let share = self.share;
        (self.progress)(Stage { share, doing });
    }

    fn none(&self) -> Option<Set> {
        let mut first = Fit::first(self.kind);
        first.scales = vec![f64::INFINITY; self.kind.channels().len()];
        self.settled(fit::refit(self.kind, first, &self.runs, &None, fit::STEPS)?)
    }

    /// Explores sets until none is more probable than the best. The share of the work that is done rises
    /// between the two of `(from, to)`.
    pub(crate) fn explore(&mut self, (from, to): (f64, f64)) {
        let mut level: Vec<Vec<usize>> = vec![Vec::new()];
        for size in 0..self.most {
            let mut next = Vec::new();
            let best = level
                .iter()
                .map(|base| self.score(base))
                .fold(f64::NEG_INFINITY, f64::max);
            let is_short = |base: &Vec<usize>| self.sets.get(base).is_none_or(Set::is_short);
            // Where something is left, the best alone may be neither of two.
            let leaves = level
                .iter()
                .any(|base| self.score(base) >= best && is_short(base));
            level.retain(|base| leaves || self.score(base) > best - NEAR);
            let count = level.len();
            for (k, base) in level.into_iter().enumerate() {
                let part = (size as f64 + k as f64 / count as f64) / (self.most + 1) as f64;
                self.share = from + (to - from) * part;
                next.extend(self.expand(&base, FITTED));
            }
            next.sort_by(|a, b| self.score(b).total_cmp(&self.score(a)));
            next.dedup();
            let here = next
                .first()
                .map_or(f64::NEG_INFINITY, |set| self.score(set));
            // A term without a name stands for something unknown: nothing is looked for beside it.
            next.retain(|set| set.iter().all(|c| *c < self.kind.listed()));
            let loss = |set: &Vec<usize>| self.sets[set].fit.loss;
            let least = next.iter().min_by(|a, b| loss(a).total_cmp(&loss(b)));
            let least = least.filter(|set| self.sets[*set].is_far()).cloned();
            // Where much is left, the error of the model hides what a cause explains.
            next.truncate(WIDTH - usize::from(least.is_some()));
            next.extend(least);
            next.sort_unstable();
            next.dedup();
            let before = self.best_of(|set| set.len() <= size);
            if here < before - 3.0 {
                break;
            }
            level = next;
        }
        self.share = to - (to - from) / (self.most + 1) as f64;
        self.pairs();
        self.refine();
        self.share = to;
    }

    /// Where the best set leaves something or has several causes, fits pairs: a gain and an offset, or a
    /// pressure and a friction, may nearly cancel, and then neither explains much alone.
    fn pairs(&mut self) {
        let best = self.best();
        let is_wanted = best.len() > 1 || self.sets.get(&best).is_none_or(Set::is_short);
        let Some(around) = self.around.as_ref().filter(|_| is_wanted && self.most > 1) else {
            return;
        };
        let near: Vec<usize> = (self.kind.common()..self.kind.listed())
            .filter(|c| !self.kind.causes()[*c].is_apart())
            .collect();
        let all: Vec<[usize; 2]> = near
            .iter()
            .enumerate()
            .flat_map(|(k, a)| near[k + 1..].iter().map(|b| [*a, *b]))
            .filter(|pair| !self.sets.contains_key(&pair[..]))
            .collect();
        let whole = &self.sets[&Vec::new()].fit;
        let found = parallel::map(all.len(), |k| {
            around.with(&all[k], self.kind.common(), whole)
        });
        let mut order: Vec<usize> = (0..all.len()).filter(|k| found[*k].is_some()).collect();
        let log = |k: usize| found[k].as_ref().map_or(f64::NEG_INFINITY, |f| f.0);
        order.sort_by(|a, b| log(*b).total_cmp(&log(*a)));
        order.truncate(PAIRS);
        let fitted = parallel::map(order.len(), |k| {
            let from = found[order[k]].as_ref()?.1.clone();
            self.settled(fit::refit(self.kind, from, &self.runs, &None, fit::STEPS)?)
        });
        for (k, set) in order.into_iter().zip(fitted) {
            if let Some(set) = set {
                self.sets.insert(all[k].to_vec(), set);
            }
        }
    }

    /// Exchanges and drops causes of the best set until none is better.
    fn refine(&mut self) {
        const ROUNDS: usize = 4;
        for _ in 0..ROUNDS {
            let best = self.best();
            if !self.sets.get(&best).is_none_or(|set| set.is_sure) {
                self.sure(&best);
                continue;
            }
            self.shorten(&best);
            let is_lost = |causes: &Vec<usize>| self.sets.get(causes).is_none_or(Set::is_far);
            let is_good = !is_lost(&best);
            // Of many causes, and where those left are far off, slopes at the answer tell more: see `exchange`.
            let shorter =
                parts(&best).filter(|less| best.len() < MANY && !(is_good && is_lost(less)));
            for less in shorter.collect::<Vec<_>>() {
                self.expand(&less, FITTED);
            }
            if self.best() == best {
                self.exchange(&best);
                if self.best() == best {
                    return;
                }
            }
        }
    }

    /// Fits a set without each of its causes, where that was not done.
    fn shorten(&mut self, base: &[usize]) {
        let kind = self.kind;
        let gone: Vec<usize> = (0..base.len())
            .filter(|k| !self.sets.contains_key(&but(base, *k)))
            .map(|k| base[k])
            .collect();
        let Some(linear) = self.sure(base).filter(|_| !gone.is_empty()) else {
            return;
        };
        let fit = &self.sets[base].fit;
        let fitted = parallel::map(gone.len(), |k| {
            let begin = without(kind, fit.clone(), gone[k]);
            let slopes = linear.slopes(kind, fit, &begin.causes);
            self.near_by(begin, slopes)
        });
        for set in fitted.into_iter().flatten() {
            let mut causes = set.fit.causes.clone();
            causes.sort_unstable();
            self.sets.insert(causes, set);
        }
    }

    /// The fit that begins at `begin`, with derivatives from nearby.
    fn near_by(&self, begin: Fit, slopes: Slopes) -> Option<Set> {
        let steps = fit::ROUGH_STEPS;
        let (fit, slopes) = fit::refit_near(self.kind, begin, slopes, &self.runs, steps)?;
        let (fit, slopes) = fit::settled(self.kind, fit, slopes, &self.runs)?;
        self.weighed(fit, slopes)
    }

    /// Fits what the linear model at a set says to do in the place of each of its causes: from no cause at
    /// all, small steps need not lead there.
    fn exchange(&mut self, base: &[usize]) {
        /// Causes that are fitted in the place of each.
        const FEW: usize = 3;
        let kind = self.kind;
        let Some(linear) = self.sure(base) else {
            return;
        };
        let set = &self.sets[base];
        let fit = &set.fit;
        let on = |causes: &[usize]| linear.places(|c| c < kind.common() || causes.contains(&c));
        let Some(now) = linear.evaluate(&on(base), &self.expected, false) else {
            return;
        };
        let mut tried: Vec<Fit> = Vec::new();
        for &gone in base.iter().filter(|c| !kind.causes()[**c].is_apart()) {
            let places = linear.places(|c| c == gone);
            let back = |place: usize| {
                let (c, p) = linear.shared[place];
                let spec = &kind.causes()[c].parameters[p];
                (place, (fit.terms.get(c, p) - spec.neutral) / spec.scale)
            };
            let back: Vec<(usize, f64)> = places.into_iter().map(back).collect();
            let there = linear.without(&back);
            let from = without(kind, fit.clone(), gone);
            let others: Vec<usize> = (kind.common()..kind.listed())
                .filter(|c| !base.contains(c) && !kind.causes()[*c].is_apart())
                .collect();
            let found = parallel::map(others.len(), |k| {
                let mut causes = from.causes.clone();
                causes.push(others[k]);
                let active = on(&causes);
                let likely = there.evaluate(&active, &self.expected, false)?;
                let moved = there.moved(kind, &from, (others[k], &active), &likely);
                (likely.log > now.log - HOPELESS).then_some((likely.log, moved))
            });
            let mut found: Vec<(f64, Fit)> = found.into_iter().flatten().collect();
            found.sort_by(|a, b| b.0.total_cmp(&a.0));
            tried.extend(found.into_iter().take(FEW).map(|(_, fit)| fit));
        }
        let fitted = parallel::map(tried.len(), |k| {
            let begin = tried[k].clone();
            let slopes = linear.slopes(kind, fit, &begin.causes);
            self.near_by(begin, slopes)
        });
        for set in fitted.into_iter().flatten() {
            self.keep(set);
        }
    }

    /// A fit without one of its causes, fitted.
    pub(crate) fn without(&self, fit: Fit, cause: usize) -> Option<Set> {
        let fit = without(self.kind, fit, cause);
        self.settled(fit::refit(self.kind, fit, &self.runs, &None, fit::STEPS)?)
    }

    fn score(&self, causes: &[usize]) -> f64 {
        self.sets.get(causes).map_or(f64::NEG_INFINITY, Set::best)
    }

    fn best_of(&self, is: impl Fn(&[usize]) -> bool) -> f64 {
        let all = self.sets.iter().filter(|(causes, _)| is(causes));
        all.map(|(_, set)| set.best())
            .fold(f64::NEG_INFINITY, f64::max)
    }

    /// The most probable set; of equal ones that with the fewest parameters.
    pub(crate) fn best(&self) -> Vec<usize> {
        /// Difference in the logarithm of a probability, for each parameter but the first of a cause, that
        /// tells nothing.
        const EQUAL: f64 = 1.0;
        let further = |c: &usize| self.kind.causes()[*c].parameters.len().saturating_sub(1) as f64;
        let worth = |(causes, set): (&Vec<usize>, &Set)| {
            set.best() - EQUAL * causes.iter().map(further).sum::<f64>()
        };
        let best = self
            .sets
            .iter()
            .max_by(|a, b| worth(*a).total_cmp(&worth(*b)));
        best.map(|(causes, _)| causes.clone()).unwrap_or_default()
    }

    /// Fits the sets that have one more cause than `base` and promise most; their causes.
    pub(crate) fn expand(&mut self, base: &[usize], count: usize) -> Vec<Vec<usize>> {
        if base.len() >= self.most || !self.sets.contains_key(base) {
            return Vec::new();
        }
        if !self.expanded.contains_key(base) {
            let all = self.expanded_anew(base, count);
            self.expanded.insert(base.to_vec(), all);
        }
        self.expanded[base].clone()
    }

    fn expanded_anew(&mut self, base: &[usize], count: usize) -> Vec<Vec<usize>> {
        let linear = self.sure(base);
        let from = self.sets[base].fit.clone();
        let with = |cause: usize| {
            let mut all = base.to_vec();
            all.push(cause);
            all.sort_unstable();
            all
        };
        let all = self.promising(&from, linear.as_ref(), count);
        let mut found: Vec<Vec<usize>> = all.iter().map(|guess| with(guess.cause)).collect();
        let is_new = |guess: &Guess| !self.sets.contains_key(&with(guess.cause));
        let mut guesses: Vec<Guess> = all.into_iter().filter(is_new).collect();
        let is_scouted = self.sets[base].is_far() && self.runs.len() > FEW;
        if is_scouted {
            guesses = self.scouted(&from, linear.as_ref(), guesses);
        } else if guesses.len() > 2 * count {
            guesses = self.screened(&from, linear.as_ref(), guesses, 2 * count);
        }
        let mut fitted = parallel::map(guesses.len(), |k| {
            let name = self.kind.causes()[guesses[k].cause].id;
            self.tell(&format!("{name} as cause {}", base.len() + 1));
            self.fitted(&from, linear.as_ref(), &guesses[k])
        });
        if count == FITTED && !is_scouted {
            self.add_apart(&from, &mut guesses, &mut fitted);
            self.try_elsewhere(&from, self.sets[base].is_far(), &guesses, &mut fitted);
        }
        for (guess, set) in guesses.iter().zip(fitted) {
            let Some(set) = set else { continue };
            found.push(with(guess.cause));
            self.keep(set);
        }
        found.sort_unstable();
        found.dedup();
        found.retain(|set| self.sets.contains_key(set));
        found
    }

    /// Of many guesses, the most promising first, those that promise most and those that some steps bring
    /// furthest, as many as `count`.
    fn screened(
        &self,
        from: &Fit,
        linear: Option<&Linear>,
        mut guesses: Vec<Guess>,
        count: usize,
    ) -> Vec<Guess> {
        /// Steps of each.
        const FIRST: usize = 4;
        let begun = parallel::map(guesses.len(), |k| {
            let begin = guesses[k].fit.clone()?;
            let slopes = linear?.slopes(self.kind, from, &begin.causes);
            Some(fit::refit_near(self.kind, begin, slopes, &self.runs, FIRST)?.0)
        });
        for (guess, begun) in guesses.iter_mut().zip(begun) {
            guess.fit = begun.or_else(|| guess.fit.take());
        }
        let loss = |guess: &Guess| guess.fit.as_ref().map_or(f64::INFINITY, |fit| fit.loss);
        // The first half by what they promise.
        let mut rest = guesses.split_off(count / 2);
        rest.sort_by(|a, b| loss(a).total_cmp(&loss(b)));
        rest.truncate(count - count / 2);
        guesses.extend(rest);
        guesses
    }

    /// Where slopes do not tell what a cause can do, few runs tell it as well as many: each guess, and each
    /// cause that small steps do not reach, is fitted to them from all its starts. Those that explain most.
    fn scouted(&self, from: &Fit, linear: Option<&Linear>, mut guesses: Vec<Guess>) -> Vec<Guess> {
        let kind = self.kind;
        let all = self.runs.len();
        let few: Vec<usize> = (0..FEW).map(|k| k * all / FEW).collect();
        for cause in kind.common()..kind.listed() {
            let is_in = from.causes.contains(&cause) || guesses.iter().any(|g| g.cause == cause);
            if kind.causes()[cause].is_apart() && !is_in {
                guesses.push(Guess::far(cause));
            }
        }
        let Some(base) = fit::refit(kind, from.clone(), &few, &None, 0) else {
            return guesses;
        };
        let begun = parallel::map(guesses.len(), |k| {
            let name = kind.causes()[guesses[k].cause].id;
            self.tell(&format!("{name} as cause {}", from.causes.len() + 1));
            let begin = guesses[k].fit.clone()?;
            let slopes = match linear.filter(|_| !guesses[k].is_far) {
                Some(linear) => linear.slopes(kind, from, &begin.causes),
                None => fit::no_slopes(kind, &begin),
            };
            let slopes = few.iter().map(|run| slopes[*run].clone()).collect();
            Some(fit::refit_near(kind, begin, slopes, &few, fit::ROUGH_STEPS)?.0)
        });
        let losses = begun.iter().flatten().map(|fit| fit.loss);
        let least = losses.fold(base.loss, f64::min);
        let enough = GIVEN_UP * (base.loss - least);
        let elsewhere = parallel::map(guesses.len(), |k| {
            fit::fit_if(kind, &base, guesses[k].cause, &few, enough)
        });
        let mut found = Vec::new();
        for ((guess, begun), elsewhere) in guesses.into_iter().zip(begun).zip(elsewhere) {
            let both = begun.into_iter().chain(elsewhere);
            let best = both.min_by(|a, b| a.loss.total_cmp(&b.loss));
            found.extend(best.map(|fit| (fit.loss, guess.cause, fit)));
        }
        let least = found.iter().map(|f| f.0).fold(base.loss, f64::min);
        found.retain(|f| base.loss - f.0 > GIVEN_UP * (base.loss - least));
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        found.truncate(2 * FITTED);
        let of = |(_, cause, mut fit): (f64, usize, Fit)| {
            let others = self.runs.iter().filter(|run| !few.contains(run));
            others.for_each(|run| fit::begin_afresh(kind, &mut fit, *run));
            Guess {
                fit: Some(fit),
                ..Guess::far(cause)
            }
        };
        found.into_iter().map(of).collect()
    }

    /// Keeps a set if it is better than what is known of the same causes. Those that do nothing where they
    /// ended are no part of it.
    fn keep(&mut self, mut set: Set) {
        let kind = self.kind;
        let all = set.fit.causes.iter().copied();
        let mut causes: Vec<usize> = all.filter(|c| does_something(kind, *c, &set.fit)).collect();
        if causes.len() < set.fit.causes.len() {
            let mut fit = set.fit;
            fit.causes.clone_from(&causes);
            let Some(less) = self.weighed_anew(fit) else {
                return;
            };
            set = less;
        }
        causes.sort_unstable();
        if set.best() > self.score(&causes) {
            self.expanded.remove(&causes);
            self.sets.insert(causes, set);
        }
    }

    /// The fit that begins at a guess beside `from`.
    fn fitted(&self, from: &Fit, linear: Option<&Linear>, guess: &Guess) -> Option<Set> {
        let begin = guess.fit.clone()?;
        let Some(linear) = linear.filter(|_| !guess.is_far) else {
            return self.settled(fit::refit(self.kind, begin, &self.runs, &None, fit::STEPS)?);
        };
        let slopes = linear.slopes(self.kind, from, &begin.causes);
        self.near_by(begin, slopes)
    }

    /// Where no listed cause explains all, those that small steps do not reach may: of them no linear model
    /// tells what they can do.
    fn add_apart(&self, from: &Fit, guesses: &mut Vec<Guess>, fitted: &mut Vec<Option<Set>>) {
        let is_listed = |set: &&Set| set.fit.causes.iter().all(|c| *c < self.kind.listed());
        let all = fitted.iter().flatten();
        let best = all.max_by(|a, b| a.best().total_cmp(&b.best()));
        let Some(best) = best else { return };
        if is_listed(&best) && !best.is_short() {
            return;
        }
        for cause in self.kind.common()..self.kind.listed() {
            let is_in = from.causes.contains(&cause) || guesses.iter().any(|g| g.cause == cause);
            if self.kind.causes()[cause].is_apart() && !is_in {
                guesses.push(Guess::far(cause));
                fitted.push(None);
            }
        }
    }

    /// One that does not hold what it promises, and promises as much as others hold, has other starts.
    fn try_elsewhere(
        &mut self,
        from: &Fit,
        is_far: bool,
        guesses: &[Guess],
        fitted: &mut [Option<Set>],
    ) {
        /// Causes that are.
        const MOST: usize = 12;
        let all = || fitted.iter().flatten();
        let best = all().max_by(|a, b| a.best().total_cmp(&b.best()));
        let held = best.map_or(f64::NEG_INFINITY, Set::best);
        let is_solved = is_far && best.is_some_and(|set| !set.is_far());
        let is_far = is_far && best.is_none_or(Set::is_short);
        // Half of the way to where nothing moves any more.
        let is_stuck = |set: &Set| is_solved && set.is_far() && set.fit.loss < 0.5 * from.loss;
        let least = all().map(|set| set.fit.loss).fold(from.loss, f64::min);
        let mut again: Vec<usize> = (0..guesses.len())
            .filter(|k| {
                let promise = guesses[*k].log;
                let own = fitted[*k].as_ref().map_or(f64::NEG_INFINITY, Set::best);
                let is_behind = own < promise - BEHIND && (is_far || promise > held - NEAR);
                is_behind || fitted[*k].as_ref().is_some_and(is_stuck)
            })
            .collect();
        let loss = |k: &usize| {
            let fit = fitted[*k].as_ref().map(|set| &set.fit);
            // Of what no linear model tells anything nothing is known either.
            fit.map_or(0.0, |fit| fit.loss)
        };
        again.sort_by(|a, b| loss(a).total_cmp(&loss(b)));
        again.truncate(MOST);
        let mut base = from.causes.clone();
        base.sort_unstable();
        again.retain(|k| self.searched.insert((base.clone(), guesses[*k].cause)));
        let others = parallel::map(again.len(), |k| {
            let cause = guesses[again[k]].cause;
            let own = fitted[again[k]].as_ref().map_or(least, |set| set.fit.loss);
            let enough = GIVEN_UP * (from.loss - own);
            self.settled(fit::fit_if(self.kind, from, cause, &self.runs, enough)?)
        });
        for (k, other) in again.into_iter().zip(others) {
            let own = fitted[k].take();
            fitted[k] = own
                .into_iter()
                .chain(other)
                .max_by(|a, b| a.best().total_cmp(&b.best()));
        }
    }

    /// Takes the derivatives by all causes at a set, and makes sure that its fit is the best.
    fn sure(&mut self, base: &[usize]) -> Option<Linear> {
        /// Fall of the loss that matters.
        const MATTERS: f64 = 1.0;
        let (kind, set) = (self.kind, self.sets.get(base)?);
        let all: Vec<usize> = (kind.common()..kind.causes().len()).collect();
        let mut linear = Linear::new(kind, &set.fit, &all, &self.expected)?;
        if set.is_sure {
            return Some(linear);
        }
        let mut fit = set.fit.clone();
        let mut slopes = linear.slopes(kind, &fit, &fit.causes);
        let steps = fit::ROUGH_STEPS;
        let refitted = fit::refit_near(kind, fit.clone(), slopes.clone(), &self.runs, steps);
        if let Some((better, by)) = refitted
            && better.loss < fit.loss - MATTERS
            && let Some(there) = Linear::new(kind, &better, &all, &self.expected)
        {
            (fit, slopes, linear) = (better, by, there);
        }
        let mut set = self.weighed(fit, slopes)?;
        set.is_sure = true;
        self.sets.insert(base.to_vec(), set);
        Some(linear)
    }

    /// A fit, with residuals counted by what is left of each channel, and how probable it is.
    fn settled(&self, fit: Fit) -> Option<Set> {
        let linear = Linear::new(self.kind, &fit, &fit.causes, &self.expected)?;
        let slopes = linear.slopes(self.kind, &fit, &fit.causes);
        let (fit, slopes) = fit::settled(self.kind, fit, slopes, &self.runs)?;
        self.weighed(fit, slopes)
    }

    fn weighed_anew(&self, fit: Fit) -> Option<Set> {
        let linear = Linear::new(self.kind, &fit, &fit.causes, &self.expected)?;
        let slopes = linear.slopes(self.kind, &fit, &fit.causes);
        self.weighed(fit, slopes)
    }

    /// The causes that a linear model at `fit` says to explain most.
    fn promising(&self, fit: &Fit, linear: Option<&Linear>, count: usize) -> Vec<Guess> {
        let kind = self.kind;
        let all = kind.common()..kind.causes().len();
        let absent: Vec<usize> = all.filter(|c| !fit.causes.contains(c)).collect();
        let Some(linear) = linear else {
            return absent.into_iter().map(Guess::far).collect();
        };
        let is_far = linear.left_most() > FAR;
        let is_lost = fit.scales.iter().any(|s| *s > FAR);
        if let Some(near) = self.near.as_ref().filter(|_| is_lost) {
            return self.promising_near(near, fit, &absent);
        }
        let found = parallel::map(absent.len(), |k| {
            promise(kind, &self.expected, linear, fit, absent[k])
        });
        let scores: Vec<f64> = found.iter().map(|f| f.0).collect();
        let mut order: Vec<usize> = (0..absent.len()).collect();
        order.sort_by(|a, b| scores[*b].total_cmp(&scores[*a]));
        let is_listed = |k: &usize| absent[*k] < kind.listed();
        let best = |of: bool| {
            let mut those = order.iter().filter(|k| is_listed(k) == of);
            those.next().map_or(f64::NEG_INFINITY, |k| scores[*k])
        };
        let best = [best(false), best(true)];
        let now = self.best_of(|_| true);
        let mut causes = fit.causes.clone();
        causes.sort_unstable();
        // A cause more must be worth it.
        let beside = self.score(&causes) - WORTH;
        // Where much is left, slopes do not tell what a cause can do.
        let may = |(place, k): &(usize, usize)| {
            let least = (best[usize::from(is_listed(k))] - HOPELESS)
                .max(now - NEAR)
                .max(beside);
            let is_first = fit.causes.is_empty() && is_listed(k);
            (is_far && (is_first || *place < count)) || (*place < count && scores[*k] > least)
        };
        let chosen = order.into_iter().enumerate().filter(may).map(|(_, k)| k);
        chosen
            .map(|k| Guess {
                cause: absent[k],
                log: scores[k],
                fit: found[k].1.clone(),
                is_far: false,
            })
            .collect()
    }

    /// Every listed cause, where short windows have its parameters beside those of `fit`; the best first.
    fn promising_near(&self, near: &Near, fit: &Fit, absent: &[usize]) -> Vec<Guess> {
        let first = Fit::first(self.kind);
        let listed = absent.iter().copied().filter(|c| *c < self.kind.listed());
        let mut all: Vec<Guess> = listed
            .filter_map(|cause| {
                let mut causes = fit.causes.clone();
                causes.push(cause);
                let whole = Fit {
                    scales: fit.scales.clone(),
                    ..first.clone()
                };
                let (log, fit) = near.with(&causes, self.kind.common(), &whole)?;
                Some(Guess {
                    cause,
                    log,
                    fit: Some(fit),
                    is_far: true,
                })
            })
            .collect();
        all.sort_by(|a, b| b.log.total_cmp(&a.log));
        all.truncate(FITTED);
        for guess in &mut all {
            // What windows promise is not what whole runs hold.
            guess.log = f64::NEG_INFINITY;
        }
        all
    }

    /// A fit with how probable it is, with the derivatives there.
    fn weighed(&self, fit: Fit, slopes: Slopes) -> Option<Set> {
        let linear = Linear::with(self.kind, &fit, slopes, &self.expected)?;
        Set::weighed(self.kind, &self.expected, fit, &linear)
    }
}

impl Set {
    /// A fit with how probable it is.
    pub(crate) fn weighed(
        kind: &dyn Kind,
        expected: &Expected,
        fit: Fit,
        linear: &Linear,
    ) -> Option<Set> {
        let active = active(kind, linear, &fit);
        let of = |is_free| linear.evaluate(&active, expected, is_free);
        let (listed, free) = (of(false)?, of(true)?);
        let mut odds: f64 = fit.causes.iter().map(|c| prior_of(kind, *c)).sum();
        for (k, place) in active.iter().enumerate() {
            let (c, p) = linear.shared[*place];
            if c >= kind.common() {
                let spec = &kind.causes()[c].parameters[p];
                odds += prior_of_size(spec, fit.terms.get(c, p), listed.variance[k]);
            }
        }
        let known: f64 = fit
            .causes
            .iter()
            .map(|c| kind.causes()[*c].by_prior(fit.terms.of(*c)))
            .sum();
        let scatter = free.scatter.iter();
        let off = expected.amplitude.iter().zip(scatter);
        let off: Vec<f64> = off.map(|(off, scatter)| off / scatter.noise).collect();
        let bump = Linear::bump(&linear.left(&active, &free), &off).max(0.0);
        let a = listed.log + odds + known;
        let unlisted = POLICY.unlisted.ln();
        let b = free.log + odds + known + unlisted + bump;
        let mut channels = (0..listed.scatter.len()).map(|c| (c, listed.scatter[c]));
        Some(Set {
            listed: a,
            free: b,
            known,
            is_beyond: channels.any(|(c, scatter)| expected.is_beyond(c, scatter)),
            likely: if b > a { free } else { listed },
            fit,
            left_most: linear.left_most(),
            is_sure: false,
        })
    }
}

/// A set without its cause `k`.
pub(crate) fn but(set: &[usize], k: usize) -> Vec<usize> {
    [&set[..k], &set[k + 1..]].concat()
}

/// A set without each of its causes in turn.
fn parts(set: &[usize]) -> impl Iterator<Item = Vec<usize>> {
    (0..set.len()).map(|k| but(set, k))
}

/// A fit with one of its causes taken away.
fn without(kind: &dyn Kind, mut fit: Fit, cause: usize) -> Fit {
    fit.causes.retain(|c| *c != cause);
    for (p, parameter) in kind.causes()[cause].parameters.iter().enumerate() {
        fit.terms.set(cause, p, parameter.neutral);
    }
    fit
}

/// Whether a cause is not where it does nothing.
pub(crate) fn does_something(kind: &dyn Kind, cause: usize, fit: &Fit) -> bool {
    let mut parameters = kind.causes()[cause].parameters.iter().enumerate();
    parameters.any(|(p, spec)| fit.terms.get(cause, p) != spec.neutral)
}

/// How probable the linear model says that `fit` is with one cause more, and where that has its
/// parameters.
pub(crate) fn promise(
    kind: &dyn Kind,
    expected: &Expected,
    linear: &Linear,
    fit: &Fit,
    cause: usize,
) -> (f64, Option<Fit>) {
    let spec = &kind.causes()[cause];
    let all = fit.causes.iter().chain([&cause]);
    let odds: f64 = all.map(|c| prior_of(kind, *c)).sum();
    let of = |places: &[usize], (is_free, is_bent): (bool, bool)| {
        let likely = if is_bent {
            linear.evaluate_bent(places, expected, is_free)?
        } else {
            linear.evaluate(places, expected, is_free)?
        };
        let mut log = likely.log + odds;
        if is_free {
            log += POLICY.unlisted.ln();
        }
        for (k, place) in places.iter().enumerate() {
            let (c, p) = linear.shared[*place];
            if c >= kind.common() && (c != cause || !spec.is_apart()) {
                let spec = &kind.causes()[c].parameters[p];
                let value = fit.terms.get(c, p) + likely.step[k] * spec.scale;
                log += prior_of_size(spec, value, likely.variance[k]);
            }
        }
        Some((log, likely))
    };
    let base = linear.places(|c| c < kind.common() || fit.causes.contains(&c));
    let own = linear.places(|c| c == cause);
    // Of starts the best one, of parameters all.
    let ways: Vec<Vec<usize>> = if spec.is_apart() {
        own.iter().map(|place| vec![*place]).collect()
    } else {
        vec![own]
    };
    let mut best = (f64::NEG_INFINITY, None);
    for way in ways {
        let places: Vec<usize> = base.iter().chain(&way).copied().collect();
        for way_of in [(false, false), (true, false), (true, true)] {
            let Some((log, likely)) = of(&places, way_of) else {
                continue;
            };
            if log > best.0 {
                let from = if spec.is_apart() {
                    fit::begun(fit, cause, &spec.starts()[linear.shared[way[0]].1])
                } else {
                    linear.moved(kind, fit, (cause, &places), &likely)
                };
                best = (log, Some(from));
            }
        }
    }
    best
}

/// Logarithm of the prior odds of a cause.
fn prior_of(kind: &dyn Kind, cause: usize) -> f64 {
    let listed = kind.listed() - kind.common();
    if cause < kind.listed() {
        (POLICY.causes / listed.max(1) as f64).ln()
    } else {
        let others = kind.causes().len() - kind.listed();
        (POLICY.unlisted / others.max(1) as f64).ln()
    }
}

/// The columns of parameters that do not rest at a bound.
fn active(kind: &dyn Kind, linear: &Linear, fit: &Fit) -> Vec<usize> {
    let moves = |k: &usize| {
        let (c, p) = linear.shared[*k];
        let spec = &kind.causes()[c].parameters[p];
        let x = fit.terms.get(c, p);
        x > spec.bounds.0 && x < spec.bounds.1
    };
    (0..linear.shared.len()).filter(moves).collect()
}

/// Logarithm of the prior probability of a parameter's size, times what Laplace's integral over it
/// needs: every order of magnitude is as probable as the others.
fn prior_of_size(spec: &Parameter, value: f64, variance: f64) -> f64 {
    let error = variance.max(0.0).sqrt();
    let away = if spec.neutral.is_finite() {
        (value - spec.neutral).abs() / spec.scale
    } else {
        (value / spec.scale).abs()
    };
    let two_sided = spec.neutral > spec.bounds.0 && spec.neutral < spec.bounds.1;
    let sides = if two_sided { 2.0 } else { 1.0 };
    let density = 1.0 / (away.max(error) * sides * POLICY.decades * std::f64::consts::LN_10);
    0.5 * std::f64::consts::TAU.ln() + density.ln()
}

impl Search<'_> {
    /// Takes noise and model error from the residuals of the best set and explores again, until they do not
    /// change. The share of the work that is done rises between the two of `(from, to)`.
    pub(crate) fn follow(&mut self, (from, to): (f64, f64)) {
        const ROUNDS: usize = 4;
        let share = |round: usize| from + (to - from) * round as f64 / ROUNDS as f64;
        for round in 0..ROUNDS {
            let before = self.best();
            if !self.look() {
                return;
            }
            if self.best() == before {
                self.refine();
                self.expand(&before, FITTED);
                if self.best() == before {
                    continue;
                }
            }
            self.explore((share(round), share(round + 1)));
        }
    }

    /// Takes noise that follows itself as that, and what the best set leaves otherwise as so few readings
    /// as are not alike; whether that is new.
    pub(crate) fn look(&mut self) -> bool {
        /// The change that matters.
        const MATTERS: f64 = 1.3;
        /// Noise beyond what is stated that may be noise all the same, where it is stated and where it
        /// is estimated from differences of readings.
        const MORE: (f64, f64) = (1.5, 3.0);
        /// Sets of several causes that are weighed anew.
        const KEPT: usize = 40;
        let best = self.best();
        let Some(set) = self.sets.get(&best) else {
            return false;
        };
        let all = set.likely.scatter.iter();
        let white = all
            .clone()
            .map(|s| Scatter {
                noise: s.noise,
                amplitude: 0.0,
            })
            .collect();
        let (Some(found), Some(raw)) = (
            self.following(set, set.likely.scatter.clone()),
            self.following(set, white),
        ) else {
            return false;
        };
        let (fit, before) = (set.fit.clone(), (set.best(), set.likely.scatter.clone()));
        let mut is_new = false;
        for c in 0..found.len() {
            let channel = &self.kind.channels()[c];
            let most = if channel.is_given { MORE.0 } else { MORE.1 };
            let follows = &mut self.expected.follows[c];
            if raw[c].level < most
                && channel.step < channel.noise
                && *follows == 0.0
                && raw[c].follows > 0.0
            {
                *follows = raw[c].follows.min(0.95);
                // Noise that follows itself, or the model's own error?
                if self
                    .weighed_anew(fit.clone())
                    .is_some_and(|set| set.listed > before.0)
                {
                    is_new = true;
                    continue;
                }
                self.expected.follows[c] = 0.0;
            }
            let is_more = before.1[c].noise > most;
            if is_more && (found[c].alike / self.expected.alike[c]).ln().abs() > MATTERS.ln() {
                self.expected.alike[c] = found[c].alike;
                is_new = true;
            }
        }
        if !is_new {
            return false;
        }
        self.expanded.clear();
        let mut all: Vec<(Vec<usize>, Set)> = std::mem::take(&mut self.sets).into_iter().collect();
        all.sort_by(|a, b| b.1.best().total_cmp(&a.1.best()));
        let mut place = 0..;
        all.retain(|(causes, _)| causes.len() < 2 || place.next().is_some_and(|k| k < KEPT));
        let weighed = parallel::map(all.len(), |k| self.weighed_anew(all[k].1.fit.clone()));
        let all = all.into_iter().zip(weighed);
        self.sets = all.filter_map(|((k, _), s)| Some((k, s?))).collect();
        true
    }

    /// How what a set leaves of each channel follows itself, with this noise and model error.
    fn following(&self, set: &Set, scatter: Vec<Scatter>) -> Option<Vec<Following>> {
        let linear = Linear::new(self.kind, &set.fit, &set.fit.causes, &self.expected)?;
        let active = active(self.kind, &linear, &set.fit);
        let likely = Likely {
            scatter,
            ..set.likely.clone()
        };
        let mut series: Vec<Vec<Vec<f64>>> = vec![Vec::new(); self.kind.channels().len()];
        for (channel, left) in linear.left(&active, &likely) {
            series[channel].push(left);
        }
        let of = |(c, runs): (usize, &Vec<Vec<f64>>)| {
            let n: usize = runs.iter().map(Vec::len).sum();
            let covariance = |lag: usize| -> f64 {
                let pairs = runs.iter().flat_map(|s| s.iter().zip(s.iter().skip(lag)));
                pairs.map(|(a, b)| a * b).sum()
            };
            let (all, count) = (covariance(0).max(1e-300), n.max(1) as f64);
            let chance = 4.0 / count.sqrt();
            let longest = runs.iter().map(Vec::len).max().unwrap_or(0) / 3;
            let lags = (1..longest).map(|lag| covariance(lag) / all);
            let alike: f64 = lags.take_while(|rho| *rho > chance).sum();
            let follows = covariance(1) / all;
            Following {
                follows: if follows > chance { follows } else { 0.0 },
                alike: 1.0 + 2.0 * alike,
                level: (all / count).sqrt() * likely.scatter[c].noise,
            }
        };
        Some(series.iter().enumerate().map(of).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::toy::{Toy, noise, sum, wave};

    fn explored(toy: &Toy) -> Search<'_> {
        let settings = Settings {
            most: Some(3),
            ..Settings::default()
        };
        let mut search = Search::new(toy, &settings, &|_| ()).expect("an answer");
        search.explore((0.0, 1.0));
        search
    }

    #[test]
    fn noise_has_no_cause() {
        for seed in 0..20 {
            let toy = Toy::new(&noise(seed), (0..10).map(wave).collect());
            let search = explored(&toy);
            let best = search.best();
            assert!(
                best.is_empty() && !search.sets[&best].is_short(),
                "{seed}: {best:?}"
            );
        }
    }

    /// Of several causes those at work are found, whatever their order.
    #[test]
    fn causes_at_work_are_found() {
        for (k, hidden) in [vec![2], vec![1, 4], vec![0, 3, 7]].into_iter().enumerate() {
            let waves: Vec<Vec<f64>> = (0..9).map(wave).collect();
            let mut parts: Vec<(f64, &[f64])> =
                hidden.iter().map(|h| (15.0, &waves[*h][..])).collect();
            let noise = noise(30 + k as u128);
            parts.push((1.0, &noise));
            let toy = Toy::new(&sum(&parts), waves.clone());
            assert_eq!(explored(&toy).best(), hidden);
        }
    }

    /// a and b = cos δ a + sin δ n nearly cancel: of n alone, each explains sin²δ, both all of it.
    #[test]
    fn two_that_nearly_cancel_are_found_together() {
        let (sin, cos) = 0.1_f64.sin_cos();
        let b = sum(&[(cos, &wave(0)), (sin, &wave(1))]);
        let data = sum(&[(60.0, &wave(1)), (1.0, &noise(1))]);
        let toy = Toy::new(&data, vec![wave(0), b, wave(2)]);
        assert_eq!(explored(&toy).best(), [0, 1]);
    }

    /// The best alone, a + b, takes no place that two others deserve.
    #[test]
    fn a_sum_does_not_stand_for_two() {
        let data = sum(&[(20.0, &wave(0)), (25.0, &wave(1)), (1.0, &noise(3))]);
        let tilted = sum(&[(0.7, &wave(0)), (0.7, &wave(1)), (0.14, &wave(2))]);
        let toy = Toy::new(&data, vec![tilted, wave(0), wave(1)]);
        assert_eq!(explored(&toy).best(), [1, 2]);
    }

    /// One column explains what two do: the second needs a reason.
    #[test]
    fn one_stands_for_two() {
        let both = sum(&[(0.6, &wave(0)), (0.8, &wave(1))]);
        let data = sum(&[(15.0, &both), (1.0, &noise(4))]);
        let toy = Toy::new(&data, vec![wave(0), wave(1), both]);
        assert_eq!(explored(&toy).best(), [2]);
    }

    /// What is known to be unusual is less probable than what explains the data nearly as well.
    #[test]
    fn what_contradicts_comes_later() {
        let near = sum(&[(0.04_f64.cos(), &wave(0)), (0.04_f64.sin(), &wave(1))]);
        let data = sum(&[(20.0, &wave(0)), (1.0, &noise(5))]);
        let toy = Toy::new(&data, vec![wave(0), near.clone()]);
        let found = explored(&toy);
        let close = found.sets[&vec![0]].best() - found.sets[&vec![1]].best();
        assert!(close.abs() < 2.0, "{close}");
        let best = found.best()[0];
        let known = Toy::new(&data, vec![wave(0), near])
            .with(best, |cause| *cause = cause.clone().usual(1.0, "test"));
        assert_ne!(explored(&known).best(), [best]);
    }

    /// What no cause explains is left over: smooth and large, and shared by all runs or not.
    #[test]
    fn what_no_cause_explains_is_short() {
        let data = sum(&[(60.0, &wave(2)), (1.0, &noise(6))]);
        let toy = Toy::new(&data, vec![wave(20), wave(21)]);
        let search = explored(&toy);
        assert!(search.sets[&search.best()].is_short());
    }

    /// Noise that follows itself is noise, and is told as that.
    #[test]
    fn noise_that_follows_itself_is_noise() {
        for seed in 0..6 {
            let mut values = noise(100 + seed);
            for run in values.chunks_mut(crate::toy::READINGS) {
                for i in 1..run.len() {
                    run[i] = 0.65 * run[i - 1] + f64::sqrt(1.0 - 0.65 * 0.65) * run[i];
                }
            }
            let toy = Toy::new(&values, (0..6).map(wave).collect()).with_discrepancy(0.1);
            let mut search = explored(&toy);
            search.follow((0.0, 1.0));
            let best = search.best();
            let found = &search.sets[&best];
            assert!(
                best.is_empty() && !found.is_short(),
                "{seed}: {best:?} {:?} {} {}",
                search.expected,
                found.listed,
                found.free
            );
            assert!(
                (search.expected.follows[0] - 0.65).abs() < 0.15,
                "{:?}",
                search.expected.follows
            );
        }
    }
}
