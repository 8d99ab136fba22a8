//! Logs as MCAP files of ROS 2 messages: what Foxglove, PlotJuggler, rerun and ROS read.
//!
//! A file says how its messages are laid out: each channel has a definition in the words of ROS 2
//! (`ros2msg`), and messages are bytes in CDR. [`Writer`] writes such files, without compression and
//! with the same bytes for the same calls. [`read`](read()) reads them and those of others, compressed by zstd or
//! LZ4, and [`Schema`] finds numbers in any message by the definition that the file has.
//!
//! Times are in ns, numbers are what the definition says. Nothing here knows robots.
//!
//! ```
//! use saltus_telemetry::{Definition, Encoder, Event, Path, Schema, Writer, message, read};
//!
//! let mut bytes = Vec::new();
//! let mut writer = Writer::new(&mut bytes, "example 1.0")?;
//! let channel = writer.channel("/joint_states", &Definition::JOINT_STATE)?;
//! let mut encoder = Encoder::new();
//! message::joint_state(&mut encoder, 1_500, &message::Joints { names: &["knee"], position: &[0.25], ..Default::default() });
//! writer.write(channel, 1_500, encoder.bytes())?;
//! writer.finish()?;
//!
//! let path: Path = "/joint_states.position[knee]".parse()?;
//! read(bytes.as_slice(), &mut |event| {
//!     if let Event::Message { channel, data, .. } = event {
//!         let text = &channel.schema.as_ref().expect("a schema").text;
//!         let selection = Schema::parse("sensor_msgs/msg/JointState", text)?.select(&[&path.fields])?;
//!         let mut found = [f64::NAN];
//!         selection.find(data, &mut found)?;
//!         assert_eq!(found, [0.25]);
//!     }
//!     Ok(())
//! })?;
//! # Ok::<(), saltus_telemetry::Error>(())
//! ```

mod cdr;
mod definition;
mod error;
mod file;
pub mod message;
mod path;
mod schema;
mod select;

pub use cdr::Encoder;
pub use definition::Definition;
pub use error::Error;
pub use file::{Channel, Event, FileSchema, Topic, Writer, is_mcap, read};
pub use path::{Field, Index, Path};
pub use schema::Schema;
pub use select::Selection;
