//! A mass on a guide, driven by a measured force.

use std::f64::consts::TAU;

use super::{FREE, sensor, simple, unknown};
use crate::experiment::{Experiment, Run, Sort};
use crate::kind::{Cause, Channel, Kind, Log, Parameter, Terms};
use crate::noise;
use crate::layout::{Draw, Layout, count};
use crate::spec::{
    FORCE, LOAD, PART, POSITION, Source, Spec, Synthesis, calm, lively, noisy, optional,
};

/// What is given of a run.
#[derive(Clone, Debug, PartialEq)]
struct Drive {
    /// Mass (kg), if it is known.
    mass: Option<f64>,
    /// When (s) each force was measured.
    time: Vec<f64>,
    /// Force (N).
    force: Vec<f64>,
}

/// Slides.
#[derive(Clone, Debug)]
pub struct Slides {
    channels: Vec<Channel>,
    logs: Vec<Log>,
    drives: Vec<Drive>,
    causes: Vec<Cause>,
    mass_is_known: bool,
    /// Standard deviation (N) of a measured force.
    force_noise: f64,
}

/// Longest step (s).
const STEP: f64 = 1e-3;

impl Slides {
    /// The experiment's slides.
    pub fn new(experiment: &Experiment) -> Slides {
        let column = |name: &str| {
            experiment
                .columns
                .iter()
                .position(|c| c == name)
                .unwrap_or(0)
        };
        let (force, position) = (column("force_n"), column("position_m"));
        let mut channels = noise::channels(experiment, &[position]);
        let of_force = noise::channels(experiment, &[force]).swap_remove(0);
        channels[0].is_given &= of_force.is_given;
        let force_noise = of_force.noise;
        let logs = experiment
            .runs
            .iter()
            .map(|run| noise::log(experiment, run, &[position]))
            .collect();
        let drives: Vec<Drive> = experiment
            .runs
            .iter()
            .map(|run| drive(run, force))
            .collect();
        let mass_is_known = drives.iter().all(|d| d.mass.is_some());
        let mut causes = vec![
            simple(
                "coulomb-friction",
                "coulomb_friction_n",
                0.0,
                (0.0, 1e5),
                0.5,
                &[1.0, 5.0],
            ),
            simple(
                "viscous-friction",
                "viscous_friction_n_s_per_m",
                0.0,
                (0.0, 1e6),
                0.5,
                &[1.0, 10.0],
            ),
            simple("air-drag", "drag_n_s2_per_m2", 0.0, (0.0, 1e5), 0.1, &[1.0]),
            Cause::several(
                "return-spring",
                vec![
                    unknown("stiffness_n_per_m", 0.0, (0.0, 1e7), 5.0),
                    unknown("preload_n", 0.0, (-1e5, 1e5), 0.5),
                ],
            ),
            sensor("sensor-offset", "force_n", "offset_n", 0.0, FREE, 0.1, &[]),
            sensor(
                "sensor-delay",
                "position_m",
                "delay_s",
                0.0,
                (0.0, 0.5),
                1e-3,
                &[0.01],
            ),
            sensor(
                "sensor-delay",
                "force_n",
                "delay_s",
                0.0,
                (0.0, 0.5),
                1e-3,
                &[0.01],
            ),
            sensor(
                "encoder-scale",
                "position_m",
                "gain",
                1.0,
                (0.2, 5.0),
                0.01,
                &[],
            ),
        ];
        if mass_is_known {
            causes.push(sensor(
                "encoder-scale",
                "force_n",
                "gain",
                1.0,
                (0.2, 5.0),
                0.01,
                &[],
            ));
            causes.push(simple(
                "mass",
                "mass_share",
                1.0,
                (0.05, 20.0),
                0.02,
                &[0.8, 1.25],
            ));
        }
        Slides {
            channels,
            logs,
            drives,
            causes,
            mass_is_known,
            force_noise,
        }
    }

    /// A parameter of the cause `id`; none where this experiment has no such cause.
    fn term(&self, id: &str, parameter: usize, terms: &Terms) -> Option<f64> {
        self.causes
            .iter()
            .position(|c| c.id == id)
            .map(|i| terms.get(i, parameter))
    }
}

/// The force of a run, where it was measured.
fn drive(run: &Run, force: usize) -> Drive {
    let rows = (0..run.time.len()).filter(|&i| run.values[force][i].is_finite());
    let (time, force) = rows.map(|i| (run.time[i], run.values[force][i])).unzip();
    Drive {
        mass: run.settings.get("mass_kg").copied(),
        time,
        force,
    }
}

impl Drive {
    /// Force (N) at `t`, after row `at`: a cubic through four rows (Catmull and Rom).
    fn between(&self, at: usize, t: f64) -> f64 {
        let last = self.time.len() - 1;
        let (a, b) = (at.min(last), (at + 1).min(last));
        let width = self.time[b] - self.time[a];
        if width <= 0.0 {
            return self.force[a];
        }
        let s = ((t - self.time[a]) / width).clamp(0.0, 1.0);
        let slope = |i: usize| {
            let (before, after) = (i.saturating_sub(1), (i + 1).min(last));
            width * (self.force[after] - self.force[before])
                / (self.time[after] - self.time[before])
        };
        let (p, q) = (self.force[a], self.force[b]);
        let (u, v, rise) = (slope(a), slope(b), q - p);
        p + s * (u + s * (3.0 * rise - 2.0 * u - v + s * (u + v - 2.0 * rise)))
    }
}

impl Kind for Slides {
    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn logs(&self) -> &[Log] {
        &self.logs
    }

    /// Where and how fast it starts; its mass where nobody knows it.
    fn unknowns(&self, run: usize) -> Vec<Parameter> {
        let readings = &self.logs[run].readings;
        let start = readings.first().map_or(0.0, |r| r.value);
        let mut all = vec![
            unknown("start_m", start, FREE, 1e-3),
            unknown("start_speed_m_s", 0.0, FREE, 0.01),
        ];
        if !self.mass_is_known {
            all.push(unknown("mass_kg", 1.0, (1e-4, 1e5), 0.1));
        }
        all
    }

    fn causes(&self) -> &[Cause] {
        &self.causes
    }

    fn stronger(&self) -> String {
        let most = self
            .drives
            .iter()
            .flat_map(|drive| &drive.force)
            .fold(0.0_f64, |most, f| most.max(f.abs()));
        format!(
            "runs with a larger force, so that the mass moves more (the largest of these is \
             {most:.3} N)"
        )
    }

    /// The noise of the force, twice integrated.
    fn input_noise(&self, run: usize, normal: &mut dyn FnMut() -> f64) -> Option<Vec<f64>> {
        let drive = &self.drives[run];
        let mass = drive.mass?;
        let (mut x, mut v, mut row) = (0.0, 0.0, 0);
        let moved = |reading: &crate::kind::Reading| {
            while row + 1 < drive.time.len() && drive.time[row] < reading.time {
                let h = drive.time[row + 1] - drive.time[row];
                let kick = h * self.force_noise * normal() / mass;
                (x, v, row) = (x + h * (v + 0.5 * kick), v + kick, row + 1);
            }
            x
        };
        Some(self.logs[run].readings.iter().map(moved).collect())
    }

    fn predict(&self, run: usize, terms: &Terms, unknowns: &[f64]) -> Option<Vec<f64>> {
        let drive = &self.drives[run];
        let mass = match (drive.mass, unknowns.get(2)) {
            (_, Some(&mass)) => mass,
            // Where a run does not tell its mass, there is no such cause: the others' are believed.
            (Some(mass), None) => mass * self.term("mass", 0, terms).unwrap_or(1.0),
            _ => return None,
        };
        let dry = self.term("coulomb-friction", 0, terms)?;
        let viscous = self.term("viscous-friction", 0, terms)?;
        let drag = self.term("air-drag", 0, terms)?;
        let [stiffness, preload] = [
            self.term("return-spring", 0, terms)?,
            self.term("return-spring", 1, terms)?,
        ];
        let offset = self.term("sensor-offset", 0, terms)?;
        let of = |id: &str, column: &str, none: f64| {
            let is_it = |c: &&Cause| c.id == id && c.column.as_deref() == Some(column);
            self.causes
                .iter()
                .position(|c| is_it(&c))
                .map_or(none, |i| terms.get(i, 0))
        };
        let [(delay, scale), (force_delay, force_scale)] =
            ["position_m", "force_n"].map(|column| {
                (
                    of("sensor-delay", column, 0.0),
                    of("encoder-scale", column, 1.0),
                )
            });
        let (start, mut x, mut v) = (unknowns[0], unknowns[0], unknowns[1]);
        let mut now = *drive.time.first()?;
        let mut at = 0;
        let force = |at: usize, t: f64| force_scale * drive.between(at, t) + offset;
        // A stiff spring swings fast.
        let step = STEP.min(0.3 * (mass / stiffness).sqrt());
        let mut out = Vec::with_capacity(self.logs[run].readings.len());
        for reading in &self.logs[run].readings {
            let until = reading.time - delay;
            while now < until {
                let h = step.min(until - now);
                // A late sensor shows now what was before.
                let seen = now + 0.5 * h + force_delay;
                while at + 1 < drive.time.len() && drive.time[at + 1] <= seen {
                    at += 1;
                }
                // The middle of the step; dry friction takes what is left of the speed and no more.
                let middle = x + 0.5 * h * v;
                let push = force(at, seen) - stiffness * (middle - start) - preload;
                // What brakes in proportion to the speed does so without end, and never turns it
                // round.
                let brake = h * (viscous + drag * v.abs()) / mass;
                let left = (-brake).exp();
                let mean = if brake > 1e-6 {
                    (1.0 - left) / brake
                } else {
                    1.0
                };
                let free = left * v + mean * h * push / mass;
                let next = free.signum() * (free.abs() - h * dry / mass).max(0.0);
                x += 0.5 * h * (v + next);
                v = next;
                now += h;
            }
            out.push(scale * x);
        }
        out.iter().all(|x| x.is_finite()).then_some(out)
    }
}

/// The kind.
pub(super) const SPEC: Spec = Spec {
    sort: Sort::Slide,
    id: "slide",
    description: "A mass driven on a guide",
    // A weight on a string pulls always the same.
    channels: &[calm("force_n", FORCE), lively("position_m", POSITION)],
    settings: &[optional("mass_kg", LOAD)],
    model: |data, _| Ok(Box::new(Slides::new(data))),
    synthesis: Synthesis {
        instruments: &[noisy("force_n", 1e-3), noisy("position_m", 2e-4)],
        runs: 6,
        lay_out,
        source: Source::Model,
    },
    ..PART
};

/// Adds slides of one mass, driven by three sines that set in smoothly.
fn lay_out(layout: &mut Layout, runs: usize, draw: &mut Draw) {
    let mass = draw.stepped(0.5, 4.0, 1e-3);
    for _ in 0..runs {
        let sines = [(); 3].map(|()| {
            // Fast enough that a mass without friction stays on the guide.
            let rate = TAU * draw.between(1.0, 4.0);
            (
                mass * draw.between(1.0, 4.0) * rate / 10.0,
                rate,
                draw.between(0.0, TAU),
            )
        });
        let rows = count(draw.between(0.7, 1.2), 2e-3);
        layout.add(&[("mass_kg", mass)], rows, 2e-3, vec![0.0, 0.0]);
        let force = layout.column("force_n");
        let Some(run) = layout.experiment.runs.last_mut() else {
            return;
        };
        for (row, t) in run.time.iter().enumerate() {
            let window = (t / 0.2).clamp(0.0, 1.0).powi(2);
            run.values[force][row] = window
                * sines
                    .iter()
                    .map(|(a, w, p)| a * (w * t + p).sin())
                    .sum::<f64>();
        }
    }
}
