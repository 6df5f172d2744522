//! Why a calibration is refused.

use super::{NEEDED_RINGS, NEEDED_VIEWS};

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
    /// A view has too few rings for a pose.
    #[error("{source_name} shows {found} rings, at least {NEEDED_RINGS} are needed")]
    TooFewRings {
        /// `source` of the view.
        source_name: String,
        /// Rings in it.
        found: usize,
    },
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
    /// The rings of a view stand in a line or in one place, so that it has no pose.
    #[error("the rings of {source_name} stand in one line or in one place")]
    DegenerateView {
        /// `source` of the view.
        source_name: String,
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
    #[error("the views cannot tell {name}: tilt the board more, and in more than one direction")]
    Undetermined {
        /// The parameter.
        name: &'static str,
    },
    /// The board's planes are parallel, turned in their plane at most: they all tell the same.
    #[error(
        "the board stands at the same tilt in all views (within {spread_deg:.1} degrees): tilt it, and in more than one direction"
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
