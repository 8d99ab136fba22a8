//! The firing decision.

use crate::map::LiftOffMap;
use crate::qp::{self, HalfLine, HalfPlane};
use crate::timing::{Timing, time_to};
use crate::{Axis, FiringCurve, FiringTable, LiftOff, Linear, Rates, Real, Reason};

/// What a robot decides by: the tables that `saltus export` writes, and how it is run.
#[derive(Clone, Copy, Debug)]
pub struct Controller<'a, R> {
    /// Firing angles for distances.
    pub rule: Rule<'a, R>,
    /// What a firing angle leads to.
    pub map: LiftOffMap<'a, R>,
    /// What an approach rate is.
    pub rates: Rates<R>,
    /// The robot.
    pub robot: Robot<R>,
    /// What may be decided.
    pub limits: Limits<R>,
}

/// Where firing angles come from.
#[derive(Clone, Copy, Debug)]
pub enum Rule<'a, R> {
    /// A table over approach rate and distance.
    Table(FiringTable<'a, R>),
    /// A curve over approach rate, for one distance.
    Curve(FiringCurve<'a, R>),
}

impl<R: Real> Rule<'_, R> {
    /// The approach rates of its nodes, and how many cells lie between them; cells that are not
    /// there do not count.
    pub(crate) fn cells(&self) -> (&Axis<R>, usize) {
        let (axis, open) = match self {
            Rule::Table(table) => (&table.rates, table.open.len()),
            Rule::Curve(curve) => (&curve.rates, curve.open.len()),
        };
        (axis, axis.count.saturating_sub(1).min(open))
    }

    /// α_f (rad) for `distance` (m) at both ends of the cell `cell` of rates; none where it is
    /// closed.
    pub(crate) fn ends(&self, cell: usize, distance: R) -> Result<Option<[R; 2]>, Reason> {
        match self {
            Rule::Table(table) => table.ends(cell, distance),
            Rule::Curve(curve) => curve.ends(cell, distance),
        }
    }
}

/// A robot's constants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Robot<R> {
    /// Foot to wheel centre with the leg retracted, r_s (m).
    pub radius: R,
    /// Gravity at the axle, g (m/s²).
    pub gravity: R,
    /// c = m g r_s/(I + m r_s²) (1/s²): on a retracted leg a lean φ accelerates by c sin φ.
    pub pendulum: R,
    /// Way (m) from one touch-down to the next when it rolls: 2 r_s sin(π/legs).
    pub stride: R,
    /// Valve opening time t_v (s) for which tables and map hold.
    pub valve_open: R,
    /// Height (m) of the wheel's centre above the foot at a landing, for which the firing angles
    /// hold.
    pub landing_height: R,
}

/// What may be decided, and how finely.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits<R> {
    /// Control period (s).
    pub period: R,
    /// By how much the valve answers later than the robot file's (s): it is commanded that much
    /// sooner.
    pub extra_delay: R,
    /// Newton steps that refine a firing angle by the lift-off map, 0 to 3; more count as 3.
    pub newton_steps: u8,
    /// Least valve opening time (s) that may be chosen over an obstacle; with the next equal to it,
    /// only the angle is.
    pub least_valve_open: R,
    /// Greatest valve opening time (s) that may be.
    pub greatest_valve_open: R,
    /// Cost of a squared second of open valve, a squared metre off the distance costing 1 (m²/s²),
    /// > 0.
    pub effort: R,
}

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensed<R> {
    /// Lean of the loaded leg from the upright (rad), forward positive.
    pub lean: R,
    /// Its rate (rad/s).
    pub rate: R,
}

/// What is wanted of a jump.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Task<R> {
    /// Distance (m) from the foot to where the wheel's centre comes down to the landing height.
    pub distance: R,
    /// That height (m) above the foot.
    pub landing_height: R,
    /// What is to be cleared on the way.
    pub obstacle: Option<Obstacle<R>>,
    /// Over an obstacle: what to start from, the last decision on the same jump; none: the firing
    /// angle for the distance.
    pub guess: Option<Guess<R>>,
}

/// What a decision over an obstacle starts from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Guess<R> {
    /// Firing angle α_f (rad).
    pub firing_angle: R,
    /// Valve opening time t_v (s).
    pub valve_open: R,
}

/// A box on the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Obstacle<R> {
    /// From the foot to its front (m).
    pub front: R,
    /// From the foot to its back (m).
    pub back: R,
    /// Its height (m).
    pub height: R,
    /// Least distance to keep (m) between the wheel and it, ≥ 0.
    pub clearance: R,
}

/// A firing decision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision<R> {
    /// Approach rate (rad/s), counted where [`Rates`] says: at the firing angle, or at the start
    /// lean.
    pub approach_rate: R,
    /// Firing angle α_f (rad).
    pub firing_angle: R,
    /// Valve opening time t_v (s).
    pub valve_open: R,
    /// When to command the valve.
    pub timing: Timing<R>,
    /// Whether it is final: by the lift-off map the jump clears what it should. If not, the next
    /// decision may be, with this one for its guess.
    pub settled: bool,
}

/// How far a step over an obstacle may go (rad): the map is nearly linear over it.
const TRUST: f64 = 0.125;
/// How far (m) inside what is asked a jump over an obstacle counts as clear, and how far apart two
/// count as one.
const MISS: f64 = 0.002;
/// How far (rad) round-off may take a firing angle of the program beyond its bounds.
const ANGLE_SLACK: f64 = 1e-4;
/// How far (s) round-off may take a valve opening time of the program beyond its bounds.
const VALVE_SLACK: f64 = 1e-5;

impl<R: Real> Controller<'_, R> {
    /// What to do now: whether and when to open the valve, and how long for.
    ///
    /// Over an obstacle, one quadratic program about the guess is solved at each call. With the
    /// last decision for a guess the next goes on from there, until they agree and the map says
    /// that the jump is clear: then it is settled, mostly at the second or third.
    ///
    /// Source: Diehl, Bock and Schlöder, A real-time iteration scheme for nonlinear optimization in
    /// optimal feedback control, SIAM J. Control Optim. 43 (2005).
    ///
    /// # Errors
    /// [`Reason::SensorInvalid`] for what is no measurement or no task; [`Reason::OutOfTable`]
    /// where tables or map do not reach; [`Reason::Infeasible`] where no jump does what is asked,
    /// or the robot comes to rest before its firing angle.
    #[inline]
    pub fn decide(&self, sensed: &Sensed<R>, task: &Task<R>) -> Result<Decision<R>, Reason> {
        let rate = self.rate_at(sensed, self.rates.reference_lean)?;
        let (guess, settled) = match &task.obstacle {
            None => {
                let angle = self.angle_at_reference(rate, task.distance, task.landing_height)?;
                (
                    Guess {
                        firing_angle: angle,
                        valve_open: self.robot.valve_open,
                    },
                    true,
                )
            }
            Some(obstacle) => self.over(rate, task, obstacle)?,
        };
        let Guess {
            firing_angle,
            valve_open,
        } = guess;
        let timing = self.timing(sensed, firing_angle)?;
        let approach_rate = if self.rates.at_firing {
            self.rate_at(sensed, firing_angle)?
        } else {
            rate
        };
        Ok(Decision {
            approach_rate,
            firing_angle,
            valve_open,
            timing,
            settled,
        })
    }

    /// α_f (rad) for an approach `rate` (rad/s), a `distance` (m) and a landing `height` (m), by
    /// the rule and as many Newton steps on the lift-off map as asked for.
    ///
    /// For plans and tests: where rates count at the firing angle, it looks for the angle that has
    /// this rate, which takes tens of times as long as a look-up. [`decide`](Self::decide) does not
    /// need it.
    ///
    /// # Errors
    /// As [`FiringTable::firing_angle`]. Another landing height than the table's is
    /// [`Reason::OutOfTable`] without Newton steps.
    #[inline]
    pub fn firing_angle(&self, rate: R, distance: R, height: R) -> Result<R, Reason> {
        if self.rates.at_firing {
            self.angle_at_firing(rate, distance, height)
        } else {
            self.angle_at_reference(rate, distance, height)
        }
    }

    /// The same, for a rate (rad/s) at the reference lean.
    #[inline]
    pub(crate) fn angle_at_reference(&self, rate: R, distance: R, height: R) -> Result<R, Reason> {
        if !height.is_finite() {
            return Err(Reason::SensorInvalid);
        }
        let mut angle = self.look_up(rate, distance)?;
        let steps = self.limits.newton_steps;
        if steps == 0 {
            return if height == self.robot.landing_height {
                Ok(angle)
            } else {
                Err(Reason::OutOfTable)
            };
        }
        let mut step = R::ZERO;
        for _ in 0..if steps > 3 { 3 } else { steps } {
            let landing = self
                .map
                .at(rate, angle)?
                .landing(self.robot.gravity, height)?;
            if !landing.by_angle.is_positive() {
                return Err(Reason::Infeasible);
            }
            step = (distance - landing.value) / landing.by_angle;
            angle = angle + step;
        }
        // The next step is smaller than the square of the last, which for the last must be small
        // itself.
        let settled = step.within(-R::of(TRUST), R::of(TRUST));
        if !settled {
            return Err(Reason::Infeasible);
        }
        if angle.within(self.map.angles.first, self.map.angles.last) {
            Ok(angle)
        } else {
            Err(Reason::OutOfTable)
        }
    }

    /// When to command the valve of a robot that is to be fired at `angle` (rad).
    ///
    /// # Errors
    /// [`Reason::Infeasible`] if it comes to rest before; [`Reason::SensorInvalid`] for numbers
    /// that are not finite.
    #[inline]
    pub fn timing(&self, sensed: &Sensed<R>, angle: R) -> Result<Timing<R>, Reason> {
        let time = time_to(sensed.lean, sensed.rate, self.robot.pendulum, angle)?
            - self.limits.extra_delay;
        if !time.is_finite() {
            return Err(Reason::SensorInvalid);
        }
        Ok(if time < R::ZERO {
            Timing::Late(-time)
        } else if time < self.limits.period {
            Timing::Fire(time)
        } else {
            Timing::Wait(time)
        })
    }

    /// What table or law says.
    #[inline]
    fn look_up(&self, rate: R, distance: R) -> Result<R, Reason> {
        match &self.rule {
            Rule::Table(table) => table.firing_angle(rate, distance),
            Rule::Curve(curve) => curve.firing_angle(rate, distance),
        }
    }

    /// Firing angle (rad) and valve opening time (s) nearest to the wanted distance that clear
    /// `obstacle`, to first order about the guess; and whether the guess clears it and they are no
    /// other jump than it.
    #[inline]
    fn over(
        &self,
        rate: R,
        task: &Task<R>,
        obstacle: &Obstacle<R>,
    ) -> Result<(Guess<R>, bool), Reason> {
        let Obstacle {
            front,
            back,
            height,
            clearance,
        } = *obstacle;
        let finite =
            front.is_finite() && back.is_finite() && height.is_finite() && clearance.is_finite();
        if !(finite && front < back && height.is_at_least_zero() && clearance.is_at_least_zero()) {
            return Err(Reason::SensorInvalid);
        }
        if !(task.distance.is_finite() && task.landing_height.is_finite()) {
            return Err(Reason::SensorInvalid);
        }
        let guess = if let Some(guess) = task.guess {
            guess
        } else {
            let angle = self.look_up(rate, task.distance)?;
            Guess {
                firing_angle: angle,
                valve_open: self.robot.valve_open,
            }
        };
        let Limits {
            least_valve_open,
            greatest_valve_open,
            ..
        } = self.limits;
        if !guess
            .valve_open
            .within(least_valve_open, greatest_valve_open)
        {
            return Err(if guess.valve_open.is_finite() {
                Reason::OutOfTable
            } else {
                Reason::SensorInvalid
            });
        }
        let lengths = self.lengths(rate, guess, task, obstacle)?;
        let (da, dv) = self.step(guess, task.distance, lengths, obstacle)?;
        let (firing_angle, valve_open) = (guess.firing_angle + da, guess.valve_open + dv);
        // Lengths that are too great for the numbers of the program leave its bounds to round-off.
        let (angles, angle_slack, valve_slack) =
            (&self.map.angles, R::of(ANGLE_SLACK), R::of(VALVE_SLACK));
        if !(firing_angle.within(angles.first - angle_slack, angles.last + angle_slack)
            && valve_open.within(
                least_valve_open - valve_slack,
                greatest_valve_open + valve_slack,
            ))
        {
            return Err(Reason::Infeasible);
        }
        let [landing, first, second] = lengths;
        let miss = R::of(MISS);
        let least = clearance - miss;
        let clears = first.value >= least && second.value >= least && landing.value >= back - miss;
        let settled = clears
            && (da * landing.by_angle).within(-miss, miss)
            && (dv * landing.by_valve).within(-miss, miss);
        Ok((
            Guess {
                firing_angle,
                valve_open,
            },
            settled,
        ))
    }

    /// Landing, and the wheel's clearances over the front and the back corner (m).
    #[inline]
    fn lengths(
        &self,
        rate: R,
        at: Guess<R>,
        task: &Task<R>,
        obstacle: &Obstacle<R>,
    ) -> Result<[Linear<R>; 3], Reason> {
        let g = self.robot.gravity;
        let lift_off = shifted(
            &self.map.at(rate, at.firing_angle)?,
            at.valve_open - self.robot.valve_open,
        );
        let landing = lift_off.landing(g, task.landing_height)?;
        let [front, back] = lift_off
            .distances_to(g, [obstacle.front, obstacle.back], obstacle.height)
            .map(|distance| Linear {
                value: distance.value - self.robot.radius,
                ..distance
            });
        Ok([landing, front, back])
    }

    /// The QP's step in firing angle (rad) and valve opening time (s).
    #[inline]
    fn step(
        &self,
        guess: Guess<R>,
        distance: R,
        [landing, first, second]: [Linear<R>; 3],
        obstacle: &Obstacle<R>,
    ) -> Result<(R, R), Reason> {
        let (trust, axis, angle) = (R::of(TRUST), &self.map.angles, guess.firing_angle);
        let high = trust.lesser(axis.last - angle);
        let low = (-trust).greater(axis.first - angle);
        let near = Near {
            low,
            high,
            off: landing.value - distance,
            beyond: landing.value - obstacle.back,
            over: [first, second].map(|over| over.value - obstacle.clearance),
            lines: [landing, first, second],
        };
        if self.limits.greatest_valve_open > self.limits.least_valve_open {
            near.step_of_both(&self.limits, guess.valve_open)
        } else {
            Ok((near.step_of_angle()?, R::ZERO))
        }
    }
}

/// The quadratic program near a guess.
struct Near<R> {
    /// Bounds of the step in firing angle (rad).
    low: R,
    high: R,
    /// How far (m) the landing is beyond the one wanted, and beyond the obstacle's back.
    off: R,
    beyond: R,
    /// Clearance (m) over both edges, beyond what is asked.
    over: [R; 2],
    /// The landing, and the clearances over both edges.
    lines: [Linear<R>; 3],
}

impl<R: Real> Near<R> {
    /// For a robot that does not choose its valve opening time.
    #[inline]
    fn step_of_angle(&self) -> Result<R, Reason> {
        let [landing, first, second] = &self.lines;
        let line = |slope: R, bound: R| HalfLine { slope, bound };
        let constraints = [
            line(R::ONE, self.high),
            line(-R::ONE, -self.low),
            line(-first.by_angle, self.over[0]),
            line(-second.by_angle, self.over[1]),
            line(-landing.by_angle, self.beyond),
        ];
        let j = landing.by_angle;
        qp::one(j * j, j * self.off, &constraints)
    }

    /// For one that chooses both.
    #[inline]
    fn step_of_both(&self, limits: &Limits<R>, valve_open: R) -> Result<(R, R), Reason> {
        let [landing, first, second] = &self.lines;
        let plane = |normal: [R; 2], bound: R| HalfPlane { normal, bound };
        let over = |l: &Linear<R>, bound: R| plane([-l.by_angle, -l.by_valve], bound);
        let shorter = valve_open - limits.least_valve_open;
        let longer = limits.greatest_valve_open - valve_open;
        // Bounds first: what is violated later is cut by all before it.
        let constraints = [
            plane([R::ZERO, -R::ONE], shorter),
            plane([R::ZERO, R::ONE], longer),
            plane([-R::ONE, R::ZERO], -self.low),
            plane([R::ONE, R::ZERO], self.high),
            over(first, self.over[0]),
            over(second, self.over[1]),
            over(landing, self.beyond),
        ];
        let (j, k, effort) = (landing.by_angle, landing.by_valve, limits.effort);
        let h = [j * j, j * k, k * k + effort];
        let g = [j * self.off, k * self.off + effort * valve_open];
        let [da, dv] = qp::two(h, g, &constraints)?;
        Ok((da, dv))
    }
}

/// A lift-off with the valve open for `more` seconds than the map's, to first order.
#[inline]
fn shifted<R: Real>(lift_off: &LiftOff<R>, more: R) -> LiftOff<R> {
    let LiftOff {
        state: [x, y, vx, vy],
        by_angle,
        by_valve,
    } = *lift_off;
    let [dx, dy, dvx, dvy] = by_valve;
    LiftOff {
        state: [
            x + more * dx,
            y + more * dy,
            vx + more * dvx,
            vy + more * dvy,
        ],
        by_angle,
        by_valve,
    }
}
