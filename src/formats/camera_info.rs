//! camera_info YAML, as camera_calibration_parsers and camera_info_manager read and write it.
//!
//! The projection matrix is the camera matrix with a column of zeros: the image is rectified with the calibration's
//! own focal lengths and principal point, no pixel is scaled away, and for a single camera nothing else is known.
//! (ROS's cameracalibrator crops there, which depends on a taste for black borders.)

use super::camera_file_error::CameraFileError;
use super::pinhole::{self, IDENTITY, Matrix, lens_by_count};
use super::yaml_number::{flow_sequence, scalar};
use crate::camera::{Camera, Distortion, LensModel};
use serde::Deserialize;

/// A camera_info file: what a camera file of any format is read as.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraInfo {
    /// Name of the camera, as its driver knows it.
    pub camera_name: String,
    /// Frame size, camera matrix and distortion.
    pub camera: Camera,
    /// 3 x 3, by rows; the identity for a single camera.
    pub rectification: [f64; 9],
    /// 3 x 4, by rows.
    pub projection: [f64; 12],
    /// Pixels binned across and down, where the file says so.
    pub binning: Option<[u32; 2]>,
    /// The part of the sensor that the frames show, where the file says so.
    pub roi: Option<RegionOfInterest>,
}

/// A part of the sensor, in unbinned pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
pub struct RegionOfInterest {
    /// First column.
    pub x_offset: u32,
    /// First row.
    pub y_offset: u32,
    /// Rows.
    pub height: u32,
    /// Columns.
    pub width: u32,
    /// Whether a rectified image shows this part alone.
    #[serde(default)]
    pub do_rectify: bool,
}

impl CameraInfo {
    /// The file of a single camera: no rectification, projection as the camera matrix.
    pub fn new(camera_name: impl Into<String>, camera: Camera) -> Self {
        let [a, b, c, d, e, f, g, h, i] = pinhole::camera_matrix(&camera);
        Self {
            camera_name: camera_name.into(),
            camera,
            rectification: IDENTITY,
            projection: [a, b, c, 0.0, d, e, f, 0.0, g, h, i, 0.0],
            binning: None,
            roi: None,
        }
    }

    /// The camera matrix by rows.
    pub fn camera_matrix(&self) -> [f64; 9] {
        pinhole::camera_matrix(&self.camera)
    }

    /// The text of the file.
    pub fn to_yaml(&self) -> String {
        let mut text = format!(
            "image_width: {}\nimage_height: {}\ncamera_name: {}\n",
            self.camera.width,
            self.camera.height,
            scalar(&self.camera_name)
        );
        let matrix = |name: &str, columns: usize, data: &[f64]| {
            let rows = data.len() / columns;
            let data = flow_sequence(data);
            format!("{name}:\n  rows: {rows}\n  cols: {columns}\n  data: {data}\n")
        };
        text += &matrix("camera_matrix", 3, &self.camera_matrix());
        text += &format!("distortion_model: {}\n", self.camera.model());
        let distortion = self.camera.distortion.coefficients();
        text += &matrix("distortion_coefficients", distortion.len(), &distortion);
        text += &matrix("rectification_matrix", 3, &self.rectification);
        text += &matrix("projection_matrix", 4, &self.projection);
        if let Some([x, y]) = self.binning {
            text += &format!("binning_x: {x}\nbinning_y: {y}\n");
        }
        if let Some(roi) = &self.roi {
            text += &format!(
                "roi:\n  x_offset: {}\n  y_offset: {}\n  height: {}\n  width: {}\n  do_rectify: {}\n",
                roi.x_offset, roi.y_offset, roi.height, roi.width, roi.do_rectify
            );
        }
        text
    }

    /// Reads the text of a file. As for the ROS parsers, the rectification and projection matrices may be missing, a file without
    /// a model is `plumb_bob`, and unknown keys are ignored.
    ///
    /// # Errors
    /// [`CameraFileError`] names the key and what was expected.
    pub fn from_yaml(text: &str) -> Result<Self, CameraFileError> {
        let file: File = serde_saphyr::from_str(text).map_err(|error| CameraFileError::Syntax {
            format: "a camera_info file",
            reason: error.to_string(),
        })?;
        let k = file.camera_matrix.values("camera_matrix", "3 x 3")?;
        let camera = pinhole::camera(
            (file.image_width, file.image_height),
            pinhole::intrinsics(&k)?,
            file.lens()?,
        )?;
        let mut info = Self::new(file.camera_name, camera);
        if let Some(matrix) = &file.rectification_matrix {
            info.rectification = matrix.values("rectification_matrix", "3 x 3")?;
        }
        if let Some(matrix) = &file.projection_matrix {
            info.projection = matrix.values("projection_matrix", "3 x 4")?;
        }
        info.binning = match (file.binning_x, file.binning_y) {
            (None, None) => None,
            (x, y) => Some([x.unwrap_or(0), y.unwrap_or(0)]),
        };
        info.roi = file.roi;
        Ok(info)
    }
}

/// The keys as written.
#[derive(Deserialize)]
struct File {
    image_width: u32,
    image_height: u32,
    #[serde(default)]
    camera_name: String,
    camera_matrix: Matrix,
    distortion_model: Option<String>,
    distortion_coefficients: Matrix,
    rectification_matrix: Option<Matrix>,
    projection_matrix: Option<Matrix>,
    binning_x: Option<u32>,
    binning_y: Option<u32>,
    roi: Option<RegionOfInterest>,
}

impl File {
    fn lens(&self) -> Result<Distortion, CameraFileError> {
        let model = match self.distortion_model.as_deref() {
            None => LensModel::PlumbBob,
            // OpenCV's name for the same
            Some("fisheye") => LensModel::Equidistant,
            Some(name) => name.parse().map_err(|_| CameraFileError::Model {
                key: "distortion_model",
                model: name.to_owned(),
                supported: "plumb_bob, rational_polynomial and equidistant",
            })?,
        };
        let name = "distortion_coefficients";
        let expected = match model {
            LensModel::PlumbBob => "1 x 5",
            LensModel::RationalPolynomial => "1 x 8",
            LensModel::Equidistant => "1 x 4",
        };
        let values = self.distortion_coefficients.vector(name, expected)?;
        let lens = match model {
            LensModel::Equidistant => Distortion::new(model, values),
            // drivers also write the four coefficients of a plumb_bob without k3
            _ => lens_by_count(name, values)?.filter(|lens| lens.model() == model),
        };
        lens.ok_or_else(|| self.distortion_coefficients.wrong_size(name, expected))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::synthetic::wide;
    use crate::camera::{Intrinsics, PlumbBob};
    use proptest::prelude::*;

    #[test]
    fn the_text_is_that_of_the_ros_parsers() {
        let text = CameraInfo::new("front", wide()).to_yaml();
        let expected = "\
image_width: 640
image_height: 480
camera_name: front
camera_matrix:
  rows: 3
  cols: 3
  data: [401.5, 0.0, 322.4, 0.0, 399.2, 236.1, 0.0, 0.0, 1.0]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.3, 0.09, 0.0008, -0.0012, -0.01]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
projection_matrix:
  rows: 3
  cols: 4
  data: [401.5, 0.0, 322.4, 0.0, 0.0, 399.2, 236.1, 0.0, 0.0, 0.0, 1.0, 0.0]
";
        assert_eq!(text, expected);
    }

    proptest! {
        #[test]
        fn what_is_written_is_read(
            k in prop::array::uniform2(1e-3..1e6_f64),
            c in prop::array::uniform2(prop::num::f64::NORMAL),
            d in prop::array::uniform5(prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL | prop::num::f64::ZERO),
            name in ".*",
            binning in prop::option::of(prop::array::uniform2(0..9_u32)),
        ) {
            let mut camera = wide();
            camera.intrinsics = Intrinsics { fx: k[0], fy: k[1], cx: c[0], cy: c[1] };
            camera.distortion = PlumbBob { k1: d[0], k2: d[1], p1: d[2], p2: d[3], k3: d[4] }.into();
            let mut info = CameraInfo::new(name, camera);
            info.binning = binning;
            info.roi = binning.map(|b| RegionOfInterest {
                x_offset: b[0],
                y_offset: 1,
                height: 2,
                width: 3,
                do_rectify: b[1] > 4,
            });
            prop_assert_eq!(CameraInfo::from_yaml(&info.to_yaml()).unwrap(), info);
        }
    }

    #[test]
    fn names_that_yaml_would_take_for_something_else_stay_names() {
        for name in [
            "no", "1e3", "", "a: b", "null", "on", "0x10", "- x", "~", "#1",
        ] {
            let info = CameraInfo::new(name, wide());
            let back = CameraInfo::from_yaml(&info.to_yaml()).unwrap();
            assert_eq!(back.camera_name, name);
            assert!(info.to_yaml().contains("camera_name: \""), "{name}");
        }
    }

    #[test]
    fn refusals_name_the_key() {
        let good = CameraInfo::new("front", wide()).to_yaml();
        let refused = |from: &str, to: &str| {
            assert!(good.contains(from));
            CameraInfo::from_yaml(&good.replace(from, to))
                .unwrap_err()
                .to_string()
        };
        assert!(refused("plumb_bob", "thin_prism").contains("\"thin_prism\" is not supported"));
        assert!(refused("[401.5,", "[0.0,").contains("not calibrated"));
        assert!(
            refused(", -0.01]", "]").contains("distortion_coefficients has 1 rows, 5 cols and 4")
        );
        assert!(refused("cols: 4", "cols: 3").contains("projection_matrix"));
        assert!(refused("-0.3", ".nan").contains("not finite"));
        assert!(refused("image_width: 640", "image_width: 0").contains("image_width 0"));
        assert!(refused("camera_matrix:", "matrix:").contains("camera_matrix"));
        assert!(refused("401.5, 0.0,", "401.5, 0.5,").contains("row 1 column 2 is 0.5"));
        assert!(CameraInfo::from_yaml("- 1\n- 2").is_err());
    }

    #[test]
    fn what_ros_reads_is_read() {
        let info = CameraInfo::new("front", wide());
        let old = info.to_yaml().replace("distortion_model: plumb_bob\n", "");
        assert_eq!(CameraInfo::from_yaml(&old).unwrap(), info);
        let four = old.replace("cols: 5", "cols: 4").replace(", -0.01]", "]");
        let read = CameraInfo::from_yaml(&four).unwrap();
        let coefficients = read.camera.distortion.coefficients();
        assert_eq!(coefficients, [-0.3, 0.09, 0.0008, -0.0012, 0.0]);
    }
}
