//! An ellipse in the image and its conic matrix.

use nalgebra::{Matrix3, Point2};

/// An ellipse by its centre, semi-axes and direction; pixels and radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ellipse {
    /// Geometric centre, px (not the projected centre of the circle).
    pub centre: Point2<f64>,
    /// Semi-major axis, px.
    pub major: f64,
    /// Semi-minor axis, px, at most `major`.
    pub minor: f64,
    /// Direction of the major axis from image +x towards +y, rad, in (-pi/2, pi/2].
    pub angle: f64,
}

impl Ellipse {
    /// Radius of the circle of the same area, px.
    pub fn mean_radius(&self) -> f64 {
        (self.major * self.minor).sqrt()
    }

    /// The symmetric matrix E with (x, y, 1) E (x, y, 1)^T = 0 on the ellipse and negative inside (paper equation 26).
    pub fn conic(&self) -> Matrix3<f64> {
        let (sin, cos) = self.angle.sin_cos();
        let (ia, ib) = (self.major.powi(-2), self.minor.powi(-2));
        let (a, b, c) = (
            cos * cos * ia + sin * sin * ib,
            cos * sin * (ia - ib),
            sin * sin * ia + cos * cos * ib,
        );
        let (x, y) = (self.centre.x, self.centre.y);
        let (d, e) = (-(a * x + b * y), -(b * x + c * y));
        let f = -(d * x + e * y) - 1.0;
        Matrix3::new(a, b, d, b, c, e, d, e, f)
    }

    /// The ellipse of a conic matrix of any scale; `None` where the conic is not a real ellipse.
    pub fn from_conic(conic: &Matrix3<f64>) -> Option<Self> {
        let block = conic.fixed_view::<2, 2>(0, 0).into_owned();
        let centre = block.try_inverse()? * -conic.fixed_view::<2, 1>(0, 2);
        let value = conic[(2, 2)] + conic[(0, 2)] * centre.x + conic[(1, 2)] * centre.y;
        let eigen = (block / -value).symmetric_eigen();
        let (major_at, minor_at) = if eigen.eigenvalues[0] <= eigen.eigenvalues[1] {
            (0, 1)
        } else {
            (1, 0)
        };
        let (low, high) = (eigen.eigenvalues[major_at], eigen.eigenvalues[minor_at]);
        let real = low > 0.0 && high.is_finite() && centre.x.is_finite() && centre.y.is_finite();
        if !real {
            return None;
        }
        let axis = eigen.eigenvectors.column(major_at);
        let mut angle = axis[1].atan2(axis[0]);
        if angle <= -std::f64::consts::FRAC_PI_2 {
            angle += std::f64::consts::PI;
        } else if angle > std::f64::consts::FRAC_PI_2 {
            angle -= std::f64::consts::PI;
        }
        Some(Self {
            centre: Point2::new(centre.x, centre.y),
            major: low.sqrt().recip(),
            minor: high.sqrt().recip(),
            angle,
        })
    }

    /// Whether a point lies inside the curve.
    pub fn contains(&self, point: &Point2<f64>) -> bool {
        let offset = point - self.centre;
        let (sin, cos) = self.angle.sin_cos();
        let u = (cos * offset.x + sin * offset.y) / self.major;
        let v = (cos * offset.y - sin * offset.x) / self.minor;
        u * u + v * v < 1.0
    }

    /// The point at parameter `t` rad (0 on the major axis).
    pub fn point(&self, t: f64) -> Point2<f64> {
        let (sin, cos) = self.angle.sin_cos();
        let (u, v) = (self.major * t.cos(), self.minor * t.sin());
        Point2::new(
            self.centre.x + cos * u - sin * v,
            self.centre.y + sin * u + cos * v,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conic_and_ellipse_are_one_another_s_inverse_at_any_scale() {
        let ellipse = Ellipse {
            centre: Point2::new(310.5, -42.25),
            major: 31.0,
            minor: 17.5,
            angle: 0.7,
        };
        for scale in [1.0, -3.5, 1e-6] {
            let back = Ellipse::from_conic(&(ellipse.conic() * scale)).unwrap();
            assert!((back.centre - ellipse.centre).norm() < 1e-8);
            assert!((back.major - ellipse.major).abs() < 1e-7);
            assert!((back.minor - ellipse.minor).abs() < 1e-7);
            assert!((back.angle - ellipse.angle).abs() < 1e-9);
        }
        assert!(
            ellipse.contains(&(ellipse.centre + (ellipse.point(2.0) - ellipse.centre) * 0.999))
        );
        assert!(
            !ellipse.contains(&(ellipse.centre + (ellipse.point(2.0) - ellipse.centre) * 1.001))
        );
        let p = ellipse.point(1.1).to_homogeneous();
        assert!((p.transpose() * ellipse.conic() * p)[0].abs() < 1e-9);
    }

    #[test]
    fn hyperbolas_and_empty_conics_are_no_ellipse() {
        assert!(Ellipse::from_conic(&Matrix3::from_diagonal(&[1.0, -1.0, -1.0].into())).is_none());
        assert!(Ellipse::from_conic(&Matrix3::identity()).is_none());
        assert!(Ellipse::from_conic(&Matrix3::zeros()).is_none());
    }
}
