//! Where the adjustment starts.

use super::observations::Observation;
use super::{CalibrateError, Fixed, zhang};
use crate::camera::homography::fit_homography;
use crate::camera::{Camera, Intrinsics, PlumbBob, Pose};
use crate::session::View;
use nalgebra::{Matrix3, Point2};

/// Focal lengths over the longer side of the frame that are tried beside the closed forms: fields of view of 90 to 4
/// degrees. Strong distortion or few views can make the closed forms useless, and the adjustment finds its way from
/// any guess within a factor of two.
const TRIED_FOCALS: [f64; 6] = [0.5, 0.8, 1.4, 2.8, 6.0, 14.0];

/// A camera without distortion and the pose of every view: of the closed-form camera with four unknowns, the one with
/// the focal length alone, and a few plain focal lengths the one with the smallest reprojection error.
pub(super) fn guess(
    views: &[View],
    observations: &[Vec<Observation>],
    fixed: &Fixed,
) -> Result<(Camera, Vec<Pose>), CalibrateError> {
    let homographies = views
        .iter()
        .zip(observations)
        .map(|(view, rings)| {
            plane_to_frame(rings).ok_or_else(|| CalibrateError::DegenerateView {
                source_name: view.source.clone(),
            })
        })
        .collect::<Result<Vec<_>, _>>()?;
    let size = (views[0].width as f64, views[0].height as f64);
    let closed_form = [
        zhang::intrinsics(&homographies, size),
        zhang::focal_length_px(&homographies, size).map(|f| zhang::centred(f, size)),
    ];
    let tried = TRIED_FOCALS.map(|f| Some(zhang::centred(f * size.0.max(size.1), size)));
    let best = closed_form
        .into_iter()
        .chain(tried)
        .flatten()
        .filter_map(|intrinsics| {
            let camera = fixed.hold(&camera(views, intrinsics));
            let poses: Vec<Pose> = homographies
                .iter()
                .map(|h| zhang::pose(h, &camera.intrinsics))
                .collect::<Option<_>>()?;
            let error = squared_error(&camera, &poses, observations)?;
            Some((error, camera, poses))
        })
        .min_by(|a, b| a.0.total_cmp(&b.0));
    // every homography is invertible here, so that only a value held by the user can leave no camera
    best.map(|(_, camera, poses)| (camera, poses))
        .ok_or_else(|| CalibrateError::Absurd {
            what: "no view fits the values that are held".to_owned(),
        })
}

fn camera(views: &[View], intrinsics: Intrinsics) -> Camera {
    let pixels = |size: usize| u32::try_from(size).unwrap_or(u32::MAX);
    Camera {
        width: pixels(views[0].width),
        height: pixels(views[0].height),
        intrinsics,
        distortion: PlumbBob::default(),
    }
}

fn squared_error(
    camera: &Camera,
    poses: &[Pose],
    observations: &[Vec<Observation>],
) -> Option<f64> {
    let mut sum = 0.0;
    for (pose, rings) in poses.iter().zip(observations) {
        for ring in rings {
            let pixel = camera.project(&pose.board_to_camera(ring.board_m))?;
            sum += (pixel - ring.pixel).norm_squared();
        }
    }
    sum.is_finite().then_some(sum)
}

/// Board plane (m) to frame (px); `None` where the rings stand in a line.
pub(super) fn plane_to_frame(rings: &[Observation]) -> Option<Matrix3<f64>> {
    let pairs: Vec<_> = rings
        .iter()
        .map(|ring| (Point2::from(ring.board_m), ring.pixel))
        .collect();
    fit_homography(&pairs)
}
