//! The planar model as a [`JumpModel`]: the stance of `lagrangian`, the flight of `ballistic`.

use saltus_ballistic::{DragFlight, Flight};
use saltus_lagrangian::{
    Batch, Drawn, Launch, LiftOff, Outcome, Sample, Stance, StanceError, TankState,
};
use saltus_numeric::{Dual, Scalar, Single};
use saltus_robot::{Robot, Term};

use crate::course::Slope;
use crate::flight::JumpFlight;
use crate::jump::Jump;
use crate::model::{Instant, JumpModel, Steered, Traced, spare_of, widen};

/// Error tolerance of the planner's stances: apex and landing are then right to nine digits
/// (`bench/README.md` says how it is measured).
pub const PLANNING_TOLERANCE: f64 = 2e-9;

/// What that comes to (m).
const ACCURACY: f64 = 2e-9;

/// Error tolerance of the stances while searching: lengths are then right to some ten nanometres,
/// well within what the check of the finished plan allows.
const SEARCH_TOLERANCE: f64 = 2e-8;

/// The planar model of a robot.
#[derive(Clone, Debug)]
pub struct Planar {
    robot: Robot,
    batch: Batch,
    /// With the supply pressure as direction 3 of its derivatives.
    sensitive: Stance<Dual<4>>,
    steered: Stance<Dual<2>>,
}

impl Planar {
    /// Of `robot`.
    pub fn new(robot: Robot) -> Planar {
        let by_supply = |term, value| match term {
            Term::Supply => Dual::variable(value, 3),
            _ => Dual::of(value),
        };
        Planar {
            batch: Batch::new(&robot, PLANNING_TOLERANCE),
            sensitive: Stance::new(&robot, by_supply).with_tolerance(PLANNING_TOLERANCE),
            steered: Stance::new(&robot, |_: Term, x: f64| Dual::of(x))
                .with_tolerance(SEARCH_TOLERANCE),
            robot,
        }
    }

    /// The robot's stance.
    pub fn stance(&self) -> &Stance<f64> {
        self.batch.stance()
    }

    /// One jump with the derivatives that its launch has; direction 3 is the supply pressure.
    pub(crate) fn with_derivatives(
        &self,
        launch: Launch<Dual<4>>,
    ) -> Result<Jump<Dual<4>>, StanceError> {
        Ok(self.fly(launch, self.sensitive.jump(&launch)?))
    }

    /// One jump with the tank as it is, and what it takes from it; none for a robot that does not carry
    /// its gas.
    pub(crate) fn jump_from(
        &self,
        launch: &Launch,
        tank: &TankState,
    ) -> Result<Option<(Jump, Drawn)>, StanceError> {
        let drawn = self.stance().jump_from(launch, tank)?;
        Ok(drawn.map(|(end, drawn)| (self.fly(*launch, end), drawn)))
    }

    /// The jump whose stance ends so.
    fn fly<S: Single>(&self, launch: Launch<S>, stance: LiftOff<S>) -> Jump<S> {
        let flight = flight_after(&self.robot, &stance).map(JumpFlight::Exact);
        Jump {
            launch,
            stance,
            flight,
        }
    }

    /// The wheel's centre in a sample of a stance.
    fn instant<S: Single>(&self, s: &Sample<S>) -> Instant<S> {
        let (sin, cos) = s.lean.sin_cos();
        let reach = S::of(self.robot.body.radius) + s.extension;
        let across = reach * s.rate;
        Instant {
            time: s.time,
            centre: [reach * sin, reach * cos],
            velocity: [
                s.extension_rate * sin + across * cos,
                s.extension_rate * cos - across * sin,
            ],
        }
    }
}

/// The flight of `robot` after a stance that ended so; none where it does not lift off.
pub fn flight_after<S: Single>(robot: &Robot, stance: &LiftOff<S>) -> Option<DragFlight<S>> {
    if !stance.outcome.is_jump() {
        return None;
    }
    let ([x, y], [vx, vy]) = (stance.axle, picked_up(robot, stance));
    Some(DragFlight {
        vacuum: Flight {
            x,
            y,
            vx,
            vy,
            gravity: S::of(robot.axle_gravity()),
        },
        drag: S::of(robot.environment.drag),
    })
}

/// Velocity (m/s) of the wheel's centre as the robot has picked up its leg. Until then the leg
/// pushed M − m with the work that the stance has given to M, so that M has √(1 − m/M) of the
/// stance's speed along the leg (docs/model.md, "The mass of the leg").
fn picked_up<S: Scalar>(robot: &Robot, stance: &LiftOff<S>) -> [S; 2] {
    let picked_up = robot.leg.picked_up;
    // A leg without force is dragged along, and nothing hits its stop on the ground.
    if picked_up == 0.0 || stance.outcome != Outcome::Stroke {
        return stance.axle_rates;
    }
    let lost = 1.0 - (1.0 - picked_up / robot.axle_mass()).sqrt();
    let along = stance.extension_rate * S::of(lost);
    let (sin, cos) = stance.lean.sin_cos();
    let [vx, vy] = stance.axle_rates;
    [vx - along * sin, vy - along * cos]
}

impl JumpModel for Planar {
    fn robot(&self) -> &Robot {
        &self.robot
    }

    fn accuracy(&self) -> f64 {
        ACCURACY
    }

    fn jump(&self, launch: &Launch) -> Result<Jump, StanceError> {
        Ok(self.fly(*launch, self.stance().jump(launch)?))
    }

    fn jumps(&self, launches: &[Launch]) -> Vec<Result<Jump, StanceError>> {
        let ends = self.batch.jumps(launches).into_iter();
        ends.zip(launches)
            .map(|(end, launch)| Ok(self.fly(*launch, end?)))
            .collect()
    }

    fn sensitive_jump(&self, launch: &Launch) -> Result<Jump<Dual<4>>, StanceError> {
        self.with_derivatives(launch.variables())
    }

    /// Every phase is stepped through, closed forms left aside.
    fn traced(&self, launch: &Launch) -> Result<Traced, StanceError> {
        let trace = self.stance().trace(launch)?;
        Ok(Traced {
            jump: self.fly(*launch, trace.lift_off),
            way: trace.samples.iter().map(|s| self.instant(s)).collect(),
            friction_needed: trace.contact.friction_needed,
        })
    }

    fn steered(&self, launch: &Launch<Dual<2>>, with_friction: bool) -> Option<Steered> {
        let (end, friction) = if with_friction {
            let (end, contact) = self.steered.contact(launch).ok()?;
            (end, Some(contact.friction_needed))
        } else {
            (self.steered.jump(launch).ok()?, None)
        };
        let DragFlight { vacuum, drag } = flight_after(&self.robot, &end)?;
        let flight = DragFlight {
            vacuum: Flight {
                x: widen(vacuum.x),
                y: widen(vacuum.y),
                vx: widen(vacuum.vx),
                vy: widen(vacuum.vy),
                gravity: widen(vacuum.gravity),
            },
            drag: widen(drag),
        };
        Some(Steered {
            axle: end.axle.map(widen),
            extension: widen(end.extension),
            flight: JumpFlight::Exact(flight),
            friction_needed: friction.map(widen),
            spare: widen(spare_of(&self.robot.leg, launch.valve_open, &end)),
        })
    }

    fn steered_way(&self, launch: &Launch<Dual<2>>) -> Option<Vec<Instant<Slope>>> {
        let wide = |at: Instant<Dual<2>>| Instant {
            time: widen(at.time),
            centre: at.centre.map(widen),
            velocity: at.velocity.map(widen),
        };
        let samples = self.steered.way(launch).ok()?;
        Some(samples.iter().map(|s| wide(self.instant(s))).collect())
    }
}
