//! What a jump is to reach: the flags that `table` and `law` share.

use clap::Args;
use saltus::Robot;
use saltus::ballistic::Obstacle;
use saltus::planner::{FIRING_ANGLES, Measure, Roots, TableRequest};

use super::common::Threads;
use super::terms::{TermFlags, Terms};
use crate::error::{CliError, cut};
use crate::output::digits;
use crate::quantity::{self, Quantity};
use crate::range::{Values, distances, rates};

/// Most pairs of approach rate and target.
const MOST: usize = 1_000_000;

/// Flags that say what is to be reached, and how.
#[derive(Args, Debug)]
pub(crate) struct TargetFlags {
    /// Approach rates ω (rad/s)
    #[arg(long, value_name = "RATES", value_parser = rates, allow_hyphen_values = true)]
    omega: Values,

    /// Distances to reach (m), from the foot to the landing
    #[arg(long, value_name = "LENGTHS", value_parser = distances, allow_hyphen_values = true,
        conflicts_with_all = ["clearance", "obstacle"])]
    distance: Option<Values>,

    /// Clearances to keep (m): least distance between the flying wheel and the obstacle
    #[arg(long, value_name = "LENGTHS", value_parser = distances, allow_hyphen_values = true, requires = "obstacle")]
    clearance: Option<Values>,

    /// Box on the ground (m): its front edge's distance from the foot, its width, its height
    #[arg(long, value_name = "FRONT,WIDTH,HEIGHT", value_parser = block, allow_hyphen_values = true, requires = "clearance")]
    obstacle: Option<Block>,

    #[command(flatten)]
    terms: TermFlags,

    /// Firing angles α_f (rad) to choose from [default: -0.6:0.8]
    #[arg(long, value_name = "LOW:HIGH", value_parser = limits, allow_hyphen_values = true)]
    firing_angles: Option<(f64, f64)>,

    #[command(flatten)]
    threads: Threads,
}

/// A box on the ground (m).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Block {
    front: f64,
    width: f64,
    height: f64,
}

/// What is reached: how columns and people call it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Distance,
    Clearance,
}

impl Kind {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Kind::Distance => "distance",
            Kind::Clearance => "clearance",
        }
    }
}

impl TargetFlags {
    pub(crate) fn kind(&self) -> Kind {
        if self.clearance.is_some() {
            Kind::Clearance
        } else {
            Kind::Distance
        }
    }

    /// Where the jumps start and end.
    pub(crate) fn terms(&self, robot: &Robot) -> Terms {
        self.terms.of(robot)
    }

    /// The request, for every angle that serves or only for the least.
    pub(crate) fn request(&self, roots: Roots, robot: &Robot) -> Result<TableRequest, CliError> {
        self.terms.note_valve(robot);
        let Terms {
            landing_height,
            valve_open,
            start_lean,
            ..
        } = self.terms(robot);
        let (targets, measure) = match (&self.distance, &self.clearance, self.obstacle) {
            (Some(distances), ..) => (distances, Measure::Distance { landing_height }),
            (None, Some(clearances), Some(block)) => (
                clearances,
                Measure::Clearance {
                    obstacle: block.obstacle(robot)?,
                },
            ),
            _ => {
                return Err(CliError::Missing {
                    flag: "--distance",
                    allowed: "the distances to reach (m), or --clearance with an --obstacle",
                });
            }
        };
        let count = self.omega.len().saturating_mul(targets.len());
        if count > MOST {
            return Err(CliError::flag(
                "--omega",
                "",
                format!("{MOST} pairs of rate and target at most, not {count}"),
            ));
        }
        Ok(TableRequest {
            rates: self.omega.to_vec(),
            measure,
            targets: targets.to_vec(),
            valve_open,
            start_lean,
            firing_angles: self.firing_angles.unwrap_or(FIRING_ANGLES),
            roots,
            sensitivities: roots == Roots::All,
            threads: self.threads.count().get(),
        })
    }
}

impl Block {
    /// Front, back and top (m).
    pub(crate) fn ends(&self) -> [f64; 3] {
        [self.front, self.front + self.width, self.height]
    }

    fn obstacle(self, robot: &Robot) -> Result<Obstacle, CliError> {
        let Block {
            front,
            width,
            height,
        } = self;
        let refused = |allowed: String| {
            CliError::flag("--obstacle", format!("{front},{width},{height}"), allowed)
        };
        if front < robot.body.radius {
            return Err(refused(format!(
                "ahead of the wheel: FRONT at least its radius, {} m",
                digits(robot.body.radius, 6)
            )));
        }
        Obstacle::block([front, 0.0], [front + width, height])
            .map_err(|error| refused(format!("a box ({error})")))
    }
}

/// Parser of a flag.
pub(crate) fn block(text: &str) -> Result<Block, String> {
    let parts: Vec<&str> = text.split(',').collect();
    let [front, width, height] = parts[..] else {
        return Err(format!(
            "{:?} must be three lengths, as in 0.4,0.21,0.21",
            cut(text)
        ));
    };
    let front = Quantity::DISTANCE
        .parse(front)
        .map_err(|error| format!("FRONT {error}"))?;
    let width = quantity::extent(width).map_err(|error| format!("WIDTH {error}"))?;
    let height = quantity::extent(height).map_err(|error| format!("HEIGHT {error}"))?;
    Ok(Block {
        front,
        width,
        height,
    })
}

/// Parser of a flag.
fn limits(text: &str) -> Result<(f64, f64), String> {
    let allowed = "two angles, the lower first, as in -0.6:0.8";
    quantity::span(text, &Quantity::ANGLE, allowed)
}
