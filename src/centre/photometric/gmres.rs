//! Linear equations solved by products with their matrix alone: GMRES (Saad & Schultz 1986), not restarted.

use nalgebra::DVector;

/// Products with the matrix at most, and how much of the right side may be left.
const PRODUCTS: usize = 60;
const ACCURACY: f64 = 1e-3;

/// The solution of a linear system from products with its matrix; `None` where they do not get near it.
pub(super) fn gmres(
    right: &DVector<f64>,
    product: impl Fn(&DVector<f64>) -> DVector<f64>,
) -> Option<DVector<f64>> {
    let whole = right.norm();
    if !(whole.is_finite() && whole > 0.0) {
        return None;
    }
    let mut basis = vec![right / whole];
    // columns of the triangle that Givens rotations make of the Hessenberg matrix, the rotations, and the right side
    let (mut columns, mut turns): (Vec<Vec<f64>>, Vec<(f64, f64)>) = (Vec::new(), Vec::new());
    let mut sides = vec![whole];
    for k in 0..PRODUCTS {
        let mut next = product(&basis[k]);
        let mut column = Vec::with_capacity(k + 2);
        for known in &basis {
            let along = known.dot(&next);
            next.axpy(-along, known, 1.0);
            column.push(along);
        }
        let beyond = next.norm();
        for (i, &(cos, sin)) in turns.iter().enumerate() {
            let (a, b) = (column[i], column[i + 1]);
            (column[i], column[i + 1]) = (cos * a + sin * b, cos * b - sin * a);
        }
        let length = column[k].hypot(beyond);
        if !(length.is_finite() && length > 0.0) {
            return None;
        }
        let (cos, sin) = (column[k] / length, beyond / length);
        column[k] = length;
        turns.push((cos, sin));
        columns.push(column);
        let side = sides[k];
        sides[k] = cos * side;
        sides.push(-sin * side);
        if sides[k + 1].abs() < ACCURACY * whole || beyond < f64::EPSILON * length {
            break;
        }
        basis.push(next / beyond);
    }
    let mut found = DVector::zeros(right.len());
    let mut weights = sides;
    for k in (0..columns.len()).rev() {
        weights[k] /= columns[k][k];
        for i in 0..k {
            weights[i] -= columns[k][i] * weights[k];
        }
        found.axpy(weights[k], &basis[k], 1.0);
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;

    #[test]
    fn a_system_is_solved_by_products() {
        let size = 12;
        let matrix = DMatrix::from_fn(size, size, |i, j| {
            let noise = ((7 * i + 13 * j) % 11) as f64 / 11.0 - 0.5;
            f64::from(u8::from(i == j)) + 0.3 * noise
        });
        let truth = DVector::from_fn(size, |i, _| (i as f64).sin());
        let found = gmres(&(&matrix * &truth), |z| &matrix * z).unwrap();
        assert!((found - &truth).norm() < 1e-2 * truth.norm());
    }
}
