//! The one-sided tangent method, which the paper calls Fei (Hao et al.).

use super::tangents::Tangents;
use super::{Centre, CentreError, CentreEstimator, RingEllipses};

/// Where the line q3 q6 meets the line of centres.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct OneSided;

impl CentreEstimator for OneSided {
    fn estimate(&self, ring: &RingEllipses) -> Result<Centre, CentreError> {
        let tangents = Tangents::new(ring)?;
        Ok(Centre {
            point: tangents.q3_q6()?.meet(&tangents.centres)?,
            covariance: None,
        })
    }
}
