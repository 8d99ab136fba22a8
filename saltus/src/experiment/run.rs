//! One run: a CSV file of any length, read row by row.

use std::path::Path;

use saltus_diagnosis::Run;

use super::channel::Tally;
use super::clock::{self, Clock};
use super::error::{Error, one_line, shown};
use super::header::{Header, bare};
use super::lines::{Hash, Lines};
use super::manifest::Listed;
use super::spec::Spec;
use super::thin::Thinned;
use super::valve::Valve;

/// Rows between two reports of progress.
const PACE: usize = 1 << 14;

/// What was read of a run.
#[derive(Debug)]
pub(super) struct Reading {
    pub(super) run: Run,
    /// Its channels.
    pub(super) columns: Vec<&'static str>,
    /// Greatest magnitude in each.
    pub(super) largest: Vec<f64>,
    pub(super) hash: Hash,
    /// Rows of the file.
    pub(super) rows: usize,
    pub(super) notes: Vec<String>,
}

/// The run that `listed` says is in `folder`, of which at most so many rows are kept.
pub(super) fn read(
    folder: &Path,
    listed: &Listed,
    spec: &'static Spec,
    most: usize,
    progress: &dyn Fn(usize),
) -> Result<Reading, Error> {
    let path = folder.join(&listed.file);
    let file = shown(&path);
    let mut lines = Lines::open(&path)?;
    let Some((line, text)) = lines.next()? else { return Err(Error::content(file, "is empty")) };
    let header = Header::read(text, &format!("{file}:{line}"), spec)?;
    let mut log = Log::new(&path, &file, listed, spec, header, most);
    while let Some((line, text)) = lines.next()? {
        log.row(line, text)?;
        if log.rows.is_multiple_of(PACE) {
            progress(PACE);
        }
    }
    progress(log.rows % PACE);
    log.finish(lines.hash())
}

/// A run so far.
struct Log<'a> {
    path: &'a Path,
    file: &'a str,
    listed: &'a Listed,
    /// As notes call it.
    name: String,
    spec: &'static Spec,
    header: Header,
    rows: usize,
    /// Time (s) of the last row.
    last: Option<f64>,
    clock: Clock,
    valve: Valve,
    tallies: Vec<Tally>,
    kept: Thinned,
    /// Rows without a channel that they need: how many, and the first one's line and column.
    left_out: Option<(usize, u64, &'static str)>,
}

impl<'a> Log<'a> {
    fn new(
        path: &'a Path,
        file: &'a str,
        listed: &'a Listed,
        spec: &'static Spec,
        header: Header,
        most: usize,
    ) -> Log<'a> {
        let channels = header.channels.len();
        Log {
            path,
            file,
            listed,
            name: one_line(&listed.file),
            spec,
            rows: 0,
            last: None,
            clock: Clock::default(),
            valve: Valve::default(),
            tallies: header.channels.iter().map(|(_, channel)| Tally::new(channel)).collect(),
            kept: Thinned::new(most, if spec.any_of { channels } else { 1 }, channels),
            left_out: None,
            header,
        }
    }

    fn row(&mut self, line: u64, text: &[u8]) -> Result<(), Error> {
        let cells: Vec<&[u8]> = text.split(|byte| *byte == b',').collect();
        if cells.len() != self.header.width {
            let reason = format!("{} cells where the header has {}", cells.len(), self.header.width);
            return Err(Error::content(self.place(line), reason));
        }
        self.rows += 1;
        let time = self.time(line, &cells)?;
        if let Some(column) = self.header.valve {
            let command = self.command(line, cells[column])?;
            self.valve.add((self.file, &self.name), line, time, command)?;
        }
        match self.listed.window {
            Some((from, to)) if time < from || time > to => Ok(()),
            _ => self.measured(line, time, &cells),
        }
    }

    /// The time (s) of a row, which is its number where there is no clock.
    fn time(&mut self, line: u64, cells: &[&[u8]]) -> Result<f64, Error> {
        let Some(column) = self.header.time else { return Ok(self.rows as f64) };
        let Some(time) = self.number(line, "time_s", cells[column])? else {
            return Err(Error::signal(self.place(line), "time_s", "is empty: every row must have its time"));
        };
        match self.last.replace(time) {
            Some(last) if time <= last => {
                Err(clock::disorder(self.path, self.file, line, column, (last, time)))
            }
            _ => Ok(time),
        }
    }

    fn command(&self, line: u64, cell: &[u8]) -> Result<Option<f64>, Error> {
        let command = self.number(line, "valve", cell)?;
        if command.is_some_and(|command| command != 0.0 && command != 1.0) {
            let text = String::from_utf8_lossy(cell);
            return Err(Error::value(self.place(line), "valve", bare(&text), "0 or 1"));
        }
        Ok(command)
    }

    /// Takes in what a row has in the channels.
    fn measured(&mut self, line: u64, time: f64, cells: &[&[u8]]) -> Result<(), Error> {
        let mut values = Vec::with_capacity(self.header.channels.len());
        for &(column, channel) in &self.header.channels {
            let value = self.number(line, channel.name, cells[column])?;
            if value.is_some_and(|value| !(channel.domain.legal)(value)) {
                let text = String::from_utf8_lossy(cells[column]);
                return Err(Error::value(
                    self.place(line),
                    channel.name,
                    bare(&text),
                    channel.domain.allowed,
                ));
            }
            if value.is_none() && channel.needed {
                self.left_out.get_or_insert((0, line, channel.name)).0 += 1;
                return Ok(());
            }
            values.push(value);
        }
        self.clock.tick(line, time);
        for (tally, value) in self.tallies.iter_mut().zip(&values) {
            tally.add(*value);
        }
        self.kept.add(time, &values);
        Ok(())
    }

    /// The number in a cell; none where it is empty.
    fn number(&self, line: u64, name: &str, cell: &[u8]) -> Result<Option<f64>, Error> {
        const ALLOWED: &str = "a finite number, or empty where none was measured";
        let Ok(text) = std::str::from_utf8(cell) else {
            return Err(Error::signal(self.place(line), name, "is not UTF-8 text"));
        };
        let text = bare(text);
        match text.parse() {
            _ if text.is_empty() => Ok(None),
            Ok(number) if f64::is_finite(number) => Ok(Some(number)),
            _ => Err(Error::value(self.place(line), name, text, ALLOWED)),
        }
    }

    fn place(&self, line: u64) -> String {
        format!("{}:{line}", self.file)
    }

    fn finish(self, hash: Hash) -> Result<Reading, Error> {
        self.enough()?;
        self.clock.judge(self.file, self.spec)?;
        let mut notes = self.notes();
        for tally in &self.tallies {
            notes.extend(tally.judge(self.file, &self.name, self.spec)?);
        }
        let valve = if self.spec.valve {
            let (times, odd) = self.valve.times(self.file)?;
            notes.extend(odd);
            Some(times)
        } else {
            None
        };
        let run = Run {
            name: self.listed.file.clone(),
            settings: self.listed.settings.clone(),
            valve,
            time: self.kept.time,
            values: self.kept.values,
        };
        let columns = self.header.channels.iter().map(|(_, channel)| channel.name).collect();
        let largest = self.tallies.iter().map(|tally| tally.largest).collect();
        Ok(Reading { run, columns, largest, hash, rows: self.rows, notes })
    }

    /// Refuses a run from which nothing can be learned.
    fn enough(&self) -> Result<(), Error> {
        let (rows, least, id) = (self.kept.seen, self.spec.least, self.spec.id);
        if self.rows == 0 {
            return Err(Error::content(self.file, "has a header and no rows"));
        }
        if rows < least {
            let part = match self.listed.window {
                Some(_) if rows < self.rows => " from valid_from_s to valid_to_s",
                _ if self.left_out.is_some() => " complete",
                _ => "",
            };
            let rows = if rows == 1 { "1 row".to_owned() } else { format!("{rows} rows") };
            let reason = format!("{rows}{part}: a run of kind {id} needs {least} at least");
            return Err(Error::content(self.file, reason));
        }
        Ok(())
    }

    fn notes(&self) -> Vec<String> {
        let name = &self.name;
        let mut notes = Vec::new();
        if let Some((rows, line, column)) = self.left_out {
            let word = if rows == 1 { "row" } else { "rows" };
            let first = format!("the first at line {line}");
            notes.push(format!("{name}: {rows} {word} left out for an empty cell, {first} for its {column}"));
        }
        let (seen, kept) = (self.kept.seen, self.kept.time.len());
        if self.kept.stride > 1 {
            let stride = self.kept.stride;
            let advice =
                if self.spec.timed() { "; valid_from_s and valid_to_s keep a part in full" } else { "" };
            notes.push(format!("{name}: thinned to one row in {stride}, {kept} of {seen}{advice}"));
        }
        if self.spec.timed() {
            notes.extend(self.clock.gap(name, &self.kept.time, seen));
        }
        notes
    }
}
