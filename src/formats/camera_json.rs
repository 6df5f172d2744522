//! The camera of a calibration.json, or of the truth.json that `ringcal simulate` writes.

use super::camera_file_error::CameraFileError;
use super::camera_info::CameraInfo;
use super::pinhole;
use crate::camera::{Distortion, Intrinsics, LensModel};
use serde::Deserialize;
use serde_json::Value;
use std::collections::BTreeMap;

/// The keys that say what the camera is; the others say how it was found.
#[derive(Deserialize)]
struct Keys {
    model: String,
    #[serde(default)]
    camera_name: String,
    width: u32,
    height: u32,
    parameters: BTreeMap<String, f64>,
}

/// Reads the text of a file.
pub(super) fn read(text: &str) -> Result<CameraInfo, CameraFileError> {
    let syntax = |reason: String| CameraFileError::Syntax {
        format: "a calibration.json",
        reason,
    };
    let file: Value = serde_json::from_str(text).map_err(|error| syntax(error.to_string()))?;
    // truth.json has the camera below a key
    let keys = Keys::deserialize(file.get("camera").unwrap_or(&file))
        .map_err(|error| syntax(error.to_string()))?;
    let model: LensModel = keys.model.parse().map_err(|_| CameraFileError::Model {
        key: "model",
        model: keys.model.clone(),
        supported: "plumb_bob, rational_polynomial and equidistant",
    })?;
    let value = |name: &&str| {
        let found = keys.parameters.get(*name).copied();
        found.ok_or_else(|| syntax(format!("parameters has no {name}")))
    };
    let values: Vec<f64> = model
        .parameter_names()
        .iter()
        .map(value)
        .collect::<Result<_, _>>()?;
    let lens = Distortion::new(model, &values[4..]);
    let lens = lens.ok_or_else(|| syntax(format!("parameters are not those of {model}")))?;
    let intrinsics = Intrinsics {
        fx: values[0],
        fy: values[1],
        cx: values[2],
        cy: values[3],
    };
    let camera = pinhole::camera((keys.width, keys.height), intrinsics, lens)?;
    Ok(CameraInfo::new(keys.camera_name, camera))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRUTH: &str = r#"{"camera": {"model": "equidistant", "width": 640, "height": 480, "parameters":
        {"fx": 500.1, "fy": 510.2, "cx": 320, "cy": 240, "k1": 0.1, "k2": 0.2, "k3": 0.3, "k4": 0.4}}, "views": []}"#;

    #[test]
    fn the_camera_of_truth_json_is_read() {
        let info = read(TRUTH).unwrap();
        assert_eq!(info.camera.intrinsics.fx, 500.1);
        assert_eq!(info.camera.model(), LensModel::Equidistant);
        assert_eq!(info.camera.distortion.coefficients(), [0.1, 0.2, 0.3, 0.4]);
    }

    #[test]
    fn refusals_name_the_key() {
        let refused = |from: &str, to: &str| {
            assert!(TRUTH.contains(from), "{from}");
            read(&TRUTH.replace(from, to)).unwrap_err().to_string()
        };
        assert!(refused("\"camera\"", "\"lens\"").contains("missing field `model`"));
        assert!(refused("equidistant", "omni").contains("model \"omni\" is not supported"));
        assert!(refused("\"k4\"", "\"k5\"").contains("parameters has no k4"));
        assert!(refused("500.1", "-500.1").contains("not calibrated"));
        assert!(refused("500.1", "null").contains("not a calibration.json"));
        assert!(refused("500.1", "1e999").contains("out of range"));
    }
}
