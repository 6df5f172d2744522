//! ~/save: the camera as camera_info.yaml.

use crate::camera::Camera;
use crate::formats::{CameraInfo, write_by_rename};
use std::io;
use std::path::{Path, PathBuf};

/// The name of the file, as `ringcal calibrate` writes it.
const FILE_NAME: &str = "camera_info.yaml";

/// What could not be written, and why.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {path}: {source}", path = path.display())]
pub struct SaveError {
    path: PathBuf,
    source: io::Error,
}

/// Writes camera_info.yaml in `folder`, which is made where it does not exist, and answers with its path.
///
/// # Errors
/// [`SaveError`] names what could not be written.
pub fn save(camera: &Camera, camera_name: &str, folder: &Path) -> Result<PathBuf, SaveError> {
    let failed = |path: &Path, source| SaveError {
        path: path.to_owned(),
        source,
    };
    std::fs::create_dir_all(folder).map_err(|error| failed(folder, error))?;
    // the answer is read by people elsewhere: a relative path would tell them nothing
    let folder = folder
        .canonicalize()
        .map_err(|error| failed(folder, error))?;
    let path = folder.join(FILE_NAME);
    let text = CameraInfo::new(camera_name, *camera).to_yaml();
    write_by_rename(&path, text.as_bytes()).map_err(|error| failed(&path, error))?;
    Ok(path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Distortion, Intrinsics, PlumbBob};

    const CAMERA: Camera = Camera {
        width: 640,
        height: 480,
        intrinsics: Intrinsics {
            fx: 500.0,
            fy: 501.0,
            cx: 320.0,
            cy: 240.0,
        },
        distortion: Distortion::PlumbBob(PlumbBob {
            k1: 0.1,
            k2: 0.2,
            p1: 0.3,
            p2: 0.4,
            k3: 0.5,
        }),
    };

    #[test]
    fn what_is_saved_can_be_read_again() {
        let place = tempfile::tempdir().unwrap();
        let path = save(&CAMERA, "left", &place.path().join("new/folder")).unwrap();
        assert!(path.is_absolute());
        let text = std::fs::read_to_string(&path).unwrap();
        let back = CameraInfo::from_yaml(&text).unwrap();
        assert_eq!(back, CameraInfo::new("left", CAMERA));
    }

    #[test]
    fn a_place_that_cannot_be_written_is_named() {
        let place = tempfile::tempdir().unwrap();
        let file = place.path().join("file");
        std::fs::write(&file, "").unwrap();
        let error = save(&CAMERA, "left", &file.join("sub")).unwrap_err();
        assert!(error.to_string().contains("sub"), "{error}");
    }
}
