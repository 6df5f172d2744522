//! The homography of one view from its rings: the normalised direct linear transformation.

use super::observations::Observation;
use nalgebra::{DMatrix, Matrix3, Point2, Vector3};

/// Board plane (m) to frame (px), least squares in the algebraic distance; `None` where the points stand in a line.
pub(super) fn homography(observations: &[Observation]) -> Option<Matrix3<f64>> {
    let board: Vec<Point2<f64>> = observations
        .iter()
        .map(|o| Point2::from(o.board_m))
        .collect();
    let frame: Vec<Point2<f64>> = observations.iter().map(|o| o.pixel).collect();
    let (to_unit_board, to_unit_frame) = (normalisation(&board)?, normalisation(&frame)?);
    let mut rows = DMatrix::zeros(2 * observations.len(), 9);
    for (i, (b, f)) in board.iter().zip(&frame).enumerate() {
        let p = to_unit_board * b.to_homogeneous();
        let q = to_unit_frame * f.to_homogeneous();
        for c in 0..3 {
            rows[(2 * i, c)] = p[c];
            rows[(2 * i, 6 + c)] = -q.x * p[c];
            rows[(2 * i + 1, 3 + c)] = p[c];
            rows[(2 * i + 1, 6 + c)] = -q.y * p[c];
        }
    }
    let unit = null_vector(&rows, LINE_TOLERANCE)?;
    let unit = Matrix3::from_row_slice(&unit);
    let homography = to_unit_frame.try_inverse()? * unit * to_unit_board;
    // one line of points in the frame is the image of a plane seen from the side
    let invertible = homography.iter().all(|v| v.is_finite()) && homography.try_inverse().is_some();
    invertible.then_some(homography)
}

/// Second smallest over largest singular value below which the points do not determine a homography.
const LINE_TOLERANCE: f64 = 1e-6;

/// The right singular vector of the smallest singular value of a matrix with at least as many rows as columns less
/// one; `None` where the second smallest is below `tolerance` of the largest, so that it is not the only one.
pub(super) fn null_vector(rows: &DMatrix<f64>, tolerance: f64) -> Option<Vec<f64>> {
    let normal = (rows.transpose() * rows).symmetric_eigen();
    let mut order: Vec<usize> = (0..normal.eigenvalues.len()).collect();
    order.sort_by(|a, b| normal.eigenvalues[*a].total_cmp(&normal.eigenvalues[*b]));
    let (least, next, largest) = (*order.first()?, *order.get(1)?, *order.last()?);
    let unique = normal.eigenvalues[next] > tolerance * tolerance * normal.eigenvalues[largest];
    unique.then(|| normal.eigenvectors.column(least).iter().copied().collect())
}

/// Moves points to their centroid and scales their root mean square distance from it to the square root of 2.
fn normalisation(points: &[Point2<f64>]) -> Option<Matrix3<f64>> {
    let count = points.len() as f64;
    let middle = points
        .iter()
        .fold(Vector3::zeros(), |sum, p| sum + p.to_homogeneous())
        / count;
    let spread = points
        .iter()
        .map(|p| (p.x - middle.x).powi(2) + (p.y - middle.y).powi(2))
        .sum::<f64>()
        / count;
    let scale = (2.0 / spread).sqrt();
    scale.is_finite().then(|| {
        Matrix3::new(
            scale,
            0.0,
            -scale * middle.x,
            0.0,
            scale,
            -scale * middle.y,
            0.0,
            0.0,
            1.0,
        )
    })
}
