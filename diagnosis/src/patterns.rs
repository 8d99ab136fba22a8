//! Patterns in residuals: parts of a run that are off, waves over the time of a run, and waves or
//! steps over the value itself.

use std::f64::consts::TAU;

use crate::kind::{Kind, Log, Reading};

/// Cells into which a run, or the range of a channel, is cut.
const CELLS: usize = 96;
/// Lengths of parts in cells.
const PARTS: [usize; 9] = [1, 2, 3, 4, 6, 8, 12, 16, 24];
/// Steps of frequency in which waves are sought, each half a period over the longest run or the
/// range.
const WAVES: usize = 64;
/// Cells that make one where values are compared, and not waves.
const COARSE: usize = 4;
/// How many patterns are sought in each channel.
pub(crate) const COUNT: usize = 4;

/// A pattern: how telling it is, in whatever unit, and how large.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Pattern {
    pub(crate) statistic: f64,
    /// Mean of the residuals where it is, for a part of a run; else the mean square of what the
    /// pattern has of all of them.
    pub(crate) size: f64,
}

impl Pattern {
    fn most(self, statistic: f64, size: f64) -> Pattern {
        if statistic > self.statistic {
            Pattern { statistic, size }
        } else {
            self
        }
    }
}

/// Where the readings are: a run over its time, or all of a channel over its value.
struct Row {
    channel: usize,
    is_time: bool,
    /// Place among all readings, and cell.
    cells: Vec<(usize, usize)>,
    /// What the readings in each cell count.
    counts: Vec<f64>,
    /// cos and sin of every wave at every cell.
    waves: Vec<[(f64, f64); CELLS]>,
}

/// Where to look for patterns.
pub(crate) struct Patterns {
    channels: usize,
    rows: Vec<Row>,
}

/// cos and sin of every wave over a row of this length: from its start the phase grows with the
/// time, and not with the cell.
fn waves(length: f64) -> Vec<[(f64, f64); CELLS]> {
    let at = |wave: usize, cell: usize| {
        let (sin, cos) = (TAU * (wave * cell) as f64 * length / (2 * CELLS) as f64).sin_cos();
        (cos, sin)
    };
    (0..=WAVES)
        .map(|wave| std::array::from_fn(|cell| at(wave, cell)))
        .collect()
}

impl Patterns {
    /// In an experiment of which a model says `predicted`, one number a reading.
    pub(crate) fn new(kind: &dyn Kind, predicted: &[f64]) -> Patterns {
        let channels = kind.channels().len();
        let readings: Vec<&Reading> = kind.logs().iter().flat_map(|log| &log.readings).collect();
        let mut rows = Vec::new();
        for channel in 0..channels {
            let runs = places(kind, channel);
            rows.extend(by_time(kind, channel, &runs));
            rows.extend(by_value(channel, &runs, predicted));
        }
        for row in &mut rows {
            for &(place, cell) in &row.cells {
                row.counts[cell] += readings[place].weight;
            }
        }
        Patterns { channels, rows }
    }

    /// The strongest pattern of each sort in each channel.
    pub(crate) fn find(&self, residuals: &[f64]) -> Vec<[Pattern; COUNT]> {
        let of = |channel| self.find_in(channel, residuals);
        (0..self.channels).map(of).collect()
    }

    fn find_in(&self, channel: usize, residuals: &[f64]) -> [Pattern; COUNT] {
        let mut found = [Pattern::default(); COUNT];
        let mut by_time = vec![0.0; WAVES + 1];
        let mut by_value = vec![[0.0; 2]; WAVES + 1];
        let (mut steps, mut count) = (0.0, 0.0);
        for row in self.rows.iter().filter(|row| row.channel == channel) {
            let sums = row.sums(residuals);
            let powers = row.powers(&sums);
            if row.is_time {
                found[0] = part(&sums, &row.counts, found[0]);
                let n: f64 = row.counts.iter().sum();
                count += n;
                for (all, [re, im]) in by_time.iter_mut().zip(powers) {
                    *all += (re * re + im * im) / n.max(1.0);
                }
            } else {
                steps = row.steps(&sums, steps);
                for (all, [re, im]) in by_value.iter_mut().zip(powers) {
                    *all = [all[0] + re, all[1] + im];
                }
            }
        }
        let by_value = by_value
            .into_iter()
            .map(|[re, im]| (re * re + im * im) / f64::max(count, 1.0));
        for (k, waves) in [by_time, by_value.collect()].iter().enumerate() {
            let most = waves[2..].iter().copied().fold(0.0, f64::max);
            // A wave a sin has the mean square a²/2, and the power n a²/4.
            found[1 + k] = found[1 + k].most(most, 2.0 * most / count.max(1.0));
        }
        found[3] = Pattern {
            statistic: steps,
            size: steps / count.max(1.0),
        };
        found
    }
}

/// Places of the readings of a channel among all readings, of each run that has some, with the run.
fn places(kind: &dyn Kind, channel: usize) -> Vec<(usize, Vec<usize>)> {
    let mut start = 0;
    let mut all = Vec::new();
    for (run, log) in kind.logs().iter().enumerate() {
        let here = log.readings.iter().enumerate();
        let places: Vec<usize> = here
            .filter(|(_, reading)| reading.channel == channel)
            .map(|(i, _)| start + i)
            .collect();
        start += log.readings.len();
        if !places.is_empty() {
            all.push((run, places));
        }
    }
    all
}

/// A row for each run, over its time.
fn by_time(kind: &dyn Kind, channel: usize, runs: &[(usize, Vec<usize>)]) -> Vec<Row> {
    let span = |log: &Log| -> f64 {
        let ends = log.readings.first().zip(log.readings.last());
        ends.map_or(0.0, |(first, last)| last.time - first.time)
    };
    let logs = kind.logs();
    let longest = logs.iter().map(span).fold(f64::MIN_POSITIVE, f64::max);
    let row = |(run, places): &(usize, Vec<usize>)| Row {
        channel,
        is_time: true,
        cells: places
            .iter()
            .enumerate()
            .map(|(i, &place)| (place, i * CELLS / places.len()))
            .collect(),
        counts: vec![0.0; CELLS],
        waves: waves(span(&logs[*run]) / longest),
    };
    runs.iter().map(row).collect()
}

/// A row of all readings where the predicted value rises, and one where it falls, over that value.
fn by_value(channel: usize, runs: &[(usize, Vec<usize>)], predicted: &[f64]) -> [Row; 2] {
    let mut sides = [Vec::new(), Vec::new()];
    for (_, places) in runs {
        let n = places.len();
        for (i, &place) in places.iter().enumerate() {
            let (next, last) = (places[(i + 1).min(n - 1)], places[i.saturating_sub(1)]);
            sides[usize::from(predicted[next] < predicted[last])].push(place);
        }
    }
    let values = || sides.iter().flatten().map(|&p| predicted[p]);
    let low = values().fold(f64::INFINITY, f64::min);
    let high = values().fold(f64::NEG_INFINITY, f64::max);
    let cell = |place: usize| {
        let share = (predicted[place] - low) / (high - low).max(f64::MIN_POSITIVE);
        // The number of a cell.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let cell = (share * CELLS as f64) as usize;
        (place, cell.min(CELLS - 1))
    };
    sides.clone().map(|places| Row {
        channel,
        is_time: false,
        cells: places.into_iter().map(cell).collect(),
        counts: vec![0.0; CELLS],
        waves: waves(1.0),
    })
}

impl Row {
    /// Sum of the residuals in each cell.
    fn sums(&self, residuals: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; CELLS];
        for &(place, cell) in &self.cells {
            sums[cell] += residuals[place];
        }
        sums
    }

    /// Square of the mean of each coarse cell beyond what chance gives it, added to `steps`.
    fn steps(&self, sums: &[f64], mut steps: f64) -> f64 {
        for (sums, counts) in sums.chunks(COARSE).zip(self.counts.chunks(COARSE)) {
            let (sum, n): (f64, f64) = (sums.iter().sum(), counts.iter().sum());
            if n > 0.0 {
                steps += sum * sum / n - 1.0;
            }
        }
        steps
    }

    /// Real and imaginary part of each wave.
    fn powers(&self, sums: &[f64]) -> Vec<[f64; 2]> {
        let of = |wave: &[(f64, f64); CELLS]| {
            let add = |[re, im]: [f64; 2], (sum, (cos, sin)): (&f64, &(f64, f64))| {
                [re + sum * cos, im + sum * sin]
            };
            sums.iter().zip(wave).fold([0.0; 2], add)
        };
        self.waves.iter().map(of).collect()
    }
}

/// The part of a row whose sum stands out most, if it does so more than `before`.
fn part(sums: &[f64], counts: &[f64], before: Pattern) -> Pattern {
    let (mut sum, mut count) = (vec![0.0], vec![0.0]);
    for (s, n) in sums.iter().zip(counts) {
        sum.push(sum[sum.len() - 1] + s);
        count.push(count[count.len() - 1] + n);
    }
    let mut most = before;
    for length in PARTS {
        for k in 0..=CELLS - length {
            let (sum, n) = (sum[k + length] - sum[k], count[k + length] - count[k]);
            // One or two readings are outliers.
            if n >= 3.0 {
                most = most.most(sum.abs() / n.sqrt(), sum.abs() / n);
            }
        }
    }
    most
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::toy::{ALL, READINGS, Toy, noise, wave};

    /// The strongest patterns in residuals, of a model whose prediction rises all along.
    fn found(residuals: &[f64]) -> [Pattern; COUNT] {
        let toy = Toy::new(&noise(1), vec![wave(0)]);
        let predicted: Vec<f64> = (0..ALL).map(|i| i as f64).collect();
        Patterns::new(&toy, &predicted).find(residuals)[0]
    }

    #[test]
    fn a_part_that_is_off_is_found_with_its_size() {
        let mut residuals = vec![0.0; ALL];
        // Twelve and a half cells of 96.
        let part = 3 * READINGS + 20..3 * READINGS + 26;
        residuals[part.clone()].fill(2.0);
        let [part_found, ..] = found(&residuals);
        assert!((part_found.size - 2.0).abs() < 1e-12, "{part_found:?}");
        let closed = 2.0 * (part.len() as f64).sqrt();
        assert!(
            (part_found.statistic - closed).abs() < 1e-12,
            "{part_found:?} {closed}"
        );
    }

    #[test]
    fn one_reading_is_an_outlier_and_no_part() {
        let mut residuals = vec![0.0; ALL];
        residuals[77] = 100.0;
        // The shortest part that counts has more readings.
        assert!(found(&residuals)[0].size <= 100.0 / 3.0 + 1e-9);
    }

    #[test]
    fn a_wave_over_the_time_has_half_its_square() {
        let swing = |i: usize| 1.5 * (TAU * 4.0 * (i % READINGS) as f64 / READINGS as f64).cos();
        let residuals: Vec<f64> = (0..ALL).map(swing).collect();
        let [_, wave, ..] = found(&residuals);
        assert!(
            (wave.size / (0.5 * 1.5 * 1.5) - 1.0).abs() < 0.05,
            "{wave:?}"
        );
    }

    #[test]
    fn a_wave_over_the_value_has_half_its_square() {
        let swing = |i: usize| 1.5 * (TAU * 5.0 * i as f64 / ALL as f64).cos();
        let residuals: Vec<f64> = (0..ALL).map(swing).collect();
        let [.., wave, steps] = found(&residuals);
        assert!(
            (wave.size / (0.5 * 1.5 * 1.5) - 1.0).abs() < 0.05,
            "{wave:?}"
        );
        // A step for each coarse cell finds nearly all of it, too.
        assert!(steps.size > 0.8 * 0.5 * 1.5 * 1.5, "{steps:?}");
    }

    #[test]
    fn nothing_is_found_in_nothing() {
        for pattern in &found(&[0.0; ALL])[..3] {
            assert_eq!(*pattern, Pattern::default());
        }
    }
}
