//! The coverage by a circle whose blur is less than half a pixel: pixel by pixel, because nodes would have to be as close as the blur
//! is small.
//!
//! Within a pixel such an edge is straight, at the distance d along its normal (M, m), M >= m >= 0. What the pixel's box and the blur
//! (sigma s) leave of it is the step integrated twice more, over M and over m:
//!
//! ```text
//! B = s^2 (J(u1) - J(u2) - J(u3) + J(u4)) / (M m),   u = (-d +- M/2 +- m/2) / s,   J'' = Phi
//! ```
//!
//! Changes by d and by s are the same with G = J' and with Phi, times s. Where the edge bends (curvature k) its distance is
//! d + k t^2 / 2 at t along it, and the pixel loses k / 2 times the integral of t^2 along the edge: s^2 of the blur, which moves the edge
//! as a whole, and the box's part, a cubic spline of d between the box's corners, blurred too. What is left is of second
//! order in k: less than 1e-3 of the contrast for circles of 8 pixels.

use super::boundary::sweeps;
use super::coverage::{COVERAGE_PARAMETERS, LANES, Lanes, Plane};
use super::normal::density_and_cumulative;
use super::shape::{SHAPE_PARAMETERS, Shape};
use super::window::Grid;

/// Blur from which on nodes are as fast, pixels of the grid.
pub(super) const MOST_SIGMA: f64 = 0.5;
/// Smaller circles bend too much within a pixel: least semi-axis, pixels of the grid.
pub(super) const LEAST_RADIUS: f64 = 5.0;
/// The step is flat beyond this many sigmas.
const REACH: f32 = 4.4;
/// The smaller part of the normal is taken as this at least, and as this many sigmas: differences would be rounding otherwise.
const LEAST_SLOPE: (f32, f32) = (0.05, 0.2);

/// A circle over a window.
pub(super) struct SharpCircle {
    /// Q = x^T (xx, xy, yy) x + 2 (lx, ly) . x - square, in pixels of the grid about the ring's centre.
    xx: f32,
    xy: f32,
    yy: f32,
    lx: f32,
    ly: f32,
    square: f32,
    /// The ring's centre, pixels of the grid.
    centre: [f32; 2],
    /// Rows it reaches.
    rows: (usize, usize),
    sigma: f32,
    reach: f32,
    shape: Shape,
    radius: f64,
    pixel_px: f64,
}

/// One vector of pixels: distances from the edge, inside negative, and what they depend on.
struct Near {
    x: Lanes,
    y: f32,
    distance: Lanes,
    normal: [Lanes; 2],
    curvature: Lanes,
}

impl SharpCircle {
    /// `None` where its image is no ellipse, or too small a one.
    pub(super) fn new(grid: &Grid, shape: &Shape, radius: f64, sigma: f64) -> Option<Self> {
        let ellipse = shape.ellipse(radius)?;
        let scale = grid.pixel_px;
        if ellipse.minor < LEAST_RADIUS * scale {
            return None;
        }
        let (matrix, linear) = shape.quadric(radius);
        let (sin, cos) = ellipse.angle.sin_cos();
        let half_height = (ellipse.major * sin).hypot(ellipse.minor * cos) / scale;
        let reach = f64::from(REACH) * sigma + 0.75;
        let row = |y: f64| y.clamp(0.0, grid.height as f64) as usize;
        let middle = (ellipse.centre.y - grid.top_px) / scale;
        let rows = (
            row((middle - half_height - reach).floor()),
            row((middle + half_height + reach).ceil() + 1.0),
        );
        Some(Self {
            xx: (matrix[(0, 0)] * scale * scale) as f32,
            xy: (matrix[(0, 1)] * scale * scale) as f32,
            yy: (matrix[(1, 1)] * scale * scale) as f32,
            lx: (linear.x * scale) as f32,
            ly: (linear.y * scale) as f32,
            square: (radius * radius) as f32,
            centre: [
                ((shape.centre.x - grid.left_px) / scale) as f32,
                ((shape.centre.y - grid.top_px) / scale) as f32,
            ],
            rows,
            sigma: sigma as f32,
            reach: reach as f32,
            shape: *shape,
            radius,
            pixel_px: scale,
        })
    }

    /// Adds the coverage to the first of the planes and, with a contrast, its changes to the others.
    #[inline(always)]
    pub(super) fn cover(
        &self,
        grid: &Grid,
        (values, changes): (&mut Plane, &mut [Plane; COVERAGE_PARAMETERS]),
        contrast: Option<f32>,
    ) {
        let stride = grid.stride();
        for row in self.rows.0..self.rows.1 {
            for vector in 0..stride / LANES {
                let near = self.near(row, vector);
                let at = row * stride + vector * LANES;
                let far = |side: f32| near.distance.iter().all(|d| side * d > self.reach);
                if far(1.0) {
                    continue;
                }
                let out = &mut values[at..at + LANES];
                if far(-1.0) {
                    out.iter_mut().for_each(|value| *value += 1.0);
                    continue;
                }
                let [sum, slope, by_sigma] = self.step(&near);
                out.iter_mut().zip(&sum).for_each(|(out, sum)| *out += sum);
                if let Some(contrast) = contrast {
                    self.change(&near, &slope.map(|s| contrast * s), changes, at);
                    let by_size = changes[SHAPE_PARAMETERS][at..at + LANES].iter_mut();
                    by_size
                        .zip(&by_sigma)
                        .for_each(|(out, by)| *out += contrast * by);
                }
            }
        }
    }

    /// Q is quadratic along the normal, so that the way to its zero is known.
    #[inline(always)]
    fn near(&self, row: usize, vector: usize) -> Near {
        let y = row as f32 - self.centre[1];
        let begin = (vector * LANES) as f32 - self.centre[0];
        let mut near = Near {
            x: [0.0; LANES],
            y,
            distance: [0.0; LANES],
            normal: [[0.0; LANES]; 2],
            curvature: [0.0; LANES],
        };
        for l in 0..LANES {
            let x = begin + l as f32;
            let half_gx = self.xx * x + self.xy * y + self.lx;
            let half_gy = self.xy * x + self.yy * y + self.ly;
            let q = (half_gx + self.lx) * x + (half_gy + self.ly) * y - self.square;
            let half = (half_gx * half_gx + half_gy * half_gy).max(1e-20).sqrt();
            let (nx, ny) = (half_gx / half, half_gy / half);
            let along = self.xx * nx * nx + 2.0 * self.xy * nx * ny + self.yy * ny * ny;
            let across = self.xx * ny * ny - 2.0 * self.xy * nx * ny + self.yy * nx * nx;
            let root = (half * half - q * along).max(0.0).sqrt();
            near.x[l] = x;
            near.distance[l] = q / (half + root);
            near.normal[0][l] = nx;
            near.normal[1][l] = ny;
            near.curvature[l] = across / root.max(1e-10);
        }
        near
    }

    /// The blurred step, its slope inwards, and its change by sigma.
    #[inline(always)]
    fn step(&self, near: &Near) -> [Lanes; 3] {
        let sigma = self.sigma;
        let least = LEAST_SLOPE.0.max(LEAST_SLOPE.1 * sigma);
        let (mut sums, mut slopes, mut changes) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for l in 0..LANES {
            let (nx, ny) = (near.normal[0][l].abs(), near.normal[1][l].abs());
            let (large, small) = (nx.max(ny), nx.min(ny).max(least));
            let half_bend = 0.5 * near.curvature[l];
            // deeper inside there is nothing but rounding
            let middle = (-near.distance[l] - half_bend * sigma * sigma).min(self.reach);
            let scale = 0.5 / (large * small);
            let (mut sum, mut slope, mut change) = (0.0, 0.0, 0.0);
            for (corner, [linear, square, cube]) in CORNERS.iter().zip(bends(large, small)) {
                let way = middle + corner[0] * large + corner[1] * small;
                let (density, [zeroth, first, second, third]) = self.powers(way);
                let (linear, cube) = (half_bend * linear, half_bend * cube);
                let square = scale * 4.0 * corner[0] * corner[1] - half_bend * square;
                sum += square * second - linear * first - cube * third;
                slope += 2.0 * square * first - linear * zeroth - 3.0 * cube * second;
                change += sigma * (2.0 * square * zeroth - 6.0 * cube * first) - linear * density;
            }
            sums[l] = sum;
            slopes[l] = slope;
            changes[l] = change - 2.0 * half_bend * sigma * slope;
        }
        [sums, slopes, changes]
    }

    /// The density at a way inwards, and the powers 0 to 3 of the ways beyond, blurred.
    #[inline(always)]
    fn powers(&self, way: f32) -> (f32, [f32; 4]) {
        let sigma = self.sigma;
        let u = (way / sigma).clamp(-2.0 * REACH, 2.0 * REACH);
        let (density, cumulative) = density_and_cumulative(u);
        // beyond the reach the integrals go on as those of the sharp step
        let way = if u > 0.0 { way } else { u * sigma };
        let (squares, variance, spread) = (way * way, sigma * sigma, sigma * density);
        let first = way * cumulative + spread;
        let second = (squares + variance) * cumulative + way * spread;
        let third =
            way * (squares + 3.0 * variance) * cumulative + (squares + 2.0 * variance) * spread;
        (density, [cumulative, first, second, third])
    }

    /// Adds the changes by the shape: the slope times how far each parameter moves the edge at the foot of the pixel.
    #[inline(always)]
    fn change(
        &self,
        near: &Near,
        slope: &Lanes,
        changes: &mut [Plane; COVERAGE_PARAMETERS],
        at: usize,
    ) {
        let scale = self.pixel_px as f32;
        let mut moved = [[0.0; LANES]; SHAPE_PARAMETERS];
        for l in 0..LANES {
            let (nx, ny) = (near.normal[0][l], near.normal[1][l]);
            let x = near.x[l] - near.distance[l] * nx;
            let y = near.y - near.distance[l] * ny;
            let half_gx = self.xx * x + self.xy * y + self.lx;
            let half_gy = self.xy * x + self.yy * y + self.ly;
            let gradient = 2.0 * (half_gx * half_gx + half_gy * half_gy).max(1e-20).sqrt();
            // the gradient is by pixels of the grid, and so is the slope
            let share = -slope[l] / gradient;
            let all = sweeps(&self.shape, self.radius, [x * scale, y * scale]);
            for (moved, sweep) in moved.iter_mut().zip(all) {
                moved[l] = share * sweep;
            }
        }
        for (plane, moved) in changes.iter_mut().zip(&moved) {
            let out = plane[at..at + LANES].iter_mut();
            out.zip(moved).for_each(|(out, moved)| *out += moved);
        }
    }
}

/// The corners of a pixel, in the order in which an edge leaves them behind.
const CORNERS: [[f32; 2]; 4] = [[0.5, 0.5], [0.5, -0.5], [-0.5, 0.5], [-0.5, -0.5]];

/// The integral of t^2 over the part of an edge that lies in the pixel, as a spline of the edge's way beyond each corner: what its first,
/// second and third power get there, where the edge goes on to the next side of the pixel.
#[inline(always)]
fn bends(large: f32, small: f32) -> [[f32; 3]; 4] {
    let (near, far) = (0.5 * (large - small), 0.5 * (large + small));
    let (flat, steep) = (small / large, large / small);
    let linear = flat + steep;
    let square = steep * steep - flat * flat;
    let cube = (flat * flat * flat + steep * steep * steep) / 3.0;
    [
        [near * near * linear, -near * square, cube],
        [-far * far * linear, -far * square, -cube],
        [-far * far * linear, far * square, -cube],
        [near * near * linear, near * square, cube],
    ]
}
