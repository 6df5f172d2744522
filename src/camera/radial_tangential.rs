//! What `plumb_bob` and `rational_polynomial` share: a factor along the radius, and the tangential terms (Brown 1966).

use nalgebra::{Matrix2, Point2};

/// The derivative, with respect to the ideal point, of a lens that moves it along the radius and tangentially: `radial` is the factor along the
/// radius there, `slope` its derivative by r^2.
pub(super) fn radial_tangential_jacobian(
    ideal: &Point2<f64>,
    (radial, slope): (f64, f64),
    (p1, p2): (f64, f64),
) -> Matrix2<f64> {
    let (x, y) = (ideal.x, ideal.y);
    let cross = 2.0 * x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y;
    Matrix2::new(
        radial + 2.0 * x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x,
        cross,
        cross,
        radial + 2.0 * y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x,
    )
}
