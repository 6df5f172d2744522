//! Every file that can hold a camera: which format it is in, and how it is read and written.
//!
//! A format is known by its content, never by its name, so that wherever a camera is asked for any of them will do. Reading gives a
//! [`CameraInfo`], the most that any of them holds. Writing says what a format cannot express instead of writing another camera.

use super::camera_file_error::{CameraFileError, CannotExpress};
use super::camera_info::CameraInfo;
use super::pinhole::IDENTITY;
use super::{camera_json, kalibr, mrcal, opencv_yaml, ost};
use std::fmt;
use std::path::Path;
use std::str::FromStr;

/// A format that a camera can be written in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum CameraFormat {
    /// The YAML of camera_calibration_parsers.
    CameraInfo,
    /// The INI file of camera_calibration.
    Ost,
    /// FileStorage of OpenCV.
    OpenCv,
    /// The camchain of Kalibr.
    Kalibr,
    /// The cameramodel of mrcal.
    Mrcal,
}

/// The name of no format.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("no format {0:?}; known are camera_info, ost, opencv, kalibr and mrcal")]
pub struct UnknownCameraFormat(pub String);

impl CameraFormat {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::CameraInfo,
        Self::Ost,
        Self::OpenCv,
        Self::Kalibr,
        Self::Mrcal,
    ];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::CameraInfo => "camera_info",
            Self::Ost => "ost",
            Self::OpenCv => "opencv",
            Self::Kalibr => "kalibr",
            Self::Mrcal => "mrcal",
        }
    }

    /// Name of the file that `ringcal calibrate` writes.
    pub fn file_name(self) -> &'static str {
        match self {
            Self::CameraInfo => "camera_info.yaml",
            Self::Ost => "ost.txt",
            Self::OpenCv => "opencv.yaml",
            Self::Kalibr => "camchain.yaml",
            Self::Mrcal => "camera.cameramodel",
        }
    }

    /// The format that a file of this name is expected to be in, as the programs name their files; `None` where the name does not tell.
    pub fn of_path(path: &Path) -> Option<Self> {
        let name = path.file_name()?.to_str()?.to_ascii_lowercase();
        let (stem, ending) = name.rsplit_once('.')?;
        match ending {
            "txt" | "ini" => Some(Self::Ost),
            "cameramodel" => Some(Self::Mrcal),
            "yaml" | "yml" if stem.contains("camchain") => Some(Self::Kalibr),
            "yaml" | "yml" if stem.contains("opencv") => Some(Self::OpenCv),
            "yaml" | "yml" => Some(Self::CameraInfo),
            _ => None,
        }
    }

    /// The text of a file in this format.
    ///
    /// # Errors
    /// [`CannotExpress`] says what the format has no place for.
    pub fn write(self, info: &CameraInfo) -> Result<String, CannotExpress> {
        let numbers = info.camera.parameters().into_iter();
        let mut all = numbers.chain(info.rectification).chain(info.projection);
        if let Some(odd) = all.find(|value| !value.is_finite()) {
            return Err(CannotExpress::NotFinite(odd));
        }
        match self {
            Self::CameraInfo => Ok(info.to_yaml()),
            Self::Ost => ost::write(info),
            Self::OpenCv => opencv_yaml::write(info),
            Self::Kalibr => kalibr::write(info),
            Self::Mrcal => mrcal::write(info),
        }
    }

    /// What a file in this format does not hold, besides the camera itself, that is known of it.
    pub fn leaves_out(self, info: &CameraInfo) -> Vec<&'static str> {
        let plain = CameraInfo::new("", info.camera);
        let ros = matches!(self, Self::CameraInfo | Self::Ost);
        let facts = [
            (
                !info.camera_name.is_empty() && self == Self::Mrcal,
                "the camera's name",
            ),
            (
                info.rectification != IDENTITY && !ros,
                "the rectification matrix",
            ),
            (
                info.projection != plain.projection && !ros,
                "the projection matrix",
            ),
            (
                info.binning.is_some() && self != Self::CameraInfo,
                "the binning",
            ),
            (
                info.roi.is_some() && self != Self::CameraInfo,
                "the region of interest",
            ),
        ];
        facts
            .iter()
            .filter(|fact| fact.0)
            .map(|fact| fact.1)
            .collect()
    }
}

impl fmt::Display for CameraFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for CameraFormat {
    type Err = UnknownCameraFormat;

    fn from_str(name: &str) -> Result<Self, UnknownCameraFormat> {
        Self::ALL
            .into_iter()
            .find(|format| format.name() == name)
            .ok_or_else(|| UnknownCameraFormat(name.to_owned()))
    }
}

/// Reads the camera of a file in any [`CameraFormat`], of calibration.json or of truth.json. Of several cameras it takes the one that is
/// `wanted` by its name.
///
/// # Errors
/// [`CameraFileError`] says what the text was taken for and what it lacks.
pub fn read_camera(text: &str, wanted: Option<&str>) -> Result<CameraInfo, CameraFileError> {
    // editors of other systems put a mark before the first character
    let text = text.trim_start_matches('\u{feff}');
    let info = match Content::of(text) {
        // these hold as many cameras as you like
        Content::Ost => return ost::read(text, wanted),
        Content::Kalibr => return kalibr::read(text, wanted),
        Content::CameraInfo => CameraInfo::from_yaml(text)?,
        Content::OpenCv => opencv_yaml::read(text)?,
        Content::Mrcal => mrcal::read(text)?,
        Content::Json => camera_json::read(text)?,
        Content::OpenCvXml => {
            return Err(CameraFileError::Syntax {
                format: "a camera file that can be read",
                reason: "OpenCV's FileStorage is read as YAML and JSON, not as XML".to_owned(),
            });
        }
    };
    match wanted {
        Some(wanted) if wanted != info.camera_name => Err(CameraFileError::NoSuchCamera {
            wanted: wanted.to_owned(),
            names: vec![match info.camera_name.as_str() {
                "" => "one without a name".to_owned(),
                name => name.to_owned(),
            }],
        }),
        _ => Ok(info),
    }
}

/// What a text looks like.
enum Content {
    CameraInfo,
    Ost,
    OpenCv,
    OpenCvXml,
    Kalibr,
    Mrcal,
    Json,
}

impl Content {
    fn of(text: &str) -> Self {
        let said = || {
            text.lines()
                .filter(|line| !line.trim_start().starts_with('#'))
        };
        let chained = |line: &str| {
            let key = line
                .strip_prefix("cam")
                .and_then(|rest| rest.split_once(':'));
            key.is_some_and(|(number, _)| number.parse::<u8>().is_ok())
        };
        let first = said().find_map(|line| line.trim_start().chars().next());
        if text.contains("<opencv_storage>") {
            Self::OpenCvXml
        } else if text.contains(opencv_yaml::MARK) {
            Self::OpenCv
        } else if said().any(|line| line.trim() == "[image]") {
            Self::Ost
        } else if said().any(chained) {
            Self::Kalibr
        } else if first == Some('{') && text.contains("lensmodel") {
            Self::Mrcal
        } else if first == Some('{') && text.contains("\"parameters\"") {
            Self::Json
        } else {
            // of all the formats the one that users of ROS have, so that the refusal of any other text names its keys
            Self::CameraInfo
        }
    }
}

#[cfg(test)]
mod tests;
