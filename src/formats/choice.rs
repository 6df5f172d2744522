//! One camera of a file that may hold several.

use super::camera_file_error::CameraFileError;

/// The place of the camera that is wanted, or of the only one.
pub(super) fn choose(names: &[&str], wanted: Option<&str>) -> Result<usize, CameraFileError> {
    let owned = || names.iter().map(|name| (*name).to_owned()).collect();
    match wanted {
        None if names.len() == 1 => Ok(0),
        None => Err(CameraFileError::SeveralCameras { names: owned() }),
        Some(wanted) => names
            .iter()
            .position(|name| *name == wanted)
            .ok_or_else(|| CameraFileError::NoSuchCamera {
                wanted: wanted.to_owned(),
                names: owned(),
            }),
    }
}
