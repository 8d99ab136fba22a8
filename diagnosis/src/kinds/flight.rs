//! A body in free flight or fall, or a robot in flight at the end of a boom.

use crate::kind::{Cause, Channel, Kind, Log, Parameter, Terms};

/// Flights, with what is believed of them.
#[derive(Clone, Debug)]
pub struct Flights {
    /// Acceleration of gravity (m/s²).
    pub gravity: f64,
    channels: Vec<Channel>,
    logs: Vec<Log>,
    causes: Vec<Cause>,
    /// Whether channel number k is the height.
    is_height: Vec<bool>,
}

/// Columns of a flight.
pub const COLUMNS: [&str; 2] = ["x_m", "y_m"];

/// Longest step (s) of the integration: its error is below a nanometre for anything that flies.
const STEP: f64 = 5e-3;

impl Flights {
    /// Flights whose `channels` are of [`COLUMNS`]; `on_boom`: at the end of a boom.
    pub fn new(gravity: f64, channels: Vec<Channel>, logs: Vec<Log>, on_boom: bool) -> Flights {
        let one = |id, name, neutral, bounds, scale, starts: &[f64]| Cause {
            id,
            parameters: vec![Parameter { name, neutral, bounds, scale, starts: starts.to_vec() }],
        };
        let mut causes = vec![one("air-drag", "drag_per_m", 0.0, (0.0, 10.0), 1e-3, &[0.01, 0.1])];
        if on_boom {
            // Less effective gravity and more inertia: both at once are one ratio.
            causes.push(one("counterweight", "gravity_share", 1.0, (0.02, 2.0), 0.01, &[0.5]));
        }
        causes.push(one("gravity", "gravity_m_s2", gravity, (0.1, 40.0), 0.05, &[0.5 * gravity]));
        for channel in &channels {
            let (scale, delay) = match channel.name {
                "x_m" => ("x_scale", "x_delay_s"),
                _ => ("y_scale", "y_delay_s"),
            };
            causes.push(one("encoder-scale", scale, 1.0, (0.2, 5.0), 0.01, &[0.9, 1.1]));
            if channels.len() > 1 {
                causes.push(one("sensor-delay", delay, 0.0, (-0.1, 0.5), 1e-3, &[0.01]));
            }
        }
        let is_height = channels.iter().map(|c| c.name == "y_m").collect();
        Flights { gravity, channels, logs, causes, is_height }
    }

    fn cause(&self, id: &str, channel: usize, terms: &Terms, neutral: f64) -> f64 {
        let name = match (id, self.channels[channel].name) {
            ("encoder-scale", "x_m") => "x_scale",
            ("encoder-scale", _) => "y_scale",
            (_, "x_m") => "x_delay_s",
            _ => "y_delay_s",
        };
        let found = self.causes.iter().position(|c| c.parameters[0].name == name);
        found.map_or(neutral, |i| terms.get(i, 0))
    }

    fn value(&self, id: &str, terms: &Terms) -> Option<f64> {
        self.causes.iter().position(|c| c.id == id).map(|i| terms.get(i, 0))
    }
}

impl Kind for Flights {
    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn logs(&self) -> &[Log] {
        &self.logs
    }

    /// Where and how fast it starts; and when, as the first rows may precede the release.
    fn unknowns(&self, run: usize) -> Vec<Parameter> {
        let readings = &self.logs[run].readings;
        let (first, last) = (readings.first().map_or(0.0, |r| r.time), readings.last().map_or(0.0, |r| r.time));
        let mut all = Vec::new();
        for (channel, &is_height) in self.is_height.iter().enumerate() {
            let here: Vec<_> = readings.iter().filter(|r| r.channel == channel).collect();
            let start = here.first().map_or(0.0, |r| r.value);
            // From the first tenth of the flight.
            let later = here.get((here.len() / 10).max(1)).or(here.last());
            let speed = later.map_or(0.0, |r| (r.value - start) / (r.time - first).max(1e-6));
            let fall = if is_height { 0.5 * self.gravity * (later.map_or(0.0, |r| r.time) - first) } else { 0.0 };
            let free = (f64::NEG_INFINITY, f64::INFINITY);
            let number = |name, neutral, scale| Parameter { name, neutral, bounds: free, scale, starts: Vec::new() };
            all.push(number("start_m", start, 0.01));
            all.push(number("start_speed_m_s", speed + fall, 0.1));
        }
        all.push(Parameter {
            name: "release_s",
            neutral: first,
            bounds: (first, first + 0.3 * (last - first)),
            scale: 0.01,
            starts: Vec::new(),
        });
        all
    }

    fn causes(&self) -> &[Cause] {
        &self.causes
    }

    fn predict(&self, run: usize, terms: &Terms, unknowns: &[f64]) -> Option<Vec<f64>> {
        let drag = self.value("air-drag", terms).unwrap_or(0.0);
        let share = self.value("counterweight", terms).unwrap_or(1.0);
        let gravity = share * self.value("gravity", terms).unwrap_or(self.gravity);
        let release = *unknowns.last()?;
        // x, y, and their rates; what is not measured stands still.
        let (mut place, mut speed) = ([0.0; 2], [0.0; 2]);
        for (channel, &is_height) in self.is_height.iter().enumerate() {
            place[usize::from(is_height)] = unknowns[2 * channel];
            speed[usize::from(is_height)] = unknowns[2 * channel + 1];
        }
        let pull = |v: [f64; 2]| {
            let size = v[0].hypot(v[1]);
            [-drag * size * v[0], -gravity - drag * size * v[1]]
        };
        let mut path = Path { time: release, place, speed };
        // Delays differ by channel: each is asked at its own time, in order, from its own start.
        let start = path;
        let mut out = vec![0.0; self.logs[run].readings.len()];
        for (channel, &is_height) in self.is_height.iter().enumerate() {
            let delay = self.cause("sensor-delay", channel, terms, 0.0);
            let scale = self.cause("encoder-scale", channel, terms, 1.0);
            path = start;
            for (i, reading) in self.logs[run].readings.iter().enumerate() {
                if reading.channel != channel {
                    continue;
                }
                path.go(reading.time - delay, &pull);
                out[i] = scale * path.place[usize::from(is_height)];
            }
        }
        out.iter().all(|x| x.is_finite()).then_some(out)
    }
}

/// Place (m) and speed (m/s) at a time (s).
#[derive(Clone, Copy)]
struct Path {
    time: f64,
    place: [f64; 2],
    speed: [f64; 2],
}

impl Path {
    /// Goes on to `time`, by Runge–Kutta steps; before its own time it waits.
    fn go(&mut self, time: f64, pull: &impl Fn([f64; 2]) -> [f64; 2]) {
        let length = time - self.time;
        if length <= 0.0 {
            return;
        }
        // As many steps as the longest allows.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let count = (length / STEP).ceil().clamp(1.0, 1e6) as usize;
        let h = length / count as f64;
        for _ in 0..count {
            let add = |v: [f64; 2], a: [f64; 2], h: f64| [v[0] + h * a[0], v[1] + h * a[1]];
            let (v1, a1) = (self.speed, pull(self.speed));
            let v2 = add(v1, a1, 0.5 * h);
            let a2 = pull(v2);
            let v3 = add(v1, a2, 0.5 * h);
            let a3 = pull(v3);
            let v4 = add(v1, a3, h);
            let a4 = pull(v4);
            for k in 0..2 {
                self.place[k] += h / 6.0 * (v1[k] + 2.0 * v2[k] + 2.0 * v3[k] + v4[k]);
                self.speed[k] += h / 6.0 * (a1[k] + 2.0 * a2[k] + 2.0 * a3[k] + a4[k]);
            }
        }
        self.time = time;
    }
}
