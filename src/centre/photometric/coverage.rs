//! How much of each pixel's light comes from inside a curve, after blur and pixel integration, and the derivatives.
//!
//! The blurred indicator of a region is an integral over its horizontal chords [l(v), r(v)]. For a Gaussian it is
//! separable: `B(x, y) = integral dv G(y - v) (F(x - l(v)) - F(x - r(v)))`, G the pixel-integrated normal density and F the
//! pixel-integrated normal distribution. With nodes v_j this is a product of two small matrices. The nodes are
//! Chebyshev's: chords shrink like a square root at top and bottom, and there the rule is as exact as elsewhere.

use super::shape::{SHAPE_PARAMETERS, Shape};
use super::window::Grid;

/// Nodes for each blur sigma of height, and the fewest.
const NODES_PER_SIGMA: f64 = 2.6;
const LEAST_NODES: usize = 14;
/// Blur below this is taken as this, px of the window: the pixel's own box rules there.
pub(super) const LEAST_SIGMA: f64 = 0.2;
/// Kernels are zero beyond this many sigmas.
const REACH: f64 = 6.0;

/// Derivatives of a coverage: with respect to the shape's parameters, then the blur.
pub(super) const COVERAGE_PARAMETERS: usize = SHAPE_PARAMETERS + 1;

/// Coverage of every pixel of a window and its derivatives, each a plane of the window.
#[derive(Debug, Clone, Default)]
pub(super) struct Coverage {
    pub(super) values: Vec<f64>,
    pub(super) derivatives: [Vec<f64>; COVERAGE_PARAMETERS],
}

impl Coverage {
    /// Coverage by the circle of `radius` (in outer radii) of `shape` under a Gaussian blur; `None` where the shape is
    /// no ellipse.
    pub(super) fn gaussian(grid: &Grid, shape: &Shape, radius: f64, sigma_px: f64) -> Option<Self> {
        let sigma = sigma_px.max(LEAST_SIGMA * grid.pixel_px);
        let (top, bottom) = shape.rows(radius)?;
        let (middle, half) = (0.5 * (top + bottom), 0.5 * (bottom - top));
        let wide = sigma.max(0.3 * grid.pixel_px);
        let count = ((NODES_PER_SIGMA * half / wide) as usize + LEAST_NODES).min(4000);
        let size = grid.width * grid.height;
        let mut out = Self {
            values: vec![0.0; size],
            derivatives: std::array::from_fn(|_| vec![0.0; size]),
        };
        let mut line = Line::new(grid.width);
        for j in 0..count {
            let t = std::f64::consts::PI * (j as f64 + 0.5) / count as f64;
            let y = middle - half * t.cos();
            let weight = half * t.sin() * std::f64::consts::PI / count as f64;
            if let Some(chord) = shape.chord(radius, y) {
                line.fill(grid, &chord.ends, &chord.derivatives, sigma);
                out.add(grid, &line, y, weight, sigma);
            }
        }
        Some(out)
    }

    /// Spreads the line at height `y` over the rows its kernel reaches.
    fn add(&mut self, grid: &Grid, line: &Line, y: f64, weight: f64, sigma: f64) {
        let reach = REACH * sigma + 0.5 * grid.pixel_px;
        for row in grid.rows_within(y - reach, y + reach) {
            let (g, slope) = density(grid.y(row) - y, grid.pixel_px, sigma);
            let (g, slope) = (weight * g, weight * slope);
            let at = row * grid.width;
            axpy(&mut self.values[at..at + grid.width], g, &line.values);
            for (plane, values) in self.derivatives[..SHAPE_PARAMETERS]
                .iter_mut()
                .zip(&line.derivatives)
            {
                axpy(&mut plane[at..at + grid.width], g, values);
            }
            let blur = &mut self.derivatives[SHAPE_PARAMETERS][at..at + grid.width];
            axpy(blur, slope, &line.values);
            axpy(blur, g, &line.blur);
        }
    }
}

fn axpy(out: &mut [f64], factor: f64, values: &[f64]) {
    for (o, v) in out.iter_mut().zip(values) {
        *o += factor * v;
    }
}

/// One chord blurred along the row.
struct Line {
    values: Vec<f64>,
    derivatives: [Vec<f64>; SHAPE_PARAMETERS],
    blur: Vec<f64>,
}

impl Line {
    fn new(width: usize) -> Self {
        Self {
            values: vec![0.0; width],
            derivatives: std::array::from_fn(|_| vec![0.0; width]),
            blur: vec![0.0; width],
        }
    }

    fn fill(
        &mut self,
        grid: &Grid,
        ends: &[f64; 2],
        moves: &[[f64; SHAPE_PARAMETERS]; 2],
        sigma: f64,
    ) {
        for column in 0..grid.width {
            let x = grid.x(column);
            let left = distribution(x - ends[0], grid.pixel_px, sigma);
            let right = distribution(x - ends[1], grid.pixel_px, sigma);
            self.values[column] = left.value - right.value;
            self.blur[column] = left.blur - right.blur;
            for (k, derivative) in self.derivatives.iter_mut().enumerate() {
                derivative[column] = right.slope * moves[1][k] - left.slope * moves[0][k];
            }
        }
    }
}

/// The normal distribution averaged over a pixel, its derivatives by place and by sigma.
struct Averaged {
    value: f64,
    slope: f64,
    blur: f64,
}

fn distribution(z: f64, pixel: f64, sigma: f64) -> Averaged {
    let (a, b) = (z + 0.5 * pixel, z - 0.5 * pixel);
    let reach = REACH * sigma;
    if b > reach {
        return Averaged {
            value: 1.0,
            slope: 0.0,
            blur: 0.0,
        };
    }
    if a < -reach {
        return Averaged {
            value: 0.0,
            slope: 0.0,
            blur: 0.0,
        };
    }
    let (pa, pb) = (cumulative(a / sigma), cumulative(b / sigma));
    let (da, db) = (bell(a / sigma), bell(b / sigma));
    Averaged {
        value: (a * pa - b * pb + sigma * (da - db)) / pixel,
        slope: (pa - pb) / pixel,
        blur: (da - db) / pixel,
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
    0.5 * libm::erfc(-z * std::f64::consts::FRAC_1_SQRT_2)
}

fn bell(z: f64) -> f64 {
    const SCALE: f64 = 0.398_942_280_401_432_7;
    SCALE * (-0.5 * z * z).exp()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::centre::photometric::shape::Shape;

    const SHAPE: [f64; SHAPE_PARAMETERS] = [31.2, 28.9, 0.0031, 0.0004, 0.0042, 0.002, -0.0015];

    fn grid() -> Grid {
        Grid {
            left_px: 0.0,
            top_px: 0.0,
            pixel_px: 1.0,
            width: 64,
            height: 60,
        }
    }

    fn coverage(p: &[f64; SHAPE_PARAMETERS], sigma: f64) -> Coverage {
        Coverage::gaussian(&grid(), &Shape::from_parameters(p), 1.0, sigma).unwrap()
    }

    #[test]
    fn the_sum_is_the_ellipse_s_area_and_the_first_moment_its_centre() {
        let ellipse = Shape::from_parameters(&SHAPE).ellipse(1.0).unwrap();
        let area = std::f64::consts::PI * ellipse.major * ellipse.minor;
        for sigma in [0.0, 0.5, 1.5, 3.0] {
            let c = coverage(&SHAPE, sigma);
            let sum: f64 = c.values.iter().sum();
            let x: f64 = c
                .values
                .iter()
                .enumerate()
                .map(|(i, v)| (i % 64) as f64 * v)
                .sum();
            let tolerance = if sigma < 0.5 { 3e-3 } else { 1e-6 };
            assert!(
                (sum / area - 1.0).abs() < tolerance,
                "{sigma}: {}",
                sum / area - 1.0
            );
            assert!(
                (x / sum - ellipse.centre.x).abs() < 30.0 * tolerance,
                "{sigma}"
            );
        }
    }

    #[test]
    fn derivatives_agree_with_finite_differences() {
        for sigma in [0.8, 2.5] {
            let c = coverage(&SHAPE, sigma);
            for k in 0..COVERAGE_PARAMETERS {
                let h = 1e-5
                    * if k < SHAPE_PARAMETERS {
                        SHAPE[k].abs()
                    } else {
                        sigma
                    };
                let moved = |sign: f64| {
                    let mut p = SHAPE;
                    let mut s = sigma;
                    if k < SHAPE_PARAMETERS {
                        p[k] += sign * h
                    } else {
                        s += sign * h
                    }
                    coverage(&p, s).values
                };
                let (up, down) = (moved(1.0), moved(-1.0));
                let largest = c.derivatives[k].iter().fold(0.0_f64, |m, v| m.max(v.abs()));
                for i in 0..up.len() {
                    let slope = (up[i] - down[i]) / (2.0 * h);
                    let error = (slope - c.derivatives[k][i]).abs();
                    assert!(
                        error < 1e-4 * largest,
                        "{sigma} {k} {i}: {slope} {}",
                        c.derivatives[k][i]
                    );
                }
            }
        }
    }
}
