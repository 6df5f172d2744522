//! Why a calibration is refused.

use super::{FixedError, NEEDED_VIEWS};
use crate::camera::LensModel;
use nalgebra::Point2;

/// What views lack; displays as what to do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Missing {
    /// Tilt about both axes of the picture.
    TiltBoth,
    /// Tilt to the left and to the right.
    TiltSideways,
    /// Tilt forward and backward.
    TiltUpright,
    /// More of everything.
    Views,
    /// Views near the border of the frame.
    Corners,
    /// Views that show the sheet's own shape.
    Sheet,
}

impl std::fmt::Display for Missing {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::TiltBoth => "tilt the board by 20 degrees or more about both axes",
            Self::TiltSideways => {
                "tilt the board by 20 degrees or more to the left and to the right"
            }
            Self::TiltUpright => "tilt the board by 20 degrees or more forward and backward",
            Self::Views => "add views at other tilts and distances, the board as large as it gets",
            Self::Corners => {
                "show the board near the edges and corners of the frame, or estimate fewer coefficients"
            }
            Self::Sheet => {
                "show the board at more tilts and quarter turns, or do not estimate the sheet's shape"
            }
        })
    }
}

/// A difference of two lenses in words.
fn apart(px: f64) -> String {
    match px {
        px if !px.is_finite() => {
            "everything, because only one of them sees anything there".to_owned()
        }
        px if px < 10.0 => format!("{px:.1} px"),
        px => format!("{px:.0} px"),
    }
}

/// Why views do not give a calibration; displays as one plain sentence.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CalibrateError {
    /// A board of one ring has no known lengths between centres.
    #[error("a board of a single ring cannot calibrate a camera, at least 2 x 2 rings are needed")]
    SingleRing,
    /// Fewer views than any calibration needs.
    #[error("{found} view{}, at least {NEEDED_VIEWS} are needed", if *found == 1 { "" } else { "s" })]
    TooFewViews {
        /// Views given.
        found: usize,
    },
    /// A view of another frame size than the first.
    #[error("{source_name} is {} x {} px, the first view is {} x {}", size.0, size.1, first.0, first.1)]
    Size {
        /// `source` of the view.
        source_name: String,
        /// Its width and height, px.
        size: (usize, usize),
        /// Those of the first view.
        first: (usize, usize),
    },
    /// A view of another frame size than the camera's that it is held against.
    #[error("{source_name} is {} x {} px, the camera's frames are {} x {} px: a calibration holds for one resolution", size.0, size.1, camera.0, camera.1)]
    CameraSize {
        /// `source` of the view.
        source_name: String,
        /// Its width and height, px.
        size: (usize, usize),
        /// Those of the camera's frames.
        camera: (usize, usize),
    },
    /// A guess of frames of another size: its principal point and focal lengths are not theirs.
    #[error(
        "the guess is a camera of {} x {} px, the frames are {} x {} px: it is no guess for them",
        guess.0, guess.1, frames.0, frames.1
    )]
    GuessSize {
        /// Width and height of the guess, px.
        guess: (u32, u32),
        /// Those of the views, px.
        frames: (u32, u32),
    },
    /// Too few views are left once the useless ones are left out.
    #[error(
        "{left} of {given} views can be used, at least {NEEDED_VIEWS} are needed; of the others the first {reason}"
    )]
    TooFewLeft {
        /// Views that can be used.
        left: usize,
        /// Views given.
        given: usize,
        /// Why the first of the others cannot.
        reason: String,
    },
    /// A parameter is fixed that the lens model does not have.
    #[error(transparent)]
    Fixed(#[from] FixedError),
    /// The pitch ratio of a board that may be seen at any quarter turn.
    #[error(
        "the pitch ratio of a square board without marks cannot be told: rows and columns may be exchanged in any view"
    )]
    QuarterTurns,
    /// A number that is not finite, or a covariance that is not positive definite.
    #[error("{source_name} has no valid {what} for ring ({row}, {column})")]
    BadRing {
        /// `source` of the view.
        source_name: String,
        /// What is wrong: position or covariance.
        what: &'static str,
        /// Row of the ring.
        row: u16,
        /// Column of the ring.
        column: u16,
    },
    /// A ring that the board does not have, or one that occurs twice.
    #[error(
        "{source_name} has ring ({row}, {column}), which is {how} a board of {rows} x {columns}"
    )]
    Label {
        /// `source` of the view.
        source_name: String,
        /// What is wrong with the label.
        how: &'static str,
        /// Row of the ring.
        row: u16,
        /// Column of the ring.
        column: u16,
        /// Rows of the board.
        rows: u16,
        /// Columns of the board.
        columns: u16,
    },
    /// Fewer numbers measured than unknown.
    #[error(
        "{measured} coordinates measured for {unknown} unknowns: more views or more rings are needed"
    )]
    TooFewMeasurements {
        /// Coordinates of rings.
        measured: usize,
        /// Free parameters of the camera and its poses.
        unknown: usize,
    },
    /// The views are too much alike to tell a parameter.
    #[error("the views cannot tell {name}: {missing}")]
    Undetermined {
        /// The parameter.
        name: &'static str,
        /// What would tell it.
        missing: Missing,
    },
    /// The views leave the lens open somewhere in the frame.
    #[error(
        "the views cannot tell the lens near ({:.0}, {:.0}), where it is uncertain by {std_px:.0} px: show the board there{}",
        at.x, at.y, if *below { ", or fix k4, k5 and k6" } else { "" }
    )]
    LensOpen {
        /// Where it is most uncertain, px.
        at: Point2<f64>,
        /// Standard deviation of the projection there, px.
        std_px: f64,
        /// Whether numbers below the line of the rational model are estimated, which most lenses do without.
        below: bool,
    },
    /// Lens models explain the views equally well and disagree about the frame.
    #[error(
        "the views cannot tell which lens it is: {chosen} and {rival} explain them equally well, and near ({:.0}, {:.0}) they differ \
         by {}: show the board there, and tilted to all sides, or give the lens model if it is known",
        at.x, at.y, apart(*apart_px)
    )]
    LensModel {
        /// The one that would have been chosen.
        chosen: LensModel,
        /// The other.
        rival: LensModel,
        /// Where they differ most in the frame, px.
        at: Point2<f64>,
        /// By how much, px; not finite where only one of them sees anything.
        apart_px: f64,
    },
    /// The lens model found does not reach most of the frame.
    #[error(
        "the lens that fits the views folds over in {percent:.0} % of the frame: show the board there too, or use another lens model"
    )]
    LensFolds {
        /// Part of the frame without a ray, %.
        percent: f64,
    },
    /// The board's planes are parallel, turned in their plane at most: they all tell the same.
    #[error(
        "the board stands at the same tilt in all views (within {spread_deg:.1} degrees): tilt it by 20 degrees or more about both axes"
    )]
    Parallel {
        /// Largest angle between the normals of two views, degrees.
        spread_deg: f64,
    },
    /// The adjustment did not settle.
    #[error(
        "no solution after {iterations} iterations: views may be mislabelled or of another camera"
    )]
    NotConverged {
        /// Iterations made.
        iterations: usize,
    },
    /// The adjustment settled on a camera that cannot be.
    #[error("the views lead to an impossible camera: {what}")]
    Absurd {
        /// What is impossible about it.
        what: String,
    },
}

impl CalibrateError {
    /// Whether it is the views that lack something, whatever the lens model.
    pub fn is_of_the_views(&self) -> bool {
        matches!(
            self,
            Self::Undetermined { .. }
                | Self::LensOpen { .. }
                | Self::LensModel { .. }
                | Self::Parallel { .. }
        )
    }

    /// Whether values that were held, or the camera to start from, can be the reason as well as the views.
    pub fn may_be_the_options(&self) -> bool {
        matches!(
            self,
            Self::TooFewLeft { .. }
                | Self::TooFewMeasurements { .. }
                | Self::Undetermined { .. }
                | Self::LensOpen { .. }
                | Self::LensModel { .. }
                | Self::LensFolds { .. }
                | Self::Parallel { .. }
                | Self::NotConverged { .. }
                | Self::Absurd { .. }
        )
    }
}
