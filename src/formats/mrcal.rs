//! mrcal's .cameramodel.
//!
//! Its LENSMODEL_OPENCV5 and LENSMODEL_OPENCV8 are `plumb_bob` and `rational_polynomial`, with the same order of the
//! coefficients and the same pixel coordinates. None of its models is the fisheye of ROS: LENSMODEL_STEREOGRAPHIC has no coefficients, the
//! CAHVOR family and the splines are other functions. The file has no place for the name of the camera. The extrinsics say where
//! a camera stands among others; a single one stands at the origin.

use super::camera_file_error::{CameraFileError, CannotExpress};
use super::camera_info::CameraInfo;
use super::pinhole::{self, finite, lens_by_count};
use super::python_literal::{Literal, parse};
use super::yaml_number::number;
use crate::camera::{Intrinsics, LensModel};

const SUPPORTED: &str = "LENSMODEL_PINHOLE and LENSMODEL_OPENCV4, 5, 8 and 12";

/// The text of the file.
pub(super) fn write(info: &CameraInfo) -> Result<String, CannotExpress> {
    let camera = &info.camera;
    let model = match camera.model() {
        LensModel::PlumbBob => "LENSMODEL_OPENCV5",
        LensModel::RationalPolynomial => "LENSMODEL_OPENCV8",
        LensModel::Equidistant => {
            return Err(CannotExpress::Model {
                format: "mrcal",
                model: camera.model(),
            });
        }
    };
    let numbers: Vec<String> = camera.parameters().into_iter().map(number).collect();
    Ok(format!(
        "{{\n    'lensmodel':  '{model}',\n\n    # {}\n    'intrinsics': [{}],\n\n    \
         # rotation vector and translation, from the reference to the camera\n    \
         'extrinsics': [0.0, 0.0, 0.0, 0.0, 0.0, 0.0],\n\n    'imagersize': [{}, {}],\n}}\n",
        camera.parameter_names().join(", "),
        numbers.join(", "),
        camera.width,
        camera.height
    ))
}

/// Reads the text of a file.
pub(super) fn read(text: &str) -> Result<CameraInfo, CameraFileError> {
    let value = parse(text).map_err(|error| syntax(error.to_string()))?;
    let Literal::Map(entries) = value else {
        return Err(syntax("it is no dictionary".to_owned()));
    };
    let file = File(entries);
    let model = match file.get("lensmodel")? {
        Literal::Text(model) => model,
        _ => return Err(syntax("lensmodel is no string".to_owned())),
    };
    let count = match model.as_str() {
        "LENSMODEL_PINHOLE" => 0,
        "LENSMODEL_OPENCV4" => 4,
        "LENSMODEL_OPENCV5" => 5,
        "LENSMODEL_OPENCV8" => 8,
        "LENSMODEL_OPENCV12" => 12,
        _ => {
            return Err(CameraFileError::Model {
                key: "lensmodel",
                model: model.clone(),
                supported: SUPPORTED,
            });
        }
    };
    let values = file.numbers("intrinsics")?;
    let wrong = || CameraFileError::Count {
        name: "intrinsics",
        values: values.len(),
        expected: (4 + count).to_string(),
    };
    let ([fx, fy, cx, cy], coefficients) = values.split_first_chunk().ok_or_else(wrong)?;
    if coefficients.len() != count {
        return Err(wrong());
    }
    let lens = lens_by_count("intrinsics", coefficients)?.ok_or_else(wrong)?;
    let intrinsics = Intrinsics {
        fx: *fx,
        fy: *fy,
        cx: *cx,
        cy: *cy,
    };
    let camera = pinhole::camera(file.size()?, intrinsics, lens)?;
    Ok(CameraInfo::new("", camera))
}

fn syntax(reason: String) -> CameraFileError {
    CameraFileError::Syntax {
        format: "an mrcal cameramodel",
        reason,
    }
}

struct File(Vec<(String, Literal)>);

impl File {
    fn get(&self, key: &str) -> Result<&Literal, CameraFileError> {
        let found = self.0.iter().find(|(name, _)| name == key);
        let found = found.map(|(_, value)| value);
        found.ok_or_else(|| syntax(format!("{key} is missing")))
    }

    fn numbers(&self, key: &'static str) -> Result<Vec<f64>, CameraFileError> {
        let no_list = || syntax(format!("{key} is no list of numbers"));
        let Literal::Sequence(values) = self.get(key)? else {
            return Err(no_list());
        };
        let number = |value: &Literal| match value {
            Literal::Number(number) => Ok(*number),
            _ => Err(no_list()),
        };
        let values: Vec<f64> = values.iter().map(number).collect::<Result<_, _>>()?;
        finite(key, &values)?;
        Ok(values)
    }

    fn size(&self) -> Result<(u32, u32), CameraFileError> {
        let values = self.numbers("imagersize")?;
        let whole = |v: &f64| v.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(v);
        match values.as_slice() {
            // whole and in range: the conversion is exact
            [width, height] if whole(width) && whole(height) => Ok((*width as u32, *height as u32)),
            [_, _] => Err(syntax(format!(
                "imagersize {values:?} is no number of pixels"
            ))),
            _ => Err(CameraFileError::Count {
                name: "imagersize",
                values: values.len(),
                expected: "2".to_owned(),
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::synthetic::wide;
    use crate::camera::{Camera, Equidistant};

    #[test]
    fn the_text_is_a_dictionary() {
        let text = write(&CameraInfo::new("front", wide())).unwrap();
        let expected = "{\n    'lensmodel':  'LENSMODEL_OPENCV5',\n\n    # fx, fy, cx, cy, k1, k2, p1, p2, k3\n    \
            'intrinsics': [401.5, 399.2, 322.4, 236.1, -0.3, 0.09, 0.0008, -0.0012, -0.01],\n\n    \
            # rotation vector and translation, from the reference to the camera\n    \
            'extrinsics': [0.0, 0.0, 0.0, 0.0, 0.0, 0.0],\n\n    'imagersize': [640, 480],\n}\n";
        assert_eq!(text, expected);
    }

    #[test]
    fn a_fisheye_has_no_model_there() {
        let lens = Equidistant { k: [0.1; 4] };
        let camera = Camera {
            distortion: lens.into(),
            ..wide()
        };
        let said = write(&CameraInfo::new("front", camera)).unwrap_err();
        assert_eq!(said.to_string(), "mrcal has no equidistant lens");
    }

    #[test]
    fn its_other_opencv_models_are_read() {
        let of = |model: &str, coefficients: &str| {
            let text = format!(
                "# generated\n{{'lensmodel': 'LENSMODEL_{model}', 'intrinsics': (500, 510, 320, 240, {coefficients}),\n\
                 'extrinsics': [1,2,3,0,0,0], 'imagersize': [640,480], 'icam_intrinsics': 0,\n\
                 'optimization_inputs': b'P)h>@6aWAK', }}"
            );
            read(&text).map(|info| info.camera.distortion.coefficients())
        };
        assert_eq!(of("PINHOLE", "").unwrap(), [0.0; 5]);
        assert_eq!(of("OPENCV4", "1,2,3,4").unwrap(), [1.0, 2.0, 3.0, 4.0, 0.0]);
        let twelve = of("OPENCV12", "1,2,3,4,5,6,7,8,0,0,0,0").unwrap();
        assert_eq!(twelve, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
        let prism = of("OPENCV12", "1,2,3,4,5,6,7,8,9,0,0,0").unwrap_err();
        assert!(prism.to_string().contains("thin prism"));
        let said = of("CAHVOR", "1,2,3,4,5").unwrap_err().to_string();
        assert!(
            said.contains("lensmodel \"LENSMODEL_CAHVOR\" is not supported"),
            "{said}"
        );
        let said = of("OPENCV5", "1,2,3,4").unwrap_err().to_string();
        assert!(
            said.contains("intrinsics has 8 values, 9 are needed"),
            "{said}"
        );
    }

    #[test]
    fn refusals_name_the_key() {
        let good = write(&CameraInfo::new("front", wide())).unwrap();
        let refused = |from: &str, to: &str| {
            assert!(good.contains(from), "{from}");
            read(&good.replace(from, to)).unwrap_err().to_string()
        };
        assert!(refused("'lensmodel'", "'model'").contains("lensmodel is missing"));
        assert!(refused("'LENSMODEL_OPENCV5'", "5").contains("lensmodel is no string"));
        assert!(refused("401.5", "'401.5'").contains("intrinsics is no list of numbers"));
        assert!(refused("401.5", "1e999").contains("intrinsics holds"));
        assert!(refused("401.5", "-401.5").contains("not calibrated"));
        assert!(refused("401.5", "nan").contains("line 5"));
        assert!(refused("[640, 480]", "[640.5, 480]").contains("no number of pixels"));
        assert!(refused("[640, 480]", "[640]").contains("imagersize has 1 values"));
        assert!(refused("[640, 480]", "[0, 480]").contains("image_width 0"));
        assert!(
            read("[1, 2]")
                .unwrap_err()
                .to_string()
                .contains("no dictionary")
        );
    }
}
