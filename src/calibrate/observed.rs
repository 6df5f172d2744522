//! What an estimator measures where it is not the projected centre.
//!
//! The constructions of the paper take a ring's image for two ellipses. Perspective displaces an ellipse's centre from the projected
//! one, and the lens bends the curves, which displaces the others too. Camera and pose say by how much: both
//! circles are sent through the camera, ellipses laid through them, the construction repeated. The photometric estimator
//! has the perspective in its model, and its shapes are the camera's.

use super::observations::Observation;
use super::shared::Shared;
use crate::board::Board;
use crate::camera::Pose;
use crate::centre::{CentreEstimator, Estimator, RingEllipses};
use crate::detect::ellipse_through;
use nalgebra::{Point2, Vector2};
use rayon::prelude::*;

/// Points of a circle that are sent through the camera.
const POINTS: usize = 24;

/// Predicts `bias_px` of every ring; `false` where nothing measures anything but projected centres.
pub(super) fn predict(
    board: &Board,
    shared: &Shared,
    poses: &[Option<Pose>],
    rings: &mut [Vec<Observation>],
    estimator: Estimator,
) -> bool {
    let fallback = Estimator::FALLBACK.construction();
    let own = estimator.construction();
    let photometric = own.is_none();
    let of = |ring: &Observation| match (&own, ring.has_covariance) {
        (Some(construction), _) => Some(construction),
        // among rings with a covariance one without was measured on its edges
        (None, false) => fallback.as_ref(),
        (None, true) => None,
    };
    let any = rings.iter().flatten().any(|ring| of(ring).is_some());
    let with_covariance = rings.iter().flatten().any(|ring| ring.has_covariance);
    if !any || (photometric && !with_covariance) {
        return false;
    }
    rings.par_iter_mut().zip(poses).for_each(|(rings, pose)| {
        let Some(pose) = pose else { return };
        for ring in rings {
            let bias =
                of(ring).and_then(|c| bias_px(board, shared, pose, ring.board_m, c.as_ref()));
            ring.bias_px = bias.unwrap_or_default();
        }
    });
    true
}

/// What a construction on the two ellipses gives less the projected centre, px; `None` where the ring has no image.
fn bias_px(
    board: &Board,
    shared: &Shared,
    pose: &Pose,
    centre_m: [f64; 2],
    construction: &dyn CentreEstimator,
) -> Option<Vector2<f64>> {
    let image = |place_m: [f64; 2]| {
        let place = shared.sheet.place_m(place_m, shared.middle_m);
        let point = pose.rotation * place + pose.translation_m;
        shared.camera.project(&point)
    };
    let ellipse = |radius_m: f64| {
        let points = (0..POINTS).map(|i| {
            let (sin, cos) = (std::f64::consts::TAU * i as f64 / POINTS as f64).sin_cos();
            image([centre_m[0] + radius_m * cos, centre_m[1] + radius_m * sin])
        });
        let points: Vec<Point2<f64>> = points.collect::<Option<_>>()?;
        ellipse_through(&points)
    };
    let ellipses = RingEllipses {
        inner: ellipse(board.inner_radius_m())?,
        outer: ellipse(board.outer_radius_m())?,
    };
    Some(construction.estimate(&ellipses).ok()?.point - image(centre_m)?)
}
