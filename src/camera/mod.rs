//! The camera: pinhole plus lens distortion, and where the board stands before it.
//!
//! Camera frame (REP 103, optical): x right, y down, z forward into the scene, metres. A point projects as
//! normalised coordinates (X/Z, Y/Z) -> distortion -> pixel (fx x + cx, fy y + cy); of a fisheye, whose field may reach
//! beyond 90 degrees, the angle from the axis takes the place of the normalised coordinates.

mod distortion;
mod equidistant;
pub(crate) mod homography;
mod parameters;
mod plumb_bob;
mod pose;
mod radial_tangential;
mod rational_polynomial;
mod undistort;

pub use distortion::{Distortion, LensModel, UnknownLensModel};
pub use equidistant::Equidistant;
pub use parameters::{MOST_PARAMETERS, Projection};
pub use plumb_bob::PlumbBob;
pub use pose::Pose;
pub use rational_polynomial::RationalPolynomial;

use nalgebra::{Point2, Point3, Vector3};

/// Focal lengths and principal point, px.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Intrinsics {
    /// Focal length along x, px.
    pub fx: f64,
    /// Focal length along y, px.
    pub fy: f64,
    /// Principal point, px from the centre of the top-left pixel.
    pub cx: f64,
    /// Principal point, px from the centre of the top-left pixel.
    pub cy: f64,
}

/// A camera of known size, intrinsics and lens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Width of its frames, px.
    pub width: u32,
    /// Height of its frames, px.
    pub height: u32,
    /// Focal lengths and principal point.
    pub intrinsics: Intrinsics,
    /// The lens (paper equation 5 and others).
    pub distortion: Distortion,
}

impl Camera {
    /// The lens model.
    pub fn model(&self) -> LensModel {
        self.distortion.model()
    }

    /// Pixel of a point in the camera frame (paper equations 4 to 7); `None` where it has no image: at or behind the camera,
    /// but for a fisheye whose field reaches there.
    pub fn project(&self, point_m: &Point3<f64>) -> Option<Point2<f64>> {
        if let Distortion::Equidistant(lens) = &self.distortion {
            return Some(self.pixel(&lens.project(&point_m.coords)?));
        }
        if point_m.z <= 0.0 || !point_m.z.is_finite() {
            return None;
        }
        let normalised = Point2::new(point_m.x / point_m.z, point_m.y / point_m.z);
        Some(self.pixel(&self.distortion.distort(&normalised)))
    }

    /// Normalised, undistorted coordinates (X/Z, Y/Z) of the ray through a pixel; `None` where the distortion cannot
    /// be undone there or the ray does not point forward.
    pub fn unproject(&self, pixel: &Point2<f64>) -> Option<Point2<f64>> {
        self.distortion.undistort(&self.distorted(pixel))
    }

    /// Direction of the ray through a pixel in the camera frame, of unit length; `None` where the distortion cannot be undone there.
    pub fn ray(&self, pixel: &Point2<f64>) -> Option<Vector3<f64>> {
        if let Distortion::Equidistant(lens) = &self.distortion {
            return lens.ray(&self.distorted(pixel));
        }
        self.unproject(pixel)
            .map(|ideal| Vector3::new(ideal.x, ideal.y, 1.0).normalize())
    }

    /// Distorted normalised coordinates of a pixel.
    fn distorted(&self, pixel: &Point2<f64>) -> Point2<f64> {
        let k = &self.intrinsics;
        Point2::new((pixel.x - k.cx) / k.fx, (pixel.y - k.cy) / k.fy)
    }

    /// Pixel of distorted normalised coordinates.
    pub fn pixel(&self, distorted: &Point2<f64>) -> Point2<f64> {
        let k = &self.intrinsics;
        Point2::new(k.fx * distorted.x + k.cx, k.fy * distorted.y + k.cy)
    }
}
