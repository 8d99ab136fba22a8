//! Firing tables: the firing angles that reach a distance, or clear an obstacle, over approach
//! rates.

use saltus_ballistic::{Disc, Obstacle};
use saltus_lagrangian::{Launch, StanceError};
use saltus_numeric::parallel::{self, in_chunks};
use saltus_numeric::{plain, refused};
use saltus_robot::Robot;

use crate::jump::{Jump, Sensitivity};
use crate::model::JumpModel;
use crate::planner::Planner;
use crate::proxy::{Branch, NODES, Piece, nodes};

/// What a firing table asks for.
#[derive(Clone, Debug)]
pub struct TableRequest {
    /// Approach rates ω (rad/s), each ≥ 0.
    pub rates: Vec<f64>,
    /// What a jump is measured by.
    pub measure: Measure,
    /// The values of that measure to reach (m).
    pub targets: Vec<f64>,
    /// Valve opening time t_v (s).
    pub valve_open: f64,
    /// Lean at the start (rad); none: the stance starts at its firing angle.
    pub start_lean: Option<f64>,
    /// Firing angles that are allowed (rad), from least to greatest.
    pub firing_angles: (f64, f64),
    /// Whether to look for every angle that serves, or for the least only.
    pub roots: Roots,
    /// Whether to give each entry its sensitivities.
    pub sensitivities: bool,
    /// Threads to work with, ≥ 1. The result does not depend on it.
    pub threads: usize,
}

impl TableRequest {
    /// The least angle that reaches this distance (m), at the rates given to
    /// [`rates`](TableRequest::rates): landing with the wheel's centre at the height of the foot, a
    /// valve that opens for 0.1 s, [`FIRING_ANGLES`], with sensitivities, on all processors.
    pub fn distance(target: f64) -> TableRequest {
        TableRequest {
            rates: Vec::new(),
            measure: Measure::Distance {
                landing_height: 0.0,
            },
            targets: vec![target],
            valve_open: 0.1,
            start_lean: None,
            firing_angles: FIRING_ANGLES,
            roots: Roots::Least,
            sensitivities: true,
            threads: parallel::available(),
        }
    }

    /// At these approach rates (rad/s).
    pub fn rates(self, rates: impl Into<Vec<f64>>) -> TableRequest {
        TableRequest {
            rates: rates.into(),
            ..self
        }
    }

    /// Landing with the wheel's centre at this height (m) above the foot.
    pub fn landing_height(self, landing_height: f64) -> TableRequest {
        TableRequest {
            measure: Measure::Distance { landing_height },
            ..self
        }
    }
}

/// What a jump is measured by.
#[derive(Clone, Debug, PartialEq)]
pub enum Measure {
    /// Distance (m) from the foot to where the wheel's centre comes down to this height (m).
    Distance {
        /// Height (m) of the wheel's centre at the landing.
        landing_height: f64,
    },
    /// Least distance (m) of the flying wheel from an obstacle, given from the foot at x = 0, or
    /// how far beyond it the wheel's centre lands, whichever is less; negative where the wheel hits
    /// the obstacle or lands before its end.
    Clearance {
        /// The obstacle.
        obstacle: Obstacle,
    },
}

/// Which of the firing angles that serve to look for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Roots {
    /// The least.
    Least,
    /// All: usually one on the branch where firing later goes farther, and one beyond its top.
    All,
}

/// Default range of firing angles (rad).
pub const FIRING_ANGLES: (f64, f64) = (-0.6, 0.8);

/// A firing table: for each approach rate in turn, each target in turn.
#[derive(Clone, Debug)]
pub struct Table {
    /// The cells, `targets` within `rates`.
    pub cells: Vec<Cell>,
}

/// The answer for one approach rate and target.
#[derive(Clone, Debug)]
pub struct Cell {
    /// Approach rate ω (rad/s).
    pub rate: f64,
    /// Value of the measure that is wanted (m).
    pub target: f64,
    /// The firing angles that serve, ascending; none where no angle does.
    pub entries: Vec<Entry>,
    /// Where no angle serves: the nearest value (m) that is reached, and how; none where no jump
    /// has a value.
    pub nearest: Option<Nearest>,
    /// Whether any angle takes off. Where one does and there is still no nearest, no jump comes
    /// down to the landing height: each stays below it, or falls for ever.
    pub takes_off: bool,
}

/// A firing angle that serves.
#[derive(Clone, Debug)]
pub struct Entry {
    /// The jump at this angle; it was computed, not interpolated.
    pub jump: Jump,
    /// What its measure comes to (m): the target, to the planner's tolerance.
    pub value: f64,
    /// Sensitivity of the measured distance and of the apex, where asked for and the measure is a
    /// distance.
    pub sensitivity: Option<[Sensitivity; 2]>,
}

/// The nearest to a target that can be reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Value of the measure (m).
    pub value: f64,
    /// The firing angle (rad).
    pub firing_angle: f64,
}

/// A request that makes no sense.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TableError {
    /// A number is outside its domain.
    #[error("{name} = {}: must be {allowed}", plain(*value))]
    Input {
        /// What was given, with its unit.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// Nothing is asked for.
    #[error("{name}: must hold at least one number")]
    Empty {
        /// What is empty.
        name: &'static str,
    },
    /// A stance cannot be computed.
    #[error(transparent)]
    Stance(#[from] StanceError),
}

/// Rows that are worked on together: few, so that threads share them evenly, and enough to keep
/// SIMD lanes full.
const ROWS: usize = 4;
/// Intervals (rad) are not divided below this.
const NARROW: f64 = 1e-4;

impl Measure {
    /// The measure of a jump of `robot`; none where it has none.
    pub fn of(&self, robot: &Robot, jump: &Jump) -> Option<f64> {
        let value = match self {
            Measure::Distance { landing_height } => jump.distance(*landing_height),
            Measure::Clearance { obstacle } => {
                let flight = jump.flight.as_ref()?;
                let radius = robot.body.radius;
                let landing = flight.time_to_height(radius).ok()?;
                let clearance = flight
                    .clearance(&Disc::wheel(radius), obstacle, 0.0, landing)
                    .ok()?;
                let beyond = flight.range_to_height(radius).ok()? - obstacle.back();
                Some(clearance.min(beyond))
            }
        };
        value.filter(|v| v.is_finite())
    }
}

impl Planner<dyn JumpModel> {
    /// The firing table of `request`.
    ///
    /// Each row is sampled at Chebyshev points of the firing angle; pieces end where the outcome
    /// changes. Between its turning points an interpolant has at most one root for each target, so
    /// none is missed that is wider than a quarter of the nodes' spacing; each root is then solved
    /// with jumps, until one confirms it.
    ///
    /// # Errors
    /// [`TableError`] for a request outside its domain.
    pub fn table(&self, request: &TableRequest) -> Result<Table, TableError> {
        self.tabulate(request, None)
    }

    /// As [`table`](Self::table), for robots whose rates count at `reference_lean` (rad): each
    /// stance starts at its firing angle, with the rate that pivoting leaves there. The start lean
    /// of `request` is not used.
    ///
    /// # Errors
    /// As [`table`](Self::table).
    pub fn table_by_energy(
        &self,
        request: &TableRequest,
        reference_lean: f64,
    ) -> Result<Table, TableError> {
        self.tabulate(request, Some(reference_lean))
    }

    fn tabulate(
        &self,
        request: &TableRequest,
        reference_lean: Option<f64>,
    ) -> Result<Table, TableError> {
        request.check()?;
        let cells = |rates: &[f64]| Rows::new(self, request, reference_lean, rates).cells();
        let parts = in_chunks(&request.rates, ROWS, request.threads, cells);
        Ok(Table {
            cells: parts.into_iter().flatten().collect(),
        })
    }
}

impl TableRequest {
    /// The launch at this approach rate (rad/s) and firing angle (rad).
    pub fn launch(&self, rate: f64, firing_angle: f64) -> Launch {
        Launch {
            rate,
            lean: self.start_lean.unwrap_or(firing_angle),
            firing_angle,
            valve_open: self.valve_open,
        }
    }

    fn check(&self) -> Result<(), TableError> {
        for (name, list) in [
            ("approach rates (rad/s)", &self.rates),
            ("targets (m)", &self.targets),
        ] {
            if list.is_empty() {
                return Err(TableError::Empty { name });
            }
        }
        let (low, high) = self.firing_angles;
        let upright = |x: f64| x.abs() < std::f64::consts::FRAC_PI_2;
        let angle = "a finite angle strictly between -pi/2 and pi/2 rad";
        let first = |list: &[f64], ok: fn(&f64) -> bool| list.iter().copied().find(|x| !ok(x));
        let rate = first(&self.rates, |x| (0.0..=1e3).contains(x));
        let target = first(&self.targets, |x| x.abs() < 1e6);
        let (lean, open) = (self.start_lean.unwrap_or(0.0), self.valve_open);
        let wrong = refused! {
            "approach rate (rad/s)", rate.unwrap_or(0.0), rate.is_none() => "from 0 to 1000 rad/s";
            "target (m)", target.unwrap_or(0.0), target.is_none()
                => "a finite length below 1000 km";
            "valve opening time (s)", open, (0.0..=1e3).contains(&open) => "from 0 to 1000 s";
            "start lean (rad)", lean, upright(lean) => angle;
            "least firing angle (rad)", low, upright(low) => angle;
            "greatest firing angle (rad)", high, upright(high) => angle;
            "greatest firing angle (rad)", high, high > low => "above the least firing angle";
            "threads", 0.0, self.threads > 0 => "at least 1";
        };
        wrong.map_or(Ok(()), |(name, value, allowed)| {
            Err(TableError::Input {
                name,
                value,
                allowed,
            })
        })
    }
}

/// Rows of a table in the making.
struct Rows<'a> {
    planner: &'a Planner<dyn JumpModel>,
    request: &'a TableRequest,
    /// Where the rates count (rad); none: where the request's stances start.
    reference_lean: Option<f64>,
    rates: &'a [f64],
    /// The interpolants of each row, ascending.
    pieces: Vec<Vec<Piece>>,
    /// Whether an angle of the row takes off.
    takes_off: Vec<bool>,
}

/// A firing angle on its way to being solved.
struct Candidate {
    cell: usize,
    row: usize,
    branch: Branch,
    angle: f64,
    found: Option<Entry>,
}

/// What must stay the same for a result to be a smooth function of the firing angle: the outcome,
/// and whether the valve closed before lift-off.
type Label = (saltus_lagrangian::Outcome, bool);

/// A candidate of a model.
impl<'a> Rows<'a> {
    fn new(
        planner: &'a Planner<dyn JumpModel>,
        request: &'a TableRequest,
        reference_lean: Option<f64>,
        rates: &'a [f64],
    ) -> Self {
        let (pieces, takes_off) = (vec![Vec::new(); rates.len()], vec![false; rates.len()]);
        let mut rows = Rows {
            planner,
            request,
            reference_lean,
            rates,
            pieces,
            takes_off,
        };
        rows.sample();
        rows
    }

    fn launch(&self, row: usize, angle: f64) -> Launch {
        let rate = self.rates[row];
        match self.reference_lean {
            None => self.request.launch(rate, angle),
            Some(reference) => {
                let rate = self.planner.pivoted(rate, reference, angle);
                Launch::at_firing(rate, angle, self.request.valve_open)
            }
        }
    }

    /// An interpolant is trusted where its last coefficients are below this (m): a Newton step from
    /// its root then lands within round-off.
    fn accuracy(&self) -> f64 {
        self.planner.model().accuracy()
    }

    /// Residual (m) at which an entry counts as solved: below the error of the jump itself.
    fn residual(&self) -> f64 {
        0.25 * self.accuracy()
    }

    fn label(&self, jump: &Jump) -> Label {
        let end = &jump.stance;
        let closing =
            end.time_fire + self.planner.robot().leg.shutting_delay() + self.request.valve_open;
        (
            end.outcome,
            self.planner.robot().leg.drive.has_valve() && end.time > closing,
        )
    }

    /// Builds the interpolants: all rows at once, interval by interval.
    fn sample(&mut self) {
        let (low, high) = self.request.firing_angles;
        let mut work: Vec<(usize, f64, f64)> =
            (0..self.rates.len()).map(|row| (row, low, high)).collect();
        while !work.is_empty() {
            let launches: Vec<Launch> = work
                .iter()
                .flat_map(|&(row, low, high)| nodes(low, high).map(|angle| self.launch(row, angle)))
                .collect();
            let jumps = self.planner.jumps(&launches);
            let mut next = Vec::new();
            for (&(row, low, high), jumps) in work.iter().zip(jumps.chunks(NODES)) {
                self.fit(row, low, high, jumps, &mut next);
            }
            work = next;
        }
        for row in &mut self.pieces {
            row.sort_by(|a, b| a.low.total_cmp(&b.low));
        }
    }

    /// Interpolates one interval, or divides it.
    fn fit(
        &mut self,
        row: usize,
        low: f64,
        high: f64,
        jumps: &[Result<Jump, StanceError>],
        next: &mut Vec<(usize, f64, f64)>,
    ) {
        self.takes_off[row] |= jumps.iter().flatten().any(|jump| jump.flight.is_some());
        let labels: Vec<Option<Label>> = jumps
            .iter()
            .map(|jump| jump.as_ref().ok().map(|jump| self.label(jump)))
            .collect();
        let values: [Option<f64>; NODES] = std::array::from_fn(|k| {
            jumps[k]
                .as_ref()
                .ok()
                .and_then(|jump| self.request.measure.of(self.planner.robot(), jump))
        });
        let wide = high - low > NARROW;
        if let Some(k) = (1..NODES)
            .find(|&k| labels[k] != labels[k - 1])
            .filter(|_| wide)
        {
            let points = nodes(low, high);
            let border = self.border(row, points[k - 1], points[k], labels[k - 1]);
            // The border itself belongs to neither side.
            let gap = 1e-11;
            next.extend([(row, low, border - gap), (row, border + gap, high)]);
            return;
        }
        if values.iter().all(Option::is_none) {
            return;
        }
        if values.iter().any(Option::is_none) {
            if wide {
                next.extend([
                    (row, low, 0.5 * (low + high)),
                    (row, 0.5 * (low + high), high),
                ]);
            }
            return;
        }
        let piece = Piece::new(low, high, &values.map(Option::unwrap_or_default));
        if wide && piece.tail() > self.accuracy() {
            next.extend([
                (row, low, 0.5 * (low + high)),
                (row, 0.5 * (low + high), high),
            ]);
        } else {
            self.pieces[row].push(piece);
        }
    }

    /// Where, between `a` and `b`, the label ceases to be `label`: by bisection to 1e-12 rad.
    fn border(&self, row: usize, mut a: f64, mut b: f64, label: Option<Label>) -> f64 {
        while b - a > 1e-12 {
            let middle = 0.5 * (a + b);
            let jump = self.planner.jump(&self.launch(row, middle));
            if jump.ok().map(|jump| self.label(&jump)) == label {
                a = middle;
            } else {
                b = middle;
            }
        }
        0.5 * (a + b)
    }

    /// Every cell of these rows.
    fn cells(&self) -> Vec<Cell> {
        let targets = &self.request.targets;
        let mut cells: Vec<Cell> = Vec::with_capacity(self.rates.len() * targets.len());
        let mut candidates = Vec::new();
        for (row, &rate) in self.rates.iter().enumerate() {
            let mut branches = Vec::new();
            for (index, piece) in self.pieces[row].iter().enumerate() {
                piece.branches(index, &mut branches);
            }
            for &target in targets {
                let cell = cells.len();
                let roots = branches.iter().filter_map(|branch| {
                    let angle = self.pieces[row][branch.piece].solve(branch, target)?;
                    Some(Candidate {
                        cell,
                        row,
                        branch: *branch,
                        angle,
                        found: None,
                    })
                });
                let wanted = if self.request.roots == Roots::Least {
                    1
                } else {
                    usize::MAX
                };
                candidates.extend(roots.take(wanted));
                cells.push(Cell {
                    rate,
                    target,
                    entries: Vec::new(),
                    nearest: nearest(&branches, target),
                    takes_off: self.takes_off[row],
                });
            }
        }
        self.solve(&mut candidates);
        for candidate in candidates {
            if let Some(entry) = candidate.found {
                let cell = &mut cells[candidate.cell];
                cell.nearest = None;
                // The same root may close one piece and open the next.
                let twin = cell.entries.last().is_some_and(|last| {
                    (last.jump.launch.firing_angle - entry.jump.launch.firing_angle).abs() < 1e-8
                });
                if !twin {
                    cell.entries.push(entry);
                }
            }
        }
        if self.request.sensitivities {
            self.differentiate(&mut cells);
        }
        cells
    }

    /// Confirms each candidate with a jump, correcting it by the interpolant's slope until one
    /// does.
    fn solve(&self, candidates: &mut [Candidate]) {
        let mut open: Vec<usize> = (0..candidates.len()).collect();
        for _ in 0..4 {
            let launches: Vec<Launch> = open
                .iter()
                .map(|&i| self.launch(candidates[i].row, candidates[i].angle))
                .collect();
            let jumps = self.planner.jumps(&launches);
            open = open
                .into_iter()
                .zip(jumps)
                .filter_map(|(i, jump)| {
                    (!self.confirm(&mut candidates[i], jump.ok()?)).then_some(i)
                })
                .collect();
            if open.is_empty() {
                return;
            }
        }
        for i in open {
            self.bisect(&mut candidates[i]);
        }
    }

    fn target(&self, candidate: &Candidate) -> f64 {
        self.request.targets[candidate.cell % self.request.targets.len()]
    }

    /// Whether `jump` solves the candidate; if not, moves its angle.
    fn confirm(&self, candidate: &mut Candidate, jump: Jump) -> bool {
        let Some(value) = self.request.measure.of(self.planner.robot(), &jump) else {
            return false;
        };
        let residual = value - self.target(candidate);
        if residual.abs() <= self.residual() {
            candidate.found = Some(Entry {
                jump,
                value,
                sensitivity: None,
            });
            return true;
        }
        let (_, slope) = self.pieces[candidate.row][candidate.branch.piece].at(candidate.angle);
        let next = candidate.angle - residual / slope;
        if next.is_finite() {
            candidate.angle = next.clamp(candidate.branch.low, candidate.branch.high);
        }
        false
    }

    /// Solves a candidate by bisection on the jumps themselves: where the interpolant's slope leads
    /// nowhere (a kink, or the very top of the reachable).
    fn bisect(&self, candidate: &mut Candidate) {
        let target = self.target(candidate);
        let look = |angle: f64| {
            let jump = self.planner.jump(&self.launch(candidate.row, angle)).ok()?;
            let value = self.request.measure.of(self.planner.robot(), &jump)?;
            Some((jump, value))
        };
        let (mut a, mut b) = (candidate.branch.low, candidate.branch.high);
        let rising = candidate.branch.at_high > candidate.branch.at_low;
        let mut best: Option<Entry> = None;
        for _ in 0..60 {
            let middle = 0.5 * (a + b);
            let Some((jump, value)) = look(middle) else {
                break;
            };
            if best
                .as_ref()
                .is_none_or(|e| (value - target).abs() < (e.value - target).abs())
            {
                best = Some(Entry {
                    jump,
                    value,
                    sensitivity: None,
                });
            }
            if (value > target) == rising {
                b = middle;
            } else {
                a = middle;
            }
        }
        candidate.found =
            best.filter(|entry| (entry.value - target).abs() <= 1e3 * self.residual());
    }

    /// Gives each entry its sensitivities.
    fn differentiate(&self, cells: &mut [Cell]) {
        let Measure::Distance { landing_height } = self.request.measure else {
            return;
        };
        for entry in cells.iter_mut().flat_map(|cell| &mut cell.entries) {
            let jump = self.planner.sensitive_jump(&entry.jump.launch);
            entry.sensitivity = jump.ok().and_then(|jump| {
                let (distance, apex) = (jump.distance(landing_height)?, jump.apex()?);
                Some([Sensitivity::new(distance), Sensitivity::new(apex)])
            });
        }
    }
}

/// The end of a branch that is nearest to `target`.
fn nearest(branches: &[Branch], target: f64) -> Option<Nearest> {
    branches
        .iter()
        .flat_map(|b| [(b.at_low, b.low), (b.at_high, b.high)])
        .min_by(|a, b| (a.0 - target).abs().total_cmp(&(b.0 - target).abs()))
        .map(|(value, firing_angle)| Nearest {
            value,
            firing_angle,
        })
}
