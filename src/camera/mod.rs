//! The camera: pinhole plus lens distortion, and where the board stands before it.
//!
//! Camera frame (REP 103, optical): x right, y down, z forward into the scene, metres. A point projects as
//! normalised coordinates (X/Z, Y/Z) -> distortion -> pixel (fx x + cx, fy y + cy).

pub(crate) mod homography;
mod parameters;
mod plumb_bob;
mod pose;

pub use parameters::Projection;
pub use plumb_bob::PlumbBob;
pub use pose::Pose;

use nalgebra::{Point2, Point3};

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
    /// Lens distortion (paper equation 5).
    pub distortion: PlumbBob,
}

impl Camera {
    /// Pixel of a point in the camera frame (paper equations 4 to 7); `None` at or behind the camera.
    pub fn project(&self, point_m: &Point3<f64>) -> Option<Point2<f64>> {
        if point_m.z <= 0.0 || !point_m.z.is_finite() {
            return None;
        }
        let normalised = Point2::new(point_m.x / point_m.z, point_m.y / point_m.z);
        Some(self.pixel(&self.distortion.distort(&normalised)))
    }

    /// Normalised, undistorted coordinates (X/Z, Y/Z) of the ray through a pixel; `None` where the distortion cannot
    /// be undone there.
    pub fn unproject(&self, pixel: &Point2<f64>) -> Option<Point2<f64>> {
        let k = &self.intrinsics;
        let distorted = Point2::new((pixel.x - k.cx) / k.fx, (pixel.y - k.cy) / k.fy);
        self.distortion.undistort(&distorted)
    }

    /// Pixel of distorted normalised coordinates.
    pub fn pixel(&self, distorted: &Point2<f64>) -> Point2<f64> {
        let k = &self.intrinsics;
        Point2::new(k.fx * distorted.x + k.cx, k.fy * distorted.y + k.cy)
    }
}
