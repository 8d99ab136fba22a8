//! Dynamic programming over strides: in each cell the choice by which most robots clear the box.

use saltus_numeric::parallel;

use super::Sensed;
use super::strides::Stride;
use crate::box_table::{
    BoxTable, CHOICES, COLUMNS, FIRST_LEAP, HEIGHTS, ROWS, WIDTH, counted, row_of,
};

/// Sweeps over all cells; a run has fewer strides.
const SWEEPS: usize = 25;
/// So many failures are added to what was seen of a choice.
const DOUBT: f64 = 1.0;
/// Weight of strides of the next cells of the rate.
const BESIDE: f64 = 0.2;
/// By how much (m) a box must be cleared.
const MARGIN: f64 = 0.008;
/// Worth of the same a stride later.
const KEPT: f64 = 0.998;
/// Rates (rad/s) and distances (cells) whose mean is what a table expects.
const EXPECTED: (f64, f64, usize) = (7.0, 11.0, 60);

/// For each row and column, what the best choice is worth, and which it is.
struct Values {
    worth: Vec<f64>,
    best: Vec<usize>,
}

impl Sensed {
    /// A table for each height.
    pub(super) fn solve(&self, strides: &[Stride], threads: usize) -> Vec<BoxTable> {
        parallel::map_on(threads, self.heights.len(), |k| {
            let height = self.heights[k];
            let values = values(strides, height + MARGIN);
            let [way, climb] = self.per_count();
            BoxTable {
                way,
                climb,
                expected: expected(&values.worth),
                ..BoxTable::new(&values.best, (height, self.length), self.room)
            }
        })
    }
}

/// Mean worth at running speed, before the box is near.
fn expected(worth: &[f64]) -> f64 {
    let (slow, fast, column) = EXPECTED;
    let rows = row_of(slow, 0.0)..=row_of(fast, 1.0);
    let count = rows.clone().count();
    rows.map(|row| worth[row * COLUMNS + column]).sum::<f64>() / count as f64
}

fn values(strides: &[Stride], height: f64) -> Values {
    let mut values = Values {
        worth: vec![0.0; ROWS * COLUMNS],
        best: vec![0; ROWS * COLUMNS],
    };
    // Sum of the worths and of the weights for each row, choice and column.
    let mut sums = vec![[0.0; 2]; ROWS * CHOICES * COLUMNS];
    for _ in 0..SWEEPS {
        sums.fill([0.0; 2]);
        for stride in strides.iter().filter(|stride| stride.choice < CHOICES) {
            add(stride, height, &values.worth, &mut sums);
        }
        for cell in 0..ROWS * COLUMNS {
            let (row, column) = (cell / COLUMNS, cell % COLUMNS);
            let mut most = (0, 0.0);
            for choice in 0..CHOICES {
                let [sum, weight] = sums[(row * CHOICES + choice) * COLUMNS + column];
                let worth = sum / (weight + DOUBT);
                if worth > most.1 + 1e-9 {
                    most = (choice, worth);
                }
            }
            (values.best[cell], values.worth[cell]) = most;
        }
    }
    values
}

/// Adds what a stride comes to, begun at each distance.
fn add(stride: &Stride, height: f64, worth: &[f64], sums: &mut [[f64; 2]]) {
    let levels = HEIGHTS.1.cast_signed();
    for (column, clears) in stride.clears.iter().enumerate() {
        let Some(comes_to) = comes_to(stride, column, f64::from(*clears) >= height, worth) else {
            continue;
        };
        for (by, weight) in [(0, 1.0), (levels, BESIDE), (-levels, BESIDE)] {
            let row = stride.row.checked_add_signed(by);
            if let Some(row) = row.filter(|row| *row < ROWS) {
                let sum = &mut sums[(row * CHOICES + stride.choice) * COLUMNS + column];
                *sum = [sum[0] + weight * comes_to, sum[1] + weight];
            }
        }
    }
}

/// The worth of a stride that begins in `column` and clears the box, or does not; none where its run
/// ended.
fn comes_to(stride: &Stride, column: usize, clears: bool, worth: &[f64]) -> Option<f64> {
    if !clears {
        return Some(0.0);
    }
    if stride.choice >= FIRST_LEAP {
        return Some(1.0);
    }
    if stride.stalls {
        return Some(0.0);
    }
    let (way, row) = stride.next?;
    let next = column as f64 - way / WIDTH;
    if next < -0.5 {
        return Some(0.0);
    }
    Some(KEPT * worth[row * COLUMNS + counted(next).min(COLUMNS - 1)])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A row, a choice that drives and a jump.
    const ROW: usize = 40;
    const DRIVE: usize = 4;
    const JUMP: usize = FIRST_LEAP + 2;

    fn stride(choice: usize, clears: impl Fn(usize) -> f32) -> Stride {
        Stride {
            row: ROW,
            choice,
            clears: (0..COLUMNS).map(clears).collect(),
            next: (choice == DRIVE).then_some((10.0 * WIDTH, ROW)),
            stalls: false,
        }
    }

    /// Nine strides of ten cells that always clear, and nine jumps that clear from columns 3 to 9.
    fn simple() -> Vec<Stride> {
        let drive = stride(DRIVE, |_| 9.0);
        let jump = stride(
            JUMP,
            |column| {
                if (3..10).contains(&column) { 0.3 } else { 0.0 }
            },
        );
        let mut all = vec![drive; 9];
        all.extend(vec![jump; 9]);
        all
    }

    #[test]
    fn it_drives_until_a_jump_clears() {
        let values = values(&simple(), 0.2);
        let at = |column: usize| {
            let cell = ROW * COLUMNS + column;
            (values.best[cell], values.worth[cell])
        };
        // Nine successes and one doubted failure.
        let jump = 0.9;
        for (column, strides) in [(3, 0), (9, 0), (13, 1), (19, 1), (45, 4)] {
            let (choice, worth) = at(column);
            let should = jump * (KEPT * 0.9_f64).powi(strides);
            assert_eq!(choice, if strides == 0 { JUMP } else { DRIVE }, "{column}");
            assert!((worth - should).abs() < 1e-12, "{column}: {worth} {should}");
        }
        // From between the windows no number of strides leads into one.
        for column in [0, 2, 10, 12, 20] {
            assert_eq!(at(column), (0, 0.0), "{column}");
        }
    }

    #[test]
    fn what_does_not_clear_is_worth_nothing() {
        let values = values(&simple(), 0.31);
        assert!(values.worth.iter().all(|worth| *worth == 0.0));
        let mut all = simple();
        for stride in &mut all {
            stride.stalls = true;
        }
        let stalled = super::values(&all, 0.2);
        let cell = ROW * COLUMNS;
        // A jump is judged by where it went; a stride that ends in a stall leads nowhere.
        assert!((stalled.worth[cell + 5] - 0.9).abs() < 1e-12);
        assert_eq!(stalled.worth[cell + 15], 0.0);
    }

    #[test]
    fn strides_count_a_little_in_the_next_rates() {
        let values = values(&simple(), 0.2);
        let beside = ROW + HEIGHTS.1;
        let worth = values.worth[beside * COLUMNS + 5];
        let weight = 9.0 * BESIDE;
        assert!((worth - weight / (weight + DOUBT)).abs() < 1e-12, "{worth}");
        // The next height is another state.
        assert_eq!(values.worth[(ROW + 1) * COLUMNS + 5], 0.0);
    }
}
