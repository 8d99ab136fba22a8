//! A robot's sensors as the controller's constants.

use std::f64::consts::TAU;

use saltus_controller::run::Instruments;
use saltus_robot::Sensors;

/// Part of the fine gyro's range beyond which the coarse one is believed.
const TRUSTED: f64 = 0.98;

/// Greatest count of a converter of `bits`, of both signs.
pub(crate) fn most_counts(bits: f64) -> f64 {
    (bits - 1.0).exp2() - 1.0
}

/// What a count of each of `sensors` is.
pub fn instruments(sensors: &Sensors) -> Instruments<f64> {
    let most = most_counts(sensors.converter_bits);
    Instruments {
        wheel: TAU / sensors.wheel_counts.round(),
        wheel_turn: whole(sensors.wheel_counts),
        radius: TAU / sensors.radius_counts.round(),
        pivot: TAU / sensors.pivot_counts.round(),
        fine_gyro: sensors.fine_gyro_range / most,
        fine_limit: whole(TRUSTED * most),
        coarse_gyro: sensors.coarse_gyro_range / most,
        fine_accelerometer: sensors.fine_accelerometer_range / most,
        accelerometer_limit: whole(most),
    }
}

/// `x` as a whole number within the range of one.
#[allow(clippy::cast_possible_truncation)]
pub(crate) fn whole(x: f64) -> i32 {
    x.round() as i32
}
