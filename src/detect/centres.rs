//! The projected centres of the rings that were found, by the estimator that was asked for.

use super::detection::Ring;
use super::grid::Placed;
use crate::board::Board;
use crate::camera::homography::fit_homography;
use crate::centre::photometric::{
    PsfChoice, RingFitted, RingStart, Workspace, measure_ring, share_perspective,
};
use crate::centre::{Centre, CentreEstimator, Cross, Estimator, RingEllipses};
use crate::frame::{Frame, Linear};
use nalgebra::{Matrix3, Point2};
use rayon::prelude::*;

/// The rings of a board with their centres; `sign` is 1 for dark rings, -1 for light ones. A ring whose ellipses have no
/// projected centre is left out.
pub(super) fn centres(
    frame: &Frame,
    board: &Board,
    placed: &[Placed],
    estimator: Estimator,
    sign: f64,
) -> Vec<Ring> {
    match estimator.construction() {
        Some(construction) => placed
            .iter()
            .filter_map(|ring| constructed(ring, construction.as_ref()))
            .collect(),
        None => photometric(frame, board, placed, sign),
    }
}

/// `None` where the ellipses have no projected centre, or the construction puts it outside the inner circle: blur has
/// then spoilt their shapes beyond what it bears.
fn constructed(placed: &Placed, construction: &dyn CentreEstimator) -> Option<Ring> {
    let centre = construction.estimate(&placed.ellipses).ok()?;
    placed
        .ellipses
        .inner
        .contains(&centre.point)
        .then_some(Ring {
            row: placed.row,
            column: placed.column,
            centre,
            ellipses: placed.ellipses,
            blur_sigma_px: placed.blur_sigma_px,
        })
}

/// Fits every ring's grey values, then shares the perspective among them. A ring that has no fit gets the paper's centre,
/// without a covariance.
fn photometric(frame: &Frame, board: &Board, placed: &[Placed], sign: f64) -> Vec<Ring> {
    let linear = Linear::new(1.0, false);
    let fits: Vec<Option<RingFitted>> = placed
        .par_iter()
        .map_init(Workspace::default, |room, ring| {
            let start = RingStart {
                outline: ring.ellipses.outer,
                sigma_px: ring.blur_sigma_px,
                ratio: board.radius_ratio(),
                sign,
                psf: PsfChoice::Auto,
                linear: &linear,
            };
            measure_ring(frame, &start, room).ok()
        })
        .collect();
    let fitted: Vec<RingFitted> = fits.iter().flatten().copied().collect();
    let mut shared = shared_centres(board, placed, &fits, &fitted).into_iter();
    placed
        .iter()
        .zip(&fits)
        .filter_map(|(ring, fit)| match fit {
            Some(fit) => {
                let shape = fit.model.shape;
                let ellipses = RingEllipses {
                    inner: shape.ellipse(board.radius_ratio())?,
                    outer: shape.ellipse(1.0)?,
                };
                Some(Ring {
                    row: ring.row,
                    column: ring.column,
                    centre: shared.next()?,
                    ellipses,
                    blur_sigma_px: fit.model.blur.sigma_px(),
                })
            }
            None => constructed(ring, &Cross::default()),
        })
        .collect()
}

/// The centres of the fitted rings, in their order.
fn shared_centres(
    board: &Board,
    placed: &[Placed],
    fits: &[Option<RingFitted>],
    fitted: &[RingFitted],
) -> Vec<Centre> {
    let pairs: Vec<_> = placed
        .iter()
        .zip(fits)
        .filter_map(|(ring, fit)| {
            let plane = Point2::from(board.centre_m(ring.row, ring.column));
            Some((plane, (*fit)?.model.shape.centre))
        })
        .collect();
    let alone = |ring: &RingFitted| (ring.model.shape.centre, ring.centre_covariance());
    let centres = match fit_homography(&pairs) {
        Some(homography) => share_perspective(fitted, &homography),
        None => fitted.iter().map(alone).collect(),
    };
    centres
        .into_iter()
        .map(|(point, covariance)| Centre {
            point,
            covariance: Some(covariance),
        })
        .collect()
}

/// Board plane (m) to frame (px) through the centres; `None` where they determine none.
pub(super) fn board_homography(board: &Board, rings: &[Ring]) -> Option<Matrix3<f64>> {
    let pairs: Vec<_> = rings
        .iter()
        .map(|r| {
            (
                Point2::from(board.centre_m(r.row, r.column)),
                r.centre.point,
            )
        })
        .collect();
    fit_homography(&pairs)
}
