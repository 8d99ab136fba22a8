//! What first guesses say.

/// Where a run starts.
#[derive(Clone, Debug)]
pub(super) struct Start {
    /// First guess of each coordinate, as its sensor says, and of its rate.
    pub(super) q: Vec<f64>,
    pub(super) v: Vec<f64>,
    /// Bounds of both.
    pub(super) places: Vec<(f64, f64)>,
    pub(super) rates: Vec<(f64, f64)>,
    /// The channel that shows each coordinate, where there is one.
    pub(super) sensors: Vec<Option<usize>>,
}

/// What is likely of a machine: in the order of its links, inertia (kg m²) about the centre, dry
/// friction and damping of each joint.
#[derive(Clone, Debug)]
pub(super) struct Likely {
    pub(super) inertia: Vec<f64>,
    pub(super) friction: Vec<f64>,
    pub(super) damping: Vec<f64>,
}
