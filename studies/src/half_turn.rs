//! Half a turn of a rolling ball as a map: how what is off its plane grows, and what its twins can do about it.
//!
//! Half a turn about the disc's axis puts the legs where others were, so that the map from one single leg to the single leg
//! opposite is all there is to know. It is that of a plain roll: each station fires as in [`Stable`], twins alike.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use nalgebra::{Complex, Matrix3, Rotation3, SMatrix, SVector, UnitQuaternion, Vector3};
use saltus_controller::ball::{Balance, Balancer, Rotation, Sight, Steer, Tracker};
use saltus_gait::GaitError;
use saltus_gait::space::{Facing, Gait, Knows, Roll, Stable, roll};
use saltus_numeric::parallel;
use saltus_robot::Robot;
use saltus_sim_check::{Ledger, LegStart, Rig, Settings, Sim, Stepping};

use crate::require;

/// Numbers of a [`State`] that lie in the plane.
pub const IN_PLANE: usize = 4;
/// Numbers of a [`State`] that lie across it.
pub const LATERAL: usize = 6;

type Plane = SMatrix<f64, IN_PLANE, IN_PLANE>;
type Across = SMatrix<f64, LATERAL, LATERAL>;
type Side = SVector<f64, LATERAL>;

/// A ball at the instant at which a single leg of its disc points straight down.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// Height (m) of the place where the legs meet, its rate (m/s), its speed along the heading (m/s), and the rate of the turn
    /// about the disc's axis (rad/s).
    pub in_plane: [f64; IN_PLANE],
    /// Way to the left (m), heading to the left (rad), roll to the right (rad), the rates of the three (m/s, across the
    /// heading; rad/s, the vertical component; rad/s, about the heading).
    pub lateral: [f64; LATERAL],
    /// Way (m) along the x axis.
    pub along: f64,
}

/// What a half turn costs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// Time (s).
    pub time: f64,
    /// Way (m).
    pub way: f64,
    /// Work of the legs' drives (J).
    pub work: f64,
    /// Lost in legs (J): friction, and what their springs take.
    pub legs: f64,
    /// Lost in feet and ground (J): rubber, and where feet slip.
    pub ground: f64,
    /// Lost at the ends of strokes (J).
    pub stops: f64,
}

/// A robot that rolls half a turn at a time.
#[derive(Debug)]
pub struct Roller {
    robot: Robot,
    rig: Rig,
    facing: Facing,
    stable: Stable,
    /// The station where the map begins: a single leg.
    first: usize,
    balance: Balance<f64>,
    step: f64,
}

impl Roller {
    /// `robot` as `stable` rolls it, in time steps of `step` (s), which are also the cycles of its control.
    ///
    /// # Errors
    /// [`GaitError`] for a robot that is not in space or has no disc that half a turn maps onto itself, and numbers that cannot
    /// be.
    pub fn new(robot: &Robot, stable: &Stable, step: f64) -> Result<Roller, GaitError> {
        require(
            (1e-6..=1e-3).contains(&step),
            "time step (s)",
            step,
            "from 1e-6 to 1e-3 s",
        )?;
        let (_, facing) = Roll::new(robot.clone(), 1.0).facing()?;
        let stations = facing.plane().stations;
        let half = stations.len() / 2;
        let is_half = |k: usize| {
            let (a, b) = (&stations[k], &stations[k + half]);
            let is_opposite = (b.angle - a.angle - PI).abs() < 1e-9;
            is_opposite && a.is_of_twins() == b.is_of_twins()
        };
        let is_even = stations.len() % 2 == 0 && (0..half).all(is_half);
        let count = stations.len() as f64;
        require(
            is_even,
            "stations of the disc",
            count,
            "such that half a turn maps the disc onto itself",
        )?;
        let first = (0..half).find(|k| !stations[*k].is_of_twins());
        let singles = f64::from(u8::from(first.is_some()));
        require(
            first.is_some(),
            "single legs of the disc",
            singles,
            "one or more",
        )?;
        let own = stable.balance(robot)?;
        // Twins open as unlike as the way aside says, which is given, and nothing else corrects.
        let steer = Steer {
            roll: 0.0,
            roll_rate: 0.0,
            heading: 0.0,
            heading_rate: 0.0,
            aside: 1.0,
            aside_rate: 0.0,
            sum: 0.0,
            from: FRAC_PI_2,
            ..own.steer
        };
        let balance = Balance {
            period: step,
            steer,
            ..own
        };
        Ok(Roller {
            rig: Rig::new(robot, &[])?,
            robot: robot.clone(),
            stable: stable.clone(),
            first: first.unwrap_or_default(),
            facing,
            balance,
            step,
        })
    }

    /// The same from the leg on the other side of the disc.
    #[must_use]
    pub fn opposite(self) -> Roller {
        let stations = self.facing.plane().stations.len();
        Roller {
            first: (self.first + stations / 2) % stations,
            ..self
        }
    }

    /// Attitude of the ball with the station at `angle` (rad) straight down, heading and roll 0.
    fn upright(&self, angle: f64) -> UnitQuaternion<f64> {
        let plane = self.facing.plane();
        let [axis, first, ahead] = [plane.axis, plane.first, plane.ahead].map(Vector3::from);
        let down = angle.cos() * first + angle.sin() * ahead;
        // In the world the axis points to the left, y, and the leg down, −z.
        let body = Matrix3::from_columns(&[down.cross(&axis), axis, -down]);
        let turn = Rotation3::from_matrix_unchecked(body.transpose());
        UnitQuaternion::from_rotation_matrix(&turn)
    }

    /// Coordinates and velocities of `state` with the station at `angle` straight down, all legs retracted.
    fn placed(&self, state: &State, angle: f64) -> (Vec<f64>, Vec<f64>) {
        let [height, climb, speed, rate] = state.in_plane;
        let [left, heading, lean, drift, turn, roll_rate] = state.lateral;
        let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), heading);
        let over = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), lean);
        let attitude = yaw * over * self.upright(angle);
        let tree = &self.rig.mechanism.tree;
        let (mut q, mut v) = (vec![0.0; tree.coordinates()], vec![0.0; tree.velocities()]);
        q[..3].copy_from_slice(&[state.along, left, height]);
        q[3..7].copy_from_slice(&[attitude.w, attitude.i, attitude.j, attitude.k]);
        let velocity = yaw * Vector3::new(speed, drift, climb);
        v[..3].copy_from_slice(velocity.as_slice());
        // About the axis, about the heading, and about the vertical: not all at right angles where the disc leans.
        let axis = yaw * over * Vector3::y();
        let ahead = yaw * Vector3::x();
        let parts = Matrix3::from_rows(&[
            axis.transpose(),
            ahead.transpose(),
            Vector3::z().transpose(),
        ]);
        let spin = parts.try_inverse().unwrap_or_default() * Vector3::new(rate, roll_rate, turn);
        v[3..6].copy_from_slice(spin.as_slice());
        (q, v)
    }

    /// The other way: what `q` and `v` are, and by how much (rad) the disc is turned past where the station at `angle` points
    /// straight down, in [−π, π).
    fn seen(&self, q: &[f64], v: &[f64], angle: f64) -> (State, f64) {
        let mut tracker = Tracker::new(self.facing.plane(), -FRAC_PI_2);
        let attitude = Rotation([q[3], q[4], q[5], q[6]]);
        let (lying, _) = tracker.look(&attitude, &[v[3], v[4], v[5]]);
        let turn = lying.lean + tracker.station().map_or(0.0, |station| station.angle);
        let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -lying.heading);
        let velocity = yaw * Vector3::new(v[0], v[1], v[2]);
        let state = State {
            in_plane: [q[2], velocity.z, velocity.x, lying.rate],
            lateral: [
                q[1],
                lying.heading,
                lying.roll,
                velocity.y,
                lying.heading_rate,
                lying.roll_rate,
            ],
            along: q[0],
        };
        (state, (turn - angle + PI).rem_euclid(TAU) - PI)
    }

    /// Half a turn on from `state`, with what it costs; none if the ball does not come there. Of twins the valve of the right one
    /// opens longer by `apart` (s), that of the left one less long; at most by [`Steer::most`].
    ///
    /// # Errors
    /// [`GaitError`] for a motion that cannot be computed.
    pub fn half_turn(&self, state: &State, apart: f64) -> Result<Option<(State, Cost)>, GaitError> {
        let plane = self.facing.plane();
        let from = plane.stations[self.first].angle;
        let (q, v) = self.placed(state, from);
        let settings = Settings {
            stepping: Stepping::Fixed(self.step),
            most_steps: usize::MAX,
            ..Settings::default()
        };
        let retracted = LegStart {
            pressure: self.robot.environment.ambient.0,
            valve: None,
        };
        let legs = vec![retracted; self.rig.legs.len()];
        let mut sim = Sim::in_motion(&self.rig.mechanism, &q, &v, &legs, settings)?;
        let begin = sim.ledger();
        let mut balancer = Balancer::new(self.balance, plane);
        let mut before: Option<(f64, State)> = None;
        let mut cycles = 0_u32;
        while sim.time() < LONGEST {
            let (now, past) = self.seen(sim.coordinates(), sim.velocities(), from + PI);
            if now.lateral[2].abs() > FALLEN {
                return Ok(None);
            }
            if let Some((was, then)) = before
                && (-0.5..0.0).contains(&was)
                && past >= 0.0
            {
                let part = was / (was - past);
                let at = then.towards(&now, part);
                let mut cost = Cost::between(&begin, &sim.ledger());
                cost.time = sim.time() - (1.0 - part) * self.step;
                cost.way = at.along - state.along;
                return Ok(Some((at, cost)));
            }
            before = Some((past, now));
            let (_, fired) = balancer.step(&self.sight(&sim, apart));
            for firing in fired.into_iter().flatten() {
                sim.fire(firing.leg as usize, firing.open)?;
            }
            cycles += 1;
            sim.run(f64::from(cycles) * self.step, &[])?;
            sim.drain_events();
        }
        Ok(None)
    }

    /// What the controller sees, with twins that open `apart` (s).
    fn sight(&self, sim: &Sim<'_>, apart: f64) -> Sight<f64> {
        let (q, v) = (sim.coordinates(), sim.velocities());
        let gaps = self.rig.foot_gaps(q);
        let touching = (0..gaps.len()).filter(|leg| gaps[*leg] <= 0.0);
        Sight {
            attitude: Rotation([q[3], q[4], q[5], q[6]]),
            spin: [v[3], v[4], v[5]],
            aside: apart,
            aside_rate: 0.0,
            course: 0.0,
            touching: touching.fold(0, |bits, leg| bits | 1 << leg),
        }
    }

    /// A plain roll that goes on for ever, found by rolling until it has settled; none where it comes to rest.
    ///
    /// # Errors
    /// [`GaitError`] for a motion that cannot be computed.
    pub fn periodic(&self) -> Result<Option<State>, GaitError> {
        let Some(mut state) = self.after_rest()? else {
            return Ok(None);
        };
        let mut sum = SVector::<f64, IN_PLANE>::zeros();
        for k in 0..SETTLES + AVERAGED {
            let Some((next, _)) = self.half_turn(&state, 0.0)? else {
                return Ok(None);
            };
            state = State::straight(next.in_plane);
            if k >= SETTLES {
                sum += SVector::from(state.in_plane);
            }
        }
        Ok(Some(State::straight((sum / AVERAGED as f64).into())))
    }

    /// The greatest roll (rad), at most [`STEEPEST`], from which the plain roll `at` comes back to its plane by itself, by
    /// halving; it may have another heading then.
    ///
    /// # Errors
    /// [`GaitError`] for a motion that cannot be computed.
    pub fn basin(&self, at: &State) -> Result<f64, GaitError> {
        let comes_back = |lean: f64| -> Result<bool, GaitError> {
            let mut state = *at;
            state.lateral[2] = lean;
            for _ in 0..BACK {
                match self.half_turn(&state, 0.0)? {
                    Some((next, _)) => state = next,
                    None => return Ok(false),
                }
            }
            Ok(state.lateral[2].abs() < 0.1 * lean)
        };
        let (mut back, mut falls) = (0.0, STEEPEST);
        for _ in 0..12 {
            let middle = 0.5 * (back + falls);
            if comes_back(middle)? {
                back = middle;
            } else {
                falls = middle;
            }
        }
        Ok(back)
    }

    /// What ten half turns of the plain roll `at` cost; none where it comes to rest.
    ///
    /// # Errors
    /// [`GaitError`] for a motion that cannot be computed.
    pub fn costs(&self, at: &State) -> Result<Option<Cost>, GaitError> {
        let (mut state, mut sum) = (*at, Cost::default());
        for _ in 0..AVERAGED {
            let Some((next, cost)) = self.half_turn(&state, 0.0)? else {
                return Ok(None);
            };
            sum = sum.and(&cost);
            state = State::straight(next.in_plane);
        }
        Ok(Some(sum))
    }

    /// A state of a run from rest, some turns later.
    fn after_rest(&self) -> Result<Option<State>, GaitError> {
        let mut setup = Roll::new(self.robot.clone(), 6.0);
        (setup.gait, setup.knows) = (Gait::Stable(self.stable.clone()), Knows::Truth);
        let from = self.facing.plane().stations[self.first].angle;
        let (mut found, mut before) = (None, 0.0);
        roll(&setup, |ball| {
            let q = [&ball.place[..], &ball.attitude].concat();
            let v = [&ball.velocity[..], &ball.spin].concat();
            let (state, past) = self.seen(&q, &v, from);
            if ball.time > 3.0 && (-0.5..0.0).contains(&before) && past >= 0.0 {
                found = Some(State::straight(state.in_plane));
            }
            before = past;
            found.is_none()
        })?;
        Ok(found)
    }

    /// How half a turn from `at` changes what is a little off, by central differences of amplitudes up to `scale` times
    /// [`OFF`], on as many threads as there are; none where one of these half turns does not come to its end.
    ///
    /// A time step decides in which step a foot touches. That makes a saw of the map, whose teeth are as wide as the step. So
    /// differences are taken over ways that are far wider, and a cubic is fitted to several.
    ///
    /// # Errors
    /// [`GaitError`] for a motion that cannot be computed.
    pub fn slopes(&self, at: &State, scale: f64) -> Result<Option<Slopes>, GaitError> {
        let tried = (IN_PLANE + LATERAL + 1) * AMPLITUDES;
        let pairs = parallel::map_on(parallel::available(), tried, |job| {
            let (what, k) = (job / AMPLITUDES, job % AMPLITUDES);
            let size = scale * OFF[what] * (k + 1) as f64 / AMPLITUDES as f64;
            let one = |size: f64| {
                let (mut state, mut apart) = (*at, 0.0);
                match what {
                    k if k < IN_PLANE => state.in_plane[k] += size,
                    k if k < IN_PLANE + LATERAL => state.lateral[k - IN_PLANE] += size,
                    _ => apart = size,
                }
                self.half_turn(&state, apart)
            };
            let [Some((more, _)), Some((less, _))] = [one(size)?, one(-size)?] else {
                return Ok(None);
            };
            Ok(Some((what, size, 0.5 * (more.numbers() - less.numbers()))))
        });
        // Normal equations of a x + b x³ for each thing that is off.
        let mut sums = vec![[0.0; 3]; OFF.len()];
        let mut rights = vec![[Numbers::zeros(); 2]; OFF.len()];
        for pair in pairs {
            let pair: Result<_, GaitError> = pair;
            let Some((what, x, odd)) = pair? else {
                return Ok(None);
            };
            let one = x / (scale * OFF[what]);
            let three = one.powi(3);
            sums[what][0] += one * one;
            sums[what][1] += one * three;
            sums[what][2] += three * three;
            rights[what][0] += one * odd;
            rights[what][1] += three * odd;
        }
        let slope = |what: usize| {
            let [a, b, c] = sums[what];
            (c * rights[what][0] - b * rights[what][1]) / ((a * c - b * b) * scale * OFF[what])
        };
        Ok(Some(Slopes::of(&slope)))
    }
}

/// All numbers of a state but the way along.
type Numbers = SVector<f64, { IN_PLANE + LATERAL }>;

/// How what is off half a turn later follows from what is off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slopes {
    /// In the plane.
    pub in_plane: Plane,
    /// Across it.
    pub lateral: Across,
    /// Of the time (s) by which the right twin opens longer and the left one less long.
    pub twins: Side,
    /// The greatest slope from the plane to what lies across it or back, each over the sizes of [`OFF`]: 0 by symmetry.
    pub mixed: f64,
}

/// A multiplier of half a turn, and what it is of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Multiplier {
    /// By what half a turn multiplies it.
    pub value: Complex<f64>,
    /// `in-plane`, `roll`, `yaw` or `offset`: where its vector is greatest, in the sizes of [`OFF`].
    pub kind: &'static str,
}

impl Slopes {
    fn of(slope: &dyn Fn(usize) -> Numbers) -> Slopes {
        let mut slopes = Slopes {
            in_plane: Plane::zeros(),
            lateral: Across::zeros(),
            twins: slope(IN_PLANE + LATERAL)
                .fixed_rows::<LATERAL>(IN_PLANE)
                .into(),
            mixed: 0.0,
        };
        for what in 0..IN_PLANE + LATERAL {
            let column = slope(what);
            for (row, x) in column.iter().enumerate() {
                match (row < IN_PLANE, what < IN_PLANE) {
                    (true, true) => slopes.in_plane[(row, what)] = *x,
                    (false, false) => slopes.lateral[(row - IN_PLANE, what - IN_PLANE)] = *x,
                    _ => slopes.mixed = slopes.mixed.max((x * OFF[what] / OFF[row]).abs()),
                }
            }
        }
        slopes
    }

    /// How far the multipliers of offset and heading are from 1, and how much of anything else they change: by symmetry 0.
    pub fn neutral(&self) -> f64 {
        let mut off = 0.0_f64;
        for what in 0..2 {
            for row in 0..LATERAL {
                // A heading that is off leads aside; that is no multiplier.
                let own = f64::from(u8::from(row == what));
                let is_way = row == 0 && what == 1;
                let size = OFF[IN_PLANE + what] / OFF[IN_PLANE + row];
                let part = if is_way {
                    0.0
                } else {
                    (self.lateral[(row, what)] - own) * size
                };
                off = off.max(part.abs());
            }
        }
        off
    }

    /// All multipliers of half a turn, the greatest first in each part. Offset and heading are on the diagonal, as nothing else
    /// follows from them.
    pub fn multipliers(&self) -> Vec<Multiplier> {
        let diagonal = |k: usize, kind| Multiplier {
            value: Complex::new(self.lateral[(k, k)], 0.0),
            kind,
        };
        let mut all = vec![diagonal(0, "offset"), diagonal(1, "yaw")];
        let rest: SMatrix<f64, 4, 4> = self.lateral.fixed_view::<4, 4>(2, 2).into();
        all.extend(parted(
            &rest,
            IN_PLANE + 2,
            &["roll", "offset", "yaw", "roll"],
        ));
        all.extend(parted(&self.in_plane, 0, &["in-plane"; 4]));
        all
    }

    /// The greatest multiplier across the plane, with its vector and the one that takes its part out of a state; none if it is
    /// not real.
    pub fn growth(&self) -> Option<(f64, Side, Side)> {
        let greatest = |matrix: &Across| -> Option<(f64, Side)> {
            let values = matrix.complex_eigenvalues();
            let value = values.iter().max_by(|a, b| a.norm().total_cmp(&b.norm()))?;
            (value.im.abs() < 1e-9 * value.norm()).then(|| (value.re, kernel(matrix, value.re)))
        };
        let (value, right) = greatest(&self.lateral)?;
        let (_, left) = greatest(&self.lateral.transpose())?;
        Some((value, right, left / left.dot(&right)))
    }

    /// Singular values of what the twins of the next six half turns can bring about, in the sizes of [`OFF`]: all above 0 where
    /// they can bring the ball to any state.
    pub fn reach(&self) -> [f64; LATERAL] {
        let size = Side::from_fn(|k, _| OFF[IN_PLANE + k]);
        let most = OFF[IN_PLANE + LATERAL];
        let mut all = Across::zeros();
        let mut column = self.twins * most;
        for k in 0..LATERAL {
            all.set_column(k, &column.component_div(&size));
            column = self.lateral * column;
        }
        all.singular_values().into()
    }

    /// Gains u = −K x on offset, heading, roll and their rates for the difference u (s) of the next twins: the least sum over all
    /// half turns of the squares of x and u, each over its size in [`OFF`].
    pub fn regulator(&self) -> Side {
        let (a, b) = (self.lateral, self.twins);
        let weigh = Across::from_diagonal(&Side::from_fn(|k, _| OFF[IN_PLANE + k].powi(-2)));
        let cheap = OFF[IN_PLANE + LATERAL].powi(-2);
        let mut cost = weigh;
        let gain =
            |cost: &Across| (b.transpose() * cost * a) / (cheap + (b.transpose() * cost * b)[0]);
        for _ in 0..ROUNDS {
            let row = gain(&cost);
            cost = weigh + a.transpose() * cost * (a - b * row);
        }
        gain(&cost).transpose()
    }
}

/// The multipliers of `matrix`, each with the name of its vector's greatest number, in the sizes of [`OFF`] from `from` on.
fn parted(matrix: &SMatrix<f64, 4, 4>, from: usize, names: &[&'static str; 4]) -> Vec<Multiplier> {
    let mut values: Vec<Complex<f64>> = matrix.complex_eigenvalues().iter().copied().collect();
    values.sort_by(|a, b| b.norm().total_cmp(&a.norm()));
    let kind = |value: &Complex<f64>| {
        let complex = matrix.map(|x| Complex::new(x, 0.0))
            - SMatrix::<Complex<f64>, 4, 4>::identity() * *value;
        let svd = complex.svd(false, true);
        let vector = svd.v_t.map(|v| v.row(3).map(Complex::norm));
        let size = |k: usize| vector.map_or(0.0, |v| v[k]) / OFF[from + k];
        let most = (0..4).max_by(|a, b| size(*a).total_cmp(&size(*b)));
        names[most.unwrap_or(0)]
    };
    values
        .iter()
        .map(|value| Multiplier {
            value: *value,
            kind: kind(value),
        })
        .collect()
}

/// The vector that `matrix` multiplies by `value`.
fn kernel(matrix: &Across, value: f64) -> Side {
    let svd = (matrix - Across::identity() * value).svd(false, true);
    svd.v_t
        .map_or(Side::zeros(), |v| v.row(LATERAL - 1).transpose())
}

impl State {
    fn straight(in_plane: [f64; IN_PLANE]) -> State {
        State {
            in_plane,
            ..State::default()
        }
    }

    fn numbers(&self) -> Numbers {
        Numbers::from_iterator(self.in_plane.into_iter().chain(self.lateral))
    }

    /// The part `part` of the way to `other`.
    fn towards(&self, other: &State, part: f64) -> State {
        let mix = |a: f64, b: f64| a + part * (b - a);
        State {
            in_plane: std::array::from_fn(|k| mix(self.in_plane[k], other.in_plane[k])),
            lateral: std::array::from_fn(|k| mix(self.lateral[k], other.lateral[k])),
            along: mix(self.along, other.along),
        }
    }
}

impl Cost {
    fn and(self, other: &Cost) -> Cost {
        Cost {
            time: self.time + other.time,
            way: self.way + other.way,
            work: self.work + other.work,
            legs: self.legs + other.legs,
            ground: self.ground + other.ground,
            stops: self.stops + other.stops,
        }
    }

    fn between(begin: &Ledger, end: &Ledger) -> Cost {
        let stops = end.stops - begin.stops;
        Cost {
            work: end.drive - begin.drive,
            legs: end.joints - begin.joints,
            ground: end.contacts - begin.contacts + end.impacts - begin.impacts - stops,
            stops,
            ..Cost::default()
        }
    }
}

/// How far off states and twins are in differences at most: height (m), its rate (m/s), speed (m/s), rate (rad/s); offset (m),
/// heading, roll (rad), their rates (m/s, rad/s); the difference of the twins (s).
pub const OFF: [f64; IN_PLANE + LATERAL + 1] = [
    2e-4, 0.02, 0.02, 0.1, 0.01, 0.01, 0.01, 0.02, 0.1, 0.1, 0.002,
];
/// Amplitudes of each difference.
const AMPLITUDES: usize = 8;
/// Rounds of the regulator's recursion.
const ROUNDS: usize = 500;
/// Roll (rad) from which on a ball has fallen.
const FALLEN: f64 = 0.8;
/// Half turns until a plain roll has settled, and those over which it is averaged.
const SETTLES: usize = 20;
const AVERAGED: usize = 10;
/// Greatest roll (rad) that is tried.
pub const STEEPEST: f64 = 0.1;
/// Half turns until a ball has come back to its plane.
const BACK: usize = 6;
/// Longest half turn (s).
const LONGEST: f64 = 3.0;

#[cfg(test)]
mod tests;
