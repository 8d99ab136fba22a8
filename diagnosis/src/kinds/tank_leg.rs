//! A robot whose legs are driven by pneumatic muscles from a tank of its own: one valve and one tube
//! for each muscle.
//!
//! The machine is a chain of links in a plane, with a muscle at each joint; what the operator
//! believes of it is in `[rig]`.

mod causes;
mod flight;
mod rig;
mod synthesis;

use std::sync::Arc;

use saltus_numeric::statistics::quantile;
use saltus_robot::Robot;
use saltus_robot::gas::HEAT_RATIOS;
use saltus_robot::units::{NUMBER, Quantity, Unit};

use super::{Causes, unknown};
use crate::experiment::{Experiment, Sort};
use crate::kind::{Asked, Data, Kind, Log, Parameter, Reading};
use crate::plausible::{Check, LENGTHS, View};
use crate::recent::Recent;
use crate::spec::{
    Domain, GAUGE, LEAP, LINK, LOAD, OUTPUT, PART, Problem, SUPPLY, Setting, Spec, TEMPERATURE,
    TURN, VOLUME, asked, calm, length, list, listed, names, optional, posture, required, without,
};
use causes::Effect;
use flight::{Course, Told};
use rig::{Changed, Rig};

const fn plain(si: &'static str, units: &'static [(&'static str, Unit)]) -> Quantity {
    Quantity {
        si,
        dimension: [0, 0, 0],
        units,
    }
}

const ANY: Domain = Domain::FINITE;
const SHARE: Domain = Domain::POSITIVE.up_to(1e9);
const NOT_NEGATIVE: Domain = Domain::NON_NEGATIVE.up_to(1e9);

/// Of parts of a leg that a person can lift.
const PULLEY: (Quantity, Domain) = length(Domain::POSITIVE.up_to(0.5), "a radius");
const TANK: (Quantity, Domain) = (
    VOLUME.0,
    Domain::POSITIVE
        .up_to(0.5)
        .called("a volume")
        .not("l, cm3 or mm3"),
);

/// A height that the links reach, or how far they jump.
const fn within_reach(name: &'static str, sizes: fn(&View<'_>) -> Option<(f64, f64)>) -> Check {
    Check {
        name,
        sizes,
        what: "half the length of all links",
        allowed: (-10.0, 10.0),
        strict: false,
        units: LENGTHS,
    }
}

/// The size of the column, and half the length (m) of all links.
fn height(view: &View<'_>) -> Option<(f64, f64)> {
    Some((quantile(view.column(view.name)?, 0.95)?, half_length(view)))
}

fn half_length(view: &View<'_>) -> f64 {
    0.5 * listed(&view.run.settings, "link_length_m")
        .iter()
        .sum::<f64>()
}

/// What `[rig]` has.
const RIG: &[Setting] = &[
    required("tank_volume_m3", TANK),
    required("gas_temperature_k", TEMPERATURE),
    optional(
        "gas_constant_j_kg_k",
        (plain("J/(kg K)", &[("_j_kg_k", Unit::SI)]), SHARE),
    ),
    optional("heat_ratio", (NUMBER, HEAT_RATIOS)),
    required(
        "tube_length_m",
        length(Domain::POSITIVE.up_to(30.0), "a length"),
    ),
    required(
        "tube_diameter_m",
        length(Domain::POSITIVE.up_to(0.1), "a diameter"),
    ),
    required(
        "tube_roughness_m",
        length(Domain::NON_NEGATIVE.up_to(1e-3), "a roughness"),
    ),
    required("valve_time_constant_s", (saltus_robot::units::TIME, SHARE)),
    optional("valve_exhaust_s", (saltus_robot::units::TIME, ANY)),
    names("actuators"),
    names("link_names"),
    list("link_mass_kg", LOAD),
    list("link_length_m", LINK),
    required("link_radius_m", PULLEY),
    required("knee_pulley_radius_m", PULLEY),
    required("hip_pulley_radius_m", PULLEY),
    required(
        "tendon_stiffness_n_m",
        (plain("N/m", &[("_n_m", Unit::SI)]), SHARE),
    ),
    required(
        "knee_spring_nm_rad",
        (plain("N m/rad", &[("_nm_rad", Unit::SI)]), NOT_NEGATIVE),
    ),
    required(
        "hip_spring_nm_rad",
        (plain("N m/rad", &[("_nm_rad", Unit::SI)]), NOT_NEGATIVE),
    ),
    required("knee_spring_from_rad", TURN),
    required("hip_spring_from_rad", TURN),
    required(
        "joint_damping_nm_s_rad",
        (plain("N m s/rad", &[("_nm_s_rad", Unit::SI)]), NOT_NEGATIVE),
    ),
    list(
        "muscle_volume_coefficients",
        (plain("m3, contraction in cm", &[("", Unit::SI)]), ANY),
    ),
    required(
        "muscle_force_per_kpa_n",
        (plain("N/kPa", &[("_n", Unit::SI)]), SHARE),
    ),
    required(
        "muscle_slope_per_kpa_n_cm",
        (plain("N/(kPa cm)", &[("_n_cm", Unit::SI)]), NOT_NEGATIVE),
    ),
    list(
        "muscle_x0_coefficients_cm",
        (plain("cm, pressure in kPa", &[("_cm", Unit::SI)]), ANY),
    ),
];

/// The kind.
pub(super) const SPEC: Spec = Spec {
    sort: Sort::TankLeg,
    id: "tank-leg",
    description: "Legs driven by pneumatic muscles from a tank",
    channels: &[
        calm("tank_pressure_gauge_pa", GAUGE),
        without(calm("com_x_m", LEAP)),
        without(calm("com_y_m", LEAP)),
        posture("torso_y_m", LEAP),
        posture("torso_angle_rad", TURN),
        without(asked("valve_*", OUTPUT)),
        without(calm("*_pressure_gauge_pa", GAUGE)),
        posture("*_angle_rad", TURN),
        posture("foot_*_y_m", LEAP),
    ],
    any_of: true,
    settings: &[required("supply_pressure_gauge_pa", SUPPLY)],
    rig: RIG,
    checks: &[
        within_reach("torso_y_m", height),
        within_reach("foot_*_y_m", height),
        within_reach("com_y_m", height),
        within_reach("com_x_m", |view| {
            Some((view.span("com_x_m")?, half_length(view)))
        }),
    ],
    synthesis: synthesis::SYNTHESIS,
    model: |data, _: Option<&Robot>| Ok(Box::new(Flights::new(data)?)),
    ..PART
};

/// What a channel measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Gauge {
    Tank,
    /// Of the muscle with this number.
    Muscle(usize),
    /// The centre of mass: 0 along, 1 up.
    Center(usize),
}

/// Jumps of a robot with a tank.
#[derive(Clone, Debug)]
pub struct Flights {
    data: Data,
    gauges: Vec<Gauge>,
    told: Vec<Told>,
    rig: Rig,
    causes: Causes<Effect>,
    courses: Vec<Courses>,
}

/// By how much (Pa) a muscle's reading may be above the tank's and still be one.
const ABOVE_TANK: f64 = 5e3;
/// How far (Pa, m) the start may be from what the first rows say.
const START: f64 = 5e3;
const PLACE: f64 = 5e-3;

impl Flights {
    /// Which unknown of a run says by how much the track of the centre of mass is off along `k`.
    fn off(&self, k: usize) -> usize {
        let before = |gauge: &&Gauge| matches!(gauge, Gauge::Center(other) if *other < k);
        2 + self.gauges.iter().filter(before).count()
    }

    /// The jumps of an experiment.
    ///
    /// # Errors
    /// [`Problem::NoMachine`] where `[rig]` is no such robot, or its columns are missing.
    pub fn new(experiment: &Experiment) -> Result<Flights, Problem> {
        let first = experiment.runs.first();
        let settings = first.map(|run| run.settings.clone()).unwrap_or_default();
        let rig = Rig::of(&settings)?;
        let needed = |name: String| {
            experiment.column(&name).ok_or_else(|| Problem::NoMachine {
                what: format!("column {name} is missing: [rig] has an actuator of that name"),
            })
        };
        let (mut gauges, mut indices) = (Vec::new(), Vec::new());
        for (k, name) in rig.actuators.iter().enumerate() {
            indices.push(needed(format!("{name}_pressure_gauge_pa"))?);
            gauges.push(Gauge::Muscle(k));
            needed(format!("valve_{name}"))?;
            needed(format!("{name}_angle_rad"))?;
        }
        indices.push(needed("tank_pressure_gauge_pa".into())?);
        gauges.push(Gauge::Tank);
        for (k, name) in ["com_x_m", "com_y_m"].into_iter().enumerate() {
            // A column whose noise nobody states is for the posture, and is not predicted.
            if let Some(index) = experiment
                .column(name)
                .filter(|i| experiment.noise[*i].is_some())
            {
                indices.push(index);
                gauges.push(Gauge::Center(k));
            }
        }
        let told = experiment
            .runs
            .iter()
            .map(|run| Told::of(run, &rig, &experiment.columns))
            .collect::<Result<Vec<_>, _>>()?;
        let mut data = Data::of(experiment, &indices);
        for log in &mut data.logs {
            data.notes.extend(without_leaps(log, &gauges));
        }
        data.common = 1;
        let (named, terms) = causes::of(&rig, &data.channels, &gauges);
        Ok(Flights {
            causes: Causes::of(&mut data, named, terms),
            data,
            gauges,
            told,
            rig,
            courses: experiment.runs.iter().map(|_| Courses::default()).collect(),
        })
    }
}

/// Courses of a run that are kept: what a gauge makes of one takes no time beside it, and every
/// cause that is tried beside others begins at the same one, with the same derivatives.
const KEPT: usize = 400;

/// What a machine does in a run from a pressure (Pa) of its tank on.
type Courses = Recent<(f64, Changed), Option<Arc<Course>>>;

impl Flights {
    /// What run `run` does.
    fn course(&self, run: usize, changed: Changed, tank: f64, last: f64) -> Option<Arc<Course>> {
        let fly = |_: &(f64, Changed)| {
            flight::fly(&self.rig, &self.told[run], &changed, tank, last).map(Arc::new)
        };
        self.courses[run].ask((tank, changed), KEPT, fly)
    }
}

/// Leaves out readings of a muscle that are above the tank's: nothing fills it from there. A note
/// says how many.
fn without_leaps(all: &mut Log, gauges: &[Gauge]) -> Option<String> {
    let tank = gauges.iter().position(|g| *g == Gauge::Tank);
    let mut highest = f64::NAN;
    let before = all.readings.len();
    let readings = all.readings.iter();
    let of_tank: Vec<(f64, f64)> = readings
        .filter(|r| Some(r.channel) == tank)
        .map(|r| (r.time, r.value))
        .collect();
    let mut of_tank = of_tank.into_iter().peekable();
    all.readings.retain(|reading| {
        while let Some((_, value)) = of_tank.next_if(|(time, _)| *time <= reading.time) {
            highest = value;
        }
        let is_muscle = matches!(gauges[reading.channel], Gauge::Muscle(_));
        !(is_muscle && reading.value > highest + ABOVE_TANK)
    });
    let left_out = before - all.readings.len();
    (left_out > 0).then(|| {
        format!(
            "{}: {left_out} readings of muscles above the tank's pressure are left out",
            all.name
        )
    })
}

impl Kind for Flights {
    fn data(&self) -> &Data {
        &self.data
    }

    /// What the tank's gauge says at the start, what the muscles' gauges say without pressure, and
    /// by how much the track of the centre of mass is off.
    fn unknowns(&self, run: usize) -> Vec<Parameter> {
        let told = &self.told[run];
        let about = |x: f64, by: f64| (x - by, x + by);
        let mut all = vec![
            unknown("tank_start_pa", told.tank, about(told.tank, START), 100.0),
            unknown("gauge_zero_pa", told.zero, about(told.zero, START), 100.0),
        ];
        for gauge in &self.gauges {
            if let Gauge::Center(k) = gauge {
                let name = ["center_off_x_m", "center_off_y_m"][*k];
                all.push(unknown(
                    name,
                    told.off[*k],
                    about(told.off[*k], PLACE),
                    1e-4,
                ));
            }
        }
        all
    }

    fn truths(&self, asked: &Asked<'_>) -> Option<Vec<f64>> {
        let (run, terms, unknowns) = asked.parts();
        let log = &self.data.logs[run];
        let last = log.readings.last()?.time;
        // A gauge that is off is so at the start as well.
        let tank = self.gauges.iter().position(|gauge| *gauge == Gauge::Tank)?;
        let start = asked.sensors[tank].truth(unknowns[0]);
        let course = self.course(run, self.changed(terms), start, last)?;
        let truth = |(reading, time): (&Reading, &f64)| match self.gauges[reading.channel] {
            Gauge::Tank => course.tank(*time),
            Gauge::Muscle(k) => course.muscle(k, *time) + unknowns[1],
            Gauge::Center(k) => course.center(k, *time) + unknowns[self.off(k)],
        };
        Some(log.readings.iter().zip(&asked.times).map(truth).collect())
    }

    /// Of a machine with so many parts, a model misses several at once.
    fn most(&self) -> usize {
        6
    }

    fn stronger(&self) -> String {
        "jumps with shorter and longer openings, at several pressures of the tank".into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::Sort;
    use crate::kind::{Cause, Terms};
    use crate::layout::{Draw, Layout};
    use crate::sensor::Fault;

    /// A gauge of the tank that reads too much says so at the start as well: the same robot with as
    /// much less in its tank.
    #[test]
    fn a_gauge_that_is_off_is_so_at_the_start() {
        const OFF: f64 = 2e4;
        let layout = Layout::new(Sort::TankLeg, false, Some(1), &mut Draw::new(5));
        let kind = Flights::new(&layout.experiment).expect("a robot");
        let own: Vec<f64> = kind.unknowns(0).iter().map(|p| p.neutral).collect();
        let is_off = |cause: &Cause| {
            cause.fault == Some(Fault::Offset)
                && cause.column.as_deref() == Some("tank_pressure_gauge_pa")
        };
        let off = kind.causes().iter().position(is_off).expect("a cause");
        let mut terms = Terms::off(kind.causes());
        let right = kind.predict(0, &terms, &own).expect("a jump");
        terms.set(off, 0, OFF);
        let more = [&[own[0] + OFF], &own[1..]].concat();
        let found = kind.predict(0, &terms, &more).expect("a jump");
        for (reading, (found, right)) in kind.data.logs[0]
            .readings
            .iter()
            .zip(found.iter().zip(right))
        {
            let is_tank = kind.gauges[reading.channel] == Gauge::Tank;
            let expected = right + if is_tank { OFF } else { 0.0 };
            assert!((found - expected).abs() < 1e-9 * (1.0 + expected.abs()));
        }
    }
}
