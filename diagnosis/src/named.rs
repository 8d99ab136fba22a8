//! The causes that have a name.

/// Ids of the named causes, each with what is so in the machine and not in the simulation.
pub const NAMED: [(&str, &str); 29] = [
    (
        "supply-pressure",
        "the supply pressure differs from the set value",
    ),
    (
        "supply-droop",
        "the supply pressure falls with the flow that is drawn",
    ),
    (
        "valve-delay",
        "the valve opens and closes later than commanded",
    ),
    ("valve-discharge", "the valve lets more or less gas through"),
    ("chamber-leak", "the chamber leaks to the atmosphere"),
    ("dead-volume", "the volume of the chamber at rest differs"),
    ("viscous-friction", "friction that grows with speed differs"),
    ("coulomb-friction", "dry friction differs"),
    (
        "seal-friction",
        "friction of the seal grows with the pressure in the chamber",
    ),
    ("return-spring", "a spring pulls the rod back"),
    ("gas-type", "the gas is another one"),
    (
        "exhaust-port",
        "the chamber opens to the atmosphere before the end of the stroke",
    ),
    ("heat-transfer", "gas and wall exchange heat"),
    ("mass", "the mass differs"),
    ("inertia", "the moment of inertia differs"),
    ("imbalance", "the centre of mass is off the axle"),
    ("boom-inertia", "the boom has mass and weight"),
    ("boom-flex", "the boom bends"),
    ("axle-friction", "dry friction in the axle brakes the spin"),
    ("foot-slip", "the foot slips on the ground"),
    ("ground-compliance", "the ground gives way under the foot"),
    (
        "foot-rolling",
        "the foot rolls on the ground instead of turning about a point",
    ),
    ("ground-slope", "the ground slopes"),
    ("air-drag", "the air brakes the body"),
    ("gravity", "the acceleration of free fall differs"),
    (
        "counterweight",
        "a counterweight carries a part of the weight",
    ),
    ("encoder-scale", "the sensor's scale is wrong"),
    ("sensor-offset", "the sensor's zero is off"),
    ("sensor-delay", "the sensor reports late"),
];

/// What the cause `id` means; none for a term that stands for something unknown.
pub fn meaning(id: &str) -> Option<&'static str> {
    NAMED
        .iter()
        .find(|(name, _)| *name == id)
        .map(|(_, meaning)| *meaning)
}
