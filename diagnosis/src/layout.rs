//! Synthetic data before they are measured: runs with their settings, times and instruments.

use std::collections::BTreeMap;

use rand_distr::{Distribution, StandardNormal, Uniform};
use rand_pcg::Pcg64;

use saltus_robot::Robot;

use crate::experiment::{Experiment, Run, Sort};

/// A pound per square inch (Pa).
pub(crate) const PSI: f64 = 6_894.757_293_168_361;
/// Supply (Pa) and bore (m) of the thesis' robot, whose leg is that of a robot without gas.
pub const SUPPLY: f64 = 120.0 * PSI;
const BORE: f64 = 0.019_05;
/// Time (s) between rows of a firing.
pub const TICK: f64 = 1e-3;

/// Numbers by chance.
#[derive(Debug)]
pub struct Draw(Pcg64);

impl Draw {
    /// Those of a seed.
    pub fn new(seed: u64) -> Draw {
        Draw(Pcg64::new(u128::from(seed), 23))
    }

    /// Anything from `low` to `high`, which is above it.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        Uniform::new(low, high).map_or(low, |uniform| uniform.sample(&mut self.0))
    }

    /// The same, rounded to steps.
    pub fn stepped(&mut self, low: f64, high: f64, step: f64) -> f64 {
        (self.between(low, high) / step).round() * step
    }

    /// A number with mean 0 and standard deviation 1.
    pub(crate) fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }
}

/// An experiment before it is measured.
#[derive(Clone, Debug)]
pub struct Layout {
    /// Settings, times and driven columns as they are; measured columns without values yet.
    pub experiment: Experiment,
    /// What is not known of each run, in the order of its kind.
    pub unknowns: Vec<Vec<f64>>,
    /// Whether a flight is at the end of a boom.
    pub(crate) on_boom: bool,
    /// Gauge pressure (Pa) of the robot's supply.
    pub(crate) supply: f64,
    /// Greatest force of its leg, in terms of that of the leg for which loads are laid out.
    pub(crate) strength: f64,
}

impl Layout {
    /// So many runs of a kind, or as many as is usual; flights at the end of a boom where
    /// `on_boom`.
    pub fn new(kind: Sort, on_boom: bool, runs: Option<usize>, draw: &mut Draw) -> Layout {
        Layout::of((kind, None), on_boom, runs, draw)
    }

    /// The same with a robot, where the kind is of one: with instruments that it can carry, at
    /// pressures up to that of its supply.
    pub fn of(
        (kind, robot): (Sort, Option<&Robot>),
        on_boom: bool,
        runs: Option<usize>,
        draw: &mut Draw,
    ) -> Layout {
        let synthesis = &kind.spec().synthesis;
        let is_free = robot.is_some_and(|robot| robot.boom.is_none());
        let instruments = match synthesis.without_boom {
            Some(own) if is_free => own,
            _ => synthesis.instruments,
        };
        let cylinder = robot.and_then(|robot| robot.leg.cylinder());
        let supply = cylinder.map_or(SUPPLY, |own| own.supply.0);
        // Loads are laid out for cylinders; a muscle has no bore, and lifts them too.
        let of_cylinder = cylinder.filter(|own| own.muscle.is_none());
        let strength = of_cylinder.map_or(1.0, |own| supply / SUPPLY * (own.bore / BORE).powi(2));
        let known = |size: f64| (size > 0.0).then_some(size);
        let mut layout = Layout {
            experiment: Experiment {
                kind,
                mechanism: None,
                columns: instruments.iter().map(|i| i.column.to_owned()).collect(),
                noise: instruments.iter().map(|i| known(i.noise)).collect(),
                resolution: instruments.iter().map(|i| known(i.step)).collect(),
                runs: Vec::new(),
            },
            unknowns: Vec::new(),
            on_boom,
            supply,
            strength: round(strength),
        };
        let count = runs.unwrap_or(synthesis.runs).max(1);
        (synthesis.lay_out)(&mut layout, count, draw);
        layout
    }

    /// Index of the column `name`, which is there.
    pub fn column(&self, name: &str) -> usize {
        self.experiment.column(name).unwrap_or_default()
    }

    /// Adds a run with rows `step` apart, of which nothing is measured yet.
    pub(crate) fn add(
        &mut self,
        settings: &[(&str, f64)],
        rows: usize,
        step: f64,
        unknowns: Vec<f64>,
    ) {
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

    /// Puts a motion of the robot in the place of run `run`: its settings, when the valve was open,
    /// and measured columns.
    pub fn put(&mut self, run: usize, supply: f64, valve: (f64, f64), values: Vec<Vec<f64>>) {
        let place = &mut self.experiment.runs[run];
        place.settings = [("supply_pressure_gauge_pa".to_owned(), supply)].into();
        place.valve = Some((valve.0, Some(valve.1)));
        place.time = (0..values.first().map_or(0, Vec::len))
            .map(|row| round(row as f64 * TICK))
            .collect();
        place.values = values;
    }

    /// Reads every column as its instrument does: with noise, then rounded to its steps.
    pub fn read(&mut self, draw: &mut Draw) {
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

/// A pressure (Pa) from `low` to `high` twelfths of a robot's supply (Pa), as it stands in a file.
pub fn supply(supply: f64, low: f64, high: f64, draw: &mut Draw) -> f64 {
    let twelfth = (supply / (12.0 * PSI) * 1e6).round() / 1e6;
    round(draw.stepped(low, high, 1.0) * twelfth * PSI)
}

/// Rows `step` apart in `length`, one at each end.
pub(crate) fn count(length: f64, step: f64) -> usize {
    // Lengths are seconds.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let rows = (length / step) as usize + 1;
    rows
}

/// A number of a file, without the digits that arithmetic leaves behind.
pub fn round(x: f64) -> f64 {
    (x * 1e9).round() / 1e9
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::Source;

    #[test]
    fn a_seed_gives_the_same_runs() {
        let laid_out = |sort: &Sort| matches!(sort.spec().synthesis.source, Source::Model);
        for sort in Sort::ALL.into_iter().filter(laid_out) {
            let make = |seed| {
                let mut draw = Draw::new(seed);
                let mut layout = Layout::new(sort, false, Some(3), &mut draw);
                layout.read(&mut draw);
                // As text: readings that are missing are no numbers, and equal none.
                format!("{:?}", layout.experiment)
            };
            let [a, b, c] = [make(7), make(7), make(8)];
            assert!(a == b && a != c, "{sort:?}");
        }
    }

    #[test]
    fn an_instrument_adds_noise_and_counts() {
        let mut draw = Draw::new(3);
        let mut layout = Layout::new(Sort::Stroke, false, Some(1), &mut draw);
        let column = layout.column("force_n");
        let experiment = &mut layout.experiment;
        (experiment.noise[column], experiment.resolution[column]) = (Some(0.5), Some(0.25));
        experiment.runs[0].values[column].fill(10.0);
        layout.read(&mut draw);
        let values = &layout.experiment.runs[0].values[column];
        assert!(values.iter().all(|x| (x * 4.0).fract() == 0.0));
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n;
        // The noise, and a count's own.
        let closed = 0.25 + 0.25_f64.powi(2) / 12.0;
        assert!((mean - 10.0).abs() < 5.0 * (closed / n).sqrt(), "{mean}");
        assert!(
            (variance / closed - 1.0).abs() < 5.0 * (2.0 / n).sqrt(),
            "{variance} {closed}"
        );
    }

    #[test]
    fn rows_are_in_step() {
        assert_eq!(count(1.0, 0.25), 5);
        assert_eq!(round(0.1 + 0.2), 0.3);
        let mut draw = Draw::new(1);
        for _ in 0..1000 {
            let x = draw.between(-1.0, 2.0);
            assert!((-1.0..2.0).contains(&x));
            let y = draw.stepped(1.0, 2.0, 0.25);
            assert_eq!((4.0 * y).fract(), 0.0);
        }
        assert_eq!(draw.between(1.0, 1.0), 1.0);
    }
}
