//! A robot for viewers and other simulators: the bodies and joints of its [`Rig`] as a URDF file.

use std::f64::consts::FRAC_PI_2;
use std::fmt::Display;

use nalgebra::Matrix3;
use saltus_robot::Robot;

use crate::SimError;
use crate::contact::ContactPoint;
use crate::rig::Rig;
use crate::spatial::Vec3;
use crate::tree::Joint;
use crate::xml::{POINT, Xml, bodily, escaped, number, plain, positive_or, vector};

/// Mass (kg) of a link that has none, as between two joints of one body: readers of URDF take no
/// moving link without mass.
const LEAST_MASS: f64 = 1e-9;

/// Effort (N, N m) and speed (m/s, rad/s) that a joint's limits name because URDF demands them; no
/// joint reaches them.
const NO_LIMIT: [f64; 2] = [1e5, 1e3];

/// Farthest travel (m) of a robot without a boom, for the same reason.
const FAR: f64 = 1e4;

/// The link of the rig's body called `name`, which is also the name of its joint and of its frame.
pub fn link(name: &str) -> String {
    plain(name)
}

/// The link at the tip of leg `leg`, and the name of its frame.
pub fn foot_frame(leg: usize) -> String {
    format!("foot_{leg}")
}

/// The rig of `robot` as URDF: the links `world`, one for each body, and one for each foot; joints
/// in the order and with the signs of the coordinates of [`Rig::new`], in SI units and radians.
///
/// What URDF cannot express is said in a comment at the head of the file.
///
/// # Errors
/// [`SimError`] for a robot whose parts cannot be bodies.
pub fn urdf(robot: &Robot) -> Result<String, SimError> {
    let rig = Rig::new(robot, &[])?;
    let mut writer = Writer {
        robot,
        rig: &rig,
        xml: Xml::default(),
    };
    writer.xml.text.push_str("<?xml version=\"1.0\"?>\n");
    writer.head();
    let name = escaped(&robot.name);
    writer.xml.open(format_args!(r#"robot name="{name}""#));
    writer.materials();
    writer.xml.leaf(r#"link name="world""#);
    for body in 0..rig.mechanism.tree.bodies().len() {
        writer.link(body);
        writer.joint(body);
    }
    for leg in 0..rig.legs.len() {
        writer.foot(leg);
    }
    writer.xml.close("robot");
    Ok(writer.xml.text)
}

struct Writer<'a> {
    robot: &'a Robot,
    rig: &'a Rig,
    xml: Xml,
}

impl Writer<'_> {
    fn head(&mut self) {
        let version = env!("CARGO_PKG_VERSION");
        self.xml.comment(&[&format!(
            "{}, written by saltus {version} (saltus export urdf).",
            self.robot.name
        )]);
        let joints = if self.robot.space.is_some() {
            "Joints: body (floating: where the legs meet, and the attitude); leg_K (extension)."
        } else {
            "Joints: travel and height of the axle, or turn and pivot of the boom; wheel (the lean of \
             leg_0); leg_K (extension)."
        };
        self.xml.comment(&[
            "SI units and radians; x is the travel, z is up, lean is forward positive.",
            joints,
        ]);
        let mut lines = vec!["What URDF does not express:".to_owned()];
        let said = missing(self.robot);
        lines.extend(said.into_iter().flatten().map(|text| format!("- {text};")));
        if let Some(last) = lines.last_mut() {
            last.pop();
            last.push('.');
        }
        let lines: Vec<&str> = lines.iter().map(String::as_str).collect();
        self.xml.comment(&lines);
    }

    fn materials(&mut self) {
        let colors = [
            ("wheel", "0.3 0.4 0.6 1"),
            ("rod", "0.5 0.5 0.5 1"),
            ("foot", "0.8 0.2 0.2 1"),
        ];
        for (name, rgba) in colors {
            self.xml.open(format_args!(r#"material name="{name}""#));
            self.xml.leaf(format_args!(r#"color rgba="{rgba}""#));
            self.xml.close("material");
        }
    }

    fn link(&mut self, index: usize) {
        let body = &self.rig.mechanism.tree.bodies()[index];
        let name = plain(&body.name);
        self.xml.open(format_args!(r#"link name="{name}""#));
        self.inertial(body.mass, &body.center, &body.inertia);
        self.shapes(index);
        self.xml.close("link");
    }

    fn inertial(&mut self, mass: f64, center: &Vec3, inertia: &Matrix3<f64>) {
        let i = bodily(inertia);
        self.xml.open("inertial");
        let (center, mass) = (vector(center), number(mass.max(LEAST_MASS)));
        self.xml.leaf(format_args!(r#"origin xyz="{center}""#));
        self.xml.leaf(format_args!(r#"mass value="{mass}""#));
        let places = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];
        let [xx, xy, xz, yy, yz, zz] = places.map(|place| number(i[place]));
        self.xml.leaf(format_args!(
            r#"inertia ixx="{xx}" ixy="{xy}" ixz="{xz}" iyy="{yy}" iyz="{yz}" izz="{zz}""#
        ));
        self.xml.close("inertial");
    }

    fn shapes(&mut self, index: usize) {
        let (rig, robot) = (self.rig, self.robot);
        let mut points = rig.mechanism.points.iter();
        if index == rig.wheel && robot.space.is_some() {
            self.ball(0.5 * rig.radius, "wheel");
        } else if index == rig.wheel {
            let half = Vec3::y() * (0.05 * rig.radius);
            self.cylinder([-half, half], 0.6 * rig.radius, "wheel");
        } else if let Some(point) = points.find(|point| point.body == index) {
            let part = &robot.leg.body;
            let tip = tip(point, rig.radius);
            let rod = positive_or(part.length, 0.4 * rig.radius);
            let thickness = positive_or(part.radius, 0.02 * rig.radius);
            self.cylinder([tip - tip.normalize() * rod, tip], thickness, "rod");
        } else if let Some(boom) = &robot.boom
            && rig.mechanism.tree.bodies()[index].mass > 0.0
        {
            let ends = [Vec3::zeros(), Vec3::y() * boom.inner_length()];
            self.cylinder(ends, positive_or(boom.radius, 0.01), "rod");
        }
    }

    /// A cylinder between two places (m), as it is seen.
    fn cylinder(&mut self, [from, to]: [Vec3; 2], radius: f64, material: &str) {
        let along = to - from;
        let length = along.norm();
        // URDF has cylinders along z: first turned about y, then about z.
        let pitch = (along.z / length).clamp(-1.0, 1.0).acos();
        let yaw = along.y.atan2(along.x);
        let turned = vector(&Vec3::new(0.0, pitch, yaw));
        let (radius, length) = (number(radius), number(length));
        self.xml.open("visual");
        let middle = vector(&(0.5 * (from + to)));
        self.xml
            .leaf(format_args!(r#"origin xyz="{middle}" rpy="{turned}""#));
        self.geometry(format_args!(
            r#"cylinder radius="{radius}" length="{length}""#
        ));
        self.xml.leaf(format_args!(r#"material name="{material}""#));
        self.xml.close("visual");
    }

    /// A ball around the origin, as it is seen.
    fn ball(&mut self, radius: f64, material: &str) {
        let radius = number(radius);
        self.xml.open("visual");
        self.geometry(format_args!(r#"sphere radius="{radius}""#));
        self.xml.leaf(format_args!(r#"material name="{material}""#));
        self.xml.close("visual");
    }

    fn geometry(&mut self, shape: impl Display) {
        self.xml.open("geometry");
        self.xml.leaf(shape);
        self.xml.close("geometry");
    }

    fn joint(&mut self, index: usize) {
        let rig = self.rig;
        let body = &rig.mechanism.tree.bodies()[index];
        let leg = rig.mechanism.legs.iter().find(|leg| leg.body == index);
        let stroke = leg.map(|leg| leg.leg.stroke);
        let (kind, axis, limits) = match body.joint {
            Joint::Revolute(axis) => ("continuous", axis, None),
            Joint::Prismatic(axis) => {
                let limits = stroke.map_or([-FAR, FAR], |stroke| [0.0, stroke]);
                ("prismatic", axis, Some(limits))
            }
            // No rig has one.
            Joint::Free => ("floating", Vec3::zeros(), None),
        };
        let parent = body
            .parent
            .map(|parent| &rig.mechanism.tree.bodies()[parent]);
        let parent = parent.map_or("world".into(), |parent| plain(&parent.name));
        let name = plain(&body.name);
        self.open_joint(&name, kind, &parent, &body.placement.position);
        let axis = vector(&axis);
        self.xml.leaf(format_args!(r#"axis xyz="{axis}""#));
        if let Some(limits) = limits {
            let ([lower, upper], [effort, velocity]) = (limits.map(number), NO_LIMIT.map(number));
            self.xml.leaf(format_args!(
                r#"limit lower="{lower}" upper="{upper}" effort="{effort}" velocity="{velocity}""#
            ));
        }
        let parts = &rig.mechanism.joints[index];
        let of = &self.robot.leg;
        let [damping, friction] = match leg {
            Some(_) => [of.viscous_friction, of.coulomb_friction],
            None => [parts.damping, parts.friction],
        };
        if damping != 0.0 || friction != 0.0 {
            let [damping, friction] = [damping, friction].map(number);
            let losses = format_args!(r#"dynamics damping="{damping}" friction="{friction}""#);
            self.xml.leaf(losses);
        }
        self.xml.close("joint");
    }

    fn open_joint(&mut self, name: &str, kind: &str, parent: &str, at: &Vec3) {
        let at = vector(at);
        self.xml
            .open(format_args!(r#"joint name="{name}" type="{kind}""#));
        self.xml.leaf(format_args!(r#"parent link="{parent}""#));
        self.xml.leaf(format_args!(r#"child link="{name}""#));
        self.xml.leaf(format_args!(r#"origin xyz="{at}""#));
    }

    /// The foot of a leg: a link without mass that is fixed to it.
    fn foot(&mut self, leg: usize) {
        let rig = self.rig;
        let point = &rig.mechanism.points[leg];
        let radius = positive_or(point.radius, POINT);
        let name = foot_frame(leg);
        let (seen, touches) = (radius.max(0.03 * rig.radius), radius);
        self.xml.open(format_args!(r#"link name="{name}""#));
        // Without it, MuJoCo gives the sphere the mass of water.
        self.inertial(0.0, &Vec3::zeros(), &Matrix3::zeros());
        for (use_, radius) in [("visual", seen), ("collision", touches)] {
            self.xml.open(use_);
            if use_ == "collision" && radius > point.radius {
                // A foot that is a point is a sphere that ends there.
                let back = vector(&(point.center.normalize() * (point.radius - radius)));
                self.xml.leaf(format_args!(r#"origin xyz="{back}""#));
            }
            let radius = number(radius);
            self.geometry(format_args!(r#"sphere radius="{radius}""#));
            if use_ == "visual" {
                self.xml.leaf(r#"material name="foot""#);
            }
            self.xml.close(use_);
        }
        self.xml.close("link");
        let carrier = plain(&rig.mechanism.tree.bodies()[point.body].name);
        self.open_joint(&name, "fixed", &carrier, &point.center);
        self.xml.close("joint");
    }
}

/// The tip of a leg (m) in its body's frame.
fn tip(point: &ContactPoint, radius: f64) -> Vec3 {
    point.center.normalize() * radius
}

/// What of `robot` the file does not say, a line each.
fn missing(robot: &Robot) -> [Option<String>; 7] {
    let leg = &robot.leg;
    let slope = robot.ground.slope;
    [
        Some("the drives of the legs, their delays, and what holds them retracted".into()),
        Some("the ground, its friction and its restitution".into()),
        (slope.abs() > 0.0 && slope.abs() < FRAC_PI_2).then(|| format!("its slope of {slope} rad")),
        leg.return_spring.map(|_| "the return springs".into()),
        robot
            .boom
            .filter(|boom| boom.flex.is_some())
            .map(|_| "the stiffness of the boom, which bends at the joint in its middle".into()),
        (robot.environment.drag > 0.0).then(|| "the drag of the air".into()),
        Some(format!(
            "links without mass, such as feet, have {LEAST_MASS} kg"
        )),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn robot(name: &str) -> Robot {
        saltus_robot::resolve(name, &[]).expect("a built-in robot")
    }

    #[test]
    fn every_body_has_a_link_and_a_joint() {
        for name in ["rats-planar", "rats-boom", "rats-run", "spring-hopper"] {
            let robot = robot(name);
            let rig = Rig::new(&robot, &[]).expect("a rig");
            let text = urdf(&robot).expect("a file");
            let bodies = rig.mechanism.tree.bodies();
            assert_eq!(
                text.matches("<joint ").count(),
                bodies.len() + rig.legs.len()
            );
            assert_eq!(
                text.matches("<link ").count(),
                bodies.len() + rig.legs.len() + 1
            );
            let places = bodies.iter().map(|body| {
                let joint = format!("<joint name=\"{}\"", plain(&body.name));
                text.find(&joint).expect(&joint)
            });
            assert!(places.collect::<Vec<_>>().is_sorted(), "{name}");
        }
    }

    #[test]
    fn what_is_not_expressed_is_said() {
        let boom = urdf(&robot("rats-boom")).expect("a file");
        assert!(boom.contains("- the drives of the legs"), "{boom}");
        assert!(!boom.contains("drag of the air"), "{boom}");
        let windy = saltus_robot::resolve("rats-boom", &["environment.drag_per_m=0.01".into()]);
        let windy = urdf(&windy.expect("a robot")).expect("a file");
        assert!(windy.contains("- the drag of the air;"), "{windy}");
    }
}
