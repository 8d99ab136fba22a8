//! One run: a CSV file of any length, read row by row.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use saltus_diagnosis::Run;
use saltus_robot::units::Unit;

use super::channel::Tally;
use super::clock::{self, Clock};
use super::error::{Error, cut, one_line, shown};
use super::header::{Header, bare};
use super::idle::Motion;
use super::instant::{self, Instant};
use super::lines::{Hash, Lines};
use super::manifest::{Listed, Manifest};
use super::mcap;
use super::thin::Thinned;
use super::valve::Valve;
use saltus_diagnosis::spec::Rest;
use saltus_diagnosis::spec::Spec;

/// Rows between two reports of progress.
const PACE: usize = 1 << 14;

/// What was read of a run.
#[derive(Debug)]
pub(super) struct Reading {
    pub(super) run: Run,
    /// Its channels.
    pub(super) columns: Vec<&'static str>,
    /// Greatest magnitude in each, and how many cells are filled.
    pub(super) largest: Vec<f64>,
    pub(super) filled: Vec<usize>,
    /// Of its rows, whatever the zero of their clock.
    pub(super) hash: Hash,
    /// Rows of the file.
    pub(super) rows: usize,
    pub(super) notes: Vec<String>,
    /// Notes that other runs may share, without the run's name: what each is about, and its text.
    pub(super) shared: Vec<(&'static str, String)>,
}

/// The run that `listed` says is in `folder`, of which at most so many rows are kept.
///
/// A run that mostly rests is read a second time, once its motion is known.
pub(super) fn read(
    folder: &Path,
    listed: &Listed,
    manifest: &Manifest,
    most: usize,
    progress: &dyn Fn(usize),
) -> Result<Reading, Error> {
    let path = folder.join(&listed.file);
    let file = shown(&path);
    let log = rows(
        &Source {
            path: &path,
            file: &file,
            listed,
            spec: manifest.spec,
            rig: &manifest.rig,
        },
        most,
        None,
        progress,
    )?;
    match log.motion(manifest) {
        Some(motion) => rows(&log.source, most, Some(motion), &|_| ())?.finish(),
        None => log.finish(),
    }
}

/// All rows of a run, of which the rest around `motion` is thinned or left out.
fn rows<'a>(
    source: &Source<'a>,
    most: usize,
    motion: Option<Motion>,
    progress: &dyn Fn(usize),
) -> Result<Log<'a>, Error> {
    let (mut lines, odd) = source.lines()?;
    let Some((line, text)) = lines.next()? else {
        return Err(Error::content(source.file, "is empty"));
    };
    let header = Header::read(text, &format!("{}:{line}", source.file), source.spec)?;
    let mut log = Log::new(*source, header, most, motion);
    log.odd = odd;
    while let Some((line, text)) = lines.next()? {
        log.row(line, text)?;
        if log.rows.is_multiple_of(PACE) {
            progress(PACE);
        }
    }
    progress(log.rows % PACE);
    if lines.comments > 0 {
        let (name, count) = (&log.name, lines.comments);
        let (lines, are) = if count == 1 {
            ("line", "begins")
        } else {
            ("lines", "begin")
        };
        log.odd.push(format!(
            "{name}: {count} {lines} left out that {are} with #"
        ));
    }
    Ok(log)
}

/// Where a run is.
#[derive(Clone, Copy)]
struct Source<'a> {
    path: &'a Path,
    /// As messages call it.
    file: &'a str,
    listed: &'a Listed,
    spec: &'static Spec,
    rig: &'a BTreeMap<String, f64>,
}

impl Source<'_> {
    /// The lines of a CSV file, or those that say the same as an MCAP file, with what is odd about
    /// it.
    fn lines(&self) -> Result<(Lines, Vec<String>), Error> {
        if !is_mcap(self.path, self.listed)? {
            return Ok((Lines::open(self.path)?, Vec::new()));
        }
        let table = mcap::table(self.path, self.listed, self.spec)?;
        let name = one_line(&self.listed.file);
        let notes = table
            .notes
            .into_iter()
            .map(|note| format!("{name}: {note}"));
        Ok((Lines::of(table.text, self.file), notes.collect()))
    }
}

/// Whether the file at `path` is to be read as MCAP: it is called so or begins so, or its columns are
/// mapped.
fn is_mcap(path: &Path, listed: &Listed) -> Result<bool, Error> {
    const MAGIC: &[u8] = b"\x89MCAP0\r\n";
    let end = path.extension().and_then(|end| end.to_str());
    let is_log = ["mcap", "db3", "bag"]
        .iter()
        .any(|log| end.is_some_and(|end| end.eq_ignore_ascii_case(log)));
    if is_log || !listed.columns.is_empty() {
        return Ok(true);
    }
    let failed = |source| Error::read(path, source);
    let file = File::open(path).map_err(failed)?;
    let mut head = Vec::new();
    if file.metadata().map_err(failed)?.is_file() {
        let mut first = file.take(MAGIC.len() as u64);
        first.read_to_end(&mut head).map_err(failed)?;
    }
    Ok(head == MAGIC)
}

/// A run so far.
struct Log<'a> {
    source: Source<'a>,
    /// As notes call it.
    name: String,
    header: Header,
    rows: usize,
    /// When the last row was measured.
    last: Option<Instant>,
    clock: Clock,
    valve: Valve,
    tallies: Vec<Tally>,
    kept: Thinned,
    /// Where its motion is known: rows of rest around it.
    motion: Option<Motion>,
    idle: Thinned,
    /// The last row of rest, and how many there were: a row that repeats it is left out, as it
    /// tells nothing new.
    resting: (Vec<Option<f64>>, usize),
    /// Rows before and after a motion that starts and ends at once.
    cut: usize,
    /// Most rows that are kept.
    most: usize,
    hash: Hash,
    /// What is odd about the file.
    odd: Vec<String>,
    /// Rows without a channel that they need: how many, and the first one's line and column.
    left_out: Option<(usize, u64, &'static str)>,
}

impl<'a> Log<'a> {
    fn new(source: Source<'a>, header: Header, most: usize, motion: Option<Motion>) -> Log<'a> {
        let channels = header.channels.len();
        let block = if source.spec.any_of { channels } else { 1 };
        Log {
            source,
            name: one_line(&source.listed.file),
            rows: 0,
            last: None,
            clock: Clock::default(),
            valve: Valve::default(),
            tallies: header
                .channels
                .iter()
                .map(|(_, channel, _)| Tally::new(channel))
                .collect(),
            kept: Thinned::new(most, block, channels),
            idle: Thinned::new(motion.map_or(0, |motion| motion.most), block, channels),
            motion,
            resting: (Vec::new(), 0),
            cut: 0,
            most,
            left_out: None,
            odd: Vec::new(),
            hash: Hash::default(),
            header,
        }
    }

    fn row(&mut self, line: u64, text: &[u8]) -> Result<(), Error> {
        let cells: Vec<&[u8]> = text.split(|byte| *byte == b',').collect();
        if cells.len() != self.header.names.len() {
            let reason = format!(
                "{} cells where the header has {}",
                cells.len(),
                self.header.names.len()
            );
            return Err(Error::content(self.place(line), reason));
        }
        self.rows += 1;
        let time = self.time(line, &cells)?;
        if let Some(column) = self.header.valve {
            let command = self.command(line, cells[column])?;
            self.valve
                .add((self.source.file, &self.name), line, time, command)?;
        }
        let [from, to] = self.source.listed.window;
        if from.is_some_and(|from| time < from) || to.is_some_and(|to| time > to) {
            return Ok(());
        }
        self.measured(line, time, &cells)
    }

    /// When a row was measured; where there is no clock, its number.
    fn time(&mut self, line: u64, cells: &[&[u8]]) -> Result<Instant, Error> {
        let Some((column, power)) = self.header.time else {
            return Ok(Instant::of_row(self.rows));
        };
        let text = self.text(line, "time_s", cells[column])?;
        if text.is_empty() {
            return Err(Error::signal(
                self.place(line),
                "time_s",
                "is empty: every row must have its time",
            ));
        }
        let Some(time) = Instant::parse(text, power) else {
            return Err(Error::value(
                self.place(line),
                "time_s",
                text,
                instant::ALLOWED,
            ));
        };
        match self.last.replace(time) {
            Some(last) if time <= last => Err(clock::disorder(
                self.source.path,
                self.source.file,
                line,
                (column, power),
                (last, time),
            )),
            _ => Ok(time),
        }
    }

    fn command(&self, line: u64, cell: &[u8]) -> Result<Option<f64>, Error> {
        let command = self.number(line, "valve", cell, Unit::SI)?;
        if command.is_some_and(|command| command != 0.0 && command != 1.0) {
            let text = String::from_utf8_lossy(cell);
            return Err(Error::value(
                self.place(line),
                "valve",
                bare(&text),
                "0 or 1",
            ));
        }
        Ok(command)
    }

    /// Takes in what a row has in the channels.
    fn measured(&mut self, line: u64, time: Instant, cells: &[&[u8]]) -> Result<(), Error> {
        let rest = self
            .motion
            .map_or(Rest::Keep, |motion| motion.rest_at(time));
        if rest == Rest::Cut {
            self.cut += 1;
            return Ok(());
        }
        let mut values = Vec::with_capacity(self.header.channels.len());
        for &(column, channel, unit) in &self.header.channels {
            let name = &self.header.names[column];
            let value = self.number(line, name, cells[column], unit)?;
            if value.is_some_and(|value| !channel.domain.contains(value)) {
                let text = String::from_utf8_lossy(cells[column]);
                return Err(Error::value(
                    self.place(line),
                    name,
                    bare(&text),
                    channel.domain.describe(channel.quantity, unit),
                ));
            }
            if value.is_none() && channel.needed {
                self.left_out.get_or_insert((0, line, channel.name)).0 += 1;
                return Ok(());
            }
            values.push(value);
        }
        self.clock.tick(line, time);
        self.hash
            .add(&time.picoseconds_since(self.clock.origin()).to_le_bytes());
        for (tally, value) in self.tallies.iter_mut().zip(&values) {
            tally.add(*value);
            self.hash.number(value.unwrap_or(f64::NAN));
        }
        if rest == Rest::Thin {
            self.resting.1 += 1;
            if self.resting.0 != values {
                self.idle.add(time, &values);
                self.resting.0 = values;
            }
        } else {
            self.kept.add(time, &values);
        }
        Ok(())
    }

    /// The number in a cell, in SI; none where it is empty.
    fn number(&self, line: u64, name: &str, cell: &[u8], unit: Unit) -> Result<Option<f64>, Error> {
        const ALLOWED: &str = "a finite number, or empty where none was measured";
        let text = self.text(line, name, cell)?;
        match unit.si(text) {
            _ if text.is_empty() => Ok(None),
            number if number.is_finite() => Ok(Some(number)),
            _ => Err(Error::value(self.place(line), name, text, ALLOWED)),
        }
    }

    fn text<'c>(&self, line: u64, name: &str, cell: &'c [u8]) -> Result<&'c str, Error> {
        let text = std::str::from_utf8(cell);
        text.map(bare)
            .map_err(|_| Error::signal(self.place(line), name, "is not UTF-8 text"))
    }

    fn place(&self, line: u64) -> String {
        format!("{}:{line}", self.source.file)
    }

    /// The motion in the run, where the rest around it is worth thinning or leaving out.
    fn motion(&self, manifest: &Manifest) -> Option<Motion> {
        let steps: Vec<Option<f64>> = self
            .header
            .channels
            .iter()
            .map(|(_, channel, _)| manifest.resolution.get(channel.name).copied())
            .collect();
        Motion::within(
            &self.kept,
            &steps,
            self.valve.opened()?,
            self.source.spec.rest,
        )
    }

    fn finish(mut self) -> Result<Reading, Error> {
        self.enough()?;
        let Source {
            file, listed, spec, ..
        } = self.source;
        let origin = self.clock.origin();
        let (mut notes, shared) = (self.notes(), self.shared());
        for tally in &self.tallies {
            notes.extend(tally.judge(file, &self.name, spec)?);
        }
        if self.tallies.iter().all(|tally| tally.values == 0) {
            return Err(Error::content(
                file,
                "all cells are empty: nothing was measured",
            ));
        }
        let valve = if spec.valve {
            let (times, odd) = self.valve.times(file)?;
            notes.extend(odd);
            Some(times)
        } else {
            None
        };
        self.clock.judge(file, spec, valve.map(|(open, _)| open))?;
        let valve =
            valve.map(|(open, shut)| (open.since(origin), shut.map(|shut| shut.since(origin))));
        if let Some((open, shut)) = valve {
            self.hash.number(open);
            self.hash.number(shut.unwrap_or(f64::INFINITY));
        }
        let mut settings = listed.settings.clone();
        settings.extend(self.source.rig.clone());
        settings.extend(
            listed
                .instants
                .iter()
                .map(|(key, at)| ((*key).to_owned(), at.since(origin))),
        );
        let (instants, values) = self.kept.merged(self.idle);
        let time = instants
            .iter()
            .map(|instant| instant.since(origin))
            .collect();
        let run = Run {
            name: listed.file.clone(),
            settings,
            valve,
            time,
            values,
        };
        let columns = self
            .header
            .channels
            .iter()
            .map(|(_, channel, _)| channel.name)
            .collect();
        let largest = self.tallies.iter().map(|tally| tally.largest).collect();
        let filled = self.tallies.iter().map(|tally| tally.values).collect();
        Ok(Reading {
            run,
            columns,
            largest,
            filled,
            hash: self.hash,
            rows: self.rows,
            notes,
            shared,
        })
    }

    /// Refuses a run from which nothing can be learned.
    fn enough(&self) -> Result<(), Error> {
        let Spec { least, id, .. } = *self.source.spec;
        let rows = self.kept.seen + self.resting.1;
        if self.rows == 0 {
            return Err(Error::content(self.source.file, "has a header and no rows"));
        }
        if rows < least {
            let is_part = self.source.listed.window != [None; 2] && rows < self.rows;
            let part = match self.left_out {
                _ if is_part => " from valid_from_s to valid_to_s",
                Some(_) => " complete",
                None => "",
            };
            let rows = if rows == 1 {
                "1 row".to_owned()
            } else {
                format!("{rows} rows")
            };
            let reason = format!("{rows}{part}: a run of kind {id} needs {least} at least");
            return Err(Error::content(self.source.file, reason));
        }
        if self.source.spec.in_full && self.kept.stride > 1 {
            let reason = format!(
                "{rows} rows: a run of kind {id} is read row by row, and may have {}; valid_from_s \
                 and valid_to_s keep a part",
                self.most
            );
            return Err(Error::content(self.source.file, reason));
        }
        Ok(())
    }

    /// What is odd about the rows.
    fn notes(&self) -> Vec<String> {
        let name = &self.name;
        let mut notes = self.odd.clone();
        if let Some((rows, line, column)) = self.left_out {
            let word = if rows == 1 { "row" } else { "rows" };
            let first = format!("the first at line {line}");
            notes.push(format!(
                "{name}: {rows} {word} left out for an empty cell, {first} for its {column}"
            ));
        }
        if self.source.spec.timed {
            notes.extend(self.clock.gap(name, &self.kept));
        }
        notes
    }

    /// What is left out of the rows.
    fn shared(&self) -> Vec<(&'static str, String)> {
        let mut shared = Vec::new();
        if !self.header.strange.is_empty() {
            let (spec, names) = (self.source.spec, self.header.strange.join(", "));
            let known = spec.columns().join(", ");
            shared.push((
                "strange",
                format!(
                    "not read: {}; the columns of a {} are {known}",
                    cut(&names),
                    spec.id
                ),
            ));
        }
        let (seen, kept, stride) = (self.kept.seen, self.kept.time.len(), self.kept.stride);
        if stride > 1 {
            let advice = if self.source.spec.timed {
                "; valid_from_s and valid_to_s keep a part in full"
            } else {
                ""
            };
            shared.push((
                "thinned",
                format!("thinned to one row in {stride}, {kept} of {seen}{advice}"),
            ));
        }
        let (seen, kept) = (self.resting.1, self.idle.time.len());
        if seen > kept {
            let text =
                format!("{kept} of {seen} rows at rest before and after the motion are kept");
            shared.push(("rest", text));
        }
        if self.cut > 0 {
            let text = format!(
                "{} rows before the start or after the landing, in which nothing moves, are left \
                 out",
                self.cut
            );
            shared.push(("cut", text));
        }
        shared
    }
}
