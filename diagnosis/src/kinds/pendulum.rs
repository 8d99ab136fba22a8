//! A part, or the robot with its legs retracted, that swings about a fixed axis; a measured torque
//! may drive it.

use std::f64::consts::TAU;

use nalgebra::{Matrix3, Vector3};
use saltus_numeric::statistics::median;
use saltus_robot::Robot;
use saltus_robot::units::{INERTIA, NUMBER, Quantity, Unit};

use super::input::Input;
use super::{Causes, FREE, causes, delay, faults, gain, offset, share, simple, unknown};
use crate::experiment::{Experiment, Run, Sort};
use crate::kind::{Asked, Cause, Data, Kind, Log, Parameter, Terms};
use crate::layout::{Draw, Layout, round};
use crate::plausible;
use crate::sensor::Sensor;
use crate::spec::{
    Domain, LOAD, PART, Problem, RADIUS, Setting, Source, Spec, Synthesis, TURN, calm, lively,
    noisy, optional, required, without,
};

/// A torque whose names end in `_nm`.
const TORQUE: (Quantity, Domain) = (
    Quantity {
        si: "N m",
        dimension: [1, 2, -2],
        units: &[("_nm", Unit::SI)],
    },
    Domain::within(1e5).called("a torque"),
);
const ABOUT_CENTRE: (Quantity, Domain) = (
    INERTIA,
    Domain::NON_NEGATIVE.up_to(1e6).called("an inertia"),
);
const AXIS: (Quantity, Domain) = (
    NUMBER,
    Domain::POSITIVE
        .up_to(100.0)
        .called("\"axle\", \"foot\" or a distance in m from the axle"),
);
/// The axis of a robot that swings about a foot.
const FOOT: f64 = -1.0;

/// The kind.
pub(super) const SPEC: Spec = Spec {
    sort: Sort::Pendulum,
    id: "pendulum",
    description: "A part or the robot, swinging about a fixed axis",
    channels: &[
        lively("angle_rad", TURN),
        without(calm("torque_nm", TORQUE)),
    ],
    settings: &[Setting {
        words: &[("axle", 0.0), ("foot", FOOT)],
        ..optional("axis", AXIS)
    }],
    rig: &[
        required("mass_kg", LOAD),
        required("centre_from_axle_m", RADIUS),
        optional("inertia_about_centre_kg_m2", ABOUT_CENTRE),
    ],
    checks: plausible::PENDULUM,
    model: |data, robot| Ok(Box::new(Pendulums::new(data, robot)?)),
    synthesis: Synthesis {
        instruments: &[noisy("angle_rad", 5e-4), noisy("torque_nm", 0.0)],
        without_boom: None,
        runs: 4,
        lay_out,
        source: Source::Model,
    },
    ..PART
};

/// What swings, as it is believed.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Body {
    /// Mass (kg).
    mass: f64,
    /// Axis to centre of mass (m).
    centre: f64,
    /// Inertia about the centre of mass (kg m²), if it is known.
    inertia: Option<f64>,
    /// Gravity (m/s²).
    gravity: f64,
}

impl Body {
    /// Weight times lever (N m).
    fn moment(&self) -> f64 {
        self.mass * self.gravity * self.centre
    }

    /// A lever (m) that matters: that of the weight, but 1 cm at least.
    fn lever(&self) -> f64 {
        self.centre.max(0.01)
    }

    /// A torque (N m) that matters.
    fn size(&self) -> f64 {
        self.mass * self.gravity * self.lever()
    }

    /// Inertia (kg m²) about the axis; of a point mass where nothing is known.
    fn about_axis(&self) -> f64 {
        self.inertia.unwrap_or(0.0) + self.mass * self.centre * self.centre
    }

    fn of(run: &Run, robot: Option<&Robot>) -> Result<Body, Problem> {
        let key = |key: &str| run.settings.get(key).copied();
        if let (Some(mass), Some(centre)) = (key("mass_kg"), key("centre_from_axle_m")) {
            return Ok(Body {
                mass,
                centre,
                inertia: key("inertia_about_centre_kg_m2"),
                gravity: robot.map_or(9.80665, |robot| robot.environment.gravity),
            });
        }
        let robot = robot.ok_or(Problem::NoRobot)?;
        let centre = match key("axis").unwrap_or(FOOT) {
            FOOT => robot.body.radius,
            distance => distance,
        };
        Ok(Body {
            mass: robot.body.mass,
            centre,
            inertia: Some(robot.body.inertia),
            gravity: robot.environment.gravity,
        })
    }
}

/// What a parameter of a cause does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Effect {
    /// Inertia about the axis, where nobody knows it.
    AboutAxis,
    Inertia,
    Mass,
    Centre,
    Dry,
    Viscous,
    Drag,
    Spring,
    Second,
    Stiffening,
}

/// Pendulums.
#[derive(Clone, Debug)]
pub struct Pendulums {
    data: Data,
    bodies: Vec<Body>,
    torques: Vec<Input>,
    causes: Causes<Effect>,
}

/// Turn (rad) of the swing's phase in a step at most: the phase of a whole step is off by its fifth
/// power over 120 (Runge and Kutta's method of order four).
const STEP: f64 = 0.08;
/// Longest step (s), and the shortest that is worth its time.
const LONGEST: f64 = 0.02;
const SHORTEST: f64 = 1e-5;

impl Pendulums {
    /// The experiment's pendulums.
    ///
    /// # Errors
    /// [`Problem::NoRobot`] where neither the data nor a robot say what swings.
    pub fn new(experiment: &Experiment, robot: Option<&Robot>) -> Result<Pendulums, Problem> {
        let angle = experiment.column("angle_rad").unwrap_or(0);
        let torque = experiment.column("torque_nm");
        let runs = &experiment.runs;
        let bodies: Vec<Body> = runs
            .iter()
            .map(|run| Body::of(run, robot))
            .collect::<Result<_, _>>()?;
        let torques: Vec<Input> = runs.iter().map(|run| Input::of(run, torque)).collect();
        let is_driven = torques.iter().any(|t| t.values.iter().any(|x| *x != 0.0));
        let mut named = named(&bodies[0], is_driven);
        let mut data = Data::of(experiment, &[angle]);
        if bodies[0].inertia.is_none() {
            let of = |run: usize| likely_inertia(&data.logs[run], &torques[run], &bodies[run]);
            let mut likely: Vec<f64> = (0..runs.len()).filter_map(of).collect();
            named.insert(0, about_axis(&bodies[0], &mut likely));
            data.common = 1;
        }
        Ok(Pendulums {
            causes: Causes::of(&mut data, named, terms(&bodies[0])),
            data,
            bodies,
            torques,
        })
    }

    /// What swings in a run.
    fn swing(&self, run: usize, terms: &Terms) -> Swing {
        let believed = self.bodies[run];
        let body = Body {
            mass: believed.mass * self.causes.or(Effect::Mass, 1.0, terms),
            centre: believed.centre + self.causes.or(Effect::Centre, 0.0, terms),
            ..believed
        };
        let inertia = match self.causes.get(Effect::AboutAxis, 0, terms) {
            Some(inertia) => inertia,
            None => body.about_axis() * self.causes.or(Effect::Inertia, 1.0, terms),
        };
        Swing {
            inertia,
            moment: body.moment(),
            dry: self.causes.or(Effect::Dry, 0.0, terms),
            viscous: self.causes.or(Effect::Viscous, 0.0, terms),
            drag: self.causes.or(Effect::Drag, 0.0, terms),
            spring: self.causes.or(Effect::Spring, 0.0, terms),
            second: self.causes.or(Effect::Second, 0.0, terms),
            stiffening: self.causes.or(Effect::Stiffening, 0.0, terms),
        }
    }
}

/// Inertia (kg m²) about the axis by least squares on the equation of motion, with viscous and
/// dry friction: over each tenth of a swing, the change of the rate is what the torques have
/// done. It is a first guess for the fit.
fn likely_inertia(log: &Log, torque: &Input, body: &Body) -> Option<f64> {
    let readings = &log.readings;
    let moment = body.moment();
    let period = TAU * (body.about_axis() / moment).sqrt();
    let first = readings.first()?;
    let mut at = 0;
    // Impulses from the first row on: of torque and weight, of a rate of one, of its sign.
    let mut impulses = vec![[0.0; 3]];
    for pair in readings.windows(2) {
        let h = pair[1].time - pair[0].time;
        let [past, turned] = [pair[0].time + 0.5 * h, pair[1].value - pair[0].value];
        let middle = pair[0].value + 0.5 * turned;
        let driven = torque.truth(past, &Sensor::default(), &mut at) - moment * middle.sin();
        let sign = if turned == 0.0 { 0.0 } else { turned.signum() };
        let [a, b, c] = impulses[impulses.len() - 1];
        impulses.push([a + h * driven, b + turned, c + h * sign]);
    }
    let rows_of = |time: f64| readings.partition_point(|r| r.time - first.time < time);
    let step = rows_of(0.1 * period).max(2);
    let rate = |row: usize| {
        let (a, b) = (&readings[row], &readings[row + step]);
        (b.value - a.value) / (b.time - a.time)
    };
    // The mean of the impulses over a window belongs to the mean rate in it.
    let mean = |row: usize| -> [f64; 3] {
        let here = &impulses[row..=row + step];
        std::array::from_fn(|k| here.iter().map(|i| i[k]).sum::<f64>() / here.len() as f64)
    };
    let (mut products, mut sums) = (Matrix3::zeros(), Vector3::zeros());
    for row in (0..readings.len().checked_sub(2 * step + 1)?).step_by(step) {
        let (a, b) = (mean(row), mean(row + step));
        let done = Vector3::from_fn(|k, _| b[k] - a[k]);
        products += done * done.transpose();
        sums += done * (rate(row + step) - rate(row));
    }
    let found = products.cholesky()?.solve(&sums)[0];
    (found > 0.0).then_some(1.0 / found)
}

/// The inertia (kg m²) about the axis of a body of which nobody knows it, at first the median of
/// what the runs tell.
fn about_axis(body: &Body, likely: &mut [f64]) -> (Option<Effect>, Cause) {
    let point = body.about_axis();
    let bounds = (0.1 * point, 100.0 * point);
    let first = if likely.is_empty() {
        point
    } else {
        median(likely).clamp(2.0 * bounds.0, 0.5 * bounds.1)
    };
    let name = "inertia_about_axis_kg_m2";
    let inertia = simple("inertia", name, first, bounds, 0.02 * point, &[]);
    (Some(Effect::AboutAxis), inertia)
}

/// The listed causes.
fn named(body: &Body, is_driven: bool) -> Vec<(Option<Effect>, Cause)> {
    let mut all = of_mass(body, is_driven);
    all.extend(of_friction(body));
    all.extend(faults([
        offset("angle_rad", "rad", (-1.0, 1.0), 1e-3),
        gain("angle_rad"),
    ]));
    if is_driven {
        all.extend(faults([
            delay("angle_rad", 0.5, 1e-3),
            offset("torque_nm", "nm", FREE, 1e-3 * body.size()),
            gain("torque_nm"),
            delay("torque_nm", 0.5, 1e-3),
        ]));
    }
    all
}

/// Causes that are masses and where they are.
fn of_mass(body: &Body, is_driven: bool) -> Vec<(Option<Effect>, Cause)> {
    let mut all = Vec::new();
    if body.inertia.is_some() {
        all.push((
            Some(Effect::Inertia),
            share("inertia", "inertia_share", 0.01),
        ));
    }
    if body.inertia.is_some() || is_driven {
        let lever = body.lever();
        let (bounds, starts) = ((-20.0 * lever, 20.0 * lever), [-0.2 * lever, 0.2 * lever]);
        let (name, scale) = ("imbalance_m", 0.01 * lever);
        let centre = simple("imbalance", name, 0.0, bounds, scale, &starts);
        all.push((Some(Effect::Centre), centre));
        all.push((Some(Effect::Mass), share("mass", "mass_share", 0.02)));
    }
    all
}

/// Causes that brake.
fn of_friction(body: &Body) -> Vec<(Option<Effect>, Cause)> {
    let size = body.size();
    let rate = (size / body.about_axis().max(1e-9)).sqrt();
    let friction = |id, name, unit: f64| {
        let starts = [0.01 * size / unit, 0.1 * size / unit];
        let (bounds, scale) = ((0.0, 10.0 * size / unit), 0.01 * size / unit);
        simple(id, name, 0.0, bounds, scale, &starts)
    };
    causes! {
        Effect::Dry => friction("coulomb-friction", "coulomb_friction_n_m", 1.0);
        Effect::Viscous => friction("viscous-friction", "viscous_friction_n_m_s_per_rad", rate);
        Effect::Drag => friction("air-drag", "drag_n_m_s2_per_rad2", rate * rate);
    }
}

/// Terms without a name.
fn terms(body: &Body) -> Vec<(Option<Effect>, Cause)> {
    let size = body.size();
    let bounds = (-100.0 * size, 100.0 * size);
    let term = |id, name| simple(id, name, 0.0, bounds, 1e-3 * size, &[]);
    causes! {
        Effect::Spring => term("torque about the axis, -c theta", "c_n_m_per_rad");
        Effect::Second => term("torque about the axis, -c sin(2 theta)", "c_n_m");
        Effect::Stiffening => term("torque about the axis, -c theta^3", "c_n_m_per_rad3");
    }
}

/// The motion: J θ̈ = τ − M sin θ − k θ − c sin 2θ − s θ³ − T sgn θ̇ − b θ̇ − d |θ̇| θ̇.
struct Swing {
    /// J (kg m²).
    inertia: f64,
    /// M (N m).
    moment: f64,
    /// T (N m).
    dry: f64,
    /// b (N m s).
    viscous: f64,
    /// d (N m s²).
    drag: f64,
    /// k (N m).
    spring: f64,
    /// c (N m).
    second: f64,
    /// s (N m).
    stiffening: f64,
}

impl Swing {
    /// Longest step (s) from a rate (rad/s).
    fn step(&self, rate: f64) -> f64 {
        let stiffness = self.moment.abs()
            + self.spring.abs()
            + 2.0 * self.second.abs()
            + 3.0 * self.stiffening.abs();
        let brake = self.viscous.abs() + 2.0 * (self.drag * rate).abs();
        let by_brake = 2.0 * STEP * self.inertia / brake;
        (STEP * (self.inertia / stiffness).sqrt())
            .min(by_brake)
            .min(LONGEST)
    }

    /// Torque (N m) but for dry friction.
    fn push(&self, [angle, rate]: [f64; 2], torque: f64) -> f64 {
        let spring = (self.spring + self.stiffening * angle * angle) * angle;
        let back = self.moment * angle.sin() + spring + self.second * (2.0 * angle).sin();
        torque - back - (self.viscous + self.drag * rate.abs()) * rate
    }

    /// One step of h (s), in which the torque (N m) goes straight from the first to the second and then to
    /// the third of `torques`. Dry friction ends and begins where the rate turns round.
    fn go(&self, mut state: [f64; 2], torques: [f64; 3], h: f64) -> [f64; 2] {
        /// Turns in a step that are followed.
        const TURNS: usize = 4;
        let torque = |share: f64| {
            let [a, b, x] = if share < 0.5 {
                [torques[0], torques[1], 2.0 * share]
            } else {
                [torques[1], torques[2], 2.0 * share - 1.0]
            };
            a + x * (b - a)
        };
        let mut done = 0.0;
        for _ in 0..TURNS {
            let mut sense = state[1].signum();
            if self.dry > 0.0 && state[1] == 0.0 {
                let net = |share: f64| self.push(state, torque(share));
                let (now, end) = (net(done), net(1.0));
                if now.abs() <= self.dry && end.abs() <= self.dry {
                    return state;
                }
                if now.abs() <= self.dry {
                    // It breaks away where the torque, which goes straight, has grown to that of friction.
                    let most = self.dry.copysign(end);
                    done += (1.0 - done) * (most - now) / (end - now);
                }
                sense = net(0.5 * (done + 1.0)).signum();
            }
            let to = |share: f64| self.moved(state, &torque, (done, share), sense, h);
            let next = to(1.0);
            if self.dry == 0.0 || next[1] * sense >= 0.0 {
                return next;
            }
            // Where the rate turns round, by secants.
            let (mut share, mut there) = (done, state);
            let (mut late, mut after) = (1.0, next);
            for _ in 0..3 {
                let slope = (after[1] - there[1]) / (late - share);
                (late, after) = (share, there);
                let at = (share - there[1] / slope).clamp(done, 1.0);
                if slope == 0.0 || (at - late).abs() < 1e-12 {
                    break;
                }
                (share, there) = (at, to(at));
            }
            (state, done) = ([there[0], 0.0], share);
        }
        state
    }

    /// The state at the share `end` of a step of h (s), from the share `begin`, where the rate has one
    /// sense.
    fn moved(
        &self,
        [angle, rate]: [f64; 2],
        torque: &dyn Fn(f64) -> f64,
        (begin, end): (f64, f64),
        sense: f64,
        h: f64,
    ) -> [f64; 2] {
        let (middle, h) = (torque(0.5 * (begin + end)), h * (end - begin));
        let at = |state: [f64; 2], torque: f64| {
            (self.push(state, torque) - sense * self.dry) / self.inertia
        };
        let k1 = [rate, at([angle, rate], torque(begin))];
        let by = |k: [f64; 2], h: f64| [angle + h * k[0], rate + h * k[1]];
        let of = |state: [f64; 2], torque: f64| [state[1], at(state, torque)];
        let k2 = of(by(k1, 0.5 * h), middle);
        let k3 = of(by(k2, 0.5 * h), middle);
        let k4 = of(by(k3, h), torque(end));
        let mean = |i: usize| (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]) / 6.0;
        by([mean(0), mean(1)], h)
    }
}

impl Kind for Pendulums {
    fn data(&self) -> &Data {
        &self.data
    }

    /// Where it starts, as its sensor says, and how fast: at rest where it stays at its first angle
    /// for a while.
    fn unknowns(&self, run: usize) -> Vec<Parameter> {
        let readings = &self.data.logs[run].readings;
        let Some(first) = readings.first() else {
            return Vec::new();
        };
        let channel = &self.data.channels[0];
        let doubt = 5.0 * channel.noise.max(channel.step);
        let at = (first.value - doubt, first.value + doubt);
        let moves = readings
            .iter()
            .find(|r| (r.value - first.value).abs() > doubt);
        let rest = moves.map_or(0.0, |reading| reading.time - first.time);
        let near = readings.get(readings.len().min(5) - 1).unwrap_or(first);
        let width = near.time - first.time;
        let (rate, bounds) = if near.time < first.time + rest {
            (0.0, (-doubt / rest, doubt / rest))
        } else {
            ((near.value - first.value) / width.max(1e-9), FREE)
        };
        vec![
            unknown("start_rad", first.value, at, 1e-3),
            unknown("start_rate_rad_s", rate, bounds, 0.01),
        ]
    }

    fn stronger(&self) -> String {
        "longer runs, some of them let go from a larger angle".into()
    }

    fn truths(&self, asked: &Asked<'_>) -> Option<Vec<f64>> {
        let (run, terms, unknowns) = asked.parts();
        let swing = self.swing(run, terms);
        let (torque, gauge) = (&self.torques[run], self.data.sensor("torque_nm", terms));
        let (mut now, mut at) = (self.data.logs[run].readings.first()?.time, 0);
        let mut state = [asked.sensors[0].truth(unknowns[0]), unknowns[1]];
        let mut out = Vec::with_capacity(asked.times.len());
        for time in &asked.times {
            let left = (time - now).max(0.0);
            let longest = swing.step(state[1]);
            if longest.is_nan() || longest < SHORTEST {
                return None;
            }
            // As many steps as the longest allows.
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let count = (left / longest).ceil() as usize;
            let h = left / count.max(1) as f64;
            for _ in 0..count {
                let torques =
                    [0.0, 0.5, 1.0].map(|share| torque.truth(now + share * h, &gauge, &mut at));
                state = swing.go(state, torques, h);
                now += h;
            }
            out.push(state[0]);
        }
        Some(out)
    }
}

/// Adds swings of one part, every second of them driven by two sines that set in smoothly.
fn lay_out(layout: &mut Layout, runs: usize, draw: &mut Draw) {
    let mass = round(draw.stepped(0.1, 2.0, 1e-3));
    let centre = round(draw.stepped(0.05, 0.3, 1e-3));
    let inertia = round(draw.between(0.1, 1.0) * mass * centre * centre);
    let rig = [
        ("mass_kg", mass),
        ("centre_from_axle_m", centre),
        ("inertia_about_centre_kg_m2", inertia),
    ];
    let moment = mass * 9.80665 * centre;
    let natural = (moment / (inertia + mass * centre * centre)).sqrt();
    let column = layout.column("torque_nm");
    for run in 0..runs {
        let is_driven = run % 2 == 1;
        let angle = if is_driven {
            0.0
        } else {
            draw.between(0.5, 1.5)
        };
        layout.add(&rig, 1201, 5e-3, vec![angle, 0.0]);
        let sines = [(); 2].map(|()| {
            // Off its resonance, in which it would turn over.
            let rate = natural * draw.between(0.3, 0.6);
            (
                moment * draw.between(0.05, 0.15),
                rate,
                draw.between(0.0, TAU),
            )
        });
        let Some(run) = layout.experiment.runs.last_mut().filter(|_| is_driven) else {
            continue;
        };
        for (value, t) in run.values[column].iter_mut().zip(&run.time) {
            let sum: f64 = sines.iter().map(|(a, w, p)| a * (w * t + p).sin()).sum();
            *value = (t / 0.2).clamp(0.0, 1.0) * sum;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FREELY: Swing = Swing {
        inertia: 0.02,
        moment: 1.5,
        dry: 0.0,
        viscous: 0.0,
        drag: 0.0,
        spring: 0.0,
        second: 0.0,
        stiffening: 0.0,
    };

    /// Turning points (s, rad) of a swing of 10 s from rest at `angle`.
    fn turns(swing: &Swing, angle: f64) -> Vec<(f64, f64)> {
        let h = swing.step(0.0);
        let (mut state, mut time, mut all) = ([angle, 0.0], 0.0, Vec::new());
        while time < 10.0 {
            let next = swing.go(state, [0.0; 3], h);
            if next[1] * state[1] < 0.0 || (next[1] == 0.0 && state[1] != 0.0) {
                let (mut low, mut high) = (0.0, h);
                for _ in 0..50 {
                    let middle = 0.5 * (low + high);
                    let has_turned = swing.go(state, [0.0; 3], middle)[1] * state[1] <= 0.0;
                    *(if has_turned { &mut high } else { &mut low }) = middle;
                }
                all.push((time + low, swing.go(state, [0.0; 3], low)[0]));
            }
            (state, time) = (next, time + h);
        }
        all
    }

    /// Half the period of a large swing, by the arithmetic-geometric mean.
    #[test]
    fn the_period_is_gauss_s() {
        for angle in [0.01_f64, 1.0, 2.5] {
            let (mut a, mut g) = (1.0, (0.5 * angle).cos());
            for _ in 0..10 {
                (a, g) = (0.5 * (a + g), f64::sqrt(a * g));
            }
            let half = std::f64::consts::PI * (FREELY.inertia / FREELY.moment).sqrt() / a;
            let found = turns(&FREELY, angle);
            let (time, _) = found[9];
            assert!((time / (10.0 * half) - 1.0).abs() < 1e-6, "{angle}: {time}");
        }
    }

    /// A spring of the third order alone: half the period is √(2 J/s)/A times ∫ du/√(1 + sin² u) over half
    /// a turn, which is 2.622057….
    #[test]
    fn a_spring_of_the_third_order_has_its_period() {
        let swing = Swing {
            moment: 0.0,
            stiffening: 1.5,
            ..FREELY
        };
        let half = (2.0 * swing.inertia / swing.stiffening).sqrt() / 1.1 * 2.622_057_554;
        let found = turns(&swing, 1.1);
        assert!(
            (found[9].0 / (10.0 * half) - 1.0).abs() < 1e-5,
            "{:?} {half}",
            found[9]
        );
        assert!((found[9].1.abs() - 1.1).abs() < 1e-5);
    }

    /// Dry friction takes 2 T of M (cos φ₁ − cos φ₂) = T (φ₁ + φ₂) in each half swing, and holds it
    /// where M sin φ is less than T.
    #[test]
    fn dry_friction_takes_its_work_and_holds_it() {
        let swing = Swing { dry: 0.1, ..FREELY };
        let found = turns(&swing, 1.2);
        let mut before = 1.2_f64;
        for (_, angle) in &found {
            let work = swing.dry * (before + angle.abs());
            let fall = swing.moment * (angle.cos() - before.cos());
            assert!((work - fall).abs() < 1e-5, "{work} {fall}");
            before = angle.abs();
        }
        assert!(found.len() < 40 && swing.moment * before.sin() < swing.dry);
    }

    /// A small swing with viscous friction falls by exp(−π b/√(4 M J − b²)) in each half swing.
    #[test]
    fn viscous_friction_has_its_decrement() {
        let swing = Swing {
            viscous: 0.02,
            ..FREELY
        };
        let b = swing.viscous;
        let root = (4.0 * swing.moment * swing.inertia - b * b).sqrt();
        let decrement = (-std::f64::consts::PI * b / root).exp();
        let found = turns(&swing, 1e-3);
        for pair in found.windows(2).take(8) {
            let ratio = -pair[1].1 / pair[0].1;
            assert!((ratio - decrement).abs() < 1e-4, "{ratio} {decrement}");
        }
    }
}
