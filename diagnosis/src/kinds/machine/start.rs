//! First guesses: where a run starts, and what nobody knows of the machine.

use nalgebra::{DMatrix, DVector};
use saltus_sim_check::chain::MOST;

use super::Piece;
use super::causes::has_unknown_inertia;
use super::guesses::{Likely, Start};
use super::plant::{Change, Plant, Row, guess};
use super::sizes::Sizes;
use crate::kind::{Channel, Log};
use crate::kinds::FREE;
use crate::kinds::input::Input;
use crate::mechanism::{Mechanism, Shows};

/// Readings of a column from which its value and rate at the start are guessed.
const NEAR: usize = 7;
/// Doubt of a first reading, in terms of its noise or count.
const DOUBT: f64 = 5.0;
/// Readings without a change that show that a machine rests.
const RESTS: usize = 6;

impl Start {
    pub(super) fn of(mechanism: &Mechanism, log: &Log, channels: &[Channel]) -> Start {
        let n = mechanism.links.len();
        let shows = |k: usize| {
            let is_it = |shows: Shows| matches!(shows, Shows::Coordinate(own) if own == k);
            mechanism.gauges.iter().position(|gauge| is_it(gauge.shows))
        };
        let sensors: Vec<Option<usize>> = (0..n).map(shows).collect();
        let first = log.readings.first().map_or(0.0, |reading| reading.time);
        let seen: Vec<Option<[f64; 2]>> = (0..channels.len())
            .map(|c| first_seen(log, c, first))
            .collect();
        let (q, mut v) = solved(mechanism, &seen);
        let (mut places, mut rates) = (vec![FREE; n], vec![FREE; n]);
        let resting = (0..channels.len())
            .map(|c| rest(log, c, &channels[c]))
            .collect::<Vec<_>>();
        if let Some(resting) = resting.into_iter().collect::<Option<Vec<_>>>() {
            for k in 0..n {
                let Some(channel) = sensors[k] else { continue };
                let doubt = DOUBT * channels[channel].noise.max(channels[channel].step);
                let rate = doubt / resting[channel];
                places[k] = (q[k] - doubt, q[k] + doubt);
                (v[k], rates[k]) = (0.0, (-rate, rate));
            }
        }
        Start {
            q,
            v,
            places,
            rates,
            sensors,
        }
    }
}

/// Value and rate of a channel at `time`, by a parabola through its first readings; of few readings
/// the first one, at rest.
fn first_seen(log: &Log, channel: usize, time: f64) -> Option<[f64; 2]> {
    let points: Vec<[f64; 2]> = log
        .of(channel)
        .take(NEAR)
        .map(|r| [r.time, r.value])
        .collect();
    let [first, last] = [points.first()?, points.last()?];
    parabola(&points, time, last[0] - first[0]).or(Some([first[1], 0.0]))
}

/// How long (s) a channel rests at first; none where it moves at once.
fn rest(log: &Log, channel: usize, spec: &Channel) -> Option<f64> {
    let doubt = DOUBT * spec.noise.max(spec.step);
    let mut own = log.of(channel);
    let first = own.next()?;
    let (mut count, mut last) = (1, first.time);
    for reading in own {
        if (reading.value - first.value).abs() > doubt {
            break;
        }
        (count, last) = (count + 1, reading.time);
    }
    (count >= RESTS).then_some(last - first.time)
}

/// Coordinates and rates at which the gauges show what is seen; 0 where they do not tell.
fn solved(mechanism: &Mechanism, seen: &[Option<[f64; 2]>]) -> (Vec<f64>, Vec<f64>) {
    /// Steps of Gauss and Newton.
    const STEPS: usize = 30;
    /// Step (rad or m) of a difference quotient, and damping.
    const DIFFERENCE: f64 = 1e-6;
    const DAMPING: f64 = 1e-6;
    let n = mechanism.links.len();
    let (mut q, still) = (vec![0.0; n], vec![0.0; n]);
    let Some(plant) = Plant::new(mechanism, Change::none(mechanism)) else {
        return (q, still);
    };
    let shown = |q: &[f64]| {
        let mut row = Row {
            q: [0.0; MOST],
            v: [0.0; MOST],
        };
        row.q[..n].copy_from_slice(q);
        let of = |shows: Shows| plant.shown(shows, &row)[0];
        DVector::from_iterator(seen.len(), mechanism.gauges.iter().map(|g| of(g.shows)))
    };
    let slopes = |q: &[f64]| {
        let here = shown(q);
        let mut matrix = DMatrix::zeros(seen.len(), n);
        for k in 0..n {
            let mut there = q.to_vec();
            there[k] += DIFFERENCE;
            matrix.set_column(k, &((shown(&there) - &here) / DIFFERENCE));
        }
        matrix
    };
    let nearest = |matrix: &DMatrix<f64>, wanted: &DVector<f64>| {
        let normal = matrix.transpose() * matrix + DMatrix::identity(n, n) * DAMPING;
        normal
            .cholesky()
            .map(|c| c.solve(&(matrix.transpose() * wanted)))
    };
    let told = |k: usize, here: &DVector<f64>| {
        let of = |(i, seen): (usize, &Option<[f64; 2]>)| seen.map_or(0.0, |s| s[k] - here[i]);
        DVector::from_iterator(seen.len(), seen.iter().enumerate().map(of))
    };
    for _ in 0..STEPS {
        let Some(step) = nearest(&slopes(&q), &told(0, &shown(&q))) else {
            break;
        };
        for (q, step) in q.iter_mut().zip(step.iter()) {
            *q += step;
        }
    }
    let rates = nearest(&slopes(&q), &told(1, &DVector::zeros(seen.len())));
    (
        q,
        rates.map_or(still, |rates| rates.iter().copied().collect()),
    )
}

/// Part of a swing over which a change of the rates is told.
const WINDOW: f64 = 0.1;
/// Most windows that are used.
const MOST_WINDOWS: usize = 3000;

/// A stretch of a run: its state at the start, and the rates at its end.
struct Window {
    run: usize,
    time: f64,
    length: f64,
    q: Vec<f64>,
    v: Vec<f64>,
    after: Vec<f64>,
}

/// Inertias that nobody knows and friction by least squares on how rates change over short
/// stretches of the runs, each from where it was seen to be. It needs every coordinate measured;
/// without, or where all is known, the likely ones are those of the description. It is a first guess
/// for the fit.
pub(super) fn likely(
    mechanisms: &[Mechanism],
    runs: &[Piece],
    logs: &[Log],
    inputs: &[Vec<Input>],
    starts: &[Start],
    sizes: &Sizes,
) -> Likely {
    let mechanism = &mechanisms[0];
    let believed = Change::none(mechanism);
    let n = mechanism.links.len();
    let mut likely = Likely {
        inertia: believed.inertia.clone(),
        friction: (0..n).map(|k| 0.03 * sizes.torque[k]).collect(),
        damping: (0..n)
            .map(|k| 0.03 * sizes.torque[k] / sizes.rate(k))
            .collect(),
    };
    let unknown: Vec<usize> = (0..n)
        .filter(|k| has_unknown_inertia(mechanism, *k))
        .collect();
    if unknown.is_empty() {
        return likely;
    }
    let rate = (0..n).map(|k| sizes.rate(k)).fold(0.0, f64::max);
    let length = WINDOW * std::f64::consts::TAU / rate;
    let mut windows = Vec::new();
    for (run, log) in logs
        .iter()
        .enumerate()
        .filter(|(run, _)| runs[*run].mechanism == 0)
    {
        windows.extend(stretches(run, log, &starts[run].sensors, length));
    }
    let stride = windows.len().div_ceil(MOST_WINDOWS).max(1);
    let windows: Vec<Window> = windows.into_iter().step_by(stride).collect();
    let search = Search {
        mechanism,
        inputs,
        windows: &windows,
        unknown: &unknown,
        sizes,
    };
    if let Some(found) = search.solve() {
        for (k, x) in unknown.iter().zip(&found) {
            likely.inertia[*k] = x.exp() * guess(&mechanism.links[*k]);
        }
        for k in 0..n {
            let friction = found[unknown.len() + k].max(0.003);
            let damping = found[unknown.len() + n + k].max(0.003);
            likely.friction[k] = friction * sizes.torque[k];
            likely.damping[k] = damping * sizes.torque[k] / sizes.rate(k);
        }
    }
    likely
}

/// When (s) every coordinate was where, and how fast.
type State = (f64, Vec<[f64; 2]>);

/// The stretches of a run of which every coordinate is measured.
fn stretches(run: usize, log: &Log, sensors: &[Option<usize>], length: f64) -> Vec<Window> {
    let Some(sensors) = sensors.iter().copied().collect::<Option<Vec<usize>>>() else {
        return Vec::new();
    };
    // Time, value.
    let of = |channel: usize| -> Vec<[f64; 2]> {
        let own = log.of(channel);
        own.map(|reading| [reading.time, reading.value]).collect()
    };
    let courses: Vec<Vec<[f64; 2]>> = sensors.iter().map(|channel| of(*channel)).collect();
    let [first, last] =
        [log.readings.first(), log.readings.last()].map(|r| r.map_or(0.0, |r| r.time));
    let mut states: Vec<Option<State>> = Vec::new();
    let mut time = first + 0.5 * length;
    while time + 0.5 * length <= last {
        let state: Option<Vec<[f64; 2]>> = courses
            .iter()
            .map(|course| local(course, time, 0.5 * length))
            .collect();
        states.push(state.map(|state| (time, state)));
        time += length;
    }
    let pair = |pair: &[Option<State>]| {
        let [Some((time, from)), Some((_, to))] = pair else {
            return None;
        };
        Some(Window {
            run,
            time: *time,
            length,
            q: from.iter().map(|x| x[0]).collect(),
            v: from.iter().map(|x| x[1]).collect(),
            after: to.iter().map(|x| x[1]).collect(),
        })
    };
    states.windows(2).filter_map(pair).collect()
}

/// Value and rate at `time` by a parabola through what was measured within `half` (s) of it.
fn local(course: &[[f64; 2]], time: f64, half: f64) -> Option<[f64; 2]> {
    let from = course.partition_point(|p| p[0] < time - half - 1e-9);
    let to = course.partition_point(|p| p[0] <= time + half + 1e-9);
    let points = &course[from..to];
    parabola(points, time, half)
}

/// Value and rate at `time` by a parabola through points, which are of the order of `scale` (s) off.
fn parabola(points: &[[f64; 2]], time: f64, scale: f64) -> Option<[f64; 2]> {
    if points.len() < 4 {
        return None;
    }
    let matrix = DMatrix::from_fn(points.len(), 3, |i, k| {
        ((points[i][0] - time) / scale).powi(i32::try_from(k).unwrap_or(0))
    });
    let values = DVector::from_fn(points.len(), |i, _| points[i][1]);
    let normal = (matrix.transpose() * &matrix).cholesky()?;
    let x = normal.solve(&(matrix.transpose() * values));
    Some([x[0], x[1] / scale])
}

/// Least squares on windows. Its parameters are logarithms of the unknown inertias in terms of a
/// rod's, then dry friction and damping of each joint in terms of its sizes.
struct Search<'a> {
    mechanism: &'a Mechanism,
    inputs: &'a [Vec<Input>],
    windows: &'a [Window],
    unknown: &'a [usize],
    sizes: &'a Sizes,
}

impl Search<'_> {
    fn change(&self, x: &[f64]) -> Change {
        let (n, mut change) = (self.mechanism.links.len(), Change::none(self.mechanism));
        for (k, x) in self.unknown.iter().zip(x) {
            change.inertia[*k] = x.exp() * guess(&self.mechanism.links[*k]);
        }
        for k in 0..n {
            let (friction, damping) = (x[self.unknown.len() + k], x[self.unknown.len() + n + k]);
            change.friction[k] = friction.max(0.0) * self.sizes.torque[k];
            change.damping[k] = damping.max(0.0) * self.sizes.torque[k] / self.sizes.rate(k);
        }
        change
    }

    /// By how much rates at the ends of the windows are off, in terms of how fast joints move.
    fn residuals(&self, x: &[f64]) -> Option<DVector<f64>> {
        /// Steps of a window.
        const STEPS: f64 = 20.0;
        let plant = Plant::new(self.mechanism, self.change(x))?;
        let mut all = Vec::new();
        for w in self.windows {
            let (state, span) = ((&w.q[..], &w.v[..]), (w.time, w.length));
            let after = plant.after(state, span, &self.inputs[w.run], w.length / STEPS)?;
            let of = |k: usize| (after.v[k] - w.after[k]) / self.sizes.rate(k);
            all.extend((0..w.q.len()).map(of));
        }
        Some(DVector::from_vec(all))
    }

    /// Levenberg and Marquardt.
    fn solve(&self) -> Option<Vec<f64>> {
        /// Steps, and step of a difference quotient.
        const STEPS: usize = 15;
        const DIFFERENCE: f64 = 1e-4;
        let n = self.mechanism.links.len();
        let bounds = |k: usize| {
            if k < self.unknown.len() {
                (-6.0, 3.9)
            } else {
                (0.0, 1.0)
            }
        };
        let mut x = vec![0.0; self.unknown.len() + 2 * n];
        for own in &mut x[self.unknown.len()..] {
            *own = 0.01;
        }
        let (mut here, mut damping) = (self.residuals(&x)?, 1e-2);
        if here.len() < 4 * x.len() {
            return None;
        }
        for _ in 0..STEPS {
            let mut slopes = DMatrix::zeros(here.len(), x.len());
            for k in 0..x.len() {
                let mut there = x.clone();
                there[k] += DIFFERENCE;
                slopes.set_column(k, &((self.residuals(&there)? - &here) / DIFFERENCE));
            }
            let mut normal = slopes.transpose() * &slopes;
            for k in 0..x.len() {
                normal[(k, k)] *= 1.0 + damping;
                normal[(k, k)] += 1e-9;
            }
            let step = normal.cholesky()?.solve(&(slopes.transpose() * &here));
            let moved: Vec<f64> = (0..x.len())
                .map(|k| (x[k] - step[k].clamp(-1.0, 1.0)).clamp(bounds(k).0, bounds(k).1))
                .collect();
            match self.residuals(&moved) {
                Some(there) if there.norm() < here.norm() => {
                    let fall = here.norm() - there.norm();
                    (x, here, damping) = (moved, there, damping * 0.3);
                    if fall < 1e-6 * here.norm() {
                        break;
                    }
                }
                _ => damping *= 10.0,
            }
        }
        Some(x)
    }
}
