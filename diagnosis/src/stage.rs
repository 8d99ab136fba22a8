//! How far a long computation is.

/// How far a diagnosis is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stage<'a> {
    /// Share of the work that is done, 0 to 1, by how many causes may be at work and how often what is left
    /// may be looked at: a search that ends early leaps.
    pub share: f64,
    /// The work at hand.
    pub doing: &'a str,
}
