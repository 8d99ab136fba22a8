//! The phases of a stance: their dynamics, and the guards that end them.

use std::f64::consts::FRAC_PI_2;

use saltus_numeric::Single;
use saltus_numeric::dop853::Derivative;
use saltus_pneumatics::{Drive, Force, Piece, Switches};

use crate::Stance;
use crate::advance::index::{EXTENSION, GAS, LEAN, RATE, SPEED, TIME};
use crate::advance::{CHECKED, Look, Phase, State, WIDTH};

/// The leg held at d = 0 by its end stop: the robot pivots, and the chamber may fill.
pub(crate) struct Held<'a, S: Single> {
    pub stance: &'a Stance<S>,
    /// The chamber's piece while energized.
    pub piece: Option<Piece<S>>,
    /// Whether the drive pushes, so that the leg may break away.
    pub energized: bool,
    /// Lean (rad) at which the phase ends.
    pub target: Option<S>,
    /// Lean (rad) at which the ground would have to pull: on both sides where it is positive.
    pub early: Option<f64>,
}

impl<S: Single> Held<'_, S> {
    /// Numbers of the guards.
    ///
    /// The others end the stance: 1, at rest before the target; 5, fallen over.
    pub(crate) const TARGET: usize = 0;
    pub(crate) const BREAK_AWAY: usize = 2;
    pub(crate) const EDGE: usize = 3;
    pub(crate) const EARLY: usize = 4;

    /// The force (N) by which the leg is pushed beyond what holds it: positive where it breaks
    /// away.
    ///
    /// (P − P_a) A − F_f + m ω² r_s − m g cos φ, with the drive's other terms where it has them.
    pub(crate) fn excess(&self, y: &State<S>) -> S {
        let stance = self.stance;
        let (_, cos) = y[LEAN].sin_cos();
        self.force(y).value
            + stance.mass * (y[RATE] * y[RATE] * stance.radius - stance.gravity * cos)
    }

    /// The leg's force at rest.
    fn force(&self, y: &State<S>) -> Force<S> {
        let switches = Switches {
            energized: self.energized,
            cushioned: false,
        };
        let zero = S::of(0.0);
        self.stance
            .leg
            .force(switches, zero, zero, self.pressure(y))
    }

    /// Chamber pressure (Pa); without a piece, u is the pressure (MPa).
    pub(crate) fn pressure(&self, y: &State<S>) -> S {
        match (self.stance.leg.chamber(), &self.piece) {
            (Some(chamber), Some(piece)) => chamber.pressure(piece.flow, y[GAS]),
            _ => y[GAS] * S::of(saltus_pneumatics::MEGA),
        }
    }

    /// d(excess)/dt (N/s).
    fn excess_rate(&self, y: &State<S>, dy: &State<S>) -> S {
        let stance = self.stance;
        let change = match (stance.leg.chamber(), &self.piece) {
            (Some(chamber), Some(piece)) => {
                dy[GAS] * piece.gas_at_rest(chamber, y[GAS]).pressure_per_variable
            }
            _ => S::of(0.0),
        };
        let (sin, _) = y[LEAN].sin_cos();
        self.force(y).wrt_pressure * change
            + stance.mass * y[RATE] * (S::of(2.0) * dy[RATE] * stance.radius + stance.gravity * sin)
    }
}

/// A guard that never acts.
pub(crate) const NEVER: f64 = -1.0;
/// Forces (N) are scaled by this in guards, so that they are about 1.
pub(crate) const FORCE_SCALE: f64 = 0.01;

impl<S: Single> Derivative<S, WIDTH> for Held<'_, S> {
    fn at(&self, y: &State<S>) -> State<S> {
        let mut dy = [S::of(0.0); WIDTH];
        let (sin, _) = y[LEAN].sin_cos();
        dy[LEAN] = y[RATE];
        dy[RATE] = self.stance.pendulum.stiffness * sin;
        dy[TIME] = S::of(1.0);
        if let (Some(piece), Some(chamber)) = (&self.piece, self.stance.leg.chamber()) {
            let gas = piece.gas_at_rest(chamber, y[GAS]);
            dy[GAS] = piece.rate(chamber, &gas);
        }
        dy
    }
}

impl<S: Single> Phase<S, WIDTH, 6> for Held<'_, S> {
    const CHECKED: usize = CHECKED;
    fn look(&self, y: &State<S>) -> Look<S, WIDTH, 6> {
        let (never, zero, scale) = (S::of(NEVER), S::of(0.0), S::of(FORCE_SCALE));
        let dy = self.at(y);
        let idle = (never, zero);
        let aside = if y[LEAN].value() < 0.0 {
            -dy[LEAN]
        } else {
            dy[LEAN]
        };
        let guards = [
            self.target
                .map_or(idle, |target| (y[LEAN] - target, dy[LEAN])),
            self.target.map_or(idle, |_| (-y[RATE], -dy[RATE])),
            if self.energized {
                (self.excess(y) * scale, self.excess_rate(y, &dy) * scale)
            } else {
                idle
            },
            self.piece
                .map_or(idle, |piece| (piece.guards(y[GAS]).0, piece.sign * dy[GAS])),
            // The ground lets go of a robot that falls back where it would of one that falls ahead.
            self.early.map_or(idle, |early| match early {
                early if early > 0.0 => (y[LEAN].abs() - S::of(early), aside),
                early => (y[LEAN] - S::of(early), dy[LEAN]),
            }),
            (y[LEAN].abs() - S::of(FRAC_PI_2), aside),
        ];
        Look {
            rates: dy,
            guards: guards.map(|g| g.0),
            guard_rates: guards.map(|g| g.1),
        }
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
    /// Numbers of the guards; the last, 4, is the leg's coming to a halt.
    pub(crate) const REACHED: usize = 0;
    pub(crate) const FORCE: usize = 1;
    pub(crate) const EDGE_ABOVE: usize = 2;
    pub(crate) const EDGE_BELOW: usize = 3;

    /// The leg's force with its derivatives at pressure `p` (Pa).
    #[inline(always)]
    fn force_at(&self, y: &State<S>, p: S) -> Force<S> {
        let leg = &self.stance.leg;
        match (&leg.drive, self.stance.plain) {
            (Drive::Pneumatic(chamber), true) => leg.plain_force(chamber, y[SPEED], p),
            _ => leg.force(self.switches, y[EXTENSION], y[SPEED], p),
        }
    }

    /// The leg's force (N).
    #[inline(always)]
    pub(crate) fn force(&self, y: &State<S>) -> S {
        self.force_at(y, self.pressure(y)).value
    }

    /// Chamber pressure (Pa); the ambient one for a leg without a chamber.
    #[inline(always)]
    pub(crate) fn pressure(&self, y: &State<S>) -> S {
        match (self.stance.leg.chamber(), &self.piece) {
            (Some(chamber), Some(piece)) => chamber.pressure(piece.flow, y[GAS]),
            _ => y[GAS] * S::of(saltus_pneumatics::MEGA),
        }
    }
}

impl<S: Single> Derivative<S, WIDTH> for Extension<'_, S> {
    #[inline(always)]
    fn at(&self, y: &State<S>) -> State<S> {
        S::apart(|| self.dynamics(y).0)
    }
}

impl<S: Single> Extension<'_, S> {
    /// The thesis' equations of motion (§5.2.1) with the leg's force and the chamber's pressure:
    /// the state's derivative, the force, and Ṗ (Pa/s).
    #[inline(always)]
    fn dynamics(&self, y: &State<S>) -> (State<S>, Force<S>, S) {
        let stance = self.stance;
        if let (Some(chamber), Some(piece)) = (stance.leg.chamber(), &self.piece) {
            let (gas, about) = stance.gas(y, chamber, &piece.valve);
            let force = self.force_at(y, gas.pressure);
            let mut dy = stance.motion(y, force.value, about);
            dy[GAS] = piece.rate(chamber, &gas);
            (dy, force, dy[GAS] * gas.pressure_per_variable)
        } else {
            let force = self.force_at(y, S::of(0.0));
            (
                stance.motion(y, force.value, stance.about_foot(y).inverse()),
                force,
                S::of(0.0),
            )
        }
    }
}

impl<S: Single> Phase<S, WIDTH, 5> for Extension<'_, S> {
    const CHECKED: usize = CHECKED;
    #[inline(always)]
    fn look(&self, y: &State<S>) -> Look<S, WIDTH, 5> {
        let (never, scale) = (S::of(NEVER), S::of(-FORCE_SCALE));
        let (dy, force, pressure_rate) = S::apart(|| self.dynamics(y));
        let change = force.wrt_pressure.mul_add(
            pressure_rate,
            force
                .wrt_speed
                .mul_add(dy[SPEED], force.wrt_extension * dy[EXTENSION]),
        );
        let (above, below) = self
            .piece
            .map_or((never, never), |piece| piece.guards(y[GAS]));
        let rise = self.piece.map_or(S::of(0.0), |piece| piece.sign * dy[GAS]);
        Look {
            rates: dy,
            guards: [
                y[EXTENSION] - self.next,
                force.value * scale,
                above,
                below,
                -y[SPEED],
            ],
            guard_rates: [dy[EXTENSION], change * scale, rise, -rise, -dy[SPEED]],
        }
    }
}

/// What a phase tells of a state.
pub(crate) trait Drives<S: Single, const W: usize>: Derivative<S, W> {
    /// Chamber pressure (Pa).
    fn gas_pressure(&self, y: &[S; W]) -> S;
    /// The drive's force and the leg's whole force (N).
    fn forces(&self, y: &[S; W]) -> (S, S);
}

impl<S: Single> Drives<S, WIDTH> for Held<'_, S> {
    fn gas_pressure(&self, y: &State<S>) -> S {
        self.pressure(y)
    }
    fn forces(&self, _: &State<S>) -> (S, S) {
        (S::of(0.0), S::of(0.0))
    }
}

impl<S: Single> Drives<S, WIDTH> for Extension<'_, S> {
    fn gas_pressure(&self, y: &State<S>) -> S {
        self.pressure(y)
    }
    fn forces(&self, y: &State<S>) -> (S, S) {
        let p = self.pressure(y);
        let Force { value, .. } =
            self.stance
                .leg
                .drive_force(self.switches, y[EXTENSION], y[SPEED], p);
        (value, self.force(y))
    }
}
