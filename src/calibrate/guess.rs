//! Where the adjustment starts.

use super::observations::Observation;
use super::rays::pose_of_rays;
use super::roll::Roll;
use super::{CalibrateError, CalibrateOptions, start_homography, zhang};
use crate::camera::{Camera, Distortion, Intrinsics, LensModel, Pose};
use nalgebra::{Matrix3, Point2};

/// Focal lengths over the longer side of the frame that are tried beside the closed forms: fields of view of 90 to 4
/// degrees. Strong distortion or few views can make the closed forms useless, and the adjustment finds its way from
/// any guess within a factor of two.
const TRIED_FOCALS: [f64; 6] = [0.5, 0.8, 1.4, 2.8, 6.0, 14.0];

/// Fields of view over the longer side that are tried for a fisheye, degrees.
const TRIED_FIELDS_DEG: [f64; 9] = [40.0, 60.0, 80.0, 100.0, 120.0, 145.0, 170.0, 195.0, 220.0];

/// A camera, and the pose of every view that takes part; views that have none with it are left out. Of several guesses it is the one
/// with the smallest typical reprojection error.
pub(super) fn guess(
    roll: &Roll,
    size: (u32, u32),
    options: &CalibrateOptions,
) -> Result<(Camera, Vec<Option<Pose>>), CalibrateError> {
    let active = roll.active();
    let rings: Vec<&[Observation]> = active.iter().map(|at| roll.rings[*at].as_slice()).collect();
    let homographies: Vec<Option<Matrix3<f64>>> = rings
        .iter()
        .map(|rings| start_homography::of_marked(rings))
        .collect();
    let best = candidates(&homographies, size, options)
        .into_iter()
        .map(|camera| {
            let views = rings.iter().zip(&homographies);
            let poses: Vec<Option<Pose>> = views
                .map(|(rings, homography)| match homography {
                    // a pinhole's homography is at hand
                    Some(h) if camera.distortion.is_none() => zhang::pose(h, &camera.intrinsics),
                    _ => pose(&camera, rings),
                })
                .collect();
            let errors = rings.iter().zip(&poses);
            let error: f64 = errors
                .map(|(rings, pose)| typical_error_px(&camera, pose.as_ref(), rings))
                .sum();
            (error, camera, poses)
        })
        .filter(|(_, _, poses)| poses.iter().any(Option::is_some))
        .min_by(|a, b| a.0.total_cmp(&b.0));
    let (_, camera, found) = best.ok_or_else(|| CalibrateError::Absurd {
        what: "no position of the board explains any view: mirrored, or held values that cannot be"
            .to_owned(),
    })?;
    let mut poses = vec![None; roll.rings.len()];
    for (at, pose) in active.into_iter().zip(found) {
        poses[at] = pose;
    }
    Ok((camera, poses))
}

fn candidates(
    homographies: &[Option<Matrix3<f64>>],
    (width, height): (u32, u32),
    options: &CalibrateOptions,
) -> Vec<Camera> {
    let none = vec![0.0; options.model.coefficient_count()];
    let camera = |intrinsics: Intrinsics| Camera {
        width,
        height,
        intrinsics,
        // as many zeros as the model has coefficients
        distortion: Distortion::new(options.model, &none).unwrap_or_default(),
    };
    if let Some(given) = options.guess {
        let start = if given.model() == options.model {
            given
        } else {
            camera(given.intrinsics)
        };
        return vec![options.fixed.hold_at(&start, true)];
    }
    let size = (f64::from(width), f64::from(height));
    let side = size.0.max(size.1);
    let mut guesses: Vec<Intrinsics> = Vec::new();
    if options.model == LensModel::Equidistant {
        let focals = TRIED_FIELDS_DEG.map(|field| side / field.to_radians());
        guesses.extend(focals.map(|f| zhang::centred(f, size)));
    } else {
        let homographies: Vec<Matrix3<f64>> = homographies.iter().flatten().copied().collect();
        guesses.extend(zhang::intrinsics(&homographies, size));
        let focal = zhang::focal_length_px(&homographies, size);
        guesses.extend(focal.map(|f| zhang::centred(f, size)));
        guesses.extend(TRIED_FOCALS.map(|f| zhang::centred(f * side, size)));
    }
    guesses
        .into_iter()
        .map(|intrinsics| options.fixed.hold_at(&camera(intrinsics), false))
        .collect()
}

/// The pose of a view with a camera, from the rings that have a share.
pub(super) fn pose(camera: &Camera, rings: &[Observation]) -> Option<Pose> {
    let near = rings.iter().filter(|ring| ring.share > 0.0);
    let pairs: Vec<(Point2<f64>, Point2<f64>)> = near
        .map(|ring| (Point2::from(ring.board_m), ring.pixel - ring.bias_px))
        .collect();
    pose_of_rays(camera, &pairs)
}

/// Median distance between measured and projected rings, px; the frame's width where there is no pose.
fn typical_error_px(camera: &Camera, pose: Option<&Pose>, rings: &[Observation]) -> f64 {
    let worst = f64::from(camera.width);
    let Some(pose) = pose else {
        return worst;
    };
    let mut errors: Vec<f64> = rings
        .iter()
        .map(|ring| {
            camera
                .project(&pose.board_to_camera(ring.board_m))
                .map_or(worst, |pixel| (pixel - ring.pixel).norm().min(worst))
        })
        .collect();
    errors.sort_by(f64::total_cmp);
    errors[errors.len() / 2]
}
