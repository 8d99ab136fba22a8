//! The equations of motion of a mechanism in a given mode: accelerations, contact forces, and what
//! guards need to know.

mod answer;
mod forces;
mod rows;
mod stepping;

use crate::complementarity::Problem;
use crate::linear::cholesky;
use crate::mechanism::Mechanism;
use crate::mode::{JointMode, Mode};
use crate::spatial::Vec3;
use crate::tree::{Pose, Welded};

/// Where things are in the continuous state: q | v | a chamber variable for each leg | the gas of legs
/// that are fed from a tank, where there are any | works | an account for each leg, where they are
/// kept.
///
/// The chamber variable of a fed leg is its pressure (MPa); its gas has the mass in each chamber,
/// the tank's pressure (MPa) and mass, and the time, by which spools move. Masses are in the units
/// of the feed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    pub coordinates: usize,
    pub velocities: usize,
    pub legs: usize,
    /// Whether the legs are fed.
    pub fed: bool,
    /// Legs of which an account is kept: all or none.
    pub accounts: usize,
}

/// Works (J) that are integrated along: of the drives, lost in joints and legs, lost in contacts,
/// of drag, of what pushes from outside.
pub(crate) const WORKS: usize = 5;
pub(crate) const DRIVE: usize = 0;
pub(crate) const JOINT_LOSS: usize = 1;
pub(crate) const CONTACT_LOSS: usize = 2;
pub(crate) const DRAG_LOSS: usize = 3;
pub(crate) const OUTSIDE: usize = 4;

/// What the account of a leg holds (J): work of its drive, lost in it, n R T times the gas from the
/// supply and to the air, and the work ∫P dV of its gas.
pub(crate) const ACCOUNT: usize = 5;

/// Numbers of the tank of fed legs: pressure, mass, and the time.
const TANK: usize = 3;

impl Layout {
    pub(crate) fn size(&self) -> usize {
        self.works() + WORKS + ACCOUNT * self.accounts
    }
    pub(crate) fn q<'a>(&self, y: &'a [f64]) -> &'a [f64] {
        &y[..self.coordinates]
    }
    pub(crate) fn v<'a>(&self, y: &'a [f64]) -> &'a [f64] {
        &y[self.coordinates..self.coordinates + self.velocities]
    }
    pub(crate) fn gas(&self) -> usize {
        self.coordinates + self.velocities
    }
    pub(crate) fn works(&self) -> usize {
        self.gas() + self.legs + if self.fed { self.legs + TANK } else { 0 }
    }
    /// Where the masses of the chambers of fed legs begin.
    pub(crate) fn masses(&self) -> usize {
        self.gas() + self.legs
    }
    /// Where the tank's pressure is, before its mass and the time.
    pub(crate) fn tank(&self) -> usize {
        self.masses() + self.legs
    }
    /// Where the time is, by which spools move.
    pub(crate) fn clock(&self) -> usize {
        self.tank() + 2
    }
    /// Where the account of leg `leg` begins, from [`works`](Self::works) on; none: not kept.
    pub(crate) fn account(&self, leg: usize) -> Option<usize> {
        (leg < self.accounts).then_some(WORKS + ACCOUNT * leg)
    }
}

/// Velocity (m/s or rad/s) below which something counts as standing: round-off of what an event or
/// an impact leaves.
pub(crate) const STANDING: f64 = 1e-9;

/// Part of the weight that is no force: an exhausted chamber keeps some of it by round-off.
const NOTHING: f64 = 1e-8;

/// What a constraint row belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Owner {
    Normal(usize),
    /// Contact, and 0 for along (or a cone's both), 1 for across.
    Tangent(usize, usize),
    /// Body.
    Joint(usize),
}

/// How a closed contact lies.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Touch {
    pub contact: usize,
    /// Where it touches (m).
    pub place: Vec3,
    pub normal: Vec3,
    pub along: Vec3,
    pub across: Vec3,
    /// Distance between point and surface (m).
    pub gap: f64,
    /// Speeds along normal, along and across (m/s).
    pub speeds: Vec3,
    /// Spring and damper's force (N); none: rigid.
    pub spring: Option<f64>,
}

impl Touch {
    /// Speed (m/s) at which it slips along an axis of friction of so many rows.
    fn slip(&self, axis: usize, width: usize) -> f64 {
        if width == 2 {
            self.speeds.y.hypot(self.speeds.z)
        } else {
            self.speeds[1 + axis].abs()
        }
    }
}

/// Joints that rest, taken to stay so in a fixed step, and what tells whether they do.
#[derive(Clone, Debug, Default)]
pub(crate) struct Folded {
    /// Body and velocity index of each.
    pub joints: Vec<(usize, usize)>,
    /// Its row of the mass matrix, and the force on it.
    mass: Vec<f64>,
    pulls: Vec<f64>,
    /// Its entry in each constraint row, joint by joint.
    jacobian: Vec<f64>,
}

/// Which constraints take part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rows {
    /// Those that hold in the mode.
    Holding,
    /// All that touch and stand, to be decided.
    Candidates,
    /// All that touch, to take an impact.
    Impact,
}

/// A mechanism with its latched joints welded, and room to work.
#[derive(Clone)]
pub(crate) struct Machine<'a> {
    pub mechanism: &'a Mechanism,
    pub layout: Layout,
    pub pairs: Vec<(usize, usize)>,
    welded: Welded,
    /// Each contact point: its body in the welded tree, and its centre there.
    points: Vec<(Option<usize>, Vec3)>,
    /// The other end there of each that is a bar.
    bars: Vec<Option<Vec3>>,
    /// Velocity index in the welded tree of the joint of each body, if it moves.
    dof: Vec<Option<usize>>,
    q: Vec<f64>,
    v: Vec<f64>,
    pose: Pose,
    mass: Vec<f64>,
    /// Applied forces less h, then M⁻¹ of them.
    free: Vec<f64>,
    /// Constraint rows J, force directions G, and L⁻¹ of both.
    jacobian: Vec<f64>,
    directions: Vec<f64>,
    reduced: Vec<f64>,
    reduced_directions: Vec<f64>,
    rates: Vec<f64>,
    /// Speeds along the rows.
    pub speeds: Vec<f64>,
    pub owners: Vec<Owner>,
    pub problem: Problem,
    pub touches: Vec<Touch>,
    /// Velocity (m/s or rad/s) below which something counts as standing now: [`STANDING`], or more
    /// while a motion chatters.
    pub standing: f64,
    /// Accelerations (welded).
    pub acceleration: Vec<f64>,
    /// Whether the contact forces are one choice of many.
    pub redundant: bool,
    /// Pressure of each chamber (Pa).
    pub pressures: Vec<f64>,
    /// Force (N) of each leg on the wheel, outwards; NaN where it is latched.
    pub pushes: Vec<f64>,
    /// Force (N) that counts as none: [`NOTHING`] of the weight.
    pub nothing: f64,
    /// Least force (N) among those that hold feet on rigid ground, over the derivatives since it
    /// was set.
    pub least_hold: f64,
    powers: Vec<f64>,
    /// How much each joint's force falls with its position (N/m) and its speed (N s/m), welded.
    stiffness: Vec<f64>,
    damping: Vec<f64>,
    /// Velocities at the start of a fixed step, welded.
    start: Vec<f64>,
    /// Room for a change of velocities, welded.
    change: Vec<f64>,
    /// Joints at rest that a step leaves out.
    pub folded: Folded,
    /// For each body: the leg that it is, and its joint's end stops.
    leg_of: Vec<Option<usize>>,
    stops: Vec<(f64, f64)>,
    /// Rates of all that the state has of gas: chambers, masses, tank, time.
    gas_rates: Vec<f64>,
    /// Mass (kg/s) and enthalpy (W) that fed legs draw.
    drawn: [f64; 2],
    /// Mass matrix was positive definite, and all was finite.
    pub sound: bool,
}

impl<'a> Machine<'a> {
    pub(crate) fn new(mechanism: &'a Mechanism, keeps_accounts: bool) -> Machine<'a> {
        let layout = Layout {
            coordinates: mechanism.tree.coordinates(),
            velocities: mechanism.tree.velocities(),
            legs: mechanism.legs.len(),
            fed: mechanism.legs.iter().any(|part| part.leg.feed.is_some()),
            accounts: if keeps_accounts {
                mechanism.legs.len()
            } else {
                0
            },
        };
        let welded = mechanism
            .tree
            .weld(&vec![false; mechanism.tree.bodies().len()], &[]);
        let bodies = 0..mechanism.tree.bodies().len();
        let mut machine = Machine {
            mechanism,
            layout,
            pairs: mechanism.pairs().collect(),
            welded,
            points: Vec::new(),
            bars: Vec::new(),
            dof: Vec::new(),
            q: Vec::new(),
            v: Vec::new(),
            pose: Pose::default(),
            mass: Vec::new(),
            free: Vec::new(),
            jacobian: Vec::new(),
            directions: Vec::new(),
            reduced: Vec::new(),
            reduced_directions: Vec::new(),
            rates: vec![0.0; layout.coordinates],
            speeds: Vec::new(),
            owners: Vec::new(),
            problem: Problem::default(),
            touches: Vec::new(),
            standing: STANDING,
            acceleration: Vec::new(),
            redundant: false,
            pressures: vec![0.0; layout.legs],
            pushes: vec![f64::NAN; layout.legs],
            nothing: NOTHING * mechanism.weight(),
            least_hold: f64::INFINITY,
            powers: vec![0.0; layout.size() - layout.works()],
            stiffness: Vec::new(),
            damping: Vec::new(),
            start: Vec::new(),
            change: Vec::new(),
            folded: Folded::default(),
            leg_of: bodies.clone().map(|body| mechanism.leg_of(body)).collect(),
            stops: bodies.map(|body| mechanism.stops(body)).collect(),
            gas_rates: vec![0.0; layout.works() - layout.gas()],
            drawn: [0.0; 2],
            sound: true,
        };
        machine.resize();
        machine
    }

    /// Welds the joints that `mode` latches, as they are in `y`.
    pub(crate) fn weld(&mut self, mode: &Mode, y: &[f64]) {
        self.welded = self.mechanism.tree.weld(&mode.latched(), self.layout.q(y));
        self.resize();
    }

    fn resize(&mut self) {
        let home = |body: usize| &self.welded.home[body];
        self.points = self
            .mechanism
            .points
            .iter()
            .map(|p| (home(p.body).0, home(p.body).1.point(&p.center)))
            .collect();
        self.bars = self
            .mechanism
            .points
            .iter()
            .map(|p| p.bar.map(|end| home(p.body).1.point(&end)))
            .collect();
        self.dof = (0..self.mechanism.tree.bodies().len())
            .map(|body| {
                let k = self.mechanism.tree.velocity_of(body);
                self.welded.velocities.iter().position(|&full| full == k)
            })
            .collect();
        let n = self.n();
        self.mass.resize(n * n, 0.0);
        self.free.resize(n, 0.0);
        self.acceleration.resize(n, 0.0);
        self.stiffness.resize(n, 0.0);
        self.damping.resize(n, 0.0);
    }

    /// Number of velocities that move.
    fn n(&self) -> usize {
        self.welded.tree.velocities()
    }

    /// The derivative of the state `y` in `mode`; NaN where the equations have no answer.
    pub(crate) fn derivative(&mut self, y: &[f64], mode: &Mode, dy: &mut [f64]) {
        self.look(y, mode);
        self.least_hold = self.least_hold.min(self.hold(mode));
        dy.fill(0.0);
        if !self.sound {
            dy.fill(f64::NAN);
            return;
        }
        let layout = self.layout;
        self.welded
            .tree
            .coordinate_rates(&self.q, &self.v, &mut self.rates);
        for (i, &full) in self.welded.coordinates.iter().enumerate() {
            dy[full] = self.rates[i];
        }
        for (k, &full) in self.welded.velocities.iter().enumerate() {
            dy[layout.coordinates + full] = self.acceleration[k];
        }
        dy[layout.gas()..layout.works()].copy_from_slice(&self.gas_rates);
        dy[layout.works()..].copy_from_slice(&self.powers);
    }

    /// Least force (N) among those that hold feet on rigid ground: of the ground, and of the legs
    /// without mass. Where forces are one choice of many, they say nothing.
    fn hold(&self, mode: &Mode) -> f64 {
        if self.redundant {
            return f64::INFINITY;
        }
        let rigid = self.touches.iter().filter(|touch| touch.spring.is_none());
        let normals = rigid.map(|touch| self.normal_force(touch.contact));
        let props = (0..self.pushes.len())
            .filter(|&leg| self.is_prop(leg, mode))
            .map(|leg| self.pushes[leg]);
        normals.chain(props).fold(f64::INFINITY, f64::min)
    }

    /// Accelerations and constraint forces at `y` in `mode`.
    pub(crate) fn look(&mut self, y: &[f64], mode: &Mode) {
        self.assemble(y, mode, Rows::Holding);
        self.redundant = self.problem.solve();
        self.accelerate();
        self.account(mode);
    }

    /// Mass matrix, forces and constraint rows at `y`.
    pub(crate) fn assemble(&mut self, y: &[f64], mode: &Mode, rows: Rows) {
        self.apply_all(y, mode);
        self.sound = cholesky(&mut self.mass, self.welded.tree.velocities());
        self.touch(mode);
        self.clear_rows();
        self.contact_rows(mode, rows);
        self.joint_rows(mode, rows);
        self.couple(rows);
    }

    /// Mass matrix and forces at `y`, without those of the rows.
    fn apply_all(&mut self, y: &[f64], mode: &Mode) {
        self.place(y);
        self.pose.equations(
            &self.welded.tree,
            &self.mechanism.gravity,
            &mut self.mass,
            &mut self.free,
        );
        self.free.iter_mut().for_each(|x| *x = -*x);
        self.powers.fill(0.0);
        self.apply_joints(y, mode);
        self.apply_drag();
    }

    /// Puts the welded tree where `y` says.
    pub(crate) fn place(&mut self, y: &[f64]) {
        let (q, v) = (self.layout.q(y), self.layout.v(y));
        self.q.clear();
        self.q.extend(self.welded.coordinates.iter().map(|&i| q[i]));
        self.v.clear();
        self.v.extend(self.welded.velocities.iter().map(|&i| v[i]));
        self.pose.set(&self.welded.tree, &self.q, &self.v);
    }

    /// End stops of the joint of `body`.
    pub(crate) fn stops(&self, body: usize) -> (f64, f64) {
        self.stops[body]
    }

    /// The leg that slides `body`.
    pub(crate) fn leg_of(&self, body: usize) -> Option<usize> {
        self.leg_of[body]
    }

    /// Whether leg `leg` is one without mass that moves with its foot on rigid ground.
    ///
    /// All that it can do is push: where it has nothing to push with, its foot leaves. No ground
    /// pulls it out, however rough it is.
    pub(crate) fn is_prop(&self, leg: usize, mode: &Mode) -> bool {
        let part = &self.mechanism.legs[leg];
        let moves = matches!(
            mode.joints[part.body],
            JointMode::Free | JointMode::Sliding(_)
        );
        let stands = |(c, &(point, _)): (usize, &(usize, usize))| {
            mode.contacts[c].closed && self.mechanism.points[point].body == part.body
        };
        part.massless
            && moves
            && self.mechanism.material.compliance.is_none()
            && self.pairs.iter().enumerate().any(stands)
    }

    /// Whether the joint of `body` is neither latched nor of several coordinates.
    pub(crate) fn moves(&self, body: usize) -> bool {
        self.dof[body].is_some()
    }

    /// Speed in the joint of `body`.
    pub(crate) fn joint_speed(&self, y: &[f64], body: usize) -> f64 {
        y[self.layout.coordinates + self.mechanism.tree.velocity_of(body)]
    }
}
