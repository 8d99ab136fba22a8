//! Ranges that the numbers of a jump, a course or a run usually lie in: what the models are for. The
//! domains of flags and keys are wider; a number between the two is taken, with a warning.
//!
//! One table for all: [`of_flag`] finds the range of a flag of the command line, [`of_key`] that of
//! a key of a course.
//!
//! ```
//! use saltus::usual;
//!
//! let [rate] = usual::of_flag("omega") else { unreachable!() };
//! assert!(rate.contains(5.0));
//! assert_eq!(
//!     rate.warning("--omega 400", "400", 400.0).unwrap(),
//!     "--omega 400: the model is for 0 to 30 rad/s; is it in deg/s?",
//! );
//! ```

use saltus_robot::units::{ANGLE, ANGULAR_RATE, LENGTH, NUMBER, Quantity, TIME};

/// A range of a quantity (SI), both ends included.
#[derive(Clone, Copy, Debug)]
pub struct Range {
    /// What is measured, and its units.
    pub quantity: Quantity,
    /// Least usual number.
    pub low: f64,
    /// Greatest usual number.
    pub high: f64,
}

const fn range(quantity: Quantity, low: f64, high: f64) -> Range {
    Range {
        quantity,
        low,
        high,
    }
}

/// Approach rates: above √(g/r), 31 rad/s of a wheel of 1 cm, the foot leaves the ground before the leg fires.
const RATE: Range = range(ANGULAR_RATE, 0.0, 30.0);
/// Leans: farther than 69° a robot lies on the ground.
const LEAN: Range = range(ANGLE, -1.2, 1.2);
/// Valve opening times: a stance is over after a few tenths of a second.
const OPENING: Range = range(TIME, 0.0, 1.0);
/// Times between two jumps, in which a tank's wall takes up the temperature of its surroundings.
const PAUSE: Range = range(TIME, 0.0, 600.0);
/// Lengths of a run: one of an hour takes an hour to compute.
const RUN: Range = range(TIME, 0.0, 3600.0);
/// Places along a course: the planner takes 12 jumps.
const PLACE: Range = range(LENGTH, -100.0, 100.0);
/// Distances of one jump.
const DISTANCE: Range = range(LENGTH, 0.0, 30.0);
/// Heights of a landing above or below the foothold.
const HEIGHT: Range = range(LENGTH, -10.0, 10.0);
/// Sizes of a box, and ways to roll.
const SIZE: Range = range(LENGTH, 0.0, 10.0);
/// Margins and tolerances of places.
const MARGIN: Range = range(LENGTH, 0.0, 1.0);
/// Friction coefficients: rubber on dry concrete has 1.
const FRICTION: Range = range(NUMBER, 0.0, 3.0);
/// Standard deviations to keep: at 6 one normal number of 10⁹ is outside.
const SIGMAS: Range = range(NUMBER, 0.0, 6.0);
/// Multiples of a robot's errors.
const MULTIPLE: Range = range(NUMBER, 0.0, 10.0);

/// The table of flags: its name, and the range of all its numbers or of each by its position.
const FLAGS: &[(&str, &[Range])] = &[
    ("omega", &[RATE]),
    ("alpha-f", &[LEAN]),
    ("firing-angle", &[LEAN]),
    ("firing-angles", &[LEAN]),
    ("start-lean", &[LEAN]),
    ("from", &[LEAN]),
    ("to", &[LEAN]),
    ("zone", &[LEAN]),
    ("valve-open", &[OPENING]),
    ("pause", &[PAUSE]),
    ("seconds", &[RUN]),
    ("knots", &[RATE, LEAN, OPENING]),
    ("switch", &[RATE]),
    ("top-rate", &[RATE]),
    ("distance", &[DISTANCE]),
    ("landing-height", &[HEIGHT]),
    ("clear", &[SIZE]),
    ("clearance", &[MARGIN]),
    ("tolerance", &[MARGIN]),
    ("friction", &[FRICTION]),
    ("drawn-across", &[FRICTION]),
    ("scatter", &[MULTIPLE]),
    ("obstacle", &[DISTANCE, SIZE, SIZE]),
];

/// The table of keys of a course, without their units.
const KEYS: &[(&str, Range)] = &[
    ("approach_rate", RATE),
    ("start_lean", LEAN),
    ("firing_angle", LEAN),
    ("valve_open", OPENING),
    ("leg_out", OPENING),
    ("start_x", PLACE),
    ("target_x", PLACE),
    ("goal_from_x", PLACE),
    ("goal_to_x", PLACE),
    ("front_x", PLACE),
    ("from_x", PLACE),
    ("to_x", PLACE),
    ("start_height", SIZE),
    ("roll", SIZE),
    ("width", SIZE),
    ("height", SIZE),
    ("clearance", MARGIN),
    ("edge_margin", MARGIN),
    ("friction_coefficient", FRICTION),
    ("margin_sigmas", SIGMAS),
];

/// Ranges of the numbers of the flag `--name`: one for all, or one for each by its position; none of
/// a flag without a usual range.
pub fn of_flag(name: &str) -> &'static [Range] {
    let found = FLAGS.iter().find(|(flag, _)| *flag == name);
    found.map_or(&[], |(_, ranges)| ranges)
}

/// The range of a key of a course, without its unit; none of a key without a usual range.
pub fn of_key(stem: &str) -> Option<&'static Range> {
    let found = KEYS.iter().find(|(key, _)| *key == stem);
    found.map(|(_, range)| range)
}

impl Range {
    /// Whether `value` (SI) is usual.
    pub fn contains(&self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }

    /// A warning that begins with `written`, for a `value` (SI) of which the user wrote `number`: the range,
    /// and of a number in SI the unit in which it would be usual; none for a usual value.
    pub fn warning(&self, written: &str, number: &str, value: f64) -> Option<String> {
        if self.contains(value) {
            return None;
        }
        let Range {
            quantity,
            low,
            high,
        } = self;
        let unit = quantity.si;
        let is_si = number.trim().parse() == Ok(value);
        let mut others = quantity.units.iter().skip(1).filter(|_| is_si);
        let meant = others.find_map(|(suffix, unit)| {
            let is_meant = self.contains(unit.si(number.trim()));
            is_meant.then(|| suffix.trim_start_matches('_').replace('_', "/"))
        });
        let question = meant.map_or_else(String::new, |unit| format!("; is it in {unit}?"));
        let range = format!("{low} to {high} {unit}");
        let range = range.trim_end();
        Some(format!("{written}: the model is for {range}{question}"))
    }
}
