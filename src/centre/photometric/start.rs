//! Where a fit starts: the window, and of a few blurs and sizes the one whose grey levels explain it best.

use super::blur::Blur;
use super::model::RingModel;
use super::problem::Workspace;
use super::shape::Shape;
use super::window::{Rectangle, Window};
use crate::centre::Ellipse;
use crate::frame::{Frame, Linear};
use nalgebra::{SMatrix, SVector};

/// A window's margin is at least this, px.
const LEAST_MARGIN_PX: f64 = 3.0;

/// Edges are where they seem to be while the blur is less than this fraction of the inner minor semi-axis.
const SHARP: f64 = 0.16;

/// Whether blur is so small against an inner circle (its minor semi-axis, px).
pub(super) fn is_sharp(sigma_px: f64, inner_minor_px: f64) -> bool {
    sigma_px < SHARP * inner_minor_px
}

/// How windows are cut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cut {
    /// How far beyond the outer circle they reach, blur sigmas.
    pub(super) margin_sigmas: f64,
    /// How wide their pixels may be, blur sigmas.
    pub(super) bin_sigmas: f64,
}

impl Cut {
    /// Of a ring alone, whose perspective is in the finest detail: its error grows by 2 % at the heaviest blur (sigma 0.4 of the outer
    /// radius), by half of that elsewhere.
    pub(super) const ALONE: Self = Self {
        margin_sigmas: 3.0,
        bin_sigmas: 0.4,
    };
    /// Of a board's rings, whose perspective is the board's: the error grows by 1 to 2.5 %.
    pub(super) const OF_BOARD: Self = Self {
        margin_sigmas: 2.0,
        bin_sigmas: 0.75,
    };
    /// Of rings at a board's border, where the sheet's end is to be told from the ring.
    pub(super) const OF_BORDER: Self = Self {
        margin_sigmas: 2.5,
        bin_sigmas: 0.5,
    };
}

/// The window around a ring: `margin_sigmas` blur sigmas beyond its outer ellipse, its pixels binned as the blur allows; `None`
/// where it lies outside the frame.
pub fn window(
    frame: &Frame,
    outer: &Ellipse,
    sigma_px: f64,
    margin_sigmas: f64,
    linear: &Linear,
) -> Option<Window> {
    let how = Cut {
        margin_sigmas,
        ..Cut::ALONE
    };
    cut(frame, outer, sigma_px, how, linear)
}

/// The window around a ring, cut as `how` says.
pub(super) fn cut(
    frame: &Frame,
    outer: &Ellipse,
    sigma_px: f64,
    how: Cut,
    linear: &Linear,
) -> Option<Window> {
    let margin = (how.margin_sigmas * sigma_px).max(LEAST_MARGIN_PX);
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
    let bin = ((how.bin_sigmas * sigma_px) as usize).max(1);
    Window::cut(frame, rectangle, bin, linear)
}

/// Least-squares levels and a slope of the light for a shape and a blur, and the sum of squares they leave; `around` are the coverages by
/// the rings beside it.
pub(super) fn levels(
    window: &Window,
    (shape, blur): (&Shape, &Blur),
    ratio: f64,
    around: Option<&[Vec<f32>; 2]>,
    room: &mut Workspace,
) -> Option<(f64, RingModel)> {
    const UNKNOWNS: usize = 5;
    let [outer, inner] = room.circles_among(&window.grid, (shape, blur), ratio, around)?;
    let grid = &window.grid;
    let (width, stride) = (grid.width as f64, grid.stride());
    let mut normal = SMatrix::<f64, UNKNOWNS, UNKNOWNS>::zeros();
    let mut right = SVector::<f64, UNKNOWNS>::zeros();
    let mut total = 0.0;
    for row in 0..grid.height {
        let v = (row as f64 - 0.5 * (grid.height as f64 - 1.0)) / width;
        for column in 0..grid.width {
            let i = row * stride + column;
            if window.weights[i] > 0.0 {
                let u = (column as f64 - 0.5 * (width - 1.0)) / width;
                let (b1, br) = (f64::from(outer[i]), f64::from(inner[i]));
                let line = SVector::from([1.0 - b1, b1 - br, br, u, v]);
                let value = f64::from(window.values[i]);
                normal.ger(1.0, &line, &line, 1.0);
                right.axpy(value, &line, 1.0);
                total += value * value;
            }
        }
    }
    let ridge = 1e-9 * normal.trace();
    for k in 0..UNKNOWNS {
        normal[(k, k)] += ridge;
    }
    let solved = normal.cholesky()?.solve(&right);
    let mean = solved[0].max(0.05);
    let model = RingModel {
        shape: *shape,
        blur: *blur,
        paper: solved[0],
        ring: solved[1],
        inside: solved[2],
        shading: [solved[3] / mean, solved[4] / mean],
        sheet: None,
    };
    Some((total - solved.dot(&right), model))
}
