//! What can be wrong with a machine, from its description.

use super::guesses::Likely;
use super::plant::{Change, guess};
use super::sizes::Sizes;
use super::{is_angle, named};
use crate::kind::{Cause, Channel, Data, Terms};
use crate::kinds::{Causes, FREE, causes, delay, faults, gain, offset, share, simple, unknown};
use crate::mechanism::{Inertia, Joint, Link, Mechanism, Shows};

/// What a cause does, with the index of its link, joint, spring, drive or channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Effect {
    /// Inertia about the centre, which nobody knows.
    Unknown(usize),
    Inertia(usize),
    Mass(usize),
    Center(usize),
    Counterweight(usize),
    Dry(usize),
    Viscous(usize),
    Drag(usize),
    Stiffness(usize),
    Spring(usize),
    Slope,
    /// Without a name.
    Second(usize),
}

/// The causes of a machine.
pub(super) struct All {
    /// What nobody knows, and is the same in all runs.
    pub(super) common: Vec<(Option<Effect>, Cause)>,
    /// Those that have a name.
    pub(super) named: Vec<(Option<Effect>, Cause)>,
    /// Terms without a name.
    pub(super) terms: Vec<(Option<Effect>, Cause)>,
}

/// The causes of a machine; indices are those of `mechanism`.
pub(super) fn of(
    mechanism: &Mechanism,
    sizes: &Sizes,
    channels: &[Channel],
    likely: &Likely,
) -> All {
    let mut all = All {
        common: Vec::new(),
        named: Vec::new(),
        terms: Vec::new(),
    };
    for (k, link) in mechanism.links.iter().enumerate() {
        if has_unknown_inertia(mechanism, k) {
            let (rod, name) = (guess(link), named(&link.name, "inertia_about_centre_kg_m2"));
            let first = likely.inertia[k].clamp(2e-3 * rod, 50.0 * rod);
            let bounds = (1e-3 * rod, 100.0 * rod);
            let cause = simple("inertia", &name, first, bounds, 0.05 * rod, &[]);
            all.common.push((Some(Effect::Unknown(k)), cause));
        }
        all.named.extend(of_link(mechanism, k, sizes));
    }
    for (k, link) in mechanism.links.iter().enumerate() {
        all.named.extend(of_joint(mechanism, k, sizes, likely));
        if link.joint.turns() && link.joint.parent.is_none() {
            let size = sizes.torque[k];
            let name = "torque in the first joint, -c sin(2 q)";
            let bounds = (-100.0 * size, 100.0 * size);
            let term = simple(name, "c_n_m", 0.0, bounds, 1e-3 * size, &[]);
            all.terms.push((Some(Effect::Second(k)), term));
        }
    }
    if is_slope_seen(mechanism) {
        let (name, starts) = ("slope_rad", [-0.05, 0.05]);
        let slope = simple("ground-slope", name, 0.0, (-0.5, 0.5), 1e-3, &starts);
        all.named.push((Some(Effect::Slope), slope));
    }
    for channel in channels {
        let column = channel.name.as_str();
        let unit = if is_angle(column) { "rad" } else { "m" };
        let faults = faults([
            offset(column, unit, (-1.0, 1.0), 1e-3),
            gain(column),
            delay(column, 0.5, 1e-3),
        ]);
        all.named.extend(faults);
    }
    for drive in &mechanism.drives {
        let turns = mechanism.links[drive.joint].joint.turns();
        let (column, size) = (&drive.column, sizes.torque[drive.joint]);
        let unit = if turns { "nm" } else { "n" };
        let faults = faults([
            offset(column, unit, FREE, 1e-3 * size),
            gain(column),
            delay(column, 0.5, 1e-3),
        ]);
        all.named.extend(faults);
    }
    all
}

/// Whether the inertia of a link about its centre counts and nobody knows it.
pub(super) fn has_unknown_inertia(mechanism: &Mechanism, k: usize) -> bool {
    mechanism.links[k].inertia == Inertia::Unknown
        && mechanism.links[k].mass > 0.0
        && turns_in_the_world(mechanism, k)
}

/// Whether a link turns at all.
fn turns_in_the_world(mechanism: &Mechanism, k: usize) -> bool {
    mechanism
        .to_ground(k)
        .any(|own| mechanism.links[own].joint.turns())
}

/// Whether a slope of the ground does anything that an offset of a sensor does not: the machine then
/// does not hang on one joint that turns, or more than one column says where that is.
fn is_slope_seen(mechanism: &Mechanism) -> bool {
    let in_the_world = |shows: &Shows| match shows {
        Shows::Coordinate(k) => mechanism.links[*k].joint.parent.is_none(),
        Shows::Angle { .. } | Shows::Place { .. } => true,
    };
    let count = mechanism
        .gauges
        .iter()
        .filter(|gauge| in_the_world(&gauge.shows))
        .count();
    let roots = mechanism
        .links
        .iter()
        .filter(|link| link.joint.parent.is_none());
    mechanism.gravity > 0.0
        && (count > 1 || roots.clone().count() > 1 || roots.clone().any(|link| !link.joint.turns()))
}

/// Causes that are masses and where they are.
fn of_link(mechanism: &Mechanism, k: usize, sizes: &Sizes) -> Vec<(Option<Effect>, Cause)> {
    let link = &mechanism.links[k];
    let share = |id, name, scale| share(id, &named(&link.name, name), scale);
    let mut all = Vec::new();
    let turns = turns_in_the_world(mechanism, k);
    let is_driven = sizes.driven.iter().any(|x| *x != 0.0) || !mechanism.springs.is_empty();
    let is_known = link.inertia != Inertia::Unknown;
    if link.mass > 0.0 && (is_known || is_driven || mechanism.links.len() > 1) {
        let mass = share("mass", "mass_share", 0.02).usual(0.1, "links are weighed");
        all.push((Some(Effect::Mass(k)), mass));
        let [x, y] = link.center;
        let reach = x.hypot(y);
        if reach > 0.0 && turns {
            let (bounds, starts) = ((-20.0 * reach, 20.0 * reach), [-0.2 * reach, 0.2 * reach]);
            let name = named(&link.name, "imbalance_m");
            let cause = simple("imbalance", &name, 0.0, bounds, 0.01 * reach, &starts);
            all.push((Some(Effect::Center(k)), cause));
        }
    }
    if matches!(link.inertia, Inertia::Center(own) if own > 0.0) && turns {
        all.push((
            Some(Effect::Inertia(k)),
            share("inertia", "inertia_share", 0.01),
        ));
    }
    if let Some(own) = &link.counterweight {
        let scale = 0.02 * own.mass.max(link.mass).max(1e-3);
        let most = 1000.0 * scale;
        let of = |name, low| unknown(&named(&own.name, name), own.mass, (low, most), scale);
        let parameters = vec![of("weight_kg", -most), of("inertia_kg", 0.0)];
        all.push((
            Some(Effect::Counterweight(k)),
            Cause::several("counterweight", parameters),
        ));
    }
    all
}

/// Causes that are in a joint.
fn of_joint(
    mechanism: &Mechanism,
    k: usize,
    sizes: &Sizes,
    likely: &Likely,
) -> Vec<(Option<Effect>, Cause)> {
    let joint = &mechanism.links[k].joint;
    let (size, rate) = (sizes.torque[k], sizes.rate(k));
    let of = |id, name: [&str; 2], neutral: f64, unit: f64, guess: f64| {
        let unit = size / unit;
        let name = named(&joint.name, name[usize::from(!joint.turns())]);
        let starts = [0.01 * unit, 0.1 * unit, guess];
        simple(id, &name, neutral, (0.0, 10.0 * unit), 0.01 * unit, &starts)
    };
    let dry = ["coulomb_friction_n_m", "coulomb_friction_n"];
    let viscous = [
        "viscous_friction_n_m_s_per_rad",
        "viscous_friction_n_s_per_m",
    ];
    let drag = ["drag_n_m_s2_per_rad2", "drag_n_s2_per_m2"];
    let (friction, damping) = (likely.friction[k], likely.damping[k]);
    let mut all = causes! {
        Effect::Dry(k) => of("coulomb-friction", dry, joint.friction, 1.0, friction);
        Effect::Viscous(k) => of("viscous-friction", viscous, joint.damping, rate, damping);
    };
    if joint.parent.is_none() {
        let unit = size / (rate * rate);
        let drag = of("air-drag", drag, 0.0, rate * rate, 0.03 * unit);
        all.push((Some(Effect::Drag(k)), drag));
    }
    let mut has_spring = false;
    for (s, spring) in mechanism
        .springs
        .iter()
        .enumerate()
        .filter(|(_, s)| s.joint == k)
    {
        has_spring = true;
        let mut name = named(&joint.name, "spring_share");
        if mechanism.springs[..s]
            .iter()
            .any(|other| other.joint == spring.joint)
        {
            name = format!("{name}_{}", s + 1);
        }
        let cause = simple("return-spring", &name, 1.0, (0.0, 20.0), 0.02, &[0.8, 1.25]);
        all.push((Some(Effect::Spring(s)), cause));
    }
    if !has_spring {
        let name = ["stiffness_n_m_per_rad", "stiffness_n_per_m"];
        let spring = of("return-spring", name, 0.0, 1.0, 0.03 * size);
        all.push((Some(Effect::Stiffness(k)), spring));
    }
    all
}

impl Change {
    /// What `terms` do to `mechanism`; indices of the causes are those of `first`, whose links and
    /// joints have the same names.
    pub(super) fn of(
        (first, mechanism): (&Mechanism, &Mechanism),
        causes: &Causes<Effect>,
        data: &Data,
        terms: &Terms,
    ) -> Change {
        let mut change = Change::none(mechanism);
        let same_link = |link: &Link| first.links.iter().position(|own| own.name == link.name);
        let same_joint = |joint: &Joint| {
            first
                .links
                .iter()
                .position(|own| own.joint.name == joint.name)
        };
        for (i, link) in mechanism.links.iter().enumerate() {
            if let Some(k) = same_link(link) {
                change.mass[i] = causes.or(Effect::Mass(k), 1.0, terms);
                change.beyond[i] = causes.or(Effect::Center(k), 0.0, terms);
                change.inertia[i] *= causes.or(Effect::Inertia(k), 1.0, terms);
                change.inertia[i] = causes.or(Effect::Unknown(k), change.inertia[i], terms);
            }
            if let Some(k) = same_joint(&link.joint) {
                let set = |to: &mut f64, effect| *to = causes.or(effect, *to, terms);
                set(&mut change.friction[i], Effect::Dry(k));
                set(&mut change.damping[i], Effect::Viscous(k));
                set(&mut change.drag[i], Effect::Drag(k));
                set(&mut change.stiffness[i], Effect::Stiffness(k));
                set(&mut change.second[i], Effect::Second(k));
            }
            let name = link.counterweight.as_ref().map(|own| &own.name);
            let same = first.links.iter().position(|own| {
                name.is_some() && own.counterweight.as_ref().map(|c| &c.name) == name
            });
            if let Some(k) = same {
                for (p, to) in change.counterweight[i].iter_mut().enumerate() {
                    *to = causes
                        .get(Effect::Counterweight(k), p, terms)
                        .unwrap_or(*to);
                }
            }
        }
        for (s, share) in change.springs.iter_mut().enumerate() {
            *share = causes.or(Effect::Spring(s), 1.0, terms);
        }
        for (sensor, drive) in change.drives.iter_mut().zip(&mechanism.drives) {
            *sensor = data.sensor(&drive.column, terms);
        }
        change.slope = causes.or(Effect::Slope, 0.0, terms);
        change
    }
}
