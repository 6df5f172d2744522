//! The files ringcal reads and writes besides pictures.

mod calibration_json;
mod camera_info;
mod check_json;
mod detection_line;
mod write_by_rename;
mod yaml_number;

pub use calibration_json::{CalibrationJson, Outcome, RingJson, ViewJson};
pub use camera_info::{CameraInfo, CameraInfoError, RegionOfInterest};
pub use check_json::CheckJson;
pub use detection_line::{DetectionLine, PointLine};
pub use write_by_rename::write_by_rename;
