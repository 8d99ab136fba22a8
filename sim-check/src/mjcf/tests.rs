//! The file against the rig that it is written from.

#![allow(clippy::unwrap_used)]

use super::*;
use crate::xml::LEAST_INERTIA;

const BUILT_IN: [&str; 5] = [
    "rats-planar",
    "rats-boom",
    "rats-run",
    "spring-hopper",
    "table-hopper",
];

fn robot(name: &str, overrides: &[&str]) -> Robot {
    let overrides: Vec<String> = overrides.iter().map(|s| (*s).to_owned()).collect();
    saltus_robot::resolve(name, &overrides).unwrap()
}

/// The elements of `xml` in their order, closing ones with a slash before their name; panics where
/// it is not well-formed.
fn elements(xml: &str) -> Vec<(String, Vec<(String, String)>)> {
    let (mut rest, mut open, mut found) = (xml, Vec::new(), Vec::new());
    while let Some(at) = rest.find('<') {
        assert!(
            !rest[..at].contains('>') && rest[..at].trim().is_empty(),
            "{}",
            &rest[..at]
        );
        rest = &rest[at..];
        if let Some(comment) = rest.strip_prefix("<!--") {
            let end = comment.find("--").unwrap();
            assert!(
                comment[end..].starts_with("-->"),
                "{}",
                &comment[end..end + 10]
            );
            rest = &comment[end + 3..];
            continue;
        }
        let end = rest.find('>').unwrap();
        let tag = &rest[1..end];
        rest = &rest[end + 1..];
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop().as_deref(), Some(name));
            found.push((tag.to_owned(), Vec::new()));
            continue;
        }
        let alone = tag.ends_with('/');
        let parts: Vec<&str> = tag.trim_end_matches('/').split('"').collect();
        assert_eq!(parts.len() % 2, 1, "{tag}");
        let name = parts[0].split(' ').next().unwrap().to_owned();
        let key = |text: &str| {
            text.rsplit(' ')
                .next()
                .unwrap()
                .trim_end_matches('=')
                .to_owned()
        };
        let attributes = parts
            .chunks_exact(2)
            .map(|two| (key(two[0]), two[1].to_owned()))
            .collect();
        if !alone {
            open.push(name.clone());
        }
        found.push((name, attributes));
    }
    assert!(open.is_empty(), "{open:?}");
    found
}

fn attribute<'a>(attributes: &'a [(String, String)], key: &str) -> Option<&'a str> {
    attributes
        .iter()
        .find(|(k, _)| k == key)
        .map(|(_, value)| value.as_str())
}

fn parsed(text: &str) -> Vec<f64> {
    text.split(' ').map(|x| x.parse().unwrap()).collect()
}

fn check_bodies(robot: &Robot) {
    let rig = Rig::new(robot, &[]).unwrap();
    let xml = mjcf(robot).unwrap();
    let (mut name, mut total, mut joints) = (String::new(), 0.0, Vec::new());
    for (element, attributes) in elements(&xml) {
        match element.as_str() {
            "body" => name = attribute(&attributes, "name").unwrap().to_owned(),
            "inertial" => {
                let bodies = rig.mechanism.tree.bodies();
                let body = bodies.iter().find(|b| plain(&b.name) == name).unwrap();
                let get = |key| attribute(&attributes, key).map(parsed);
                assert_eq!(get("mass").unwrap(), [body.mass]);
                assert_eq!(get("pos").unwrap(), body.center.as_slice());
                let i = &body.inertia;
                let (found, expected) = match get("diaginertia") {
                    Some(moments) => (moments, i.diagonal().as_slice().to_vec()),
                    None => (
                        get("fullinertia").unwrap(),
                        vec![
                            i[(0, 0)],
                            i[(1, 1)],
                            i[(2, 2)],
                            i[(0, 1)],
                            i[(0, 2)],
                            i[(1, 2)],
                        ],
                    ),
                };
                for (a, b) in found.iter().zip(&expected) {
                    // What is added to moments that are 0, and its round-off.
                    assert!(
                        (a - b).abs() <= 1.001 * LEAST_INERTIA,
                        "{name}: {found:?} {expected:?}"
                    );
                }
                total += body.mass;
            }
            "joint" => joints.extend(
                attribute(&attributes, "axis")
                    .and(attribute(&attributes, "name"))
                    .map(str::to_owned),
            ),
            _ => {}
        }
    }
    let boom = robot
        .boom
        .map_or(0.0, |b| b.mass + b.counterweight.map_or(0.0, |c| c.mass));
    // Round-off of a sum of seven.
    assert!((total - robot.body.mass - boom).abs() < 1e-14 * total);
    let expected: Vec<String> = rig
        .mechanism
        .tree
        .bodies()
        .iter()
        .map(|b| plain(&b.name))
        .collect();
    assert_eq!(
        joints, expected,
        "the coordinates are in the order of the rig's"
    );
}

#[test]
fn bodies_are_those_of_the_rig() {
    for name in BUILT_IN {
        check_bodies(&robot(name, &[]));
    }
    let boom = |overrides: &[&str]| check_bodies(&robot("rats-boom", overrides));
    boom(&["boom.bending_stiffness_n_m_per_rad=2000"]);
    boom(&[
        "boom.counterweight.mass_kg=0.2",
        "boom.counterweight.distance_m=0.4",
    ]);
    boom(&["boom.mass_kg=0", "boom.radius_m=0"]);
    boom(&[
        "leg.rod_radius_m=0",
        "body.imbalance_mm=2",
        "body.imbalance_angle_deg=30",
    ]);
}

#[test]
fn pairs_and_sensors_name_shapes_that_are_there() {
    for name in BUILT_IN {
        let found = elements(&mjcf(&robot(name, &[])).unwrap());
        let of = |kinds: &[&str], key: &str| -> Vec<String> {
            let meant = found
                .iter()
                .filter(|(kind, _)| kinds.contains(&kind.as_str()));
            let values = meant.filter_map(|(_, all)| attribute(all, key));
            values.map(str::to_owned).collect()
        };
        let (shapes, sites) = (of(&["geom"], "name"), of(&["site"], "name"));
        let pairs = of(&["pair"], "geom2");
        assert!(
            !pairs.is_empty() && pairs.iter().all(|x| shapes.contains(x)),
            "{name}: {pairs:?}"
        );
        let touched = of(&["touch"], "site");
        assert!(
            touched.len() == pairs.len() && touched.iter().all(|x| sites.contains(x)),
            "{name}"
        );
    }
}

#[test]
fn joints_of_a_boom_without_mass_turn_about_its_base() {
    let xml = mjcf(&robot("rats-boom", &["boom.mass_kg=0"])).unwrap();
    for joint in [
        "name=\"boom_turn\" type=\"hinge\" axis=\"0 0 -1\"",
        "name=\"boom\" type=\"hinge\" axis=\"1 0 0\"",
    ] {
        assert!(xml.contains(&format!("{joint} pos=\"0 -2.12 0\"")), "{xml}");
    }
}

#[test]
fn a_leg_has_its_friction_and_springs() {
    let xml = mjcf(&robot(
        "rats-boom",
        &[
            "leg.return_spring.stiffness_n_per_m=50",
            "leg.return_spring.preload_n=2",
        ],
    ));
    let leg = "range=\"0 0.06\" damping=\"5.2843\" frictionloss=\"9.7003\" stiffness=\"50\" \
        springref=\"-0.04\"";
    assert_eq!(xml.unwrap().matches(leg).count(), 5);
}

#[test]
fn a_name_is_only_a_name() {
    let mut named = robot("rats-planar", &[]);
    named.name = "a --- <b> & \"c\"\n\u{1}d".into();
    let found = elements(&mjcf(&named).unwrap());
    let model = attribute(&found[0].1, "model");
    assert_eq!(model, Some("a --- &lt;b&gt; &amp; &quot;c&quot;  d"));
}

#[test]
fn what_is_not_expressed_is_said() {
    let said = |overrides: &[&str]| missing(&robot("rats-boom", overrides)).join("\n");
    assert!(said(&[]).contains("infinite friction") && said(&[]).ends_with('.'));
    assert!(
        said(&["ground.static_friction=0.9", "ground.kinetic_friction=0.7"])
            .contains("kinetic friction of 0.7")
    );
    assert!(said(&["ground.restitution=0.2"]).contains("restitution of 0.2"));
    assert!(said(&["environment.drag_per_m=0.01"]).contains("drag of 0.01"));
    let run = missing(&robot("rats-run", &[])).join("\n");
    assert!(run.contains("the struts between the legs") && run.contains("- sensors"));
    assert!(!said(&[]).contains("strut") && !said(&[]).contains("sensors"));
    assert!(
        missing(&robot("rats-planar", &[]))
            .join("\n")
            .contains("legs without mass")
    );
}

#[test]
fn a_robot_in_space_moves_freely_and_stands_on_three_feet() {
    let robot = saltus_robot::resolve("rats-twelve", &[]).expect("sound");
    let text = mjcf(&robot).expect("bodies");
    assert!(text.contains("<freejoint name=\"body\""));
    // MuJoCo has no sensor of a free joint.
    assert!(!text.contains("jointpos name=\"body_position\""));
    assert!(text.contains("framequat name=\"axle_attitude\""));
    assert_eq!(text.matches("type=\"slide\"").count(), 12);
    let key = text.lines().find(|line| line.contains("<key name"));
    let qpos = key.and_then(|line| line.split("qpos=\"").nth(1));
    let numbers = qpos.map_or(0, |text| text.trim_end_matches("\"/>").split(' ').count());
    assert_eq!(numbers, 19);
}

#[test]
fn feet_of_rubber_are_springs_and_dampers() {
    let found = elements(&mjcf(&robot("rats-twelve", &[])).unwrap());
    let is_foot = |(kind, all): &&(String, Vec<(String, String)>)| {
        kind == "pair" && attribute(all, "geom2").is_some()
    };
    // Along a rod nothing but itself resists. Across it the sphere does with all legs, each of them by its parts across its
    // own slide: 12 - 4 of 12, as the squares of the cosines add up to 12/3 along any axis. It turns too.
    let (sphere, rod, reach, inertia) = (3.0, 0.05, 0.19, 0.08390313333333332);
    let across = 1.0 / (sphere + 8.0 * rod) + reach * reach / inertia;
    let mobility = (1.0 / rod + 2.0 * across) / 3.0;
    let feet: Vec<_> = found.iter().filter(is_foot).collect();
    assert_eq!(feet.len(), 12);
    for (_, all) in feet {
        let law = parsed(attribute(all, "solref").unwrap());
        for (given, number) in law.iter().zip([50_000.0, 850.0]) {
            let expected = -number * mobility * (1.0 - 1e-4);
            assert!((given / expected - 1.0).abs() < 1e-12, "{law:?}");
        }
    }
    // A rigid ground has none of it.
    let rigid = mjcf(&robot("rats-run", &[])).unwrap();
    assert!(!rigid.contains("impratio") && !rigid.contains("solreffriction=\"-"));
}

#[test]
fn each_leg_has_its_own_friction() {
    let factors = "legs.friction_factors=[1,2,3,4,5,6,7,8,9,10,11,12]";
    let robot = robot(
        "rats-twelve",
        &[factors, "leg.viscous_friction_n_s_per_m=0.5"],
    );
    let found = elements(&mjcf(&robot).unwrap());
    let slides = found
        .iter()
        .filter(|(_, all)| attribute(all, "type") == Some("slide"));
    let friction = |key: &'static str| {
        let all = slides
            .clone()
            .map(move |(_, all)| attribute(all, key).unwrap());
        all.map(|x| x.parse().unwrap()).collect::<Vec<f64>>()
    };
    let expected: Vec<f64> = (1..=12).map(f64::from).collect();
    assert_eq!(friction("frictionloss"), expected);
    assert_eq!(
        friction("damping"),
        expected.iter().map(|x| 0.5 * x).collect::<Vec<f64>>()
    );
    let said = missing(&robot).join("\n");
    assert!(
        said.contains("legs that differ: forces times 1 1"),
        "{said}"
    );
}
