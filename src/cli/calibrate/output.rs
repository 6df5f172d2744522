//! The files that `ringcal calibrate` writes.

use crate::camera::Camera;
use crate::formats::{CalibrationJson, CameraInfo, write_by_rename};
use anyhow::Context;
use std::path::Path;

const REPORT: &str = "report.html";
const CALIBRATION: &str = "calibration.json";
const CAMERA_INFO: &str = "camera_info.yaml";

/// Writes everything of a calibration.
pub fn write_calibration(
    folder: &Path,
    page: String,
    file: &CalibrationJson,
    camera: Camera,
) -> anyhow::Result<()> {
    let info = CameraInfo::new(file.camera_name.as_str(), camera);
    // camera_info.yaml last: where it is new, the others are too
    let files = [
        (REPORT, page),
        (CALIBRATION, file.to_json()?),
        (CAMERA_INFO, info.to_yaml()),
    ];
    for (name, text) in files {
        write(folder, name, &text)?;
    }
    Ok(())
}

/// Writes the report of views that gave no calibration. Files of an earlier run stay: nothing better takes their place.
pub fn write_refusal(folder: &Path, page: &str) -> anyhow::Result<()> {
    write(folder, REPORT, page)?;
    let earlier = folder.join(CAMERA_INFO);
    if earlier.exists() {
        eprintln!("warning: {} is of an earlier run", earlier.display());
    }
    Ok(())
}

fn write(folder: &Path, name: &str, text: &str) -> anyhow::Result<()> {
    let path = folder.join(name);
    write_by_rename(&path, text.as_bytes())
        .with_context(|| format!("{}: cannot be written", path.display()))?;
    eprintln!("wrote {}", path.display());
    Ok(())
}
