//! One file of a bag, whatever its kind.

use super::files::{BagFile, Storage};
use super::message::ImageMessage;
use super::topic::Topic;
use super::{mcap, sqlite, zstd};
use ::mcap::McapError;
use std::fs::File;
use std::io::{self, BufReader, Read};

/// Why a file of a bag cannot be read on.
#[derive(Debug, thiserror::Error)]
pub enum StorageError {
    /// It ends before it is finished.
    #[error("the file is cut off; its recording was not finished, or a part of the file is lost")]
    CutOff,
    /// The operating system refuses, or its compression is damaged.
    #[error("{0}")]
    Io(io::Error),
    /// An MCAP file that is not as it should be.
    #[error("the MCAP file is damaged: {0}")]
    Mcap(McapError),
    /// A SQLite file that is not as it should be.
    #[error("the SQLite file is damaged or not a bag's: {0}")]
    Sqlite(#[from] rusqlite::Error),
}

impl From<io::Error> for StorageError {
    fn from(error: io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::UnexpectedEof => Self::CutOff,
            _ => Self::Io(error),
        }
    }
}

impl From<McapError> for StorageError {
    fn from(error: McapError) -> Self {
        match error {
            McapError::UnexpectedEof => Self::CutOff,
            McapError::Io(error) => error.into(),
            error => Self::Mcap(error),
        }
    }
}

/// The messages of one topic in one file, in the order in which they were recorded.
pub(super) enum Messages {
    Mcap(Box<mcap::Messages<Box<dyn Read + Send>>>),
    Sqlite(sqlite::Messages),
}

impl Messages {
    pub(super) fn open(file: &BagFile, topic: &Topic) -> Result<Self, StorageError> {
        Ok(match file.storage {
            Storage::Mcap => Self::Mcap(Box::new(mcap::Messages::new(
                mcap_source(file)?,
                topic.clone(),
            ))),
            Storage::Sqlite => Self::Sqlite(sqlite::Messages::open(file, topic)?),
        })
    }

    /// The next message; `None` after the last one of a file that is whole, or after an error.
    pub(super) fn next(&mut self) -> Option<Result<ImageMessage, StorageError>> {
        match self {
            Self::Mcap(messages) => messages.next(),
            Self::Sqlite(messages) => messages.next(),
        }
    }
}

/// The topics with images of a file; of a damaged one, those that can be told.
pub(super) fn topics(file: &BagFile) -> Result<Vec<Topic>, StorageError> {
    match file.storage {
        Storage::Mcap => mcap::topics(file),
        Storage::Sqlite => sqlite::topics(file),
    }
}

/// The bytes of an MCAP file from its start.
pub(super) fn mcap_source(file: &BagFile) -> io::Result<Box<dyn Read + Send>> {
    Ok(if file.packed {
        Box::new(BufReader::new(zstd::unpacking(&file.path)?))
    } else {
        Box::new(BufReader::with_capacity(1 << 16, File::open(&file.path)?))
    })
}
