//! Clearance: the least distance that a moving disc keeps from an obstacle.

use saltus_numeric::Single;

use crate::obstacle::{Feature, Gap};
use crate::path::{Arc, Path, settle};
use crate::{Flight, FlightError, Obstacle};

/// Gap (m) below which the path may dip into the obstacle, and the search goes on inside.
///
/// Far above the error of an arc; a dip that is looked for in vain costs only time.
const NEAR: f64 = 1e-4;

/// The disc around the wheel's centre that must stay clear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc<S> {
    /// Radius (m), ≥ 0: the wheel's.
    pub radius: S,
    /// The leg that is still out after lift-off.
    pub leg: Option<ExtendedLeg<S>>,
}

/// A leg that has not yet been retracted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExtendedLeg<S> {
    /// Reach (m) from the wheel's centre, r_s + d, in whatever direction: the leg turns.
    pub reach: S,
    /// Time (s) after lift-off at which it is in.
    pub until: S,
}

impl<S> Disc<S> {
    /// The wheel alone, of this radius (m).
    pub fn wheel(radius: S) -> Self {
        Disc { radius, leg: None }
    }
}

impl<S: Single> Flight<S> {
    /// Least clearance (m) of `disc` over `obstacle` from time `from` to `to` (s) after lift-off;
    /// negative by the depth of the centre, plus the radius, if the disc hits it.
    ///
    /// The minimum over time of the centre's signed distance to the obstacle less the radius. It is
    /// found among the roots of polynomials, without sampling, and carries exact derivatives: those
    /// of an inner minimum with its time held fixed, those of a minimum at an end with that end.
    ///
    /// Not promised: derivatives where two minima are equal, or where the centre touches a corner.
    ///
    /// ```
    /// use saltus_ballistic::{Disc, Flight, FlightError, Obstacle};
    /// let flight = Flight { x: 0.0, y: 0.3, vx: 2.0, vy: 2.8, gravity: 9.80665 };
    /// let carton = Obstacle::block([0.4, 0.0], [0.61, 0.21])?;
    /// let landing = flight.time_to_height(0.24)?;
    /// let clearance = flight.clearance(&Disc::wheel(0.24), &carton, 0.0, landing)?;
    /// assert!((clearance - 0.12884).abs() < 1e-5);
    /// # Ok::<(), FlightError>(())
    /// ```
    ///
    /// # Errors
    /// [`FlightError::EmptySpan`] unless `from` ≤ `to`, finite; [`FlightError::NotFinite`].
    pub fn clearance(
        &self,
        disc: &Disc<S>,
        obstacle: &Obstacle,
        from: S,
        to: S,
    ) -> Result<S, FlightError> {
        self.check_finite()?;
        check_span(from, to)?;
        Ok(clearance(self, disc, obstacle, [from, to]))
    }
}

/// Refuses a span that is none.
pub(crate) fn check_span<S: Single>(from: S, to: S) -> Result<(), FlightError> {
    let (from, to) = (from.value(), to.value());
    let ordered = from <= to && from.is_finite() && to.is_finite();
    if ordered {
        Ok(())
    } else {
        Err(FlightError::EmptySpan { from, to })
    }
}

/// [`Flight::clearance`] on any path.
pub(crate) fn clearance<S: Single>(
    path: &impl Path<S>,
    disc: &Disc<S>,
    obstacle: &Obstacle,
    [from, to]: [S; 2],
) -> S {
    let least = |span, radius| least(path, obstacle, span, radius);
    match disc.leg {
        Some(leg) if from.value() < leg.until.value() => {
            if to.value() < leg.until.value() {
                return least([from, to], leg.reach);
            }
            let (out, retracted) = (
                least([from, leg.until], leg.reach),
                least([leg.until, to], disc.radius),
            );
            if out.value() <= retracted.value() {
                out
            } else {
                retracted
            }
        }
        _ => least([from, to], disc.radius),
    }
}

/// What fixes the time of a minimum.
#[derive(Clone, Copy, Debug)]
enum Cause<S> {
    /// An end of the span.
    End(S),
    /// The distance to the nearest feature neither falls nor rises.
    Level,
    /// Inside, the nearest feature changes from one of these to the other.
    Tie(Feature, Feature),
}

/// The best candidate so far.
#[derive(Clone, Copy, Debug)]
struct Best<S> {
    gap: f64,
    time: f64,
    feature: Feature,
    cause: Cause<S>,
}

impl<S> Best<S> {
    /// The nearer one; of two equally near the earlier.
    fn or(self, other: Self) -> Self {
        if (other.gap, other.time) < (self.gap, self.time) {
            other
        } else {
            self
        }
    }
}

/// Least clearance of a disc of constant radius.
///
/// The candidates are a superset of the local minima; the exact distance decides among them.
fn least<S: Single>(path: &impl Path<S>, obstacle: &Obstacle, span: [S; 2], radius: S) -> S {
    let values = span.map(S::value);
    let at = |time: f64, cause: Cause<S>| {
        let (feature, gap) = obstacle.nearest(path.state(S::of(time)).position.map(S::value));
        Best {
            gap,
            time,
            feature,
            cause,
        }
    };
    let mut best = at(values[0], Cause::End(span[0])).or(at(values[1], Cause::End(span[1])));
    for arc in path.arcs(values[0], values[1]) {
        // A minimum may sit in the bend between two arcs.
        best = best.or(at(arc.span[0], Cause::Level));
        for_each_level(obstacle, &arc, |time| {
            best = best.or(at(time, Cause::Level));
        });
        if best.gap < NEAR {
            for_each_tie(obstacle, &arc, |time, a, b| {
                best = best.or(at(time, Cause::Tie(a, b)));
            });
        }
    }
    let time = settled(path, &best, values);
    best.feature.gap(&path.state(time)).value - radius
}

/// The time of the minimum on the path itself, with its derivatives.
fn settled<S: Single>(path: &impl Path<S>, best: &Best<S>, span: [f64; 2]) -> S {
    match best.cause {
        Cause::End(time) => time,
        Cause::Level => settle(best.time, span, |t| {
            let Gap { rate, bend, .. } = best.feature.gap(&path.state(t));
            [rate, bend]
        }),
        Cause::Tie(a, b) => settle(best.time, span, |t| {
            let state = path.state(t);
            let (a, b) = (a.gap(&state), b.gap(&state));
            [a.value - b.value, a.rate - b.rate]
        }),
    }
}

/// Times at which the distance to a feature is level, or a side's line is crossed, which shows that
/// the path dips in.
fn for_each_level(obstacle: &Obstacle, arc: &Arc, mut found: impl FnMut(f64)) {
    for side in obstacle.sides() {
        let distance = side.distance(arc);
        arc.roots(&distance.derivative())
            .chain(arc.roots(&distance))
            .for_each(&mut found);
    }
    for corner in obstacle.corners() {
        arc.roots(&corner.distance(arc).derivative())
            .for_each(&mut found);
    }
}

/// Times at which two sides are equally far from a centre inside the box.
fn for_each_tie(obstacle: &Obstacle, arc: &Arc, mut found: impl FnMut(f64, Feature, Feature)) {
    let sides = obstacle.sides();
    for (i, side) in sides.into_iter().enumerate() {
        for &other in &sides[i + 1..] {
            let tie = side.distance(arc) - other.distance(arc);
            arc.roots(&tie).for_each(|t| found(t, side, other));
        }
    }
}

#[cfg(test)]
mod tests;
