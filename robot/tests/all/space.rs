//! Robots in space: their geometry against closed forms, and their files.

use std::f64::consts::TAU;
use std::path::Path;

use saltus_robot::space::{Directions, Rest, discs, rests};
use saltus_robot::{Robot, resolve};

const FINE: f64 = 1e-12;

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

fn far(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

fn near(x: f64, expected: f64) {
    assert!((x - expected).abs() < FINE, "{x}, and not {expected}");
}

#[test]
fn a_dodecahedron_stands_on_twenty_triples() {
    let legs = Directions::Dodecahedron.vectors();
    assert_eq!(legs.len(), 12);
    // Neighbours are arctan 2 apart, and the faces meet at π − arctan 2: 63.435° and 116.565°.
    let least = (1..12)
        .map(|k| dot(&legs[0], &legs[k]))
        .filter(|x| *x < 0.99);
    near(least.fold(-1.0, f64::max).acos(), 2.0_f64.atan());
    near(2.0_f64.atan().to_degrees(), 63.434_948_822_922_01);
    let all = rests(&legs);
    assert_eq!(all.len(), 20);
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    for rest in &all {
        let [a, b, c] = rest.legs[..] else {
            panic!("{rest:?}");
        };
        // An icosahedron of circumradius 1: its edge, and the radius of the sphere in it.
        let edge = 2.0 / (golden * golden + 1.0).sqrt();
        for (one, other) in [(a, b), (b, c), (c, a)] {
            near(far(&legs[one], &legs[other]), edge);
            assert!((0.24 * edge - 0.252_35).abs() < 5e-6);
        }
        let inner = golden * golden / 3.0_f64.sqrt() * 0.5 * edge;
        near(rest.height, inner);
        assert!((0.24 * inner - 0.190_72).abs() < 5e-6);
        // Leg 1 of the thesis leans by 37.377°.
        near(dot(&rest.down, &legs[a]).acos(), inner.acos());
        assert!((inner.acos().to_degrees() - 37.377).abs() < 5e-4);
    }
}

#[test]
fn a_dodecahedron_rolls_in_fifteen_planes_with_six_stations() {
    let legs = Directions::Dodecahedron.vectors();
    let all = discs(&legs);
    assert_eq!(all.len(), 15);
    let flat = 2.0_f64.atan();
    let steep = 0.25 * TAU - 0.5 * flat;
    near(steep.to_degrees(), 58.282_525_588_538_99);
    for disc in &all {
        let sizes: Vec<usize> = disc.stations.iter().map(|it| it.legs.len()).collect();
        assert_eq!(sizes.iter().sum::<usize>(), 8);
        assert_eq!(sizes.iter().filter(|size| **size == 2).count(), 2);
        for (k, station) in disc.stations.iter().enumerate() {
            let next = &disc.stations[(k + 1) % 6];
            let step = (next.angle - station.angle).rem_euclid(TAU);
            let singles = station.legs.len() == 1 && next.legs.len() == 1;
            near(step, if singles { flat } else { steep });
            // Twins reach 0.8507 of a leg, and stand to both sides.
            let reach = if station.legs.len() == 1 {
                1.0
            } else {
                (0.5 * flat).cos()
            };
            near(station.reach, reach);
            near((0.5 * flat).cos(), 0.850_650_808_352_039_9);
            if let [left, right] = station.legs[..] {
                near(dot(&legs[left], &disc.axis), (0.5 * flat).sin());
                near(dot(&legs[right], &disc.axis), -(0.5 * flat).sin());
            }
        }
    }
}

#[test]
fn three_discs_go_through_each_rest() {
    let legs = Directions::Dodecahedron.vectors();
    let all = discs(&legs);
    for Rest { down, .. } in rests(&legs) {
        // The plane is upright: its axis is level. Either way of three discs makes six headings.
        let upright: Vec<_> = all
            .iter()
            .filter(|disc| dot(&disc.axis, &down).abs() < FINE)
            .collect();
        assert_eq!(upright.len(), 3);
        let cosine = dot(&upright[0].axis, &upright[1].axis).abs();
        near(cosine, 0.5);
    }
}

#[test]
fn the_other_solids_stand_on_their_faces() {
    for (directions, legs, faces, feet) in [
        (Directions::Cube, 6, 8, 3),
        (Directions::Octahedron, 8, 6, 4),
        (Directions::Icosahedron, 20, 12, 5),
    ] {
        let vectors = directions.vectors();
        assert_eq!(vectors.len(), legs);
        assert!(vectors.iter().all(|v| (dot(v, v) - 1.0).abs() < FINE));
        let all = rests(&vectors);
        assert_eq!(all.len(), faces);
        assert!(all.iter().all(|rest| rest.legs.len() == feet));
    }
}

#[test]
fn twelve_legs_have_the_mass_and_the_inertia_of_the_robot() {
    let robot = resolve("rats-twelve", &[]).expect("sound");
    let space = robot.space.as_ref().expect("in space");
    let core = robot.core(space, 0.0);
    // A solid sphere of 3 kg is left where the legs are taken off.
    near(core.mass, 3.0);
    for i in 0..3 {
        for j in 0..3 {
            let expected = if i == j { 0.4 * 3.0 * 0.24 * 0.24 } else { 0.0 };
            near(core.inertia[i][j], expected);
        }
    }
}

fn changed(overrides: &[&str]) -> Result<Robot, String> {
    let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
    resolve("rats-twelve", &overrides).map_err(|error| error.to_string())
}

#[test]
fn a_file_that_was_written_is_read_as_the_same_robot() {
    let tetrahedron = "legs.directions=[[0.57735,0.57735,0.57735],[0.57735,-0.57735,-0.57735],\
                       [-0.57735,0.57735,-0.57735],[-0.57735,-0.57735,0.57735]]";
    for overrides in [
        vec![],
        vec![
            "legs.directions=\"cube\"",
            "legs.force_factors=[1,1.05,0.9,1,1,1]",
        ],
        vec![
            tetrahedron,
            "legs.delay_factors=0.5",
            "legs.friction_factors=2",
        ],
        vec![
            "body.inertia_kg_m2=[0.09,0.08,0.085,0.001,-0.002,0.0005]",
            "body.center_of_mass_mm=[1,-2,0.5]",
        ],
    ] {
        let robot = changed(&overrides).expect("sound");
        let again = Robot::parse(&robot.to_toml(), "again.toml", Path::new(".")).expect("sound");
        assert_eq!(robot, again);
    }
    let robot = changed(&[
        "legs.directions=\"cube\"",
        "legs.force_factors=[1,1.05,0.9,1,1,1]",
    ]);
    let robot = robot.expect("sound");
    assert_eq!(robot.body.legs, 6);
    near(
        250.0 * 1.05,
        match robot.own_leg(1).drive {
            saltus_robot::Drive::Constant { force } => force,
            _ => f64::NAN,
        },
    );
}

#[test]
fn what_is_no_robot_in_space_is_named() {
    for (overrides, says) in [
        (
            vec!["legs.directions=[[1,0,0],[0,1,0],[0,0,1]]"],
            "from 4 to 64 unit vectors; this list has 3",
        ),
        (
            vec!["legs.directions=[[2,0,0],[0,1,0],[0,0,1],[-1,0,0]]"],
            "the length of item 1 is 2",
        ),
        (
            vec!["legs.directions=[[1,0,0],[0,1],[0,0,1],[-1,0,0]]"],
            "item 2 is none",
        ),
        (
            vec!["legs.directions=[[1,0,0],[0,1,0],[0,0,1],[1,0.0004,0]]"],
            "items 1 and 4 do",
        ),
        (
            vec!["legs.directions=[[1,0,0],[0,1,0],[-1,0,0],[0,-1,0]]"],
            "on which the robot can stand",
        ),
        (vec!["legs.directions=\"sphere\""], "dodecahedron"),
        (
            vec!["legs.force_factors=[1,2]"],
            "a list of 12; this list has 2",
        ),
        (vec!["legs.force_factors=0"], "force_factors"),
        (vec!["legs.delay_factors=nan"], "delay_factors"),
        (vec!["legs.directon=\"cube\""], "legs.directions"),
        (
            vec!["body.inertia_kg_m2=[0.2,0.05,0.05,0,0,0]"],
            "that of a body",
        ),
        (vec!["body.inertia_kg_m2=0.001"], "less than body.inertia"),
        (vec!["body.inertia_kg_m2=[0.08,0.08]"], "a list of 6"),
        (vec!["body.center_of_mass_mm=[300,0,0]"], "within the feet"),
        (vec!["body.center_of_mass_mm=3"], "a list of three numbers"),
        (vec!["body.imbalance_mm=3"], "unknown key body.imbalance_mm"),
        (vec!["body.legs=12"], "unknown key body.legs"),
        (
            vec!["ground.across_friction=0.1"],
            "unknown key ground.across_friction",
        ),
        (
            vec!["struts.distance_m=0.1"],
            "left out for a robot in space",
        ),
        (vec!["body.shape=\"egg\""], "wheel or sphere"),
    ] {
        let error = changed(&overrides).expect_err("refused");
        assert!(error.contains(says), "{overrides:?}: {error}");
    }
    let planar = resolve("rats-planar", &["legs.directions=\"cube\"".into()]);
    assert!(
        planar
            .expect_err("refused")
            .to_string()
            .contains("left out for a wheel")
    );
}
