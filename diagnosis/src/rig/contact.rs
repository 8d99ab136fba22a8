//! The foot on the ground: where it touches, how a robot stands on it, and the accelerations in
//! each contact mode.

use nalgebra::{Cholesky, Const};

use super::Flight;
use super::bodies::V3;
use super::machine::{
    BEND, Coordinates, Equations, Frame, LEAN, LEG, Machine, N, PIVOT, Square, TURN,
};

/// The contact mode of the foot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Foot {
    /// It sticks along the travel.
    Stands,
    /// It slips along the travel, this way.
    Slips(f64),
    /// It is in the air.
    Flies,
}

/// What the axle does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Axle {
    /// It turns this way.
    Turns(f64),
    /// Dry friction holds it.
    Held,
}

/// Which parts stick or are held.
#[derive(Clone, Copy, Debug)]
pub(super) struct Modes {
    pub(super) foot: Foot,
    pub(super) axle: Axle,
    pub(super) is_leg_held: bool,
    /// What other legs that are out add to the wheel's moment of inertia (kg m²), and its rate.
    pub(super) others: (f64, f64),
}

/// Accelerations and what causes them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Answer {
    pub(super) acceleration: Coordinates,
    /// Force (N) of the ground, normal and along the travel.
    pub(super) ground: [f64; 2],
    /// Force (N) that holds the leg at its extension, if it is held: positive keeps it from
    /// extending.
    pub(super) hold: f64,
    /// Torque (N m) that holds the axle at its lean, if it is held: positive keeps it from leaning
    /// forward.
    pub(super) brake: f64,
    /// Force (N) of the leg on the wheel, outwards, less what holds it.
    pub(super) push: f64,
}

/// Where the foot is nearest to the ground.
struct Place {
    /// Its distance from the ground (m).
    gap: f64,
    /// Unit vectors along the ground's normal and the travel.
    normal: V3,
    along: V3,
    /// The contact point and the centre of the foot (m).
    point: V3,
    center: V3,
}

/// Coordinates that are held.
type Held = [bool; N];

/// A foot on the ground. A constraint row is the velocity of the contact point in a direction for a
/// unit velocity of each coordinate.
struct Touch {
    /// Normal force (N) of soft ground.
    spring: Option<f64>,
    /// Constraint rows along normal and travel.
    normal: Coordinates,
    along: Coordinates,
    /// The row along which the normal force acts, with the friction across the travel.
    push: Coordinates,
    /// Accelerations of the contact point along normal and travel where all accelerations are 0.
    bias: [f64; 2],
}

/// Speed (m/s) up to which friction across the travel is proportional to the speed.
const ACROSS_SPEED: f64 = 1e-4;
/// Rate (rad/s) up to which an axle counts as standing.
const STANDING: f64 = 1e-9;

fn without(mut x: Coordinates, held: Held) -> Coordinates {
    for k in 0..N {
        if held[k] {
            x[k] = 0.0;
        }
    }
    x
}

/// The mass matrix without the coordinates that are held.
fn factor(mut mass: Square, held: Held) -> Option<Cholesky<f64, Const<N>>> {
    for k in 0..N {
        if held[k] {
            mass.row_mut(k).fill(0.0);
            mass.column_mut(k).fill(0.0);
            mass[(k, k)] = 1.0;
        }
    }
    mass.cholesky()
}

impl Machine {
    fn place(&self, f: &Frame, q: &Coordinates) -> Place {
        let center = f.wheel.joint + f.down * (self.radius - self.foot + q[LEG]);
        // The ground's normal in axes that turn with ψ; its point below the start.
        let below = V3::new(0.0, 0.0, -self.radius);
        let (normal, start) = if self.floor.slope == 0.0 {
            (V3::z(), below)
        } else {
            let (sin, cos) = self.floor.slope.sin_cos();
            let (turn, length) = self.boom.map_or((0.0, 0.0), |length| (q[TURN], length));
            let (across, ahead) = turn.sin_cos();
            let start = below + V3::new(-across, ahead, 0.0) * length;
            (V3::new(-sin * ahead, -sin * across, cos), start)
        };
        let point = center - normal * self.foot;
        let ahead = match self.boom {
            Some(_) => V3::new(point.y, -point.x, 0.0),
            None => V3::x(),
        };
        Place {
            gap: normal.dot(&(center - start)) - self.foot,
            normal,
            along: (ahead - normal * normal.dot(&ahead)).normalize(),
            point,
            center,
        }
    }

    /// Gap (m) of the foot, its speed along normal and travel (m/s), and its travel angle (rad) or
    /// travel (m).
    pub(super) fn contact(&self, q: &Coordinates, v: &Coordinates) -> (f64, [f64; 2], f64) {
        let f = self.frame(q, v);
        let place = self.place(&f, q);
        let speed = velocity(&self.columns(&f, &place.point, true), v);
        let travel = match self.boom {
            Some(_) => q[TURN] + place.point.x.atan2(place.point.y),
            None => place.point.x,
        };
        let speeds = [speed.dot(&place.normal), speed.dot(&place.along)];
        (place.gap, speeds, travel)
    }

    /// The robot on its retracted foot at travel 0, at lean `lean` (rad) and turning at `rate`
    /// (rad/s); on soft ground, which has given way under what stands on it.
    pub(super) fn stand(&self, lean: f64, rate: f64) -> Option<(Coordinates, Coordinates)> {
        if self.is_bench() {
            return Some((Coordinates::zeros(), Coordinates::zeros()));
        }
        let start = self.sunk(lean, rate, 0.0)?;
        let Some((stiffness, _)) = self.floor.soft else {
            return Some(start);
        };
        let mut rigid = self.clone();
        rigid.floor.soft = None;
        let modes = Modes {
            foot: Foot::Stands,
            axle: self.axle_at(rate),
            is_leg_held: true,
            others: (0.0, 0.0),
        };
        let answer = rigid.solve(&start.0, &start.1, 0.0, modes)?;
        self.sunk(lean, rate, answer.ground[0].max(0.0) / stiffness)
    }

    /// The robot in the air, its legs home.
    pub(super) fn aloft(flight: &Flight) -> (Coordinates, Coordinates) {
        let (mut q, mut v) = (Coordinates::zeros(), Coordinates::zeros());
        (q[LEAN], v[LEAN]) = flight.lean;
        (q[PIVOT], v[PIVOT]) = flight.pivot;
        v[TURN] = flight.turn_rate;
        (q, v)
    }

    /// The same with its foot `sag` (m) deep in the ground.
    fn sunk(&self, lean: f64, rate: f64, sag: f64) -> Option<(Coordinates, Coordinates)> {
        let (mut q, mut v) = (Coordinates::zeros(), Coordinates::zeros());
        q[LEAN] = lean;
        if self.boom.is_none() {
            q[PIVOT] = self.radius;
        }
        let arm = self.boom.unwrap_or(1.0);
        for _ in 0..30 {
            let (gap, _, travel) = self.contact(&q, &v);
            q[PIVOT] -= (gap + sag) / arm;
            q[TURN] -= travel;
            if (gap + sag).abs() < 1e-14 && travel.abs() < 1e-14 {
                break;
            }
        }
        let speeds = |k: usize, size: f64| {
            let mut v = Coordinates::zeros();
            v[k] = size;
            self.contact(&q, &v).1
        };
        let (spin, a, b) = (speeds(LEAN, rate), speeds(TURN, 1.0), speeds(PIVOT, 1.0));
        let determinant = a[0] * b[1] - a[1] * b[0];
        v[LEAN] = rate;
        v[TURN] = -(spin[0] * b[1] - spin[1] * b[0]) / determinant;
        v[PIVOT] = -(a[0] * spin[1] - a[1] * spin[0]) / determinant;
        (q.iter().chain(v.iter()).all(|x| x.is_finite())).then_some((q, v))
    }

    /// The mode of an axle that turns at `rate` (rad/s).
    pub(super) fn axle_at(&self, rate: f64) -> Axle {
        if self.axle_friction == 0.0 || rate.abs() > STANDING {
            Axle::Turns(rate.signum())
        } else {
            Axle::Held
        }
    }

    /// Accelerations and forces in `modes` under the force `push` of the leg (N, positive extends).
    /// None if the mass matrix is not positive definite.
    pub(super) fn solve(
        &self,
        q: &Coordinates,
        v: &Coordinates,
        push: f64,
        modes: Modes,
    ) -> Option<Answer> {
        if let Some(load) = self.load {
            return Some(self.lift(load, push, modes.is_leg_held));
        }
        let f = self.frame(q, v);
        let Equations {
            mut mass,
            mut force,
        } = self.assemble(&f, q, v);
        mass[(LEAN, LEAN)] += modes.others.0;
        force[LEAN] -= modes.others.1 * v[LEAN];
        force[LEG] += push;
        if let Axle::Turns(way) = modes.axle {
            force[LEAN] -= way * self.axle_friction;
        }
        let held = self.held(modes);
        let factor = factor(mass, held)?;
        let mut acceleration = factor.solve(&without(force, held));
        let mut ground = [0.0; 2];
        if modes.foot != Foot::Flies {
            let touch = self.touch(&f, q, v);
            let by_normal = factor.solve(&without(touch.push, held));
            let by_along = factor.solve(&without(touch.along, held));
            ground = self.ground(&touch, &acceleration, [&by_normal, &by_along], modes.foot);
            acceleration = acceleration + by_normal * ground[0] + by_along * ground[1];
            force = force + touch.push * ground[0] + touch.along * ground[1];
        }
        // The row of a coordinate that is held tells what holds it.
        let hold = |k: usize| force[k] - (mass.row(k) * acceleration)[0];
        Some(Answer {
            acceleration,
            ground,
            hold: hold(LEG),
            brake: hold(LEAN),
            push,
        })
    }

    /// Coordinates that the robot has not, and those that `modes` holds.
    fn held(&self, modes: Modes) -> Held {
        let mut held = [false; N];
        held[BEND] = !self.bends();
        held[LEAN] = modes.axle == Axle::Held;
        held[LEG] = modes.is_leg_held;
        held
    }

    /// A cylinder on the bench that lifts `load` (kg).
    fn lift(&self, load: f64, push: f64, is_held: bool) -> Answer {
        let hold = push - load * self.gravity;
        let mut acceleration = Coordinates::zeros();
        acceleration[LEG] = if is_held { 0.0 } else { hold / load };
        Answer {
            acceleration,
            ground: [0.0; 2],
            hold,
            brake: 0.0,
            push,
        }
    }

    fn touch(&self, f: &Frame, q: &Coordinates, v: &Coordinates) -> Touch {
        self.touch_and_across(f, q, v).0
    }

    /// The foot on the ground, and the constraint row across the travel.
    fn touch_and_across(
        &self,
        f: &Frame,
        q: &Coordinates,
        v: &Coordinates,
    ) -> (Touch, Coordinates) {
        let place = self.place(f, q);
        let columns = self.columns(f, &place.point, true);
        let row = |way: &V3| Coordinates::from_fn(|k, _| columns[k].dot(way));
        let speed = |way: &V3| (0..N).map(|k| columns[k].dot(way) * v[k]).sum::<f64>();
        let (normal, along) = (row(&place.normal), row(&place.along));
        let mut push = normal;
        let mut sideways = Coordinates::zeros();
        if self.floor.across > 0.0 && self.boom.is_some() {
            let across = place.normal.cross(&place.along);
            sideways = row(&across);
            let share = -self.floor.across * (speed(&across) / ACROSS_SPEED).clamp(-1.0, 1.0);
            push += sideways * share;
        }
        let spring = |(k, c): (f64, f64)| -k * place.gap - c * speed(&place.normal);
        let touch = Touch {
            spring: self.floor.soft.map(spring),
            normal,
            along,
            push,
            bias: self.bias(f, v, &place, &columns),
        };
        (touch, sideways)
    }

    /// Accelerations (m/s²) of the contact point along normal and travel where all accelerations of
    /// the coordinates are 0.
    fn bias(&self, f: &Frame, v: &Coordinates, at: &Place, columns: &[V3; N]) -> [f64; 2] {
        let (w, r) = (&f.wheel.spin, &f.wheel.spin_rate);
        let arm = at.center - f.wheel.joint;
        let at_center = f.wheel.bias
            + r.cross(&arm)
            + w.cross(&w.cross(&arm))
            + 2.0 * w.cross(&f.down) * v[LEG];
        let on_sphere = r.cross(&(at.point - at.center));
        let mut along = at.along.dot(&(at_center + on_sphere));
        if self.boom.is_some() {
            // The travel's direction turns as a rolling foot goes along it, while the boom drags it
            // across.
            let moving = f.axle_rate + w.cross(&arm) + f.down * v[LEG];
            let level = V3::new(at.point.x, at.point.y, 0.0);
            let rate = moving.dot(&at.along) / level.norm();
            along -= rate * velocity(columns, v).dot(&level.normalize());
        }
        [at.normal.dot(&at_center), along]
    }

    /// Force (N) of the ground, normal and along the travel. The accelerations without it are
    /// `free`; 1 N of each adds `answers` to them.
    fn ground(
        &self,
        touch: &Touch,
        free: &Coordinates,
        answers: [&Coordinates; 2],
        foot: Foot,
    ) -> [f64; 2] {
        let (normal, along) = (&touch.normal, &touch.along);
        let [nn, nt] = answers.map(|answer| normal.dot(answer));
        let [tn, tt] = answers.map(|answer| along.dot(answer));
        let an = normal.dot(free) + touch.bias[0];
        let at = along.dot(free) + touch.bias[1];
        match (touch.spring, foot) {
            (Some(n), Foot::Slips(way)) => [n, -way * self.floor.friction.1 * n],
            (Some(n), _) => [n, -(at + tn * n) / tt],
            (None, Foot::Slips(way)) => {
                let t = -way * self.floor.friction.1;
                let n = -an / (nn + t * nt);
                [n, t * n]
            }
            (None, _) => {
                let determinant = nn * tt - nt * tn;
                [
                    (-an * tt + at * nt) / determinant,
                    (-at * nn + an * tn) / determinant,
                ]
            }
        }
    }

    /// Velocities after the impulse of a foot that comes down, and what the foot does then. The
    /// impact is inelastic, with Coulomb friction along the travel and across it. The leg is held
    /// where it is home; else the impulse pushes it in. `others` is what other legs add to the wheel's
    /// moment of inertia (kg m²). Soft ground takes no impulse.
    pub(super) fn touched_down(
        &self,
        q: &Coordinates,
        v: &Coordinates,
        is_home: bool,
        others: f64,
    ) -> Option<(Coordinates, Foot)> {
        if self.floor.soft.is_some() {
            return Some((*v, Foot::Stands));
        }
        let f = self.frame(q, v);
        let modes = Modes {
            foot: Foot::Flies,
            axle: Axle::Turns(0.0),
            is_leg_held: is_home,
            others: (others, 0.0),
        };
        let held = self.held(modes);
        let mut mass = self.assemble(&f, q, v).mass;
        mass[(LEAN, LEAN)] += others;
        let factor = factor(mass, held)?;
        let (touch, across) = self.touch_and_across(&f, q, v);
        let touch = Touch {
            bias: [0.0; 2],
            ..touch
        };
        let by_along = factor.solve(&without(touch.along, held));
        let hit = |share: f64| {
            let push = touch.normal + across * share;
            let by_normal = factor.solve(&without(push, held));
            let answers = [&by_normal, &by_along];
            let mut foot = Foot::Stands;
            let mut impulse = self.ground(&touch, v, answers, foot);
            if impulse[1].abs() > self.floor.friction.0 * impulse[0] {
                foot = Foot::Slips(-impulse[1].signum());
                impulse = self.ground(&touch, v, answers, foot);
            }
            (v + by_normal * impulse[0] + by_along * impulse[1], foot)
        };
        let most = if self.boom.is_some() {
            self.floor.across
        } else {
            0.0
        };
        let way = across.dot(v).signum();
        let full = hit(-way * most);
        if most == 0.0 || across.dot(&full.0) * way >= 0.0 {
            return Some(full);
        }
        // Friction stops the motion across the travel before it is used up.
        let stops = |share: f64| across.dot(&hit(-way * share).0) * way > 0.0;
        let (low, high) = saltus_numeric::root::bisect(0.0, most, 40, stops);
        Some(hit(-way * 0.5 * (low + high)))
    }

    /// Velocities after the impulse that stops the leg in its stroke, with foot and axle free.
    pub(super) fn stop_leg(&self, q: &Coordinates, v: &Coordinates) -> Option<Coordinates> {
        if self.is_bench() {
            return Some(Coordinates::zeros());
        }
        let Equations { mass, .. } = self.assemble(&self.frame(q, v), q, v);
        let mut unit = Coordinates::zeros();
        unit[LEG] = 1.0;
        let modes = Modes {
            foot: Foot::Flies,
            axle: Axle::Turns(0.0),
            is_leg_held: false,
            others: (0.0, 0.0),
        };
        let answer = factor(mass, self.held(modes))?.solve(&unit);
        Some(v - answer * (v[LEG] / answer[LEG]))
    }
}

/// Velocity (m/s) of the point that has these columns.
fn velocity(columns: &[V3; N], v: &Coordinates) -> V3 {
    (0..N).fold(V3::zeros(), |sum, k| sum + columns[k] * v[k])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each leg has mass, because the accelerations of one without have large round-off.
    const CASES: &[(&str, &[&str])] = &[
        ("rats-planar", &["leg.mass_kg=0.3", "leg.center_m=0.19"]),
        (
            "rats-planar",
            &[
                "leg.mass_kg=0.3",
                "leg.center_m=0.19",
                "ground.slope_deg=5",
                "foot.radius_mm=30",
            ],
        ),
        ("rats-boom", &[]),
        ("rats-boom", &["foot.radius_mm=30"]),
        ("rats-boom", &["boom.bending_stiffness_n_m_per_rad=400"]),
    ];

    fn machine(name: &str, terms: &[&str]) -> Machine {
        let overrides: Vec<String> = terms.iter().map(ToString::to_string).collect();
        Machine::new(&saltus_robot::resolve(name, &overrides).expect("sound"))
    }

    /// A robot that leans, with its leg extended and extending.
    fn moving(machine: &Machine) -> (Coordinates, Coordinates) {
        let (mut q, mut v) = machine.stand(-0.3, 4.0).expect("a start");
        (q[LEG], v[LEG]) = (0.02, 1.5);
        (q, v)
    }

    fn modes(foot: Foot) -> Modes {
        Modes {
            foot,
            axle: Axle::Turns(1.0),
            is_leg_held: false,
            others: (0.0, 0.0),
        }
    }

    /// Rates of the contact point's speeds (m/s²), by quotients.
    fn rates(
        machine: &Machine,
        (q, v): &(Coordinates, Coordinates),
        acceleration: &Coordinates,
    ) -> [f64; 2] {
        let h = 1e-5;
        let speeds = |h: f64| {
            let q = q + v * h + acceleration * (0.5 * h * h);
            machine.contact(&q, &(v + acceleration * h)).1
        };
        let (before, after) = (speeds(-h), speeds(h));
        [0, 1].map(|k| (after[k] - before[k]) / (2.0 * h))
    }

    #[test]
    fn the_point_of_a_foot_that_stands_is_not_accelerated() {
        for (name, terms) in CASES {
            let machine = machine(name, terms);
            let state = moving(&machine);
            let answer = machine
                .solve(&state.0, &state.1, 200.0, modes(Foot::Stands))
                .expect("an answer");
            let rates = rates(&machine, &state, &answer.acceleration);
            // Round-off of a quotient of speeds of 1 m/s over 10 µs.
            assert!(
                rates.iter().all(|rate| rate.abs() < 1e-5),
                "{name} {terms:?}: {rates:?} m/s²"
            );
        }
    }

    #[test]
    fn a_foot_that_slips_keeps_its_gap_and_its_friction() {
        for (name, terms) in CASES {
            let mut machine = machine(name, terms);
            machine.floor.friction = (0.4, 0.3);
            let state = moving(&machine);
            let answer = machine
                .solve(&state.0, &state.1, 200.0, modes(Foot::Slips(1.0)))
                .expect("an answer");
            let rates = rates(&machine, &state, &answer.acceleration);
            assert!(rates[0].abs() < 1e-5, "{name} {terms:?}: {rates:?} m/s²");
            let [normal, along] = answer.ground;
            assert!(normal > 0.0 && (along + 0.3 * normal).abs() < 1e-12 * normal);
        }
    }

    /// A leg that pushes against the force that holds it does not move once it is free.
    #[test]
    fn a_leg_is_held_by_what_it_would_move_with() {
        for (name, terms) in CASES {
            let machine = machine(name, terms);
            let (q, mut v) = moving(&machine);
            v[LEG] = 0.0;
            let held = Modes {
                is_leg_held: true,
                ..modes(Foot::Stands)
            };
            let solve = |push, modes| machine.solve(&q, &v, push, modes).expect("an answer");
            let hold = solve(0.0, held).hold;
            let free = solve(-hold, modes(Foot::Stands));
            assert_eq!(solve(0.0, held).acceleration[LEG], 0.0);
            let rest = solve(0.0, modes(Foot::Stands)).acceleration[LEG].abs();
            assert!(
                free.acceleration[LEG].abs() < 1e-6 * rest,
                "{name} {terms:?}: {} m/s²",
                free.acceleration[LEG]
            );
        }
    }

    /// The impulse acts between leg and wheel only.
    #[test]
    fn a_leg_that_stops_takes_no_momentum_from_the_robot() {
        let (name, terms) = CASES[0];
        let machine = machine(name, terms);
        let (q, v) = moving(&machine);
        let after = machine.stop_leg(&q, &v).expect("an answer");
        let mass = machine.assemble(&machine.frame(&q, &v), &q, &v).mass;
        let (before, now) = (mass * v, mass * after);
        assert!(after[LEG].abs() < 1e-12);
        for k in [TURN, PIVOT, LEAN] {
            assert!(
                (now[k] - before[k]).abs() < 1e-12,
                "{k}: {} and {}",
                before[k],
                now[k]
            );
        }
    }
}
