//! A ring as the map through a board's rings takes it, and what the map says of it.

use super::fitted::RingFitted;
use nalgebra::{Matrix2, Point2, Vector2};

/// What the fit of a ring measures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sighting {
    /// Where it is on the board, m.
    pub(super) plane_m: Point2<f64>,
    /// Centre, px, and perspective, px^-1.
    pub(super) centre: Point2<f64>,
    pub(super) perspective: Vector2<f64>,
    /// G: what the centre moves by with the perspective, px^2.
    pub(super) gain: Matrix2<f64>,
    /// V: covariance of the centre if the perspective were known, px^2.
    pub(super) given: Matrix2<f64>,
    /// Covariance of the perspective, px^-2.
    pub(super) of_perspective: Matrix2<f64>,
}

/// A perspective that the board says, px^-1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BoardPerspective {
    pub(super) perspective: Vector2<f64>,
    pub(super) covariance: Matrix2<f64>,
    /// Covariance of the ring's `e` (rows) with it: the ring has had its say in the map.
    pub(super) with_ring: Matrix2<f64>,
}

impl Sighting {
    /// Of a fit; `None` where it has no covariance.
    pub(super) fn of(ring: &RingFitted, plane_m: Point2<f64>) -> Option<Self> {
        let cross = ring.covariance.fixed_view::<2, 2>(0, 5).into_owned();
        let of_perspective = ring.covariance.fixed_view::<2, 2>(5, 5).into_owned();
        let gain = cross * of_perspective.try_inverse()?;
        Some(Self {
            plane_m,
            centre: ring.model.shape.centre,
            perspective: ring.model.shape.perspective,
            gain,
            given: ring.centre_covariance() - gain * cross.transpose(),
            of_perspective,
        })
    }

    /// The centre if the perspective is this one.
    pub(super) fn centre_given(&self, perspective: &Vector2<f64>) -> Point2<f64> {
        self.centre + self.gain * (perspective - self.perspective)
    }

    /// How far its own perspective is from the board's, in standard deviations squared.
    pub(super) fn contradicts(&self, board: &BoardPerspective) -> Option<f64> {
        let off = board.perspective - self.perspective;
        Some(off.dot(&(self.of_perspective.try_inverse()? * off)))
    }

    /// The mean variance of the centre alone, px^2.
    pub(super) fn variance(&self) -> f64 {
        let own = self.given + self.gain * self.of_perspective * self.gain.transpose();
        0.5 * own.trace()
    }
}

impl BoardPerspective {
    /// One that is known exactly.
    pub(super) fn exact(perspective: Vector2<f64>) -> Self {
        Self {
            perspective,
            covariance: Matrix2::zeros(),
            with_ring: Matrix2::zeros(),
        }
    }
}
