//! The report.

use saltus_gait::{Draw, GaitError};
use saltus_studies::analysis::frontier::Choices;
use saltus_studies::analysis::{Effort, report};

use crate::pushed;

/// The same for any number of threads, the differences of the multipliers included; its energy is
/// that of its run.
#[test]
fn a_report_is_the_same_for_any_number_of_threads() -> Result<(), GaitError> {
    let effort = |threads: usize| {
        let effort = Effort {
            threads,
            rates: vec![12.0],
            sizes: vec![3],
            choices: Choices {
                angles: vec![0.1],
                openings: vec![0.02, 0.04],
                legs: [4, 6],
                ..Effort::default().choices
            },
            ..Effort::default()
        };
        effort.with_robots(Draw::default(), 2, 7)
    };
    let setup = pushed(2.0);
    let (one, three) = (report(&setup, &effort(1))?, report(&setup, &effort(3))?);
    // Debug prints every digit.
    assert_eq!(format!("{one:?}"), format!("{three:?}"));
    assert_eq!(one.gaits.len(), 1);
    assert_eq!(one.basins[0].fates.len(), 9);
    assert_eq!(one.choices.len(), 2);
    let (energy, summary) = (&one.energy, &one.summary);
    assert!((energy.unexplained() + summary.residual).abs() < 1e-9);
    Ok(())
}
