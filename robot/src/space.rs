//! A robot that moves freely in space: where its legs point, and on which feet it can stand.
//!
//! Source: thesis, chapter 7.

use std::f64::consts::TAU;

use crate::{Drive, GaugePressure, Leg, Robot};

/// Most legs.
pub(crate) const MOST: usize = 64;
/// How far (relative to a leg) a foot may be from a plane on which it still stands.
const FLAT: f64 = 1e-9;

type Vector = [f64; 3];

/// What a robot has that moves freely in space; a robot without it moves in its plane.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Space {
    /// Where its legs point.
    pub directions: Directions,
    /// Moments and products of inertia xx, yy, zz, xy, xz, yz (kg m²) about the place where the legs meet, with all legs
    /// retracted; off the diagonal as they stand in the matrix.
    pub inertia: [f64; 6],
    /// Centre of mass (m) of the body without its legs, from there.
    pub center: Vector,
    /// How each leg differs from the robot's leg, in the order of the directions; none: all are equal.
    pub legs: Vec<Factors>,
}

/// How a leg differs from the robot's leg.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Factors {
    /// Its force, or the pressure of its supply above ambient, over that of the robot's leg, > 0.
    pub force: f64,
    /// Its valve's delay over that of the robot's leg, ≥ 0.
    pub delay: f64,
    /// Its friction, viscous and dry, over that of the robot's leg, ≥ 0.
    pub friction: f64,
}

impl Default for Factors {
    fn default() -> Factors {
        Factors {
            force: 1.0,
            delay: 1.0,
            friction: 1.0,
        }
    }
}

/// Where the legs of a robot in space point: unit vectors in the body's axes.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Directions {
    /// Out of the six faces of a cube.
    Cube,
    /// Out of the eight faces of an octahedron.
    Octahedron,
    /// Out of the twelve faces of a dodecahedron.
    #[default]
    Dodecahedron,
    /// Out of the twenty faces of an icosahedron.
    Icosahedron,
    /// As listed.
    List(Vec<Vector>),
}

impl Directions {
    /// Those with a name, by their names in a robot file.
    pub(crate) const NAMED: [(&'static str, usize); 4] = [
        ("cube", 0),
        ("octahedron", 1),
        ("dodecahedron", 2),
        ("icosahedron", 3),
    ];

    /// That of a place in [`NAMED`](Self::NAMED).
    pub(crate) fn named(place: usize) -> Directions {
        match place {
            0 => Directions::Cube,
            1 => Directions::Octahedron,
            2 => Directions::Dodecahedron,
            _ => Directions::Icosahedron,
        }
    }

    /// Its name in a robot file, if it has one.
    pub fn name(&self) -> Option<&'static str> {
        let place = match self {
            Directions::Cube => 0,
            Directions::Octahedron => 1,
            Directions::Dodecahedron => 2,
            Directions::Icosahedron => 3,
            Directions::List(_) => return None,
        };
        Some(Directions::NAMED[place].0)
    }

    /// The unit vectors, in the order of the legs.
    pub fn vectors(&self) -> Vec<Vector> {
        let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
        match self {
            Directions::Cube => turned(&[1.0, 0.0, 0.0]),
            Directions::Octahedron => turned(&[1.0, 1.0, 1.0]),
            Directions::Dodecahedron => turned(&[0.0, 1.0, golden]),
            Directions::Icosahedron => [
                turned(&[1.0, 1.0, 1.0]),
                turned(&[0.0, 1.0 / golden, golden]),
            ]
            .concat(),
            Directions::List(vectors) => vectors.clone(),
        }
    }
}

/// The unit vectors along `first` with its coordinates in each cyclic order and of either sign.
fn turned(first: &Vector) -> Vec<Vector> {
    let length = norm(first);
    let mut all: Vec<Vector> = Vec::new();
    for shift in 0..3 {
        for signs in 0..8_u32 {
            let at = |k: usize| {
                let x = first[(k + shift) % 3] / length;
                if signs >> k & 1 == 0 { x } else { -x }
            };
            let new = std::array::from_fn(at);
            if !all.contains(&new) {
                all.push(new);
            }
        }
    }
    all
}

/// Feet on which a robot stands: all in one plane, with every other foot above it.
#[derive(Clone, Debug, PartialEq)]
pub struct Rest {
    /// The legs, in their order.
    pub legs: Vec<usize>,
    /// Unit vector, in the body's axes, towards the ground.
    pub down: Vector,
    /// Distance of the plane of the feet's tips from where the legs meet, over the length of a leg.
    pub height: f64,
}

/// All ways in which legs of one length along `directions` stand on three feet or more: the faces of the convex hull
/// of their tips, by their first legs.
///
/// Source: thesis 7.1.
pub fn rests(directions: &[Vector]) -> Vec<Rest> {
    let count = directions.len();
    let mut found: Vec<Rest> = Vec::new();
    for a in 0..count {
        for b in a + 1..count {
            for c in b + 1..count {
                let known = |rest: &Rest| [a, b, c].iter().all(|leg| rest.legs.contains(leg));
                if !found.iter().any(known) {
                    found.extend(rest_on(directions, [a, b, c]));
                }
            }
        }
    }
    found
}

/// The rest on three legs and all others in their plane, if every other foot is above it.
fn rest_on(directions: &[Vector], [a, b, c]: [usize; 3]) -> Option<Rest> {
    let corner = directions[a];
    let across = cross(
        &minus(&directions[b], &corner),
        &minus(&directions[c], &corner),
    );
    let length = norm(&across);
    if length < FLAT {
        return None;
    }
    let mut down = across.map(|x| x / length);
    if dot(&down, &corner) < 0.0 {
        down = down.map(|x| -x);
    }
    let height = dot(&down, &corner);
    // A plane through the middle has feet on both sides, or all legs in it.
    if height < FLAT || directions.iter().any(|leg| dot(&down, leg) > height + FLAT) {
        return None;
    }
    let stands = |leg: &usize| dot(&down, &directions[*leg]) > height - FLAT;
    Some(Rest {
        legs: (0..directions.len()).filter(stands).collect(),
        down,
        height,
    })
}

/// A plane in which a robot can roll on its legs as a disc: it contains four legs or more, and mirrors the others.
#[derive(Clone, Debug, PartialEq)]
pub struct Disc {
    /// Unit vector, in the body's axes, across the plane: to the left of a robot that rolls forwards, right-handed about it.
    pub axis: Vector,
    /// Unit vector, in the body's axes, along the leg of the first station.
    pub first: Vector,
    /// Unit vector, in the body's axes, that points down after a quarter turn from where `first` does.
    pub ahead: Vector,
    /// What comes onto the ground as the disc rolls forwards, in its order.
    pub stations: Vec<Station>,
}

/// A leg in the plane of a disc, or two of which each is the mirror image of the other.
#[derive(Clone, Debug, PartialEq)]
pub struct Station {
    /// The leg, or the twins: first the left one.
    pub legs: Vec<usize>,
    /// How far (rad) the disc turns from where the first station points down to where this one does, in [0, 2 π).
    pub angle: f64,
    /// How far it reaches in the plane, over the length of a leg.
    pub reach: f64,
}

/// The discs of legs along `directions`, each once; the one about the opposite axis is the same disc, the other way.
///
/// Source: thesis 7.2.
pub fn discs(directions: &[Vector]) -> Vec<Disc> {
    let mut found: Vec<Disc> = Vec::new();
    for a in 0..directions.len() {
        for b in a + 1..directions.len() {
            let across = cross(&directions[a], &directions[b]);
            let length = norm(&across);
            if length < FLAT {
                continue;
            }
            let axis = across.map(|x| x / length);
            let same = |disc: &Disc| dot(&disc.axis, &axis).abs() > 1.0 - FLAT;
            if !found.iter().any(same) {
                found.extend(disc_about(directions, axis, a));
            }
        }
    }
    found
}

/// The disc about `axis`, with its angles from leg `first` on.
fn disc_about(directions: &[Vector], axis: Vector, first: usize) -> Option<Disc> {
    let first = directions[first];
    let ahead = cross(&first, &axis);
    let mut stations: Vec<Station> = Vec::new();
    let mut inside = 0;
    for (leg, direction) in directions.iter().enumerate() {
        let side = dot(direction, &axis);
        let in_plane = side.abs() < FLAT;
        inside += usize::from(in_plane);
        let mirrored: Vector = std::array::from_fn(|k| direction[k] - 2.0 * side * axis[k]);
        let twin = directions
            .iter()
            .position(|other| norm(&minus(other, &mirrored)) < FLAT)?;
        if in_plane || side > 0.0 {
            let (x, y) = (dot(direction, &first), dot(direction, &ahead));
            stations.push(Station {
                legs: if in_plane { vec![leg] } else { vec![leg, twin] },
                // A leg that is a round-off behind the first is the first.
                angle: (y.atan2(x) + 1e-12).rem_euclid(TAU) - 1e-12,
                reach: x.hypot(y),
            });
        }
    }
    stations.sort_by(|a, b| a.angle.total_cmp(&b.angle));
    let touching = (0..stations.len()).filter(|k| touches(&stations, *k));
    let stations: Vec<Station> = touching.map(|k| stations[k].clone()).collect();
    (inside >= 4).then_some(Disc {
        axis,
        first,
        ahead,
        stations,
    })
}

/// Whether station `k` comes onto the ground as the disc rolls: its tip is a corner of the hull of all.
fn touches(stations: &[Station], k: usize) -> bool {
    let tip = |station: &Station| {
        let (up, along) = station.angle.sin_cos();
        [along * station.reach, up * station.reach]
    };
    let own = tip(&stations[k]);
    // It is one if in some direction none is farther; between its neighbours' normals, such as its own.
    let mut spans: Vec<f64> = Vec::new();
    for (other, station) in stations.iter().enumerate() {
        if other != k {
            let [x, y] = tip(station);
            spans.push((y - own[1]).atan2(x - own[0]));
        }
    }
    spans.sort_by(f64::total_cmp);
    let gap = |i: usize| {
        let next = if i + 1 == spans.len() {
            spans[0] + TAU
        } else {
            spans[i + 1]
        };
        next - spans[i]
    };
    (0..spans.len()).any(|i| gap(i) > 0.5 * TAU + FLAT)
}

impl Robot {
    /// Leg `k` as it differs from the robot's leg.
    pub fn own_leg(&self, k: usize) -> Leg {
        let mut leg = self.leg.clone();
        let factors = self.space.as_ref().and_then(|space| space.legs.get(k));
        let Some(factors) = factors else {
            return leg;
        };
        leg.delay *= factors.delay;
        leg.closing_delay = leg.closing_delay.map(|delay| delay * factors.delay);
        leg.viscous_friction *= factors.friction;
        leg.coulomb_friction *= factors.friction;
        match &mut leg.drive {
            Drive::Pneumatic(cylinder) => {
                cylinder.supply = GaugePressure(cylinder.supply.0 * factors.force);
            }
            Drive::Spring { stiffness, .. } => *stiffness *= factors.force,
            Drive::Constant { force } => *force *= factors.force,
            Drive::Table(table) => {
                for force in &mut table.forces {
                    *force *= factors.force;
                }
            }
        }
        leg
    }
}

pub(crate) fn dot(a: &Vector, b: &Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn norm(a: &Vector) -> f64 {
    dot(a, a).sqrt()
}

pub(crate) fn minus(a: &Vector, b: &Vector) -> Vector {
    std::array::from_fn(|k| a[k] - b[k])
}

fn cross(a: &Vector, b: &Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}
