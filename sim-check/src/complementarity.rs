//! Which contacts hold, which slide and which let go: Coulomb's law and end stops as a
//! complementarity problem.
//!
//! With w = A λ + b, where w are accelerations (or velocities after an impact) along the
//! constraints' directions and λ the forces (or impulses) along them: a row that holds has w = 0
//! and its λ within its bounds; one at a bound has λ there and moves away from it.
//!
//! Four ways are tried in turn; each answers what those before it do not (shares of the problems of
//! running robots in their plane, and of balls):
//!
//! 1. guess who holds, solve, correct the guess: a semismooth Newton method (99.7 %; 86 %);
//! 2. where guesses go round in circles, pivots, by Lemke's method (0.3 %; it takes no discs);
//! 3. for discs of friction, Newton's method on projections (13 % of balls);
//! 4. projected Gauss–Seidel iteration (0.2 % of balls).
//!
//! Source: Pang & Trinkle, Complementarity formulations, Math. Prog. 73 (1996); Hintermüller, Ito,
//! Kunisch, SIAM J. Optim. 13 (2003).

use crate::lemke::Lemke;
use crate::linear;

/// What a constraint does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Grip {
    /// It does not move.
    Held,
    /// Its force is at the lower bound, and it moves up (w ≥ 0).
    Low,
    /// Its force is at the upper bound, and it moves down (w ≤ 0).
    High,
    /// Two-dimensional friction at its bound: it moves along this unit vector.
    Along([f64; 2]),
}

/// Bounds of a constraint's force.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Bounds {
    /// Between two numbers: one row.
    Between(f64, f64),
    /// At most `limit` times the force of the row `normal`, or `limit` itself: one row, or two in a
    /// disc.
    Friction {
        normal: Option<usize>,
        limit: f64,
        rows: usize,
    },
}

/// A constraint: its rows begin at `row`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Element {
    pub row: usize,
    pub bounds: Bounds,
    pub grip: Grip,
}

impl Element {
    fn rows(&self) -> usize {
        match self.bounds {
            Bounds::Between(..) => 1,
            Bounds::Friction { rows, .. } => rows,
        }
    }
}

/// w = A λ + b and what each row may do.
#[derive(Clone, Debug, Default)]
pub(crate) struct Problem {
    pub rows: usize,
    /// A, row by row.
    pub a: Vec<f64>,
    pub b: Vec<f64>,
    pub elements: Vec<Element>,
    /// The solution λ.
    pub force: Vec<f64>,
    /// The solution's w.
    pub motion: Vec<f64>,
    /// Solutions of steps so far that obey the laws only within [`SLOW`] and [`SLACK`].
    pub approximate: usize,
    system: Vec<f64>,
    right: Vec<f64>,
    /// Forces before a step of Newton's method, and the step.
    before: Vec<f64>,
    step: Vec<f64>,
    held: Vec<usize>,
    /// Each row's force: a constant, and a multiple of another row's.
    known: Vec<Known>,
    lemke: Lemke,
}

/// Guesses of who holds, each corrected by the last, before an answer is sought by pivots.
const GUESSES: usize = 15;

/// The same where friction is in discs: whose direction a guess follows slowly.
const FEW_GUESSES: usize = 4;
/// What moves more slowly (m/s) at the end of a step may have been sought in vain: it stands.
const CREEP: f64 = 1e-6;
/// As much (m/s), and this part of the greatest force, may be left at the end of a step where the forces of many feet that squeeze the
/// ground between them are not found more exactly: there is an answer for every step. How often is counted.
const SLOW: f64 = 1e-3;
const SLACK: f64 = 1e-4;
/// What part of the greatest force the last step of Newton's method on projections may be.
const SETTLED: f64 = 1e-13;
/// Least part of a step that a damped one is cut to.
const LEAST_PART: f64 = 1e-4;

/// Most steps of Newton's method on projections.
const MOST_STEPS: usize = 40;

/// Sweeps of the iteration after which its steps must be shorter by this factor, if they come to an answer.
const SWEEPS: usize = 100;
const DRIFT: f64 = 0.95;

/// Friction coefficient of what has no limit, where it needs one.
const ROUGHEST: f64 = 1e3;

/// The variables of Lemke's method for elements.
struct Variables {
    /// Where those of each element begin.
    starts: Vec<usize>,
    /// λ where all are 0.
    base: Vec<f64>,
    /// What each adds to λ: a row and a sign.
    adds: Vec<Option<(usize, f64)>>,
}

/// Whether a row's variable counts from its low bound up (1) or from its high bound down (−1).
fn way(low: f64) -> f64 {
    if low.is_finite() { 1.0 } else { -1.0 }
}

impl Variables {
    fn of(elements: &[Element], rows: usize) -> Variables {
        let mut all = Variables {
            starts: Vec::with_capacity(elements.len()),
            base: vec![0.0; rows],
            adds: Vec::new(),
        };
        for e in elements {
            all.starts.push(all.adds.len());
            match e.bounds {
                Bounds::Between(low, high) => {
                    all.base[e.row] = if low.is_finite() { low } else { high };
                    all.adds.push(Some((e.row, way(low))));
                    if low.is_finite() && high.is_finite() {
                        all.adds.push(None);
                    }
                }
                Bounds::Friction { .. } => {
                    all.adds
                        .extend([Some((e.row, 1.0)), Some((e.row, -1.0)), None]);
                }
            }
        }
        all
    }
}

#[derive(Clone, Copy, Debug)]
enum Known {
    Unknown,
    Is(f64),
    Times(usize, f64),
}

impl Problem {
    /// λ and w for the grips as they are; whether rows were redundant, so that λ is one of many.
    pub(crate) fn solve(&mut self) -> bool {
        self.assign();
        self.assemble();
        let redundant = linear::solve(&mut self.system, self.held.len(), &mut self.right);
        self.set_force();
        self.set_motion();
        redundant
    }

    /// Which rows are held, and what the forces of the others are.
    fn assign(&mut self) {
        self.known.clear();
        self.known.resize(self.rows, Known::Is(0.0));
        self.held.clear();
        for e in &self.elements {
            if e.grip == Grip::Held && !self.is_idle(e) {
                for k in e.row..e.row + e.rows() {
                    self.known[k] = Known::Unknown;
                    self.held.push(k);
                }
            }
        }
        for e in &self.elements {
            let direction = match e.grip {
                Grip::Held => continue,
                Grip::Low => [-1.0, 0.0],
                Grip::High => [1.0, 0.0],
                Grip::Along(d) => [-d[0], -d[1]],
            };
            for k in 0..e.rows() {
                self.known[e.row + k] = match e.bounds {
                    Bounds::Between(low, high) => {
                        Known::Is(if e.grip == Grip::Low { low } else { high })
                    }
                    Bounds::Friction {
                        normal: None,
                        limit,
                        ..
                    } => Known::Is(limit * direction[k]),
                    Bounds::Friction {
                        normal: Some(n),
                        limit,
                        ..
                    } => match self.known[n] {
                        Known::Unknown => Known::Times(n, limit * direction[k]),
                        _ => Known::Is(0.0),
                    },
                };
            }
        }
    }

    /// The equations of the held rows: they do not move.
    fn assemble(&mut self) {
        let (m, h) = (self.rows, self.held.len());
        self.system.clear();
        self.system.resize(h * h, 0.0);
        self.right.clear();
        for i in 0..h {
            let row = &self.a[self.held[i] * m..(self.held[i] + 1) * m];
            let mut right = -self.b[self.held[i]];
            for (c, entry) in row.iter().enumerate() {
                if let Known::Is(force) = self.known[c] {
                    right -= entry * force;
                }
            }
            self.right.push(right);
            for j in 0..h {
                self.system[i * h + j] += row[self.held[j]];
            }
            for (c, entry) in row.iter().enumerate() {
                if let Known::Times(n, factor) = self.known[c]
                    && let Some(j) = self.held.iter().position(|&k| k == n)
                {
                    self.system[i * h + j] += entry * factor;
                }
            }
        }
    }

    fn set_force(&mut self) {
        self.force.clear();
        self.force.resize(self.rows, 0.0);
        for (i, &k) in self.held.iter().enumerate() {
            self.force[k] = self.right[i];
        }
        for k in 0..self.rows {
            match self.known[k] {
                Known::Unknown => {}
                Known::Is(force) => self.force[k] = force,
                Known::Times(n, factor) => self.force[k] = factor * self.force[n],
            }
        }
    }

    /// Whether an element is the friction of a contact that is open.
    fn is_idle(&self, e: &Element) -> bool {
        match e.bounds {
            Bounds::Friction {
                normal: Some(n), ..
            } => self
                .elements
                .iter()
                .any(|other| other.row == n && other.grip != Grip::Held),
            _ => false,
        }
    }

    fn set_motion(&mut self) {
        self.motion.clear();
        for i in 0..self.rows {
            self.motion.push(self.motion_of(i));
        }
    }

    /// w of row `i` for the present forces.
    fn motion_of(&self, i: usize) -> f64 {
        let row = &self.a[i * self.rows..(i + 1) * self.rows];
        row.iter().zip(&self.force).map(|(a, f)| a * f).sum::<f64>() + self.b[i]
    }

    /// Whether an element's rows do not move, though its force may be at a bound.
    pub(crate) fn stands(&self, e: &Element) -> bool {
        self.motion[e.row..e.row + e.rows()]
            .iter()
            .all(|w| w.abs() <= 10.0 * self.still())
    }

    /// Whether the force of an element is at a bound and it moves faster than `speed`.
    pub(crate) fn lets_go(&self, e: &Element, speed: f64) -> bool {
        e.grip != Grip::Held && self.motion[e.row].abs() > speed
    }

    /// If the contact forces are not unique, a force at its friction bound does not prove slip.
    /// After [`resolve`](Self::resolve), such contacts stick as long as they do not move.
    pub(crate) fn hold_what_stands(&mut self) {
        let grips: Vec<Grip> = self.elements.iter().map(|e| e.grip).collect();
        for i in 0..self.elements.len() {
            if self.stands(&self.elements[i]) {
                self.elements[i].grip = Grip::Held;
            }
        }
        if !self.solve() {
            for (e, grip) in self.elements.iter_mut().zip(grips) {
                e.grip = grip;
            }
        }
    }

    /// How small a motion counts as none: what is left of numbers of this size after cancelling.
    fn still(&self) -> f64 {
        1e-10 * self.b.iter().fold(0.0_f64, |s, x| s.max(x.abs())) + 1e-14
    }

    /// The bound of a friction element's force.
    fn limit(&self, e: &Element) -> f64 {
        match e.bounds {
            Bounds::Between(_, high) => high,
            Bounds::Friction {
                normal: None,
                limit,
                ..
            } => limit,
            Bounds::Friction {
                normal: Some(n),
                limit,
                ..
            } => {
                if self.force[n] > 0.0 {
                    limit * self.force[n]
                } else {
                    0.0
                }
            }
        }
    }

    /// Finds the grips that obey every law, from those given; false where there are none.
    pub(crate) fn resolve(&mut self) -> bool {
        let pivots = self.is_polyhedral(f64::is_finite);
        self.resolve_by(pivots, 0.0)
    }

    /// As [`resolve`](Self::resolve), for the impulses of a step: there is an answer for friction
    /// however rough, so that friction without a limit is one that is very rough.
    pub(crate) fn resolve_step(&mut self) -> bool {
        let pivots = self.is_polyhedral(|_| true);
        if self.resolve_by(pivots, CREEP) {
            return true;
        }
        let is_near = self.nearly_obeys(SLOW, SLACK);
        self.approximate += usize::from(is_near);
        is_near
    }

    /// The same, with pivots where guesses go round in circles, if `pivots`; what moves up to `creep` stands.
    fn resolve_by(&mut self, pivots: bool, creep: f64) -> bool {
        let in_discs = |e: &Element| e.rows() == 2;
        let has_discs = self.elements.iter().any(in_discs);
        let guesses = if has_discs { FEW_GUESSES } else { GUESSES };
        for _ in 0..guesses {
            self.solve();
            if !self.correct() {
                return self.force.iter().all(|f| f.is_finite());
            }
        }
        if pivots && self.pivot() && self.obeys(creep) {
            return true;
        }
        if has_discs && self.project() && self.obeys(creep) {
            return true;
        }
        // Near the onset of slip iteration is slow: what it has found counts if it obeys the laws.
        self.relax(creep);
        self.obeys(creep)
    }

    /// Newton's method on λ = P(λ − ρ w), where P takes each force to the nearest within its bounds and ρ is the reciprocal
    /// of the row's own mobility: the law of every row at once, discs of friction with the slope of their edge. A step that
    /// takes the forces farther from the laws is cut. Whether it comes to an answer, whose grips it sets.
    ///
    /// Source: Alart and Curnier, A mixed formulation for frictional contact problems prone to Newton like solution methods,
    /// Comput. Methods Appl. Mech. Eng. 92 (1991).
    fn project(&mut self) -> bool {
        let m = self.rows;
        self.force.clear();
        self.force.resize(m, 0.0);
        let mut error = self.state_laws();
        for _ in 0..MOST_STEPS {
            self.before.clone_from(&self.force);
            linear::solve(&mut self.system, m, &mut self.right);
            self.step.clone_from(&self.right);
            if !self.step.iter().all(|x| x.is_finite()) {
                return false;
            }
            let was = error;
            let mut part = 1.0;
            loop {
                for k in 0..m {
                    self.force[k] = self.before[k] + part * self.step[k];
                }
                error = self.state_laws();
                if error < (1.0 - 0.1 * part) * was || part < LEAST_PART {
                    break;
                }
                part *= 0.5;
            }
            let greatest = |x: &[f64]| x.iter().fold(0.0_f64, |s, x| s.max(x.abs()));
            if part * greatest(&self.step) <= SETTLED * greatest(&self.before) + f64::MIN_POSITIVE {
                let still = self.still();
                for i in 0..self.elements.len() {
                    self.elements[i].grip = self.grip_by_motion(&self.elements[i], still);
                }
                return true;
            }
        }
        false
    }

    /// The linear equations for the next step of [`project`](Self::project), with motions at the present forces; how far
    /// these are from obeying every law.
    fn state_laws(&mut self) -> f64 {
        let m = self.rows;
        self.set_motion();
        self.system.clear();
        self.system.resize(m * m, 0.0);
        self.right.clear();
        self.right.resize(m, 0.0);
        for i in 0..self.elements.len() {
            self.state_projection(self.elements[i]);
        }
        self.right.iter().map(|x| x * x).sum::<f64>().sqrt()
    }

    /// The linear equations of one element for the next step of [`project`](Self::project).
    fn state_projection(&mut self, e: Element) {
        let m = self.rows;
        let share = |k: usize| 1.0 / self.a[k * m + k];
        if e.rows() == 1 {
            let limit = self.limit(&e);
            let (low, high, normal) = match e.bounds {
                Bounds::Between(low, high) => (low, high, None),
                Bounds::Friction {
                    normal, limit: by, ..
                } => (-limit, limit, normal.map(|n| (n, by))),
            };
            let (f, rho) = (self.force[e.row], share(e.row));
            let free = f - rho * self.motion[e.row];
            let edge = [(low, -1.0, free < low), (high, 1.0, free > high)];
            match edge.into_iter().find(|(.., is_beyond)| *is_beyond) {
                Some((bound, sign, _)) => {
                    self.system[e.row * m + e.row] = 1.0;
                    if let Some((n, by)) = normal.filter(|_| bound != 0.0) {
                        self.system[e.row * m + n] -= sign * by;
                    }
                    self.right[e.row] = bound - f;
                }
                None => self.state_rest(e.row, rho),
            }
            return;
        }
        let limit = self.limit(&e);
        let rho = share(e.row).min(share(e.row + 1));
        let z = [0, 1].map(|k| self.force[e.row + k] - rho * self.motion[e.row + k]);
        let length = z[0].hypot(z[1]);
        if length <= limit {
            self.state_rest(e.row, rho);
            self.state_rest(e.row + 1, rho);
            return;
        }
        // λ = l z/|z|: its change follows that of l along z, and that of z across it.
        let way = z.map(|x| x / length);
        let slope = limit / length;
        for k in 0..2 {
            let row = e.row + k;
            for l in 0..2 {
                let across = if k == l { 1.0 } else { 0.0 } - way[k] * way[l];
                self.system[row * m + e.row + l] -= slope * across;
                for c in 0..m {
                    self.system[row * m + c] += slope * across * rho * self.a[(e.row + l) * m + c];
                }
            }
            self.system[row * m + row] += 1.0;
            if let Bounds::Friction {
                normal: Some(n),
                limit: by,
                ..
            } = e.bounds
                && limit > 0.0
            {
                self.system[row * m + n] -= by * way[k];
            }
            self.right[row] = limit * way[k] - self.force[row];
        }
    }

    /// The equation of a row that does not move.
    fn state_rest(&mut self, row: usize, rho: f64) {
        let m = self.rows;
        for c in 0..m {
            self.system[row * m + c] = rho * self.a[row * m + c];
        }
        self.right[row] = -rho * self.motion[row];
    }

    /// Whether Lemke's method takes it: friction in single directions, with limits that `takes`
    /// accepts.
    fn is_polyhedral(&self, takes: impl Fn(f64) -> bool) -> bool {
        self.elements.iter().all(|e| match e.bounds {
            Bounds::Between(..) => true,
            Bounds::Friction { limit, rows, .. } => rows == 1 && takes(limit),
        })
    }

    /// The answer by Lemke's method; false where it finds none.
    ///
    /// In the form of Stewart and Trinkle: a row between two bounds has z₁ = λ − low and s ≥ 0,
    /// which is |w| where λ is high; friction has λ₊, λ₋ and the slip speed σ.
    fn pivot(&mut self) -> bool {
        let mut lemke = std::mem::take(&mut self.lemke);
        let layout = Variables::of(&self.elements, self.rows);
        lemke.clear(layout.adds.len());
        self.state(&layout, &mut lemke);
        let found = lemke.solve();
        if found {
            self.force.clone_from(&layout.base);
            for (add, z) in layout.adds.iter().zip(&lemke.z) {
                if let Some((row, way)) = add {
                    self.force[*row] += way * z;
                }
            }
            self.set_motion();
            self.grips_of(&lemke.z, &layout.starts);
        }
        self.lemke = lemke;
        found
    }

    /// States the problem in the variables of `layout`.
    fn state(&self, layout: &Variables, lemke: &mut Lemke) {
        let size = layout.adds.len();
        for (e, &at) in self.elements.iter().zip(&layout.starts) {
            match e.bounds {
                Bounds::Between(low, high) => {
                    self.state_motion(layout, lemke, (e.row, way(low)), at);
                    if low.is_finite() && high.is_finite() {
                        lemke.m[at * size + at + 1] = 1.0;
                        lemke.m[(at + 1) * size + at] = -1.0;
                        lemke.q[at + 1] = high - low;
                    }
                }
                Bounds::Friction { normal, limit, .. } => {
                    self.state_motion(layout, lemke, (e.row, 1.0), at);
                    self.state_motion(layout, lemke, (e.row, -1.0), at + 1);
                    lemke.m[at * size + at + 2] = 1.0;
                    lemke.m[(at + 1) * size + at + 2] = 1.0;
                    lemke.m[(at + 2) * size + at] = -1.0;
                    lemke.m[(at + 2) * size + at + 1] = -1.0;
                    let limit = limit.min(ROUGHEST);
                    let of_normal = normal
                        .and_then(|n| self.elements.iter().position(|other| other.row == n))
                        .map(|k| layout.starts[k]);
                    match of_normal {
                        Some(normal) => lemke.m[(at + 2) * size + normal] = limit,
                        None => lemke.q[at + 2] = limit,
                    }
                }
            }
        }
    }

    /// States that the variable `at` is complementary to the motion of `row`, or to its opposite.
    fn state_motion(
        &self,
        layout: &Variables,
        lemke: &mut Lemke,
        (row, sign): (usize, f64),
        at: usize,
    ) {
        let a = &self.a[row * self.rows..(row + 1) * self.rows];
        let size = layout.adds.len();
        for (j, add) in layout.adds.iter().enumerate() {
            if let Some((other, way)) = add {
                lemke.m[at * size + j] = sign * way * a[*other];
            }
        }
        let known: f64 = a.iter().zip(&layout.base).map(|(a, l)| a * l).sum();
        lemke.q[at] = sign * (self.b[row] + known);
    }

    /// The grips of a solution by pivots.
    fn grips_of(&mut self, z: &[f64], starts: &[usize]) {
        for (e, &at) in self.elements.iter_mut().zip(starts) {
            e.grip = match e.bounds {
                Bounds::Between(low, high) if low.is_finite() && high.is_finite() => {
                    match (z[at] > 0.0, z[at + 1] > 0.0) {
                        (false, _) => Grip::Low,
                        (true, false) => Grip::Held,
                        (true, true) => Grip::High,
                    }
                }
                Bounds::Between(low, _) => match (z[at] > 0.0, low.is_finite()) {
                    (true, _) => Grip::Held,
                    (false, true) => Grip::Low,
                    (false, false) => Grip::High,
                },
                Bounds::Friction { limit, .. } if z[at + 2] > 0.0 && limit.is_finite() => {
                    if self.force[e.row] < 0.0 {
                        Grip::Low
                    } else {
                        Grip::High
                    }
                }
                Bounds::Friction { .. } => Grip::Held,
            };
        }
    }

    /// Corrects the grips that the present solution contradicts; whether there were any.
    fn correct(&mut self) -> bool {
        let still = self.still();
        let mut changed = false;
        for i in 0..self.elements.len() {
            let e = self.elements[i];
            if self.is_idle(&e) {
                continue;
            }
            let next = self.next(&e, still);
            if !same(next, e.grip) {
                self.elements[i].grip = next;
                changed = true;
            }
        }
        changed
    }

    fn next(&self, e: &Element, still: f64) -> Grip {
        let (f, w) = (self.force[e.row], self.motion[e.row]);
        let slack = 1e-12 * self.force.iter().fold(0.0_f64, |s, x| s.max(x.abs()));
        let (low, high) = match e.bounds {
            Bounds::Between(low, high) => (low, high),
            Bounds::Friction { rows: 1, .. } => (-self.limit(e), self.limit(e)),
            Bounds::Friction { .. } => return self.next_in_disc(e, still, slack),
        };
        match e.grip {
            Grip::Held if f < low - slack => Grip::Low,
            Grip::Held if f > high + slack => Grip::High,
            Grip::Low if w < -still => Grip::Held,
            Grip::High if w > still => Grip::Held,
            grip => grip,
        }
    }

    fn next_in_disc(&self, e: &Element, still: f64, slack: f64) -> Grip {
        let pick = |x: &[f64]| [x[e.row], x[e.row + 1]];
        let (f, w) = (pick(&self.force), pick(&self.motion));
        let (size, speed) = (f[0].hypot(f[1]), w[0].hypot(w[1]));
        match e.grip {
            Grip::Along(d) => {
                if speed <= still {
                    return e.grip;
                }
                let ahead = w[0] * d[0] + w[1] * d[1];
                if ahead < 0.0 {
                    Grip::Held
                } else {
                    Grip::Along([w[0] / speed, w[1] / speed])
                }
            }
            _ if size > self.limit(e) + slack && size > 0.0 => {
                Grip::Along([-f[0] / size, -f[1] / size])
            }
            grip => grip,
        }
    }

    /// Projected Gauss–Seidel iteration, then the grips that its solution has.
    fn relax(&mut self, creep: f64) {
        self.force.fill(0.0);
        let mut before = f64::INFINITY;
        for sweep in 1..=20_000 {
            let mut change = 0.0_f64;
            for i in 0..self.elements.len() {
                change = change.max(self.relax_element(self.elements[i]));
            }
            let size = self.force.iter().fold(0.0_f64, |s, x| s.max(x.abs()));
            if change <= 1e-13 * size + 1e-300 {
                break;
            }
            if sweep % SWEEPS == 0 {
                // Forces that are not unique drift on, though they obey the laws.
                if change > DRIFT * before {
                    self.grip_as_it_moves(creep);
                    if self.obeys(creep) {
                        return;
                    }
                }
                before = change;
            }
        }
        self.grip_as_it_moves(creep);
    }

    /// The motions, and the grips that they mean; what moves up to `creep` stands.
    fn grip_as_it_moves(&mut self, creep: f64) {
        self.set_motion();
        let still = (1e3 * self.still()).max(creep);
        for i in 0..self.elements.len() {
            self.elements[i].grip = self.grip_by_motion(&self.elements[i], still);
        }
    }

    /// The force of one element that stops it, within its bounds; by how much it has changed.
    fn relax_element(&mut self, e: Element) -> f64 {
        let limit = self.limit(&e);
        let diagonal = |k: usize| self.a[k * self.rows + k];
        let mut next = [0.0; 2];
        if e.rows() == 1 {
            let (low, high) = match e.bounds {
                Bounds::Between(low, high) => (low, high),
                Bounds::Friction { .. } => (-limit, limit),
            };
            let step = self.motion_of(e.row) / diagonal(e.row);
            next[0] = (self.force[e.row] - step).clamp(low, high);
        } else {
            let step = 1.0 / diagonal(e.row).max(diagonal(e.row + 1));
            let free = [0, 1].map(|k| self.force[e.row + k] - step * self.motion_of(e.row + k));
            let size = free[0].hypot(free[1]);
            let scale = if size > limit { limit / size } else { 1.0 };
            next = free.map(|x| x * scale);
        }
        let mut change = 0.0_f64;
        for k in 0..e.rows() {
            change = change.max((next[k] - self.force[e.row + k]).abs());
            self.force[e.row + k] = next[k];
        }
        change
    }

    /// The grip of an element that moves as it does; one that moves up to `still` is held.
    fn grip_by_motion(&self, e: &Element, still: f64) -> Grip {
        let w = self.motion[e.row];
        if e.rows() == 2 {
            let v = [w, self.motion[e.row + 1]];
            let speed = v[0].hypot(v[1]);
            return if speed <= still {
                Grip::Held
            } else {
                Grip::Along([v[0] / speed, v[1] / speed])
            };
        }
        if w > still {
            Grip::Low
        } else if w < -still {
            Grip::High
        } else {
            Grip::Held
        }
    }

    /// Whether the present forces and motions obey every law, up to round-off of an iteration; what moves up to `creep` stands.
    fn obeys(&self, creep: f64) -> bool {
        self.nearly_obeys(creep, 1e-8)
    }

    /// The same up to this part of the greatest force.
    fn nearly_obeys(&self, creep: f64, part: f64) -> bool {
        let still = (1e4 * self.still()).max(creep);
        let slack = part * self.force.iter().fold(0.0_f64, |s, x| s.max(x.abs())) + 1e-12;
        self.elements.iter().all(|e| {
            if self.is_idle(e) {
                return true;
            }
            let (f, w) = (self.force[e.row], self.motion[e.row]);
            match e.bounds {
                Bounds::Between(low, high) => {
                    f >= low - slack
                        && f <= high + slack
                        && (w <= still || f <= low + slack)
                        && (w >= -still || f >= high - slack)
                }
                Bounds::Friction { rows, .. } => {
                    let size = if rows == 2 {
                        f.hypot(self.force[e.row + 1])
                    } else {
                        f.abs()
                    };
                    size <= self.limit(e) + slack
                }
            }
        })
    }
}

fn same(a: Grip, b: Grip) -> bool {
    match (a, b) {
        (Grip::Along(p), Grip::Along(q)) => (p[0] - q[0]).hypot(p[1] - q[1]) < 1e-13,
        _ => a == b,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn contact(a: Vec<f64>, b: Vec<f64>, limit: f64) -> Problem {
        let rows = b.len();
        let elements = vec![
            Element {
                row: 0,
                bounds: Bounds::Between(0.0, f64::INFINITY),
                grip: Grip::Held,
            },
            Element {
                row: 1,
                bounds: Bounds::Friction {
                    normal: Some(0),
                    limit,
                    rows: rows - 1,
                },
                grip: Grip::Held,
            },
        ];
        Problem {
            rows,
            a,
            b,
            elements,
            ..Problem::default()
        }
    }

    #[test]
    fn a_block_on_the_ground_stands_slides_or_leaves() {
        let unit = vec![1.0, 0.0, 0.0, 1.0];
        let mut stands = contact(unit.clone(), vec![-10.0, 3.0], 0.5);
        assert!(stands.resolve());
        assert_eq!(stands.force, [10.0, -3.0]);
        let mut slides = contact(unit.clone(), vec![-10.0, 6.0], 0.5);
        assert!(slides.resolve());
        assert_eq!((slides.force[1], slides.motion[1]), (-5.0, 1.0));
        let mut leaves = contact(unit, vec![10.0, 6.0], 0.5);
        assert!(leaves.resolve());
        assert_eq!(leaves.force, [0.0, 0.0]);
    }

    #[test]
    fn no_friction_slides_along_what_pushes() {
        let mut unit = vec![0.0; 9];
        (0..3).for_each(|k| unit[k * 4] = 1.0);
        let mut slides = contact(unit, vec![-10.0, 3.0, 4.0], 0.1);
        assert!(slides.resolve());
        let f = &slides.force;
        assert!(
            (f[1] + 0.6).abs() < 1e-12 && (f[2] + 0.8).abs() < 1e-12,
            "{f:?}"
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig { rng_seed: proptest::test_runner::RngSeed::Fixed(1), failure_persistence: None, ..ProptestConfig::with_cases(500) })]

        /// Three feet that can squeeze the ground between them: their forces are not unique, but there are some, and they
        /// obey the laws.
        #[test]
        fn three_feet_that_squeeze_the_ground_find_forces(
            feet in prop::collection::vec(-0.2..0.2_f64, 6),
            spread in 0.1..0.3_f64,
            push in prop::array::uniform6(-1.0..1.0_f64),
            limit in 0.05..1.5_f64,
            slide in prop::array::uniform3(-1.0..1.0_f64),
        ) {
            // Rows of a unit mass with unit inertia: up, along and across at three feet below its middle.
            let place = |k: usize| {
                let angle = 2.1 * k as f64;
                [spread * angle.cos() + 0.3 * feet[2 * k], spread * angle.sin() + 0.3 * feet[2 * k + 1], -0.2]
            };
            let rows: Vec<[f64; 6]> = (0..9)
                .map(|r| {
                    let [x, y, z] = place(r / 3);
                    match r % 3 {
                        0 => [0.0, 0.0, 1.0, y, -x, 0.0],
                        1 => [1.0, 0.0, 0.0, 0.0, z, -y],
                        _ => [0.0, 1.0, 0.0, -z, 0.0, x],
                    }
                })
                .collect();
            let dot = |a: &[f64; 6], b: &[f64; 6]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            // Feet give way a little, as in a step.
            let a = (0..81)
                .map(|k| dot(&rows[k / 9], &rows[k % 9]) * if k / 9 == k % 9 { 1.0 + 1e-8 } else { 1.0 })
                .collect();
            // It is pressed onto the ground, and slides or hardly does.
            let motion = [0.01 * slide[0], 0.01 * slide[1], -1.0, 0.1 * push[3], 0.1 * push[4], slide[2]];
            let b = rows.iter().map(|row| dot(row, &motion)).collect();
            let elements = [0, 3, 6]
                .into_iter()
                .flat_map(|row| [
                    Element { row, bounds: Bounds::Between(0.0, f64::INFINITY), grip: Grip::Held },
                    Element {
                        row: row + 1,
                        bounds: Bounds::Friction { normal: Some(row), limit, rows: 2 },
                        grip: Grip::Along([1.0, 0.0]),
                    },
                ])
                .collect();
            let mut p = Problem { rows: 9, a, b, elements, ..Problem::default() };
            prop_assert!(p.resolve_step());
            prop_assert!(p.approximate == usize::from(!p.obeys(CREEP)));
            for n in [0, 3, 6] {
                let (f, w) = (p.force[n], p.motion[n]);
                prop_assert!(f >= -1e-9 && w >= -1e-5 && (f * w).abs() < 1e-5, "normal {f} {w}");
                prop_assert!(p.force[n + 1].hypot(p.force[n + 2]) <= limit * f + 1e-7);
            }
        }

        /// Whatever the masses and the pushes: contact forces obey Signorini's and Coulomb's laws.
        /// Low friction, so that rigid bodies always have an answer.
        #[test]
        fn forces_obey_the_laws(
            j in prop::collection::vec(-1.0..1.0_f64, 36),
            b in prop::collection::vec(-10.0..10.0_f64, 6),
            limit in 0.0..0.3_f64,
        ) {
            // A = J Jᵀ + a bit on the diagonal: two contacts of a body with six freedoms.
            let a: Vec<f64> = (0..36)
                .map(|k| {
                    let (r, c) = (k / 6, k % 6);
                    (0..6).map(|i| j[r * 6 + i] * j[c * 6 + i]).sum::<f64>() + if r == c { 0.5 } else { 0.0 }
                })
                .collect();
            let elements = [0, 3]
                .into_iter()
                .flat_map(|row| [
                    Element { row, bounds: Bounds::Between(0.0, f64::INFINITY), grip: Grip::Held },
                    Element { row: row + 1, bounds: Bounds::Friction { normal: Some(row), limit, rows: 2 }, grip: Grip::Held },
                ])
                .collect();
            let mut p = Problem { rows: 6, a, b, elements, ..Problem::default() };
            prop_assert!(p.resolve());
            for n in [0, 3] {
                let (f, w) = (p.force[n], p.motion[n]);
                prop_assert!(f >= -1e-9 && w >= -1e-6 && (f * w).abs() < 1e-5, "normal {f} {w}");
                let (t, v) = ([p.force[n + 1], p.force[n + 2]], [p.motion[n + 1], p.motion[n + 2]]);
                let (size, speed) = (t[0].hypot(t[1]), v[0].hypot(v[1]));
                prop_assert!(size <= limit * f + 1e-7);
                if speed > 1e-5 && f > 1e-6 {
                    prop_assert!((size - limit * f).abs() < 1e-6);
                    prop_assert!((t[0] * v[0] + t[1] * v[1] + size * speed).abs() < 1e-5 * (1.0 + speed));
                }
            }
        }
    }
}
