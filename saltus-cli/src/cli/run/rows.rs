//! A run as rows, written as they come.

use std::fmt::Write as _;
use std::io::{self, ErrorKind, Write};
use std::path::Path;

use saltus::gait::Row;

use crate::error::CliError;
use crate::output::{Stream, full};
use crate::session::Screen;

/// What a cycle is written with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Columns {
    /// What happens, and what the controller decides.
    Motion,
    /// That, and what the sensors say.
    Telemetry,
}

/// Where rows go.
#[derive(Debug)]
enum Sink {
    File(Stream),
    Screen(io::BufWriter<Screen>),
}

/// Rows on their way to a file or to the screen.
#[derive(Debug)]
pub(super) struct Rows {
    sink: Sink,
    line: String,
    /// What went wrong first.
    failed: Option<io::Error>,
}

impl Rows {
    /// To `path`, which `flag` names, or to the screen, under `header`.
    pub(super) fn open(
        flag: &'static str,
        path: Option<&Path>,
        header: String,
    ) -> Result<Rows, CliError> {
        let sink = match path.filter(|path| *path != Path::new("-")) {
            Some(path) => Sink::File(Stream::open(flag, path)?),
            None => Sink::Screen(io::BufWriter::new(Screen)),
        };
        let mut rows = Rows {
            sink,
            line: header,
            failed: None,
        };
        rows.send();
        Ok(rows)
    }

    /// Sends the line that `write` makes.
    pub(super) fn line(&mut self, write: impl FnOnce(&mut String)) {
        self.line.clear();
        write(&mut self.line);
        self.send();
    }

    /// Sends what is measured at a time (s); what is not is an empty cell.
    pub(super) fn measured(&mut self, time: f64, values: &[f64]) {
        self.line(|line| {
            line.push_str(&full(time));
            for value in values {
                line.push(',');
                if value.is_finite() {
                    line.push_str(&full(*value));
                }
            }
        });
    }

    /// Whether somebody still reads them.
    pub(super) fn is_open(&self) -> bool {
        self.failed.is_none()
    }

    fn send(&mut self) {
        if self.failed.is_some() {
            return;
        }
        self.line.push('\n');
        let bytes = self.line.as_bytes();
        let sent = match &mut self.sink {
            Sink::File(stream) => stream.write_all(bytes),
            Sink::Screen(screen) => screen.write_all(bytes),
        };
        self.failed = sent.err();
    }

    /// The file to publish, if there is one; that nobody reads on is no error.
    pub(super) fn finish(mut self) -> Result<Option<Stream>, CliError> {
        let failed = match (self.failed.take(), &mut self.sink) {
            (None, Sink::Screen(screen)) => screen.flush().err(),
            (failed, _) => failed,
        };
        match (failed, self.sink) {
            (Some(error), Sink::Screen(_)) if error.kind() != ErrorKind::BrokenPipe => {
                Err(CliError::write(Path::new("standard output"), error))
            }
            (_, Sink::Screen(_)) => Ok(None),
            (Some(error), Sink::File(stream)) => Err(CliError::write(stream.path(), error)),
            (None, Sink::File(stream)) => Ok(Some(stream)),
        }
    }
}

impl Columns {
    /// The names of the columns, which end with their units.
    pub(super) fn header(self, legs: usize) -> String {
        let mut text = String::from(
            "time_s,x_m,height_m,vx_m_s,vz_m_s,wheel_angle_rad,wheel_rate_rad_s,leg_in_zone,lean_rad,\
             filtered_rate_rad_s,firing_angle_rad,fired_leg,valve_open_s,stalled",
        );
        for (name, unit) in [("extension", "m"), ("pressure", "pa"), ("valve_open", "s")] {
            for leg in 0..legs {
                // Writing to a string does not fail.
                let _ = write!(text, ",{name}_{leg}_{unit}");
            }
        }
        if self == Columns::Telemetry {
            text.push_str(
                ",wheel_encoder_counts,radius_encoder_counts,pivot_encoder_counts,fine_gyro_counts,\
                 coarse_gyro_counts,fine_accelerometer_forward_counts,fine_accelerometer_up_counts,\
                 coarse_accelerometer_forward_counts,coarse_accelerometer_up_counts",
            );
        }
        text
    }

    /// Writes the cycle of `row`.
    pub(super) fn write(self, row: &Row<'_>, text: &mut String) {
        let action = &row.action;
        let number = |text: &mut String, x: f64| {
            text.push_str(&full(x));
            text.push(',');
        };
        for x in [
            row.time,
            row.axle[0],
            row.axle[1],
            row.axle_rates[0],
            row.axle_rates[1],
            row.lean,
            row.rate,
        ] {
            number(text, x);
        }
        let _ = write!(text, "{},", action.in_zone);
        for x in [action.lean, action.rate] {
            number(text, x);
        }
        if let Some(angle) = row.firing_angle() {
            text.push_str(&full(angle));
        }
        text.push(',');
        match action.leg {
            Some(leg) => {
                let _ = write!(text, "{leg},");
                if action.valve_open.is_finite() {
                    text.push_str(&full(action.valve_open));
                }
            }
            None => text.push(','),
        }
        let _ = write!(text, ",{}", action.stalled);
        let outputs = row.outputs.iter();
        let open = outputs.map(|output| output.within(row.time, row.period));
        let extensions = row.extensions.iter().copied();
        for x in extensions.chain(row.pressures.iter().copied()).chain(open) {
            text.push(',');
            text.push_str(&full(x));
        }
        if self == Columns::Telemetry {
            let r = &row.readings;
            for count in [
                r.wheel,
                r.radius,
                r.pivot,
                r.fine_gyro,
                r.coarse_gyro,
                r.fine_accelerometer[0],
                r.fine_accelerometer[1],
                r.coarse_accelerometer[0],
                r.coarse_accelerometer[1],
            ] {
                let _ = write!(text, ",{count}");
            }
        }
    }
}
