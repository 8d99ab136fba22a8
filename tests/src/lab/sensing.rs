//! What a sensor does to the number that it measures.

use super::dial::{Dial, Hidden};
use super::draw::Draw;

/// A measured column.
#[derive(Clone, Copy, Debug)]
pub(super) struct Column {
    /// What it is called.
    pub name: &'static str,
    /// Standard deviation of its noise; 0: none.
    pub noise: f64,
    /// Its step, where it is quantised; else 0.
    pub resolution: f64,
}

impl Column {
    /// Without steps.
    pub(super) fn noisy(name: &'static str, noise: f64) -> Column {
        Column {
            name,
            noise,
            resolution: 0.0,
        }
    }

    /// One standard deviation of all that blurs it.
    pub(super) fn sigma(&self) -> f64 {
        (self.noise * self.noise + self.resolution * self.resolution / 12.0).sqrt()
    }

    /// As read: with `noise`, then rounded to its steps.
    pub(super) fn read(&self, value: f64, noise: f64) -> f64 {
        let value = value + noise;
        if self.resolution > 0.0 {
            (value / self.resolution).round() * self.resolution
        } else {
            value
        }
    }
}

/// Noise of a column from row to row: AR(1), as strong at the first row as at any other.
pub(super) struct Noise {
    deviation: f64,
    autocorrelation: f64,
    before: Option<f64>,
}

impl Noise {
    pub(super) fn new(column: &Column, autocorrelation: f64) -> Noise {
        Noise {
            deviation: column.noise,
            autocorrelation,
            before: None,
        }
    }

    /// That of the next row.
    pub(super) fn next(&mut self, draw: &mut Draw) -> f64 {
        let (phi, new) = (self.autocorrelation, draw.normal(self.deviation));
        let noise = self
            .before
            .map_or(new, |before| phi * before + (1.0 - phi * phi).sqrt() * new);
        self.before = Some(noise);
        noise
    }
}

/// The keys of what may be done to a column.
struct Keys {
    name: &'static str,
    gain: &'static str,
    offset: &'static str,
    delay: &'static str,
    ripple: &'static str,
    ripple_rate: &'static str,
    gear: &'static str,
    gear_length: &'static str,
    ceiling: &'static str,
}

macro_rules! keys {
    ($($name:literal),*) => {
        &[$(Keys {
            name: $name,
            gain: concat!($name, " gain"),
            offset: concat!($name, " offset"),
            delay: concat!($name, " delay_s"),
            ripple: concat!($name, " ripple"),
            ripple_rate: concat!($name, " ripple_rad_s"),
            gear: concat!($name, " gear_ripple"),
            gear_length: concat!($name, " gear_length"),
            ceiling: concat!($name, " ceiling"),
        }),*]
    };
}

const KEYS: &[Keys] = keys![
    "position_m",
    "pressure_pa",
    "pivot_angle_rad",
    "wheel_angle_rad",
    "radius_angle_rad",
    "wheel_rate_rad_s",
    "x_m",
    "y_m",
    "distance_m",
    "apex_m",
    "force_n",
    "pressure_gauge_pa",
    "temperature_k",
    "angle_rad",
    "tank_pressure_gauge_pa",
    "knee_right_pressure_gauge_pa",
    "hip_right_pressure_gauge_pa",
    "hip_left_pressure_gauge_pa",
    "knee_left_pressure_gauge_pa",
    "com_y_m"
];

fn keys_of(column: &str) -> Option<&'static Keys> {
    KEYS.iter().find(|keys| keys.name == column)
}

/// What is known of a column before an effect is put on it.
pub(super) struct Seen<'a> {
    pub column: &'a Column,
    /// Least and greatest exact value in any run.
    pub range: (f64, f64),
    /// Length (s) of the longest run.
    pub length: f64,
    /// Longest delay (s) that makes sense.
    pub delay: f64,
}

/// The dials of the effect `id` on a column, if it is one of a sensor.
pub(super) fn dials(id: &str, seen: &Seen, draw: &mut Draw) -> Option<Vec<Dial>> {
    let keys = keys_of(seen.column.name)?;
    let (low, high) = seen.range;
    let sign = draw.one(&[-1.0, 1.0]);
    let (most, sigma) = ((high - low).max(1e-12), seen.column.sigma());
    Some(match id {
        "encoder-scale" => vec![Dial::linear(keys.gain, 1.0, 1.0 + sign * 0.3)],
        "sensor-offset" => vec![Dial::up_to(keys.offset, sign * 20.0 * sigma)],
        "sensor-delay" => vec![Dial::up_to(keys.delay, seen.delay)],
        // From some to some tens of periods in a run.
        "ripple" => {
            let rate = std::f64::consts::TAU * draw.scale(5.0, 15.0) / seen.length;
            vec![
                Dial::up_to(keys.ripple, 20.0 * sigma),
                Dial::fixed(keys.ripple_rate, rate),
            ]
        }
        // Waves over the column's own value, as of a gear or an eccentric disc.
        "gear-ripple" => {
            let length = most / draw.between(1.5, 4.0);
            vec![
                Dial::up_to(keys.gear, 20.0 * sigma),
                Dial::fixed(keys.gear_length, length),
            ]
        }
        "saturation" => vec![Dial::linear(keys.ceiling, high, low)],
        _ => return None,
    })
}

/// Applies to the exact `values` of a column at `time` what is `hidden` in its sensor.
pub(super) fn sense(column: &str, time: &[f64], values: &mut [f64], hidden: &Hidden) {
    let Some(keys) = keys_of(column) else { return };
    let delay = hidden.or_zero(keys.delay);
    if delay > 0.0 {
        let late: Vec<f64> = time
            .iter()
            .map(|t| interpolated(time, values, t - delay))
            .collect();
        values.copy_from_slice(&late);
    }
    let (gain, offset) = (hidden.get(keys.gain, 1.0), hidden.or_zero(keys.offset));
    let (ripple, rate) = (
        hidden.or_zero(keys.ripple),
        hidden.or_zero(keys.ripple_rate),
    );
    let (gear, length) = (hidden.or_zero(keys.gear), hidden.get(keys.gear_length, 1.0));
    let ceiling = hidden.get(keys.ceiling, f64::INFINITY);
    for (t, value) in time.iter().zip(values) {
        let wave =
            ripple * (rate * t).sin() + gear * (std::f64::consts::TAU * *value / length).sin();
        *value = (gain * *value + offset + wave).min(ceiling);
    }
}

/// The cubic through the four rows about `t`; before the first row the line through two.
fn interpolated(time: &[f64], values: &[f64], t: f64) -> f64 {
    let n = time.len();
    if n < 4 {
        return values[0];
    }
    let k = time.partition_point(|x| *x <= t);
    let rows = if k == 0 {
        0..2
    } else {
        k.clamp(2, n - 2) - 2..k.clamp(2, n - 2) + 2
    };
    rows.clone()
        .map(|i| {
            let others = rows.clone().filter(|j| *j != i);
            values[i]
                * others
                    .map(|j| (t - time[j]) / (time[i] - time[j]))
                    .product::<f64>()
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Variance and lag-1 autocorrelation of a long series.
    #[test]
    fn noise_follows_from_row_to_row() {
        let (mut noise, mut draw) = (
            Noise::new(&Column::noisy("x_m", 2.0), 0.65),
            Draw::new(1, 1),
        );
        let all: Vec<f64> = (0..40_000).map(|_| noise.next(&mut draw)).collect();
        let mean = |lag: usize| {
            let products = all[lag..].iter().zip(&all).map(|(a, b)| a * b);
            products.sum::<f64>() / (all.len() - lag) as f64
        };
        // Four standard deviations of the variance's estimate, and of the correlation's.
        assert!((mean(0) / 4.0 - 1.0).abs() < 0.045, "{}", mean(0));
        assert!((mean(1) / mean(0) - 0.65).abs() < 0.016, "{}", mean(1));
    }

    #[test]
    fn a_delayed_sensor_shows_what_was() {
        let time: Vec<f64> = (0..50).map(|i| 0.02 * f64::from(i)).collect();
        let mut values: Vec<f64> = time.iter().map(|t| 1.0 + t * (2.0 - 4.9 * t)).collect();
        sense(
            "y_m",
            &time,
            &mut values,
            &Hidden::of(&[Dial::fixed("y_m delay_s", 0.013)], 1.0),
        );
        for (t, y) in time.iter().zip(&values).skip(3) {
            let then = t - 0.013;
            assert!((y - (1.0 + then * (2.0 - 4.9 * then))).abs() < 1e-12, "{t}");
        }
    }

    #[test]
    fn gain_offset_and_ceiling_come_in_this_order() {
        let dials = [
            Dial::fixed("x_m gain", 2.0),
            Dial::fixed("x_m offset", 1.0),
            Dial::fixed("x_m ceiling", 6.0),
        ];
        let mut values = [1.0, 2.0, 3.0];
        sense(
            "x_m",
            &[0.0, 1.0, 2.0],
            &mut values,
            &Hidden::of(&dials, 1.0),
        );
        assert_eq!(values, [3.0, 5.0, 6.0]);
    }
}
