//! The whole robot in space: a tree of bodies with contact, friction and slip, derived without
//! `lagrangian` and `ballistic`.

pub mod chain;
mod complementarity;
mod contact;
mod error;
mod feeding;
mod gas;
mod jump;
mod lemke;
mod linear;
mod machine;
mod mechanism;
mod mjcf;
mod mode;
mod rig;
mod shot;
mod sim;
mod spatial;
mod step;
mod tree;
mod urdf;
mod xml;

pub use contact::{ContactPoint, Friction, Material, Surface, Travel};
pub use error::SimError;
pub use jump::{End, Plan, Report, Sample};
pub use mechanism::{Drag, JointParts, LegPart, Mechanism};
pub use mjcf::mjcf;
pub use rig::Rig;
pub use saltus_robot::{Launch, LiftOff, Outcome};
pub use shot::{Firing, Flown, Shot, TICK};
pub use sim::{
    Account, Contact, Event, Happening, Ledger, LegStart, Pause, Settings, Sim, Stepping, Watch,
};
pub use spatial::{Inertia, Motion, Vec3, Wrench};
pub use tree::{Body, Joint, Placement, Pose, Tree};
pub use urdf::{foot_frame, link, urdf};
