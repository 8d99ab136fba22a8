//! Parameters of a leg from benchtop firings, as the thesis' 4.3.3 identifies them.
//!
//! All that is chosen is fitted at once, so that what the data do not tell apart shows: the
//! discharge coefficient and the radius of the orifice, of which only C_f r² is ever seen.
//!
//! Source: thesis §4.3.3, table 4.2.

use saltus_diagnosis::kinds::{Firings, Problem};
use saltus_diagnosis::{Cause, Data, Estimate, Experiment, Kind, Parameter, Sort, Terms, estimate};
use saltus_robot::{Drive, Robot};

/// What table 4.2 of the thesis lists and the data can tell.
pub const USUAL: [&str; 5] = [
    "leg.discharge_coefficient",
    "leg.dead_volume_m3",
    "leg.viscous_friction_n_s_per_m",
    "leg.coulomb_friction_n",
    "leg.valve_delay_s",
];

const ORIFICE: &str = "leg.orifice_radius_m";

/// A leg with its parameters fitted.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// Values, errors, and what is left.
    pub estimate: Estimate,
    /// The robot with the fitted leg.
    pub robot: Robot,
}

/// Why there is no fit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Data of another kind.
    #[error("data of kind {}: must be of kind bench", found.spec().id)]
    Kind {
        /// The kind.
        found: Sort,
    },
    /// A name that is no parameter.
    #[error("{name}: must be one of {}", known.join(", "))]
    Parameter {
        /// The name.
        name: String,
        /// Every parameter.
        known: Vec<String>,
    },
    /// One parameter twice, or none.
    #[error("{name:?}: each parameter once, and at least one")]
    Twice {
        /// The name.
        name: String,
    },
    /// The model has no such motion.
    #[error("the model of the leg has no such motion: is it the leg that was measured?")]
    NoMotion,
    /// Data and robot do not go together.
    #[error(transparent)]
    Robot(#[from] Problem),
}

/// Fits the parameters of these names (keys of a robot file) to firings of what is believed to be
/// the leg of `robot`.
///
/// # Errors
/// [`Error`] for data of another kind, for a name that is no parameter of a leg, or where the model
/// has no such motion.
pub fn fit(experiment: &Experiment, robot: &Robot, names: &[String]) -> Result<Fitted, Error> {
    if experiment.kind != Sort::Bench {
        return Err(Error::Kind {
            found: experiment.kind,
        });
    }
    let bench = Bench::new(experiment, robot, names)?;
    let all: Vec<usize> = (0..bench.data.causes.len()).collect();
    let estimate = estimate(&bench, &all).ok_or(Error::NoMotion)?;
    let robot = bench.robot(&estimate.after.terms).ok_or(Error::NoMotion)?;
    Ok(Fitted { estimate, robot })
}

/// Where a parameter stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    /// A cause of the firings, and which of its parameters.
    Cause(usize, usize),
    /// The radius of the orifice, which is no cause of its own.
    Orifice,
}

/// Firings in which the chosen parameters are the only causes.
struct Bench {
    firings: Firings,
    /// Each run alone, its noise as in all of them.
    singles: Vec<Experiment>,
    believed: Robot,
    /// That of the firings, with these causes alone.
    data: Data,
    places: Vec<Place>,
}

impl Bench {
    fn new(experiment: &Experiment, robot: &Robot, names: &[String]) -> Result<Bench, Error> {
        let firings = Firings::new(experiment, robot)?;
        let known = parameters(&firings, robot);
        let (mut causes, mut places) = (Vec::new(), Vec::new());
        for name in names {
            let found = known.iter().find(|(_, p, _)| p.name == *name);
            let (id, parameter, place) = found.ok_or_else(|| Error::Parameter {
                name: name.clone(),
                known: known.iter().map(|(_, p, _)| p.name.clone()).collect(),
            })?;
            if places.contains(place) {
                return Err(Error::Twice { name: name.clone() });
            }
            causes.push(Cause::one(id, parameter.clone()));
            places.push(*place);
        }
        if causes.is_empty() {
            return Err(Error::Twice {
                name: String::new(),
            });
        }
        let noise: Vec<Option<f64>> = experiment
            .columns
            .iter()
            .map(|column| noise(&firings, column))
            .collect();
        let single = |run: &saltus_diagnosis::Run| Experiment {
            noise: noise.clone(),
            runs: vec![run.clone()],
            ..Experiment {
                runs: Vec::new(),
                ..experiment.clone()
            }
        };
        let singles = experiment.runs.iter().map(single).collect();
        let data = Data {
            listed: causes.len(),
            causes,
            ..firings.data().clone()
        };
        Ok(Bench {
            firings,
            singles,
            believed: robot.clone(),
            data,
            places,
        })
    }

    /// The terms of the firings, and the robot with its orifice where that is not what is believed.
    fn terms(&self, terms: &Terms) -> (Terms, Option<Robot>) {
        let mut own = Terms::off(self.firings.causes());
        let mut changed = None;
        for (k, place) in self.places.iter().enumerate() {
            let value = terms.get(k, 0);
            match place {
                Place::Cause(cause, parameter) => own.set(*cause, *parameter, value),
                Place::Orifice if value != self.data.causes[k].parameters[0].neutral => {
                    let mut robot = self.believed.clone();
                    if let Drive::Pneumatic(cylinder) = &mut robot.leg.drive {
                        cylinder.orifice_radius = value;
                    }
                    changed = Some(robot);
                }
                Place::Orifice => {}
            }
        }
        (own, changed)
    }
}

/// What is given, as quantisation is counted on top of it.
fn noise(firings: &Firings, column: &str) -> Option<f64> {
    let channel = firings
        .channels()
        .iter()
        .find(|channel| channel.name == *column)?;
    let quantised = channel.step * channel.step / 12.0;
    Some(
        (channel.noise * channel.noise - quantised)
            .max(1e-6 * channel.noise * channel.noise)
            .sqrt(),
    )
}

/// Every parameter of the leg, with the cause that it is of.
fn parameters(firings: &Firings, robot: &Robot) -> Vec<(&'static str, Parameter, Place)> {
    let mut all: Vec<(&'static str, Parameter, Place)> = Vec::new();
    for (c, cause) in firings.causes().iter().enumerate() {
        for (p, parameter) in cause.parameters.iter().enumerate() {
            if ["leg.", "tank."]
                .iter()
                .any(|part| parameter.name.starts_with(part))
            {
                all.push((cause.id, parameter.clone(), Place::Cause(c, p)));
            }
        }
    }
    if let Drive::Pneumatic(cylinder) = &robot.leg.drive {
        let radius = cylinder.orifice_radius;
        let parameter = Parameter {
            name: ORIFICE.into(),
            neutral: radius,
            bounds: (0.05 * radius, 20.0 * radius),
            scale: 5e-3 * radius,
            starts: vec![0.85 * radius, 1.15 * radius],
        };
        all.push(("valve-discharge", parameter, Place::Orifice));
    }
    all
}

impl Kind for Bench {
    fn data(&self) -> &Data {
        &self.data
    }

    fn unknowns(&self, run: usize) -> Vec<Parameter> {
        self.firings.unknowns(run)
    }

    fn predict(&self, run: usize, terms: &Terms, unknowns: &[f64]) -> Option<Vec<f64>> {
        let (terms, changed) = self.terms(terms);
        match changed {
            None => self.firings.predict(run, &terms, unknowns),
            Some(robot) => Firings::new(&self.singles[run], &robot)
                .ok()?
                .predict(0, &terms, unknowns),
        }
    }

    fn robot(&self, terms: &Terms) -> Option<Robot> {
        let (terms, changed) = self.terms(terms);
        let believed = changed.as_ref().unwrap_or(&self.believed);
        Firings::new(&self.singles[0], believed).ok()?.robot(&terms)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::inject::{Effect, Request, make};

    fn data(effects: &[&str], seed: u64) -> Experiment {
        let effects: Vec<Effect> = effects.iter().map(|text| text.parse().unwrap()).collect();
        let robot = Robot::rats_planar();
        let request = Request {
            kind: Sort::Bench,
            robot: Some(&robot),
            effects: &effects,
            seed,
            runs: Some(8),
            asked: &[],
        };
        make(&request).unwrap().experiment
    }

    fn names(list: &[&str]) -> Vec<String> {
        list.iter().map(|name| (*name).to_owned()).collect()
    }

    #[test]
    fn the_parameters_of_the_thesis_come_back() {
        let truth = [0.45, 7e-6, 9.0, 16.0, 0.013];
        let effects = [
            "valve-discharge=0.45",
            "dead-volume=0.000007",
            "viscous-friction=9",
            "coulomb-friction=16",
            "valve-delay=0.013",
        ];
        let found = fit(&data(&effects, 5), &Robot::rats_planar(), &names(&USUAL)).unwrap();
        assert!(
            found.estimate.undetermined.is_empty(),
            "{:?}",
            found.estimate.undetermined
        );
        for (p, truth) in found.estimate.parameters.iter().zip(truth) {
            let error = p.error.unwrap();
            // Five errors beyond 3 standard deviations: once in 70 seeds; and no error is large.
            assert!(
                (p.value - truth).abs() < 3.0 * error && error < 0.1 * truth,
                "{p:?}"
            );
        }
        for r in &found.estimate.residuals {
            assert!(
                (r.after / r.noise - 1.0).abs() < 0.1 && r.before > 1.5 * r.noise,
                "{r:?}"
            );
        }
        assert_eq!(found.robot.leg.delay, found.estimate.parameters[4].value);
    }

    #[test]
    fn coefficient_and_radius_are_told_as_a_product_alone() {
        let both = names(&[
            "leg.discharge_coefficient",
            "leg.coulomb_friction_n",
            ORIFICE,
        ]);
        let found = fit(
            &data(&["valve-discharge=0.45"], 2),
            &Robot::rats_planar(),
            &both,
        )
        .unwrap();
        let estimate = &found.estimate;
        assert_eq!(
            (estimate.parameters[0].error, estimate.parameters[2].error),
            (None, None)
        );
        assert!(estimate.parameters[1].error.is_some());
        assert_eq!(estimate.undetermined.len(), 1);
        let known = estimate.undetermined[0].known.as_ref().unwrap();
        assert_eq!(known.exponents, [(0, 1.0), (2, 2.0)]);
        let truth = 0.45 * 1.0215e-3 * 1.0215e-3;
        assert!(
            (known.value - truth).abs() < 3.0 * known.error && known.error < 0.02 * truth,
            "{known:?}"
        );
    }

    #[test]
    fn wrong_names_are_told_the_right_ones() {
        let experiment = data(&[], 1);
        let error = |list: &[&str]| {
            fit(&experiment, &Robot::rats_planar(), &names(list))
                .unwrap_err()
                .to_string()
        };
        assert!(error(&["leg.bore_m"]).contains(ORIFICE));
        assert!(error(&[]).contains("at least one"));
        assert!(error(&[ORIFICE, ORIFICE]).contains("once"));
    }
}
