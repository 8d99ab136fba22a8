//! The best policy of a running robot, as `run` and `export` seek it.

use saltus::gait::{GaitError, Optimal, Program, Quest, Setup, optimal};

use super::refused::refused;
use crate::error::CliError;
use crate::output::{digits, print};
use crate::progress::Progress;

/// Parser of a flag.
pub(crate) fn goal(text: &str) -> Result<f64, String> {
    let distance = crate::quantity::distance(text).map_err(|error| error.to_string())?;
    if distance > 0.0 && distance <= 10.0 {
        Ok(distance)
    } else {
        Err(format!("{distance} m must be above 0, at most 10 m"))
    }
}

/// Seeks the best policy for `setup` and makes it its program; none, with the reason on standard
/// output, where no choice leads there.
pub(crate) fn seek(
    setup: &mut Setup,
    quest: Quest,
    threads: usize,
) -> Result<Option<Optimal>, CliError> {
    let progress = Progress::new("cells of the best policy", 0);
    let told = |level: usize, cells: usize| {
        progress.note(&format!("level {} of {}, {cells}", level + 1, quest.levels));
    };
    let found = optimal(setup, quest, threads, told);
    drop(progress);
    match found {
        Ok(found) => {
            setup.program = Program::Policy(found.table.clone());
            setup.mark = quest.distance;
            Ok(Some(found))
        }
        Err(error @ GaitError::Unreached { .. }) => {
            print(&format!("{}: no best policy: {error}\n", setup.robot.name))?;
            Ok(None)
        }
        Err(error) => Err(refused(error, &setup.robot)),
    }
}

/// What `found` predicts, in words.
pub(crate) fn predicted(found: &Optimal) -> String {
    let each = |of: &dyn Fn(&saltus::gait::Level) -> String| {
        let all: Vec<String> = found.levels.iter().map(of).collect();
        all.join(", ")
    };
    let worst = found.levels.iter().map(|level| level.residual);
    format!(
        "in {} s; level by level {} s by {} cells, Bellman residual at most {} s",
        digits(found.time, 4),
        each(&|level| digits(level.value, 4)),
        each(&|level| level.cells.to_string()),
        digits(worst.fold(0.0, f64::max), 2)
    )
}
