//! A camera as a vector of named numbers, and the derivatives of a projection with respect to them.
//!
//! The adjustment in `calibrate` sees a camera only through this file: names, values and Jacobian. Another lens
//! model brings its own names; nothing in the solver counts on nine.

use super::{Camera, Intrinsics, PlumbBob};
use nalgebra::{Matrix2x3, Point2, Point3};

/// A projected point and how it moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projection {
    /// Where the point appears, px.
    pub pixel: Point2<f64>,
    /// Derivative of the pixel with respect to the point in the camera frame, px per m.
    pub wrt_point: Matrix2x3<f64>,
    /// Derivative of the pixel with respect to each of [`Camera::PARAMETER_NAMES`], as (dx, dy).
    pub wrt_parameters: [[f64; 2]; Camera::PARAMETER_COUNT],
}

impl Camera {
    /// How many numbers describe the camera.
    pub const PARAMETER_COUNT: usize = 9;

    /// Their names, in the order of [`Camera::parameters`]: px for the first four, no unit for the rest. The
    /// distortion is in the order of `plumb_bob`.
    pub const PARAMETER_NAMES: [&'static str; Self::PARAMETER_COUNT] =
        ["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"];

    /// The values of [`Camera::PARAMETER_NAMES`].
    pub fn parameters(&self) -> [f64; Self::PARAMETER_COUNT] {
        let (i, d) = (&self.intrinsics, &self.distortion);
        [i.fx, i.fy, i.cx, i.cy, d.k1, d.k2, d.p1, d.p2, d.k3]
    }

    /// A camera of the same frame size with these values of [`Camera::PARAMETER_NAMES`].
    pub fn with_parameters(&self, values: &[f64; Self::PARAMETER_COUNT]) -> Self {
        let [fx, fy, cx, cy, k1, k2, p1, p2, k3] = *values;
        Self {
            intrinsics: Intrinsics { fx, fy, cx, cy },
            distortion: PlumbBob { k1, k2, p1, p2, k3 },
            ..*self
        }
    }

    /// Projects a point in the camera frame together with all derivatives; `None` at or behind the camera.
    pub fn project_with_derivatives(&self, point_m: &Point3<f64>) -> Option<Projection> {
        let pixel = self.project(point_m)?;
        let k = &self.intrinsics;
        let (inverse_z, ideal) = (
            1.0 / point_m.z,
            Point2::new(point_m.x / point_m.z, point_m.y / point_m.z),
        );
        let (x, y) = (ideal.x, ideal.y);
        let r2 = x * x + y * y;
        let distorted = self.distortion.distort(&ideal);
        let lens = self.distortion.jacobian(&ideal);
        let (row_x, row_y) = (lens.row(0) * k.fx, lens.row(1) * k.fy);
        // d(X/Z, Y/Z) / d(X, Y, Z) has the columns (1, 0), (0, 1) and (-x, -y), all over Z
        let wrt_point = Matrix2x3::new(
            row_x[0],
            row_x[1],
            -row_x[0] * x - row_x[1] * y,
            row_y[0],
            row_y[1],
            -row_y[0] * x - row_y[1] * y,
        ) * inverse_z;
        let radial = |power: f64| [k.fx * x * power, k.fy * y * power];
        Some(Projection {
            pixel,
            wrt_point,
            wrt_parameters: [
                [distorted.x, 0.0],
                [0.0, distorted.y],
                [1.0, 0.0],
                [0.0, 1.0],
                radial(r2),
                radial(r2 * r2),
                [k.fx * 2.0 * x * y, k.fy * (r2 + 2.0 * y * y)],
                [k.fx * (r2 + 2.0 * x * x), k.fy * 2.0 * x * y],
                radial(r2 * r2 * r2),
            ],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        Camera {
            width: 640,
            height: 480,
            intrinsics: Intrinsics {
                fx: 410.0,
                fy: 395.0,
                cx: 311.0,
                cy: 245.0,
            },
            distortion: PlumbBob {
                k1: -0.3,
                k2: 0.11,
                p1: 0.002,
                p2: -0.003,
                k3: -0.02,
            },
        }
    }

    #[test]
    fn parameters_go_in_and_out() {
        let values = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0];
        assert_eq!(camera().with_parameters(&values).parameters(), values);
        assert_eq!(
            camera().with_parameters(&camera().parameters()),
            camera(),
            "nothing but the parameters may change"
        );
    }

    #[test]
    fn derivatives_agree_with_finite_differences() {
        let (camera, point) = (camera(), Point3::new(0.07, -0.05, 0.16));
        let projection = camera.project_with_derivatives(&point).unwrap();
        assert_eq!(Some(projection.pixel), camera.project(&point));
        for axis in 0..3 {
            let h = 1e-7;
            let (mut low, mut high) = (point, point);
            low[axis] -= h;
            high[axis] += h;
            let slope =
                (camera.project(&high).unwrap() - camera.project(&low).unwrap()) / (2.0 * h);
            assert!((projection.wrt_point.column(axis) - slope).norm() < 1e-5 * slope.norm());
        }
        for (at, name) in Camera::PARAMETER_NAMES.iter().enumerate() {
            let (mut low, mut high) = (camera.parameters(), camera.parameters());
            low[at] -= 1e-4;
            high[at] += 1e-4;
            let slope = (camera.with_parameters(&high).project(&point).unwrap()
                - camera.with_parameters(&low).project(&point).unwrap())
                / 2e-4;
            let ours = projection.wrt_parameters[at];
            let error = (ours[0] - slope.x).hypot(ours[1] - slope.y);
            assert!(error < 1e-6 * (1.0 + slope.norm()), "{name}: {error}");
        }
    }

    #[test]
    fn nothing_behind_the_camera_projects() {
        let behind = Point3::new(0.0, 0.0, -1.0);
        assert!(camera().project_with_derivatives(&behind).is_none());
    }
}
