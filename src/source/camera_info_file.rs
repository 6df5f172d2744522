//! Camera calibration files.

use super::text_file::read_at_most;
use crate::formats::{CameraInfo, CameraInfoError};
use std::io;
use std::path::{Path, PathBuf};

/// No camera_info file is longer, bytes.
const LONGEST: u64 = 64 * 1024;

/// Why a path gives no camera. Every message names the path.
#[derive(Debug, thiserror::Error)]
pub enum CameraInfoFileError {
    /// It cannot be read.
    #[error("camera_info file {}: {reason}", path.display())]
    Unreadable {
        /// The path as given.
        path: PathBuf,
        /// What the operating system says.
        reason: io::Error,
    },
    /// It is longer than any camera_info file.
    #[error("camera_info file {}: more than {LONGEST} bytes, this is no camera_info file", path.display())]
    TooLong {
        /// The path as given.
        path: PathBuf,
    },
    /// What it says is no camera that can be used.
    #[error("camera_info file {}: {reason}", path.display())]
    NoCamera {
        /// The path as given.
        path: PathBuf,
        /// What is wrong.
        reason: CameraInfoError,
    },
}

/// Reads a camera_info file.
///
/// # Errors
/// [`CameraInfoFileError`] where it cannot be read or describes no camera.
pub fn read_camera_info(path: &Path) -> Result<CameraInfo, CameraInfoFileError> {
    let owned = || path.to_owned();
    let text = read_at_most(path, LONGEST)
        .map_err(|reason| CameraInfoFileError::Unreadable {
            path: owned(),
            reason,
        })?
        .ok_or_else(|| CameraInfoFileError::TooLong { path: owned() })?;
    CameraInfo::from_yaml(&text).map_err(|reason| CameraInfoFileError::NoCamera {
        path: owned(),
        reason,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::synthetic::wide;

    #[test]
    fn what_was_saved_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("camera_info.yaml");
        let info = CameraInfo::new("front", wide());
        std::fs::write(&path, info.to_yaml()).unwrap();
        assert_eq!(read_camera_info(&path).unwrap(), info);
    }

    #[test]
    fn refusals_name_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("front.yaml");
        let refusal = || read_camera_info(&path).unwrap_err();
        assert!(refusal().to_string().contains("front.yaml"));
        std::fs::write(&path, "rows: 7\n").unwrap();
        let reason = refusal().to_string();
        assert!(
            reason.contains("front.yaml") && reason.contains("not a camera_info file"),
            "{reason}"
        );
        std::fs::write(&path, "#".repeat(70_000)).unwrap();
        assert!(matches!(refusal(), CameraInfoFileError::TooLong { .. }));
    }
}
