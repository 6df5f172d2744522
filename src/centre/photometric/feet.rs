//! A circle's image over a window, and how pixels stand to it: the way to its edge, and the edge where that way ends.
//!
//! Q (`shape`) is quadratic along any ray, so that the way to its zero is known. The first ray follows the gradient at the pixel, the second the
//! one where the first arrives.

use super::boundary::by_moments;
use super::real::Real;
use super::shape::{SHAPE_PARAMETERS, Shape};
use super::window::Grid;
use std::ops::Range;

/// How much of what it is at an ellipse's vertex the gradient may be elsewhere on the edge: perspective takes something off.
const LEAST_CLIMB: f64 = 0.3;
/// No way from a pixel that sees the edge is longer, major semi-axes. Far from a narrow ellipse the gradient may lead past it, and the way
/// back to the edge has no end.
const LONGEST_WAY: f64 = 3.0;
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
    longest_way: f32,
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
            longest_way: (LONGEST_WAY * major) as f32,
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

    /// The first way to the edge of pixels (about the ring's centre): it is no shorter than the distance, negative inside. With g half of the
    /// gradient and t the way in steps of g, `Q - 2 t g^2 + t^2 g^T N g` vanishes.
    #[inline(always)]
    pub(super) fn way<T: Real>(&self, [x, y]: [T; 2]) -> Way<T> {
        let gradient = self.half_gradient([x, y]);
        let [gx, gy] = gradient;
        let [lx, ly] = self.linear;
        let q = (gx + lx).times(x, (gy + ly).times(y, x.like(-self.square)));
        let square = gx.times(gx, gy * gy).at_least(TINY);
        let root = square.times(square, -(q * self.bend(gradient)));
        Way {
            at: [x, y],
            q,
            gradient,
            steps: q / (square + root.at_least(0.0).sqrt()),
            square,
        }
    }

    /// Where the way to the edge ends: along f, half of the gradient where the first way ends.
    #[inline(always)]
    pub(super) fn foot<T: Real>(&self, way: &Way<T>) -> Foot<T> {
        let [gx, gy] = way.gradient;
        let [xx, xy, yy] = self.form;
        let fx = gx - way.steps * (gx * xx + gy * xy);
        let fy = gy - way.steps * (gx * xy + gy * yy);
        let square = fx.times(fx, fy * fy).at_least(TINY);
        let climb = gx.times(fx, gy * fy);
        let bend = self.bend([fx, fy]);
        // a ray from far beyond may miss the edge, but the gradient on the edge is no less than that
        let least = square * (self.least_climb * self.least_climb);
        let root = climb.times(climb, -(way.q * bend)).larger(least).sqrt();
        // one quotient gives the reciprocals of f's length and of the root
        let length = square.sqrt();
        let both = fx.like(1.0) / (length * root);
        let (over, scale) = (both * root, both * square);
        let (ux, uy) = (fx * over, fy * over);
        Foot {
            at: way.at,
            // the gradient of a far pixel may lead past the circle
            distance: way.q * length / (climb + root).larger(length * 1e-6),
            normal: [ux, uy],
            curvature: self.bend([-uy, ux]) * scale,
            along: bend * over * over * scale,
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

    /// Half of Q's gradient along a normal at a place of the edge. Deep inside the foot may be anywhere, but the edge is on the edge.
    #[inline(always)]
    fn climb<T: Real>(&self, at: [T; 2], normal: [T; 2]) -> T {
        let [gx, gy] = self.half_gradient(at);
        gx.times(normal[0], gy * normal[1])
            .at_least(self.least_climb)
    }

    /// The way to the edge, no longer than that of any pixel which sees it.
    #[inline(always)]
    fn at_most_across<T: Real>(&self, way: T) -> T {
        way.within(-self.longest_way, self.longest_way)
    }

    /// The changes by the shape: the slope (by pixel) times how far each parameter moves the edge at the foot.
    #[inline(always)]
    pub(super) fn moved<T: Real>(&self, foot: &Foot<T>, slope: T) -> [T; SHAPE_PARAMETERS] {
        let [nx, ny] = foot.normal;
        let inwards = self.at_most_across(foot.distance);
        let (x, y) = (foot.at[0] - inwards * nx, foot.at[1] - inwards * ny);
        let share = -(slope * 0.5 / self.climb([x, y], foot.normal));
        let (by_x, by_y) = (share * x, share * y);
        self.by_moments(share, [by_x, by_y], [by_x * x, by_x * y, by_y * y])
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
        let inwards = self.at_most_across(inwards);
        let (fx, fy) = (foot.at[0] - inwards * nx, foot.at[1] - inwards * ny);
        let (ax, ay) = (aside * ny, aside * nx);
        let ([x, y], [u, v]) = ([fx + ax, fy - ay], [fx - ax, fy + ay]);
        let climbs = [
            self.climb([x, y], foot.normal),
            self.climb([u, v], foot.normal),
        ];
        let share = -(slope * 0.25 / (climbs[0] * climbs[1]));
        let (one, other) = (share * climbs[1], share * climbs[0]);
        let (one_x, one_y, other_x, other_y) = (one * x, one * y, other * u, other * v);
        let squares = [
            one_x.times(x, other_x * u),
            one_x.times(y, other_x * v),
            one_y.times(y, other_y * v),
        ];
        self.by_moments(one + other, [one_x + other_x, one_y + other_y], squares)
    }

    /// The changes of Q by the shape from moments in pixels of the grid.
    #[inline(always)]
    fn by_moments<T: Real>(
        &self,
        shares: T,
        [x, y]: [T; 2],
        [xx, xy, yy]: [T; 3],
    ) -> [T; SHAPE_PARAMETERS] {
        let (pixel, square) = (self.pixel_px, self.pixel_px * self.pixel_px);
        let q = self.shape.perspective;
        by_moments(
            self.shape.affine.map(|v| v as f32),
            [q.x as f32, q.y as f32],
            (2.0 * self.radius * self.radius) as f32,
            (
                shares,
                [x * pixel, y * pixel],
                [xx * square, xy * square, yy * square],
            ),
        )
    }
}

/// Pixels and the way from them to the edge that follows the gradient.
#[derive(Clone, Copy)]
pub(super) struct Way<T> {
    at: [T; 2],
    q: T,
    /// Half of Q's gradient, and its square.
    gradient: [T; 2],
    square: T,
    /// The way's length in steps of that.
    steps: T,
}

impl<T: Real> Way<T> {
    /// The square of its length (pixels of the grid), with the sign of its direction.
    #[inline(always)]
    pub(super) fn signed_square(&self) -> T {
        self.steps * self.steps.magnitude() * self.square
    }
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
