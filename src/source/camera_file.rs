//! Camera calibration files.

use super::text_file::read_at_most;
use crate::formats::{CameraFileError, CameraInfo, read_camera};
use std::io;
use std::path::{Path, PathBuf};

/// No camera file is longer, bytes: a calibration.json has a line for each ring, and mrcal keeps its observations in the file.
const LONGEST: u64 = 64 * 1024 * 1024;

/// Why a path gives no camera. Every message names the path.
#[derive(Debug, thiserror::Error)]
pub enum NoCamera {
    /// It cannot be read.
    #[error("camera file {}: {reason}", path.display())]
    Unreadable {
        /// The path as given.
        path: PathBuf,
        /// What the operating system says.
        reason: io::Error,
    },
    /// It is longer than any camera file.
    #[error("camera file {}: more than {LONGEST} bytes, this is no camera file", path.display())]
    TooLong {
        /// The path as given.
        path: PathBuf,
    },
    /// What it says is no camera that can be used.
    #[error("camera file {}: {reason}", path.display())]
    Unusable {
        /// The path as given.
        path: PathBuf,
        /// What is wrong.
        reason: CameraFileError,
    },
}

/// Reads the camera of a file in any format that `formats` knows.
///
/// # Errors
/// [`NoCamera`] where it cannot be read or does not describe one camera.
pub fn read_camera_file(path: &Path) -> Result<CameraInfo, NoCamera> {
    read_camera_of(path, None)
}

/// The same, of a file that may hold several cameras, the one of this name.
///
/// # Errors
/// As [`read_camera_file`], and where no camera has the name.
pub fn read_camera_of(path: &Path, wanted: Option<&str>) -> Result<CameraInfo, NoCamera> {
    let owned = || path.to_owned();
    let text = read_at_most(path, LONGEST)
        .map_err(|reason| NoCamera::Unreadable {
            path: owned(),
            reason,
        })?
        .ok_or_else(|| NoCamera::TooLong { path: owned() })?;
    read_camera(&text, wanted).map_err(|reason| NoCamera::Unusable {
        path: owned(),
        reason,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::synthetic::wide;
    use crate::formats::CameraFormat;

    #[test]
    fn every_format_is_read_whatever_the_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("camera.yaml");
        let info = CameraInfo::new("front", wide());
        for format in CameraFormat::ALL {
            // Kalibr has no place for k3
            let Ok(text) = format.write(&info) else {
                assert_eq!(format, CameraFormat::Kalibr);
                continue;
            };
            std::fs::write(&path, text).unwrap();
            assert_eq!(read_camera_file(&path).unwrap().camera, info.camera);
        }
    }

    #[test]
    fn refusals_name_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("front.yaml");
        let refusal = || read_camera_file(&path).unwrap_err();
        assert!(refusal().to_string().contains("front.yaml"));
        std::fs::write(&path, "rows: 7\n").unwrap();
        let reason = refusal().to_string();
        assert!(
            reason.contains("front.yaml") && reason.contains("not a camera_info file"),
            "{reason}"
        );
        let file = std::fs::File::create(&path).unwrap();
        file.set_len(LONGEST + 1).unwrap();
        assert!(matches!(refusal(), NoCamera::TooLong { .. }));
    }
}
