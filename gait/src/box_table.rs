//! What a leg can do, and the table that says what it does.

use saltus_controller::Axis;
use saltus_controller::run::Ahead;

/// What a leg does: it fires at a lean (rad), its valve opens for a time (s). With a time of 0 it does
/// not fire.
pub type Choice = [f64; 2];

/// What each leg does before a box, by the rate at which it enters the zone, the height of the axle
/// and the distance from the axle to the box then.
#[derive(Clone, Debug, PartialEq)]
pub struct BoxTable {
    /// Height of the box (m).
    pub height: f64,
    /// Share of the robots that it expects to clear the box, of those that come upon it at running
    /// speed; what it has not tried often enough counts as failures.
    pub expected: f64,
    /// Way (m) for a count of the radius encoder.
    pub way: f64,
    /// Height (m) for a count of the pivot encoder.
    pub climb: f64,
    /// Distance (m) below which the box is behind.
    pub behind: f64,
    /// Least distance (m) to run up.
    pub room: f64,
    /// Index of the choice in each cell, all distances of a height one after the other, all heights
    /// of a rate.
    pub cells: Vec<u8>,
}

/// Firing angles (rad) and valve opening times (s) of legs that drive the robot.
pub(crate) const ANGLES: [f64; 6] = [-0.4, -0.1, 0.1, 0.2, 0.3, 0.45];
pub(crate) const TIMES: [f64; 3] = [0.025, 0.042, 0.065];
/// Firing angles (rad) of a jump, and its valve opening time (s): past the end of the stroke.
pub(crate) const LEAP_ANGLES: [f64; 7] = [-0.5, -0.42, -0.34, -0.26, -0.18, -0.1, 0.05];
pub(crate) const LEAP_OPEN: f64 = 0.1;
/// The first choice: the leg does not fire.
const IDLE: Choice = [0.6, 0.0];
/// The first choice that is a jump, and how many there are in all.
pub(crate) const FIRST_LEAP: usize = 1 + ANGLES.len() * TIMES.len();
pub(crate) const CHOICES: usize = FIRST_LEAP + LEAP_ANGLES.len();

/// All that a leg can do, jumps last.
pub(crate) static ALL: [Choice; CHOICES] = {
    let mut all = [IDLE; CHOICES];
    let mut k = 0;
    while k < ANGLES.len() * TIMES.len() {
        all[1 + k] = [ANGLES[k / TIMES.len()], TIMES[k % TIMES.len()]];
        k += 1;
    }
    let mut k = 0;
    while k < LEAP_ANGLES.len() {
        all[FIRST_LEAP + k] = [LEAP_ANGLES[k], LEAP_OPEN];
        k += 1;
    }
    all
};

/// Where the active zone begins (rad): a jump's leg fires well before it is upright.
pub(crate) const ZONE: f64 = -0.5;
/// Cells of the rate: from the first rate, so wide (rad/s), so many.
pub(crate) const RATES: (f64, f64, usize) = (-0.5, 1.0, 17);
/// Cells of the axle's height above that of a robot that stands: so wide (m), so many.
pub(crate) const HEIGHTS: (f64, usize) = (0.02, 5);
/// Cells of both.
pub(crate) const ROWS: usize = RATES.2 * HEIGHTS.1;
/// Width of a cell of the distance (m); the nearest distance at which a leg may still fire, and how
/// many cells there are from there on.
pub(crate) const WIDTH: f64 = 0.025;
pub(crate) const NEAREST: f64 = 0.2;
pub(crate) const COLUMNS: usize = 72;
/// Way (m) beyond a box after which it is behind.
pub(crate) const BEYOND: f64 = 0.3;
/// By how much (m) a reading of the range sensor may differ from what is known.
const SAME: f64 = 0.3;
/// Least weight of a reading.
const LEAST_WEIGHT: f64 = 0.05;

/// The cell of a rate (rad/s) and a height (m) above the stand.
pub(crate) fn row_of(rate: f64, height: f64) -> usize {
    let (first, wide, rows) = RATES;
    let row = floor(rate - first, wide).min(rows - 1);
    row * HEIGHTS.1 + floor(height, HEIGHTS.0).min(HEIGHTS.1 - 1)
}

/// Distances (m) of which the first is that of cell 0 here, and how many cells lie before it: they
/// reach until the box of `length` (m) is behind.
fn passing(length: f64) -> (f64, usize) {
    let cells = counted(((NEAREST + length + BEYOND) / WIDTH).ceil());
    (NEAREST - cells as f64 * WIDTH, cells)
}

impl BoxTable {
    /// A table of the choices `best`, for each row and column; nearer than these no leg fires.
    pub(crate) fn new(best: &[usize], (height, length): (f64, f64), room: f64) -> BoxTable {
        let (behind, before) = passing(length);
        let row = |row: &[usize]| {
            let known = row.iter().map(|choice| u8::try_from(*choice).unwrap_or(0));
            std::iter::repeat_n(0, before)
                .chain(known)
                .collect::<Vec<u8>>()
        };
        BoxTable {
            height,
            expected: 0.0,
            way: 0.0,
            climb: 0.0,
            behind,
            room,
            cells: best.chunks(COLUMNS).flat_map(row).collect(),
        }
    }

    /// The controller's constants.
    pub fn ahead(&self) -> Ahead<'_, f64> {
        let (slowest, wide, rows) = RATES;
        let columns = self.cells.len() / ROWS;
        let farthest = self.behind + columns as f64 * WIDTH;
        Ahead {
            way: self.way,
            climb: self.climb,
            least_weight: LEAST_WEIGHT,
            same: SAME,
            room: self.room,
            rates: Axis::new(slowest, slowest + wide * rows as f64, rows + 1),
            heights: Axis::new(0.0, HEIGHTS.0 * HEIGHTS.1 as f64, HEIGHTS.1 + 1),
            distances: Axis::new(self.behind, farthest, columns + 1),
            cells: &self.cells,
            choices: &ALL,
            first_leap: u8::try_from(FIRST_LEAP).unwrap_or(u8::MAX),
        }
    }
}

/// The count nearest to `x`, 0 for what is less.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
pub(crate) fn counted(x: f64) -> usize {
    x.round().max(0.0) as usize
}

/// The cell of width `wide` in which `x` lies, the first for what is less.
pub(crate) fn floor(x: f64, wide: f64) -> usize {
    counted((x / wide).floor())
}
