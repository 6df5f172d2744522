//! What the parameters mean, checked as a whole.

use super::parameters::{ParameterError, ParameterValues};
use crate::calibrate::{Fixed, ModelChoice};
use crate::centre::Estimator;
use crate::centre::photometric::{PsfChoice, ResponseGamma};
use crate::detect::Required;
use crate::report::Quality;
use crate::session::SessionRules;
use ros2_client::ParameterValue;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// The parameters of the node as its parts need them.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Path of the board file.
    pub board_file: PathBuf,
    /// How the projected centres are found.
    pub estimator: Estimator,
    /// Which shape of blur the photometric estimator fits.
    pub psf: PsfChoice,
    /// How the grey values follow the light.
    pub response_gamma: ResponseGamma,
    /// How much of the board must be seen.
    pub required: Required,
    /// The lens model.
    pub model: ModelChoice,
    /// Camera parameters that are not estimated.
    pub fixed: Fixed,
    /// When a frame is kept.
    pub rules: SessionRules,
    /// Calibrate without being asked.
    pub auto_calibrate: bool,
    /// Name of the camera in what is saved.
    pub camera_name: String,
    /// Folder for what is saved; `None` where the default is wanted.
    pub save_dir: Option<PathBuf>,
    /// Size of the uncompressed pictures relative to the frame.
    pub debug_scale: f64,
    /// Quality of the compressed pictures.
    pub jpeg_quality: Quality,
}

impl Settings {
    /// Reads the values.
    ///
    /// # Errors
    /// [`ParameterError::Meaning`] names the parameter that makes no sense, and why.
    pub fn of(values: &ParameterValues) -> Result<Self, ParameterError> {
        let board_file = text(values, "board_file");
        if board_file.is_empty() {
            return Err(meaning(
                "board_file",
                "no board file is given; set it with --ros-args -p board_file:=/path/to/board.yaml or in a parameter file",
            ));
        }
        only(values, "image_transport", "raw")?;
        let model: ModelChoice = parsed(values, "model")?;
        let (estimator, psf) = (parsed(values, "estimator")?, parsed(values, "psf")?);
        let response_gamma = parsed(values, "response_gamma")?;
        let fixed = Fixed::from_entries(list(values, "fixed"))
            .map_err(|error| meaning("fixed", error.to_string()))?;
        if let ModelChoice::Fixed(model) = model {
            fixed
                .suits(model)
                .map_err(|error| meaning("fixed", error.to_string()))?;
        }
        let (min_views, max_views) = (count(values, "min_views"), count(values, "max_views"));
        if max_views < min_views {
            return Err(meaning(
                "max_views",
                format!("{max_views} is less than min_views, which is {min_views}"),
            ));
        }
        let camera_name = text(values, "camera_name").to_owned();
        if camera_name.is_empty()
            || camera_name.contains(['/', '\0'])
            || camera_name.starts_with('.')
        {
            return Err(meaning(
                "camera_name",
                format!("{camera_name:?} is empty, holds a slash or starts with a dot"),
            ));
        }
        let max_motion_px = number(values, "max_motion_px");
        let target_px = number(values, "target_px");
        let save_dir = text(values, "save_dir");
        let percent = count(values, "jpeg_quality");
        let jpeg_quality = u8::try_from(percent).ok().and_then(Quality::new);
        let jpeg_quality = jpeg_quality
            .ok_or_else(|| meaning("jpeg_quality", format!("{percent} is not from 1 to 100")))?;
        Ok(Self {
            board_file: board_file.into(),
            estimator,
            psf,
            response_gamma,
            required: Required::rings(count(values, "required_rings")),
            model,
            fixed,
            rules: SessionRules {
                max_motion_px: (max_motion_px > 0.0).then_some(max_motion_px),
                min_views,
                max_views,
                target_px: (target_px > 0.0).then_some(target_px),
                ..SessionRules::default()
            },
            auto_calibrate: matches!(
                values.get("auto_calibrate"),
                Some(ParameterValue::Boolean(true))
            ),
            camera_name,
            save_dir: (!save_dir.is_empty()).then(|| save_dir.into()),
            debug_scale: number(values, "debug_scale"),
            jpeg_quality,
        })
    }

    /// The first parameter by which `other` measures the projected centres in another way, if it does.
    pub fn measures_differently(&self, other: &Self) -> Option<&'static str> {
        let differs = [
            ("estimator", self.estimator != other.estimator),
            ("psf", self.psf != other.psf),
            (
                "response_gamma",
                self.response_gamma != other.response_gamma,
            ),
        ];
        differs
            .into_iter()
            .find_map(|(name, differs)| differs.then_some(name))
    }

    /// The folder to save in: `save_dir`, or `ros_home`/ringcal/camera_name.
    pub fn folder(&self, ros_home: &Path) -> PathBuf {
        match &self.save_dir {
            Some(folder) => folder.clone(),
            None => ros_home.join("ringcal").join(&self.camera_name),
        }
    }
}

fn meaning(name: &'static str, reason: impl Into<String>) -> ParameterError {
    ParameterError::Meaning {
        name,
        reason: reason.into(),
    }
}

fn only(values: &ParameterValues, name: &'static str, known: &str) -> Result<(), ParameterError> {
    match text(values, name) {
        value if value == known => Ok(()),
        value => Err(meaning(
            name,
            format!("{value:?} is not supported; {known} is"),
        )),
    }
}

/// What a text stands for.
fn parsed<T: FromStr<Err = String>>(
    values: &ParameterValues,
    name: &'static str,
) -> Result<T, ParameterError> {
    let read = text(values, name).parse();
    read.map_err(|reason: String| meaning(name, reason))
}

// The values are of their declared types, so the fallbacks below are never taken.

fn text<'a>(values: &'a ParameterValues, name: &str) -> &'a str {
    match values.get(name) {
        Some(ParameterValue::String(text)) => text,
        _ => "",
    }
}

fn list<'a>(values: &'a ParameterValues, name: &str) -> &'a [String] {
    match values.get(name) {
        Some(ParameterValue::StringArray(list)) => list,
        _ => &[],
    }
}

fn count(values: &ParameterValues, name: &str) -> usize {
    match values.get(name) {
        Some(ParameterValue::Integer(count)) => usize::try_from(*count).unwrap_or(0),
        _ => 0,
    }
}

fn number(values: &ParameterValues, name: &str) -> f64 {
    match values.get(name) {
        Some(ParameterValue::Double(number)) => *number,
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::centre::photometric::Psf;

    fn values(changes: &[(&str, ParameterValue)]) -> ParameterValues {
        let mut values = ParameterValues::default();
        values.set("board_file", word("/boards/c4.yaml")).unwrap();
        for (name, value) in changes {
            values.set(name, value.clone()).unwrap();
        }
        values
    }

    fn word(text: &str) -> ParameterValue {
        ParameterValue::String(text.to_owned())
    }

    #[test]
    fn the_defaults_are_the_session_s() {
        let settings = Settings::of(&values(&[])).unwrap();
        assert_eq!(settings.rules, SessionRules::default());
        assert_eq!(settings.estimator, Estimator::default());
        assert_eq!(settings.psf, PsfChoice::default());
        assert_eq!(settings.response_gamma, ResponseGamma::default());
        assert_eq!(settings.board_file, Path::new("/boards/c4.yaml"));
        assert_eq!(Some(settings.jpeg_quality), Quality::new(80));
        assert_eq!(
            settings.folder(Path::new("/h/.ros")),
            Path::new("/h/.ros/ringcal/camera")
        );
    }

    #[test]
    fn every_parameter_reaches_its_setting() {
        let settings = Settings::of(&values(&[
            ("estimator", word("pole_polar")),
            ("psf", word("disc")),
            ("response_gamma", word("auto")),
            ("required_rings", ParameterValue::Integer(12)),
            ("fixed", ParameterValue::StringArray(vec!["k3".into()])),
            ("model", word("auto")),
            ("min_views", ParameterValue::Integer(5)),
            ("max_views", ParameterValue::Integer(7)),
            ("auto_calibrate", ParameterValue::Boolean(true)),
            ("camera_name", word("left")),
            ("save_dir", word("/data")),
            ("debug_scale", ParameterValue::Double(0.25)),
            ("jpeg_quality", ParameterValue::Integer(33)),
            ("max_motion_px", ParameterValue::Double(0.0)),
            ("target_px", ParameterValue::Double(0.0)),
        ]))
        .unwrap();
        assert_eq!(settings.estimator, Estimator::PolePolar);
        assert_eq!(settings.psf, PsfChoice::Fixed(Psf::Disc));
        assert_eq!(settings.response_gamma, ResponseGamma::Auto);
        assert_eq!(settings.required, Required::Rings(12));
        assert_eq!(settings.fixed, Fixed::from_entries(["k3"]).unwrap());
        assert_eq!(settings.model, ModelChoice::Auto);
        assert_eq!((settings.rules.min_views, settings.rules.max_views), (5, 7));
        assert_eq!(settings.rules.max_motion_px, None);
        assert_eq!(settings.rules.target_px, None);
        assert!(settings.auto_calibrate);
        assert_eq!(settings.camera_name, "left");
        assert_eq!(settings.folder(Path::new("/h")), Path::new("/data"));
        assert_eq!(settings.debug_scale, 0.25);
        assert_eq!(Some(settings.jpeg_quality), Quality::new(33));
    }

    #[test]
    fn the_response_may_be_a_number() {
        let given = ParameterValue::Double(2.2);
        let settings = Settings::of(&values(&[("response_gamma", given)])).unwrap();
        assert_eq!(settings.response_gamma, ResponseGamma::Fixed(2.2));
    }

    #[test]
    fn what_makes_no_sense_is_refused_by_name() {
        for (name, value, says) in [
            ("board_file", word(""), "-p board_file:="),
            ("estimator", word("best"), "cross"),
            ("psf", word("pillbox"), "disc"),
            ("response_gamma", word("srgb"), "auto"),
            ("response_gamma", ParameterValue::Double(9.0), "9.0"),
            ("response_gamma", ParameterValue::Double(f64::NAN), "NaN"),
            ("image_transport", word("theora"), "raw"),
            ("model", word("fisheye"), "plumb_bob"),
            (
                "fixed",
                ParameterValue::StringArray(vec!["k9".into()]),
                "k9",
            ),
            ("max_views", ParameterValue::Integer(4), "min_views"),
            ("camera_name", word(""), "empty"),
            ("camera_name", word("../x"), "slash"),
        ] {
            let error = Settings::of(&values(&[(name, value)]))
                .unwrap_err()
                .to_string();
            assert!(error.starts_with(name) && error.contains(says), "{error}");
        }
    }
}
