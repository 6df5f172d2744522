//! A circle's image over a window, and how pixels stand to it: the way to its edge, and the edge where that way ends.
//!
//! Q (`shape`) is quadratic along any ray, so that the way to its zero is known. The first ray follows the gradient at the pixel, the second the
//! one where the first arrives.

use super::boundary::by_shape;
use super::real::Real;
use super::shape::{SHAPE_PARAMETERS, Shape};
use super::window::Grid;
use std::ops::Range;

/// How much of what it is at an ellipse's vertex the gradient may be elsewhere on the edge: perspective takes something off.
const LEAST_CLIMB: f64 = 0.3;
/// The least of a squared root that is divided by.
const TINY: f32 = 1e-12;

/// A circle of a ring over a window; pixels of the grid.
#[derive(Debug, Clone, Copy)]
pub(super) struct Circle {
    shape: Shape,
    radius: f64,
    /// Q = x^T (xx, xy, yy) x + 2 (lx, ly) . x - square about the ring's centre.
    form: [f32; 3],
    linear: [f32; 2],
    square: f32,
    centre: [f32; 2],
    pixel_px: f32,
    /// Row of its middle, and how far above and below its edge reaches.
    middle: f64,
    half_height: f64,
    height: usize,
    /// Half of Q's gradient is no less anywhere on the edge.
    least_climb: f32,
    /// The smaller semi-axis.
    pub(super) minor: f64,
    /// Its curvature where it bends most.
    pub(super) most_bent: f64,
}

impl Circle {
    /// The circle of `radius` (outer radii); `None` where its image is no ellipse.
    pub(super) fn new(grid: &Grid, shape: &Shape, radius: f64) -> Option<Self> {
        let ellipse = shape.ellipse(radius)?;
        let scale = grid.pixel_px;
        let (major, minor) = (ellipse.major / scale, ellipse.minor / scale);
        let (matrix, linear) = shape.quadric(radius);
        let (sin, cos) = ellipse.angle.sin_cos();
        let square = scale * scale;
        Some(Self {
            shape: *shape,
            radius,
            form: [matrix[(0, 0)], matrix[(0, 1)], matrix[(1, 1)]].map(|v| (v * square) as f32),
            linear: [(linear.x * scale) as f32, (linear.y * scale) as f32],
            square: (radius * radius) as f32,
            centre: [
                ((shape.centre.x - grid.left_px) / scale) as f32,
                ((shape.centre.y - grid.top_px) / scale) as f32,
            ],
            pixel_px: scale as f32,
            middle: (ellipse.centre.y - grid.top_px) / scale,
            half_height: (major * sin).hypot(minor * cos),
            height: grid.height,
            least_climb: (LEAST_CLIMB * radius * radius / major) as f32,
            minor,
            most_bent: major / (minor * minor),
        })
    }

    /// The rows of the window that have pixels within `reach` of it or inside.
    pub(super) fn rows(&self, reach: f64) -> Range<usize> {
        let row = |y: f64| y.clamp(0.0, self.height as f64) as usize;
        let reach = self.half_height + reach;
        row((self.middle - reach).floor())..row((self.middle + reach).ceil() + 1.0)
    }

    /// A row's pixels, about the ring's centre.
    #[inline(always)]
    pub(super) fn about_centre<T: Real>(&self, column: T, row: usize) -> [T; 2] {
        let y = row as f32 - self.centre[1];
        [column - self.centre[0], column.like(y)]
    }

    /// The first way to the edge of pixels (about the ring's centre): it is no shorter than the distance, negative inside.
    #[inline(always)]
    pub(super) fn way<T: Real>(&self, [x, y]: [T; 2]) -> Way<T> {
        let gradient = self.half_gradient([x, y]);
        let [gx, gy] = gradient;
        let [lx, ly] = self.linear;
        let q = (gx + lx).times(x, (gy + ly).times(y, x.like(-self.square)));
        let square = gx.times(gx, gy * gy).at_least(TINY);
        let length = square.sqrt();
        let over = x.like(1.0) / length;
        let normal = [gx * over, gy * over];
        let bend = self.bend(normal);
        let root = (square - q * bend).at_least(0.0).sqrt();
        Way {
            at: [x, y],
            q,
            gradient,
            normal,
            long: q / (length + root),
        }
    }

    /// Where the way to the edge ends.
    #[inline(always)]
    pub(super) fn foot<T: Real>(&self, way: &Way<T>) -> Foot<T> {
        let ([gx, gy], [ux, uy]) = (way.gradient, way.normal);
        let [xx, xy, yy] = self.form;
        let fx = gx - way.long * (ux * xx + uy * xy);
        let fy = gy - way.long * (ux * xy + uy * yy);
        let over = fx.like(1.0) / fx.times(fx, fy * fy).at_least(TINY).sqrt();
        let (ux, uy) = (fx * over, fy * over);
        let bend = self.bend([ux, uy]);
        let climb = gx.times(ux, gy * uy);
        let root = climb.times(climb, -(way.q * bend)).at_least(TINY).sqrt();
        let scale = root.like(1.0) / root;
        Foot {
            at: way.at,
            // the gradient of a far pixel may lead past the circle
            distance: way.q / (climb + root).at_least(1e-6),
            normal: [ux, uy],
            curvature: self.bend([-uy, ux]) * scale,
            along: bend * scale,
            across: ((ux * ux - uy * uy) * xy + ux * uy * (yy - xx)) * scale,
        }
    }

    #[inline(always)]
    fn half_gradient<T: Real>(&self, [x, y]: [T; 2]) -> [T; 2] {
        let [xx, xy, yy] = self.form.map(|v| x.like(v));
        let [lx, ly] = self.linear.map(|v| x.like(v));
        [x.times(xx, y.times(xy, lx)), x.times(xy, y.times(yy, ly))]
    }

    /// Half of Q's second derivative along a unit vector.
    #[inline(always)]
    fn bend<T: Real>(&self, [ux, uy]: [T; 2]) -> T {
        let [xx, xy, yy] = self.form;
        ux * ux * xx + ux * uy * (2.0 * xy) + uy * uy * yy
    }

    /// What a slope at a place of the edge (pixels of the grid about the ring's centre) makes of each parameter's movement of it.
    #[inline(always)]
    fn swept<T: Real>(&self, at: [T; 2], normal: [T; 2], slope: T) -> [T; SHAPE_PARAMETERS] {
        let [gx, gy] = self.half_gradient(at);
        // deep inside the foot may be anywhere, but the edge is on the edge
        let climb = gx.times(normal[0], gy * normal[1]);
        let climb = climb.at_least(self.least_climb);
        let share = -(slope / (climb + climb));
        let affine = self.shape.affine.map(|v| slope.like(v as f32));
        let q = self.shape.perspective;
        let q = [slope.like(q.x as f32), slope.like(q.y as f32)];
        let squares = slope.like((2.0 * self.radius * self.radius) as f32);
        let at = [at[0] * self.pixel_px, at[1] * self.pixel_px];
        // not by `map`, which is not inlined
        let mut all = by_shape(affine, q, squares, at);
        for by in &mut all {
            *by = share * *by;
        }
        all
    }

    /// The changes by the shape: the slope (by pixel) times how far each parameter moves the edge at the foot.
    #[inline(always)]
    pub(super) fn moved<T: Real>(&self, foot: &Foot<T>, slope: T) -> [T; SHAPE_PARAMETERS] {
        let [nx, ny] = foot.normal;
        let at = [
            foot.at[0] - foot.distance * nx,
            foot.at[1] - foot.distance * ny,
        ];
        self.swept(at, foot.normal, slope)
    }

    /// The same, where two points of the edge that are `aside` from the foot stand for the arc that is seen.
    #[inline(always)]
    pub(super) fn moved_along<T: Real>(
        &self,
        foot: &Foot<T>,
        slope: T,
        aside: T,
    ) -> [T; SHAPE_PARAMETERS] {
        let [nx, ny] = foot.normal;
        let inwards = (foot.curvature * 0.5 * aside).times(aside, foot.distance);
        let (fx, fy) = (foot.at[0] - inwards * nx, foot.at[1] - inwards * ny);
        let half = slope * 0.5;
        let one = self.swept([fx + aside * ny, fy - aside * nx], foot.normal, half);
        let other = self.swept([fx - aside * ny, fy + aside * nx], foot.normal, half);
        let mut both = one;
        for (sum, more) in both.iter_mut().zip(other) {
            *sum = *sum + more;
        }
        both
    }
}

/// Pixels and the way from them to the edge that follows the gradient.
#[derive(Clone, Copy)]
pub(super) struct Way<T> {
    at: [T; 2],
    q: T,
    /// Half of Q's gradient.
    gradient: [T; 2],
    normal: [T; 2],
    /// How long it is, pixels of the grid.
    pub(super) long: T,
}

/// Pixels, and the edge at the feet of their perpendiculars; lengths in pixels of the grid.
#[derive(Clone, Copy)]
pub(super) struct Foot<T> {
    /// The pixels, about the ring's centre.
    at: [T; 2],
    /// How far they are beyond the edge.
    pub(super) distance: T,
    /// Outwards.
    pub(super) normal: [T; 2],
    /// Curvature of the edge.
    pub(super) curvature: T,
    /// The two numbers by which it is no circle: the curvature and zero where it is one.
    pub(super) along: T,
    /// See `along`.
    pub(super) across: T,
}
