//! The lens model that ROS calls `rational_polynomial`: a ratio of radial polynomials, for wide lenses.

use super::radial_tangential::radial_tangential_jacobian;
use super::undistort::undistort;
use nalgebra::{Matrix2, Point2};

/// Distortion coefficients; with k4, k5 and k6 at zero it is `plumb_bob`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RationalPolynomial {
    /// Radial, r^2, above the line.
    pub k1: f64,
    /// Radial, r^4, above the line.
    pub k2: f64,
    /// Tangential.
    pub p1: f64,
    /// Tangential.
    pub p2: f64,
    /// Radial, r^6, above the line.
    pub k3: f64,
    /// Radial, r^2, below the line.
    pub k4: f64,
    /// Radial, r^4, below the line.
    pub k5: f64,
    /// Radial, r^6, below the line.
    pub k6: f64,
}

impl RationalPolynomial {
    /// Numerator and denominator of the radial factor at r^2.
    fn ratio(&self, r2: f64) -> (f64, f64) {
        (
            1.0 + r2 * (self.k1 + r2 * (self.k2 + r2 * self.k3)),
            1.0 + r2 * (self.k4 + r2 * (self.k5 + r2 * self.k6)),
        )
    }

    /// Distorted normalised coordinates of an ideal point.
    pub fn distort(&self, ideal: &Point2<f64>) -> Point2<f64> {
        let (x, y) = (ideal.x, ideal.y);
        let r2 = x * x + y * y;
        let (above, below) = self.ratio(r2);
        let radial = above / below;
        Point2::new(
            x * radial + 2.0 * self.p1 * x * y + self.p2 * (r2 + 2.0 * x * x),
            y * radial + self.p1 * (r2 + 2.0 * y * y) + 2.0 * self.p2 * x * y,
        )
    }

    /// Derivative of [`RationalPolynomial::distort`] with respect to the ideal point.
    pub fn jacobian(&self, ideal: &Point2<f64>) -> Matrix2<f64> {
        let r2 = ideal.coords.norm_squared();
        let (above, below) = self.ratio(r2);
        let radial = above / below;
        // by r^2
        let up = self.k1 + r2 * (2.0 * self.k2 + 3.0 * r2 * self.k3);
        let down = self.k4 + r2 * (2.0 * self.k5 + 3.0 * r2 * self.k6);
        let slope = (up - radial * down) / below;
        radial_tangential_jacobian(ideal, (radial, slope), (self.p1, self.p2))
    }

    /// Derivative of the distorted point with respect to k1, k2, p1, p2, k3, k4, k5, k6.
    pub(super) fn by_coefficients(&self, ideal: &Point2<f64>) -> [[f64; 2]; 8] {
        let (x, y) = (ideal.x, ideal.y);
        let r2 = x * x + y * y;
        let (above, below) = self.ratio(r2);
        let up = |power: f64| [x * power / below, y * power / below];
        let down = |power: f64| up(-power * above / below);
        [
            up(r2),
            up(r2 * r2),
            [2.0 * x * y, r2 + 2.0 * y * y],
            [r2 + 2.0 * x * x, 2.0 * x * y],
            up(r2 * r2 * r2),
            down(r2),
            down(r2 * r2),
            down(r2 * r2 * r2),
        ]
    }

    /// Ideal point of distorted coordinates; `None` where the model does not reach them or folds over.
    pub fn undistort(&self, distorted: &Point2<f64>) -> Option<Point2<f64>> {
        let ideal = undistort(distorted, |p| self.distort(p), |p| self.jacobian(p))?;
        // a denominator that passed zero on the way belongs to another branch
        (self.ratio(ideal.coords.norm_squared()).1 > 0.0).then_some(ideal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::PlumbBob;

    const LENS: RationalPolynomial = RationalPolynomial {
        k1: 0.9,
        k2: 0.12,
        p1: 0.001,
        p2: -0.002,
        k3: 0.004,
        k4: 1.25,
        k5: 0.4,
        k6: 0.03,
    };

    #[test]
    fn undistort_undoes_distort() {
        for (x, y) in [(0.0, 0.0), (0.3, -0.2), (-1.5, 0.4), (0.01, 1.6)] {
            let ideal = Point2::new(x, y);
            let back = LENS.undistort(&LENS.distort(&ideal)).unwrap();
            assert!((back - ideal).norm() < 1e-11, "{back} {ideal}");
        }
    }

    #[test]
    fn without_a_denominator_it_is_plumb_bob() {
        let plumb_bob = PlumbBob {
            k1: -0.34,
            k2: 0.12,
            p1: 0.001,
            p2: -0.002,
            k3: -0.02,
        };
        let PlumbBob { k1, k2, p1, p2, k3 } = plumb_bob;
        let rational = RationalPolynomial {
            k1,
            k2,
            p1,
            p2,
            k3,
            ..RationalPolynomial::default()
        };
        let ideal = Point2::new(0.31, -0.22);
        assert_eq!(rational.distort(&ideal), plumb_bob.distort(&ideal));
        assert_eq!(rational.jacobian(&ideal), plumb_bob.jacobian(&ideal));
    }
}
