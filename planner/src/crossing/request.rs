//! What is to be crossed, and how: the numbers of a course for the rolling robot.

use saltus_lagrangian::Launch;
use saltus_numeric::refused;

use super::CrossingError;
use crate::course::{self, Course, Span};
use crate::table::FIRING_ANGLES;

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

/// What a lean or a firing angle may be.
const UPRIGHT: &str = "between -pi/2 and pi/2 rad, exclusive";

/// Key and value of a number that is not allowed, and what is.
type Refused = (&'static str, f64, &'static str);

fn is_upright(x: f64) -> bool {
    x.abs() < std::f64::consts::FRAC_PI_2
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
    pub(super) fn rate(&self, jump: usize) -> f64 {
        self.rates[jump.min(self.rates.len() - 1)]
    }

    pub(super) fn check(&self) -> Result<(), CrossingError> {
        self.course.check()?;
        let refused = self.refused().or_else(|| self.refused_end());
        match refused.or_else(|| self.refused_start()) {
            Some((key, value, allowed)) => Err(CrossingError::Input {
                key,
                value,
                allowed,
            }),
            None => Ok(()),
        }
    }

    /// The first number that is not allowed.
    fn refused(&self) -> Option<Refused> {
        let (jumps, rates, zones) = (self.course.jumps, self.rates.len(), self.zones.len());
        let mut bad_rates = self
            .rates
            .iter()
            .filter(|rate| !(0.0..=1e3).contains(*rate));
        let rate = bad_rates.next().copied().unwrap_or(0.0);
        let lean = self.start_lean.unwrap_or(0.0);
        let (angles, valve) = (self.firing_angles, self.valve_open);
        let friction = self.friction.unwrap_or(0.0);
        let length = |x: f64| (0.0..=1e4).contains(&x);
        let weight = |x: f64| x >= 0.0 && x.is_finite();
        let (one_or_all, above) = ("1, or as many as there are jumps", "0 or above");
        let (later, longer) = (
            "above its least value, below pi/2 rad",
            "above its least value, to 10 s",
        );
        refused! {
            "approach_rate_rad_s (count)", rates as f64, rates == 1 || rates == jumps => one_or_all;
            "land (count)", zones as f64, zones <= jumps => "at most one for each jump";
            "approach_rate_rad_s", rate, (0.0..=1e3).contains(&rate) => "from 0 to 1000 rad/s";
            "start_lean_rad", lean, is_upright(lean) => UPRIGHT;
            "firing_angle_rad", angles.low, is_upright(angles.low) => UPRIGHT;
            "firing_angle_rad", angles.high, is_upright(angles.high) && angles.high > angles.low
                => later;
            "valve_open_s", valve.low, valve.low > 0.0 && valve.low <= 10.0 => "above 0, to 10 s";
            "valve_open_s", valve.high, valve.high > valve.low && valve.high <= 10.0 => longer;
            "target_x_m", self.target, self.target.abs() <= 1e4 => "from -10000 to 10000 m";
            "roll_m", self.roll, length(self.roll) => above;
            "clearance_m", self.clearance, length(self.clearance) => above;
            "edge_margin_m", self.edge_margin, length(self.edge_margin) => above;
            "leg_out_s", self.leg_out, length(self.leg_out) => above;
            "friction_coefficient", friction, length(friction) => above;
            "margin_sigmas", self.sigmas, length(self.sigmas) => above;
            "deviation_weight", self.deviation_weight, weight(self.deviation_weight) => above;
            "effort_weight", self.effort_weight, weight(self.effort_weight) => above;
        }
    }

    /// A start that is neither on the ground nor on a box, or a landing zone that runs backwards.
    fn refused_start(&self) -> Option<Refused> {
        let inside = |o: &course::Obstacle| {
            let under = o.span().widened(-1e-9).clamp(self.course.start) == self.course.start;
            under && self.course.start_height != o.height
        };
        let carries = |o: &course::Obstacle| o.span().clamp(self.course.start) == self.course.start;
        let is_in_the_air =
            self.course.start_height != 0.0 && !self.course.obstacles.iter().any(carries);
        if is_in_the_air || self.course.obstacles.iter().any(inside) {
            let allowed = "the height of the obstacle on which the start is, or 0 on the ground";
            return Some(("start_height_m", self.course.start_height, allowed));
        }
        let zone = self
            .zones
            .iter()
            .flatten()
            .find(|z| z.is_empty() || !z.low.is_finite() || !z.high.is_finite())?;
        let allowed = "finite and not before its from_x_m";
        Some(("land.to_x_m", zone.high, allowed))
    }

    /// A goal or landing zone without room between its margins.
    fn refused_end(&self) -> Option<Refused> {
        let narrow = |span: Span| span.width() > 0.0 && span.width() <= 2.0 * self.edge_margin;
        let wider = "more than 2 edge_margin_m beyond its beginning";
        let ends = [("goal_to_x_m", Some(self.course.goal))].into_iter();
        let mut ends = ends.chain(self.zones.iter().map(|zone| ("land.to_x_m", *zone)));
        let (key, span) = ends.find(|(_, span)| span.is_some_and(narrow))?;
        Some((key, span?.high, wider))
    }

    /// The launch of jump number `jump`.
    pub(super) fn launch(&self, jump: usize, [firing_angle, valve_open]: [f64; 2]) -> Launch {
        Launch {
            rate: self.rate(jump),
            lean: self.start_lean.unwrap_or(firing_angle),
            firing_angle,
            valve_open,
        }
    }

    /// Least distance (m) of a landing from an obstacle that rises by `rise` (m) above it: the edge
    /// margin, and room for the rim of a wheel of this `radius` (m) with its clearance.
    pub(super) fn margin_beside(&self, radius: f64, rise: f64) -> f64 {
        let reach = radius + self.clearance;
        let above = (radius - rise).max(0.0);
        let rim = if rise > 0.0 {
            (reach * reach - above * above).max(0.0).sqrt()
        } else {
            0.0
        };
        rim.max(self.edge_margin)
    }

    /// The part of the surface of height `to` around `landing` (m) on which a wheel of this
    /// `radius` (m) may land.
    pub(super) fn ground(&self, radius: f64, landing: f64, to: f64) -> Span {
        let mut span = Span::ALL;
        let mut exclude = |area: Span, kept: Span| {
            if landing >= f64::midpoint(area.low, area.high) {
                span.low = span.low.max(kept.high);
            } else {
                span.high = span.high.min(kept.low);
            }
        };
        for area in &self.course.no_landing {
            let kept = area.widened(self.edge_margin);
            exclude(kept, kept);
        }
        for obstacle in &self.course.obstacles {
            let (body, rise) = (obstacle.span(), obstacle.height - to);
            if rise > 0.0 {
                exclude(body, body.widened(self.margin_beside(radius, rise)));
            }
        }
        for obstacle in &self.course.obstacles {
            let body = obstacle.span();
            if obstacle.height == to && landing >= body.low && landing <= body.high {
                span = span.meet(body.widened(-self.edge_margin));
            }
        }
        span
    }
}
