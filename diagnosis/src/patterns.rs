//! Patterns in residuals: parts of a run that are off, waves over the time of a run, and waves or
//! steps over the value itself.

use std::f64::consts::TAU;

use crate::kind::Kind;

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
        let span = |log: &crate::kind::Log| -> f64 {
            log.readings.last().map_or(0.0, |l| l.time)
                - log.readings.first().map_or(0.0, |f| f.time)
        };
        let longest = kind
            .logs()
            .iter()
            .map(span)
            .fold(f64::MIN_POSITIVE, f64::max);
        let mut rows = Vec::new();
        for channel in 0..channels {
            let mut by_value = [Vec::new(), Vec::new()];
            let mut start = 0;
            let mut weights = Vec::new();
            for log in kind.logs() {
                let places: Vec<usize> = (0..log.readings.len())
                    .filter(|i| log.readings[*i].channel == channel)
                    .map(|i| start + i)
                    .collect();
                weights.extend(log.readings.iter().map(|r| r.weight));
                start += log.readings.len();
                let n = places.len();
                if n == 0 {
                    continue;
                }
                let cells = places
                    .iter()
                    .enumerate()
                    .map(|(i, &p)| (p, i * CELLS / n))
                    .collect();
                let waves = waves(span(log) / longest);
                rows.push(Row {
                    channel,
                    is_time: true,
                    cells,
                    counts: Vec::new(),
                    waves,
                });
                for (i, &place) in places.iter().enumerate() {
                    let falls = predicted[places[(i + 1).min(n - 1)]]
                        < predicted[places[i.saturating_sub(1)]];
                    by_value[usize::from(falls)].push(place);
                }
            }
            let values = || by_value.iter().flatten().map(|&p| predicted[p]);
            let (low, high) = (
                values().fold(f64::INFINITY, f64::min),
                values().fold(f64::NEG_INFINITY, f64::max),
            );
            for places in &by_value {
                let cell = |place: usize| {
                    let share = (predicted[place] - low) / (high - low).max(f64::MIN_POSITIVE);
                    // The number of a cell.
                    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
                    let cell = (share * CELLS as f64) as usize;
                    (place, cell.min(CELLS - 1))
                };
                let cells = places.iter().map(|&p| cell(p)).collect();
                rows.push(Row {
                    channel,
                    is_time: false,
                    cells,
                    counts: Vec::new(),
                    waves: waves(1.0),
                });
            }
            for row in rows.iter_mut().filter(|row| row.channel == channel) {
                row.counts = vec![0.0; CELLS];
                for &(place, cell) in &row.cells {
                    row.counts[cell] += weights[place];
                }
            }
        }
        Patterns { channels, rows }
    }

    /// The strongest pattern of each sort in each channel.
    pub(crate) fn find(&self, residuals: &[f64]) -> Vec<[Pattern; COUNT]> {
        let mut found = vec![[Pattern::default(); COUNT]; self.channels];
        for (channel, found) in found.iter_mut().enumerate() {
            let mut waves = [vec![0.0; WAVES + 1], vec![0.0; WAVES + 1]];
            let (mut steps, mut count) = (0.0, 0.0);
            let mut by_value = vec![(0.0, 0.0); WAVES + 1];
            for row in self.rows.iter().filter(|row| row.channel == channel) {
                let mut sums = vec![0.0; CELLS];
                for &(place, cell) in &row.cells {
                    sums[cell] += residuals[place];
                }
                if row.is_time {
                    found[0] = part(&sums, &row.counts, found[0]);
                    count += row.counts.iter().sum::<f64>();
                    for (k, power) in row.powers(&sums).into_iter().enumerate() {
                        let [re, im] = power;
                        waves[0][k] +=
                            (re * re + im * im) / row.counts.iter().sum::<f64>().max(1.0);
                    }
                } else {
                    for k in (0..CELLS).step_by(COARSE) {
                        let (sum, n): (f64, f64) = (
                            sums[k..k + COARSE].iter().sum(),
                            row.counts[k..k + COARSE].iter().sum(),
                        );
                        if n > 0.0 {
                            steps += sum * sum / n - 1.0;
                        }
                    }
                    for (all, [re, im]) in by_value.iter_mut().zip(row.powers(&sums)) {
                        *all = (all.0 + re, all.1 + im);
                    }
                }
            }
            for (k, (re, im)) in by_value.into_iter().enumerate() {
                waves[1][k] = (re * re + im * im) / f64::max(count, 1.0);
            }
            for (k, waves) in waves.iter().enumerate() {
                let most = waves[2..].iter().copied().fold(0.0, f64::max);
                // A wave a sin has the mean square a²/2, and the power n a²/4.
                found[1 + k] = found[1 + k].most(most, 2.0 * most / count.max(1.0));
            }
            found[3] = Pattern {
                statistic: steps,
                size: steps / count.max(1.0),
            };
        }
        found
    }
}

impl Row {
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
