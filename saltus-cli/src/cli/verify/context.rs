//! What a verification's report is about.

use saltus::planner::{Corrected, Planner};
use saltus::verify::{Flown, Outcome, Plant, Subject, Verification};

/// What was verified, and how.
pub(in crate::cli) struct Context<'a> {
    pub(in crate::cli) planner: &'a Planner<Corrected>,
    pub(in crate::cli) plant: &'a Plant,
    /// What the subject is called.
    pub(in crate::cli) title: &'a str,
    pub(in crate::cli) subject: &'a Subject,
    /// Whether it was made for the robot that jumps.
    pub(in crate::cli) for_plant: bool,
    pub(in crate::cli) how: &'a Verification,
    pub(in crate::cli) step_cost: Option<&'a StepCost>,
}

/// What fixed steps cost: greatest differences from the jumps with error control.
pub(in crate::cli) struct StepCost {
    pub(super) step: f64,
    pub(super) landing: f64,
    pub(super) apex: f64,
    /// Jumps that end otherwise.
    pub(super) other_ends: usize,
}

impl StepCost {
    /// Of jumps with steps of `step` (s), and the same with error control.
    pub(super) fn of(step: Option<f64>, fixed: &[Outcome], exact: &[Outcome]) -> StepCost {
        let pairs = || {
            fixed
                .iter()
                .flat_map(|o| &o.attempts)
                .zip(exact.iter().flat_map(|o| &o.attempts))
        };
        let most = |of: fn(&Flown) -> Option<f64>| {
            let gaps = pairs().filter_map(|(a, b)| Some((of(a.flown()?)? - of(b.flown()?)?).abs()));
            gaps.fold(0.0, f64::max)
        };
        StepCost {
            step: step.unwrap_or(f64::NAN),
            landing: most(|f| f.landing),
            apex: most(|f| f.apex),
            other_ends: pairs().filter(|(a, b)| a.outcome() != b.outcome()).count(),
        }
    }
}
