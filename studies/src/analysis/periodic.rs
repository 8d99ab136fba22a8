//! Periodic gaits: states that come back after so many legs, and whether neighbours do.

use nalgebra::{Complex, DMatrix, DVector};
use saltus_gait::GaitError;
use saltus_numeric::parallel;

use super::chart::{Chart, distance};
use super::stride::{Stride, StrideState, Strides};

/// A gait that repeats itself.
#[derive(Clone, Debug)]
pub struct Periodic {
    /// After how many legs.
    pub legs: usize,
    /// Its state on the section.
    pub state: StrideState,
    /// How long it takes (s).
    pub period: f64,
    /// Mean speed (m/s).
    pub speed: f64,
    /// Gas from the supply over the way (kg/m).
    pub gas: f64,
    /// Work of the drives over the way (J/m).
    pub work: f64,
    /// How far from its begin it ends: the greatest difference in units of 1 cm, 1 m/s, 0.2 bar.
    pub residual: f64,
    /// Floquet multipliers, the greatest first.
    pub multipliers: Vec<Multiplier>,
    /// What its feet do, leg by leg: [`Stride::contacts`].
    pub contacts: Vec<Vec<(usize, bool)>>,
}

/// By how much a small difference is multiplied from one period to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Multiplier {
    /// Its value.
    pub value: Complex<f64>,
    /// By how much differences of another width move it.
    pub error: f64,
}

impl Periodic {
    /// The greatest modulus among the multipliers, with its error; 0 where nothing is left to differ.
    pub fn greatest(&self) -> (f64, f64) {
        let first = self.multipliers.first();
        first.map_or((0.0, 0.0), |m| (m.value.norm(), m.error))
    }

    /// Whether neighbours come nearer, the multipliers' error taken off.
    pub fn is_stable(&self) -> bool {
        let (most, error) = self.greatest();
        most + error < 1.0
    }
}

/// What a search for a periodic gait came to.
#[derive(Clone, Debug)]
pub enum Search {
    /// It was found.
    Found(Box<Periodic>),
    /// Newton's method came no nearer than this, in the units of [`Periodic::residual`].
    Missed(f64),
    /// It stalls.
    Stalled,
}

impl Search {
    /// The gait, if it was found.
    pub fn found(self) -> Option<Periodic> {
        match self {
            Search::Found(gait) => Some(*gait),
            _ => None,
        }
    }
}

/// Residual at which a gait counts as periodic: what steps to a tolerance of 1e-10 leave after a
/// dozen events.
pub const CLOSED: f64 = 1e-6;
/// Widths of differences, in the units of [`Periodic::residual`]: what a multiplier is taken from, and
/// half of it.
const WIDTH: f64 = 2e-4;
/// Newton steps.
const STEPS: usize = 12;

/// The periodic gait of `legs` legs near `start`, by Newton's method on the section, damped, with the
/// Jacobian by central differences.
///
/// # Errors
/// [`GaitError::Sim`] for a start that cannot be.
pub fn find(strides: &Strides, start: &StrideState, legs: usize) -> Result<Search, GaitError> {
    let mut state = start.clone();
    let Some(mut end) = after(strides, &state, legs)? else {
        return Ok(Search::Stalled);
    };
    let rig = strides.rig();
    let mut residual = distance(rig, &state, &end);
    for _ in 0..STEPS {
        if residual < CLOSED {
            break;
        }
        // A chart around the end: what holds there is what the gait does, whatever the start was.
        let chart = Chart::new(strides, &end);
        let x = chart.coordinates(&state);
        let Some(slopes) = slopes(strides, &chart, &x, legs, WIDTH) else {
            break;
        };
        let off = -x.clone();
        let matrix = slopes - DMatrix::identity(chart.dimension(), chart.dimension());
        // P(x) − x = 0, where P(x) is the origin.
        let Some(step) = matrix.lu().solve(&(-off)) else {
            break;
        };
        let Some(better) = damped(strides, &chart, &x, &step, (legs, residual)) else {
            break;
        };
        (state, end, residual) = better;
    }
    if residual >= CLOSED {
        return Ok(Search::Missed(residual));
    }
    let legs = fewest(strides, &end, legs)?;
    Ok(match describe(strides, &end, legs)? {
        Some(gait) => Search::Found(Box::new(gait)),
        None => Search::Stalled,
    })
}

/// The fewest legs, of which `legs` are a multiple, after which `state` comes back.
fn fewest(strides: &Strides, state: &StrideState, legs: usize) -> Result<usize, GaitError> {
    let done = strides.strides(state, legs)?;
    let back = |k: &usize| {
        let end = done.get(k - 1);
        let far = end.map(|end| distance(strides.rig(), state, &end.state));
        legs.is_multiple_of(*k) && far.is_some_and(|far| far < 10.0 * CLOSED)
    };
    Ok((1..legs).find(back).unwrap_or(legs))
}

/// A state, where it ends, and how far from itself.
type Tried = (StrideState, StrideState, f64);

/// The longest part of a Newton step that comes nearer.
fn damped(
    strides: &Strides,
    chart: &Chart<'_>,
    x: &DVector<f64>,
    step: &DVector<f64>,
    (legs, residual): (usize, f64),
) -> Option<Tried> {
    let mut part = 1.0;
    for _ in 0..7 {
        let state = chart.state(&(x + step * part));
        // A step may lead where nothing can stand.
        if let Ok(Some(end)) = after(strides, &state, legs) {
            let left = distance(strides.rig(), &state, &end);
            if left < residual {
                return Some((state, end, left));
            }
        }
        part *= 0.5;
    }
    None
}

/// The state after so many legs; none where it stalls.
fn after(
    strides: &Strides,
    state: &StrideState,
    legs: usize,
) -> Result<Option<StrideState>, GaitError> {
    let mut done = strides.strides(state, legs)?;
    Ok((done.len() == legs)
        .then(|| done.pop())
        .flatten()
        .map(|stride| stride.state))
}

/// How the coordinates after so many legs change with those at `x`, by central differences of
/// `width`; none where a neighbour stalls or cannot be.
fn slopes(
    strides: &Strides,
    chart: &Chart<'_>,
    x: &DVector<f64>,
    legs: usize,
    width: f64,
) -> Option<DMatrix<f64>> {
    let n = chart.dimension();
    let column = |k: usize| -> Option<DVector<f64>> {
        let end = |step: f64| {
            let mut moved = x.clone();
            moved[k] += step;
            let end = after(strides, &chart.state(&moved), legs).ok().flatten()?;
            Some(chart.coordinates(&end))
        };
        Some((end(width)? - end(-width)?) / (2.0 * width))
    };
    let columns: Option<Vec<DVector<f64>>> = parallel::map_on(strides.threads(), n, column)
        .into_iter()
        .collect();
    let columns = columns?;
    Some(if n == 0 {
        DMatrix::zeros(0, 0)
    } else {
        DMatrix::from_columns(&columns)
    })
}

/// The gait of `legs` legs at `state`, which repeats itself.
fn describe(
    strides: &Strides,
    state: &StrideState,
    legs: usize,
) -> Result<Option<Periodic>, GaitError> {
    let done = strides.strides(state, legs)?;
    let Some(end) = done.last().filter(|_| done.len() == legs) else {
        return Ok(None);
    };
    let chart = Chart::new(strides, state);
    let origin = DVector::zeros(chart.dimension());
    let mut of_width = Vec::new();
    for width in [WIDTH, 0.5 * WIDTH] {
        let Some(slopes) = slopes(strides, &chart, &origin, legs, width) else {
            return Ok(None);
        };
        of_width.push(eigenvalues(&slopes));
    }
    let sum = |what: fn(&Stride) -> f64| done.iter().map(what).sum::<f64>();
    let (period, travel) = (sum(|s| s.time), sum(|s| s.travel));
    Ok(Some(Periodic {
        legs,
        state: state.clone(),
        period,
        speed: travel / period,
        gas: sum(|s| s.gas) / travel,
        work: sum(|s| s.work) / travel,
        residual: distance(strides.rig(), state, &end.state),
        multipliers: with_errors(&of_width[1], &of_width[0]),
        contacts: done.iter().map(|stride| stride.contacts.clone()).collect(),
    }))
}

fn eigenvalues(matrix: &DMatrix<f64>) -> Vec<Complex<f64>> {
    if matrix.nrows() == 0 {
        return Vec::new();
    }
    let mut values: Vec<Complex<f64>> = matrix.complex_eigenvalues().iter().copied().collect();
    values.sort_by(|a, b| b.norm().total_cmp(&a.norm()).then(b.im.total_cmp(&a.im)));
    values
}

/// Each of `values` with how far the nearest of `others` is.
fn with_errors(values: &[Complex<f64>], others: &[Complex<f64>]) -> Vec<Multiplier> {
    let error = |value: Complex<f64>| {
        let far = others.iter().map(|other| (other - value).norm());
        far.fold(f64::INFINITY, f64::min)
    };
    let with = |&value: &Complex<f64>| Multiplier {
        value,
        error: error(value),
    };
    values.iter().map(with).collect()
}

/// The periodic gait to which `start` comes: after `warm_up` strides Newton's method begins where the
/// run comes nearest to itself, after at most `most_legs` legs.
///
/// # Errors
/// [`GaitError::Sim`] for a start that cannot be, or a motion that cannot go on.
pub fn settle(
    strides: &Strides,
    start: &StrideState,
    warm_up: usize,
    most_legs: usize,
) -> Result<Search, GaitError> {
    let done = strides.strides(start, warm_up + 2 * most_legs)?;
    if done.len() < warm_up + 2 * most_legs {
        return Ok(Search::Stalled);
    }
    let mut best = Search::Stalled;
    for (at, legs) in returns(strides, &done, most_legs) {
        match find(strides, &done[at].state, legs)? {
            Search::Missed(residual) => {
                let before = match best {
                    Search::Missed(before) => before,
                    _ => f64::INFINITY,
                };
                best = Search::Missed(residual.min(before));
            }
            Search::Stalled => {}
            found @ Search::Found(_) => return Ok(found),
        }
    }
    Ok(best)
}

/// The two nearest returns among the last of `done`: from which stride on, after how many legs. A
/// return after fewer legs goes before one that is not much nearer.
fn returns(strides: &Strides, done: &[Stride], most_legs: usize) -> Vec<(usize, usize)> {
    let last = done.len() - 1;
    let mut found: Vec<(f64, usize, usize)> = Vec::new();
    for legs in 1..=most_legs {
        let nearest = (last - most_legs..=last)
            .filter(|at| *at >= legs)
            .map(|at| {
                let [then, now] = [at - legs, at].map(|k| &done[k].state);
                (distance(strides.rig(), then, now), at)
            })
            .min_by(|a, b| a.0.total_cmp(&b.0));
        found.extend(nearest.map(|(far, at)| (far.max(CLOSED) * (1.0 + legs as f64), at, legs)));
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.truncate(2);
    found.into_iter().map(|(_, at, legs)| (at, legs)).collect()
}

/// The periodic gaits to which upright starts at these `rates` (rad/s) come, each once: as
/// [`settle`] finds them.
///
/// # Errors
/// As [`settle`].
pub fn settled(
    strides: &Strides,
    rates: &[f64],
    [warm_up, most_legs]: [usize; 2],
) -> Result<Vec<Periodic>, GaitError> {
    let mut gaits: Vec<Periodic> = Vec::new();
    for &rate in rates {
        let start = strides.standing(strides.firing().section, rate)?;
        // A start that the simulation cannot go on from is none that comes to a gait.
        let Ok(Search::Found(gait)) = settle(strides, &start, warm_up, most_legs) else {
            continue;
        };
        let is_same = |other: &Periodic| {
            other.legs == gait.legs && (other.period / gait.period - 1.0).abs() < 1e-4
        };
        if !gaits.iter().any(is_same) {
            gaits.push(*gait);
        }
    }
    Ok(gaits)
}
