//! The causes that have a name.

use saltus_robot::{Term, terms};

/// Ids of the causes that are not a term of a robot file, each with what is so in the machine and
/// not in the simulation.
const OTHERS: [(&str, &str); 8] = [
    (
        "supply-pressure",
        "the supply pressure differs from the set value",
    ),
    ("gas-type", "the gas is another one"),
    (
        "directional-friction",
        "dry friction differs by direction, as with a constant force beside it",
    ),
    ("imbalance", "the centre of mass is off the axle"),
    ("foot-slip", "the foot slips on the ground"),
    ("encoder-scale", "the sensor's scale is wrong"),
    ("sensor-offset", "the sensor's zero is off"),
    ("sensor-delay", "the sensor reports late"),
];

/// Ids of the named causes, each with what is so in the machine and not in the simulation.
pub fn named() -> impl Iterator<Item = (&'static str, &'static str)> {
    let causes = Term::ALL.iter().filter_map(|term| term.spec().cause);
    let of_terms = causes.map(|cause| (cause.id, cause.sentence));
    of_terms
        .filter(|(_, sentence)| !sentence.is_empty())
        .chain(OTHERS)
}

/// What the cause `id` means in the form that has the parameter `key`; none for a term that stands
/// for something unknown.
pub(crate) fn meaning_of(id: &str, key: &str) -> Option<&'static str> {
    let specs = Term::ALL.iter().map(|term| term.spec());
    let is_form = |cause: &terms::Cause| cause.id == id && !cause.sentence.is_empty();
    specs
        .filter(|spec| key.starts_with(spec.key))
        .find_map(|spec| spec.cause.filter(is_form))
        .map(|cause| cause.sentence)
        .or_else(|| meaning(id))
}

/// What the cause `id` means; none for a term that stands for something unknown.
pub fn meaning(id: &str) -> Option<&'static str> {
    named()
        .find(|(name, _)| *name == id)
        .map(|(_, sentence)| sentence)
}
