//! Terrain, and where the wheel lands on it.

use saltus_numeric::Single;

use crate::outline::{Corner, Edge, Feature, Gap, Outline};
use crate::path::{Path, settle};
use crate::{Flight, FlightError};

/// Distance (m) that another feature may reach into the disc at touchdown: round-off, and the error
/// of an arc.
const SLACK: f64 = 1e-6;

/// The ground's surface: a chain of vertices that goes on straight at both ends.
#[derive(Clone, Debug, PartialEq)]
pub struct Terrain {
    outline: Outline,
}

/// Where and how the wheel comes down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Landing<S> {
    /// Time (s) after lift-off.
    pub time: S,
    /// Where the centre is then (m).
    pub centre: [S; 2],
    /// Where the wheel touches the ground (m).
    pub point: [S; 2],
    /// What of the terrain it touches: a wall is an edge like any other.
    pub feature: Feature,
}

impl Terrain {
    /// Level ground at `height` (m).
    pub fn flat(height: f64) -> Self {
        Self::open(&[[0.0, height]], 0.0)
    }

    /// Level ground at height `before` up to `x`, at `after` from there on (m).
    ///
    /// # Errors
    /// [`FlightError::VertexRepeated`] if the two are equal, [`FlightError::VertexNotFinite`].
    pub fn step(x: f64, before: f64, after: f64) -> Result<Self, FlightError> {
        Self::profile(&[[x, before], [x, after]])
    }

    /// The slope y = tan(`angle`) (x − `x0`), with x0 in m and the angle in rad.
    ///
    /// # Errors
    /// [`FlightError::TooSteep`] unless |angle| < π/2; [`FlightError::VertexNotFinite`].
    pub fn slope(x0: f64, angle: f64) -> Result<Self, FlightError> {
        if !x0.is_finite() {
            Err(FlightError::VertexNotFinite {
                vertex: 0,
                at: [x0, 0.0],
            })
        } else if angle.abs() < std::f64::consts::FRAC_PI_2 {
            Ok(Self::open(&[[x0, 0.0]], angle))
        } else {
            Err(FlightError::TooSteep { angle })
        }
    }

    /// The chain of `vertices` [x, y] (m), level before the first and after the last; x must not
    /// fall.
    ///
    /// # Errors
    /// [`FlightError::FewVertices`], [`FlightError::VertexNotFinite`],
    /// [`FlightError::VertexRepeated`], and [`FlightError::TerrainRunsBack`] where x falls or a
    /// wall goes back over itself.
    pub fn profile(vertices: &[[f64; 2]]) -> Result<Self, FlightError> {
        if vertices.is_empty() {
            return Err(FlightError::FewVertices { count: 0, least: 1 });
        }
        for (vertex, &at) in vertices.iter().enumerate() {
            if !at.iter().all(|number| number.is_finite()) {
                return Err(FlightError::VertexNotFinite { vertex, at });
            }
            let Some(&next) = vertices.get(vertex + 1) else {
                break;
            };
            let wall_back = vertex > 0 && {
                let last = vertices[vertex - 1];
                last[0] == next[0] && (at[1] - last[1]) * (next[1] - at[1]) < 0.0
            };
            if at == next {
                return Err(FlightError::VertexRepeated { vertex, at });
            } else if next[0] < at[0] || wall_back {
                return Err(FlightError::TerrainRunsBack { vertex, at });
            }
        }
        Ok(Self::open(vertices, 0.0))
    }

    /// The chain of checked `vertices` between two rays at `angle`.
    fn open(vertices: &[[f64; 2]], angle: f64) -> Self {
        // The ground lies to the right of a chain that goes forward.
        const SIDE: f64 = -1.0;
        let (sin, cos) = angle.sin_cos();
        let ray = |origin, range| Edge::new(origin, [cos, sin], range, SIDE);
        let last = vertices.len() - 1;
        let mut edges = vec![ray(vertices[0], [f64::NEG_INFINITY, 0.0])];
        edges.extend(
            vertices
                .windows(2)
                .map(|pair| Edge::between(pair[0], pair[1], SIDE)),
        );
        edges.push(ray(vertices[last], [0.0, f64::INFINITY]));
        let corner = |i: usize| Corner::new(vertices[i], &edges[i], &edges[i + 1], SIDE);
        let corners = (0..=last).map(corner).collect();
        Terrain {
            outline: Outline { edges, corners },
        }
    }

    /// The landing of a disc of `radius` on a path, if it lands from time 0 to `horizon` (s).
    ///
    /// The first time at which the distance to the nearest feature falls to the radius. A foot that
    /// has just pushed off may leave the wheel nearer than that: what counts is coming down.
    pub(crate) fn touchdown<S: Single>(
        &self,
        path: &impl Path<S>,
        radius: S,
        horizon: f64,
    ) -> Option<Landing<S>> {
        let touches = |time: &f64| {
            let state = path.state(S::of(*time));
            let (feature, gap) = self.outline.nearest(state.position.map(S::value));
            (gap - radius.value()).abs() <= SLACK
                && self.outline.gap(feature, &state).rate.value() < 0.0
        };
        let time = path.arcs(0.0, horizon).find_map(|arc| {
            let mut times = vec![arc.span[0]];
            for edge in &self.outline.edges {
                let mut distance = arc.distance(edge);
                distance.0[0] -= radius.value();
                times.extend(arc.roots(&distance));
            }
            for corner in &self.outline.corners {
                let mut distance = arc.squared_distance(corner);
                distance.0[0] -= radius.value().powi(2);
                times.extend(arc.roots(&distance));
            }
            times.sort_by(f64::total_cmp);
            times.into_iter().find(touches)
        })?;
        Some(self.landing_at(path, radius, time, horizon))
    }

    /// The landing near `time`, with its derivatives.
    fn landing_at<S: Single>(
        &self,
        path: &impl Path<S>,
        radius: S,
        time: f64,
        horizon: f64,
    ) -> Landing<S> {
        let (feature, _) = self
            .outline
            .nearest(path.state(S::of(time)).position.map(S::value));
        let time = settle(time, [0.0, horizon], |t| {
            let Gap { value, rate, .. } = self.outline.gap(feature, &path.state(t));
            [value - radius, rate]
        });
        let centre = path.state(time).position;
        Landing {
            time,
            centre,
            point: self.outline.foot(feature, centre, radius),
            feature,
        }
    }

    /// That the wheel does not come down.
    pub(crate) fn never_lands<S: Single>(&self, flight: &Flight<S>, radius: S) -> FlightError {
        FlightError::NeverLands {
            gap: self.gap([flight.x, flight.y]),
            radius: radius.value(),
        }
    }

    /// Distance (m) from the surface, negative below it.
    pub(crate) fn gap<S: Single>(&self, position: [S; 2]) -> f64 {
        self.outline.nearest(position.map(S::value)).1
    }
}

impl<S: Single> Flight<S> {
    /// Where a wheel of `radius` (m) lands on `terrain`: its centre comes down to that distance
    /// from the surface.
    ///
    /// On flat ground the centre is at its height plus the radius. A wheel that is nearer at
    /// lift-off, as a leaning leg may leave it, must rise first. Grazing is not landing.
    ///
    /// ```
    /// use saltus_ballistic::{Flight, FlightError, Terrain};
    /// let flight = Flight { x: 0.0, y: 0.3, vx: 2.0, vy: 2.8, gravity: 9.80665 };
    /// let landing = flight.landing(&Terrain::step(0.8, 0.0, 0.2)?, 0.24)?;
    /// assert!((landing.centre[1] - 0.44).abs() < 1e-12);
    /// assert!((landing.centre[0] - 1.03134).abs() < 1e-5);
    /// # Ok::<(), FlightError>(())
    /// ```
    ///
    /// # Errors
    /// [`FlightError::NeverLands`], [`FlightError::NotFinite`].
    pub fn landing(&self, terrain: &Terrain, radius: S) -> Result<Landing<S>, FlightError> {
        self.check_finite()?;
        let landing = terrain.touchdown(self, radius, f64::INFINITY);
        landing.ok_or_else(|| terrain.never_lands(self, radius))
    }
}

#[cfg(test)]
mod tests;
