//! A piece of outline out of focus by a Gaussian: closed form, separable.
//!
//! A point of the outline lands at `place - size a`, a normal with unit covariance (a place in the aperture). Each a sees
//! its own sharp outline, whose pieces rise by `rise - growth a_y`; the picture is the mean over a.

use super::field::Band;
use super::outline::Node;

/// Where a Gaussian is cut off; 2e-9 of it lie beyond.
const CUT_SIGMAS: f64 = 6.0;

/// Weights along the row, kept to spare allocations.
#[derive(Debug, Default)]
pub(super) struct Kernel {
    columns: Vec<f64>,
}

impl Kernel {
    /// Adds one piece to a band.
    pub(super) fn add(&mut self, band: &mut Band, node: &Node) {
        let sigma = node.size;
        let rows = band.rows_near(node.place.y, CUT_SIGMAS * sigma + 0.5);
        if rows.is_empty() {
            return;
        }
        let Some(start) = self.weigh_columns(node.place.x, sigma, band.width) else {
            return;
        };
        let y = node.place.y - band.first_row as f64;
        for row in rows {
            let (high, low) = (
                (row as f64 + 0.5 - y) / sigma,
                (row as f64 - 0.5 - y) / sigma,
            );
            let share = node.rise * (below(high) - below(low))
                - node.growth * (density(high) - density(low));
            let line = &mut band.first_differences(row)[start..start + self.columns.len()];
            for (pixel, weight) in line.iter_mut().zip(&self.columns) {
                *pixel -= share * weight;
            }
        }
    }

    /// First differences along a row of the blurred, pixel-integrated step at x, and the column they begin at;
    /// `None` where the step lies right of the picture. What lies left of it is added to its first column.
    fn weigh_columns(&mut self, x: f64, sigma: f64, width: usize) -> Option<usize> {
        let reach = CUT_SIGMAS * sigma + 0.5;
        let first = (x - reach).floor().max(0.0);
        if first >= width as f64 {
            return None;
        }
        let last = ((x + reach).ceil() + 1.0).clamp(first, width as f64 - 1.0);
        self.columns.clear();
        // integral of the step over pixels up to the right border of column k
        let up_to = |k: f64| sigma * integral_below((k + 0.5 - x) / sigma);
        let mut area = up_to(first) - up_to(first - 1.0);
        self.columns.push(area);
        let mut before = up_to(first);
        for k in first as usize + 1..=last as usize {
            let here = up_to(k as f64);
            self.columns.push(here - before - area);
            area = here - before;
            before = here;
        }
        Some(first as usize)
    }
}

/// Density of the normal distribution.
fn density(z: f64) -> f64 {
    const FACTOR: f64 = 0.398_942_280_401_432_7;
    FACTOR * (-0.5 * z * z).exp()
}

/// Share of the normal distribution below z.
fn below(z: f64) -> f64 {
    0.5 * libm::erfc(-z * std::f64::consts::FRAC_1_SQRT_2)
}

/// Integral of [`below`] from minus infinity.
fn integral_below(z: f64) -> f64 {
    if z < -CUT_SIGMAS {
        0.0
    } else if z > CUT_SIGMAS {
        z
    } else {
        z * below(z) + density(z)
    }
}
