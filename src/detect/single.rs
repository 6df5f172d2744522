//! A board of one ring: the most conspicuous of the frame.

use super::centres::{constructed, drawn};
use super::detection::{Detection, FellBack, Indices, Measured, Miss, Ring};
use super::detector::DetectOptions;
use super::grid::Placed;
use super::patch::patch;
use super::ring_fit::RingFit;
use super::rings::{add_drowned, find_rings};
use crate::board::Board;
use crate::centre::photometric::{RingError, RingFitted, RingStart, Seen, Workspace, measure_ring};
use crate::centre::{Centre, Ellipse, Estimator, RingEllipses};
use crate::frame::{Frame, Linear};
use nalgebra::Matrix3;

/// So many candidates are measured, the most conspicuous first.
const MEASURED: usize = 3;
/// Blur of a patch that shows no edge, as a fraction of its minor semi-axis: where the starts of a fit spread from.
const PATCH_BLUR: f64 = 0.3;

/// Finds the ring of a board of one; `sign` is 1 where it is dark, -1 where it is light.
pub(super) fn find_single(
    frame: &Frame,
    board: &Board,
    options: &DetectOptions,
    linear: &Linear,
    sign: f64,
) -> Result<Detection, Miss> {
    let ratio = board.radius_ratio();
    let mut rings = find_rings(frame, sign, ratio);
    if rings.is_empty() {
        rings = add_drowned(frame, rings, sign, ratio);
    }
    let size = |r: &RingFit| r.contrast * r.outer.major * r.outer.minor;
    rings.sort_by(|a, b| size(b).total_cmp(&size(a)));
    let edges = rings.first().map(|fit| placed(fit, ratio));
    if let Some(construction) = options.estimator.construction() {
        let edges = edges.ok_or(Miss::NoRing)?;
        let ring = constructed(&edges, construction.as_ref()).ok_or(Miss::NoRing)?;
        return Ok(detection(frame, board, ring, None));
    }
    match photometric(frame, board, options, linear, &rings, sign) {
        Ok(fitted) => {
            let centre = Centre {
                point: fitted.model.shape.centre,
                covariance: Some(fitted.centre_covariance()),
            };
            let measured = Measured {
                psf: fitted.model.blur.psf,
                response_gamma: linear.gamma(),
                fell_back: Vec::new(),
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
            };
            Ok(detection(frame, board, ring, Some(measured)))
        }
    }
}

/// The first of the candidates that measures as a ring; after those with edges, the frame's most conspicuous patch.
fn photometric(
    frame: &Frame,
    board: &Board,
    options: &DetectOptions,
    linear: &Linear,
    rings: &[RingFit],
    sign: f64,
) -> Result<RingFitted, RingError> {
    let mut room = Workspace::default();
    let mut failure = RingError::Outside;
    let seen = rings.iter().map(|fit| (fit.outer, fit.blur_sigma_px));
    let patch = patch(frame, sign).map(|outline| (outline, PATCH_BLUR * outline.minor));
    for (outline, sigma_px) in seen.take(MEASURED).chain(patch) {
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
    let scale = (outer.major * outer.minor).sqrt() / board.outer_radius_m();
    let (x, y) = (ring.centre.point.x, ring.centre.point.y);
    Detection {
        width: frame.width(),
        height: frame.height(),
        indices: Indices::Absolute,
        homography: Matrix3::new(scale, 0.0, x, 0.0, scale, y, 0.0, 0.0, 1.0),
        rings: vec![ring],
        photometric,
    }
}
