//! The model of a stance: a robot's equations of motion on one foot.

use saltus_numeric::{Scalar, Single, refused};
use saltus_pneumatics::{Chamber, GasState, Leg, Valve};
use saltus_robot::{Launch, Robot, Term};

use crate::StanceError;
use crate::advance::State;
use crate::advance::index::{EXTENSION, GAS, LEAN, RATE, SPEED, TIME};
use crate::pendulum::Pendulum;

/// Error tolerance at which every result is right to at least ten digits.
pub const FINE: f64 = 1e-12;

/// A robot on one foot: the wheel's centre at distance R = r_s + d from the foot, at lean φ.
///
/// φ̈ = m R (g sin φ − 2 φ̇ ḋ)/(I + m R²) and d̈ = F/m + φ̇² R − g cos φ.
///
/// With a boom, m and g are the mass and the gravity at the axle.
///
/// Source: thesis §5.2.1, with the lean φ = π/2 − α.
#[derive(Clone, Debug)]
pub struct Stance<S> {
    /// m (kg): the robot's, with what the boom adds at the axle.
    pub mass: S,
    /// I (kg m²).
    pub inertia: S,
    /// r_s (m).
    pub radius: S,
    /// g (m/s²), at the axle.
    pub gravity: S,
    /// The leg.
    pub leg: Leg<S>,
    /// Error tolerance of a step, relative to 1 + |state| with the pressure in MPa.
    pub tolerance: f64,
    /// P_a (Pa).
    pub(crate) ambient: S,
    pub(crate) inverse_mass: S,
    pub(crate) pendulum: Pendulum<S>,
    /// The leg is a pneumatic one without optional terms.
    pub(crate) plain: bool,
}

/// Inertia about the foot.
pub(crate) struct AboutFoot<S> {
    /// R (m).
    reach: S,
    /// m R (kg m).
    lever: S,
    /// I + m R² (kg m²).
    inertia: S,
}

impl<S: Scalar> AboutFoot<S> {
    pub(crate) fn inverse(&self) -> Pivoting<S> {
        Pivoting {
            reach: self.reach,
            lever: self.lever / self.inertia,
        }
    }
}

/// What the pivoting of an extending leg depends on.
#[derive(Clone, Copy)]
pub(crate) struct Pivoting<S> {
    /// R (m).
    reach: S,
    /// m R/(I + m R²) (1/m).
    lever: S,
}

/// The force of the ground on the foot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reaction<S> {
    /// Normal force (N), upwards.
    pub normal: S,
    /// Friction force (N), forwards.
    pub friction: S,
}

impl<S: Single> Stance<S> {
    /// The model of `robot`; `lift` turns each term's value into a number of the wanted kind:
    /// `|_, x| x` for plain numbers, a [`Dual`](saltus_numeric::Dual) variable for those to
    /// differentiate by.
    pub fn new(robot: &Robot, lift: impl Fn(Term, f64) -> S + Copy) -> Stance<S> {
        let mut stance = Stance::assemble(robot, lift);
        stance.plain = stance.leg.is_plain();
        stance
    }
}

impl<S: Scalar> Stance<S> {
    /// The model with nothing decided yet that takes a look at a number.
    pub(crate) fn assemble(robot: &Robot, lift: impl Fn(Term, f64) -> S + Copy) -> Stance<S> {
        let inertia = lift(Term::Inertia, robot.body.inertia);
        let radius = lift(Term::Radius, robot.body.radius);
        let (mass, gravity) = robot.at_axle(lift);
        Stance {
            mass,
            inertia,
            radius,
            gravity,
            leg: Leg::new(robot, lift),
            tolerance: FINE,
            ambient: lift(Term::Ambient, robot.environment.ambient.0),
            inverse_mass: S::of(1.0) / mass,
            pendulum: Pendulum::new(mass, inertia, radius, gravity),
            plain: true,
        }
    }

    /// The same model with another error tolerance.
    #[must_use]
    pub fn with_tolerance(mut self, tolerance: f64) -> Self {
        self.tolerance = tolerance;
        self
    }

    /// The robot's inertia about the foot.
    #[inline(always)]
    pub(crate) fn about_foot<const N: usize>(&self, y: &[S; N]) -> AboutFoot<S> {
        let reach = self.radius + y[EXTENSION];
        let lever = self.mass * reach;
        AboutFoot {
            reach,
            lever,
            inertia: lever.mul_add(reach, self.inertia),
        }
    }

    /// The gas in the chamber, with the robot's inertia about the foot; their divisions are one.
    #[inline(always)]
    pub(crate) fn gas<const N: usize>(
        &self,
        y: &[S; N],
        chamber: &Chamber<S>,
        valve: &Valve<S>,
    ) -> (GasState<S>, Pivoting<S>) {
        let about = self.about_foot(y);
        let gas = chamber.gas(valve, y[GAS], y[EXTENSION], y[SPEED], about.inertia);
        (
            gas,
            Pivoting {
                reach: about.reach,
                lever: about.lever * gas.inverses.0,
            },
        )
    }

    /// Derivative in time of a state while the leg extends under `force` (N), the gas left out.
    #[inline(always)]
    pub(crate) fn motion<const N: usize>(
        &self,
        y: &[S; N],
        force: S,
        about: Pivoting<S>,
    ) -> [S; N] {
        let Pivoting { reach, lever } = about;
        let (sin, cos) = y[LEAN].sin_cos();
        let (rate, speed) = (y[RATE], y[SPEED]);
        let mut dy = [S::of(0.0); N];
        dy[LEAN] = rate;
        dy[RATE] = lever * self.gravity.mul_add(sin, -((rate + rate) * speed));
        dy[EXTENSION] = speed;
        dy[SPEED] = force.mul_add(
            self.inverse_mass,
            (rate * rate).mul_add(reach, -(self.gravity * cos)),
        );
        dy[TIME] = S::of(1.0);
        dy
    }

    /// The ground's reaction where the state `y` changes at the rates `dy`: m times the centre's
    /// acceleration, with the weight.
    pub(crate) fn reaction<const N: usize>(&self, y: &[S; N], dy: &[S; N]) -> Reaction<S> {
        let (sin, cos) = y[LEAN].sin_cos();
        let reach = self.radius + y[EXTENSION];
        let (rate, speed) = (y[RATE], y[SPEED]);
        let axial = dy[SPEED] - reach * rate * rate;
        let across = reach * dy[RATE] + S::of(2.0) * speed * rate;
        Reaction {
            normal: self.mass * (axial * cos - across * sin + self.gravity),
            friction: self.mass * (axial * sin + across * cos),
        }
    }

    /// Kinetic and potential energy (J) of a state; the height counts from the foot.
    pub(crate) fn energy(&self, y: &State<S>) -> (S, S) {
        let reach = self.radius + y[EXTENSION];
        let about_foot = self.inertia + self.mass * reach * reach;
        let (_, cos) = y[LEAN].sin_cos();
        let half = S::of(0.5);
        (
            half * about_foot * y[RATE] * y[RATE] + half * self.mass * y[SPEED] * y[SPEED],
            self.mass * self.gravity * reach * cos,
        )
    }
}

/// Whether a stance can be given `launch`.
pub(crate) fn check<S: Single>(launch: &Launch<S>) -> Result<(), StanceError> {
    let angle = "a finite angle strictly between -pi/2 and pi/2 rad";
    let is_upright = |x: f64| x.abs() < std::f64::consts::FRAC_PI_2;
    let is_moderate = |x: f64| (0.0..=1e3).contains(&x);
    let numbers = [
        launch.rate,
        launch.lean,
        launch.firing_angle,
        launch.valve_open,
    ];
    let [rate, lean, firing_angle, open] = numbers.map(S::value);
    let wrong = refused! {
        "approach rate (rad/s)", rate, is_moderate(rate) => "from 0 to 1000 rad/s";
        "start lean (rad)", lean, is_upright(lean) => angle;
        "firing angle (rad)", firing_angle, is_upright(firing_angle) => angle;
        "valve opening time (s)", open, is_moderate(open) => "from 0 to 1000 s";
    };
    wrong.map_or(Ok(()), |(name, value, allowed)| {
        Err(StanceError::Input {
            name,
            value,
            allowed,
        })
    })
}
