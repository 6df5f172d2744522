//! Why an input gives no frame.

use super::bag::{BagError, MessageError};
use super::folder;
use crate::frame::DecodeError;
use std::io;
use std::path::{Path, PathBuf};

/// Why an input gives no frame. Every message names the path.
#[derive(Debug, thiserror::Error)]
pub enum SourceError {
    /// There is nothing at this path.
    #[error("{}: no such file or folder", path.display())]
    NotFound {
        /// The path as given.
        path: PathBuf,
    },
    /// The file or folder is there but cannot be read.
    #[error("{}: cannot be read: {reason}", path.display())]
    Unreadable {
        /// The path as given.
        path: PathBuf,
        /// What the operating system says.
        reason: io::Error,
    },
    /// The file was read but is no picture, or a damaged one.
    #[error("{}: {reason}", path.display())]
    NotDecoded {
        /// The path as given.
        path: PathBuf,
        /// What is wrong with it.
        reason: DecodeError,
    },
    /// A folder without image files.
    #[error("{}: the folder has no image files ({})", path.display(), folder::EXTENSIONS.join(", "))]
    EmptyFolder {
        /// The path as given.
        path: PathBuf,
    },
    /// A message of a bag without a picture.
    #[error("{}: frame {number}: {reason}", path.display())]
    Message {
        /// The bag's path as given.
        path: PathBuf,
        /// Its number on the topic, from 0.
        number: u64,
        /// What is wrong with it.
        reason: MessageError,
    },
    /// A bag that cannot be opened.
    #[error("{0}")]
    Bag(#[from] BagError),
}

impl SourceError {
    pub(super) fn from_io(path: &Path, reason: io::Error) -> Self {
        let path = path.to_owned();
        if reason.kind() == io::ErrorKind::NotFound {
            Self::NotFound { path }
        } else {
            Self::Unreadable { path, reason }
        }
    }
}
