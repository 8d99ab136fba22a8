//! A flight that another simulation has computed: its states at some times, and cubics between.

use saltus_numeric::Single;

use crate::clearance::{check_span, clearance};
use crate::path::{Arc, Path, settle};
use crate::polynomial::{Polynomial, root_between};
use crate::state::State;
use crate::{Disc, Flight, FlightError, Obstacle};

/// The wheel's centre at one time of a flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlightSample<S> {
    /// Time (s) after lift-off.
    pub time: f64,
    /// Position [x, y] (m).
    pub position: [S; 2],
    /// Velocity [v_x, v_y] (m/s).
    pub velocity: [S; 2],
}

/// A flight given by samples; between two of them it is the cubic through both positions and
/// velocities.
///
/// With samples h apart a cubic is off by x⁗ h⁴/384: for drag, whose fourth derivative is some m/s⁴,
/// 1e-14 m at a millisecond.
///
/// ```
/// use saltus_ballistic::{FlightError, FlightSample, SampledFlight};
/// // A parabola under 10 m/s² from 0.3 m, upwards at 2 m/s.
/// let sample = |time: f64| FlightSample {
///     time,
///     position: [time, 0.3 + 2.0 * time - 5.0 * time * time],
///     velocity: [1.0, 2.0 - 10.0 * time],
/// };
/// let flight = SampledFlight::new([0.0, 0.25, 0.6].map(sample).to_vec())?;
/// assert!((flight.apex_height() - 0.5).abs() < 1e-12);
/// assert!((flight.time_to_height(0.3)? - 0.4).abs() < 1e-12);
/// # Ok::<(), FlightError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SampledFlight<S> {
    samples: Vec<FlightSample<S>>,
}

impl<S: Single> SampledFlight<S> {
    /// The flight of `samples`, the first of which is the lift-off.
    ///
    /// # Errors
    /// [`FlightError::BadSamples`] unless there are two or more, at rising times, of finite numbers.
    pub fn new(samples: Vec<FlightSample<S>>) -> Result<SampledFlight<S>, FlightError> {
        let is_finite = |s: &FlightSample<S>| {
            let numbers = s.position.into_iter().chain(s.velocity);
            s.time.is_finite() && numbers.into_iter().all(|x| x.value().is_finite())
        };
        let rises = samples.windows(2).all(|pair| pair[0].time < pair[1].time);
        if samples.len() >= 2 && rises && samples.iter().all(is_finite) {
            Ok(SampledFlight { samples })
        } else {
            let samples = samples.len();
            Err(FlightError::BadSamples { samples })
        }
    }

    /// The samples that it was made of.
    pub fn samples(&self) -> &[FlightSample<S>] {
        &self.samples
    }

    /// The state at `time` (s) after lift-off; before the first sample and after the last the
    /// nearest cubic goes on.
    pub fn at(&self, time: f64) -> FlightSample<S> {
        let State {
            position, velocity, ..
        } = self.state(S::of(time));
        FlightSample {
            time,
            position,
            velocity,
        }
    }

    /// Position [x, y] (m) at time `t` (s) after lift-off.
    pub fn position(&self, t: S) -> [S; 2] {
        self.state(t).position
    }

    /// Position (m) and velocity (m/s) at time `t` (s) after lift-off.
    pub fn motion(&self, t: S) -> [[S; 2]; 2] {
        let state = self.state(t);
        [state.position, state.velocity]
    }

    /// Greatest height (m) from lift-off on.
    pub fn apex_height(&self) -> S {
        self.state(self.apex_time()).position[1]
    }

    /// Time (s) at which the centre is highest.
    fn apex_time(&self) -> S {
        let falls = |s: &FlightSample<S>| s.velocity[1].value() <= 0.0;
        match self.samples.iter().position(falls) {
            Some(0) => S::of(self.samples[0].time),
            Some(k) => self.root([k - 1, k], |state| {
                [state.velocity[1], state.acceleration[1]]
            }),
            None => S::of(self.end()),
        }
    }

    /// Time (s) from lift-off until the centre comes down to `height` (m).
    ///
    /// # Errors
    /// [`FlightError::AboveApex`], [`FlightError::HeightNotFinite`], or
    /// [`FlightError::BelowSamples`] for a height at which the samples do not arrive.
    pub fn time_to_height(&self, height: S) -> Result<S, FlightError> {
        let (top, asked) = (self.apex_time(), height.value());
        let apex = self.state(top).position[1].value();
        if !asked.is_finite() {
            return Err(FlightError::HeightNotFinite { height: asked });
        }
        if asked > apex {
            return Err(FlightError::AboveApex {
                height: asked,
                apex,
            });
        }
        let is_below = |s: &FlightSample<S>| s.time > top.value() && s.position[1].value() < asked;
        match self.samples.iter().position(is_below) {
            Some(0) => Ok(S::of(self.samples[0].time)),
            Some(k) => {
                let (before, after) = (self.samples[k - 1].time, self.samples[k].time);
                let span = [before.max(top.value()), after];
                Ok(self.root_in(span, |state| {
                    [state.position[1] - height, state.velocity[1]]
                }))
            }
            None => Err(FlightError::BelowSamples {
                height: asked,
                lowest: self.samples[self.samples.len() - 1].position[1].value(),
            }),
        }
    }

    /// Forward position (m) at which the wheel's centre comes down to `height` (m).
    ///
    /// # Errors
    /// As [`time_to_height`](SampledFlight::time_to_height).
    pub fn range_to_height(&self, height: S) -> Result<S, FlightError> {
        Ok(self.position(self.time_to_height(height)?)[0])
    }

    /// Least clearance (m) of `disc` over `obstacle` from time `from` to `to` (s) after lift-off, as
    /// [`Flight::clearance`].
    ///
    /// # Errors
    /// [`FlightError::EmptySpan`] unless `from` ≤ `to`, finite.
    pub fn clearance(
        &self,
        disc: &Disc<S>,
        obstacle: &Obstacle,
        from: S,
        to: S,
    ) -> Result<S, FlightError> {
        check_span(from, to)?;
        Ok(clearance(self, disc, obstacle, [from, to]))
    }

    /// The same flight from a place `by` (m) farther along.
    #[must_use]
    pub fn shifted(&self, by: S) -> SampledFlight<S> {
        let mut samples = self.samples.clone();
        for sample in &mut samples {
            sample.position[0] = sample.position[0] + by;
        }
        SampledFlight { samples }
    }

    /// The parabola of the same lift-off and apex; under the gravity of the first piece where the
    /// centre does not rise.
    pub fn parabola(&self) -> Flight<f64> {
        let first = &self.samples[0];
        let ([x, y], [vx, vy]) = (first.position.map(S::value), first.velocity.map(S::value));
        let rise = self.apex_height().value() - y;
        let gravity = if rise > 0.0 && vy > 0.0 {
            0.5 * vy * vy / rise
        } else {
            -self.state(S::of(first.time)).acceleration[1].value()
        };
        Flight {
            x,
            y,
            vx,
            vy,
            gravity: gravity.max(0.0),
        }
    }

    fn end(&self) -> f64 {
        self.samples[self.samples.len() - 1].time
    }

    /// Where between two samples a function, given as its value and its slope in time, falls
    /// through 0.
    fn root(&self, [a, b]: [usize; 2], of: impl Fn(&State<S>) -> [S; 2]) -> S {
        self.root_in([self.samples[a].time, self.samples[b].time], of)
    }

    fn root_in(&self, span: [f64; 2], of: impl Fn(&State<S>) -> [S; 2]) -> S {
        let at = |t: S| of(&self.state(t));
        let time = root_between(span[0], span[1], |t| at(S::of(t)).map(S::value));
        settle(time, span, at)
    }
}

impl<S: Single> Path<S> for SampledFlight<S> {
    fn state(&self, t: S) -> State<S> {
        let after = self.samples.partition_point(|s| s.time <= t.value());
        let k = after.clamp(1, self.samples.len() - 1);
        cubic(&self.samples[k - 1], &self.samples[k], t)
    }

    fn arcs(&self, from: f64, to: f64) -> impl Iterator<Item = Arc> {
        let last = self.samples.len() - 1;
        // The first and the last piece go on beyond their ends.
        let span = move |k: usize, a: f64, b: f64| {
            let start = if k == 1 { from } else { a.max(from) };
            [start, if k == last { to } else { b.min(to) }]
        };
        self.samples
            .windows(2)
            .zip(1..)
            .filter_map(move |(pair, k)| {
                let (a, b) = (&pair[0], &pair[1]);
                let span = span(k, a.time, b.time);
                (span[0] < span[1]).then(|| {
                    let h = b.time - a.time;
                    // Through both positions, with the mean acceleration.
                    let parabola = |i: usize| {
                        let [p, q] = [a.position[i].value(), b.position[i].value()];
                        let bend = 0.5 * (b.velocity[i].value() - a.velocity[i].value()) / h;
                        Polynomial::quadratic(p, (q - p) / h - bend * h, bend)
                    };
                    Arc {
                        x: parabola(0),
                        y: parabola(1),
                        start: a.time,
                        span,
                    }
                })
            })
    }
}

/// The state at `t` (s) on the cubic through two samples.
fn cubic<S: Single>(a: &FlightSample<S>, b: &FlightSample<S>, t: S) -> State<S> {
    let h = b.time - a.time;
    let s = (t - S::of(a.time)) * S::of(1.0 / h);
    let of = |x: f64| S::of(x);
    // x = p + h u s + c s² + d s³ with c and d from the far end.
    let piece = |i: usize| {
        let (p, q) = (a.position[i], b.position[i]);
        let (u, v) = (a.velocity[i] * of(h), b.velocity[i] * of(h));
        let away = q - p;
        let (c, d) = (of(3.0) * away - of(2.0) * u - v, u + v - of(2.0) * away);
        [
            p + s * (u + s * (c + s * d)),
            (u + s * (of(2.0) * c + of(3.0) * s * d)) * of(1.0 / h),
            (of(2.0) * c + of(6.0) * s * d) * of(1.0 / (h * h)),
        ]
    };
    let (x, y) = (piece(0), piece(1));
    State {
        position: [x[0], y[0]],
        velocity: [x[1], y[1]],
        acceleration: [x[2], y[2]],
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::check::{close, config, flights};

    /// Samples of a parabola, `count` steps from lift-off to `end` (s).
    fn sampled(flight: &Flight<f64>, end: f64, count: usize) -> SampledFlight<f64> {
        let sample = |k: usize| {
            let time = end * k as f64 / count as f64;
            FlightSample {
                time,
                position: flight.position(time),
                velocity: flight.velocity(time),
            }
        };
        SampledFlight::new((0..=count).map(sample).collect()).unwrap()
    }

    proptest! {
        #![proptest_config(config())]

        /// A cubic through two states of a parabola is that parabola.
        #[test]
        fn a_parabola_in_samples_is_that_parabola(flight in flights(), count in 1..20_usize, down in 0.05..0.95_f64) {
            let floor = flight.y.min(flight.apex_height()) - 1.0;
            let end = flight.time_to_height(floor).unwrap();
            let other = sampled(&flight, end, count);
            let size = flight.apex_height().abs() + floor.abs() + 1.0;
            prop_assert!((other.apex_height() - flight.apex_height()).abs() < 1e-9 * size);
            let height = floor + down * (flight.y - floor);
            let (t, exact) = (other.time_to_height(height).unwrap(), flight.time_to_height(height).unwrap());
            prop_assert!(close(t, exact, 1e-7), "{t} and {exact}");
            let wall = Obstacle::block([flight.x + 0.4 * flight.vx * end, floor - 1.0], [flight.x + 0.4 * flight.vx * end + 0.5, flight.y]).unwrap();
            let gap = other.clearance(&Disc::wheel(0.2), &wall, 0.0, exact).unwrap();
            let wanted = flight.clearance(&Disc::wheel(0.2), &wall, 0.0, exact).unwrap();
            prop_assert!((gap - wanted).abs() < 1e-8 * size, "{gap} and {wanted}");
            let near = other.parabola();
            if flight.vy > 1e-3 {
                prop_assert!(close(near.gravity, flight.gravity, 1e-4), "{near:?}");
            }
        }
    }

    #[test]
    fn what_is_no_flight_is_refused() {
        let at = |time: f64| FlightSample {
            time,
            position: [0.0, 1.0],
            velocity: [1.0, f64::from(time == 0.5)],
        };
        for times in [&[0.0][..], &[0.0, 0.0], &[1.0, 0.0], &[0.0, f64::NAN]] {
            let samples: Vec<_> = times.iter().map(|&t| at(t)).collect();
            assert!(SampledFlight::new(samples).is_err(), "{times:?}");
        }
        let flight = SampledFlight::new(vec![at(0.0), at(1.0)]).unwrap();
        assert!(matches!(
            flight.time_to_height(0.5),
            Err(FlightError::BelowSamples { .. })
        ));
        assert!(matches!(
            flight.time_to_height(1.5),
            Err(FlightError::AboveApex { .. })
        ));
    }
}
