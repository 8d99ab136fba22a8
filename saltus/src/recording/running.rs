//! A running robot, cycle by cycle.

use std::io::Write;

use saltus_controller::run::Signals;
use saltus_gait::{Footfall, Logger, Row, Setup, instruments};

use super::body::{Moment, Sensed};
use super::course::Block;
use super::{Error, Recording};

/// Puts a run into a recording as it goes: the motion, and what its instruments measure.
#[derive(Debug)]
pub struct Running<W: Write> {
    recording: Recording<W>,
    logger: Logger,
    instruments: saltus_controller::run::Instruments<f64>,
    legs: usize,
    stood: bool,
    /// Legs whose valves are held open.
    held: Vec<usize>,
    /// Rows of the logger with their times, of one cycle.
    rows: Vec<(f64, Vec<f64>)>,
}

impl<W: Write> Running<W> {
    /// Of a run as `setup` says, into a recording that has nothing yet.
    ///
    /// # Errors
    /// [`Error::Robot`] for a robot whose parts cannot be bodies, [`Error::File`] if the file takes no
    /// bytes.
    pub fn new(mut recording: Recording<W>, setup: &Setup) -> Result<Running<W>, Error> {
        let robot = &setup.robot;
        recording.robot(robot)?;
        let obstacles = setup.obstacles.iter();
        let blocks: Vec<Block> = obstacles
            .map(|o| Block {
                front: o.front,
                back: o.front + o.length,
                top: o.height,
            })
            .collect();
        recording.course(&blocks)?;
        let logger = Logger::new(robot);
        let columns = logger.columns();
        let names = columns.iter().map(String::as_str);
        recording.columns(std::iter::once("time_s").chain(names))?;
        Ok(Running {
            recording,
            logger,
            instruments: instruments(&setup.sensors()),
            legs: robot.body.legs as usize,
            stood: false,
            held: Vec::new(),
            rows: Vec::new(),
        })
    }

    /// Adds a cycle.
    ///
    /// # Errors
    /// [`Error::File`] if the file takes no bytes.
    pub fn row(&mut self, row: &Row<'_>) -> Result<(), Error> {
        let rows = &mut self.rows;
        rows.clear();
        self.logger
            .log(row, |time, values| rows.push((time, values.to_vec())));
        for (time, values) in &self.rows {
            let values = values.iter().copied();
            self.recording
                .row(*time, std::iter::once(*time).chain(values))?;
        }
        for (leg, output) in row.outputs.iter().enumerate() {
            if self.held.contains(&leg) && !output.is_on(row.time) {
                self.held.retain(|held| *held != leg);
                let open = 1e3 * (output.off - output.on);
                let text = format!("close the valve of leg {leg} after {open:.1} ms");
                self.recording.event(row.time, &text)?;
            }
        }
        if let Some(leg) = row.action.leg {
            let open = row.action.valve_open;
            let text = if open.is_finite() {
                format!("fire leg {leg} for {:.1} ms", 1e3 * open)
            } else {
                self.held.push(leg as usize);
                format!("open the valve of leg {leg}")
            };
            self.recording.event(row.time, &text)?;
        }
        if row.stands != self.stood {
            self.stood = row.stands;
            let text = if row.stands {
                "stands still"
            } else {
                "goes on"
            };
            self.recording.event(row.time, text)?;
        }
        self.moment(row)
    }

    fn moment(&mut self, row: &Row<'_>) -> Result<(), Error> {
        let one = &self.instruments;
        let counts = row.readings.fine_accelerometer;
        let [ahead, up] = counts.map(|count| f64::from(count) * one.fine_accelerometer);
        let sensed = Sensed {
            // The gyros measure about the axle alone, the accelerometer across it.
            rate: [0.0, Signals::new(*one, &[1.0]).gyro(&row.readings), 0.0],
            force: [ahead, 0.0, up],
        };
        // Of the cycle itself; what comes before it are ends of openings.
        let valves = self.rows.last().map_or(&[][..], |(_, values)| values);
        let valves: Vec<bool> = valves.iter().take(self.legs).map(|x| *x > 0.5).collect();
        let on_feet = row
            .contacts
            .iter()
            .filter(|contact| contact.point < self.legs);
        let forces: Vec<(usize, [f64; 3])> = on_feet
            .clone()
            .map(|contact| (contact.point, contact.force.into()))
            .collect();
        let slip = on_feet.map(|contact| contact.slip[0]);
        let slip = slip.fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
        self.recording.moment(&Moment {
            time: row.time,
            coordinates: row.coordinates,
            velocities: row.velocities,
            base: 0.0,
            pressures: row.pressures,
            valves: &valves,
            slip,
            forces: &forces,
            sensed: Some(sensed),
        })
    }

    /// Adds that a foot comes down.
    ///
    /// # Errors
    /// [`Error::File`] if the file takes no bytes.
    pub fn footfall(&mut self, footfall: &Footfall) -> Result<(), Error> {
        let text = format!("touch-down of leg {}", footfall.leg);
        self.recording.event(footfall.time, &text)
    }

    /// Ends the file, and gives back where it went.
    ///
    /// # Errors
    /// [`Error::File`] if the file takes no bytes.
    pub fn finish(self) -> Result<W, Error> {
        self.recording.finish()
    }
}
