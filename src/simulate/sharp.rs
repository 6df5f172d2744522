//! A straight piece of outline in focus: the exact area it cuts off each pixel.

use super::field::Band;
use super::outline::Segment;
use nalgebra::Point2;

/// Adds one piece, shorter than a pixel, to a band.
pub(super) fn add(band: &mut Band, segment: &Segment) {
    let (from, to) = (segment.from, segment.to);
    let top = from.y.min(to.y) - band.first_row as f64;
    let bottom = from.y.max(to.y) - band.first_row as f64;
    if bottom < -0.5 || top > band.rows as f64 - 0.5 {
        return;
    }
    // cut where it crosses the border between two rows or two columns of pixels
    let mut cuts = [0.0, border(from.x, to.x), border(from.y, to.y), 1.0];
    if cuts[1] > cuts[2] {
        cuts.swap(1, 2);
    }
    let at = |t: f64| from + t * (to - from);
    for pair in cuts.windows(2) {
        add_within_pixel(band, at(pair[0]), at(pair[1]));
    }
}

/// Share of the way from a to b at which a border between pixels is crossed; 0 where none is.
fn border(a: f64, b: f64) -> f64 {
    let border = (a.max(b) + 0.5).floor() - 0.5;
    if a.min(b) < border {
        (border - a) / (b - a)
    } else {
        0.0
    }
}

/// Adds a piece that lies within one pixel.
fn add_within_pixel(band: &mut Band, from: Point2<f64>, to: Point2<f64>) {
    let rise = to.y - from.y;
    let row = (0.5 * (from.y + to.y) + 0.5).floor() - band.first_row as f64;
    if row < 0.0 || row >= band.rows as f64 {
        return;
    }
    let x = 0.5 * (from.x + to.x);
    let column = (x + 0.5).floor();
    let line = band.first_differences(row as usize);
    if column < 0.0 {
        line[0] -= rise;
    } else if column < line.len() as f64 {
        // the part of the pixel right of the piece
        let share = column + 0.5 - x;
        line[column as usize] -= rise * share;
        if let Some(next) = line.get_mut(column as usize + 1) {
            *next -= rise * (1.0 - share);
        }
    }
}
