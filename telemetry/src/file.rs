//! MCAP files. The only place that knows the crate `mcap`.
//!
//! Source: MCAP specification, mcap.dev/spec.

use std::collections::BTreeMap;
use std::io::{self, ErrorKind, Read, Seek, SeekFrom, Write};
use std::rc::Rc;

use mcap::records::{ChunkHeader, MessageHeader, Metadata, Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{Attachment, McapError, WriteOptions};

use crate::{Definition, Error};

/// Longest record or chunk (bytes), compressed or not.
const LONGEST: usize = 1 << 28;

/// Whether bytes begin as an MCAP file does.
pub fn is_mcap(bytes: &[u8]) -> bool {
    bytes.starts_with(mcap::MAGIC)
}

/// A channel of a file that is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Topic {
    id: u16,
    /// Place among the counts of messages.
    place: usize,
}

/// Writes a file from begin to end, in chunks that are not compressed.
pub struct Writer<W: Write> {
    inner: mcap::Writer<Ahead<W>>,
    /// Messages of each channel.
    counts: Vec<u32>,
}

impl<W: Write> Writer<W> {
    /// A file that says that it was written by `library`.
    ///
    /// # Errors
    /// [`Error::Io`] if `out` takes no bytes.
    pub fn new(out: W, library: &str) -> Result<Writer<W>, Error> {
        let options = WriteOptions::new()
            .profile("ros2")
            .library(library)
            .compression(None)
            .disable_seeking(true);
        let out = Ahead { out, at: 0 };
        Ok(Writer {
            inner: options.create(out).map_err(written)?,
            counts: Vec::new(),
        })
    }

    /// A channel for messages of type `definition` on `topic`.
    ///
    /// # Errors
    /// [`Error::Io`] if the file takes no bytes.
    pub fn channel(&mut self, topic: &str, definition: &Definition) -> Result<Topic, Error> {
        // Offered as ROS 2 offers topics that every reader takes.
        const PROFILES: &str = "- history: keep_last\n  depth: 10\n  reliability: reliable\n  \
            durability: transient_local\n  deadline:\n    sec: 9223372036\n    nsec: 854775807\n  \
            lifespan:\n    sec: 9223372036\n    nsec: 854775807\n  liveliness: automatic\n  \
            liveliness_lease_duration:\n    sec: 9223372036\n    nsec: 854775807\n  \
            avoid_ros_namespace_conventions: false\n";
        let (name, text) = (&definition.name, definition.text.as_bytes());
        let schema = self
            .inner
            .add_schema(name, "ros2msg", text)
            .map_err(written)?;
        let profiles = ("offered_qos_profiles".to_owned(), PROFILES.to_owned());
        let metadata = BTreeMap::from([profiles]);
        let channel = self.inner.add_channel(schema, topic, "cdr", &metadata);
        self.counts.push(0);
        Ok(Topic {
            id: channel.map_err(written)?,
            place: self.counts.len() - 1,
        })
    }

    /// Writes a message of the time `ns`.
    ///
    /// # Errors
    /// [`Error::Io`] if the file takes no bytes.
    pub fn write(&mut self, topic: Topic, ns: u64, message: &[u8]) -> Result<(), Error> {
        let count = &mut self.counts[topic.place];
        let header = MessageHeader {
            channel_id: topic.id,
            sequence: *count,
            log_time: ns,
            publish_time: ns,
        };
        *count = count.wrapping_add(1);
        self.inner
            .write_to_known_channel(&header, message)
            .map_err(written)
    }

    /// Adds a file within the file.
    ///
    /// # Errors
    /// [`Error::Io`] if the file takes no bytes.
    pub fn attach(&mut self, name: &str, media_type: &str, bytes: &[u8]) -> Result<(), Error> {
        let attachment = Attachment {
            log_time: 0,
            create_time: 0,
            name: name.into(),
            media_type: media_type.into(),
            data: bytes.into(),
        };
        self.inner.attach(&attachment).map_err(written)
    }

    /// Adds names with values.
    ///
    /// # Errors
    /// [`Error::Io`] if the file takes no bytes.
    pub fn metadata(&mut self, name: &str, values: BTreeMap<String, String>) -> Result<(), Error> {
        let metadata = Metadata {
            name: name.into(),
            metadata: values,
        };
        self.inner.write_metadata(&metadata).map_err(written)
    }

    /// Writes the end, with the index.
    ///
    /// # Errors
    /// [`Error::Io`] if the file takes no bytes.
    pub fn finish(mut self) -> Result<W, Error> {
        self.inner.finish().map_err(written)?;
        let mut out = self.inner.into_inner().out;
        out.flush()?;
        Ok(out)
    }
}

impl<W: Write> std::fmt::Debug for Writer<W> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Writer")
            .field("counts", &self.counts)
            .finish_non_exhaustive()
    }
}

/// Why the file could not be written. All that can fail is where the bytes go.
fn written(error: McapError) -> Error {
    match error {
        McapError::Io(error) => Error::Io(error),
        other => Error::Io(io::Error::other(other.to_string())),
    }
}

/// A place to write that only goes ahead.
struct Ahead<W> {
    out: W,
    at: u64,
}

impl<W: Write> Write for Ahead<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.out.write(bytes)?;
        self.at += count as u64;
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

impl<W> Seek for Ahead<W> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match to {
            SeekFrom::Current(0) | SeekFrom::End(0) => Ok(self.at),
            SeekFrom::Start(at) if at == self.at => Ok(at),
            _ => Err(ErrorKind::Unsupported.into()),
        }
    }
}

/// A channel of a file that is read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// Its number in the file.
    pub id: u16,
    /// Its topic.
    pub topic: String,
    /// How its messages are written, such as `cdr`.
    pub encoding: String,
    /// What they are, where the file says that.
    pub schema: Option<Rc<FileSchema>>,
}

/// A definition that stands in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileSchema {
    /// The type.
    pub name: String,
    /// How it is written, such as `ros2msg`.
    pub encoding: String,
    /// The definition.
    pub text: String,
}

impl Channel {
    /// The type of its messages, as this crate reads it.
    ///
    /// # Errors
    /// [`Error::Encoding`] for other messages than CDR with `ros2msg`, [`Error::Definition`] for a
    /// definition that cannot be read.
    pub fn layout(&self) -> Result<crate::Schema, Error> {
        match &self.schema {
            Some(schema) if self.encoding == "cdr" && schema.encoding == "ros2msg" => {
                crate::Schema::parse(&schema.name, &schema.text)
            }
            other => {
                let of = other.as_ref().map_or("none", |schema| &schema.encoding);
                let found = format!("{:?} with a definition in {of:?}", self.encoding);
                Err(Error::Encoding {
                    topic: self.topic.clone(),
                    found,
                })
            }
        }
    }
}

/// What stands in a file.
#[derive(Debug)]
pub enum Event<'a> {
    /// A message.
    Message {
        /// Its channel.
        channel: &'a Channel,
        /// When it was written into the log (ns).
        log_time: u64,
        /// Its bytes.
        data: &'a [u8],
    },
    /// A file within the file.
    Attachment {
        /// Its name.
        name: String,
        /// Its contents.
        data: &'a [u8],
    },
    /// Names with values.
    Metadata {
        /// What they are about.
        name: String,
        /// Each value by its name.
        values: BTreeMap<String, String>,
    },
}

/// Reads a file from begin to end and gives what stands in it to `visit`; the index at its end is
/// not needed.
///
/// Memory grows with the longest chunk alone. A chunk whose checksum is wrong gives no message.
///
/// # Errors
/// [`Error`] for a file that is none, is cut off or damaged: what came before has been given then. An
/// error of `visit` ends the reading.
pub fn read(
    source: impl Read,
    visit: &mut dyn FnMut(Event<'_>) -> Result<(), Error>,
) -> Result<(), Error> {
    let mut source = source;
    let options = LinearReaderOptions::default()
        .with_emit_chunks(true)
        .with_validate_data_section_crc(true)
        .with_record_length_limit(LONGEST);
    let mut reader = LinearReader::new_with_options(options);
    let mut known = Known::default();
    let mut is_first = true;
    while let Some(event) = reader.next_event() {
        match event.map_err(|error| unread(&error))? {
            LinearReadEvent::ReadRequest(wanted) => {
                if wanted > LONGEST {
                    return Err(Error::damaged(format!("a record of {wanted} bytes")));
                }
                let place = reader.insert(wanted);
                let count = filled(&mut source, place)?;
                if is_first && !is_mcap(&place[..count.min(mcap::MAGIC.len())]) {
                    return Err(foreign(&place[..count]));
                }
                is_first = false;
                reader.notify_read(count);
            }
            LinearReadEvent::Record { opcode, data } if opcode == op::CHUNK => {
                let record = parsed(opcode, data)?;
                if let Record::Chunk { header, data } = record {
                    known.chunk(&unpacked(&header, &data)?, visit)?;
                }
            }
            LinearReadEvent::Record { opcode, data } => {
                known.record(opcode, data, visit)?;
                // What follows repeats what was there.
                if opcode == op::DATA_END {
                    return Ok(());
                }
            }
        }
    }
    Ok(())
}

/// Reads as much as there is.
fn filled(source: &mut impl Read, place: &mut [u8]) -> io::Result<usize> {
    let mut count = 0;
    while count < place.len() {
        match source.read(&mut place[count..]) {
            Ok(0) => break,
            Ok(more) => count += more,
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(count)
}

/// What a file is that begins with `bytes`.
fn foreign(bytes: &[u8]) -> Error {
    let found = if bytes.is_empty() {
        "nothing: it is empty".into()
    } else if bytes.starts_with(&[0x28, 0xb5, 0x2f, 0xfd]) {
        "zstd: a file that is compressed as a whole is unpacked by `zstd -d`".into()
    } else if bytes.starts_with(b"SQLite") || mcap::MAGIC.starts_with(bytes) && bytes.len() < 8 {
        match bytes.first() {
            Some(b'S') => {
                "SQLite: a rosbag2 of that storage is converted by `ros2 bag convert`".into()
            }
            _ => "a part of what an MCAP file begins with: it is cut off".into(),
        }
    } else if bytes.starts_with(b"#ROSBAG") {
        "#ROSBAG: a bag of ROS 1 is converted by `mcap convert`".into()
    } else {
        format!(
            "{:?}",
            String::from_utf8_lossy(&bytes[..bytes.len().min(8)])
        )
    };
    Error::NotMcap { found }
}

/// Why the crate could not go on.
fn unread(error: &McapError) -> Error {
    match error {
        McapError::UnexpectedEof => Error::Truncated,
        other => Error::damaged(other.to_string()),
    }
}

fn parsed(opcode: u8, data: &[u8]) -> Result<Record<'_>, Error> {
    let refused = |_| Error::damaged(format!("a record of kind {opcode} is not laid out as such"));
    mcap::parse_record(opcode, data).map_err(refused)
}

/// The records of a chunk.
fn unpacked<'a>(header: &ChunkHeader, data: &'a [u8]) -> Result<std::borrow::Cow<'a, [u8]>, Error> {
    let size = usize::try_from(header.uncompressed_size).unwrap_or(usize::MAX);
    if size > LONGEST {
        return Err(Error::damaged(format!("a chunk of {size} bytes")));
    }
    let records = match header.compression.as_str() {
        "" => data.into(),
        "zstd" => {
            let decoder = ruzstd::decoding::StreamingDecoder::new(data);
            let decoder = decoder.map_err(|error| Error::damaged(error.to_string()))?;
            inflated(decoder, size)?.into()
        }
        "lz4" => inflated(lz4_flex::frame::FrameDecoder::new(data), size)?.into(),
        other => {
            return Err(Error::Compression { name: other.into() });
        }
    };
    let records: std::borrow::Cow<'a, [u8]> = records;
    if records.len() != size {
        let found = records.len();
        return Err(Error::damaged(format!(
            "a chunk of {size} bytes has {found}"
        )));
    }
    let expected = header.uncompressed_crc;
    if expected != 0 && expected != crc32fast::hash(&records) {
        return Err(Error::damaged("the checksum of a chunk is wrong"));
    }
    Ok(records)
}

fn inflated(decoder: impl Read, size: usize) -> Result<Vec<u8>, Error> {
    let mut records = Vec::new();
    let read = decoder.take(size as u64 + 1).read_to_end(&mut records);
    read.map_err(|error| Error::damaged(format!("a chunk cannot be unpacked: {error}")))?;
    Ok(records)
}

/// Schemas and channels so far.
#[derive(Default)]
struct Known {
    schemas: BTreeMap<u16, Rc<FileSchema>>,
    channels: BTreeMap<u16, Channel>,
}

impl Known {
    fn chunk(
        &mut self,
        mut records: &[u8],
        visit: &mut dyn FnMut(Event<'_>) -> Result<(), Error>,
    ) -> Result<(), Error> {
        const SHORT: &str = "a record in a chunk is longer than the chunk";
        while !records.is_empty() {
            let Some((head, rest)) = records.split_first_chunk::<9>() else {
                return Err(Error::damaged(SHORT));
            };
            let [opcode, length @ ..] = *head;
            let length = usize::try_from(u64::from_le_bytes(length)).unwrap_or(usize::MAX);
            let Some((record, after)) = rest.split_at_checked(length) else {
                return Err(Error::damaged(SHORT));
            };
            self.record(opcode, record, visit)?;
            records = after;
        }
        Ok(())
    }

    fn record(
        &mut self,
        opcode: u8,
        data: &[u8],
        visit: &mut dyn FnMut(Event<'_>) -> Result<(), Error>,
    ) -> Result<(), Error> {
        match opcode {
            op::MESSAGE => {
                let event = self.message(data)?;
                return visit(event);
            }
            op::SCHEMA | op::CHANNEL | op::ATTACHMENT | op::METADATA => {}
            _ => return Ok(()),
        }
        match parsed(opcode, data)? {
            Record::Schema { header, data } => {
                let schema = FileSchema {
                    name: header.name,
                    encoding: header.encoding,
                    text: String::from_utf8_lossy(&data).into_owned(),
                };
                self.schemas.insert(header.id, Rc::new(schema));
            }
            Record::Channel(channel) => {
                let schema = self.schemas.get(&channel.schema_id).cloned();
                let of = Channel {
                    id: channel.id,
                    topic: channel.topic,
                    encoding: channel.message_encoding,
                    schema,
                };
                self.channels.insert(of.id, of);
            }
            Record::Attachment { header, data, .. } => {
                let name = header.name;
                return visit(Event::Attachment { name, data: &data });
            }
            Record::Metadata(metadata) => {
                let (name, values) = (metadata.name, metadata.metadata);
                return visit(Event::Metadata { name, values });
            }
            _ => {}
        }
        Ok(())
    }

    fn message<'a>(&'a self, data: &'a [u8]) -> Result<Event<'a>, Error> {
        // Channel (2 bytes), number (4), time of the log (8), time of sending (8).
        let Some((head, data)) = data.split_first_chunk::<22>() else {
            return Err(Error::damaged("a message has no head"));
        };
        let id = u16::from_le_bytes([head[0], head[1]]);
        let Some(channel) = self.channels.get(&id) else {
            let reason = format!("a message is of channel {id}, which is not there");
            return Err(Error::damaged(reason));
        };
        let mut log_time = [0; 8];
        log_time.copy_from_slice(&head[6..14]);
        Ok(Event::Message {
            channel,
            log_time: u64::from_le_bytes(log_time),
            data,
        })
    }
}
