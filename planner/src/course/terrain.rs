//! Where a course can be landed on, and what lies between.

use super::{Course, Edge, Jumper, Leap, Obstacle, Push, Side, Span};

/// A level stretch to land on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ground {
    /// Where (m).
    pub(super) span: Span,
    /// Height (m).
    pub(super) height: f64,
    /// Index of the obstacle that it is the top of; none for the ground itself.
    pub(super) obstacle: Option<usize>,
}

/// A course's grounds and edges, both in the order of the travel.
#[derive(Clone, Debug)]
pub(super) struct Terrain {
    pub(super) start: Ground,
    pub(super) grounds: Vec<Ground>,
    pub(super) edges: Vec<Edge>,
    /// Where the last jump may land (m).
    pub(super) goal: Span,
    /// How near (m) an obstacle has to be for a jumper to touch it where it stands.
    girth: f64,
}

impl Terrain {
    /// Grounds keep the jumper's margins from obstacles, no-landing areas and the ends of a goal
    /// zone.
    pub(super) fn new(course: &Course, jumper: &dyn Jumper) -> Terrain {
        let mut boxes: Vec<_> = course.obstacles.iter().enumerate().collect();
        boxes.sort_by(|a, b| a.1.center.total_cmp(&b.1.center));
        let mut edges = Vec::new();
        let floor = Ground {
            span: Span::new(course.start, f64::INFINITY),
            height: 0.0,
            obstacle: None,
        };
        let mut grounds = vec![floor];
        for (obstacle, o) in &boxes {
            let span = o.span();
            edges.push(Edge {
                x: span.low,
                top: o.height,
                obstacle: *obstacle,
                side: Side::Front,
            });
            edges.push(Edge {
                x: span.high,
                top: o.height,
                obstacle: *obstacle,
                side: Side::Back,
            });
            let span = span.widened(-jumper.edge_margin(0.0));
            grounds.push(Ground {
                span,
                height: o.height,
                obstacle: Some(*obstacle),
            });
        }
        for (_, o) in &boxes {
            let beside = |g: Ground| {
                let rise = o.height - g.height;
                if rise > 0.0 {
                    without(g, o.span().widened(jumper.edge_margin(rise)))
                } else {
                    vec![g]
                }
            };
            grounds = grounds.into_iter().flat_map(beside).collect();
        }
        let zone_margin = jumper.zone_margin();
        for area in &course.no_landing {
            grounds = grounds
                .into_iter()
                .flat_map(|g| without(g, area.widened(zone_margin)))
                .collect();
        }
        let travel = Span::new(course.start, course.goal.high);
        for ground in &mut grounds {
            ground.span = ground.span.meet(travel);
        }
        grounds.retain(|g| !g.span.is_empty());
        grounds.sort_by(|a, b| a.span.low.total_cmp(&b.span.low));
        let carries = |o: &&(usize, &Obstacle)| {
            o.1.height == course.start_height && o.1.span().clamp(course.start) == course.start
        };
        let start = Ground {
            span: Span::point(course.start),
            height: course.start_height,
            obstacle: boxes.iter().find(carries).map(|(obstacle, _)| *obstacle),
        };
        let goal = kept_goal(course.goal, zone_margin);
        Terrain {
            start,
            grounds,
            edges,
            goal,
            girth: jumper.girth(),
        }
    }

    /// Jump number `jump` from a foothold on `from` to a landing on `to`.
    pub(super) fn leap(&self, jump: usize, from: &Ground, to: &Ground) -> Leap {
        let first = self.edges.partition_point(|e| e.x <= from.span.low);
        let end = self.edges.partition_point(|e| e.x < to.span.high);
        let edges = self.edges[first..end.max(first)].to_vec();
        let near = |e: &&Edge| {
            let behind =
                e.side == Side::Back && (0.0..=self.girth).contains(&(from.span.low - e.x));
            let ahead =
                e.side == Side::Front && (0.0..=self.girth).contains(&(e.x - from.span.high));
            e.top > from.height && (behind || ahead)
        };
        let beside = self.edges.iter().filter(near).copied().collect();
        Leap {
            jump,
            from: from.height,
            to: to.height,
            on: [from.obstacle, to.obstacle],
            edges,
            beside,
            push: Push::Any,
        }
    }
}

/// The part of a goal that keeps `margin` (m) from its ends; an exact place is kept as it is.
pub(super) fn kept_goal(goal: Span, margin: f64) -> Span {
    if goal.width() > 0.0 {
        goal.widened(-margin)
    } else {
        goal
    }
}

/// What is left of a ground outside `area`.
fn without(ground: Ground, area: Span) -> Vec<Ground> {
    let before = Span::new(ground.span.low, ground.span.high.min(area.low));
    let after = Span::new(ground.span.low.max(area.high), ground.span.high);
    [before, after]
        .into_iter()
        .filter(|s| !s.is_empty())
        .map(|span| Ground { span, ..ground })
        .collect()
}
