//! Why a log could not be read or written.

/// A file or a message that is not what it should be.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Another kind of file.
    #[error("is no MCAP file: it begins with {found}")]
    NotMcap {
        /// What it begins with, in words.
        found: String,
    },
    /// A file that ends too early.
    #[error("ends in the middle of a record: the file is cut off")]
    Truncated,
    /// Bytes that contradict each other.
    #[error("is damaged: {reason}")]
    Damaged {
        /// What is wrong.
        reason: String,
    },
    /// A compression that is not read here.
    #[error("its chunks are compressed by {name:?}: must be zstd, lz4 or not compressed")]
    Compression {
        /// The compression as the file names it.
        name: String,
    },
    /// A channel whose messages are not read here.
    #[error("{topic}: its messages are {found}: must be cdr messages with a ros2msg definition")]
    Encoding {
        /// The topic.
        topic: String,
        /// The encodings of message and definition.
        found: String,
    },
    /// A definition of messages that cannot be read.
    #[error("definition of {name}, line {line}: {reason}")]
    Definition {
        /// The type that it defines.
        name: String,
        /// The line, from 1.
        line: usize,
        /// What is wrong.
        reason: String,
    },
    /// A path that leads to no number.
    #[error("{path}: {reason}")]
    Path {
        /// The path, or the part of it that is wrong.
        path: String,
        /// What is wrong, and what is there.
        reason: String,
    },
    /// A message that does not fit its definition.
    #[error("a message of {bytes} bytes does not fit its definition {name}: {reason}")]
    Message {
        /// The type.
        name: String,
        /// Its length.
        bytes: usize,
        /// What is wrong.
        reason: &'static str,
    },
    /// What the system says.
    #[error(transparent)]
    Io(#[from] std::io::Error),
}

impl Error {
    pub(crate) fn damaged(reason: impl Into<String>) -> Error {
        Error::Damaged {
            reason: reason.into(),
        }
    }
}
