//! The jumps themselves, with every digit that the model has: finer than plans need them.

use std::num::NonZeroUsize;

use saltus::lagrangian::{Batch, Contact, EnergyLedger, FINE, Sample};
use saltus::numeric::parallel;
use saltus::planner::{JumpFlight, flight_after};
use saltus::{Jump, Launch, LiftOff, Robot, StanceError};

use crate::progress::Progress;

/// Jumps that are computed side by side. It does not depend on the number of threads, so neither
/// does the result.
const SIDE_BY_SIDE: usize = 256;

/// What is wanted beside the end of each stance.
#[derive(Clone, Copy)]
pub(super) struct Detail {
    /// What the ground bears and where the energy goes.
    pub(super) stance: bool,
    /// The path of the wheel's centre.
    pub(super) path: bool,
}

/// A jump and how it went.
pub(super) struct Answer {
    pub(super) jump: Jump,
    /// Where it is wanted.
    pub(super) bearing: Option<Bearing>,
    /// The wheel's centre (m) during the stance, where it is wanted.
    pub(super) path: Vec<(f64, f64)>,
}

/// What the ground bears and where the energy goes.
pub(super) struct Bearing {
    pub(super) contact: Contact,
    pub(super) energy: EnergyLedger,
}

/// A jump that cannot be computed.
pub(super) struct Failed {
    /// Its place among the launches.
    pub(super) index: usize,
    /// Why not.
    pub(super) source: StanceError,
}

/// The answers to `launches` in their order, or the first that cannot be had.
pub(super) fn simulate(
    robot: &Robot,
    launches: &[Launch],
    detail: Detail,
    threads: NonZeroUsize,
) -> Result<Vec<Answer>, Failed> {
    let work = Work {
        robot,
        batch: Batch::new(robot, FINE),
        detail,
        progress: Progress::new("jumps", launches.len()),
    };
    let chunks: Vec<&[Launch]> = launches.chunks(SIDE_BY_SIDE).collect();
    let parts = parallel::map_on(threads.get(), chunks.len(), |i| {
        work.chunk(i * SIDE_BY_SIDE, chunks[i])
    });
    let parts = parts.into_iter().collect::<Result<Vec<_>, _>>()?;
    Ok(parts.into_iter().flatten().collect())
}

struct Work<'a> {
    robot: &'a Robot,
    batch: Batch,
    detail: Detail,
    progress: Progress,
}

impl Work<'_> {
    /// The answers to `launches`, of which the first has the place `start`.
    fn chunk(&self, start: usize, launches: &[Launch]) -> Result<Vec<Answer>, Failed> {
        let ends = self.batch.jumps(launches);
        let answers = ends
            .into_iter()
            .zip(launches)
            .enumerate()
            .map(|(i, (end, launch))| {
                let answer = end.and_then(|end| self.answer(launch, end));
                answer.map_err(|source| Failed {
                    index: start + i,
                    source,
                })
            });
        let answers = answers.collect();
        self.progress.advance(launches.len());
        answers
    }

    fn answer(&self, launch: &Launch, end: LiftOff) -> Result<Answer, StanceError> {
        let jump = Jump {
            launch: *launch,
            stance: end,
            flight: flight_after(self.robot, &end).map(JumpFlight::Exact),
        };
        if !self.detail.stance && !self.detail.path {
            return Ok(Answer {
                jump,
                bearing: None,
                path: Vec::new(),
            });
        }
        let trace = self.batch.stance().trace(launch)?;
        let centre = |sample: &Sample| {
            let (reach, (sin, cos)) = (
                self.robot.body.radius + sample.extension,
                sample.lean.sin_cos(),
            );
            (reach * sin, reach * cos)
        };
        let path = if self.detail.path {
            trace.samples.iter().map(centre).collect()
        } else {
            Vec::new()
        };
        let bearing = self.detail.stance.then_some(Bearing {
            contact: trace.contact,
            energy: trace.energy,
        });
        Ok(Answer {
            jump,
            bearing,
            path,
        })
    }
}
