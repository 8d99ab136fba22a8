//! Lower bounds on what a jump costs, and sketches of jumps, from flights sampled over firing
//! angles and valve opening times.
//!
//! Each firing angle has a valve time at which the valve shuts just as the robot lifts off. A valve
//! that is open longer changes nothing; one that shuts earlier ends the push within the stroke, and
//! there the landing's deviation and the friction needed jump. So the samples of each angle are
//! rows from the shortest valve time to just below that one, and one more row just above it.
//!
//! A cell of the samples stands for all jumps between its corners. It can be used by a jump if
//! one of its corners rises high enough over every edge on the way, from some foothold that also
//! lets it land where it should; it costs at least what its shortest valve time does. What the
//! samples cannot see, a change within a cell that no corner shows, the bound cannot see either.

use std::cell::{OnceCell, RefCell};
use std::rc::Rc;

use saltus_ballistic::Flight;
use saltus_robot::Outcome;

use super::Crossing;
use crate::course::{Edge, Envelope, Leap, Push, Span};
use crate::jump::{Jump, norm};
use crate::model::JumpModel;
use crate::planner::Planner;

/// Firing angles that are sampled.
const ANGLES: usize = 24;

/// Rows of valve times that shut within the stroke: for one jump the solver goes the rest of the
/// way, for several the bounds have to be close.
const ROWS: usize = 33;
const ROWS_OF_ONE: usize = 9;

/// By how much (s) a valve outlasts the stance or shuts before its end, so that a coarser model and a
/// finer one agree which of both it does.
pub(super) const APART: f64 = 1e-5;

/// Height (m) by which a flight within a cell may be above its corners.
const SLACK: f64 = 2e-3;

/// Parts of the distances by which sketches are found.
const BINS: usize = 128;

/// Flights over firing angles and valve times.
pub(super) struct Grid {
    /// Firing angles (rad), ascending.
    angles: Vec<f64>,
    /// Valve times ascending; those of the last row outlast the stance, or the leg has no valve.
    rows: Vec<Row>,
    /// For landing heights (m) that were asked for, how far the jumps go.
    reached: RefCell<Vec<(f64, Rc<Reached>)>>,
}

/// Samples over the firing angles.
struct Row {
    push: Push,
    /// None where this push has no valve time within the limits.
    samples: Vec<Option<Sample>>,
}

/// A sampled jump.
struct Sample {
    push: Push,
    /// Valve time (s).
    time: f64,
    jump: Jump,
    /// What each error of the robot changes of the landing (m), with its sign, and the friction needed,
    /// once they are asked for.
    errors: OnceCell<[f64; 4]>,
    friction: OnceCell<f64>,
}

/// How far the jumps go, down to one height.
struct Reached {
    /// Distances (m) by row and firing angle; NaN where a jump does not land.
    distances: Vec<Vec<f64>>,
    /// Least and greatest of them.
    span: Span,
    /// Row and right column of each pair of neighbours that spans a part of the distances, by part;
    /// shortest valve time first.
    pairs: Vec<Vec<[usize; 2]>>,
}

/// A jump that is looked for.
pub(super) struct Wanted<'a> {
    pub(super) leap: &'a Leap,
    /// Foothold and landing (m).
    pub(super) from_to: [f64; 2],
    /// As those of [`Within`].
    pub(super) height: f64,
    pub(super) rim: [f64; 2],
    /// Greatest standard deviation (m) of the landing, and greatest friction needed.
    pub(super) scatter: f64,
    pub(super) friction: f64,
}

/// What jumps are bounded for.
pub(super) struct Within<'a> {
    pub(super) leap: &'a Leap,
    /// Height (m) of the wheel's centre above the foot at the landing.
    pub(super) height: f64,
    /// Height (m) of the wheel's centre above the foot, less an edge's top, at which its rim clears
    /// the edge; then the same of the box that it lands on, which asks for no clearance.
    pub(super) rim: [f64; 2],
    pub(super) feet: Span,
    pub(super) landings: Span,
    pub(super) reach: Span,
    /// Least cost of the landing, and cost of a squared second of valve time.
    pub(super) cost: [f64; 2],
}

impl Grid {
    pub(super) fn new(planner: &Planner<dyn JumpModel>, crossing: &Crossing, jump: usize) -> Grid {
        let angles: Vec<f64> = (0..ANGLES)
            .map(|i| part(crossing.firing_angles, i, ANGLES))
            .collect();
        let row = |push: Push, times: &[Option<f64>]| {
            let launch = |(angle, time): (&f64, &Option<f64>)| {
                time.map(|time| crossing.launch(jump, [*angle, time]))
            };
            let launches: Vec<_> = angles.iter().zip(times).map(launch).collect();
            let flown = planner.jumps(&launches.iter().flatten().copied().collect::<Vec<_>>());
            let mut flown = flown.into_iter().map(Result::ok);
            let sample = |time: &Option<f64>| {
                let time = (*time)?;
                let jump = flown.next().flatten()?;
                Some(Sample {
                    push: pushed(push, jump.stance.outcome),
                    time,
                    jump,
                    errors: OnceCell::new(),
                    friction: OnceCell::new(),
                })
            };
            let samples = times.iter().map(sample).collect();
            Row { push, samples }
        };
        let valve = crossing.valve_open;
        let longest = row(Push::Any, &[Some(valve.high); ANGLES]);
        let rows = if planner.robot().leg.drive.has_valve() {
            let shuts = |sample: &Option<Sample>| {
                let sample = sample.as_ref()?;
                Some(sample.time - planner.model().spare(&sample.jump))
            };
            let shuts: Vec<Option<f64>> = longest.samples.iter().map(shuts).collect();
            let count = if crossing.course.jumps == 1 {
                ROWS_OF_ONE
            } else {
                ROWS
            };
            let within = |k: usize| {
                let time = |shuts: &Option<f64>| {
                    let to = shuts.map_or(valve.high, |time| valve.high.min(time - APART));
                    (to > valve.low).then(|| part(Span::new(valve.low, to), k, count))
                };
                row(Push::Part, &shuts.iter().map(time).collect::<Vec<_>>())
            };
            let whole = |shuts: &Option<f64>| {
                shuts
                    .map(|time| valve.low.max(time + APART))
                    .filter(|time| *time <= valve.high)
            };
            let whole: Vec<_> = shuts.iter().map(whole).collect();
            let parts = (0..count).map(within);
            parts.chain([row(Push::Whole, &whole)]).collect()
        } else {
            vec![longest]
        };
        Grid {
            angles,
            rows,
            reached: RefCell::default(),
        }
    }

    /// How far the jumps go until the wheel's centre comes down to `height` (m).
    fn reached(&self, height: f64) -> Rc<Reached> {
        let known = self
            .reached
            .borrow()
            .iter()
            .find(|(of, _)| *of == height)
            .map(|(_, known)| known.clone());
        known.unwrap_or_else(|| {
            let reached = Rc::new(Reached::new(&self.rows, height));
            self.reached.borrow_mut().push((height, reached.clone()));
            reached
        })
    }

    /// Least and greatest distance (m) of the sampled jumps down to `height` (m).
    pub(super) fn span(&self, height: f64) -> Span {
        self.reached(height).span
    }

    /// The sampled jumps that push longest, one of each firing angle: firing angle (rad), valve
    /// time (s), the jump and its distance (m) down to `height` (m).
    pub(super) fn longest(&self, height: f64) -> impl Iterator<Item = ([f64; 2], &Jump, f64)> {
        let reached = self.reached(height);
        (0..ANGLES).filter_map(move |column| {
            let (row, sample) = (0..self.rows.len())
                .rev()
                .find_map(|row| Some((row, self.rows[row].samples[column].as_ref()?)))?;
            let distance = reached.distances[row][column];
            let decisions = [self.angles[column], sample.time];
            (!distance.is_nan()).then_some((decisions, &sample.jump, distance))
        })
    }

    /// Firing angle (rad) and valve time (s) of every sampled jump that flies.
    pub(super) fn decisions(&self) -> impl Iterator<Item = [f64; 2]> {
        let samples = self
            .rows
            .iter()
            .flat_map(|row| row.samples.iter().zip(&self.angles));
        samples.filter_map(|(sample, angle)| {
            let sample = sample.as_ref()?;
            sample
                .jump
                .flight
                .is_some()
                .then_some([*angle, sample.time])
        })
    }

    /// The sampled jump of the shortest valve time that is as wanted, between two firing angles.
    /// `errors` and `friction` give those of a sample for a firing angle and a valve time.
    pub(super) fn sketch(
        &self,
        wanted: &Wanted<'_>,
        errors: impl Fn([f64; 2]) -> [f64; 4],
        friction: impl Fn([f64; 2]) -> f64,
    ) -> Option<[f64; 2]> {
        let reached = self.reached(wanted.height);
        let [foot, landing] = wanted.from_to;
        let distance = landing - foot;
        if !(reached.span.low..=reached.span.high).contains(&distance) {
            return None;
        }
        for &[row, column] in &reached.pairs[reached.bin(distance)] {
            let samples = &self.rows[row].samples;
            let ends = &reached.distances[row][column - 1..=column];
            let (low, high) = (ends[0] - distance, ends[1] - distance);
            let is_between = low * high <= 0.0 && low != high;
            let (Some(a), Some(b)) = (&samples[column - 1], &samples[column]) else {
                continue;
            };
            let (Some(from), Some(to)) = (&a.jump.flight, &b.jump.flight) else {
                continue;
            };
            let is_wanted = [Push::Any, a.push].contains(&wanted.leap.push);
            if !is_between || !is_wanted || a.push != b.push {
                continue;
            }
            let part = low / (low - high);
            let mix = |a: f64, b: f64| a + part * (b - a);
            let flight = between(&from.parabola(), &to.parabola(), mix);
            let ends = [(a, column - 1), (b, column)];
            let at = |(sample, column): (&Sample, usize)| [self.angles[column], sample.time];
            let scatters_little = || {
                let [a, b] = ends.map(|end| end.0.errors.get_or_init(|| errors(at(end))));
                // Mixed with their signs: at the greatest distance the angle's error changes nothing.
                let parts: [f64; 4] = std::array::from_fn(|i| mix(a[i], b[i]));
                norm(&parts) <= wanted.scatter
            };
            let holds = || {
                let [a, b] = ends.map(|end| *end.0.friction.get_or_init(|| friction(at(end))));
                mix(a, b) <= wanted.friction
            };
            if clears(&flight, wanted.leap, foot, wanted.height, wanted.rim)
                && (wanted.scatter == f64::INFINITY || scatters_little())
                && (wanted.friction == f64::INFINITY || holds())
            {
                let angle = mix(self.angles[column - 1], self.angles[column]);
                return Some([angle, mix(a.time, b.time)]);
            }
        }
        None
    }

    /// A convex function of the distance that no jump undercuts in cost; none if there is no such
    /// jump.
    pub(super) fn envelope(&self, within: &Within<'_>) -> Option<Envelope> {
        let mut usable: Vec<(Span, f64)> = Vec::new();
        let reached = self.reached(within.height);
        for (row, Row { push, .. }) in self.rows.iter().enumerate() {
            // A row that no other of its push follows stands for itself.
            let next = self.rows.get(row + 1).filter(|next| next.push == *push);
            if next.is_none() && *push == Push::Part {
                continue;
            }
            for column in 1..ANGLES {
                let corners = [row, row + usize::from(next.is_some())]
                    .map(|row| [[row, column - 1], [row, column]]);
                let corners = corners.as_flattened().iter();
                let mut shortest = f64::INFINITY;
                let corner = |[row, column]: &[usize; 2]| {
                    let sample = self.rows[*row].samples[*column].as_ref()?;
                    let distance = reached.distances[*row][*column];
                    shortest = shortest.min(sample.time);
                    let flight = sample.jump.flight.as_ref()?.parabola();
                    (!distance.is_nan()).then_some((distance, flight))
                };
                let distances = within.distances(corners.filter_map(corner));
                let cost = within.cost[0] + within.cost[1] * shortest * shortest;
                usable.extend(distances.map(|distances| (distances, cost)));
            }
        }
        below(&usable)
    }
}

impl Reached {
    fn new(rows: &[Row], height: f64) -> Reached {
        let distance = |sample: &Option<Sample>| {
            let sample = sample.as_ref();
            sample
                .and_then(|sample| sample.jump.distance(height))
                .unwrap_or(f64::NAN)
        };
        let distances: Vec<Vec<f64>> = rows
            .iter()
            .map(|row| row.samples.iter().map(distance).collect())
            .collect();
        let lands = distances.iter().flatten().filter(|d| !d.is_nan());
        let span = lands.fold(Span::NONE, |span, d| span.hull(Span::point(*d)));
        let mut reached = Reached {
            distances,
            span,
            pairs: vec![Vec::new(); BINS],
        };
        let time = |row: usize, column: usize| rows[row].samples[column].as_ref().map(|s| s.time);
        let mut pairs: Vec<(f64, [usize; 2])> = Vec::new();
        for row in 0..rows.len() {
            for column in 1..ANGLES {
                if let (Some(a), Some(b)) = (time(row, column - 1), time(row, column)) {
                    pairs.push((a.min(b), [row, column]));
                }
            }
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (_, [row, column]) in pairs {
            let ends = [column - 1, column].map(|column| reached.distances[row][column]);
            if ends.iter().any(|d| d.is_nan()) {
                continue;
            }
            let bins = ends.map(|d| reached.bin(d));
            for bin in bins[0].min(bins[1])..=bins[0].max(bins[1]) {
                reached.pairs[bin].push([row, column]);
            }
        }
        reached
    }

    /// The part of the distances that `distance` (m) is in: from 0 to the last, as a cast of what is
    /// less, or no number, gives 0.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    fn bin(&self, distance: f64) -> usize {
        let share = (distance - self.span.low) / self.span.width();
        ((share * BINS as f64) as usize).min(BINS - 1)
    }
}

/// The push of a jump of a row that ended so.
pub(super) fn pushed(row: Push, outcome: Outcome) -> Push {
    if row == Push::Part && outcome == Outcome::Force {
        Push::Short
    } else {
        row
    }
}

/// The `i`th of `count` even places in a span, the first at its beginning.
fn part(span: Span, i: usize, count: usize) -> f64 {
    span.low + span.width() * i as f64 / (count - 1) as f64
}

/// A flight whose numbers are mixed from those of two.
fn between(a: &Flight<f64>, b: &Flight<f64>, mix: impl Fn(f64, f64) -> f64) -> Flight<f64> {
    Flight {
        x: mix(a.x, b.x),
        y: mix(a.y, b.y),
        vx: mix(a.vx, b.vx),
        vy: mix(a.vy, b.vy),
        gravity: a.gravity,
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
                edge.top + rim_over(self.rim, self.leap, edge) - SLACK,
                feet.high,
            ));
        }
        let distances = distances.meet(self.landings - feet);
        (!feet.is_empty() && !distances.is_empty()).then_some(distances)
    }
}

/// The height that is meant for an edge of a leap.
fn rim_over(rim: [f64; 2], leap: &Leap, edge: &Edge) -> f64 {
    rim[usize::from(leap.lands_on(edge))]
}

/// Whether a flight from `foot` (m) keeps the wheel's rim clear of a leap's edges.
fn clears(flight: &Flight<f64>, leap: &Leap, foot: f64, height: f64, rim: [f64; 2]) -> bool {
    leap.edges.iter().all(|edge| {
        let reach = rim_over(rim, leap, edge) + leap.from;
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
