//! The paper's projected centre, equations 26 to 29.

use super::tangents::Tangents;
use super::{Centre, CentreError, CentreEstimator, RingEllipses};

/// Crosses the lines q3 q6 and q4 q5; where the crossing lies off the line of centres by more than `delta_px`, the mean
/// of it and of where the two lines meet the line of centres is taken (equation 29).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cross {
    /// The paper's threshold delta, px.
    pub delta_px: f64,
}

impl Default for Cross {
    /// The paper's choice, 0.1 px.
    fn default() -> Self {
        Self { delta_px: 0.1 }
    }
}

impl CentreEstimator for Cross {
    fn estimate(&self, ring: &RingEllipses) -> Result<Centre, CentreError> {
        let tangents = Tangents::new(ring)?;
        let (left, right) = (tangents.q3_q6()?, tangents.q4_q5()?);
        let crossing = left.meet(&right)?;
        let point = if tangents.centres.distance(&crossing).abs() <= self.delta_px {
            crossing
        } else {
            let p1 = left.meet(&tangents.centres)?;
            let p2 = right.meet(&tangents.centres)?;
            ((crossing.coords + p1.coords + p2.coords) / 3.0).into()
        };
        Ok(Centre {
            point,
            covariance: None,
        })
    }
}
