//! Which starts lead to running.

use saltus_gait::GaitError;
use saltus_sim_check::Stepping;
use saltus_studies::analysis::basin::{Fate, Starts, basin, refined};
use saltus_studies::analysis::stride::{Firing, Strides};

use crate::robot;

fn strides() -> Result<Strides, GaitError> {
    let strides = Strides::new(&robot("rats-run"), Firing::new(0.1, 0.04))?;
    Ok(strides.by(Stepping::USUAL))
}

#[test]
fn the_same_for_any_number_of_threads() -> Result<(), GaitError> {
    let (strides, starts) = (strides()?, Starts::default());
    let wanted = basin(&strides, &starts, 5, 1)?;
    for threads in [2, 3, 40] {
        assert_eq!(basin(&strides, &starts, 5, threads)?, wanted);
    }
    Ok(())
}

/// Slow starts stall and fast ones run, with a line between them: its length and the share of what
/// runs settle as the grid is refined.
#[test]
fn share_and_boundary_settle() -> Result<(), GaitError> {
    let starts = Starts {
        legs: 12,
        ..Starts::default()
    };
    let basins = refined(&strides()?, &starts, &[4, 8, 16], 2)?;
    for basin in &basins {
        for lean in 0..basin.size {
            assert_eq!(basin.fate(lean, basin.size - 1), Fate::Runs);
        }
        assert_eq!(basin.fails(), 0);
    }
    let [coarse, middle, fine] = &basins[..] else {
        panic!("three grids")
    };
    assert_eq!(fine.fate(0, 0), Fate::Stalls);
    // A line through a grid of n cells a side leaves n of n² cells undecided.
    assert!((fine.share - middle.share).abs() < 1.0 / 16.0);
    assert!((middle.share - coarse.share).abs() < 1.0 / 8.0);
    assert!((fine.boundary / middle.boundary - 1.0).abs() < 0.35);
    Ok(())
}
