//! SC (GCS in the paper's Table 2): the centre of the inner ellipse.

use super::{Centre, CentreError, CentreEstimator, RingEllipses};

/// The geometric centre of the inner ellipse; its perspective bias is smaller than the outer one's by the square of
/// the radius ratio.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SmallEllipse;

impl CentreEstimator for SmallEllipse {
    fn estimate(&self, ring: &RingEllipses) -> Result<Centre, CentreError> {
        Ok(Centre {
            point: ring.inner.centre,
            covariance: None,
        })
    }
}
