//! The files ringcal reads and writes besides pictures.

mod calibration_json;
mod camera_file;
mod camera_file_error;
mod camera_info;
mod camera_json;
mod check_json;
mod choice;
mod detection_line;
mod kalibr;
mod mrcal;
mod opencv_yaml;
mod ost;
mod pinhole;
mod python_literal;
mod write_by_rename;
mod yaml_number;

pub use calibration_json::{CalibrationJson, Outcome, RingJson, ViewJson};
pub use camera_file::{CameraFormat, UnknownCameraFormat, read_camera};
pub use camera_file_error::{CameraFileError, CannotExpress};
pub use camera_info::{CameraInfo, RegionOfInterest};
pub use check_json::CheckJson;
pub use detection_line::{DetectionLine, PointLine};
pub use write_by_rename::write_by_rename;
