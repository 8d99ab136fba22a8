//! Convex piecewise linear functions: lower bounds on the cost of jumps, and their sum over a
//! course.
//!
//! A jump's cost is bounded from below by a convex function of its distance, an [`Envelope`]. The
//! least sum of such bounds over the footholds of a course is a linear program along a chain; it is
//! solved exactly by adding one jump at a time: the infimal convolution of convex piecewise linear
//! functions strings their pieces together in the order of their slopes.

use super::Span;

/// Most points that an envelope is made of.
const POINTS: usize = 4;

/// A convex piecewise linear function over a span of distances, from (distance, cost) points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Envelope {
    points: [[f64; 2]; POINTS],
    len: usize,
}

impl Envelope {
    /// Through 1 to 4 points (distance (m), cost) in the order of their distances. A middle point
    /// that would make the function concave is left out.
    pub fn new(points: &[[f64; 2]]) -> Envelope {
        let slope = |a: [f64; 2], b: [f64; 2]| (b[1] - a[1]) / (b[0] - a[0]);
        let mut kept = [points[0]; POINTS];
        let mut len = 1;
        for &p in points.iter().skip(1).filter(|p| p[0] > points[0][0]) {
            while len > 1 && slope(kept[len - 2], kept[len - 1]) >= slope(kept[len - 2], p) {
                len -= 1;
            }
            if p[0] > kept[len - 1][0] {
                kept[len] = p;
                len += 1;
            }
        }
        Envelope { points: kept, len }
    }

    /// The same cost at all distances in `reach` (m).
    pub fn level(reach: Span, cost: f64) -> Envelope {
        Envelope::new(&[[reach.low, cost], [reach.high, cost]])
    }

    /// Distances (m) over which it is defined.
    pub fn reach(&self) -> Span {
        Span::new(self.points[0][0], self.points[self.len - 1][0])
    }

    /// Least value.
    pub(super) fn least(&self) -> f64 {
        self.points[..self.len]
            .iter()
            .fold(f64::INFINITY, |least, p| least.min(p[1]))
    }

    /// Value at a distance (m) within [`reach`](Self::reach).
    pub fn at(&self, distance: f64) -> f64 {
        let mut end = 1;
        while end + 1 < self.len && self.points[end][0] < distance {
            end += 1;
        }
        let ([x0, y0], [x1, y1]) = (self.points[end - 1], self.points[end.min(self.len - 1)]);
        if x1 > x0 {
            y0 + (y1 - y0) / (x1 - x0) * (distance - x0)
        } else {
            y0
        }
    }

    /// Length and slope of each piece.
    fn pieces(&self) -> impl Iterator<Item = [f64; 2]> {
        self.points[..self.len]
            .windows(2)
            .map(|w| [w[1][0] - w[0][0], (w[1][1] - w[0][1]) / (w[1][0] - w[0][0])])
    }
}

/// Least cost to get to a place, as a convex piecewise linear function of the place.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct CostToCome {
    /// The first place and its cost.
    start: [f64; 2],
    /// Length and slope of each piece, slopes ascending.
    pieces: Vec<[f64; 2]>,
}

impl CostToCome {
    /// Nothing to pay at `x`, and no other place.
    pub(super) fn start(x: f64) -> CostToCome {
        CostToCome {
            start: [x, 0.0],
            pieces: Vec::new(),
        }
    }

    /// After a roll (m) and a jump under `envelope` from one of these places to within `landings`;
    /// none if that is out of reach.
    pub(super) fn jump(
        &self,
        roll: f64,
        envelope: &Envelope,
        landings: Span,
    ) -> Option<CostToCome> {
        let [x, y] = self.start;
        let [distance, cost] = envelope.points[0];
        let mut pieces = Vec::with_capacity(self.pieces.len() + POINTS - 1);
        pieces.extend_from_slice(&self.pieces);
        for piece in envelope.pieces() {
            let at = pieces.partition_point(|p| p[1] <= piece[1]);
            pieces.insert(at, piece);
        }
        CostToCome {
            start: [x + roll + distance, y + cost],
            pieces,
        }
        .clip(landings)
    }

    /// The part within `span`.
    fn clip(self, span: Span) -> Option<CostToCome> {
        let [mut x, mut y] = self.start;
        let mut end = x;
        let mut pieces = Vec::with_capacity(self.pieces.len());
        for [length, slope] in self.pieces {
            let cut = (span.low - end).clamp(0.0, length);
            let rest = (length - cut).min(span.high - end - cut);
            if cut > 0.0 {
                (x, y) = (x + cut, y + cut * slope);
            }
            if rest > 0.0 {
                pieces.push([rest, slope]);
            }
            end += cut + rest.max(0.0);
        }
        // A place missed by round-off is reached.
        let slack = 1e-12 * (1.0 + end.abs());
        let reached = x <= span.high + slack && end >= span.low - slack;
        reached.then_some(CostToCome {
            start: [x, y],
            pieces,
        })
    }

    /// The cheapest place and its cost.
    pub(super) fn least(&self) -> [f64; 2] {
        let falling = self.pieces.iter().take_while(|p| p[1] < 0.0);
        falling.fold(self.start, |[x, y], [length, slope]| {
            [x + length, y + length * slope]
        })
    }

    /// The place that the cheapest way to `landing` comes from: what [`jump`](Self::jump) with the
    /// same roll and envelope used of this function.
    pub(super) fn origin(&self, roll: f64, envelope: &Envelope, landing: f64) -> f64 {
        let mut origin = self.start[0];
        let mut left = landing - origin - roll - envelope.points[0][0];
        let mut own = self.pieces.iter().peekable();
        let mut jump = envelope.pieces().peekable();
        while left > 0.0 {
            let [first, second] = [own.peek().map(|p| p[1]), jump.peek().map(|p| p[1])];
            if second.is_none_or(|s| first.is_some_and(|f| f <= s)) {
                let Some(piece) = own.next() else { break };
                origin += piece[0].min(left);
                left -= piece[0];
            } else if let Some(piece) = jump.next() {
                left -= piece[0];
            }
        }
        origin
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_chain_agrees_with_a_dense_grid() {
        let first = Envelope::new(&[[0.1, 0.4], [0.3, 0.3], [0.8, 0.6]]);
        let second = Envelope::new(&[[0.2, 0.5], [0.7, 0.55]]);
        let windows = [Span::new(0.25, 0.6), Span::new(0.9, 1.0)];
        let chain = CostToCome::start(0.0)
            .jump(0.0, &first, windows[0])
            .expect("in reach");
        let end = chain.jump(0.05, &second, windows[1]).expect("in reach");
        let mut least = f64::INFINITY;
        for i in 0..=350 {
            for j in 0..=100 {
                let (x, z) = (0.25 + 1e-3 * f64::from(i), 0.9 + 1e-3 * f64::from(j));
                let distance = z - x - 0.05;
                if second.reach().meet(Span::point(distance)).is_empty() {
                    continue;
                }
                least = least.min(first.at(x) + second.at(distance));
            }
        }
        let [place, cost] = end.least();
        // The optimum is on the grid, at its points.
        assert!((cost - least).abs() < 1e-12, "{cost} {least}");
        let x = chain.origin(0.05, &second, place);
        assert!((first.at(x) + second.at(place - x - 0.05) - cost).abs() < 1e-12);
    }

    #[test]
    fn a_place_out_of_reach_has_no_cost() {
        let envelope = Envelope::level(Span::new(0.2, 0.5), 0.0);
        assert_eq!(
            CostToCome::start(0.0).jump(0.0, &envelope, Span::new(0.6, 0.7)),
            None
        );
        assert_eq!(
            CostToCome::start(0.0).jump(0.0, &envelope, Span::new(0.0, 0.1)),
            None
        );
    }

    #[test]
    fn a_concave_middle_point_is_left_out() {
        let chord = Envelope::new(&[[0.0, 0.0], [1.0, 2.0], [2.0, 2.0]]);
        assert_eq!((chord.at(1.0), chord.reach()), (1.0, Span::new(0.0, 2.0)));
        let bowl = Envelope::new(&[[0.0, 1.0], [1.0, 0.0], [2.0, 0.0], [3.0, 2.0]]);
        assert_eq!([0.5, 1.5, 2.5].map(|x| bowl.at(x)), [0.5, 0.0, 1.0]);
        let dented = Envelope::new(&[[0.0, 0.0], [1.0, 1.0], [2.0, 1.0], [3.0, 0.0]]);
        assert_eq!(dented.at(1.5), 0.0);
    }
}
