//! The paper's figure 7: the line of centres, two tangents of the inner ellipse, four points of the outer one.

use super::line::Line;
use super::{CentreError, RingEllipses};
use nalgebra::Point2;

/// Where the ellipse centres are nearer to one another than this fraction of the inner minor axis, the view is frontal
/// and the line of centres undefined.
const FRONTAL: f64 = 1e-9;

/// The construction of paper section III-C up to equation 27, as mended (both tangents are of the inner ellipse).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Tangents {
    /// l1: through both ellipse centres; the projected centre lies on it.
    pub(super) centres: Line,
    /// q3 to q6; q3 and q5 on one tangent, q4 and q6 on the other, q3 and q4 on the same side of l1.
    pub(super) q3: Point2<f64>,
    pub(super) q4: Point2<f64>,
    pub(super) q5: Point2<f64>,
    pub(super) q6: Point2<f64>,
}

impl Tangents {
    pub(super) fn new(ring: &RingEllipses) -> Result<Self, CentreError> {
        let (inner, outer) = (ring.inner, ring.outer);
        let apart = (outer.centre - inner.centre).norm();
        let centres = if apart > FRONTAL * inner.minor {
            Line::through(&inner.centre, &outer.centre)?
        } else {
            Line::through(&inner.centre, &inner.point(0.0))?
        };
        let (small, big) = (inner.conic(), outer.conic());
        let [q1, q2] = centres.meet_conic(&small)?;
        let l2 = Line::from_homogeneous(small * q1.to_homogeneous())?;
        let l3 = Line::from_homogeneous(small * q2.to_homogeneous())?;
        let [q3, q5] = by_side(&centres, l2.meet_conic(&big)?);
        let [q4, q6] = by_side(&centres, l3.meet_conic(&big)?);
        Ok(Self {
            centres,
            q3,
            q4,
            q5,
            q6,
        })
    }

    /// The line through q3 and q6.
    pub(super) fn q3_q6(&self) -> Result<Line, CentreError> {
        Line::through(&self.q3, &self.q6)
    }

    /// The line through q4 and q5.
    pub(super) fn q4_q5(&self) -> Result<Line, CentreError> {
        Line::through(&self.q4, &self.q5)
    }
}

/// The point on the positive side of the line first.
fn by_side(line: &Line, [p, q]: [Point2<f64>; 2]) -> [Point2<f64>; 2] {
    if line.distance(&p) >= line.distance(&q) {
        [p, q]
    } else {
        [q, p]
    }
}
