//! How well views predict views they were not calibrated from.
//!
//! The camera of all views is next to that of any part of them, and who is an outlier is known: so each part is adjusted from the whole
//! solution, in a step or two, and the views left out find their poses from those they have in it.

use super::adjust::{Goal, Solution, adjust};
use super::calibration::rms;
use super::observations::{Observation, observations};
use super::roll::residual_px;
use super::shared::{Free, Shared};
use super::{CalibrateError, CalibrateOptions, Calibration, NEEDED_VIEWS, observed};
use crate::board::Board;
use crate::camera::Pose;
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
    let whole = Whole::of(board, views, options, calibration);
    let count = whole.as_ref().map_or(0, |whole| whole.views.len());
    let folds = FOLDS.min(count);
    let mut refused = None;
    let parts: Vec<Result<Vec<HeldOut>, CalibrateError>> = match whole {
        Err(error) => vec![Err(error)],
        Ok(_) if count <= NEEDED_VIEWS => vec![Err(CalibrateError::TooFewViews { found: count })],
        Ok(whole) => (0..folds)
            .into_par_iter()
            .map(|fold| whole.held_out(fold, folds))
            .collect(),
    };
    let mut view_factors = vec![None; calibration.views.len()];
    let (mut squares, mut rings) = (0.0, 0);
    for part in parts {
        match part {
            Ok(part) => {
                for view in part {
                    view_factors[view.at] = Some(view.factor);
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

/// The solution of all views that took part.
struct Whole {
    shared: Shared,
    free: Free,
    views: Vec<One>,
}

/// A view of it: its place among all, where it stands, and its rings that took part, with what their estimator measures.
struct One {
    at: usize,
    pose: Pose,
    rings: Vec<Observation>,
}

/// A view predicted from others.
struct HeldOut {
    /// Its place among all views.
    at: usize,
    /// Sum of its squared whitened residuals over the degrees of freedom.
    factor: f64,
    rms_px: f64,
    rings: usize,
}

impl Whole {
    fn of(
        board: &Board,
        views: &[View],
        options: &CalibrateOptions,
        calibration: &Calibration,
    ) -> Result<Self, CalibrateError> {
        let shared = Shared {
            camera: calibration.camera,
            sheet: calibration.sheet,
            middle_m: board.middle_m(),
        };
        let mut rings = observations(board, views)?;
        let poses: Vec<Option<Pose>> = calibration.views.iter().map(|fit| fit.pose).collect();
        observed::predict(board, &shared, &poses, &mut rings, options.estimator);
        let fits = calibration.views.iter().zip(rings).enumerate();
        let views = fits.filter(|(_, (fit, _))| fit.used());
        let views = views.filter_map(|(at, (fit, rings))| {
            let used = rings.into_iter().zip(&fit.rings_used);
            Some(One {
                at,
                pose: fit.pose?,
                rings: used.filter(|(_, used)| **used).map(|(r, _)| r).collect(),
            })
        });
        Ok(Self {
            shared,
            free: calibration.uncertain.free.clone(),
            views: views.collect(),
        })
    }

    /// The views of one part, predicted from the others.
    fn held_out(&self, fold: usize, folds: usize) -> Result<Vec<HeldOut>, CalibrateError> {
        let inside = |place: usize| place % folds == fold;
        let places = || 0..self.views.len();
        let (poses, rings): (Vec<Pose>, Vec<Vec<Observation>>) = places()
            .filter(|place| !inside(*place))
            .map(|place| (self.views[place].pose, self.views[place].rings.clone()))
            .unzip();
        let measured = 2 * rings.iter().map(Vec::len).sum::<usize>();
        let unknown = self.free.len() + 6 * poses.len();
        if measured <= unknown {
            return Err(CalibrateError::TooFewMeasurements { measured, unknown });
        }
        let start = Solution {
            shared: self.shared,
            poses,
        };
        let none = CalibrateError::NotConverged { iterations: 0 };
        let rest = adjust(start, &rings, &self.free, Goal::Prediction).ok_or(none)?;
        let shared = rest.solution.shared;
        let held = places().filter(|place| inside(*place));
        Ok(held
            .filter_map(|place| self.views[place].predicted(shared))
            .collect())
    }
}

impl One {
    /// What is left of it with the camera of other views, once it stands where that says; `None` where it cannot.
    fn predicted(&self, shared: Shared) -> Option<HeldOut> {
        let start = Solution {
            shared,
            poses: vec![self.pose],
        };
        let degrees = 2.0 * self.rings.len() as f64 - 6.0;
        let rings = std::slice::from_ref(&self.rings);
        let settled = adjust(start, rings, &Free::default(), Goal::Prediction)?;
        let pose = settled.solution.poses.first()?;
        let residuals = self.rings.iter();
        (degrees > 0.0).then(|| HeldOut {
            at: self.at,
            factor: settled.equations.squares() / degrees,
            rms_px: rms(residuals.filter_map(|ring| residual_px(&shared, pose, ring))),
            rings: self.rings.len(),
        })
    }
}
