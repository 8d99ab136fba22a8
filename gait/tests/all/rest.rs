//! A robot that stalls comes to rest, with every event located.

use saltus_gait::{Centre, Draw, Ending, Program, Setup, drawn_robot, run};
use saltus_sim_check::Stepping;

/// These rock on two feet, of which one slips, while their legs slide by nanometres.
#[test]
fn drawn_robots_rock_to_rest_by_events() {
    let base = crate::robot("rats-run");
    for (seed, k) in [(23, 16), (23, 59), (123, 145)] {
        let program = Program::OpenLoop {
            first: 0.35,
            last: 0.0,
            slope: 2.1,
            centre: Centre::Seconds(3.0),
        };
        let robot = drawn_robot(&base, &Draw::default(), seed, k).expect("a drawn robot");
        let setup = Setup {
            seed: seed + k as u64,
            stepping: Stepping::Adaptive,
            ..Setup::new(robot, program, 2.3)
        };
        let summary = run(&setup, &mut ()).expect("a run");
        assert!(
            matches!(summary.ending, Ending::Stalled { .. }),
            "{seed} {k}: {:?}",
            summary.ending
        );
        assert!(summary.residual.abs() < 1e-8, "{} J", summary.residual);
    }
}
