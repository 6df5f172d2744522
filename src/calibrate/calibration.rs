//! The result of a calibration.

use crate::camera::{Camera, Pose};
use nalgebra::{DMatrix, Vector2};

/// Residuals of a view over those of the median view beyond which it is pointed out.
const SUSPICIOUS_RATIO: f64 = 4.0;

/// A calibrated camera, and how well the views support it.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// The camera.
    pub camera: Camera,
    /// The views, in the order given.
    pub views: Vec<ViewFit>,
    /// Root mean square of the distance between measured and projected centres, px: the square root of the sum of the
    /// squared distances over the number of rings (not of coordinates), unweighted, as ROS and OpenCV report it.
    pub rms_px: f64,
    /// Sum of the squared whitened residuals over the degrees of freedom: about 1 where the covariances of the rings are
    /// true, px^2 where they have none.
    pub variance_factor: f64,
    /// Covariance of [`Camera::parameters`] in that order: `variance_factor` times the inverse of the Schur complement of
    /// J^T J. Rows and columns of fixed parameters are 0.
    pub covariance: DMatrix<f64>,
    /// Names of the parameters that were not estimated.
    pub fixed: Vec<&'static str>,
    /// Iterations of the adjustment.
    pub iterations: usize,
}

/// How one view fits.
#[derive(Debug, Clone, PartialEq)]
pub struct ViewFit {
    /// Where the board stands.
    pub pose: Pose,
    /// Measured less projected centre of each ring of the view, in its order, px.
    pub residuals: Vec<Vector2<f64>>,
    /// As [`Calibration::rms_px`], of this view alone.
    pub rms_px: f64,
}

impl Calibration {
    /// Standard deviation of the parameter at this place of [`Camera::PARAMETER_NAMES`]; 0 for a fixed one.
    ///
    /// It counts the noise of the centres and nothing else: not a bias that the centres share, and not a lens that the
    /// model does not describe.
    pub fn std(&self, at: usize) -> f64 {
        self.covariance
            .get((at, at))
            .map_or(0.0, |variance| variance.max(0.0).sqrt())
    }

    /// Places of the views whose residuals are four times those of the median view or more: mislabelled, moved
    /// during the exposure, or of another board. Nothing is left out because of it.
    pub fn suspicious_views(&self) -> Vec<usize> {
        let mut sorted: Vec<f64> = self.views.iter().map(|view| view.rms_px).collect();
        sorted.sort_by(f64::total_cmp);
        let median = sorted.get(sorted.len() / 2).copied().unwrap_or(0.0);
        let limit = SUSPICIOUS_RATIO * median.max(NO_NOISE_PX);
        (0..self.views.len())
            .filter(|at| self.views[*at].rms_px > limit)
            .collect()
    }
}

/// Residuals below this are rounding, px.
const NO_NOISE_PX: f64 = 1e-6;

/// Root mean square length of residuals; 0 for none.
pub(super) fn rms<'a>(residuals: impl Iterator<Item = &'a Vector2<f64>>) -> f64 {
    let (sum, count) = residuals.fold((0.0, 0_usize), |(sum, count), r| {
        (sum + r.norm_squared(), count + 1)
    });
    (sum / count.max(1) as f64).sqrt()
}
