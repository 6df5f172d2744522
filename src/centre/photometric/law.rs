//! What the rings of a board know of one another: perspective.
//!
//! A ring alone has to find its own perspective q, and pays for it with half the certainty of its centre: the two are
//! strongly correlated. But all rings share one plane and one lens, so q is a smooth function of the place in the frame:
//! that of the plane's homography, and a correction that is a polynomial of low degree for the curvature of the
//! lens (which acts on a small ring as perspective does). The polynomial is fitted to all rings; each ring's centre is
//! then its own measurement given the better q: `c + C_cq C_qq^-1 (q_board - q)`, the mean of the conditional normal distribution.
//! Centres are not drawn to one another or onto a plane.

use super::fit::RingFitted;
use super::plane::PlaneView;
use nalgebra::{DMatrix, DVector, Matrix2, Point2, Vector2};

/// Rings for each coefficient of the polynomial, at least.
const RINGS_PER_COEFFICIENT: usize = 3;
/// A ring whose own perspective is this many standard deviations off the board's is left as it is.
const OUTLIER: f64 = 5.0;

/// A centre and its covariance, px and px^2.
pub(super) type CentreAndCovariance = (Point2<f64>, Matrix2<f64>);

/// The centres of the rings of one board, given one another's perspective and its plane. Where there are too few rings to know
/// the lens's part, the centres are those of the fits.
pub(super) fn share_perspective(
    rings: &[RingFitted],
    view: Option<&PlaneView>,
) -> Vec<CentreAndCovariance> {
    let alone = || {
        rings
            .iter()
            .map(|r| (r.model.shape.centre, r.centre_covariance()))
            .collect()
    };
    let Some(law) = view.and_then(|view| PerspectiveLaw::of(rings, view)) else {
        return alone();
    };
    rings.iter().map(|ring| law.apply(ring)).collect()
}

/// The perspective of every place of the frame.
struct PerspectiveLaw {
    view: PlaneView,
    middle: Point2<f64>,
    scale_px: f64,
    degree: usize,
    /// Coefficients of both components, x first.
    coefficients: DVector<f64>,
    covariance: DMatrix<f64>,
}

impl PerspectiveLaw {
    fn of(rings: &[RingFitted], view: &PlaneView) -> Option<Self> {
        let degree = (0..=2)
            .rev()
            .find(|d| terms(*d) * RINGS_PER_COEFFICIENT <= rings.len())?;
        let count = rings.len() as f64;
        let sum = rings
            .iter()
            .map(|r| r.model.shape.centre.coords)
            .sum::<Vector2<f64>>();
        let middle = Point2::from(sum / count);
        let scale_px = rings
            .iter()
            .map(|r| (r.model.shape.centre - middle).norm())
            .fold(1.0, f64::max);
        let size = 2 * terms(degree);
        let mut law = Self {
            view: *view,
            middle,
            scale_px,
            degree,
            coefficients: DVector::zeros(size),
            covariance: DMatrix::zeros(size, size),
        };
        let mut normal = DMatrix::zeros(size, size);
        let mut right = DVector::zeros(size);
        for ring in rings {
            let row = law.row(&ring.model.shape.centre);
            let weight = perspective_covariance(ring).try_inverse()?;
            let missing =
                ring.model.shape.perspective - law.view.perspective(&ring.model.shape.centre);
            normal += row.transpose() * weight * &row;
            right += row.transpose() * (weight * missing);
        }
        law.covariance = normal.try_inverse()?;
        law.coefficients = &law.covariance * right;
        law.coefficients
            .iter()
            .all(|v| v.is_finite())
            .then_some(law)
    }

    /// 2 x size: the polynomial's terms for both components.
    fn row(&self, at: &Point2<f64>) -> DMatrix<f64> {
        let p = (at - self.middle) / self.scale_px;
        let all = [1.0, p.x, p.y, p.x * p.x, p.x * p.y, p.y * p.y];
        let n = terms(self.degree);
        let mut row = DMatrix::zeros(2, 2 * n);
        for k in 0..n {
            row[(0, k)] = all[k];
            row[(1, n + k)] = all[k];
        }
        row
    }

    fn apply(&self, ring: &RingFitted) -> CentreAndCovariance {
        let (centre, own) = (ring.model.shape.centre, ring.centre_covariance());
        let row = self.row(&centre);
        let board = self.view.perspective(&centre)
            + Vector2::from_column_slice((&row * &self.coefficients).as_slice());
        let uncertain = &row * &self.covariance * row.transpose();
        let uncertain = Matrix2::new(
            uncertain[(0, 0)],
            uncertain[(0, 1)],
            uncertain[(1, 0)],
            uncertain[(1, 1)],
        );
        let q = perspective_covariance(ring);
        let Some(inverse) = q.try_inverse() else {
            return (centre, own);
        };
        let off = board - ring.model.shape.perspective;
        if off.dot(&(inverse * off)) > OUTLIER * OUTLIER {
            return (centre, own);
        }
        let cross = ring.covariance.fixed_view::<2, 2>(0, 5).into_owned();
        let gain = cross * inverse;
        let covariance = own - gain * cross.transpose() + gain * uncertain * gain.transpose();
        (centre + gain * off, covariance)
    }
}

fn terms(degree: usize) -> usize {
    (degree + 1) * (degree + 2) / 2
}

fn perspective_covariance(ring: &RingFitted) -> Matrix2<f64> {
    ring.covariance.fixed_view::<2, 2>(5, 5).into_owned()
}
