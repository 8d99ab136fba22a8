//! Where a course can be landed on, and what lies between.

use super::{Course, Edge, Leap, Side, Span};

/// A level stretch to land on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ground {
    /// Where (m).
    pub(super) span: Span,
    /// Height (m).
    pub(super) height: f64,
}

/// A course's grounds and edges, both in the order of the travel.
#[derive(Clone, Debug)]
pub(super) struct Terrain {
    pub(super) start: Ground,
    pub(super) grounds: Vec<Ground>,
    pub(super) edges: Vec<Edge>,
}

impl Terrain {
    /// Grounds keep `margin` (m) from every edge and leave out the no-landing areas.
    pub(super) fn new(course: &Course, margin: f64) -> Terrain {
        let mut boxes: Vec<_> = course.obstacles.iter().enumerate().collect();
        boxes.sort_by(|a, b| a.1.center.total_cmp(&b.1.center));
        let mut grounds = Vec::new();
        let mut edges = Vec::new();
        let mut begin = course.start;
        for (obstacle, o) in boxes {
            let Span { low, high } = o.span();
            grounds.push(Ground { span: Span::new(begin, low - margin), height: 0.0 });
            grounds.push(Ground { span: Span::new(low + margin, high - margin), height: o.height });
            edges.push(Edge { x: low, top: o.height, obstacle, side: Side::Front });
            edges.push(Edge { x: high, top: o.height, obstacle, side: Side::Back });
            begin = high + margin;
        }
        grounds.push(Ground { span: Span::new(begin, f64::INFINITY), height: 0.0 });
        for area in &course.no_landing {
            grounds = grounds.into_iter().flat_map(|g| without(g, *area)).collect();
        }
        let travel = Span::new(course.start, course.goal.high);
        for ground in &mut grounds {
            ground.span = ground.span.meet(travel);
        }
        grounds.retain(|g| !g.span.is_empty());
        let start = Ground { span: Span::point(course.start), height: course.start_height };
        Terrain { start, grounds, edges }
    }

    /// Jump number `jump` from a foothold on `from` to a landing on `to`.
    pub(super) fn leap(&self, jump: usize, from: &Ground, to: &Ground) -> Leap {
        let first = self.edges.partition_point(|e| e.x <= from.span.low);
        let end = self.edges.partition_point(|e| e.x < to.span.high);
        let edges = self.edges[first..end.max(first)].to_vec();
        Leap { jump, from: from.height, to: to.height, edges }
    }
}

/// What is left of a ground outside `area`.
fn without(ground: Ground, area: Span) -> impl Iterator<Item = Ground> {
    let before = Span::new(ground.span.low, ground.span.high.min(area.low));
    let after = Span::new(ground.span.low.max(area.high), ground.span.high);
    [before, after].into_iter().filter(|s| !s.is_empty()).map(move |span| Ground { span, ..ground })
}
