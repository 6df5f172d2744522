//! A piece of outline out of focus by a disc (pillbox).
//!
//! A point of the outline lands at `place - size a`, a evenly in the unit disc (a place in the aperture). Each a sees its own
//! sharp outline, whose pieces rise by `rise - growth a_y`; the picture is the mean over a. Along a row the disc is a span
//! of even light, so that the second difference of the picture has two places: its ends.

use super::field::Band;
use super::outline::{GAUSS_LEGENDRE, Node};

/// Adds one piece to a band.
pub(super) fn add(band: &mut Band, node: &Node) {
    let y = node.place.y - band.first_row as f64;
    let heights = |row: usize| {
        let border = |edge: f64| ((row as f64 + edge - y) / node.size).clamp(-1.0, 1.0);
        (border(-0.5), border(0.5))
    };
    for row in band.rows_near(node.place.y, node.size + 0.5) {
        let (top, bottom) = heights(row);
        let mut ends = Ends {
            line: band.second_differences(row),
            node,
        };
        if top.abs().max(bottom.abs()) < STEEP && bottom - top < THIN {
            ends.add_steep(top, bottom);
        } else {
            ends.add_cap(top.asin(), bottom.asin());
        }
    }
}

/// Nodes of the Gauss-Legendre rule of two points.
const FRAC_1_SQRT_3: f64 = 0.577_350_269_189_625_8;

/// Up to this height (of the radius) the rim of a disc is taken as a function of the height; above it turns too fast.
const STEEP: f64 = 0.75;

/// A row thinner than this (of the radius) needs two nodes where the rim is steep.
const THIN: f64 = 0.25;

/// The ends of the spans of one disc in one row.
struct Ends<'a> {
    line: &'a mut [f64],
    node: &'a Node,
}

impl Ends<'_> {
    /// Adds the rows between two heights, as shares of the radius, where the rim is steep.
    fn add_steep(&mut self, top: f64, bottom: f64) {
        let (middle, half) = (0.5 * (top + bottom), 0.5 * (bottom - top));
        // two Gauss-Legendre nodes: over a row the ends move by about a pixel, and the ramp is piecewise quadratic
        for at in [-FRAC_1_SQRT_3, FRAC_1_SQRT_3] {
            let height = middle + half * at;
            self.add(height, (1.0 - height * height).sqrt(), half);
        }
    }

    /// Adds the rows between two angles on the rim, 0 at its right and left: at most a pixel and a radian at a time.
    fn add_cap(&mut self, top: f64, bottom: f64) {
        let run = self.node.size * (bottom.cos() - top.cos()).abs();
        let parts = 1 + run as usize + (bottom - top) as usize;
        let half = 0.5 * (bottom - top) / parts as f64;
        for part in 0..parts {
            let middle = top + half * (2 * part + 1) as f64;
            for (at, weight) in GAUSS_LEGENDRE {
                let (sin, cos) = (middle + half * at).sin_cos();
                self.add(sin, cos, weight * half * cos);
            }
        }
    }

    /// Adds a span at this height, of this half width and this thickness, all in radii.
    fn add(&mut self, height: f64, half_width: f64, thickness: f64) {
        let (x, radius) = (self.node.place.x, self.node.size);
        let rise = self.node.rise + self.node.growth * height;
        let light = -rise * thickness / (std::f64::consts::PI * radius);
        add_end(self.line, x - radius * half_width, light);
        add_end(self.line, x + radius * half_width, -light);
    }
}

/// Adds to the second differences of a row the pixel-integrated ramp that begins at x with this slope.
fn add_end(line: &mut [f64], x: f64, slope: f64) {
    if x >= line.len() as f64 {
        return;
    }
    let (start, taps) = if x >= -0.5 {
        // the first pixel whose right border is beyond x
        let first = (x + 0.5) as usize;
        let into = first as f64 - x;
        let area = 0.5 * (into + 0.5) * (into + 0.5);
        (first, [area, into + 1.0 - 2.0 * area, area - into])
    } else {
        // the ramp began left of the picture: the first two columns carry its value and slope
        let (at_0, at_1, at_2) = (ramp(-x), ramp(1.0 - x), ramp(2.0 - x));
        (0, [at_0, at_1 - 2.0 * at_0, at_2 - 2.0 * at_1 + at_0])
    };
    for (pixel, tap) in line.iter_mut().skip(start).zip(taps) {
        *pixel += slope * tap;
    }
}

/// Pixel-integrated ramp max(0, z).
fn ramp(z: f64) -> f64 {
    if z <= -0.5 {
        0.0
    } else if z < 0.5 {
        0.5 * (z + 0.5) * (z + 0.5)
    } else {
        z
    }
}
