//! What each kind of experiment has in its files.

use std::f64::consts::{FRAC_PI_2, PI};

use saltus_robot::units::{
    ANGLE, ANGULAR_RATE, AREA as SQUARE, FORCE as NEWTON, LENGTH, MASS, PRESSURE, Quantity,
    TEMPERATURE as KELVIN, TIME, Unit, VOLUME as CUBE,
};

use super::Sort;
use super::idle::Rest;

/// One kind of experiment.
#[derive(Debug)]
pub(super) struct Spec {
    pub(super) sort: Sort,
    /// Its name in the file.
    pub(super) id: &'static str,
    /// Whether a robot was measured, and so has to be named.
    pub(super) robot: bool,
    /// Whether rows carry the valve's command.
    pub(super) valve: bool,
    /// What is done with rest before and after the motion.
    pub(super) rest: [Rest; 2],
    /// What is measured.
    pub(super) channels: &'static [Channel],
    /// Whether some of the channels suffice. They may then come from instruments with clocks of
    /// their own, each with cells empty where another measured.
    pub(super) any_of: bool,
    /// What the operator sets.
    pub(super) settings: &'static [Setting],
    /// Keys of a run, each optional, that say when something happened on the clock of its file.
    pub(super) instants: &'static [&'static str],
    /// Fewest rows from which anything can be learned.
    pub(super) least: usize,
    /// Longest time (s) that a run can take.
    pub(super) longest: f64,
}

/// A measured column.
#[derive(Clone, Copy, Debug)]
pub(super) struct Channel {
    /// Its name in SI, as [`Run`](super::Run) has it.
    pub(super) name: &'static str,
    pub(super) quantity: Quantity,
    pub(super) domain: Domain,
    /// What it means that it never changes.
    pub(super) still: Still,
    /// Whether runs may do without it.
    pub(super) optional: bool,
    /// Whether a row without it says nothing.
    pub(super) needed: bool,
    /// Size that it reaches in some run, in the right unit; 0 where that says nothing.
    pub(super) scale: f64,
}

/// What it means that a channel never changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Still {
    /// The sensor is dead.
    Dead,
    /// It may be so, but is worth a note.
    Odd,
    /// Nothing.
    Usual,
}

/// A number that the operator sets for a run.
#[derive(Debug)]
pub(super) struct Setting {
    /// Its key in SI.
    pub(super) key: &'static str,
    pub(super) quantity: Quantity,
    pub(super) domain: Domain,
    pub(super) required: bool,
}

/// Which numbers are possible. The bounds are wide, to tell a wrong unit from a strange rig.
#[derive(Clone, Copy, Debug)]
pub(super) struct Domain {
    pub(super) legal: fn(f64) -> bool,
    /// In words.
    pub(super) allowed: &'static str,
}

/// A channel that always changes.
const fn lively(name: &'static str, (quantity, domain): (Quantity, Domain)) -> Channel {
    Channel {
        name,
        quantity,
        domain,
        still: Still::Dead,
        optional: false,
        needed: false,
        scale: 0.0,
    }
}

/// A channel that may stay the same, if seldom.
const fn calm(name: &'static str, (quantity, domain): (Quantity, Domain)) -> Channel {
    Channel {
        name,
        quantity,
        domain,
        still: Still::Odd,
        optional: false,
        needed: false,
        scale: 0.0,
    }
}

/// The channel, which runs may do without.
const fn without(channel: Channel) -> Channel {
    Channel {
        optional: true,
        ..channel
    }
}

/// A channel that says what was asked for: often the same, never missing.
const fn asked(name: &'static str, (quantity, domain): (Quantity, Domain)) -> Channel {
    Channel {
        name,
        quantity,
        domain,
        still: Still::Usual,
        optional: false,
        needed: true,
        scale: 0.0,
    }
}

const fn required(key: &'static str, (quantity, domain): (Quantity, Domain)) -> Setting {
    Setting {
        key,
        quantity,
        domain,
        required: true,
    }
}

const fn optional(key: &'static str, (quantity, domain): (Quantity, Domain)) -> Setting {
    Setting {
        key,
        quantity,
        domain,
        required: false,
    }
}

const POSITION: (Quantity, Domain) = (
    LENGTH,
    Domain {
        legal: |x| x.abs() <= 10.0,
        allowed: "a position from -10 to 10 m",
    },
);
const PLACE: (Quantity, Domain) = (
    LENGTH,
    Domain {
        legal: |x| x.abs() <= 1e4,
        allowed: "a place from -10000 to 10000 m",
    },
);
const LEAP: (Quantity, Domain) = (
    LENGTH,
    Domain {
        legal: |x| x.abs() <= 100.0,
        allowed: "a length from -100 to 100 m",
    },
);
const TILT: (Quantity, Domain) = (
    ANGLE,
    Domain {
        legal: |x| x.abs() <= FRAC_PI_2,
        allowed: "an angle from -pi/2 to pi/2 in rad, not degrees",
    },
);
// A wheel goes on turning in flight: 10 rad/s for a second is more than one turn.
const TURN: (Quantity, Domain) = (
    ANGLE,
    Domain {
        legal: |x| x.abs() <= 4.0 * PI,
        allowed: "an angle from -4 pi to 4 pi in rad, not degrees",
    },
);
const YAW: (Quantity, Domain) = (
    ANGLE,
    Domain {
        legal: |x| x.abs() <= 2.0 * PI,
        allowed: "an angle from -2 pi to 2 pi in rad, not degrees",
    },
);
const RATE: (Quantity, Domain) = (
    ANGULAR_RATE,
    Domain {
        legal: |x| x.abs() <= 100.0,
        allowed: "a rate from -100 to 100 rad/s, not degrees a second",
    },
);
const OPENING: (Quantity, Domain) = (
    TIME,
    Domain {
        legal: |x| x > 0.0 && x <= 10.0,
        allowed: "a time above 0 and up to 10 s",
    },
);
const FORCE: (Quantity, Domain) = (
    NEWTON,
    Domain {
        legal: |x| x.abs() <= 1e6,
        allowed: "a force from -1e6 to 1e6 N",
    },
);
const LOAD: (Quantity, Domain) = (
    MASS,
    Domain {
        legal: |x| x > 0.0 && x <= 1e3,
        allowed: "a mass above 0 and up to 1000 kg",
    },
);
const DIAMETER: (Quantity, Domain) = (
    LENGTH,
    Domain {
        legal: |x| x > 0.0 && x <= 10.0,
        allowed: "a diameter above 0 and up to 10 m",
    },
);
const BORE: (Quantity, Domain) = (
    LENGTH,
    Domain {
        legal: |x| x > 0.0 && x <= 1.0,
        allowed: "a diameter above 0 and up to 1 m",
    },
);
const RADIUS: (Quantity, Domain) = (
    LENGTH,
    Domain {
        legal: |x| x > 0.0 && x <= 100.0,
        allowed: "a length above 0 and up to 100 m",
    },
);
const VOLUME: (Quantity, Domain) = (
    CUBE,
    Domain {
        legal: |x| x > 0.0 && x <= 1e4,
        allowed: "a volume above 0 and up to 10000 m3",
    },
);
const AREA: (Quantity, Domain) = (
    SQUARE,
    Domain {
        legal: |x| x > 0.0 && x <= 1e4,
        allowed: "an area above 0 and up to 10000 m2",
    },
);
// Colder than any gas is handled at, so that room temperature in degrees Celsius is seen.
const TEMPERATURE: (Quantity, Domain) = (
    KELVIN,
    Domain {
        legal: |x| (100.0..=3000.0).contains(&x),
        allowed: "a temperature from 100 to 3000 in K, not degC",
    },
);
// A supply that a bar or a psi would be the right unit for has more than 1000 Pa.
const SUPPLY: (Quantity, Domain) = (
    PRESSURE,
    Domain {
        legal: |x| (1e3..=1e8).contains(&x),
        allowed: "a gauge pressure from 1000 to 1e8 in Pa, not kPa, bar or psi",
    },
);
const GAUGE: (Quantity, Domain) = (
    PRESSURE,
    Domain {
        legal: |x| (-2e5..=1e8).contains(&x),
        allowed: "a gauge pressure from -2e5 to 1e8 Pa",
    },
);
// A leg's chamber is never below the surroundings, of which there are 33 kPa on the highest
// mountain.
const CHAMBER: (Quantity, Domain) = (
    PRESSURE,
    Domain {
        legal: |x| (2e4..=1e8).contains(&x),
        allowed: "an absolute pressure from 20000 to 1e8 in Pa, not gauge, kPa, bar or psi",
    },
);
const ABSOLUTE: (Quantity, Domain) = (
    PRESSURE,
    Domain {
        legal: |x| (1e3..=1e8).contains(&x),
        allowed: "an absolute pressure from 1000 to 1e8 in Pa, not gauge, kPa, bar or psi",
    },
);

/// A logged run of part of the robot.
const LOGGED: Spec = Spec {
    sort: Sort::Bench,
    id: "",
    robot: true,
    valve: true,
    rest: [Rest::Keep; 2],
    channels: &[],
    any_of: false,
    settings: &[],
    instants: &[],
    least: 10,
    longest: 100.0,
};

/// A logged test of one part, which may take a day.
const PART: Spec = Spec {
    robot: false,
    valve: false,
    longest: f64::INFINITY,
    ..LOGGED
};

/// All kinds, in the order of messages.
pub(super) const SPECS: [Spec; 8] = [
    Spec {
        sort: Sort::Bench,
        id: "bench",
        rest: [Rest::Thin; 2],
        channels: &[
            lively("position_m", POSITION),
            without(lively("pressure_pa", CHAMBER)),
        ],
        settings: &[
            required("load_mass_kg", LOAD),
            required("supply_pressure_gauge_pa", SUPPLY),
        ],
        ..LOGGED
    },
    Spec {
        sort: Sort::Hop,
        id: "hop",
        // It stands until it is fired; after the landing it does what nobody models.
        rest: [Rest::Thin, Rest::Cut],
        channels: &[
            without(lively("pivot_angle_rad", TILT)),
            without(lively("y_m", LEAP)),
        ],
        settings: &[required("supply_pressure_gauge_pa", SUPPLY)],
        ..LOGGED
    },
    Spec {
        sort: Sort::Jump,
        id: "jump",
        rest: [Rest::Cut; 2],
        channels: &[
            lively("wheel_angle_rad", TURN),
            without(lively("pivot_angle_rad", TILT)),
            without(lively("radius_angle_rad", YAW)),
            without(lively("wheel_rate_rad_s", RATE)),
            without(lively("x_m", LEAP)),
            without(lively("y_m", LEAP)),
        ],
        settings: &[required("supply_pressure_gauge_pa", SUPPLY)],
        ..LOGGED
    },
    Spec {
        sort: Sort::Flight,
        id: "flight",
        // Something dropped may stay above its shadow.
        channels: &[without(calm("x_m", PLACE)), without(lively("y_m", PLACE))],
        any_of: true,
        settings: &[
            optional("mass_kg", LOAD),
            optional("diameter_m", DIAMETER),
            optional("boom_radius_m", RADIUS),
        ],
        least: 5,
        longest: 1000.0,
        ..PART
    },
    Spec {
        sort: Sort::Outcomes,
        id: "outcomes",
        robot: true,
        channels: &[
            asked("omega_rad_s", RATE),
            asked("alpha_f_rad", TILT),
            asked("valve_open_s", OPENING),
            lively("distance_m", LEAP),
            lively("apex_m", LEAP),
        ],
        least: 3,
        ..PART
    },
    Spec {
        sort: Sort::Stroke,
        id: "stroke",
        channels: &[
            lively("position_m", POSITION),
            // A regulator may hold it to one count.
            Channel {
                scale: 1000.0,
                ..calm("pressure_gauge_pa", GAUGE)
            },
            lively("force_n", FORCE),
        ],
        settings: &[required("bore_m", BORE)],
        ..PART
    },
    Spec {
        sort: Sort::Slide,
        id: "slide",
        // A weight on a string pulls always the same.
        channels: &[calm("force_n", FORCE), lively("position_m", POSITION)],
        settings: &[optional("mass_kg", LOAD)],
        ..PART
    },
    Spec {
        sort: Sort::Vessel,
        id: "vessel",
        // A slow discharge may be as warm as the room throughout.
        channels: &[
            without(lively("pressure_pa", ABSOLUTE)),
            without(calm("temperature_k", TEMPERATURE)),
        ],
        any_of: true,
        settings: &[
            required("volume_m3", VOLUME),
            required("orifice_diameter_m", BORE),
            required("initial_pressure_pa", ABSOLUTE),
            required("initial_temperature_k", TEMPERATURE),
            required("ambient_pressure_pa", ABSOLUTE),
            optional("wall_area_m2", AREA),
        ],
        instants: &["release_s"],
        least: 5,
        ..PART
    },
];

/// What a column holds.
#[derive(Clone, Copy, Debug)]
pub(super) enum Meaning {
    /// Times, in units of ten to this power of a second.
    Time(i32),
    /// The valve's command.
    Valve,
    /// A channel, in this unit.
    Channel(&'static Channel, Unit),
}

/// The name of a number, and its names in other units.
pub(super) fn spellings(
    name: &'static str,
    quantity: Quantity,
) -> impl Iterator<Item = (String, Unit)> {
    let stem = name.strip_suffix(quantity.units[0].0).unwrap_or(name);
    quantity
        .units
        .iter()
        .map(move |(suffix, unit)| (format!("{stem}{suffix}"), *unit))
}

/// The power of ten of a unit of time.
pub(super) fn power(unit: Unit) -> i32 {
    match unit {
        Unit::Decimal(power) => i32::try_from(power).unwrap_or(0),
        Unit::Times(_) => 0,
    }
}

impl Spec {
    /// The kind that a file calls `id`.
    pub(super) fn named(id: &str) -> Option<&'static Spec> {
        SPECS.iter().find(|spec| spec.id == id)
    }

    /// What is in the files of `sort`.
    pub(super) fn of(sort: Sort) -> Option<&'static Spec> {
        SPECS.iter().find(|spec| spec.sort == sort)
    }

    /// The channel of this name.
    pub(super) fn channel(&self, name: &str) -> Option<&'static Channel> {
        self.channels.iter().find(|channel| channel.name == name)
    }

    /// Whether rows carry a time; else there is one for each jump.
    pub(super) fn timed(&self) -> bool {
        self.sort != Sort::Outcomes
    }

    /// What a column of this name holds; none: nothing that the kind knows.
    pub(super) fn meaning(&self, name: &str) -> Option<Meaning> {
        let unit = |own: &'static str, quantity| {
            spellings(own, quantity)
                .find(|(spelling, _)| spelling == name)
                .map(|(_, unit)| unit)
        };
        if self.valve && name == "valve" {
            return Some(Meaning::Valve);
        }
        if let (true, Some(unit)) = (self.timed(), unit("time_s", TIME)) {
            return Some(Meaning::Time(power(unit)));
        }
        self.channels
            .iter()
            .find_map(|own| Some(Meaning::Channel(own, unit(own.name, own.quantity)?)))
    }

    /// Names in SI of all columns that its files may have.
    pub(super) fn columns(&self) -> Vec<&'static str> {
        let time = self.timed().then_some("time_s");
        let valve = self.valve.then_some("valve");
        time.into_iter()
            .chain(valve)
            .chain(self.channels.iter().map(|channel| channel.name))
            .collect()
    }

    /// Whether a channel may be missing in so many of its rows.
    pub(super) fn may_lack(&self, missing: usize, rows: usize) -> bool {
        if self.any_of {
            10 * missing <= 9 * rows
        } else {
            2 * missing <= rows
        }
    }
}
