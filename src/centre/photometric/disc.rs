//! Stamps of a disc of even light (pillbox), as a round aperture makes, integrated over the pixels.
//!
//! At height y the disc is a chord of half-width s = sqrt(c^2 - y^2). Summed up from the left it is a ramp from -s to s, which the
//! pixel's width rounds off at both corners. Over the pixel's height it is averaged by three chords: Gauss-Legendre, where the disc's rim
//! lies in the pixel in the square root of the distance from it, because chords begin like one; Gauss-Chebyshev where the
//! whole disc lies in it.
//!
//! A rounded ramp changes its slope in three pixels and is straight again. So of each end of a chord only the moments of where in a
//! pixel it lies are laid, in that one pixel. Second differences of the sum follow from them, and first differences of what goes
//! with its slope; sums along the rows, once for all nodes, make pictures of these.

use super::boundary::Node;
use super::coverage::{COVERAGE_PARAMETERS, Lanes, Plane};
use super::shape::SHAPE_PARAMETERS;
use super::window::Grid;
use std::f32::consts::{FRAC_1_SQRT_2, FRAC_PI_4};

/// Distance of nodes in pixels of the grid: so much, and so much more for each pixel of the radius; and at most. A pixel is then wrong by
/// 1e-3 of the contrast at most and 2e-4 usually, a centre by less than 1e-4 px.
const SPACING: (f64, f64, f64) = (0.06, 0.1, 0.4);
/// Gauss-Legendre on [-1, 1]: places and weights over two. (A fourth that weighs nothing fills a vector.)
const HEIGHTS: [(f32, f32); 4] = [
    (-0.774_596_7, 5.0 / 18.0),
    (0.0, 8.0 / 18.0),
    (0.774_596_7, 5.0 / 18.0),
    (0.0, 0.0),
];
/// Gauss-Chebyshev of the second kind: places and weights for chords.
const WHOLE: [(f32, f32); 4] = [
    (-FRAC_1_SQRT_2, FRAC_PI_4 * FRAC_1_SQRT_2),
    (0.0, FRAC_PI_4),
    (FRAC_1_SQRT_2, FRAC_PI_4 * FRAC_1_SQRT_2),
    (0.0, 0.0),
];

/// A disc over a window.
#[derive(Debug, Clone, Default)]
pub(super) struct Disc {
    radius: f32,
    /// Moments of the chords' ends in each pixel: 0, 1 and 2, for the sums.
    bends: Vec<[f32; 4]>,
    /// Moments 1 and 0 for the changes by the shape's parameters, then for the part by the radius.
    steps: Vec<[Lanes; 2]>,
}

/// Chords that stand for a pixel's height: half their widths, and their shares of the height over the disc's area.
#[derive(Clone, Copy)]
struct Chords {
    half_widths: [f32; 4],
    shares: [f32; 4],
    /// Changes of the half widths by the radius.
    growths: [f32; 4],
}

/// So many of them.
const CHORDS: usize = 3;
/// A column before the window for what begins there, and columns behind it for what lies there.
const BEFORE: usize = 1;
const MARGIN: usize = 3;

impl Disc {
    /// How close the nodes of an outline must be for a disc of this radius, both in pixels of the grid.
    pub(super) fn spacing(radius: f64) -> f64 {
        let (least, by_radius, most) = SPACING;
        (least + by_radius * radius).min(most)
    }

    /// Adds the coverage by the outline of these nodes to the first of the planes and, with a contrast, its changes to the others.
    #[inline(always)]
    pub(super) fn cover(
        &mut self,
        (grid, nodes, radius): (&Grid, &[Node], f64),
        (values, changes): (&mut Plane, &mut [Plane; COVERAGE_PARAMETERS]),
        contrast: Option<f32>,
    ) {
        self.radius = radius as f32;
        let places = (grid.stride() + MARGIN) * grid.height;
        self.bends.clear();
        self.bends.resize(places, [0.0; 4]);
        match contrast {
            None => {
                for node in nodes {
                    self.lay::<false>(grid, node);
                }
                self.sum(grid, values);
            }
            Some(contrast) => {
                self.steps.clear();
                self.steps.resize(places, [Lanes::default(); 2]);
                for node in nodes {
                    self.lay::<true>(grid, node);
                }
                self.sum_all(grid, (values, changes), contrast);
            }
        }
    }

    /// Lays the ends of a node's chords on its rows.
    #[inline(always)]
    fn lay<const ALL: bool>(&mut self, grid: &Grid, node: &Node) {
        let reach = self.radius + 0.5;
        let first = (node.y - reach).ceil().max(0.0) as usize;
        let past = ((node.y + reach).floor() + 1.0).clamp(0.0, grid.height as f32) as usize;
        let columns = grid.stride() + MARGIN;
        let last = (columns - 1) as f32;
        let mut whole = Lanes::default();
        whole[..SHAPE_PARAMETERS].copy_from_slice(&node.sweep);
        if first >= past {
            return;
        }
        let rows = first * columns..past * columns;
        let mut bends = self.bends[rows.clone()].chunks_exact_mut(columns);
        let mut steps = if ALL { &mut self.steps[rows] } else { &mut [] }.chunks_exact_mut(columns);
        let radius = self.radius;
        for row in first..past {
            let chords = chords(radius, row as f32 - node.y);
            let Some(bends) = bends.next() else { return };
            let steps = steps.next().unwrap_or_default();
            let ends = Ends::of(node, &chords, last);
            for k in 0..ENDS {
                if k % 4 == CHORDS {
                    continue;
                }
                let column = ends.columns[k] as usize;
                let Some(bend) = bends.get_mut(column) else {
                    return;
                };
                for (sum, moments) in bend.iter_mut().zip(&ends.moments) {
                    *sum += moments[k];
                }
                if ALL {
                    let Some([by_part, by_all]) = steps.get_mut(column) else {
                        return;
                    };
                    let mut change = whole.map(|sweep| ends.shares[k] * sweep);
                    change[SHAPE_PARAMETERS] = ends.growths[k];
                    add(by_part, ends.parts[k], &change);
                    add(by_all, 1.0, &change);
                }
            }
        }
    }

    /// Sums of the bends along the rows, twice.
    #[inline(always)]
    fn sum(&self, grid: &Grid, values: &mut Plane) {
        let stride = grid.stride();
        let rows = self.bends.chunks_exact(stride + MARGIN);
        for (bends, values) in rows.zip(values.chunks_exact_mut(stride)) {
            let mut sum = Sum::default();
            sum.next(&bends[0]);
            for (bend, value) in bends[BEFORE..].iter().zip(values) {
                *value += sum.next(bend);
            }
        }
    }

    /// The same, and sums of the steps.
    #[inline(always)]
    fn sum_all(
        &self,
        grid: &Grid,
        (values, changes): (&mut Plane, &mut [Plane; COVERAGE_PARAMETERS]),
        contrast: f32,
    ) {
        let stride = grid.stride();
        // the disc's area is in the shares, and grows too
        let shrink = contrast * 2.0 / self.radius;
        let rows = self.bends.chunks_exact(stride + MARGIN);
        let rows = rows.zip(self.steps.chunks_exact(stride + MARGIN));
        for (row, (bends, steps)) in rows.enumerate() {
            let at = row * stride;
            let mut planes = changes.each_mut().map(|plane| &mut plane[at..at + stride]);
            let values = &mut values[at..at + stride];
            let (mut sum, mut step, mut begun) =
                (Sum::default(), Lanes::default(), Lanes::default());
            for (i, (bend, [by_part, by_all])) in bends.iter().zip(steps).enumerate() {
                let total = sum.next(bend);
                for l in 0..step.len() {
                    // a step rises by its part in its own pixel and by the rest in the next
                    step[l] += contrast * (begun[l] + by_part[l]);
                    begun[l] = by_all[l] - by_part[l];
                }
                let Some(i) = i.checked_sub(BEFORE).filter(|i| *i < stride) else {
                    continue;
                };
                values[i] += total;
                for (plane, step) in planes.iter_mut().zip(&step) {
                    plane[i] += step;
                }
                planes[SHAPE_PARAMETERS][i] -= shrink * total;
            }
        }
    }
}

/// The ends of a row's chords: first where they enter the disc, then where they leave it.
const ENDS: usize = 8;
struct Ends {
    /// The pixels they lie in, of the row with its margin.
    columns: [u32; ENDS],
    /// How far before the middles of these.
    parts: [f32; ENDS],
    /// Shares of the disc, negative where they leave it.
    shares: [f32; ENDS],
    /// Moments 0, 1 and 2 of the parts, times share and rise; a fourth fills a vector.
    moments: [[f32; ENDS]; 4],
    /// Changes by the radius.
    growths: [f32; ENDS],
}

impl Ends {
    #[inline(always)]
    fn of(node: &Node, chords: &Chords, last: f32) -> Self {
        // adding this rounds to a whole number and leaves it in the low bits
        const ROUND: f32 = 8_388_608.0;
        let mut ends = Self {
            columns: [0; ENDS],
            parts: [0.0; ENDS],
            shares: [0.0; ENDS],
            moments: [[0.0; ENDS]; 4],
            growths: [0.0; ENDS],
        };
        let from = node.x + BEFORE as f32 - 0.5;
        for k in 0..ENDS {
            let side = if k < 4 { -1.0 } else { 1.0 };
            let at = from + side * chords.half_widths[k % 4];
            // what lies before the window bends there, wherever it is
            let rounded = (at + 0.5).max(0.0).min(last) + ROUND;
            ends.columns[k] = rounded.to_bits() & 0x007f_ffff;
            let part = (rounded - ROUND) - at;
            ends.parts[k] = part;
            ends.shares[k] = -side * chords.shares[k % 4];
            let rise = ends.shares[k] * node.rise;
            ends.moments[0][k] = rise;
            ends.moments[1][k] = rise * part;
            ends.moments[2][k] = rise * part * part;
            ends.growths[k] = chords.shares[k % 4] * node.rise * chords.growths[k % 4];
        }
        ends
    }
}

/// A sum along a row from the moments of its bends.
#[derive(Default)]
struct Sum {
    /// What the bends of the pixel before leave for this one, and for the next.
    left: [f32; 2],
    slope: f32,
    total: f32,
}

impl Sum {
    #[inline(always)]
    fn next(&mut self, [all, first, second, _]: &[f32; 4]) -> f32 {
        self.slope += 0.5 * second + self.left[0];
        self.left[0] = self.left[1] + 0.5 * all + first - second;
        self.left[1] = 0.5 * (all + second) - first;
        self.total += self.slope;
        self.total
    }
}

/// The chords that stand for a pixel's height about `y` from the disc's middle.
#[inline(always)]
fn chords(radius: f32, y: f32) -> Chords {
    let scale = 1.0 / (std::f32::consts::PI * radius * radius);
    let (first, last) = (y - 0.5, y + 0.5);
    let (heights, weights) = match (first < -radius, last > radius) {
        (true, true) => (
            WHOLE.map(|(place, _)| radius * place),
            WHOLE.map(|(_, weight)| radius * weight),
        ),
        (false, false) => (
            HEIGHTS.map(|(place, _)| y + 0.5 * place),
            HEIGHTS.map(|(_, weight)| weight),
        ),
        (low, _) => {
            // from the rim on, whichever of the two it is
            let length = if low { last + radius } else { radius - first };
            let u = HEIGHTS.map(|(place, _)| 0.5 * (1.0 + place));
            (
                u.map(|u| radius - length * u * u),
                std::array::from_fn(|k| 2.0 * length * u[k] * HEIGHTS[k].1),
            )
        }
    };
    let half_widths = heights.map(|v| (radius * radius - v * v).max(0.0).sqrt());
    Chords {
        half_widths,
        shares: weights.map(|weight| weight * scale),
        growths: half_widths.map(|half_width| radius / half_width.max(1e-3 * radius)),
    }
}

#[inline(always)]
fn add(sums: &mut Lanes, factor: f32, values: &Lanes) {
    for (sum, value) in sums.iter_mut().zip(values) {
        *sum += factor * value;
    }
}
