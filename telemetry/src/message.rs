//! The standard messages, field by field. Times are in ns from the clock's zero.

use crate::Encoder;

/// `sensor_msgs/msg/JointState`; a list that is empty says nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Joints<'a> {
    /// Names.
    pub names: &'a [&'a str],
    /// Positions (rad or m).
    pub position: &'a [f64],
    /// Velocities (rad/s or m/s).
    pub velocity: &'a [f64],
    /// Efforts (N m or N).
    pub effort: &'a [f64],
}

/// Where a frame is in another.
#[derive(Clone, Copy, Debug)]
pub struct Transform<'a> {
    /// The frame in which it is given.
    pub parent: &'a str,
    /// The frame.
    pub child: &'a str,
    /// Its origin (m).
    pub translation: [f64; 3],
    /// Its axes as a unit quaternion x, y, z, w.
    pub rotation: [f64; 4],
}

/// `sensor_msgs/msg/Imu`.
#[derive(Clone, Copy, Debug)]
pub struct Imu {
    /// Axes of the sensor as a unit quaternion x, y, z, w.
    pub orientation: [f64; 4],
    /// Angular rates (rad/s) about its axes.
    pub angular_velocity: [f64; 3],
    /// Specific force (m/s²) along its axes; none is told as the convention of ROS has it.
    pub linear_acceleration: Option<[f64; 3]>,
}

/// A block to draw.
#[derive(Clone, Copy, Debug)]
pub struct Block {
    /// Its centre (m), in the world.
    pub center: [f64; 3],
    /// Its lengths (m).
    pub size: [f64; 3],
    /// Its axes as a unit quaternion x, y, z, w.
    pub rotation: [f64; 4],
    /// Red, green, blue and opacity, from 0 to 1.
    pub color: [f32; 4],
}

/// Level of a line of a log: an information.
pub const INFO: u8 = 20;

/// Nanoseconds of a second.
const SECOND: u64 = 1_000_000_000;
/// Axes that are those of the frame around.
const STRAIGHT: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

/// `builtin_interfaces/msg/Time`; one that its 32 bits do not hold is the last that they hold.
pub fn time(out: &mut Encoder, ns: u64) {
    out.i32(i32::try_from(ns / SECOND).unwrap_or(i32::MAX));
    // The remainder is below 1e9.
    out.u32(u32::try_from(ns % SECOND).unwrap_or_default());
}

/// `std_msgs/msg/Header`.
pub fn header(out: &mut Encoder, ns: u64, frame: &str) {
    time(out, ns);
    out.string(frame);
}

/// `std_msgs/msg/String`.
pub fn text(out: &mut Encoder, text: &str) {
    out.clear().string(text);
}

/// `sensor_msgs/msg/JointState`.
pub fn joint_state(out: &mut Encoder, ns: u64, joints: &Joints<'_>) {
    header(out.clear(), ns, "");
    out.length(joints.names.len());
    for name in joints.names {
        out.string(name);
    }
    out.sequence(joints.position)
        .sequence(joints.velocity)
        .sequence(joints.effort);
}

/// `tf2_msgs/msg/TFMessage`.
pub fn transforms(out: &mut Encoder, ns: u64, all: &[Transform<'_>]) {
    out.clear().length(all.len());
    for one in all {
        header(out, ns, one.parent);
        out.string(one.child)
            .f64s(&one.translation)
            .f64s(&one.rotation);
    }
}

/// `sensor_msgs/msg/Imu`, of unknown covariances.
pub fn imu(out: &mut Encoder, ns: u64, frame: &str, imu: &Imu) {
    const UNKNOWN: [f64; 9] = [0.0; 9];
    header(out.clear(), ns, frame);
    out.f64s(&imu.orientation).f64s(&UNKNOWN);
    out.f64s(&imu.angular_velocity).f64s(&UNKNOWN);
    let mut covariance = UNKNOWN;
    if imu.linear_acceleration.is_none() {
        covariance[0] = -1.0;
    }
    out.f64s(&imu.linear_acceleration.unwrap_or_default())
        .f64s(&covariance);
}

/// `geometry_msgs/msg/WrenchStamped`: a force (N) in the axes and at the origin of `frame`.
pub fn wrench(out: &mut Encoder, ns: u64, frame: &str, force: [f64; 3]) {
    header(out.clear(), ns, frame);
    out.f64s(&force).f64s(&[0.0; 3]);
}

/// `rcl_interfaces/msg/Log`.
pub fn log(out: &mut Encoder, ns: u64, level: u8, name: &str, text: &str) {
    time(out.clear(), ns);
    out.u8(level).string(name).string(text);
    out.string("").string("").u32(0);
}

/// `visualization_msgs/msg/MarkerArray`: cubes in `frame`.
pub fn blocks(out: &mut Encoder, ns: u64, frame: &str, blocks: &[Block]) {
    const CUBE: i32 = 1;
    out.clear().length(blocks.len());
    for (id, block) in (0..).zip(blocks) {
        header(out, ns, frame);
        out.string("course").i32(id).i32(CUBE).i32(0);
        out.f64s(&block.center)
            .f64s(&block.rotation)
            .f64s(&block.size);
        for part in block.color {
            out.f32(part);
        }
        // Lifetime without end; fixed in its frame's place of that time.
        out.i32(0).u32(0).u8(0);
        out.length(0).length(0).string("");
        // No texture: an image without name, format and bytes.
        header(out, 0, "");
        out.string("").length(0).length(0);
        out.string("").string("");
        // No mesh.
        out.string("").length(0).u8(0);
    }
}

impl Default for Imu {
    fn default() -> Imu {
        Imu {
            orientation: STRAIGHT,
            angular_velocity: [0.0; 3],
            linear_acceleration: None,
        }
    }
}
