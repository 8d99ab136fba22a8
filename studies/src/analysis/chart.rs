//! Coordinates of the states on a section that lie near one: what holds there keeps holding.

use nalgebra::{DMatrix, DVector};
use saltus_sim_check::Rig;

use super::stride::{StrideState, Strides};

/// A number of a state.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Slot {
    Coordinate(usize),
    Velocity(usize),
    Extension(usize),
    Rate(usize),
    Pressure(usize),
    /// When a leg's open valve closes.
    Valve(usize),
}

/// A closed contact: a foot, and whether it stands along the travel and across it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Standing {
    leg: usize,
    along: bool,
    across: bool,
}

/// Scales, so that a change of 1 is about as great in each: m or rad, m/s or rad/s, m, m/s, Pa, s.
const SCALES: [f64; 6] = [0.01, 1.0, 0.01, 0.3, 2e4, 0.01];
/// A gap (m) that is none, and speeds (m/s) that are none: round-off of what an event leaves.
const TOUCHES: f64 = 1e-10;
const STANDS: f64 = 1e-7;

/// Coordinates near a state. What stands still there (a leg at a stop, a chamber at ambient pressure, a
/// foot on the ground) does so in all states that they name.
pub(crate) struct Chart<'a> {
    rig: &'a Rig,
    /// The state at the origin.
    at: StrideState,
    slots: Vec<Slot>,
    standing: Vec<Standing>,
    /// Directions that keep what stands standing: orthonormal, a column each.
    basis: DMatrix<f64>,
}

impl<'a> Chart<'a> {
    /// The chart around `at`.
    pub(crate) fn new(strides: &'a Strides, at: &StrideState) -> Chart<'a> {
        let rig = strides.rig();
        let mut chart = Chart {
            rig,
            at: at.clone(),
            slots: free_slots(strides, at),
            standing: standing_feet(rig, at),
            basis: DMatrix::zeros(0, 0),
        };
        let origin = chart.values(at);
        chart.basis = null_space(&chart.holds_wrt(&origin), chart.slots.len());
        chart
    }

    /// Number of coordinates.
    pub(crate) fn dimension(&self) -> usize {
        self.basis.ncols()
    }

    /// The coordinates of `state`, less what leaves the chart.
    pub(crate) fn coordinates(&self, state: &StrideState) -> DVector<f64> {
        self.basis.transpose() * (self.values(state) - self.values(&self.at))
    }

    /// The state at coordinates `x`.
    pub(crate) fn state(&self, x: &DVector<f64>) -> StrideState {
        let mut values = self.values(&self.at) + &self.basis * x;
        // Back to where what stands does: nearly linear.
        for _ in 0..if self.standing.is_empty() { 0 } else { 6 } {
            let off = self.holds(&values);
            let slopes = self.holds_wrt(&values);
            let Ok(step) = slopes.svd(true, true).solve(&off, 1e-12) else {
                break;
            };
            values -= step;
        }
        self.with(&values)
    }

    fn values(&self, state: &StrideState) -> DVector<f64> {
        let rig = self.rig;
        let value = |slot: &Slot| match *slot {
            Slot::Coordinate(k) => state.coordinates[k] / SCALES[0],
            Slot::Velocity(k) => state.velocities[k] / SCALES[1],
            Slot::Extension(leg) => state.coordinates[rig.extension_coordinate(leg)] / SCALES[2],
            Slot::Rate(leg) => state.velocities[rate_of(rig, leg)] / SCALES[3],
            Slot::Pressure(leg) => state.legs[leg].pressure / SCALES[4],
            Slot::Valve(leg) => state.legs[leg].valve.map_or(0.0, |[_, until]| until) / SCALES[5],
        };
        DVector::from_iterator(self.slots.len(), self.slots.iter().map(value))
    }

    fn with(&self, values: &DVector<f64>) -> StrideState {
        let (rig, mut state) = (self.rig, self.at.clone());
        for (slot, x) in self.slots.iter().zip(values.iter()) {
            match *slot {
                Slot::Coordinate(k) => state.coordinates[k] = x * SCALES[0],
                Slot::Velocity(k) => state.velocities[k] = x * SCALES[1],
                Slot::Extension(leg) => {
                    state.coordinates[rig.extension_coordinate(leg)] = x * SCALES[2];
                }
                Slot::Rate(leg) => state.velocities[rate_of(rig, leg)] = x * SCALES[3],
                Slot::Pressure(leg) => state.legs[leg].pressure = x * SCALES[4],
                Slot::Valve(leg) => {
                    if let Some([from, until]) = &mut state.legs[leg].valve {
                        let later = x * SCALES[5] - *until;
                        *from += later;
                        *until += later;
                    }
                }
            }
        }
        state
    }

    /// What must be 0 for all that stands to do so.
    fn holds(&self, values: &DVector<f64>) -> DVector<f64> {
        let state = self.with(values);
        let mut off = Vec::new();
        for foot in &self.standing {
            let (gap, [normal, along, across]) =
                self.rig
                    .foot_motion(foot.leg, &state.coordinates, &state.velocities);
            off.extend([gap / SCALES[0], normal]);
            off.extend(foot.along.then_some(along));
            off.extend(foot.across.then_some(across));
        }
        DVector::from_vec(off)
    }

    fn holds_wrt(&self, values: &DVector<f64>) -> DMatrix<f64> {
        let (rows, width) = (self.holds(values).len(), 1e-6);
        let mut slopes = DMatrix::zeros(rows, values.len());
        for k in 0..if rows == 0 { 0 } else { values.len() } {
            let at = |step: f64| {
                let mut moved = values.clone();
                moved[k] += step;
                self.holds(&moved)
            };
            slopes.set_column(k, &((at(width) - at(-width)) / (2.0 * width)));
        }
        slopes
    }
}

/// How far two states are apart: the greatest difference among their scaled numbers, those that a
/// chart would leave out included.
pub(crate) fn distance(rig: &Rig, a: &StrideState, b: &StrideState) -> f64 {
    let lean = rig.lean_coordinate();
    let mut most = 0.0_f64;
    for (k, (x, y)) in a.coordinates.iter().zip(&b.coordinates).enumerate() {
        if k != 0 && k != lean {
            most = most.max((x - y).abs() / SCALES[0]);
        }
    }
    for (x, y) in a.velocities.iter().zip(&b.velocities) {
        most = most.max((x - y).abs() / SCALES[1]);
    }
    for (x, y) in a.legs.iter().zip(&b.legs) {
        most = most.max((x.pressure - y.pressure).abs() / SCALES[4]);
        let until = |valve: Option<[f64; 2]>| valve.map_or(0.0, |[_, until]| until);
        most = most.max((until(x.valve) - until(y.valve)).abs() / SCALES[5]);
    }
    most
}

fn rate_of(rig: &Rig, leg: usize) -> usize {
    rig.mechanism.tree.velocity_of(rig.legs[leg])
}

/// The numbers of a state that are free to differ a little.
fn free_slots(strides: &Strides, at: &StrideState) -> Vec<Slot> {
    let rig = strides.rig();
    let lean = rig.lean_coordinate();
    // Travel is 0 and the lean is the section's.
    let mut slots: Vec<Slot> = (1..lean).map(Slot::Coordinate).collect();
    slots.extend((0..=rig.lean_velocity()).map(Slot::Velocity));
    for (leg, part) in rig.mechanism.legs.iter().enumerate() {
        let extension = at.coordinates[rig.extension_coordinate(leg)];
        if extension > TOUCHES && extension < part.leg.stroke - TOUCHES {
            slots.push(Slot::Extension(leg));
        }
        if at.velocities[rate_of(rig, leg)].abs() > STANDS {
            slots.push(Slot::Rate(leg));
        }
        let Some(chamber) = part.leg.chamber() else {
            continue;
        };
        let pressure = at.legs[leg].pressure;
        let is_at = |level: f64| (pressure / level - 1.0).abs() < 1e-9;
        if !is_at(chamber.ambient) && !is_at(chamber.supply) {
            slots.push(Slot::Pressure(leg));
        }
        if at.legs[leg].valve.is_some() {
            slots.push(Slot::Valve(leg));
        }
    }
    slots
}

fn standing_feet(rig: &Rig, at: &StrideState) -> Vec<Standing> {
    let foot = |leg: usize| {
        let (gap, [normal, along, across]) = rig.foot_motion(leg, &at.coordinates, &at.velocities);
        let touches = gap.abs() < TOUCHES && normal.abs() < STANDS;
        touches.then(|| Standing {
            leg,
            along: along.abs() < STANDS,
            across: across.abs() < STANDS,
        })
    };
    (0..rig.legs.len()).filter_map(foot).collect()
}

/// An orthonormal basis of the directions that `rows` take to 0, of so many numbers.
fn null_space(rows: &DMatrix<f64>, numbers: usize) -> DMatrix<f64> {
    if rows.nrows() == 0 {
        return DMatrix::identity(numbers, numbers);
    }
    // Of Gram's matrix: eigenvalues 0.
    let eigen = (rows.transpose() * rows).symmetric_eigen();
    let most = eigen.eigenvalues.max();
    let keep: Vec<usize> = (0..numbers)
        .filter(|&k| eigen.eigenvalues[k] <= 1e-12 * most)
        .collect();
    eigen.eigenvectors.select_columns(&keep)
}
