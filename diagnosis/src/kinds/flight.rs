//! A body in free flight or fall, or a robot in flight at the end of a boom.

use super::{FREE, sensor, simple, unknown};
use crate::experiment::{Experiment, Run, Sort};
use crate::kind::{Cause, Channel, Kind, Log, Parameter, Terms};
use crate::next::Proposal;
use crate::noise;

/// Flights, with what is believed of them.
#[derive(Clone, Debug)]
pub struct Flights {
    gravity: f64,
    channels: Vec<Channel>,
    logs: Vec<Log>,
    causes: Vec<Cause>,
    /// How many of them have an id.
    listed: usize,
    /// Whether channel number k is the height.
    is_height: Vec<bool>,
    /// Drag (1/m) of each run for one of the parameter: ρ A/(2 m), or 1.
    drag: Vec<f64>,
    /// Drops from rest: when each was let go is not known, and may be before its first row or after.
    is_drop: bool,
}

/// Longest step (s) of the integration: its error is below a micrometre for anything that flies.
const STEP: f64 = 2e-2;
/// Density (kg/m³) of air at 15 °C.
const AIR: f64 = 1.225;

impl Flights {
    /// The experiment's flights, believed to be under `gravity` (m/s²).
    pub fn new(experiment: &Experiment, gravity: f64) -> Flights {
        let indices: Vec<usize> = (0..experiment.columns.len()).collect();
        let channels = noise::channels(experiment, &indices);
        let logs: Vec<Log> =
            experiment.runs.iter().map(|run| noise::log(experiment, run, &indices)).collect();
        let on_boom = experiment.runs.iter().any(|r| r.settings.contains_key("boom_radius_m"));
        let sizes: Vec<Option<f64>> = experiment
            .runs
            .iter()
            .map(|run| {
                let (mass, diameter) = (run.settings.get("mass_kg")?, run.settings.get("diameter_m")?);
                Some(0.5 * AIR * std::f64::consts::FRAC_PI_4 * diameter * diameter / mass)
            })
            .collect();
        let known: Option<Vec<f64>> = sizes.into_iter().collect();
        let mut causes = vec![match &known {
            Some(_) => simple("air-drag", "drag_coefficient", 0.0, (0.0, 50.0), 0.05, &[0.3, 1.0]),
            None => simple("air-drag", "drag_per_m", 0.0, (0.0, 10.0), 1e-3, &[0.01, 0.1]),
        }];
        if on_boom {
            // Less effective gravity and more inertia: both at once are one ratio.
            causes.push(simple("counterweight", "gravity_share", 1.0, (0.02, 2.0), 0.01, &[0.5]));
        }
        let of_gravity = simple("gravity", "gravity_m_s2", gravity, (0.1, 40.0), 0.05, &[0.5 * gravity]);
        // Gravity is known, wherever a body falls.
        causes.push(Cause { usual: Some(0.01 * gravity), ..of_gravity });
        for channel in &channels {
            causes.push(sensor("encoder-scale", &channel.name, "gain", 1.0, (0.2, 5.0), 0.01, &[0.9, 1.1]));
            if channels.len() > 1 {
                causes.push(sensor("sensor-delay", &channel.name, "delay_s", 0.0, (0.0, 0.5), 1e-3, &[0.01]));
            }
        }
        let listed = causes.len();
        causes.push(simple("acceleration -c v", "c_per_s", 0.0, (-50.0, 50.0), 1e-3, &[]));
        if channels.len() > 1 {
            causes.push(simple(
                "acceleration across the path, c v",
                "c_per_s",
                0.0,
                (-50.0, 50.0),
                1e-3,
                &[],
            ));
            causes.push(simple("constant acceleration along x", "c_m_s2", 0.0, (-50.0, 50.0), 0.02, &[]));
        }
        let is_height: Vec<bool> = channels.iter().map(|c| c.name == "y_m").collect();
        let is_drop = !on_boom && is_height == [true] && logs.iter().all(|log| !rises(log, &channels[0]));
        let drag = known.unwrap_or_else(|| vec![1.0; logs.len()]);
        Flights { gravity, channels, logs, causes, listed, is_height, drag, is_drop }
    }

    fn value(&self, id: &str, column: Option<&str>, terms: &Terms) -> Option<f64> {
        self.causes.iter().position(|c| c.id == id && c.column.as_deref() == column).map(|i| terms.get(i, 0))
    }
}

impl Kind for Flights {
    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn logs(&self) -> &[Log] {
        &self.logs
    }

    /// Where and how fast it starts; of a drop when, as the first rows may precede the release.
    fn unknowns(&self, run: usize) -> Vec<Parameter> {
        let readings = &self.logs[run].readings;
        let (first, last) =
            (readings.first().map_or(0.0, |r| r.time), readings.last().map_or(0.0, |r| r.time));
        let mut all = Vec::new();
        for (channel, &is_height) in self.is_height.iter().enumerate() {
            let here: Vec<_> = readings.iter().filter(|r| r.channel == channel).collect();
            let start = here.first().map_or(0.0, |r| r.value);
            // From the first tenth of the flight.
            let later = here.get((here.len() / 10).max(1)).or(here.last());
            let speed = later.map_or(0.0, |r| (r.value - start) / (r.time - first).max(1e-6));
            let fall =
                if is_height { 0.5 * self.gravity * (later.map_or(0.0, |r| r.time) - first) } else { 0.0 };
            all.push(unknown("start_m", start, FREE, 0.01));
            if self.is_drop {
                let bounds = (first - 2.0, first + 0.3 * (last - first));
                all.push(unknown("release_s", first + 0.02 * (last - first), bounds, 0.01));
            } else {
                all.push(unknown("start_speed_m_s", speed + fall, FREE, 0.1));
            }
        }
        all
    }

    fn causes(&self) -> &[Cause] {
        &self.causes
    }

    fn listed(&self) -> usize {
        self.listed
    }

    /// Free falls, without the boom and with a body of another weight, and flights that are timed against a ruler.
    fn proposals(&self) -> Vec<Proposal> {
        let mut all = Vec::new();
        for height in [2.0, 10.0] {
            let fall = (2.0 * height / self.gravity).sqrt();
            // The number of rows.
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let rows = (fall / 5e-3) as usize;
            let time: Vec<f64> = (0..rows).map(|i| i as f64 * 5e-3).collect();
            let run =
                Run { name: "proposal".into(), values: vec![vec![height; rows]], time, ..Run::default() };
            let experiment = Experiment {
                kind: Sort::Flight,
                columns: vec!["y_m".into()],
                noise: vec![self.channels.last().map(|c| c.noise)],
                resolution: vec![None],
                runs: vec![run],
            };
            let mut kind = Flights::new(&experiment, self.gravity);
            // Its height is measured with a ruler, and it weighs so much that air does not matter.
            kind.causes.retain(|c| c.id == "gravity");
            kind.listed = 1;
            let what = format!(
                "drop a heavy, small body by {height} m, free of the boom, its height measured by a ruler"
            );
            all.push(Proposal { what, kind: Box::new(kind) });
        }
        all
    }

    fn predict(&self, run: usize, terms: &Terms, unknowns: &[f64]) -> Option<Vec<f64>> {
        let drag = self.drag[run] * self.value("air-drag", None, terms).unwrap_or(0.0);
        let share = self.value("counterweight", None, terms).unwrap_or(1.0);
        let gravity = share * self.value("gravity", None, terms).unwrap_or(self.gravity);
        let readings = &self.logs[run].readings;
        let release = if self.is_drop { unknowns[1] } else { readings.first()?.time };
        // x, y, and their rates; what is not measured stands still.
        let (mut place, mut speed) = ([0.0; 2], [0.0; 2]);
        for (channel, &is_height) in self.is_height.iter().enumerate() {
            place[usize::from(is_height)] = unknowns[2 * channel];
            if !self.is_drop {
                speed[usize::from(is_height)] = unknowns[2 * channel + 1];
            }
        }
        let extra = |id: &str| self.value(id, None, terms).unwrap_or(0.0);
        let linear = extra("acceleration -c v");
        let (lift, wind) =
            (extra("acceleration across the path, c v"), extra("constant acceleration along x"));
        let is_parabola = drag == 0.0 && linear == 0.0 && lift == 0.0 && wind == 0.0;
        let pull = |v: [f64; 2]| {
            let against = drag * v[0].hypot(v[1]) + linear;
            [wind - against * v[0] - lift * v[1], -gravity - against * v[1] + lift * v[0]]
        };
        let start = Path { time: release, place, speed };
        let mut out = vec![0.0; readings.len()];
        for (channel, &is_height) in self.is_height.iter().enumerate() {
            let name = Some(self.channels[channel].name.as_str());
            let delay = self.value("sensor-delay", name, terms).unwrap_or(0.0);
            let scale = self.value("encoder-scale", name, terms).unwrap_or(1.0);
            let mut path = start;
            for (i, reading) in readings.iter().enumerate() {
                if reading.channel != channel {
                    continue;
                }
                let time = reading.time - delay;
                if is_parabola || time < start.time {
                    // A parabola; before the first row it was on the same one, unless it was held.
                    let t = if self.is_drop { (time - start.time).max(0.0) } else { time - start.time };
                    let k = usize::from(is_height);
                    let fall = if is_height { 0.5 * gravity * t * t } else { 0.0 };
                    out[i] = scale * (start.place[k] + start.speed[k] * t - fall);
                } else {
                    path.go(time, &pull);
                    out[i] = scale * path.place[usize::from(is_height)];
                }
            }
        }
        out.iter().all(|x| x.is_finite()).then_some(out)
    }
}

/// Whether a body rises from its first row on, by more than the noise.
fn rises(log: &Log, channel: &Channel) -> bool {
    let Some(first) = log.readings.first() else { return false };
    let early = log.readings.iter().take(log.readings.len().div_ceil(4));
    early.map(|r| r.value).fold(f64::NEG_INFINITY, f64::max) > first.value + 5.0 * channel.noise
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
