//! Measured tosses of a cube: reading them, rolling them out in the simulation, and how far the two
//! are apart.

use std::path::{Path, PathBuf};

use nalgebra::{Matrix3, Quaternion, UnitQuaternion};
use saltus_sim_check::{
    Body, ContactPoint, Friction, Joint, Mechanism, Placement, Settings, Sim, SimError, Surface,
    Tree, Vec3,
};

/// Width of the cube (m).
const WIDTH: f64 = 0.1048;
/// Mass of the cube (kg), and its moment of inertia (kg m²) about any axis through its centre.
const MASS: f64 = 0.37;
const MOMENT: f64 = 8.1e-4;
/// Acceleration of gravity (m/s²).
const GRAVITY: f64 = 9.80665;

/// Columns of a toss: time, position, quaternion (w, x, y, z), velocity, spin in body axes.
const COLUMNS: &str =
    "time_s,x_m,y_m,z_m,qw,qx,qy,qz,vx_m_s,vy_m_s,vz_m_s,wx_body_rad_s,wy_body_rad_s,wz_body_rad_s";

/// What can be wrong with a folder of tosses.
#[derive(Debug, thiserror::Error)]
pub(crate) enum TossError {
    /// A file or folder that cannot be read.
    #[error("{path}: {source}")]
    Read {
        path: PathBuf,
        source: std::io::Error,
    },
    /// A file that is no toss.
    #[error("{path}: {what}")]
    Shape { path: PathBuf, what: String },
    /// A cell that is no number.
    #[error("{path}: row {row}, column {column}: '{value}': must be {allowed}")]
    Cell {
        path: PathBuf,
        row: usize,
        column: String,
        value: String,
        allowed: &'static str,
    },
}

/// The cube at an instant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row {
    /// Time (s).
    pub(crate) time: f64,
    /// Centre (m).
    pub(crate) place: Vec3,
    /// Attitude: body to world.
    pub(crate) turn: UnitQuaternion<f64>,
    /// Velocity (m/s).
    pub(crate) velocity: Vec3,
    /// Angular velocity (rad/s), body axes.
    pub(crate) spin: Vec3,
}

/// One toss.
#[derive(Clone, Debug)]
pub(crate) struct Toss {
    /// Its samples.
    pub(crate) rows: Vec<Row>,
}

/// The tosses of `folder`, sorted by the number in their names.
///
/// # Errors
/// [`TossError`], which names the file, the row and the column.
pub(crate) fn read_folder(folder: &Path) -> Result<Vec<Toss>, TossError> {
    let unread = |source| TossError::Read {
        path: folder.into(),
        source,
    };
    let mut paths = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unread)? {
        let path = entry.map_err(unread)?.path();
        if path.extension().is_some_and(|e| e == "csv") {
            paths.push(path);
        }
    }
    let stem = |path: &PathBuf| {
        path.file_stem()
            .map_or_else(String::new, |s| s.to_string_lossy().into_owned())
    };
    paths.sort_by_key(|path| (stem(path).parse::<u64>().unwrap_or(u64::MAX), stem(path)));
    if paths.is_empty() {
        return Err(TossError::Shape {
            path: folder.into(),
            what: "has no .csv file".into(),
        });
    }
    paths
        .iter()
        .map(|path| Ok(Toss { rows: read(path)? }))
        .collect()
}

fn read(path: &Path) -> Result<Vec<Row>, TossError> {
    let text = std::fs::read_to_string(path).map_err(|source| TossError::Read {
        path: path.into(),
        source,
    })?;
    parse(path, &text)
}

/// The rows of a toss' `text`; `path` is for messages.
///
/// # Errors
/// [`TossError`], which names the file, the row and the column.
pub(crate) fn parse(path: &Path, text: &str) -> Result<Vec<Row>, TossError> {
    let shape = |what: String| TossError::Shape {
        path: path.into(),
        what,
    };
    let mut lines = text.lines();
    if lines.next().map(str::trim_end) != Some(COLUMNS) {
        return Err(shape(format!("row 1: the columns must be {COLUMNS}")));
    }
    let mut rows: Vec<Row> = Vec::new();
    for (index, line) in lines.enumerate() {
        let row = index + 2;
        let wrong = |column: &str, value: &str, allowed| TossError::Cell {
            path: path.into(),
            row,
            column: column.into(),
            value: value.into(),
            allowed,
        };
        let cells: Vec<&str> = line.trim_end().split(',').collect();
        let mut n = [0.0; 14];
        if cells.len() != n.len() {
            return Err(shape(format!(
                "row {row}: {} cells, {} wanted",
                cells.len(),
                n.len()
            )));
        }
        for ((x, cell), column) in n.iter_mut().zip(&cells).zip(COLUMNS.split(',')) {
            *x = cell
                .parse()
                .ok()
                .filter(|x: &f64| x.is_finite() && x.abs() < 1e6)
                .ok_or_else(|| wrong(column, cell, "a finite number below 1e6"))?;
        }
        if rows.last().is_some_and(|last| last.time >= n[0]) {
            return Err(wrong("time_s", cells[0], "later than in the row before"));
        }
        let turn = Quaternion::new(n[4], n[5], n[6], n[7]);
        if (turn.norm() - 1.0).abs() > 1e-3 {
            return Err(wrong(
                "qw",
                cells[4],
                "of a quaternion of length 1 to within 1e-3",
            ));
        }
        rows.push(Row {
            time: n[0],
            place: Vec3::new(n[1], n[2], n[3]),
            turn: UnitQuaternion::new_normalize(turn),
            velocity: Vec3::new(n[8], n[9], n[10]),
            spin: Vec3::new(n[11], n[12], n[13]),
        });
    }
    if rows.len() < 2 {
        return Err(shape(format!("{} rows, at least 2 wanted", rows.len())));
    }
    Ok(rows)
}

/// What a roll-out assumes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Law {
    /// Friction coefficient, standing and slipping alike.
    pub(crate) friction: f64,
    /// Restitution of an impact, in [0, 1].
    pub(crate) restitution: f64,
    /// Height (m) of the board in the measured frame.
    pub(crate) board: f64,
}

impl Law {
    /// What the data's authors measured, over a board at height `board` (m).
    pub(crate) fn published(board: f64) -> Law {
        Law {
            friction: 0.18,
            restitution: 0.125,
            board,
        }
    }
}

/// Corner `k` (m) of the cube, body axes.
fn corner(k: usize) -> Vec3 {
    let sign = |bit: usize| if k >> bit & 1 == 0 { -1.0 } else { 1.0 };
    Vec3::new(sign(0), sign(1), sign(2)) * (WIDTH / 2.0)
}

/// The cube with its eight corners over the board.
fn cube(law: &Law) -> Result<Mechanism, SimError> {
    let mut tree = Tree::default();
    tree.add(Body {
        name: "cube".into(),
        parent: None,
        joint: Joint::Free,
        placement: Placement::identity(),
        mass: MASS,
        center: Vec3::zeros(),
        inertia: Matrix3::identity() * MOMENT,
    })?;
    let mut mechanism = Mechanism::new(tree, Vec3::z() * -GRAVITY);
    for k in 0..8 {
        let center = corner(k);
        mechanism.points.push(ContactPoint {
            name: format!("corner {k}"),
            body: 0,
            center,
            radius: 0.0,
            bar: None,
        });
    }
    mechanism.surfaces.push(Surface::Plane {
        point: Vec3::z() * law.board,
        normal: Vec3::z(),
    });
    mechanism.material.friction = Friction::Cone {
        standing: law.friction,
        slipping: law.friction,
    };
    mechanism.material.restitution = law.restitution;
    Ok(mechanism)
}

/// Height (m) of the lowest corner of the cube at `row` in the measured frame.
pub(crate) fn lowest_corner(row: &Row) -> f64 {
    let up = row.turn.inverse() * Vec3::z();
    row.place.z - WIDTH / 2.0 * up.abs().sum()
}

/// Height (m) of the board: the median over `tosses` of the lowest corner at the end, where the
/// cube rests.
pub(crate) fn board_height<'t>(tosses: impl IntoIterator<Item = &'t Toss>) -> f64 {
    let mut heights: Vec<f64> = tosses
        .into_iter()
        .filter_map(|toss| toss.rows.last())
        .map(lowest_corner)
        .collect();
    heights.sort_by(f64::total_cmp);
    heights.get(heights.len() / 2).copied().unwrap_or(0.0)
}

/// Samples that the first state is taken from, and how far (m) the cube is then above the board.
const FIRST: usize = 8;
const CLEAR: f64 = 0.005;

/// The first state: free flight through the first samples, at most [`FIRST`] (54 ms) and [`CLEAR`]
/// of the board.
///
/// The velocities given are differences to the sample before, half a sample late, and noisy.
fn first_state(toss: &Toss, board: f64) -> Row {
    let mut first = toss.rows[0];
    let clear = |row: &&Row| lowest_corner(row) > board + CLEAR;
    let rows: Vec<&Row> = toss.rows.iter().take(FIRST).take_while(clear).collect();
    if rows.len() < 3 {
        return first;
    }
    let times: Vec<f64> = rows.iter().map(|row| row.time - first.time).collect();
    let of = |value: &dyn Fn(&Row, f64) -> Vec3| -> Vec<Vec3> {
        rows.iter()
            .zip(&times)
            .map(|(row, &t)| value(row, t))
            .collect()
    };
    let straight = of(&|row, t| row.place + Vec3::z() * (0.5 * GRAVITY * t * t));
    // A cube turns about any axis at a constant rate.
    let turns = of(&|row, _| (row.turn * first.turn.inverse()).scaled_axis());
    (first.place, first.velocity) = line(&times, &straight);
    let (turn, spin) = line(&times, &turns);
    first.turn = UnitQuaternion::from_scaled_axis(turn) * first.turn;
    first.spin = first.turn.inverse() * spin;
    first
}

/// Value at 0 and slope of the line of least squares.
fn line(times: &[f64], values: &[Vec3]) -> (Vec3, Vec3) {
    let n = times.len() as f64;
    let (time, value) = (
        times.iter().sum::<f64>() / n,
        values.iter().sum::<Vec3>() / n,
    );
    let spread: f64 = times.iter().map(|t| (t - time).powi(2)).sum();
    let slope = times
        .iter()
        .zip(values)
        .map(|(t, x)| (x - value) * (t - time))
        .sum::<Vec3>()
        / spread;
    (value - slope * time, slope)
}

/// Centres (m) and attitudes of the simulated cube at the times of `toss`.
///
/// # Errors
/// [`SimError`] where the motion cannot go on.
pub(crate) fn roll_out(
    toss: &Toss,
    law: &Law,
) -> Result<Vec<(Vec3, UnitQuaternion<f64>)>, SimError> {
    let mechanism = cube(law)?;
    let first = first_state(toss, law.board);
    let (p, t, u, w) = (
        first.place,
        first.turn,
        first.velocity,
        first.turn * first.spin,
    );
    let (q, v) = (
        [p.x, p.y, p.z, t.w, t.i, t.j, t.k],
        [u.x, u.y, u.z, w.x, w.y, w.z],
    );
    let settings = Settings {
        tolerance: 1e-7,
        ..Settings::default()
    };
    let mut sim = Sim::new(&mechanism, &q, &v, settings)?;
    let mut places = Vec::new();
    for row in &toss.rows {
        sim.run(row.time - first.time, &[])?;
        let q = sim.coordinates();
        let turn = UnitQuaternion::new_normalize(Quaternion::new(q[3], q[4], q[5], q[6]));
        places.push((Vec3::new(q[0], q[1], q[2]), turn));
    }
    Ok(places)
}

/// How far simulation and measurement are apart in a toss, as parts of the width.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Apart {
    /// Mean distance of the centres.
    pub(crate) center: f64,
    /// Mean distance of the corners, which also tells the attitudes apart.
    pub(crate) corners: f64,
}

/// Rolls out `toss` and compares all its samples.
///
/// # Errors
/// As [`roll_out`].
pub(crate) fn compare(toss: &Toss, law: &Law) -> Result<Apart, SimError> {
    let places = roll_out(toss, law)?;
    let (mut center, mut corners) = (0.0, 0.0);
    for (row, (place, turn)) in toss.rows.iter().zip(&places) {
        let off = place - row.place;
        center += off.norm();
        for corner in (0..8).map(corner) {
            corners += (off + turn * corner - row.turn * corner).norm() / 8.0;
        }
    }
    let samples = toss.rows.len() as f64 * WIDTH;
    Ok(Apart {
        center: center / samples,
        corners: corners / samples,
    })
}
