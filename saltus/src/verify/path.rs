//! The path of the wheel, and how near it comes to a box.

use saltus_numeric::root::greatest;
use saltus_sim_check::{Report, Sample};

/// Distances (m) between the wheel and a box; negative: how deep they overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearance {
    /// Least distance until lift-off.
    pub stance: f64,
    /// Least distance from lift-off to the landing, of the fired leg too while that is out; none
    /// without a flight.
    pub flight: Option<f64>,
}

impl Clearance {
    /// The lesser of the two.
    pub fn least(&self) -> f64 {
        self.flight
            .map_or(self.stance, |flight| flight.min(self.stance))
    }
}

/// The axle at an instant.
#[derive(Clone, Copy, Debug)]
struct Point {
    time: f64,
    axle: [f64; 2],
}

impl From<&Sample> for Point {
    fn from(sample: &Sample) -> Point {
        Point {
            time: sample.time,
            axle: sample.axle,
        }
    }
}

/// The path of an axle that carries a wheel.
pub(super) struct Path {
    radius: f64,
    stance: Vec<Point>,
    /// While the fired leg is out, and afterwards.
    flight: [Vec<Point>; 2],
    /// Distance (m) from the axle to the tip of the fired leg.
    reach: f64,
}

impl Path {
    /// Of a jump that lands at `landing` (m from the foothold), where the axle is at `height` (m);
    /// the fired leg is out for `leg_out` (s) after lift-off.
    pub(super) fn new(
        report: &Report,
        radius: f64,
        (landing, height): (Option<f64>, f64),
        leg_out: f64,
    ) -> Path {
        let Some(lift_off) = report.lift_off else {
            let stance = report.samples.iter().map(Point::from).collect();
            return Path {
                radius,
                stance,
                flight: [Vec::new(), Vec::new()],
                reach: radius,
            };
        };
        let start = report
            .samples
            .partition_point(|sample| sample.time < lift_off.time);
        let stance = report.samples[..=start.min(report.samples.len() - 1)]
            .iter()
            .map(Point::from)
            .collect();
        let flight = report.samples[start..].iter().map(Point::from).collect();
        let flight = match landing {
            Some(x) => until_landing(flight, [x, height]),
            None => flight,
        };
        let flight = if leg_out > 0.0 {
            split(&flight, lift_off.time + leg_out)
        } else {
            [Vec::new(), flight]
        };
        Path {
            radius,
            stance,
            flight,
            reach: radius + lift_off.extension,
        }
    }

    /// Distances to the box from `front` to `back`, which ends at `top` and has no lower end (m
    /// from the foothold).
    pub(super) fn clearance(&self, solid: &[f64; 3]) -> Clearance {
        let wheel = |points| nearest(points, solid).map(|distance| distance - self.radius);
        let leg = nearest(&self.flight[0], solid).map(|distance| distance - self.reach);
        let flight = [leg, wheel(&self.flight[1])]
            .into_iter()
            .flatten()
            .reduce(f64::min);
        Clearance {
            stance: wheel(&self.stance).unwrap_or(f64::INFINITY),
            flight,
        }
    }
}

/// The flight down to `landing`, which is its last point.
fn until_landing(mut flight: Vec<Point>, landing: [f64; 2]) -> Vec<Point> {
    let height = |point: &Point| point.axle[1];
    let top = (0..flight.len())
        .max_by(|&a, &b| height(&flight[a]).total_cmp(&height(&flight[b])))
        .unwrap_or(0);
    let down = flight
        .iter()
        .skip(top)
        .take_while(|point| height(point) > landing[1])
        .count();
    flight.truncate(top + down);
    if let [.., before, last] = flight[..] {
        let speed = (last.axle[1] - before.axle[1]) / (last.time - before.time);
        let wait = (landing[1] - last.axle[1]) / speed;
        let time = last.time
            + if wait.is_finite() && wait > 0.0 {
                wait
            } else {
                0.0
            };
        flight.push(Point {
            time,
            axle: landing,
        });
    }
    flight
}

/// A path before and after a time (s); both hold the point at that time.
fn split(points: &[Point], time: f64) -> [Vec<Point>; 2] {
    let after = points.partition_point(|point| point.time <= time);
    let (mut first, mut second) = (points[..after].to_vec(), points[after..].to_vec());
    if after > 0 && after < points.len() {
        let here = Point {
            time,
            axle: parabola(around(points, after), time),
        };
        first.push(here);
        second.insert(0, here);
    }
    [first, second]
}

/// Least distance (m) from the axle to a box; none without points. Between its samples the path is
/// a parabola but for a nanometre.
fn nearest(points: &[Point], solid: &[f64; 3]) -> Option<f64> {
    let here = |i: usize| distance(points[i].axle, solid);
    let is_least = |i: &usize| {
        let beside = [
            i.checked_sub(1),
            Some(i + 1).filter(|next| *next < points.len()),
        ];
        beside
            .into_iter()
            .flatten()
            .all(|other| here(other) >= here(*i))
    };
    let refined = |i: usize| {
        let three = around(points, i);
        let along = |time: f64| distance(parabola(three, time), solid);
        let (start, end) = (
            points[i.saturating_sub(1)].time,
            points[(i + 1).min(points.len() - 1)].time,
        );
        if start < end {
            least(start, end, along).min(here(i))
        } else {
            here(i)
        }
    };
    (0..points.len())
        .filter(is_least)
        .map(refined)
        .reduce(f64::min)
}

/// The point number `i` with its neighbours; at an end with the nearest two.
fn around(points: &[Point], i: usize) -> [Point; 3] {
    let middle = i.clamp(1, points.len().max(3) - 2);
    [middle - 1, middle, middle + 1].map(|k| points[k.min(points.len() - 1)])
}

/// Where the parabola through three points is at a time (s).
fn parabola([a, b, c]: [Point; 3], t: f64) -> [f64; 2] {
    if a.time >= b.time || b.time >= c.time {
        return b.axle;
    }
    let weights = [
        (t - b.time) * (t - c.time) / ((a.time - b.time) * (a.time - c.time)),
        (t - a.time) * (t - c.time) / ((b.time - a.time) * (b.time - c.time)),
        (t - a.time) * (t - b.time) / ((c.time - a.time) * (c.time - b.time)),
    ];
    [0, 1].map(|k| weights[0] * a.axle[k] + weights[1] * b.axle[k] + weights[2] * c.axle[k])
}

/// Distance (m) from a point to a box; inside negative, to the nearest of its front, back and top.
fn distance([x, y]: [f64; 2], [front, back, top]: &[f64; 3]) -> f64 {
    let across = (front - x).max(x - back);
    if across < 0.0 && y < *top {
        return across.max(y - top);
    }
    across.max(0.0).hypot((y - top).max(0.0))
}

/// The least value in [a, b] of a function with one minimum.
fn least(a: f64, b: f64, f: impl Fn(f64) -> f64) -> f64 {
    f(greatest(a, b, 40, |x| -f(x)))
}
