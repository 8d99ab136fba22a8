//! Measured data, column by column, as [`experiment`](crate::experiment) reads them back.

use std::io::Write;

use saltus_telemetry::Definition;

use super::{Error, Recording, nanoseconds};

/// The topic of measured data: a field for each column, with the column's name.
pub const MEASURED: &str = "/measured";

impl<W: Write> Recording<W> {
    /// Adds the channel of measured data with these `columns`, whose names end with their unit; the
    /// first is `time_s` where there is a clock.
    ///
    /// # Errors
    /// [`Error::File`] if the file takes no bytes.
    pub fn columns<'c>(&mut self, columns: impl IntoIterator<Item = &'c str>) -> Result<(), Error> {
        let fields = columns.into_iter().map(|name| ("float64", name));
        let definition = Definition::own("saltus_msgs/msg/Measured", fields);
        self.measured = Some(self.writer.channel(MEASURED, &definition)?);
        Ok(())
    }

    /// Adds a row of measured data at a time (s): a number for each of the columns, NaN where nothing
    /// was measured. Without [`columns`](Recording::columns) nothing.
    ///
    /// # Errors
    /// [`Error::File`] if the file takes no bytes.
    pub fn row(&mut self, time: f64, row: impl IntoIterator<Item = f64>) -> Result<(), Error> {
        let Some(topic) = self.measured else {
            return Ok(());
        };
        self.encoder.clear();
        for x in row {
            self.encoder.f64(x);
        }
        let ns = nanoseconds(time);
        Ok(self.writer.write(topic, ns, self.encoder.bytes())?)
    }
}
