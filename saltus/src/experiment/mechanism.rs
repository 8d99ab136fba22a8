//! The file that describes a machine: links in a plane, what is in their joints, what is measured.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use saltus_diagnosis::mechanism::{
    Counterweight, Drive, Gauge, Inertia, Joint, Law, Link, Mechanism, Shows, Side, Spring, Way,
};
use saltus_robot::RobotError;
use saltus_robot::domain::Domain;
use saltus_robot::section::Section;
use saltus_robot::units::{
    ACCELERATION, ANGLE, ANGULAR_STIFFNESS, DAMPING, FORCE, INERTIA, LENGTH, MASS, NUMBER,
    Quantity, STIFFNESS, TORQUE, Unit,
};

use super::error::{Error, one_line, shown};

/// Most links of a machine.
const MOST_LINKS: usize = saltus_sim_check::chain::MOST;
/// Most springs, drives and columns.
const MOST_PARTS: usize = 64;
/// What the first link hangs on.
const GROUND: &str = "ground";
/// Gravity (m/s²) where nobody says otherwise.
const GRAVITY: f64 = 9.806_65;

/// A damping whose names end in `_n_m_s_per_rad`.
const TURNING: Quantity = Quantity {
    si: "N m s/rad",
    dimension: [1, 2, -1],
    units: &[("_n_m_s_per_rad", Unit::SI)],
};
const MASSES: Domain = Domain::NON_NEGATIVE.up_to(1e6).called("a mass");
const INERTIAS: Domain = Domain::NON_NEGATIVE.up_to(1e9).called("an inertia");
const FRICTIONS: Domain = Domain::NON_NEGATIVE.up_to(1e6).called("a friction");
const STIFFNESSES: Domain = Domain::NON_NEGATIVE.up_to(1e9).called("a stiffness");

/// The machine that the file `name` in `folder` describes, and its text.
pub(super) fn read(folder: &Path, name: &str) -> Result<(Mechanism, String), Error> {
    let path = folder.join(name);
    let text = fs::read_to_string(&path).map_err(|error| Error::read(&path, error))?;
    Ok((parse(&text, &shown(&path), name)?, text))
}

/// What `text` says, which messages call `file`.
fn parse(text: &str, file: &str, name: &str) -> Result<Mechanism, Error> {
    let mut root = Section::file(text, file)?;
    root.check_keys(&[
        "gravity_m_s2",
        "gravity_g",
        "link",
        "spring",
        "drive",
        "measured",
    ])?;
    let gravity = root.optional("gravity", ACCELERATION, Domain::NON_NEGATIVE.up_to(100.0));
    let tables = root.tables("link", MOST_LINKS);
    if tables.is_empty() {
        root.missing(&["link"], "a table [[link]] for each link");
    }
    root.stop_at_problem()?;
    let links = links(tables, file)?;
    let known = Names { links: &links };
    let springs = known.each(root.tables("spring", MOST_PARTS), Names::spring)?;
    let drives = known.each(root.tables("drive", MOST_PARTS), Names::drive)?;
    let measured = root.tables("measured", MOST_PARTS);
    if measured.is_empty() {
        root.missing(
            &["measured"],
            "a table [[measured]] for each column that shows the machine",
        );
    }
    root.stop_at_problem()?;
    let gauges = known.each(measured, Names::gauge)?;
    root.finish(())?;
    Ok(Mechanism {
        name: one_line(name),
        gravity: gravity.unwrap_or(GRAVITY),
        links,
        springs,
        drives,
        gauges,
    })
}

/// A link as the file has it, before it is known where its parent stands.
struct Listed {
    name: String,
    parent: Option<usize>,
    place: String,
    section: Section,
}

/// The links, each after its parent.
fn links(mut tables: Vec<Section>, file: &str) -> Result<Vec<Link>, Error> {
    let mut names: Vec<String> = Vec::new();
    for table in &mut tables {
        let allowed = "a name in quotes that no other link has, and not \"ground\"";
        let is_new = |text: &str| {
            let is_new = !text.is_empty() && text != GROUND && !names.iter().any(|n| n == text);
            is_new.then(|| text.to_owned())
        };
        let name = table.text_as("name", allowed, is_new);
        table.stop_at_problem()?;
        names.extend(name);
    }
    let mut listed = Vec::new();
    for (mut section, name) in tables.into_iter().zip(&names) {
        let known = names
            .iter()
            .filter(|other| *other != name)
            .map(String::as_str);
        let known: Vec<&str> = [GROUND].into_iter().chain(known).collect();
        let allowed = format!(
            "the link that carries it, or the ground: one of {}",
            known.join(", ")
        );
        let parent = section.text_as("parent", &allowed, |text| {
            known
                .contains(&text)
                .then(|| names.iter().position(|name| name == text))
        });
        section.stop_at_problem()?;
        listed.push(Listed {
            name: name.clone(),
            parent: parent.flatten(),
            place: section.place().to_string(),
            section,
        });
    }
    let order = ordered(&listed, file)?;
    let mut links: Vec<Link> = Vec::new();
    let mut sections: Vec<Option<Listed>> = listed.into_iter().map(Some).collect();
    let mut places = Vec::new();
    for &k in &order {
        if let Some(own) = sections[k].take() {
            let parent = own
                .parent
                .and_then(|p| order.iter().position(|other| *other == p));
            places.push(own.place.clone());
            links.push(link(own.section, own.name, parent)?);
        }
    }
    weighed(&links, &places)?;
    Ok(links)
}

/// The links in an order in which each comes after its parent.
fn ordered(listed: &[Listed], file: &str) -> Result<Vec<usize>, Error> {
    let mut order: Vec<usize> = Vec::new();
    loop {
        let is_next = |k: &usize| {
            !order.contains(k)
                && listed[*k]
                    .parent
                    .is_none_or(|parent| order.contains(&parent))
        };
        let Some(next) = (0..listed.len()).find(is_next) else {
            break;
        };
        order.push(next);
    }
    let Some(lost) = (0..listed.len()).find(|k| !order.contains(k)) else {
        return Ok(order);
    };
    if order.is_empty() && listed.iter().all(|own| own.parent.is_some()) {
        let reason = "no link hangs on the ground: one must have parent = \"ground\"";
        return Err(Error::content(file, reason));
    }
    // From a link that does not lead to the ground on, in a circle.
    let mut way = vec![lost];
    while let Some(parent) = listed[way[way.len() - 1]].parent {
        if let Some(from) = way.iter().position(|k| *k == parent) {
            way.drain(..from);
            way.push(parent);
            break;
        }
        way.push(parent);
    }
    let names: Vec<&str> = way.iter().map(|k| listed[*k].name.as_str()).collect();
    Err(Error::Value {
        place: listed[way[0]].place.clone(),
        name: format!("link {}.parent", way[0] + 1),
        value: format!("{:?}", names[1]),
        allowed: format!(
            "a link that does not hang on this one: {} goes round in a circle",
            names.join(" on ")
        ),
    })
}

/// Refuses links without mass that carry none with one.
fn weighed(links: &[Link], places: &[String]) -> Result<(), Error> {
    let is_heavy = |link: &Link| {
        link.mass > 0.0
            || link
                .counterweight
                .as_ref()
                .is_some_and(|own| own.mass > 0.0)
    };
    let leads = |from: usize, to: usize| {
        std::iter::successors(Some(from), |k| links[*k].joint.parent).any(|k| k == to)
    };
    for (k, own) in links.iter().enumerate() {
        let carries = (0..links.len()).any(|outer| leads(outer, k) && is_heavy(&links[outer]));
        if !carries {
            return Err(Error::Value {
                place: places[k].clone(),
                name: format!("mass_kg of link {:?}", own.name),
                value: "0".into(),
                allowed: "above 0, as it carries no link that has a mass".into(),
            });
        }
    }
    Ok(())
}

/// One link.
fn link(mut s: Section, name: String, parent: Option<usize>) -> Result<Link, RobotError> {
    const JOINTS: [(&str, bool); 2] = [("turns", true), ("slides", false)];
    let turns = s.choice("joint", &JOINTS, "\"turns\" or \"slides\"");
    let way = if turns {
        Way::Turns {
            back: is_back(&mut s),
        }
    } else {
        Way::Slides(along(&mut s))
    };
    let joint_name = if s.has("joint_name") {
        s.text("joint_name")
    } else {
        name.clone()
    };
    let (friction, damping) = if turns {
        (
            s.optional("coulomb_friction", TORQUE, FRICTIONS),
            s.optional("viscous_friction", TURNING, FRICTIONS),
        )
    } else {
        (
            s.optional("coulomb_friction", FORCE, FRICTIONS),
            s.optional("viscous_friction", DAMPING, FRICTIONS),
        )
    };
    let inertia = s.optional("inertia", INERTIA, INERTIAS);
    let carried = s.optional("counterweight", MASS, MASSES);
    let carried_at = s.array("counterweight_at", LENGTH);
    if carried.is_some() && carried_at.is_none() {
        s.missing(&["counterweight_at_m"], "a list of two numbers");
    } else if carried.is_none() && carried_at.is_some() {
        s.missing(&["counterweight_kg"], "the mass that hangs there");
    }
    let link = Link {
        joint: Joint {
            name: joint_name,
            parent,
            way,
            at: s.array("at", LENGTH).unwrap_or_default(),
            angle: s
                .optional("angle", ANGLE, Domain::within(10.0))
                .unwrap_or(0.0),
            friction: friction.unwrap_or(0.0),
            damping: damping.unwrap_or(0.0),
        },
        mass: s.number("mass", MASS, MASSES),
        center: s.array("centre", LENGTH).unwrap_or_default(),
        inertia: inertia.map_or(Inertia::Unknown, Inertia::Center),
        counterweight: carried.zip(carried_at).map(|(mass, at)| Counterweight {
            name: name.clone(),
            at,
            mass,
        }),
        name,
    };
    s.finish(link)
}

/// Whether `positive` is `"back"`.
fn is_back(s: &mut Section) -> bool {
    s.has("positive")
        && s.choice(
            "positive",
            &[("forward", false), ("back", true)],
            "\"forward\" or \"back\"",
        )
}

/// The unit vector `along`.
fn along(s: &mut Section) -> [f64; 2] {
    let Some([x, y]) = s.array("along", NUMBER) else {
        s.missing(&["along"], "a direction forward and up, as in [1, 0]");
        return [1.0, 0.0];
    };
    let size = x.hypot(y);
    if size == 0.0 {
        s.missing(&["along"], "a direction that is not [0, 0]");
        return [1.0, 0.0];
    }
    [x / size, y / size]
}

/// The links by which other tables name them.
struct Names<'a> {
    links: &'a [Link],
}

impl Names<'_> {
    /// What `read` makes of each table.
    fn each<T>(
        &self,
        tables: Vec<Section>,
        read: fn(&Self, Section) -> Result<T, RobotError>,
    ) -> Result<Vec<T>, Error> {
        let all: Result<Vec<T>, RobotError> =
            tables.into_iter().map(|table| read(self, table)).collect();
        Ok(all?)
    }

    /// The link that `key` names.
    fn link(&self, s: &mut Section, key: &str) -> usize {
        let names: Vec<&str> = self.links.iter().map(|link| link.name.as_str()).collect();
        let allowed = format!("the name of a link: one of {}", names.join(", "));
        let named = s.text_as(key, &allowed, |text| {
            names.iter().position(|name| *name == text)
        });
        named.unwrap_or_default()
    }

    /// A column whose name has the unit `end`.
    fn column(s: &mut Section, end: &str) -> String {
        let allowed = format!("the name of a column in SI, which ends with {end}");
        let is_it = |text: &str| text.len() > end.len() && text.ends_with(end);
        let is_it = |text: &str| is_it(text).then(|| text.to_owned());
        s.text_as("column", &allowed, is_it).unwrap_or_default()
    }

    fn spring(&self, mut s: Section) -> Result<Spring, RobotError> {
        let joint = self.link(&mut s, "joint");
        // Its keys follow from how the joint moves.
        s.stop_at_problem()?;
        let turns = self.links[joint].joint.turns();
        let (place, force, stiffness) = if turns {
            (ANGLE, ("torque", TORQUE), ANGULAR_STIFFNESS)
        } else {
            (LENGTH, ("force", FORCE), STIFFNESS)
        };
        let is_table = place
            .units
            .iter()
            .any(|(end, _)| s.has(&format!("at{end}")));
        let law = if is_table {
            let places = s.list("at", place, Domain::FINITE);
            let forces = s.list(force.0, force.1, Domain::FINITE);
            s.stop_at_problem()?;
            let is_rising = places.len() > 1 && places.windows(2).all(|w| w[0] < w[1]);
            if !is_rising || places.len() != forces.len() {
                return Err(RobotError::NotAllowed {
                    place: s.place().clone(),
                    key: format!("at of the spring in {}", self.links[joint].name),
                    value: format!("{places:?} with {} of {}", forces.len(), force.0),
                    allowed: "two places at least, which rise, with a number for each".into(),
                });
            }
            Law::Table(
                places
                    .into_iter()
                    .zip(forces)
                    .map(|(x, f)| [x, f])
                    .collect(),
            )
        } else {
            const SIDES: [(&str, Side); 3] = [
                ("both", Side::Both),
                ("above", Side::Above),
                ("below", Side::Below),
            ];
            Law::Linear {
                stiffness: s.number("stiffness", stiffness, STIFFNESSES),
                from: s.optional("from", place, Domain::FINITE).unwrap_or(0.0),
                side: if s.has("acts") {
                    s.choice("acts", &SIDES, "\"both\", \"above\" or \"below\"")
                } else {
                    Side::Both
                },
            }
        };
        s.finish(Spring { joint, law })
    }

    fn drive(&self, mut s: Section) -> Result<Drive, RobotError> {
        let joint = self.link(&mut s, "joint");
        let end = if self.links[joint].joint.turns() {
            "_nm"
        } else {
            "_n"
        };
        let column = Names::column(&mut s, end);
        s.finish(Drive { column, joint })
    }

    fn gauge(&self, mut s: Section) -> Result<Gauge, RobotError> {
        #[derive(Clone, Copy)]
        enum What {
            Joint,
            Angle,
            Place(usize),
        }
        const WHAT: [(&str, What); 4] = [
            ("joint", What::Joint),
            ("angle", What::Angle),
            ("x", What::Place(0)),
            ("y", What::Place(1)),
        ];
        let link = self.link(&mut s, "link");
        let what = s.choice("shows", &WHAT, "\"joint\", \"angle\", \"x\" or \"y\"");
        let turns = self.links[link].joint.turns();
        let (shows, end) = match what {
            What::Joint => (Shows::Coordinate(link), if turns { "_rad" } else { "_m" }),
            What::Angle => (
                Shows::Angle {
                    link,
                    back: is_back(&mut s),
                },
                "_rad",
            ),
            What::Place(axis) => (
                Shows::Place {
                    link,
                    at: s.array("at", LENGTH).unwrap_or_default(),
                    axis,
                },
                "_m",
            ),
        };
        let column = Names::column(&mut s, end);
        s.finish(Gauge { column, shows })
    }
}

/// The file that describes `mechanism`.
pub(super) fn written(mechanism: &Mechanism) -> String {
    let mut text = format!("gravity_m_s2 = {:?}\n", mechanism.gravity);
    // Writing into a string does not fail.
    let _ = mechanism
        .links
        .iter()
        .try_for_each(|link| write_link(&mut text, mechanism, link));
    let _ = mechanism
        .springs
        .iter()
        .try_for_each(|s| write_spring(&mut text, mechanism, s));
    for Drive { column, joint } in &mechanism.drives {
        let joint = &mechanism.links[*joint].name;
        let _ = writeln!(text, "\n[[drive]]\ncolumn = {column:?}\njoint = {joint:?}");
    }
    for Gauge { column, shows } in &mechanism.gauges {
        let _ = writeln!(text, "\n[[measured]]\ncolumn = {column:?}");
        let name = |k: usize| &mechanism.links[k].name;
        let _ = match shows {
            Shows::Coordinate(k) => writeln!(text, "link = {:?}\nshows = \"joint\"", name(*k)),
            Shows::Angle { link, back } => {
                let end = if *back { "\npositive = \"back\"" } else { "" };
                writeln!(text, "link = {:?}\nshows = \"angle\"{end}", name(*link))
            }
            Shows::Place { link, at, axis } => {
                let axis = ["x", "y"][*axis];
                writeln!(
                    text,
                    "link = {:?}\nshows = {axis:?}\nat_m = {at:?}",
                    name(*link)
                )
            }
        };
    }
    text
}

fn write_link(text: &mut String, mechanism: &Mechanism, link: &Link) -> std::fmt::Result {
    let joint = &link.joint;
    let parent = joint.parent.map_or(GROUND, |k| &mechanism.links[k].name);
    writeln!(
        text,
        "\n[[link]]\nname = {:?}\nparent = {parent:?}",
        link.name
    )?;
    let (unit, per) = match joint.way {
        Way::Turns { back } => {
            writeln!(text, "joint = \"turns\"")?;
            if back {
                writeln!(text, "positive = \"back\"")?;
            }
            ("_n_m", "_n_m_s_per_rad")
        }
        Way::Slides(along) => {
            writeln!(text, "joint = \"slides\"\nalong = {along:?}")?;
            ("_n", "_n_s_per_m")
        }
    };
    if joint.name != link.name {
        writeln!(text, "joint_name = {:?}", joint.name)?;
    }
    writeln!(text, "at_m = {:?}\nangle_rad = {:?}", joint.at, joint.angle)?;
    writeln!(
        text,
        "mass_kg = {:?}\ncentre_m = {:?}",
        link.mass, link.center
    )?;
    if let Inertia::Center(inertia) = link.inertia {
        writeln!(text, "inertia_kg_m2 = {inertia:?}")?;
    }
    if let Some(Counterweight { at, mass, .. }) = &link.counterweight {
        writeln!(
            text,
            "counterweight_kg = {mass:?}\ncounterweight_at_m = {at:?}"
        )?;
    }
    writeln!(text, "coulomb_friction{unit} = {:?}", joint.friction)?;
    writeln!(text, "viscous_friction{per} = {:?}", joint.damping)
}

fn write_spring(text: &mut String, mechanism: &Mechanism, spring: &Spring) -> std::fmt::Result {
    let link = &mechanism.links[spring.joint];
    writeln!(text, "\n[[spring]]\njoint = {:?}", link.name)?;
    let [place, force, stiffness] = if link.joint.turns() {
        ["rad", "torque_n_m", "n_m_per_rad"]
    } else {
        ["m", "force_n", "n_per_m"]
    };
    match &spring.law {
        Law::Linear {
            stiffness: value,
            from,
            side,
        } => writeln!(
            text,
            "stiffness_{stiffness} = {value:?}\nfrom_{place} = {from:?}\nacts = \"{side}\""
        ),
        Law::Table(points) => {
            let [at, of] = [0, 1].map(|k| points.iter().map(|p| p[k]).collect::<Vec<_>>());
            writeln!(text, "at_{place} = {at:?}\n{force} = {of:?}")
        }
    }
}
