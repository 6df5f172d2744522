//! rosbag2 recordings: the images of one topic, message by message.
//!
//! A [`Bag`] is a folder with `metadata.yaml`, a folder of files, or one bare file; MCAP or SQLite, compressed as a whole, by
//! chunks, by messages or not at all. [`Bag::messages`] reads from the first file to the last; only one message, or one
//! compressed chunk's part of it, is in memory at a time. A file that is cut off or damaged gives what comes before, says
//! where it ended with a [`Breakoff`], and the next file goes on.
//!
//! | file | what |
//! |---|---|
//! | files | which files, in which order |
//! | metadata | metadata.yaml |
//! | topic | which topic |
//! | mcap, sqlite | the two kinds of file |
//! | zstd | compressed files and messages |
//! | message, cdr | bytes to a [`Frame`](crate::frame::Frame) |

mod cdr;
mod files;
mod mcap;
mod message;
mod metadata;
mod sqlite;
mod storage;
#[cfg(test)]
pub(super) mod testing;
mod topic;
mod zstd;

pub use cdr::CdrError;
pub use files::{first_in_folder, is_bag};
pub use message::{ImageKind, ImageMessage, MessageError, RecordedFrame};
pub use metadata::MetadataError;
pub use storage::StorageError;
pub use topic::{Topic, TopicError};
pub use zstd::UnpackError;

use files::BagFile;
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// A recording.
#[derive(Debug)]
pub struct Bag {
    path: PathBuf,
    files: Vec<BagFile>,
    topics: Vec<Topic>,
    notes: Vec<String>,
}

/// Why a path is no bag. Every message names the path.
#[derive(Debug, thiserror::Error)]
pub enum BagError {
    /// It cannot be read.
    #[error("{}: cannot be read: {reason}", path.display())]
    Unreadable {
        /// The path as given.
        path: PathBuf,
        /// What the operating system says.
        reason: io::Error,
    },
    /// There is no file of a bag.
    #[error("{}: no MCAP or SQLite file of a rosbag2 bag is there", path.display())]
    NoFiles {
        /// The path as given.
        path: PathBuf,
    },
}

/// A file of a bag that could not be read to its end.
#[derive(Debug)]
pub struct Breakoff {
    /// The file.
    pub file: PathBuf,
    /// Messages of the topic that were read from it.
    pub messages: u64,
    /// When the last of them was recorded, ns since 1970.
    pub last_recorded_ns: Option<i64>,
    /// Why it goes no further.
    pub reason: StorageError,
}

impl fmt::Display for Breakoff {
    /// One sentence, without the file.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.messages, self.last_recorded_ns) {
            (0, _) | (_, None) => write!(f, "no frame could be read: ")?,
            (count, Some(last)) => {
                let (sec, ns) = (
                    last.div_euclid(1_000_000_000),
                    last.rem_euclid(1_000_000_000),
                );
                let frames = if count == 1 { "frame" } else { "frames" };
                write!(
                    f,
                    "ends after {count} {frames}, the last recorded at {sec}.{ns:09}: "
                )?;
            }
        }
        write!(f, "{}", self.reason)
    }
}

impl Bag {
    /// Looks into a bag: its files and its topics with images.
    ///
    /// Files that are missing or damaged are no error here: see [`Bag::notes`] and [`Breakoff`].
    ///
    /// # Errors
    /// [`BagError`] where the path cannot be read or holds no file of a bag.
    pub fn open(path: &Path) -> Result<Self, BagError> {
        let unreadable = |reason| BagError::Unreadable {
            path: path.to_owned(),
            reason,
        };
        let mut notes = Vec::new();
        let mut metadata = None;
        let mut paths = vec![path.to_owned()];
        if path.is_dir() {
            metadata = metadata::read(path).unwrap_or_else(|error| {
                notes.push(format!("{error}; the files are read without it"));
                None
            });
            let missing;
            (paths, missing) = files::of_folder(path, metadata.as_ref()).map_err(unreadable)?;
            notes.extend(missing.iter().map(|missing| {
                let missing = missing.display();
                format!("{missing}: metadata.yaml names this file, and it is missing")
            }));
        }
        let mut files = Vec::new();
        for path in paths {
            files.extend(BagFile::at(&path).map_err(unreadable)?);
        }
        if files.is_empty() {
            let path = path.to_owned();
            return Err(BagError::NoFiles { path });
        }
        // what the recorder counted saves looking into every file; after a crash it may have counted nothing yet
        let counted = metadata.map(|m| m.topics).filter(|topics| {
            let some = |topic: &Topic| topic.messages.is_some_and(|count| count > 0);
            topics.iter().any(some)
        });
        let topics = counted.unwrap_or_else(|| topics_of(&files, &mut notes));
        Ok(Self {
            path: path.to_owned(),
            files,
            topics,
            notes,
        })
    }

    /// The path as given.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What is wrong with it, a sentence each that begins with a path.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// The topics with images, by name.
    pub fn topics(&self) -> &[Topic] {
        &self.topics
    }

    /// The topic of this name, or the only one with images.
    ///
    /// # Errors
    /// [`TopicError`] with the topics there are.
    pub fn topic(&self, wanted: Option<&str>) -> Result<&Topic, TopicError> {
        topic::choose((&self.path, &self.notes), &self.topics, wanted)
    }

    /// The messages of a topic in the order in which they were recorded; an error where a file ends early, after which the next
    /// file goes on.
    pub fn messages(
        &self,
        topic: &Topic,
    ) -> impl Iterator<Item = Result<ImageMessage, Breakoff>> + use<> {
        let topic = topic.clone();
        let files = self.files.clone().into_iter();
        files.flat_map(move |file| OfFile::new(file, &topic))
    }
}

fn topics_of(files: &[BagFile], notes: &mut Vec<String>) -> Vec<Topic> {
    let mut all = Vec::new();
    for file in files {
        match storage::topics(file) {
            Ok(topics) => all.extend(topics),
            Err(error) => notes.push(format!("{}: {error}", file.path.display())),
        }
    }
    topic::merged(all)
}

/// The messages of one file.
struct OfFile {
    file: PathBuf,
    messages: Result<storage::Messages, Option<StorageError>>,
    count: u64,
    last_recorded_ns: Option<i64>,
}

impl OfFile {
    fn new(file: BagFile, topic: &Topic) -> Self {
        Self {
            messages: storage::Messages::open(&file, topic).map_err(Some),
            file: file.path,
            count: 0,
            last_recorded_ns: None,
        }
    }
}

impl Iterator for OfFile {
    type Item = Result<ImageMessage, Breakoff>;

    fn next(&mut self) -> Option<Self::Item> {
        let next = match &mut self.messages {
            Ok(messages) => messages.next()?,
            Err(error) => Err(error.take()?),
        };
        Some(match next {
            Ok(message) => {
                self.count += 1;
                self.last_recorded_ns = Some(message.recorded_ns);
                Ok(message)
            }
            Err(reason) => Err(Breakoff {
                file: self.file.clone(),
                messages: self.count,
                last_recorded_ns: self.last_recorded_ns,
                reason,
            }),
        })
    }
}

#[cfg(test)]
mod tests;
