//! Sequential quadratic programming with exact first derivatives.
//!
//! At each iterate the constraints are linearised, the Lagrangian's Hessian is taken by differences
//! of exact gradients and made positive semidefinite, and the quadratic program is solved within a
//! trust region, a box in units of the variables' ranges. A step is taken if it lowers the exact
//! penalty function
//!
//! ```text
//! φ(x) = f(x) + ν · greatest violation
//! ```
//!
//! An iterate that violates a constraint gets an elastic program: one more variable, how much every
//! row gives way, at the price ν. So no subproblem is infeasible, and a program without a feasible
//! point ends where the greatest violation is locally least.
//!
//! Source: Nocedal & Wright, Numerical Optimization, 2nd ed., chapter 18 (18.5, Sℓ1QP), with the
//! greatest violation in place of their sum.

use nalgebra::DMatrix;
use saltus_numeric::statistics::dot;

use super::Span;
use super::qp::{Outcome, Qp};

/// A smooth program: least cost with values = 0 in the first rows and ≥ 0 in the others, within
/// bounds.
pub trait Nlp {
    /// Allowed values of each variable; finite and with a width, which is its unit in the solver.
    fn bounds(&self) -> Vec<Span>;
    /// Leading rows that must be 0.
    fn equalities(&self) -> usize;
    /// Cost and rows at `x`, with their exact first derivatives.
    fn evaluate(&self, x: &[f64], at: &mut Evaluation);
}

/// Cost and rows of a program, with derivatives. What is not finite counts as a point that cannot
/// be used.
#[derive(Clone, Debug, Default)]
pub struct Evaluation {
    /// Cost.
    pub cost: f64,
    /// Its gradient: n.
    pub gradient: Vec<f64>,
    /// Rows: m.
    pub values: Vec<f64>,
    /// Their derivatives, row after row: m × n.
    pub jacobian: Vec<f64>,
}

/// How the solver stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Most quadratic programs to solve.
    pub iterations: usize,
    /// Least promise of a step, in units of the cost, that is worth taking it.
    pub tolerance: f64,
    /// Greatest violation of a row that counts as none.
    pub feasibility: f64,
    /// First size of the trust region, in units of the variables' ranges.
    pub radius: f64,
}

impl Default for Settings {
    fn default() -> Settings {
        Settings {
            iterations: 100,
            tolerance: 1e-10,
            feasibility: 1e-10,
            radius: 0.1,
        }
    }
}

/// Why the solver stopped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Status {
    /// No step promises anything, and every row holds.
    Converged,
    /// No step lessens the violation of `row`, the worst one, by `violation`.
    Infeasible {
        /// Index of the row.
        row: usize,
        /// By how much it is violated, in the row's unit.
        violation: f64,
    },
    /// Too many iterations, or steps too short to go on.
    IterationLimit,
}

/// What the solver did.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// Why it stopped.
    pub status: Status,
    /// The last iterate; if a row is violated there, the cheapest at which all held, where there
    /// was one.
    pub x: Vec<f64>,
    /// Cost there.
    pub cost: f64,
    /// Greatest violation of a row there.
    pub violation: f64,
    /// Greatest component of the Lagrangian's gradient there, in units of the variables' ranges;
    /// components that push against a bound do not count.
    pub kkt_residual: f64,
    /// Multipliers of the rows.
    pub multipliers: Vec<f64>,
    /// Quadratic programs solved.
    pub iterations: usize,
}

/// Greatest price of a violation.
const PRICE_LIMIT: f64 = 1e8;

/// The price is raised by this factor, up to this limit, where the rows then give way by no more
/// than this part.
const STEERING: f64 = 10.0;
const STEERING_LIMIT: f64 = 1e6;
const STEERED: f64 = 0.9;

/// Least size of the trust region.
const RADIUS_LIMIT: f64 = 1e-9;

/// Steps (in units of the ranges) that do what they promise and changes of the multipliers (of
/// their sum) below these leave the Hessian as it is.
const SHORT: f64 = 0.01;
const STEADY: f64 = 0.05;

/// Solves a program from `x`.
pub fn solve<P: Nlp>(nlp: &P, x: &[f64], settings: &Settings) -> Report {
    let mut iterate = Iterate::new(nlp, x, settings);
    let mut status = Status::IterationLimit;
    while iterate.count < settings.iterations && iterate.radius > RADIUS_LIMIT {
        if let Some(end) = iterate.advance() {
            status = end;
            break;
        }
    }
    iterate.report(status)
}

/// A step that the quadratic program proposes.
struct Step {
    /// In units of the ranges.
    d: Vec<f64>,
    /// By how much the rows still give way.
    give: f64,
    /// How much less the cost is in the model.
    gain: f64,
}

struct Iterate<'a, P> {
    nlp: &'a P,
    settings: &'a Settings,
    bounds: Vec<Span>,
    x: Vec<f64>,
    at: Evaluation,
    trial: Evaluation,
    hessian: Vec<f64>,
    /// The multipliers that the Hessian was taken with.
    weights: Vec<f64>,
    multipliers: Vec<f64>,
    radius: f64,
    price: f64,
    count: usize,
    /// The cheapest iterate so far at which every row holds.
    best: Option<(Vec<f64>, Evaluation)>,
}

impl<'a, P: Nlp> Iterate<'a, P> {
    fn new(nlp: &'a P, x: &[f64], settings: &'a Settings) -> Self {
        let bounds = nlp.bounds();
        let x: Vec<f64> = x.iter().zip(&bounds).map(|(x, b)| b.clamp(*x)).collect();
        let mut at = Evaluation::default();
        nlp.evaluate(&x, &mut at);
        let multipliers = vec![0.0; at.values.len()];
        let (trial, radius, price) = (at.clone(), settings.radius, 10.0);
        let mut iterate = Iterate {
            nlp,
            settings,
            bounds,
            x,
            at,
            trial,
            hessian: Vec::new(),
            weights: Vec::new(),
            multipliers,
            radius,
            price,
            count: 0,
            best: None,
        };
        iterate.remember();
        iterate.hessian = iterate.curvature();
        iterate
    }

    /// One quadratic program, and the step if it is good. The status if there is nothing left to
    /// do.
    fn advance(&mut self) -> Option<Status> {
        let (violation, row) = self.violation(&self.at);
        let Some(step) = self.propose(violation) else {
            self.radius *= 0.25;
            return None;
        };
        let promise = step.gain + self.price * (violation - step.give);
        // What is promised for a lesser violation is known to the violation's round-off.
        let round_off = self.price * violation.min(self.settings.feasibility);
        if promise <= self.settings.tolerance + round_off || !promise.is_finite() {
            if violation <= self.settings.feasibility {
                return Some(Status::Converged);
            }
            self.price *= 10.0;
            return (self.price > PRICE_LIMIT).then_some(Status::Infeasible { row, violation });
        }
        self.try_step(&step, violation, promise);
        None
    }

    /// Takes the step, or the step and a second one from where it leads, if the penalty function
    /// falls by a fair part of the promise, and fits the trust region to it.
    ///
    /// A step along a curved constraint, or along a curved valley of the cost, leaves it; the
    /// second one leads back.
    fn try_step(&mut self, step: &Step, violation: f64, promise: f64) {
        let mut x = self.moved(&step.d);
        let mut ratio = self.fall(&x, violation) / promise;
        if ratio < 0.75
            && let Some(second) = self.onward(&x)
        {
            let second_ratio = self.fall(&second, violation) / promise;
            if second_ratio > ratio {
                (x, ratio) = (second, second_ratio);
            } else {
                ratio = self.fall(&x, violation) / promise;
            }
        }
        let length = step.d.iter().fold(0.0, |m: f64, d| m.max(d.abs()));
        if ratio > 0.75 && length > 0.9 * self.radius {
            self.radius = (2.0 * self.radius).min(1.0);
        } else if ratio.is_nan() || ratio < 0.25 {
            self.radius = 0.25 * self.radius.min(length);
        }
        if ratio > 1e-3 {
            self.x = x;
            std::mem::swap(&mut self.at, &mut self.trial);
            self.remember();
            let is_as_promised = (0.75..1.25).contains(&ratio);
            if length > SHORT || !is_as_promised || self.multipliers_moved() {
                self.hessian = self.curvature();
            }
        }
    }

    /// Whether the multipliers are no longer about those of the Hessian.
    fn multipliers_moved(&self) -> bool {
        let moved: f64 = self
            .multipliers
            .iter()
            .zip(&self.weights)
            .map(|(a, b)| (a - b).abs())
            .sum();
        moved > STEADY * self.multipliers.iter().map(|m| m.abs()).sum::<f64>()
    }

    /// The iterate after a step.
    fn moved(&self, d: &[f64]) -> Vec<f64> {
        self.x
            .iter()
            .zip(d)
            .zip(&self.bounds)
            .map(|((x, d), b)| b.clamp(x + d * b.width()))
            .collect()
    }

    /// By how much the penalty function falls from here, where the violation is `violation`, to
    /// `x`.
    fn fall(&mut self, x: &[f64], violation: f64) -> f64 {
        self.nlp.evaluate(x, &mut self.trial);
        let after = self.violation(&self.trial).0;
        self.at.cost - self.trial.cost + self.price * (violation - after)
    }

    /// Keeps the iterate if every row holds and none of those was cheaper.
    fn remember(&mut self) {
        let is_cheaper = self
            .best
            .as_ref()
            .is_none_or(|(_, best)| self.at.cost < best.cost);
        if is_cheaper && self.violation(&self.at).0 <= self.settings.feasibility {
            self.best = Some((self.x.clone(), self.at.clone()));
        }
    }

    /// Where the step from `x` leads, whose evaluation is the trial, with the Hessian as it is (the
    /// watchdog technique, Nocedal & Wright, 15.6).
    fn onward(&mut self, x: &[f64]) -> Option<Vec<f64>> {
        let (multipliers, price) = (self.multipliers.clone(), self.price);
        let here = std::mem::replace(&mut self.x, x.to_vec());
        std::mem::swap(&mut self.at, &mut self.trial);
        let (violation, _) = self.violation(&self.at);
        let step = if violation.is_finite() {
            self.propose(violation)
        } else {
            None
        };
        let onward = step.map(|step| self.moved(&step.d));
        std::mem::swap(&mut self.at, &mut self.trial);
        self.x = here;
        (self.multipliers, self.price) = (multipliers, price);
        onward
    }

    /// Greatest violation of a row, and which; infinite where a value is not finite.
    fn violation(&self, at: &Evaluation) -> (f64, usize) {
        let equalities = self.nlp.equalities();
        let mut worst = (
            if at.cost.is_finite() {
                0.0
            } else {
                f64::INFINITY
            },
            0,
        );
        for (row, &value) in at.values.iter().enumerate() {
            let violation = if row < equalities {
                value.abs()
            } else {
                -value
            };
            if violation > worst.0 || violation.is_nan() {
                worst = (
                    if violation.is_nan() {
                        f64::INFINITY
                    } else {
                        violation
                    },
                    row,
                );
            }
        }
        worst
    }

    /// Solves the quadratic program here; updates the multipliers and the price.
    fn propose(&mut self, violation: f64) -> Option<Step> {
        self.count += 1;
        let n = self.x.len();
        let elastic = violation > self.settings.feasibility;
        let rows = self.relevant_rows();
        let mut qp = self.subproblem(&rows, elastic);
        let Outcome::Solved {
            x: mut d,
            mut multipliers,
        } = qp.solve()
        else {
            return None;
        };
        if elastic {
            // A price below what the cost gains from a violation leads away from what is allowed:
            // it is raised as long as the rows then give way less (steering; Byrd, Nocedal & Waltz,
            // Optim. Methods Softw. 23, 2008).
            while d[n] > self.settings.feasibility && self.price < STEERING_LIMIT {
                qp.gradient[n] = STEERING * self.price;
                let Outcome::Solved {
                    x,
                    multipliers: raised,
                } = qp.solve()
                else {
                    break;
                };
                if x[n] > STEERED * d[n] {
                    break;
                }
                (d, multipliers, self.price) = (x, raised, STEERING * self.price);
            }
        }
        let give = if elastic { d[n].max(0.0) } else { 0.0 };
        d.truncate(n);
        self.multipliers.fill(0.0);
        // In the elastic program each equality is two rows.
        let signed = rows.iter().flat_map(|&row| {
            let twice = elastic && row < self.nlp.equalities();
            std::iter::once((row, 1.0)).chain(twice.then_some((row, -1.0)))
        });
        for ((row, sign), multiplier) in signed.zip(&multipliers) {
            self.multipliers[row] += sign * multiplier;
        }
        let sum: f64 = self.multipliers.iter().map(|m| m.abs()).sum();
        if 1.5 * sum > self.price && give <= self.settings.feasibility {
            self.price = 2.0 * sum;
        }
        let gain = -(0..n)
            .map(|i| d[i] * (qp.gradient[i] + 0.5 * dot(&self.hessian[i * n..][..n], &d)))
            .sum::<f64>();
        Some(Step { d, give, gain })
    }

    /// Rows that can become active within the trust region.
    fn relevant_rows(&self) -> Vec<usize> {
        let n = self.x.len();
        let can_fall = |row: usize| -> f64 {
            let slopes = self.at.jacobian[row * n..][..n].iter().zip(&self.bounds);
            self.radius * slopes.map(|(s, b)| (s * b.width()).abs()).sum::<f64>()
        };
        let relevant =
            |&row: &usize| row < self.nlp.equalities() || self.at.values[row] <= can_fall(row);
        (0..self.at.values.len()).filter(relevant).collect()
    }

    /// The quadratic program in the step, in units of the ranges, and, if elastic, in the give of
    /// the rows.
    fn subproblem(&self, rows: &[usize], elastic: bool) -> Qp {
        let n = self.x.len();
        let size = n + usize::from(elastic);
        let equalities = if elastic { 0 } else { self.nlp.equalities() };
        let mut qp = Qp {
            hessian: vec![0.0; size * size],
            equalities,
            ..Qp::default()
        };
        for i in 0..n {
            qp.hessian[i * size..][..n].copy_from_slice(&self.hessian[i * n..][..n]);
        }
        qp.gradient.extend(
            self.at
                .gradient
                .iter()
                .zip(&self.bounds)
                .map(|(g, b)| g * b.width()),
        );
        qp.gradient.extend(elastic.then_some(self.price));
        for &row in rows {
            let slopes = self.at.jacobian[row * n..][..n].iter().zip(&self.bounds);
            let slopes: Vec<f64> = slopes.map(|(s, b)| s * b.width()).collect();
            let value = self.at.values[row];
            qp.push(slopes.iter().copied(), elastic, -value);
            if elastic && row < self.nlp.equalities() {
                qp.push(slopes.iter().map(|s| -s), elastic, value);
            }
        }
        for (i, b) in self.bounds.iter().enumerate() {
            let unit = |sign: f64| (0..n).map(move |j| if i == j { sign } else { 0.0 });
            qp.push(
                unit(1.0),
                false,
                ((b.low - self.x[i]) / b.width()).max(-self.radius).min(0.0),
            );
            qp.push(
                unit(-1.0),
                false,
                ((self.x[i] - b.high) / b.width())
                    .max(-self.radius)
                    .min(0.0),
            );
        }
        if elastic {
            qp.push((0..n).map(|_| 0.0), true, 0.0);
        }
        qp
    }

    /// The Lagrangian's gradient at an evaluation, in units of the ranges.
    fn lagrangian(&self, at: &Evaluation) -> Vec<f64> {
        let n = self.x.len();
        let mut slope = at.gradient.clone();
        for (row, &multiplier) in self
            .multipliers
            .iter()
            .enumerate()
            .filter(|(_, m)| **m != 0.0)
        {
            for (s, j) in slope.iter_mut().zip(&at.jacobian[row * n..][..n]) {
                *s -= multiplier * j;
            }
        }
        slope
            .iter()
            .zip(&self.bounds)
            .map(|(s, b)| s * b.width())
            .collect()
    }

    /// The Lagrangian's Hessian by forward differences of its gradient, in units of the ranges,
    /// without its negative eigenvalues.
    fn curvature(&mut self) -> Vec<f64> {
        // Balances truncation against round-off of gradients that are exact to 1e-16.
        const DIFFERENCE: f64 = 1e-7;
        let n = self.x.len();
        self.weights.clone_from(&self.multipliers);
        let base = self.lagrangian(&self.at);
        let mut hessian = DMatrix::zeros(n, n);
        let mut x = self.x.clone();
        for i in 0..n {
            let b = self.bounds[i];
            let h = if (x[i] - b.low) > 0.5 * b.width() {
                -DIFFERENCE
            } else {
                DIFFERENCE
            };
            x[i] += h * b.width();
            let mut trial = std::mem::take(&mut self.trial);
            self.nlp.evaluate(&x, &mut trial);
            for (j, slope) in self.lagrangian(&trial).into_iter().enumerate() {
                hessian[(i, j)] += 0.5 * (slope - base[j]) / h;
                hessian[(j, i)] += 0.5 * (slope - base[j]) / h;
            }
            self.trial = trial;
            x[i] = self.x[i];
        }
        without_negative_curvature(hessian)
    }

    fn report(mut self, status: Status) -> Report {
        if self.violation(&self.at).0 > self.settings.feasibility
            && let Some((x, at)) = self.best.take()
        {
            (self.x, self.at) = (x, at);
        }
        let pushes = |((slope, x), b): ((f64, &f64), &Span)| {
            let edge = 1e-9 * b.width();
            if (*x <= b.low + edge && slope > 0.0) || (*x >= b.high - edge && slope < 0.0) {
                0.0
            } else {
                slope.abs()
            }
        };
        let slopes = self
            .lagrangian(&self.at)
            .into_iter()
            .zip(&self.x)
            .zip(&self.bounds);
        let kkt_residual = slopes.map(pushes).fold(0.0, f64::max);
        let violation = self.violation(&self.at).0;
        let (cost, iterations) = (self.at.cost, self.count);
        Report {
            status,
            x: self.x,
            cost,
            violation,
            kkt_residual,
            multipliers: self.multipliers,
            iterations,
        }
    }
}

impl Qp {
    /// Adds a row: slopes, whether the elastic variable helps it, and its bound.
    fn push(&mut self, slopes: impl Iterator<Item = f64>, elastic: bool, bound: f64) {
        let start = self.rows.len();
        self.rows.extend(slopes);
        self.rows
            .resize(start + self.gradient.len(), f64::from(u8::from(elastic)));
        self.bounds.push(bound);
    }
}

/// The nearest positive semidefinite matrix, by columns; zero where a derivative is not finite.
fn without_negative_curvature(hessian: DMatrix<f64>) -> Vec<f64> {
    if hessian.iter().any(|h| !h.is_finite()) {
        return vec![0.0; hessian.len()];
    }
    let mut eigen = hessian.symmetric_eigen();
    eigen.eigenvalues.iter_mut().for_each(|e| *e = e.max(0.0));
    eigen.recompose().as_slice().to_vec()
}

#[cfg(test)]
mod tests;
