//! Lower bounds on what a jump costs, from flights sampled over firing angles and valve opening
//! times.
//!
//! A cell of the samples stands for all jumps between its four corners. It can be used by a jump if
//! one of its corners rises high enough over every edge on the way, from some foothold that also
//! lets it land where it should; it costs at least what its shortest valve time does. What the
//! samples cannot see, a change within a cell that no corner shows, the bound cannot see either.

use std::cell::{OnceCell, RefCell};
use std::rc::Rc;

use saltus_ballistic::Flight;
use saltus_lagrangian::Launch;

use super::Crossing;
use crate::course::{Envelope, Leap, Span};
use crate::jump::Jump;
use crate::model::JumpModel;
use crate::planner::Planner;

/// Firing angles that are sampled.
const ANGLES: usize = 24;

/// Valve times that are sampled: for one jump the solver goes the rest of the way, for several the
/// bounds have to be close.
const TIMES: usize = 33;
const TIMES_OF_ONE: usize = 9;

/// Height (m) by which a flight within a cell may be above its corners.
const SLACK: f64 = 2e-3;

/// Flights over firing angles and valve times.
pub(super) struct Grid {
    /// Valve times (s), ascending.
    times: Vec<f64>,
    /// Firing angles (rad), ascending.
    angles: Vec<f64>,
    /// For each valve time its jumps over the firing angles; none where a jump cannot be computed.
    jumps: Vec<Vec<Option<Jump>>>,
    /// Standard deviation (m) of the landing at each firing angle, for the middle valve time: worked
    /// out where a sketch asks for it.
    deviations: Vec<OnceCell<f64>>,
    /// For landing heights (m) that were asked for, the distances (m) of the jumps; NaN where they
    /// do not land.
    distances: RefCell<Vec<(f64, Rc<Distances>)>>,
}

/// Distances (m) by valve time and firing angle.
type Distances = Vec<Vec<f64>>;

/// What jumps are bounded for.
pub(super) struct Within<'a> {
    pub(super) leap: &'a Leap,
    /// Height (m) of the wheel's centre above the foot at the landing.
    pub(super) height: f64,
    /// Height (m) of the wheel's centre above the foot, less an edge's top, at which its rim clears
    /// the edge.
    pub(super) rim: f64,
    pub(super) feet: Span,
    pub(super) landings: Span,
    pub(super) reach: Span,
    /// Least cost of the landing, and cost of a squared second of valve time.
    pub(super) cost: [f64; 2],
}

impl Grid {
    pub(super) fn new(planner: &Planner<dyn JumpModel>, crossing: &Crossing, jump: usize) -> Grid {
        let spread = |span: Span, i: usize, count: usize| {
            span.low + span.width() * i as f64 / (count - 1) as f64
        };
        let count = if crossing.course.jumps == 1 {
            TIMES_OF_ONE
        } else {
            TIMES
        };
        let times: Vec<f64> = (0..count)
            .map(|i| spread(crossing.valve_open, i, count))
            .collect();
        let row = |&time: &f64| {
            let at = |i| {
                let angle = spread(crossing.firing_angles, i, ANGLES);
                crossing.launch(jump, [angle, time])
            };
            let launches: Vec<Launch> = (0..ANGLES).map(at).collect();
            planner
                .jumps(&launches)
                .into_iter()
                .map(Result::ok)
                .collect()
        };
        let angles: Vec<f64> = (0..ANGLES)
            .map(|i| spread(crossing.firing_angles, i, ANGLES))
            .collect();
        let jumps = times.iter().map(row).collect();
        Grid {
            times,
            angles,
            jumps,
            deviations: vec![OnceCell::new(); ANGLES],
            distances: RefCell::default(),
        }
    }

    /// Distances (m) to where the wheel's centre comes down to `height` (m).
    fn distances(&self, height: f64) -> Rc<Distances> {
        let known = self
            .distances
            .borrow()
            .iter()
            .find(|(of, _)| *of == height)
            .map(|(_, known)| known.clone());
        known.unwrap_or_else(|| {
            let distance = |jump: &Option<Jump>| {
                let jump = jump.as_ref();
                jump.and_then(|jump| jump.distance(height))
                    .unwrap_or(f64::NAN)
            };
            let distances: Distances = self
                .jumps
                .iter()
                .map(|row| row.iter().map(distance).collect())
                .collect();
            let distances = Rc::new(distances);
            self.distances
                .borrow_mut()
                .push((height, distances.clone()));
            distances
        })
    }

    /// The sampled jump of the shortest valve time that goes over `leap` from `foot` to `landing`
    /// (m), between two firing angles; its valve time, with its deviation. `height` and `rim` (m)
    /// are those of [`Within`]; `deviation` gives the standard deviation (m) of the landing with a
    /// firing angle and a valve time.
    pub(super) fn sketch(
        &self,
        leap: &Leap,
        [foot, landing]: [f64; 2],
        height: f64,
        rim: f64,
        deviation: impl Fn([f64; 2]) -> f64,
    ) -> Option<([f64; 2], f64)> {
        let middle = self.times[self.times.len() / 2];
        let deviation_at =
            |i: usize| *self.deviations[i].get_or_init(|| deviation([self.angles[i], middle]));
        let wanted = landing - foot;
        for ((time, row), distances) in self
            .times
            .iter()
            .zip(&self.jumps)
            .zip(self.distances(height).iter())
        {
            for i in 1..ANGLES {
                let (low, high) = (distances[i - 1] - wanted, distances[i] - wanted);
                if low * high <= 0.0
                    && low != high
                    && let (Some(a), Some(b)) = (&row[i - 1], &row[i])
                    && let (Some(a), Some(b)) = (&a.flight, &b.flight)
                {
                    let part = low / (low - high);
                    let mix = |a: f64, b: f64| a + part * (b - a);
                    let [a, b] = [a.parabola(), b.parabola()];
                    let flight = Flight {
                        x: mix(a.x, b.x),
                        y: mix(a.y, b.y),
                        vx: mix(a.vx, b.vx),
                        vy: mix(a.vy, b.vy),
                        gravity: a.gravity,
                    };
                    if clears(&flight, leap, foot, height, rim) {
                        let angle = mix(self.angles[i - 1], self.angles[i]);
                        return Some(([angle, *time], mix(deviation_at(i - 1), deviation_at(i))));
                    }
                }
            }
        }
        None
    }

    /// A convex function of the distance that no jump undercuts in cost; none if there is no such
    /// jump.
    pub(super) fn envelope(&self, within: &Within<'_>) -> Option<Envelope> {
        let mut usable: Vec<(Span, f64)> = Vec::new();
        let known = self.distances(within.height);
        for (row, time) in self.times.iter().enumerate().take(self.times.len() - 1) {
            let cost = within.cost[0] + within.cost[1] * time * time;
            for column in 1..ANGLES {
                let corners = [
                    [row, column - 1],
                    [row, column],
                    [row + 1, column - 1],
                    [row + 1, column],
                ];
                let corner = |[row, column]: [usize; 2]| {
                    let flight = self.jumps[row][column].as_ref()?.flight.as_ref()?;
                    Some((known[row][column], flight.parabola()))
                        .filter(|(distance, _)| !distance.is_nan())
                };
                let reach = within.distances(corners.into_iter().filter_map(corner));
                usable.extend(reach.map(|distances| (distances, cost)));
            }
        }
        below(&usable)
    }
}

impl Within<'_> {
    /// Distances (m) that the jumps between some corners can go; none if none of them is possible.
    fn distances(&self, corners: impl Iterator<Item = (f64, Flight<f64>)>) -> Option<Span> {
        let mut distances = Span::NONE;
        let mut flights = Vec::with_capacity(4);
        for (distance, flight) in corners {
            distances = distances.hull(Span::point(distance));
            flights.push(flight);
        }
        if distances.is_empty() {
            return None;
        }
        let distances = distances.widened(0.25 * distances.width()).meet(self.reach);
        let mut feet = self.feet.meet(self.landings - distances);
        for edge in &self.leap.edges {
            if feet.is_empty() {
                return None;
            }
            feet = feet.meet(clear_feet(
                &flights,
                edge.x,
                edge.top + self.rim - SLACK,
                feet.high,
            ));
        }
        let distances = distances.meet(self.landings - feet);
        (!feet.is_empty() && !distances.is_empty()).then_some(distances)
    }
}

/// Whether a flight from `foot` (m) keeps the wheel's rim clear of a leap's edges.
fn clears(flight: &Flight<f64>, leap: &Leap, foot: f64, height: f64, rim: f64) -> bool {
    let reach = rim + leap.from;
    leap.edges.iter().all(|edge| {
        let corner = [edge.x - foot, edge.top - leap.from];
        let over = flight.position((corner[0] - flight.x) / flight.vx)[1];
        let Ok(landing) = flight.time_to_height(height) else {
            return false;
        };
        // The cheap condition first: the centre is a rim above the edge where it is over it.
        let is_passed = corner[0] > flight.x;
        (!is_passed || over >= corner[1] + reach)
            && flight.distance_to_point(corner, 0.0, landing) >= reach
    })
}

/// The footholds (m), up to `last`, from which one of `flights` has its centre at `height` (m) or
/// more over `x`, or starts behind it.
fn clear_feet(flights: &[Flight<f64>], x: f64, height: f64, last: f64) -> Span {
    let mut feet = Span::NONE;
    for flight in flights {
        let Flight {
            x: ahead,
            y,
            vx,
            vy,
            gravity,
        } = *flight;
        let behind = x - ahead;
        if last > behind {
            feet = feet.hull(Span::new(behind, last));
        }
        let square = vy * vy + 2.0 * gravity * (y - height);
        if square >= 0.0 {
            let [first, end] =
                [-1.0, 1.0].map(|sign| ((vy + sign * square.sqrt()) / gravity).max(0.0));
            if y >= height || vy > 0.0 {
                feet = feet.hull(Span::new(behind - vx * end, behind - vx * first));
            }
        }
    }
    feet
}

/// A convex function of the distance below the costs of all `usable` distances.
fn below(usable: &[(Span, f64)]) -> Option<Envelope> {
    let least = usable
        .iter()
        .map(|(_, cost)| *cost)
        .fold(f64::INFINITY, f64::min);
    let (mut all, mut cheap) = (Span::NONE, Span::NONE);
    for (distances, cost) in usable {
        all = all.hull(*distances);
        if *cost == least {
            cheap = cheap.hull(*distances);
        }
    }
    if all.is_empty() {
        return None;
    }
    let (mut falling, mut rising) = (f64::INFINITY, f64::INFINITY);
    for (distances, cost) in usable {
        if distances.low < cheap.low {
            falling = falling.min((cost - least) / (cheap.low - distances.low));
        }
        if distances.high > cheap.high {
            rising = rising.min((cost - least) / (distances.high - cheap.high));
        }
    }
    let end = |slope: f64, away: f64| {
        if away > 0.0 {
            least + slope * away
        } else {
            least
        }
    };
    Some(Envelope::new(&[
        [all.low, end(falling, cheap.low - all.low)],
        [cheap.low, least],
        [cheap.high, least],
        [all.high, end(rising, all.high - cheap.high)],
    ]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bound_is_below_every_cost() {
        let usable = [
            (Span::new(0.4, 0.6), 1.0),
            (Span::new(0.1, 0.3), 3.0),
            (Span::new(0.2, 0.45), 1.5),
            (Span::new(0.55, 0.9), 2.0),
        ];
        let envelope = below(&usable).expect("something is usable");
        assert_eq!(envelope.reach(), Span::new(0.1, 0.9));
        for (distances, cost) in usable {
            for distance in [distances.low, distances.high] {
                assert!(
                    envelope.at(distance) <= cost + 1e-12,
                    "{distance}: {envelope:?}"
                );
            }
        }
        assert_eq!(below(&[]), None);
    }

    #[test]
    fn a_flight_clears_an_edge_from_footholds_between_its_two_heights() {
        let flight = Flight {
            x: 0.1,
            y: 0.3,
            vx: 1.0,
            vy: 2.0,
            gravity: 10.0,
        };
        // 0.3 + 2 t − 5 t² = 0.45 at t = 0.1 and 0.3.
        let feet = clear_feet(&[flight], 1.0, 0.45, 0.85);
        assert!(
            (feet.low - 0.6).abs() < 1e-12 && (feet.high - 0.8).abs() < 1e-12,
            "{feet:?}"
        );
        assert!(clear_feet(&[flight], 1.0, 0.6, 0.85).is_empty());
    }
}
