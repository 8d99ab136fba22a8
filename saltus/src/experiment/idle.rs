//! Rest before and after what a run is about: found in its channels.
//!
//! A logger often goes on for seconds after a firing of a tenth of a second. Rows at rest repeat
//! each other: there few are kept, and those of the motion all.

use saltus_diagnosis::spec::Rest;
use saltus_numeric::statistics::quantile;

use super::instant::Instant;
use super::thin::Thinned;

/// Rest that is so many times as long as the motion is thinned.
const LONG: usize = 3;
/// Fewest rows of rest that are cut off.
const FEWEST: usize = 20;
/// Part of a run at each end from which the level at rest is taken.
const END: usize = 32;
/// Standard deviations of the noise, steps of the instrument and part of the channel's range within
/// which a channel rests.
const SIGMAS: f64 = 6.0;
const STEPS: f64 = 1.5;
const RANGE: f64 = 0.005;

/// The part of a run in which something happens, and what is done with the rest.
#[derive(Clone, Copy, Debug)]
pub(super) struct Motion {
    pub(super) from: Instant,
    pub(super) to: Instant,
    /// What is done with rows before and after.
    pub(super) rest: [Rest; 2],
    /// Most rows of rest that are kept.
    pub(super) most: usize,
}

impl Motion {
    /// The motion within a run of which `kept` is known, where its rest is worth thinning or
    /// leaving out.
    ///
    /// `steps` are those of the channels' instruments, where known; the valve was commanded at
    /// `command`.
    pub(super) fn within(
        kept: &Thinned,
        steps: &[Option<f64>],
        command: Instant,
        rest: [Rest; 2],
    ) -> Option<Motion> {
        let time = &kept.time;
        let (first, last) = moving(&kept.values, steps)?;
        let length = time[last].picoseconds_since(time[first]);
        // What dies away slowly, and what falls between the rows that are kept.
        let sample = time[time.len() - 1].picoseconds_since(time[0]) / time.len() as i128;
        let margin = (length / 4).max(2 * sample);
        let [before, after] = rest.map(|rest| if rest == Rest::Cut { 0 } else { margin });
        let from = time[first].moved(-before).min(command);
        let to = time[last].moved(after);
        let rows = |is_in: &dyn Fn(&Instant) -> bool| {
            kept.stride * time.iter().filter(|t| is_in(t)).count()
        };
        let ends = [rows(&|t| *t < from), rows(&|t| *t > to)];
        let moves = rows(&|t| (from..=to).contains(t)).max(1);
        let idle: usize = (0..2)
            .filter(|&end| rest[end] == Rest::Thin)
            .map(|end| ends[end])
            .sum();
        let is_long = idle > LONG * moves;
        let act = |end: usize| match rest[end] {
            Rest::Thin if !is_long => Rest::Keep,
            Rest::Cut if ends[end] < FEWEST => Rest::Keep,
            rest => rest,
        };
        let rest = [act(0), act(1)];
        (rest != [Rest::Keep; 2]).then_some(Motion {
            from,
            to,
            rest,
            most: (moves / 4).max(FEWEST),
        })
    }

    /// What is done with a row of this instant; [`Rest::Keep`] of the motion itself.
    pub(super) fn rest_at(&self, time: Instant) -> Rest {
        match time {
            _ if time < self.from => self.rest[0],
            _ if time > self.to => self.rest[1],
            _ => Rest::Keep,
        }
    }
}

/// The first and the last row in which a channel is not at the level of its end; none where all
/// rest.
fn moving(channels: &[Vec<f64>], steps: &[Option<f64>]) -> Option<(usize, usize)> {
    let rows = channels.first()?.len();
    let end = (rows / END).max(10).min(rows);
    let (mut first, mut last) = (rows, None);
    for (values, step) in channels.iter().zip(steps) {
        let within = tolerance(values, step.unwrap_or(0.0));
        let departs = |level: f64| move |row: &usize| (values[*row] - level).abs() > within;
        let [at_first, at_last] = [&values[..end], &values[rows - end..]].map(median);
        first = first.min((0..rows).find(departs(at_first)).unwrap_or(rows));
        last = last.max((0..rows).rev().find(departs(at_last)));
    }
    last.filter(|last| first <= *last).map(|last| (first, last))
}

/// How far from its level a channel at rest is read.
fn tolerance(values: &[f64], step: f64) -> f64 {
    let filled: Vec<f64> = values
        .iter()
        .copied()
        .filter(|value| value.is_finite())
        .collect();
    let third = |w: &[f64]| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).abs();
    let differences: Vec<f64> = filled.windows(4).map(third).collect();
    // As the diagnosis estimates noise: Σ of the squares of 1, 3, 3, 1 is 20, the median of |x| is
    // 0.6745 of a standard deviation.
    let noise = median(&differences) / (0.6745 * 20f64.sqrt());
    let (low, high) = filled
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| {
            (l.min(*x), h.max(*x))
        });
    let range = if low < high { high - low } else { 0.0 };
    [SIGMAS * noise, STEPS * step, RANGE * range]
        .into_iter()
        .filter(|x| x.is_finite())
        .fold(0.0, f64::max)
}

/// The median of what is filled; NaN of nothing.
fn median(values: &[f64]) -> f64 {
    quantile(values, 0.5).unwrap_or(f64::NAN)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// A channel that is 0, rises from one row to another, and stays.
    fn kept(rows: usize, from: usize, to: usize) -> Thinned {
        let mut kept = Thinned::new(4000, 1, 1);
        for row in 0..rows {
            let share = (row.clamp(from, to) - from) as f64 / (to - from) as f64;
            // A sine whose period is no part of the run stands for noise.
            kept.add(
                Instant::of_row(row),
                &[Some(share + 1e-3 * (1.7 * row as f64).sin())],
            );
        }
        kept
    }

    #[test]
    fn rest_is_thinned_where_it_is_most_of_a_run() {
        use Rest::{Cut, Keep, Thin};
        let check = |(rows, from, to): (usize, usize, usize), rest, expected: Option<[Rest; 2]>| {
            let found = Motion::within(&kept(rows, from, to), &[None], Instant::of_row(from), rest);
            let ends =
                |motion: Motion| [5, rows - 5].map(|row| motion.rest_at(Instant::of_row(row)));
            assert_eq!(
                found.map(ends),
                expected,
                "{rows} rows, motion from {from} to {to}: {found:?}"
            );
        };
        check((1000, 100, 140), [Thin, Thin], Some([Thin, Thin]));
        check((1000, 900, 940), [Thin, Cut], Some([Thin, Cut]));
        check((1000, 100, 700), [Thin, Thin], None);
        check((1000, 100, 700), [Thin, Cut], Some([Keep, Cut]));
        check((1000, 100, 700), [Cut, Keep], Some([Cut, Keep]));
        check((1000, 10, 990), [Cut, Cut], None);
        check((1000, 100, 140), [Keep, Keep], None);
    }

    #[test]
    fn the_motion_is_whole() {
        let motion = Motion::within(
            &kept(1000, 100, 140),
            &[None],
            Instant::of_row(98),
            [Rest::Thin; 2],
        )
        .unwrap();
        let rows: Vec<usize> = (0..1000)
            .filter(|&row| motion.rest_at(Instant::of_row(row)) == Rest::Keep)
            .collect();
        assert!(
            rows[0] <= 98 && rows[rows.len() - 1] >= 140 && rows.len() < 80,
            "{motion:?}"
        );
    }
}
