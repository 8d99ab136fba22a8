//! A run as its instruments log it: the columns of data of kind `run` (docs/logs.md).

use saltus_controller::run::{Instruments, Signals};
use saltus_robot::Robot;

use crate::cast::instruments;
use crate::run::{Row, Run};
use crate::world::{NEAR, Output};

/// What the sensors of a running robot measure, a row a cycle: outputs of the valves, wheel angle,
/// angles of the boom, rate of the wheel.
#[derive(Clone, Debug)]
pub struct Logger {
    instruments: Instruments<f64>,
    on_boom: bool,
    legs: usize,
    /// The outputs to the valves in the last row.
    outputs: Vec<Output>,
    /// Time (s) of the last row.
    last: f64,
}

impl Logger {
    /// The logger of `robot`.
    pub fn new(robot: &Robot) -> Logger {
        let sensors = robot.sensors.unwrap_or_default();
        let legs = robot.body.legs as usize;
        Logger {
            instruments: instruments(&sensors),
            on_boom: robot.boom.is_some(),
            legs,
            outputs: Vec::new(),
            last: f64::NEG_INFINITY,
        }
    }

    /// The columns after the time; each ends with its unit but the valves, which are 0 or 1.
    pub fn columns(&self) -> Vec<String> {
        let valves = (1..=self.legs).map(|leg| format!("valve_{leg}"));
        let boom: &[&str] = if self.on_boom {
            &["pivot_angle_rad", "radius_angle_rad"]
        } else {
            &[]
        };
        let measured = ["wheel_angle_rad", "wheel_rate_rad_s"];
        let names = measured.iter().chain(boom).map(|name| (*name).to_owned());
        valves.chain(names).collect()
    }

    /// One standard deviation (the column's unit) of the noise of a column that has noise, and the
    /// step of a column that has counts.
    pub fn errors(robot: &Robot, column: &str) -> (Option<f64>, Option<f64>) {
        let sensors = robot.sensors.unwrap_or_default();
        let one = instruments(&sensors);
        match column {
            "wheel_angle_rad" => (None, Some(one.wheel)),
            "pivot_angle_rad" => (None, Some(one.pivot)),
            "radius_angle_rad" => (None, Some(one.radius)),
            "wheel_rate_rad_s" => (Some(sensors.gyro_noise).filter(|x| *x > 0.0), None),
            _ => (None, None),
        }
    }

    /// Gives the rows of a cycle to `take`: the time (s), and a number for each column. A valve that
    /// closes between two cycles has a row of its own, in which nothing else is measured: NaN.
    pub fn log(&mut self, row: &Row<'_>, mut take: impl FnMut(f64, &[f64])) {
        let mut closings: Vec<f64> = self.outputs.iter().map(|output| output.off).collect();
        closings.retain(|time| *time > self.last + NEAR && *time < row.time - NEAR);
        closings.sort_by(f64::total_cmp);
        for time in closings {
            let mut values = self.valves(time);
            values.resize(values.len() + if self.on_boom { 4 } else { 2 }, f64::NAN);
            take(time, &values);
        }
        self.last = row.time;
        self.outputs.clear();
        self.outputs.extend_from_slice(row.outputs);
        let mut values = self.valves(row.time);
        let one = &self.instruments;
        let readings = &row.readings;
        values.push(f64::from(readings.wheel) * one.wheel);
        values.push(Signals::new(*one, &[1.0]).gyro(readings));
        if self.on_boom {
            values.push(f64::from(readings.pivot) * one.pivot);
            values.push(f64::from(readings.radius) * one.radius);
        }
        take(row.time, &values);
    }

    fn valves(&self, time: f64) -> Vec<f64> {
        let outputs = self.outputs.iter();
        outputs
            .map(|output| f64::from(u8::from(output.is_on(time))))
            .collect()
    }
}

/// A whole run as its instruments log it.
#[derive(Clone, Debug)]
pub struct Logged {
    logger: Logger,
    /// Time (s) of each row.
    pub time: Vec<f64>,
    /// For each column of [`Logger::columns`] a value for each row.
    pub values: Vec<Vec<f64>>,
}

impl Logged {
    /// Of a run of `robot`, which follows it.
    pub fn new(robot: &Robot) -> Logged {
        let logger = Logger::new(robot);
        Logged {
            values: vec![Vec::new(); logger.columns().len()],
            time: Vec::new(),
            logger,
        }
    }

    /// The names of the columns.
    pub fn columns(&self) -> Vec<String> {
        self.logger.columns()
    }
}

impl Run for Logged {
    fn row(&mut self, row: &Row<'_>) {
        let (times, columns) = (&mut self.time, &mut self.values);
        self.logger.log(row, |time, values| {
            times.push(time);
            for (column, value) in columns.iter_mut().zip(values) {
                column.push(*value);
            }
        });
    }

    fn footfall(&mut self, _: &crate::run::Footfall) {}
}
