//! OpenCV's FileStorage in YAML, with the keys of its camera calibration sample.
//!
//! The number of the coefficients is the model, as in OpenCV itself: 5 are `plumb_bob`, 8 `rational_polynomial`. Its fisheye
//! functions have another model with 4; the sample marks it with `fisheye_model: 1`, and so does this file. The name of the camera is an
//! additional key, `camera_name`, which OpenCV reads like any other.
//!
//! FileStorage begins with `%YAML:1.0`, which is no YAML directive (OpenCV 5 writes one, and reads both), and has tags that no other
//! program knows; both are taken off before the text is read as YAML. FileStorage's JSON is read as well, because JSON is YAML.

use super::camera_file_error::{CameraFileError, CannotExpress};
use super::camera_info::CameraInfo;
use super::pinhole::{self, Matrix, lens_by_count};
use super::yaml_number::flow_sequence;
use crate::camera::{Distortion, LensModel};
use serde::Deserialize;

/// What marks a matrix, and with it the file.
pub(super) const MARK: &str = "opencv-matrix";
/// What marks the lists of OpenCV 5.
const LIST: &str = "!!opencv-nd-matrix";

/// The text of the file.
pub(super) fn write(info: &CameraInfo) -> Result<String, CannotExpress> {
    let camera = &info.camera;
    let matrix = |key: &str, columns: usize, values: &[f64]| {
        format!(
            "{key}: !!{MARK}\n   rows: {}\n   cols: {columns}\n   dt: d\n   data: {}\n",
            values.len() / columns,
            flow_sequence(values)
        )
    };
    let fisheye = u8::from(camera.model() == LensModel::Equidistant);
    Ok(format!(
        "%YAML:1.0\n---\ncamera_name: {}\nimage_width: {}\nimage_height: {}\nfisheye_model: {fisheye}\n",
        string(&info.camera_name)?,
        camera.width,
        camera.height
    ) + &matrix("camera_matrix", 3, &info.camera_matrix())
        + &matrix(
            "distortion_coefficients",
            1,
            &camera.distortion.coefficients(),
        ))
}

/// A string in quotes. FileStorage knows few of YAML's escapes, and takes the bytes of other characters as they are.
fn string(text: &str) -> Result<String, CannotExpress> {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            '\n' => out += "\\n",
            '\r' => out += "\\r",
            '\t' => out += "\\t",
            _ if c.is_control() => {
                return Err(CannotExpress::Name {
                    format: "OpenCV",
                    name: text.to_owned(),
                    why: "it has no escape for such a character",
                });
            }
            _ => out.push(c),
        }
    }
    Ok(out + "\"")
}

/// Reads the text of a file.
pub(super) fn read(text: &str) -> Result<CameraInfo, CameraFileError> {
    let syntax = |reason: String| CameraFileError::Syntax {
        format: "an OpenCV FileStorage file",
        reason,
    };
    let yaml = match text.split_once('\n') {
        Some((first, rest)) if first.starts_with("%YAML") => rest,
        _ => text,
    };
    let yaml = yaml.replace(&format!("!!{MARK}"), "").replace(LIST, "");
    let file: File = serde_saphyr::from_str(&yaml).map_err(|error| syntax(error.to_string()))?;
    let name = "distortion_coefficients";
    let (lens, expected) = if file.fisheye_model != 0 {
        let values = file.distortion_coefficients.vector(name, "4 x 1")?;
        (Distortion::new(LensModel::Equidistant, values), "4 x 1")
    } else {
        let values = file.distortion_coefficients.vector(name, "5 x 1")?;
        (
            lens_by_count(name, values)?,
            "4, 5, 8, 12 or 14 rows and 1 column",
        )
    };
    let lens = lens.ok_or_else(|| file.distortion_coefficients.wrong_size(name, expected))?;
    let k = file.camera_matrix.values("camera_matrix", "3 x 3")?;
    let size = (file.image_width, file.image_height);
    let camera = pinhole::camera(size, pinhole::intrinsics(&k)?, lens)?;
    Ok(CameraInfo::new(file.camera_name, camera))
}

/// The keys as written; another key is ignored.
#[derive(Deserialize)]
struct File {
    #[serde(default)]
    camera_name: String,
    image_width: u32,
    image_height: u32,
    #[serde(default)]
    fisheye_model: i64,
    camera_matrix: Matrix,
    distortion_coefficients: Matrix,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::synthetic::wide;
    use crate::camera::Equidistant;

    #[test]
    fn the_text_is_that_of_file_storage() {
        let text = write(&CameraInfo::new("front", wide())).unwrap();
        let expected = "%YAML:1.0\n---\ncamera_name: \"front\"\nimage_width: 640\nimage_height: 480\nfisheye_model: 0\n\
            camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   \
            data: [401.5, 0.0, 322.4, 0.0, 399.2, 236.1, 0.0, 0.0, 1.0]\n\
            distortion_coefficients: !!opencv-matrix\n   rows: 5\n   cols: 1\n   dt: d\n   \
            data: [-0.3, 0.09, 0.0008, -0.0012, -0.01]\n";
        assert_eq!(text, expected);
    }

    #[test]
    fn names_are_escaped_or_refused() {
        let name = "a \"b\" \\ c\n\u{e9}";
        let text = write(&CameraInfo::new(name, wide())).unwrap();
        assert!(text.contains(r#"camera_name: "a \"b\" \\ c\né""#), "{text}");
        assert_eq!(read(&text).unwrap().camera_name, name);
        let said = write(&CameraInfo::new("a\u{7}", wide())).unwrap_err();
        assert!(
            said.to_string().contains("camera name \"a\\u{7}\""),
            "{said}"
        );
    }

    /// As OpenCV writes it: its own form of numbers, broken lines, a row of coefficients, and more keys.
    #[test]
    fn what_the_sample_writes_is_read() {
        let text = "%YAML:1.0\n---\ncalibration_time: \"Wed 25 Nov 2026\"\nnr_of_frames: 20\nimage_width: 640\n\
            image_height: 480\nboard_width: 9\nsquare_size: 50.\n# flags:  +fix_k4 +fix_k5\nflags: 6144\n\
            fisheye_model: 0\ncamera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   \
            data: [ 6.5746697944293521e+02, 0., 3.1950000000000000e+02, 0.,\n       \
            6.5746697944293521e+02, 2.3950000000000000e+02, 0., 0., 1. ]\n\
            distortion_coefficients: !!opencv-matrix\n   rows: 1\n   cols: 5\n   dt: d\n   \
            data: [ -4.1802327176423804e-01, 5.0715244063187526e-01, 0., 0.,\n       -5.7843597214487474e-01 ]\n";
        let camera = read(text).unwrap().camera;
        assert_eq!(camera.intrinsics.fx, 657.466_979_442_935_2);
        assert_eq!(
            camera.distortion.coefficients()[4],
            -0.578_435_972_144_874_7
        );
        let fisheye = text.replace("fisheye_model: 0", "fisheye_model: 1");
        let said = read(&fisheye).unwrap_err().to_string();
        assert!(
            said.contains("1 rows, 5 cols and 5 values, 4 x 1"),
            "{said}"
        );
    }

    #[test]
    fn lists_of_opencv_5_are_read() {
        let text = write(&CameraInfo::new("front", wide())).unwrap();
        let five = text.replace("%YAML:1.0", "%YAML 1.2").replace(
            "!!opencv-matrix\n   rows: 5\n   cols: 1",
            "!!opencv-nd-matrix\n   sizes: [ 5 ]",
        );
        assert!(five.contains("nd-matrix"));
        assert_eq!(read(&five).unwrap().camera, wide());
        assert!(read(&five.replace("[ 5 ]", "[ 4 ]")).is_err());
    }

    #[test]
    fn json_of_file_storage_is_read() {
        let text = r#"{ "image_width": 640, "image_height": 480, "fisheye_model": 1,
            "camera_matrix": { "type_id": "opencv-matrix", "rows": 3, "cols": 3, "dt": "d",
                "data": [ 401.5, 0.0, 322.4, 0.0, 399.2, 236.1, 0.0, 0.0, 1.0 ] },
            "distortion_coefficients": { "type_id": "opencv-matrix", "rows": 4, "cols": 1, "dt": "d",
                "data": [ 0.1, 0.2, 0.3, 0.4 ] } }"#;
        let lens = Equidistant {
            k: [0.1, 0.2, 0.3, 0.4],
        };
        assert_eq!(read(text).unwrap().camera.distortion, lens.into());
    }

    #[test]
    fn refusals_name_the_key() {
        let good = write(&CameraInfo::new("front", wide())).unwrap();
        let refused = |from: &str, to: &str| {
            assert!(good.contains(from), "{from}");
            read(&good.replace(from, to)).unwrap_err().to_string()
        };
        assert!(refused("image_width: 640\n", "").contains("image_width"));
        assert!(refused("-0.3", ".nan").contains("not finite"));
        assert!(refused("-0.3", ".Nan").contains("not an OpenCV FileStorage file"));
        assert!(refused("-0.3", ".Inf").contains("not finite"));
        assert!(refused("-0.3,", "").contains("5 rows, 1 cols and 4 values"));
        assert!(refused("[401.5, 0.0,", "[401.5, 0.1,").contains("row 1 column 2"));
        assert!(refused("image_height: 480", "image_height: 0").contains("image_height 0"));
        assert!(refused("[-0.3", "[[-0.3").contains("not an OpenCV FileStorage file"));
    }
}
