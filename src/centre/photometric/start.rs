//! Where a fit starts: the window, and of a few blurs and sizes the one whose grey levels explain it best.

use super::blur::Blur;
use super::coverage::Values;
use super::model::RingModel;
use super::shape::Shape;
use super::window::{Rectangle, Window};
use crate::centre::{Ellipse, RingEllipses};
use crate::frame::Frame;
use nalgebra::{Matrix3, Vector3};

/// A window reaches this many blur sigmas beyond the outer ellipse, and at least this many px.
const MARGIN_SIGMAS: f64 = 2.5;
const LEAST_MARGIN_PX: f64 = 3.0;
/// A window's pixel is at most this fraction of the blur sigma: binning by half of it costs no accuracy.
const BIN_OF_SIGMA: f64 = 0.5;
/// Edges of a blurred ring stand too far out and look too sharp: factors of size and blur that are tried.
const SIZES: [f64; 3] = [1.0, 0.92, 0.84];
const BLURS: [f64; 3] = [1.0, 1.35, 1.8];

/// The window around a ring. `counts` says which places of the frame (px) belong to this ring alone.
pub fn window(
    frame: &Frame,
    outer: &Ellipse,
    sigma_px: f64,
    counts: impl Fn(f64, f64) -> bool,
) -> Option<Window> {
    let margin = (MARGIN_SIGMAS * sigma_px).max(LEAST_MARGIN_PX);
    let (sin, cos) = outer.angle.sin_cos();
    let half_x = (outer.major * cos).hypot(outer.minor * sin) + margin;
    let half_y = (outer.major * sin).hypot(outer.minor * cos) + margin;
    let clamp = |v: f64, size: usize| v.clamp(0.0, size as f64) as usize;
    let (x0, x1) = (
        clamp((outer.centre.x - half_x).floor(), frame.width()),
        clamp((outer.centre.x + half_x).ceil() + 1.0, frame.width()),
    );
    let (y0, y1) = (
        clamp((outer.centre.y - half_y).floor(), frame.height()),
        clamp((outer.centre.y + half_y).ceil() + 1.0, frame.height()),
    );
    let rectangle = Rectangle {
        x: x0,
        y: y0,
        width: x1.saturating_sub(x0),
        height: y1.saturating_sub(y0),
    };
    let bin = ((BIN_OF_SIGMA * sigma_px) as usize).max(1);
    Window::cut(frame, rectangle, bin, counts)
}

/// The best of the starts near two ellipses.
pub fn start(
    window: &Window,
    ellipses: &RingEllipses,
    sigma_px: f64,
    ratio: f64,
) -> Option<RingModel> {
    let mut room = Default::default();
    SIZES
        .iter()
        .flat_map(|&size| BLURS.iter().map(move |&blur| (size, blur)))
        .filter_map(|(size, blur)| {
            let outer = Ellipse {
                major: ellipses.outer.major * size,
                minor: ellipses.outer.minor * size,
                ..ellipses.outer
            };
            levels(
                window,
                &Shape::frontal(&outer),
                &Blur::gaussian((sigma_px * blur).max(0.3)),
                ratio,
                &mut room,
            )
        })
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, model)| model)
}

/// Least-squares grey levels for a shape and a blur, and the sum of squares they leave.
pub(super) fn levels(
    window: &Window,
    shape: &Shape,
    blur: &Blur,
    ratio: f64,
    [outer, inner]: &mut [Values; 2],
) -> Option<(f64, RingModel)> {
    outer.fill(&window.grid, shape, 1.0, blur)?;
    inner.fill(&window.grid, shape, ratio, blur)?;
    let (mut normal, mut right, mut total) = (Matrix3::zeros(), Vector3::zeros(), 0.0);
    for i in 0..window.values.len() {
        if window.weights[i] > 0.0 {
            let (b1, br) = (outer.value(i), inner.value(i));
            let row = Vector3::new(1.0 - b1, b1 - br, br);
            normal += row * row.transpose();
            right += row * window.values[i];
            total += window.values[i] * window.values[i];
        }
    }
    let levels = normal.cholesky()?.solve(&right);
    let model = RingModel {
        shape: *shape,
        blur: *blur,
        paper: levels.x,
        ring: levels.y,
        inside: levels.z,
        shading: [0.0, 0.0],
    };
    Some((total - levels.dot(&right), model))
}
