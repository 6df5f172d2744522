//! How well views predict views they were not calibrated from, and which lens model does it best.

use super::resect::{Known, resect};
use super::{CalibrateError, CalibrateOptions, Calibration, NEEDED_VIEWS, calibrate};
use crate::board::Board;
use crate::camera::LensModel;
use crate::session::View;
use rayon::prelude::*;

/// Parts that the views are dealt into.
pub const FOLDS: usize = 5;

/// Standard deviations by which a lens model with more coefficients has to be better to be chosen.
const CLEARLY: f64 = 2.0;
/// Part of the error that such a lens model has to take away, on the typical view: what is less is worth no coefficient and no other kind
/// of lens.
const NOTICEABLY: f64 = 0.02;

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
    let used: Vec<usize> = (0..views.len())
        .filter(|at| calibration.views[*at].used())
        .collect();
    let views: Vec<View> = used
        .iter()
        .map(|at| without_outliers(&views[*at], &calibration.views[*at].rings_used))
        .collect();
    let folds = FOLDS.min(views.len());
    if views.len() <= NEEDED_VIEWS {
        return Err(CalibrateError::TooFewViews { found: views.len() });
    }
    // the camera of all views is a good start for each part of them
    let options = CalibrateOptions {
        guess: options.guess.or(Some(calibration.camera)),
        ..options.clone()
    };
    let parts: Vec<Vec<HeldOut>> = (0..folds)
        .into_par_iter()
        .map(|fold| held_out(board, &views, &options, (fold, folds)))
        .collect::<Result<_, _>>()?;
    let mut view_factors = vec![None; calibration.views.len()];
    let (mut squares, mut rings) = (0.0, 0);
    for view in parts.into_iter().flatten() {
        view_factors[used[view.at]] = Some(view.factor);
        squares += view.rms_px * view.rms_px * view.rings as f64;
        rings += view.rings;
    }
    Ok(CrossValidation {
        folds,
        rms_px: (squares / rings.max(1) as f64).sqrt(),
        view_factors,
    })
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

/// What became of a lens model in [`choose_model`].
#[derive(Debug, Clone, PartialEq)]
pub struct ModelScore {
    /// The lens model.
    pub model: LensModel,
    /// Root mean square of its residuals on views left out, px, or why it has none.
    pub rms_px: Result<f64, CalibrateError>,
}

/// The lens model that predicts left-out views best, and what became of each. `plumb_bob` is the one to beat: another is chosen only
/// where its error on a typical view is smaller by 2 % and by two standard deviations of the difference over the views.
///
/// # Errors
/// That of the first lens model, where none gives a calibration.
pub fn choose_model(
    board: &Board,
    views: &[View],
    options: &CalibrateOptions,
) -> Result<(LensModel, Vec<ModelScore>), CalibrateError> {
    let candidates = [
        LensModel::PlumbBob,
        LensModel::Equidistant,
        LensModel::RationalPolynomial,
    ];
    let mut scores = Vec::new();
    let mut best: Option<(LensModel, CrossValidation)> = None;
    let mut refused = None;
    for model in candidates {
        let options = CalibrateOptions {
            model,
            ..options.clone()
        };
        let validated = calibrate(board, views, &options)
            .and_then(|calibration| cross_validate(board, views, &options, &calibration));
        scores.push(ModelScore {
            model,
            rms_px: validated.as_ref().map(|v| v.rms_px).map_err(Clone::clone),
        });
        match validated {
            Ok(validated) => {
                let better = best
                    .as_ref()
                    .is_none_or(|b| clearly_better(&validated, &b.1));
                if better {
                    best = Some((model, validated));
                }
            }
            Err(error) => refused = refused.or(Some(error)),
        }
    }
    match (best, refused) {
        (Some((model, _)), _) => Ok((model, scores)),
        (None, Some(error)) => Err(error),
        (None, None) => Err(CalibrateError::TooFewViews { found: views.len() }),
    }
}

/// Whether `a` predicts the views better than `b` beyond chance, or predicts more of them.
fn clearly_better(a: &CrossValidation, b: &CrossValidation) -> bool {
    let count = |v: &CrossValidation| v.view_factors.iter().flatten().count();
    if count(a) != count(b) {
        return count(a) > count(b);
    }
    let pairs = a.view_factors.iter().zip(&b.view_factors);
    // in logarithms, so that one bad view decides nothing
    let gains: Vec<f64> = pairs
        .filter_map(|(a, b)| Some(((*b)? / (*a)?).ln()))
        .filter(|gain| gain.is_finite())
        .collect();
    let n = gains.len() as f64;
    let mean = gains.iter().sum::<f64>() / n;
    let variance = gains.iter().map(|g| (g - mean).powi(2)).sum::<f64>() / (n - 1.0);
    // of squares
    let noticeable = -2.0 * (1.0 - NOTICEABLY).ln();
    mean > noticeable.max(CLEARLY * (variance / n).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(view_factors: Vec<Option<f64>>) -> CrossValidation {
        CrossValidation {
            folds: FOLDS,
            rms_px: 0.0054,
            view_factors,
        }
    }

    #[test]
    fn a_gain_that_nobody_notices_is_a_tie_however_certain_it_is() {
        let scaled = |by: f64| of((0..10).map(|i| Some(by * (1.0 + f64::from(i)))).collect());
        let one = scaled(1.0);
        assert!(!clearly_better(&one, &one));
        assert!(!clearly_better(&scaled(0.97), &one));
        assert!(clearly_better(&scaled(0.95), &one));
        let scattered =
            |i: u32| Some((1.0 + f64::from(i)) * if i.is_multiple_of(2) { 0.5 } else { 1.7 });
        assert!(!clearly_better(&of((0..10).map(scattered).collect()), &one));
    }
}
