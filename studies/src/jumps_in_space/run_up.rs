//! Run-ups: where twins come onto the ground, by the first push.

use saltus_controller::ball::{Rotation, Tracker};
use saltus_gait::GaitError;
use saltus_gait::space::{DrawnBalls, Gait, Knows, Roll, Stable, drawn_ball, roll};
use saltus_numeric::parallel;
use saltus_robot::Robot;

use crate::require;

/// A first push, and where it leads.
///
/// A disc that rolls without leaving the ground comes onto its feet at places that lie as far apart as its feet do. How far the
/// first push throws it moves all of them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct RunUp {
    /// Valve opening time (s) of the first push, of a single leg.
    first: f64,
    /// Where the legs of some drawn robots meet (m) as twins come onto the ground, robot by robot.
    twins: Vec<Vec<f64>>,
}

/// First pushes (s): shortest, step, and how many.
const FIRST: f64 = 0.014;
const STEP: f64 = 0.002;
const COUNT: usize = 18;
/// Robots on which each is measured, and the seed from which they are drawn.
const ROBOTS: usize = 4;
const SEED: u64 = 0x7057;
/// Farther off (m) than this is as bad.
const LOST: f64 = 0.36;
/// A push that brings twins this near (m) serves.
const SERVES: f64 = 0.25;
/// Longest run (s) for each metre, and before the first.
const SLOWEST: f64 = 3.0;
const STARTS: f64 = 5.0;

impl RunUp {
    /// Those of robots like `robot`, which roll as `stable` says as far as `most` (m).
    ///
    /// # Errors
    /// [`GaitError::Input`] for a robot that is not in space, or has no twins in its plane.
    pub(super) fn measured(
        robot: &Robot,
        stable: &Stable,
        draw: &DrawnBalls,
        most: f64,
        threads: usize,
    ) -> Result<Vec<RunUp>, GaitError> {
        let (_, facing) = Roll::new(robot.clone(), 1.0).facing()?;
        let stations = facing.plane().stations;
        let twins = stations.iter().filter(|it| it.is_of_twins()).count();
        let allowed = "such that two legs side by side come onto the ground together";
        require(twins > 0, "legs.directions", twins as f64, allowed)?;
        let all = parallel::map_on(threads, COUNT * ROBOTS, |k| {
            let first = FIRST + STEP * (k / ROBOTS) as f64;
            let own = drawn_ball(robot, draw, SEED, k % ROBOTS)?;
            let mut setup = Roll::new(own, STARTS + SLOWEST * most);
            let mut stable = stable.clone();
            stable.first[0] = first;
            setup.gait = Gait::Stable(stable);
            setup.knows = Knows::Sensors(SEED + k as u64);
            twins_of(&setup, most)
        });
        let all = all.into_iter().collect::<Result<Vec<_>, _>>()?;
        let run_up = |(k, twins): (usize, &[Vec<f64>])| RunUp {
            first: FIRST + STEP * k as f64,
            twins: twins.to_vec(),
        };
        Ok(all.chunks(ROBOTS).enumerate().map(run_up).collect())
    }

    /// The first push (s) by which twins come nearest to `place` (m).
    pub(super) fn to(all: &[RunUp], place: f64) -> f64 {
        let best = all
            .iter()
            .min_by(|a, b| a.off(place).total_cmp(&b.off(place)));
        best.map_or(FIRST, |it| it.first)
    }

    /// Whether some first push brings twins near `place` (m), where they do not stand at rest.
    pub(super) fn serve(all: &[RunUp], place: f64) -> bool {
        place > SERVES && all.iter().any(|it| it.off(place) < SERVES * SERVES)
    }

    /// Mean square (m²) of how far twins come down off `place` (m).
    fn off(&self, place: f64) -> f64 {
        let nearest = |twins: &Vec<f64>| {
            let off = twins.iter().map(|x| (x - place).abs());
            off.fold(LOST, f64::min).powi(2)
        };
        self.twins.iter().map(nearest).sum::<f64>() / self.twins.len() as f64
    }
}

/// Where the legs of a robot meet (m) as its twins come onto the ground, as far as `most` (m).
fn twins_of(setup: &Roll, most: f64) -> Result<Vec<f64>, GaitError> {
    let (_, facing) = setup.facing()?;
    let mut tracker = Tracker::new(facing.plane(), ZONE);
    let (mut places, mut noted) = (Vec::new(), i32::MIN);
    roll(setup, |ball| {
        tracker.look(&Rotation(ball.attitude), &ball.spin);
        let here = tracker.passed();
        let twins = tracker.station().filter(|it| it.is_of_twins());
        let touches = |leg: &u32| ball.touching >> *leg & 1 == 1;
        if here > noted && twins.is_some_and(|it| it.legs.iter().any(touches)) {
            noted = here;
            places.push(ball.place[0]);
        }
        ball.place[0] < most
    })?;
    Ok(places)
}

/// Lean (rad) at which a station counts as the next one.
const ZONE: f64 = -0.3;
