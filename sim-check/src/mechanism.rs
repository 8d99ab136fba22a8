//! What is simulated: bodies, joints with what acts in them, legs, contact points, surroundings.

use saltus_pneumatics::{Feed, Leg};

use crate::SimError;
use crate::contact::{ContactPoint, Material, Surface, Travel};
use crate::error::{ensure, finite, length, not_negative, require};
use crate::spatial::Vec3;
use crate::tree::{Joint, Pose, Tree};

/// A mechanism and what surrounds it.
#[derive(Clone, Debug)]
pub struct Mechanism {
    /// The bodies.
    pub tree: Tree,
    /// What acts in the joint of each body (joints of one coordinate; the others' parts are not
    /// used).
    pub joints: Vec<JointParts>,
    /// Telescoping legs.
    pub legs: Vec<LegPart>,
    /// What can touch.
    pub points: Vec<ContactPoint>,
    /// What can be touched.
    pub surfaces: Vec<Surface>,
    /// How contacts answer.
    pub material: Material,
    /// Which way is along the travel.
    pub travel: Travel,
    /// Acceleration of gravity (m/s²).
    pub gravity: Vec3,
    /// Air drag.
    pub drag: Option<Drag>,
    /// What pushes from outside: a force (N or N m) for each velocity of the tree; empty: nothing.
    pub forces: Vec<f64>,
}

/// What acts in a joint of one coordinate x (m or rad).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointParts {
    /// Inelastic end stops; infinite: none.
    pub stops: (f64, f64),
    /// Spring −k (x − rest): k (N/m or N m/rad) ≥ 0, and rest.
    pub spring: (f64, f64),
    /// Damper −c ẋ: c ≥ 0.
    pub damping: f64,
    /// Dry friction (N or N m), ≥ 0.
    pub friction: f64,
}

impl Default for JointParts {
    fn default() -> JointParts {
        JointParts {
            stops: (f64::NEG_INFINITY, f64::INFINITY),
            spring: (0.0, 0.0),
            damping: 0.0,
            friction: 0.0,
        }
    }
}

/// A leg: the prismatic joint of a body, driven.
///
/// Its stops (0 and the stroke) and its friction are the leg's.
#[derive(Clone, Debug)]
pub struct LegPart {
    /// The body that slides.
    pub body: usize,
    /// What pushes it, and what resists.
    pub leg: Leg<f64>,
    /// Without mass of its own: once its foot is off the ground, nothing tells where it is, and it
    /// stays.
    pub massless: bool,
}

/// Air drag −c |v| v on a body's origin.
#[derive(Clone, Copy, Debug)]
pub struct Drag {
    /// The body.
    pub body: usize,
    /// c (kg/m), ≥ 0.
    pub coefficient: f64,
}

impl JointParts {
    /// Checks what is in the joint of the body called `name`.
    fn check(&self, name: &str) -> Result<(), SimError> {
        for x in [self.spring.0, self.damping, self.friction] {
            let what = format_args!("spring, damper or friction in the joint of '{name}'");
            not_negative(what, x)?;
        }
        let (rest, (low, high)) = (self.spring.1, self.stops);
        ensure! {
            format_args!("rest or stop in the joint of '{name}'"), f64::NAN, ![rest, low, high].iter().any(|x| x.is_nan())
                => "a number";
        }
        let spring = format_args!("rest of the spring in the joint of '{name}'");
        finite(spring, &[rest])?;
        let stops = format_args!("stops in the joint of '{name}', low above high");
        require(low <= high, stops, low, "at most the high one")
    }
}

impl Mechanism {
    /// What feeds its legs from a tank, if they are fed: all have the same tank.
    pub(crate) fn feed(&self) -> Option<&Feed<f64>> {
        self.legs.iter().find_map(|part| part.leg.feed.as_ref())
    }

    /// A mechanism of these bodies alone: nothing in their joints, nothing to touch.
    pub fn new(tree: Tree, gravity: Vec3) -> Mechanism {
        Mechanism {
            joints: vec![JointParts::default(); tree.bodies().len()],
            tree,
            legs: Vec::new(),
            points: Vec::new(),
            surfaces: Vec::new(),
            material: Material {
                friction: crate::contact::Friction::Cone {
                    standing: 0.0,
                    slipping: 0.0,
                },
                restitution: 0.0,
                compliance: None,
            },
            travel: Travel::Straight,
            gravity,
            drag: None,
            forces: Vec::new(),
        }
    }

    /// Weight of all bodies (N).
    pub(crate) fn weight(&self) -> f64 {
        self.tree.bodies().iter().map(|body| body.mass).sum::<f64>() * self.gravity.norm()
    }

    /// The leg that slides `body`.
    pub(crate) fn leg_of(&self, body: usize) -> Option<usize> {
        self.legs.iter().position(|leg| leg.body == body)
    }

    /// End stops of the joint of `body`.
    pub(crate) fn stops(&self, body: usize) -> (f64, f64) {
        match self.leg_of(body) {
            Some(i) => (0.0, self.legs[i].leg.stroke),
            None => self.joints[body].stops,
        }
    }

    /// The pairs of a point and a surface.
    pub(crate) fn pairs(&self) -> impl Iterator<Item = (usize, usize)> + use<'_> {
        let surfaces = self.surfaces.len();
        let meets = |&(p, s): &(usize, usize)| {
            self.points[p].bar.is_none() || self.surfaces[s].meets_bars()
        };
        (0..self.points.len())
            .flat_map(move |p| (0..surfaces).map(move |s| (p, s)))
            .filter(meets)
    }

    /// Checks every number, and that each joint has something to move at coordinates `q`.
    pub(crate) fn check(&self, q: &[f64]) -> Result<(), SimError> {
        length("joints", self.joints.len(), self.tree.bodies().len())?;
        finite("gravity (m/s²)", self.gravity.as_slice())?;
        self.material.check()?;
        self.surfaces.iter().try_for_each(Surface::check)?;
        self.points.iter().try_for_each(|p| self.check_point(p))?;
        let mut joints = self.tree.bodies().iter().zip(&self.joints);
        joints.try_for_each(|(body, parts)| parts.check(&body.name))?;
        self.check_surroundings()?;
        for leg in &self.legs {
            let body = self.tree.bodies().get(leg.body);
            let slides = body.is_some_and(|body| matches!(body.joint, Joint::Prismatic(_)));
            let index = leg.body as f64;
            require(slides, "body of a leg", index, "one on a prismatic joint")?;
        }
        self.check_inertia(q)
    }

    fn check_point(&self, point: &ContactPoint) -> Result<(), SimError> {
        let (name, body) = (&point.name, point.body);
        ensure! {
            format_args!("body of point '{name}'"), body as f64, body < self.tree.bodies().len()
                => "one of the tree's";
        }
        not_negative(format_args!("radius of point '{name}' (m)"), point.radius)?;
        finite(
            format_args!("centre of point '{name}' (m)"),
            point.center.as_slice(),
        )?;
        let end = point.bar.unwrap_or(point.center);
        finite(format_args!("end of bar '{name}' (m)"), end.as_slice())
    }

    fn check_surroundings(&self) -> Result<(), SimError> {
        if let Some(drag) = self.drag {
            let body = drag.body as f64;
            let is_known = drag.body < self.tree.bodies().len();
            require(is_known, "body of the drag", body, "one of the tree's")?;
            not_negative("drag coefficient (kg/m)", drag.coefficient)?;
        }
        finite("force from outside (N or N m)", &self.forces)?;
        if !self.forces.is_empty() {
            let wanted = self.tree.velocities();
            length("forces from outside", self.forces.len(), wanted)?;
        }
        match self.travel {
            Travel::Around(center) => finite("centre of the travel (m)", center.as_slice()),
            Travel::Straight => Ok(()),
        }
    }

    fn check_inertia(&self, q: &[f64]) -> Result<(), SimError> {
        let n = self.tree.velocities();
        let (mut pose, mut mass, mut bias) = (Pose::default(), vec![0.0; n * n], vec![0.0; n]);
        pose.set(&self.tree, q, &vec![0.0; n]);
        pose.equations(&self.tree, &self.gravity, &mut mass, &mut bias);
        for (i, body) in self.tree.bodies().iter().enumerate() {
            let first = self.tree.velocity_of(i);
            for k in first..first + body.joint.sizes().1 {
                if mass[k * n + k] <= 0.0 || mass[k * n + k].is_nan() {
                    return Err(SimError::NoInertia {
                        body: body.name.clone(),
                    });
                }
            }
        }
        Ok(())
    }
}
