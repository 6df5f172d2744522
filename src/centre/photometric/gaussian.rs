//! Stamps of a Gaussian blur, integrated over the pixels: separable, so a stamp is a column times a row.

use super::boundary::Node;
use super::coverage::{LANES, Place, Target};
use super::normal::density_and_cumulative;

/// The kernel is zero beyond this many standard deviations: 1e-5 of it is cut off.
const REACH: f32 = 4.4;
/// Distance of nodes in standard deviations: the trapezoidal rule is then right within 2 exp(-2 pi^2 / 1.3^2) = 2e-5.
const SPACING: f64 = 1.3;
/// Blur below this is taken as this, pixels of the grid: the pixel's own box hides it.
const LEAST_SIGMA: f64 = 0.03;

/// How close the nodes of an outline must be, pixels of the grid.
pub(super) fn spacing(sigma: f64) -> f64 {
    SPACING * sigma.max(LEAST_SIGMA)
}

/// Room for one node's row and column.
#[derive(Debug, Clone, Default)]
pub(super) struct Room {
    across: Axis,
    down: Axis,
}

/// The kernel along one axis, pixel by pixel.
#[derive(Debug, Clone, Default)]
struct Axis {
    /// Normal density at the left edge of each pixel (and the last one's right edge).
    density: Vec<f32>,
    /// Normal distribution there.
    cumulative: Vec<f32>,
    /// Share of the kernel in each pixel.
    share: Vec<f32>,
    /// Change of the share by the standard deviation.
    share_by_sigma: Vec<f32>,
    /// Share of all up to a pixel, averaged over it.
    sum: Vec<f32>,
    /// Change of the sum by the standard deviation.
    sum_by_sigma: Vec<f32>,
}

impl Axis {
    #[inline(always)]
    fn fill(&mut self, first: usize, count: usize, centre: f32, sigma: f32) {
        let scale = 1.0 / sigma;
        let begin = (first as f32 - 0.5 - centre) * scale;
        let padded = (count + 1).next_multiple_of(LANES);
        self.density.resize(padded, 0.0);
        self.cumulative.resize(padded, 0.0);
        let edges = self.density.iter_mut().zip(&mut self.cumulative);
        for (i, (density, cumulative)) in edges.enumerate() {
            (*density, *cumulative) = density_and_cumulative(begin + i as f32 * scale);
        }
        for v in [
            &mut self.share,
            &mut self.share_by_sigma,
            &mut self.sum,
            &mut self.sum_by_sigma,
        ] {
            v.resize(count, 0.0);
        }
        let (d0, d1) = (&self.density[..count], &self.density[1..count + 1]);
        let (c0, c1) = (&self.cumulative[..count], &self.cumulative[1..count + 1]);
        let (share, share_by_sigma) = (&mut self.share[..count], &mut self.share_by_sigma[..count]);
        let (sum, sum_by_sigma) = (&mut self.sum[..count], &mut self.sum_by_sigma[..count]);
        for i in 0..count {
            let u = begin + i as f32 * scale;
            let (bend, step) = (d1[i] - d0[i], c1[i] - c0[i]);
            share[i] = step;
            share_by_sigma[i] = scale * (u * d0[i] - (u + scale) * d1[i]);
            sum_by_sigma[i] = bend;
            sum[i] = sigma * (u * step + bend) + c1[i];
        }
    }
}

/// Lays the stamps of an outline; `sigma` in pixels of the grid.
#[inline(always)]
pub(super) fn stamp(target: &mut Target, nodes: &[Node], sigma: f64, room: &mut Room) {
    let sigma = sigma.max(LEAST_SIGMA) as f32;
    let reach = REACH * sigma + 0.5;
    let Room { across, down } = room;
    for node in nodes {
        let Some(reached) = target.reached(node, reach) else {
            continue;
        };
        across.fill(reached.first, reached.padded, node.x, sigma);
        let rows = reached.past_row - reached.first_row;
        down.fill(reached.first_row, rows, node.y, sigma);
        for i in 0..rows {
            let at = Place {
                row: reached.first_row + i,
                column: reached.first,
            };
            let share = down.share[i];
            target.add_value(at, node.rise * share, &across.sum, 1.0);
            if let Some(contrast) = target.contrast {
                target.add_sweep(at, contrast * share, &node.sweep, &across.share);
                let factor = contrast * node.rise;
                let slope = factor * down.share_by_sigma[i];
                target.add_blur(at, slope, &across.sum, 1.0);
                target.add_blur(at, factor * share, &across.sum_by_sigma, 0.0);
            }
        }
    }
}
