//! The phases of a stance: their dynamics, and the guards that end them.

use std::f64::consts::FRAC_PI_2;

use saltus_numeric::Single;
use saltus_pneumatics::{Chamber, Drive, Flow, Switches, Valve};

use crate::Stance;
use crate::advance::index::{EXTENSION, LEAN, PRESSURE, RATE, RATIO, SPEED, TIME};
use crate::advance::{MEGA, Phase, State, WIDTH};

/// The smooth piece that the chamber is on: the valve's law, and the pressures at which it ends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece<S: Single> {
    pub flow: Flow,
    valve: Valve<S>,
    /// Pressures (MPa) at which the law switches: falling to the first, rising to the second.
    low: S,
    high: S,
    port_open: bool,
    extras: bool,
}

impl<S: Single> Piece<S> {
    /// The piece at pressure `p` (Pa), or just above or below it where `side` is ±1.
    pub(crate) fn new(chamber: &Chamber<S>, energized: bool, p: S, side: f64, port_open: bool) -> Piece<S> {
        let nudged = p * S::of(1.0 + 1e-9 * side);
        let flow = chamber.flow(energized, nudged);
        let extras = chamber.has_extras();
        let (fill, exhaust) = (chamber.fill_edge(), chamber.exhaust_edge());
        let mut edges = [fill, chamber.balance_above(), exhaust];
        if !energized {
            edges[..2].copy_from_slice(&[chamber.balance_below(), exhaust]);
        } else if !extras {
            edges[2] = fill;
        }
        let (mut low, mut high) = (S::of(0.0), S::of(f64::MAX / MEGA));
        for edge in edges {
            if edge.value() < nudged.value() && edge.value() > low.value() {
                low = edge;
            }
            if edge.value() >= nudged.value() && edge.value() < high.value() {
                high = edge;
            }
        }
        let micro = S::of(1.0 / MEGA);
        Piece { flow, valve: chamber.on(flow), low: low * micro, high: high * micro, port_open, extras }
    }

    /// Rates of pressure (MPa/s) and of z at pressure `p` (Pa), where `inverse` is 1/(V P).
    #[inline(always)]
    fn rates(&self, chamber: &Chamber<S>, p: S, z: S, d: S, speed: S, inverse: S) -> (S, S) {
        let (mut rate, mut z_rate) = chamber.rates(&self.valve, p, z, speed, inverse);
        if self.extras {
            let more = chamber.pressure_per_mass(chamber.volume(d))
                * chamber.extra_inflow(self.flow, p, self.port_open);
            z_rate = z_rate + self.valve.ratio_rate(z, more / p);
            rate = rate + more;
        }
        (rate * S::of(1.0 / MEGA), z_rate)
    }
}

/// The leg held at d = 0 by its end stop: the robot pivots, and the chamber may fill.
pub(crate) struct Held<'a, S: Single> {
    pub stance: &'a Stance<S>,
    /// The chamber's piece while energized.
    pub piece: Option<Piece<S>>,
    /// Whether the drive pushes, so that the leg may break away.
    pub energized: bool,
    /// Lean (rad) at which the phase ends.
    pub target: Option<S>,
    /// Lean (rad) at which the ground would have to pull.
    pub early: Option<f64>,
}

impl<S: Single> Held<'_, S> {
    /// Numbers of the guards.
    pub(crate) const TARGET: usize = 0;
    pub(crate) const STALL: usize = 1;
    pub(crate) const BREAK_AWAY: usize = 2;
    pub(crate) const EDGE: usize = 3;
    pub(crate) const EARLY: usize = 4;
    pub(crate) const FALLEN: usize = 5;

    /// The force (N) by which the leg is pushed beyond what holds it: positive where it breaks away.
    ///
    /// (P − P_a) A − F_f + m ω² r_s − m g cos φ, with the drive's other terms where it has them.
    pub(crate) fn excess(&self, y: &State<S>) -> S {
        let stance = self.stance;
        let zero = S::of(0.0);
        let push = stance.leg.force(self.switches(), zero, zero, y[PRESSURE] * S::of(MEGA)).value;
        let (_, cos) = y[LEAN].sin_cos();
        push + stance.mass * (y[RATE] * y[RATE] * stance.radius - stance.gravity * cos)
    }

    fn switches(&self) -> Switches {
        Switches { energized: self.energized, cushioned: false }
    }

    /// d(excess)/dt (N/s).
    fn excess_rate(&self, y: &State<S>, dy: &State<S>) -> S {
        let stance = self.stance;
        let zero = S::of(0.0);
        let force = stance.leg.force(self.switches(), zero, zero, y[PRESSURE] * S::of(MEGA));
        let (sin, _) = y[LEAN].sin_cos();
        force.wrt_pressure * dy[PRESSURE] * S::of(MEGA)
            + stance.mass
                * y[RATE]
                * (S::of(2.0) * dy[RATE] * stance.radius + stance.gravity * sin)
    }
}

/// A guard that never acts.
const NEVER: f64 = -1.0;
/// Forces (N) are scaled by this in guards, so that they are about 1.
const FORCE_SCALE: f64 = 0.01;

impl<S: Single> Phase<S, 6> for Held<'_, S> {
    fn rates(&self, y: &State<S>) -> State<S> {
        let mut dy = [S::of(0.0); WIDTH];
        let (sin, _) = y[LEAN].sin_cos();
        dy[LEAN] = y[RATE];
        dy[RATE] = self.stance.pendulum.stiffness * sin;
        dy[TIME] = S::of(1.0);
        if let (Some(piece), Some(chamber)) = (&self.piece, self.stance.leg.chamber()) {
            let p = y[PRESSURE] * S::of(MEGA);
            let zero = S::of(0.0);
            let inverse = S::of(1.0) / (chamber.dead_volume * p);
            (dy[PRESSURE], dy[RATIO]) = piece.rates(chamber, p, y[RATIO], zero, zero, inverse);
        }
        dy
    }

    fn guards(&self, y: &State<S>) -> [S; 6] {
        let never = S::of(NEVER);
        [
            self.target.map_or(never, |target| y[LEAN] - target),
            self.target.map_or(never, |_| -y[RATE]),
            if self.energized { self.excess(y) * S::of(FORCE_SCALE) } else { never },
            self.piece.map_or(never, |piece| y[PRESSURE] - piece.high),
            self.early.map_or(never, |early| y[LEAN] - S::of(early)),
            y[LEAN].abs() - S::of(FRAC_PI_2),
        ]
    }

    fn guard_rates(&self, y: &State<S>, dy: &State<S>) -> [S; 6] {
        let zero = S::of(0.0);
        let on = |active: bool, rate: S| if active { rate } else { zero };
        let aside = if y[LEAN].value() < 0.0 { -dy[LEAN] } else { dy[LEAN] };
        [
            on(self.target.is_some(), dy[LEAN]),
            on(self.target.is_some(), -dy[RATE]),
            on(self.energized, self.excess_rate(y, dy) * S::of(FORCE_SCALE)),
            on(self.piece.is_some(), dy[PRESSURE]),
            on(self.early.is_some(), dy[LEAN]),
            aside,
        ]
    }
}

/// The leg extending.
pub(crate) struct Extension<'a, S: Single> {
    pub stance: &'a Stance<S>,
    /// The chamber's piece, for a pneumatic leg.
    pub piece: Option<Piece<S>>,
    pub switches: Switches,
    /// The next extension (m) at which something switches: the stroke's end at the latest.
    pub next: S,
}

impl<S: Single> Extension<'_, S> {
    /// Numbers of the guards.
    pub(crate) const REACHED: usize = 0;
    pub(crate) const FORCE: usize = 1;
    pub(crate) const EDGE_ABOVE: usize = 2;
    pub(crate) const EDGE_BELOW: usize = 3;
    pub(crate) const HALT: usize = 4;

    /// The leg's force with its derivatives.
    #[inline(always)]
    pub(crate) fn force(&self, y: &State<S>) -> saltus_pneumatics::Force<S> {
        let p = y[PRESSURE] * S::of(MEGA);
        let leg = &self.stance.leg;
        match (&leg.drive, self.stance.plain) {
            (Drive::Pneumatic(chamber), true) => leg.plain_force(chamber, y[SPEED], p),
            _ => leg.force(self.switches, y[EXTENSION], y[SPEED], p),
        }
    }
}

impl<S: Single> Phase<S, 5> for Extension<'_, S> {
    /// The thesis' equations of motion (§5.2.1) with the leg's force and the chamber's pressure.
    #[inline(always)]
    fn rates(&self, y: &State<S>) -> State<S> {
        let stance = self.stance;
        let force = self.force(y).value;
        match (stance.leg.chamber(), &self.piece) {
            (Some(chamber), Some(piece)) => stance.motion(y, force, |p, inverse| {
                piece.rates(chamber, p, y[RATIO], y[EXTENSION], y[SPEED], inverse)
            }),
            _ => stance.motion_without_gas(y, force),
        }
    }

    #[inline(always)]
    fn guards(&self, y: &State<S>) -> [S; 5] {
        let never = S::of(NEVER);
        let (above, below) =
            self.piece.map_or((never, never), |p| (y[PRESSURE] - p.high, p.low - y[PRESSURE]));
        [y[EXTENSION] - self.next, -self.force(y).value * S::of(FORCE_SCALE), above, below, -y[SPEED]]
    }

    #[inline(always)]
    fn guard_rates(&self, y: &State<S>, dy: &State<S>) -> [S; 5] {
        let force = self.force(y);
        let change = force.wrt_extension * dy[EXTENSION]
            + force.wrt_speed * dy[SPEED]
            + force.wrt_pressure * dy[PRESSURE] * S::of(MEGA);
        [dy[EXTENSION], -change * S::of(FORCE_SCALE), dy[PRESSURE], -dy[PRESSURE], -dy[SPEED]]
    }
}
