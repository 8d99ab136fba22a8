//! What a kind of experiment says of itself: what is in its files, which sizes are plausible, its
//! model, and how synthetic data of it are laid out.

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::{Mutex, PoisonError};

use saltus_robot::Robot;
pub use saltus_robot::domain::Domain;
use saltus_robot::units::{
    ANGLE, ANGULAR_RATE, AREA as SQUARE, FORCE as NEWTON, LENGTH, MASS, NUMBER, PRESSURE, Quantity,
    TEMPERATURE as KELVIN, TIME, Unit, VOLUME as CUBE,
};

use crate::experiment::{Experiment, Sort};
use crate::kind::Kind;
use crate::layout::{Draw, Layout};
use crate::plausible::Check;

/// Why an experiment has no model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    /// The kind is about a robot.
    #[error("data of this kind need the robot that was measured")]
    NoRobot,
    /// The bench fires a pneumatic leg.
    #[error("the leg of robot {robot} is not pneumatic, which data of kind bench need")]
    NotPneumatic {
        /// Its name.
        robot: String,
    },
    /// The strides of a run draw on one tank, and are fitted one by one.
    #[error(
        "robot {robot:?} has a tank, which its strides empty, and data of kind run are fitted stride by stride: leave \
         tank.volume out, or measure jumps (kind jump)"
    )]
    Tank {
        /// Its name.
        robot: String,
    },
    /// Of a vessel that is not shut, one number is missing.
    #[error(
        "{run}: {given} is given without {missing}: a vessel with an orifice needs both, one that is shut neither"
    )]
    HalfAVessel {
        /// The run.
        run: String,
        /// The key that it has.
        given: &'static str,
        /// The key that it lacks.
        missing: &'static str,
    },
    /// The gas of a vessel is not said in one way.
    #[error(
        "{run}: {what}: a vessel's gas is air, or one that gas names, or one with molar_mass_kg_mol and heat_ratio"
    )]
    Gas {
        /// The run.
        run: String,
        /// The keys that do not go together.
        what: String,
    },
    /// What `[rig]` says is no machine of this kind, or its columns are not those of the machine.
    #[error("{what}")]
    NoMachine {
        /// What is wrong, and what is allowed.
        what: String,
    },
    /// A run has not one valve for each leg.
    #[error(
        "robot {robot} has {legs} legs: column {column} is {is}; a run has valve_1 to valve_{legs}"
    )]
    Valves {
        /// Its name.
        robot: String,
        /// Its legs.
        legs: usize,
        /// The column.
        column: String,
        /// What it is.
        is: &'static str,
    },
    /// The output of a valve that is none.
    #[error("{run}: {column} is {value} at {time} s: must be 0 or 1")]
    Output {
        /// The run.
        run: String,
        /// The column.
        column: String,
        /// What it says.
        value: f64,
        /// When (s).
        time: f64,
    },
    /// A run in which no leg is fired.
    #[error("{run}: valve_1 to valve_{last} never turn from 0 to 1 and back: no leg is fired")]
    NeverFires {
        /// The run.
        run: String,
        /// How many valves there are.
        last: usize,
    },
    /// A wheel angle that begins anew.
    #[error(
        "{run}: wheel_angle_rad jumps from {before:.4} to {after:.4} rad at {time} s: it must count \
         on through every turn"
    )]
    Wraps {
        /// The run.
        run: String,
        /// When (s).
        time: f64,
        /// The angle (rad) before.
        before: f64,
        /// The angle (rad) after.
        after: f64,
    },
    /// A run without the height of its axle.
    #[error(
        "a run needs wheel_angle_rad, and the height of the axle: pivot_angle_rad of a robot on a boom, or y_m"
    )]
    NoHeight,
    /// Too few strides.
    #[error(
        "{fit} of {firings} firings can be read as jumps: must be {least} at least; left out are \
         {reasons}"
    )]
    FewStrides {
        /// Firings.
        firings: usize,
        /// Those that can be read.
        fit: usize,
        /// Fewest.
        least: usize,
        /// Why the others cannot.
        reasons: String,
    },
    /// A column is about a boom.
    #[error(
        "robot {robot} has no boom, whose {column} the data have: is it the robot that was \
         measured? Of a robot without a boom x_m and y_m of the axle may be given, beside \
         wheel_angle_rad and wheel_rate_rad_s"
    )]
    NoBoom {
        /// Its name.
        robot: String,
        /// The column.
        column: String,
    },
}

/// What makes the model of an experiment, of a robot where one was measured.
pub type Build = fn(&Experiment, Option<&Robot>) -> Result<Box<dyn Kind>, Problem>;

/// One kind of experiment. All of it stands in the kind's own file in `kinds`.
#[derive(Debug)]
// Independent facts of a kind, none of which is a state.
#[allow(clippy::struct_excessive_bools)]
pub struct Spec {
    /// Which it is.
    pub sort: Sort,
    /// Its name in files and on the command line.
    pub id: &'static str,
    /// What was done, in a few words.
    pub description: &'static str,
    /// The built-in robot that synthetic data are of, where a robot was measured: a folder of data
    /// has to name it then.
    pub robot: Option<&'static str>,
    /// Whether rows carry a time; else there is one for each jump.
    pub timed: bool,
    /// Whether rows carry the valve's command.
    pub valve: bool,
    /// What is done with rest before and after the motion.
    pub rest: [Rest; 2],
    /// What is measured.
    pub channels: &'static [Column],
    /// Whether some of the channels suffice. They may then come from instruments with clocks of
    /// their own, each with cells empty where another measured.
    pub any_of: bool,
    /// What the operator sets.
    pub settings: &'static [Setting],
    /// What the operator believes of the machine, in the table `[rig]` of the folder: each run has
    /// it among its settings. A folder without that table has to name a robot.
    pub rig: &'static [Setting],
    /// Whether `[rig]` names a file that describes the machine, as [`mechanism`](crate::mechanism) has
    /// it.
    pub mechanism: bool,
    /// Keys of a run, each optional, that say when something happened on the clock of its file.
    pub instants: &'static [&'static str],
    /// Fewest rows from which anything can be learned.
    pub least: usize,
    /// Longest time (s) that a run can take.
    pub longest: f64,
    /// Most rows that are kept of a run.
    pub most_rows: usize,
    /// Whether a run with more rows is refused, and not thinned.
    pub in_full: bool,
    /// Sizes that tell a wrong unit or a sign turned round.
    pub checks: &'static [Check],
    /// What a report calls a phase of a run.
    pub phase: fn(&'static str) -> &'static str,
    /// The model of data, and of a robot where one was measured.
    pub model: Build,
    /// How synthetic data are made.
    pub synthesis: Synthesis,
}

/// How synthetic data of a kind are made: what the operator would do and measure.
#[derive(Debug)]
pub struct Synthesis {
    /// Columns with their instruments.
    pub instruments: &'static [Instrument],
    /// The same of a robot without a boom, where they are others.
    pub without_boom: Option<&'static [Instrument]>,
    /// Runs that are usual (of outcomes: rows).
    pub runs: usize,
    /// Lays out so many runs.
    pub lay_out: fn(&mut Layout, usize, &mut Draw),
    /// What fills the measured columns.
    pub source: Source,
}

/// What fills the measured columns of synthetic data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// The kind's own model.
    Model,
    /// Motions of a robot, by another simulation.
    Robot,
}

/// A column of synthetic data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instrument {
    /// The column.
    pub column: &'static str,
    /// Standard deviation of its noise, in the column's unit; 0: none that is known.
    pub noise: f64,
    /// Its step, in the column's unit; 0: none.
    pub step: f64,
}

/// An instrument with noise.
pub(crate) const fn noisy(column: &'static str, noise: f64) -> Instrument {
    Instrument {
        column,
        noise,
        step: 0.0,
    }
}

/// An encoder.
pub(crate) const fn counting(column: &'static str, step: f64) -> Instrument {
    Instrument {
        column,
        noise: 0.0,
        step,
    }
}

/// What is done with rest at one end of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rest {
    /// It is measured like the rest, and thinned where it is most of the run.
    Thin,
    /// The model has no such phase: it is left out.
    Cut,
    /// It is kept as it is.
    Keep,
}

/// A measured column.
#[derive(Clone, Copy, Debug)]
pub struct Column {
    /// Its name in SI, as [`Run`](super::Run) has it.
    pub name: &'static str,
    /// Its quantity, with the units in which it may come.
    pub quantity: Quantity,
    /// Values that are possible.
    pub domain: Domain,
    /// What it tells if it never changes.
    pub still: Still,
    /// Whether runs may do without it.
    pub optional: bool,
    /// Whether a row without it says nothing.
    pub needed: bool,
    /// Size that it reaches in some run, in the right unit; 0 where that says nothing.
    pub scale: f64,
}

impl Column {
    /// Whether it stands for many columns: its name has a star in the place of a part's name.
    pub fn is_family(&self) -> bool {
        self.name.contains('*')
    }

    /// What a column of this name holds, if it is one of the family.
    fn member(&'static self, name: &str) -> Option<Meaning> {
        let within = |pattern: &str| {
            let (before, after) = pattern.split_once('*')?;
            let part = name.strip_prefix(before)?.strip_suffix(after)?;
            Some(part.to_owned()).filter(|part| !part.is_empty())
        };
        let (part, unit) = spellings(self.name, self.quantity)
            .find_map(|(spelling, unit)| Some((within(&spelling)?, unit)))?;
        Some(Meaning::Column(
            interned(self, &self.name.replace('*', &part)),
            unit,
        ))
    }
}

/// The column `name` of a family. Each is kept for good: there are as many as names in files.
fn interned(family: &'static Column, name: &str) -> &'static Column {
    type Member = (&'static Column, &'static Column);
    static KNOWN: Mutex<Vec<Member>> = Mutex::new(Vec::new());
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    let is_it = |(of, own): &&Member| std::ptr::eq(*of, family) && own.name == name;
    if let Some((_, own)) = known.iter().find(is_it) {
        return own;
    }
    let own: &'static Column = Box::leak(Box::new(Column {
        name: Box::leak(name.to_owned().into_boxed_str()),
        ..*family
    }));
    known.push((family, own));
    own
}

/// What a channel without any change tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Still {
    /// The sensor is dead.
    Dead,
    /// It may be so, but is worth a note.
    Odd,
    /// Nothing.
    Usual,
    /// Nothing, and it may be empty after the first rows, which say how the machine stands.
    AtStart,
}

/// A number that the operator sets for a run.
#[derive(Debug)]
pub struct Setting {
    /// Its key in SI.
    pub key: &'static str,
    /// Its quantity, with the units in which it may come.
    pub quantity: Quantity,
    /// Values that are possible.
    pub domain: Domain,
    /// Whether every run needs it.
    pub required: bool,
    /// Words that stand for a number.
    pub words: &'static [(&'static str, f64)],
    /// Whether it is one number.
    pub form: Form,
}

/// What stands under a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// A number.
    One,
    /// A list of numbers: among the settings of a run, the k-th one has the key with `.k` after it,
    /// counted from 1.
    List,
    /// One of the words that the setting has.
    Word,
    /// A list of names: the key with a dot and the name is the place of that one, counted from 1.
    Names,
}

impl Setting {
    /// Whether the key of a run's setting is of this one.
    pub fn stands_under(&self, key: &str) -> bool {
        match self.form {
            Form::One | Form::Word => key == self.key,
            Form::List | Form::Names => key
                .strip_prefix(self.key)
                .is_some_and(|rest| rest.starts_with('.')),
        }
    }

    /// A value as it stands in a file.
    pub fn written(&self, value: f64) -> String {
        let word = self.words.iter().find(|(_, number)| *number == value);
        word.map_or_else(|| format!("{value:?}"), |(name, _)| format!("{name:?}"))
    }
}

/// The list of numbers `key` among the settings of a run, in its order.
pub fn listed(settings: &BTreeMap<String, f64>, key: &str) -> Vec<f64> {
    let at = |k: usize| settings.get(&format!("{key}.{k}")).copied();
    (1..).map_while(at).collect()
}

/// The list of names `key` among the settings of a run, in its order.
pub fn named(settings: &BTreeMap<String, f64>, key: &str) -> Vec<String> {
    let prefix = format!("{key}.");
    let mut all: Vec<(&str, f64)> = settings
        .iter()
        .filter_map(|(name, place)| Some((name.strip_prefix(&prefix)?, *place)))
        .collect();
    all.sort_by(|a, b| a.1.total_cmp(&b.1));
    all.into_iter().map(|(name, _)| name.to_owned()).collect()
}

/// A channel that always changes.
pub(crate) const fn lively(name: &'static str, (quantity, domain): (Quantity, Domain)) -> Column {
    Column {
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
pub(crate) const fn calm(name: &'static str, meaning: (Quantity, Domain)) -> Column {
    Column {
        still: Still::Odd,
        ..lively(name, meaning)
    }
}

/// The channel, which runs may do without.
pub(crate) const fn without(channel: Column) -> Column {
    Column {
        optional: true,
        ..channel
    }
}

/// A channel that says how the machine stands at the start.
pub(crate) const fn posture(name: &'static str, meaning: (Quantity, Domain)) -> Column {
    Column {
        still: Still::AtStart,
        optional: true,
        ..calm(name, meaning)
    }
}

/// A channel that says what was asked for: often the same, never missing.
pub(crate) const fn asked(name: &'static str, meaning: (Quantity, Domain)) -> Column {
    Column {
        still: Still::Usual,
        needed: true,
        ..lively(name, meaning)
    }
}

pub(crate) const fn required(key: &'static str, (quantity, domain): (Quantity, Domain)) -> Setting {
    Setting {
        key,
        quantity,
        domain,
        required: true,
        words: &[],
        form: Form::One,
    }
}

pub(crate) const fn optional(key: &'static str, meaning: (Quantity, Domain)) -> Setting {
    Setting {
        required: false,
        ..required(key, meaning)
    }
}

/// A list of numbers, which a machine needs.
pub(crate) const fn list(key: &'static str, meaning: (Quantity, Domain)) -> Setting {
    Setting {
        form: Form::List,
        ..required(key, meaning)
    }
}

/// A list of names, which a machine needs.
pub(crate) const fn names(key: &'static str) -> Setting {
    Setting {
        form: Form::Names,
        ..required(key, (NUMBER, Domain::POSITIVE))
    }
}

/// A length of this name within a domain that its values leave where they come in a smaller unit.
pub(crate) const fn length(domain: Domain, name: &'static str) -> (Quantity, Domain) {
    (LENGTH, domain.called(name).not("mm, cm or inch"))
}

pub(crate) const POSITION: (Quantity, Domain) = length(Domain::within(10.0), "a position");
pub(crate) const PLACE: (Quantity, Domain) = length(Domain::within(1e4), "a place");
pub(crate) const LEAP: (Quantity, Domain) = length(Domain::within(100.0), "a length");
const fn angle(most: f64) -> (Quantity, Domain) {
    let domain = Domain::within(most).called("an angle");
    (ANGLE, domain.not("degrees"))
}

const fn absolute(least: f64) -> (Quantity, Domain) {
    let domain = Domain::at_least(least)
        .up_to(1e8)
        .called("an absolute pressure");
    (PRESSURE, domain.not("gauge, kPa, bar or psi"))
}

pub(crate) const TILT: (Quantity, Domain) = angle(FRAC_PI_2);
// A wheel goes on turning in flight: 10 rad/s for a second is more than one turn.
pub(crate) const TURN: (Quantity, Domain) = angle(4.0 * PI);
/// Of a wheel and a boom that go round and round.
pub(crate) const TURN_ON: (Quantity, Domain) = angle(1e5);
pub(crate) const LEAP_ON: (Quantity, Domain) = length(Domain::within(1e5), "a length");
pub(crate) const INCLINE: (Quantity, Domain) = angle(1.0);
/// Of a valve: 0 or 1.
pub(crate) const OUTPUT: (Quantity, Domain) =
    (NUMBER, Domain::at_least(0.0).up_to(1.0).called("0 or 1"));
pub(crate) const YAW: (Quantity, Domain) = angle(2.0 * PI);
pub(crate) const RATE: (Quantity, Domain) = (
    ANGULAR_RATE,
    Domain::within(100.0)
        .called("a rate")
        .not("degrees a second"),
);
pub(crate) const OPENING: (Quantity, Domain) =
    (TIME, Domain::POSITIVE.up_to(10.0).called("a time"));
pub(crate) const FORCE: (Quantity, Domain) = (NEWTON, Domain::within(1e6).called("a force"));
pub(crate) const LOAD: (Quantity, Domain) = (MASS, Domain::POSITIVE.up_to(1e3).called("a mass"));
pub(crate) const DIAMETER: (Quantity, Domain) = length(Domain::POSITIVE.up_to(10.0), "a diameter");
pub(crate) const BORE: (Quantity, Domain) = length(Domain::POSITIVE.up_to(1.0), "a diameter");
pub(crate) const RADIUS: (Quantity, Domain) = length(Domain::POSITIVE.up_to(100.0), "a length");
/// Of a link or a leg of a machine that one can carry.
pub(crate) const LINK: (Quantity, Domain) = length(Domain::POSITIVE.up_to(10.0), "a length");
pub(crate) const VOLUME: (Quantity, Domain) = (
    CUBE,
    Domain::POSITIVE
        .up_to(1e4)
        .called("a volume")
        .not("l, cm3 or mm3"),
);
pub(crate) const AREA: (Quantity, Domain) = (
    SQUARE,
    Domain::POSITIVE
        .up_to(1e4)
        .called("an area")
        .not("cm2 or mm2"),
);
// Colder than any gas is handled at, so that room temperature in degrees Celsius is seen.
pub(crate) const TEMPERATURE: (Quantity, Domain) = (
    KELVIN,
    Domain::at_least(100.0)
        .up_to(3000.0)
        .called("a temperature")
        .not("degC"),
);
// A supply that a bar or a psi would be the right unit for has more than 1000 Pa.
pub(crate) const SUPPLY: (Quantity, Domain) = (
    PRESSURE,
    Domain::at_least(1e3)
        .up_to(1e8)
        .called("a gauge pressure")
        .not("kPa, bar or psi"),
);
pub(crate) const GAUGE: (Quantity, Domain) = (
    PRESSURE,
    Domain::at_least(-2e5).up_to(1e8).called("a gauge pressure"),
);
// A leg's chamber is never below the surroundings, of which there are 33 kPa on the highest
// mountain.
pub(crate) const CHAMBER: (Quantity, Domain) = absolute(2e4);
pub(crate) const ABSOLUTE: (Quantity, Domain) = absolute(1e3);

/// A logged run of part of the robot.
pub(crate) const LOGGED: Spec = Spec {
    sort: Sort::Bench,
    id: "",
    description: "",
    robot: None,
    timed: true,
    valve: true,
    rest: [Rest::Keep; 2],
    channels: &[],
    any_of: false,
    settings: &[],
    rig: &[],
    mechanism: false,
    instants: &[],
    least: 10,
    longest: 100.0,
    most_rows: 4000,
    in_full: false,
    checks: &[],
    phase: |phase| phase,
    model: |_, _| Err(Problem::NoRobot),
    synthesis: Synthesis {
        instruments: &[],
        without_boom: None,
        runs: 12,
        lay_out: |_, _, _| {},
        source: Source::Model,
    },
};

/// A logged test of one part. What is simulated in steps of a millisecond has to end.
pub(crate) const PART: Spec = Spec {
    valve: false,
    longest: 1000.0,
    ..LOGGED
};

/// What a column holds.
#[derive(Clone, Copy, Debug)]
pub enum Meaning {
    /// Times, in units of ten to this power of a second.
    Time(i32),
    /// The valve's command.
    Valve,
    /// A channel, in this unit.
    Column(&'static Column, Unit),
}

/// The name of a number without its unit.
pub fn stem(name: &'static str, quantity: Quantity) -> &'static str {
    name.strip_suffix(quantity.units[0].0).unwrap_or(name)
}

/// The name of a number, and its names in other units.
fn spellings(name: &'static str, quantity: Quantity) -> impl Iterator<Item = (String, Unit)> {
    let stem = stem(name, quantity);
    quantity
        .units
        .iter()
        .map(move |(suffix, unit)| (format!("{stem}{suffix}"), *unit))
}

/// The power of ten of a unit of time.
pub fn power(unit: Unit) -> i32 {
    match unit {
        Unit::Decimal(power) => i32::try_from(power).unwrap_or(0),
        Unit::Times(_) => 0,
    }
}

impl Spec {
    /// The channel of this name.
    pub fn channel(&self, name: &str) -> Option<&'static Column> {
        let own = self.channels.iter().find(|channel| channel.name == name);
        own.or_else(|| match self.meaning(name)? {
            Meaning::Column(own, _) if own.name == name => Some(own),
            _ => None,
        })
    }

    /// What a column of this name holds; none: nothing that the kind knows.
    pub fn meaning(&self, name: &str) -> Option<Meaning> {
        let unit = |own: &'static str, quantity| {
            spellings(own, quantity)
                .find(|(spelling, _)| spelling == name)
                .map(|(_, unit)| unit)
        };
        if self.valve && name == "valve" {
            return Some(Meaning::Valve);
        }
        if let (true, Some(unit)) = (self.timed, unit("time_s", TIME)) {
            return Some(Meaning::Time(power(unit)));
        }
        let (families, plain): (Vec<_>, Vec<_>) =
            self.channels.iter().partition(|own| own.is_family());
        plain
            .into_iter()
            .find_map(|own| Some(Meaning::Column(own, unit(own.name, own.quantity)?)))
            .or_else(|| families.into_iter().find_map(|own| own.member(name)))
    }

    /// Names in SI of all columns that its files may have.
    pub fn columns(&self) -> Vec<&'static str> {
        let time = self.timed.then_some("time_s");
        let valve = self.valve.then_some("valve");
        time.into_iter()
            .chain(valve)
            .chain(self.channels.iter().map(|channel| channel.name))
            .collect()
    }

    /// The name, with a star, of the family that the column `name` is of.
    pub(crate) fn family(&self, name: &str) -> Option<&'static str> {
        let mut families = self.channels.iter().filter(|own| own.is_family());
        let family = families.find(|own| own.member(name).is_some())?;
        Some(family.name)
    }

    /// Whether a channel may be missing in so many of its rows.
    pub fn may_lack(&self, missing: usize, rows: usize) -> bool {
        if self.any_of {
            10 * missing <= 9 * rows
        } else {
            2 * missing <= rows
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// Names of a kind's numbers, with their quantities and domains.
    fn numbers(spec: &Spec) -> Vec<(&'static str, Quantity, Domain)> {
        let columns = spec.channels.iter().map(|c| (c.name, c.quantity, c.domain));
        let settings = spec.settings.iter().chain(spec.rig);
        columns
            .chain(settings.map(|s| (s.key, s.quantity, s.domain)))
            .collect()
    }

    #[test]
    fn every_name_ends_with_its_unit_and_means_one_thing() {
        for spec in Sort::ALL.map(Sort::spec) {
            let mut seen = BTreeSet::new();
            for (name, quantity, _) in numbers(spec) {
                assert!(name.ends_with(quantity.units[0].0), "{}: {name}", spec.id);
                for (spelling, _) in spellings(name, quantity) {
                    assert!(
                        seen.insert(spelling.clone()),
                        "{}: {spelling} twice",
                        spec.id
                    );
                }
            }
            let is_known = |name| {
                let is_member = || spec.channel(name).is_some();
                numbers(spec).iter().any(|number| number.0 == name) || is_member()
            };
            for instrument in spec.synthesis.instruments {
                assert!(is_known(instrument.column), "{}", instrument.column);
            }
            for check in spec.checks {
                let is_family = spec.channels.iter().any(|own| own.name == check.name);
                let is_clock = spec.timed && check.name == "time_s";
                assert!(
                    is_clock || is_family || is_known(check.name),
                    "{}",
                    check.name
                );
            }
        }
    }

    #[test]
    fn a_column_is_known_in_each_of_its_units() {
        let bench = Sort::Bench.spec();
        assert!(matches!(bench.meaning("time_ms"), Some(Meaning::Time(-3))));
        assert!(matches!(bench.meaning("valve"), Some(Meaning::Valve)));
        let column = bench.meaning("pressure_kpa");
        let Some(Meaning::Column(column, unit)) = column else {
            panic!("{column:?}")
        };
        assert_eq!((column.name, unit.si("3.5")), ("pressure_pa", 3500.0));
        assert!(bench.meaning("pressure_torr").is_none());
        // Jumps that are rows have no clock.
        assert!(Sort::Outcomes.spec().meaning("time_s").is_none());
    }

    /// What Saltus lays out itself it would read.
    #[test]
    fn synthetic_runs_are_within_their_domains() {
        for spec in Sort::ALL.map(Sort::spec) {
            let domain = |key: &str| {
                let mut settings = spec.settings.iter().chain(spec.rig);
                let setting = settings.find(|setting| setting.stands_under(key));
                setting.map(|setting| setting.domain)
            };
            for seed in 0..20 {
                let layout = Layout::new(spec.sort, false, None, &mut Draw::new(seed));
                let runs = &layout.experiment.runs;
                assert_eq!(runs.len(), layout.unknowns.len());
                for run in runs {
                    for (key, value) in &run.settings {
                        let domain = domain(key).expect("a known setting");
                        assert!(domain.contains(*value), "{}: {key} = {value}", spec.id);
                    }
                    let is_timed = run.time.windows(2).all(|w| w[0] < w[1]);
                    assert!(is_timed, "{}", spec.id);
                    let takes = run.time.last().copied().unwrap_or(0.0);
                    assert!(
                        !spec.timed || takes <= spec.longest,
                        "{}: {takes} s",
                        spec.id
                    );
                }
            }
        }
    }
}
