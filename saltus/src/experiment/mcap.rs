//! Runs in MCAP files: those of Saltus, and those of rosbag2 and others by a mapping of topics to
//! columns.
//!
//! A file becomes the text that a CSV file with the same numbers has. What follows is then the same
//! for both, and so are the answers.

mod tracks;

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader, Write};
use std::path::Path;

use saltus_diagnosis::spec::Spec;
use saltus_telemetry::{self as telemetry, Channel, Event, Field, Selection};

use super::error::{Error, cut, shown};
use super::lines::Table;
use super::manifest::{Listed, LogClock};
use crate::origin::Origin;
use crate::recording::{self, MEASURED, Recording};

use tracks::{Track, joined};

/// Most messages of a topic: a row of each is kept in memory.
const MOST: usize = 10_000_000;
/// Most topics that an error lists.
const LISTED: usize = 20;

/// The run in the file at `path`.
pub(super) fn table(path: &Path, listed: &Listed, spec: &'static Spec) -> Result<Table, Error> {
    let file = shown(path);
    let mut log = Log::new(listed);
    let opened = File::open(path).map_err(|source| Error::read(path, source))?;
    if !opened
        .metadata()
        .map_err(|source| Error::read(path, source))?
        .is_file()
    {
        return Err(Error::content(file, "is not a file"));
    }
    let read = telemetry::read(
        BufReader::with_capacity(1 << 16, opened),
        &mut |event| match event {
            Event::Message {
                channel,
                log_time,
                data,
            } => log.message(channel, log_time, data),
            _ => Ok(()),
        },
    );
    match read {
        Ok(()) => {}
        Err(telemetry::Error::Truncated) if log.kept() > 0 => log.notes.push(format!(
            "is cut off: {} whole messages are read, what came after them is lost",
            log.seen()
        )),
        Err(telemetry::Error::Io(source)) => return Err(Error::read(path, source)),
        Err(error) => return Err(Error::content(file, error.to_string())),
    }
    log.table(&file, spec)
}

/// Writes `rows`, each with its time (s), as a file that [`table`] reads.
pub(super) fn write(
    out: &mut dyn Write,
    names: &[&str],
    rows: impl Iterator<Item = (f64, Vec<f64>)>,
    origin: &Origin<'_>,
) -> io::Result<()> {
    let record = || -> Result<(), recording::Error> {
        let mut recording = Recording::new(&mut *out, origin)?;
        recording.columns(names.iter().copied())?;
        for (time, row) in rows {
            recording.row(time, row)?;
        }
        recording.finish().map(|_| ())
    };
    record().map_err(|error| match error {
        recording::Error::File(telemetry::Error::Io(error)) => error,
        other => io::Error::other(other.to_string()),
    })
}

/// What is kept of a file as it is read.
struct Log<'a> {
    listed: &'a Listed,
    /// Messages of each topic, with their type.
    topics: BTreeMap<String, (String, usize)>,
    /// What is looked for in each channel; none: nothing.
    looks: BTreeMap<u16, Option<Look>>,
    /// By topic.
    tracks: BTreeMap<String, Track>,
    notes: Vec<String>,
}

/// How the numbers of a channel are found.
struct Look {
    selection: Selection,
    /// How many numbers are columns; times follow.
    columns: usize,
    /// Whether seconds and nanoseconds of a header follow.
    has_header: bool,
}

impl<'a> Log<'a> {
    fn new(listed: &'a Listed) -> Log<'a> {
        Log {
            listed,
            topics: BTreeMap::new(),
            looks: BTreeMap::new(),
            tracks: BTreeMap::new(),
            notes: Vec::new(),
        }
    }

    fn seen(&self) -> usize {
        self.topics.values().map(|(_, count)| count).sum()
    }

    fn kept(&self) -> usize {
        self.tracks
            .values()
            .map(|track| track.log_times.len())
            .sum()
    }

    fn message(
        &mut self,
        channel: &Channel,
        log_time: u64,
        data: &[u8],
    ) -> Result<(), telemetry::Error> {
        if let Some((_, count)) = self.topics.get_mut(&channel.topic) {
            *count += 1;
        } else {
            let schema = channel.schema.as_ref();
            let name = schema.map_or("no type", |schema| &schema.name);
            self.topics.insert(channel.topic.clone(), (name.into(), 1));
        }
        if !self.looks.contains_key(&channel.id) {
            let look = self.look(channel)?;
            self.looks.insert(channel.id, look);
        }
        let Some(Some(look)) = self.looks.get(&channel.id) else {
            return Ok(());
        };
        let Some(track) = self.tracks.get_mut(&channel.topic) else {
            return Ok(());
        };
        track.add(look, log_time, data)
    }

    /// What is looked for in the messages of a channel.
    fn look(&mut self, channel: &Channel) -> Result<Option<Look>, telemetry::Error> {
        let is_ours = self.listed.columns.is_empty() && channel.topic == MEASURED;
        let mapped = self.listed.columns.iter();
        let mapped = mapped.filter(|(_, path)| path.topic == channel.topic);
        let mapped: Vec<(String, Vec<Field>)> = mapped
            .map(|(name, path)| (name.clone(), path.fields.clone()))
            .collect();
        if mapped.is_empty() && !is_ours {
            return Ok(None);
        }
        let schema = channel.layout()?;
        let own = |name: &&str| ((*name).to_owned(), vec![Field::named(name)]);
        let wanted = if is_ours {
            schema.numbers().iter().map(own).collect()
        } else {
            mapped
        };
        let paths: Vec<&[Field]> = wanted.iter().map(|(_, path)| &path[..]).collect();
        let selection = schema.select(&paths)?;
        let columns = paths.len();
        let stamps = ["header.stamp", "stamp"].map(stamp);
        let with_stamp = stamps.iter().find_map(|stamp| {
            let mut all = paths.clone();
            all.extend(stamp.iter().map(Vec::as_slice));
            schema.select(&all).ok()
        });
        let has_header = with_stamp.is_some();
        let names = wanted.into_iter().map(|(name, _)| name).collect();
        self.tracks
            .entry(channel.topic.clone())
            .or_insert_with(|| Track::new(names, has_header));
        Ok(Some(Look {
            selection: with_stamp.unwrap_or(selection),
            columns,
            has_header,
        }))
    }

    fn table(mut self, file: &str, spec: &Spec) -> Result<Table, Error> {
        if self.listed.columns.is_empty() {
            let Some(track) = self.tracks.remove(MEASURED) else {
                let reason = format!(
                    "has no topic {MEASURED}: say which numbers are which columns, as in columns = {{ \
                     wheel_rate_rad_s = \"/imu.angular_velocity.y\" }}; {}",
                    self.listing()
                );
                return Err(Error::content(file, reason));
            };
            return Ok(Table {
                text: track.text(),
                notes: self.notes,
            });
        }
        for (name, path) in &self.listed.columns {
            if !self.tracks.contains_key(&path.topic) {
                let reason = format!(
                    "column {name}: no message on {}; {}",
                    cut(&path.topic),
                    self.listing()
                );
                return Err(Error::content(file, reason));
            }
        }
        let clock = self.clock(file)?;
        let tracks: Vec<(String, Track)> = std::mem::take(&mut self.tracks).into_iter().collect();
        let text = joined(&tracks, clock, spec, &mut self.notes)
            .map_err(|reason| Error::content(file, reason))?;
        Ok(Table {
            text,
            notes: self.notes,
        })
    }

    /// Which times count.
    fn clock(&mut self, file: &str) -> Result<LogClock, Error> {
        let bare = self.tracks.iter().find(|(_, track)| !track.has_header);
        let bare = bare.map(|(topic, _)| topic.clone());
        match (self.listed.clock, bare) {
            (Some(LogClock::Header), Some(topic)) => {
                let reason = format!(
                    "clock = \"header\", but messages on {topic} have no header: must be \"log\""
                );
                Err(Error::content(file, reason))
            }
            (Some(clock), _) => Ok(clock),
            (None, None) => Ok(LogClock::Header),
            (None, Some(topic)) => {
                self.notes.push(format!(
                    "times are those of the log, as messages on {topic} have no header"
                ));
                Ok(LogClock::Log)
            }
        }
    }

    /// The topics of the file, in words.
    fn listing(&self) -> String {
        if self.topics.is_empty() {
            return "it has no messages".into();
        }
        let topics = self.topics.iter().take(LISTED);
        let mut words: Vec<String> = topics
            .map(|(topic, (name, count))| format!("{} ({}, {count})", cut(topic), cut(name)))
            .collect();
        let more = self.topics.len().saturating_sub(LISTED);
        words.extend((more > 0).then(|| format!("{more} more")));
        format!("its topics are {}", words.join(", "))
    }
}

/// The fields of a time within `path`.
fn stamp(path: &str) -> [Vec<Field>; 2] {
    ["sec", "nanosec"].map(|part| path.split('.').chain([part]).map(Field::named).collect())
}
