//! Motions as MCAP files, which Foxglove, PlotJuggler, rerun and ROS 2 open.
//!
//! A [`Recording`] has the robot's description (URDF), where its frames are, its joints, what an
//! inertial sensor on the wheel measures, its legs, the ground's reaction, events and the course;
//! and the columns of measured data, as [`experiment`](crate::experiment) reads them. Times are in
//! ns from 0, simulated. The same motion gives the same bytes.
//!
//! ```
//! use saltus::recording::{Origin, Recording};
//! use saltus::sim_check::{Plan, Rig};
//! use saltus::{Launch, Robot};
//!
//! let robot = Robot::rats_planar();
//! let launch = Launch::at_firing(5.0, -0.1, 0.1);
//! let report = Rig::new(&robot, &[])?.jump(&launch, &Plan::default())?;
//! let mut bytes = Vec::new();
//! let mut recording = Recording::new(&mut bytes, &Origin { command: "example", seed: None, robot: Some(&robot) })?;
//! recording.robot(&robot)?;
//! recording.jump(&report, &saltus::recording::Flown { valve_open: 0.1, ..Default::default() })?;
//! recording.finish()?;
//! assert!(saltus::telemetry::is_mcap(&bytes));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod body;
mod course;
mod jump;
mod measured;
mod rolling;
mod running;

use std::collections::BTreeMap;
use std::io::Write;

use hmac_sha256::Hash;
use saltus_robot::Robot;
use saltus_sim_check::SimError;
use saltus_telemetry::{Definition, Encoder, Topic, Writer, message};

use body::Body;

pub use crate::origin::Origin;
pub use body::Moment;
pub use course::Block;
pub use jump::Flown;
pub use measured::MEASURED;
pub use rolling::Rolling;
pub use running::Running;

/// Why a motion could not be recorded.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The file takes no bytes.
    #[error(transparent)]
    File(#[from] saltus_telemetry::Error),
    /// The robot is none of bodies.
    #[error(transparent)]
    Robot(#[from] SimError),
}

/// A recording on its way to a file.
#[derive(Debug)]
pub struct Recording<W: Write> {
    writer: Writer<W>,
    encoder: Encoder,
    body: Option<Body>,
    measured: Option<Topic>,
    events: Option<Topic>,
}

impl<W: Write> Recording<W> {
    /// Begins a recording in `out`.
    ///
    /// # Errors
    /// [`Error::File`] if `out` takes no bytes.
    pub fn new(out: W, origin: &Origin<'_>) -> Result<Recording<W>, Error> {
        let version = env!("CARGO_PKG_VERSION");
        let mut writer = Writer::new(out, &format!("saltus {version}"))?;
        let mut about = BTreeMap::new();
        let mut say = |key: &str, value: String| {
            about.insert(key.to_owned(), value);
        };
        say("command", origin.command.into());
        say("version", version.into());
        say("time", "ns from 0, simulated".into());
        if let Some(seed) = origin.seed {
            say("seed", seed.to_string());
        }
        if let Some(robot) = origin.robot {
            let text = robot.to_toml();
            say("robot", robot.name.clone());
            say("robot_sha256", hex(&Hash::hash(text.as_bytes())));
            writer.attach("robot.toml", "application/toml", text.as_bytes())?;
        }
        writer.metadata("saltus", about)?;
        Ok(Recording {
            writer,
            encoder: Encoder::new(),
            body: None,
            measured: None,
            events: None,
        })
    }

    /// Adds the description of `robot`, whose motion follows.
    ///
    /// # Errors
    /// [`Error::Robot`] for a robot whose parts cannot be bodies, [`Error::File`] as before.
    pub fn robot(&mut self, robot: &Robot) -> Result<(), Error> {
        let topic = self
            .writer
            .channel("/robot_description", &Definition::STRING)?;
        message::text(&mut self.encoder, &saltus_sim_check::urdf(robot)?);
        self.writer.write(topic, 0, self.encoder.bytes())?;
        self.body = Some(Body::new(&mut self.writer, robot)?);
        Ok(())
    }

    /// Adds an event at a time (s), as a line of a log.
    ///
    /// # Errors
    /// [`Error::File`] if the file takes no bytes.
    pub fn event(&mut self, time: f64, text: &str) -> Result<(), Error> {
        let topic = match self.events {
            Some(topic) => topic,
            None => *self
                .events
                .insert(self.writer.channel("/events", &Definition::LOG)?),
        };
        let ns = nanoseconds(time);
        message::log(&mut self.encoder, ns, message::INFO, "saltus", text);
        Ok(self.writer.write(topic, ns, self.encoder.bytes())?)
    }

    /// Adds the robot at an instant; without a [`robot`](Recording::robot) nothing.
    ///
    /// # Errors
    /// [`Error::File`] if the file takes no bytes.
    pub fn moment(&mut self, moment: &Moment<'_>) -> Result<(), Error> {
        if let Some(body) = &mut self.body {
            body.write(&mut self.writer, &mut self.encoder, moment)?;
        }
        Ok(())
    }

    /// Ends the file, and gives back where it went.
    ///
    /// # Errors
    /// [`Error::File`] if the file takes no bytes.
    pub fn finish(self) -> Result<W, Error> {
        Ok(self.writer.finish()?)
    }
}

/// A time (s) in ns from 0; before 0 there is none.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
pub(crate) fn nanoseconds(time: f64) -> u64 {
    // A cast of what is negative, or no number, gives 0.
    (time * 1e9).round() as u64
}

fn hex(bytes: &[u8]) -> String {
    use std::fmt::Write as _;
    bytes.iter().fold(String::new(), |mut text, byte| {
        // Writing to a string does not fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}

#[cfg(test)]
mod tests;
