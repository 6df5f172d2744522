//! What is asked of a calibration.

use super::Fixed;
use crate::camera::{Camera, LensModel};
use crate::centre::Estimator;

/// How to calibrate.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CalibrateOptions {
    /// The lens model.
    pub model: LensModel,
    /// Parameters of the camera that are not estimated.
    pub fixed: Fixed,
    /// Where to start, and what fixed parameters are held at; a lens of another model gives its focal lengths and principal
    /// point alone. Without it the views tell.
    pub guess: Option<Camera>,
    /// What is estimated of the printed sheet.
    pub sheet: SheetOptions,
    /// What measured the centres: constructions on ellipses are displaced by perspective and distortion, which is predicted.
    pub estimator: Estimator,
}

/// The lens model that is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModelChoice {
    /// This one.
    Fixed(LensModel),
    /// The one that predicts left-out views best.
    Auto,
}

impl Default for ModelChoice {
    fn default() -> Self {
        Self::Fixed(LensModel::default())
    }
}

impl std::str::FromStr for ModelChoice {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        if name == "auto" {
            return Ok(Self::Auto);
        }
        let model = name.parse::<LensModel>();
        model
            .map(Self::Fixed)
            .map_err(|error| format!("{error}, or auto"))
    }
}

/// What is estimated of the printed sheet. Every freedom costs certainty, so that each is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SheetOptions {
    /// Two curvatures; a single one of a square board without marks, which may be seen at any quarter turn.
    pub bow: bool,
    /// The ratio of the pitches along the columns and along the rows.
    pub pitch_ratio: bool,
}
