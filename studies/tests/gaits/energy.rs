//! The energy of a run by parts.

use saltus_gait::{GaitError, run};
use saltus_studies::analysis::energy::Energy;

use crate::pushed;

/// In steps of 1 ms a run of 10 s on 0.87 kJ of gas leaves 0.29 J. The bound is thrice that: single runs part, and ledgers
/// with them.
#[test]
fn parts_make_up_the_whole() -> Result<(), GaitError> {
    let setup = pushed(10.0);
    let energy = Energy::of(&setup.robot, &run(&setup, &mut ())?);
    let parts = [
        energy.valves,
        energy.slip,
        energy.impacts,
        energy.stops,
        energy.gas,
    ];
    assert!(parts.iter().all(|part| *part > 0.0), "{energy:?}");
    assert!(energy.unexplained().abs() < 0.9, "{energy:?}");
    Ok(())
}
