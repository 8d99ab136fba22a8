//! A robot for MuJoCo: the bodies, joints, feet and ground of its [`Rig`] as an MJCF file.

mod rubber;

use std::fmt::Write;

use saltus_robot::space::{Factors, rests};
use saltus_robot::{Drive, ReturnSpring, Robot};

use crate::SimError;
use crate::contact::{ContactPoint, Surface};
use crate::error::require;
use crate::rig::Rig;
use crate::spatial::Vec3;
use crate::tree::Joint;
use crate::xml::{POINT, Xml, bodily, escaped, number, numbers, plain, positive_or, vector};

/// Friction coefficient that stands for one that is infinite.
///
/// No greater one: MuJoCo's cone is convex, so that a foot that lifts off at v_n while it moves
/// along at v_t is still pulled at while v_n < μ v_t. A leg of lean φ that is picked up at its end
/// stop leaves with v_t/v_n = tan φ: it is let go up to φ = acot 2 = 0.46 rad.
const NO_SLIP: f64 = 2.0;

/// Least friction coefficient across the travel: with less beside one along it, MuJoCo's solver
/// chatters between pushing and not.
const LEAST_FRICTION: f64 = 1e-3;

/// Time step (s).
const STEP: f64 = 1e-4;

/// Time constant (s) and damping ratio of constraints: MuJoCo lengthens the first to two of its
/// steps.
const REFERENCE: &str = "1e-06 1";

/// The same of end stops, damped so that a leg does not rebound: critically damped, they give back
/// exp(-2) of its speed.
const STOP: &str = "1e-06 10";

/// Impedance of every constraint: as near to rigid as MuJoCo goes.
const IMPEDANCE: &str = "0.9999 0.9999 0.001 0.5 2";

/// The rig of `robot` on its ground as MJCF: the same bodies, coordinates and signs as [`Rig::new`]
/// gives, in SI units and radians.
///
/// One motor for each leg, whose control is the force (N) of its drive, and one latch, an equality
/// that holds the leg retracted until it is made inactive. What MuJoCo cannot express is said in a
/// comment at the head of the file.
///
/// # Errors
/// [`SimError`] for a robot whose parts cannot be bodies.
pub fn mjcf(robot: &Robot) -> Result<String, SimError> {
    let rig = Rig::new(robot, &[])?;
    let mut writer = Writer {
        robot,
        rig: &rig,
        xml: Xml::default(),
    };
    writer.head();
    let name = escaped(&robot.name);
    writer.xml.open(format_args!(r#"mujoco model="{name}""#));
    writer.options();
    writer.world();
    writer.contacts();
    writer.latches();
    writer.actuators();
    writer.sensors();
    writer.keyframe()?;
    writer.xml.close("mujoco");
    Ok(writer.xml.text)
}

struct Writer<'a> {
    robot: &'a Robot,
    rig: &'a Rig,
    xml: Xml,
}

/// A joint that waits for a body with mass to be written in: its body, and its place (m) in the
/// frame of the next.
#[derive(Clone, Copy)]
struct Waiting {
    body: usize,
    anchor: Vec3,
}

impl Writer<'_> {
    fn head(&mut self) {
        let robot = self.robot;
        self.xml.comment(&[&format!(
            "{}, written by saltus {} (saltus export mjcf).",
            robot.name,
            env!("CARGO_PKG_VERSION")
        )]);
        let coordinates = if self.robot.space.is_some() {
            "Coordinates: where the legs meet (m), attitude (a unit quaternion w, x, y, z), then each leg's extension (m)."
        } else if self.rig.boom.is_some() {
            "Coordinates: turn (rad, forward) and pivot (rad, up) of the boom, then lean of leg_0 \
             (rad), then each leg's extension."
        } else {
            "Coordinates: travel and height of the axle (m), lean of leg_0 (rad), then each leg's \
             extension (m)."
        };
        self.xml.comment(&[
            "SI units and radians; x is the travel, z is up, lean is forward positive.",
            coordinates,
        ]);
        self.xml.comment(&[
            "A leg's motor takes the force of its drive (N), less what is said below; its joint \
             has viscous and Coulomb friction.",
            "To fire leg K make the equality latch_K inactive (data.eq_active), wait for its \
             delay, and set its motor's control.",
        ]);
        let missing = missing(robot);
        let lines: Vec<&str> = missing.iter().map(String::as_str).collect();
        self.xml
            .comment(&[&["What MuJoCo does not express:"], lines.as_slice()].concat());
    }

    fn options(&mut self) {
        self.xml
            .leaf(r#"compiler angle="radian" autolimits="true" inertiafromgeom="false""#);
        let (step, gravity) = (number(STEP), vector(&self.rig.mechanism.gravity));
        let compliance = self.rig.mechanism.material.compliance;
        let stiffer = compliance.map_or(String::new(), |_| {
            format!(r#" impratio="{}""#, number(rubber::FRICTION_STIFFER))
        });
        // At its default tolerance of 1e-8 the solver gives up while two coefficients of friction
        // are far apart.
        self.xml.leaf(format_args!(
            r#"option timestep="{step}" integrator="implicitfast" cone="elliptic" tolerance="1e-15" gravity="{gravity}"{stiffer}"#
        ));
        self.xml.open("default");
        let solver = format!(r#"solref="{REFERENCE}" solimp="{IMPEDANCE}""#);
        self.xml.leaf(r#"geom contype="0" conaffinity="0""#);
        self.xml.leaf(format_args!(
            r#"joint solreflimit="{STOP}" solimplimit="{IMPEDANCE}" solreffriction="{REFERENCE}" solimpfriction="{IMPEDANCE}""#
        ));
        self.xml.leaf(format_args!("equality {solver}"));
        self.xml.leaf(format_args!(r#"pair condim="3" {solver}"#));
        self.xml.close("default");
    }

    fn world(&mut self) {
        self.xml.open("worldbody");
        self.xml.leaf(r#"light pos="0 0 4" dir="0 0 -1""#);
        if let Some(Surface::Plane { point, normal }) = self.rig.mechanism.surfaces.first() {
            let (point, normal) = (vector(point), vector(normal));
            self.xml.leaf(format_args!(
                r#"geom name="ground" type="plane" pos="{point}" zaxis="{normal}" size="5 5 0.1" rgba="0.8 0.8 0.8 1""#
            ));
        }
        for body in self.children(None) {
            self.body(body, Vec3::zeros(), Vec::new());
        }
        self.xml.close("worldbody");
    }

    fn children(&self, parent: Option<usize>) -> Vec<usize> {
        let bodies = self.rig.mechanism.tree.bodies().iter().enumerate();
        bodies
            .filter(|(_, body)| body.parent == parent)
            .map(|(i, _)| i)
            .collect()
    }

    /// Writes a body, `at` (m) in the frame of what is written around it. One without mass, which
    /// MuJoCo does not take, leaves its joint to the body that it carries.
    fn body(&mut self, index: usize, at: Vec3, mut joints: Vec<Waiting>) {
        let body = &self.rig.mechanism.tree.bodies()[index];
        let at = at + body.placement.position;
        for waiting in &mut joints {
            waiting.anchor -= body.placement.position;
        }
        joints.push(Waiting {
            body: index,
            anchor: Vec3::zeros(),
        });
        if body.mass == 0.0 {
            for child in self.children(Some(index)) {
                self.body(child, at, joints.clone());
            }
            return;
        }
        // The height is that of the axle above the ground: the robot as drawn stands on it.
        let raised = joints.iter().any(|j| Some(j.body) == self.height());
        let at = if raised {
            at + Vec3::z() * self.rig.radius
        } else {
            at
        };
        let (name, at) = (plain(&body.name), vector(&at));
        self.xml
            .open(format_args!(r#"body name="{name}" pos="{at}""#));
        self.inertial(index);
        for joint in &joints {
            self.joint(joint);
        }
        self.shapes(index);
        for child in self.children(Some(index)) {
            self.body(child, Vec3::zeros(), Vec::new());
        }
        self.xml.close("body");
    }

    /// The body whose joint is the axle's height.
    fn height(&self) -> Option<usize> {
        self.rig.mechanism.tree.find("height")
    }

    fn inertial(&mut self, index: usize) {
        let body = &self.rig.mechanism.tree.bodies()[index];
        let i = bodily(&body.inertia);
        let off = [i[(0, 1)], i[(0, 2)], i[(1, 2)]];
        let diagonal = i.diagonal();
        // MuJoCo finds the axes of a full matrix with round-off that a disc, two of whose moments
        // sum to the third, does not bear.
        let moments = if off == [0.0; 3] {
            format!(r#"diaginertia="{}""#, vector(&diagonal))
        } else {
            format!(r#"fullinertia="{} {}""#, vector(&diagonal), numbers(&off))
        };
        let (center, mass) = (vector(&body.center), number(body.mass));
        self.xml.leaf(format_args!(
            r#"inertial pos="{center}" mass="{mass}" {moments}"#
        ));
    }

    fn joint(&mut self, waiting: &Waiting) {
        let (rig, index) = (self.rig, waiting.body);
        let body = &rig.mechanism.tree.bodies()[index];
        let name = plain(&body.name);
        let (kind, axis) = match body.joint {
            Joint::Revolute(axis) => ("hinge", axis),
            Joint::Prismatic(axis) => ("slide", axis),
            Joint::Free => {
                self.xml.leaf(format_args!(r#"freejoint name="{name}""#));
                return;
            }
        };
        let (axis, at) = (vector(&axis), vector(&waiting.anchor));
        let mut joint = format!(r#"joint name="{name}" type="{kind}" axis="{axis}" pos="{at}""#);
        let mut add = |key, value: String| {
            let _ = write!(joint, r#" {key}="{value}""#);
        };
        if Some(index) == self.height() {
            add("ref", number(rig.radius));
        }
        let parts = &rig.mechanism.joints[index];
        let (mut damping, mut dry, mut spring) = (parts.damping, parts.friction, parts.spring);
        let leg = rig.mechanism.legs.iter().position(|leg| leg.body == index);
        if let Some(k) = leg {
            let (leg, of) = (&rig.mechanism.legs[k], self.robot.own_leg(k));
            add("range", numbers(&[0.0, leg.leg.stroke]));
            (damping, dry) = (of.viscous_friction, of.coulomb_friction);
            if let Some(s) = of.return_spring.filter(|s| s.stiffness > 0.0) {
                spring = (s.stiffness, -s.preload / s.stiffness);
            }
        }
        let optional = [
            ("damping", damping),
            ("frictionloss", dry),
            ("stiffness", spring.0),
            ("springref", spring.1),
        ];
        for (key, x) in optional.into_iter().filter(|(_, x)| *x != 0.0) {
            add(key, number(x));
        }
        self.xml.leaf(joint);
    }

    /// What is seen of a body, and the feet that touch the ground.
    fn shapes(&mut self, index: usize) {
        let (rig, robot) = (self.rig, self.robot);
        let mut points = rig.mechanism.points.iter();
        if index == rig.wheel {
            let thickness = 0.05 * rig.radius;
            let ends = [-thickness, thickness].map(|y| Vec3::y() * y);
            self.cylinder(ends, 0.6 * rig.radius, r#" rgba="0.3 0.4 0.6 1""#);
            self.xml.leaf(r#"site name="axle" size="0.005""#);
        } else if let Some(point) = points.find(|point| point.body == index) {
            self.rod_and_foot(point);
        } else if let Some(boom) = &robot.boom {
            let ends = [Vec3::zeros(), Vec3::y() * boom.inner_length()];
            self.cylinder(ends, positive_or(boom.radius, 0.01), "");
        }
    }

    /// The rod of a leg, and the sphere that touches the ground.
    fn rod_and_foot(&mut self, point: &ContactPoint) {
        let (length, part) = (self.rig.radius, &self.robot.leg.body);
        let way = point.center.normalize();
        let tip = way * length;
        let rod = positive_or(part.length, 0.4 * length);
        let thickness = positive_or(part.radius, 0.02 * length);
        // Rods are drawn short of the tip, or they would hide the foot.
        let ends = [tip - way * rod, tip - way * thickness.min(0.5 * rod)];
        self.cylinder(ends, thickness, "");
        let radius = positive_or(point.radius, POINT);
        let (name, center) = (plain(&point.name), vector(&(tip - way * radius)));
        let (size, seen) = (number(radius), number(radius + 0.005));
        self.xml.leaf(format_args!(
            r#"geom name="{name}" type="sphere" pos="{center}" size="{size}" rgba="0.8 0.2 0.2 1""#
        ));
        self.xml.leaf(format_args!(
            r#"site name="{name}" pos="{center}" size="{seen}""#
        ));
    }

    fn cylinder(&mut self, ends: [Vec3; 2], radius: f64, color: &str) {
        let (ends, size) = (ends.map(|end| vector(&end)).join(" "), number(radius));
        self.xml.leaf(format_args!(
            r#"geom type="cylinder" fromto="{ends}" size="{size}"{color}"#
        ));
    }

    fn contacts(&mut self) {
        let ground = &self.robot.ground;
        let finite = |mu: f64| number(if mu.is_finite() { mu } else { NO_SLIP });
        let along = finite(ground.static_friction);
        // MuJoCo's first tangent is y, which is across the travel.
        let across = if self.rig.boom.is_some() {
            finite(ground.across_friction.max(LEAST_FRICTION))
        } else {
            along.clone()
        };
        self.xml.open("contact");
        for point in feet(self.rig) {
            let soft = self
                .rig
                .mechanism
                .material
                .compliance
                .map(|law| rubber::pair(law, rubber::mobility(self.rig, point.body), STEP));
            let (name, soft) = (plain(&point.name), soft.unwrap_or_default());
            self.xml.leaf(format_args!(
                r#"pair geom1="ground" geom2="{name}" friction="{across} {along} 0 0 0"{soft}"#
            ));
        }
        self.xml.close("contact");
    }

    fn legs(&self) -> Vec<String> {
        self.rig
            .legs
            .iter()
            .map(|&leg| plain(&self.rig.mechanism.tree.bodies()[leg].name))
            .collect()
    }

    fn latches(&mut self) {
        self.xml.open("equality");
        for (k, joint) in self.legs().into_iter().enumerate() {
            self.xml.leaf(format_args!(
                r#"joint name="latch_{k}" joint1="{joint}" polycoef="0 0 0 0 0""#
            ));
        }
        self.xml.close("equality");
    }

    fn actuators(&mut self) {
        self.xml.open("actuator");
        for joint in self.legs() {
            self.xml
                .leaf(format_args!(r#"motor name="{joint}" joint="{joint}""#));
        }
        self.xml.close("actuator");
    }

    fn sensors(&mut self) {
        let tree = &self.rig.mechanism.tree;
        // What moves freely is measured at the axle.
        let bodies = tree
            .bodies()
            .iter()
            .filter(|body| body.joint != Joint::Free);
        let joints: Vec<String> = bodies.map(|body| plain(&body.name)).collect();
        self.xml.open("sensor");
        for joint in joints {
            for (sensor, what) in [("jointpos", "position"), ("jointvel", "velocity")] {
                self.xml.leaf(format_args!(
                    r#"{sensor} name="{joint}_{what}" joint="{joint}""#
                ));
            }
        }
        let attitude = self
            .robot
            .space
            .is_some()
            .then_some(("framequat", "attitude"));
        let motion = [("framepos", "position"), ("framelinvel", "velocity")];
        for (sensor, what) in motion.into_iter().chain(attitude) {
            self.xml.leaf(format_args!(
                r#"{sensor} name="axle_{what}" objtype="site" objname="axle""#
            ));
        }
        self.xml.leaf(r#"gyro name="axle_gyro" site="axle""#);
        for point in feet(self.rig) {
            let site = plain(&point.name);
            self.xml
                .leaf(format_args!(r#"touch name="{site}_force" site="{site}""#));
        }
        self.xml.close("sensor");
    }

    /// A robot in space on the first feet on which it stands.
    fn stand_on_feet(&self, directions: &[[f64; 3]]) -> Result<Vec<f64>, SimError> {
        let rests = rests(directions);
        let legs = directions.len() as f64;
        let allowed = "those of a robot that stands on three of them";
        require(!rests.is_empty(), "legs", legs, allowed)?;
        let rest = &rests[0];
        // Any heading but straight down.
        let ahead = directions[rest.legs[0]];
        self.rig.stand_on(rest, &ahead)
    }

    fn keyframe(&mut self) -> Result<(), SimError> {
        let q = match &self.robot.space {
            Some(space) => self.stand_on_feet(&space.directions.vectors())?,
            None => self.rig.stand(0.0, 0.0)?.0,
        };
        let q = numbers(&q);
        self.xml.open("keyframe");
        self.xml
            .leaf(format_args!(r#"key name="stand" qpos="{q}""#));
        self.xml.close("keyframe");
        Ok(())
    }
}

/// What touches the ground: rods and struts touch obstacles alone.
fn feet(rig: &Rig) -> impl Iterator<Item = &ContactPoint> {
    let points = rig.mechanism.points.iter();
    points.filter(|point| point.bar.is_none())
}

/// What of `robot` the file does not say, or says otherwise, a line each.
fn missing(robot: &Robot) -> Vec<String> {
    let mut lines = vec![
        "- constraints are soft: contacts, end stops, latches and dry friction give way a little, \
         with a time constant of two time steps,"
            .to_owned(),
        "  and an end stop or a foot may rebound a little; reduce the time step until nothing \
         changes;"
            .to_owned(),
    ];
    let said = missing_of_leg(robot).into_iter().flatten();
    let all = said
        .chain(missing_of_ground(robot).into_iter().flatten())
        .chain(missing_of_running(robot).into_iter().flatten());
    lines.extend(all.map(|text| format!("- {text};")));
    if let Some(last) = lines.last_mut() {
        last.pop();
        last.push('.');
    }
    lines
}

/// The same of its legs.
fn missing_of_leg(robot: &Robot) -> [Option<String>; 8] {
    let leg = &robot.leg;
    let drive = match &leg.drive {
        Drive::Pneumatic(cylinder) if cylinder.muscle.is_some() => {
            "the muscles in the legs: integrate their gas outside, and give the motor the lever's \
             ratio times the pull"
        }
        Drive::Pneumatic(_) => {
            "the gas in the legs: integrate the chamber outside, and give the motor (P - P_a) A"
        }
        _ => "the law of the drive: give its force to the motor",
    };
    let seal = leg.cylinder().filter(|c| c.seal_friction > 0.0);
    let constant = |spring: &ReturnSpring| spring.stiffness == 0.0 && spring.preload > 0.0;
    [
        Some(drive.into()),
        robot.tank.map(|tank| {
            let litres = 1e3 * tank.volume;
            format!("the tank of {litres} l: its pressure falls with what the legs draw")
        }),
        lags(robot),
        scatter(robot),
        seal.map(|c| format!("seal friction of {} N/Pa", c.seal_friction)),
        leg.return_spring.filter(constant).map(|spring| {
            format!(
                "the return spring's constant force of {} N: take it from the motor's",
                spring.preload
            )
        }),
        leg.cushion
            .map(|_| "the end-stop cushion: take its force from the motor's".into()),
        (leg.body.mass == 0.0).then(|| {
            "legs without mass: each has 1e-6 of the robot's, and a drive pushes it through \
             ground and end stop; give leg.mass_kg"
                .into()
        }),
    ]
}

/// What lies between the command of a valve and the gas in its chamber.
fn lags(robot: &Robot) -> Option<String> {
    let cylinder = robot.leg.cylinder()?;
    let mut all = Vec::new();
    if let Some(tube) = cylinder.tube.filter(|tube| tube.length > 0.0) {
        let [length, diameter] = [tube.length, 1e3 * tube.diameter];
        all.push(format!("a tube of {length} m and {diameter} mm"));
    }
    if cylinder.spool_time > 0.0 {
        all.push(format!(
            "a spool's time constant of {} s",
            cylinder.spool_time
        ));
    }
    if let Some(delay) = robot.leg.closing_delay {
        all.push(format!("a delay of {delay} s on closing"));
    }
    (!all.is_empty()).then(|| format!("between valve and chamber: {}", all.join(", ")))
}

/// How the drives of its legs differ.
fn scatter(robot: &Robot) -> Option<String> {
    let legs = &robot.space.as_ref()?.legs;
    let list = |of: fn(&Factors) -> f64| numbers(&legs.iter().map(of).collect::<Vec<f64>>());
    let forces = list(|leg| leg.force);
    let delays = list(|leg| leg.delay);
    (!legs.is_empty()).then(|| {
        format!("legs that differ: forces times {forces}, and delays times {delays}, leg by leg")
    })
}

/// The same of its feet, what they stand on, and the air.
fn missing_of_ground(robot: &Robot) -> [Option<String>; 8] {
    let ground = &robot.ground;
    let (sticks, slips) = (ground.static_friction, ground.kinetic_friction);
    let across = ground.across_friction;
    [
        (!sticks.is_finite()).then(|| format!("infinite friction: the coefficient is {NO_SLIP}")),
        (sticks.is_finite() && slips != sticks)
            .then(|| format!("kinetic friction of {slips}: the coefficient is the static one")),
        robot.boom.map(|_| {
            "friction by the direction of travel: across it is along y, as where the boom stands \
             at turn 0"
                .into()
        }),
        (robot.boom.is_some() && across < LEAST_FRICTION).then(|| {
            format!("a coefficient of friction across it below {LEAST_FRICTION}: it is that")
        }),
        (robot.foot.radius == 0.0)
            .then(|| format!("feet that are points: they are spheres of radius {POINT} m")),
        (ground.restitution > 0.0)
            .then(|| format!("a foot's restitution of {}", ground.restitution)),
        ground.stiffness.map(|_| {
            "feet of rubber that stand creep, by twice the time step times how fast the place of \
             contact accelerates; with another time step, scale solreffriction by its inverse"
                .into()
        }),
        (robot.environment.drag > 0.0)
            .then(|| format!("air drag of {} 1/m", robot.environment.drag)),
    ]
}

/// The same of what only a running robot needs.
fn missing_of_running(robot: &Robot) -> [Option<String>; 2] {
    [
        robot
            .struts
            .map(|_| "the struts between the legs: the mass is there, their shape is not".into()),
        robot
            .sensors
            .map(|_| "sensors: read the state and add steps and noise outside".into()),
    ]
}

#[cfg(test)]
mod tests;
