//! Stamps of a Gaussian blur, integrated over the pixels: separable, so a stamp is a column times a row.

use super::boundary::Node;
use super::coverage::{LANES, Lanes};
use super::normal::density_and_cumulative;
use super::stamps::{Kernel, Stamp, touched};
use super::window::Grid;

/// The kernel is zero beyond this many standard deviations: 1e-5 of it is cut off.
const REACH: f32 = 4.4;
/// Distance of nodes in standard deviations: the trapezoidal rule is then right within 2 exp(-2 pi^2 / 1.3^2) = 2e-5.
pub(super) const SPACING: f64 = 1.3;
/// Blur below this is taken as this, pixels of the grid: the pixel's own box hides it. A pixel on a perfectly sharp edge is wrong by
/// at most 0.006 of the contrast then, a centre by 1e-4 px.
pub(super) const LEAST_SIGMA: f64 = 0.03;

/// The stamps of the nodes of one outline: of each its row and its column.
#[derive(Debug, Clone, Default)]
pub(super) struct Gaussian {
    across: Vec<Across>,
    /// Where each node's vectors begin in `across`.
    begins: Vec<usize>,
    /// Share of the kernel in each row and its change by sigma, node after node.
    down: Vec<[f32; 2]>,
    stamps: Vec<Stamp>,
}

/// The kernel across a vector of pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Across {
    /// Share of all up to a pixel, averaged over it.
    sum: Lanes,
    /// Share of the kernel in each pixel.
    share: Lanes,
    /// Change of the sum by the standard deviation.
    sum_by_sigma: Lanes,
}

impl Gaussian {
    #[inline(always)]
    fn down_of(&mut self, y: f32, (first, past): (usize, usize), scale: f32) {
        let mut at = first;
        while at < past {
            let begin = (at as f32 - 0.5 - y) * scale;
            let (density, cumulative) = edges(begin, scale);
            let (next_density, next_cumulative) = edges(begin + scale, scale);
            let mut shares = [[0.0; 2]; LANES];
            for l in 0..LANES {
                let u = begin + l as f32 * scale;
                shares[l] = [
                    next_cumulative[l] - cumulative[l],
                    scale * (u * density[l] - (u + scale) * next_density[l]),
                ];
            }
            self.down.extend_from_slice(&shares[..LANES.min(past - at)]);
            at += LANES;
        }
    }
}

/// Normal density and distribution at `LANES` places from `begin` on.
#[inline(always)]
fn edges(begin: f32, scale: f32) -> (Lanes, Lanes) {
    let (mut density, mut cumulative) = ([0.0; LANES], [0.0; LANES]);
    for l in 0..LANES {
        (density[l], cumulative[l]) = density_and_cumulative(begin + l as f32 * scale);
    }
    (density, cumulative)
}

impl Across {
    /// From density and distribution at the left edges of a vector of pixels and at the right ones.
    #[inline(always)]
    fn new(begin: f32, scale: f32, sigma: f32, [left, right]: [(Lanes, Lanes); 2]) -> Self {
        let ((d0, c0), (d1, c1)) = (left, right);
        let mut across = Self {
            sum: [0.0; LANES],
            share: [0.0; LANES],
            sum_by_sigma: [0.0; LANES],
        };
        for l in 0..LANES {
            let u = begin + l as f32 * scale;
            let (bend, step) = (d1[l] - d0[l], c1[l] - c0[l]);
            across.share[l] = step;
            across.sum_by_sigma[l] = bend;
            across.sum[l] = sigma * (u * step + bend) + c1[l];
        }
        across
    }
}

/// What follows one place after the values of a vector: all but its first, and the first of the next vector.
#[inline(always)]
fn shifted(values: &Lanes, next: &Lanes) -> Lanes {
    std::array::from_fn(|l| {
        if l + 1 < LANES {
            values[l + 1]
        } else {
            next[0]
        }
    })
}

impl Kernel for Gaussian {
    /// Share of the kernel in the row, and its change by sigma.
    type Row = [f32; 2];
    type Part = Across;

    fn spacing(sigma: f64) -> f64 {
        SPACING * sigma.max(LEAST_SIGMA)
    }

    #[inline(always)]
    fn prepare(&mut self, grid: &Grid, nodes: &[Node], sigma: f64) {
        let sigma = sigma.max(LEAST_SIGMA) as f32;
        let scale = 1.0 / sigma;
        let reach = REACH * sigma + 0.5;
        self.across.clear();
        self.begins.clear();
        self.down.clear();
        self.stamps.clear();
        for node in nodes {
            let stamp = touched(node, reach, grid, self.down.len());
            self.stamps.push(stamp);
            self.begins.push(self.across.len());
            if stamp.rows.0 == stamp.rows.1 {
                continue;
            }
            self.down_of(node.y, stamp.rows, scale);
            let begin = |vector: usize| ((vector * LANES) as f32 - 0.5 - node.x) * scale;
            // the right edges of pixels are the left ones of the next
            let mut left = edges(begin(stamp.vectors.0), scale);
            for vector in stamp.vectors.0..stamp.vectors.1 {
                let next = edges(begin(vector + 1), scale);
                let right = (shifted(&left.0, &next.0), shifted(&left.1, &next.1));
                let across = Across::new(begin(vector), scale, sigma, [left, right]);
                self.across.push(across);
                left = next;
            }
        }
    }

    #[inline(always)]
    fn stamps(&self) -> &[Stamp] {
        &self.stamps
    }

    #[inline(always)]
    fn row(&self, at: usize) -> Self::Row {
        self.down[at]
    }

    #[inline(always)]
    fn part(&self, node: &Node, j: usize, vector: usize) -> Across {
        let across = &self.across[self.begins[j] + vector - self.stamps[j].vectors.0];
        Across {
            sum: across.sum.map(|sum| node.rise * sum),
            share: across.share,
            sum_by_sigma: across.sum_by_sigma.map(|slope| node.rise * slope),
        }
    }

    #[inline(always)]
    fn sum(&self, row: &Self::Row, part: &Across) -> Lanes {
        part.sum.map(|sum| row[0] * sum)
    }

    #[inline(always)]
    fn all(&self, row: &Self::Row, part: &Across) -> [Lanes; 3] {
        let [share, change] = *row;
        let (mut sum, mut pixel, mut by_sigma) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for l in 0..LANES {
            sum[l] = share * part.sum[l];
            pixel[l] = share * part.share[l];
            by_sigma[l] = share * part.sum_by_sigma[l] + change * part.sum[l];
        }
        [sum, pixel, by_sigma]
    }

    #[inline(always)]
    fn beyond(&self, row: &Self::Row) -> [f32; 2] {
        *row
    }
}
