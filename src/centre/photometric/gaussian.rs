//! Coverage under a Gaussian blur.
//!
//! The kernel is separable: `B(x, y) = integral dv G(y - v) (F(x - l(v)) - F(x - r(v)))` over the chords [l(v), r(v)], G the
//! pixel-integrated normal density and F the pixel-integrated normal distribution. The nodes in v are Chebyshev's:
//! chords shrink like a square root at top and bottom, and there the rule is as exact as elsewhere.

use super::coverage::{BLUR, Coverage, VALUE, add_moments};
use super::outline::{End, Outline};
use super::window::Grid;
use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// Nodes for each blur sigma of height, and the fewest.
const NODES_PER_SIGMA: f64 = 2.6;
const LEAST_NODES: usize = 14;
/// Blur below this is taken as this, px of the window: the pixel's own box rules there.
const LEAST_SIGMA: f64 = 0.2;
/// The kernel is zero beyond this many sigmas: 3e-7 of it is cut off.
const REACH: f64 = 5.0;

/// Adds the coverage of a window by an outline, blurred by a Gaussian.
pub(super) fn cover<const N: usize>(
    out: &mut Coverage<N>,
    grid: &Grid,
    outline: &Outline,
    sigma_px: f64,
) {
    let sigma = sigma_px.max(LEAST_SIGMA * grid.pixel_px);
    let (top, bottom) = outline.rows();
    let (middle, half) = (0.5 * (top + bottom), 0.5 * (bottom - top));
    let wide = sigma.max(0.3 * grid.pixel_px);
    let count = ((NODES_PER_SIGMA * half / wide) as usize + LEAST_NODES).min(4000);
    let mut piece = Piece::new(grid, sigma);
    for j in 0..count {
        let t = PI * (j as f64 + 0.5) / count as f64;
        let y = middle - half * t.cos();
        let weight = half * t.sin() * PI / count as f64;
        for (end, sign) in outline.chord(y).iter().flatten().zip([1.0, -1.0]) {
            piece.fill(grid, end, sign);
            piece.add_to(out, grid, y, weight);
        }
    }
    out.sum_steps();
}

/// What one end of a chord does to the pixels of a row, before it is spread over the rows.
struct Piece<const N: usize> {
    sigma: f64,
    /// Columns near the end.
    first: usize,
    cells: Vec<[f64; N]>,
    /// Coverage of all columns beyond.
    beyond: f64,
}

impl<const N: usize> Piece<N> {
    fn new(grid: &Grid, sigma: f64) -> Self {
        Self {
            sigma,
            first: 0,
            cells: Vec::with_capacity(grid.width),
            beyond: 0.0,
        }
    }

    /// The end of a chord: 0 on its left, `sign` on its right.
    fn fill(&mut self, grid: &Grid, end: &End, sign: f64) {
        let (sigma, pixel) = (self.sigma, grid.pixel_px);
        let reach = REACH * sigma + 0.5 * pixel;
        let columns = grid.columns_within(end.x - reach, end.x + reach);
        self.first = columns.start;
        self.beyond = sign;
        self.cells.clear();
        let scale = sign / pixel;
        let mut left = Distribution::at(grid.x(columns.start) - 0.5 * pixel - end.x, sigma);
        for column in columns {
            let right = Distribution::at(grid.x(column) + 0.5 * pixel - end.x, sigma);
            let mut cell = [0.0; N];
            cell[VALUE] = scale * (right.integral - left.integral);
            if N > 1 {
                cell[BLUR] = scale * (right.bell - left.bell);
                let share = (right.value - left.value) / pixel;
                add_moments(&mut cell, share, &end.moments);
            }
            self.cells.push(cell);
            left = right;
        }
    }

    /// Spreads the piece at height `y` over the rows its kernel reaches.
    fn add_to(&self, out: &mut Coverage<N>, grid: &Grid, y: f64, weight: f64) {
        let reach = REACH * self.sigma + 0.5 * grid.pixel_px;
        for row in grid.rows_within(y - reach, y + reach) {
            let (g, slope) = density(grid.y(row) - y, grid.pixel_px, self.sigma);
            let (g, slope) = (weight * g, weight * slope);
            let row = out.row(row);
            let past = self.first + self.cells.len();
            for (sum, cell) in row.cells[self.first..past].iter_mut().zip(&self.cells) {
                for (s, c) in sum.iter_mut().zip(cell) {
                    *s += g * c;
                }
                if N > 1 {
                    sum[BLUR] += slope * cell[VALUE];
                }
            }
            row.steps[past][0] += g * self.beyond;
            row.steps[past][1] += slope * self.beyond;
        }
    }
}

/// The normal distribution at one place, its density times sigma^2, and its integral up to there.
struct Distribution {
    value: f64,
    bell: f64,
    integral: f64,
}

impl Distribution {
    fn at(z: f64, sigma: f64) -> Self {
        let u = z / sigma;
        if u.abs() > REACH {
            let value = if u > 0.0 { 1.0 } else { 0.0 };
            return Self {
                value,
                bell: 0.0,
                integral: z * value,
            };
        }
        let (value, bell) = (cumulative(u), bell(u));
        Self {
            value,
            bell,
            integral: z * value + sigma * bell,
        }
    }
}

/// The normal density averaged over a pixel and its derivative by sigma.
fn density(z: f64, pixel: f64, sigma: f64) -> (f64, f64) {
    let (a, b) = ((z + 0.5 * pixel) / sigma, (z - 0.5 * pixel) / sigma);
    let value = (cumulative(a) - cumulative(b)) / pixel;
    let slope = (b * bell(b) - a * bell(a)) / (sigma * pixel);
    (value, slope)
}

fn cumulative(z: f64) -> f64 {
    0.5 * libm::erfc(-z * FRAC_1_SQRT_2)
}

fn bell(z: f64) -> f64 {
    const SCALE: f64 = 0.398_942_280_401_432_7;
    SCALE * (-0.5 * z * z).exp()
}
