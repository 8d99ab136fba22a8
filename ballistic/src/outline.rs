//! Chains of edges that bound solid matter, and signed distances to them.

use saltus_numeric::Single;

use crate::state::State;

/// What of an outline is nearest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feature {
    /// An edge: of an obstacle the one from this vertex to the next, of a terrain the one that ends
    /// at this vertex.
    Edge(usize),
    /// A vertex.
    Vertex(usize),
}

/// A straight edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Edge {
    /// A point on it (m).
    pub(crate) origin: [f64; 2],
    /// Direction of unit length.
    pub(crate) tangent: [f64; 2],
    /// Direction of unit length that points out of the solid.
    pub(crate) normal: [f64; 2],
    /// Where it starts and ends along the tangent, seen from the origin (m); infinite for a ray.
    pub(crate) range: [f64; 2],
}

/// Where two edges meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Corner {
    /// The vertex (m).
    pub(crate) at: [f64; 2],
    /// Sum of the edges' normals, which tells outside from inside.
    outward: [f64; 2],
    /// Whether the solid fills more than half of its surroundings.
    pub(crate) reflex: bool,
}

/// The edge of a solid, which lies to the left of its edges.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Outline {
    pub(crate) edges: Vec<Edge>,
    pub(crate) corners: Vec<Corner>,
}

/// A signed distance to a feature and its change along a path.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gap<S> {
    /// Distance (m), negative inside the solid.
    pub(crate) value: S,
    /// Its derivative in time (m/s).
    pub(crate) rate: S,
    /// Its second derivative in time (m/s²).
    pub(crate) bend: S,
}

impl Edge {
    /// The edge from `start` along `tangent` over `range`, with the solid to its `side`: 1 on the
    /// left, −1 on the right.
    pub(crate) fn new(origin: [f64; 2], tangent: [f64; 2], range: [f64; 2], side: f64) -> Self {
        Edge {
            origin,
            tangent,
            normal: [side * tangent[1], -side * tangent[0]],
            range,
        }
    }

    /// The edge between two points.
    pub(crate) fn between(start: [f64; 2], end: [f64; 2], side: f64) -> Self {
        let [dx, dy] = difference(end, start);
        let length = dx.hypot(dy);
        Edge::new(start, [dx / length, dy / length], [0.0, length], side)
    }

    /// Whether the foot of the perpendicular from `point` lies on the edge.
    fn faces(&self, point: [f64; 2]) -> bool {
        let along = dot(difference(point, self.origin), self.tangent);
        self.range[0] <= along && along <= self.range[1]
    }
}

impl Corner {
    /// The corner at which the edge `before` ends and `after` begins; `side` as in [`Edge::new`].
    pub(crate) fn new(at: [f64; 2], before: &Edge, after: &Edge, side: f64) -> Self {
        let turn = before.tangent[0] * after.tangent[1] - before.tangent[1] * after.tangent[0];
        let outward = [
            before.normal[0] + after.normal[0],
            before.normal[1] + after.normal[1],
        ];
        Corner {
            at,
            outward,
            reflex: side * turn < 0.0,
        }
    }
}

impl Outline {
    /// The feature nearest to `point` and the signed distance to it (m).
    pub(crate) fn nearest(&self, point: [f64; 2]) -> (Feature, f64) {
        let edges = self
            .edges
            .iter()
            .enumerate()
            .filter(|(_, edge)| edge.faces(point));
        let edges = edges.map(|(i, edge)| {
            (
                Feature::Edge(i),
                dot(difference(point, edge.origin), edge.normal),
            )
        });
        let corners = self.corners.iter().enumerate().map(|(i, corner)| {
            let [dx, dy] = difference(point, corner.at);
            (
                Feature::Vertex(i),
                dx.hypot(dy).copysign(dot([dx, dy], corner.outward)),
            )
        });
        // Edges come first, so that they win a tie.
        edges
            .chain(corners)
            .reduce(|best, next| {
                if next.1.abs() < best.1.abs() {
                    next
                } else {
                    best
                }
            })
            .unwrap_or((Feature::Vertex(0), f64::NAN))
    }

    /// The signed distance to `feature` at a path's `state`.
    pub(crate) fn gap<S: Single>(&self, feature: Feature, state: &State<S>) -> Gap<S> {
        let from = |origin: [f64; 2]| [0, 1].map(|i| state.position[i] - S::of(origin[i]));
        match feature {
            Feature::Edge(i) => {
                let normal = self.edges[i].normal.map(S::of);
                Gap {
                    value: product(from(self.edges[i].origin), normal),
                    rate: product(state.velocity, normal),
                    bend: product(state.acceleration, normal),
                }
            }
            Feature::Vertex(i) => {
                let corner = &self.corners[i];
                let offset = from(corner.at);
                let distance = product(offset, offset).sqrt();
                let inside = dot(offset.map(S::value), corner.outward) < 0.0;
                let value = if inside { -distance } else { distance };
                let rate = product(offset, state.velocity) / value;
                let speed2 = product(state.velocity, state.velocity);
                let bend = (speed2 + product(offset, state.acceleration) - rate * rate) / value;
                Gap { value, rate, bend }
            }
        }
    }

    /// The point (m) of `feature` nearest to `position`, which is `gap` away.
    pub(crate) fn foot<S: Single>(&self, feature: Feature, position: [S; 2], gap: S) -> [S; 2] {
        match feature {
            Feature::Edge(i) => {
                [0, 1].map(|k| (-gap).mul_add(S::of(self.edges[i].normal[k]), position[k]))
            }
            Feature::Vertex(i) => self.corners[i].at.map(S::of),
        }
    }
}

/// a − b.
pub(crate) fn difference(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

/// a · b, of plain numbers.
pub(crate) fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// a · b.
fn product<S: Single>(a: [S; 2], b: [S; 2]) -> S {
    a[0].mul_add(b[0], a[1] * b[1])
}
