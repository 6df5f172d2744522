//! The projected centres of the rings that were found, by the estimator that was asked for.

use super::detection::Ring;
use super::grid::Placed;
use crate::board::Board;
use crate::camera::homography::fit_homography;
use crate::centre::photometric::{BoardPlace, BoardStart, PsfChoice, measure_board};
use crate::centre::{Centre, CentreEstimator, Cross, Estimator, RingEllipses};
use crate::frame::{Frame, Linear};
use nalgebra::{Matrix3, Point2};

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

/// Measures every ring by its grey values. A ring that cannot be measured so gets the paper's centre, without a covariance.
fn photometric(frame: &Frame, board: &Board, placed: &[Placed], sign: f64) -> Vec<Ring> {
    let linear = Linear::new(1.0, false);
    let places: Vec<BoardPlace> = placed
        .iter()
        .map(|ring| BoardPlace {
            plane_m: Point2::from(board.centre_m(ring.row, ring.column)),
            outline: ring.ellipses.outer,
            sigma_px: ring.blur_sigma_px,
        })
        .collect();
    let start = BoardStart {
        places: &places,
        ratio: board.radius_ratio(),
        sign,
        psf: PsfChoice::Auto,
        linear: &linear,
    };
    let measured = measure_board(frame, &start);
    placed
        .iter()
        .zip(measured.rings)
        .filter_map(|(ring, measured)| match measured {
            Ok(measured) => {
                let shape = measured.fitted.model.shape;
                let ellipses = RingEllipses {
                    inner: shape.ellipse(board.radius_ratio())?,
                    outer: shape.ellipse(1.0)?,
                };
                Some(Ring {
                    row: ring.row,
                    column: ring.column,
                    centre: Centre {
                        point: measured.centre,
                        covariance: Some(measured.covariance),
                    },
                    ellipses,
                    blur_sigma_px: measured.fitted.model.blur.sigma_px(),
                })
            }
            Err(_) => constructed(ring, &Cross::default()),
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
