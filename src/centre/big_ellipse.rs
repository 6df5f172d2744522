//! BC: the centre of the outer ellipse, as most circle-grid calibrations take it.

use super::{Centre, CentreError, CentreEstimator, RingEllipses};

/// The geometric centre of the outer ellipse; off the projected centre by the perspective (paper equation 25).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct BigEllipse;

impl CentreEstimator for BigEllipse {
    fn estimate(&self, ring: &RingEllipses) -> Result<Centre, CentreError> {
        Ok(Centre {
            point: ring.outer.centre,
            covariance: None,
        })
    }
}
