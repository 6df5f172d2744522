//! Stamps of a disc of even light (pillbox), as a round aperture makes, integrated over the pixels.
//!
//! At height y the disc is a chord of half-width s = sqrt(c^2 - y^2). Summed up from the left it is a ramp from -s to s, which the
//! pixel's width rounds off at both corners; over the pixel's height it is averaged by Gauss-Legendre, on the part of
//! the height that the disc reaches.

use super::boundary::Node;
use super::coverage::{LANES, Place, Target};

/// A disc smaller than this (pixels of the grid) is taken as one of this radius: the pixel's own box hides it.
const LEAST_RADIUS: f64 = 0.1;
/// Distance of nodes in pixels of the grid, from small discs to large ones, and the radius from which one is large.
const SPACING: (f64, f64) = (0.2, 0.8);
const LARGE: f64 = 4.0;
/// Gauss-Legendre on [-1, 1]: places and weights over two.
const HEIGHTS: [(f32, f32); 3] = [
    (-0.774_596_7, 5.0 / 18.0),
    (0.0, 8.0 / 18.0),
    (0.774_596_7, 5.0 / 18.0),
];

/// How close the nodes of an outline must be, pixels of the grid.
pub(super) fn spacing(radius: f64) -> f64 {
    SPACING.0 + (SPACING.1 - SPACING.0) * (radius / LARGE).min(1.0)
}

/// Room for one row of a stamp.
#[derive(Debug, Clone, Default)]
pub(super) struct Room {
    kernel: Vec<f32>,
    sum: Vec<f32>,
    sum_by_radius: Vec<f32>,
}

/// Lays the stamps of an outline; `radius` in pixels of the grid.
#[inline(always)]
pub(super) fn stamp(target: &mut Target, nodes: &[Node], radius: f64, room: &mut Room) {
    let radius = radius.max(LEAST_RADIUS) as f32;
    let reach = radius + 0.5;
    for node in nodes {
        let Some(reached) = target.reached(node, reach) else {
            continue;
        };
        for row in reached.first_row..reached.past_row {
            let at = Place {
                row,
                column: reached.first,
            };
            let (z, y) = (reached.first as f32 - node.x, row as f32 - node.y);
            let heights = heights(y, radius);
            let (total, by_radius) = room.fill(z, reached.padded, &heights, radius);
            target.add_value(at, node.rise, &room.sum, total);
            if let Some(contrast) = target.contrast {
                target.add_sweep(at, contrast, &node.sweep, &room.kernel);
                let factor = contrast * node.rise;
                target.add_blur(at, factor, &room.sum_by_radius, by_radius);
            }
        }
    }
}

/// A chord of the disc: half its width, and its share of the pixel's height over the disc's area.
type Chord = (f32, f32);

/// The chords that stand for a pixel's height about `y` from the disc's middle.
#[inline(always)]
fn heights(y: f32, radius: f32) -> [Chord; 3] {
    let (first, last) = ((y - 0.5).max(-radius), (y + 0.5).min(radius));
    let (middle, half) = (0.5 * (first + last), (0.5 * (last - first)).max(0.0));
    let scale = 2.0 * half / (std::f32::consts::PI * radius * radius);
    HEIGHTS.map(|(place, weight)| {
        let v = middle + half * place;
        ((radius * radius - v * v).max(0.0).sqrt(), weight * scale)
    })
}

impl Room {
    /// One row of the stamp, its first pixel `z` from the disc's middle. Returns what all pixels beyond get: of the sum, and of
    /// its change by the radius.
    #[inline(always)]
    fn fill(&mut self, z: f32, count: usize, chords: &[Chord; 3], radius: f32) -> (f32, f32) {
        self.kernel.clear();
        self.kernel.resize(count, 0.0);
        self.sum.clear();
        self.sum.resize(count, 0.0);
        self.sum_by_radius.clear();
        self.sum_by_radius.resize(count, 0.0);
        let (mut total, mut slope_total) = (0.0, 0.0);
        for &(half_width, weight) in chords {
            let growth = weight * radius / half_width.max(1e-3 * radius);
            total += 2.0 * weight * half_width;
            slope_total += 2.0 * growth;
            let rows = self
                .kernel
                .chunks_exact_mut(LANES)
                .zip(self.sum.chunks_exact_mut(LANES))
                .zip(self.sum_by_radius.chunks_exact_mut(LANES));
            for (chunk, ((kernel, sum), slope)) in rows.enumerate() {
                for i in 0..LANES {
                    let at = z + (chunk * LANES + i) as f32;
                    let (enters, enter_slope) = ramp(at + half_width);
                    let (leaves, leave_slope) = ramp(at - half_width);
                    sum[i] += weight * (enters - leaves);
                    kernel[i] += weight * (enter_slope - leave_slope);
                    slope[i] += growth * (enter_slope + leave_slope);
                }
            }
        }
        // the disc's area is in the weights: its change by the radius
        let shrink = 2.0 / radius;
        for (slope, sum) in self.sum_by_radius.iter_mut().zip(&self.sum) {
            *slope -= shrink * sum;
        }
        (total, slope_total - shrink * total)
    }
}

/// max(z, 0) averaged over a pixel, and its slope.
#[inline(always)]
fn ramp(z: f32) -> (f32, f32) {
    let inside = z + 0.5;
    let slope = inside.clamp(0.0, 1.0);
    (0.5 * slope * slope + (inside - 1.0).max(0.0), slope)
}
