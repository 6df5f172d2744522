//! The projected centres of the rings that were found, by the estimator that was asked for.

use super::detection::{FellBack, Indices, Measured, Ring};
use super::detector::DetectOptions;
use super::grid::Placed;
use super::odd_ones::leave_out_odd_ones;
use super::ring_fit::{Care, measure};
use crate::board::Board;
use crate::camera::homography::{apply, fit_homography};
use crate::centre::photometric::{
    BoardPlace, BoardStart, ResponseGamma, RingError, RingFitted, RingMeasured, estimate_gamma,
    measure_board,
};
use crate::centre::{Centre, CentreEstimator, Ellipse, Estimator, RingEllipses};
use crate::frame::{Frame, Linear, Pixels};
use nalgebra::{Matrix3, Point2};
use std::sync::Arc;

/// A ring so far from its neighbours' prediction, in minor semi-axes, is something else.
const FARTHEST: f64 = 0.6;
/// Edges say where a ring is up to this blur sigma over its width.
const MOST_BLURRED: f64 = 0.25;

/// The rings of a board with their centres, and what the photometric estimator says of the frame; `sign` is 1 for dark rings, -1
/// for light ones. A ring whose ellipses have no projected centre is left out. Rings that showed no edges are looked for, too: on the
/// whole board where the rows and columns placed are numbered as the board's, else as far as these reach.
pub(super) fn centres(
    frame: &Frame,
    board: &Board,
    (placed, indices): (&[Placed], Indices),
    options: &DetectOptions,
    sign: f64,
) -> (Vec<Ring>, Option<Measured>) {
    match options.estimator.construction() {
        Some(construction) => {
            let rings = placed
                .iter()
                .filter(|ring| !board.is_mark(ring.row, ring.column))
                .filter_map(|ring| constructed(ring, construction.as_ref()));
            (rings.collect(), None)
        }
        None => {
            let (rings, measured) = photometric(frame, board, (placed, indices), options, sign);
            (rings, Some(measured))
        }
    }
}

/// `None` where the ellipses have no projected centre, or the construction puts it outside the inner circle: blur has
/// then spoilt their shapes beyond what it bears.
pub(super) fn constructed(placed: &Placed, construction: &dyn CentreEstimator) -> Option<Ring> {
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
            kept: None,
        })
}

/// A ring as a fit of its grey values draws it; `None` where that is no ellipse.
pub(super) fn drawn(
    (row, column): (u16, u16),
    centre: Centre,
    fitted: &RingFitted,
    ratio: f64,
) -> Option<Ring> {
    let shape = fitted.model.shape;
    Some(Ring {
        row,
        column,
        centre,
        ellipses: RingEllipses {
            inner: shape.ellipse(ratio)?,
            outer: shape.ellipse(1.0)?,
        },
        blur_sigma_px: fitted.model.blur.sigma_px(),
        kept: None,
    })
}

/// Measures every ring by its grey values, those too that showed no edges but must be there. A ring that was seen and cannot be
/// measured so gets the paper's centre, without a covariance.
fn photometric(
    frame: &Frame,
    board: &Board,
    (placed, indices): (&[Placed], Indices),
    options: &DetectOptions,
    sign: f64,
) -> (Vec<Ring>, Measured) {
    let mut at: Vec<(u16, u16)> = placed.iter().map(|ring| (ring.row, ring.column)).collect();
    let mut places: Vec<BoardPlace> = placed
        .iter()
        .map(|ring| BoardPlace {
            plane_m: Point2::from(board.centre_m(ring.row, ring.column)),
            outline: ring.ellipses.outer,
            sigma_px: ring.blur_sigma_px,
        })
        .collect();
    for (label, place) in unseen(frame, board, placed, indices) {
        at.push(label);
        places.push(place);
    }
    let plain = Linear::new(1.0, false);
    let start = BoardStart {
        places: &places,
        outer_radius_m: board.outer_radius_m(),
        ratio: board.radius_ratio(),
        sign,
        psf: options.psf,
        camera: options.camera,
        linear: &plain,
    };
    let linear = response(frame, options, &start);
    let start = BoardStart {
        linear: &linear,
        ..start
    };
    let measured = measure_board(frame, &start);
    let mut report = Measured {
        psf: measured.psf,
        response_gamma: linear.gamma(),
        fell_back: Vec::new(),
        out_of_round: measured.out_of_round,
    };
    let mut rings = Vec::with_capacity(places.len());
    for (i, result) in measured.rings.into_iter().enumerate() {
        if board.is_mark(at[i].0, at[i].1) {
            // it tells how the board is turned and shades its neighbours; without an inner circle it is no ring to measure
            continue;
        }
        match result {
            Ok(ring) if is_expected(&places[i], &ring) => {
                rings.extend(of_measured(at[i], ring, board.radius_ratio()));
            }
            Ok(_) | Err(RingError::Covered { .. }) => {}
            Err(reason) => {
                rings.extend(
                    placed.get(i).and_then(|ring| {
                        fall_back((frame, board, sign), ring, reason, &mut report)
                    }),
                );
            }
        }
    }
    rings.sort_by_key(|ring| (ring.row, ring.column));
    leave_out_odd_ones(&mut rings);
    (rings, report)
}

/// Light from this frame's grey values.
pub(super) fn response(frame: &Frame, options: &DetectOptions, start: &BoardStart) -> Linear {
    let gamma = match options.response_gamma {
        ResponseGamma::Fixed(gamma) => gamma,
        ResponseGamma::Auto => estimate_gamma(frame, start),
    };
    Linear::new(gamma, matches!(frame.pixels, Pixels::U16(_)))
}

fn of_measured(at: (u16, u16), ring: RingMeasured, ratio: f64) -> Option<Ring> {
    let centre = Centre {
        point: ring.centre,
        covariance: Some(ring.covariance),
    };
    let drawn = drawn(at, centre, &ring.kept.fitted, ratio)?;
    Some(Ring {
        kept: Some(Arc::new(ring.kept)),
        ..drawn
    })
}

/// The centre from edges that are measured with all care now; `None` where they do not show a ring either.
fn fall_back(
    (frame, board, sign): (&Frame, &Board, f64),
    ring: &Placed,
    reason: RingError,
    report: &mut Measured,
) -> Option<Ring> {
    let construction = Estimator::FALLBACK.construction()?;
    // edges of a ring that is filled with blur are not where its circles are, and nobody knows by how much
    if ring.blur_sigma_px > MOST_BLURRED * ring.ellipses.width() {
        return None;
    }
    let careful = measure(
        frame,
        &ring.ellipses,
        sign,
        board.radius_ratio(),
        Care::Edges,
    )?;
    let ring = Placed {
        ellipses: RingEllipses {
            inner: careful.inner?,
            outer: careful.outer,
        },
        ..*ring
    };
    report.fell_back.push(FellBack {
        row: ring.row,
        column: ring.column,
        reason,
    });
    constructed(&ring, construction.as_ref())
}

fn is_expected(place: &BoardPlace, ring: &RingMeasured) -> bool {
    let off = (ring.centre - place.outline.centre).norm();
    off < FARTHEST * place.outline.minor
}

/// The board's rings that showed no edges, where those that did say they are, as far as they lie inside the frame.
fn unseen(
    frame: &Frame,
    board: &Board,
    placed: &[Placed],
    indices: Indices,
) -> Vec<((u16, u16), BoardPlace)> {
    let pairs: Vec<_> = placed
        .iter()
        .map(|ring| {
            let plane = Point2::from(board.centre_m(ring.row, ring.column));
            (plane, ring.ellipses.outer.centre)
        })
        .collect();
    let Some(homography) = fit_homography(&pairs) else {
        return Vec::new();
    };
    // numbers that begin at the first row seen say nothing of rows beyond the last
    let last = |of: fn(&Placed) -> u16| match indices {
        Indices::Absolute => u16::MAX,
        Indices::Relative => placed.iter().map(of).max().unwrap_or(0),
    };
    let (last_row, last_column) = (last(|ring| ring.row), last(|ring| ring.column));
    let labels = board.indices();
    labels
        .filter(|&(row, column)| row <= last_row && column <= last_column)
        .filter(|&(row, column)| {
            !placed
                .iter()
                .any(|ring| (ring.row, ring.column) == (row, column))
        })
        .filter_map(|label| Some((label, predicted(frame, board, placed, &homography, label)?)))
        .collect()
}

/// A ring as its nearest neighbour shows itself, at the place where the plane puts it.
fn predicted(
    frame: &Frame,
    board: &Board,
    placed: &[Placed],
    homography: &Matrix3<f64>,
    (row, column): (u16, u16),
) -> Option<BoardPlace> {
    let plane = Point2::from(board.centre_m(row, column));
    let apart = |ring: &Placed| {
        let (dr, dc) = (ring.row.abs_diff(row), ring.column.abs_diff(column));
        u32::from(dr) * u32::from(dr) + u32::from(dc) * u32::from(dc)
    };
    let nearest = placed.iter().min_by_key(|ring| apart(ring))?;
    let there = Point2::from(board.centre_m(nearest.row, nearest.column));
    // what the lens bends the neighbour by, it bends this ring by
    let bend = nearest.ellipses.outer.centre - apply(homography, there)?;
    let outline = Ellipse {
        centre: apply(homography, plane)? + bend,
        ..nearest.ellipses.outer
    };
    let (x, y) = (outline.centre.x, outline.centre.y);
    let inside = |v: f64, size: usize| v >= outline.major && v <= size as f64 - 1.0 - outline.major;
    (inside(x, frame.width()) && inside(y, frame.height())).then_some(BoardPlace {
        plane_m: plane,
        outline,
        sigma_px: nearest.blur_sigma_px,
    })
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
