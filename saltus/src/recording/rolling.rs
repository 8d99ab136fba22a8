//! A ball that rolls, cycle by cycle.

use std::io::Write;

use saltus_gait::space::{Ball, Measured, Roll};
use saltus_telemetry::{Definition, Topic, message};

use super::body::{Moment, Sensed, WORLD};
use super::{Error, Recording, nanoseconds};

/// The frame in which the robot takes itself to be.
const ESTIMATE: &str = "estimate";

/// Puts the run of a ball into a recording as it goes: the motion, what its sensors say, and what it makes of them.
#[derive(Debug)]
pub struct Rolling<W: Write> {
    recording: Recording<W>,
    disc: Topic,
    estimate: Topic,
    legs: usize,
    measured: Measured,
    /// Feet on the ground in the last cycle.
    stood: u64,
    coordinates: Vec<f64>,
    velocities: Vec<f64>,
}

/// The type of messages on `/disc`: how the plane lies in which the robot rolls.
fn disc() -> Definition {
    let fields = [
        ("float64", "lean_rad"),
        ("float64", "rate_rad_s"),
        ("float64", "roll_rad"),
        ("float64", "roll_rate_rad_s"),
        ("float64", "heading_rad"),
        ("float64", "heading_rate_rad_s"),
        ("float64", "aside_m"),
        ("int32", "stations_passed"),
        ("float64[3]", "axis"),
    ];
    Definition::own("saltus_msgs/msg/Disc", fields)
}

/// The type of messages on `/estimate`: what the robot takes its motion for.
fn estimate() -> Definition {
    let fields = [
        ("float64[3]", "place_m"),
        ("float64[4]", "quaternion_wxyz"),
        ("float64[3]", "velocity_m_s"),
        ("float64[3]", "spin_rad_s"),
    ];
    Definition::own("saltus_msgs/msg/Estimate", fields)
}

impl<W: Write> Rolling<W> {
    /// Of a run as `setup` says, into a recording that has nothing yet. The run has to tell the forces on the feet in every
    /// cycle: [`Roll::forces_every`] is 1.
    ///
    /// # Errors
    /// [`Error::Robot`] for a robot whose parts cannot be bodies, [`Error::File`] if the file takes no bytes.
    pub fn new(mut recording: Recording<W>, setup: &Roll) -> Result<Rolling<W>, Error> {
        let legs = setup.robot.body.legs as usize;
        recording.robot(&setup.robot)?;
        recording.course(&[])?;
        let measured = Measured::new(legs);
        let columns = measured.columns();
        recording.columns(columns.iter().map(String::as_str))?;
        Ok(Rolling {
            disc: recording.writer.channel("/disc", &disc())?,
            estimate: recording.writer.channel("/estimate", &estimate())?,
            recording,
            legs,
            measured,
            stood: u64::MAX,
            coordinates: Vec::new(),
            velocities: Vec::new(),
        })
    }

    /// Adds a cycle.
    ///
    /// # Errors
    /// [`Error::File`] if the file takes no bytes.
    pub fn row(&mut self, ball: &Ball) -> Result<(), Error> {
        for firing in &ball.fired {
            let text = format!("fire leg {} for {:.1} ms", firing.leg, 1e3 * firing.open);
            self.recording.event(ball.time, &text)?;
        }
        let came_down = ball.touching & !self.stood;
        self.stood = ball.touching;
        for leg in (0..self.legs).filter(|leg| came_down >> leg & 1 == 1) {
            let text = format!("touch-down of leg {leg}");
            self.recording.event(ball.time, &text)?;
        }
        let measured = self.measured.row(ball);
        self.recording.row(ball.time, measured)?;
        self.moment(ball)?;
        self.lying(ball)?;
        self.estimate(ball)
    }

    fn moment(&mut self, ball: &Ball) -> Result<(), Error> {
        // The coordinates of a body that moves freely, then those of its legs.
        self.coordinates.clear();
        self.coordinates
            .extend(ball.place.iter().chain(&ball.attitude));
        self.coordinates.extend(&ball.extensions);
        self.velocities.clear();
        self.velocities
            .extend(ball.velocity.iter().chain(&ball.spin));
        self.velocities.extend(&ball.extension_rates);
        self.recording.moment(&Moment {
            time: ball.time,
            coordinates: &self.coordinates,
            velocities: &self.velocities,
            base: 0.0,
            pressures: &[],
            valves: &self.measured.valves(ball.time),
            slip: f64::NAN,
            forces: &ball.forces,
            sensed: ball.sensed.map(|[rate, force]| Sensed { rate, force }),
        })
    }

    fn lying(&mut self, ball: &Ball) -> Result<(), Error> {
        let (out, l) = (&mut self.recording.encoder, &ball.rolling);
        out.clear();
        for x in [
            l.lean,
            l.rate,
            l.roll,
            l.roll_rate,
            l.heading,
            l.heading_rate,
            ball.aside,
        ] {
            out.f64(x);
        }
        out.i32(ball.passed).f64s(&ball.axis);
        let ns = nanoseconds(ball.time);
        Ok(self.recording.writer.write(self.disc, ns, out.bytes())?)
    }

    fn estimate(&mut self, ball: &Ball) -> Result<(), Error> {
        let Some(estimate) = &ball.estimate else {
            return Ok(());
        };
        let ns = nanoseconds(ball.time);
        let (recording, attitude) = (&mut self.recording, estimate.attitude.0);
        let out = &mut recording.encoder;
        out.clear().f64s(&estimate.place).f64s(&attitude);
        out.f64s(&estimate.velocity).f64s(&estimate.spin);
        recording.writer.write(self.estimate, ns, out.bytes())?;
        let [w, x, y, z] = attitude;
        let Some(body) = &recording.body else {
            return Ok(());
        };
        let frame = message::Transform {
            parent: WORLD,
            child: ESTIMATE,
            translation: estimate.place,
            rotation: [x, y, z, w],
        };
        message::transforms(out, ns, &[frame]);
        Ok(recording
            .writer
            .write(body.transforms_topic(), ns, out.bytes())?)
    }

    /// Ends the file, and gives back where it went.
    ///
    /// # Errors
    /// [`Error::File`] if the file takes no bytes.
    pub fn finish(self) -> Result<W, Error> {
        self.recording.finish()
    }
}
