//! The frontier of speed against gas.

use saltus_gait::{Draw, GaitError};
use saltus_sim_check::Stepping;
use saltus_studies::analysis::frontier::{Choices, choices, frontier};

use crate::robot;

/// None of the frontier is worse than another choice in both, every other choice is; the same for any
/// number of threads. Short openings run as fast on half the gas.
#[test]
fn none_is_better_than_the_frontier() -> Result<(), GaitError> {
    let tried = Choices {
        angles: vec![0.0, 0.1, 0.2],
        openings: vec![0.02, 0.04],
        drawn: Some((Draw::default(), 3, 7)),
        rate: 12.0,
        legs: [10, 20],
    };
    let robot = robot("rats-run");
    let on = |threads: usize| choices(&robot, &tried, |s| s.by(Stepping::USUAL), threads);
    let all = on(1)?;
    assert_eq!(on(3)?, all);
    assert!(
        all.iter()
            .all(|choice| choice.robots == 3 && choice.running > 0)
    );
    let best = frontier(&all, 0.0);
    assert!(!best.is_empty());
    for choice in &all {
        let beaten = all
            .iter()
            .any(|c| c.speed >= choice.speed && c.gas <= choice.gas && c != choice);
        assert_eq!(beaten, !best.contains(choice), "{choice:?}");
    }
    assert!(best.windows(2).all(|pair| pair[0].gas < pair[1].gas));
    Ok(())
}
