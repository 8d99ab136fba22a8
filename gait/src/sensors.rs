//! What the sensors of a running robot say.

use nalgebra::Rotation3;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use saltus_controller::run::Readings;
use saltus_robot::Sensors;
use saltus_sim_check::{Rig, Vec3};

use crate::cast::{most_counts, whole};

/// The sensors of a robot, read a cycle at a time.
#[derive(Clone, Debug)]
pub struct Sensing {
    sensors: Sensors,
    random: Pcg64,
    /// Velocity of the axle (m/s) and rate of the wheel (rad/s) a cycle ago.
    before: Option<(Vec3, f64)>,
}

impl Sensing {
    /// `sensors`, whose noise is drawn from `random`.
    pub fn new(sensors: Sensors, random: Pcg64) -> Sensing {
        Sensing {
            sensors,
            random,
            before: None,
        }
    }

    /// What they say of `rig` at coordinates `q` and velocities `v`, a period after they were last
    /// read. An accelerometer gives the mean of the period: impacts within it count.
    pub fn read(&mut self, rig: &Rig, q: &[f64], v: &[f64]) -> Readings {
        let s = self.sensors;
        let turn = |angle: f64, counts: f64| whole(angle * counts.round() / std::f64::consts::TAU);
        let (radius, pivot) = match rig.boom {
            Some(_) => (turn(q[0], s.radius_counts), turn(q[1], s.pivot_counts)),
            None => (0, 0),
        };
        let (lean, rate) = (q[rig.lean_coordinate()], v[rig.lean_velocity()]);
        let spin = rig.spin(q, v);
        let gyro = |random: &mut Pcg64| spin + s.gyro_bias + s.gyro_noise * normal(random);
        let (fine, coarse) = (gyro(&mut self.random), gyro(&mut self.random));
        let force = self.specific_force(rig, q, v, lean, rate);
        let mut accelerometer = |range: f64| {
            force.map(|x| {
                let noise = s.accelerometer_noise * normal(&mut self.random);
                converted(x + s.accelerometer_bias + noise, range, s.converter_bits)
            })
        };
        Readings {
            wheel: turn(lean, s.wheel_counts),
            radius,
            pivot,
            fine_gyro: converted(fine, s.fine_gyro_range, s.converter_bits),
            coarse_gyro: converted(coarse, s.coarse_gyro_range, s.converter_bits),
            fine_accelerometer: accelerometer(s.fine_accelerometer_range),
            coarse_accelerometer: accelerometer(s.coarse_accelerometer_range),
        }
    }

    /// Acceleration less gravity (m/s²) at the accelerometers, along the wheel's axes: forwards and
    /// up at lean 0. They sit forwards of the axle.
    fn specific_force(
        &mut self,
        rig: &Rig,
        q: &[f64],
        v: &[f64],
        lean: f64,
        rate: f64,
    ) -> [f64; 2] {
        let [along, up] = rig.axle_rates(q, v);
        let axle = Vec3::new(along, 0.0, up);
        let period = self.sensors.period;
        let (acceleration, spin) = match self.before.replace((axle, rate)) {
            Some((velocity, before)) => ((axle - velocity) / period, (rate - before) / period),
            None => (Vec3::zeros(), 0.0),
        };
        let gravity = rig.mechanism.gravity;
        let gravity = Vec3::new(gravity.x, 0.0, gravity.z);
        // The wheel turns about +y, which carries x to −z.
        let turned = Rotation3::from_axis_angle(&Vec3::y_axis(), lean);
        let [x, _, z]: [f64; 3] = (turned.inverse() * (acceleration - gravity)).into();
        let arm = self.sensors.accelerometer_radius;
        [x - rate * rate * arm, z - spin * arm]
    }
}

/// The range sensor: the distance from the axle to the front of the next box, now and then.
#[derive(Clone, Debug)]
pub struct Ranging {
    sensors: Sensors,
    random: Pcg64,
    /// Readings so far.
    count: u32,
}

impl Ranging {
    /// That of `sensors`, whose noise is drawn from `seed`.
    pub fn new(sensors: Sensors, seed: u64) -> Ranging {
        Ranging {
            sensors,
            random: Pcg64::new(u128::from(seed), 0x4a96),
            count: 0,
        }
    }

    /// Its reading (m) in the cycle of `time` (s), if there is one then: the axle has travelled
    /// `travel` (m), the boxes' fronts are `fronts` (m). What is beyond its reach gives none.
    pub fn read(
        &mut self,
        time: f64,
        travel: f64,
        fronts: impl Iterator<Item = f64>,
    ) -> Option<f64> {
        let due = f64::from(self.count) * self.sensors.range_period;
        if time < due - 1e-9 {
            return None;
        }
        self.count += 1;
        // Drawn for each reading, so that what is seen does not change the noise of later ones.
        let noise = self.sensors.range_noise * normal(&mut self.random);
        let next = fronts
            .map(|front| front - travel)
            .filter(|distance| *distance > 0.0)
            .fold(f64::INFINITY, f64::min);
        (next <= self.sensors.range_reach).then_some(next + noise)
    }
}

/// A draw of the standard normal distribution.
fn normal(random: &mut Pcg64) -> f64 {
    StandardNormal.sample(random)
}

/// `x` in counts of a converter of `bits` for ±`range`, at its end where it is beyond.
fn converted(x: f64, range: f64, bits: f64) -> i32 {
    let most = most_counts(bits);
    whole((x / range * most).clamp(-most, most))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn readings(noise: f64, reach: f64) -> Vec<(u32, f64)> {
        let sensors = Sensors {
            range_noise: noise,
            range_reach: reach,
            range_period: 0.05,
            ..Sensors::default()
        };
        let mut ranging = Ranging::new(sensors, 1);
        let of = |k: u32| {
            let time = f64::from(k) * 1e-3;
            // 1 m/s towards a box at 2 m; one at 5 m is behind it.
            let fronts = [5.0, 2.0].into_iter();
            ranging.read(time, time, fronts).map(|reading| (k, reading))
        };
        (0..3000).filter_map(of).collect()
    }

    #[test]
    fn the_range_sensor_sees_the_next_box_within_its_reach() {
        let all = readings(0.0, 1.5);
        // From 1.5 m before the first box until its front is beneath the axle, each 50 ms; then the
        // other one is too far.
        let ks: Vec<u32> = all.iter().map(|(k, _)| *k).collect();
        assert_eq!(ks, (10..40).map(|k| 50 * k).collect::<Vec<_>>());
        for (k, reading) in all {
            assert!((reading - (2.0 - f64::from(k) * 1e-3)).abs() < 1e-12);
        }
        let far = readings(0.0, 4.0);
        assert_eq!(far.len(), 60);
        assert!((far[40].1 - 3.0).abs() < 1e-12, "{:?}", far[40]);
    }

    #[test]
    fn the_range_sensor_has_noise() {
        let off = |k: u32| 2.0 - f64::from(k) * 1e-3;
        let near = readings(0.02, 4.0);
        let near = near.iter().filter(|(k, _)| *k < 2000);
        let errors: Vec<f64> = near.map(|(k, reading)| reading - off(*k)).collect();
        let mean = errors.iter().sum::<f64>() / 40.0;
        let sd = (errors.iter().map(|e| e * e).sum::<f64>() / 40.0).sqrt();
        // 40 draws of 20 mm: the mean within 3 standard errors, 9.5 mm, the deviation within 3 of
        // its own, 6.7 mm.
        assert!(
            mean.abs() < 9.5e-3 && (sd - 0.02).abs() < 6.7e-3,
            "{mean} {sd}"
        );
    }
}
