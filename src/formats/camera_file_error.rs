//! Why a text gives no camera, and why a camera cannot be written in a format.

use crate::camera::LensModel;

/// Why a text is not a camera file that can be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CameraFileError {
    /// The text breaks the rules of the format, or a key is missing or of another kind.
    #[error("not {format}: {reason}")]
    Syntax {
        /// What the text was taken for, with its article.
        format: &'static str,
        /// Where it stops being that.
        reason: String,
    },
    /// A matrix of another size.
    #[error("{name} has {rows} rows, {columns} cols and {values} values, {expected} are needed")]
    Size {
        /// Key of the matrix.
        name: &'static str,
        /// Its rows.
        rows: usize,
        /// Its columns.
        columns: usize,
        /// How many numbers it holds.
        values: usize,
        /// What is needed.
        expected: &'static str,
    },
    /// A list of another length.
    #[error("{name} has {values} values, {expected} are needed")]
    Count {
        /// Key of the list.
        name: &'static str,
        /// Its length.
        values: usize,
        /// What is needed.
        expected: String,
    },
    /// A number that is not finite.
    #[error("{name} holds a value that is not finite")]
    NotFinite {
        /// Key of the value.
        name: &'static str,
    },
    /// A lens model or a projection that is not supported.
    #[error("{key} {model:?} is not supported; {supported} are")]
    Model {
        /// Key of the model.
        key: &'static str,
        /// Its value.
        model: String,
        /// What could be read, as a list of words.
        supported: &'static str,
    },
    /// Coefficients beyond those that any supported model has.
    #[error(
        "{name} has {values:?} behind the eighth, a thin prism or a tilted sensor, which is not supported"
    )]
    BeyondRational {
        /// Key of the coefficients.
        name: &'static str,
        /// Those that are too many.
        values: Vec<f64>,
    },
    /// The camera matrix has entries that no camera here has.
    #[error("camera_matrix is not [fx 0 cx; 0 fy cy; 0 0 1]: row {row} column {column} is {value}")]
    NotPinhole {
        /// From 1.
        row: usize,
        /// From 1.
        column: usize,
        /// What stands there.
        value: f64,
    },
    /// The camera matrix is not that of a camera.
    #[error("the focal lengths are {fx} and {fy}: the camera is not calibrated")]
    Uncalibrated {
        /// Along x, px.
        fx: f64,
        /// Along y, px.
        fy: f64,
    },
    /// A frame without pixels.
    #[error("image_width {width} and image_height {height} must be positive")]
    NoPixels {
        /// Width, px.
        width: u32,
        /// Height, px.
        height: u32,
    },
    /// One camera is needed and the file holds several.
    #[error("it holds several cameras: {}; `ringcal convert --camera NAME` takes one out", names.join(", "))]
    SeveralCameras {
        /// Their names.
        names: Vec<String>,
    },
    /// The camera that was asked for is not there.
    #[error("it holds no camera {wanted:?}, but {}", names.join(", "))]
    NoSuchCamera {
        /// The name that was asked for.
        wanted: String,
        /// Those that are there.
        names: Vec<String>,
    },
}

/// Why a format cannot hold a camera.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CannotExpress {
    /// It has no such lens model.
    #[error("{format} has no {model} lens")]
    Model {
        /// Name of the format.
        format: &'static str,
        /// The lens.
        model: LensModel,
    },
    /// It has fewer coefficients, and those that it lacks are not zero.
    #[error(
        "{format} has the coefficients k1, k2, p1 and p2 only, this {model} lens has {} as well \
         (calibrating with --fix radial=2 keeps the lens to the four)",
        listed(beyond)
    )]
    Coefficients {
        /// Name of the format.
        format: &'static str,
        /// The lens.
        model: LensModel,
        /// The coefficients that have no place, with their values.
        beyond: Vec<(&'static str, f64)>,
    },
    /// It has no place for such a name.
    #[error("{format} cannot hold the camera name {name:?}: {why}")]
    Name {
        /// Name of the format.
        format: &'static str,
        /// Name of the camera.
        name: String,
        /// What is in the way.
        why: &'static str,
    },
    /// A number that is not finite.
    #[error("the camera holds {0}, no file does")]
    NotFinite(f64),
}

fn listed(coefficients: &[(&'static str, f64)]) -> String {
    let words: Vec<_> = coefficients
        .iter()
        .map(|(name, value)| format!("{name} = {value}"))
        .collect();
    words.join(", ")
}
