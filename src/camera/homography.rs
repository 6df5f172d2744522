//! The plane-to-image map of points on a plane: the normalised direct linear transformation.

use nalgebra::{DMatrix, Matrix3, Point2, Vector3};

/// Second smallest over largest singular value below which points do not determine a homography.
const LINE_TOLERANCE: f64 = 1e-6;

/// Homography from plane points to image points, least squares in the algebraic distance (Hartley's normalisation), scaled
/// so that its last element is 1; `None` for fewer than four pairs or where either side stands in a line.
pub(crate) fn fit_homography(pairs: &[(Point2<f64>, Point2<f64>)]) -> Option<Matrix3<f64>> {
    if pairs.len() < 4 {
        return None;
    }
    let from = normalisation(pairs.iter().map(|p| p.0))?;
    let to = normalisation(pairs.iter().map(|p| p.1))?;
    let mut design = DMatrix::zeros(2 * pairs.len(), 9);
    for (i, (p, q)) in pairs.iter().enumerate() {
        let p = from * p.to_homogeneous();
        let q = to * q.to_homogeneous();
        for k in 0..3 {
            design[(2 * i, k)] = p[k];
            design[(2 * i, 6 + k)] = -q.x * p[k];
            design[(2 * i + 1, 3 + k)] = p[k];
            design[(2 * i + 1, 6 + k)] = -q.y * p[k];
        }
    }
    let unit = Matrix3::from_row_slice(&null_vector(&design, LINE_TOLERANCE)?);
    let homography = to.try_inverse()? * unit * from;
    let homography = homography / homography[(2, 2)];
    // one line of points in the image is a plane seen from the side
    let usable = homography.iter().all(|v| v.is_finite()) && homography.try_inverse().is_some();
    usable.then_some(homography)
}

/// The right singular vector of the smallest singular value of a matrix with at least as many rows as columns less
/// one; `None` where the second smallest is below `tolerance` of the largest, so that it is not the only one.
pub(crate) fn null_vector(rows: &DMatrix<f64>, tolerance: f64) -> Option<Vec<f64>> {
    let normal = (rows.transpose() * rows).symmetric_eigen();
    let mut order: Vec<usize> = (0..normal.eigenvalues.len()).collect();
    order.sort_by(|a, b| normal.eigenvalues[*a].total_cmp(&normal.eigenvalues[*b]));
    let (least, next, largest) = (*order.first()?, *order.get(1)?, *order.last()?);
    let unique = normal.eigenvalues[next] > tolerance * tolerance * normal.eigenvalues[largest];
    unique.then(|| normal.eigenvectors.column(least).iter().copied().collect())
}

/// Where a plane point lands, px.
pub(crate) fn apply(homography: &Matrix3<f64>, point: Point2<f64>) -> Option<Point2<f64>> {
    let p: Vector3<f64> = homography * point.to_homogeneous();
    let image = Point2::new(p.x / p.z, p.y / p.z);
    (image.x.is_finite() && image.y.is_finite()).then_some(image)
}

/// Moves the mean to the origin and the mean distance to sqrt 2.
fn normalisation(points: impl Iterator<Item = Point2<f64>> + Clone) -> Option<Matrix3<f64>> {
    let n = points.clone().count() as f64;
    let mean = points
        .clone()
        .map(|p| p.coords)
        .sum::<nalgebra::Vector2<f64>>()
        / n;
    let distance = points.map(|p| (p.coords - mean).norm()).sum::<f64>() / n;
    let s = std::f64::consts::SQRT_2 / distance;
    s.is_finite()
        .then(|| Matrix3::new(s, 0.0, -s * mean.x, 0.0, s, -s * mean.y, 0.0, 0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recovers_a_homography_from_its_points() {
        let truth = Matrix3::new(900.0, 30.0, 400.0, -20.0, 870.0, 300.0, 0.3, -0.2, 1.0);
        let pairs: Vec<_> = (0..20)
            .map(|i| {
                let p = Point2::new(f64::from(i % 5) * 0.03, f64::from(i / 5) * 0.03);
                (p, apply(&truth, p).unwrap())
            })
            .collect();
        let found = fit_homography(&pairs).unwrap();
        assert!((found - truth).norm() < 1e-6);
    }

    #[test]
    fn a_line_of_points_is_refused() {
        let pairs: Vec<_> = (0..9)
            .map(|i| {
                (
                    Point2::new(f64::from(i), 0.0),
                    Point2::new(10.0 * f64::from(i), 3.0),
                )
            })
            .collect();
        assert!(fit_homography(&pairs).is_none());
        assert!(fit_homography(&pairs[..3]).is_none());
    }
}
