//! A run as a page to watch.

use saltus::gait::Ending;

use super::report::{Disturbed, Report};
use crate::cli::film::{About, Film};

/// The page.
pub(super) fn html(report: &Report<'_>, film: Film) -> String {
    let about = About {
        title: report.title(),
        ended: report.ending(),
        ran: report.summary.ending == Ending::Ran,
        disturbances: Disturbed::of(&report.run.plane.disturb, &report.summary.disturbed).by,
    };
    film.page(report.setup, &about)
}
