//! What is verified: the plan of a course, a table or a law.

use saltus_lagrangian::Launch;
use saltus_planner::{Crossing, CrossingPlan};

use super::Task;

/// What is verified.
#[derive(Clone, Debug)]
pub enum Subject {
    /// A course and its plan.
    Plan {
        /// The course.
        crossing: Box<Crossing>,
        /// Its plan.
        plan: Box<CrossingPlan>,
    },
    /// A rule for the firing angle.
    Rule(Rule),
}

/// A firing angle for every approach rate.
#[derive(Clone, Debug, PartialEq)]
pub struct Rule {
    /// The rule.
    pub steering: Steering,
    /// Rates (rad/s) of the jumps without errors; the others are between the least and the
    /// greatest.
    pub rates: Vec<f64>,
    /// Where it should land (m); none: where planned.
    pub distance: Option<f64>,
    /// Height (m) of the axle above the foothold at which it lands.
    pub landing_height: f64,
    /// Valve opening time (s).
    pub valve_open: f64,
    /// Lean at the start (rad); none: the stance starts at its firing angle.
    pub start_lean: Option<f64>,
    /// Boxes in the way: front, back and top (m from the foothold).
    pub obstacles: Vec<[f64; 3]>,
}

/// How a firing angle follows from an approach rate.
#[derive(Clone, Debug, PartialEq)]
pub enum Steering {
    /// A straight line.
    Law {
        /// Change of the angle with the rate (s).
        slope: f64,
        /// Angle (rad) at no rate.
        intercept: f64,
    },
    /// Rates (rad/s) and angles (rad), rates ascending.
    Table(Vec<(f64, f64)>),
}

impl Subject {
    /// The plan of a course.
    pub fn plan(crossing: Crossing, plan: CrossingPlan) -> Subject {
        Subject::Plan {
            crossing: Box::new(crossing),
            plan: Box::new(plan),
        }
    }

    /// Jumps of a run.
    pub fn jumps(&self) -> usize {
        match self {
            Subject::Plan { plan, .. } => plan.jumps.len(),
            Subject::Rule(_) => 1,
        }
    }

    /// Whether it is the plan of a course.
    pub fn is_plan(&self) -> bool {
        matches!(self, Subject::Plan { .. })
    }
}

impl Rule {
    /// The jump at an approach rate (rad/s).
    pub fn task(&self, rate: f64) -> Task {
        let firing_angle = self.steering.angle(rate);
        let lean = self.start_lean.unwrap_or(firing_angle);
        Task {
            launch: Launch {
                rate,
                lean,
                firing_angle,
                valve_open: self.valve_open,
            },
            landing_height: self.landing_height,
            obstacles: self.obstacles.clone(),
            leg_out: 0.0,
        }
    }
}

impl Steering {
    /// The firing angle (rad) at a rate (rad/s). A table is linear between its rates, and ends with
    /// its last segments.
    pub fn angle(&self, rate: f64) -> f64 {
        match self {
            Steering::Law { slope, intercept } => slope * rate + intercept,
            Steering::Table(points) => {
                let after = points
                    .partition_point(|(r, _)| *r < rate)
                    .clamp(1, points.len().max(2) - 1);
                match (points.get(after - 1), points.get(after)) {
                    (Some(a), Some(b)) => a.1 + (b.1 - a.1) * (rate - a.0) / (b.0 - a.0),
                    _ => points[0].1,
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_linear_between_and_beyond_their_rates() {
        let table = Steering::Table(vec![(3.0, 0.0), (4.0, -0.1), (6.0, -0.5)]);
        for (rate, angle) in [
            (3.0, 0.0),
            (3.5, -0.05),
            (4.0, -0.1),
            (5.0, -0.3),
            (6.0, -0.5),
            (2.0, 0.1),
            (7.0, -0.7),
        ] {
            assert!((table.angle(rate) - angle).abs() < 1e-12, "{rate}");
        }
        assert_eq!(Steering::Table(vec![(3.0, 0.2)]).angle(5.0), 0.2);
    }
}
