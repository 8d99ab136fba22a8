//! A plan flown in full, and held against every limit.

use saltus_ballistic::{Disc, ExtendedLeg, Obstacle as Solid};
use saltus_lagrangian::{Launch, StanceError};
use saltus_numeric::Single;

use super::{Crossing, CrossingPlan, PlannedJump};
use crate::course::{self, Obstacle, Span};
use crate::flight::JumpFlight;
use crate::jump::{Sensitivity, norm};
use crate::model::{JumpModel, Traced};
use crate::planner::Planner;

/// Length (m) that is the solver's round-off.
const ROUND_OFF: f64 = 1e-6;

/// The same of a friction coefficient: models look at a stance's friction every millisecond.
const FRICTION_ROUND_OFF: f64 = 1e-3;

/// A limit in the full model.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// Index of the jump.
    pub jump: usize,
    /// What is limited, with its unit.
    pub what: String,
    /// What it comes to.
    pub value: f64,
    /// Least and greatest allowed.
    pub allowed: Span,
    /// A miss up to this is round-off.
    pub round_off: f64,
}

impl Check {
    /// Whether the value is allowed, but for round-off.
    pub fn holds(&self) -> bool {
        let allowed = self.allowed.widened(self.round_off);
        allowed.low <= self.value && self.value <= allowed.high
    }
}

/// One jump of a plan, and where it stands and lands.
struct Judge<'a> {
    crossing: &'a Crossing,
    radius: f64,
    jump: usize,
    /// Foothold and landing: along the course, and height of the surface (m).
    foot: [f64; 2],
    landing: [f64; 2],
    /// What landings keep from the ends of their ground for their scatter (m).
    keep: f64,
    traced: &'a Traced,
    checks: &'a mut Vec<Check>,
}

impl Planner<dyn JumpModel> {
    /// Flies a plan in full and holds it against every limit.
    pub(super) fn verify(
        &self,
        crossing: &Crossing,
        search: course::Plan,
    ) -> Result<CrossingPlan, StanceError> {
        self.fly_in_full(crossing, search, |_, launch, height| {
            self.landing_deviation(launch, height)
        })
    }

    /// `plan`, which another model has made, as this one flies it; what its landings scatter is
    /// taken over.
    ///
    /// # Errors
    /// [`StanceError`] where a stance cannot be computed.
    pub fn flown(
        &self,
        crossing: &Crossing,
        plan: &CrossingPlan,
    ) -> Result<CrossingPlan, StanceError> {
        self.fly_in_full(crossing, plan.search.clone(), |jump, _, _| {
            plan.jumps[jump].deviation
        })
    }

    fn fly_in_full(
        &self,
        crossing: &Crossing,
        search: course::Plan,
        deviation: impl Fn(usize, &Launch, f64) -> f64,
    ) -> Result<CrossingPlan, StanceError> {
        let (mut jumps, mut checks) = (Vec::new(), Vec::new());
        let radius = self.robot().body.radius;
        let mut foot = crossing.course.start;
        for (index, planned) in search.jumps.iter().enumerate() {
            let launch = crossing.launch(index, planned.decisions);
            let traced = self.model().traced(&launch)?;
            let (from, to) = (planned.leap.from, planned.leap.to);
            let distance = traced.jump.distance(radius + to - from);
            let landing = foot + distance.unwrap_or(f64::NAN);
            let deviation = deviation(index, &launch, radius + to - from);
            let mut judge = Judge {
                crossing,
                radius,
                jump: index,
                foot: [foot, from],
                landing: [landing, to],
                keep: crossing.sigmas * deviation,
                traced: &traced,
                checks: &mut checks,
            };
            judge.landing(index + 1 == search.jumps.len());
            for (number, obstacle) in crossing.course.obstacles.iter().enumerate() {
                judge.obstacle(number + 1, obstacle);
            }
            judge.friction();
            jumps.push(PlannedJump {
                foot: [foot, from],
                landing: [landing, to],
                deviation,
                friction_needed: traced.friction_needed,
                jump: traced.jump,
            });
            foot = landing + crossing.roll;
        }
        Ok(CrossingPlan {
            jumps,
            search,
            checks,
        })
    }

    /// Standard deviation (m) of the landing at `height` (m) above the foot, to first order; 0
    /// where there is none.
    pub(super) fn landing_deviation(&self, launch: &saltus_lagrangian::Launch, height: f64) -> f64 {
        norm(&self.landing_errors(launch, height))
    }

    /// What each error of the robot changes of the landing (m), with its sign.
    pub(super) fn landing_errors(
        &self,
        launch: &saltus_lagrangian::Launch,
        height: f64,
    ) -> [f64; 4] {
        let jump = self.sensitive_jump(launch).ok();
        let distance = jump.and_then(|jump| jump.distance(height));
        distance.map_or([0.0; 4], |d| {
            Sensitivity::new(d).parts(&self.robot().errors)
        })
    }
}

impl Judge<'_> {
    fn check(&mut self, what: impl Into<String>, value: f64, allowed: Span) {
        self.checks.push(Check {
            jump: self.jump,
            what: what.into(),
            value,
            allowed,
            round_off: ROUND_OFF,
        });
    }

    /// On its ground, in its zone, and, if it `is_last`, in the goal.
    fn landing(&mut self, is_last: bool) {
        let ([landing, to], crossing, keep) = (self.landing, self.crossing, self.keep);
        let ground = crossing.ground(self.radius, landing, to);
        self.check("landing (m)", landing, ground.widened(-keep));
        if let Some(zone) = crossing.zones.get(self.jump).copied().flatten() {
            let zone = zone.widened(-crossing.edge_margin - keep);
            self.check("landing in its zone (m)", landing, zone);
        }
        let goal = crossing.course.goal;
        if is_last {
            let keep = if goal.width() > 0.0 {
                crossing.edge_margin + keep
            } else {
                0.0
            };
            self.check("landing in the goal (m)", landing, goal.widened(-keep));
        }
    }

    /// Clear of an obstacle in the flight and in the stance, unless the robot stands on it.
    fn obstacle(&mut self, number: usize, obstacle: &Obstacle) {
        let (span, top) = (obstacle.span(), obstacle.height);
        let on_it = |[x, height]: [f64; 2]| height == top && x >= span.low && x <= span.high;
        if on_it(self.foot) {
            return;
        }
        // The landing itself is a touch.
        let kept = if on_it(self.landing) {
            0.0
        } else {
            self.crossing.clearance
        };
        let gap = self.flight_gap(span, top).unwrap_or(f64::NAN);
        let what = format!("clearance of obstacle {number} (m)");
        self.check(what, gap, above(kept));
        let [foot, from] = self.foot;
        let way = self.traced.way.iter().map(|at| {
            let [x, y] = at.centre;
            box_distance([foot + x, from + y], span, top) - self.radius
        });
        let gap = way.fold(f64::INFINITY, f64::min);
        let what = format!("clearance of obstacle {number} in the stance (m)");
        self.check(what, gap, above(0.0));
    }

    fn friction(&mut self) {
        if let Some(friction) = self.crossing.friction {
            let needed = self.traced.friction_needed;
            self.checks.push(Check {
                jump: self.jump,
                what: "friction needed".into(),
                value: needed,
                allowed: Span::new(0.0, friction),
                round_off: FRICTION_ROUND_OFF,
            });
        }
    }

    /// Least clearance (m) of the flight from a box.
    fn flight_gap(&self, span: Span, top: f64) -> Option<f64> {
        let ([foot, from], [_, to]) = (self.foot, self.landing);
        let jump = &self.traced.jump;
        let solid = Solid::block([span.low - foot, -from], [span.high - foot, top - from]).ok()?;
        let reach = self.radius + jump.stance.extension;
        let height = self.radius + to - from;
        let flight = jump.flight.as_ref()?;
        clearance(flight, self.crossing, self.radius, reach, &solid, height)
    }
}

fn above(low: f64) -> Span {
    Span::new(low, f64::INFINITY)
}

/// Distance (m) from a point to a box on the ground; 0 inside.
pub(super) fn box_distance([x, y]: [f64; 2], span: Span, top: f64) -> f64 {
    (x - span.clamp(x)).hypot((y - top).max(0.0))
}

/// Least clearance (m) of the wheel, and of its leg while that is out, from lift-off until the
/// centre is down at `height`.
pub(super) fn clearance<S: Single>(
    flight: &JumpFlight<S>,
    crossing: &Crossing,
    radius: f64,
    reach: S,
    solid: &Solid,
    height: f64,
) -> Option<S> {
    let landing = flight.time_to_height(S::of(height)).ok()?;
    let leg = (crossing.leg_out > 0.0).then(|| ExtendedLeg {
        reach,
        until: S::of(crossing.leg_out),
    });
    let disc = Disc {
        radius: S::of(radius),
        leg,
    };
    flight.clearance(&disc, solid, S::of(0.0), landing).ok()
}
