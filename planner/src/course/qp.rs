//! Convex quadratic programs, solved by `clarabel`: the only place that knows it.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};

/// Least ½ xᵀ H x + gᵀ x with A x ≥ b, the first `equalities` rows with equality.
#[derive(Clone, Debug, Default)]
pub(super) struct Qp {
    /// Columns of the symmetric H, positive semidefinite: n × n.
    pub(super) hessian: Vec<f64>,
    /// g: n.
    pub(super) gradient: Vec<f64>,
    /// Rows of A, one after the other: m × n.
    pub(super) rows: Vec<f64>,
    /// b: m.
    pub(super) bounds: Vec<f64>,
    /// Leading rows that hold with equality.
    pub(super) equalities: usize,
}

/// What came of a quadratic program.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Outcome {
    /// Solved: x, and a multiplier for each row, ≥ 0 where it is an inequality.
    Solved { x: Vec<f64>, multipliers: Vec<f64> },
    /// No x satisfies the rows.
    Infeasible,
    /// The solver stopped for another reason.
    Stopped,
}

impl Qp {
    /// Solves it.
    pub(super) fn solve(&self) -> Outcome {
        let (n, m) = (self.gradient.len(), self.bounds.len());
        let hessian = sparse(
            n,
            n,
            |i, j| if i <= j { self.hessian[j * n + i] } else { 0.0 },
        );
        // clarabel's rows are A x + s = b with s ≥ 0.
        let rows = sparse(m, n, |i, j| -self.rows[i * n + j]);
        let bounds: Vec<f64> = self.bounds.iter().map(|b| -b).collect();
        let cones = [
            SupportedConeT::ZeroConeT(self.equalities),
            SupportedConeT::NonnegativeConeT(m - self.equalities),
        ];
        let cones = if self.equalities == 0 {
            &cones[1..]
        } else {
            &cones[..]
        };
        let Ok(mut solver) =
            DefaultSolver::new(&hessian, &self.gradient, &rows, &bounds, cones, settings())
        else {
            return Outcome::Stopped;
        };
        solver.solve();
        let solution = solver.solution;
        match solution.status {
            SolverStatus::Solved | SolverStatus::AlmostSolved => Outcome::Solved {
                x: solution.x,
                multipliers: solution.z,
            },
            SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible => {
                Outcome::Infeasible
            }
            _ => Outcome::Stopped,
        }
    }
}

/// Small dense problems in, exact solutions out: no presolve, no scaling, tolerances near
/// round-off.
fn settings() -> DefaultSettings<f64> {
    DefaultSettings {
        verbose: false,
        presolve_enable: false,
        equilibrate_enable: false,
        tol_gap_abs: 1e-11,
        tol_gap_rel: 1e-11,
        tol_feas: 1e-11,
        ..DefaultSettings::default()
    }
}

/// The nonzero entries of a dense matrix, by columns.
fn sparse(rows: usize, columns: usize, entry: impl Fn(usize, usize) -> f64) -> CscMatrix<f64> {
    let mut starts = vec![0];
    let (mut row_of, mut values) = (
        Vec::with_capacity(rows * columns),
        Vec::with_capacity(rows * columns),
    );
    for j in 0..columns {
        for i in 0..rows {
            let value = entry(i, j);
            if value != 0.0 {
                row_of.push(i);
                values.push(value);
            }
        }
        starts.push(values.len());
    }
    CscMatrix::new(rows, columns, starts, row_of, values)
}
