//! Motion at an instant.

/// Motion of the wheel's centre at an instant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct State<S> {
    /// Position (m).
    pub(crate) position: [S; 2],
    /// Velocity (m/s).
    pub(crate) velocity: [S; 2],
    /// Acceleration (m/s²).
    pub(crate) acceleration: [S; 2],
}
