//! What the sensors of a ball say.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use saltus_controller::ball::{Estimator, Feet, Filter, Inertial, Rotation, Scales};
use saltus_robot::{Robot, Sensors};

use crate::cast::{instruments, most_counts, whole};

/// The sensors of a ball, read a cycle at a time: gyros and accelerometers where the legs meet, switches in the feet. Beside a run
/// with the same robot and seed they say what its own say.
#[derive(Clone, Debug)]
pub struct Hearing {
    sensors: Sensors,
    gravity: f64,
    random: Pcg64,
    /// Attitude and velocity (m/s) a cycle ago.
    before: (UnitQuaternion<f64>, Vector3<f64>),
}

impl Hearing {
    /// The sensors of `robot`, at rest with this `attitude` (w, x, y, z); their noise is drawn from `seed`.
    pub fn new(robot: &Robot, attitude: [f64; 4], seed: u64) -> Hearing {
        Hearing {
            sensors: robot.sensors.unwrap_or_default(),
            gravity: robot.environment.gravity,
            random: Pcg64::new(u128::from(seed), 0xba11),
            before: (unit(attitude), Vector3::zeros()),
        }
    }

    /// What they say a period after they were last read, with this attitude (w, x, y, z), velocity (m/s) and feet on the ground;
    /// gyros and accelerometers give the mean over the period.
    pub fn read(&mut self, attitude: [f64; 4], velocity: [f64; 3], touching: u64) -> Inertial {
        let (s, attitude, velocity) = (self.sensors, unit(attitude), Vector3::from(velocity));
        let (was, slower) = std::mem::replace(&mut self.before, (attitude, velocity));
        let turned = (was.inverse() * attitude).scaled_axis();
        let middle = was * UnitQuaternion::new(turned * 0.5);
        let pull = (velocity - slower) / s.period + Vector3::z() * self.gravity;
        let spin = turned / s.period;
        let force = middle.inverse() * pull;
        let mut read = |x: &Vector3<f64>, bias: f64, noise: f64, range: f64| {
            std::array::from_fn(|k| {
                let draw: f64 = StandardNormal.sample(&mut self.random);
                let most = most_counts(s.converter_bits);
                let x = (x[k] + bias + noise * draw) / range * most;
                whole(x.clamp(-most, most))
            })
        };
        let mut gyro = |range| read(&spin, s.gyro_bias, s.gyro_noise, range);
        let (fine_gyro, coarse_gyro) = (gyro(s.fine_gyro_range), gyro(s.coarse_gyro_range));
        let mut meter = |range| read(&force, s.accelerometer_bias, s.accelerometer_noise, range);
        Inertial {
            fine_gyro,
            coarse_gyro,
            fine_accelerometer: meter(s.fine_accelerometer_range),
            coarse_accelerometer: meter(s.coarse_accelerometer_range),
            touching,
        }
    }
}

fn unit([w, x, y, z]: [f64; 4]) -> UnitQuaternion<f64> {
    UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z))
}

/// How fast (1/s) the velocity follows a standing foot, and (1/(m s)) the vertical.
const BY_FOOT: f64 = 40.0;
const TILT: f64 = 0.1;
/// For how long (s) a foot must stand to be believed, and for how long it is not once its leg was fired.
const SETTLES: f64 = 0.03;
const RETURNS: f64 = 0.25;

/// What makes the motion of `robot`, whose legs point along `directions`, of its readings; it is at rest at `start`:
/// attitude and place (m).
pub(super) fn estimator<'a>(
    robot: &Robot,
    directions: &'a [[f64; 3]],
    start: (Rotation<f64>, [f64; 3]),
) -> Estimator<'a, f64> {
    let sensors = robot.sensors.unwrap_or_default();
    Estimator::new(
        filter(robot),
        scales(&sensors),
        feet(robot, directions),
        start,
    )
}

/// How the sensors of `robot` are weighed.
pub(super) fn filter(robot: &Robot) -> Filter<f64> {
    let sensors = robot.sensors.unwrap_or_default();
    Filter {
        period: sensors.period,
        gravity: robot.environment.gravity,
        bias: [sensors.gyro_bias; 3],
        by_foot: BY_FOOT,
        tilt: TILT,
        settles: SETTLES,
        returns: RETURNS,
    }
}

/// The feet of `robot`, whose legs point along `directions`.
pub(super) fn feet<'a>(robot: &Robot, directions: &'a [[f64; 3]]) -> Feet<'a, f64> {
    let radius = robot.foot.radius;
    Feet {
        directions,
        reach: robot.body.radius - radius,
        radius,
    }
}

/// What a count of `sensors` is.
pub(super) fn scales(sensors: &Sensors) -> Scales<f64> {
    let scale = instruments(sensors);
    Scales {
        fine_gyro: scale.fine_gyro,
        coarse_gyro: scale.coarse_gyro,
        fine_accelerometer: scale.fine_accelerometer,
        coarse_accelerometer: sensors.coarse_accelerometer_range
            / most_counts(sensors.converter_bits),
        limit: scale.fine_limit,
    }
}
