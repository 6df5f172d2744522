//! The plane-to-image map of a grid of centres: normalised direct linear transform.

use nalgebra::{DMatrix, Matrix3, Point2, Vector3};

/// Eigenvalues below this fraction of the largest are zero but for rounding.
const UNDETERMINED: f64 = 1e-10;

/// Least-squares homography from plane points to image points (Hartley's normalisation); `None` for fewer than four
/// pairs or where they lie on a line.
pub(super) fn fit_homography(pairs: &[(Point2<f64>, Point2<f64>)]) -> Option<Matrix3<f64>> {
    if pairs.len() < 4 {
        return None;
    }
    let from = normalisation(pairs.iter().map(|p| p.0))?;
    let to = normalisation(pairs.iter().map(|p| p.1))?;
    let mut design = DMatrix::zeros(2 * pairs.len(), 9);
    for (i, (p, q)) in pairs.iter().enumerate() {
        let p = from * p.to_homogeneous();
        let q = to * q.to_homogeneous();
        for (k, value) in [p.x, p.y, 1.0].into_iter().enumerate() {
            design[(2 * i, k)] = value;
            design[(2 * i, 6 + k)] = -q.x * value;
            design[(2 * i + 1, 3 + k)] = value;
            design[(2 * i + 1, 6 + k)] = -q.y * value;
        }
    }
    let eigen = (design.transpose() * &design).symmetric_eigen();
    let least = eigen.eigenvalues.imin();
    // points on a line leave more than one solution
    let largest = eigen.eigenvalues.max();
    let solutions = eigen
        .eigenvalues
        .iter()
        .filter(|&&v| v < UNDETERMINED * largest)
        .count();
    if solutions > 1 {
        return None;
    }
    let h = eigen.eigenvectors.column(least);
    let unit = Matrix3::new(h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], h[8]);
    let homography = to.try_inverse()? * unit * from;
    let scale = homography[(2, 2)];
    let usable =
        unit.determinant().abs() > 1e-9 && scale != 0.0 && homography.iter().all(|v| v.is_finite());
    usable.then(|| homography / scale)
}

/// Where a plane point lands, px.
pub(super) fn apply(homography: &Matrix3<f64>, point: Point2<f64>) -> Option<Point2<f64>> {
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
