//! What keeps a course from having a plan, in words and as JSON.

use saltus::planner::course::{Give, Limit, Side};
use serde_json::{Value, json};

/// What a limit is about; obstacles are counted from 1, in the order of the file.
fn name(limit: &Limit) -> String {
    match limit {
        Limit::Edge { obstacle, side: Side::Front } => format!("front edge of obstacle {}", obstacle + 1),
        Limit::Edge { obstacle, side: Side::Back } => format!("back edge of obstacle {}", obstacle + 1),
        Limit::Landing(Side::Front) => "beginning of the ground to land on".into(),
        Limit::Landing(Side::Back) => "end of the ground to land on".into(),
        Limit::Goal => "goal".into(),
        Limit::Robot(name) => (*name).into(),
    }
}

/// The limits that would have to give; jumps are counted from 1.
pub(super) fn json(gives: &[Give]) -> Vec<Value> {
    let give =
        |give: &Give| json!({ "jump": give.jump + 1, "limit": name(&give.limit), "amount_m": give.amount });
    gives.iter().map(give).collect()
}

/// The same in words.
pub(super) fn text(gives: &[Give]) -> String {
    let give = |give: &Give| format!("jump {}: {} by {:.3} m", give.jump + 1, name(&give.limit), give.amount);
    match gives {
        [] => "no course near it has a plan".into(),
        _ => format!(
            "the nearest course that has a plan differs: {}",
            gives.iter().map(give).collect::<Vec<_>>().join(", ")
        ),
    }
}
