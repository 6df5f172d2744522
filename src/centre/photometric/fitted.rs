//! A fitted ring, or why there is none.

use super::model::RingModel;
use super::shape::{AFFINE, SHAPE_PARAMETERS};
use nalgebra::{Matrix2, SMatrix, SVector, Vector3};

/// A fitted ring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RingFitted {
    /// The most likely parameters.
    pub model: RingModel,
    /// Covariance of the shape's parameters (centre x, y first, px^2), from the residuals' own noise.
    pub covariance: ShapeCovariance,
    /// Standard deviation of the residuals, light at full scale 1.
    pub noise: f64,
    /// Sum of the squared residuals.
    pub squares: f64,
    /// Pixels it was fitted to.
    pub pixels: usize,
    /// The darker of paper and ring over the lighter, as they would be if there were negative light; the model's own do not go there (`wall`).
    pub darkest: f64,
}

/// Covariance of centre x, y; affine xx, xy, yy; perspective x, y.
pub type ShapeCovariance = SMatrix<f64, SHAPE_PARAMETERS, SHAPE_PARAMETERS>;

impl RingFitted {
    /// The same fit, as uncertain as it differs from another one of the same ring.
    pub(super) fn widened_by(mut self, other: &Self) -> Self {
        let parameters = |fitted: &Self| SVector::from(fitted.model.shape.parameters());
        let apart: SVector<f64, SHAPE_PARAMETERS> = parameters(&self) - parameters(other);
        self.covariance += apart * apart.transpose();
        self
    }

    /// Standard deviation of the outer radius, relative to it.
    pub fn size_deviation(&self) -> f64 {
        let [xx, xy, yy] = self.model.shape.affine;
        let determinant = xx * yy - xy * xy;
        // the radius goes with the determinant's -1/4th power
        let by_affine = Vector3::new(yy, -2.0 * xy, xx) * (-0.25 / determinant);
        let affine = self.covariance.fixed_view::<3, 3>(AFFINE, AFFINE);
        by_affine.dot(&(affine * by_affine)).max(0.0).sqrt()
    }

    /// Covariance of the projected centre, px^2.
    pub fn centre_covariance(&self) -> Matrix2<f64> {
        self.covariance.fixed_view::<2, 2>(0, 0).into_owned()
    }
}

/// Why a window has no fitted ring.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum FitError {
    /// More parameters than pixels.
    #[error("{pixels} pixels are too few to fit a ring to")]
    TooFewPixels {
        /// Pixels that count.
        pixels: usize,
    },
    /// The start is no ring, or the pixels determine none.
    #[error("the pixels determine no ring")]
    Undetermined,
    /// The steps did not settle.
    #[error("the fit did not converge in {steps} steps")]
    NotConverged {
        /// Steps made.
        steps: usize,
    },
}
