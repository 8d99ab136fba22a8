//! The controller's small QPs against clarabel, on random problems, a good part of them without a
//! solution.
//!
//!     cd studies && cargo run --release --bin qp_million -- 1000000

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus};
use rand_distr::{Distribution, StandardNormal, Uniform};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;
use saltus_controller::Reason;
use saltus_controller::qp::{self, HalfLine, HalfPlane};

/// A problem with one variable or two.
struct Problem {
    variables: usize,
    h: [f64; 3],
    g: [f64; 2],
    constraints: Vec<HalfPlane<f64>>,
}

/// What became of them.
#[derive(Default)]
struct Tally {
    solved: usize,
    infeasible: usize,
    /// Ours and clarabel's answers differ by more than [`APART`], or one says infeasible: with a
    /// margin (m) below [`MARGIN`].
    marginal: usize,
    /// The same, and clearly.
    different: usize,
    /// Clarabel ends without an answer.
    unfinished: usize,
    /// Greatest difference, relative to 1 + |x|.
    worst: f64,
}

/// Greatest difference that counts as agreement: clarabel's tolerance is 1e-9 in the objective, of
/// which a point is the square root.
const APART: f64 = 1e-5;
/// Least size of the interior (as the largest s for which a x ≤ b − s |a| can be kept, or must be
/// broken) that says feasible or not for sure.
const MARGIN: f64 = 1e-6;

fn problem(random: &mut Pcg64) -> Problem {
    let mut normal = || -> f64 { StandardNormal.sample(random) };
    let variables = if normal() > 0.0 { 2 } else { 1 };
    let l = [normal(), normal(), normal()];
    let h = [
        l[0] * l[0] + 0.1,
        l[0] * l[1],
        l[1] * l[1] + l[2] * l[2] + 0.1,
    ];
    let g = [3.0 * normal(), 3.0 * normal()];
    let inside = [normal(), normal()];
    // Half of the problems are about a point that keeps all, with room of different size; the
    // others may have none.
    let feasible = normal() > 0.0;
    let count = Uniform::new_inclusive(0, 8).map_or(0, |range| range.sample(random));
    let constraints = (0..count)
        .map(|_| {
            let mut normal = || -> f64 { StandardNormal.sample(random) };
            let a = [normal(), if variables == 2 { normal() } else { 0.0 }];
            let room = normal();
            let bound =
                a[0] * inside[0] + a[1] * inside[1] + if feasible { room.abs() } else { room };
            HalfPlane { normal: a, bound }
        })
        .collect();
    Problem {
        variables,
        h,
        g,
        constraints,
    }
}

fn ours(p: &Problem) -> Result<[f64; 2], Reason> {
    if p.variables == 2 {
        return qp::two(p.h, p.g, &p.constraints);
    }
    let lines: Vec<_> = p
        .constraints
        .iter()
        .map(|c| HalfLine {
            slope: c.normal[0],
            bound: c.bound,
        })
        .collect();
    qp::one(p.h[0], p.g[0], &lines).map(|x| [x, 0.0])
}

/// Clarabel's answer at a tolerance of 1e-11, or, where its steps end before that, of 1e-9 and its
/// own 1e-8; none for infeasible, an error for any other end.
fn clarabel(
    n: usize,
    h: &[f64],
    g: &[f64],
    constraints: &[(Vec<f64>, f64)],
) -> Result<Option<Vec<f64>>, SolverStatus> {
    solved(n, h, g, constraints, 1e-11)
        .or_else(|_| solved(n, h, g, constraints, 1e-9))
        .or_else(|_| solved(n, h, g, constraints, 1e-8))
}

fn solved(
    n: usize,
    h: &[f64],
    g: &[f64],
    constraints: &[(Vec<f64>, f64)],
    tolerance: f64,
) -> Result<Option<Vec<f64>>, SolverStatus> {
    let m = constraints.len();
    let upper = CscMatrix::new(
        n,
        n,
        (0..=n).map(|j| j * (j + 1) / 2).collect(),
        (0..n).flat_map(|j| 0..=j).collect(),
        h.to_vec(),
    );
    let columns = CscMatrix::new(
        m,
        n,
        (0..=n).map(|j| j * m).collect(),
        (0..n).flat_map(|_| 0..m).collect(),
        (0..n)
            .flat_map(|j| constraints.iter().map(move |c| c.0[j]))
            .collect(),
    );
    let bounds: Vec<f64> = constraints.iter().map(|c| c.1).collect();
    let settings = DefaultSettings {
        verbose: false,
        presolve_enable: false,
        tol_gap_abs: tolerance,
        tol_gap_rel: tolerance,
        tol_feas: tolerance,
        ..DefaultSettings::default()
    };
    let mut solver = DefaultSolver::new(
        &upper,
        g,
        &columns,
        &bounds,
        &[NonnegativeConeT(m)],
        settings,
    )
    .map_err(|_| SolverStatus::Unsolved)?;
    solver.solve();
    match solver.solution.status {
        SolverStatus::Solved | SolverStatus::AlmostSolved => Ok(Some(solver.solution.x.clone())),
        SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible => Ok(None),
        other => Err(other),
    }
}

fn rows(p: &Problem) -> Vec<(Vec<f64>, f64)> {
    p.constraints
        .iter()
        .map(|c| (c.normal[..p.variables].to_vec(), c.bound))
        .collect()
}

/// How far inside, or outside, of all constraints the best point is, up to 1: by clarabel,
/// maximising s.
fn margin(p: &Problem) -> f64 {
    let n = p.variables;
    let mut constraints: Vec<(Vec<f64>, f64)> = rows(p)
        .into_iter()
        .map(|(mut a, b)| {
            let norm = a.iter().map(|x| x * x).sum::<f64>().sqrt();
            a.push(norm);
            (a, b)
        })
        .collect();
    let mut most = vec![0.0; n + 1];
    most[n] = 1.0;
    constraints.push((most.clone(), 1.0));
    // A little curvature keeps it bounded.
    let h: Vec<f64> = (0..=n)
        .flat_map(|j| (0..=j).map(move |i| if i == j { 1e-9 } else { 0.0 }))
        .collect();
    let mut g = vec![0.0; n + 1];
    g[n] = -1.0;
    clarabel(n + 1, &h, &g, &constraints)
        .ok()
        .flatten()
        .map_or(f64::NAN, |x| x[n])
}

fn compare(p: &Problem, tally: &mut Tally) {
    let h = if p.variables == 2 {
        p.h.to_vec()
    } else {
        vec![p.h[0]]
    };
    let theirs = clarabel(p.variables, &h, &p.g[..p.variables], &rows(p));
    let agree = match (ours(p), &theirs) {
        (Ok(x), Ok(Some(y))) => {
            let scale = 1.0 + y.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
            let apart = y
                .iter()
                .zip(x)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max)
                / scale;
            tally.solved += 1;
            if apart <= APART {
                tally.worst = tally.worst.max(apart);
            }
            apart <= APART
        }
        (Err(Reason::Infeasible), Ok(None)) => {
            tally.infeasible += 1;
            true
        }
        _ => false,
    };
    if theirs.is_err() {
        tally.unfinished += 1;
    } else if !agree {
        let margin = margin(p);
        if margin.abs() < MARGIN {
            tally.marginal += 1;
        } else {
            tally.different += 1;
            println!(
                "{:?}, clarabel {theirs:?}, margin {margin:e}: {:?} {:?} {:?}",
                ours(p),
                p.h,
                p.g,
                p.constraints
            );
        }
    }
}

fn main() {
    let count: usize = std::env::args()
        .nth(1)
        .map_or(5_000, |text| text.parse().expect("a number of problems"));
    let mut random = Pcg64::seed_from_u64(5);
    let mut tally = Tally::default();
    for _ in 0..count {
        compare(&problem(&mut random), &mut tally);
    }
    let Tally {
        solved,
        infeasible,
        marginal,
        different,
        unfinished,
        worst,
    } = tally;
    println!(
        "{count} problems of one and two variables: {solved} solved, {infeasible} infeasible, \
         {marginal} infeasible or not by less than {MARGIN}, {unfinished} where clarabel ends \
         without an answer, {different} different; greatest difference {worst:.1e} of 1 + |x|"
    );
    assert!(different == 0 && unfinished * 10_000 <= count);
}
