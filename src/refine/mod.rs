//! The second pass: with the camera and the poses known, every ring's shape is known, and its centre can be found again, better.
//!
//! The first pass takes a ring's perspective from a smooth map through the centres of its own view; the camera knows it from all
//! views. Where a view has kept a ring's pixels they are fitted again with the camera's shape; where it has kept the fit
//! alone, the centre moves as the fit's covariance says. What the lens's bends have moved is moved back. Calibrate, refine, calibrate: mostly
//! two passes are enough. Where the second camera is another than the first by more than noise, its shapes are others, too,
//! and what is wrong of a camera is a tenth as wrong in the next: so they are renewed until it stays.

use crate::board::Board;
use crate::calibrate::{
    CalibrateError, CalibrateOptions, Calibration, ModelChoice, ModelScore, calibrate,
    choose_model, with_rivals,
};
use crate::camera::Pose;
use crate::centre::photometric::{KnownRing, refit, shape_under};
use crate::session::View;
use nalgebra::Vector2;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Times that the centres are found again.
const PASSES: usize = 4;
/// The camera stays when none of its numbers moves by this many of its standard deviations: what is left to move is a tenth of that.
const SETTLED: f64 = 0.7;

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
    let mut calibration = first;
    let mut refined = Vec::new();
    for _ in 0..PASSES {
        refined = refine(board, views, &calibration);
        let next = calibrate(board, &refined, options)?;
        let last = std::mem::replace(&mut calibration, next);
        if moved(&last, &calibration) < SETTLED {
            break;
        }
    }
    Ok((calibration, refined))
}

/// A calibration with a lens model that is given or chosen.
#[derive(Debug, Clone, PartialEq)]
pub struct Chosen {
    /// The calibration.
    pub calibration: Calibration,
    /// The views that it comes from, with their centres found again.
    pub views: Vec<View>,
    /// What became of each lens model, where it was to be chosen.
    pub scores: Vec<ModelScore>,
}

/// [`calibrate_refined`] with a lens model that may have to be chosen first; then what other models that explain the views as well disagree
/// by is part of the uncertainty.
///
/// # Errors
/// [`CalibrateError`], where the views do not tell the lens model either.
pub fn calibrate_chosen(
    board: &Board,
    views: &[View],
    (options, model): (&CalibrateOptions, ModelChoice),
) -> Result<Chosen, CalibrateError> {
    let (model, scores) = match model {
        ModelChoice::Fixed(model) => (model, Vec::new()),
        ModelChoice::Auto => choose_model(board, views, options)?,
    };
    let options = CalibrateOptions {
        model,
        ..options.clone()
    };
    let (calibration, views) = calibrate_refined(board, views, &options)?;
    let rivals = scores.iter().filter(|score| score.rival);
    let rivals: Vec<_> = rivals.map(|score| score.model).collect();
    Ok(Chosen {
        calibration: with_rivals(board, &views, &options, (calibration, &rivals))?,
        views,
        scores,
    })
}

/// By how many of its standard deviations the number moved that moved most.
fn moved(last: &Calibration, next: &Calibration) -> f64 {
    let stds = next.stds();
    let moves = last.values().into_iter().zip(next.values()).zip(stds);
    let moves = moves.filter(|(_, std)| *std > 0.0);
    moves.fold(0.0, |most, ((last, next), std)| {
        most.max((next - last).abs() / std)
    })
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
    let image = |place: usize, d: Vector2<f64>| {
        let ring = &view.rings[place];
        let [x, y] = board.centre_m(ring.row, ring.column);
        let radius = board.outer_radius_m();
        let on_board = [x + d.x * radius, y + d.y * radius];
        let on_sheet = calibration.sheet.place_m(on_board, board.middle_m());
        let point = pose.rotation * on_sheet + pose.translation_m;
        calibration.camera.project(&point)
    };
    let (places, rings): (Vec<usize>, Vec<KnownRing>) = view
        .rings
        .iter()
        .enumerate()
        .filter_map(|(place, ring)| {
            let shape = shape_under(|d| image(place, d))?;
            let kept = ring.kept.as_deref()?;
            Some((place, KnownRing { kept, shape }))
        })
        .unzip();
    let ratio = board.radius_ratio();
    let found = refit(&rings, ratio, |i, d| image(places[i], d));
    let mut refined = view.clone();
    let mut again = places.into_iter().zip(found).collect::<BTreeMap<_, _>>();
    for (place, ring) in refined.rings.iter_mut().enumerate() {
        if let Some((point, covariance)) = again.remove(&place).flatten() {
            ring.centre.point = point;
            ring.centre.covariance = Some(covariance);
        }
    }
    refined
}
