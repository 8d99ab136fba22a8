//! What the library refuses of a run, as what the user typed.

use saltus::Robot;
use saltus::gait::GaitError;

use crate::error::CliError;

/// The flag or the file that `error` is about; firing angles are those of the flags `angles`.
pub(crate) fn refused(error: GaitError, robot: &Robot, angles: &'static str) -> CliError {
    let name = &robot.name;
    match error {
        GaitError::Input {
            name: what,
            value,
            allowed,
        } => {
            let flag = match what.as_str() {
                "legs" => {
                    let reason = format!("body.legs = {value}: must be {allowed}");
                    return CliError::content(name, reason);
                }
                "start of the active zone (rad)" => "--zone",
                "length of the run (s)" => "--seconds",
                "taps of the filter" | "sum of the filter's taps" => "--taps",
                "valve opening time (s)" => "--valve-open",
                "firing angle (rad)" => {
                    let value = format!("({what} = {value})");
                    return CliError::flag(angles, value, allowed + " (--zone moves it)");
                }
                "rate of a law's knot (rad/s)" | "knots of a law" => "--knots",
                "length of the boom (m)" | "speeds measured (m/s)" => "speed",
                "B (1/s)" => "--steepness",
                "C" => "--shift",
                _ => "--disturb",
            };
            CliError::flag(flag, format!("({what} = {value})"), allowed)
        }
        _ => CliError::content(name, error),
    }
}
