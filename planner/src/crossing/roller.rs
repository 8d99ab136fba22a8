//! The rolling robot as a [`Jumper`]: what its decisions come to, and where to start.

use std::cell::{OnceCell, RefCell};
use std::rc::Rc;

use saltus_ballistic::Obstacle as Solid;
use saltus_lagrangian::Launch;
use saltus_numeric::{Dual, Scalar};

use super::Crossing;
use super::check::clearance;
use super::grid::{Grid, Within};
use super::stance::Path;
use crate::course::{self, Envelope, Jumper, Leap, Limit, Margin, Sketch, Slope, Span};
use crate::flight::JumpFlight;
use crate::jump::Jump;
use crate::model::{JumpModel, Steered};
use crate::planner::Planner;

/// Firing angles at which the reach of the jumps is sampled.
const SAMPLES: usize = 16;

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
    /// For each jump its flights over the firing angles, with the valve open longest and then
    /// shortest.
    samples: Vec<[Vec<Jump>; 2]>,
    /// For each jump its flights over angles and valve times, to bound its cost.
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
    /// The jump; none where the robot does not fly.
    jump: Option<Steered>,
    /// The way of the wheel in the stance, once it was asked for; none without a stance.
    path: OnceCell<Option<Path>>,
}

impl<'a> Roller<'a> {
    pub(super) fn new(planner: &'a Planner<dyn JumpModel>, crossing: &'a Crossing) -> Roller<'a> {
        let angles = crossing.firing_angles;
        let jumps = crossing.course.jumps;
        let sample = |jump: usize| {
            [crossing.valve_open.high, crossing.valve_open.low].map(|valve_open| {
                let launches: Vec<Launch> = (0..SAMPLES)
                    .map(|i| angles.low + angles.width() * i as f64 / (SAMPLES - 1) as f64)
                    .map(|angle| crossing.launch(jump, [angle, valve_open]))
                    .collect();
                let flown = planner.jumps(&launches).into_iter();
                flown.filter_map(Result::ok).collect()
            })
        };
        // Jumps at the same rate share their samples.
        let mut samples: Vec<[Vec<Jump>; 2]> = Vec::new();
        let mut grids: Vec<Rc<Grid>> = Vec::new();
        let twin = |jump: usize| (0..jump).find(|&k| crossing.rate(k) == crossing.rate(jump));
        for jump in 0..jumps {
            samples.push(twin(jump).map_or_else(|| sample(jump), |k| samples[k].clone()));
        }
        for jump in 0..jumps {
            let grid = || Rc::new(Grid::new(planner, crossing, jump));
            grids.push(twin(jump).map_or_else(grid, |k| grids[k].clone()));
        }
        let remembered = RefCell::new((0..jumps).map(|_| Vec::new()).collect());
        Roller {
            planner,
            crossing,
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
        let Some(flight) = jump.flight.as_ref().map(JumpFlight::parabola) else {
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
    fn flown(&self, leap: &Leap, decisions: [f64; 2]) -> Rc<Decided> {
        let height = self.landing_height(leap);
        let of = [decisions[0], decisions[1], height];
        let known = self.remembered.borrow()[leap.jump]
            .iter()
            .find(|flown| flown.of == of)
            .cloned();
        known.unwrap_or_else(|| {
            let flown = Rc::new(Decided {
                of,
                jump: self.planner.model().steered(
                    &self.launch(leap, decisions),
                    self.crossing.friction.is_some(),
                ),
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
                value: gap - Slope::of(self.crossing.clearance),
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
        margins.extend(
            self.crossing
                .friction
                .map(|_| nothing(Limit::Robot("friction"))),
        );
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
        let launch = self.crossing.launch(leap.jump, [angle, open]);
        self.planner
            .landing_deviation(&launch, self.landing_height(leap))
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
                0.97 * (jump.stance.time
                    - jump.stance.time_fire
                    - self.planner.robot().leg.opening_delay())
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
        let spread = |decisions| {
            if self.crossing.sigmas > 0.0 {
                let launch = self.crossing.launch(leap.jump, decisions);
                self.planner
                    .landing_deviation(&launch, self.planner.robot().body.radius)
            } else {
                0.0
            }
        };
        let height = self.landing_height(leap);
        let (decisions, deviation) = grid.sketch(leap, [foot, landing], height, rim, spread)?;
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
