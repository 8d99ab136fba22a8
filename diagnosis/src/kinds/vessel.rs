//! A vessel filling or discharging through an orifice, or one that was shut and should hold what is in it.

mod contents;

use std::f64::consts::{FRAC_PI_4, PI};

use saltus_numeric::hermite;
use saltus_numeric::statistics::quantile;
use saltus_pneumatics::OrificeLaw;
use saltus_robot::Gas as Perfect;
use saltus_robot::gas;
use saltus_robot::units::{MOLAR_MASS, NUMBER};

use super::{Causes, FREE, amount, causes, delay, faults, gain, offset, simple, unknown};
use crate::experiment::{Experiment, Run, Sort};
use crate::kind::{Asked, Cause, Channel, Data, Kind, Log, Parameter, Proposal, Reading, Terms};
use crate::kinds::Problem;
use crate::layout::{Draw, Layout};
use crate::plausible::{Check, PRESSURES, View};
use crate::spec::{
    ABSOLUTE, AREA, BORE, Domain, Form, PART, Setting, Source, Spec, Synthesis, TEMPERATURE,
    VOLUME, calm, lively, noisy, optional, required, without,
};
use contents::Contents;

/// What is given of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Vessel {
    /// Volume (m³); of a vessel that is shut, of which nobody knows it, 1: only areas over the volume can be told then.
    volume: f64,
    /// Diameter of the orifice (m); none: it is shut from its first row on.
    orifice: Option<f64>,
    /// Pressure (Pa) and temperature (K) until it is opened.
    pressure: f64,
    /// See `pressure`.
    temperature: f64,
    /// Pressure (Pa) outside.
    ambient: f64,
    /// When (s) it is opened, if the operator knows.
    release: Option<f64>,
    /// Area of the wall (m²); none: that of a sphere.
    wall: Option<f64>,
    /// The gas in it.
    contents: Contents,
}

/// Vessels.
#[derive(Clone, Debug)]
pub struct Vessels {
    data: Data,
    tanks: Vec<Vessel>,
    causes: Causes<Effect>,
    /// The gas that may be in them in place of the stated one.
    other: Perfect,
}

/// Standard deviations of a reading that has left the initial state.
const LEFT: f64 = 5.0;
/// The key, and the name of the unknown, of when it is opened.
const RELEASE: &str = "release_s";
/// Standard deviation (K) of a thermometer that could be had.
const THERMOMETER: f64 = 1.0;
/// How far the pressure at which a vessel was shut may be from the one that is given, as a part of it.
const SHUT_AT: f64 = 0.03;
/// Part of a run for which the supply may go on to hold the pressure of a vessel that is shut then.
const MOST_HELD: f64 = 0.3;
/// Steps of a run.
const STEPS: f64 = 500.0;
/// Part of the pressure from the balance within which steps are cut, and part of the gas that flows
/// within such a part of a step at most: the pressure is then true within a few millionths of
/// itself.
const NEAR: f64 = 0.05;
const SHARE: f64 = 3e-3;
const MOST_PARTS: f64 = 100.0;
/// What a channel measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Gauge {
    Pressure,
    Temperature,
}

impl Gauge {
    /// Of the column `name`.
    fn of(name: &str) -> Gauge {
        if name.ends_with("pressure_pa") {
            Gauge::Pressure
        } else {
            Gauge::Temperature
        }
    }
}

/// What a cause does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Effect {
    Heat,
    Gas,
    Outside,
    /// Area over volume (1/m) of what each shut vessel leaks through.
    Leak,
    /// Time (s) in which the wall brings the gas of a shut vessel back to its own temperature.
    Settling,
    /// Without a name.
    DriftByPressure,
    DriftByTime,
    Opening,
}

/// Whether no vessel has an orifice.
fn are_shut(experiment: &Experiment) -> bool {
    let mut runs = experiment.runs.iter();
    runs.all(|run| vessel(run).orifice.is_none())
}

/// Whether all vessels hold air.
fn are_air(experiment: &Experiment) -> bool {
    experiment.runs.iter().all(contents::is_air)
}

/// The listed causes.
fn named(experiment: &Experiment, logs: &[Log]) -> Vec<(Option<Effect>, Cause)> {
    let (bounds, scale) = ((-1e6, 1e6), 1e3);
    let name = "outside_pressure_pa";
    let outside = simple("supply-pressure", name, 0.0, bounds, scale, &[]);
    let mut all = if are_shut(experiment) {
        causes! {
            Effect::Leak => leaks(experiment, logs);
            Effect::Settling => amount("heat-transfer", "settling_time_s", 1e4, 0.1, &[1.0, 10.0]);
        }
    } else {
        let name = if are_air(experiment) {
            "carbon_dioxide_share"
        } else {
            "air_share"
        };
        let bounds = (0.8, 1.0);
        let gas = simple("gas-type", name, 0.0, bounds, 0.05, &[0.999]);
        // Natural convection, Nu = c Ra^⅓; turbulent, c is 0.1 to 0.15.
        let heat = amount("heat-transfer", "convection", 5.0, 0.02, &[0.1]);
        vec![(Some(Effect::Heat), heat), (Some(Effect::Gas), gas)]
    };
    all.push((Some(Effect::Outside), outside));
    all.extend(of_gauges(experiment));
    all
}

/// The leak of each shut vessel, as its area over the volume (1/m). A search starts where what left
/// first would have left at the speed of sound.
fn leaks(experiment: &Experiment, logs: &[Log]) -> Cause {
    const NAME: &str = "leak_area_per_volume_per_m";
    let of = |(run, log): (&Run, &Log)| {
        let tank = vessel(run);
        let gas = tank.contents.gas;
        let columns = experiment.columns.len();
        let column = |r: &&Reading| experiment.columns[r.channel % columns] == "pressure_pa";
        let mut readings = log.readings.iter().filter(column);
        let first = readings.next().map_or(0.0, |r| r.time);
        let is_far = |r: &&Reading| r.value < 0.6 * tank.pressure;
        let far = readings.clone().find(is_far).or(readings.next_back());
        let rate = far.map_or(0.0, |r| {
            (tank.pressure / r.value).ln() / (r.time - first).max(1e-9)
        });
        let speed = OrificeLaw::new(gas).choked * gas.constant * tank.temperature.sqrt();
        let likely = (rate / speed).clamp(1e-9, 0.1);
        let file = stem(&run.name);
        Parameter {
            starts: vec![likely],
            name: match logs {
                [_] => NAME.into(),
                _ => format!("{file}.{NAME}"),
            },
            ..unknown(NAME, 0.0, (0.0, 1.0), 0.05 * likely)
        }
    };
    let each = experiment.runs.iter().zip(logs).map(of);
    Cause::several("chamber-leak", each.collect())
}

/// Channels for each run: vessels that have nothing in common are no measure of each other.
fn each_its_own(channels: &[Channel], logs: &mut [Log]) -> Vec<Channel> {
    let mut all = Vec::new();
    for log in logs {
        for reading in &mut log.readings {
            reading.channel += all.len();
        }
        all.extend(channels.iter().map(|channel| Channel {
            name: format!("{}.{}", stem(&log.name), channel.name),
            ..channel.clone()
        }));
    }
    all
}

/// The name of a file without its ending.
fn stem(file: &str) -> &str {
    file.strip_suffix(".csv").unwrap_or(file)
}

/// What can be wrong with the gauges.
fn of_gauges(experiment: &Experiment) -> Vec<(Option<Effect>, Cause)> {
    let mut all = Vec::new();
    for (column, unit, size) in [("pressure_pa", "pa", 1e3), ("temperature_k", "k", 0.2)] {
        if experiment.columns.iter().all(|own| own != column) {
            continue;
        }
        let calibrated = "sensors are calibrated";
        all.extend(faults([
            offset(column, unit, FREE, size).usual(5.0 * size, calibrated),
            gain(column),
            delay(column, 10.0, 0.1),
        ]));
    }
    all
}

/// Terms of the flow without a name, of runs that last `last` (s).
fn unnamed(last: f64) -> Vec<(Option<Effect>, Cause)> {
    let drift = |id| simple(id, "c", 0.0, (-3.0, 3.0), 0.01, &[]);
    let by_pressure =
        "flow through the orifice, times 1 + c times the share of pressure that is lost";
    let by_time = "flow through the orifice, times 1 + c times the share of time that is gone";
    let (name, bounds) = ("orifice that opens over a time", (0.01 * last, last));
    let starts = [0.02, 0.06, 0.2].map(|part| part * last);
    causes! {
        Effect::DriftByPressure => drift(by_pressure);
        Effect::DriftByTime => drift(by_time);
        Effect::Opening => simple(name, "opening_s", 0.0, bounds, 0.02 * last, &starts);
    }
}

impl Vessels {
    /// The experiment's vessels.
    pub fn new(experiment: &Experiment) -> Vessels {
        let indices: Vec<usize> = (0..experiment.columns.len()).collect();
        let mut data = Data::of(experiment, &indices);
        if are_shut(experiment) && data.logs.len() > 1 {
            data.channels = each_its_own(&data.channels, &mut data.logs);
        }
        let named = named(experiment, &data.logs);
        let length = |log: &Log| Some(log.readings.last()?.time - log.readings.first()?.time);
        let last = data.logs.iter().filter_map(length).fold(0.0, f64::max);
        let note = |run: &Run| {
            let tank = vessel(run);
            contents::note(run, tank.pressure.max(tank.ambient), tank.temperature)
        };
        data.notes.extend(experiment.runs.iter().filter_map(note));
        Vessels {
            causes: Causes::of(&mut data, named, unnamed(last)),
            data,
            tanks: experiment.runs.iter().map(vessel).collect(),
            other: if are_air(experiment) {
                Perfect::CO2
            } else {
                Perfect::AIR
            },
        }
    }

    /// Times (s) of the first and the last reading of a run.
    fn span(&self, run: usize) -> (f64, f64) {
        let time = |reading: Option<&Reading>| reading.map_or(0.0, |reading| reading.time);
        let readings = &self.data.logs[run].readings;
        (time(readings.first()), time(readings.last()))
    }

    /// When (s) it was opened: the earliest, the likeliest and the latest time.
    ///
    /// The latest is that of the first reading that has left the initial state. The likeliest is
    /// where a line through it and a reading more than twice as far away meets that state. The
    /// earliest is twice as long before as that line would meet it with both readings off by as
    /// much as no noise is: a bound that shuts out the truth in one of many runs would be a false
    /// alarm.
    fn opened(&self, run: usize) -> [f64; 3] {
        let (first, last) = self.span(run);
        let tank = &self.tanks[run];
        let own = self.data.logs[run].readings.iter().map(|r| r.channel).min();
        let own = own.unwrap_or(0);
        let channel = &self.data.channels[own];
        let initial = match Gauge::of(&channel.name) {
            Gauge::Pressure => tank.pressure,
            Gauge::Temperature => tank.temperature,
        };
        let away = |r: &Reading| (r.value - initial).abs();
        let doubt = LEFT * channel.noise;
        let mut column = self.data.logs[run]
            .readings
            .iter()
            .filter(|r| r.channel == own);
        let long_before = first - 2.0 * (last - first);
        let Some(left) = column.find(|r| away(r) > doubt) else {
            return [long_before, first, last];
        };
        // Both may be off by the doubt, and are then still apart by as much.
        let Some(farther) = column.find(|r| away(r) > 2.0 * away(left) + 2.0 * doubt) else {
            return [long_before, left.time, left.time];
        };
        let (near, apart) = (away(left), away(farther) - away(left));
        let between = farther.time - left.time;
        let most = between * (near + doubt) / (apart - 2.0 * doubt);
        [
            left.time - 2.0 * most,
            left.time - between * near / apart,
            left.time,
        ]
    }
}

fn vessel(run: &Run) -> Vessel {
    let of = |key: &str| run.settings.get(key).copied();
    Vessel {
        volume: of("volume_m3").unwrap_or(1.0),
        orifice: of("orifice_diameter_m"),
        pressure: of("initial_pressure_pa").unwrap_or(101_325.0),
        temperature: of("initial_temperature_k").unwrap_or(293.15),
        ambient: of("ambient_pressure_pa").unwrap_or(101_325.0),
        release: of(RELEASE),
        wall: of("wall_area_m2"),
        contents: contents::contents(run),
    }
}

impl Kind for Vessels {
    fn data(&self) -> &Data {
        &self.data
    }

    /// What the orifice lets through of the ideal flow, which no drawing tells; and when it was
    /// opened, where nobody says: some time before or after the first row.
    ///
    /// Of a vessel that is shut the pressure at that instant, which its gauge tells better than who
    /// filled it; and the instant, until which the supply may have held it.
    fn unknowns(&self, run: usize) -> Vec<Parameter> {
        let tank = &self.tanks[run];
        if tank.orifice.is_none() {
            let at = tank.pressure;
            let (bounds, scale) = (((1.0 - SHUT_AT) * at, (1.0 + SHUT_AT) * at), 1e-3 * at);
            let mut all = vec![unknown("initial_pressure_pa", at, bounds, scale)];
            if tank.release.is_none() {
                let (first, last) = self.span(run);
                let [_, likeliest, latest] = self.opened(run);
                let bounds = (
                    first,
                    latest.clamp(first, first + MOST_HELD * (last - first)),
                );
                let (release, scale) = (likeliest.clamp(bounds.0, bounds.1), 1e-3 * (last - first));
                all.push(unknown(RELEASE, release, bounds, scale));
            }
            return all;
        }
        let mut all = vec![unknown("discharge_coefficient", 0.8, (0.05, 1.5), 0.02)];
        if tank.release.is_none() {
            let [earliest, likeliest, latest] = self.opened(run);
            all.push(unknown(
                RELEASE,
                likeliest,
                (earliest, latest),
                1e-3 * (self.span(run).1 - earliest),
            ));
        }
        all
    }

    fn stronger(&self) -> String {
        "runs from a pressure that is farther from the other side's, until both are equal".into()
    }

    /// Each vessel that is shut has a leak of its own.
    fn is_apart(&self) -> bool {
        self.tanks.iter().all(|tank| tank.orifice.is_none())
    }

    /// The same runs with the temperature of the gas measured too, where it was not.
    fn proposals(&self) -> Vec<Proposal> {
        let mut measured = self.data.channels.iter();
        if measured.any(|c| c.name.ends_with("temperature_k")) || self.is_apart() {
            return Vec::new();
        }
        let channel = Channel {
            name: "temperature_k".into(),
            noise: THERMOMETER,
            step: 0.0,
            is_given: true,
        };
        let proposal = |(log, tank): (&Log, &Vessel)| {
            let readings = log
                .readings
                .iter()
                .map(|r| Reading { channel: 0, ..*r })
                .collect();
            let name = log.name.clone();
            let kind = Vessels {
                data: Data {
                    channels: vec![channel.clone()],
                    logs: vec![Log { name, readings }],
                    ..self.data.clone()
                },
                tanks: vec![*tank],
                causes: self.causes.clone(),
                other: self.other,
            };
            let what = format!(
                "measure the temperature of the gas too, to {THERMOMETER} K, in a run like {}",
                log.name
            );
            Proposal {
                what,
                kind: Box::new(kind),
            }
        };
        self.data
            .logs
            .iter()
            .zip(&self.tanks)
            .map(proposal)
            .collect()
    }

    fn truths(&self, asked: &Asked<'_>) -> Option<Vec<f64>> {
        let (run, terms, unknowns) = asked.parts();
        let gas = self.gas(run, terms, unknowns)?;
        let knots = gas.knots();
        let truth = |(reading, time): (&Reading, &f64)| {
            let state = between(&knots, gas.step, time - gas.release);
            match Gauge::of(&self.data.channels[reading.channel].name) {
                Gauge::Pressure => gas.pressure(state),
                Gauge::Temperature => state[1],
            }
        };
        let readings = self.data.logs[run].readings.iter();
        Some(readings.zip(&asked.times).map(truth).collect())
    }
}

/// Gas in a vessel: its mass (kg) and temperature (K) are the state.
struct Gas {
    vessel: Vessel,
    /// Heat ratio and gas constant (J/(kg K)).
    kappa: f64,
    constant: f64,
    law: OrificeLaw,
    /// Effective area of the orifice (m²).
    area: f64,
    /// Pressure (Pa) outside.
    outside: f64,
    /// Area of the wall (m²), and the coefficient of natural convection there.
    wall: f64,
    convection: f64,
    /// Of a shut vessel, the time (s) in which the wall brings the gas back to its own temperature;
    /// 0: it is always there.
    settling: Option<f64>,
    /// When (s) the orifice is opened, how long that takes, and how long the run is from there.
    release: f64,
    opening: f64,
    last: f64,
    /// Length (s) of a step, and in how many parts it is cut near the balance.
    step: f64,
    parts: f64,
    /// Part of the pressure below which the flow is in proportion to the difference.
    least: f64,
    /// Drift of the flow with the share of pressure that is lost, and of time that is gone.
    drift: [f64; 2],
}

impl Vessels {
    /// The gas of a run; none where it cannot flow.
    fn gas(&self, run: usize, terms: &Terms, unknowns: &[f64]) -> Option<Gas> {
        let value = |effect, none| self.causes.or(effect, none, terms);
        let mut vessel = self.tanks[run];
        let share = value(Effect::Gas, 0.0);
        let mix = |a: f64, b: f64| a + share * (b - a);
        let (own, other) = (vessel.contents.gas, self.other);
        let (kappa, constant) = (
            mix(own.heat_ratio, other.heat_ratio),
            mix(own.constant, other.constant),
        );
        let (first, end) = self.span(run);
        let (widest, area, release) = if let Some(orifice) = vessel.orifice {
            let widest = FRAC_PI_4 * orifice * orifice;
            let release = vessel.release.or(unknowns.get(1).copied())?;
            (widest, widest * unknowns[0], release)
        } else {
            vessel.pressure = unknowns[0];
            let leak = self.causes.get(Effect::Leak, run, terms);
            let area = vessel.volume * leak.unwrap_or(0.0);
            (area, area, vessel.release.or(unknowns.get(1).copied())?)
        };
        let last = end - release;
        let steps = match vessel.orifice {
            Some(_) => STEPS,
            None => 4.0 * STEPS,
        };
        let step = last / steps;
        // Near the balance steps are cut into so many parts: the same ones whatever is fitted.
        let speed = kappa * (constant * vessel.temperature).sqrt() / vessel.volume;
        let parts = match vessel.orifice {
            Some(_) => (speed * widest * (end - first) / (STEPS * SHARE)).ceil(),
            None => 1.0,
        };
        let parts = parts.clamp(1.0, MOST_PARTS);
        let sphere = || (36.0 * PI).cbrt() * vessel.volume.powf(2.0 / 3.0);
        let outside = vessel.ambient + value(Effect::Outside, 0.0);
        (outside > 0.0 && last > 0.0).then(|| Gas {
            vessel,
            kappa,
            constant,
            law: OrificeLaw::new(Perfect {
                heat_ratio: kappa,
                constant,
            }),
            area,
            outside,
            wall: vessel.wall.unwrap_or_else(sphere),
            convection: value(Effect::Heat, 0.0),
            settling: vessel
                .orifice
                .is_none()
                .then(|| value(Effect::Settling, 0.0)),
            release,
            opening: value(Effect::Opening, 0.0),
            last,
            step,
            parts,
            // A part there shall not be stiff: the flow is nearly √(2 difference).
            least: (2.0 * (speed * area * step / parts).powi(2)).clamp(1e-9, 0.1),
            drift: [
                value(Effect::DriftByPressure, 0.0),
                value(Effect::DriftByTime, 0.0),
            ],
        })
    }
}

impl Gas {
    /// Pressure (Pa).
    fn pressure(&self, [mass, temperature]: [f64; 2]) -> f64 {
        mass * self.constant * temperature / self.vessel.volume
    }

    /// Mass flow over conductance (Pa √(kg K/J)) from `up` to `down` (Pa); in proportion to the
    /// difference where that is less than the part `least` of `up`, so that steps of an integration
    /// do not jump to and fro across the balance.
    fn flow(&self, up: f64, down: f64) -> f64 {
        if down > (1.0 - self.least) * up {
            return self.law.flow(1.0, 1.0 - self.least) * (up - down) / self.least;
        }
        self.law.flow(up, down)
    }

    /// Rates of the state by mass and energy of the gas: dU = h_in dm + Q, with natural convection
    /// from a wall that stays at the first temperature.
    fn rates(&self, time: f64, [mass, temperature]: [f64; 2]) -> [f64; 2] {
        let (vessel, outside) = (&self.vessel, self.outside);
        let pressure = self.pressure([mass, temperature]);
        let (up, down, source, sign) = if pressure > outside {
            (pressure, outside, temperature, -1.0)
        } else {
            (outside, pressure, vessel.temperature, 1.0)
        };
        let lost = (vessel.pressure - pressure) / (vessel.pressure - outside);
        let opened = if time < self.opening {
            time / self.opening
        } else {
            1.0
        };
        let drifted =
            opened * (1.0 + self.drift[0] * lost + self.drift[1] * time / self.last).max(0.0);
        let flow = sign * drifted * self.area / source.sqrt() * self.flow(up, down);
        let heat =
            self.convection * self.wall * convection(vessel, mass / vessel.volume, temperature);
        let heat_capacity = self.constant / (self.kappa - 1.0);
        // Inflow brings the enthalpy of outside, outflow takes that of inside.
        let brought = flow * (self.kappa * source - temperature) * heat_capacity;
        let warming = (brought + heat) / (mass * heat_capacity);
        match self.settling {
            None => [flow, warming],
            // What settles within a step is always where it settles.
            Some(time) if time < self.step => {
                let settled = vessel.temperature + time * warming;
                [flow, (settled - temperature) / self.step]
            }
            Some(time) => [flow, warming + (vessel.temperature - temperature) / time],
        }
    }

    /// The state after each step, with its rates.
    fn knots(&self) -> Vec<(f64, [f64; 2], [f64; 2])> {
        let vessel = &self.vessel;
        let rates = |time, state| self.rates(time, state);
        let mut state = [
            vessel.pressure * vessel.volume / (self.constant * vessel.temperature),
            vessel.temperature,
        ];
        let mut now = 0.0;
        let mut knots = vec![(0.0, state, rates(0.0, state))];
        while now < self.last {
            let pressure = self.pressure(state);
            let is_near = (pressure - self.outside).abs() < NEAR * pressure.max(self.outside);
            let (mut left, h) = if is_near {
                (self.parts, self.step / self.parts)
            } else {
                (1.0, self.step)
            };
            let mut time = now;
            while left > 0.5 {
                state = runge_kutta(time, state, h, &rates);
                time += h;
                left -= 1.0;
            }
            now += self.step;
            knots.push((now, state, rates(now, state)));
        }
        knots
    }
}

/// Heat (W/m²) from the wall, which stays at the first temperature, to gas of this density (kg/m³) at
/// `inside` (K), for Nu = Ra^⅓: no length matters.
fn convection(vessel: &Vessel, density: f64, inside: f64) -> f64 {
    let Contents {
        conductivity,
        viscosity,
        capacity,
        ..
    } = vessel.contents;
    let wall = vessel.temperature;
    let difference = wall - inside;
    let film = 0.5 * (wall + inside);
    let rayleigh =
        9.81 / film * difference.abs() * density * density * capacity / (viscosity * conductivity);
    conductivity * rayleigh.cbrt() * difference
}

/// The state at `time` between knots that are `step` apart, by cubics.
fn between(knots: &[(f64, [f64; 2], [f64; 2])], step: f64, time: f64) -> [f64; 2] {
    // The number of a knot.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let k = ((time / step).max(0.0) as usize).min(knots.len().saturating_sub(2));
    let (a, b) = (&knots[k], &knots[(k + 1).min(knots.len() - 1)]);
    let s = ((time - a.0) / step).clamp(0.0, 1.0);
    std::array::from_fn(|i| hermite((a.1[i], a.2[i]), (b.1[i], b.2[i]), step, s).0)
}

fn runge_kutta(t: f64, y: [f64; 2], h: f64, f: &impl Fn(f64, [f64; 2]) -> [f64; 2]) -> [f64; 2] {
    let add = |k: [f64; 2], h: f64| [y[0] + h * k[0], y[1] + h * k[1]];
    let a = f(t, y);
    let b = f(t + 0.5 * h, add(a, 0.5 * h));
    let c = f(t + 0.5 * h, add(b, 0.5 * h));
    let d = f(t + h, add(c, h));
    std::array::from_fn(|k| y[k] + h / 6.0 * (a[k] + 2.0 * b[k] + 2.0 * c[k] + d[k]))
}

/// The kind.
pub(super) const SPEC: Spec = Spec {
    sort: Sort::Vessel,
    id: "vessel",
    description: "A vessel filling or discharging, or shut",
    // A slow discharge may be as warm as the room throughout.
    channels: &[
        without(lively("pressure_pa", ABSOLUTE)),
        without(calm("temperature_k", TEMPERATURE)),
    ],
    any_of: true,
    settings: &[
        optional("volume_m3", VOLUME),
        optional("orifice_diameter_m", BORE),
        required("initial_pressure_pa", ABSOLUTE),
        required("initial_temperature_k", TEMPERATURE),
        required("ambient_pressure_pa", ABSOLUTE),
        optional("wall_area_m2", AREA),
        Setting {
            words: contents::WORDS,
            form: Form::Word,
            ..optional(contents::NAME, (NUMBER, Domain::FINITE))
        },
        optional(contents::MOLAR_MASS, (MOLAR_MASS, gas::MOLAR_MASSES)),
        optional(contents::HEAT_RATIO, (NUMBER, gas::HEAT_RATIOS)),
    ],
    instants: &[RELEASE],
    least: 5,
    // It may leak for days.
    longest: f64::INFINITY,
    checks: &[
        Check {
            name: "pressure_pa",
            sizes: |view| {
                let expected = view
                    .setting("initial_pressure_pa")?
                    .max(view.setting("ambient_pressure_pa")?);
                Some((quantile(view.column("pressure_pa")?, 0.95)?, expected))
            },
            what: "the higher of initial and ambient pressure",
            allowed: (0.05, 4.0),
            strict: false,
            units: PRESSURES,
        },
        Check {
            name: "volume_m3",
            sizes: |view| Some((view.setting("volume_m3")?, emptied(view)?)),
            what: "the volume whose pressure the orifice changes as fast as measured",
            // The orifice may let through a twentieth of the ideal flow.
            allowed: (0.05, 25.0),
            strict: false,
            units: &[
                ("l", 1e-3),
                ("cm3", 1e-6),
                ("inch3", 1.638_706_4e-5),
                ("ft3", 0.028_316_846_592),
                ("m3, and time_s in min", 1.0 / 60.0),
                ("m3, and time_s in ms", 1e3),
                ("m3, and orifice_diameter_m in mm", 1e6),
                ("m3, and orifice_diameter_m in cm", 1e4),
                ("m3, and orifice_diameter_m in inch", 1_550.003_100_006_2),
            ],
        },
        Check {
            name: "wall_area_m2",
            sizes: |view| {
                let sphere = (36.0 * PI).cbrt() * view.setting("volume_m3")?.powf(2.0 / 3.0);
                Some((view.setting("wall_area_m2")?, sphere))
            },
            what: "the area of a sphere of that volume",
            // A vessel full of wool has a hundred times as much.
            allowed: (0.0, 300.0),
            strict: false,
            units: &[("cm2", 1e-4), ("inch2", 6.4516e-4), ("mm2", 1e-6)],
        },
    ],
    model: |data, _| {
        data.runs.iter().try_for_each(is_whole)?;
        data.runs.iter().try_for_each(contents::is_one)?;
        Ok(Box::new(Vessels::new(data)))
    },
    synthesis: Synthesis {
        instruments: &[noisy("pressure_pa", 3e3), noisy("temperature_k", 1.0)],
        without_boom: None,
        runs: 5,
        lay_out,
        source: Source::Model,
    },
    ..PART
};

/// The volume (m³) whose pressure changes as measured, from a quarter of its change to three quarters,
/// with the ideal flow through the orifice at the speed of sound.
fn emptied(view: &View<'_>) -> Option<f64> {
    let pressure = view.column("pressure_pa")?;
    let orifice = view.setting("orifice_diameter_m")?;
    let temperature = view.setting("initial_temperature_k")?;
    let outside = view.setting("ambient_pressure_pa")?;
    let (first, last) = (
        quantile(&pressure[..3.min(pressure.len())], 0.5)?,
        *pressure.iter().rfind(|p| p.is_finite())?,
    );
    let reached = |part: f64| {
        let mut rows = view.run.time.iter().zip(pressure);
        rows.find(|(_, p)| (*p - first) / (last - first) > part)
    };
    let (from, to) = (reached(0.25)?, reached(0.75)?);
    let up = outside.max(0.5 * (from.1 + to.1));
    let gas = contents::contents(view.run).gas;
    let law = OrificeLaw::new(gas);
    let flow = law.choked * FRAC_PI_4 * orifice * orifice * up / temperature.sqrt();
    let density = (to.1 - from.1).abs() / (gas.constant * temperature);
    Some(flow * (to.0 - from.0) / density).filter(|volume| *volume > 0.0)
}

/// Refuses a vessel of which only the volume or only the orifice is known.
fn is_whole(run: &Run) -> Result<(), Problem> {
    let keys = ["volume_m3", "orifice_diameter_m"];
    let [volume, orifice] = keys.map(|key| run.settings.contains_key(key));
    let (given, missing) = match (volume, orifice) {
        (true, false) => (keys[0], keys[1]),
        (false, true) => (keys[1], keys[0]),
        _ => return Ok(()),
    };
    Err(Problem::HalfAVessel {
        run: run.name.clone(),
        given,
        missing,
    })
}

/// Adds discharges of one vessel, every third a filling.
fn lay_out(layout: &mut Layout, runs: usize, draw: &mut Draw) {
    let (volume, orifice) = (draw.between(0.005, 0.03), draw.between(1.5e-3, 3e-3));
    let discharge = draw.between(0.6, 0.95);
    let wall = 4.836 * volume.powf(2.0 / 3.0) * draw.between(1.1, 1.6);
    // Time in which the gas would be gone at the first rate.
    let scale = volume / (discharge * PI / 4.0 * orifice * orifice * 0.685 * 290.0);
    for k in 0..runs {
        let (high, low) = (draw.stepped(4e5, 12e5, 1e4), 1e5);
        let (inside, outside) = if k % 3 == 2 { (low, high) } else { (high, low) };
        let step = scale * draw.between(1.5, 3.0) / 100.0;
        let settings = [
            ("volume_m3", volume),
            ("orifice_diameter_m", orifice),
            ("initial_pressure_pa", inside),
            ("initial_temperature_k", draw.stepped(288.0, 300.0, 0.1)),
            ("ambient_pressure_pa", outside),
            ("wall_area_m2", wall),
        ];
        layout.add(&settings, 101, step, vec![discharge, 0.0]);
    }
}

#[cfg(test)]
mod tests {
    use rand_distr::{Distribution, StandardNormal};
    use rand_pcg::Pcg64;

    use super::*;
    use crate::experiment::Sort;

    const NOISE: f64 = 3000.0;
    const VOLUME: f64 = 0.01;
    const ORIFICE: f64 = 2e-3;
    const TEMPERATURE: f64 = 290.0;
    const OUTSIDE: f64 = 1.2e6;

    /// A vessel that fills, opened at the first row, and what its gauge shows.
    fn filling(initial: f64, time: Vec<f64>, pressure: Vec<f64>) -> Vessels {
        let settings = [
            ("volume_m3", VOLUME),
            ("orifice_diameter_m", ORIFICE),
            ("initial_pressure_pa", initial),
            ("initial_temperature_k", TEMPERATURE),
            ("ambient_pressure_pa", OUTSIDE),
        ];
        let settings = settings.map(|(key, value)| (key.to_owned(), value)).into();
        Vessels::new(&Experiment {
            kind: Sort::Vessel,
            mechanism: None,
            columns: vec!["pressure_pa".into()],
            noise: vec![Some(NOISE)],
            resolution: vec![None],
            runs: vec![Run {
                settings,
                time,
                values: vec![pressure],
                ..Run::default()
            }],
        })
    }

    /// Pressure (Pa) at a time (s): gas that fills a vessel without heat below the speed of sound;
    /// of the temperature ratio e across the orifice √(1 − e) falls evenly, to 0 at the balance.
    fn filled(initial: f64, discharge: f64, time: f64) -> f64 {
        let (kappa, gas) = (Perfect::AIR.heat_ratio, Perfect::AIR.constant);
        let area = discharge * FRAC_PI_4 * ORIFICE * ORIFICE;
        let fall = (kappa - 1.0) * gas * TEMPERATURE / VOLUME
            * area
            * (2.0 * kappa / (gas * TEMPERATURE * (kappa - 1.0))).sqrt();
        let start = (1.0 - (initial / OUTSIDE).powf((kappa - 1.0) / kappa)).sqrt();
        let root = (start - 0.5 * fall * time).max(0.0);
        OUTSIDE * (1.0 - root * root).powf(kappa / (kappa - 1.0))
    }

    /// Choked and without heat p = p₀ (1 + (κ − 1)/2 t/τ)^(−2κ/(κ−1)), with τ the gas over its first
    /// outflow; the temperature follows (p/p₀)^((κ−1)/κ).
    #[test]
    fn another_gas_blows_down_as_in_closed_form() {
        let helium = [(contents::NAME, contents::WORDS[4].1)];
        let heavy = [
            (contents::MOLAR_MASS, 0.146_055),
            (contents::HEAT_RATIO, 1.094),
        ];
        for (gas, constant, kappa) in [
            (&helium[..], 2077.26, 5.0 / 3.0),
            (&heavy[..], 56.927, 1.094),
        ] {
            let law = OrificeLaw::new(Perfect {
                heat_ratio: kappa,
                constant,
            });
            let (first, discharge) = (8e6, 0.8);
            let area = discharge * FRAC_PI_4 * ORIFICE * ORIFICE;
            let tau = VOLUME / (area * law.choked * constant * TEMPERATURE.sqrt());
            let time: Vec<f64> = (0..=200).map(|k| f64::from(k) * tau / 200.0).collect();
            let pressure = |t: &f64| {
                let fall: f64 = 1.0 + 0.5 * (kappa - 1.0) * t / tau;
                first * fall.powf(-2.0 * kappa / (kappa - 1.0))
            };
            let exact: Vec<f64> = time.iter().map(pressure).collect();
            let mut vessels = filling(first, time, exact.clone());
            let run = Run {
                settings: gas.iter().map(|(k, v)| ((*k).to_owned(), *v)).collect(),
                ..Run::default()
            };
            vessels.tanks[0].contents = contents::contents(&run);
            vessels.tanks[0].ambient = 1e5;
            let off = Terms::off(vessels.causes());
            let found = vessels
                .predict(0, &off, &[discharge, 0.0])
                .expect("an answer");
            for (p, q) in exact.iter().zip(found) {
                assert!((p / q - 1.0).abs() < 1e-5, "{constant}: {q}, {p}");
            }
        }
    }

    /// Where the flow ends its root is steep: the steps must not round it off, or every vessel that
    /// fills up seems to have something wrong.
    #[test]
    fn a_vessel_fills_up_as_in_closed_form() {
        for (initial, end) in [(0.7e6, 8.0), (0.7e6, 40.0), (1.15e6, 3.0)] {
            let time: Vec<f64> = (0..=400).map(|k| f64::from(k) * end / 400.0).collect();
            let pressure: Vec<f64> = time.iter().map(|t| filled(initial, 0.8, *t)).collect();
            let vessels = filling(initial, time.clone(), pressure.clone());
            let found = vessels
                .predict(0, &Terms::off(vessels.causes()), &[0.8, 0.0])
                .expect("an answer");
            for ((t, p), q) in time.iter().zip(pressure).zip(found) {
                // A hundredth of what a good gauge tells.
                assert!(
                    (p - q).abs() < 1e-5 * OUTSIDE,
                    "{initial} Pa, {t} of {end} s: {q}, {p}"
                );
            }
        }
    }

    /// Whatever the noise makes of the first readings: a truth that is shut out is a false alarm.
    #[test]
    fn the_opening_is_within_its_bounds() {
        let mut random = Pcg64::new(1, 1);
        for k in 0..3000 {
            // From half a standard deviation a row to many.
            let between = [0.004, 0.016, 0.03, 0.1][k % 4];
            let time: Vec<f64> = (0..150).map(|k| f64::from(k) * between).collect();
            let read = |t: &f64| {
                let noise: f64 = StandardNormal.sample(&mut random);
                filled(0.7e6, 0.8, *t) + NOISE * noise
            };
            let pressure = time.iter().map(read).collect();
            let [earliest, likeliest, latest] = filling(0.7e6, time, pressure).opened(0);
            assert!(
                earliest <= 0.0 && latest >= 0.0,
                "{k}: {earliest} to {latest}"
            );
            assert!((earliest..=latest).contains(&likeliest), "{k}: {likeliest}");
        }
    }
}
