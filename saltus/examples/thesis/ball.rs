//! Chapter 7: the geometry of the robot with twelve legs, figures 7.1 to 7.5.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::fmt::Write;

use saltus::chart::{COLORS, Chart, Ink};
use saltus::gait::space::Facing;

use saltus::robot::space::{Directions, Rest, Station, discs, rests};

use crate::{Outcome, Section, claim};

type Vector = [f64; 3];

const BLACK: Ink<'_> = Ink::Solid("#333");
const RED: Ink<'_> = Ink::Solid(COLORS[1]);
const QUIET: Ink<'_> = Ink::Faint("#333");
/// Length of a leg (m), its foot left out, and radius of the ball that is drawn between the legs.
const LEG: f64 = 0.24;
const HUB: f64 = 0.1;
/// Lean (rad) at which the active zone begins, and a firing angle in it.
const ZONE: f64 = -0.3;
const FIRES: f64 = 0.5;

/// The robot at rest, with the names that the thesis gives its legs.
struct Standing {
    directions: Vec<Vector>,
    rests: Vec<Rest>,
    discs: usize,
    /// Along the heading, to its left, up: in the body's axes.
    axes: [Vector; 3],
    /// Stations from leg 1 on, and what the thesis calls them.
    stations: Vec<(Station, &'static str)>,
    /// How far (rad) leg 1 leans back.
    lean: f64,
    ways: usize,
}

fn dot(a: &Vector, b: &Vector) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn cross(a: &Vector, b: &Vector) -> Vector {
    std::array::from_fn(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        a[i] * b[j] - a[j] * b[i]
    })
}

impl Standing {
    /// On the first rest, headed so that leg 1 stands behind and the twins 2 and 3 ahead.
    fn new() -> Outcome<Standing> {
        let directions = Directions::Dodecahedron.vectors();
        let (rests, discs) = (rests(&directions), discs(&directions));
        let rest = rests[0].clone();
        let ways = Facing::all(&rest, &discs);
        for way in &ways {
            let disc = way.disc();
            let ahead = cross(&rest.down, &disc.axis);
            let first = disc.stations.iter().position(|station| {
                let leg = &directions[station.legs[0]];
                station.legs.len() == 1
                    && rest.legs.contains(&station.legs[0])
                    && dot(leg, &ahead) < 0.0
            });
            if let Some(first) = first {
                let mut stations = disc.stations.clone();
                stations.rotate_left(first);
                let leg = directions[stations[0].legs[0]];
                let names = ["1", "2-3", "4", "5", "6-7", "8"];
                return Ok(Standing {
                    axes: [ahead, disc.axis, rest.down.map(|x| -x)],
                    stations: stations.into_iter().zip(names).collect(),
                    lean: dot(&leg, &ahead).abs().atan2(dot(&leg, &rest.down)),
                    directions,
                    discs: discs.len(),
                    ways: ways.len(),
                    rests,
                });
            }
        }
        Err("no way from the first rest has leg 1 behind".into())
    }

    /// A vector of the body's axes along the heading, to its left and up.
    fn in_world(&self, v: &Vector) -> Vector {
        std::array::from_fn(|k| dot(&self.axes[k], v))
    }

    /// Angle (rad) from station `k` to the one after it.
    fn gap(&self, k: usize) -> f64 {
        let at = |k: usize| self.stations[k % self.stations.len()].0.angle;
        (at(k + 1) - at(k)).rem_euclid(TAU)
    }

    /// Height (m) of the middle.
    fn height(&self) -> f64 {
        LEG * self.rests[0].height
    }

    /// What the thesis calls leg `leg`, and whether it is a twin; none for a leg that is not used.
    fn name(&self, leg: usize) -> Option<(&'static str, bool)> {
        let mut all = self.stations.iter();
        let (station, name) = all.find(|(station, _)| station.legs.contains(&leg))?;
        Some((name, station.legs.len() > 1))
    }
}

/// Looks along `yaw` (rad) from the heading and down by `pitch` (rad): where a place of the world is in the picture, and how
/// near.
fn seen([x, y, z]: Vector, yaw: f64, pitch: f64) -> (f64, f64, f64) {
    let (away, right) = (x * yaw.cos() + y * yaw.sin(), x * yaw.sin() - y * yaw.cos());
    let up = z * pitch.cos() + away * pitch.sin();
    (right, up, z * pitch.sin() - away * pitch.cos())
}

fn ring(points: impl Fn(f64) -> (f64, f64), from: f64, to: f64) -> Vec<(f64, f64)> {
    (0..=60_i32)
        .map(|k| points(from + (to - from) * f64::from(k) / 60.0))
        .collect()
}

fn circle(radius: f64) -> Vec<(f64, f64)> {
    ring(|a| (radius * a.cos(), radius * a.sin()), 0.0, TAU)
}

/// Figure 7.1: the faces, each with its leg.
fn dodecahedron(standing: &Standing) -> String {
    let (yaw, pitch) = (0.5, 0.3);
    let mut chart = Chart::to_scale(520.0, ("(m)", (-0.42, 0.42)), ("(m)", (-0.36, 0.36)));
    let at = |v: &Vector, far: f64| seen(standing.in_world(v).map(|x| far * x), yaw, pitch);
    // A corner lies where three faces meet, whose legs stand together on one rest.
    let corner = 0.5 * LEG / standing.rests[0].height;
    for (k, a) in standing.rests.iter().enumerate() {
        for b in &standing.rests[k + 1..] {
            let both: Vec<&usize> = a.legs.iter().filter(|leg| b.legs.contains(leg)).collect();
            if both.len() == 2 {
                let is_seen = both
                    .iter()
                    .any(|leg| at(&standing.directions[**leg], 1.0).2 > 0.0);
                let ends = [&a.down, &b.down]
                    .map(|v| at(v, corner))
                    .map(|(x, y, _)| (x, y));
                chart.line(if is_seen { BLACK } else { QUIET }, &ends);
            }
        }
    }
    for (leg, direction) in standing.directions.iter().enumerate() {
        let [from, to] = [0.5 * LEG, LEG].map(|far| at(direction, far));
        let ink = if to.2 > 0.0 {
            RED
        } else {
            Ink::Faint(COLORS[1])
        };
        chart.line(ink, &[(from.0, from.1), (to.0, to.1)]);
        chart.text(ink, (1.12 * to.0, 1.12 * to.1 - 0.008), &leg.to_string());
    }
    chart.file()
}

/// Legs, hub and feet of the robot as it stands, seen from `yaw` and `pitch`, with their names.
fn robot(chart: &mut Chart, standing: &Standing, (yaw, pitch): (f64, f64), across: f64) {
    let height = standing.height();
    let at = |[x, y, z]: Vector| {
        let (right, up, _) = seen([x, y, z + height], yaw, pitch);
        (right + across, up)
    };
    let (x, y) = at([0.0; 3]);
    let hub: Vec<(f64, f64)> = circle(HUB)
        .into_iter()
        .map(|(a, b)| (a + x, b + y))
        .collect();
    chart.line(QUIET, &hub);
    for (leg, direction) in standing.directions.iter().enumerate() {
        let world = standing.in_world(direction);
        let [from, to, name] = [HUB, LEG, 1.13 * LEG].map(|far| at(world.map(|x| far * x)));
        let ink = match standing.name(leg) {
            Some((_, false)) => BLACK,
            Some((_, true)) => RED,
            None => QUIET,
        };
        chart.line(ink, &[from, to]);
        chart.dots(ink, &[to]);
        if let Some((named, _)) = standing.name(leg) {
            chart.text(ink, (name.0, name.1 - 0.008), named);
        }
    }
}

/// Figure 7.2: the robot on its three feet.
fn at_rest(standing: &Standing) -> String {
    let (yaw, pitch) = (0.9, 0.35);
    let mut chart = Chart::to_scale(520.0, ("(m)", (-0.4, 0.4)), ("(m)", (-0.2, 0.46)));
    let ground = |x: f64, y: f64| {
        let (right, up, _) = seen([x, y, 0.0], yaw, pitch);
        (right, up)
    };
    for k in -2..=2 {
        let c = 0.1 * f64::from(k);
        chart.line(QUIET, &[ground(c, -0.2), ground(c, 0.2)]);
        chart.line(QUIET, &[ground(-0.2, c), ground(0.2, c)]);
    }
    let mut feet: Vec<(f64, f64)> = standing.rests[0]
        .legs
        .iter()
        .map(|leg| standing.in_world(&standing.directions[*leg]))
        .map(|[x, y, _]| ground(LEG * x, LEG * y))
        .collect();
    feet.push(feet[0]);
    chart.line(Ink::Dotted(COLORS[0]), &feet);
    robot(&mut chart, standing, (yaw, pitch), 0.0);
    chart.key(Ink::Solid(COLORS[0]), "the triangle of its feet");
    chart.file()
}

/// Figure 7.3: the plane of the disc from behind, and from its right.
fn disc_plane(standing: &Standing) -> String {
    let mut chart = Chart::to_scale(760.0, ("(m)", (-0.4, 1.1)), ("(m)", (-0.13, 0.56)));
    chart.line(QUIET, &[(-0.4, 0.0), (1.1, 0.0)]);
    robot(&mut chart, standing, (0.0, 0.0), 0.0);
    robot(&mut chart, standing, (FRAC_PI_2, 0.0), 0.7);
    let middle = standing.height();
    // The plane is seen edge on, then as a disc.
    chart.line(
        Ink::Solid(COLORS[0]),
        &[(0.0, middle - LEG), (0.0, middle + LEG)],
    );
    let disc: Vec<(f64, f64)> = circle(LEG)
        .into_iter()
        .map(|(x, y)| (x + 0.7, y + middle))
        .collect();
    chart.line(Ink::Solid(COLORS[0]), &disc);
    chart.line(Ink::Dotted(COLORS[2]), &[(-0.3, middle), (0.3, middle)]);
    let arrow = [
        (0.95, 0.1),
        (1.05, 0.1),
        (1.03, 0.11),
        (1.05, 0.1),
        (1.03, 0.09),
    ];
    chart.line(Ink::Solid(COLORS[2]), &arrow);
    chart.text(BLACK, (0.0, -0.1), "(a) along the heading, with the axis");
    chart.text(BLACK, (0.7, -0.1), "(b) from the right, with the heading");
    chart.key(Ink::Solid(COLORS[0]), "plane of the disc");
    chart.key(RED, "twins");
    chart.key(BLACK, "legs in the plane");
    chart.file()
}

/// A place (m) that leans back by `lean` (rad) from straight down, `far` (m) from the middle.
fn leans(lean: f64, far: f64) -> (f64, f64) {
    (-far * lean.sin(), -far * lean.cos())
}

/// The wheel that the legs make in the plane, with the first station at a lean of `lean` (rad).
fn wheel(chart: &mut Chart, standing: &Standing, lean: f64) {
    chart.line(QUIET, &circle(LEG));
    for (station, name) in &standing.stations {
        // A station that comes later is still ahead.
        let at = lean - (station.angle - standing.stations[0].0.angle);
        let ink = if station.legs.len() > 1 { RED } else { BLACK };
        chart.line(ink, &[(0.0, 0.0), leans(at, station.reach * LEG)]);
        chart.dots(ink, &[leans(at, station.reach * LEG)]);
        let (x, y) = leans(at, 1.15 * LEG);
        chart.text(ink, (x, y - 0.008), name);
    }
}

/// Figure 7.4: the legs in the plane, with the angles between them.
fn projection(standing: &Standing) -> String {
    let mut chart = Chart::to_scale(520.0, ("(m)", (-0.4, 0.4)), ("(m)", (-0.34, 0.34)));
    wheel(&mut chart, standing, standing.lean);
    let mut lean = standing.lean;
    for k in 0..standing.stations.len() {
        let gap = standing.gap(k);
        chart.line(
            Ink::Faint(COLORS[0]),
            &ring(|a| leans(a, 0.3 * LEG), lean, lean - gap),
        );
        let (x, y) = leans(lean - 0.5 * gap, 0.48 * LEG);
        chart.text(
            Ink::Solid(COLORS[0]),
            (x, y - 0.008),
            &format!("{:.1}°", gap.to_degrees()),
        );
        lean -= gap;
    }
    chart.key(RED, "twins, as long as they reach in the plane");
    chart.file()
}

/// Figure 7.5: the active zone as leg 1 leans in it by the firing angle, and how far it reaches for each leg.
fn active_zone(standing: &Standing) -> String {
    let mut chart = Chart::to_scale(520.0, ("(m)", (-0.4, 0.4)), ("(m)", (-0.34, 0.34)));
    wheel(&mut chart, standing, FIRES);
    for (k, color, far) in [(0, COLORS[0], 0.55), (5, COLORS[2], 0.45)] {
        let gap = standing.gap(k);
        let mut wedge = vec![(0.0, 0.0)];
        wedge.extend(ring(|lean| leans(lean, far * LEG), ZONE, ZONE + gap));
        wedge.push((0.0, 0.0));
        chart.line(Ink::Solid(color), &wedge);
        let name = if k == 0 {
            "active zone of 1, 2-3, 5 and 6-7"
        } else {
            "active zone of 4 and 8"
        };
        chart.key(
            Ink::Solid(color),
            &format!("{name}, {:.1}°", gap.to_degrees()),
        );
    }
    chart.line(Ink::Dotted("#333"), &[(0.0, 0.0), leans(0.0, 1.25 * LEG)]);
    let (x, y) = leans(0.5 * FIRES, 0.75 * LEG);
    chart.text(BLACK, (x, y), "α_f");
    chart.line(
        Ink::Dotted("#333"),
        &ring(|lean| leans(lean, 0.65 * LEG), 0.0, FIRES),
    );
    chart.file()
}

/// Holds the numbers of the chapter against those of the program.
fn check(standing: &Standing) -> Outcome<()> {
    let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
    let neighbour = (1.0 / 5.0_f64.sqrt()).acos();
    let nearest = standing.directions[1..]
        .iter()
        .map(|leg| dot(leg, &standing.directions[0]));
    let nearest = nearest.fold(-1.0, f64::max).acos();
    claim(
        near(nearest, neighbour),
        "neighbours are arccos(1/√5) apart",
    )?;
    let gaps: Vec<f64> = (0..6).map(|k| standing.gap(k)).collect();
    let twin = FRAC_PI_2 - 0.5 * neighbour;
    let wanted = [twin, twin, neighbour, twin, twin, neighbour];
    claim(
        gaps.iter().zip(wanted).all(|(a, b)| near(*a, b)),
        "the angles of figure 7.4",
    )?;
    claim(
        standing.rests.len() == 20 && standing.discs == 15 && standing.ways == 6,
        "20 rests, 15 planes, six ways",
    )
}

/// The numbers of the chapter as rows of a table.
fn rows(standing: &Standing) -> Outcome<String> {
    let side = {
        let [a, b] = [0, 1].map(|k| standing.directions[standing.rests[0].legs[k]]);
        LEG * (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
    };
    let neighbour = standing.gap(2);
    let mut rows = String::new();
    for (what, thesis, ours) in [
        (
            "angle between neighbours",
            "63.43°".to_owned(),
            format!("{:.3}°", neighbour.to_degrees()),
        ),
        (
            "dihedral angle",
            "116.6°".to_owned(),
            format!("{:.3}°", (PI - neighbour).to_degrees()),
        ),
        (
            "angles in the plane (figure 7.4)",
            "≈ 58.3°, ≈ 63.4°".to_owned(),
            format!(
                "{:.3}° beside twins, {:.3}°",
                standing.gap(0).to_degrees(),
                neighbour.to_degrees()
            ),
        ),
        (
            "reach of twins in the plane",
            "shorter".to_owned(),
            format!("{:.4} of a leg", standing.stations[1].0.reach),
        ),
        (
            "triangle of the feet",
            "equilateral".to_owned(),
            format!("sides of {side:.5} m, for feet without a radius"),
        ),
        (
            "height of the middle at rest",
            "–".to_owned(),
            format!("{:.5} m", standing.height()),
        ),
        (
            "lean of leg 1 at rest",
            "–".to_owned(),
            format!("{:.3}°", standing.lean.to_degrees()),
        ),
        (
            "ways to stand; planes; headings open at each rest",
            "–".to_owned(),
            format!(
                "{}; {}; {}",
                standing.rests.len(),
                standing.discs,
                standing.ways
            ),
        ),
    ] {
        writeln!(rows, "| {what} | {thesis} | {ours} |")?;
    }
    Ok(rows)
}

pub(crate) fn section() -> Outcome<Section> {
    let standing = Standing::new()?;
    check(&standing)?;
    let rows = rows(&standing)?;
    let text = format!(
        "## Twelve legs (7.1, 7.2, figures 7.1 to 7.5)\n\nThe robot of chapter 7 has a leg at each face of a dodecahedron. \
         [space.md](space.md) describes the robot `rats-twelve` and what Saltus makes of it. The figures are drawn from the \
         program's own geometry.\n\n| | thesis | Saltus |\n| --- | --- | --- |\n{rows}\nThe thesis gives the angle between \
         neighbours as π − 2 arccos(−1/√5). That is less than 0; its 63.43° is π − arccos(−1/√5).\n\n![A leg at each face of a \
         dodecahedron](thesis/dodecahedron.svg)\n\nFigure 7.1: the faces and the legs, with their numbers in Saltus.\n\n![The \
         robot on three feet](thesis/ball-at-rest.svg)\n\nFigure 7.2: the robot at rest. Legs have the numbers of the thesis; \
         the four grey ones are not used.\n\n![The plane of the disc](thesis/disc-plane.svg)\n\nFigure 7.3: the plane in which it \
         rolls.\n\n![The legs in the plane](thesis/disc-projection.svg)\n\nFigure 7.4: the eight legs in the plane make a wheel of \
         six.\n\n![The active zone](thesis/active-zone.svg)\n\nFigure 7.5: the active zone begins at a lean of {ZONE} rad here; the \
         thesis gives no number. It ends where the next leg enters it, so that its width changes with the leg. The leg in it fires \
         at α_f.\n"
    );
    Ok(Section {
        text: text.replace("of -0.3 rad", "of −0.3 rad"),
        drawings: vec![
            ("dodecahedron.svg", dodecahedron(&standing)),
            ("ball-at-rest.svg", at_rest(&standing)),
            ("disc-plane.svg", disc_plane(&standing)),
            ("disc-projection.svg", projection(&standing)),
            ("active-zone.svg", active_zone(&standing)),
        ],
    })
}
