//! A one-leg hopper on a boom that crosses obstacle courses, as a [`Jumper`]: launch speed and
//! angle are free, and the total flight time is to be least. Its published problems validate the
//! planner's branch and bound.
//!
//! Decided are the distance D of a jump, foothold to foothold, and its launch angle θ; the landing
//! is then linear in the decisions, and time and speed follow in closed form. With the flight from
//! p = foothold + ℓ (cos θ, sin θ) + f over the length L = D − p_x and the rise H = surface − p_z:
//!
//! ```text
//! t = √(2 (L tan θ − H) / g)      v = L / (t cos θ)
//! height over a point e ahead of p:  p_z + e tan θ − (e/L)² (L tan θ − H)
//! ```
//!
//! Time, speed and all heights grow with θ at a given distance: a jump from here to there is
//! fastest at the lowest θ that its clearances and the least speed allow.
//!
//! Source: README.md and check.py of the problem set (Albracht, Kumar, Vyas, 'Model Predictive
//! Parkour Control of a Monoped Hopper in Dynamically Changing Environments', RA-L 2024).

use saltus_numeric::root::Bracket;
use saltus_numeric::{Scalar, Single};
use saltus_planner::course::{
    Course, Edge, Envelope, Flight, Jump, Jumper, Leap, Limit, Margin, Obstacle, Side, Slope, Span,
};
use serde_json::Value;

/// A course and the flight time that its own planner found.
#[derive(Clone, Debug)]
pub struct Problem {
    /// The course.
    pub course: Course,
    /// Total flight time (s) of the published plan.
    pub published: f64,
}

/// The 58 published problems.
///
/// # Panics
/// If the reference file is not what its README says.
pub fn published() -> Vec<Problem> {
    problems(include_str!("../reference/parkour-hopper/instances.json"))
}

/// The problems that `text` (JSON) lists.
///
/// # Panics
/// If `text` is not of the form of the published ones.
pub fn problems(text: &str) -> Vec<Problem> {
    let file: Value = serde_json::from_str(text).expect("JSON");
    list(&file, "instances").iter().map(problem).collect()
}

fn problem(i: &Value) -> Problem {
    let course = Course {
        id: i["id"].as_str().expect("a name").into(),
        start: number(i, "start_x_m"),
        start_height: number(i, "start_height_m"),
        jumps: i["jumps"]
            .as_u64()
            .and_then(|n| n.try_into().ok())
            .expect("a count"),
        goal: Span::point(number(i, "goal_x_m")),
        obstacles: list(i, "obstacles").iter().map(obstacle).collect(),
        no_landing: list(i, "no_landing").iter().map(area).collect(),
    };
    Problem {
        course,
        published: number(&i["published"], "total_flight_time_s"),
    }
}

fn obstacle(o: &Value) -> Obstacle {
    Obstacle {
        center: number(o, "center_x_m"),
        width: number(o, "width_m"),
        height: number(o, "height_m"),
    }
}

fn area(a: &Value) -> Span {
    let (center, half) = (number(a, "center_x_m"), number(a, "width_m") / 2.0);
    Span::new(center - half, center + half)
}

fn list<'a>(of: &'a Value, key: &str) -> &'a [Value] {
    of[key].as_array().unwrap_or_else(|| panic!("{key}"))
}

fn number(of: &Value, key: &str) -> f64 {
    of[key].as_f64().unwrap_or_else(|| panic!("{key}"))
}

/// The hopper. Its nominal values, [`Hopper::default`], are those of the published experiments.
#[derive(Clone, Debug, PartialEq)]
pub struct Hopper {
    /// Gravity g (m/s²), > 0.
    pub gravity: f64,
    /// Length of the leg at take-off ℓ (m), > 0.
    pub leg: f64,
    /// From the hip to the point that flies, the foot in its flight pose, and then mirrored: f (m).
    pub foot: [f64; 2],
    /// From the flying foot to the knee (m).
    pub knee: [f64; 2],
    /// Launch speed v (m/s), > 0.
    pub speed: Span,
    /// Launch angle θ (rad) above the ground, above the angle of the longest jump and below a right
    /// angle.
    pub angle: Span,
    /// Flight time t (s), > 0.
    pub time: Span,
    /// Height (m) over an edge at which foot and knee pass it at least, ≥ 0.
    pub clearance: f64,
    /// Least distance (m) of a landing from an obstacle's edge, ≥ 0.
    pub edge_margin: f64,
}

impl Default for Hopper {
    fn default() -> Hopper {
        let (leg_in_flight, link, pose) = (0.17_f64, 0.15, 94_f64.to_radians());
        let shank = std::f64::consts::PI - pose - (leg_in_flight / (2.0 * link)).acos();
        Hopper {
            gravity: 8.0665,
            leg: 0.19,
            foot: [-leg_in_flight * pose.cos(), -leg_in_flight * pose.sin()],
            knee: [-link * shank.cos(), link * shank.sin()],
            speed: Span::new(1.5, 2.7),
            angle: Span::new(65_f64.to_radians(), 85_f64.to_radians()),
            time: Span::new(0.2, 3.0),
            clearance: 0.05,
            edge_margin: 0.03,
        }
    }
}

/// A jump in the terms of the hopper's own planner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Takeoff {
    /// Flight time t (s).
    pub flight_time: f64,
    /// Launch speed v (m/s).
    pub speed: f64,
    /// Launch angle θ (rad).
    pub angle: f64,
}

/// A flight over a distance at a launch angle; positions from the foothold.
struct Arc<S> {
    /// tan θ.
    tan: S,
    /// Where the flight starts: ahead of the foothold, and above the ground (m).
    start: [S; 2],
    /// Length L (m).
    length: S,
    /// L tan θ − H (m): how far it falls below its tangent.
    fall: S,
    /// Flight time (s).
    time: S,
    /// Launch speed (m/s).
    speed: S,
}

impl Hopper {
    /// The jump as launch speed, launch angle and flight time.
    pub fn launch(&self, jump: &Jump) -> Takeoff {
        let [distance, angle] = jump.decisions;
        let arc = self.arc(&jump.leap, distance, angle);
        Takeoff {
            flight_time: arc.time,
            speed: arc.speed,
            angle,
        }
    }

    fn start<S: Single>(&self, leap: &Leap, (sin, cos): (S, S)) -> [S; 2] {
        let [x, z] = self.foot.map(S::of);
        let leg = S::of(self.leg);
        [leg * cos + x, leg * sin + z + S::of(leap.from)]
    }

    fn arc<S: Single>(&self, leap: &Leap, distance: S, angle: S) -> Arc<S> {
        let (sin, cos) = angle.sin_cos();
        let start = self.start(leap, (sin, cos));
        let tan = sin / cos;
        let length = distance - start[0];
        let fall = length * tan + start[1] - S::of(leap.to);
        let time = (fall * S::of(2.0 / self.gravity)).sqrt();
        Arc {
            tan,
            start,
            length,
            fall,
            time,
            speed: length / (time * cos),
        }
    }

    /// What passes an edge: the flying foot at a front edge, the knee at a back edge (m from the
    /// flying foot).
    fn passing(&self, edge: &Edge) -> [f64; 2] {
        match edge.side {
            Side::Front => [0.0, 0.0],
            Side::Back => self.knee,
        }
    }

    /// Clearance (m) over an edge beyond what is required.
    fn over<S: Single>(&self, edge: &Edge, foot: S, arc: &Arc<S>) -> S {
        let [x, z] = self.passing(edge);
        let ahead = S::of(edge.x - x) - foot - arc.start[0];
        let part = ahead / arc.length;
        arc.start[1] + ahead * arc.tan - part * part * arc.fall
            + S::of(z - edge.top - self.clearance)
    }

    /// The most clearance (m) beyond what is required that a jump at `angle` from within `feet` to
    /// within `landings` can have over all its edges; exact where both are points.
    ///
    /// With a point e ahead of the start and r = L − e before the end, the height is
    /// p_z + tan θ · e r/(e + r) + H (e/(e + r))²; the first product grows with e and with r.
    fn most_over(&self, leap: &Leap, feet: Span, landings: Span, furthest: f64, angle: f64) -> f64 {
        let (sin, cos) = Scalar::sin_cos(angle);
        let [px, pz] = self.start(leap, (sin, cos));
        let rise = leap.to - pz;
        let over = |edge: &Edge| {
            let [x, z] = self.passing(edge);
            let ahead = Span::point(edge.x - x - px) - feet;
            let behind = landings - Span::point(edge.x - x);
            if ahead.low + behind.low <= 0.0 {
                return f64::INFINITY;
            }
            // The product is greatest half way, as far as there is room.
            let length = (ahead.high + behind.high).min(furthest - px);
            let part = Span::new(length - behind.high, ahead.high).clamp(0.5 * length);
            let product = part * (length - part) / length;
            let square = |e: f64, r: f64| (e / (e + r)).powi(2);
            let corners = [
                square(ahead.low, behind.low),
                square(ahead.low, behind.high),
                square(ahead.high, behind.low),
                square(ahead.high, behind.high),
            ];
            let most = if rise > 0.0 {
                corners.into_iter().fold(0.0, f64::max)
            } else if ahead.low < 0.0 && ahead.high > 0.0 {
                0.0
            } else {
                corners.into_iter().fold(f64::INFINITY, f64::min)
            };
            pz + sin / cos * product + rise * most + z - edge.top - self.clearance
        };
        leap.edges.iter().map(over).fold(f64::INFINITY, f64::min)
    }

    /// How much further (m) a flight falls below its tangent than one that lands at its apex, L tan
    /// θ − 2 H.
    fn descent(&self, leap: &Leap, distance: f64, angle: f64) -> f64 {
        let (sin, cos) = Scalar::sin_cos(angle);
        let start = self.start(leap, (sin, cos));
        (distance - start[0]) * sin / cos + 2.0 * (start[1] - leap.to)
    }

    /// Lowest launch angle (rad) from `low` up at which `margin`, which grows with the angle, is
    /// not negative.
    fn steepen(&self, low: f64, margin: impl Fn(f64) -> f64) -> Option<f64> {
        let high = self.angle.high;
        let at_low = margin(low);
        if at_low >= 0.0 {
            return Some(low);
        }
        let at_high = margin(high);
        (at_high >= 0.0).then(|| rising_root(margin, (low, at_low), (high, at_high)))
    }

    /// Distance (m) of a jump at a speed and an angle; none if it does not get as high as the
    /// landing.
    fn distance(&self, leap: &Leap, speed: f64, angle: f64) -> Option<f64> {
        let (sin, cos) = Scalar::sin_cos(angle);
        let start = self.start(leap, (sin, cos));
        let up = speed * sin;
        let square = up * up + 2.0 * self.gravity * (start[1] - leap.to);
        (square >= 0.0).then(|| start[0] + speed * cos * (up + square.sqrt()) / self.gravity)
    }

    /// Whether jumps at `speed` get shorter with every launch angle above `angle`: the longest is
    /// at tan θ = v/√(v² − 2 g H).
    fn past_longest(&self, leap: &Leap, speed: f64, angle: f64) -> bool {
        // The start moves with the angle, by less than a hundredth of a radian's worth.
        let (sin, cos) = Scalar::sin_cos(angle - 0.01);
        let square =
            speed * speed + 2.0 * self.gravity * (self.start(leap, (sin, cos))[1] - leap.to);
        square > 0.0 && square * sin * sin > speed * speed * cos * cos
    }

    /// Distances (m) within which all jumps at `angle` or steeper lie.
    fn reach(&self, leap: &Leap, angle: f64) -> Option<Span> {
        let (speed, steepest) = (self.speed, self.angle.high);
        // At least up to the apex: v² sin 2θ/2g.
        let up = speed.low * speed.low * (2.0 * steepest).sin() / (2.0 * self.gravity);
        let to_apex = self.start(leap, Scalar::sin_cos(steepest))[0] + up;
        let shortest = self.distance(leap, speed.low, steepest);
        let low = shortest
            .filter(|_| self.past_longest(leap, speed.low, angle))
            .unwrap_or(to_apex);
        let high = if self.past_longest(leap, speed.high, angle) {
            self.distance(leap, speed.high, angle)?
        } else {
            // The longest jump at any angle: v √(v² − 2 g H)/g.
            let ahead = self.start(leap, Scalar::sin_cos(angle))[0];
            let above = self.start(leap, Scalar::sin_cos(steepest))[1];
            let square = speed.high * speed.high + 2.0 * self.gravity * (above - leap.to);
            if square < 0.0 {
                return None;
            }
            ahead + speed.high * square.sqrt() / self.gravity
        };
        Some(Span::new(low, high))
    }

    /// Speed (m/s) above the least one; negative too where the landing is above the launch's
    /// tangent.
    fn excess_speed(&self, arc: &Arc<f64>) -> f64 {
        if arc.fall > 0.0 {
            arc.speed - self.speed.low
        } else {
            -self.speed.low
        }
    }

    /// Least time (s) over a distance at `angle` or steeper, with the least speed.
    fn least_time(&self, leap: &Leap, distance: f64, angle: f64) -> f64 {
        let slow = |angle: f64| self.excess_speed(&self.arc(leap, distance, angle));
        let angle = self.steepen(angle, slow).unwrap_or(self.angle.high);
        let time = self.arc(leap, distance, angle).time;
        if time.is_finite() { time } else { 0.0 }
    }
}

impl Jumper for Hopper {
    fn decisions(&self, _jump: usize) -> [Span; 2] {
        [
            Span::new(
                0.0,
                self.leg + self.speed.high * self.angle.low.cos() * self.time.high,
            ),
            self.angle,
        ]
    }

    fn fly(
        &self,
        leap: &Leap,
        foot: Slope,
        [distance, angle]: [Slope; 2],
        margins: &mut Vec<Margin<Slope>>,
    ) -> Flight<Slope> {
        let arc = self.arc(leap, distance, angle);
        let mut robot = |name, value| {
            margins.push(Margin {
                limit: Limit::Robot(name),
                value,
            });
        };
        robot("least launch speed", arc.speed - Slope::of(self.speed.low));
        robot(
            "greatest launch speed",
            Slope::of(self.speed.high) - arc.speed,
        );
        robot(
            "landing from above",
            arc.fall + arc.start[1] - Slope::of(leap.to),
        );
        robot("least flight time", arc.time - Slope::of(self.time.low));
        robot("greatest flight time", Slope::of(self.time.high) - arc.time);
        for edge in &leap.edges {
            let limit = Limit::Edge {
                obstacle: edge.obstacle,
                side: edge.side,
            };
            margins.push(Margin {
                limit,
                value: self.over(edge, foot, &arc),
            });
        }
        Flight {
            landing: foot + distance,
            cost: arc.time,
        }
    }

    fn aim(&self, leap: &Leap, foot: f64, landing: f64) -> [f64; 2] {
        let distance = landing - foot;
        let margin = |angle: f64| {
            let arc = self.arc(leap, distance, angle);
            let robot = self
                .excess_speed(&arc)
                .min(arc.time - self.time.low)
                .min(self.descent(leap, distance, angle));
            self.most_over(
                leap,
                Span::point(foot),
                Span::point(landing),
                distance,
                angle,
            )
            .min(robot)
        };
        [
            distance,
            self.steepen(self.angle.low, margin)
                .unwrap_or(self.angle.high),
        ]
    }

    /// At a given launch angle the time grows concavely with the distance, and so it falls at the
    /// least speed: chords bound it from below.
    fn envelope(&self, leap: &Leap, feet: Span, landings: Span, reach: Span) -> Option<Envelope> {
        let furthest = reach.high.min(landings.high - feet.low);
        let angle = if leap.edges.is_empty() && leap.to <= leap.from {
            self.angle.low
        } else {
            self.steepen(self.angle.low, |angle| {
                self.most_over(leap, feet, landings, furthest, angle)
                    .min(self.descent(leap, furthest, angle))
            })?
        };
        let Span { low, high } = self.reach(leap, angle)?.meet(reach).meet(landings - feet);
        if low > high {
            return None;
        }
        let least = |distance| [distance, self.least_time(leap, distance, angle)];
        let slowest = self
            .distance(leap, self.speed.low, angle)
            .filter(|_| self.past_longest(leap, self.speed.low, angle));
        Some(match slowest {
            Some(middle) if low < middle && middle < high => Envelope::new(&[
                least(low),
                [middle, self.arc(leap, middle, angle).time],
                least(high),
            ]),
            _ => Envelope::new(&[least(low), least(high)]),
        })
    }

    fn edge_margin(&self, _: f64) -> f64 {
        self.edge_margin
    }
}

/// Where a rising function crosses zero between a point (x, f) with f < 0 and one with f ≥ 0; from
/// the side where it is not negative.
fn rising_root(f: impl Fn(f64) -> f64, below: (f64, f64), above: (f64, f64)) -> f64 {
    const ROUND_OFF: f64 = 1e-15;
    let mut bracket = Bracket::new(below, above);
    for _ in 0..60 {
        let x = bracket.secant();
        let y = f(x);
        if y.abs() <= ROUND_OFF {
            return x;
        }
        bracket.take(x, y);
        let (below, above) = bracket.places();
        if above - below <= ROUND_OFF {
            break;
        }
    }
    bracket.places().1
}
