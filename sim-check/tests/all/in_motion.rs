//! Motions that go on from what another one was.

use saltus_sim_check::{LegStart, Rig, Settings, Sim, SimError, Stepping};

fn rig() -> Result<Rig, SimError> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../robots/rats-run.toml");
    let robot = saltus_robot::resolve(path, &[] as &[String]).unwrap_or_else(|e| panic!("{e}"));
    Rig::new(&robot, &[])
}

fn leg_starts(sim: &Sim<'_>, valve: [f64; 2]) -> Vec<LegStart> {
    let start = |leg: usize| LegStart {
        pressure: sim.pressure(leg),
        valve: (leg == 0).then(|| valve.map(|t| t - sim.time())),
    };
    (0..5).map(start).collect()
}

/// Cut before the valve opens, while it is open and while the chamber exhausts: the second part ends
/// where the whole does. Steps by events, whose lengths alone differ.
#[test]
fn a_motion_that_is_cut_is_the_whole() -> Result<(), SimError> {
    let (rig, settings) = (rig()?, Settings::default());
    let (q, v) = rig.stand(0.1, 8.0)?;
    // The valve answers after 10 ms.
    let valve = [0.01, 0.05];
    let mut whole = Sim::new(&rig.mechanism, &q, &v, settings)?;
    whole.release_legs()?;
    whole.fire(0, 0.04)?;
    whole.run(0.12, &[])?;
    for cut in [0.005, 0.02, 0.06] {
        let mut first = Sim::new(&rig.mechanism, &q, &v, settings)?;
        first.release_legs()?;
        first.fire(0, 0.04)?;
        first.run(cut, &[])?;
        let legs = leg_starts(&first, valve);
        let (q, v) = (first.coordinates(), first.velocities());
        let mut second = Sim::in_motion(&rig.mechanism, q, v, &legs, settings)?;
        second.run(0.12 - cut, &[])?;
        for (got, wanted) in second.coordinates().iter().zip(whole.coordinates()) {
            assert!((got - wanted).abs() < 1e-8, "cut at {cut}: {got} {wanted}");
        }
        for leg in 0..5 {
            let off = second.pressure(leg) - whole.pressure(leg);
            assert!(off.abs() < 1e-2, "cut at {cut}: {off} Pa");
        }
    }
    Ok(())
}

#[test]
fn legs_that_cannot_be_are_refused() -> Result<(), SimError> {
    let rig = rig()?;
    let (q, v) = rig.stand(0.1, 8.0)?;
    let settings = Settings {
        stepping: Stepping::USUAL,
        ..Settings::default()
    };
    let good = LegStart {
        pressure: 101325.0,
        valve: None,
    };
    for (legs, key) in [
        (vec![good; 4], "legs at the start"),
        (
            vec![
                LegStart {
                    pressure: 0.0,
                    ..good
                };
                5
            ],
            "chamber pressure",
        ),
        (
            vec![
                LegStart {
                    valve: Some([0.2, 0.1]),
                    ..good
                };
                5
            ],
            "valve closes",
        ),
    ] {
        let refused = Sim::in_motion(&rig.mechanism, &q, &v, &legs, settings).map(|_| ());
        let error = refused.map_or_else(|error| error.to_string(), |()| "none".into());
        assert!(error.contains(key), "{error}");
    }
    Ok(())
}
