//! Why a stride cannot be read.

/// Why a stride is no jump.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Unfit {
    Cut,
    Backwards,
    NotHome,
    InTheAir,
    Hops,
    TwoFeet,
    OtherOut,
    Short,
    Misses,
    NoMotion,
    Unlike,
}

impl Unfit {
    pub(super) fn reason(self) -> &'static str {
        match self {
            Unfit::Cut => "the log begins or ends within it",
            Unfit::Backwards => "the robot rolls backwards",
            Unfit::NotHome => "its leg may not be home again at its touch-down",
            Unfit::InTheAir => "its leg is not seen to stand or to fly as it is fired",
            Unfit::Hops => "it rolls so fast that its foot may not stay on the ground",
            Unfit::TwoFeet => "two feet are down",
            Unfit::OtherOut => "another leg may be out and on the ground",
            Unfit::Short => "the next touch-down comes too soon",
            Unfit::Misses => "its foot does not reach the ground, or hardly",
            Unfit::NoMotion => "the model has no such motion",
            Unfit::Unlike => "it is unlike the others, as if pushed",
        }
    }

    /// Whether the robot ran too fast for it to be read.
    pub(super) fn is_of_speed(self) -> bool {
        matches!(
            self,
            Unfit::NotHome | Unfit::Hops | Unfit::OtherOut | Unfit::Short
        )
    }
}
