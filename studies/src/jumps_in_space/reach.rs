//! Where a robot can land.

use saltus_gait::GaitError;
use saltus_numeric::parallel;

use super::plan::{JumpPlan, Planner, far};
use crate::require;

/// A place on the ground, and the jump to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Spot {
    /// Where (m), from the middle of the robot at rest.
    pub target: [f64; 2],
    /// The jump.
    pub plan: JumpPlan,
}

/// Most places of a map.
const MOST: f64 = 10_000.0;

impl Planner {
    /// Jumps to all places of a grid with this `spacing` (m) as far as any legs that fire together reach, and one more. The same
    /// for any number of `threads`.
    ///
    /// # Errors
    /// [`GaitError::Input`] for a spacing that makes no map, [`GaitError::Sim`] for a motion that cannot go on.
    pub fn reach(&self, spacing: f64, threads: usize) -> Result<Vec<Spot>, GaitError> {
        let targets = self.grid(spacing)?;
        let all = parallel::map_on(threads, targets.len(), |k| {
            let plan = self.to(targets[k], 1);
            plan.map(|plan| Spot {
                target: targets[k],
                plan,
            })
        });
        all.into_iter().collect()
    }

    /// The places of that map.
    ///
    /// # Errors
    /// [`GaitError::Input`] for a spacing that makes no map.
    pub fn grid(&self, spacing: f64) -> Result<Vec<[f64; 2]>, GaitError> {
        let most = self.known().map(|at| far(at, [0.0; 2])).fold(0.0, f64::max) + spacing;
        let count = (most / spacing).floor();
        let sound = spacing > 0.0 && (2.0 * count + 1.0).powi(2) <= MOST;
        let allowed = format!("above 0 m, and not so fine that there are more than {MOST} places");
        require(sound, "spacing of the map (m)", spacing, allowed)?;
        // At most a hundred.
        #[allow(clippy::cast_possible_truncation)]
        let count = count as i32;
        let mut targets = Vec::new();
        for i in -count..=count {
            for j in -count..=count {
                let at = [f64::from(i) * spacing, f64::from(j) * spacing];
                if (i, j) != (0, 0) && far(at, [0.0; 2]) <= most {
                    targets.push(at);
                }
            }
        }
        Ok(targets)
    }
}
