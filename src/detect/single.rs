//! A board of one ring: the most conspicuous of the frame.

use super::centres::{constructed, drawn, response};
use super::detection::{Detection, FellBack, Indices, Measured, Miss, Ring};
use super::detector::DetectOptions;
use super::grid::Placed;
use super::patch::patch;
use super::ring_fit::{Care, RingFit};
use super::rings::{add_drowned, find_rings};
use super::scales::Scales;
use crate::board::Board;
use crate::centre::photometric::{
    BoardPlace, BoardStart, RingError, RingFitted, RingStart, Seen, Workspace, measure_ring,
};
use crate::centre::{Centre, Ellipse, Estimator, RingEllipses};
use crate::frame::{Frame, Linear};
use nalgebra::{Matrix3, Point2};

/// So many candidates are measured, the most conspicuous first.
const MEASURED: usize = 3;
/// Blur of a patch that shows no edge, as a fraction of its minor semi-axis: where the starts of a fit spread from.
const PATCH_BLUR: f64 = 0.3;

/// Finds the ring of a board of one; `sign` is 1 where it is dark, -1 where it is light.
pub(super) fn find_single(
    frame: &Frame,
    board: &Board,
    options: &DetectOptions,
    sign: f64,
) -> Result<Detection, Miss> {
    let ratio = board.radius_ratio();
    let mut scales = Scales::new(frame, sign, ratio);
    let mut rings = find_rings(&mut scales, board, Care::Edges);
    if rings.is_empty() {
        rings = add_drowned(&mut scales, board, rings, Care::Edges);
    }
    let size = |r: &RingFit| r.contrast * r.outer.major * r.outer.minor;
    rings.sort_by(|a, b| size(b).total_cmp(&size(a)));
    let edges = rings.first().map(|fit| placed(fit, ratio));
    if let Some(construction) = options.estimator.construction() {
        let edges = edges.ok_or(Miss::NoRing)?;
        let ring = constructed(&edges, construction.as_ref()).ok_or(Miss::NoRing)?;
        return Ok(detection(frame, board, ring, None));
    }
    let candidates = candidates(frame, &rings, sign);
    let linear = linear(frame, board, options, &candidates, sign);
    match photometric(frame, board, options, &linear, &candidates, sign) {
        Ok(fitted) => {
            let centre = Centre {
                point: fitted.model.shape.centre,
                covariance: Some(fitted.centre_covariance()),
            };
            let measured = Measured {
                psf: fitted.model.blur.psf,
                response_gamma: linear.gamma(),
                fell_back: Vec::new(),
                out_of_round: 0.0,
            };
            let ring = drawn((0, 0), centre, &fitted, ratio).ok_or(Miss::NoRing)?;
            Ok(detection(frame, board, ring, Some(measured)))
        }
        Err(error) => {
            let edges = edges.ok_or(Miss::NoRing)?;
            let construction = Estimator::FALLBACK.construction().ok_or(Miss::NoRing)?;
            let ring = constructed(&edges, construction.as_ref()).ok_or(Miss::NoRing)?;
            let measured = Measured {
                psf: Default::default(),
                response_gamma: linear.gamma(),
                fell_back: vec![FellBack {
                    row: 0,
                    column: 0,
                    reason: error,
                }],
                out_of_round: 0.0,
            };
            Ok(detection(frame, board, ring, Some(measured)))
        }
    }
}

/// An outline, px, and the blur it seems to have, px.
type Candidate = (Ellipse, f64);

/// The rings with edges, the most conspicuous first, then the frame's most conspicuous patch.
fn candidates(frame: &Frame, rings: &[RingFit], sign: f64) -> Vec<Candidate> {
    let seen = rings.iter().map(|fit| (fit.outer, fit.blur_sigma_px));
    let patch = patch(frame, sign).map(|outline| (outline, PATCH_BLUR * outline.minor));
    seen.take(MEASURED).chain(patch).collect()
}

/// Light from this frame's grey values.
fn linear(
    frame: &Frame,
    board: &Board,
    options: &DetectOptions,
    candidates: &[Candidate],
    sign: f64,
) -> Linear {
    let places: Vec<BoardPlace> = candidates
        .iter()
        .take(1)
        .map(|&(outline, sigma_px)| BoardPlace {
            plane_m: Point2::origin(),
            outline,
            sigma_px,
        })
        .collect();
    let start = BoardStart {
        places: &places,
        outer_radius_m: board.outer_radius_m(),
        ratio: board.radius_ratio(),
        sign,
        psf: options.psf,
        camera: options.camera,
        linear: &Linear::new(1.0, false),
    };
    response(frame, options, &start)
}

/// The first of the candidates that measures as a ring.
fn photometric(
    frame: &Frame,
    board: &Board,
    options: &DetectOptions,
    linear: &Linear,
    candidates: &[Candidate],
    sign: f64,
) -> Result<RingFitted, RingError> {
    let mut room = Workspace::default();
    let mut failure = RingError::Outside;
    for &(outline, sigma_px) in candidates {
        let start = RingStart {
            seen: Seen {
                outline,
                ratio: board.radius_ratio(),
                sign,
            },
            sigma_px,
            psf: options.psf,
            linear,
        };
        match measure_ring(frame, &start, &mut room) {
            Ok(fitted) => return Ok(fitted),
            Err(error) => failure = error,
        }
    }
    Err(failure)
}

/// Where its inner circle has drowned, it is drawn where the board says.
fn placed(fit: &RingFit, ratio: f64) -> Placed {
    let outer = fit.outer;
    let drowned = Ellipse {
        major: ratio * outer.major,
        minor: ratio * outer.minor,
        ..outer
    };
    Placed {
        row: 0,
        column: 0,
        ellipses: RingEllipses {
            inner: fit.inner.unwrap_or(drowned),
            outer,
        },
        blur_sigma_px: fit.blur_sigma_px,
    }
}

fn detection(frame: &Frame, board: &Board, ring: Ring, photometric: Option<Measured>) -> Detection {
    let outer = ring.ellipses.outer;
    let scale = outer.mean_radius() / board.outer_radius_m();
    let (x, y) = (ring.centre.point.x, ring.centre.point.y);
    Detection {
        width: frame.width(),
        height: frame.height(),
        indices: Indices::Absolute,
        homography: Matrix3::new(scale, 0.0, x, 0.0, scale, y, 0.0, 0.0, 1.0),
        rings: vec![ring],
        photometric,
        another: None,
    }
}
