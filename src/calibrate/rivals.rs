//! Lens models that explain the views as well as the one that was chosen: what they disagree by is not known.
//!
//! Where the board was, all of them say the same, or they would not explain the views; elsewhere each says what its formula says, with a
//! standard deviation that takes the formula for the truth. Nor need focal length and principal point agree where views are few or
//! alike. With d the difference of a rival, V its covariance and C that of the chosen one, the truth is as far from the chosen one as
//!
//! ```text
//!     C + (V - C)+ + d d'
//! ```
//!
//! says if the rival is the right lens, where ()+ keeps what is positive: the mean square about the chosen one, not less than its own (the
//! variance between models of model averaging, Hoeting et al. 1999, with all weight on the rival). Differences in the frame are those of the
//! projection uncertainty: what the one sees at a pixel is carried by the boards to the other.

use super::calibration::Calibration;
use super::conclude;
use super::observability;
use super::observations::observations;
use super::solve::solved;
use super::uncertainty::Range;
use super::{CalibrateError, CalibrateOptions};
use crate::board::Board;
use crate::camera::LensModel;
use crate::session::View;
use nalgebra::{DMatrix, DVector, Matrix2, Point2, Point3, Vector2, Vector3};

/// Numbers that mean the same in every lens model; first in all of them.
const COMMON: usize = 4;
/// Part of the largest that counts as nothing where a covariance is inverted: a tied focal length adds nothing to the other.
const NOTHING: f64 = 1e-12;

/// A calibration whose covariances cover what these other lens models say; `options` are those of its own.
///
/// # Errors
/// [`CalibrateError::LensModel`] where that leaves the camera open.
pub fn with_rivals(
    board: &Board,
    views: &[View],
    options: &CalibrateOptions,
    (mut calibration, models): (Calibration, &[LensModel]),
) -> Result<Calibration, CalibrateError> {
    for model in models {
        let options = CalibrateOptions {
            model: *model,
            ..options.clone()
        };
        let rival = solved(board, views, &options)
            .and_then(|(solved, roll)| conclude::unjudged(solved, roll, &options));
        // one that has no solution any more does not explain the views
        let Ok(rival) = rival else { continue };
        calibration.covariance += beyond(&calibration, &rival);
        calibration.rivals.push(rival);
    }
    if calibration.rivals.is_empty() {
        return Ok(calibration);
    }
    let mut rings = observations(board, views)?;
    for (rings, fit) in rings.iter_mut().zip(&calibration.views) {
        for (ring, used) in rings.iter_mut().zip(&fit.rings_used) {
            ring.share = f64::from(u8::from(fit.used() && *used));
        }
    }
    let determined = observability::determined(&calibration, &rings);
    match (apart(&calibration), determined) {
        (Some((rival, at, apart_px)), told) if told.is_err() || !apart_px.is_finite() => {
            Err(CalibrateError::LensModel {
                chosen: calibration.camera.model(),
                rival,
                at,
                apart_px,
            })
        }
        (_, Err(error)) => Err(error),
        _ => Ok(calibration),
    }
}

/// What a rival adds to the covariance of the parameters. The coefficients of two models mean different things; they follow the
/// numbers that are common to all as the views say.
fn beyond(calibration: &Calibration, rival: &Calibration) -> DMatrix<f64> {
    let count = calibration.names.len();
    let free = (0..COMMON).filter(|at| calibration.std(*at) > 0.0);
    let free: Vec<usize> = free.collect();
    let common = |covariance: &DMatrix<f64>| covariance.select_rows(&free).select_columns(&free);
    let own = common(&calibration.covariance);
    let (ours, theirs) = (calibration.values(), rival.values());
    let apart = DVector::from_iterator(free.len(), free.iter().map(|at| theirs[*at] - ours[*at]));
    let more = positive(common(&rival.covariance) - &own) + &apart * apart.transpose();
    let nothing = NOTHING * own.diagonal().iter().copied().fold(0.0, f64::max);
    let Ok(inverse) = own.pseudo_inverse(nothing) else {
        return DMatrix::zeros(count, count);
    };
    let follow = calibration.covariance.select_columns(&free) * inverse;
    &follow * more * follow.transpose()
}

/// The positive part of a symmetric matrix.
fn positive(matrix: DMatrix<f64>) -> DMatrix<f64> {
    let eigen = matrix.symmetric_eigen();
    let kept = DMatrix::from_diagonal(&eigen.eigenvalues.map(|value| value.max(0.0)));
    &eigen.eigenvectors * kept * eigen.eigenvectors.transpose()
}

/// What a rival adds to the projection covariance `own` of a calibration at a pixel, px^2.
pub(super) fn projection_beyond(
    calibration: &Calibration,
    rival: &Calibration,
    (pixel, range): (&Point2<f64>, Range),
    own: &Matrix2<f64>,
) -> Matrix2<f64> {
    let Some(apart) = offset(calibration, rival, pixel, range) else {
        // only one of them sees anything there: it may be anywhere
        let camera = &calibration.camera;
        let anywhere = f64::from(camera.width).hypot(f64::from(camera.height));
        return Matrix2::from_diagonal_element(anywhere * anywhere);
    };
    let theirs = rival.own_projection_covariance(&(pixel + apart), range);
    let eigen = (theirs.unwrap_or(*own) - own).symmetric_eigen();
    let kept = Matrix2::from_diagonal(&eigen.eigenvalues.map(|value| value.max(0.0)));
    eigen.eigenvectors * kept * eigen.eigenvectors.transpose() + apart * apart.transpose()
}

/// Where the rival sees what the calibration sees at a pixel, carried by the boards, less that pixel; `None` where one of them does not see it.
fn offset(
    calibration: &Calibration,
    rival: &Calibration,
    pixel: &Point2<f64>,
    range: Range,
) -> Option<Vector2<f64>> {
    let ray = calibration.camera.ray(pixel)?;
    let (mut sum, mut count) = (Vector3::zeros(), 0.0);
    for (ours, theirs) in calibration.views.iter().zip(&rival.views) {
        let (Some(from), Some(to)) = (ours.pose, theirs.pose) else {
            continue;
        };
        if ours.used() && theirs.used() {
            let (point, shifts) = match range {
                Range::Infinity => (ray, 0.0),
                Range::At(distance_m) => (ray * distance_m, 1.0),
            };
            let on_board = from.rotation.inverse() * (point - from.translation_m * shifts);
            sum += to.rotation * on_board + to.translation_m * shifts;
            count += 1.0;
        }
    }
    let seen = rival.camera.project(&Point3::from(sum / count))?;
    // beyond a fold a formula goes on, and means nothing there
    rival.camera.ray(&seen)?;
    Some(seen - pixel)
}

/// The rival that differs most in the frame, where, and by how much, px: not finite where it has rays and the calibration has none.
fn apart(calibration: &Calibration) -> Option<(LensModel, Point2<f64>, f64)> {
    let camera = &calibration.camera;
    let cells = (0..observability::CELLS.0 * observability::CELLS.1)
        .map(|cell| observability::middle(camera, cell));
    let all = cells.flat_map(|at| calibration.rivals.iter().map(move |rival| (at, rival)));
    let differences = all.filter_map(|(at, rival)| {
        let sees = (camera.ray(&at).is_some(), rival.camera.ray(&at).is_some());
        let px = match (sees, offset(calibration, rival, &at, Range::Infinity)) {
            ((false, false), _) => return None,
            (_, Some(apart)) => apart.norm(),
            (_, None) => f64::INFINITY,
        };
        Some((rival.camera.model(), at, px))
    });
    differences.fold(None, |most, next| match most {
        Some(most) if next.2.total_cmp(&most.2).is_le() => Some(most),
        _ => Some(next),
    })
}
