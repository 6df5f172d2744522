//! The fisheye model that ROS calls `equidistant` (Kannala and Brandt 2006, as OpenCV's fisheye module writes it): the distance from
//! the principal point grows with the angle from the optical axis instead of with its tangent, so that a field of view of 180
//! degrees and more has an image.

use nalgebra::{Matrix2, Matrix2x3, Point2, Vector3};

/// Coefficients of theta_d = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8), theta in rad.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Equidistant {
    /// k1 to k4.
    pub k: [f64; 4],
}

/// Below this radius over depth the image is that of a pinhole to rounding.
const AXIS: f64 = 1e-9;
/// Newton steps for the angle of a radius.
const STEPS: usize = 60;

impl Equidistant {
    /// Radius in the image (focal lengths) of an angle from the axis (rad), and its derivative.
    fn radius(&self, theta: f64) -> (f64, f64) {
        let t2 = theta * theta;
        let [a, b, c, d] = self.k;
        let value = theta * (1.0 + t2 * (a + t2 * (b + t2 * (c + t2 * d))));
        let slope = 1.0 + t2 * (3.0 * a + t2 * (5.0 * b + t2 * (7.0 * c + t2 * 9.0 * d)));
        (value, slope)
    }

    /// Angle from the axis (rad) of a radius in the image (focal lengths); `None` beyond the largest radius that the polynomial
    /// reaches while it grows, or beyond 180 degrees.
    fn angle(&self, radius: f64) -> Option<f64> {
        // the first root, by bisection on the rising part, then Newton's steps
        let (mut low, mut high) = (0.0, 0.0);
        let pace = 0.02;
        while self.radius(high).0 < radius {
            low = high;
            high += pace;
            if high > std::f64::consts::PI || self.radius(high).1 <= 0.0 {
                return None;
            }
        }
        let mut theta = 0.5 * (low + high);
        for _ in 0..STEPS {
            let (value, slope) = self.radius(theta);
            let step = (value - radius) / slope;
            theta = (theta - step).clamp(low, high);
            if step.abs() < 1e-15 * (1.0 + theta) {
                break;
            }
        }
        Some(theta)
    }

    /// Image, in focal lengths, of a direction of any length, forward or backward; `None` for no direction, right behind, and where
    /// the polynomial has stopped to grow.
    pub fn project(&self, ray: &Vector3<f64>) -> Option<Point2<f64>> {
        let across = ray.x.hypot(ray.y);
        if across <= AXIS * ray.z {
            return (ray.z > 0.0).then(|| Point2::new(ray.x / ray.z, ray.y / ray.z));
        }
        let theta = across.atan2(ray.z);
        let (radius, slope) = self.radius(theta);
        let scale = radius / across;
        (slope > 0.0 && scale.is_finite() && theta < std::f64::consts::PI)
            .then(|| Point2::new(ray.x * scale, ray.y * scale))
    }

    /// Derivative of [`Equidistant::project`] with respect to the ray, and by k1 to k4.
    pub(super) fn derivatives(&self, ray: &Vector3<f64>) -> (Matrix2x3<f64>, [[f64; 2]; 4]) {
        let (x, y, z) = (ray.x, ray.y, ray.z);
        let across = x.hypot(y);
        if across <= AXIS * z {
            let by_ray = Matrix2x3::new(1.0, 0.0, -x / z, 0.0, 1.0, -y / z) / z;
            return (by_ray, [[0.0; 2]; 4]);
        }
        let theta = across.atan2(z);
        let (radius, slope) = self.radius(theta);
        let length2 = across * across + z * z;
        let (c, s) = (x / across, y / across);
        // theta by (x, y, z); the direction (c, s) by (x, y)
        let by_across = slope * z / length2;
        let by_z = -slope * across / length2;
        let turn = radius / across;
        let by_ray = Matrix2x3::new(
            c * c * by_across + s * s * turn,
            c * s * (by_across - turn),
            c * by_z,
            c * s * (by_across - turn),
            s * s * by_across + c * c * turn,
            s * by_z,
        );
        let t2 = theta * theta;
        let mut power = theta;
        let by_k = std::array::from_fn(|_| {
            power *= t2;
            [c * power, s * power]
        });
        (by_ray, by_k)
    }

    /// The direction (unit length) whose image, in focal lengths, this is; `None` beyond the image circle.
    pub fn ray(&self, image: &Point2<f64>) -> Option<Vector3<f64>> {
        let radius = image.coords.norm();
        let theta = self.angle(radius)?;
        if radius == 0.0 {
            return Some(Vector3::z());
        }
        let (sin, cos) = theta.sin_cos();
        Some(Vector3::new(
            image.x / radius * sin,
            image.y / radius * sin,
            cos,
        ))
    }

    /// As [`Equidistant::project`] of the ray (x, y, 1).
    pub fn distort(&self, ideal: &Point2<f64>) -> Point2<f64> {
        let r = ideal.coords.norm();
        if r <= AXIS {
            return *ideal;
        }
        Point2::from(ideal.coords * (self.radius(r.atan()).0 / r))
    }

    /// Derivative of [`Equidistant::distort`] with respect to the ideal point.
    pub fn jacobian(&self, ideal: &Point2<f64>) -> Matrix2<f64> {
        let (by_ray, _) = self.derivatives(&Vector3::new(ideal.x, ideal.y, 1.0));
        by_ray.fixed_columns::<2>(0).into_owned()
    }

    /// Ideal point (X/Z, Y/Z) of an image in focal lengths; `None` where the ray does not point forward.
    pub fn undistort(&self, image: &Point2<f64>) -> Option<Point2<f64>> {
        let ray = self.ray(image)?;
        (ray.z > 1e-6).then(|| Point2::new(ray.x / ray.z, ray.y / ray.z))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LENS: Equidistant = Equidistant {
        k: [-0.02, 0.004, -0.002, 0.0003],
    };

    #[test]
    fn rays_come_back_also_from_behind() {
        for degrees in [0.0_f64, 1e-8, 0.5, 30.0, 85.0, 90.0, 105.0] {
            for around in [0.1_f64, 2.0, 4.5] {
                let (sin, cos) = degrees.to_radians().sin_cos();
                let ray = Vector3::new(sin * around.cos(), sin * around.sin(), cos);
                let image = LENS.project(&(ray * 3.0)).unwrap();
                let back = LENS.ray(&image).unwrap();
                assert!((back - ray).norm() < 1e-12, "{degrees}: {back} {ray}");
            }
        }
        assert!(LENS.project(&Vector3::new(0.0, 0.0, -1.0)).is_none());
        assert!(
            LENS.undistort(&LENS.project(&Vector3::new(1.0, 0.0, -0.1)).unwrap())
                .is_none()
        );
    }

    #[test]
    fn the_plane_of_normalised_coordinates_is_the_ray_at_depth_one() {
        let ideal = Point2::new(3.0, -7.0);
        let ray = Vector3::new(3.0, -7.0, 1.0);
        assert!((LENS.distort(&ideal) - LENS.project(&ray).unwrap()).norm() < 1e-14);
        assert!((LENS.undistort(&LENS.distort(&ideal)).unwrap() - ideal).norm() < 1e-9);
    }
}
