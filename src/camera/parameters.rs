//! A camera as a vector of named numbers, and the derivatives of a projection with respect to them.
//!
//! The adjustment in `calibrate` sees a camera only through this file: names, values and Jacobian. Another lens
//! model brings its own names; nothing in the solver counts on their number.

use super::distortion::MOST_COEFFICIENTS;
use super::{Camera, Distortion, Intrinsics};
use nalgebra::{Matrix2, Matrix2x3, Point2, Point3};

/// Most numbers that any camera has.
pub const MOST_PARAMETERS: usize = 4 + MOST_COEFFICIENTS;

/// A projected point and how it moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projection {
    /// Where the point appears, px.
    pub pixel: Point2<f64>,
    /// Derivative of the pixel with respect to the point in the camera frame, px per m.
    pub wrt_point: Matrix2x3<f64>,
    /// Derivative of the pixel with respect to each of [`Camera::parameter_names`], as (dx, dy); 0 beyond them.
    pub wrt_parameters: [[f64; 2]; MOST_PARAMETERS],
}

impl Camera {
    /// Names of [`Camera::parameters`]: px for the first four, no unit for the rest.
    pub fn parameter_names(&self) -> &'static [&'static str] {
        self.model().parameter_names()
    }

    /// The values of [`Camera::parameter_names`].
    pub fn parameters(&self) -> Vec<f64> {
        let i = &self.intrinsics;
        let mut values = vec![i.fx, i.fy, i.cx, i.cy];
        values.extend(self.distortion.coefficients());
        values
    }

    /// A camera of the same frame size and lens model with these values of [`Camera::parameter_names`]; values that are
    /// missing keep those of this camera.
    pub fn with_parameters(&self, values: &[f64]) -> Self {
        let mut all = self.parameters();
        for (value, new) in all.iter_mut().zip(values) {
            *value = *new;
        }
        let (pinhole, lens) = all.split_at(4);
        Self {
            intrinsics: Intrinsics {
                fx: pinhole[0],
                fy: pinhole[1],
                cx: pinhole[2],
                cy: pinhole[3],
            },
            // as many coefficients as the model has, or the camera's own
            distortion: Distortion::new(self.model(), lens).unwrap_or(self.distortion),
            ..*self
        }
    }

    /// Projects a point in the camera frame together with all derivatives; `None` where it has no image.
    pub fn project_with_derivatives(&self, point_m: &Point3<f64>) -> Option<Projection> {
        let pixel = self.project(point_m)?;
        let k = &self.intrinsics;
        let mut lens = [[0.0; 2]; MOST_COEFFICIENTS];
        let by_point = match &self.distortion {
            Distortion::Equidistant(fisheye) => {
                let (by_point, by_k) = fisheye.derivatives(&point_m.coords);
                lens[..4].copy_from_slice(&by_k);
                by_point
            }
            Distortion::PlumbBob(plumb_bob) => {
                let ideal = Point2::new(point_m.x / point_m.z, point_m.y / point_m.z);
                lens[..5].copy_from_slice(&plumb_bob.by_coefficients(&ideal));
                through_depth(&plumb_bob.jacobian(&ideal), &ideal, point_m.z)
            }
            Distortion::RationalPolynomial(rational) => {
                let ideal = Point2::new(point_m.x / point_m.z, point_m.y / point_m.z);
                lens = rational.by_coefficients(&ideal);
                through_depth(&rational.jacobian(&ideal), &ideal, point_m.z)
            }
        };
        let mut wrt_parameters = [[0.0; 2]; MOST_PARAMETERS];
        wrt_parameters[0][0] = (pixel.x - k.cx) / k.fx;
        wrt_parameters[1][1] = (pixel.y - k.cy) / k.fy;
        (wrt_parameters[2][0], wrt_parameters[3][1]) = (1.0, 1.0);
        for (row, by) in wrt_parameters[4..].iter_mut().zip(lens) {
            *row = [k.fx * by[0], k.fy * by[1]];
        }
        let mut wrt_point = by_point;
        wrt_point.row_mut(0).scale_mut(k.fx);
        wrt_point.row_mut(1).scale_mut(k.fy);
        Some(Projection {
            pixel,
            wrt_point,
            wrt_parameters,
        })
    }
}

/// The derivative by (X, Y, Z) of a function of (X/Z, Y/Z): the columns of the latter are (1, 0), (0, 1) and (-x, -y), all over Z.
fn through_depth(by_ideal: &Matrix2<f64>, ideal: &Point2<f64>, z: f64) -> Matrix2x3<f64> {
    let depth = -(by_ideal * ideal.coords);
    Matrix2x3::from_columns(&[
        by_ideal.column(0).into_owned(),
        by_ideal.column(1).into_owned(),
        depth,
    ]) / z
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Equidistant, LensModel, PlumbBob, RationalPolynomial};

    fn cameras() -> [Camera; 3] {
        let lenses: [Distortion; 3] = [
            PlumbBob {
                k1: -0.3,
                k2: 0.11,
                p1: 0.002,
                p2: -0.003,
                k3: -0.02,
            }
            .into(),
            RationalPolynomial {
                k1: 0.3,
                k2: 0.11,
                p1: 0.002,
                p2: -0.003,
                k3: -0.02,
                k4: 0.5,
                k5: 0.2,
                k6: 0.01,
            }
            .into(),
            Equidistant {
                k: [-0.02, 0.01, -0.003, 0.0004],
            }
            .into(),
        ];
        lenses.map(|distortion| Camera {
            width: 640,
            height: 480,
            intrinsics: Intrinsics {
                fx: 410.0,
                fy: 395.0,
                cx: 311.0,
                cy: 245.0,
            },
            distortion,
        })
    }

    #[test]
    fn parameters_go_in_and_out() {
        for camera in cameras() {
            let count = camera.parameter_names().len();
            let values: Vec<f64> = (1..=count).map(|i| i as f64).collect();
            assert_eq!(camera.with_parameters(&values).parameters(), values);
            let same = camera.with_parameters(&camera.parameters());
            assert_eq!(same, camera, "nothing but the parameters may change");
        }
    }

    fn check(camera: &Camera, point: Point3<f64>) {
        let projection = camera.project_with_derivatives(&point).unwrap();
        let plain = camera.project(&point).unwrap();
        assert!((projection.pixel - plain).norm() < 1e-11);
        for axis in 0..3 {
            let h = 1e-7;
            let (mut low, mut high) = (point, point);
            low[axis] -= h;
            high[axis] += h;
            let slope =
                (camera.project(&high).unwrap() - camera.project(&low).unwrap()) / (2.0 * h);
            let ours = projection.wrt_point.column(axis);
            assert!(
                (ours - slope).norm() < 1e-5 * (1.0 + slope.norm()),
                "{axis}"
            );
        }
        for (at, name) in camera.parameter_names().iter().enumerate() {
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
    fn derivatives_agree_with_finite_differences() {
        for camera in cameras() {
            check(&camera, Point3::new(0.07, -0.05, 0.16));
            check(&camera, Point3::new(0.0, 0.0, 0.5));
        }
        let fisheye = cameras()[2];
        assert_eq!(fisheye.model(), LensModel::Equidistant);
        check(&fisheye, Point3::new(-0.5, 0.2, 0.01));
        check(&fisheye, Point3::new(0.3, 0.4, -0.1));
    }

    #[test]
    fn nothing_behind_a_pinhole_projects() {
        let behind = Point3::new(0.0, 0.0, -1.0);
        for camera in cameras() {
            assert!(camera.project_with_derivatives(&behind).is_none());
            assert!(camera.project(&behind).is_none());
        }
    }

    #[test]
    fn rays_come_back() {
        for camera in cameras() {
            let point = Point3::new(0.07, -0.05, 0.16);
            let ray = camera.ray(&camera.project(&point).unwrap()).unwrap();
            assert!((ray - point.coords.normalize()).norm() < 1e-12);
        }
    }
}
