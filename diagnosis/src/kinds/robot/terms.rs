//! The effects that a robot can show: those of its table of terms, and those that are more than one
//! number of its file.

use saltus_pneumatics::Leg;
use saltus_robot::terms::Form as TermForm;
use saltus_robot::{Cylinder, Gas, GaugePressure, Robot, Term};

use super::Column;
use crate::experiment::Sort;
use crate::kind::{Cause, Channel, Data, Form};
use crate::kinds::{delay, gain, offset, simple, unknown};
use crate::rig::Extra;
use crate::sensor::Fault;

/// What a cause does to the model.
#[derive(Clone, Debug)]
pub(super) enum Effect {
    /// It sets terms of the robot, or their inverses.
    Terms(Vec<(Term, TermForm)>),
    /// It changes the robot otherwise.
    Robot(Switch),
    /// It multiplies the load on the bench.
    LoadFactor,
    /// It adds to the load on the bench.
    LoadAdded,
    /// It is a term that no listed cause has.
    Extra(fn(&mut Extra, f64)),
    /// It is a fault of a sensor, of which the model knows nothing.
    None,
}

/// Switches a term on in a robot.
pub(super) type Switch = fn(&mut Robot, &[f64]);

/// Collects causes with what they do.
#[derive(Default)]
struct List {
    causes: Vec<Cause>,
    effects: Vec<Effect>,
}

impl List {
    fn add(&mut self, cause: Cause, effect: Effect) {
        self.causes.push(cause);
        self.effects.push(effect);
    }
}

/// Terms whose effect shows in data of a kind.
fn shows(term: Term, sort: Sort) -> bool {
    let section = term.spec().section();
    match sort {
        Sort::Bench => section.starts_with("leg") || section == "tank" || term == Term::Gravity,
        // A hop does not know how the ground lies about its foot.
        Sort::Hop => !matches!(term, Term::Slope | Term::Tilt),
        _ => true,
    }
}

/// Puts the causes that could show in data of a kind into `data`; their effects.
pub(super) fn causes(
    data: &mut Data,
    sort: Sort,
    robot: &Robot,
    columns: &[Column],
) -> Vec<Effect> {
    let mut list = List::default();
    of_terms(&mut list, sort, robot);
    if let Some(cylinder) = robot.leg.cylinder() {
        gas(&mut list, cylinder);
    }
    if sort == Sort::Bench {
        load(&mut list);
    } else {
        contact(&mut list, robot);
    }
    sensing(&mut list, sort, columns, &data.channels);
    data.listed = list.causes.len();
    unlisted(&mut list, sort, robot);
    data.causes = list.causes;
    list.effects
}

/// The causes in the table of terms; terms of one id are one cause, unless each has a sentence.
fn of_terms(list: &mut List, sort: Sort, robot: &Robot) {
    for &term in Term::ALL {
        let (Some(cause), Some(fit)) = (term.spec().cause, term.fit(robot)) else {
            continue;
        };
        if !term.applies(robot) || !shows(term, sort) || !(cause.seen_in)(robot) {
            continue;
        }
        // A swinging boom shows little in where a jump ends: a few starts will do.
        let every = match sort {
            Sort::Outcomes if matches!(term, Term::BoomFlex | Term::BoomFlexTime) => 7,
            _ => 1,
        };
        let starts: Vec<f64> = fit.starts.into_iter().step_by(every).collect();
        let key = term.key(robot);
        let (name, form) = match fit.form {
            TermForm::Direct => (key, Form::Direct),
            TermForm::Inverse(name) => (name.into(), Form::Inverse(key)),
        };
        let parameter = unknown(&name, fit.neutral, fit.bounds, fit.scale).starting(&starts);
        match (list.causes.last_mut(), list.effects.last_mut()) {
            (Some(last), Some(Effect::Terms(terms)))
                if last.id == cause.id && cause.sentence.is_empty() =>
            {
                last.parameters.push(parameter);
                terms.push((term, fit.form));
            }
            _ => list.add(
                Cause {
                    form,
                    ..Cause::one(cause.id, parameter)
                },
                Effect::Terms(vec![(term, fit.form)]),
            ),
        }
    }
}

/// Sets `terms` of a robot to what a cause's parameters say.
pub(super) fn set(robot: &mut Robot, terms: &[(Term, TermForm)], values: &[f64]) {
    for ((term, form), value) in terms.iter().zip(values) {
        match form {
            TermForm::Direct => term.set(robot, *value),
            TermForm::Inverse(_) => term.set(robot, 1.0 / value),
        }
    }
}

fn cylinder(robot: &mut Robot, change: impl FnOnce(&mut Cylinder)) {
    if let Some(cylinder) = robot.leg.cylinder_mut() {
        change(cylinder);
    }
}

/// The supply, and another gas.
fn gas(list: &mut List, c: &Cylinder) {
    let (name, starts) = ("supply_pressure_offset_pa", [-8e4, 8e4]);
    list.add(
        simple("supply-pressure", name, 0.0, (-2e6, 2e6), 5e3, &starts),
        Effect::Robot(|r, v| {
            cylinder(r, |c| {
                c.supply = GaugePressure((c.supply.0 + v[0]).max(1e3));
            });
        }),
    );
    let (name, starts) = ("supply_pressure_factor", [0.9, 1.1]);
    list.add(
        simple("supply-pressure", name, 1.0, (0.2, 3.0), 5e-3, &starts),
        Effect::Robot(|r, v| cylinder(r, |c| c.supply = GaugePressure(c.supply.0 * v[0]))),
    );
    let (name, switch): (_, Switch) = if c.gas == Gas::AIR {
        ("carbon_dioxide_share", |r, v| {
            cylinder(r, |c| mix(c, Gas::AIR, Gas::CO2, v[0]));
        })
    } else {
        ("air_share", |r, v| {
            cylinder(r, |c| mix(c, c.gas, Gas::AIR, v[0]));
        })
    };
    let share = simple("gas-type", name, 0.0, (0.8, 1.0), 0.05, &[0.999]);
    list.add(share, Effect::Robot(switch));
}

/// Fills a cylinder with a mixture of which `b` has `share`.
fn mix(cylinder: &mut Cylinder, a: Gas, b: Gas, share: f64) {
    let of = |a: f64, b: f64| a + share * (b - a);
    let heat_ratio = of(a.heat_ratio, b.heat_ratio);
    cylinder.gas = Gas {
        heat_ratio,
        constant: of(a.constant, b.constant),
    };
    let exponent = cylinder.polytropic_exponent;
    cylinder.polytropic_exponent = exponent.map(|n| n.min(heat_ratio));
}

/// The mass on the bench.
fn load(list: &mut List) {
    let factor = simple("mass", "load_factor", 1.0, (0.2, 5.0), 0.01, &[0.8, 1.25]);
    list.add(factor, Effect::LoadFactor);
    let (name, starts) = ("load_mass_added_kg", [-0.2, 0.2]);
    let added = simple("mass", name, 0.0, (-5.0, 20.0), 0.01, &starts);
    list.add(added, Effect::LoadAdded);
}

/// A centre of mass off the axle, and a foot that slips.
fn contact(list: &mut List, robot: &Robot) {
    if robot.body.imbalance == 0.0 {
        let off = |name| unknown(name, 0.0, (-0.08, 0.08), 5e-4);
        let both = ["imbalance_forward_m", "imbalance_along_leg_m"].map(off);
        let mut imbalance = Cause::several("imbalance", both.into());
        let names = [Term::Imbalance, Term::ImbalanceAngle].map(|term| term.key(robot));
        imbalance.form = Form::Polar(names);
        list.add(
            imbalance,
            Effect::Robot(|r, v| {
                r.body.imbalance = v[0].hypot(v[1]);
                r.body.imbalance_angle = v[0].atan2(v[1]);
            }),
        );
    }
    let friction = unknown("one_over_friction", 0.0, (0.1, 60.0), 0.1);
    let kinetic = unknown("kinetic_over_static", 1.0, (0.5, 1.0), 0.05);
    let both = vec![
        friction.starting(&[1.5, 2.5, 4.0, 7.0]),
        kinetic.starting(&[1.0]),
    ];
    let mut slip = Cause::several("foot-slip", both);
    slip.form = Form::Inverse(Term::StaticFriction.key(robot));
    list.add(
        slip,
        Effect::Robot(|r, v| {
            r.ground.static_friction = 1.0 / v[0];
            r.ground.kinetic_friction = v[1] / v[0];
        }),
    );
}

/// A term without a name: what it is, its coefficient, a typical size of that, and how to set it.
type Unlisted = (&'static str, &'static str, f64, fn(&mut Extra, f64));

const OF_LEG: [Unlisted; 2] = [
    (
        "force on the leg, -c |d'| d'",
        "c_n_s2_per_m2",
        0.5,
        |e, c| e.quadratic = c,
    ),
    ("dry friction of the leg, c d", "c_n_per_m", 10.0, |e, c| {
        e.tightening = c;
    }),
];

const OF_CHAMBER: [Unlisted; 1] = [(
    "leak of the chamber, an area c d",
    "c_m2_per_m",
    1e-7,
    |e, c| e.leak_along = c,
)];

const OF_WHEEL: [Unlisted; 1] = [(
    "torque on the wheel, -c phi'",
    "c_n_m_s_per_rad",
    1e-3,
    |e, c| e.spin_damping = c,
)];

const OF_BOOM: [Unlisted; 3] = [
    (
        "torque on the boom's pivot, -c theta'",
        "c_n_m_s_per_rad",
        0.05,
        |e, c| e.pivot_damping = c,
    ),
    (
        "torque on the boom's pivot, -c theta",
        "c_n_m_per_rad",
        0.1,
        |e, c| e.pivot_spring = c,
    ),
    (
        "torque on the boom's turn, -c psi'",
        "c_n_m_s_per_rad",
        0.05,
        |e, c| e.turn_damping = c,
    ),
];

/// Whether the leg is fed from a tank, through a tube, or by a valve that moves in time.
fn is_fed(robot: &Robot) -> bool {
    Leg::new(robot, |_, x: f64| x).feed.is_some()
}

/// Terms without a name: forces and torques as functions of the state.
fn unlisted(list: &mut List, sort: Sort, robot: &Robot) {
    // One that is fed has a valve that opens in time, and its leaks, of its own.
    let is_plain = robot.leg.cylinder().is_some() && !is_fed(robot);
    if is_plain {
        let (id, starts) = ("valve that opens over a time", [5e-4, 2e-3, 8e-3, 0.03]);
        let opening = simple(id, "opening_s", 0.0, (3e-4, 0.1), 1e-3, &starts);
        list.add(opening, Effect::Extra(|e, c| e.opening = c));
    }
    let moves = sort != Sort::Bench;
    let parts = [
        (true, &OF_LEG[..]),
        (is_plain, &OF_CHAMBER),
        (moves && sort != Sort::Hop, &OF_WHEEL),
        (moves && robot.boom.is_some(), &OF_BOOM),
    ];
    let present = parts.into_iter().filter(|(is_there, _)| *is_there);
    for &(id, name, scale, set) in present.flat_map(|(_, terms)| terms) {
        let bounds = (-1e4 * scale, 1e4 * scale);
        list.add(
            simple(id, name, 0.0, bounds, scale, &[]),
            Effect::Extra(set),
        );
    }
}

fn sensing(list: &mut List, sort: Sort, columns: &[Column], channels: &[Channel]) {
    for (column, Channel { name, noise, .. }) in columns.iter().zip(channels) {
        let mut add = |cause: Cause| list.add(cause, Effect::None);
        add(gain(name).usual(0.1, "encoders are calibrated"));
        let unit = match column {
            Column::Rate => "rad_s",
            _ => name.rsplit_once('_').map_or("", |(_, unit)| unit),
        };
        add(offset(name, unit, (-1e7, 1e7), *noise));
        let late = delay(name, 0.1, 2e-4);
        if sort != Sort::Outcomes {
            add(late.clone());
        }
        if sort == Sort::Jump {
            add(late.of_column(name, Fault::Held));
        }
    }
}
