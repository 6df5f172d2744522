//! A piece of outline out of focus by a disc (pillbox).
//!
//! A point of the outline lands at `place - size a`, a evenly in the unit disc (a place in the aperture). Each a sees its own
//! sharp outline, whose pieces rise by `rise - growth a_y`; the picture is the mean over a. Along a row the disc is a span
//! of even light, so that the second difference of the picture has two places: its ends.

use super::field::Band;
use super::outline::{GAUSS_LEGENDRE, Node};

/// Adds one piece to a band.
pub(super) fn add(band: &mut Band, node: &Node) {
    let radius = node.size;
    let y = node.place.y - band.first_row as f64;
    let density = 1.0 / (std::f64::consts::PI * radius);
    for row in band.rows_near(node.place.y, radius + 0.5) {
        let bottom = ((row as f64 + 0.5 - y) / radius).clamp(-1.0, 1.0).asin();
        let top = ((row as f64 - 0.5 - y) / radius).clamp(-1.0, 1.0).asin();
        let line = band.second_differences(row);
        // near the top and the bottom of the disc the ends run along the row: at most a pixel at a time
        let run = radius * (bottom.cos() - top.cos()).abs();
        let parts = 1 + run as usize;
        let half = 0.5 * (bottom - top) / parts as f64;
        for part in 0..parts {
            let middle = top + half * (2 * part + 1) as f64;
            for (at, weight) in GAUSS_LEGENDRE {
                let (sin, cos) = (middle + half * at).sin_cos();
                let light = -weight * half * cos * density * (node.rise + node.growth * sin);
                add_end(line, node.place.x - radius * cos, light);
                add_end(line, node.place.x + radius * cos, -light);
            }
        }
    }
}

/// Adds to the second differences of a row the pixel-integrated ramp that begins at x with this slope.
fn add_end(line: &mut [f64], x: f64, slope: f64) {
    let first = (x + 0.5).floor();
    if first >= line.len() as f64 {
        return;
    }
    let (start, taps) = if first >= 0.0 {
        let into = first - x;
        let area = 0.5 * (into + 0.5) * (into + 0.5);
        (first as usize, [area, into + 1.0 - 2.0 * area, area - into])
    } else {
        // the ramp began left of the picture: the first two columns carry its value and slope
        let (at_0, at_1, at_2) = (ramp(-x), ramp(1.0 - x), ramp(2.0 - x));
        (0, [at_0, at_1 - 2.0 * at_0, at_2 - 2.0 * at_1 + at_0])
    };
    for (pixel, tap) in line[start..].iter_mut().zip(taps) {
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
