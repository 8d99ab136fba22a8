//! A body in free flight or fall, or a robot in flight at the end of a boom.

use super::{Causes, FREE, amount, causes, delay, faults, gain, simple, unknown};
use crate::experiment::{Experiment, Run, Sort};
use crate::fit::{self, Fit};
use crate::kind::Proposal;
use crate::kind::{Asked, Cause, Channel, Data, Kind, Log, Parameter, Reading, Terms};
use crate::layout::{Draw, Layout, count};
use crate::plausible::{Check, FRAMES, JUMPS, LENGTHS, clock};
use crate::prior::Prior;
use crate::spec::{
    DIAMETER, LOAD, PART, PLACE, RADIUS, Source, Spec, Synthesis, calm, lively, noisy, optional,
    without,
};

/// Flights, with what is believed of them.
#[derive(Clone, Debug)]
pub struct Flights {
    gravity: f64,
    data: Data,
    causes: Causes<Effect>,
    /// Whether channel number k is the height.
    is_height: Vec<bool>,
    /// Drag (1/m) of each run for one of the parameter: ρ A/(2 m), or 1.
    drag: Vec<f64>,
    /// Length (m) of the boom of each run, if it is on one and the data show its arc.
    boom: Vec<Option<f64>>,
    /// Drops from rest: when each was let go is not known, and may be before its first row or
    /// after.
    is_drop: bool,
}

/// Longest step (s) of the integration: its error is below a micrometre for anything that flies.
const STEP: f64 = 2e-2;
/// Density (kg/m³) of air at 15 °C.
const AIR: f64 = 1.225;
/// Its viscosity (Pa s).
const VISCOSITY: f64 = 1.81e-5;

/// Drag per metre for a drag coefficient of 1, of a body's mass (kg) and diameter (m).
fn drag_per_coefficient((mass, diameter): (f64, f64)) -> f64 {
    0.5 * AIR * std::f64::consts::FRAC_PI_4 * diameter * diameter / mass
}

/// Greatest drag in proportion to speed (1/s) that air has for spheres of these masses (kg) and
/// diameters (m): Stokes' law.
fn viscous_drag(sizes: &[(f64, f64)]) -> f64 {
    let of =
        |(mass, diameter): &(f64, f64)| 3.0 * std::f64::consts::PI * VISCOSITY * diameter / mass;
    sizes.iter().map(of).fold(0.0, f64::max)
}

impl Flights {
    /// The experiment's flights, believed to be under `gravity` (m/s²).
    pub fn new(experiment: &Experiment, gravity: f64) -> Flights {
        let indices: Vec<usize> = (0..experiment.columns.len()).collect();
        let mut data = Data::of(experiment, &indices);
        let boom: Vec<Option<f64>> = experiment
            .runs
            .iter()
            .map(|r| r.settings.get("boom_radius_m").copied())
            .collect();
        let on_boom = boom.iter().any(Option::is_some);
        let size = |run: &Run| -> Option<(f64, f64)> {
            let of = |key| run.settings.get(key).copied();
            Some((of("mass_kg")?, of("diameter_m")?))
        };
        let sizes: Option<Vec<(f64, f64)>> = experiment.runs.iter().map(size).collect();
        let named = named(&data.channels, gravity, sizes.is_some(), on_boom);
        let viscous = sizes.as_deref().map(viscous_drag);
        let terms = terms(data.channels.len(), viscous);
        let causes = Causes::of(&mut data, named, terms);
        let (channels, logs) = (&data.channels, &data.logs);
        let is_height: Vec<bool> = channels.iter().map(|c| c.name == "y_m").collect();
        let is_drop =
            !on_boom && is_height == [true] && logs.iter().all(|log| !rises(log, &channels[0]));
        let drag = sizes.map_or_else(
            || vec![1.0; logs.len()],
            |sizes| sizes.into_iter().map(drag_per_coefficient).collect(),
        );
        let flat = vec![None; logs.len()];
        let mut flights = Flights {
            gravity,
            data,
            causes,
            is_height,
            drag,
            boom: flat,
            is_drop,
        };
        if on_boom && flights.is_round(&boom) {
            flights.boom = boom;
        }
        flights
    }

    /// Whether the data follow the end of these booms round its base, with the height counted from
    /// the pivot, rather than a plane: what a log means by x and y nobody tells. If with one of
    /// them nothing is wrong, it is that; else, whatever is at work, the arc must explain most of
    /// what the plane leaves.
    fn is_round(&self, boom: &[Option<f64>]) -> bool {
        let round = Flights {
            boom: boom.to_vec(),
            ..self.clone()
        };
        let runs: Vec<usize> = (0..self.data.logs.len()).collect();
        let readings: usize = self.data.logs.iter().map(|log| log.readings.len()).sum();
        let noise = readings as f64 + 3.0 * (2.0 * readings as f64).sqrt();
        let [plane, arc] =
            [self, &round].map(|flights| fit::fit_none(flights, &runs).map(|f| f.loss));
        if let (Some(plane), Some(arc)) = (plane, arc)
            && plane.min(arc) < noise
        {
            return arc < plane;
        }
        let left = |flights: &Flights| -> Option<Fit> {
            let mut model = fit::fit_none(flights, &runs)?;
            for cause in
                (0..flights.data.listed).filter(|&c| flights.causes.0[c] != Some(Effect::Share))
            {
                model = fit::fit_with(flights, &model, cause, &runs)?;
            }
            Some(model)
        };
        match (left(self), left(&round)) {
            (Some(plane), Some(arc)) => {
                plane.loss - arc.loss > 0.5 * (plane.loss - readings as f64)
            }
            _ => false,
        }
    }
}

/// What a cause does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Effect {
    Drag,
    Share,
    Gravity,
    /// Without a name.
    Linear,
    Lift,
    Turning,
    Wind,
}

/// Prior standard deviations of gravity (m/s²) and of the scale of a length, each with its reason.
type CommonSense = [(f64, &'static str); 2];

/// Of a body that nothing holds: gravity differs by 0.05 m/s² between equator and pole, and by 0.03
/// at 10 km of height.
const IN_THE_OPEN: CommonSense = [(0.02, "gravity on Earth"), (0.003, "a ruler")];

/// Of a robot at the end of a boom, whose plane may be tilted, and whose place an encoder tells.
const ON_A_RIG: CommonSense = [
    (0.2, "gravity on Earth, on a rig that may be tilted"),
    (0.05, "encoders are calibrated"),
];

/// The listed causes.
fn named(
    channels: &[Channel],
    gravity: f64,
    size_is_known: bool,
    on_boom: bool,
) -> Vec<(Option<Effect>, Cause)> {
    let drag = if size_is_known {
        amount("air-drag", "drag_coefficient", 50.0, 0.05, &[0.3, 1.0])
    } else {
        amount("air-drag", "drag_per_m", 10.0, 1e-3, &[0.01, 0.1])
    };
    let mut all = vec![(Some(Effect::Drag), drag)];
    if on_boom {
        // Less effective gravity and more inertia: both at once are one ratio.
        let (bounds, starts) = ((0.02, 2.0), [0.5]);
        let share = simple("counterweight", "gravity_share", 1.0, bounds, 0.01, &starts);
        all.push((Some(Effect::Share), share));
    }
    let known = if on_boom { ON_A_RIG } else { IN_THE_OPEN };
    let starts = [0.5 * gravity];
    let name = "gravity_m_s2";
    let of_gravity = simple("gravity", name, gravity, (0.1, 40.0), 0.05, &starts);
    let [(error, why), of_scale] = known;
    all.push((Some(Effect::Gravity), of_gravity.usual(error, why)));
    let (error, why) = of_scale;
    for Channel { name, .. } in channels {
        all.extend(faults([gain(name).usual(error, why)]));
        if channels.len() > 1 {
            all.extend(faults([delay(name, 0.5, 1e-3)]));
        }
    }
    all
}

/// Terms without a name, of flights with so many channels; `viscous` is the drag in proportion to
/// speed (1/s) of a body whose size is known.
fn terms(channels: usize, viscous: Option<f64>) -> Vec<(Option<Effect>, Cause)> {
    let term = |id, name, scale| simple(id, name, 0.0, (-50.0, 50.0), scale, &[]);
    let mut linear = term("acceleration -c v", "c_per_s", 1e-3);
    if let Some(viscous) = viscous {
        let prior = Prior::common(viscous, viscous, "the viscosity of air (Stokes)");
        linear.priors = vec![(0, prior)];
    }
    let mut all = vec![(Some(Effect::Linear), linear)];
    if channels > 1 {
        all.extend(causes! {
            Effect::Lift => term("acceleration across the path, c v", "c_per_s", 1e-3);
            Effect::Turning => term("acceleration along x, -c v_x", "c_per_s", 1e-2);
            Effect::Wind => term("constant acceleration along x", "c_m_s2", 0.02);
        });
    }
    all
}

impl Kind for Flights {
    fn data(&self) -> &Data {
        &self.data
    }

    /// Where and how fast it starts; of a drop when, as the first rows may precede the release.
    fn unknowns(&self, run: usize) -> Vec<Parameter> {
        let readings = &self.data.logs[run].readings;
        let (first, last) = (
            readings.first().map_or(0.0, |r| r.time),
            readings.last().map_or(0.0, |r| r.time),
        );
        let mut all = Vec::new();
        for (channel, &is_height) in self.is_height.iter().enumerate() {
            let here: Vec<_> = self.data.logs[run].of(channel).collect();
            let start = here.first().map_or(0.0, |r| r.value);
            // From the first tenth of the flight.
            let later = here.get((here.len() / 10).max(1)).or(here.last());
            let speed = later.map_or(0.0, |r| (r.value - start) / (r.time - first).max(1e-6));
            let fall = if is_height {
                0.5 * self.gravity * (later.map_or(0.0, |r| r.time) - first)
            } else {
                0.0
            };
            all.push(unknown("start_m", start, FREE, 0.01));
            if self.is_drop {
                let bounds = (first - 2.0, first + 0.3 * (last - first));
                all.push(unknown(
                    "release_s",
                    first + 0.02 * (last - first),
                    bounds,
                    0.01,
                ));
            } else {
                all.push(unknown("start_speed_m_s", speed + fall, FREE, 0.1));
            }
        }
        all
    }

    fn stronger(&self) -> String {
        "longer and faster flights".into()
    }

    /// Free falls, without the boom and with a body of another weight, and flights that are timed
    /// against a ruler.
    fn proposals(&self) -> Vec<Proposal> {
        let mut all = Vec::new();
        for height in [2.0, 10.0] {
            let fall = (2.0 * height / self.gravity).sqrt();
            // The number of rows.
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let rows = (fall / 5e-3) as usize;
            let time: Vec<f64> = (0..rows).map(|i| i as f64 * 5e-3).collect();
            let run = Run {
                name: "proposal".into(),
                values: vec![vec![height; rows]],
                time,
                ..Run::default()
            };
            let experiment = Experiment {
                kind: Sort::Flight,
                mechanism: None,
                columns: vec!["y_m".into()],
                noise: vec![self.data.channels.last().map(|c| c.noise)],
                resolution: vec![None],
                runs: vec![run],
            };
            let mut kind = Flights::new(&experiment, self.gravity);
            // Its height is measured with a ruler, and it weighs so much that air does not matter.
            let gravity = |c: &Cause| c.id == "gravity";
            let of_gravity = kind
                .data
                .causes
                .iter()
                .find(|cause| gravity(cause))
                .cloned();
            let listed = of_gravity.map(|cause| (Some(Effect::Gravity), cause));
            kind.causes = Causes::of(&mut kind.data, listed.into_iter().collect(), Vec::new());
            let what = format!(
                "drop a heavy, small body by {height} m, free of the boom, its height measured by \
                 a ruler"
            );
            all.push(Proposal {
                what,
                kind: Box::new(kind),
            });
        }
        all
    }

    fn truths(&self, asked: &Asked<'_>) -> Option<Vec<f64>> {
        let (run, terms, unknowns) = asked.parts();
        let (release, place, speed) = self.released(run, unknowns)?;
        let share = self.causes.or(Effect::Share, 1.0, terms);
        let motion = Motion {
            gravity: share * self.causes.or(Effect::Gravity, self.gravity, terms),
            boom: self.boom[run].filter(|length| place[1].abs() < 0.99 * length),
            pull: self.pull(run, terms),
        };
        let start = motion.start(release, place, speed);
        let mut paths = vec![start; self.is_height.len()];
        let truth = |(reading, time): (&Reading, &f64)| {
            // Before the first row it was on the same path, unless it was held.
            let time = if self.is_drop {
                time.max(start.time)
            } else {
                *time
            };
            let seen = motion.seen_at(&mut paths[reading.channel], time);
            seen[usize::from(self.is_height[reading.channel])]
        };
        let readings = self.data.logs[run].readings.iter();
        Some(readings.zip(&asked.times).map(truth).collect())
    }
}

impl Flights {
    /// When (s) the flight of a run begins, and where (m) and how fast (m/s), forward and up; what
    /// is not measured stands still.
    fn released(&self, run: usize, unknowns: &[f64]) -> Option<(f64, [f64; 2], [f64; 2])> {
        let release = if self.is_drop {
            unknowns[1]
        } else {
            self.data.logs[run].readings.first()?.time
        };
        let (mut place, mut speed) = ([0.0; 2], [0.0; 2]);
        for (channel, &is_height) in self.is_height.iter().enumerate() {
            place[usize::from(is_height)] = unknowns[2 * channel];
            if !self.is_drop {
                speed[usize::from(is_height)] = unknowns[2 * channel + 1];
            }
        }
        Some((release, place, speed))
    }

    fn pull(&self, run: usize, terms: &Terms) -> Pull {
        let of = |effect| self.causes.or(effect, 0.0, terms);
        Pull {
            drag: self.drag[run] * of(Effect::Drag),
            linear: of(Effect::Linear),
            lift: of(Effect::Lift),
            turning: of(Effect::Turning),
            wind: of(Effect::Wind),
        }
    }
}

/// Whether a body rises from its first row on, by more than the noise.
fn rises(log: &Log, channel: &Channel) -> bool {
    let Some(first) = log.readings.first() else {
        return false;
    };
    let early = log.readings.iter().take(log.readings.len().div_ceil(4));
    early.map(|r| r.value).fold(f64::NEG_INFINITY, f64::max) > first.value + 5.0 * channel.noise
}

/// Place and speed at a time (s): x and y (m), or turn and pivot of a boom (rad).
#[derive(Clone, Copy)]
struct Path {
    time: f64,
    place: [f64; 2],
    speed: [f64; 2],
}

/// What the air, and terms without a name, do to a body.
#[derive(Clone, Copy, Default, PartialEq)]
struct Pull {
    /// Drag (1/m).
    drag: f64,
    linear: f64,
    lift: f64,
    turning: f64,
    wind: f64,
}

impl Pull {
    /// Acceleration (m/s²) by the velocity, forward and up.
    fn at(&self, v: [f64; 2]) -> [f64; 2] {
        let against = self.drag * v[0].hypot(v[1]) + self.linear;
        [
            self.wind - (against + self.turning) * v[0] - self.lift * v[1],
            -against * v[1] + self.lift * v[0],
        ]
    }
}

/// What moves a body.
struct Motion {
    /// What is felt of gravity (m/s²).
    gravity: f64,
    /// Length (m) of the boom whose end it is, pivoting at height 0; none: it is free.
    boom: Option<f64>,
    /// Other accelerations.
    pull: Pull,
}

impl Motion {
    fn start(&self, time: f64, place: [f64; 2], speed: [f64; 2]) -> Path {
        let Some(length) = self.boom else {
            return Path { time, place, speed };
        };
        let pivot = (place[1] / length).clamp(-1.0, 1.0).asin();
        Path {
            time,
            place: [place[0] / length, pivot],
            speed: [speed[0] / length, speed[1] / (length * pivot.cos())],
        }
    }

    /// Where it is seen at `time` (s); `path` goes on to there. A body that only falls does not need
    /// to.
    fn seen_at(&self, path: &mut Path, time: f64) -> [f64; 2] {
        if self.boom.is_none() && self.pull == Pull::default() {
            let t = time - path.time;
            let [x, y] = std::array::from_fn(|k| path.place[k] + path.speed[k] * t);
            return [x, y - 0.5 * self.gravity * t * t];
        }
        self.go(path, time);
        self.seen(path)
    }

    /// Where it is seen: x along the arc of the boom's end when level.
    fn seen(&self, path: &Path) -> [f64; 2] {
        self.boom.map_or(path.place, |length| {
            [length * path.place[0], length * path.place[1].sin()]
        })
    }

    fn accelerations(&self, place: [f64; 2], v: [f64; 2]) -> [f64; 2] {
        let Some(length) = self.boom else {
            let [x, y] = self.pull.at(v);
            return [x, y - self.gravity];
        };
        let (sin, cos) = place[1].sin_cos();
        let [forward, up] = self.pull.at([length * cos * v[0], length * v[1]]);
        [
            forward / (length * cos) + 2.0 * sin / cos * v[0] * v[1],
            (up - self.gravity * cos) / length - sin * cos * v[0] * v[0],
        ]
    }

    /// Goes on, or back, to `time` by Runge–Kutta steps.
    fn go(&self, path: &mut Path, time: f64) {
        let length = time - path.time;
        // As many steps as the longest allows.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let count = (length.abs() / STEP).ceil().clamp(1.0, 1e6) as usize;
        let h = length / count as f64;
        for _ in 0..count {
            let add = |a: [f64; 2], b: [f64; 2], h: f64| [a[0] + h * b[0], a[1] + h * b[1]];
            let (x1, v1) = (path.place, path.speed);
            let a1 = self.accelerations(x1, v1);
            let (x2, v2) = (add(x1, v1, 0.5 * h), add(v1, a1, 0.5 * h));
            let a2 = self.accelerations(x2, v2);
            let (x3, v3) = (add(x1, v2, 0.5 * h), add(v1, a2, 0.5 * h));
            let a3 = self.accelerations(x3, v3);
            let (x4, v4) = (add(x1, v3, h), add(v1, a3, h));
            let a4 = self.accelerations(x4, v4);
            for k in 0..2 {
                path.place[k] += h / 6.0 * (v1[k] + 2.0 * v2[k] + 2.0 * v3[k] + v4[k]);
                path.speed[k] += h / 6.0 * (a1[k] + 2.0 * a2[k] + 2.0 * a3[k] + a4[k]);
            }
        }
        path.time = time;
    }
}

/// The kind.
pub(super) const SPEC: Spec = Spec {
    sort: Sort::Flight,
    id: "flight",
    description: "A body thrown",
    // Something dropped may stay above its shadow.
    channels: &[without(calm("x_m", PLACE)), without(lively("y_m", PLACE))],
    any_of: true,
    settings: &[
        optional("mass_kg", LOAD),
        optional("diameter_m", DIAMETER),
        optional("boom_radius_m", RADIUS),
    ],
    least: 5,
    checks: &[
        Check {
            name: "y_m",
            sizes: |view| Some((view.fall("y_m")?, 9.806_65)),
            what: "a fall (m/s²) under gravity",
            allowed: (0.02, 2.0),
            strict: false,
            units: LENGTHS,
        },
        clock(
            |view| {
                let fall = view.fall("y_m")?;
                // A straight line tells no clock.
                let bent = 0.125 * fall * view.length()?.powi(2) > 0.1 * view.span("y_m")?;
                view.paced(9.806_65, fall).filter(|_| bent)
            },
            FRAMES,
        ),
        Check {
            name: "x_m",
            sizes: |view| Some((view.span("x_m")? / view.length()?, 5.0)),
            what: "the speed (m/s) of a throw",
            // As far as 100 m/s.
            allowed: (0.0, 20.0),
            strict: false,
            units: LENGTHS,
        },
        Check {
            name: "diameter_m",
            sizes: |view| {
                let volume = view.setting("mass_kg")? / 500.0;
                let diameter = (6.0 / std::f64::consts::PI * volume).cbrt();
                Some((view.setting("diameter_m")?, diameter))
            },
            what: "the diameter of a ball of this mass and half the density of water",
            // From a ball of lead to one of paper with air in it.
            allowed: (0.1, 20.0),
            strict: false,
            units: JUMPS,
        },
        Check {
            name: "boom_radius_m",
            sizes: |view| Some((view.setting("boom_radius_m")?, 2.0)),
            what: "the length of a usual boom",
            allowed: (0.0, 10.0),
            strict: false,
            units: LENGTHS,
        },
    ],
    phase: |_| "flight",
    model: |data, robot| {
        let gravity = robot.map_or(9.80665, |r| r.environment.gravity);
        Ok(Box::new(Flights::new(data, gravity)))
    },
    synthesis: Synthesis {
        instruments: &[noisy("x_m", 5e-3), noisy("y_m", 5e-3)],
        without_boom: None,
        runs: 6,
        lay_out: |layout, runs, draw| (0..runs).for_each(|_| throw(layout, draw)),
        source: Source::Model,
    },
    ..PART
};

/// Adds a throw.
fn throw(layout: &mut Layout, draw: &mut Draw) {
    let (height, forward, up) = if layout.on_boom {
        (
            draw.between(0.0, 0.1),
            draw.between(0.5, 1.5),
            draw.between(1.0, 2.5),
        )
    } else {
        (
            draw.between(1.0, 2.0),
            draw.between(2.0, 8.0),
            draw.between(3.0, 8.0),
        )
    };
    let boom: &[(&str, f64)] = if layout.on_boom {
        &[("boom_radius_m", 2.12)]
    } else {
        &[]
    };
    layout.add(
        boom,
        count(0.22 * up, 0.01),
        0.01,
        vec![0.0, forward, height, up],
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::toy;

    const G: f64 = 9.81;

    fn rows(end: f64) -> Vec<f64> {
        (0..=50).map(|k| f64::from(k) * end / 50.0).collect()
    }

    /// Flights of one run with these columns, whose values are what `shown` gives at each time.
    fn flights(
        settings: &[(&str, f64)],
        end: f64,
        shown: &[(&str, &dyn Fn(f64) -> f64)],
    ) -> Flights {
        let time = rows(end);
        let columns: Vec<(&str, Vec<f64>)> = shown
            .iter()
            .map(|(name, of)| (*name, time.iter().map(|t| of(*t)).collect()))
            .collect();
        Flights::new(&toy::measured(Sort::Flight, settings, &time, &columns), G)
    }

    /// Holds the prediction, with terms on, of every channel against `closed(channel, time)`.
    #[track_caller]
    fn check(
        flights: &Flights,
        on: &[(&str, usize, f64)],
        unknowns: &[f64],
        within: f64,
        closed: impl Fn(usize, f64) -> f64,
    ) {
        let found = flights.predict(0, &toy::terms(flights, on), unknowns);
        for (reading, x) in flights.data.logs[0]
            .readings
            .iter()
            .zip(found.expect("an answer"))
        {
            let y = closed(reading.channel, reading.time);
            assert!(
                (x - y).abs() < within,
                "channel {} at {} s: {x} {y}",
                reading.channel,
                reading.time
            );
        }
    }

    /// A throw from (0, 1) m at (3, 4) m/s.
    const THROWN: [f64; 4] = [0.0, 3.0, 1.0, 4.0];

    fn throw(gravity: f64) -> impl Fn(usize, f64) -> f64 {
        move |channel, t| match channel {
            0 => 3.0 * t,
            _ => 1.0 + 4.0 * t - 0.5 * gravity * t * t,
        }
    }

    fn thrown(settings: &[(&str, f64)]) -> Flights {
        flights(
            settings,
            0.8,
            &[("x_m", &|t| throw(G)(0, t)), ("y_m", &|t| throw(G)(1, t))],
        )
    }

    #[test]
    fn a_free_body_flies_a_parabola() {
        let flights = thrown(&[]);
        check(&flights, &[], &THROWN, 1e-12, throw(G));
        check(
            &flights,
            &[("gravity", 0, 1.62)],
            &THROWN,
            1e-12,
            throw(1.62),
        );
        check(
            &flights,
            &[("encoder-scale@y_m", 0, 1.1)],
            &THROWN,
            1e-12,
            |channel, t| throw(G)(channel, t) * [1.0, 1.1][channel],
        );
        check(
            &flights,
            &[("sensor-delay@x_m", 0, 0.02)],
            &THROWN,
            1e-12,
            |channel, t| throw(G)(channel, t - [0.02, 0.0][channel]),
        );
    }

    #[test]
    fn the_first_guess_is_the_throw() {
        let guess = thrown(&[]).unknowns(0);
        for (parameter, value) in guess.iter().zip(THROWN) {
            assert!(
                (parameter.neutral - value).abs() < 1e-6,
                "{parameter:?} {value}"
            );
        }
    }

    #[test]
    fn air_resists_a_fall_as_in_closed_form() {
        let (k, start) = (0.2, 50.0);
        let fallen = |t: f64| start - ((k * G).sqrt() * t).cosh().ln() / k;
        let falls = flights(&[], 2.0, &[("y_m", &|t| fallen(t))]);
        assert!(falls.is_drop);
        check(
            &falls,
            &[("air-drag", 0, k)],
            &[start, 0.0],
            1e-6,
            |_, t| fallen(t),
        );
    }

    #[test]
    fn air_slows_a_body_without_weight_as_in_closed_form() {
        let k = 0.3;
        let on = [("air-drag", 0, k), ("gravity", 0, 0.0)];
        // Along a line: ln(1 + k v t)/k of its way.
        check(&thrown(&[]), &on, &THROWN, 1e-6, |channel, t| {
            let way = (1.0 + k * 5.0 * t).ln() / k;
            [0.6 * way, 1.0 + 0.8 * way][channel]
        });
    }

    #[test]
    fn a_size_makes_drag_a_coefficient() {
        let (mass, diameter, coefficient) = (0.058, 0.066, 0.5);
        let k = coefficient * 0.5 * AIR * std::f64::consts::FRAC_PI_4 * diameter * diameter / mass;
        let ball = thrown(&[("mass_kg", mass), ("diameter_m", diameter)]);
        let on = |x| [("air-drag", 0, x)];
        let [by_size, plain] = [(&ball, coefficient), (&thrown(&[]), k)].map(|(flights, x)| {
            let terms = toy::terms(flights, &on(x));
            flights.predict(0, &terms, &THROWN).expect("an answer")
        });
        assert!(
            by_size
                .iter()
                .zip(plain)
                .all(|(a, b)| (a - b).abs() < 1e-12)
        );
    }

    #[test]
    fn a_drop_begins_when_it_is_let_go() {
        let release = 0.1;
        let fallen = |t: f64| 2.0 - 0.5 * G * (t - release).max(0.0).powi(2);
        let falls = flights(&[], 0.5, &[("y_m", &fallen)]);
        check(&falls, &[], &[2.0, release], 1e-12, |_, t| fallen(t));
    }

    /// The end of a boom of length L that is let go level: θ̇² = 2 (g/L) (sin θ₀ − sin θ), as energy
    /// is kept.
    #[test]
    fn the_end_of_a_boom_keeps_its_energy() {
        let length = 1.2;
        let shown: [(&str, &dyn Fn(f64) -> f64); 1] = [("y_m", &|t| 0.6 * (3.0 * t).sin())];
        let mut flights = flights(&[("boom_radius_m", length)], 0.6, &shown);
        flights.boom = vec![Some(length)];
        let (start, speed) = (0.2, 1.5);
        let terms = toy::terms(&flights, &[("counterweight", 0, 0.4)]);
        let y = flights
            .predict(0, &terms, &[start, speed])
            .expect("an answer");
        let time = rows(0.6);
        let energy = |k: usize| {
            // Fourth-order differences.
            let h = time[1];
            let rise = (y[k - 2] - y[k + 2] + 8.0 * (y[k + 1] - y[k - 1])) / (12.0 * h);
            let cos = (1.0 - (y[k] / length).powi(2)).sqrt();
            0.5 * (rise / cos).powi(2) + 0.4 * G * y[k]
        };
        let first = 0.5 * speed * speed / (1.0 - (start / length).powi(2)) + 0.4 * G * start;
        for k in 2..y.len() - 2 {
            assert!(
                (energy(k) - first).abs() < 1e-4 * first,
                "{k}: {} {first}",
                energy(k)
            );
        }
    }
}
