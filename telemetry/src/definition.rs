//! How messages are laid out, in the words of ROS 2.

use std::borrow::Cow;
use std::fmt::Write;

/// A message type and its definition as MCAP files hold it (`ros2msg`).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Definition {
    /// Package and name, such as `sensor_msgs/msg/Imu`.
    pub name: Cow<'static, str>,
    /// Its fields, and those of the types that it uses.
    pub text: Cow<'static, str>,
}

/// A type of ROS 2 Jazzy, whose text stands in the folder `definitions`.
macro_rules! standard {
    ($package:literal, $name:literal) => {
        Definition {
            name: Cow::Borrowed(concat!($package, "/msg/", $name)),
            text: Cow::Borrowed(include_str!(concat!(
                "../definitions/",
                $package,
                "_",
                $name,
                ".msg"
            ))),
        }
    };
}

impl Definition {
    /// A text.
    pub const STRING: Definition = standard!("std_msgs", "String");
    /// Where frames are in others.
    pub const TRANSFORMS: Definition = standard!("tf2_msgs", "TFMessage");
    /// Positions, velocities and efforts of joints.
    pub const JOINT_STATE: Definition = standard!("sensor_msgs", "JointState");
    /// What an inertial measurement unit says.
    pub const IMU: Definition = standard!("sensor_msgs", "Imu");
    /// A force and a torque.
    pub const WRENCH: Definition = standard!("geometry_msgs", "WrenchStamped");
    /// A line of a program's log.
    pub const LOG: Definition = standard!("rcl_interfaces", "Log");
    /// Things to draw.
    pub const MARKERS: Definition = standard!("visualization_msgs", "MarkerArray");

    /// All that are standard.
    pub const STANDARD: [Definition; 7] = [
        Definition::STRING,
        Definition::TRANSFORMS,
        Definition::JOINT_STATE,
        Definition::IMU,
        Definition::WRENCH,
        Definition::LOG,
        Definition::MARKERS,
    ];

    /// A type of one's own, `name` as in `saltus_msgs/msg/Leg`, with `fields`: pairs of a primitive
    /// type and a name.
    pub fn own<'f>(
        name: &'static str,
        fields: impl IntoIterator<Item = (&'f str, &'f str)>,
    ) -> Definition {
        let mut text = String::new();
        for (kind, field) in fields {
            // Writing to a string does not fail.
            let _ = writeln!(text, "{kind} {field}");
        }
        Definition {
            name: name.into(),
            text: text.into(),
        }
    }
}
