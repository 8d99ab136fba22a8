//! Which grounds the jumps of a course can land on, one after the other.
//!
//! The sequences of grounds are as many as there are ways over the course, so they are not listed.
//! The jumps of a course hang together through the footholds alone: a recursion from the last jump
//! to the first gives, for each landing on each ground, a lower bound on what the jumps that follow
//! cost (dynamic programming). A [`Prefix`], the first jumps of a sequence, then has a lower bound
//! on all its sequences, and the search grows the most promising ones.

use super::envelope::{CostToCome, Envelope};
use super::problem::Choice;
use super::terrain::{Ground, Terrain};
use super::{Course, Jumper, Span};

/// Where a jump may land: index of the ground, and the part of it.
pub(super) type Place = (usize, Span);

/// What follows a landing on a ground.
#[derive(Clone, Copy)]
struct Ahead {
    /// The part of the ground from which the goal can be reached (m).
    span: Span,
    /// No way to the goal costs less.
    cost: f64,
}

/// A jump from a ground to another.
struct Link {
    /// Index of the ground to land on.
    to: usize,
    envelope: Envelope,
    /// What follows the landing.
    ahead: Ahead,
}

/// The sequences of grounds that the jumps' reach allows.
pub(super) struct Choices<'a> {
    jumper: &'a dyn Jumper,
    course: &'a Course,
    pub(super) terrain: &'a Terrain,
    /// For each jump, the links from the start (jump 0) or from each ground.
    links: Vec<Vec<Vec<Link>>>,
}

/// The first jumps of a sequence of grounds.
#[derive(Clone)]
pub(super) struct Prefix {
    /// Indices of the grounds landed on.
    grounds: Vec<usize>,
    come: CostToCome,
    /// No sequence that begins so costs less.
    pub(super) bound: f64,
}

impl<'a> Choices<'a> {
    /// Finds what follows each landing, from the last jump to the first.
    pub(super) fn new(jumper: &'a dyn Jumper, course: &'a Course, terrain: &'a Terrain) -> Self {
        let last = jumper.window(course.jumps - 1).meet(terrain.goal);
        let at_goal = |g: &Ground| {
            Some(Ahead {
                span: g.span.meet(last),
                cost: 0.0,
            })
            .filter(|a| !a.span.is_empty())
        };
        let mut choices = Choices {
            jumper,
            course,
            terrain,
            links: Vec::new(),
        };
        let mut ahead: Vec<Option<Ahead>> = terrain.grounds.iter().map(at_goal).collect();
        for jump in (0..course.jumps).rev() {
            let origins = if jump == 0 {
                std::slice::from_ref(&terrain.start)
            } else {
                &terrain.grounds
            };
            let links: Vec<Vec<Link>> = origins
                .iter()
                .enumerate()
                .map(|(index, from)| choices.links_from(jump, index, from, &ahead))
                .collect();
            if jump > 0 {
                let before =
                    |(from, links): (&Ground, &Vec<Link>)| choices.before(jump, from, links);
                ahead = origins.iter().zip(&links).map(before).collect();
            }
            choices.links.insert(0, links);
        }
        choices
    }

    /// The jumps number `jump` from a ground to those behind it from which the goal can be reached.
    fn links_from(
        &self,
        jump: usize,
        index: usize,
        from: &Ground,
        ahead: &[Option<Ahead>],
    ) -> Vec<Link> {
        let landed = if jump == 0 {
            from.span
        } else {
            landable(self.jumper, self.course, jump - 1, from)
        };
        if landed.is_empty() {
            return Vec::new();
        }
        let feet = landed + Span::point(roll(self.jumper, jump));
        let link = |(to, ground): (usize, &Ground)| {
            let ahead = ahead[to]?;
            let leap = self.terrain.leap(jump, from, ground);
            let envelope = self.jumper.envelope(&leap, feet, ahead.span, Span::ALL)?;
            Some(Link {
                to,
                envelope,
                ahead,
            })
        };
        self.terrain
            .grounds
            .iter()
            .enumerate()
            .skip(index)
            .filter_map(link)
            .collect()
    }

    /// What follows a landing on `from` if the next jump, number `jump`, is one of `links`.
    fn before(&self, jump: usize, from: &Ground, links: &[Link]) -> Option<Ahead> {
        let shift = Span::point(roll(self.jumper, jump));
        let landed = landable(self.jumper, self.course, jump - 1, from);
        let mut hull = Ahead {
            span: Span::NONE,
            cost: f64::INFINITY,
        };
        for Link {
            envelope, ahead, ..
        } in links
        {
            hull.span = hull
                .span
                .hull((ahead.span - envelope.reach() - shift).meet(landed));
            hull.cost = hull.cost.min(envelope.least() + ahead.cost);
        }
        Some(hull).filter(|a| !a.span.is_empty())
    }

    /// The start, before the first jump; none where the goal is out of reach.
    pub(super) fn start(&self) -> Option<Prefix> {
        let come = CostToCome::start(self.course.start);
        let least = |link: &Link| link.envelope.least() + link.ahead.cost;
        let bound = self.links[0][0]
            .iter()
            .map(least)
            .fold(f64::INFINITY, f64::min);
        bound.is_finite().then_some(Prefix {
            grounds: Vec::new(),
            come,
            bound,
        })
    }

    /// For each jump the grounds that it can land on, and the parts of them that the jumps before
    /// it reach.
    pub(super) fn places(&self) -> Vec<Vec<Place>> {
        let mut reached = vec![(0, self.terrain.start.span)];
        let mut places = Vec::new();
        for (jump, links) in self.links.iter().enumerate() {
            let shift = Span::point(roll(self.jumper, jump));
            let mut spans = vec![Span::NONE; self.terrain.grounds.len()];
            for (from, span) in &reached {
                for Link {
                    to,
                    envelope,
                    ahead,
                } in &links[*from]
                {
                    let here = (*span + shift + envelope.reach()).meet(ahead.span);
                    if !here.is_empty() {
                        spans[*to] = spans[*to].hull(here);
                    }
                }
            }
            reached = spans
                .into_iter()
                .enumerate()
                .filter(|(_, span)| !span.is_empty())
                .collect();
            places.push(reached.clone());
        }
        places
    }

    /// The choice of these grounds.
    pub(super) fn choice(&self, grounds: &[usize]) -> Choice {
        let (mut leaps, mut windows) = (Vec::new(), Vec::new());
        let mut from = &self.terrain.start;
        for (jump, index) in grounds.iter().enumerate() {
            let to = &self.terrain.grounds[*index];
            let is_last = jump + 1 == self.course.jumps;
            leaps.push(self.terrain.leap(jump, from, to));
            let window = landable(self.jumper, self.course, jump, to);
            windows.push(if is_last {
                window.meet(self.terrain.goal)
            } else {
                window
            });
            from = to;
        }
        Choice {
            leaps,
            windows,
            grounds: grounds.to_vec(),
        }
    }

    /// All prefixes with one jump more, the one with the least bound last.
    pub(super) fn grow(&self, prefix: &Prefix) -> Vec<Prefix> {
        let jump = prefix.grounds.len();
        let shift = roll(self.jumper, jump);
        let from = prefix.grounds.last().copied().unwrap_or(0);
        let next = |Link {
                        to,
                        envelope,
                        ahead,
                    }: &Link| {
            let come = prefix.come.jump(shift, envelope, ahead.span)?;
            let bound = come.least()[1] + ahead.cost;
            let grounds = prefix.grounds.iter().copied().chain([*to]).collect();
            Some(Prefix {
                grounds,
                come,
                bound,
            })
        };
        let mut grown: Vec<Prefix> = self.links[jump][from].iter().filter_map(next).collect();
        grown.sort_by(|a, b| b.bound.total_cmp(&a.bound));
        grown
    }

    /// The choice, if every jump has its ground.
    pub(super) fn finished(&self, prefix: &Prefix) -> Option<Choice> {
        (prefix.grounds.len() == self.course.jumps).then(|| self.choice(&prefix.grounds))
    }
}

/// Where on a ground (m) jump number `jump` may land: within its window and, if another jump
/// follows, where the roll to the next foothold stays on the ground.
pub(super) fn landable(jumper: &dyn Jumper, course: &Course, jump: usize, ground: &Ground) -> Span {
    let span = ground.span.meet(jumper.window(jump));
    let next = jump + 1;
    if next < course.jumps {
        span.meet(ground.span - Span::point(roll(jumper, next)))
    } else {
        span
    }
}

/// Distance (m) rolled before a jump.
pub(super) fn roll(jumper: &dyn Jumper, jump: usize) -> f64 {
    if jump == 0 { 0.0 } else { jumper.roll(jump) }
}
