//! The radial and tangential lens model that ROS calls `plumb_bob` (paper equation 5, as mended).

use super::radial_tangential::radial_tangential_jacobian;
use super::undistort::undistort;
use nalgebra::{Matrix2, Point2};

/// Distortion coefficients; the paper's k4 is p1 and its k5 is p2.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PlumbBob {
    /// Radial, r^2.
    pub k1: f64,
    /// Radial, r^4.
    pub k2: f64,
    /// Tangential.
    pub p1: f64,
    /// Tangential.
    pub p2: f64,
    /// Radial, r^6.
    pub k3: f64,
}

impl PlumbBob {
    /// Distorted normalised coordinates of an ideal point.
    pub fn distort(&self, ideal: &Point2<f64>) -> Point2<f64> {
        let (x, y) = (ideal.x, ideal.y);
        let r2 = x * x + y * y;
        let radial = 1.0 + r2 * (self.k1 + r2 * (self.k2 + r2 * self.k3));
        Point2::new(
            x * radial + 2.0 * self.p1 * x * y + self.p2 * (r2 + 2.0 * x * x),
            y * radial + self.p1 * (r2 + 2.0 * y * y) + 2.0 * self.p2 * x * y,
        )
    }

    /// Derivative of [`PlumbBob::distort`] with respect to the ideal point.
    pub fn jacobian(&self, ideal: &Point2<f64>) -> Matrix2<f64> {
        let r2 = ideal.coords.norm_squared();
        let radial = 1.0 + r2 * (self.k1 + r2 * (self.k2 + r2 * self.k3));
        let slope = self.k1 + r2 * (2.0 * self.k2 + 3.0 * r2 * self.k3);
        radial_tangential_jacobian(ideal, (radial, slope), (self.p1, self.p2))
    }

    /// Derivative of the distorted point with respect to k1, k2, p1, p2, k3.
    pub(super) fn by_coefficients(&self, ideal: &Point2<f64>) -> [[f64; 2]; 5] {
        let (x, y) = (ideal.x, ideal.y);
        let r2 = x * x + y * y;
        let radial = |power: f64| [x * power, y * power];
        [
            radial(r2),
            radial(r2 * r2),
            [2.0 * x * y, r2 + 2.0 * y * y],
            [r2 + 2.0 * x * x, 2.0 * x * y],
            radial(r2 * r2 * r2),
        ]
    }

    /// Ideal point of distorted coordinates; `None` where the lens model does not reach them or folds over.
    pub fn undistort(&self, distorted: &Point2<f64>) -> Option<Point2<f64>> {
        undistort(distorted, |p| self.distort(p), |p| self.jacobian(p))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LENS: PlumbBob = PlumbBob {
        k1: -0.34,
        k2: 0.12,
        p1: 0.001,
        p2: -0.002,
        k3: -0.02,
    };

    #[test]
    fn undistort_undoes_distort() {
        for (x, y) in [(0.0, 0.0), (0.3, -0.2), (-0.5, 0.4), (0.01, 0.6)] {
            let ideal = Point2::new(x, y);
            let back = LENS.undistort(&LENS.distort(&ideal)).unwrap();
            assert!((back - ideal).norm() < 1e-12);
        }
    }

    #[test]
    fn jacobian_agrees_with_finite_differences() {
        let ideal = Point2::new(0.31, -0.22);
        let h = 1e-6;
        let jacobian = LENS.jacobian(&ideal);
        for (axis, step) in [(0, Point2::new(h, 0.0)), (1, Point2::new(0.0, h))] {
            let slope = (LENS.distort(&(ideal + step.coords))
                - LENS.distort(&(ideal - step.coords)))
                / (2.0 * h);
            assert!((jacobian.column(axis) - slope).norm() < 1e-9);
        }
    }
}
