//! One jump, from the approach to the landing: stance and flight together.

use saltus_ballistic::{DragFlight, Flight, FlightError};
use saltus_lagrangian::{Batch, Launch, LiftOff, Stance, StanceError};
use saltus_numeric::{Dual, Single};
use saltus_robot::{Robot, Term};

/// Error tolerance of the planner's stances: apex and landing are then right to nine digits
/// (`bench/README.md` says how it is measured).
pub const PLANNING_TOLERANCE: f64 = 2e-9;

/// A robot, ready to plan its jumps.
#[derive(Clone, Debug)]
pub struct Planner {
    robot: Robot,
    batch: Batch,
}

/// A jump: the end of its stance, and the flight that follows a lift-off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jump<S = f64> {
    /// What it was given.
    pub launch: Launch<S>,
    /// How the stance ended.
    pub stance: LiftOff<S>,
    /// The flight of the wheel's centre, from the foot at (0, 0); none where the robot does not
    /// lift off.
    pub flight: Option<DragFlight<S>>,
}

impl<S: Single> Jump<S> {
    pub(crate) fn new(launch: Launch<S>, stance: LiftOff<S>, gravity: S, drag: S) -> Jump<S> {
        let flight = stance.outcome.is_jump().then(|| {
            let ([x, y], [vx, vy]) = (stance.axle, stance.axle_rates);
            DragFlight {
                vacuum: Flight {
                    x,
                    y,
                    vx,
                    vy,
                    gravity,
                },
                drag,
            }
        });
        Jump {
            launch,
            stance,
            flight,
        }
    }

    /// Greatest height (m) of the wheel's centre above the ground; none without a flight.
    pub fn apex(&self) -> Option<S> {
        self.flight.map(|f| f.apex_height())
    }

    /// Distance (m) from the foot to where the wheel's centre comes down to `height` (m); none
    /// where it never does.
    pub fn distance(&self, height: f64) -> Option<S> {
        self.flight
            .and_then(|f| f.range_to_height(S::of(height)).ok())
    }

    /// As [`distance`](Self::distance), with the reason where there is none.
    ///
    /// # Errors
    /// As [`DragFlight::range_to_height`]; none where there is no flight.
    pub fn landing(&self, height: f64) -> Option<Result<S, FlightError>> {
        self.flight.map(|f| f.range_to_height(S::of(height)))
    }
}

/// A jump with its derivatives by approach rate, firing angle, valve opening time and supply
/// pressure, in this order.
pub type SensitiveJump = Jump<Dual<4>>;

/// How a jump's result changes with what is measured and commanded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensitivity {
    /// The result (m).
    pub value: f64,
    /// By the approach rate ω (m s/rad).
    pub by_rate: f64,
    /// By the firing angle α_f (m/rad).
    pub by_firing_angle: f64,
    /// By the valve opening time t_v (m/s).
    pub by_valve_open: f64,
    /// By the supply pressure P_s (m/Pa).
    pub by_supply: f64,
}

impl Sensitivity {
    /// From a number with its derivatives.
    pub fn new(x: Dual<4>) -> Sensitivity {
        let [by_rate, by_firing_angle, by_valve_open, by_supply] = x.slope;
        Sensitivity {
            value: x.value,
            by_rate,
            by_firing_angle,
            by_valve_open,
            by_supply,
        }
    }

    /// Standard deviation of the result for independent `errors`, to first order.
    pub fn standard_deviation(&self, errors: &saltus_robot::Errors) -> f64 {
        let parts = [
            self.by_rate * errors.rate,
            self.by_firing_angle * errors.firing_angle,
            self.by_valve_open * errors.valve_open,
            self.by_supply * errors.supply,
        ];
        parts.iter().map(|p| p * p).sum::<f64>().sqrt()
    }
}

impl Planner {
    /// A planner for `robot`.
    pub fn new(robot: Robot) -> Planner {
        let batch = Batch::new(&robot, PLANNING_TOLERANCE);
        Planner { robot, batch }
    }

    /// The robot.
    pub fn robot(&self) -> &Robot {
        &self.robot
    }

    /// The robot's stance.
    pub fn stance(&self) -> &Stance<f64> {
        self.batch.stance()
    }

    /// c = m g r_s/(I + m r_s²) (1/s²): on a retracted leg a lean φ accelerates by c sin φ.
    ///
    /// Source: docs/model.md, Stance.
    pub fn pendulum(&self) -> f64 {
        let (mass, radius) = (self.robot.axle_mass(), self.robot.body.radius);
        mass * self.robot.axle_gravity() * radius
            / (self.robot.body.inertia + mass * radius * radius)
    }

    /// The rate (rad/s) at the lean `to` (rad) of a robot that pivots on its retracted leg with
    /// `rate` at the lean `from`; 0 where it does not get there.
    ///
    /// √(ω² + 2 c (cos from − cos to)).
    pub fn pivoted(&self, rate: f64, from: f64, to: f64) -> f64 {
        (rate * rate + 2.0 * self.pendulum() * (from.cos() - to.cos()))
            .max(0.0)
            .sqrt()
    }

    /// One jump.
    ///
    /// # Errors
    /// As [`Stance::jump`].
    pub fn jump(&self, launch: &Launch) -> Result<Jump, StanceError> {
        Ok(self.fly(launch, self.stance().jump(launch)?))
    }

    /// Many jumps, several side by side.
    ///
    /// # Errors
    /// Each as [`Stance::jump`].
    pub fn jumps(&self, launches: &[Launch]) -> Vec<Result<Jump, StanceError>> {
        let ends = self.batch.jumps(launches);
        ends.into_iter()
            .zip(launches)
            .map(|(end, launch)| Ok(self.fly(launch, end?)))
            .collect()
    }

    fn fly(&self, launch: &Launch, end: LiftOff) -> Jump {
        Jump::new(
            *launch,
            end,
            self.robot.axle_gravity(),
            self.robot.environment.drag,
        )
    }

    /// The stance with the supply pressure as the direction `3` of its derivatives.
    pub fn sensitive_stance(&self) -> Stance<Dual<4>> {
        let lift = |parameter, value| match parameter {
            Term::Supply => Dual::variable(value, 3),
            _ => saltus_numeric::Scalar::of(value),
        };
        Stance::new(&self.robot, lift).with_tolerance(self.stance().tolerance)
    }

    /// One jump with its derivatives by ω, α_f, t_v and P_s; a stance that starts at its firing
    /// angle keeps doing so when that angle changes. `stance` is [`Planner::sensitive_stance`].
    ///
    /// # Errors
    /// As [`Stance::jump`].
    pub fn sensitive_jump(
        &self,
        stance: &Stance<Dual<4>>,
        launch: &Launch,
    ) -> Result<SensitiveJump, StanceError> {
        use saltus_numeric::Scalar;
        let firing_angle = Dual::variable(launch.firing_angle, 1);
        let starts_at_firing = launch.lean == launch.firing_angle;
        let launch = Launch {
            rate: Dual::variable(launch.rate, 0),
            lean: if starts_at_firing {
                firing_angle
            } else {
                Dual::of(launch.lean)
            },
            firing_angle,
            valve_open: Dual::variable(launch.valve_open, 2),
        };
        let end = stance.jump(&launch)?;
        let (gravity, drag) = (self.robot.axle_gravity(), self.robot.environment.drag);
        Ok(Jump::new(launch, end, Dual::of(gravity), Dual::of(drag)))
    }
}
