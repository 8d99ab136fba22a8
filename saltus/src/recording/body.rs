//! The robot as it moves: frames, joints, sensor, legs and the ground's reaction.

use std::f64::consts::PI;
use std::io::Write;

use saltus_robot::Robot;
use saltus_sim_check::{Joint, Pose, Rig, Vec3, foot_frame, link};
use saltus_telemetry::message::{self, Imu, Joints, Transform};
use saltus_telemetry::{Definition, Encoder, Topic, Writer};

use super::{Error, nanoseconds};

/// The frame in which everything stands.
pub(super) const WORLD: &str = "world";

/// The robot at an instant.
#[derive(Clone, Copy, Debug, Default)]
pub struct Moment<'a> {
    /// Time (s).
    pub time: f64,
    /// Coordinates of its [`Rig`].
    pub coordinates: &'a [f64],
    /// Velocities of its rig.
    pub velocities: &'a [f64],
    /// Height (m) of what it stands on above the ground of the world.
    pub base: f64,
    /// Chamber pressure of each leg (Pa, absolute); NaN where it is not known.
    pub pressures: &'a [f64],
    /// Whether the valve of each leg is commanded open.
    pub valves: &'a [bool],
    /// Slip speed of the foot that bears (m/s), along the travel.
    pub slip: f64,
    /// The ground's force on feet, each with its leg (N, world axes).
    pub forces: &'a [(usize, [f64; 3])],
    /// What the inertial sensor says; none: the truth, without accelerations.
    pub sensed: Option<Sensed>,
}

/// What an inertial sensor on the wheel, or on a ball's body, says.
#[derive(Clone, Copy, Debug)]
pub struct Sensed {
    /// Rates (rad/s) about the wheel's axes; one that measures about the axle alone says 0 about the others.
    pub rate: [f64; 3],
    /// Specific force (m/s²) along them; x forwards and z up at lean 0.
    pub force: [f64; 3],
}

/// A robot with the channels that its motion goes to.
#[derive(Debug)]
pub(super) struct Body {
    rig: Rig,
    /// Frames and joints of the bodies.
    links: Vec<String>,
    feet: Vec<String>,
    /// Area of a bore (m²) and pressure outside (Pa); none for legs without a chamber.
    chamber: Option<[f64; 2]>,
    pose: Pose,
    topics: Topics,
}

#[derive(Debug)]
struct Topics {
    transforms: Topic,
    joints: Topic,
    imu: Topic,
    legs: Topic,
    reaction: Topic,
}

/// The type of messages on `/leg`: a number for each leg, and that of the foot that bears.
fn legs() -> Definition {
    let fields = [
        ("float64[]", "extension_m"),
        ("float64[]", "extension_rate_m_s"),
        ("float64[]", "pressure_pa"),
        ("float64[]", "drive_force_n"),
        ("uint8[]", "valve_open"),
        ("float64", "slip_speed_m_s"),
    ];
    Definition::own("saltus_msgs/msg/Leg", fields)
}

impl Body {
    pub(super) fn new<W: Write>(writer: &mut Writer<W>, robot: &Robot) -> Result<Body, Error> {
        let rig = Rig::new(robot, &[])?;
        let bodies = rig.mechanism.tree.bodies().iter();
        let links = bodies.map(|body| link(&body.name)).collect();
        let feet = (0..rig.legs.len()).map(foot_frame).collect();
        let chamber = robot.leg.cylinder().map(|cylinder| {
            let area = PI * cylinder.bore * cylinder.bore / 4.0;
            [area, robot.environment.ambient.0]
        });
        let topics = Topics {
            transforms: writer.channel("/tf", &Definition::TRANSFORMS)?,
            joints: writer.channel("/joint_states", &Definition::JOINT_STATE)?,
            imu: writer.channel("/imu", &Definition::IMU)?,
            legs: writer.channel("/leg", &legs())?,
            reaction: writer.channel("/ground_reaction", &Definition::WRENCH)?,
        };
        Ok(Body {
            rig,
            links,
            feet,
            chamber,
            pose: Pose::default(),
            topics,
        })
    }

    pub(super) fn rig(&self) -> &Rig {
        &self.rig
    }

    /// Where frames go.
    pub(super) fn transforms_topic(&self) -> Topic {
        self.topics.transforms
    }

    pub(super) fn write<W: Write>(
        &mut self,
        writer: &mut Writer<W>,
        out: &mut Encoder,
        moment: &Moment<'_>,
    ) -> Result<(), Error> {
        let ns = nanoseconds(moment.time);
        let tree = &self.rig.mechanism.tree;
        self.pose.set(tree, moment.coordinates, moment.velocities);
        let transforms = self.transforms(moment);
        message::transforms(out, ns, &transforms);
        writer.write(self.topics.transforms, ns, out.bytes())?;

        // A body that moves freely is none of the joints: `/tf` says where it is.
        let (first, first_rate) = match tree.bodies().first() {
            Some(body) if body.joint == Joint::Free => (7, 6),
            _ => (0, 0),
        };
        let jointed = self.links.len() - (moment.coordinates.len() - first);
        let names: Vec<&str> = self.links[jointed..].iter().map(String::as_str).collect();
        let joints = Joints {
            names: &names,
            position: &moment.coordinates[first..],
            velocity: &moment.velocities[first_rate..],
            effort: &[],
        };
        message::joint_state(out, ns, &joints);
        writer.write(self.topics.joints, ns, out.bytes())?;

        message::imu(out, ns, &self.links[self.rig.wheel], &self.imu(moment));
        writer.write(self.topics.imu, ns, out.bytes())?;

        self.legs(out, moment);
        writer.write(self.topics.legs, ns, out.bytes())?;

        for (leg, force) in moment.forces {
            let axes = &self.pose.frames[self.rig.legs[*leg]].rotation;
            let force = axes.transpose() * Vec3::from(*force);
            message::wrench(out, ns, &self.feet[*leg], force.into());
            writer.write(self.topics.reaction, ns, out.bytes())?;
        }
        Ok(())
    }

    /// Where each link is in the one that carries it.
    fn transforms(&self, moment: &Moment<'_>) -> Vec<Transform<'_>> {
        let tree = &self.rig.mechanism.tree;
        let bodies = tree.bodies().iter().enumerate().map(|(k, body)| {
            let first = tree.coordinate_of(k);
            let q = moment.coordinates[first];
            let mut at = body.placement.position;
            let mut rotation = [0.0, 0.0, 0.0, 1.0];
            match body.joint {
                Joint::Prismatic(axis) => at += axis * q,
                Joint::Revolute(axis) => {
                    let (sin, cos) = (0.5 * q).sin_cos();
                    rotation = [axis.x * sin, axis.y * sin, axis.z * sin, cos];
                }
                Joint::Free => {
                    let q = &moment.coordinates[first..first + 7];
                    at += Vec3::new(q[0], q[1], q[2]);
                    rotation = [q[4], q[5], q[6], q[3]];
                }
            }
            if body.parent.is_none() {
                at.z += moment.base;
            }
            Transform {
                parent: body.parent.map_or(WORLD, |parent| &self.links[parent]),
                child: &self.links[k],
                translation: at.into(),
                rotation,
            }
        });
        let points = self.rig.mechanism.points.iter().zip(&self.feet);
        let feet = points.map(|(point, foot)| Transform {
            parent: &self.links[point.body],
            child: foot,
            translation: point.center.into(),
            rotation: [0.0, 0.0, 0.0, 1.0],
        });
        bodies.chain(feet).collect()
    }

    fn imu(&self, moment: &Moment<'_>) -> Imu {
        let wheel = self.rig.wheel;
        let frame = &self.pose.frames[wheel];
        let truth = frame.rotation.transpose() * self.pose.velocities[wheel].angular;
        let orientation = frame.quaternion();
        match moment.sensed {
            None => Imu {
                orientation,
                angular_velocity: truth.into(),
                linear_acceleration: None,
            },
            Some(Sensed { rate, force }) => Imu {
                orientation,
                angular_velocity: rate,
                linear_acceleration: Some(force),
            },
        }
    }

    fn legs(&self, out: &mut Encoder, moment: &Moment<'_>) {
        let (rig, tree) = (&self.rig, &self.rig.mechanism.tree);
        let count = rig.legs.len();
        let pick = |list: &[f64], at: usize| list.get(at).copied().unwrap_or(f64::NAN);
        let pressure = |k: usize| pick(moment.pressures, k);
        let force = |k: usize| {
            let [area, outside] = self.chamber.unwrap_or([f64::NAN; 2]);
            (pressure(k) - outside) * area
        };
        let columns: [&dyn Fn(usize) -> f64; 4] = [
            &|k| pick(moment.coordinates, rig.extension_coordinate(k)),
            &|k| pick(moment.velocities, tree.velocity_of(rig.legs[k])),
            &pressure,
            &force,
        ];
        out.clear();
        for column in columns {
            out.length(count);
            for leg in 0..count {
                out.f64(column(leg));
            }
        }
        out.length(count);
        for leg in 0..count {
            out.u8(u8::from(moment.valves.get(leg).is_some_and(|open| *open)));
        }
        out.f64(moment.slip);
    }
}
