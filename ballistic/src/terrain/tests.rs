//! Landings against closed forms, dense sampling and finite differences.

use proptest::prelude::*;
use saltus_numeric::{Dual, Scalar};

use super::*;
use crate::check::{check_slopes, close, config, dual};

const HOP: Flight<f64> = Flight {
    x: 0.0,
    y: 1.0,
    vx: 1.0,
    vy: 4.0,
    gravity: 8.0,
};

#[test]
fn closed_forms() {
    let check =
        |terrain: Result<Terrain, FlightError>, radius: f64, centre: [f64; 2], feature: Feature| {
            let landing = HOP.landing(&terrain.unwrap(), radius).unwrap();
            for (found, expected) in landing.centre.into_iter().zip(centre) {
                assert!((found - expected).abs() < 1e-14, "{landing:?}");
            }
            assert_eq!(landing.feature, feature);
            let [dx, dy] = [centre[0] - landing.point[0], centre[1] - landing.point[1]];
            assert!((dx.hypot(dy) - radius).abs() < 1e-14, "{landing:?}");
        };
    // The path is y = 2 − 4 (x − 1/2)².
    check(Ok(Terrain::flat(0.5)), 0.5, [1.0, 1.0], Feature::Edge(1));
    check(
        Terrain::step(0.75, 0.0, 0.5),
        0.5,
        [1.0, 1.0],
        Feature::Edge(2),
    );
    // Against the face of a wall too high to climb.
    check(
        Terrain::step(0.75, 0.0, 9.0),
        0.25,
        [0.5, 2.0],
        Feature::Edge(1),
    );
    // A point on the slope y = x − 1: 4 x² − 3 x − 2 = 0.
    let x = (3.0 + 41.0_f64.sqrt()) / 8.0;
    check(
        Terrain::slope(1.0, std::f64::consts::FRAC_PI_4),
        0.0,
        [x, x - 1.0],
        Feature::Edge(1),
    );
    // On the tip of a spike below.
    check(
        Terrain::profile(&[[0.95, 0.0], [1.0, 0.75], [1.05, 0.0]]),
        0.25,
        [1.0, 1.0],
        Feature::Vertex(1),
    );
}

#[test]
fn what_never_lands_says_so() {
    let flat = Terrain::flat(0.0);
    let rising = Flight {
        gravity: 0.0,
        ..HOP
    };
    assert_eq!(
        rising.landing(&flat, 0.25).unwrap_err().to_string(),
        "the wheel's centre, 1 m from the terrain at lift-off, never comes down to its radius of \
         0.25 m"
    );
    let low = Flight {
        y: 0.1,
        vy: 0.5,
        ..HOP
    };
    assert_eq!(
        low.landing(&flat, 0.25),
        Err(FlightError::NeverLands {
            gap: 0.1,
            radius: 0.25
        })
    );
}

#[test]
fn bad_terrains_say_why() {
    let check = |terrain: Result<Terrain, FlightError>, expected: &str| {
        assert_eq!(terrain.unwrap_err().to_string(), expected);
    };
    check(
        Terrain::profile(&[]),
        "0 vertices where at least 1 are needed",
    );
    check(
        Terrain::step(1.0, 2.0, 2.0),
        "vertex 0 at (1, 2) m is there twice in a row",
    );
    check(
        Terrain::profile(&[[1.0, 0.0], [0.0, 0.0]]),
        "the terrain runs back at vertex 0, (1, 0) m",
    );
    check(
        Terrain::profile(&[[1.0, 0.0], [1.0, 2.0], [1.0, 1.0]]),
        "the terrain runs back at vertex 1, (1, 2) m",
    );
    check(
        Terrain::slope(0.0, 2.0),
        "a slope of 2 rad is not between level and upright",
    );
    check(
        Terrain::profile(&[[f64::NAN, 0.0]]),
        "vertex 0 at (NaN, 0) m is not at a finite place",
    );
}

/// Ground with slopes, steps and peaks.
fn profiles() -> impl Strategy<Value = Terrain> {
    prop::collection::vec((0.05..0.5, -0.5..0.5, any::<bool>()), 1..7).prop_map(|steps| {
        let mut x = -0.5;
        let mut vertices = Vec::new();
        for (run, height, wall) in steps {
            x += if wall && vertices.len() % 2 == 1 {
                0.0
            } else {
                run
            };
            vertices.push([x, height]);
        }
        Terrain::profile(&vertices).unwrap()
    })
}

fn jumps() -> impl Strategy<Value = Flight<f64>> {
    // Lift-off is clear of the terrain above, which ends at 0.5 m.
    (-1.0..1.0, 0.8..1.5, -4.0..4.0, -1.0..5.0, 1.0..20.0).prop_map(|(x, y, vx, vy, gravity)| {
        Flight {
            x,
            y,
            vx,
            vy,
            gravity,
        }
    })
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn flat_ground_is_the_closed_form(flight in jumps(), radius in 0.0..0.3) {
        let landing = flight.landing(&Terrain::flat(0.1), radius).unwrap();
        prop_assert!(close(landing.time, flight.time_to_height(0.1 + radius).unwrap(), 1e-13));
        prop_assert!(close(landing.centre[0], flight.range_to_height(0.1 + radius).unwrap(), 1e-13));
    }

    #[test]
    fn stays_clear_until_it_lands(flight in jumps(), terrain in profiles(), radius in 0.01..0.25) {
        let landing = flight.landing(&terrain, radius).unwrap();
        prop_assert!((terrain.outline.nearest(landing.centre).1 - radius).abs() < 1e-13);
        for (t, x, y) in flight.samples(0.0, landing.time, 1000) {
            let gap = terrain.outline.nearest([x, y]).1;
            prop_assert!(gap >= radius - 1e-13, "{gap} at {t} before {landing:?}");
        }
    }

    #[test]
    fn slopes_are_those_of_finite_differences(flight in jumps(), terrain in profiles(), radius in 0.05..0.2) {
        let landing = |f: Flight<f64>| f.landing(&terrain, radius).unwrap();
        let here = landing(flight);
        // Differences need room: no other feature, no grazing within their reach.
        let settled = |by: f64| {
            let moved = Flight { x: flight.x + by, y: flight.y - by, vx: flight.vx + by, vy: flight.vy + by, ..flight };
            let there = landing(moved);
            there.feature == here.feature && (there.time - here.time).abs() < 0.05
        };
        prop_assume!(settled(0.02) && settled(-0.02));
        let exact = dual(flight).landing(&terrain, Dual::of(radius)).unwrap();
        check_slopes(flight, exact.time, |f| landing(f).time);
        for i in 0..2 {
            check_slopes(flight, exact.centre[i], |f| landing(f).centre[i]);
            check_slopes(flight, exact.point[i], |f| landing(f).point[i]);
        }
    }
}
