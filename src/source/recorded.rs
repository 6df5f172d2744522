//! One frame of an input before it is decoded: that may be done on another thread.

use super::bag::ImageMessage;
use super::{SourceError, read_image};
use crate::frame::Frame;
use std::fmt;
use std::path::{Path, PathBuf};

/// One frame of an input, still encoded, or why there is none.
#[derive(Debug)]
pub struct Recorded {
    origin: Origin,
    content: Content,
}

/// Where a frame is from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Origin {
    /// The file or bag, as the path was given (for a file of a folder: the folder's path as given, and the name).
    pub path: PathBuf,
    /// For a frame of a bag its number on the topic, from 0; `None` for an image file.
    pub number: Option<u64>,
}

#[derive(Debug)]
enum Content {
    File,
    Message(ImageMessage),
    Nothing(SourceError),
}

impl Recorded {
    pub(super) fn file(path: PathBuf) -> Self {
        Self {
            origin: Origin { path, number: None },
            content: Content::File,
        }
    }

    pub(super) fn message(bag: &Path, number: u64, message: ImageMessage) -> Self {
        let path = bag.to_owned();
        Self {
            origin: Origin {
                path,
                number: Some(number),
            },
            content: Content::Message(message),
        }
    }

    pub(super) fn nothing(path: PathBuf, error: SourceError) -> Self {
        Self {
            origin: Origin { path, number: None },
            content: Content::Nothing(error),
        }
    }

    /// Where it is from.
    pub fn origin(&self) -> &Origin {
        &self.origin
    }

    /// Reads and decodes the picture; its `source` is the path of an image file, the `frame_id` of a message.
    ///
    /// # Errors
    /// [`SourceError`] where the file cannot be read or there is no picture in it.
    pub fn read(self) -> Result<Frame, SourceError> {
        match (self.content, self.origin.number) {
            (Content::File, _) => read_image(&self.origin.path),
            (Content::Nothing(error), _) => Err(error),
            (Content::Message(message), number) => {
                message
                    .decode()
                    .frame
                    .map_err(|reason| SourceError::Message {
                        path: self.origin.path,
                        number: number.unwrap_or(0),
                        reason,
                    })
            }
        }
    }
}

impl Origin {
    /// Whether it is one of a stream of frames, in which the frame before says whether the board is still.
    pub fn is_stream(&self) -> bool {
        self.number.is_some()
    }
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.path.display())?;
        match self.number {
            Some(number) => write!(f, ": frame {number}"),
            None => Ok(()),
        }
    }
}
