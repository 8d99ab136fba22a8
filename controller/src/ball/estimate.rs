//! Attitude, rates and way of a ball by its own sensors.

use super::rotation::{Rotation, cross, plus};
use crate::Real;

/// What a ball's sensors say in a cycle, in counts of their converters, along the body's axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Inertial {
    /// The fine gyros: the mean of the cycle.
    pub fine_gyro: [i32; 3],
    /// The coarse ones.
    pub coarse_gyro: [i32; 3],
    /// The fine accelerometers: the mean of the cycle.
    pub fine_accelerometer: [i32; 3],
    /// The coarse ones.
    pub coarse_accelerometer: [i32; 3],
    /// Switches in the feet: bit k is leg k's, 1 where it is pressed.
    pub touching: u64,
}

/// What a count is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scales<R> {
    /// A count of a fine gyro (rad/s).
    pub fine_gyro: R,
    /// A count of a coarse one (rad/s).
    pub coarse_gyro: R,
    /// A count of a fine accelerometer (m/s²).
    pub fine_accelerometer: R,
    /// A count of a coarse one (m/s²).
    pub coarse_accelerometer: R,
    /// Count of a fine one from which on the coarse one is believed.
    pub limit: i32,
}

impl<R: Real> Scales<R> {
    /// Rates (rad/s) about the body's axes, as the gyros say them.
    #[inline]
    pub fn rate(&self, readings: &Inertial) -> [R; 3] {
        let counts = (&readings.fine_gyro, &readings.coarse_gyro);
        self.read(counts, self.fine_gyro, self.coarse_gyro)
    }

    /// Specific force (m/s²) along the body's axes, as the accelerometers say it.
    #[inline]
    pub fn force(&self, readings: &Inertial) -> [R; 3] {
        let counts = (&readings.fine_accelerometer, &readings.coarse_accelerometer);
        self.read(counts, self.fine_accelerometer, self.coarse_accelerometer)
    }

    /// Readings of three axes: the fine one of each, unless it is at its end.
    #[inline]
    fn read(&self, (fine, coarse): (&[i32; 3], &[i32; 3]), small: R, large: R) -> [R; 3] {
        let one = |k: usize| {
            if fine[k] < self.limit && fine[k] > self.limit.wrapping_neg() {
                R::of_count(fine[k]) * small
            } else {
                R::of_count(coarse[k]) * large
            }
        };
        [one(0), one(1), one(2)]
    }
}

/// The feet of a ball.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Feet<'a, R> {
    /// Where each leg points: unit vectors in the body's axes; at most 64 count.
    pub directions: &'a [[R; 3]],
    /// From where the legs meet to the middle of a retracted foot (m).
    pub reach: R,
    /// Radius of a foot (m).
    pub radius: R,
}

/// How sensors are weighed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filter<R> {
    /// Cycle (s).
    pub period: R,
    /// Gravity (m/s²).
    pub gravity: R,
    /// What gyros read at rest (rad/s), along the body's axes.
    pub bias: [R; 3],
    /// How fast (1/s) the velocity follows what a standing foot says.
    pub by_foot: R,
    /// How fast (1/(m s)) the vertical follows what that leaves.
    pub tilt: R,
    /// For how long (s) a foot must be pressed before it is believed.
    pub settles: R,
    /// For how long (s) it is not believed after its leg was fired: it must be home again.
    pub returns: R,
}

/// What a ball knows of its motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate<R> {
    /// Attitude, from the body's axes to the world's.
    pub attitude: Rotation<R>,
    /// Spin (rad/s), the world's axes.
    pub spin: [R; 3],
    /// Velocity of the place where the legs meet (m/s).
    pub velocity: [R; 3],
    /// Where that place is (m), the world's axes.
    pub place: [R; 3],
}

/// Most legs.
const MOST: usize = 64;

/// Makes an [`Estimate`], a cycle at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimator<'a, R> {
    filter: Filter<R>,
    scales: Scales<R>,
    feet: Feet<'a, R>,
    estimate: Estimate<R>,
    /// Cycles for which each foot has been pressed, and since its leg was fired.
    pressed: [u16; MOST],
    fired: [u16; MOST],
}

impl<'a, R: Real> Estimator<'a, R> {
    /// A ball at rest with this `attitude`, its legs meeting at `place` (m).
    pub fn new(
        filter: Filter<R>,
        scales: Scales<R>,
        feet: Feet<'a, R>,
        (attitude, place): (Rotation<R>, [R; 3]),
    ) -> Estimator<'a, R> {
        Estimator {
            filter,
            scales,
            feet,
            estimate: Estimate {
                attitude: attitude.unit(),
                spin: [R::ZERO; 3],
                velocity: [R::ZERO; 3],
                place,
            },
            pressed: [0; MOST],
            fired: [u16::MAX; MOST],
        }
    }

    /// What it knows.
    pub fn estimate(&self) -> &Estimate<R> {
        &self.estimate
    }

    /// The leg has been fired.
    pub fn fired(&mut self, leg: u32) {
        let place = usize::try_from(leg).unwrap_or(MOST);
        if let Some(since) = self.fired.get_mut(place) {
            *since = 0;
        }
    }

    /// Takes a cycle's readings.
    #[inline]
    pub fn take(&mut self, readings: &Inertial) {
        let (f, period) = (self.filter, self.filter.period);
        let gyro = self.scales.rate(readings);
        let force = self.scales.force(readings);
        let rate = plus(&gyro, -R::ONE, &f.bias);
        let e = &mut self.estimate;
        // Half of the turn, where the mean force acted; then the other half.
        let half = Rotation::small(&plus(&[R::ZERO; 3], R::of(0.5) * period, &rate));
        let middle = e.attitude.after(&half);
        let mut pull = middle.turn(&force);
        pull[2] = pull[2] - f.gravity;
        e.attitude = middle.after(&half).unit();
        e.spin = e.attitude.turn(&rate);
        let before = e.velocity;
        e.velocity = plus(&e.velocity, period, &pull);
        let mean = plus(&before, R::ONE, &e.velocity);
        e.place = plus(&e.place, R::of(0.5) * period, &mean);
        self.stand(readings.touching);
    }

    /// What the feet that stand say of velocity and vertical.
    #[inline]
    fn stand(&mut self, touching: u64) {
        let f = self.filter;
        let mut off = [R::ZERO; 3];
        let mut count = 0_i32;
        let feet = self.pressed.iter_mut().zip(&mut self.fired);
        for (k, ((pressed, fired), direction)) in feet.zip(self.feet.directions).enumerate() {
            *fired = fired.saturating_add(1);
            if touching >> k & 1 == 0 {
                *pressed = 0;
                continue;
            }
            *pressed = pressed.saturating_add(1);
            let settled = R::of_count(i32::from(*pressed)) * f.period > f.settles;
            let is_home = R::of_count(i32::from(*fired)) * f.period > f.returns;
            if settled && is_home {
                // A sphere that rolls on the ground: where it touches, it does not move.
                let e = &self.estimate;
                let mut arm = e.attitude.turn(direction).map(|x| x * self.feet.reach);
                arm[2] = arm[2] - self.feet.radius;
                let still = plus(&e.velocity, R::ONE, &cross(&e.spin, &arm));
                off = plus(&off, -R::ONE, &still);
                count += 1;
            }
        }
        if count == 0 {
            return;
        }
        let part = f.period / R::of_count(count);
        let e = &mut self.estimate;
        e.velocity = plus(&e.velocity, part * f.by_foot, &off);
        // A foot that says more velocity to the left than was integrated: the ball leans more to the left than was believed.
        let tilt = part * f.tilt;
        let vector = [-off[1] * tilt, off[0] * tilt, R::ZERO];
        e.attitude = Rotation::small(&vector).after(&e.attitude).unit();
    }
}
