//! Over which boxes a stride carries the robot.

use std::f64::consts::TAU;

use saltus_robot::Robot;

use crate::box_table::{COLUMNS, NEAREST, WIDTH, counted, floor};
use crate::run::Row;

/// Least height (m) of the robot above each place, from the entry of a leg into the zone on.
#[derive(Clone, Debug)]
pub(super) struct Profile {
    from: f64,
    least: Vec<f64>,
}

/// Width of a place (m), the first one, from the axle at the entry, and how many there are.
const FINE: f64 = 0.01;
const FROM: f64 = -0.3;
const PLACES: usize = 230;
/// Height (m) where the robot does not come.
const HIGH: f64 = 9.0;
/// Way (m) that the axle must get beyond the box for a jump over it.
const OVER: f64 = 0.25;

impl Profile {
    /// Nothing yet, the axle being at `travel` (m).
    pub(super) fn new(travel: f64) -> Profile {
        Profile {
            from: travel + FROM,
            least: vec![HIGH; PLACES],
        }
    }

    /// Lowers it by the robot in a cycle.
    pub(super) fn take(&mut self, robot: &Robot, row: &Row<'_>) {
        let legs = robot.body.legs as usize;
        let tip = robot.body.radius - robot.foot.radius;
        let begin = robot.body.radius - robot.leg.body.length;
        let thick = robot.foot.radius.max(robot.leg.body.radius);
        let place = |leg: usize, out: f64| {
            let (sin, cos) = (row.lean - TAU * leg as f64 / legs as f64).sin_cos();
            [row.axle[0] - out * sin, row.axle[1] - out * cos]
        };
        for leg in 0..legs {
            let extension = row.extensions[leg];
            let ends = [begin + extension, tip + extension].map(|out| place(leg, out));
            self.lower(ends, thick);
            if let Some(struts) = &robot.struts {
                let ends = [leg, (leg + 1) % legs].map(|leg| place(leg, struts.distance));
                self.lower(ends, struts.radius);
            }
        }
    }

    /// Lowers it by a bar between two ends, of `radius` (m).
    fn lower(&mut self, [a, b]: [[f64; 2]; 2], radius: f64) {
        let (a, b) = if a[0] < b[0] { (a, b) } else { (b, a) };
        let low = floor(a[0] - radius - self.from, FINE);
        let high = counted(((b[0] + radius - self.from) / FINE).ceil());
        for k in low..=high.min(PLACES - 1) {
            let x = self.from + k as f64 * FINE;
            let part = ((x - a[0]) / (b[0] - a[0]).max(1e-9)).clamp(0.0, 1.0);
            let z = a[1] + part * (b[1] - a[1]) - radius;
            self.least[k] = self.least[k].min(z);
        }
    }

    /// For the distances of each column, the height (m) of the highest box of `length` (m) that is
    /// cleared; of a jump that got as far as `reach` (m) from the entry, 0 where it did not get over.
    pub(super) fn clears(&self, length: f64, reach: Option<f64>) -> Vec<f32> {
        let cell = |k: usize| {
            let distance = NEAREST + k as f64 * WIDTH;
            let end = distance + WIDTH + length;
            if reach.is_some_and(|reach| end + OVER > reach) {
                return 0.0;
            }
            let places = floor(distance - FROM, FINE)..=counted(((end - FROM) / FINE).ceil());
            let heights = places.map(|k| self.least.get(k).copied().unwrap_or(HIGH));
            #[allow(clippy::cast_possible_truncation)]
            let least = heights.fold(HIGH, f64::min) as f32;
            least
        };
        (0..COLUMNS).map(cell).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bar_lowers_what_is_beneath_it() {
        // From 0.5 m on it rises by 1 in 2, up to 0.9 m; 1 cm thick.
        let mut profile = Profile::new(10.0);
        profile.lower([[10.5, 0.3], [10.9, 0.5]], 0.01);
        let clears = profile.clears(0.1, None);
        let at = |distance: f64| f64::from(clears[floor(distance + 1e-9 - NEAREST, WIDTH)]);
        // A box before it and one beyond it are not touched.
        for distance in [0.25, 0.35, 0.95] {
            assert_eq!(at(distance), HIGH, "{distance}");
        }
        // Within it, the lowest place counts, and places are 1 cm wide.
        for (distance, should) in [(0.5, 0.29), (0.6, 0.34), (0.7, 0.39)] {
            assert!(
                (at(distance) - should).abs() < 0.0051,
                "{distance}: {}",
                at(distance)
            );
        }
        // Its ends are round: a box that reaches below one is touched.
        assert!((at(0.4) - 0.29).abs() < 1e-6);
    }

    #[test]
    fn a_jump_that_does_not_get_over_clears_nothing() {
        let profile = Profile::new(0.0);
        let clears = profile.clears(0.2, Some(1.2));
        let over = |distance: f64| clears[floor(distance + 1e-9 - NEAREST, WIDTH)] > 0.0;
        assert!(over(0.7) && !over(0.75));
    }
}
