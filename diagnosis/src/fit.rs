//! Parameters from data: Levenberg–Marquardt on Huber's loss, with bounds.

use nalgebra::{DMatrix, DVector};

use crate::kind::{Kind, Parameter, Terms};

/// Residuals beyond so many standard deviations count in proportion to their size only (Huber's loss).
const HUBER: f64 = 3.0;
/// Steps of a fit.
const STEPS: usize = 60;
/// Relative fall of the loss below which a fit is done.
const DONE: f64 = 1e-9;

/// Which readings count: for each run, one flag for each reading.
pub(crate) type Mask = Vec<Vec<bool>>;

/// A model with its parameters fitted.
#[derive(Clone, Debug)]
pub struct Fit {
    /// Indices of the causes that are on.
    pub causes: Vec<usize>,
    /// Parameters of all causes.
    pub terms: Terms,
    /// Unknowns of each run.
    pub unknowns: Vec<Vec<f64>>,
    /// Twice the negative log-likelihood, up to a constant: Σ of Huber's loss of the residuals in standard deviations.
    pub loss: f64,
    /// Standard errors of the parameters of the causes that are on, in their order; infinite where the data do not tell.
    pub errors: Vec<f64>,
    /// Correlation of the least well determined direction with each of these parameters, if their information is singular.
    pub singular: Option<Vec<f64>>,
}

/// Huber's loss of a residual (in standard deviations), and its square root with the residual's sign.
fn huber(r: f64) -> (f64, f64) {
    let size = r.abs();
    let loss = if size <= HUBER { r * r } else { 2.0 * HUBER * size - HUBER * HUBER };
    (loss, loss.sqrt().copysign(r))
}

/// The parameters of a fit in a row: those of the causes that are on, then the unknowns of each run.
struct Layout {
    shared: Vec<(usize, usize, Parameter)>,
    unknowns: Vec<Vec<Parameter>>,
    runs: Vec<usize>,
}

impl Layout {
    fn new(kind: &dyn Kind, causes: &[usize], runs: &[usize], share: bool) -> Layout {
        let all = kind.causes();
        let of = |&c: &usize| {
            all[c].parameters.iter().enumerate().map(move |(p, parameter)| (c, p, parameter.clone()))
        };
        Layout {
            shared: if share { causes.iter().flat_map(of).collect() } else { Vec::new() },
            unknowns: (0..kind.logs().len()).map(|run| kind.unknowns(run)).collect(),
            runs: runs.to_vec(),
        }
    }

    fn parameters(&self) -> impl Iterator<Item = &Parameter> {
        let unknowns = self.runs.iter().flat_map(|&run| &self.unknowns[run]);
        self.shared.iter().map(|(.., p)| p).chain(unknowns)
    }

    fn read(&self, terms: &Terms, unknowns: &[Vec<f64>]) -> Vec<f64> {
        let shared = self.shared.iter().map(|&(c, p, _)| terms.get(c, p));
        shared.chain(self.runs.iter().flat_map(|&run| unknowns[run].iter().copied())).collect()
    }

    fn write(&self, x: &[f64], terms: &mut Terms, unknowns: &mut [Vec<f64>]) {
        for (&(c, p, _), value) in self.shared.iter().zip(x) {
            terms.set(c, p, *value);
        }
        let mut rest = &x[self.shared.len()..];
        for &run in &self.runs {
            let (here, after) = rest.split_at(unknowns[run].len());
            unknowns[run].copy_from_slice(here);
            rest = after;
        }
    }

    /// Columns of the unknowns of the run at place `place` among the runs.
    fn columns(&self, place: usize) -> std::ops::Range<usize> {
        let before: usize = self.runs[..place].iter().map(|&run| self.unknowns[run].len()).sum();
        let start = self.shared.len() + before;
        start..start + self.unknowns[self.runs[place]].len()
    }
}

/// Residuals of a run in standard deviations, those that count, after Huber's square root; none where the model has no answer.
fn residuals(
    kind: &dyn Kind,
    run: usize,
    mask: &Mask,
    terms: &Terms,
    unknowns: &[f64],
) -> Option<Vec<f64>> {
    let predicted = kind.predict(run, terms, unknowns)?;
    let log = &kind.logs()[run];
    let channels = kind.channels();
    let rows = log.readings.iter().zip(&predicted).zip(&mask[run]).filter(|(_, counts)| **counts);
    let of = |(reading, value): (&crate::kind::Reading, &f64)| {
        huber((reading.value - value) / channels[reading.channel].noise).1
    };
    let out: Vec<f64> = rows.map(|(pair, _)| of(pair)).collect();
    out.iter().all(|r| r.is_finite()).then_some(out)
}

/// Everything that a fit works on.
struct Problem<'a> {
    kind: &'a dyn Kind,
    layout: Layout,
    mask: &'a Mask,
    terms: Terms,
    unknowns: Vec<Vec<f64>>,
}

impl Problem<'_> {
    fn at(&mut self, x: &[f64]) -> Option<(Vec<Vec<f64>>, f64)> {
        self.layout.write(x, &mut self.terms, &mut self.unknowns);
        let mut all = Vec::with_capacity(self.layout.runs.len());
        for &run in &self.layout.runs {
            all.push(residuals(self.kind, run, self.mask, &self.terms, &self.unknowns[run])?);
        }
        let loss = all.iter().flatten().map(|r| r * r).sum();
        Some((all, loss))
    }

    /// Normal equations JᵀJ and −Jᵀr in units of the parameters' scales, by central differences.
    fn normal(&mut self, x: &[f64], at: &[Vec<f64>]) -> Option<(DMatrix<f64>, DVector<f64>)> {
        const STEP: f64 = 1e-4;
        let parameters: Vec<Parameter> = self.layout.parameters().cloned().collect();
        let n = x.len();
        let (mut matrix, mut slope) = (DMatrix::zeros(n, n), DVector::zeros(n));
        let shared = self.layout.shared.len();
        for (place, here) in at.iter().enumerate() {
            let run = self.layout.runs[place];
            let columns: Vec<usize> = (0..shared).chain(self.layout.columns(place)).collect();
            let mut jacobian = Vec::with_capacity(columns.len());
            for &j in &columns {
                let p = &parameters[j];
                let side = |way: f64| {
                    let mut moved = x.to_vec();
                    moved[j] = (x[j] + way * STEP * p.scale).clamp(p.bounds.0, p.bounds.1);
                    let (mut terms, mut unknowns) = (self.terms.clone(), self.unknowns.clone());
                    self.layout.write(&moved, &mut terms, &mut unknowns);
                    let r = residuals(self.kind, run, self.mask, &terms, &unknowns[run])?;
                    Some((r, moved[j]))
                };
                let (low, high) = (side(-1.0), side(1.0));
                let ((a, xa), (b, xb)) = match (low, high) {
                    (Some(low), Some(high)) => (low, high),
                    (Some(low), None) => (low, (here.clone(), x[j])),
                    (None, Some(high)) => ((here.clone(), x[j]), high),
                    (None, None) => return None,
                };
                let width = (xb - xa) / p.scale;
                let column: Vec<f64> = if width > 0.0 {
                    a.iter().zip(&b).map(|(a, b)| (b - a) / width).collect()
                } else {
                    vec![0.0; here.len()]
                };
                jacobian.push(column);
            }
            for (i, &row) in columns.iter().enumerate() {
                slope[row] -= jacobian[i].iter().zip(here).map(|(j, r)| j * r).sum::<f64>();
                for (k, &column) in columns.iter().enumerate().take(i + 1) {
                    let sum: f64 = jacobian[i].iter().zip(&jacobian[k]).map(|(a, b)| a * b).sum();
                    matrix[(row, column)] += sum;
                    if row != column {
                        matrix[(column, row)] += sum;
                    }
                }
            }
        }
        Some((matrix, slope))
    }

    /// Levenberg–Marquardt from `x`; the loss and the information matrix at the end.
    fn solve(&mut self, x: &mut Vec<f64>) -> Option<(f64, DMatrix<f64>)> {
        let parameters: Vec<Parameter> = self.layout.parameters().cloned().collect();
        let (mut at, mut loss) = self.at(x)?;
        let mut damping = 1e-3;
        let mut information = DMatrix::zeros(x.len(), x.len());
        for _ in 0..STEPS {
            let (matrix, mut slope) = self.normal(x, &at)?;
            information.copy_from(&matrix);
            // What a bound holds does not move.
            let held: Vec<bool> = parameters
                .iter()
                .zip(x.iter().zip(slope.iter()))
                .map(|(p, (x, s))| (*x <= p.bounds.0 && *s < 0.0) || (*x >= p.bounds.1 && *s > 0.0))
                .collect();
            let mut better = false;
            for _ in 0..12 {
                let mut damped = matrix.clone();
                for i in 0..x.len() {
                    damped[(i, i)] += damping * (matrix[(i, i)] + 1e-12);
                    if held[i] {
                        damped.row_mut(i).fill(0.0);
                        damped.column_mut(i).fill(0.0);
                        damped[(i, i)] = 1.0;
                        slope[i] = 0.0;
                    }
                }
                let Some(step) = damped.cholesky().map(|c| c.solve(&slope)) else {
                    damping *= 10.0;
                    continue;
                };
                let moved: Vec<f64> = x
                    .iter()
                    .zip(step.iter().zip(&parameters))
                    .map(|(x, (s, p))| (x + s * p.scale).clamp(p.bounds.0, p.bounds.1))
                    .collect();
                match self.at(&moved) {
                    Some((there, less)) if less < loss => {
                        let fall = (loss - less) / (loss + 1e-12);
                        (*x, at, loss) = (moved, there, less);
                        damping = (damping * 0.2).max(1e-12);
                        better = fall > DONE;
                        break;
                    }
                    _ => damping *= 6.0,
                }
            }
            if !better {
                break;
            }
        }
        // Leaves the best in place.
        self.at(x)?;
        Some((loss, information))
    }
}

/// Fits the causes `on` and the unknowns of `runs` to the readings that count. Starts from `from`, and from every start of the last cause's
/// parameters.
pub(crate) fn fit(kind: &dyn Kind, on: &[usize], runs: &[usize], mask: &Mask, from: Option<&Fit>) -> Option<Fit> {
    let causes = kind.causes();
    let first: Vec<Vec<f64>> =
        (0..kind.logs().len()).map(|run| kind.unknowns(run).iter().map(|p| p.neutral).collect()).collect();
    let (terms, unknowns) =
        from.map_or_else(|| (Terms::off(causes), first.clone()), |f| (f.terms.clone(), f.unknowns.clone()));
    let mut starts = vec![terms.clone()];
    if let Some(&last) = on.last() {
        let parameters = &causes[last].parameters;
        let most = parameters.iter().map(|p| p.starts.len()).max().unwrap_or(0);
        for k in 0..most {
            let mut start = terms.clone();
            for (i, p) in parameters.iter().enumerate() {
                let value = p.starts.get(k.min(p.starts.len().saturating_sub(1))).copied();
                start.set(last, i, value.unwrap_or(p.neutral));
            }
            starts.push(start);
        }
    }
    let mut best: Option<Fit> = None;
    // The unknowns from where they are, and from their first guesses: a wrong model may have led them astray.
    let begins = [&unknowns, &first];
    let begins = if unknowns == first { &begins[..1] } else { &begins[..] };
    let pairs = starts.iter().flat_map(|start| begins.iter().map(move |begin| (start, begin)));
    for (start, begin) in pairs {
        let layout = Layout::new(kind, on, runs, true);
        let mut problem =
            Problem { kind, layout, mask, terms: start.clone(), unknowns: (*begin).clone() };
        let mut x = problem.layout.read(&problem.terms, &problem.unknowns);
        let Some((loss, information)) = problem.solve(&mut x) else { continue };
        if best.as_ref().is_none_or(|b| loss < b.loss) {
            let (errors, singular) = uncertainty(&problem.layout, &information);
            best = Some(Fit {
                causes: on.to_vec(),
                terms: problem.terms,
                unknowns: problem.unknowns,
                loss,
                errors,
                singular,
            });
        }
    }
    best
}

/// Loss of the readings that count, with the causes' parameters as fitted; the unknowns of `runs` are fitted anew if `refit`.
pub(crate) fn score(kind: &dyn Kind, model: &Fit, runs: &[usize], mask: &Mask, refit: bool) -> Option<f64> {
    let layout = Layout::new(kind, &model.causes, runs, false);
    let mut problem =
        Problem { kind, layout, mask, terms: model.terms.clone(), unknowns: model.unknowns.clone() };
    let mut x = problem.layout.read(&problem.terms, &problem.unknowns);
    if refit {
        return problem.solve(&mut x).map(|(loss, _)| loss);
    }
    problem.at(&x).map(|(_, loss)| loss)
}

/// Fits the unknowns of `runs` anew to the readings that count.
pub(crate) fn refit_unknowns(kind: &dyn Kind, model: &mut Fit, runs: &[usize], mask: &Mask) {
    let layout = Layout::new(kind, &model.causes, runs, false);
    let mut problem =
        Problem { kind, layout, mask, terms: model.terms.clone(), unknowns: model.unknowns.clone() };
    let mut x = problem.layout.read(&problem.terms, &problem.unknowns);
    if problem.solve(&mut x).is_some() {
        model.unknowns = problem.unknowns;
    }
}

/// Standard errors of the shared parameters, and the direction that the data do not tell, if there is one.
fn uncertainty(layout: &Layout, information: &DMatrix<f64>) -> (Vec<f64>, Option<Vec<f64>>) {
    let shared = layout.shared.len();
    if shared == 0 {
        return (Vec::new(), None);
    }
    // The unknowns are eliminated: what is left is what the data say of the causes alone.
    let n = information.nrows();
    let (a, b, d) = (
        information.view((0, 0), (shared, shared)),
        information.view((0, shared), (shared, n - shared)),
        information.view((shared, shared), (n - shared, n - shared)),
    );
    let inner = d.into_owned();
    let ridge = 1e-12 * (inner.trace() / (n - shared).max(1) as f64 + 1e-300);
    let inner = inner + DMatrix::identity(n - shared, n - shared) * ridge;
    let rest = inner.cholesky().map_or_else(
        || DMatrix::zeros(n - shared, shared),
        |c| c.solve(&b.transpose()),
    );
    let left = a.into_owned() - b * rest;
    // In units in which each alone has information 1, the eigenvalues tell how much they stand for one another.
    let sizes: Vec<f64> = (0..shared).map(|i| left[(i, i)].max(0.0).sqrt()).collect();
    let unit = |i: usize| if sizes[i] > 0.0 { sizes[i] } else { 1.0 };
    let scaled = DMatrix::from_fn(shared, shared, |i, j| left[(i, j)] / (unit(i) * unit(j)));
    let eigen = scaled.symmetric_eigen();
    let least = eigen.eigenvalues.imin();
    let singular = (eigen.eigenvalues[least] < 1e-6)
        .then(|| eigen.eigenvectors.column(least).iter().copied().collect());
    let errors = (0..shared)
        .map(|i| {
            let variance: f64 = (0..shared)
                .map(|k| eigen.eigenvectors[(i, k)].powi(2) / eigen.eigenvalues[k].max(1e-14))
                .sum();
            let told = sizes[i] > 0.0;
            let (.., parameter) = &layout.shared[i];
            if told { variance.sqrt() / sizes[i] * parameter.scale } else { f64::INFINITY }
        })
        .collect();
    (errors, singular)
}
