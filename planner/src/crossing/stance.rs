//! How near the wheel comes to what stands beside its foothold, from the foot's touch to the
//! lift-off.

use saltus_numeric::Scalar;
use saltus_numeric::root::greatest;

use crate::course::{Edge, Side, Slope};
use crate::model::Instant;

/// The way of the wheel's centre in a stance.
pub(super) struct Path {
    points: Vec<Instant<Slope>>,
}

/// Halvings, by the golden section, of an interval between two points in which the least distance
/// is.
const SECTIONS: u32 = 40;

impl Path {
    /// Through these instants of a stance.
    pub(super) fn new(points: Vec<Instant<Slope>>) -> Path {
        Path { points }
    }

    /// Through places (m from the foot) alone.
    pub(super) fn through(centres: &[[Slope; 2]]) -> Path {
        let (zero, none) = (Slope::of(0.0), [Slope::of(0.0); 2]);
        let point = |centre: &[Slope; 2]| Instant {
            time: zero,
            centre: *centre,
            velocity: none,
        };
        Path {
            points: centres.iter().map(point).collect(),
        }
    }

    /// Least distance (m) of the centre from the obstacle whose side `edge` is, of which nothing
    /// else is near; `foot` is the foothold (m) and `from` the height of its surface (m). Negative:
    /// how deep the centre is inside.
    pub(super) fn distance(&self, foot: Slope, from: f64, edge: &Edge) -> Slope {
        let distance = |[x, y]: [Slope; 2]| {
            let away = match edge.side {
                Side::Front => Slope::of(edge.x) - foot - x,
                Side::Back => foot + x - Slope::of(edge.x),
            };
            let above = y - Slope::of(edge.top - from);
            match (away.value > 0.0, above.value > 0.0) {
                (true, true) => (away * away + above * above).sqrt(),
                (false, true) => above,
                _ => away,
            }
        };
        let here = |i: usize| distance(self.points[i].centre);
        let Some(nearest) =
            (0..self.points.len()).min_by(|&a, &b| here(a).value.total_cmp(&here(b).value))
        else {
            return Slope::of(f64::NAN);
        };
        let mut least = here(nearest);
        for start in nearest.saturating_sub(1)..(nearest + 1).min(self.points.len() - 1) {
            let [from, to] = [&self.points[start], &self.points[start + 1]];
            let along = |part: f64| distance(between(from, to, part));
            let refined = along(greatest(0.0, 1.0, SECTIONS, |part| -along(part).value));
            if refined.value < least.value {
                least = refined;
            }
        }
        least
    }
}

/// The centre at a part (0 to 1) of the way from a point to the next, by the cubic with their
/// velocities.
fn between(from: &Instant<Slope>, to: &Instant<Slope>, part: f64) -> [Slope; 2] {
    let (s, t) = (part, 1.0 - part);
    let step = to.time - from.time;
    std::array::from_fn(|i| {
        from.centre[i] * Slope::of(t * t * (1.0 + 2.0 * s))
            + to.centre[i] * Slope::of(s * s * (1.0 + 2.0 * t))
            + step
                * (from.velocity[i] * Slope::of(s * t * t) - to.velocity[i] * Slope::of(s * s * t))
    })
}
