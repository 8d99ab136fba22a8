//! Inputs and answers that written code tests itself with, as rows of C.

use saltus_controller::qp::{self, HalfPlane};
use saltus_controller::{Approach, Axis, Input, Obstacle, Reason, Sensed, Task, Timing};

use super::c::list;
use super::numbers::Number;
use super::tables::{Nodes, Tables};

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
    pub(super) fn firing_angles(&self, count: usize) -> Vec<String> {
        let mut draw = Draw(4);
        let rates = Axis {
            first: self.counted.least,
            last: self.counted.greatest,
            ..self.rates
        };
        let look = |_| {
            let given = [R::of(draw.along(&rates)), R::of(self.distance(&mut draw))];
            let height = self.robot.landing_height;
            let answer = self.controller().firing_angle(given[0], given[1], height);
            let (code, angle) = coded(answer, R::ZERO);
            format!("{}, {code}, {}", list(&given), angle.c())
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
    pub(super) fn decisions(&self, count: usize) -> Vec<String> {
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
            let over = u8::from(task.obstacle.is_some());
            let numbers = |o: Obstacle<R>| [o.front, o.back, o.height, o.clearance];
            let obstacle = list(&task.obstacle.map_or([R::ZERO; 4], numbers));
            let answer = self.controller().decide(&sensed, &task).map(|d| {
                let (timing, time) = timing(d.timing);
                let numbers = list(&[d.approach_rate, d.firing_angle, d.valve_open, time]);
                format!("{numbers}, {timing}, {}", u8::from(d.settled))
            });
            let none = format!("{}, SALTUS_WAIT, 0", list(&[R::ZERO; 4]));
            let (code, answer) = coded(answer, none);
            let asked = list(&[task.distance, task.landing_height]);
            let sensed = list(&[sensed.lean, sensed.rate]);
            format!("{{{sensed}}}, {asked}, {over}, {{{obstacle}}}, {code}, {{{answer}}}")
        };
        (0..count).map(decide).collect()
    }

    /// `count` take-offs.
    pub(super) fn take_offs(&self, count: usize) -> Vec<String> {
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
            let a = &approach;
            let given = list(&[a.distance, a.height, a.length, a.speed, a.clearance]);
            let answer = match self.controller().take_off(a) {
                Ok(t) => {
                    let numbers = [t.approach_rate, t.firing_angle, t.distance, t.clearance];
                    let (down, numbers) = (t.touch_down, list(&numbers));
                    format!("SALTUS_OK, SALTUS_NO_INPUT, {{{down}, {numbers}}}")
                }
                Err(none) => {
                    let (code, which) = (status(none.reason), input(none.input));
                    format!("{code}, {which}, {{0, {}}}", list(&[R::ZERO; 4]))
                }
            };
            format!("{{{given}}}, {answer}")
        };
        (0..count).map(choose).collect()
    }

    /// `count` quadratic programs.
    pub(super) fn programs(count: usize) -> Vec<String> {
        let mut draw = Draw(3);
        let solve = |_| {
            let mut signed = || R::of(draw.between(-1.0, 1.0));
            let (a, b, c) = (signed(), signed(), signed());
            let h = [a * a + R::ONE, a * b, b * b + c * c + R::ONE];
            let g = [signed(), signed()];
            let constraints: [HalfPlane<R>; 4] = std::array::from_fn(|_| HalfPlane {
                normal: [signed(), signed()],
                bound: signed() * R::of(0.3),
            });
            let row = |c: &HalfPlane<R>| format!("{{{{{}}}, {}}}", list(&c.normal), c.bound.c());
            let rows = constraints.each_ref().map(row).join(", ");
            let (code, x) = coded(qp::two(h, g, &constraints), [R::ZERO; 2]);
            let (h, g, x) = (list(&h), list(&g), list(&x));
            format!("{{{h}}}, {{{g}}}, {{{rows}}}, {code}, {{{x}}}")
        };
        (0..count).map(solve).collect()
    }
}

/// The status of C, and the answer or what stands in the place of one.
fn coded<T>(answer: Result<T, Reason>, none: T) -> (&'static str, T) {
    match answer {
        Ok(answer) => ("SALTUS_OK", answer),
        Err(reason) => (status(reason), none),
    }
}

fn status(reason: Reason) -> &'static str {
    match reason {
        Reason::OutOfTable => "SALTUS_OUT_OF_TABLE",
        Reason::Infeasible => "SALTUS_INFEASIBLE",
        Reason::SensorInvalid => "SALTUS_SENSOR_INVALID",
        Reason::AskLater => "SALTUS_ASK_LATER",
    }
}

fn input(input: Option<Input>) -> &'static str {
    match input {
        None => "SALTUS_NO_INPUT",
        Some(Input::Distance) => "SALTUS_INPUT_DISTANCE",
        Some(Input::Height) => "SALTUS_INPUT_HEIGHT",
        Some(Input::Length) => "SALTUS_INPUT_LENGTH",
        Some(Input::Speed) => "SALTUS_INPUT_SPEED",
        Some(Input::Clearance) => "SALTUS_INPUT_CLEARANCE",
    }
}

fn timing<R: Number>(timing: Timing<R>) -> (&'static str, R) {
    match timing {
        Timing::Wait(time) => ("SALTUS_WAIT", time),
        Timing::Fire(time) => ("SALTUS_FIRE", time),
        Timing::Late(time) => ("SALTUS_LATE", time),
    }
}
