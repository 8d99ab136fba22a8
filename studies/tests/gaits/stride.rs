//! Strides as a map.

use saltus_gait::GaitError;
use saltus_studies::analysis::stride::{Firing, StrideState, Strides};

use crate::{planar, robot};

/// The greatest difference of velocities (m/s or rad/s) and of pressures (Pa).
fn differences(a: &StrideState, b: &StrideState) -> [f64; 2] {
    let far = |pairs: &mut dyn Iterator<Item = (f64, f64)>| {
        pairs.map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
    };
    let pressures = a.legs.iter().zip(&b.legs);
    [
        far(&mut a
            .velocities
            .iter()
            .copied()
            .zip(b.velocities.iter().copied())),
        far(&mut pressures.map(|(x, y)| (x.pressure, y.pressure))),
    ]
}

/// What a section leaves out, legs' names and the travel, is nothing that the motion depends on; and
/// a motion goes on from a section as if it had not stopped there. With the section at 0.3 rad, a
/// valve is open there.
#[test]
fn a_run_cut_at_every_section_is_the_run_in_one_go() -> Result<(), GaitError> {
    for (robot, section) in [(robot("rats-run"), 0.0), (planar(), 0.0), (planar(), 0.3)] {
        let firing = Firing {
            section,
            ..Firing::new(0.1, 0.04)
        };
        let strides = Strides::new(&robot, firing)?;
        let start = strides.standing(section, 12.0)?;
        let whole = strides.strides(&start, 6)?;
        let mut state = start;
        for wanted in &whole {
            let got = strides.stride(&state)?.unwrap_or_else(|| panic!("runs"));
            let [speeds, pressures] = differences(&got.state, &wanted.state);
            // Steps of another length to a tolerance of 1e-10; differences grow from stride to
            // stride by the multipliers, of which none is above 10.
            assert!(speeds < 1e-5 && pressures < 1.0, "{speeds:e} {pressures:e}");
            assert!((got.time - wanted.time).abs() < 1e-7);
            assert_eq!(got.contacts, wanted.contacts);
            state = got.state;
        }
        assert_eq!(whole.len(), 6);
    }
    Ok(())
}

#[test]
fn one_that_is_too_slow_stalls() -> Result<(), GaitError> {
    let strides = Strides::new(&robot("rats-run"), Firing::new(0.1, 0.04))?;
    assert_eq!(strides.stride(&strides.standing(-0.5, 0.5)?)?, None);
    Ok(())
}

#[test]
fn what_cannot_be_is_refused() {
    let run = robot("rats-run");
    let mut hill = run.clone();
    hill.ground.tilt = 0.1;
    for (robot, firing, key) in [
        (&hill, Firing::new(0.1, 0.04), "slope"),
        (&run, Firing::new(2.0, 0.04), "firing angle"),
        (&run, Firing::new(f64::NAN, 0.04), "firing angle"),
        (&run, Firing::new(0.1, -0.04), "valve opening time"),
        (
            &run,
            Firing {
                section: -1.2,
                ..Firing::new(0.1, 0.04)
            },
            "section",
        ),
    ] {
        let refused = Strides::new(robot, firing).map(|_| ());
        let error = refused.map_or_else(|error| error.to_string(), |()| "none".into());
        assert!(error.contains(key), "{error}");
    }
}
