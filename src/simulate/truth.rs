//! What is true of a rendered frame.

use super::scene::{Scene, SceneError};
use crate::camera::{Camera, Pose};
use nalgebra::Point2;

/// One ring as it is, not as it looks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RingTruth {
    /// Row on the board.
    pub row: u16,
    /// Column on the board.
    pub column: u16,
    /// Image of the common centre of its circles, distortion included, px.
    pub centre: Point2<f64>,
    /// Standard deviation of the blur at its centre (half the radius of a disc), px.
    pub blur_sigma_px: f64,
}

/// Camera, pose and rings of a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// The camera.
    pub camera: Camera,
    /// Where the board stands.
    pub pose: Pose,
    /// All rings of the board by row, then column, also those outside the frame.
    pub rings: Vec<RingTruth>,
}

impl Truth {
    /// The truth about a scene.
    ///
    /// # Errors
    /// [`SceneError::BehindCamera`] where a ring has no image.
    pub fn of(scene: &Scene) -> Result<Self, SceneError> {
        let ring = |(row, column)| {
            let [x_m, y_m] = scene.board.centre_m(row, column);
            let point = scene.pose.board_to_camera([x_m, y_m]);
            let centre = scene.camera.project(&point);
            let (size_px, _) = scene.defocus.size_px(point.z);
            Ok(RingTruth {
                row,
                column,
                centre: centre.ok_or(SceneError::BehindCamera { x_m, y_m })?,
                blur_sigma_px: scene.defocus.psf().sigma_px(size_px),
            })
        };
        Ok(Self {
            camera: scene.camera,
            pose: scene.pose,
            rings: scene.board.indices().map(ring).collect::<Result<_, _>>()?,
        })
    }
}
