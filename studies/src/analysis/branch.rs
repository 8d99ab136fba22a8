//! Periodic gaits over a parameter.

use saltus_gait::GaitError;
use saltus_robot::{Drive, GaugePressure, Robot};

use super::periodic::{Periodic, Search, find, settle};
use super::stride::{Firing, StrideState, Strides};

/// What a gait is followed over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parameter {
    /// Firing angle α_f (rad).
    FiringAngle,
    /// Valve opening time t_v (s).
    ValveOpen,
    /// Supply pressure above ambient (Pa).
    Supply,
    /// Slope (rad), uphill positive, of a robot without a boom.
    Slope,
}

impl Parameter {
    /// `robot` and `firing` with the parameter at `value`.
    fn at(self, value: f64, robot: &Robot, firing: Firing) -> (Robot, Firing) {
        let (mut robot, mut firing) = (robot.clone(), firing);
        match self {
            Parameter::FiringAngle => firing.angle = value,
            Parameter::ValveOpen => firing.valve_open = value,
            Parameter::Supply => {
                if let Drive::Pneumatic(cylinder) = &mut robot.leg.drive {
                    cylinder.supply = GaugePressure(value);
                }
            }
            Parameter::Slope => robot.ground.tilt = value,
        }
        (robot, firing)
    }
}

/// Periodic gaits over a parameter.
#[derive(Clone, Debug)]
pub struct Branch {
    /// The gaits, each with the parameter's value. Where the number of legs changes, so did the
    /// branch: the one before is not found any more, and runs that begin on it come to this one.
    pub gaits: Vec<(f64, Periodic)>,
    /// The value at which none was found, and what the search came to there.
    pub lost: Option<(f64, Search)>,
}

/// Strides in which a run comes from a branch that ends to the gait that it goes on by.
const SETTLING: usize = 120;
/// Legs after which such a gait may repeat.
const MOST_LEGS: usize = 6;

/// Follows `gait` of `robot` under `firing` over the `values` of `parameter`, each from the one
/// before: natural continuation, which follows unstable gaits too. Where it ends (the branch turns
/// back, or what the feet do changes) it goes on by the gait to which runs come from there, if any.
///
/// # Errors
/// [`GaitError::Input`] for a value that cannot be.
pub fn follow(
    (robot, firing): (&Robot, Firing),
    gait: &Periodic,
    parameter: Parameter,
    values: &[f64],
) -> Result<Branch, GaitError> {
    let mut branch = Branch {
        gaits: Vec::new(),
        lost: None,
    };
    let (mut state, mut legs) = (gait.state.clone(), gait.legs);
    for &value in values {
        let (robot, firing) = parameter.at(value, robot, firing);
        match next(&Strides::new(&robot, firing)?, &state, legs)? {
            Search::Found(gait) => {
                (state, legs) = (gait.state.clone(), gait.legs);
                branch.gaits.push((value, *gait));
            }
            lost => {
                branch.lost = Some((value, lost));
                break;
            }
        }
    }
    Ok(branch)
}

/// The gait near `state`, or to which it comes.
fn next(strides: &Strides, state: &StrideState, legs: usize) -> Result<Search, GaitError> {
    match find(strides, state, legs)? {
        Search::Found(gait) => Ok(Search::Found(gait)),
        _ => settle(strides, state, SETTLING, MOST_LEGS),
    }
}
