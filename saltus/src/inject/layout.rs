//! What the operator would do: runs with their settings, times and instruments, by kind.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use rand_distr::{Distribution, StandardNormal, Uniform};
use rand_pcg::Pcg64;
use saltus_diagnosis::{Experiment, Run, Sort};
use saltus_sim_check::TICK;

/// A pound per square inch (Pa).
const PSI: f64 = 6_894.757_293_168_361;
/// Step (rad) of the encoder on the wheel, and of those on the boom.
const WHEEL_COUNT: f64 = 7.854e-3;
const BOOM_COUNT: f64 = 3.927e-3;

/// Numbers by chance.
#[derive(Debug)]
pub(super) struct Draw(Pcg64);

impl Draw {
    pub(super) fn new(seed: u64) -> Draw {
        Draw(Pcg64::new(u128::from(seed), 23))
    }

    /// Anything from `low` to `high`, which is above it.
    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        Uniform::new(low, high).map_or(low, |uniform| uniform.sample(&mut self.0))
    }

    /// The same, rounded to steps.
    pub(super) fn stepped(&mut self, low: f64, high: f64, step: f64) -> f64 {
        (self.between(low, high) / step).round() * step
    }

    fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }
}

/// An experiment before it is measured.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    /// Settings, times and driven columns as they are; measured columns without values yet.
    pub experiment: Experiment,
    /// What is not known of each run, in the order of its kind.
    pub unknowns: Vec<Vec<f64>>,
}

/// A column: its name, noise (0: none that is known) and step (0: none).
type Instrument = (&'static str, f64, f64);

impl Layout {
    /// So many runs of a kind, or as many as is usual; flights at the end of a boom where
    /// `on_boom`.
    pub(super) fn new(kind: Sort, on_boom: bool, runs: Option<usize>, draw: &mut Draw) -> Layout {
        let (instruments, usual): (&[Instrument], usize) = match kind {
            Sort::Bench => (&[("position_m", 1e-4, 0.0), ("pressure_pa", 2e3, 0.0)], 12),
            Sort::Hop => (&[("pivot_angle_rad", 0.0, BOOM_COUNT)], 12),
            Sort::Jump => (
                &[
                    ("wheel_angle_rad", 0.0, WHEEL_COUNT),
                    ("pivot_angle_rad", 0.0, BOOM_COUNT),
                    ("radius_angle_rad", 0.0, BOOM_COUNT),
                    ("wheel_rate_rad_s", 0.03, 0.0),
                ],
                12,
            ),
            Sort::Outcomes => (
                &[
                    ("omega_rad_s", 0.0, 0.0),
                    ("alpha_f_rad", 0.0, 0.0),
                    ("valve_open_s", 0.0, 0.0),
                    ("distance_m", 3e-3, 0.0),
                    ("apex_m", 2e-3, 0.0),
                ],
                50,
            ),
            Sort::Flight => (&[("x_m", 5e-3, 0.0), ("y_m", 5e-3, 0.0)], 6),
            Sort::Stroke => (
                &[
                    ("position_m", 1e-5, 0.0),
                    ("pressure_gauge_pa", 50.0, 0.0),
                    ("force_n", 0.06, 0.0),
                ],
                5,
            ),
            Sort::Slide => (&[("force_n", 1e-3, 0.0), ("position_m", 2e-4, 0.0)], 6),
            Sort::Vessel => (&[("pressure_pa", 3e3, 0.0), ("temperature_k", 1.0, 0.0)], 5),
        };
        let known = |size: f64| (size > 0.0).then_some(size);
        let experiment = Experiment {
            kind,
            columns: instruments.iter().map(|i| i.0.to_owned()).collect(),
            noise: instruments.iter().map(|i| known(i.1)).collect(),
            resolution: instruments.iter().map(|i| known(i.2)).collect(),
            runs: Vec::new(),
        };
        let mut layout = Layout {
            experiment,
            unknowns: Vec::new(),
        };
        let count = runs.unwrap_or(usual).max(1);
        match kind {
            Sort::Bench => (0..count).for_each(|_| layout.firing(draw)),
            // The simulation says how long they are.
            Sort::Hop | Sort::Jump => (0..count).for_each(|_| layout.add(&[], 3, TICK, Vec::new())),
            // One run, and so many rows of it.
            Sort::Outcomes => layout.add(&[], count, 1.0, Vec::new()),
            Sort::Flight => (0..count).for_each(|_| layout.throw(on_boom, draw)),
            Sort::Stroke => layout.strokes(count, draw),
            Sort::Slide => layout.slides(count, draw),
            Sort::Vessel => layout.vessels(count, draw),
        }
        layout
    }

    /// Index of the column `name`, which is there.
    pub(super) fn column(&self, name: &str) -> usize {
        self.experiment
            .columns
            .iter()
            .position(|column| column == name)
            .unwrap_or_default()
    }

    /// Adds a run with rows `step` apart, of which nothing is measured yet.
    fn add(&mut self, settings: &[(&str, f64)], rows: usize, step: f64, unknowns: Vec<f64>) {
        let number = self.experiment.runs.len() + 1;
        self.experiment.runs.push(Run {
            name: format!("run-{number:02}.csv"),
            settings: settings
                .iter()
                .map(|(key, value)| ((*key).to_owned(), *value))
                .collect::<BTreeMap<_, _>>(),
            valve: None,
            time: (0..rows).map(|row| round(row as f64 * step)).collect(),
            values: vec![vec![0.0; rows]; self.experiment.columns.len()],
        });
        self.unknowns.push(unknowns);
    }

    /// Adds a firing on the bench.
    fn firing(&mut self, draw: &mut Draw) {
        let load = draw.stepped(1.2, 4.0, 1e-3);
        let supply = round(draw.stepped(60.0, 120.0, 10.0) * PSI);
        self.add(
            &[("load_mass_kg", load), ("supply_pressure_gauge_pa", supply)],
            151,
            TICK,
            Vec::new(),
        );
        if let Some(run) = self.experiment.runs.last_mut() {
            run.valve = Some((0.01, None));
        }
    }

    /// Adds a throw.
    fn throw(&mut self, on_boom: bool, draw: &mut Draw) {
        let (height, forward, up) = if on_boom {
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
        let boom: &[(&str, f64)] = if on_boom {
            &[("boom_radius_m", 2.12)]
        } else {
            &[]
        };
        self.add(
            boom,
            count(0.22 * up, 0.01),
            0.01,
            vec![0.0, forward, height, up],
        );
    }

    /// Adds slow strokes at several pressures, each twice back and forth with round turns.
    fn strokes(&mut self, runs: usize, draw: &mut Draw) {
        let (seal, way) = (draw.between(-1.0, 1.0), draw.between(5e-5, 3e-4));
        for k in 0..runs {
            let set = 1e5 + 6e5 * k as f64 / (runs - 1).max(1) as f64;
            let (middle, half) = (draw.between(0.03, 0.05), draw.between(0.02, 0.025));
            let period = draw.between(8.0, 20.0);
            let rate = 0.02;
            self.add(
                &[("bore_m", 0.01905)],
                count(2.0 * period, rate),
                rate,
                vec![seal, way],
            );
            let (position, pressure) =
                (self.column("position_m"), self.column("pressure_gauge_pa"));
            let Some(run) = self.experiment.runs.last_mut() else {
                return;
            };
            for (row, t) in run.time.iter().enumerate() {
                // Nearly a triangle: an arcsine of a sine that stays short of 1.
                let phase = TAU * t / period;
                run.values[position][row] =
                    middle - half * (0.99 * phase.cos()).asin() / (PI / 2.0);
                run.values[pressure][row] =
                    set + 1500.0 * (0.7 * phase.sin() + 0.3 * (TAU * t / 7.0).sin());
            }
        }
    }

    /// Adds slides of one mass, driven by three sines that set in smoothly.
    fn slides(&mut self, runs: usize, draw: &mut Draw) {
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
            self.add(&[("mass_kg", mass)], rows, 2e-3, vec![0.0, 0.0]);
            let force = self.column("force_n");
            let Some(run) = self.experiment.runs.last_mut() else {
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

    /// Adds discharges of one vessel, every third a filling.
    fn vessels(&mut self, runs: usize, draw: &mut Draw) {
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
            self.add(&settings, 101, step, vec![discharge, 0.0]);
        }
    }

    /// Puts a motion of the robot in the place of run `run`: its settings, when the valve was open,
    /// and measured columns.
    pub(super) fn put(
        &mut self,
        run: usize,
        supply: f64,
        valve: (f64, f64),
        values: Vec<Vec<f64>>,
    ) {
        let place = &mut self.experiment.runs[run];
        place.settings = [("supply_pressure_gauge_pa".to_owned(), supply)].into();
        place.valve = Some((valve.0, Some(valve.1)));
        place.time = (0..values.first().map_or(0, Vec::len))
            .map(|row| round(row as f64 * TICK))
            .collect();
        place.values = values;
    }

    /// Reads every column as its instrument does: with noise, then rounded to its steps.
    pub(super) fn read(&mut self, draw: &mut Draw) {
        let Experiment {
            runs,
            noise,
            resolution,
            ..
        } = &mut self.experiment;
        for run in runs {
            for ((column, noise), step) in run.values.iter_mut().zip(&*noise).zip(&*resolution) {
                for value in column {
                    *value += noise.map_or(0.0, |size| size * draw.normal());
                    *value = step.map_or(*value, |step| round((*value / step).round() * step));
                }
            }
        }
    }
}

/// A supply (Pa) from `low` to `high` (psi) in tens, as it stands in a file.
pub(super) fn supply(low: f64, high: f64, draw: &mut Draw) -> f64 {
    round(draw.stepped(low, high, 10.0) * PSI)
}

/// Rows `step` apart in `length`, one at each end.
fn count(length: f64, step: f64) -> usize {
    // Lengths are seconds.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let rows = (length / step) as usize + 1;
    rows
}

/// A number of a file, without the digits that arithmetic leaves behind.
pub(super) fn round(x: f64) -> f64 {
    (x * 1e9).round() / 1e9
}
