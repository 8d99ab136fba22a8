//! A first plan by dynamic programming over a lattice of footholds.
//!
//! The jumps of a course hang together through the footholds alone. So with the landings on a
//! lattice, the cheapest way to each of them, jump after jump, is known from the cheapest ways to
//! those before it. What a jump costs there is the jumper's [`sketch`](Jumper::sketch); the solver
//! makes a plan of it.

use super::choices::{Place, landable, roll};
use super::terrain::{Ground, Terrain};
use super::{Course, Jumper, Leap, Push, Span};

/// Distance (m) between points of the lattice over a whole course, if they are not too many.
pub(super) const STEP: f64 = 0.03;

/// By how much finer the lattice of the last landing is: what it is off the target costs most.
const FINER: f64 = 10.0;

/// Most points for the landings of one jump.
const MOST: u32 = 300;

/// Least parts of a place: the landings that a jump can keep may be a small part of it.
const FEWEST: u32 = 16;

/// The cheapest way over the lattice.
pub(super) struct Way {
    /// Index of the ground that each jump lands on.
    pub(super) grounds: Vec<usize>,
    /// Two for each jump.
    pub(super) decisions: Vec<f64>,
    /// About what it costs.
    pub(super) cost: f64,
}

/// A landing on the lattice, and how to get there.
struct Point {
    ground: usize,
    x: f64,
    cost: f64,
    /// Index of the landing before.
    from: usize,
    decisions: [f64; 2],
}

/// The cheapest way over a lattice of the places of each jump, `step` (m) apart if they are not too
/// many, whose landings keep `sigmas` standard deviations from the ends of their ground and whose last
/// jump pushes so; none if there is no way or the jumper has no sketches.
pub(super) fn way(
    jumper: &dyn Jumper,
    course: &Course,
    terrain: &Terrain,
    places: &[Vec<Place>],
    step: f64,
    sigmas: f64,
    push: Push,
) -> Option<Way> {
    let start = Point {
        ground: 0,
        x: course.start,
        cost: 0.0,
        from: 0,
        decisions: [0.0; 2],
    };
    let mut layers = vec![vec![start]];
    for (jump, places) in places.iter().enumerate() {
        let total: f64 = places.iter().map(|(_, span)| span.width()).sum();
        let is_last = jump + 1 == course.jumps;
        let step = if is_last { step / FINER } else { step };
        let step = step.max(total / f64::from(MOST));
        let stage = Stage {
            jumper,
            course,
            terrain,
            jump,
            is_last,
            sigmas,
            push: if is_last { push } else { Push::Any },
        };
        let before = &layers[jump];
        let reached: Vec<Point> = places
            .iter()
            .flat_map(|&(ground, span)| stage.reach(before, ground, span, step))
            .collect();
        layers.push(reached);
    }
    let end = layers
        .last()?
        .iter()
        .min_by(|a, b| a.cost.total_cmp(&b.cost))?;
    let cost = end.cost;
    let (mut grounds, mut decisions, mut point) = (Vec::new(), Vec::new(), end);
    for layer in layers[..course.jumps].iter().rev() {
        grounds.insert(0, point.ground);
        decisions.splice(0..0, point.decisions);
        point = &layer[point.from];
    }
    Some(Way {
        grounds,
        decisions,
        cost,
    })
}

/// One jump of the lattice.
struct Stage<'a> {
    jumper: &'a dyn Jumper,
    course: &'a Course,
    terrain: &'a Terrain,
    jump: usize,
    is_last: bool,
    sigmas: f64,
    push: Push,
}

impl Stage<'_> {
    /// The landings on a ground within `span`, each with the cheapest way to it.
    fn reach(&self, before: &[Point], ground: usize, span: Span, step: f64) -> Vec<Point> {
        let to = &self.terrain.grounds[ground];
        let mut allowed = landable(self.jumper, self.course, self.jump, to);
        if self.is_last {
            allowed = allowed.meet(self.terrain.goal);
        }
        // An odd number, so that the middle of a narrow place is there.
        let is_enough = |pieces: &u32| f64::from(*pieces) * step >= span.width();
        let pieces = (FEWEST..MOST).step_by(2).find(is_enough).unwrap_or(MOST);
        let place = |i: u32| span.low + span.width() * f64::from(i) / f64::from(pieces);
        // Points on one ground stand side by side and share their leap.
        let mut leaps: Vec<Leap> = Vec::new();
        let mut leap_of = Vec::with_capacity(before.len());
        for (i, origin) in before.iter().enumerate() {
            if i == 0 || origin.ground != before[i - 1].ground {
                let leap = self.terrain.leap(self.jump, self.origin(origin), to);
                leaps.push(Leap {
                    push: self.push,
                    ..leap
                });
            }
            leap_of.push(leaps.len() - 1);
        }
        let point = |x: f64| {
            let room = (x - allowed.low).min(allowed.high - x);
            let scatter = if self.is_exact() || self.sigmas == 0.0 {
                f64::INFINITY
            } else {
                room / self.sigmas
            };
            if room < 0.0 {
                return None;
            }
            let ways = before.iter().enumerate().filter_map(|(from, origin)| {
                let leap = &leaps[leap_of[from]];
                let foot = origin.x + roll(self.jumper, self.jump);
                let sketch = self.jumper.sketch(leap, foot, x, scatter)?;
                Some(Point {
                    ground,
                    x,
                    cost: origin.cost + sketch.cost,
                    from,
                    decisions: sketch.decisions,
                })
            });
            ways.min_by(|a, b| a.cost.total_cmp(&b.cost))
        };
        let target = Some(self.jumper.target(self.terrain.goal))
            .filter(|x| self.is_last && span.clamp(*x) == *x);
        (0..=pieces)
            .map(place)
            .chain(target)
            .filter_map(point)
            .collect()
    }

    /// Whether the jump has to land in one exact place.
    fn is_exact(&self) -> bool {
        self.is_last && self.course.goal.width() == 0.0
    }

    /// The ground that a jump starts from.
    fn origin(&self, point: &Point) -> &Ground {
        if self.jump == 0 {
            &self.terrain.start
        } else {
            &self.terrain.grounds[point.ground]
        }
    }
}
