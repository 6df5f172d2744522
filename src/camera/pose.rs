//! Where the board stands: the rigid motion from the board frame to the camera frame (paper equations 1 to 3).

use nalgebra::{Point3, Rotation3, Vector3};

/// Board to camera: `point_camera = rotation * point_board + translation_m`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Rotation from the board frame to the camera frame.
    pub rotation: Rotation3<f64>,
    /// The board's origin (ring 0, 0) in the camera frame, m.
    pub translation_m: Vector3<f64>,
}

impl Pose {
    /// A pose from a rotation vector (axis times angle, rad) and a translation (m).
    pub fn from_rotation_vector(
        rotation_vector: Vector3<f64>,
        translation_m: Vector3<f64>,
    ) -> Self {
        Self {
            rotation: Rotation3::new(rotation_vector),
            translation_m,
        }
    }

    /// Axis times angle, rad.
    pub fn rotation_vector(&self) -> Vector3<f64> {
        self.rotation.scaled_axis()
    }

    /// A point of the board plane (m) in the camera frame (m).
    pub fn board_to_camera(&self, point_m: [f64; 2]) -> Point3<f64> {
        self.rotation * Point3::new(point_m[0], point_m[1], 0.0) + self.translation_m
    }

    /// The angle between the board's normal and the optical axis, rad: 0 for a frontal view.
    pub fn tilt_rad(&self) -> f64 {
        (self.rotation * Vector3::z()).z.clamp(-1.0, 1.0).acos()
    }
}
