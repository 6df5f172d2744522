//! How well views predict views they were not calibrated from.

use super::resect::{Known, resect};
use super::{CalibrateError, CalibrateOptions, Calibration, NEEDED_VIEWS, calibrate};
use crate::board::Board;
use crate::session::View;
use rayon::prelude::*;

/// Parts that the views are dealt into.
pub const FOLDS: usize = 5;

/// Residuals of views that were left out while the camera was estimated.
#[derive(Debug, Clone, PartialEq)]
pub struct CrossValidation {
    /// Parts that the views were dealt into: each was predicted from the others.
    pub folds: usize,
    /// Root mean square distance between measured and predicted centres over the views left out, px; to be compared with the
    /// calibration's `rms_px`.
    pub rms_px: f64,
    /// Sum of the squared whitened residuals over the degrees of freedom, for every view; `None` for one without a pose or that
    /// the calibration of all views leaves out.
    pub view_factors: Vec<Option<f64>>,
}

/// Cross-validates a calibration of these views: every view's pose is found with the camera of the parts it is not in. Views and
/// rings that the calibration left out do not count.
///
/// # Errors
/// [`CalibrateError`] where a part of the views does not give a camera: there are too few.
pub fn cross_validate(
    board: &Board,
    views: &[View],
    options: &CalibrateOptions,
    calibration: &Calibration,
) -> Result<CrossValidation, CalibrateError> {
    let (validated, refused) = validate(board, views, options, calibration);
    refused.map_or(Ok(validated), Err)
}

/// Cross-validates as far as the parts of the views give cameras, and says why the first did not that gives none.
pub(super) fn validate(
    board: &Board,
    views: &[View],
    options: &CalibrateOptions,
    calibration: &Calibration,
) -> (CrossValidation, Option<CalibrateError>) {
    let used: Vec<usize> = (0..views.len())
        .filter(|at| calibration.views[*at].used())
        .collect();
    let views: Vec<View> = used
        .iter()
        .map(|at| without_outliers(&views[*at], &calibration.views[*at].rings_used))
        .collect();
    let folds = FOLDS.min(views.len());
    // the camera of all views is a good start for each part of them
    let options = CalibrateOptions {
        guess: options.guess.or(Some(calibration.camera)),
        ..options.clone()
    };
    let mut refused = None;
    let parts: Vec<Result<Vec<HeldOut>, CalibrateError>> = if views.len() <= NEEDED_VIEWS {
        refused = Some(CalibrateError::TooFewViews { found: views.len() });
        Vec::new()
    } else {
        (0..folds)
            .into_par_iter()
            .map(|fold| held_out(board, &views, &options, (fold, folds)))
            .collect()
    };
    let mut view_factors = vec![None; calibration.views.len()];
    let (mut squares, mut rings) = (0.0, 0);
    for part in parts {
        match part {
            Ok(part) => {
                for view in part {
                    view_factors[used[view.at]] = Some(view.factor);
                    squares += view.rms_px * view.rms_px * view.rings as f64;
                    rings += view.rings;
                }
            }
            Err(error) => refused = refused.or(Some(error)),
        }
    }
    let validated = CrossValidation {
        folds,
        rms_px: (squares / rings.max(1) as f64).sqrt(),
        view_factors,
    };
    (validated, refused)
}

/// A view predicted from others.
struct HeldOut {
    /// Its place among the views that are validated.
    at: usize,
    /// Sum of its squared whitened residuals over the degrees of freedom.
    factor: f64,
    rms_px: f64,
    rings: usize,
}

/// The views of one part, predicted from the others.
fn held_out(
    board: &Board,
    views: &[View],
    options: &CalibrateOptions,
    (fold, folds): (usize, usize),
) -> Result<Vec<HeldOut>, CalibrateError> {
    let inside = |at: usize| at % folds == fold;
    let rest: Vec<View> = (0..views.len())
        .filter(|at| !inside(*at))
        .map(|at| views[at].clone())
        .collect();
    let camera = calibrate(board, &rest, options)?;
    let known = Known {
        camera: camera.camera,
        sheet: camera.sheet,
        estimator: options.estimator,
    };
    let places: Vec<usize> = (0..views.len()).filter(|at| inside(*at)).collect();
    let left: Vec<View> = places.iter().map(|at| views[*at].clone()).collect();
    let resections = resect(board, &left, &known)?;
    let told = places.into_iter().zip(resections);
    Ok(told
        .filter(|(_, r)| r.fit.used() && r.degrees > 0.0)
        .map(|(at, r)| HeldOut {
            at,
            factor: r.cost / r.degrees,
            rms_px: r.fit.rms_px,
            rings: r.fit.residuals.len(),
        })
        .collect())
}

fn without_outliers(view: &View, used: &[bool]) -> View {
    let rings = view.rings.iter().zip(used);
    View {
        rings: rings
            .filter(|(_, used)| **used)
            .map(|(ring, _)| ring.clone())
            .collect(),
        ..view.clone()
    }
}
