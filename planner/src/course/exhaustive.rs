//! What the search is compared with in tests: a program for every sequence of grounds, without any
//! bound.

use super::nearest::{choices, evenly};
use super::problem::Problem;
use super::terrain::Terrain;
use super::{Course, Jumper, Settings, sqp};

/// Least cost of all plans that the solver finds, one from each sequence of grounds; none without a
/// plan.
pub(crate) fn least_cost(jumper: &dyn Jumper, course: &Course, settings: &Settings) -> Option<f64> {
    let terrain = Terrain::new(course, jumper);
    let last = course.jumps - 1;
    let costs = choices(jumper, course, &terrain, usize::MAX)
        .into_iter()
        .filter_map(|mut choice| {
            choice.windows[last] = choice.windows[last].meet(terrain.goal);
            if choice.windows[last].is_empty() {
                return None;
            }
            let problem = Problem::new(jumper, course, &choice, settings.sigmas);
            let report = sqp::solve(&problem, &evenly(&problem, course), &settings.solver);
            (report.violation <= settings.solver.feasibility).then_some(report.cost)
        });
    costs.min_by(f64::total_cmp)
}
