//! Stamps of a disc of even light (pillbox), as a round aperture makes, integrated over the pixels.
//!
//! At height y the disc is a chord of half-width s = sqrt(c^2 - y^2). Summed up from the left it is a ramp from -s to s, which the
//! pixel's width rounds off at both corners. Over the pixel's height it is averaged by three chords: Gauss-Legendre, where the disc's rim
//! lies in the pixel in the square root of the distance from it, because chords begin like one; Gauss-Chebyshev where the
//! whole disc lies in it.

use super::boundary::Node;
use super::coverage::{Kernel, LANES, Lanes, Stamp, touched};
use super::window::Grid;
use std::f32::consts::{FRAC_1_SQRT_2, FRAC_PI_4};

/// Distance of nodes in pixels of the grid, from small discs to large ones, and the radius from which one is large.
const SPACING: (f64, f64) = (0.03, 0.5);
const LARGE: f64 = 4.0;
/// Gauss-Legendre on [-1, 1]: places and weights over two.
const HEIGHTS: [(f32, f32); 3] = [
    (-0.774_596_7, 5.0 / 18.0),
    (0.0, 8.0 / 18.0),
    (0.774_596_7, 5.0 / 18.0),
];
/// Gauss-Chebyshev of the second kind: places and weights for chords.
const WHOLE: [(f32, f32); 3] = [
    (-FRAC_1_SQRT_2, FRAC_PI_4 * FRAC_1_SQRT_2),
    (0.0, FRAC_PI_4),
    (FRAC_1_SQRT_2, FRAC_PI_4 * FRAC_1_SQRT_2),
];

/// A disc over a window.
#[derive(Debug, Clone, Default)]
pub(super) struct Disc {
    radius: f32,
    stamps: Vec<Stamp>,
    /// The chords of each row, node after node.
    rows: Vec<[Chord; 3]>,
}

/// A chord of the disc: half its width, and its share of the pixel's height over the disc's area.
type Chord = (f32, f32);

/// Where a node is against a vector of pixels, and its rise.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    begin: f32,
    rise: f32,
}

impl Disc {
    /// The chords that stand for a pixel's height about `y` from the disc's middle.
    #[inline(always)]
    fn chords(&self, y: f32) -> [Chord; 3] {
        let radius = self.radius;
        let scale = 1.0 / (std::f32::consts::PI * radius * radius);
        let chord = |v: f32, weight: f32| {
            let half_width = (radius * radius - v * v).max(0.0).sqrt();
            (half_width, weight * scale)
        };
        let (first, last) = (y - 0.5, y + 0.5);
        match (first < -radius, last > radius) {
            (true, true) => WHOLE.map(|(place, weight)| chord(radius * place, radius * weight)),
            (false, false) => HEIGHTS.map(|(place, weight)| chord(y + 0.5 * place, weight)),
            (low, _) => {
                let length = if low { last + radius } else { radius - first };
                HEIGHTS.map(|(place, weight)| {
                    let u = 0.5 * (1.0 + place);
                    let v = radius - length * u * u;
                    chord(if low { -v } else { v }, 2.0 * length * u * weight)
                })
            }
        }
    }

    /// Change of a chord's half-width by the radius.
    #[inline(always)]
    fn growth(&self, half_width: f32) -> f32 {
        self.radius / half_width.max(1e-3 * self.radius)
    }
}

impl Kernel for Disc {
    type Row = [Chord; 3];
    type Part = Place;

    fn spacing(radius: f64) -> f64 {
        SPACING.0 + (SPACING.1 - SPACING.0) * (radius / LARGE).min(1.0)
    }

    #[inline(always)]
    fn prepare(&mut self, grid: &Grid, nodes: &[Node], radius: f64) {
        self.radius = radius as f32;
        self.stamps.clear();
        self.rows.clear();
        for node in nodes {
            let stamp = touched(node, self.radius + 0.5, grid, self.rows.len());
            for i in stamp.rows.0..stamp.rows.1 {
                let chords = self.chords(i as f32 - node.y);
                self.rows.push(chords);
            }
            self.stamps.push(stamp);
        }
    }

    #[inline(always)]
    fn stamps(&self) -> &[Stamp] {
        &self.stamps
    }

    #[inline(always)]
    fn row(&self, at: usize) -> Self::Row {
        self.rows[at]
    }

    #[inline(always)]
    fn part(&self, node: &Node, _: usize, vector: usize) -> Place {
        Place {
            begin: (vector * LANES) as f32 - node.x,
            rise: node.rise,
        }
    }

    #[inline(always)]
    fn sum(&self, row: &Self::Row, part: &Place) -> Lanes {
        let mut sum = [0.0; LANES];
        for &(half_width, weight) in row {
            for (l, sum) in sum.iter_mut().enumerate() {
                let z = part.begin + l as f32;
                *sum += weight * (ramp(z + half_width).0 - ramp(z - half_width).0);
            }
        }
        sum.map(|sum| part.rise * sum)
    }

    #[inline(always)]
    fn all(&self, row: &Self::Row, part: &Place) -> [Lanes; 3] {
        let begin = part.begin;
        let shrink = 2.0 / self.radius;
        let (mut sums, mut shares, mut slopes) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for &(half_width, weight) in row {
            let growth = weight * self.growth(half_width);
            let pixels = sums.iter_mut().zip(&mut shares).zip(&mut slopes);
            for (l, ((sum, share), slope)) in pixels.enumerate() {
                let z = begin + l as f32;
                let (enters, enter_slope) = ramp(z + half_width);
                let (leaves, leave_slope) = ramp(z - half_width);
                let own = weight * (enters - leaves);
                *sum += own;
                *share += weight * (enter_slope - leave_slope);
                // the disc's area is in the weights, and grows too
                *slope += growth * (enter_slope + leave_slope) - shrink * own;
            }
        }
        [
            sums.map(|sum| part.rise * sum),
            shares,
            slopes.map(|slope| part.rise * slope),
        ]
    }

    #[inline(always)]
    fn beyond(&self, row: &Self::Row) -> [f32; 2] {
        let (mut total, mut change) = (0.0, 0.0);
        for &(half_width, weight) in row {
            total += 2.0 * weight * half_width;
            change += 2.0 * weight * self.growth(half_width);
        }
        [total, change - 2.0 / self.radius * total]
    }
}

/// max(z, 0) averaged over a pixel, and its slope.
#[inline(always)]
fn ramp(z: f32) -> (f32, f32) {
    let inside = z + 0.5;
    let slope = inside.clamp(0.0, 1.0);
    (0.5 * slope * slope + (inside - 1.0).max(0.0), slope)
}
