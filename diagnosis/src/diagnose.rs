//! A diagnosis from its data to its answer.

use crate::finding::{Alone, Candidate, Competitor, Diagnosis, Finding, Fitness, Reported};
use crate::fit::{self, Fit};
use crate::folds::{Fold, folds};
use crate::gain::{self, Score};
use crate::kind::{Kind, Parameter};
use crate::likelihood::Scatter;
use crate::next;
use crate::policy::POLICY;
use crate::report;
use crate::residuals::worst;
use crate::search::{Search, Set, but, does_something};
use crate::settings::Settings;
use crate::stage::Stage;
use crate::statistics::chi_square;
use crate::view::View;

/// Rivals that are named with a cause; the others are less likely. An answer with more names is no answer.
pub(crate) const MOST_RIVALS: usize = 2;

/// Shares of the work that are done after the first exploration of sets, and after those that follow it.
const EXPLORED: f64 = 0.5;
const FOLLOWED: f64 = 0.8;

/// Causes that make the model of an experiment wrong; none where the model has no answer at its first
/// guesses. `progress` receives the share of the work that is done.
pub fn diagnose(
    kind: &dyn Kind,
    settings: &Settings,
    progress: &(dyn Fn(Stage) + Sync),
) -> Option<Diagnosis> {
    let at = |share, doing| progress(Stage { share, doing });
    at(0.0, "the model as it is");
    let view = View::new(kind, settings);
    let mut search = Search::new(&view, settings, progress)?;
    search.start_near(settings);
    search.look();
    search.explore((0.02, EXPLORED));
    search.follow((EXPLORED, FOLLOWED));
    at(FOLLOWED, "causes that are worth it");
    let folds = folds(&view, settings);
    let causes = search.claimed();
    let causes = search.worth(&view, causes, &folds);
    let mut answer = causes;
    loop {
        let found = Answer::new(&view, &search, settings, answer, folds.clone())?;
        let (fit, causes) = (found.set.fit.clone(), found.causes.clone());
        let gone = match found.tell(progress) {
            Ok(diagnosis) => return Some(diagnosis),
            Err(gone) => gone,
        };
        let less: Vec<usize> = causes.into_iter().filter(|c| *c != gone).collect();
        if !search.sets.contains_key(&less) {
            let fitted = search.without(fit, gone)?;
            search.sets.insert(less.clone(), fitted);
        }
        answer = less;
    }
}

impl Search<'_> {
    /// The most probable set, without causes with which the data are hardly more probable.
    fn claimed(&self) -> Vec<usize> {
        let mut causes = self.best();
        let shorter = |causes: &[usize], k: usize| {
            let less = but(causes, k);
            let now = self.sets[causes].best();
            let set = self.sets.get(&less)?;
            (set.best() > now - POLICY.strong.ln()).then_some(less)
        };
        while let Some(less) = (0..causes.len()).find_map(|k| shorter(&causes, k)) {
            causes = less;
        }
        causes
    }

    /// `causes` as far as they are claimed where something unknown is left: what is bent to the unknown
    /// does not predict data that were left out.
    fn worth(&mut self, view: &View, mut causes: Vec<usize>, folds: &[Fold]) -> Vec<usize> {
        /// Part of a cause's effect that may be left: with more of it in the cause's shape, 95 % intervals
        /// hold that the cause is not there.
        const HIDDEN: f64 = 0.5;
        while let Some(set) = self.sets.get(&causes).filter(|set| set.is_short()).cloned() {
            let scatter = &set.likely.scatter;
            let seen = view.scattering(scatter, &vec![1.0; scatter.len()]);
            let loss = |of: &[usize]| -> Option<f64> {
                let model = Fit {
                    scales: vec![1.0; scatter.len()],
                    ..self.sets.get(of)?.fit.clone()
                };
                let scores = gain::held_out(&seen, &model, folds)?;
                Some(scores.iter().map(|score| score.loss).sum())
            };
            let Some(now) = loss(&causes) else {
                return causes;
            };
            let less = |gone: usize| {
                let others = causes.iter().copied().filter(|c| *c != gone);
                others.collect::<Vec<usize>>()
            };
            let without = causes.iter().filter_map(|c| Some((loss(&less(*c))?, *c)));
            let least = without.min_by(|a, b| a.0.total_cmp(&b.0));
            let least = least.filter(|(loss, _)| *loss <= (1.0 + POLICY.worth) * now);
            let hidden = || {
                let mut all = causes.iter().copied();
                all.find(|c| share(view, &set.fit, *c) > HIDDEN)
            };
            let Some(gone) = least.map(|(_, cause)| cause).or_else(hidden) else {
                let none = loss(&[]).unwrap_or(f64::INFINITY);
                let is_little = now > (1.0 - POLICY.explained) * none;
                return if is_little { Vec::new() } else { causes };
            };
            let less = less(gone);
            if !self.sets.contains_key(&less) {
                let Some(fitted) = self.without(set.fit.clone(), gone) else {
                    return causes;
                };
                self.sets.insert(less.clone(), fitted);
            }
            causes = less;
        }
        causes
    }
}

/// A fit of all runs by the noise of `view`.
fn refitted(view: &View, fit: &Fit) -> Fit {
    let fit = Fit {
        scales: vec![1.0; view.channels().len()],
        ..fit.clone()
    };
    let runs: Vec<usize> = (0..view.logs().len()).collect();
    fit::refit(view, fit.clone(), &runs, &None, fit::STEPS).unwrap_or(fit)
}

/// Ratio of the residuals of `fit` to the effect of `cause` on the same readings (root mean squares), 1 at
/// most.
fn share(kind: &dyn Kind, fit: &Fit, cause: usize) -> f64 {
    let mut without = fit.terms.clone();
    for (p, parameter) in kind.causes()[cause].parameters.iter().enumerate() {
        without.set(cause, p, parameter.neutral);
    }
    let (mut left, mut change) = (0.0, 0.0);
    for run in 0..kind.logs().len() {
        let of = |terms| fit::residuals(kind, run, terms, &fit.unknowns[run]);
        let (Some(now), Some(then)) = (of(&fit.terms), of(&without)) else {
            continue;
        };
        left += now.iter().map(|r| r * r).sum::<f64>();
        let moved = now.iter().zip(&then).map(|(a, b)| (a - b) * (a - b));
        change += moved.sum::<f64>();
    }
    (left / f64::max(change, left)).sqrt()
}

struct Answer<'a> {
    view: &'a View<'a>,
    search: &'a Search<'a>,
    settings: &'a Settings,
    /// The experiment with the noise as it was found; and with what that is worth where readings follow
    /// each other.
    seen: View<'a>,
    wide: View<'a>,
    causes: Vec<usize>,
    set: &'a Set,
    before: Fit,
    after: Fit,
    /// The answer, fitted by the noise of `wide`.
    widely: Fit,
    folds: Vec<Fold>,
    /// Scores of the data left out, by the model before and after.
    scores: [Option<Vec<Score>>; 2],
}

impl<'a> Answer<'a> {
    fn new(
        view: &'a View<'a>,
        search: &'a Search<'a>,
        settings: &'a Settings,
        mut causes: Vec<usize>,
        folds: Vec<Fold>,
    ) -> Option<Answer<'a>> {
        let mut set = &search.sets[&causes];
        let scatter = &set.likely.scatter;
        let seen = view.scattering(scatter, &vec![1.0; scatter.len()]);
        let wide = view.scattering(scatter, &search.expected.together());
        let runs: Vec<usize> = (0..view.logs().len()).collect();
        let of = |fit: &Fit| {
            let fit = Fit {
                scales: vec![1.0; view.channels().len()],
                ..fit.clone()
            };
            fit::refit(&seen, fit, &runs, &None, fit::STEPS)
        };
        let (before, mut after) = (of(&search.sets[&Vec::new()].fit)?, of(&set.fit)?);
        // With the noise as it was found, a cause may do nothing, or explain no more than chance does in 95 %
        // of cases (likelihood ratio): it is left out.
        let mut widely = refitted(&wide, &set.fit);
        while let Some((smaller, less)) = (0..causes.len()).find_map(|k| {
            let less = but(&causes, k);
            let smaller = search.sets.get(&less)?;
            let by_chance = chi_square(view.causes()[causes[k]].parameters.len(), 0.95);
            let is_none = !does_something(view, causes[k], &after)
                || refitted(&wide, &smaller.fit).loss < widely.loss + by_chance;
            is_none.then_some((smaller, less))
        }) {
            (causes, set, after) = (less, smaller, of(&smaller.fit)?);
            widely = refitted(&wide, &set.fit);
        }
        let mut answer = Answer {
            view,
            search,
            settings,
            widely,
            seen,
            wide,
            causes,
            set,
            before,
            after,
            folds,
            scores: [None, None],
        };
        answer.scores = [&answer.before, &answer.after].map(|model| answer.scores(model));
        Some(answer)
    }

    /// The diagnosis; or a cause that is not to be named: one that may be none at all by its own interval, or one of
    /// which nothing limits how strong it is where something unknown is left. What a cause leaves limits it: where
    /// that is unknown, it takes away what the model does and describes nothing.
    fn tell(self, progress: &dyn Fn(Stage)) -> Result<Diagnosis, usize> {
        let done = |k: usize| FOLLOWED + (0.95 - FOLLOWED) * k as f64 / self.causes.len() as f64;
        let kind = self.view;
        let mut findings: Vec<Finding> = self
            .causes
            .iter()
            .enumerate()
            .filter(|(_, c)| **c < kind.listed())
            .map(|(k, c)| {
                progress(Stage {
                    share: done(k),
                    doing: "intervals",
                });
                self.finding(*c)
            })
            .collect();
        findings.sort_by(|a, b| b.best.log_odds.total_cmp(&a.best.log_odds));
        let has_term = self.causes.iter().find(|c| **c >= kind.listed());
        let is_short = self.set.is_short() || has_term.is_some();
        let term = has_term.map(|c| {
            let mut term = self.candidate(*c, self.set, self.less(*c));
            report::report(&self.wide, &mut term, &[], false);
            term
        });
        let named = findings.iter().map(|finding| &finding.best).chain(&term);
        if let Some(none) = named.into_iter().find(|it| it.may_be_none(kind)) {
            return Err(none.cause);
        }
        let is_open = |finding: &&Finding| self.set.is_short() && !finding.is_identifiable;
        if let Some(finding) = findings.iter().find(is_open) {
            return Err(finding.best.cause);
        }
        progress(Stage {
            share: 0.95,
            doing: "data left out",
        });
        let tried = self.tried();
        let alone = tried
            .first()
            .filter(|_| self.causes.len() > 1)
            .map(|cause| Alone {
                rms: self
                    .gains(self.scores(&cause.fit))
                    .into_iter()
                    .map(|gain| gain.rms.1)
                    .collect(),
                cause: cause.clone(),
            });
        let fitness = (
            self.fitness(&self.search.sets[&Vec::new()]),
            self.fitness(self.set),
        );
        // What is unknown is what is left without the term that describes it.
        let unknown = is_short.then(|| match has_term {
            Some(term) => {
                let less = self.less(*term);
                worst(self.view, &less.fit, self.unlisted(less))
            }
            None => worst(self.view, &self.after, self.unlisted(self.set)),
        });
        let unknown = unknown.flatten();
        let mut gains = self.gains(self.scores[1].clone());
        for (gain, channel) in gains.iter_mut().zip(self.view.channels()) {
            gain.noise = channel.noise;
        }
        Ok(Diagnosis {
            sets: self.sets(),
            findings,
            common: self.common(),
            alone,
            unknown,
            term,
            tried,
            gains,
            before: self.before,
            after: self.after,
            fitness,
        })
    }

    /// The answer without one of its causes.
    fn less(&self, cause: usize) -> &Set {
        let mut less = self.causes.clone();
        less.retain(|c| *c != cause);
        self.search
            .sets
            .get(&less)
            .unwrap_or(&self.search.sets[&Vec::new()])
    }

    fn candidate(&self, cause: usize, set: &Set, base: &Set) -> Candidate {
        let is_answer = std::ptr::eq(set, self.set);
        let mut fit = if is_answer {
            self.widely.clone()
        } else {
            refitted(&self.wide, &set.fit)
        };
        if !does_something(self.view, cause, &fit) {
            fit.clone_from(&set.fit);
            fit.scales.fill(1.0);
        }
        let mut candidate = Candidate::new(self.view, cause, &base.fit, fit);
        candidate.log_odds = set.best() - base.best();
        candidate
    }

    fn finding(&self, cause: usize) -> Finding {
        let base = self.less(cause);
        let mut best = self.candidate(cause, self.set, base);
        let known = report::report(&self.wide, &mut best, &self.bias(cause), true);
        let mut others: Vec<(usize, &Set)> = Vec::new();
        for (causes, set) in &self.search.sets {
            let own: Vec<usize> = causes
                .iter()
                .copied()
                .filter(|c| !self.causes.contains(c))
                .collect();
            let [other] = own[..] else { continue };
            if causes.len() == self.causes.len() && !causes.contains(&cause) {
                others.push((other, set));
            }
        }
        others.sort_by(|a, b| b.1.best().total_cmp(&a.1.best()));
        let limit = POLICY.strong.ln();
        let now = self.set;
        let data = |set: &Set| set.best() - set.known;
        let mut finding = Finding {
            best,
            rivals: Vec::new(),
            less_likely: Vec::new(),
            contradicting: Vec::new(),
            unlisted: None,
            held_out: f64::NAN,
            undetermined: known.undetermined,
            is_identifiable: !known.is_unlimited,
            next: None,
        };
        let of = |cause: usize| {
            (
                self.view.causes()[cause].id,
                &self.view.causes()[cause].column,
            )
        };
        let mut seen = vec![of(cause)];
        for (other, set) in others {
            let is_rival = set.best() > now.best() - limit;
            // What is known of it is what speaks against it.
            let is_contrary =
                !is_rival && data(set) > data(now) - limit && set.known < now.known - limit;
            if (!is_rival && !is_contrary) || seen.contains(&of(other)) {
                continue;
            }
            seen.push(of(other));
            let mut candidate = self.candidate(other, set, base);
            if other >= self.view.listed() {
                report::report(&self.wide, &mut candidate, &[], false);
                finding.unlisted.get_or_insert(candidate);
                let named = finding.rivals.len().min(MOST_RIVALS - 1);
                finding
                    .less_likely
                    .splice(0..0, finding.rivals.drain(named..));
            } else if is_contrary {
                report::report(&self.wide, &mut candidate, &[], false);
                finding.contradicting.push(candidate);
            } else if finding.rivals.len() + usize::from(finding.unlisted.is_some()) < MOST_RIVALS {
                report::report(&self.wide, &mut candidate, &[], known.is_unlimited);
                finding.rivals.push(candidate);
            } else {
                finding.less_likely.push(candidate);
            }
        }
        let loss = |scores: &[Score]| scores.iter().map(|score| score.loss).sum::<f64>();
        let without = self.scores(&base.fit);
        let both = without.as_ref().zip(self.scores[1].as_ref());
        finding.held_out = both.map_or(f64::NAN, |(without, with)| loss(without) - loss(with));
        let rivals = finding
            .rivals
            .iter()
            .chain(&finding.less_likely)
            .chain(&finding.unlisted);
        let all: Vec<(usize, &Fit)> = std::iter::once(&finding.best)
            .chain(rivals)
            .map(|c| (c.cause, &c.fit))
            .collect();
        if all.len() > 1 {
            finding.next = next::next(self.view, &all, &self.view.proposals());
        }
        finding
    }

    /// By how much each parameter of a cause may be off (its scales) where something unknown is left: all of
    /// that may have the shape of the cause's effect; and causes that were not claimed may be at work.
    fn bias(&self, cause: usize) -> Vec<f64> {
        if !self.set.is_short() {
            return Vec::new();
        }
        let parameters = &self.view.causes()[cause].parameters;
        let share = share(self.view, &self.after, cause);
        let most_probable = &self.search.sets[&self.search.best()].fit;
        let of = |(p, parameter): (usize, &Parameter)| {
            let value = self.after.terms.get(cause, p);
            let shape = share * (value - parameter.neutral).abs();
            let others = (value - most_probable.terms.get(cause, p)).abs();
            let is_there = most_probable.causes.contains(&cause);
            shape.max(if is_there { others } else { 0.0 }) / parameter.scale
        };
        parameters.iter().enumerate().map(of).collect()
    }

    /// Each cause alone, the most probable first.
    fn tried(&self) -> Vec<Candidate> {
        let none = &self.search.sets[&Vec::new()];
        let mut all: Vec<(&Set, usize)> = self
            .search
            .sets
            .iter()
            .filter_map(|(causes, set)| match causes[..] {
                [one] if one < self.view.listed() => Some((set, one)),
                _ => None,
            })
            .collect();
        all.sort_by(|a, b| b.0.best().total_cmp(&a.0.best()));
        let of = |(set, cause): (&Set, usize)| {
            let mut candidate = Candidate::new(self.view, cause, &none.fit, set.fit.clone());
            candidate.log_odds = set.best() - none.best();
            candidate
        };
        all.into_iter().map(of).collect()
    }

    /// All sets, the most probable first.
    fn sets(&self) -> Vec<Competitor> {
        let none = self.search.sets[&Vec::new()].best();
        let of = |(causes, set): (&Vec<usize>, &Set)| Competitor {
            causes: causes.clone(),
            terms: set.fit.terms.clone(),
            log_odds: set.listed - none,
            log_odds_unlisted: set.free - none,
            is_answer: *causes == self.causes,
        };
        let mut all: Vec<Competitor> = self.search.sets.iter().map(of).collect();
        all.sort_by(|a, b| b.best().total_cmp(&a.best()));
        all
    }

    fn scores(&self, model: &Fit) -> Option<Vec<Score>> {
        let model = Fit {
            scales: vec![1.0; self.view.channels().len()],
            ..model.clone()
        };
        gain::held_out(&self.seen, &model, &self.folds)
    }

    fn gains(&self, after: Option<Vec<Score>>) -> Vec<gain::Gain> {
        let before = self.scores[0].as_deref().unwrap_or_default();
        gain::gains(
            &self.seen,
            before,
            &after.unwrap_or_default(),
            self.settings,
        )
    }

    fn common(&self) -> Vec<Reported> {
        let of = |cause| {
            let mut one = Candidate::new(self.view, cause, &self.before, self.after.clone());
            report::report(&self.wide, &mut one, &[], false);
            one.reported
        };
        (0..self.view.common()).flat_map(of).collect()
    }

    fn fitness(&self, set: &Set) -> Fitness {
        let expected = &self.search.expected;
        let scatter = &set.likely.scatter;
        let is_noise = |c: usize| !expected.is_beyond(c, scatter[c]);
        Fitness {
            noise: scatter.iter().map(|s| s.noise).collect(),
            follows: expected.follows.clone(),
            own_error: scatter.iter().map(|s| s.amplitude).collect(),
            is_noise: (0..scatter.len()).map(is_noise).collect(),
        }
    }

    /// The channel in which most is left that is not noise.
    fn unlisted(&self, set: &Set) -> usize {
        let scatter = &set.likely.scatter;
        let size = |c: &usize| {
            let Scatter { noise, amplitude } = scatter[*c];
            (noise * noise - 1.0).max(0.0)
                + (amplitude / self.search.expected.amplitude[*c].max(1e-3)).powi(2)
        };
        let all = 0..scatter.len();
        all.max_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::toy::{Toy, noise, sum, wave};

    /// Odds of sets are beside the model as it is, and one of the sets is the answer.
    #[test]
    fn the_sets_are_what_the_answer_was_chosen_from() {
        let data = sum(&[(20.0, &wave(1)), (1.0, &noise(1))]);
        let toy = Toy::new(&data, (0..4).map(wave).collect());
        let found = diagnose(&toy, &Settings::default(), &|_| ()).expect("an answer");
        let none = found.sets.iter().find(|set| set.causes.is_empty());
        assert_eq!(none.map(Competitor::best), Some(0.0));
        assert!(found.sets.is_sorted_by(|a, b| a.best() >= b.best()));
        let answers: Vec<_> = found.sets.iter().filter(|set| set.is_answer).collect();
        let [answer] = answers[..] else {
            panic!("{answers:?}")
        };
        assert_eq!(answer.causes, [1]);
        assert_eq!(answer.best(), found.findings[0].best.log_odds);
    }
}
