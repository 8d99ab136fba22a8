//! The path through air, step by step.

use saltus_numeric::{Single, dop853};

use super::DragFlight;
use crate::path::{Arc, Path};
use crate::polynomial::{Polynomial, root_between};
use crate::state::State;

/// Error of a step, relative to 1 + |state|.
///
/// Below round-off on purpose: the estimate is too good where a steep jump turns over and |v| has
/// all but a kink. At 1e-13 it let 2e-10 pass, which the scaling law, tested to 1e-12, brought to
/// light.
const TOLERANCE: f64 = 1e-15;

/// Distance (m) by which an arc may miss the path.
const ARC_ERROR: f64 = 1e-8;

/// The motion at one time, and what follows from it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node<S> {
    /// Time (s) after lift-off.
    pub(super) time: S,
    /// x, y (m), v_x, v_y (m/s).
    state: [S; 4],
    /// Length (s) of the step to try next.
    step: f64,
}

impl<S: Single> Node<S> {
    /// Position (m).
    pub(super) fn position(&self) -> [S; 2] {
        [self.state[0], self.state[1]]
    }

    /// Velocity (m/s).
    pub(super) fn velocity(&self) -> [S; 2] {
        [self.state[2], self.state[3]]
    }

    /// Acceleration (m/s²).
    pub(super) fn acceleration(&self, flight: &DragFlight<S>) -> [S; 2] {
        let [_, _, ax, ay] = flight.rates(&self.state);
        [ax, ay]
    }
}

impl<S: Single> DragFlight<S> {
    /// The state at lift-off.
    pub(super) fn lift_off(&self) -> Node<S> {
        let flight = &self.vacuum;
        let values = flight.values();
        let (drag, speed) = (self.drag.value(), values.vx.hypot(values.vy));
        // A tenth of the shorter time over which the drag acts, that of this speed or of the
        // terminal one.
        let step = (0.1 / (drag * speed + (drag * values.gravity).sqrt())).min(1.0);
        Node {
            time: S::of(0.0),
            state: [flight.x, flight.y, flight.vx, flight.vy],
            step,
        }
    }

    /// Derivative of x, y, v_x, v_y in time.
    fn rates(&self, &[_, _, vx, vy]: &[S; 4]) -> [S; 4] {
        let squared = vx.mul_add(vx, vy * vy);
        // At rest the root has no derivative, but its product with the velocity has.
        let speed = S::select(S::of(0.0).less(squared), || squared.sqrt(), || S::of(0.0));
        let damping = self.drag * speed;
        [vx, vy, -damping * vx, -(damping * vy) - self.vacuum.gravity]
    }

    /// One step of length `h` (s).
    fn step(&self, node: &Node<S>, h: S) -> (Node<S>, f64) {
        let rates = |state: &[S; 4]| self.rates(state);
        let step = dop853::step(&rates, &node.state, &rates(&node.state), h, 4, TOLERANCE);
        (
            Node {
                time: node.time + h,
                state: step.state,
                step: node.step,
            },
            step.error,
        )
    }

    /// The state after one step of a length that keeps to the tolerance.
    fn advance(&self, node: &Node<S>) -> Node<S> {
        /// A step that stays bad after so many cuts meets numbers beyond the greatest; let it show.
        const MOST: usize = 100;
        let mut h = node.step;
        for _ in 0..MOST {
            let (next, error) = self.step(node, S::of(h));
            let factor = dop853::step_factor(error);
            if error <= 1.0 {
                return Node {
                    step: h * factor,
                    ..next
                };
            }
            h *= factor;
        }
        Node {
            time: S::of(f64::NAN),
            ..*node
        }
    }

    /// The states after `from`, step by step without end, itself included.
    fn nodes(&self, from: Node<S>) -> impl Iterator<Item = Node<S>> {
        std::iter::successors(Some(from), |node| Some(self.advance(node)))
    }

    /// The state after `from` in which `event`, given as its value and its slope in time, first
    /// falls below zero.
    ///
    /// At `from` it is not below zero. It is a root of the step's length.
    pub(super) fn first_below(&self, from: Node<S>, event: impl Fn(&Node<S>) -> [S; 2]) -> Node<S> {
        let mut node = from;
        loop {
            let next = self.advance(&node);
            if next.time.value().is_nan() {
                return next;
            }
            if event(&next)[0].value() < 0.0 {
                let after = |h: S| self.step(&node, h).0;
                let length = (next.time - node.time).value();
                let h = root_between(0.0, length, |h| event(&after(S::of(h))).map(S::value));
                let [value, slope] = event(&after(S::of(h)));
                // A step of Newton's method gives the root its derivatives; a height at the apex
                // has none.
                let level = slope.value() == 0.0;
                return after(if level {
                    S::of(h)
                } else {
                    S::of(h) - value / S::of(slope.value())
                });
            }
            node = next;
        }
    }
}

/// The path from lift-off on, kept so that any time on it is one step away.
#[derive(Clone, Debug)]
pub(super) struct Track<S> {
    flight: DragFlight<S>,
    /// One at the apex, so that no step passes it: a vertical jump's drag has a kink there.
    nodes: Vec<Node<S>>,
}

impl<S: Single> Track<S> {
    /// The path of `flight` up to time `until` (s).
    pub(super) fn new(flight: &DragFlight<S>, until: f64) -> Self {
        let apex = flight.apex();
        let turn = apex.map_or(f64::INFINITY, |apex| apex.time.value());
        let reached = |node: &Node<S>| node.time.value() <= until;
        let rise = flight
            .nodes(flight.lift_off())
            .take_while(|node| reached(node) && node.time.value() < turn);
        let mut nodes: Vec<_> = rise.collect();
        if let Some(apex) = apex {
            nodes.extend(flight.nodes(apex).take_while(reached));
        }
        Track {
            flight: *flight,
            nodes,
        }
    }

    /// The state at time `t` (s): one step from the node before; not a number before lift-off.
    pub(super) fn node(&self, t: S) -> Node<S> {
        let after = self
            .nodes
            .partition_point(|node| node.time.value() <= t.value());
        match after.checked_sub(1) {
            Some(i) => self.flight.step(&self.nodes[i], t - self.nodes[i].time).0,
            None => Node {
                state: [S::of(f64::NAN); 4],
                ..self.flight.lift_off()
            },
        }
    }

    /// The greatest length (s) of a parabola that misses the path after node `i` by no more than
    /// [`ARC_ERROR`].
    ///
    /// A parabola through the ends and the middle of a piece of length h misses by up to |j|
    /// h³/125. The jerk j, at most 2 c |v| |a|, is taken at the nodes, between which it changes
    /// little.
    fn arc_length(&self, i: usize, end: f64) -> f64 {
        let drag = self.flight.drag.value();
        let jerk = [self.nodes[i], self.node(S::of(end))].map(|node| {
            let norm = |v: [S; 2]| v[0].value().hypot(v[1].value());
            2.0 * drag * norm(node.velocity()) * norm(node.acceleration(&self.flight))
        });
        (125.0 * ARC_ERROR / jerk[0].max(jerk[1])).cbrt()
    }

    /// The parabola through the path at `from`, `to` and the middle between them (s).
    fn arc(&self, from: f64, to: f64) -> Arc {
        let half = 0.5 * (to - from);
        let [a, b, c] =
            [from, from + half, to].map(|t| self.node(S::of(t)).position().map(S::value));
        let through = |i: usize| {
            let (second, first) = (0.5 * (c[i] - 2.0 * b[i] + a[i]), 0.5 * (c[i] - a[i]));
            Polynomial::quadratic(b[i], first / half, second / (half * half))
        };
        Arc {
            x: through(0),
            y: through(1),
            start: from + half,
            span: [from, to],
        }
    }
}

impl<S: Single> Path<S> for Track<S> {
    fn state(&self, t: S) -> State<S> {
        let node = self.node(t);
        State {
            position: node.position(),
            velocity: node.velocity(),
            acceleration: node.acceleration(&self.flight),
        }
    }

    fn arcs(&self, from: f64, to: f64) -> impl Iterator<Item = Arc> {
        (0..self.nodes.len()).flat_map(move |i| {
            let next = self.nodes.get(i + 1).map_or(to, |node| node.time.value());
            let (from, to) = (self.nodes[i].time.value().max(from), next.min(to));
            let count = if from < to {
                ((to - from) / self.arc_length(i, to)).ceil().max(1.0)
            } else {
                0.0
            };
            let at = move |share: f64| {
                if share < count {
                    from + (to - from) * share / count
                } else {
                    to
                }
            };
            std::iter::successors(Some(0.0), |share| Some(share + 1.0))
                .take_while(move |share| *share < count)
                .map(move |share| self.arc(at(share), at(share + 1.0)))
        })
    }
}
