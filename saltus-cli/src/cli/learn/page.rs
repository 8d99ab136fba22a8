//! What a robot had learnt after some episodes, side by side.

use std::collections::VecDeque;

use saltus::gait::learn::Task as Course;
use saltus::gait::{Footfall, GaitError, Program, Row, Run, Setup, run};
use saltus::learning::{Pupil, Settings, learn};

use crate::animation::side_by_side;
use crate::cli::film::{About, Film};
use crate::output::digits;

/// How long each is played (s).
const SECONDS: f64 = 2.0;
/// Time (s) over which the speed is a mean.
const MEAN: f64 = 0.15;

struct Filmed {
    film: Film,
    recent: VecDeque<[f64; 2]>,
}

impl Run for Filmed {
    fn row(&mut self, row: &Row<'_>) {
        self.recent.push_back([row.time, row.axle[0]]);
        while self.recent.len() > 1 && self.recent[0][0] < row.time - MEAN {
            self.recent.pop_front();
        }
        let [since, from] = self.recent[0];
        let span = (row.time - since).max(1e-9);
        self.film.push(row, (row.axle[0] - from) / span);
    }

    fn footfall(&mut self, footfall: &Footfall) {
        self.film.touch_down(footfall);
    }

    fn asks_contacts(&mut self, _: f64) -> bool {
        self.film.is_due()
    }
}

fn episodes_of(count: usize) -> String {
    format!("{count} episode{}", if count == 1 { "" } else { "s" })
}

/// The page: what `pupil`'s seed had learnt after each of `episodes`.
pub(super) fn html(
    settings: &Settings,
    pupil: &Pupil,
    episodes: &[usize],
) -> Result<String, GaitError> {
    let mut pages = Vec::new();
    for &count in episodes {
        let mut shorter = settings.clone();
        shorter.schedule.episodes = count;
        // The first episodes of a seed are the same in any number of them.
        let learnt = learn(&shorter, (pupil.seed, 1), None, 1, &|| true)?;
        let Some(then) = learnt.pupils.first() else {
            continue;
        };
        let robot = settings.plant.robot.clone();
        let mut setup = Setup::new(
            robot,
            Program::Learnt(settings.policy(&then.table)?),
            SECONDS,
        );
        setup.zone = Course::default().zone;
        setup.obstacles.clone_from(&settings.plant.obstacles);
        let mut filmed = Filmed {
            film: Film::new(&setup),
            recent: VecDeque::new(),
        };
        let summary = run(&setup, &mut filmed)?;
        let came = digits(summary.travel, 3);
        let about = About {
            title: format!("{} after {}", settings.task.name(), episodes_of(count)),
            ended: format!("{came} m in {SECONDS} s"),
            ran: true,
            disturbances: Vec::new(),
        };
        let caption = format!("after {}: {came} m in {SECONDS} s", episodes_of(count));
        pages.push((caption, filmed.film.page(&setup, &about)));
    }
    let title = format!(
        "{}: {} by {}, seed {}, without exploration",
        settings.plant.robot.name,
        settings.task.name(),
        settings.algorithm.name(),
        pupil.seed
    );
    Ok(side_by_side(&title, &pages))
}
