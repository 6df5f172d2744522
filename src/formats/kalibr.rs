//! Kalibr's camchain.yaml.
//!
//! `radtan` is `plumb_bob` without k3, `equidistant` the fisheye of ROS, `none` a pinhole. Kalibr's other projections (omni,
//! eucm, ds) and its `fov` distortion are models that ringcal does not have. A camera is named by its place in the chain there (cam0) and
//! by its topic: the name is written into the topic, and taken from it.

use super::camera_file_error::{CameraFileError, CannotExpress};
use super::camera_info::CameraInfo;
use super::choice::choose;
use super::pinhole::{self, finite};
use super::yaml_number::{flow_sequence, scalar};
use crate::camera::{Camera, Distortion, Intrinsics, LensModel};
use serde::Deserialize;
use std::collections::BTreeMap;

/// The text of the file, a chain of one camera.
pub(super) fn write(info: &CameraInfo) -> Result<String, CannotExpress> {
    let camera = &info.camera;
    let coefficients = camera.distortion.coefficients();
    let model = match camera.model() {
        LensModel::Equidistant => "equidistant",
        LensModel::PlumbBob | LensModel::RationalPolynomial => "radtan",
    };
    let names = camera.parameter_names()[4..].iter().copied();
    let beyond: Vec<_> = names
        .zip(coefficients.iter().copied())
        .skip(4)
        .filter(|(_, value)| *value != 0.0)
        .collect();
    if !beyond.is_empty() {
        return Err(CannotExpress::Coefficients {
            format: "Kalibr",
            model: camera.model(),
            beyond,
        });
    }
    let Intrinsics { fx, fy, cx, cy } = camera.intrinsics;
    Ok(format!(
        "cam0:\n  camera_model: pinhole\n  intrinsics: {}\n  distortion_model: {model}\n  distortion_coeffs: {}\n  \
         resolution: [{}, {}]\n  rostopic: {}\n",
        flow_sequence(&[fx, fy, cx, cy]),
        flow_sequence(&coefficients[..4]),
        camera.width,
        camera.height,
        scalar(&format!("/{}/image_raw", info.camera_name)),
    ))
}

/// Reads the text of a file; of a chain of several cameras the one that is wanted (cam0, cam1, ...).
pub(super) fn read(text: &str, wanted: Option<&str>) -> Result<CameraInfo, CameraFileError> {
    let chain: BTreeMap<String, Entry> =
        serde_saphyr::from_str(text).map_err(|error| CameraFileError::Syntax {
            format: "a Kalibr camchain",
            reason: error.to_string(),
        })?;
    let names: Vec<&str> = chain.keys().map(String::as_str).collect();
    let name = names[choose(&names, wanted)?];
    let entry = &chain[name];
    let topic = entry.rostopic.as_deref();
    let named = topic.and_then(|topic| topic.strip_prefix('/')?.strip_suffix("/image_raw"));
    Ok(CameraInfo::new(named.unwrap_or(name), entry.camera()?))
}

/// The keys of one camera; another key, such as where it stands in the chain, is ignored.
#[derive(Deserialize)]
struct Entry {
    camera_model: String,
    intrinsics: Vec<f64>,
    distortion_model: String,
    #[serde(default)]
    distortion_coeffs: Vec<f64>,
    resolution: Vec<u32>,
    rostopic: Option<String>,
}

impl Entry {
    fn camera(&self) -> Result<Camera, CameraFileError> {
        if self.camera_model != "pinhole" {
            return Err(CameraFileError::Model {
                key: "camera_model",
                model: self.camera_model.clone(),
                supported: "pinhole cameras",
            });
        }
        let [fx, fy, cx, cy] = numbers("intrinsics", &self.intrinsics)?;
        let [width, height] = numbers("resolution", &self.resolution)?;
        let intrinsics = Intrinsics { fx, fy, cx, cy };
        pinhole::camera((width, height), intrinsics, self.lens()?)
    }

    fn lens(&self) -> Result<Distortion, CameraFileError> {
        let name = "distortion_coeffs";
        finite(name, &self.distortion_coeffs)?;
        let four = || numbers(name, &self.distortion_coeffs);
        let (model, values) = match self.distortion_model.as_str() {
            "radtan" => {
                let [k1, k2, p1, p2] = four()?;
                (LensModel::PlumbBob, vec![k1, k2, p1, p2, 0.0])
            }
            "equidistant" => (LensModel::Equidistant, four()?.to_vec()),
            "none" => {
                let [] = numbers(name, &self.distortion_coeffs)?;
                (LensModel::PlumbBob, vec![0.0; 5])
            }
            other => {
                return Err(CameraFileError::Model {
                    key: "distortion_model",
                    model: other.to_owned(),
                    supported: "radtan, equidistant and none",
                });
            }
        };
        Distortion::new(model, &values).ok_or_else(|| CameraFileError::Count {
            name,
            values: values.len(),
            expected: model.coefficient_count().to_string(),
        })
    }
}

fn numbers<T: Copy, const N: usize>(
    name: &'static str,
    values: &[T],
) -> Result<[T; N], CameraFileError> {
    values.try_into().map_err(|_| CameraFileError::Count {
        name,
        values: values.len(),
        expected: N.to_string(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::synthetic::wide;
    use crate::camera::{PlumbBob, RationalPolynomial};

    /// Without k3.
    fn plain() -> Camera {
        let lens = PlumbBob {
            k1: -0.3,
            p1: 0.0008,
            ..PlumbBob::default()
        };
        Camera {
            distortion: lens.into(),
            ..wide()
        }
    }

    #[test]
    fn the_text_is_a_chain_of_one() {
        let text = write(&CameraInfo::new("front", plain())).unwrap();
        let expected = "cam0:\n  camera_model: pinhole\n  intrinsics: [401.5, 399.2, 322.4, 236.1]\n  \
            distortion_model: radtan\n  distortion_coeffs: [-0.3, 0.0, 0.0008, 0.0]\n  resolution: [640, 480]\n  \
            rostopic: \"/front/image_raw\"\n";
        assert_eq!(text, expected);
    }

    #[test]
    fn coefficients_without_a_place_are_named() {
        let lens = RationalPolynomial {
            k1: 0.1,
            k3: -0.01,
            k5: 0.25,
            ..RationalPolynomial::default()
        };
        let camera = Camera {
            distortion: lens.into(),
            ..wide()
        };
        let said = write(&CameraInfo::new("a", camera))
            .unwrap_err()
            .to_string();
        assert!(
            said.starts_with("Kalibr has the coefficients k1, k2, p1 and p2 only"),
            "{said}"
        );
        assert!(
            said.contains("rational_polynomial lens has k3 = -0.01, k5 = 0.25 as well"),
            "{said}"
        );
    }

    #[test]
    fn a_chain_of_two_is_asked_which() {
        let one = write(&CameraInfo::new("left", plain())).unwrap();
        let two = one.replace("cam0", "cam1").replace("left", "right")
            + "  T_cn_cnm1:\n  - [1.0, 0.0, 0.0, -0.1]\n  - [0.0, 1.0, 0.0, 0.0]\n  - [0.0, 0.0, 1.0, 0.0]\n  \
               - [0.0, 0.0, 0.0, 1.0]\n  cam_overlaps: [0]\n";
        let both = one + &two;
        let said = read(&both, None).unwrap_err().to_string();
        assert!(said.contains("several cameras: cam0, cam1"), "{said}");
        assert_eq!(read(&both, Some("cam1")).unwrap().camera_name, "right");
        let said = read(&both, Some("cam2")).unwrap_err().to_string();
        assert!(
            said.contains("no camera \"cam2\", but cam0, cam1"),
            "{said}"
        );
    }

    #[test]
    fn another_topic_leaves_the_name_of_the_chain_and_none_is_a_pinhole() {
        let text = write(&CameraInfo::new("left", plain())).unwrap();
        let read = |text: &str| read(text, None).unwrap();
        let compressed = text.replace("image_raw", "image/compressed");
        assert_eq!(read(&compressed).camera_name, "cam0");
        let none = text
            .replace("radtan", "none")
            .replace("[-0.3, 0.0, 0.0008, 0.0]", "[]");
        assert!(read(&none).camera.distortion.is_none());
    }

    #[test]
    fn refusals_name_the_key() {
        let good = write(&CameraInfo::new("front", plain())).unwrap();
        let refused = |from: &str, to: &str| {
            assert!(good.contains(from), "{from}");
            read(&good.replace(from, to), None).unwrap_err().to_string()
        };
        assert!(refused("pinhole", "ds").contains("camera_model \"ds\" is not supported"));
        assert!(refused("radtan", "fov").contains("distortion_model \"fov\" is not supported"));
        assert!(refused("radtan", "none").contains("distortion_coeffs has 4 values, 0"));
        assert!(refused("[-0.3, ", "[").contains("distortion_coeffs has 3 values, 4"));
        assert!(refused("-0.3", ".nan").contains("distortion_coeffs holds"));
        assert!(refused("[401.5,", "[.inf,").contains("not finite"));
        assert!(refused("[401.5,", "[").contains("intrinsics has 3 values"));
        assert!(refused("[640, 480]", "[640]").contains("resolution has 1 values, 2"));
        assert!(refused("[640, 480]", "[640, -480]").contains("not a Kalibr camchain"));
        assert!(refused("  intrinsics", "  numbers").contains("intrinsics"));
    }
}
