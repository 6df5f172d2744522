//! Pole and polar: the common centre has the same polar, the line at infinity of the board, in both conics.

use super::{Centre, CentreError, CentreEstimator, RingEllipses};
use nalgebra::{Matrix3, Point2, Vector3};

/// The isolated eigenvector of E_B^-1 E_S: two concentric circles in their own plane give diag(1, 1, r^2/R^2) up to
/// scale, whose isolated eigenvector is the centre, and a homography carries it along.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PolePolar;

impl CentreEstimator for PolePolar {
    fn estimate(&self, ring: &RingEllipses) -> Result<Centre, CentreError> {
        // coordinates in which the outer ellipse is about the unit circle keep the matrices well scaled
        let origin = ring.outer.centre;
        let scale = ring.outer.mean_radius();
        let to_px = Matrix3::new(scale, 0.0, origin.x, 0.0, scale, origin.y, 0.0, 0.0, 1.0);
        let small = to_px.transpose() * ring.inner.conic() * to_px;
        let big = to_px.transpose() * ring.outer.conic() * to_px;
        let product = big.try_inverse().ok_or(CentreError::Degenerate)? * small;
        let vector = null_vector(&(product - Matrix3::identity() * isolated(&product)?));
        let centre = to_px * vector;
        let point = Point2::new(centre.x / centre.z, centre.y / centre.z);
        if !(point.x.is_finite() && point.y.is_finite()) {
            return Err(CentreError::Degenerate);
        }
        Ok(Centre {
            point,
            covariance: None,
        })
    }
}

/// The real eigenvalue farthest from the other two (noise may turn the double one into a complex pair).
fn isolated(matrix: &Matrix3<f64>) -> Result<f64, CentreError> {
    let values = matrix.complex_eigenvalues();
    let apart = |i: usize| {
        let gap = |j: usize| (values[i] - values[j]).norm();
        gap((i + 1) % 3).min(gap((i + 2) % 3))
    };
    let tolerance = 1e-9 * values.iter().map(|v| v.norm()).fold(0.0, f64::max);
    (0..3)
        .filter(|&i| values[i].im.abs() <= tolerance && values[i].re.is_finite())
        .max_by(|&i, &j| apart(i).total_cmp(&apart(j)))
        .map(|i| values[i].re)
        .ok_or(CentreError::Degenerate)
}

/// The direction that a matrix of rank two maps to zero: the longest cross product of its rows.
fn null_vector(matrix: &Matrix3<f64>) -> Vector3<f64> {
    let row = |i: usize| matrix.row(i).transpose();
    let crosses = [
        row(0).cross(&row(1)),
        row(1).cross(&row(2)),
        row(2).cross(&row(0)),
    ];
    crosses
        .into_iter()
        .max_by(|a, b| a.norm().total_cmp(&b.norm()))
        .unwrap_or_else(Vector3::zeros)
}
