//! Pages to watch in a browser: the jumps of `saltus verify --animate` and the run of `saltus run
//! --animate`, of a robot in its plane or of one in space.

mod of_report;
pub(crate) mod packed;
#[cfg(test)]
mod tests;

use serde::Serialize;
use serde_json::Value;

pub(crate) use of_report::sizes;

/// The page; the scene takes the place of [`PLACE`].
const TEMPLATE: &str = include_str!("../../assets/animation.html");
const RUN_TEMPLATE: &str = include_str!("../../assets/run.html");
const BALL_TEMPLATE: &str = include_str!("../../assets/ball.html");
const PLACE: &str = "@SCENE@";
/// What all pages look like, in the place of [`STYLE_PLACE`].
const STYLE: &str = include_str!("../../assets/animation.css");
const STYLE_PLACE: &str = "@STYLE@";
/// What draws a robot in space, in the place of [`VIEW_PLACE`].
const VIEW: &str = include_str!("../../assets/view_in_space.js");
const VIEW_PLACE: &str = "@VIEW@";
/// Significant digits of a number in the page.
const DIGITS: usize = 6;
/// Nothing in a scene is so small (SI) and yet seen.
const NOTHING: f64 = 1e-9;

/// What the page shows. Places are x along the travel and y up from the jumping leg's foothold.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Scene {
    /// Name of the robot.
    pub(crate) robot: String,
    /// Heading.
    pub(crate) title: String,
    /// Foot tip to axle with the leg retracted (m).
    pub(crate) wheel_radius_m: f64,
    /// Radius of the hub that carries the legs (m); drawn, no more.
    pub(crate) hub_radius_m: f64,
    /// Legs around the hub, ≥ 1.
    pub(crate) legs: usize,
    /// Length of a leg's rod (m); drawn, no more.
    pub(crate) rod_length_m: f64,
    /// Length of the boom (m), if there is one.
    pub(crate) boom_length_m: Option<f64>,
    /// Slope of the ground through the foothold (rad), rising forward.
    pub(crate) slope_rad: f64,
    /// What stands on the ground.
    pub(crate) obstacles: Vec<Obstacle>,
    /// Where no jump may land: from and to (m).
    pub(crate) avoid: Vec<[f64; 2]>,
    /// Where jumps have to land.
    pub(crate) zones: Vec<Zone>,
    /// The jumps, at least one.
    pub(crate) jumps: Vec<Jump>,
}

/// A box on the ground.
#[derive(Clone, Copy, Debug, Serialize)]
#[allow(clippy::struct_field_names, reason = "the names carry their unit")]
pub(crate) struct Obstacle {
    /// Where it begins (m).
    pub(crate) from_x_m: f64,
    /// Where it ends (m).
    pub(crate) to_x_m: f64,
    /// Height of its top (m).
    pub(crate) top_m: f64,
}

/// Where a jump has to land.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Zone {
    /// What it is called.
    pub(crate) name: String,
    /// From and to (m); an end that is not finite is none.
    pub(crate) span_m: [f64; 2],
}

/// One simulated jump beside its plan. A number that there is none of is NaN.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct Jump {
    /// What it is called.
    pub(crate) name: String,
    /// What was found, in words.
    pub(crate) verdict: String,
    /// Whether it held.
    pub(crate) passed: bool,
    /// What of the scene it misses: `obstacle`, `avoid` or `zone`, and its number from 0.
    pub(crate) missed: Vec<(&'static str, usize)>,
    /// Foothold (m).
    pub(crate) foothold_m: [f64; 2],
    /// Paths of the axle (m) in the other jumps of its run.
    pub(crate) others: Vec<Vec<[f64; 2]>>,
    /// Number of the jump that follows in its run, if one does.
    pub(crate) next: Option<usize>,
    /// Planned path of the axle (m), stance and flight.
    pub(crate) planned: Vec<[f64; 2]>,
    /// Planned greatest height of the axle (m).
    pub(crate) planned_apex_m: f64,
    /// Planned landing of the axle (m).
    pub(crate) planned_land_m: f64,
    /// Simulated greatest height of the axle (m).
    pub(crate) apex_m: f64,
    /// Simulated landing of the axle (m).
    pub(crate) land_m: f64,
    /// Its course, times ascending, at least one.
    pub(crate) frames: Vec<Frame>,
    /// What happened, times ascending.
    pub(crate) events: Vec<Event>,
}

/// The robot at an instant.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Frame {
    /// Time (s).
    pub(crate) time_s: f64,
    /// The axle (m).
    pub(crate) axle_m: [f64; 2],
    /// Lean of the jumping leg (rad), forward.
    pub(crate) lean_rad: f64,
    /// Extension of each leg (m), the jumping one first, then forwards.
    pub(crate) extensions_m: Vec<f64>,
    /// Pressure in the jumping leg's chamber (Pa, absolute); 0 for a leg without a chamber.
    pub(crate) pressure_pa: f64,
    /// The jumping foot (m), where it is nearest to the ground.
    pub(crate) foot_m: [f64; 2],
    /// The ground's force on that foot (N), along x and y.
    pub(crate) force_n: [f64; 2],
    /// How far that foot has slipped so far (m), forward positive, net.
    pub(crate) slip_m: f64,
    /// Whether that foot is on the ground.
    pub(crate) touching: bool,
    /// The boom's radius angle ψ (forward) and pivot angle θ (up), rad.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) boom: Option<[f64; 2]>,
}

/// Something that happened.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Event {
    /// When (s).
    pub(crate) time_s: f64,
    /// What, in a word or two.
    pub(crate) what: String,
}

/// `scene` as one HTML page that needs nothing else.
pub(crate) fn page(scene: &Scene) -> String {
    let value = serde_json::to_value(scene).expect("a scene is plain data");
    filled(TEMPLATE, value)
}

/// A run as one HTML page that needs nothing else: `scene` has what its script reads.
pub(crate) fn run_page(scene: Value) -> String {
    filled(RUN_TEMPLATE, scene)
}

/// A run of a robot in space as one HTML page that needs nothing else: `scene` has what its script reads.
pub(crate) fn ball_page(scene: Value) -> String {
    filled(&BALL_TEMPLATE.replacen(VIEW_PLACE, VIEW, 1), scene)
}

fn filled(template: &str, scene: Value) -> String {
    // The style first: what a scene says is never a place.
    let page = template.replacen(STYLE_PLACE, STYLE, 1);
    page.replacen(PLACE, &inert(&rounded(scene).to_string()), 1)
}

/// `value` with its numbers to [`DIGITS`] significant digits.
fn rounded(value: Value) -> Value {
    match value {
        Value::Array(items) => items.into_iter().map(rounded).collect(),
        Value::Object(fields) => fields
            .into_iter()
            .map(|(key, item)| (key, rounded(item)))
            .collect(),
        Value::Number(number) if number.is_f64() => number.as_f64().map_or(Value::Null, round),
        other => other,
    }
}

fn round(x: f64) -> Value {
    if x.abs() < NOTHING {
        return Value::from(0);
    }
    let nearest = format!("{x:.*e}", DIGITS - 1).parse().unwrap_or(x);
    // A whole number is shorter without its `.0`.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "exact for a whole number of this size"
    )]
    if nearest.fract() == 0.0 && nearest.abs() < 1e15 {
        Value::from(nearest as i64)
    } else {
        Value::from(nearest)
    }
}

/// JSON that ends no script and starts no comment.
fn inert(json: &str) -> String {
    json.replace('<', "\\u003c")
        .replace('\u{2028}', "\\u2028")
        .replace('\u{2029}', "\\u2029")
}
