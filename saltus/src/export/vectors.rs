//! Inputs and answers that written code tests itself with.

use saltus_controller::qp::{self, HalfPlane};
use saltus_controller::{
    Approach, Axis, Decision, NoTakeOff, Obstacle, Reason, Sensed, TakeOff, Task,
};

use super::numbers::Number;
use super::tables::{Nodes, Tables};

/// Rate and distance, and the firing angle.
pub(super) struct Looked<R> {
    pub(super) given: [R; 2],
    pub(super) answer: Result<R, Reason>,
}

/// A decision's input and answer.
pub(super) struct Decided<R> {
    pub(super) sensed: Sensed<R>,
    pub(super) task: Task<R>,
    pub(super) answer: Result<Decision<R>, Reason>,
}

/// A take-off's input and answer.
pub(super) struct Chosen<R> {
    pub(super) approach: Approach<R>,
    pub(super) answer: Result<TakeOff<R>, NoTakeOff>,
}

/// A quadratic program and its answer.
pub(super) struct Solved<R> {
    pub(super) h: [R; 3],
    pub(super) g: [R; 2],
    pub(super) constraints: [HalfPlane<R>; 4],
    pub(super) answer: Result<[R; 2], Reason>,
}

/// Numbers from 0 to 1, the same each time.
///
/// Source: L'Ecuyer, Tables of linear congruential generators, Math. Comp. 68 (1999); the modulus
/// is 2³².
struct Draw(u32);

impl Draw {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(2_891_336_453).wrapping_add(12345);
        f64::from(self.0 >> 8) / f64::from(1 << 24)
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    /// A little beyond an axis, too.
    fn along<R: Number>(&mut self, axis: &Axis<R>) -> f64 {
        let (first, last) = (axis.first.wide(), axis.last.wide());
        let more = 0.05 * (last - first);
        self.between(first - more, last + more)
    }
}

impl<R: Number> Tables<R> {
    /// `count` firing angles for the landing height of the tables: over the rates and distances and
    /// a little beyond.
    pub(super) fn firing_angles(&self, count: usize) -> Vec<Looked<R>> {
        let mut draw = Draw(4);
        let rates = Axis {
            first: self.counted.least,
            last: self.counted.greatest,
            ..self.rates
        };
        let look = |_| {
            let given = [R::of(draw.along(&rates)), R::of(self.distance(&mut draw))];
            let answer =
                self.controller()
                    .firing_angle(given[0], given[1], self.robot.landing_height);
            Looked { given, answer }
        };
        (0..count).map(look).collect()
    }

    fn distance(&self, draw: &mut Draw) -> f64 {
        match self.nodes {
            Nodes::Curve(_) => self.distances.first.wide(),
            Nodes::Table(_) => draw.along(&self.distances),
        }
    }

    /// `count` decisions: over the tables and a little beyond, half of them over an obstacle.
    pub(super) fn decisions(&self, count: usize) -> Vec<Decided<R>> {
        let mut draw = Draw(1);
        let start = self.counted.reference_lean.wide();
        let decide = |k: usize| {
            let lean = draw.between(start, start + 0.3);
            let distance = self.distance(&mut draw);
            let radius = self.robot.radius.wide();
            let (front, length) = (
                draw.between(1.0, 1.5) * radius,
                draw.between(0.1, 0.8) * radius,
            );
            let height = draw.between(0.0, 0.6) * radius;
            let obstacle = Obstacle {
                front: R::of(front),
                back: R::of(front + length),
                height: R::of(height),
                clearance: R::of(0.01),
            };
            let sensed = Sensed {
                lean: R::of(lean),
                rate: R::of(draw.along(&self.rates)),
            };
            let task = Task {
                distance: R::of(distance),
                landing_height: self.robot.landing_height,
                obstacle: (k % 2 == 1).then_some(obstacle),
                guess: None,
            };
            let answer = self.controller().decide(&sensed, &task);
            Decided {
                sensed,
                task,
                answer,
            }
        };
        (0..count).map(decide).collect()
    }

    /// `count` take-offs.
    pub(super) fn take_offs(&self, count: usize) -> Vec<Chosen<R>> {
        let mut draw = Draw(2);
        let radius = self.robot.radius.wide();
        let rates = Axis {
            first: self.counted.least,
            last: self.counted.greatest,
            ..self.rates
        };
        let choose = |_| {
            let approach = Approach {
                distance: R::of(draw.between(0.5, 5.0) * radius),
                height: R::of(draw.between(0.0, 0.6) * radius),
                length: R::of(draw.between(0.1, 0.8) * radius),
                speed: R::of(draw.along(&rates) * radius),
                clearance: R::of(0.01),
            };
            Chosen {
                approach,
                answer: self.controller().take_off(&approach),
            }
        };
        (0..count).map(choose).collect()
    }

    /// `count` quadratic programs.
    pub(super) fn programs(count: usize) -> Vec<Solved<R>> {
        let mut draw = Draw(3);
        let solve = |_| {
            let mut signed = || R::of(draw.between(-1.0, 1.0));
            let (a, b, c) = (signed(), signed(), signed());
            let h = [a * a + R::ONE, a * b, b * b + c * c + R::ONE];
            let g = [signed(), signed()];
            let constraints = std::array::from_fn(|_| HalfPlane {
                normal: [signed(), signed()],
                bound: signed() * R::of(0.3),
            });
            Solved {
                h,
                g,
                constraints,
                answer: qp::two(h, g, &constraints),
            }
        };
        (0..count).map(solve).collect()
    }
}
