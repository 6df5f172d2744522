//! The normal equations of a fit, solved.

use super::fitted::ShapeCovariance;
use super::model::{Matrix, Vector};
use super::shape::SHAPE_PARAMETERS;
use nalgebra::{SMatrix, SVector};

/// Takes a parameter out of the normal equations.
pub(super) fn freeze(matrix: &mut Matrix, k: usize) {
    matrix.fill_row(k, 0.0);
    matrix.fill_column(k, 0.0);
    matrix[(k, k)] = 1.0;
}

/// What makes the diagonal one: parameters differ in their units by many powers of ten.
pub(super) fn diagonal_scales<const N: usize>(matrix: &Matrix) -> SVector<f64, N> {
    SVector::from_fn(|k, _| matrix[(k, k)].max(f64::MIN_POSITIVE).sqrt().recip())
}

/// The part of a matrix that belongs to the first N parameters, scaled.
pub(super) fn scaled_by<const N: usize>(
    matrix: &Matrix,
    scales: &SVector<f64, N>,
) -> SMatrix<f64, N, N> {
    SMatrix::from_fn(|i, j| matrix[(i, j)] * scales[i] * scales[j])
}

/// The step of the first N parameters, with the diagonal times `damping`; the others stay.
pub(super) fn solved<const N: usize>(
    matrix: &Matrix,
    gradient: &Vector,
    damping: f64,
) -> Option<Vector> {
    let scales = diagonal_scales::<N>(matrix);
    let mut scaled = scaled_by(matrix, &scales);
    for k in 0..N {
        scaled[(k, k)] *= damping;
    }
    let right = SVector::<f64, N>::from_fn(|k, _| gradient[k] * scales[k]);
    let solution = scaled.cholesky()?.solve(&right);
    Some(Vector::from_fn(|k, _| {
        if k < N { solution[k] * scales[k] } else { 0.0 }
    }))
}

/// The inverse of the part that belongs to the first N parameters, as far as it is the shape's.
pub(super) fn shape_of_inverse<const N: usize>(matrix: &Matrix) -> Option<ShapeCovariance> {
    let scales = diagonal_scales::<N>(matrix);
    let factor = scaled_by(matrix, &scales).cholesky()?;
    let units = SMatrix::<f64, N, SHAPE_PARAMETERS>::identity();
    let columns = factor.solve(&units);
    Some(ShapeCovariance::from_fn(|i, j| {
        columns[(i, j)] * scales[i] * scales[j]
    }))
}
