//! What a measured column says about its sensor.

use super::error::Error;
use saltus_diagnosis::spec::{Column, Spec, Still};

/// So many values that are all the same cannot be chance; of fewer, a coarse sensor may give them.
const TELLING: usize = 8;

/// A column so far.
#[derive(Debug)]
pub(super) struct Tally {
    channel: &'static Column,
    /// Cells that are filled.
    pub(super) values: usize,
    missing: usize,
    first: f64,
    changes: bool,
    /// Greatest magnitude.
    pub(super) largest: f64,
}

impl Tally {
    pub(super) fn new(channel: &'static Column) -> Tally {
        Tally {
            channel,
            values: 0,
            missing: 0,
            first: f64::NAN,
            changes: false,
            largest: 0.0,
        }
    }

    /// Takes in a cell.
    pub(super) fn add(&mut self, cell: Option<f64>) {
        let Some(value) = cell else {
            self.missing += 1;
            return;
        };
        if self.values == 0 {
            self.first = value;
        }
        self.values += 1;
        self.changes |= value != self.first;
        self.largest = self.largest.max(value.abs());
    }

    /// What is odd about the column; messages call the file `file` and the run `name`.
    pub(super) fn judge(
        &self,
        file: &str,
        name: &str,
        spec: &Spec,
    ) -> Result<Option<String>, Error> {
        let rows = self.values + self.missing;
        let column = self.channel.name;
        let all = if self.missing == 0 {
            format!("all {rows}")
        } else {
            format!("all {} filled", self.values)
        };
        if self.values == 0 && self.channel.optional {
            return Ok(None);
        }
        if self.values == 0 {
            return Err(Error::signal(
                file,
                column,
                format!("is empty in all {rows} rows"),
            ));
        }
        if self.channel.still != Still::AtStart && !spec.may_lack(self.missing, rows) {
            let most = if spec.any_of { "nine tenths" } else { "half" };
            let symptom = format!(
                "is empty in {} of {rows} rows: at most {most} may be",
                self.missing
            );
            return Err(Error::signal(file, column, symptom));
        }
        match self.channel.still {
            Still::Dead if !self.changes && self.values >= TELLING => {
                let symptom = format!("is {} in {all} rows: the sensor seems dead", self.first);
                Err(Error::signal(file, column, symptom))
            }
            Still::Dead | Still::Odd if !self.changes => Ok(Some(format!(
                "{name}: {column} is {} in {all} rows",
                self.first
            ))),
            _ => Ok(None),
        }
    }
}
