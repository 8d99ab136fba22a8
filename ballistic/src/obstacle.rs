//! Obstacles: boxes and simple polygons.

use crate::FlightError;
use crate::outline::{Corner, Edge, Outline, difference, dot};

/// A solid obstacle with straight sides.
#[derive(Clone, Debug, PartialEq)]
pub struct Obstacle {
    pub(crate) outline: Outline,
}

impl Obstacle {
    /// The box from `low` to `high`, its lower left and upper right corners [x, y] (m).
    ///
    /// Its vertices are counted from `low` forward and round, so that its top is edge 2.
    ///
    /// # Errors
    /// [`FlightError::EmptyBox`] unless `low` < `high` in both coordinates, finite.
    pub fn block(low: [f64; 2], high: [f64; 2]) -> Result<Self, FlightError> {
        let finite = [low, high]
            .as_flattened()
            .iter()
            .all(|number| number.is_finite());
        if !(finite && low[0] < high[0] && low[1] < high[1]) {
            return Err(FlightError::EmptyBox { low, high });
        }
        Self::polygon(&[low, [high[0], low[1]], high, [low[0], high[1]]])
    }

    /// The polygon with these `vertices` [x, y] (m), in either direction; convex or not.
    ///
    /// # Errors
    /// [`FlightError::FewVertices`], [`FlightError::VertexNotFinite`],
    /// [`FlightError::VertexRepeated`],
    /// [`FlightError::EdgesCross`]: what keeps it from having an inside.
    pub fn polygon(vertices: &[[f64; 2]]) -> Result<Self, FlightError> {
        check_simple(vertices)?;
        let n = vertices.len();
        let side = area(vertices).signum();
        let edges: Vec<_> = (0..n)
            .map(|i| Edge::between(vertices[i], vertices[(i + 1) % n], side))
            .collect();
        let corners = (0..n)
            .map(|i| Corner::new(vertices[i], &edges[(i + n - 1) % n], &edges[i], side))
            .collect();
        Ok(Obstacle {
            outline: Outline { edges, corners },
        })
    }

    /// Forward position (m) of the vertex that is furthest ahead.
    pub fn back(&self) -> f64 {
        self.outline
            .corners
            .iter()
            .map(|corner| corner.at[0])
            .fold(f64::NEG_INFINITY, f64::max)
    }
}

/// Area (m²) of a polygon, positive if its vertices go round counterclockwise.
fn area(vertices: &[[f64; 2]]) -> f64 {
    // Seen from the first vertex, so that a polygon far away loses no digits.
    let seen = |i: usize| difference(vertices[i], vertices[0]);
    (1..vertices.len() - 1)
        .map(|i| cross(seen(i), seen(i + 1)) / 2.0)
        .sum()
}

/// Whether the vertices bound one solid.
fn check_simple(vertices: &[[f64; 2]]) -> Result<(), FlightError> {
    let n = vertices.len();
    if n < 3 {
        return Err(FlightError::FewVertices { count: n, least: 3 });
    }
    if let Some(vertex) = vertices
        .iter()
        .position(|v| !v.iter().all(|number| number.is_finite()))
    {
        return Err(FlightError::VertexNotFinite {
            vertex,
            at: vertices[vertex],
        });
    }
    let edge = |i: usize| [vertices[i], vertices[(i + 1) % n]];
    if let Some(vertex) = (0..n).find(|&i| edge(i)[0] == edge(i)[1]) {
        return Err(FlightError::VertexRepeated {
            vertex,
            at: vertices[vertex],
        });
    }
    let mut pairs = (0..n).flat_map(|i| (i + 1..n).map(move |j| (i, j)));
    let cross = pairs.find(|&(i, j)| {
        let neighbours = j == i + 1 || (i, j) == (0, n - 1);
        if !neighbours {
            touch(edge(i), edge(j))
        } else if j == i + 1 {
            fold_back(edge(i), edge(j))
        } else {
            fold_back(edge(j), edge(i))
        }
    });
    cross.map_or(Ok(()), |(first, second)| {
        Err(FlightError::EdgesCross { first, second })
    })
}

/// Whether an edge runs back over the one that it follows.
fn fold_back(edge: [[f64; 2]; 2], next: [[f64; 2]; 2]) -> bool {
    let (d, e) = (difference(edge[1], edge[0]), difference(next[1], next[0]));
    cross(d, e) == 0.0 && dot(d, e) < 0.0
}

/// Whether two segments have a point in common.
fn touch([a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2]) -> bool {
    // On which side of the line through p and q the point r lies: −1, 0 or 1.
    let side = |p, q, r| {
        let turn = cross(difference(q, p), difference(r, p));
        if turn == 0.0 { 0.0 } else { turn.signum() }
    };
    let within = |p, q, r| dot(difference(p, r), difference(q, r)) <= 0.0;
    let (abc, abd, cda, cdb) = (side(a, b, c), side(a, b, d), side(c, d, a), side(c, d, b));
    (abc * abd < 0.0 && cda * cdb < 0.0)
        || (abc == 0.0 && within(a, b, c))
        || (abd == 0.0 && within(a, b, d))
        || (cda == 0.0 && within(c, d, a))
        || (cdb == 0.0 && within(c, d, b))
}

/// The third component of a × b.
fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_polygons_say_why() {
        let check = |vertices: &[[f64; 2]], expected: &str| {
            assert_eq!(
                Obstacle::polygon(vertices).unwrap_err().to_string(),
                expected
            );
        };
        check(
            &[[0.0, 0.0], [1.0, 0.0]],
            "2 vertices where at least 3 are needed",
        );
        check(
            &[[0.0, 0.0], [1.0, f64::NAN], [1.0, 1.0]],
            "vertex 1 at (1, NaN) m is not at a finite place",
        );
        check(
            &[[0.0, 0.0], [1.0, 0.0], [1.0, 0.0]],
            "vertex 1 at (1, 0) m is there twice in a row",
        );
        check(
            &[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]],
            "edges 0 and 2 meet elsewhere than at a common end",
        );
        check(
            &[[0.0, 0.0], [2.0, 0.0], [1.0, 0.0]],
            "edges 0 and 1 meet elsewhere than at a common end",
        );
        assert_eq!(
            Obstacle::block([0.0, 0.0], [1.0, 0.0])
                .unwrap_err()
                .to_string(),
            "a box from (0, 0) to (1, 0) m has no inside"
        );
    }

    #[test]
    fn signed_distances_are_the_same_in_both_directions() {
        let check = |vertices: &[[f64; 2]], point: [f64; 2], expected: f64| {
            let reversed: Vec<_> = vertices.iter().rev().copied().collect();
            for vertices in [vertices, &reversed] {
                let gap = Obstacle::polygon(vertices)
                    .unwrap()
                    .outline
                    .nearest(point)
                    .1;
                assert!(
                    (gap - expected).abs() < 1e-15,
                    "{gap} instead of {expected}"
                );
            }
        };
        let square = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
        check(&square, [5.0, 6.0], 5.0);
        check(&square, [1.0, 3.0], 1.0);
        check(&square, [1.0, 1.5], -0.5);
        check(&square, [2.0, 2.0], 0.0);
        // An L: inside, its reflex corner at (1, 1) is the nearest from the opposite corner on.
        let l = [
            [0.0, 0.0],
            [2.0, 0.0],
            [2.0, 1.0],
            [1.0, 1.0],
            [1.0, 2.0],
            [0.0, 2.0],
        ];
        check(&l, [1.5, 1.25], 0.25);
        check(&l, [0.9, 0.9], -0.1 * 2.0_f64.sqrt());
        check(&l, [0.25, 0.5], -0.25);
    }
}
