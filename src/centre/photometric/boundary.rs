//! The image of one circle of a ring as nodes along its outline.
//!
//! A blurred region is an integral along its outline (Green): with W the kernel summed up from the left,
//! `B(x) = -integral W(x - X) dY`, and where a parameter moves the outline outwards by v a unit, `dB = integral K(x - X) v ds`.
//! Both integrands are periodic and smooth in the angle that runs round the ellipse, and for such the trapezoidal rule is as
//! exact as any: its error falls exponentially once the nodes are about as close as the kernel is wide.
//!
//! The outline is Q = 0 of `shape`; a parameter p moves it by v = -Q_p / |grad Q|. In the angle t, |dX/dt| / |grad Q| is the same
//! everywhere: det L / (2 s), where X = m + L (cos t, sin t) and Q = (X - m)^T M (X - m) - s.

use super::shape::{SHAPE_PARAMETERS, Shape};
use super::window::Grid;
use std::ops::{Add, Mul, Neg, Sub};

/// Fewest and most nodes of an outline.
const NODES: (f64, f64) = (16.0, 20_000.0);

/// Their number is a multiple of this, so that it hardly ever changes during a fit: what little the rule is wrong by changes with it.
const STEP: f64 = 8.0;

/// A point of an outline with its share of the integrals, in pixels of a window's grid.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Node {
    /// Column.
    pub(super) x: f32,
    /// Row.
    pub(super) y: f32,
    /// -dY: weight of the kernel's sum from the left.
    pub(super) rise: f32,
    /// v ds for each parameter of the shape: weights of the kernel.
    pub(super) sweep: [f32; SHAPE_PARAMETERS],
}

/// Replaces `nodes` by those of the circle of `radius` (in outer radii), at most `spacing` pixels of the grid apart; `None` where
/// its image is no ellipse.
pub(super) fn trace(
    nodes: &mut Vec<Node>,
    grid: &Grid,
    shape: &Shape,
    radius: f64,
    spacing: f64,
) -> Option<()> {
    let ellipse = shape.ellipse(radius)?;
    let scale = 1.0 / grid.pixel_px;
    let square = radius * radius;
    let (sin, cos) = ellipse.angle.sin_cos();
    let (major, minor) = (
        [ellipse.major * cos, ellipse.major * sin],
        [-ellipse.minor * sin, ellipse.minor * cos],
    );
    let middle = ellipse.centre - shape.centre;
    let length = std::f64::consts::TAU * ellipse.major * scale;
    let count = (length / spacing / STEP).ceil() * STEP;
    let count = count.clamp(NODES.0, NODES.1);
    let step = std::f64::consts::TAU / count;
    // s = m^T M m + a^2 of the completed square
    let (_, l) = shape.quadric(radius);
    let s = square - l.dot(&middle);
    let share = ellipse.major * ellipse.minor / (2.0 * s) * step * scale * scale;
    let q = shape.perspective;
    let (turn_sin, turn_cos) = step.sin_cos();
    let (mut c, mut w) = (1.0_f64, 0.0_f64);
    nodes.clear();
    for _ in 0..count as usize {
        let (x, y) = (
            middle.x + major[0] * c + minor[0] * w,
            middle.y + major[1] * c + minor[1] * w,
        );
        let rise = minor[1] * c - major[1] * w;
        let by_parameter = by_shape(shape.affine, [q.x, q.y], 2.0 * square, [x, y]);
        nodes.push(Node {
            x: ((x + shape.centre.x - grid.left_px) * scale) as f32,
            y: ((y + shape.centre.y - grid.top_px) * scale) as f32,
            rise: (-rise * step * scale) as f32,
            sweep: by_parameter.map(|derivative| (-derivative * share) as f32),
        });
        (c, w) = (c * turn_cos - w * turn_sin, w * turn_cos + c * turn_sin);
    }
    Some(())
}

/// Changes of Q by each parameter at a place (x, y) about the ring's centre; `squares` is twice the square of the circle's radius.
#[inline(always)]
pub(super) fn by_shape(
    affine: [f64; 3],
    perspective: [f64; 2],
    squares: f64,
    [x, y]: [f64; 2],
) -> [f64; SHAPE_PARAMETERS] {
    let moments = (1.0, [x, y], [x * x, x * y, y * y]);
    by_moments(affine, perspective, squares, moments)
}

/// The same, summed over places with their shares: of the sum of the shares, of the shares times x and y, and times their squares and
/// product.
#[inline(always)]
pub(super) fn by_moments<S, T>(
    [nxx, nxy, nyy]: [S; 3],
    [qx, qy]: [S; 2],
    squares: S,
    (shares, [x, y], [xx, xy, yy]): (T, [T; 2], [T; 3]),
) -> [T; SHAPE_PARAMETERS]
where
    S: Copy,
    T: Copy + Add<Output = T> + Sub<Output = T> + Mul<S, Output = T> + Neg<Output = T>,
{
    let depth = (shares - x * qx - y * qy) * squares;
    let (mx, my) = (x * nxx + y * nxy, x * nxy + y * nyy);
    [
        -(mx + mx) - depth * qx,
        -(my + my) - depth * qy,
        xx,
        xy + xy,
        yy,
        (x - xx * qx - xy * qy) * squares,
        (y - xy * qx - yy * qy) * squares,
    ]
}
