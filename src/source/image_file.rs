//! One image file.

use super::SourceError;
use crate::frame::{Frame, Stamp};
use std::path::Path;

/// Reads one image file; its content decides the format, not its name.
///
/// # Errors
/// [`SourceError`] where the file cannot be read or is not a picture.
pub fn read_image(path: &Path) -> Result<Frame, SourceError> {
    let bytes = std::fs::read(path).map_err(|reason| SourceError::from_io(path, reason))?;
    Frame::decode(&bytes, Stamp::default(), path.to_string_lossy()).map_err(|reason| {
        SourceError::NotDecoded {
            path: path.to_owned(),
            reason,
        }
    })
}
