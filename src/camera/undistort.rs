//! The inverse of a lens model given by its map and derivative.

use nalgebra::{Matrix2, Point2};

/// Newton steps that undo the distortion; it converges in 3 to 6 where the model is invertible.
const STEPS: usize = 30;
/// Stations from the principal point outward where one leap does not arrive.
const STATIONS: usize = 40;

/// The ideal point that `distort` maps to `distorted`, by Newton's method; where it does not arrive from the distorted point, it is led there
/// from the principal point, so that of several solutions the one on the way is found. `None` where the map folds over before.
pub(super) fn undistort(
    distorted: &Point2<f64>,
    distort: impl Fn(&Point2<f64>) -> Point2<f64>,
    jacobian: impl Fn(&Point2<f64>) -> Matrix2<f64>,
) -> Option<Point2<f64>> {
    let newton = |start: Point2<f64>, goal: &Point2<f64>| {
        let mut ideal = start;
        for _ in 0..STEPS {
            let at = jacobian(&ideal);
            let step = at.try_inverse()? * (distort(&ideal) - goal);
            ideal -= step;
            if step.norm() < 1e-14 * (1.0 + ideal.coords.norm()) {
                let upright = at.determinant() > 0.0 && at.trace() > 0.0;
                return upright.then_some(ideal);
            }
        }
        None
    };
    // a lens that moves the point by more than itself has left the neighbourhood
    let near = |ideal: &Point2<f64>| ideal.coords.norm() < 2.0 * distorted.coords.norm() + 1e-9;
    if let Some(ideal) = newton(*distorted, distorted).filter(near) {
        return Some(ideal);
    }
    let mut ideal = Point2::origin();
    for station in 1..=STATIONS {
        let goal = distorted * (station as f64 / STATIONS as f64);
        let next = newton(ideal, &goal)?;
        // a jump to another sheet of the map
        let leap = (next - ideal).norm();
        if leap > 0.5 * (next.coords.norm() + 1.0) {
            return None;
        }
        ideal = next;
    }
    Some(ideal)
}
