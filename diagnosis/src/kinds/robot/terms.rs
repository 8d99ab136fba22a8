//! The named effects of a robot, each a change of its file.

use saltus_robot::{
    Counterweight, Cylinder, Drive, ExhaustPort, Gas, GaugePressure, LegBody, ReturnSpring, Robot,
};

use super::Column;
use crate::experiment::Sort;
use crate::kind::{Cause, Channel, Parameter};
use crate::rig::Extra;

/// What a cause does to the model.
#[derive(Clone, Copy, Debug)]
pub(super) enum Term {
    /// It changes the robot.
    Robot(Switch),
    /// It multiplies the load on the bench.
    LoadFactor,
    /// It adds to the load on the bench.
    LoadAdded,
    /// It is a term that no listed cause has.
    Extra(fn(&mut Extra, f64)),
    /// It changes what a channel says.
    Sensor(usize, Sensor),
}

/// Switches a term on in a robot.
pub(super) type Switch = fn(&mut Robot, &[f64]);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sensor {
    Gain,
    Offset,
    /// Late by a time; before the first row the robot went on as it does there.
    Delay,
    /// Late by a time, with the first row's value before it.
    HeldDelay,
}

/// Collects causes with their terms.
#[derive(Default)]
struct List {
    causes: Vec<Cause>,
    terms: Vec<Term>,
}

/// A parameter: name, neutral value, bounds, scale, starts.
fn parameter(
    name: &str,
    neutral: f64,
    bounds: (f64, f64),
    scale: f64,
    starts: &[f64],
) -> Parameter {
    Parameter {
        name: name.into(),
        neutral,
        bounds,
        scale,
        starts: starts.to_vec(),
    }
}

impl List {
    fn add(&mut self, id: &'static str, parameters: Vec<Parameter>, switch: Switch) {
        self.causes.push(Cause {
            id,
            column: None,
            parameters,
            usual: None,
        });
        self.terms.push(Term::Robot(switch));
    }

    fn one(&mut self, id: &'static str, p: Parameter, switch: Switch) {
        self.add(id, vec![p], switch);
    }

    fn extra(&mut self, id: &'static str, p: Parameter, set: fn(&mut Extra, f64)) {
        self.causes.push(Cause {
            id,
            column: None,
            parameters: vec![p],
            usual: None,
        });
        self.terms.push(Term::Extra(set));
    }
}

fn cylinder(robot: &mut Robot, change: impl FnOnce(&mut Cylinder)) {
    if let Drive::Pneumatic(c) = &mut robot.leg.drive {
        change(c);
    }
}

/// The causes that could show in data of a kind, with their terms.
///
/// After those with an id come terms that describe what none of them explains; how many have one is
/// the last answer.
pub(super) fn causes(
    sort: Sort,
    robot: &Robot,
    columns: &[Column],
    channels: &[Channel],
) -> (Vec<Cause>, Vec<Term>, usize) {
    let mut list = List::default();
    leg(&mut list, robot);
    if sort == Sort::Bench {
        let factor = parameter("load_factor", 1.0, (0.2, 5.0), 0.01, &[0.8, 1.25]);
        list.causes.push(Cause {
            id: "mass",
            column: None,
            parameters: vec![factor],
            usual: None,
        });
        list.terms.push(Term::LoadFactor);
        let added = parameter("load_mass_added_kg", 0.0, (-5.0, 20.0), 0.01, &[-0.2, 0.2]);
        list.causes.push(Cause {
            id: "mass",
            column: None,
            parameters: vec![added],
            usual: None,
        });
        list.terms.push(Term::LoadAdded);
    } else {
        body(&mut list, robot, sort);
        contact(&mut list, sort);
    }
    flight(&mut list, robot, sort);
    sensing(&mut list, sort, columns, channels);
    let listed = list.causes.len();
    unlisted(&mut list, sort, robot);
    (list.causes, list.terms, listed)
}

/// Terms without a name: forces and torques as functions of the state.
fn unlisted(list: &mut List, sort: Sort, robot: &Robot) {
    if matches!(robot.leg.drive, Drive::Pneumatic(_)) {
        let opening = parameter(
            "opening_s",
            0.0,
            (3e-4, 0.1),
            1e-3,
            &[5e-4, 2e-3, 8e-3, 0.03],
        );
        list.extra("valve that opens over a time", opening, |e, c| {
            e.opening = c
        });
    }
    let mut add = |id: &'static str, name: &str, scale: f64, set: fn(&mut Extra, f64)| {
        list.extra(
            id,
            parameter(name, 0.0, (-1e4 * scale, 1e4 * scale), scale, &[]),
            set,
        );
    };
    add(
        "force on the leg, -c |d'| d'",
        "c_n_s2_per_m2",
        0.5,
        |e, c| e.quadratic = c,
    );
    add("dry friction of the leg, c d", "c_n_per_m", 10.0, |e, c| {
        e.tightening = c
    });
    if matches!(robot.leg.drive, Drive::Pneumatic(_)) {
        add(
            "leak of the chamber, an area c d",
            "c_m2_per_m",
            1e-7,
            |e, c| e.leak_along = c,
        );
    }
    if sort == Sort::Bench {
        return;
    }
    if sort != Sort::Hop {
        add(
            "torque on the wheel, -c phi'",
            "c_n_m_s_per_rad",
            1e-3,
            |e, c| e.spin_damping = c,
        );
    }
    if robot.boom.is_some() {
        add(
            "torque on the boom's pivot, -c theta'",
            "c_n_m_s_per_rad",
            0.05,
            |e, c| e.pivot_damping = c,
        );
        add(
            "torque on the boom's pivot, -c theta",
            "c_n_m_per_rad",
            0.1,
            |e, c| e.pivot_spring = c,
        );
        add(
            "torque on the boom's turn, -c psi'",
            "c_n_m_s_per_rad",
            0.05,
            |e, c| e.turn_damping = c,
        );
    }
}

fn leg(list: &mut List, robot: &Robot) {
    let leg = &robot.leg;
    let delay = leg.delay;
    list.one(
        "valve-delay",
        parameter(
            "leg.valve_delay_s",
            delay,
            (0.0, 0.2),
            3e-4,
            &[0.5 * delay, delay + 4e-3, delay + 0.012],
        ),
        |r, v| r.leg.delay = v[0],
    );
    let viscous = leg.viscous_friction;
    list.one(
        "viscous-friction",
        parameter(
            "leg.viscous_friction_n_s_per_m",
            viscous,
            (0.0, 2e3),
            0.5,
            &[3.0 * viscous + 10.0],
        ),
        |r, v| r.leg.viscous_friction = v[0],
    );
    let dry = leg.coulomb_friction;
    list.one(
        "coulomb-friction",
        parameter(
            "leg.coulomb_friction_n",
            dry,
            (0.0, 1e3),
            0.5,
            &[2.0 * dry + 10.0],
        ),
        |r, v| r.leg.coulomb_friction = v[0],
    );
    let spring = leg.return_spring.unwrap_or(ReturnSpring {
        stiffness: 0.0,
        preload: 0.0,
    });
    list.add(
        "return-spring",
        vec![
            parameter(
                "leg.return_spring.stiffness_n_per_m",
                spring.stiffness,
                (0.0, 1e5),
                10.0,
                &[200.0, 20.0],
            ),
            parameter(
                "leg.return_spring.preload_n",
                spring.preload,
                (0.0, 500.0),
                0.5,
                &[1.0, 10.0],
            ),
        ],
        |r, v| {
            r.leg.return_spring = Some(ReturnSpring {
                stiffness: v[0],
                preload: v[1],
            })
        },
    );
    if let Drive::Pneumatic(c) = &leg.drive {
        pneumatic(list, c, leg.stroke);
    }
}

fn pneumatic(list: &mut List, c: &Cylinder, stroke: f64) {
    list.one(
        "supply-pressure",
        parameter(
            "supply_pressure_offset_pa",
            0.0,
            (-2e6, 2e6),
            5e3,
            &[-8e4, 8e4],
        ),
        |r, v| {
            cylinder(r, |c| {
                c.supply = GaugePressure((c.supply.0 + v[0]).max(1e3))
            })
        },
    );
    list.one(
        "supply-pressure",
        parameter("supply_pressure_factor", 1.0, (0.2, 3.0), 5e-3, &[0.9, 1.1]),
        |r, v| cylinder(r, |c| c.supply = GaugePressure(c.supply.0 * v[0])),
    );
    list.one(
        "supply-droop",
        parameter(
            "leg.supply_droop_pa_s_per_kg",
            c.supply_droop,
            (0.0, 1e9),
            1e6,
            &[5e6, 5e7],
        ),
        |r, v| cylinder(r, |c| c.supply_droop = v[0]),
    );
    let discharge = c.discharge_coefficient;
    list.one(
        "valve-discharge",
        parameter(
            "leg.discharge_coefficient",
            discharge,
            (0.02, 1.0),
            5e-3,
            &[0.75 * discharge, (1.3 * discharge).min(1.0)],
        ),
        |r, v| cylinder(r, |c| c.discharge_coefficient = v[0]),
    );
    list.one(
        "chamber-leak",
        parameter(
            "leg.leak_area_m2",
            c.leak_area,
            (0.0, 1e-4),
            2e-8,
            &[2e-7, 1e-6],
        ),
        |r, v| cylinder(r, |c| c.leak_area = v[0]),
    );
    let dead = c.dead_volume;
    list.one(
        "dead-volume",
        parameter(
            "leg.dead_volume_m3",
            dead,
            (1e-8, 1e-3),
            1e-7,
            &[0.5 * dead, 2.0 * dead],
        ),
        |r, v| cylinder(r, |c| c.dead_volume = v[0]),
    );
    list.one(
        "seal-friction",
        parameter(
            "leg.seal_friction_n_per_pa",
            c.seal_friction,
            (0.0, 1e-2),
            1e-6,
            &[1e-5],
        ),
        |r, v| cylinder(r, |c| c.seal_friction = v[0]),
    );
    if c.gas == Gas::AIR {
        list.one(
            "gas-type",
            parameter("carbon_dioxide_share", 0.0, (0.8, 1.0), 0.05, &[0.999]),
            |r, v| {
                cylinder(r, |c| c.gas = mix(Gas::AIR, Gas::CO2, v[0]));
            },
        );
    } else {
        list.one(
            "gas-type",
            parameter("air_share", 0.0, (0.8, 1.0), 0.05, &[0.999]),
            |r, v| {
                cylinder(r, |c| c.gas = mix(c.gas, Gas::AIR, v[0]));
            },
        );
    }
    if c.exhaust_port.is_none() {
        list.add(
            "exhaust-port",
            vec![
                parameter(
                    "leg.exhaust_port.position_m",
                    stroke,
                    (0.05 * stroke, 0.999 * stroke),
                    5e-4,
                    &[0.9 * stroke, 0.8 * stroke, 0.65 * stroke, 0.45 * stroke],
                ),
                parameter("leg.exhaust_port.area_m2", 0.0, (1e-8, 1e-3), 5e-6, &[2e-5]),
            ],
            |r, v| {
                cylinder(r, |c| {
                    c.exhaust_port = Some(ExhaustPort {
                        position: v[0],
                        area: v[1],
                    })
                })
            },
        );
    }
    let ratio = c.gas.heat_ratio;
    list.one(
        "heat-transfer",
        parameter(
            "leg.polytropic_exponent",
            c.polytropic_exponent.unwrap_or(ratio),
            (1.0, ratio),
            5e-3,
            &[1.2],
        ),
        |r, v| {
            cylinder(r, |c| {
                c.polytropic_exponent = Some(v[0].min(c.gas.heat_ratio))
            })
        },
    );
}

fn mix(a: Gas, b: Gas, share: f64) -> Gas {
    let of = |a: f64, b: f64| a + share * (b - a);
    Gas {
        heat_ratio: of(a.heat_ratio, b.heat_ratio),
        constant: of(a.constant, b.constant),
    }
}

fn body(list: &mut List, robot: &Robot, sort: Sort) {
    let LegBody { mass: leg_mass, .. } = robot.leg.body;
    let (m, i) = (robot.body.mass, robot.body.inertia);
    let legs = f64::from(robot.body.legs) * leg_mass;
    list.one(
        "mass",
        parameter(
            "body.mass_kg",
            m,
            (0.2 * m + legs, 10.0 * m),
            0.01,
            &[0.85 * m, 1.2 * m],
        ),
        |r, v| r.body.mass = v[0],
    );
    let least = f64::from(robot.body.legs) * robot.leg.body.inertia_about_axle();
    list.one(
        "inertia",
        parameter(
            "body.inertia_kg_m2",
            i,
            (least + 0.02 * i, 20.0 * i),
            5e-4,
            &[0.7 * i, 1.4 * i],
        ),
        |r, v| r.body.inertia = v[0],
    );
    if robot.body.imbalance == 0.0 {
        list.add(
            "imbalance",
            vec![
                parameter("imbalance_forward_m", 0.0, (-0.08, 0.08), 5e-4, &[]),
                parameter("imbalance_along_leg_m", 0.0, (-0.08, 0.08), 5e-4, &[]),
            ],
            |r, v| {
                r.body.imbalance = v[0].hypot(v[1]);
                r.body.imbalance_angle = v[0].atan2(v[1]);
            },
        );
    }
    list.one(
        "axle-friction",
        parameter(
            "body.axle_friction_n_m",
            robot.body.axle_friction,
            (0.0, 10.0),
            5e-3,
            &[0.1],
        ),
        |r, v| r.body.axle_friction = v[0],
    );
    let Some(boom) = robot.boom else { return };
    list.one(
        "boom-inertia",
        parameter(
            "boom.mass_kg",
            boom.mass,
            (0.0, 20.0),
            0.01,
            &[0.5 * boom.mass, 2.0 * boom.mass],
        ),
        |r, v| {
            if let Some(boom) = &mut r.boom {
                boom.mass = v[0];
            }
        },
    );
    if boom.flex.is_none() {
        // The boom swings: each stiffness has its own phase, and near ones are no way to far ones.
        // Where a jump ends tells less of it.
        let every = if sort == Sort::Outcomes { 7 } else { 1 };
        let starts: Vec<f64> = (0..20)
            .step_by(every)
            .map(|k| 1e-4 * 1.28_f64.powi(k))
            .collect();
        list.one(
            "boom-flex",
            parameter(
                "boom_compliance_rad_per_n_m",
                0.0,
                (5e-5, 0.05),
                2e-5,
                &starts,
            ),
            |r, v| {
                if let Some(boom) = &mut r.boom {
                    boom.flex = Some(1.0 / v[0]);
                }
            },
        );
    }
    if boom.counterweight.is_none() {
        list.add(
            "counterweight",
            vec![
                parameter(
                    "boom.counterweight.mass_kg",
                    0.0,
                    (0.0, 20.0),
                    0.02,
                    &[0.3, 1.5],
                ),
                parameter(
                    "boom.counterweight.distance_m",
                    0.5,
                    (0.05, 3.0),
                    0.05,
                    &[0.5],
                ),
            ],
            |r, v| {
                if let Some(boom) = &mut r.boom {
                    boom.counterweight = Some(Counterweight {
                        mass: v[0],
                        distance: v[1],
                    });
                }
            },
        );
    }
}

fn contact(list: &mut List, sort: Sort) {
    list.add(
        "foot-slip",
        vec![
            parameter(
                "one_over_friction",
                0.0,
                (0.1, 60.0),
                0.1,
                &[1.5, 2.5, 4.0, 7.0],
            ),
            parameter("kinetic_over_static", 1.0, (0.5, 1.0), 0.05, &[1.0]),
        ],
        |r, v| {
            r.ground.static_friction = 1.0 / v[0];
            r.ground.kinetic_friction = v[1] / v[0];
        },
    );
    let (soft, damped): (Vec<f64>, Vec<f64>) = [1e-4, 3e-5, 1e-5, 3e-6, 1e-6]
        .into_iter()
        .flat_map(|c| [(c, 30.0), (c, 300.0)])
        .unzip();
    list.add(
        "ground-compliance",
        vec![
            // A robot of 3 kg sinks in by 1 cm at most.
            parameter("ground_compliance_m_per_n", 0.0, (5e-7, 3e-4), 2e-6, &soft),
            parameter("ground.damping_n_s_per_m", 0.0, (0.0, 600.0), 20.0, &damped),
        ],
        |r, v| {
            r.ground.stiffness = Some(1.0 / v[0]);
            r.ground.damping = v[1];
        },
    );
    list.one(
        "foot-rolling",
        parameter("foot.radius_m", 0.0, (0.0, 0.1), 5e-4, &[0.01]),
        |r, v| {
            r.foot.radius = v[0];
        },
    );
    if sort != Sort::Hop {
        list.one(
            "ground-slope",
            parameter("ground.slope_rad", 0.0, (-0.6, 0.6), 2e-3, &[-0.05, 0.05]),
            |r, v| {
                r.ground.slope = v[0];
            },
        );
    }
}

fn flight(list: &mut List, robot: &Robot, sort: Sort) {
    let g = robot.environment.gravity;
    list.one(
        "gravity",
        parameter(
            "environment.gravity_m_s2",
            g,
            (0.2, 40.0),
            0.02,
            &[0.9 * g, 1.1 * g],
        ),
        |r, v| {
            r.environment.gravity = v[0];
        },
    );
    if sort != Sort::Bench {
        let drag = robot.environment.drag;
        list.one(
            "air-drag",
            parameter("environment.drag_per_m", drag, (0.0, 10.0), 5e-3, &[0.1]),
            |r, v| {
                r.environment.drag = v[0];
            },
        );
    }
}

fn sensing(list: &mut List, sort: Sort, columns: &[Column], channels: &[Channel]) {
    for (k, (column, channel)) in columns.iter().zip(channels).enumerate() {
        let mut add = |id: &'static str, what: Sensor, p: Parameter| {
            let usual = (what == Sensor::Gain).then_some(0.1);
            list.causes.push(Cause {
                id,
                column: Some(channel.name.clone()),
                parameters: vec![p],
                usual,
            });
            list.terms.push(Term::Sensor(k, what));
        };
        add(
            "encoder-scale",
            Sensor::Gain,
            parameter("gain", 1.0, (0.2, 5.0), 2e-3, &[0.95, 1.05]),
        );
        let unit = channel.name.rsplit_once('_').map_or("", |(_, unit)| unit);
        let offset = if *column == Column::Rate {
            "offset_rad_s".to_owned()
        } else {
            format!("offset_{unit}")
        };
        add(
            "sensor-offset",
            Sensor::Offset,
            parameter(&offset, 0.0, (-1e7, 1e7), channel.noise, &[]),
        );
        if sort != Sort::Outcomes {
            add(
                "sensor-delay",
                Sensor::Delay,
                parameter("delay_s", 0.0, (0.0, 0.1), 2e-4, &[5e-3]),
            );
        }
        if sort == Sort::Jump {
            let delay = parameter("delay_s", 0.0, (0.0, 0.1), 2e-4, &[5e-3]);
            add("sensor-delay", Sensor::HeldDelay, delay);
        }
    }
}

/// What is told of a cause: where its parameters are not keys of a robot file, those keys.
pub(super) fn report(cause: &Cause, values: &[f64]) -> Vec<(String, f64)> {
    let say = |name: &str, value: f64| (name.to_owned(), value);
    match cause.id {
        "boom-flex" => vec![say("boom.bending_stiffness_n_m_per_rad", 1.0 / values[0])],
        "foot-slip" => {
            vec![
                say("ground.static_friction", 1.0 / values[0]),
                say("kinetic_over_static", values[1]),
            ]
        }
        "ground-compliance" => {
            vec![
                say("ground.stiffness_n_per_m", 1.0 / values[0]),
                say("ground.damping_n_s_per_m", values[1]),
            ]
        }
        "imbalance" => vec![
            say("body.imbalance_m", values[0].hypot(values[1])),
            say("body.imbalance_angle_rad", values[0].atan2(values[1])),
        ],
        _ => cause
            .parameters
            .iter()
            .zip(values)
            .map(|(p, v)| (p.name.clone(), *v))
            .collect(),
    }
}
