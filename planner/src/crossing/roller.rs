//! The rolling robot as a [`Jumper`]: what its decisions come to, and where to start.

use std::cell::{OnceCell, RefCell};
use std::rc::Rc;

use saltus_ballistic::Obstacle as Solid;
use saltus_lagrangian::Launch;
use saltus_numeric::{Dual, Scalar};

use super::Crossing;
use super::check::clearance;
use super::grid::{APART, Grid, Wanted, Within, pushed};
use super::stance::Path;
use crate::course::{self, Edge, Envelope, Jumper, Leap, Limit, Margin, Push, Sketch, Slope, Span};
use crate::flight::JumpFlight;
use crate::jump::Jump;
use crate::model::{JumpModel, Steered, widen};
use crate::planner::Planner;

/// A wheel that is farther than this (m) from what is beside its foothold, at three places of the
/// stance, does not touch it; how near a wheel that is nearer comes, the whole stance says.
pub(super) const NEAR: f64 = 0.03;

/// Results of a stance that are remembered for each jump: where the solver is, and a difference for
/// each decision.
const REMEMBERED: usize = 3;

/// The robot as a [`Jumper`]: decisions are firing angle (rad) and valve opening time (s).
pub(super) struct Roller<'a> {
    planner: &'a Planner<dyn JumpModel>,
    crossing: &'a Crossing,
    /// For each jump its flights over angles and valve times.
    grids: Vec<Rc<Grid>>,
    /// For each jump what came of its last decisions. A foothold changes nothing but the place of a
    /// jump, and so the solver's differences cost one stance for each decision and not one for each
    /// jump and decision.
    remembered: RefCell<Vec<Vec<Rc<Decided>>>>,
}

/// What came of a jump's decisions, wherever its foothold is.
struct Decided {
    /// Firing angle (rad), valve opening time (s) and landing height (m).
    of: [f64; 3],
    /// How it is to push.
    push: Push,
    /// By how much (s) the valve pushes as it is to; negative where it does not.
    valve: Slope,
    /// The jump; none where the robot does not fly.
    jump: Option<Steered>,
    /// The way of the wheel in the stance, once it was asked for; none without a stance.
    path: OnceCell<Option<Path>>,
}

impl<'a> Roller<'a> {
    pub(super) fn new(planner: &'a Planner<dyn JumpModel>, crossing: &'a Crossing) -> Roller<'a> {
        let jumps = crossing.course.jumps;
        // Jumps at the same rate share their samples.
        let mut grids: Vec<Rc<Grid>> = Vec::new();
        let twin = |jump: usize| (0..jump).find(|&k| crossing.rate(k) == crossing.rate(jump));
        for jump in 0..jumps {
            let grid = || Rc::new(Grid::new(planner, crossing, jump));
            grids.push(twin(jump).map_or_else(grid, |k| grids[k].clone()));
        }
        let remembered = RefCell::new((0..jumps).map(|_| Vec::new()).collect());
        Roller {
            planner,
            crossing,
            grids,
            remembered,
        }
    }

    /// Height (m) of the wheel's centre above the foot at the landing.
    fn landing_height(&self, leap: &Leap) -> f64 {
        self.planner.robot().body.radius + leap.to - leap.from
    }

    /// Clearance (m) that an edge asks for: the landing on a box is a touch.
    fn clearance(&self, leap: &Leap, edge: &Edge) -> f64 {
        if leap.lands_on(edge) {
            0.0
        } else {
            self.crossing.clearance
        }
    }

    /// As [`Within::rim`].
    fn rim(&self, leap: &Leap) -> [f64; 2] {
        let touching = self.planner.robot().body.radius - leap.from;
        [touching + self.crossing.clearance, touching]
    }

    /// By how much (m) the wheel's rim is too low where its centre is over `x` (m from the
    /// foothold): a cheap stand-in for the clearance, for starting points.
    fn shortfall(&self, leap: &Leap, x: f64, edge: &Edge, jump: &Jump) -> f64 {
        let Some(flight) = jump.flight.as_ref().map(JumpFlight::parabola) else {
            return 1.0;
        };
        let [_, y] = flight.position(((x - flight.x) / flight.vx).max(0.0));
        let rim = self.planner.robot().body.radius + self.clearance(leap, edge);
        let needed = edge.top - leap.from + rim;
        (needed - y).max(0.0)
    }

    /// What comes of a jump's decisions.
    fn flown(&self, leap: &Leap, decisions: [f64; 2]) -> Rc<Decided> {
        let height = self.landing_height(leap);
        let of = [decisions[0], decisions[1], height];
        let known = self.remembered.borrow()[leap.jump]
            .iter()
            .find(|flown| flown.of == of && flown.push == leap.push)
            .cloned();
        known.unwrap_or_else(|| {
            let flown = Rc::new(self.fly_out(leap, of));
            let mut remembered = self.remembered.borrow_mut();
            remembered[leap.jump].insert(0, flown.clone());
            remembered[leap.jump].truncate(REMEMBERED);
            flown
        })
    }

    fn fly_out(&self, leap: &Leap, of: [f64; 3]) -> Decided {
        let fly = |open: Dual<2>| {
            let launch = Launch {
                valve_open: open,
                ..self.launch(leap, [of[0], of[1]])
            };
            let with_friction = self.crossing.friction.is_some();
            self.planner.model().steered(&launch, with_friction)
        };
        let open = Dual::variable(of[1], 1);
        let mut jump = fly(open);
        let spare = |jump: &Option<Steered>| jump.as_ref().map(|jump| jump.spare);
        let mut valve = spare(&jump);
        // A push to the end of the stance is the same however much longer the valve is open, and so it
        // is known where the valve is open too short for it.
        let longest = Dual::of(self.crossing.valve_open.high);
        if leap.push == Push::Whole && valve.is_some_and(|valve| valve.value < 0.0) {
            jump = fly(longest);
            valve = spare(&jump).map(|spare| spare + widen(open - longest));
        }
        let apart = Slope::of(APART);
        let valve = valve.unwrap_or(Slope::of(f64::NAN));
        Decided {
            of,
            push: leap.push,
            valve: match leap.push {
                Push::Any => Slope::of(0.0),
                Push::Whole => valve - apart,
                Push::Part | Push::Short => Slope::of(0.0) - valve - apart,
            },
            jump,
            path: OnceCell::new(),
        }
    }

    /// The launch with these decisions, with its valve time moved to where the jump pushes as it is to.
    fn pushing(&self, leap: &Leap, decisions: [f64; 2]) -> Launch {
        let launch = self.crossing.launch(leap.jump, decisions);
        if leap.push == Push::Any {
            return launch;
        }
        let spare = self.spare(&launch).unwrap_or(0.0);
        let valve_open = match leap.push {
            Push::Whole if spare < APART => self.crossing.valve_open.high,
            Push::Part | Push::Short if spare > -APART => launch.valve_open - spare - APART,
            _ => launch.valve_open,
        };
        Launch {
            valve_open,
            ..launch
        }
    }

    /// How much longer (s) than the stance the valve is open; none without a jump.
    fn spare(&self, launch: &Launch) -> Option<f64> {
        let jump = self.planner.jump(launch).ok()?;
        Some(self.planner.model().spare(&jump))
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
    fn roughly(&self, leap: &Leap, lift_off: [Slope; 2], firing_angle: f64) -> Path {
        let firing_angle = Slope::variable(firing_angle, 1);
        let start = self.crossing.start_lean.map_or(firing_angle, Slope::of);
        let turned = self.crossing.rate(leap.jump) * self.planner.robot().leg.opening_delay();
        let radius = Slope::of(self.planner.robot().body.radius);
        let pivot = [start, firing_angle + Slope::of(turned)].map(|lean| {
            let (sin, cos) = lean.sin_cos();
            [radius * sin, radius * cos]
        });
        Path::through(&[pivot[0], pivot[1], lift_off])
    }

    /// The way of the wheel in the stance; none without one.
    fn path(&self, leap: &Leap, decisions: [f64; 2]) -> Option<Path> {
        let model = self.planner.model();
        Some(Path::new(model.steered_way(&self.launch(leap, decisions))?))
    }

    /// The jump's landing and margins; none where it does not reach the surface.
    fn try_fly(
        &self,
        leap: &Leap,
        foot: Slope,
        flown: &Decided,
        margins: &mut Vec<Margin<Slope>>,
    ) -> Option<Slope> {
        let jump = flown.jump.as_ref()?;
        let height = self.landing_height(leap);
        let landing = foot + jump.flight.range_to_height(Slope::of(height)).ok()?;
        // The flight along the course, so that clearances know how the foothold moves.
        let along = jump.flight.shifted(foot);
        let radius = Slope::of(self.planner.robot().body.radius);
        let reach = radius + jump.extension;
        for edge in &leap.edges {
            let gap = self.edge_gap(&along, edge.x, leap.from, edge.top, reach, height)?;
            let limit = Limit::Edge {
                obstacle: edge.obstacle,
                side: edge.side,
            };
            margins.push(Margin {
                limit,
                value: gap - Slope::of(self.clearance(leap, edge)),
            });
        }
        for edge in &leap.beside {
            let limit = Limit::Stance {
                obstacle: edge.obstacle,
                side: edge.side,
            };
            let mut distance = self
                .roughly(leap, jump.axle, flown.of[0])
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
        if let Some((friction, needed)) = self.crossing.friction.zip(jump.friction_needed) {
            let value = Slope::of(friction) - needed;
            margins.push(Margin {
                limit: course::FRICTION,
                value,
            });
        }
        if leap.push != Push::Any {
            margins.push(Margin {
                limit: Limit::Robot("valve"),
                value: flown.valve,
            });
        }
        Some(landing)
    }

    /// Clearance (m) over the edge of a box. The path is concave, so that between two edges it is
    /// clear if it is over both.
    fn edge_gap(
        &self,
        flight: &JumpFlight<Slope>,
        x: f64,
        from: f64,
        top: f64,
        reach: Slope,
        height: f64,
    ) -> Option<Slope> {
        let radius = self.planner.robot().body.radius;
        // A centre that passes below the corner is inside the box: the distance counts as negative.
        if self.crossing.leg_out == 0.0
            && let Some(distance) = flight.over_corner([x, top - from], Slope::of(height))
        {
            return Some(distance - Slope::of(radius));
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
        margins.extend(self.crossing.friction.map(|_| nothing(course::FRICTION)));
        if leap.push != Push::Any {
            margins.push(nothing(Limit::Robot("valve")));
        }
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

    fn deviation(&self, leap: &Leap, decisions: [f64; 2]) -> f64 {
        let launch = self.pushing(leap, decisions);
        self.planner
            .landing_deviation(&launch, self.landing_height(leap))
    }

    fn push(&self, leap: &Leap, decisions: [f64; 2]) -> Push {
        if !self.planner.robot().leg.drive.has_valve() {
            return Push::Any;
        }
        let launch = self.crossing.launch(leap.jump, decisions);
        self.planner.jump(&launch).map_or(Push::Any, |jump| {
            let outlasts = self.planner.model().spare(&jump) >= 0.0;
            let row = if outlasts { Push::Whole } else { Push::Part };
            pushed(row, jump.stance.outcome)
        })
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
        let short = |jump: &Jump| -> f64 {
            let edges = leap.edges.iter();
            edges
                .map(|edge| self.shortfall(leap, edge.x - foot, edge, jump))
                .sum()
        };
        let points: Vec<([f64; 2], f64, f64)> = self.grids[leap.jump]
            .longest(self.landing_height(leap))
            .map(|(decisions, jump, distance)| (decisions, distance, short(jump)))
            .collect();
        let free = points.windows(2).find(|w| {
            (w[0].1 - wanted) * (w[1].1 - wanted) <= 0.0
                && w[0].2 + w[1].2 <= 0.0
                && w[0].1 != w[1].1
        });
        if let Some(&[a, b]) = free {
            let part = (wanted - a.1) / (b.1 - a.1);
            return [0, 1].map(|i| a.0[i] + part * (b.0[i] - a.0[i]));
        }
        let miss = |p: &([f64; 2], f64, f64)| (p.1 - wanted).abs() + 10.0 * p.2;
        let nearest = points.iter().min_by(|a, b| miss(a).total_cmp(&miss(b)));
        nearest.map_or([0.0, self.crossing.valve_open.high], |p| p.0)
    }

    fn envelope(&self, leap: &Leap, feet: Span, landings: Span, reach: Span) -> Option<Envelope> {
        let grid = &self.grids[leap.jump];
        let possible = grid.span(self.landing_height(leap));
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
        grid.envelope(&Within {
            height: self.landing_height(leap),
            rim: self.rim(leap),
            leap,
            feet,
            landings,
            reach: span,
            cost: [deviation, self.crossing.effort_weight],
        })
    }

    fn sketch(&self, leap: &Leap, foot: f64, landing: f64, scatter: f64) -> Option<Sketch> {
        let errors = |decisions: [f64; 2]| {
            let launch = self.crossing.launch(leap.jump, decisions);
            let radius = self.planner.robot().body.radius;
            self.planner.landing_errors(&launch, radius)
        };
        let friction = |decisions: [f64; 2]| {
            let launch = self.launch(leap, decisions);
            let jump = self.planner.model().steered(&launch, true);
            let needed = jump.and_then(|jump| jump.friction_needed);
            needed.map_or(f64::INFINITY, |needed| needed.value)
        };
        let wanted = Wanted {
            leap,
            from_to: [foot, landing],
            height: self.landing_height(leap),
            rim: self.rim(leap),
            scatter,
            friction: self.crossing.friction.unwrap_or(f64::INFINITY),
        };
        let decisions = self.grids[leap.jump].sketch(&wanted, errors, friction)?;
        let is_last = leap.jump + 1 == self.crossing.course.jumps;
        let off = if is_last {
            landing - self.crossing.target
        } else {
            0.0
        };
        let cost = self.crossing.deviation_weight * off * off
            + self.crossing.effort_weight * decisions[1].powi(2);
        Some(Sketch { decisions, cost })
    }

    fn spread(&self, leap: &Leap) -> Vec<[f64; 2]> {
        self.grids[leap.jump].decisions().collect()
    }

    fn edge_margin(&self, rise: f64) -> f64 {
        self.crossing
            .margin_beside(self.planner.robot().body.radius, rise)
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
