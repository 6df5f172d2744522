//! Views -> camera: guess, bundle adjustment, outliers, uncertainty, and the refusal of views that cannot tell.
//!
//! 1. `observations` checks the views and pairs their rings with the board's; `roll` leaves out repeats and hopeless views.
//! 2. `guess` takes a camera without distortion and the poses from homographies (`zhang`) or rays (`rays`).
//! 3. `adjust` minimises the residuals in the image, each weighted by its covariance, over camera, sheet and poses, on the
//!    `normal_equations` with the poses eliminated; `observed` says what an estimator measures.
//! 4. `roll` leaves out rings and views that contradict the solution, `leverage` views that bend it, and 3 is repeated until nothing
//!    changes.
//! 5. The covariance of the parameters is that of least squares (`uncertainty`); views that leave the camera open are refused
//!    (`observability`), however small their residuals are.
//! 6. Whether one focal length served all views is `steady`'s question.
//! 7. Where the lens model is to be chosen, `lens_choice` does it by `cross_validation`; what other models that explain the views as well
//!    disagree by counts as not known (`rivals`).
//! 8. What the result is worth, as one word and a sentence, is `assess`'s to say, by written rules.

mod adjust;
mod assess;
mod below;
mod calibration;
mod check;
mod conclude;
mod cross_validation;
mod design;
mod difference;
mod error;
mod fixed;
mod guess;
mod information;
mod lens_choice;
mod leverage;
mod linearise;
mod normal_equations;
mod observability;
mod observations;
mod observed;
mod options;
mod rays;
mod repeats;
mod resect;
mod rivals;
mod roll;
mod shared;
mod solve;
mod start_homography;
mod steady;
mod uncertainty;
mod zhang;

pub use assess::{Assessment, Criterion, Facts, FramesRead, Grade, Rule, assess, refused};
pub use calibration::{Calibration, ViewFit};
pub use check::{Alone, Cell, Check, FIELD, Verdict, check};
pub use cross_validation::{CrossValidation, FOLDS, cross_validate};
pub use difference::{Difference, difference};
pub use error::{CalibrateError, Missing};
pub use fixed::{Fixed, FixedError};
pub use information::{Estimate, MAP_CELLS, Told, Unfit, most_informative};
pub use lens_choice::{ModelScore, choose_model};
pub use options::{CalibrateOptions, ModelChoice, SheetOptions};
pub use resect::{Known, Resection, resect};
pub use rivals::with_rivals;
pub use roll::LeftOut;
pub use shared::{SHEET_NAMES, SheetShape};
pub use steady::{Change, When};
pub use uncertainty::Range;
pub use zhang::{focal_length_px, plane_normal, pose};

use crate::board::Board;
use crate::session::View;

/// Views below which nothing is tried.
pub const NEEDED_VIEWS: usize = 3;

/// Rings of a view below which it has no pose.
pub const NEEDED_RINGS: usize = 4;

/// Estimates the camera that took `views` of `board`.
///
/// The residuals are weighted by the covariance of each ring. A ring without one counts much less than those that
/// have one; where none has, all weights are equal. Rings and views that contradict the others are left out; the result lists them.
///
/// # Errors
/// [`CalibrateError`] says what the views lack, or which of them is wrong.
pub fn calibrate(
    board: &Board,
    views: &[View],
    options: &CalibrateOptions,
) -> Result<Calibration, CalibrateError> {
    let (solved, roll) = solve::solved(board, views, options)?;
    conclude::conclude(solved, roll, options)
}

#[cfg(test)]
pub(crate) mod synthetic;
#[cfg(test)]
mod tests;
