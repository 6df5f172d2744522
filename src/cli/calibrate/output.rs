//! The files that `ringcal calibrate` writes.

use crate::formats::{CalibrationJson, CameraFormat, CameraInfo, write_by_rename};
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
    info: &CameraInfo,
) -> anyhow::Result<()> {
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

/// Writes the formats that were asked for besides, as far as they can express the camera.
///
/// # Errors
/// Those that could not be written; the others are there.
pub fn write_also(
    folder: &Path,
    formats: &[CameraFormat],
    info: &CameraInfo,
) -> anyhow::Result<()> {
    let mut failed = Vec::new();
    for format in formats {
        let name = format.file_name();
        let written = match format.write(info) {
            Ok(text) => write(folder, name, &text).map_err(|error| format!("{error:#}")),
            Err(error) => Err(format!(
                "{} is not written: {error}",
                folder.join(name).display()
            )),
        };
        failed.extend(written.err());
    }
    anyhow::ensure!(failed.is_empty(), "{}", failed.join("; "));
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
