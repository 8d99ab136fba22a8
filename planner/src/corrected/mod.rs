//! The planar model, corrected by what another model makes of a few jumps.

mod difference;
mod kriging;

use saltus_lagrangian::{Launch, Outcome, StanceError};
use saltus_numeric::{Dual, Scalar, Single};
use saltus_robot::Robot;

use crate::course::{Slope, Span};
use crate::flight::JumpFlight;
use crate::jump::Jump;
use crate::model::{Instant, JumpModel, Steered, Traced, widen};
use crate::planar::Planar;
use crate::planner::Planner;
use difference::{Account, Difference, SHOWN, account};
use kriging::{Kriging, Place, apart};

/// Error (m) of corrected jumps beside what they miss: flights are cubics in twelve parts.
const ACCURACY: f64 = 1e-7;

/// Two models whose flights differ by less (m) are one: that is what their tolerances leave.
const SAME: f64 = 5e-6;

/// Two launches that are nearer in units of their ranges are one.
const ONE: f64 = 1e-7;

/// A valve time (s) that no stroke outlasts.
const LONG: f64 = 100.0;

/// How far (m) below the lowest landing flights are compared.
const BELOW: f64 = 0.01;

/// The planar model of a robot with a correction: the difference, at some launches, between its
/// jumps and those of a truer model, and a smooth function of the launch between them.
///
/// Its jumps are nearly as cheap as the planar model's. Where it has learnt nothing, or nothing
/// that differs, it is the planar model bit for bit. Derivatives by the supply pressure are the
/// planar model's.
#[derive(Clone, Debug)]
pub struct Corrected {
    planar: Planar,
    range: LaunchRange,
    lowest: f64,
    learnt: Vec<Learnt>,
    /// Time of the planar model for each second of the truer one, in a stroke.
    quickness: f64,
    /// Whether launches near those from which the truer model does not fly are avoided.
    avoids: bool,
    /// That of the truer model.
    pendulum: f64,
    correction: Option<Kriging>,
}

/// Where launches are asked for: differences are taken to change little over a small part of it.
#[derive(Clone, Copy, Debug)]
pub struct LaunchRange {
    /// Approach rates (rad/s).
    pub rates: Span,
    /// Firing angles (rad).
    pub firing_angles: Span,
    /// Valve opening times (s).
    pub valve_open: Span,
}

/// A jump of the truer model.
#[derive(Clone, Debug)]
struct Learnt {
    launch: Launch,
    place: Place,
    /// What came of it, or how it did not fly.
    came: Result<Account, Outcome>,
    /// Time (s) from the opening of the valve to the lift-off, if the valve was open all along.
    powered: Option<f64>,
}

/// What is learnt from one jump.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Lesson {
    /// The corrected flight was off by this much (m) at most.
    Missed(f64),
    /// One model flies, the other does not.
    Otherwise,
}

/// How a correction was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Correction {
    /// Jumps of the truer model.
    pub jumps: usize,
    /// By how much (m) the flights of the last jumps were off before they were learnt from: new
    /// launches, as far as can be from those known. Infinite where none of them could be compared,
    /// or one could not and each has to.
    pub miss: f64,
    /// Whether the two models are one where they were compared.
    pub is_exact: bool,
}

/// How hard to look for a correction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Error (m) of the flights that is allowed.
    pub bound: f64,
    /// Jumps of the truer model in a round.
    pub round: usize,
    /// Jumps of the truer model in all.
    pub jumps: usize,
    /// Whether the truer model has to fly from every launch: those near one from which it does not
    /// are avoided then. Else they stay among the answers, for whoever flies them all to drop.
    pub every: bool,
}

impl Corrected {
    /// Nothing learnt yet. Flights are compared down to `lowest` (m above the foothold), the lowest
    /// height at which the wheel's centre may land.
    pub fn new(planar: Planar, range: LaunchRange, lowest: f64) -> Corrected {
        Corrected {
            pendulum: planar.pendulum(),
            planar,
            range,
            lowest: lowest - BELOW,
            learnt: Vec::new(),
            quickness: 1.0,
            avoids: false,
            correction: None,
        }
    }

    /// A launch in units of the ranges.
    fn place<S: Single>(&self, launch: &Launch<S>) -> Place<S> {
        let LaunchRange {
            rates,
            firing_angles,
            valve_open,
        } = self.range;
        let angle = firing_angles.width();
        let scaled = |x: S, width: f64| {
            // A number that is the same in all launches tells nothing.
            let unit = if width > 0.0 { 1.0 / width } else { 0.0 };
            x * S::of(unit)
        };
        [
            scaled(launch.rate, rates.width()),
            scaled(launch.lean, angle),
            scaled(launch.firing_angle, angle),
            scaled(launch.valve_open, valve_open.width()),
        ]
    }

    /// What is learnt from the jump of `truth` at `launch`; the correction is not changed before
    /// [`apply`](Corrected::apply).
    ///
    /// # Errors
    /// As [`JumpModel::jump`].
    fn learn(&mut self, truth: &dyn JumpModel, launch: &Launch) -> Result<Lesson, StanceError> {
        let flown = match truth.traced(launch) {
            // Where a robot cannot even start, its load is on another leg.
            Err(StanceError::Simulation { .. }) => {
                return Ok(self.note(launch, Outcome::EarlyLiftOff));
            }
            flown => flown?,
        };
        let stance = &flown.jump.stance;
        // Flights after another kind of lift-off are no smooth function of the launch.
        let is_alike = |ours: Outcome| ours == stance.outcome;
        let ours = self.planar.jump(&self.timed(*launch))?.stance.outcome;
        let theirs = account(&flown, self.lowest).filter(|_| is_alike(ours));
        let came = theirs.ok_or(stance.outcome);
        let lesson = match (&came, self.predicted(launch)) {
            (Ok(theirs), Some(ours)) => {
                let off: Vec<f64> = theirs.iter().zip(&ours).map(|(a, b)| a - b).collect();
                let at = off[SHOWN].chunks(4).map(|knot| knot[0].hypot(knot[1]));
                Lesson::Missed(at.fold(0.0, f64::max))
            }
            _ => Lesson::Otherwise,
        };
        let powered = stance.time - stance.time_fire - self.robot().leg.opening_delay();
        self.learnt.push(Learnt {
            launch: *launch,
            place: self.place(launch),
            powered: (came.is_ok() && powered <= launch.valve_open).then_some(powered),
            came,
        });
        Ok(lesson)
    }

    /// The truer model does not fly.
    fn note(&mut self, launch: &Launch, outcome: Outcome) -> Lesson {
        self.learnt.push(Learnt {
            launch: *launch,
            place: self.place(launch),
            came: Err(outcome),
            powered: None,
        });
        Lesson::Otherwise
    }

    /// The account of a launch, as it is seen now; none where the robot does not fly.
    fn predicted(&self, launch: &Launch) -> Option<Account> {
        let ours = self.planned(launch)?;
        let Some(correction) = &self.correction else {
            return Some(ours);
        };
        let by = correction.at(&self.place(launch));
        Some(ours.iter().zip(&by).map(|(a, b)| a + b).collect())
    }

    /// The planar model's account of a launch.
    fn planned(&self, launch: &Launch) -> Option<Account> {
        let jump = self.planar.traced(&self.timed(*launch)).ok()?;
        account(&jump, self.lowest)
    }

    /// Corrects by all that was learnt.
    fn apply(&mut self) {
        self.quickness = self.quickness();
        let (mut places, mut values) = (Vec::new(), Vec::new());
        for learnt in &self.learnt {
            if let (Ok(theirs), Some(ours)) = (&learnt.came, self.planned(&learnt.launch)) {
                places.push(learnt.place);
                values.push(theirs.iter().zip(&ours).map(|(a, b)| a - b).collect());
            }
        }
        let values: Vec<&[f64]> = values.iter().map(Vec::as_slice).collect();
        if let Some(correction) = Kriging::through(&places, &values, &SHOWN) {
            self.correction = Some(correction);
        }
    }

    /// How much sooner the planar model's stroke is over than the truer model's, with the valve
    /// open all along.
    fn quickness(&self) -> f64 {
        let shares = self.learnt.iter().filter_map(|learnt| {
            let open = Launch {
                valve_open: LONG,
                ..learnt.launch
            };
            let end = self.planar.jump(&open).ok()?.stance;
            let powered = end.time - end.time_fire - self.robot().leg.opening_delay();
            Some(powered / learnt.powered.filter(|_| end.outcome.is_jump())?)
        });
        let shares: Vec<f64> = shares.filter(|x| x.is_finite() && *x > 0.0).collect();
        match shares.len() {
            0 => 1.0,
            n => shares.iter().sum::<f64>() / n as f64,
        }
    }

    /// The planar model's launch for this one: where its stroke is over sooner, so is its valve
    /// time. A valve that closes at the lift-off of one does so at that of the other.
    fn timed<S: Single>(&self, launch: Launch<S>) -> Launch<S> {
        Launch {
            valve_open: launch.valve_open * S::of(self.quickness),
            ..launch
        }
    }

    /// The difference at a launch; none where nothing is corrected.
    fn difference<S: Single>(&self, launch: &Launch<S>) -> Option<Difference<S>> {
        let correction = self.correction.as_ref()?;
        Some(Difference::new(correction.at(&self.place(launch))))
    }

    /// How the truer model does not fly where it is known not to and that is avoided: at the nearest
    /// launch known.
    fn stays(&self, launch: &Launch) -> Option<Outcome> {
        if !self.avoids {
            return None;
        }
        let place = self.place(launch);
        let off = |l: &&Learnt| apart(&l.place, &place);
        let nearest = self
            .learnt
            .iter()
            .min_by(|a, b| off(a).total_cmp(&off(b)))?;
        nearest.came.as_ref().err().copied()
    }

    fn corrected<S: Single>(&self, jump: Jump<S>, difference: Option<&Difference<S>>) -> Jump<S> {
        let Some((difference, flight)) = difference.zip(jump.flight.as_ref()) else {
            return jump;
        };
        let flight = difference.flight(flight, self.lowest);
        Jump {
            launch: jump.launch,
            stance: difference.stance(&jump.stance),
            flight: flight.map(JumpFlight::Sampled),
        }
    }

    /// The planar model's jump for a launch, corrected.
    fn fly(&self, launch: Launch, jump: Jump) -> Jump {
        let jump = Jump { launch, ..jump };
        match self.stays(&launch).filter(|_| jump.flight.is_some()) {
            Some(outcome) => Jump {
                launch,
                stance: saltus_lagrangian::LiftOff {
                    outcome,
                    ..jump.stance
                },
                flight: None,
            },
            None => self.corrected(jump, self.difference(&launch).as_ref()),
        }
    }

    /// Those of `launches` that are farthest from what is known and from each other, at most `count`.
    fn farthest(&self, launches: &[Launch], count: usize) -> Vec<Launch> {
        let places: Vec<Place> = launches.iter().map(|l| self.place(l)).collect();
        let mut known: Vec<Place> = self.learnt.iter().map(|l| l.place).collect();
        let mut chosen = Vec::new();
        let nearest = |place: &Place, known: &[Place]| {
            let off = known.iter().map(|k| apart(k, place));
            off.fold(f64::INFINITY, f64::min)
        };
        let mut off: Vec<f64> = places.iter().map(|p| nearest(p, &known)).collect();
        while chosen.len() < count {
            let best = (0..places.len()).max_by(|a, b| off[*a].total_cmp(&off[*b]));
            let Some(best) = best.filter(|k| off[*k] > ONE * ONE) else {
                break;
            };
            chosen.push(launches[best]);
            known.push(places[best]);
            for (off, place) in off.iter_mut().zip(&places) {
                *off = off.min(apart(&places[best], place));
            }
        }
        chosen
    }
}

impl Planner<Corrected> {
    /// Learns from jumps of `truth` until the answers of this planner hold for it: `answers` gives
    /// the launches that count, as this planner sees them now. In each round those farthest from
    /// what is known are flown, until none of them misses by more than the bound.
    ///
    /// # Errors
    /// What `answers` or a jump of `truth` refuses.
    pub fn correct<E: From<StanceError>>(
        &mut self,
        truth: &dyn JumpModel,
        effort: &Effort,
        answers: impl Fn(&Planner<Corrected>) -> Result<Vec<Launch>, E>,
    ) -> Result<Correction, E> {
        let mut correction = Correction {
            jumps: 0,
            miss: 0.0,
            is_exact: true,
        };
        self.model_mut().avoids = effort.every;
        while correction.jumps < effort.jumps {
            let round = effort.round.min(effort.jumps - correction.jumps);
            let mut launches = answers(self)?;
            // First with the valve open all along, to see how long a stroke takes.
            let explores = correction.jumps == 0 && self.model().range.valve_open.width() > 0.0;
            if explores {
                let valve_open = self.model().range.valve_open.high;
                let open = |l: &mut Launch| l.valve_open = valve_open;
                launches.iter_mut().for_each(open);
            }
            let launches = self.model().farthest(&launches, round);
            if launches.is_empty() {
                break;
            }
            let mut misses = Vec::new();
            for launch in &launches {
                if let Lesson::Missed(by) = self.model_mut().learn(truth, launch)? {
                    misses.push(by);
                }
            }
            let enough = if effort.every { launches.len() } else { 1 };
            correction.miss = if misses.len() < enough {
                f64::INFINITY
            } else {
                misses.into_iter().fold(0.0, f64::max)
            };
            correction.jumps += launches.len();
            correction.is_exact &= correction.miss <= SAME;
            // What was flown is what is answered: the last lessons are not applied.
            if !explores && (correction.is_exact || correction.miss <= effort.bound) {
                break;
            }
            if !correction.is_exact {
                self.model_mut().apply();
            }
        }
        if correction.jumps > 0 && !correction.is_exact {
            self.model_mut().pendulum = truth.pendulum();
        }
        Ok(correction)
    }
}

impl JumpModel for Corrected {
    fn robot(&self) -> &Robot {
        self.planar.robot()
    }

    fn pendulum(&self) -> f64 {
        self.pendulum
    }

    fn accuracy(&self) -> f64 {
        self.correction
            .as_ref()
            .map_or(self.planar.accuracy(), |_| ACCURACY)
    }

    fn jump(&self, launch: &Launch) -> Result<Jump, StanceError> {
        Ok(self.fly(*launch, self.planar.jump(&self.timed(*launch))?))
    }

    fn jumps(&self, launches: &[Launch]) -> Vec<Result<Jump, StanceError>> {
        let timed: Vec<Launch> = launches.iter().map(|l| self.timed(*l)).collect();
        let jumps = self.planar.jumps(&timed).into_iter().zip(launches);
        jumps
            .map(|(jump, launch)| Ok(self.fly(*launch, jump?)))
            .collect()
    }

    fn sensitive_jump(&self, launch: &Launch) -> Result<Jump<Dual<4>>, StanceError> {
        let launch = launch.variables();
        let jump = self.planar.with_derivatives(self.timed(launch))?;
        let difference = self.difference(&launch);
        Ok(self.corrected(Jump { launch, ..jump }, difference.as_ref()))
    }

    fn spare(&self, jump: &Jump) -> f64 {
        let difference = self.difference(&jump.launch);
        let stance = match difference.filter(|_| jump.flight.is_some()) {
            Some(difference) => difference.without(&jump.stance),
            None => jump.stance,
        };
        let launch = self.timed(jump.launch);
        let planar = Jump {
            launch,
            stance,
            flight: None,
        };
        self.planar.spare(&planar) / self.quickness
    }

    fn traced(&self, launch: &Launch) -> Result<Traced, StanceError> {
        let Traced {
            jump,
            way,
            friction_needed,
        } = self.planar.traced(&self.timed(*launch))?;
        let (time, difference) = (jump.stance.time, self.difference(launch));
        let flies = jump.flight.is_some();
        let jump = self.fly(*launch, jump);
        Ok(match difference.filter(|_| flies) {
            None => Traced {
                jump,
                way,
                friction_needed,
            },
            Some(difference) => Traced {
                jump,
                way: way.iter().map(|at| difference.instant(at, time)).collect(),
                friction_needed: difference.friction(friction_needed),
            },
        })
    }

    fn steered(&self, launch: &Launch<Dual<2>>, with_friction: bool) -> Option<Steered> {
        let steered = self.planar.steered(&self.timed(*launch), with_friction)?;
        let Some(difference) = self.difference(launch) else {
            return Some(Steered {
                axle: steered.axle,
                extension: steered.extension,
                flight: steered.flight,
                friction_needed: steered.friction_needed,
                spare: steered.spare,
            });
        };
        if self.stays(&values(launch)).is_some() {
            return None;
        }
        let difference = difference.map(widen);
        let flight = difference.flight(&steered.flight, self.lowest)?;
        Some(Steered {
            axle: difference.axle(steered.axle),
            extension: difference.extension(steered.extension),
            flight: JumpFlight::Sampled(flight),
            friction_needed: steered.friction_needed.map(|x| difference.friction(x)),
            spare: steered.spare * Slope::of(1.0 / self.quickness),
        })
    }

    fn steered_way(&self, launch: &Launch<Dual<2>>) -> Option<Vec<Instant<Slope>>> {
        let way = self.planar.steered_way(&self.timed(*launch))?;
        let Some(difference) = self.difference(launch) else {
            return Some(way);
        };
        let difference = difference.map(widen);
        let time = way.last()?.time;
        Some(way.iter().map(|at| difference.instant(at, time)).collect())
    }
}

fn values(launch: &Launch<Dual<2>>) -> Launch {
    Launch {
        rate: launch.rate.value,
        lean: launch.lean.value,
        firing_angle: launch.firing_angle.value,
        valve_open: launch.valve_open.value,
    }
}

#[cfg(test)]
mod tests;
