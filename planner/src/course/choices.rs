//! Which grounds the jumps of a course can land on, one after the other.

use super::problem::Choice;
use super::terrain::{Ground, Terrain};
use super::{Course, Jumper, Span};

/// All sequences of grounds that the jumps' reach allows.
pub(super) fn choices<J: Jumper>(jumper: &J, course: &Course, terrain: &Terrain) -> Vec<Choice> {
    let alive = backward_reach(jumper, course, terrain);
    let mut found = Vec::new();
    let mut open = vec![(terrain.start, 0, Choice { leaps: Vec::new(), windows: Vec::new() })];
    while let Some((from, first, choice)) = open.pop() {
        let jump = choice.leaps.len();
        if jump == course.jumps {
            found.push(choice);
            continue;
        }
        for (index, ground) in terrain.grounds.iter().enumerate().skip(first) {
            let Some(window) = alive[jump][index] else { continue };
            let leap = terrain.leap(jump, &from, ground);
            let feet = from.span + Span::point(roll(jumper, jump));
            let Some(envelope) = jumper.envelope(&leap, feet, window, Span::ALL) else { continue };
            let to = Ground { span: (feet + envelope.reach()).meet(window), ..*ground };
            if !to.span.is_empty() {
                let mut choice = choice.clone();
                choice.leaps.push(leap);
                choice.windows.push(if jump + 1 == course.jumps {
                    ground.span.meet(course.goal)
                } else {
                    ground.span
                });
                open.push((to, index, choice));
            }
        }
    }
    found
}

/// Distance (m) rolled before a jump.
pub(super) fn roll<J: Jumper>(jumper: &J, jump: usize) -> f64 {
    if jump == 0 { 0.0 } else { jumper.roll(jump) }
}

/// For each jump and ground, the part of the ground from which the goal can still be reached if the jump lands there.
fn backward_reach<J: Jumper>(jumper: &J, course: &Course, terrain: &Terrain) -> Vec<Vec<Option<Span>>> {
    let at_goal = |g: &Ground| Some(g.span.meet(course.goal)).filter(|s| !s.is_empty());
    let mut alive = vec![terrain.grounds.iter().map(at_goal).collect::<Vec<_>>()];
    for jump in (1..course.jumps).rev() {
        let shift = Span::point(roll(jumper, jump));
        let part = |(index, from): (usize, &Ground)| {
            let mut hull = Span::NONE;
            for (to, window) in terrain.grounds.iter().zip(&alive[0]).skip(index) {
                let Some(window) = *window else { continue };
                let leap = terrain.leap(jump, from, to);
                if let Some(envelope) = jumper.envelope(&leap, from.span + shift, window, Span::ALL) {
                    hull = hull.hull((window - envelope.reach() - shift).meet(from.span));
                }
            }
            Some(hull).filter(|s| !s.is_empty())
        };
        let parts = terrain.grounds.iter().enumerate().map(part).collect();
        alive.insert(0, parts);
    }
    alive
}
