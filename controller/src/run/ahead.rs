//! An obstacle ahead: how far it is, and what each leg does about it.

use crate::{Axis, Real};

/// What each leg does before an obstacle: a table over the rate at which it enters the active zone, the
/// height of the axle and the distance from the axle to the obstacle's front then. The height tells
/// when the foot will come down.
///
/// A range sensor gives the distance now and then ([`Runner::sense`](super::Runner::sense)); in between
/// the encoder of the radius carries it on. Beyond the last distance the law of the gait holds. Before
/// the first one the obstacle is behind, and the next one counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ahead<'a, R> {
    /// Way forwards (m) for a count of the radius encoder; negative if it counts backwards.
    pub way: R,
    /// Height (m) for a count of the pivot encoder; negative if it counts downwards.
    pub climb: R,
    /// Least weight of a reading of the range sensor in the distance; the mean of the first readings
    /// weighs each of them alike.
    pub least_weight: R,
    /// By how much (m) a reading may differ from the distance; farther off, it is another obstacle's.
    pub same: R,
    /// Least distance (m) to run up: before a nearer obstacle a robot at rest first runs the other way,
    /// until it is this far from it, and comes to stand. With 0 it never does, nor where a speed is
    /// held.
    pub room: R,
    /// Ends of the cells of the rate (rad/s). Beyond them the first cell and the last one hold.
    pub rates: Axis<R>,
    /// Ends of the cells of the axle's height above that of the first cycle (m), in which the robot
    /// stands. Beyond them the first cell and the last one hold.
    pub heights: Axis<R>,
    /// Ends of the cells of the distance (m).
    pub distances: Axis<R>,
    /// What is done in each cell, all distances of a height one after the other, all
    /// heights of a rate: an index into `choices`.
    pub cells: &'a [u8],
    /// Firing angle (rad) and valve opening time (s); with a time of 0 the leg does not fire.
    pub choices: &'a [[R; 2]],
    /// From this choice on a firing jumps over the obstacle: no leg fires until that is behind.
    pub first_leap: u8,
}

/// What a leg is to do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Choice<R> {
    /// Firing angle (rad) and valve opening time (s).
    pub(super) firing: [R; 2],
    /// Whether it jumps over the obstacle.
    pub(super) leaps: bool,
}

impl<R: Real> Ahead<'_, R> {
    /// What a leg does that enters the zone at `rate` (rad/s), the axle at `height` (m), `distance` (m)
    /// from the obstacle; none beyond the table.
    #[inline]
    pub(super) fn choice(&self, rate: R, height: R, distance: R) -> Option<Choice<R>> {
        let row = within(&self.rates, rate)?;
        let level = within(&self.heights, height)?;
        let column = self.distances.locate(distance).ok()?.cell;
        let after = |cell: usize, axis: &Axis<R>, next: usize| {
            let count = axis.count.wrapping_sub(1);
            cell.wrapping_mul(count).wrapping_add(next)
        };
        let cell = after(after(row, &self.heights, level), &self.distances, column);
        let index = *self.cells.get(cell)?;
        Some(Choice {
            firing: *self.choices.get(usize::from(index))?,
            leaps: index >= self.first_leap,
        })
    }
}

/// The cell of `axis` in which `x` lies, the first or the last one beyond.
#[inline]
fn within<R: Real>(axis: &Axis<R>, x: R) -> Option<usize> {
    let inside = x.greater(axis.first).lesser(axis.last);
    Some(axis.locate(inside).ok()?.cell)
}

/// The distance to the obstacle ahead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sight<R> {
    /// From the axle to its front (m), if it has been seen.
    distance: Option<R>,
    /// Readings in it.
    readings: i32,
    /// The range sensor's reading of this cycle (m).
    reading: Option<R>,
    last_radius: Option<i32>,
}

/// Most readings that are counted.
const MOST_READINGS: i32 = 1000;

impl<R: Real> Sight<R> {
    /// Nothing seen.
    pub(super) const NOTHING: Sight<R> = Sight {
        distance: None,
        readings: 0,
        reading: None,
        last_radius: None,
    };

    /// A reading (m) of this cycle.
    #[inline]
    pub(super) fn sense(&mut self, distance: R) {
        self.reading = (distance.is_positive() && distance.is_finite()).then_some(distance);
    }

    /// The distance (m) in this cycle, the boom's encoder being at `radius`, counted in `direction`.
    #[inline]
    pub(super) fn look(&mut self, ahead: &Ahead<'_, R>, radius: i32, direction: i32) -> Option<R> {
        let counts = radius.wrapping_sub(self.last_radius.unwrap_or(radius));
        self.last_radius = Some(radius);
        let way = R::of_count(counts.wrapping_mul(direction)) * ahead.way;
        let carried = self.distance.map(|distance| distance - way);
        self.distance = carried.filter(|distance| *distance >= ahead.distances.first);
        if let Some(reading) = self.reading.take() {
            self.take(ahead, reading);
        }
        self.distance
    }

    #[inline]
    fn take(&mut self, ahead: &Ahead<'_, R>, reading: R) {
        match self.distance {
            // What is beneath the robot is not seen: the reading is of the next obstacle.
            Some(distance) if !distance.is_positive() => {}
            Some(distance) if (reading - distance).magnitude() <= ahead.same => {
                self.readings = (self.readings + 1).min(MOST_READINGS);
                let weight = (R::ONE / R::of_count(self.readings)).greater(ahead.least_weight);
                self.distance = Some(distance + weight * (reading - distance));
            }
            _ => (self.distance, self.readings) = (Some(reading), 1),
        }
    }
}
