//! The pose of one view with a camera that is known: what cross-validation and checks are made of.

use super::adjust::{Goal, Solution, adjust};
use super::calibration::{self, ViewFit};
use super::observations::{Observation, observations};
use super::roll::{LeftOut, residual_px};
use super::shared::{Free, Shared, SheetShape};
use super::{CalibrateError, NEEDED_RINGS, guess, observed, start_homography};
use crate::board::Board;
use crate::camera::{Camera, Pose};
use crate::centre::Estimator;
use crate::session::View;
use rayon::prelude::*;

/// A camera and a sheet that views are held against.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Known {
    /// The camera.
    pub camera: Camera,
    /// The sheet.
    pub sheet: SheetShape,
    /// What measured the centres.
    pub estimator: Estimator,
}

/// A view held against a camera.
#[derive(Debug, Clone, PartialEq)]
pub struct Resection {
    /// Pose and residuals.
    pub fit: ViewFit,
    /// Sum of the squared whitened residuals.
    pub cost: f64,
    /// Numbers measured, less six for the pose.
    pub degrees: f64,
}

/// The pose of each view by the camera alone, and what is left over; no ring is left out.
///
/// # Errors
/// [`CalibrateError`] for views that are not of this board or not all of one size.
pub fn resect(
    board: &Board,
    views: &[View],
    known: &Known,
) -> Result<Vec<Resection>, CalibrateError> {
    let rings = observations(board, views)?;
    let shared = Shared {
        camera: known.camera,
        sheet: known.sheet,
        middle_m: board.middle_m(),
    };
    Ok(rings
        .into_par_iter()
        .map(|rings| resect_one(board, &shared, rings, known.estimator))
        .collect())
}

fn resect_one(
    board: &Board,
    shared: &Shared,
    mut rings: Vec<Observation>,
    estimator: Estimator,
) -> Resection {
    let none = |left_out| Resection {
        fit: ViewFit {
            pose: None,
            residuals: Vec::new(),
            rings_used: Vec::new(),
            rms_px: 0.0,
            left_out: Some(left_out),
        },
        cost: 0.0,
        degrees: 0.0,
    };
    let found = rings.len();
    if found < NEEDED_RINGS {
        return none(LeftOut::TooFewRings { found });
    }
    if start_homography::mark(&mut rings).is_none() {
        return none(LeftOut::Degenerate);
    }
    let Some(start) = guess::pose(&shared.camera, &rings) else {
        return none(LeftOut::NoPose);
    };
    for ring in &mut rings {
        ring.share = 1.0;
    }
    let Some((pose, cost)) = settle(board, shared, &mut rings, (start, estimator)) else {
        return none(LeftOut::NoPose);
    };
    let residuals: Vec<_> = rings
        .iter()
        .map(|ring| residual_px(shared, &pose, ring))
        .collect();
    Resection {
        fit: ViewFit {
            pose: Some(pose),
            rms_px: calibration::rms(residuals.iter().copied().flatten()),
            rings_used: vec![true; residuals.len()],
            residuals,
            left_out: None,
        },
        cost,
        degrees: 2.0 * rings.len() as f64 - 6.0,
    }
}

/// Where the board of a view stands, by the rings that have a share, and the sum of their squared whitened residuals.
pub(super) fn settle(
    board: &Board,
    shared: &Shared,
    rings: &mut Vec<Observation>,
    (start, estimator): (Pose, Estimator),
) -> Option<(Pose, f64)> {
    let mut pose = start;
    let mut cost = 0.0;
    for _ in 0..2 {
        let mut one = [std::mem::take(rings)];
        observed::predict(board, shared, &[Some(pose)], &mut one, estimator);
        let solution = Solution {
            shared: *shared,
            poses: vec![pose],
        };
        let adjusted = adjust(solution, &one, &Free::default(), Goal::Exact);
        let [again] = one;
        *rings = again;
        let adjusted = adjusted?;
        pose = *adjusted.solution.poses.first()?;
        cost = adjusted.equations.cost();
        if adjusted.iterations <= 1 {
            break;
        }
    }
    Some((pose, cost))
}
