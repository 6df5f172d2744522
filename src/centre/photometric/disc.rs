//! Coverage under a disc of even light (pillbox), as a round aperture makes.
//!
//! At height y the disc's chord at height v of the outline has half-width s = sqrt(c^2 - (y - v)^2). The end l of an outline's
//! chord gives a pixel at x the overlap of [l, infinity) with [x - s, x + s], which is a ramp in x with two corners; the
//! mean over the pixel's width rounds them off to parabolas. So
//! `B(x, y) = 1 / (pi c^2) integral dv (L(x; l(v), s) - L(x; r(v), s))`, L the rounded ramp; what is left is the integral over v and the mean over the
//! pixel's height:
//!
//! - v runs where both chords are: each ends like a square root, for which Chebyshev's nodes are made.
//! - y is split where the disc begins or ceases to touch the outline's top or bottom from outside or inside: there the coverage is not smooth.
//!   Between, Gauss-Legendre.

use super::coverage::{BLUR, Coverage, Row, VALUE, add_moments};
use super::outline::{End, Outline};
use super::window::Grid;
use std::f64::consts::PI;

/// From this radius down (px of the window) the disc shrinks no more: the pixel's own box rules there.
const LEAST_RADIUS: f64 = 0.25;
/// Nodes over the height of the disc, for each pixel of its radius, and bounds.
const NODES_PER_PIXEL: f64 = 5.0;
const NODES: (f64, f64) = (10.0, 48.0);
/// A Gauss-Legendre rule spans at most this much height, in radii of the disc.
const PANEL: f64 = 0.75;
/// Gauss-Legendre on [-1, 1], three nodes: places and weights over two.
const GAUSS_LEGENDRE: [(f64, f64); 3] = [
    (-0.774_596_669_241_483_4, 5.0 / 18.0),
    (0.0, 8.0 / 18.0),
    (0.774_596_669_241_483_4, 5.0 / 18.0),
];

/// Adds the coverage of a window by an outline, blurred by a disc.
pub(super) fn cover<const N: usize>(
    out: &mut Coverage<N>,
    grid: &Grid,
    outline: &Outline,
    radius_px: f64,
) {
    let (radius, growth) = effective_radius(radius_px, LEAST_RADIUS * grid.pixel_px);
    let disc = Disc::new(grid, radius);
    let (top, bottom) = outline.rows();
    let breaks = [top - radius, top + radius, bottom - radius, bottom + radius];
    let half = 0.5 * grid.pixel_px;
    for index in grid.rows_within(top - radius - half, bottom + radius + half) {
        let y = grid.y(index);
        let mut row = out.row(index);
        for_each_height((y - half, y + half), &breaks, radius, |y, share| {
            disc.add(&mut row, grid, outline, y, share);
        });
    }
    out.sum_steps();
    if N > 1 {
        // B = A / (pi c^2): the derivative of A is there, that of the divisor is not
        for cell in out.cells_mut() {
            cell[BLUR] = growth * (cell[BLUR] - 2.0 / radius * cell[VALUE]);
        }
    }
}

/// The radius to compute with, and its derivative: the radius itself from twice the least on, below it a parabola that meets it
/// smoothly. The derivative is kept from vanishing, or a sharp ring would leave the normal equations singular.
fn effective_radius(radius: f64, least: f64) -> (f64, f64) {
    if radius >= 2.0 * least {
        (radius, 1.0)
    } else {
        let part = radius.max(0.0) / (2.0 * least);
        (least * (1.0 + part * part), part.max(1e-2))
    }
}

/// Calls `visit` with heights in a span and their shares of its mean.
fn for_each_height(
    (first, last): (f64, f64),
    breaks: &[f64; 4],
    radius: f64,
    mut visit: impl FnMut(f64, f64),
) {
    let mut cuts = [first, first, first, first, first, last];
    for (cut, at) in cuts[1..5].iter_mut().zip(breaks) {
        *cut = at.clamp(first, last);
    }
    cuts.sort_unstable_by(f64::total_cmp);
    for pair in cuts.windows(2) {
        let length = pair[1] - pair[0];
        if length <= 1e-9 * radius {
            continue;
        }
        let panels = (length / (PANEL * radius)).ceil().max(1.0);
        let half = 0.5 * length / panels;
        for panel in 0..panels as usize {
            let middle = pair[0] + half * (2.0 * panel as f64 + 1.0);
            for (place, weight) in GAUSS_LEGENDRE {
                visit(middle + half * place, 2.0 * half * weight / (last - first));
            }
        }
    }
}

/// A disc and its quadrature.
struct Disc {
    radius: f64,
    /// cos and sin of the Chebyshev angles.
    nodes: Vec<(f64, f64)>,
}

impl Disc {
    fn new(grid: &Grid, radius: f64) -> Self {
        let count = (NODES_PER_PIXEL * radius / grid.pixel_px).clamp(NODES.0, NODES.1) as usize;
        let angle = |j: usize| PI * (j as f64 + 0.5) / count as f64;
        Self {
            radius,
            nodes: (0..count)
                .map(|j| (angle(j).cos(), angle(j).sin()))
                .collect(),
        }
    }

    /// Adds `share` of what a disc at height `y` sees to a row.
    fn add<const N: usize>(
        &self,
        row: &mut Row<'_, N>,
        grid: &Grid,
        outline: &Outline,
        y: f64,
        share: f64,
    ) {
        let (top, bottom) = outline.rows();
        let (first, last) = (top.max(y - self.radius), bottom.min(y + self.radius));
        let (middle, half) = (0.5 * (first + last), 0.5 * (last - first));
        if half <= 0.0 {
            return;
        }
        // pi c^2 normalises the disc, pi / n is the step between the angles
        let scale = share * half / (self.radius * self.radius * self.nodes.len() as f64);
        for (cos, sin) in &self.nodes {
            let v = middle - half * cos;
            let square = self.radius * self.radius - (y - v) * (y - v);
            let (true, Some(ends)) = (square > 0.0, outline.chord(v)) else {
                continue;
            };
            let span = Span {
                half_width: square.sqrt(),
                weight: scale * sin,
                growth: self.radius / square.sqrt(),
            };
            span.add(row, grid, &ends[0], 1.0);
            span.add(row, grid, &ends[1], -1.0);
        }
    }
}

/// A chord of the disc.
struct Span {
    half_width: f64,
    weight: f64,
    /// Derivative of the half-width by the radius.
    growth: f64,
}

impl Span {
    /// Adds what the end of a chord of the outline does to a row: overlap on its right, none on its left.
    fn add<const N: usize>(&self, row: &mut Row<'_, N>, grid: &Grid, end: &End, sign: f64) {
        let pixel = grid.pixel_px;
        let reach = self.half_width + 0.5 * pixel;
        let columns = grid.columns_within(end.x - reach, end.x + reach);
        let signed = sign * self.weight;
        let past = columns.end;
        let mut z = grid.x(columns.start) - end.x;
        for cell in &mut row.cells[columns] {
            let enters = Ramp::at(z + self.half_width, pixel);
            let leaves = Ramp::at(z - self.half_width, pixel);
            cell[VALUE] += signed * (enters.value - leaves.value);
            if N > 1 {
                cell[BLUR] += signed * self.growth * (enters.slope + leaves.slope);
                let share = self.weight * (enters.slope - leaves.slope);
                add_moments(cell, share, &end.moments);
            }
            z += pixel;
        }
        row.steps[past][0] += signed * 2.0 * self.half_width;
        row.steps[past][1] += signed * 2.0 * self.growth;
    }
}

/// max(z, 0) averaged over a pixel, and its slope.
struct Ramp {
    value: f64,
    slope: f64,
}

impl Ramp {
    fn at(z: f64, pixel: f64) -> Self {
        let inside = z / pixel + 0.5;
        let slope = inside.clamp(0.0, 1.0);
        // beyond the pixel the ramp is z itself
        let beyond = if inside > 1.0 { inside - 1.0 } else { 0.0 };
        Self {
            value: pixel * (0.5 * slope * slope + beyond),
            slope,
        }
    }
}
