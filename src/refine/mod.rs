//! The second pass: with the camera and the poses known, every ring's shape is known, and its centre can be found again, better.
//!
//! The first pass takes a ring's perspective from a smooth map through the centres of its own view; the camera knows it from all
//! views. Where a view has kept a ring's pixels they are fitted again with the camera's shape; where it has kept the fit
//! alone, the centre moves as the fit's covariance says. Calibrate, refine, calibrate: two passes are enough.

use crate::board::Board;
use crate::calibrate::{CalibrateError, CalibrateOptions, Calibration, calibrate};
use crate::camera::Pose;
use crate::centre::photometric::{KnownRing, Shape, refit, shape_under};
use crate::session::View;
use nalgebra::Point2;
use rayon::prelude::*;

/// Calibrates, finds the centres again with that camera, and calibrates from those. Where no ring was measured photometrically there
/// is nothing to find again, and the first calibration is the result. Returns the views it comes from, too.
///
/// # Errors
/// [`CalibrateError`] of either calibration.
pub fn calibrate_refined(
    board: &Board,
    views: &[View],
    options: &CalibrateOptions,
) -> Result<(Calibration, Vec<View>), CalibrateError> {
    let first = calibrate(board, views, options)?;
    if views
        .iter()
        .flat_map(|v| &v.rings)
        .all(|r| r.kept.is_none())
    {
        return Ok((first, views.to_vec()));
    }
    let refined = refine(board, views, &first);
    let second = calibrate(board, &refined, options)?;
    Ok((second, refined))
}

/// The views with their centres found again. Rings that were not measured photometrically stay as they are, and so do those that
/// cannot be found again.
pub fn refine(board: &Board, views: &[View], calibration: &Calibration) -> Vec<View> {
    views
        .par_iter()
        .zip(&calibration.views)
        .map(|(view, fit)| match &fit.pose {
            Some(pose) if fit.used() => refine_view(board, view, calibration, pose),
            _ => view.clone(),
        })
        .collect()
}

fn refine_view(board: &Board, view: &View, calibration: &Calibration, pose: &Pose) -> View {
    let (places, rings): (Vec<usize>, Vec<KnownRing>) = view
        .rings
        .iter()
        .enumerate()
        .filter_map(|(place, ring)| {
            let shape = ring_shape(board, (ring.row, ring.column), calibration, pose)?;
            let kept = ring.kept.as_deref()?;
            Some((place, KnownRing { kept, shape }))
        })
        .unzip();
    let mut refined = view.clone();
    for (place, again) in places.into_iter().zip(refit(&rings, board.radius_ratio())) {
        if let Some((point, covariance)) = again {
            let centre = &mut refined.rings[place].centre;
            centre.point = point;
            centre.covariance = Some(covariance);
        }
    }
    refined
}

/// The image of a ring of the board, px; `None` where the camera does not see it.
fn ring_shape(
    board: &Board,
    (row, column): (u16, u16),
    calibration: &Calibration,
    pose: &Pose,
) -> Option<Shape> {
    let [x, y] = board.centre_m(row, column);
    let radius = board.outer_radius_m();
    shape_under(|d| {
        let place = Point2::new(x + d.x * radius, y + d.y * radius);
        let on_sheet = calibration.sheet.place_m(place.into(), board.middle_m());
        let point = pose.rotation * on_sheet + pose.translation_m;
        calibration.camera.project(&point)
    })
}
