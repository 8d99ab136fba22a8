//! What keeps a course from having a plan, in words and as JSON.

use saltus::planner::Crossing;
use saltus::planner::course::{Course, FRICTION, Give, Limit, Obstacle, Side, Span};
use serde_json::{Value, json};

use crate::output::{digits, measured};

/// What a limit is about; obstacles are counted from 1, in the order of the file.
fn name(limit: &Limit) -> String {
    let side = |side: &Side| {
        if *side == Side::Front {
            "front"
        } else {
            "back"
        }
    };
    match limit {
        Limit::Edge { obstacle, side: it } => {
            format!("{} edge of obstacle {}", side(it), obstacle + 1)
        }
        Limit::Stance { obstacle, side: it } => {
            format!(
                "{} side of obstacle {} beside the foothold",
                side(it),
                obstacle + 1
            )
        }
        Limit::Landing(Side::Front) => "beginning of the ground to land on".into(),
        Limit::Landing(Side::Back) => "end of the ground to land on".into(),
        Limit::Goal => "goal".into(),
        Limit::Robot(name) => (*name).into(),
    }
}

/// The obstacles that a goal beginning at `nearer` (m) would be in front of.
fn in_front_of(course: &Course, nearer: f64) -> String {
    let is_left_out = |center: f64| nearer < center && center < course.goal.low;
    let obstacles = course
        .obstacles
        .iter()
        .enumerate()
        .filter(|(_, o)| is_left_out(o.center));
    let names: Vec<String> = obstacles
        .map(|(i, o)| format!("obstacle {}, {} m high", i + 1, digits(o.height, 4)))
        .collect();
    if names.is_empty() {
        String::new()
    } else {
        format!(", in front of {}", names.join(" and "))
    }
}

/// The ground on which a jump may land, with what is before and behind it.
fn ground(give: &Give, course: &Course) -> String {
    let Span { low, high } = give.ground;
    let beside = |is_before: bool| {
        let off = |o: &Obstacle| {
            let (front, back) = (o.center - 0.5 * o.width, o.center + 0.5 * o.width);
            if is_before { low - back } else { front - high }
        };
        let numbered = course.obstacles.iter().enumerate();
        let near = numbered.filter(|(_, o)| off(o) >= -1e-9);
        near.min_by(|a, b| off(a.1).total_cmp(&off(b.1)))
            .map(|(i, _)| i + 1)
    };
    let between = match [beside(true), beside(false)] {
        [Some(a), Some(b)] => format!(", between obstacles {a} and {b}"),
        [Some(a), None] => format!(", behind obstacle {a}"),
        [None, Some(b)] => format!(", in front of obstacle {b}"),
        [None, None] => String::new(),
    };
    let [from, to] = [low, high].map(|x| measured(x, 4));
    format!(
        "the ground that jump {} lands on ({from} to {to} m{between})",
        give.jump + 1
    )
}

/// What would have to be otherwise.
fn otherwise(give: &Give, crossing: &Crossing) -> String {
    let course = &crossing.course;
    let (goal, amount) = (course.goal, digits(give.amount.abs(), 3));
    match give.limit {
        Limit::Goal if goal.width() == 0.0 => {
            format!(
                "the goal would have to be at {} m{} (it is at {} m)",
                digits(goal.low + give.amount, 4),
                in_front_of(course, goal.low + give.amount),
                digits(goal.low, 4)
            )
        }
        Limit::Goal if give.amount < 0.0 => format!(
            "the goal would have to begin at {} m or nearer{} (it begins at {} m)",
            digits(goal.low + give.amount, 4),
            in_front_of(course, goal.low + give.amount),
            digits(goal.low, 4)
        ),
        Limit::Goal => format!(
            "the goal would have to reach to {} m or farther (it ends at {} m)",
            digits(goal.high + give.amount, 4),
            digits(goal.high, 4)
        ),
        Limit::Edge { obstacle, .. } => format!(
            "obstacle {} would have to be {amount} m lower (it is {} m high)",
            obstacle + 1,
            digits(course.obstacles[obstacle].height, 4)
        ),
        Limit::Stance { obstacle, .. } => format!(
            "obstacle {} is under the wheel where jump {} starts: it would have to be {amount} m \
             lower, or to stand farther from the foothold",
            obstacle + 1,
            give.jump + 1
        ),
        Limit::Landing(Side::Front) => {
            format!(
                "{} would have to begin {amount} m earlier",
                ground(give, course)
            )
        }
        Limit::Landing(Side::Back) => {
            format!(
                "{} would have to end {amount} m later",
                ground(give, course)
            )
        }
        FRICTION => {
            let friction = crossing.friction.unwrap_or(f64::NAN);
            format!(
                "friction_coefficient would have to be {} for jump {} (it is {})",
                digits(friction + give.amount, 3),
                give.jump + 1,
                digits(friction, 3)
            )
        }
        Limit::Robot(name) => format!("jump {}: {name} by {amount}", give.jump + 1),
    }
}

/// The limits that would have to give; jumps are counted from 1.
pub(super) fn json(gives: &[Give]) -> Vec<Value> {
    let give = |give: &Give| {
        let amount = if give.limit == FRICTION {
            "amount"
        } else {
            "amount_m"
        };
        json!({ "jump": give.jump + 1, "limit": name(&give.limit), amount: give.amount })
    };
    gives.iter().map(give).collect()
}

/// The same in words: what the nearest course with a plan has otherwise.
pub(super) fn text(gives: &[Give], crossing: &Crossing) -> String {
    match gives {
        [] => "none was found; where no jump of this robot lands on the ground that is left, \
            `saltus map` shows what it reaches"
            .into(),
        _ => gives
            .iter()
            .map(|give| otherwise(give, crossing))
            .collect::<Vec<_>>()
            .join("; "),
    }
}
