//! The rolling robot on a course: firing angles and valve opening times over obstacles.
//!
//! [`Planner::cross`] makes the robot a [`Jumper`]: each of its jumps is flown by the full stance
//! and flight with exact derivatives, and [`course::plan`] searches and solves. The plan is then
//! flown again, finely, and held against every limit: see [`Check`].

use std::borrow::Cow;
use std::cell::{OnceCell, RefCell};
use std::ops::ControlFlow;
use std::rc::Rc;

use saltus_ballistic::{Disc, DragFlight, ExtendedLeg, Flight, Obstacle as Solid};
use saltus_lagrangian::{Launch, Stance, StanceError};
use saltus_numeric::{Dual, Scalar, Single};
use saltus_robot::Term;

use crate::course::{
    self, Answer, Course, CourseError, Envelope, Jumper, Leap, Limit, MAX_JUMPS, Margin, Relief,
    Sketch, Slope, Span, Watch,
};
use crate::jump::{Jump, Planner};
use crate::table::FIRING_ANGLES;

mod grid;
mod stance;

use grid::{Grid, Within};
use stance::Path;

/// Distance (m) that landings keep from the ends of their ground unless a course says otherwise: of
/// a robot without stated errors too no landing is on the last millimetre.
pub const EDGE_MARGIN: f64 = 5e-3;

/// Standard deviations that landings keep from the ends of their ground unless a course says
/// otherwise: of normally distributed landings 2 % are beyond an end.
pub const MARGIN_SIGMAS: f64 = 2.0;

/// What is to be crossed, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct Crossing {
    /// Start, goal, obstacles and no-landing areas. A landing is where the wheel's centre comes
    /// down to r_s above the surface; the next foot stands there, or after the roll.
    pub course: Course,
    /// Approach rates ω (rad/s): one for all jumps, or one for each.
    pub rates: Vec<f64>,
    /// Lean at the start of each stance (rad); none: stances start at their firing angles.
    pub start_lean: Option<f64>,
    /// Allowed firing angles (rad).
    pub firing_angles: Span,
    /// Allowed valve opening times (s); without effect for a leg without a valve.
    pub valve_open: Span,
    /// Where each jump has to land (m), beside the course's own limits; none or missing: anywhere.
    pub zones: Vec<Option<Span>>,
    /// Where the last landing should be (m): deviation from it costs.
    pub target: f64,
    /// Distance (m) that the robot rolls between a landing and the next foothold, ≥ 0.
    pub roll: f64,
    /// Least clearance (m) of the wheel over obstacles, ≥ 0.
    pub clearance: f64,
    /// Least distance (m), ≥ 0, of a landing from the ends of its ground: obstacles, no-landing
    /// areas, the ends of its zone and of a goal that is a zone. From an obstacle that rises beside
    /// it, a landing keeps at least the wheel's rim.
    pub edge_margin: f64,
    /// Time (s) after lift-off during which the fired leg is still out, so that the extended leg
    /// must stay clear too.
    pub leg_out: f64,
    /// Friction coefficient of the ground; none: the foot holds.
    pub friction: Option<f64>,
    /// Standard deviations of the landing, ≥ 0, that are kept from the ends of its ground beside
    /// the margin.
    pub sigmas: f64,
    /// Cost of a squared metre off the target (1/m²), ≥ 0.
    pub deviation_weight: f64,
    /// Cost of a squared second of open valve (1/s²), ≥ 0: the control effort.
    pub effort_weight: f64,
}

/// What crossing a course comes to.
#[derive(Clone, Debug)]
pub enum CrossingAnswer {
    /// A plan, and how it fared in the check.
    Plan(CrossingPlan),
    /// There is none.
    Infeasible {
        /// What blocks, and how the nearest course that has a plan differs.
        relief: Relief,
        /// With how many jumps, up to two more, there is a plan.
        jumps: Option<usize>,
    },
    /// None was found before the search came to its limits or was stopped.
    Undecided {
        /// Nodes of the search that were looked at.
        nodes: usize,
        /// Programs that were solved.
        solves: usize,
    },
}

/// A plan for a course.
#[derive(Clone, Debug)]
pub struct CrossingPlan {
    /// Jump after jump.
    pub jumps: Vec<PlannedJump>,
    /// The search's own account.
    pub search: course::Plan,
    /// Every limit, held against the full model.
    pub checks: Vec<Check>,
}

impl CrossingPlan {
    /// Whether every limit holds in the planar model.
    pub fn holds(&self) -> bool {
        self.checks.iter().all(Check::holds)
    }
}

/// One jump of a plan, as the full model flies it.
#[derive(Clone, Debug)]
pub struct PlannedJump {
    /// Foothold (m), and the height of its surface (m).
    pub foot: [f64; 2],
    /// The jump; its positions count from the foothold.
    pub jump: Jump,
    /// Landing (m along the course), and the height of its surface (m).
    pub landing: [f64; 2],
    /// Standard deviation of the landing (m), to first order.
    pub deviation: f64,
    /// Friction coefficient that the stance needs.
    pub friction_needed: f64,
}

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
}

impl Check {
    /// A micrometre, or a millionth, is the solver's round-off.
    pub fn holds(&self) -> bool {
        self.value >= self.allowed.low - 1e-6 && self.value <= self.allowed.high + 1e-6
    }
}

/// A crossing that cannot even be tried.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CrossingError {
    /// The course is wrong.
    #[error(transparent)]
    Course(#[from] CourseError),
    /// A number is outside its domain.
    #[error("{key} = {value}: must be {allowed}")]
    Input {
        /// Key, as in course files.
        key: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A stance cannot be computed.
    #[error(transparent)]
    Stance(#[from] StanceError),
}

/// A number of a crossing: key, value, whether it is allowed, and what is.
type Case = (&'static str, f64, bool, &'static str);

/// What a lean or a firing angle may be.
const UPRIGHT: &str = "between -pi/2 and pi/2 rad, exclusive";

fn is_upright(x: f64) -> bool {
    x.abs() < std::f64::consts::FRAC_PI_2
}

/// The first number that is not allowed, as an error.
fn refused(cases: impl IntoIterator<Item = Case>) -> Result<(), CrossingError> {
    let bad = cases.into_iter().find(|(_, _, holds, _)| !holds);
    bad.map_or(Ok(()), |(key, value, _, allowed)| {
        Err(CrossingError::Input {
            key,
            value,
            allowed,
        })
    })
}

impl Crossing {
    /// `course` at one approach rate (rad/s): stances start at firing angles of [`FIRING_ANGLES`],
    /// the valve opens for 20 to 100 ms, the last landing should be in the middle of the goal,
    /// landings keep [`EDGE_MARGIN`] and [`MARGIN_SIGMAS`] from the ends of their ground, and
    /// nothing else is asked for.
    ///
    /// A decimetre off the target costs as much as opening the valve for a second.
    pub fn new(course: Course, rate: f64) -> Crossing {
        Crossing {
            target: f64::midpoint(course.goal.low, course.goal.high),
            course,
            rates: vec![rate],
            start_lean: None,
            firing_angles: Span::new(FIRING_ANGLES.0, FIRING_ANGLES.1),
            valve_open: Span::new(0.02, 0.1),
            zones: Vec::new(),
            roll: 0.0,
            clearance: 0.0,
            edge_margin: EDGE_MARGIN,
            leg_out: 0.0,
            friction: None,
            sigmas: MARGIN_SIGMAS,
            deviation_weight: 100.0,
            effort_weight: 1.0,
        }
    }

    /// The approach rate (rad/s) of jump number `jump`.
    fn rate(&self, jump: usize) -> f64 {
        self.rates[jump.min(self.rates.len() - 1)]
    }

    fn check(&self) -> Result<(), CrossingError> {
        self.course.check()?;
        refused(self.approach())?;
        refused(self.commands())?;
        refused(self.margins())?;
        self.check_ends()?;
        self.check_start()
    }

    /// How the robot comes, and to how many landings.
    fn approach(&self) -> [Case; 4] {
        let (jumps, rates) = (self.course.jumps, self.rates.len());
        let bad_rate = self
            .rates
            .iter()
            .copied()
            .find(|r| !(0.0..=1e3).contains(r));
        [
            (
                "approach_rate_rad_s (count)",
                rates as f64,
                rates == 1 || rates == jumps,
                "1, or as many as there are jumps",
            ),
            (
                "land (count)",
                self.zones.len() as f64,
                self.zones.len() <= jumps,
                "at most one for each jump",
            ),
            (
                "approach_rate_rad_s",
                bad_rate.unwrap_or(0.0),
                bad_rate.is_none(),
                "from 0 to 1000 rad/s",
            ),
            (
                "start_lean_rad",
                self.start_lean.unwrap_or(0.0),
                self.start_lean.is_none_or(is_upright),
                UPRIGHT,
            ),
        ]
    }

    /// What may be commanded.
    fn commands(&self) -> [Case; 4] {
        let (angles, valve) = (self.firing_angles, self.valve_open);
        [
            (
                "firing_angle_rad",
                angles.low,
                is_upright(angles.low),
                UPRIGHT,
            ),
            (
                "firing_angle_rad",
                angles.high,
                is_upright(angles.high) && angles.high > angles.low,
                "above its least value, below pi/2 rad",
            ),
            (
                "valve_open_s",
                valve.low,
                valve.low > 0.0 && valve.low <= 10.0,
                "above 0, to 10 s",
            ),
            (
                "valve_open_s",
                valve.high,
                valve.high > valve.low && valve.high <= 10.0,
                "above its least value, to 10 s",
            ),
        ]
    }

    /// Distances, margins and weights.
    fn margins(&self) -> [Case; 9] {
        let length = |x: f64| (0.0..=1e4).contains(&x);
        let positive = "0 or above";
        [
            (
                "target_x_m",
                self.target,
                self.target.abs() <= 1e4,
                "from -10000 to 10000 m",
            ),
            ("roll_m", self.roll, length(self.roll), positive),
            (
                "clearance_m",
                self.clearance,
                length(self.clearance),
                positive,
            ),
            (
                "edge_margin_m",
                self.edge_margin,
                length(self.edge_margin),
                positive,
            ),
            ("leg_out_s", self.leg_out, length(self.leg_out), positive),
            (
                "friction_coefficient",
                self.friction.unwrap_or(0.0),
                self.friction.is_none_or(length),
                positive,
            ),
            ("margin_sigmas", self.sigmas, length(self.sigmas), positive),
            (
                "deviation_weight",
                self.deviation_weight,
                self.deviation_weight >= 0.0 && self.deviation_weight.is_finite(),
                positive,
            ),
            (
                "effort_weight",
                self.effort_weight,
                self.effort_weight >= 0.0 && self.effort_weight.is_finite(),
                positive,
            ),
        ]
    }

    /// Whether the robot starts on the ground or on a box, and no landing zone runs backwards.
    fn check_start(&self) -> Result<(), CrossingError> {
        let inside = |o: &course::Obstacle| {
            let under = o.span().widened(-1e-9).clamp(self.course.start) == self.course.start;
            under && self.course.start_height != o.height
        };
        let carries = |o: &course::Obstacle| o.span().clamp(self.course.start) == self.course.start;
        let is_in_the_air =
            self.course.start_height != 0.0 && !self.course.obstacles.iter().any(carries);
        if is_in_the_air || self.course.obstacles.iter().any(inside) {
            let allowed = "the height of the obstacle on which the start is, or 0 on the ground";
            return Err(CrossingError::Input {
                key: "start_height_m",
                value: self.course.start_height,
                allowed,
            });
        }
        let backwards = self
            .zones
            .iter()
            .flatten()
            .find(|z| z.is_empty() || !z.low.is_finite() || !z.high.is_finite());
        match backwards {
            Some(zone) => Err(CrossingError::Input {
                key: "land.to_x_m",
                value: zone.high,
                allowed: "finite and not before its from_x_m",
            }),
            None => Ok(()),
        }
    }

    /// Whether there is room between the margins of the goal and of each landing zone.
    fn check_ends(&self) -> Result<(), CrossingError> {
        let narrow = |span: Span| span.width() > 0.0 && span.width() <= 2.0 * self.edge_margin;
        let wider = "more than 2 edge_margin_m beyond its beginning";
        let ends = [("goal_to_x_m", Some(self.course.goal))].into_iter();
        let mut ends = ends.chain(self.zones.iter().map(|zone| ("land.to_x_m", *zone)));
        if let Some((key, Some(span))) = ends.find(|(_, span)| span.is_some_and(narrow)) {
            return Err(CrossingError::Input {
                key,
                value: span.high,
                allowed: wider,
            });
        }
        Ok(())
    }
}

impl Planner {
    /// Plans `crossing`.
    ///
    /// # Errors
    /// [`CrossingError`] for a value outside its domain. A course without a plan is an answer, not
    /// an error.
    pub fn cross(&self, crossing: &Crossing) -> Result<CrossingAnswer, CrossingError> {
        self.cross_watched(crossing, &|_| ControlFlow::Continue(()))
    }

    /// As [`cross`](Self::cross), with `watch` told how far the search is; it may stop it, and gets
    /// the best answer so far.
    ///
    /// # Errors
    /// As [`cross`](Self::cross).
    pub fn cross_watched(
        &self,
        crossing: &Crossing,
        watch: &Watch<'_>,
    ) -> Result<CrossingAnswer, CrossingError> {
        crossing.check()?;
        let crossing = &self.with_its_valve(crossing);
        Ok(match self.search(crossing, watch)? {
            Answer::Plan(plan) => CrossingAnswer::Plan(self.verify(crossing, plan)?),
            Answer::Infeasible(relief) => {
                let jumps = self.enough_jumps(crossing, &relief, watch)?;
                CrossingAnswer::Infeasible { relief, jumps }
            }
            Answer::Undecided { nodes, solves } => CrossingAnswer::Undecided { nodes, solves },
        })
    }

    /// `crossing` as this robot can choose: without a valve there is no opening time to choose, and
    /// none that costs.
    fn with_its_valve<'a>(&self, crossing: &'a Crossing) -> Cow<'a, Crossing> {
        if self.robot().leg.drive.has_valve() {
            return Cow::Borrowed(crossing);
        }
        let valve_open = Span::point(crossing.valve_open.low);
        Cow::Owned(Crossing {
            valve_open,
            effort_weight: 0.0,
            ..crossing.clone()
        })
    }

    fn search(&self, crossing: &Crossing, watch: &Watch<'_>) -> Result<Answer, CourseError> {
        course::plan_watched(
            &Roller::new(self, crossing),
            &crossing.course,
            &settings(crossing),
            watch,
        )
    }

    /// With how many jumps, one or two more, there is a plan; looked for where one more landing can
    /// help and all jumps have the same rate.
    fn enough_jumps(
        &self,
        crossing: &Crossing,
        relief: &Relief,
        watch: &Watch<'_>,
    ) -> Result<Option<usize>, CrossingError> {
        let helps = |limit: Limit| matches!(limit, Limit::Goal | Limit::Landing(_));
        if crossing.rates.len() > 1 || !relief.gives.iter().any(|give| helps(give.limit)) {
            return Ok(None);
        }
        for jumps in (crossing.course.jumps + 1..=MAX_JUMPS).take(2) {
            let mut more = crossing.clone();
            more.course.jumps = jumps;
            if let Answer::Plan(plan) = self.search(&more, watch)?
                && self.verify(&more, plan)?.holds()
            {
                return Ok(Some(jumps));
            }
        }
        Ok(None)
    }

    /// Flies a plan in the full model and holds it against every limit.
    fn verify(
        &self,
        crossing: &Crossing,
        search: course::Plan,
    ) -> Result<CrossingPlan, StanceError> {
        let (mut jumps, mut checks) = (Vec::new(), Vec::new());
        let sensitive = self.sensitive_stance();
        let robot = self.robot();
        let (radius, gravity, drag) = (
            robot.body.radius,
            robot.axle_gravity(),
            robot.environment.drag,
        );
        let mut foot = crossing.course.start;
        for (index, planned) in search.jumps.iter().enumerate() {
            let [firing_angle, valve_open] = planned.decisions;
            let launch = launch(crossing, index, firing_angle, valve_open);
            // Ten times finer than the search, and without its closed forms.
            let trace = self.stance().trace(&launch)?;
            let jump = Jump::new(launch, trace.lift_off, gravity, drag);
            let (from, to) = (planned.leap.from, planned.leap.to);
            let distance = jump.distance(radius + to - from).unwrap_or(f64::NAN);
            let landing = foot + distance;
            let deviation = self.landing_deviation(&sensitive, &launch, radius + to - from);
            let mut check = |what: String, value: f64, allowed: Span| {
                checks.push(Check {
                    jump: index,
                    what,
                    value,
                    allowed,
                });
            };
            let keep = crossing.sigmas * deviation;
            let ground = ground(crossing, radius, landing, to);
            check("landing (m)".into(), landing, ground.widened(-keep));
            if let Some(zone) = crossing.zones.get(index).copied().flatten() {
                check(
                    "landing in its zone (m)".into(),
                    landing,
                    zone.widened(-crossing.edge_margin - keep),
                );
            }
            let goal = crossing.course.goal;
            if index + 1 == search.jumps.len() {
                let keep = if goal.width() > 0.0 {
                    crossing.edge_margin + keep
                } else {
                    0.0
                };
                check(
                    "landing in the goal (m)".into(),
                    landing,
                    goal.widened(-keep),
                );
            }
            for (number, obstacle) in crossing.course.obstacles.iter().enumerate() {
                let (span, top) = (obstacle.span(), obstacle.height);
                let on_it = |height: f64, x: f64| height == top && x >= span.low && x <= span.high;
                if on_it(from, foot) {
                    continue;
                }
                // The landing itself is a touch.
                let kept = if on_it(to, landing) {
                    0.0
                } else {
                    crossing.clearance
                };
                let gap = flight_gap(
                    crossing,
                    &jump,
                    radius,
                    [foot, from],
                    to,
                    [span.low, span.high, top],
                );
                check(
                    format!("clearance of obstacle {} (m)", number + 1),
                    gap,
                    above(kept),
                );
                let path = trace.samples.iter().map(|s| {
                    let (sin, cos) = Scalar::sin_cos(s.lean);
                    let reach = radius + s.extension;
                    box_distance([foot + reach * sin, from + reach * cos], span, top) - radius
                });
                let gap = path.fold(f64::INFINITY, f64::min);
                check(
                    format!("clearance of obstacle {} in the stance (m)", number + 1),
                    gap,
                    above(0.0),
                );
            }
            let friction_needed = trace.contact.friction_needed;
            if let Some(friction) = crossing.friction {
                check(
                    "friction needed".into(),
                    friction_needed,
                    Span::new(0.0, friction),
                );
            }
            jumps.push(PlannedJump {
                foot: [foot, from],
                jump,
                landing: [landing, to],
                deviation,
                friction_needed,
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
    fn landing_deviation(&self, stance: &Stance<Dual<4>>, launch: &Launch, height: f64) -> f64 {
        self.sensitive_jump(stance, launch)
            .ok()
            .and_then(|jump| jump.distance(height))
            .map_or(0.0, |d| {
                crate::Sensitivity::new(d).standard_deviation(&self.robot().errors)
            })
    }
}

fn settings(crossing: &Crossing) -> course::Settings {
    course::Settings {
        sigmas: crossing.sigmas,
        // One program for each choice of grounds: a choice's distances are smooth in its decisions.
        resolution: f64::INFINITY,
        nodes: NODES,
        work: WORK,
        solver: SOLVER,
        ..course::Settings::default()
    }
}

fn above(low: f64) -> Span {
    Span::new(low, f64::INFINITY)
}

fn launch(crossing: &Crossing, jump: usize, firing_angle: f64, valve_open: f64) -> Launch {
    let lean = crossing.start_lean.unwrap_or(firing_angle);
    Launch {
        rate: crossing.rate(jump),
        lean,
        firing_angle,
        valve_open,
    }
}

/// Least distance (m) of a landing from an obstacle that rises by `rise` (m) above it: the edge
/// margin, and room for the wheel's rim with its clearance.
fn margin_beside(crossing: &Crossing, radius: f64, rise: f64) -> f64 {
    let reach = radius + crossing.clearance;
    let above = (radius - rise).max(0.0);
    let rim = if rise > 0.0 {
        (reach * reach - above * above).max(0.0).sqrt()
    } else {
        0.0
    };
    rim.max(crossing.edge_margin)
}

/// The part of the surface of height `to` around `landing` (m) on which a jump may land.
fn ground(crossing: &Crossing, radius: f64, landing: f64, to: f64) -> Span {
    let mut span = Span::ALL;
    let mut exclude = |area: Span| {
        if landing >= f64::midpoint(area.low, area.high) {
            span.low = span.low.max(area.high);
        } else {
            span.high = span.high.min(area.low);
        }
    };
    crossing
        .course
        .no_landing
        .iter()
        .for_each(|area| exclude(area.widened(crossing.edge_margin)));
    for obstacle in &crossing.course.obstacles {
        let (body, rise) = (obstacle.span(), obstacle.height - to);
        if rise == 0.0 && landing >= body.low && landing <= body.high {
            span = span.meet(body.widened(-crossing.edge_margin));
        } else if rise > 0.0 {
            let kept = body.widened(margin_beside(crossing, radius, rise));
            if landing >= f64::midpoint(body.low, body.high) {
                span.low = span.low.max(kept.high);
            } else {
                span.high = span.high.min(kept.low);
            }
        }
    }
    span
}

/// Distance (m) from a point to a box on the ground; 0 inside.
fn box_distance([x, y]: [f64; 2], span: Span, top: f64) -> f64 {
    (x - span.clamp(x)).hypot((y - top).max(0.0))
}

/// Least clearance (m) of a flying jump from the box [front, back, top].
fn flight_gap(
    crossing: &Crossing,
    jump: &Jump,
    radius: f64,
    [foot, from]: [f64; 2],
    to: f64,
    [front, back, top]: [f64; 3],
) -> f64 {
    let gap = || {
        let flight = jump.flight?;
        let solid = Solid::block([front - foot, -from], [back - foot, top - from]).ok()?;
        clearance(
            &flight,
            crossing,
            radius,
            radius + jump.stance.extension,
            &solid,
            radius + to - from,
        )
    };
    gap().unwrap_or(f64::NAN)
}

/// Least clearance (m) of the wheel, and of its leg while that is out, from lift-off until the
/// centre is down at `height`.
fn clearance<S: Single>(
    flight: &DragFlight<S>,
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
    flight
        .clearance(&disc, solid, S::of(0.0), landing)
        .ok()
        .map(|c| c.distance)
}

/// Costs are about 1 and a tenth of a millimetre off the target costs 1e-6; the start is within a
/// third of the range of the answer.
const SOLVER: course::sqp::Settings = course::sqp::Settings {
    iterations: 60,
    tolerance: 1e-6,
    feasibility: 5e-7,
    radius: 0.3,
};

/// Error tolerance of the stances while searching: lengths are then right to some ten nanometres,
/// well within what the check of the finished plan allows.
const SEARCH_TOLERANCE: f64 = 2e-8;

/// Firing angles at which the reach of the jumps is sampled.
const SAMPLES: usize = 16;

/// Nodes that a search may look at.
const NODES: usize = 1000;

/// Jumps in the programs that a search may solve: 20 programs of 12 jumps take some seconds.
const WORK: usize = 240;

/// A wheel that is farther than this (m) from what is beside its foothold, at three places of the
/// stance, does not touch it; how near a wheel that is nearer comes, the whole stance says.
const NEAR: f64 = 0.03;

/// Results of a stance that are remembered for each jump: where the solver is, and a difference for
/// each decision.
const REMEMBERED: usize = 3;

/// The robot as a [`Jumper`]: decisions are firing angle (rad) and valve opening time (s).
struct Roller<'a> {
    planner: &'a Planner,
    crossing: &'a Crossing,
    /// The model with the derivatives by the two decisions.
    stance: Stance<Dual<2>>,
    sensitive: Stance<Dual<4>>,
    /// For each jump its flights over the firing angles, with the valve open longest and then
    /// shortest.
    samples: Vec<[Vec<Jump>; 2]>,
    /// For each jump its flights over angles and valve times, to bound its cost.
    grids: Vec<Rc<Grid>>,
    /// For each jump what came of its last decisions. A foothold changes nothing but the place of a
    /// jump, and so the solver's differences cost one stance for each decision and not one for each
    /// jump and decision.
    remembered: RefCell<Vec<Vec<Rc<Flown>>>>,
}

/// What came of a jump's decisions, wherever its foothold is.
struct Flown {
    /// Firing angle (rad), valve opening time (s) and landing height (m).
    of: [f64; 3],
    /// The flight, the leg's reach at lift-off and the friction that the stance needs; none without
    /// a flight.
    jump: Option<(DragFlight<Slope>, Slope, Slope)>,
    /// The way of the wheel in the stance, once it was asked for; none without a stance.
    path: OnceCell<Option<Path>>,
}

impl<'a> Roller<'a> {
    fn new(planner: &'a Planner, crossing: &'a Crossing) -> Roller<'a> {
        let stance = Stance::new(planner.robot(), |_: Term, x: f64| Dual::of(x))
            .with_tolerance(SEARCH_TOLERANCE);
        let angles = crossing.firing_angles;
        let sample = |jump: usize| {
            [crossing.valve_open.high, crossing.valve_open.low].map(|valve_open| {
                let launches: Vec<Launch> = (0..SAMPLES)
                    .map(|i| angles.low + angles.width() * i as f64 / (SAMPLES - 1) as f64)
                    .map(|angle| launch(crossing, jump, angle, valve_open))
                    .collect();
                planner
                    .jumps(&launches)
                    .into_iter()
                    .filter_map(Result::ok)
                    .collect()
            })
        };
        // Jumps at the same rate share their samples.
        let mut samples: Vec<[Vec<Jump>; 2]> = Vec::new();
        for jump in 0..crossing.course.jumps {
            let twin = (0..jump).find(|&k| crossing.rate(k) == crossing.rate(jump));
            samples.push(twin.map_or_else(|| sample(jump), |k| samples[k].clone()));
        }
        let jumps = crossing.course.jumps;
        let grid = |jump: usize| Rc::new(Grid::new(planner, crossing, jump));
        let mut grids: Vec<Rc<Grid>> = Vec::new();
        for jump in 0..jumps {
            let twin = (0..jump).find(|&k| crossing.rate(k) == crossing.rate(jump));
            grids.push(twin.map_or_else(|| grid(jump), |k| grids[k].clone()));
        }
        let remembered = RefCell::new(vec![Vec::new(); jumps]);
        Roller {
            planner,
            crossing,
            stance,
            sensitive: planner.sensitive_stance(),
            samples,
            grids,
            remembered,
        }
    }

    /// Height (m) of the wheel's centre above the foot at the landing.
    fn landing_height(&self, leap: &Leap) -> f64 {
        self.planner.robot().body.radius + leap.to - leap.from
    }

    /// By how much (m) the wheel's rim is too low where its centre is over `x` (m from the
    /// foothold): a cheap stand-in for the clearance, for starting points.
    fn shortfall(&self, leap: &Leap, x: f64, top: f64, jump: &Jump) -> f64 {
        let Some(DragFlight { vacuum: flight, .. }) = jump.flight else {
            return 1.0;
        };
        let [_, y] = flight.position(((x - flight.x) / flight.vx).max(0.0));
        let needed = top - leap.from + self.planner.robot().body.radius + self.crossing.clearance;
        (needed - y).max(0.0)
    }

    fn distances<'b>(
        &'b self,
        leap: &'b Leap,
        longest: bool,
    ) -> impl Iterator<Item = (f64, f64)> + 'b {
        let height = self.landing_height(leap);
        self.samples[leap.jump][usize::from(!longest)]
            .iter()
            .filter_map(move |jump| Some((jump.launch.firing_angle, jump.distance(height)?)))
    }

    /// What comes of a jump's decisions.
    fn flown(&self, leap: &Leap, decisions: [f64; 2]) -> Rc<Flown> {
        let height = self.landing_height(leap);
        let of = [decisions[0], decisions[1], height];
        let known = self.remembered.borrow()[leap.jump]
            .iter()
            .find(|flown| flown.of == of)
            .cloned();
        known.unwrap_or_else(|| {
            let flown = Rc::new(Flown {
                of,
                jump: self.jump(leap, decisions),
                path: OnceCell::new(),
            });
            let mut remembered = self.remembered.borrow_mut();
            remembered[leap.jump].insert(0, flown.clone());
            remembered[leap.jump].truncate(REMEMBERED);
            flown
        })
    }

    /// The launch of these decisions, with its derivatives by them.
    fn launch(&self, leap: &Leap, [angle, open]: [f64; 2]) -> Launch<Dual<2>> {
        let (angle, open) = (Dual::variable(angle, 0), Dual::variable(open, 1));
        let lean = self.crossing.start_lean.map_or(angle, Dual::of);
        let rate = Dual::of(self.crossing.rate(leap.jump));
        Launch {
            rate,
            lean,
            firing_angle: angle,
            valve_open: open,
        }
    }

    /// Where the wheel's centre is at the start of the stance, where the leg begins to extend, and
    /// at the lift-off.
    fn roughly(&self, leap: &Leap, flight: &DragFlight<Slope>, firing_angle: f64) -> Path {
        let firing_angle = Slope::variable(firing_angle, 1);
        let start = self.crossing.start_lean.map_or(firing_angle, Slope::of);
        let turned = self.crossing.rate(leap.jump) * self.planner.robot().leg.delay;
        let radius = Slope::of(self.planner.robot().body.radius);
        let pivot = [start, firing_angle + Slope::of(turned)].map(|lean| {
            let (sin, cos) = lean.sin_cos();
            [radius * sin, radius * cos]
        });
        Path::through(&[pivot[0], pivot[1], [flight.vacuum.x, flight.vacuum.y]])
    }

    /// The way of the wheel in the stance; none without one.
    fn path(&self, leap: &Leap, decisions: [f64; 2]) -> Option<Path> {
        Path::new(
            &self.stance,
            &self.launch(leap, decisions),
            self.planner.robot().body.radius,
        )
    }

    /// The flight, the leg's reach at lift-off and the friction needed, from the derivatives' own
    /// stance.
    fn jump(&self, leap: &Leap, decisions: [f64; 2]) -> Option<(DragFlight<Slope>, Slope, Slope)> {
        let launch = self.launch(leap, decisions);
        let (end, needed) = if self.crossing.friction.is_some() {
            let (end, contact) = self.stance.contact(&launch).ok()?;
            (end, contact.friction_needed)
        } else {
            (self.stance.jump(&launch).ok()?, Dual::of(0.0))
        };
        let robot = self.planner.robot();
        let (gravity, drag) = (
            Dual::of(robot.axle_gravity()),
            Dual::of(robot.environment.drag),
        );
        let flight = widen_flight(&Jump::new(launch, end, gravity, drag).flight?);
        let reach = Dual::of(robot.body.radius) + end.extension;
        Some((flight, widen(reach), widen(needed)))
    }

    /// The jump's landing and margins; none where it does not reach the surface.
    fn try_fly(
        &self,
        leap: &Leap,
        foot: Slope,
        flown: &Flown,
        margins: &mut Vec<Margin<Slope>>,
    ) -> Option<Slope> {
        let (flight, reach, needed) = flown.jump?;
        let height = self.landing_height(leap);
        let landing = foot + flight.range_to_height(Slope::of(height)).ok()?;
        // The flight along the course, so that clearances know how the foothold moves.
        let mut along = flight;
        along.vacuum.x = along.vacuum.x + foot;
        for edge in &leap.edges {
            let gap = self.edge_gap(&along, edge.x, leap.from, edge.top, reach, height)?;
            let limit = Limit::Edge {
                obstacle: edge.obstacle,
                side: edge.side,
            };
            margins.push(Margin {
                limit,
                value: gap - Slope::of(self.crossing.clearance),
            });
        }
        let radius = Slope::of(self.planner.robot().body.radius);
        for edge in &leap.beside {
            let limit = Limit::Stance {
                obstacle: edge.obstacle,
                side: edge.side,
            };
            let mut distance = self
                .roughly(leap, &flight, flown.of[0])
                .distance(foot, leap.from, edge);
            if distance.value < radius.value + NEAR {
                let path = flown
                    .path
                    .get_or_init(|| self.path(leap, [flown.of[0], flown.of[1]]));
                distance = path.as_ref()?.distance(foot, leap.from, edge);
            }
            margins.push(Margin {
                limit,
                value: distance - radius,
            });
        }
        if let Some(friction) = self.crossing.friction {
            let value = Slope::of(friction) - needed;
            margins.push(Margin {
                limit: Limit::Robot("friction"),
                value,
            });
        }
        Some(landing)
    }

    /// Clearance (m) over the edge of a box. The path is concave, so that between two edges it is
    /// clear if it is over both.
    fn edge_gap(
        &self,
        flight: &DragFlight<Slope>,
        x: f64,
        from: f64,
        top: f64,
        reach: Slope,
        height: f64,
    ) -> Option<Slope> {
        let radius = self.planner.robot().body.radius;
        if flight.drag.value == 0.0 && self.crossing.leg_out == 0.0 {
            let vacuum = &flight.vacuum;
            let corner = [x, top - from];
            let landing = vacuum.time_to_height(Slope::of(height)).ok()?;
            let distance = vacuum.distance_to_point(corner, Slope::of(0.0), landing);
            // A centre that passes below the corner is inside the box: the distance counts as
            // negative.
            let passing = (corner[0] - vacuum.x.value) / vacuum.vx.value;
            let is_inside = (0.0..=landing.value).contains(&passing)
                && vacuum.position(Slope::of(passing))[1].value < corner[1];
            return Some(if is_inside { -distance } else { distance } - Slope::of(radius));
        }
        // A post a millimetre thin stands for the edge.
        let post = Solid::block([x - 5e-4, -from - 1e-3], [x + 5e-4, top - from]).ok()?;
        clearance(flight, self.crossing, radius, reach, &post, height)
    }

    /// Limits of every jump, in their order, for one that does not reach the surface.
    fn no_margins(&self, leap: &Leap, margins: &mut Vec<Margin<Slope>>) {
        let nothing = |limit| Margin {
            limit,
            value: Slope::of(f64::NAN),
        };
        margins.clear();
        let edges = leap.edges.iter().map(|e| Limit::Edge {
            obstacle: e.obstacle,
            side: e.side,
        });
        let beside = leap.beside.iter().map(|e| Limit::Stance {
            obstacle: e.obstacle,
            side: e.side,
        });
        margins.extend(edges.chain(beside).map(nothing));
        margins.extend(
            self.crossing
                .friction
                .map(|_| nothing(Limit::Robot("friction"))),
        );
    }
}

/// A number with its slopes by the two decisions, as one that could also depend on the foothold.
fn widen(x: Dual<2>) -> Slope {
    let [by_angle, by_opening] = x.slope;
    Slope {
        value: x.value,
        slope: [0.0, by_angle, by_opening],
    }
}

/// As [`widen`], for a flight.
fn widen_flight(flight: &DragFlight<Dual<2>>) -> DragFlight<Slope> {
    let Flight {
        x,
        y,
        vx,
        vy,
        gravity,
    } = flight.vacuum;
    let vacuum = Flight {
        x: widen(x),
        y: widen(y),
        vx: widen(vx),
        vy: widen(vy),
        gravity: widen(gravity),
    };
    DragFlight {
        vacuum,
        drag: widen(flight.drag),
    }
}

impl Jumper for Roller<'_> {
    fn decisions(&self, _: usize) -> [Span; 2] {
        [self.crossing.firing_angles, self.crossing.valve_open]
    }

    fn fly(
        &self,
        leap: &Leap,
        foot: Slope,
        [firing_angle, valve_open]: [Slope; 2],
        margins: &mut Vec<Margin<Slope>>,
    ) -> course::Flight<Slope> {
        let before = margins.len();
        let flown = self.flown(leap, [firing_angle.value, valve_open.value]);
        let landing = self.try_fly(leap, foot, &flown, margins);
        if landing.is_none() {
            margins.truncate(before);
            self.no_margins(leap, margins);
        }
        let landing = landing.unwrap_or(Slope::of(f64::NAN));
        let off = landing - Slope::of(self.crossing.target);
        let is_last = leap.jump + 1 == self.crossing.course.jumps;
        let weight = if is_last {
            self.crossing.deviation_weight
        } else {
            0.0
        };
        let cost = Slope::of(weight) * off * off
            + Slope::of(self.crossing.effort_weight) * valve_open * valve_open;
        course::Flight { landing, cost }
    }

    fn deviation(&self, leap: &Leap, [angle, open]: [f64; 2]) -> f64 {
        let launch = launch(self.crossing, leap.jump, angle, open);
        self.planner
            .landing_deviation(&self.sensitive, &launch, self.landing_height(leap))
    }

    fn window(&self, jump: usize) -> Span {
        let zone = self.crossing.zones.get(jump).copied().flatten();
        zone.map_or(Span::ALL, |zone| zone.widened(-self.crossing.edge_margin))
    }

    /// The sampled jump that misses the landing and the heights over the edges least, moved onto
    /// the landing where it lies between two samples and nothing is in the way; the valve closes at
    /// its lift-off, as later is waste.
    fn aim(&self, leap: &Leap, foot: f64, landing: f64) -> [f64; 2] {
        let wanted = landing - foot;
        let height = self.landing_height(leap);
        let samples = &self.samples[leap.jump][0];
        let points: Vec<(f64, f64, f64)> = samples
            .iter()
            .filter_map(|jump| {
                let distance = jump.distance(height)?;
                let short: f64 = leap
                    .edges
                    .iter()
                    .map(|edge| self.shortfall(leap, edge.x - foot, edge.top, jump))
                    .sum();
                Some((jump.launch.firing_angle, distance, short))
            })
            .collect();
        let free = points.windows(2).find(|w| {
            (w[0].1 - wanted) * (w[1].1 - wanted) <= 0.0
                && w[0].2 + w[1].2 <= 0.0
                && w[0].1 != w[1].1
        });
        let angle = match free {
            Some(&[a, b]) => a.0 + (b.0 - a.0) * (wanted - a.1) / (b.1 - a.1),
            _ => points
                .iter()
                .min_by(|a, b| {
                    let miss = |p: &(f64, f64, f64)| (p.1 - wanted).abs() + 10.0 * p.2;
                    miss(a).total_cmp(&miss(b))
                })
                .map_or(0.0, |p| p.0),
        };
        let used = samples
            .iter()
            .min_by(|a, b| {
                let off = |jump: &Jump| (jump.launch.firing_angle - angle).abs();
                off(a).total_cmp(&off(b))
            })
            .map_or(f64::INFINITY, |jump| {
                // A little earlier, where the opening time begins to matter.
                0.97 * (jump.stance.time - jump.stance.time_fire - self.planner.robot().leg.delay)
            });
        [angle, self.crossing.valve_open.clamp(used)]
    }

    fn envelope(&self, leap: &Leap, feet: Span, landings: Span, reach: Span) -> Option<Envelope> {
        let mut possible = Span::NONE;
        for (_, distance) in self
            .distances(leap, true)
            .chain(self.distances(leap, false))
        {
            possible = possible.hull(Span::point(distance));
        }
        // The samples may miss the ends of the range by a little.
        let possible = possible.widened(0.05 * possible.width());
        let span = possible.meet(landings - feet).meet(reach);
        if span.is_empty() {
            return None;
        }
        let is_last = leap.jump + 1 == self.crossing.course.jumps;
        let off = self.crossing.target - landings.meet(feet + span).clamp(self.crossing.target);
        let deviation = if is_last {
            self.crossing.deviation_weight * off * off
        } else {
            0.0
        };
        let effort = self.crossing.effort_weight;
        match self.grids.get(leap.jump) {
            Some(grid) => grid.envelope(&Within {
                height: self.landing_height(leap),
                rim: self.planner.robot().body.radius + self.crossing.clearance - leap.from,
                leap,
                feet,
                landings,
                reach: span,
                cost: [deviation, effort],
            }),
            None => Some(Envelope::level(
                span,
                deviation + effort * self.crossing.valve_open.low.powi(2),
            )),
        }
    }

    fn sketch(&self, leap: &Leap, foot: f64, landing: f64) -> Option<Sketch> {
        let rim = self.planner.robot().body.radius + self.crossing.clearance - leap.from;
        let grid = self.grids.get(leap.jump)?;
        let (decisions, deviation) =
            grid.sketch(leap, [foot, landing], self.landing_height(leap), rim)?;
        let is_last = leap.jump + 1 == self.crossing.course.jumps;
        let off = if is_last {
            landing - self.crossing.target
        } else {
            0.0
        };
        let cost = self.crossing.deviation_weight * off * off
            + self.crossing.effort_weight * decisions[1].powi(2);
        Some(Sketch {
            decisions,
            cost,
            deviation,
        })
    }

    fn edge_margin(&self, rise: f64) -> f64 {
        margin_beside(self.crossing, self.planner.robot().body.radius, rise)
    }

    fn zone_margin(&self) -> f64 {
        self.crossing.edge_margin
    }

    fn target(&self, goal: Span) -> f64 {
        goal.clamp(self.crossing.target)
    }

    fn girth(&self) -> f64 {
        2.0 * self.planner.robot().body.radius
    }

    fn roll(&self, _: usize) -> f64 {
        self.crossing.roll
    }
}

#[cfg(test)]
mod tests;
