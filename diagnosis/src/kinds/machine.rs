//! Any machine that is a chain of links in a plane: its data come with a file that describes it.

mod causes;
mod guesses;
mod plant;
mod sizes;
mod start;

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use saltus_robot::Robot;
use saltus_robot::units::{ANGLE, Quantity, Unit};
use saltus_sim_check::chain::MOST;

use super::input::Input;
use super::{Causes, unknown};
use crate::experiment::{Experiment, Run, Sort};
use crate::kind::{Asked, Data, Kind, Parameter};
use crate::layout::{Draw, Layout, round};
use crate::mechanism::{Counterweight, Drive, Gauge, Inertia, Joint, Link, Mechanism, Shows};
use crate::plausible;
use crate::spec::{
    Column, Domain, FORCE, LEAP_ON, PART, Problem, Source, Spec, Synthesis, TURN_ON, calm, noisy,
    without,
};
use causes::Effect;
use guesses::Start;
use plant::{Change, Plant};
use sizes::Sizes;

/// A torque whose names end in `_nm`.
pub(super) const TORQUE: (Quantity, Domain) = (
    Quantity {
        si: "N m",
        dimension: [1, 2, -2],
        units: &[("_nm", Unit::SI)],
    },
    Domain::within(1e5).called("a torque"),
);

/// Columns of which any may be there, by their units.
const CHANNELS: &[Column] = &[
    without(calm("*_rad", TURN_ON)),
    without(calm("*_m", LEAP_ON)),
    without(calm("*_nm", TORQUE)),
    without(calm("*_n", FORCE)),
];

/// The kind.
pub(super) const SPEC: Spec = Spec {
    sort: Sort::Machine,
    id: "machine",
    description: "A chain of links in a plane, which a file describes",
    mechanism: true,
    channels: CHANNELS,
    checks: &[plausible::LINKS, plausible::PLACES],
    model: |data, _: Option<&Robot>| Ok(Box::new(of(data)?)),
    synthesis: Synthesis {
        instruments: &[
            noisy("shoulder_rad", 5e-4),
            noisy("elbow_rad", 5e-4),
            noisy("shoulder_nm", 0.0),
        ],
        without_boom: None,
        runs: 4,
        lay_out,
        source: Source::Model,
    },
    ..PART
};

/// Motions of a machine, or of a machine that is now one mechanism, now another.
#[derive(Clone, Debug)]
pub struct Motions {
    data: Data,
    /// Which mechanism each run is of, and which runs belong together.
    runs: Vec<Piece>,
    mechanisms: Vec<Mechanism>,
    /// What each drive of a run does.
    inputs: Vec<Vec<Input>>,
    starts: Vec<Start>,
    causes: Causes<Effect>,
    /// Longest step (s) of the integration.
    step: f64,
}

/// What a run is of.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    /// Index of its mechanism.
    pub(super) mechanism: usize,
    /// Runs of one group are left out together.
    pub(super) group: usize,
}

/// The motions of an experiment of this kind.
fn of(experiment: &Experiment) -> Result<Motions, Problem> {
    let Some(mechanism) = experiment.mechanism.clone() else {
        return Err(Problem::NoMachine {
            what: "rig.chain is missing: a machine needs the file that describes it".into(),
        });
    };
    let runs = (0..experiment.runs.len()).map(|group| Piece {
        mechanism: 0,
        group,
    });
    let mut motions = Motions::new(experiment, vec![mechanism], runs.collect())?;
    let is_used = |name: &&String| {
        let mechanism = &motions.mechanisms[0];
        let drives = mechanism.drives.iter().map(|drive| &drive.column);
        let gauges = mechanism.gauges.iter().map(|gauge| &gauge.column);
        drives.chain(gauges).any(|used| used == *name)
    };
    let unused: Vec<&str> = experiment
        .columns
        .iter()
        .filter(|name| !is_used(name))
        .map(String::as_str)
        .collect();
    if !unused.is_empty() {
        motions.data.notes.push(format!(
            "{}: {} not named there, and not used",
            motions.mechanisms[0].name,
            unused.join(", ")
        ));
    }
    Ok(motions)
}

impl Motions {
    /// The runs of an experiment, each of one of `mechanisms`, which have the same names.
    ///
    /// # Errors
    /// [`Problem::NoMachine`] where a column is missing, or a mechanism is none.
    pub(super) fn new(
        experiment: &Experiment,
        mechanisms: Vec<Mechanism>,
        runs: Vec<Piece>,
    ) -> Result<Motions, Problem> {
        let first = &mechanisms[0];
        let column = |name: &str| {
            let found = experiment.column(name);
            found.ok_or_else(|| Problem::NoMachine {
                what: format!(
                    "column {name} is missing or empty in the runs: {} names it",
                    first.name
                ),
            })
        };
        let gauges: Vec<usize> = first
            .gauges
            .iter()
            .map(|gauge| column(&gauge.column))
            .collect::<Result<_, _>>()?;
        let drives: Vec<usize> = first
            .drives
            .iter()
            .map(|drive| column(&drive.column))
            .collect::<Result<_, _>>()?;
        for mechanism in &mechanisms {
            plant::check(mechanism)?;
        }
        let mut data = Data::of(experiment, &gauges);
        let (channels, logs) = (&data.channels, &data.logs);
        let input = |run: &Run| drives.iter().map(|k| Input::of(run, Some(*k))).collect();
        let inputs: Vec<Vec<Input>> = experiment.runs.iter().map(input).collect();
        let starts: Vec<Start> = logs
            .iter()
            .zip(&runs)
            .map(|(log, piece)| Start::of(&mechanisms[piece.mechanism], log, channels))
            .collect();
        let most = |k: usize| {
            let of = |all: &Vec<Input>| all[k].values.iter().map(|x| x.abs()).fold(0.0, f64::max);
            inputs.iter().map(of).fold(0.0, f64::max)
        };
        let driven: Vec<f64> = (0..drives.len()).map(most).collect();
        let sizes = Sizes::of(first, &driven);
        let likely = start::likely(&mechanisms, &runs, logs, &inputs, &starts, &sizes);
        let step = plant::longest_step(&mechanisms, &starts, &runs, (&likely, logs))?;
        let all = causes::of(first, &sizes, channels, &likely);
        data.common = all.common.len();
        let listed = all.common.into_iter().chain(all.named).collect();
        data.notes = vec![
            "where each run starts is estimated from that run, of runs left out as well".into(),
        ];
        Ok(Motions {
            causes: Causes::of(&mut data, listed, all.terms),
            data,
            runs,
            inputs,
            starts,
            step,
            mechanisms,
        })
    }

    /// With other notes.
    pub(super) fn noting(mut self, notes: Vec<String>) -> Motions {
        self.data.notes = notes;
        self
    }
}

impl Kind for Motions {
    fn data(&self) -> &Data {
        &self.data
    }

    /// Every coordinate at the start, as its sensor says where it has one, and its rate.
    fn unknowns(&self, run: usize) -> Vec<Parameter> {
        let mechanism = &self.mechanisms[self.runs[run].mechanism];
        let start = &self.starts[run];
        let mut all = Vec::new();
        for (k, link) in mechanism.links.iter().enumerate() {
            let unit = if link.joint.turns() { "rad" } else { "m" };
            let name = format!("{}_start_{unit}", link.joint.name);
            all.push(unknown(&name, start.q[k], start.places[k], 1e-3));
        }
        for (k, link) in mechanism.links.iter().enumerate() {
            let unit = if link.joint.turns() { "rad_s" } else { "m_s" };
            let name = format!("{}_start_rate_{unit}", link.joint.name);
            all.push(unknown(&name, start.v[k], start.rates[k], 1e-2));
        }
        all
    }

    fn group(&self, run: usize) -> usize {
        self.runs[run].group
    }

    fn truths(&self, asked: &Asked<'_>) -> Option<Vec<f64>> {
        let (run, terms, unknowns) = asked.parts();
        let mechanism = &self.mechanisms[self.runs[run].mechanism];
        let both = (&self.mechanisms[0], mechanism);
        let plant = Plant::new(mechanism, Change::of(both, &self.causes, &self.data, terms))?;
        let n = mechanism.links.len();
        let (mut q, mut v) = (unknowns[..n].to_vec(), unknowns[n..].to_vec());
        for (channel, (gauge, sensor)) in mechanism.gauges.iter().zip(&asked.sensors).enumerate() {
            // The start is what the sensor says.
            if let Shows::Coordinate(k) = gauge.shows
                && self.starts[run].sensors[k] == Some(channel)
            {
                q[k] = sensor.truth(q[k]);
                v[k] /= sensor.gain;
            }
        }
        let log = &self.data.logs[run];
        let course = plant.run((&q, &v), log, &self.inputs[run], self.step)?;
        let mut out = vec![0.0; log.readings.len()];
        for (channel, gauge) in mechanism.gauges.iter().enumerate() {
            let rows = course.rows.iter();
            let shown: Vec<[f64; 2]> = rows.map(|row| plant.shown(gauge.shows, row)).collect();
            let mut at = 0;
            for (i, reading) in log.readings.iter().enumerate() {
                if reading.channel == channel {
                    out[i] = course.at(&shown, asked.times[i], &mut at);
                }
            }
        }
        Some(out)
    }

    fn stronger(&self) -> String {
        "longer runs, some of them with larger and faster motions".into()
    }
}

/// Adds swings of two links that hang on each other, every second of them driven at the shoulder.
fn lay_out(layout: &mut Layout, runs: usize, draw: &mut Draw) {
    let mechanism = two_links(draw);
    let sizes = Sizes::of(&mechanism, &[0.0]);
    let column = layout.column("shoulder_nm");
    for run in 0..runs {
        let is_driven = run % 2 == 1;
        let angle = if is_driven {
            0.0
        } else {
            draw.between(0.4, 0.9)
        };
        layout.add(
            &[],
            601,
            5e-3,
            vec![angle, draw.between(-0.3, 0.3), 0.0, 0.0],
        );
        let (torque, rate) = (sizes.torque[0], sizes.rate(0));
        let sines = [(); 2].map(|()| {
            (
                torque * draw.between(0.1, 0.2),
                rate * draw.between(0.3, 0.6),
                draw.between(0.0, TAU),
            )
        });
        let Some(run) = layout.experiment.runs.last_mut().filter(|_| is_driven) else {
            continue;
        };
        for (value, t) in run.values[column].iter_mut().zip(&run.time) {
            let sum: f64 = sines.iter().map(|(a, w, p)| a * (w * t + p).sin()).sum();
            *value = round((t / 0.2).clamp(0.0, 1.0) * sum);
        }
    }
    layout.experiment.mechanism = Some(mechanism);
}

/// An arm of two links, of sizes that are drawn.
fn two_links(draw: &mut Draw) -> Mechanism {
    let mut link = |name: &str, parent: Option<usize>, at: [f64; 2]| {
        let mass = round(draw.stepped(0.2, 1.0, 1e-3));
        let center = round(draw.stepped(0.08, 0.15, 1e-3));
        let inertia = round(draw.between(0.2, 0.5) * mass * center * center);
        Link {
            name: name.into(),
            joint: Joint::turning(name, parent, at),
            mass,
            center: [0.0, -center],
            inertia: Inertia::Center(inertia),
            counterweight: None::<Counterweight>,
        }
    };
    let links = vec![
        link("shoulder", None, [0.0, 0.0]),
        link("elbow", Some(0), [0.0, -0.25]),
    ];
    let gauge = |column: &str, joint| Gauge {
        column: column.into(),
        shows: Shows::Coordinate(joint),
    };
    Mechanism {
        name: "chain.toml".into(),
        gravity: 9.80665,
        links,
        springs: Vec::new(),
        drives: vec![Drive {
            column: "shoulder_nm".into(),
            joint: 0,
        }],
        gauges: vec![gauge("shoulder_rad", 0), gauge("elbow_rad", 1)],
    }
}

/// The name of a parameter of a part of a machine.
fn named(part: &str, name: &str) -> String {
    format!("{part}.{name}")
}

/// Names that are there twice.
pub(super) fn twice(names: &[&str]) -> Option<String> {
    let mut seen = BTreeSet::new();
    let again = names.iter().find(|name| !seen.insert(**name));
    again.map(|name| (*name).to_owned())
}

/// Whether a column is an angle.
fn is_angle(column: &str) -> bool {
    ANGLE
        .units
        .iter()
        .any(|(suffix, _)| column.ends_with(suffix))
}

const _: () = assert!(MOST == 12);

#[cfg(test)]
mod tests;
