//! A run that keeps every k-th row, where k doubles whenever it is full.

use super::instant::Instant;

/// Rows kept of a run.
#[derive(Debug)]
pub(super) struct Thinned {
    /// Most rows.
    most: usize,
    /// Rows that stay together: where instruments take turns, each has to be in what is kept.
    block: usize,
    /// One block in so many is kept.
    pub(super) stride: usize,
    /// Rows seen.
    pub(super) seen: usize,
    /// When each row was measured.
    pub(super) time: Vec<Instant>,
    /// For each channel a value for each row.
    pub(super) values: Vec<Vec<f64>>,
}

impl Thinned {
    /// At most so many rows of so many channels.
    pub(super) fn new(most: usize, block: usize, channels: usize) -> Thinned {
        let (time, values) = (Vec::new(), vec![Vec::new(); channels]);
        Thinned {
            most,
            block: block.max(1),
            stride: 1,
            seen: 0,
            time,
            values,
        }
    }

    /// Takes in a row; a missing cell is NaN.
    pub(super) fn add(&mut self, time: Instant, cells: &[Option<f64>]) {
        if (self.seen / self.block).is_multiple_of(self.stride) {
            if self.time.len() >= self.most {
                self.halve();
            }
            // The row may be in a block that went just now.
            if (self.seen / self.block).is_multiple_of(self.stride) {
                self.time.push(time);
                for (values, cell) in self.values.iter_mut().zip(cells) {
                    values.push(cell.unwrap_or(f64::NAN));
                }
            }
        }
        self.seen += 1;
    }

    /// The rows of both in the order of time: instants, and values for each channel.
    pub(super) fn merged(self, other: Thinned) -> (Vec<Instant>, Vec<Vec<f64>>) {
        let time: Vec<Instant> = self.time.into_iter().chain(other.time).collect();
        let mut order: Vec<usize> = (0..time.len()).collect();
        order.sort_by_key(|&row| time[row]);
        let values = self
            .values
            .into_iter()
            .zip(other.values)
            .map(|(mut values, others)| {
                values.extend(others);
                order.iter().map(|&row| values[row]).collect()
            });
        let values = values.collect();
        (order.iter().map(|&row| time[row]).collect(), values)
    }

    fn halve(&mut self) {
        self.stride *= 2;
        let block = self.block;
        self.time = every_other(&self.time, block);
        for column in &mut self.values {
            *column = every_other(column, block);
        }
    }
}

/// The blocks of even number.
fn every_other<T: Copy>(rows: &[T], block: usize) -> Vec<T> {
    rows.chunks(block).step_by(2).flatten().copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kth_row_stays() {
        for (rows, most, block, stride) in [
            (7, 8, 1, 1),
            (8, 8, 1, 1),
            (9, 8, 1, 2),
            (100, 8, 1, 16),
            (100, 8, 2, 16),
            (1000, 9, 2, 128),
        ] {
            let mut kept = Thinned::new(most, block, 1);
            for row in 0..rows {
                kept.add(
                    Instant::of_row(row),
                    &[(row % 2 == 0).then_some(row as f64)],
                );
            }
            assert_eq!(kept.stride, stride, "{rows} rows in {most}");
            assert!(kept.time.len() <= most);
            let expected: Vec<Instant> = (0..rows)
                .filter(|row| (row / block).is_multiple_of(stride))
                .map(Instant::of_row)
                .collect();
            assert_eq!(kept.time, expected, "{rows} rows in {most}");
            // Of instruments that take turns, both stay.
            let filled = kept.values[0]
                .iter()
                .filter(|value| !value.is_nan())
                .count();
            assert!(
                block == 1 || filled.abs_diff(kept.time.len() / 2) <= 1,
                "{filled}"
            );
        }
    }
}
