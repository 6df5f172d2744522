//! Letters of any size on a picture, from the bitmaps that the font crate brings.

use super::sheet::{ADVANCE, Text, Turn};
use noto_sans_mono_bitmap::{
    FontWeight, RasterHeight, RasterizedChar, get_raster, get_raster_width,
};

const RASTER: RasterHeight = RasterHeight::Size32;

/// A line of text with its letters' bitmaps.
pub(super) struct Glyphs<'a> {
    text: &'a Text,
    letters: Vec<Option<RasterizedChar>>,
    /// Columns of a bitmap.
    columns: f64,
    /// The row of a bitmap on whose lower edge letters stand, counted from 1.
    foot: f64,
}

impl<'a> Glyphs<'a> {
    pub(super) fn new(text: &'a Text) -> Self {
        let weight = match text.bold {
            true => FontWeight::Bold,
            false => FontWeight::Regular,
        };
        let letter = |c| get_raster(c, weight, RASTER);
        let letters = text.text.chars().map(letter).collect();
        let foot = letter('H').map_or(0, |h| {
            h.rows()
                .rposition(|row| row.iter().any(|ink| *ink > 127))
                .unwrap_or(0)
                + 1
        });
        Self {
            text,
            letters,
            columns: get_raster_width(weight, RASTER) as f64,
            foot: foot as f64,
        }
    }

    /// How much ink is on the square of this side about a point of the sheet, 0 to 1. Lengths in mm.
    pub(super) fn ink(&self, [x, y]: [f64; 2], side_mm: f64) -> f64 {
        // bitmap pixels for each mm
        let finer = self.columns / (ADVANCE * self.text.em_mm);
        let samples = (finer * side_mm).ceil().clamp(1.0, 16.0) as u32;
        let offset = |k: u32| ((f64::from(k) + 0.5) / f64::from(samples) - 0.5) * side_mm;
        let all = (0..samples).flat_map(|i| (0..samples).map(move |j| (offset(i), offset(j))));
        let ink: f64 = all.map(|(dx, dy)| self.at(x + dx, y + dy, finer)).sum();
        ink / f64::from(samples * samples)
    }

    /// Ink at a point.
    fn at(&self, x: f64, y: f64, finer: f64) -> f64 {
        let (dx, dy) = (x - self.text.at_mm[0], y - self.text.at_mm[1]);
        let (along, up) = match self.text.turn {
            Turn::Level => (dx, -dy),
            Turn::Down => (dy, dx),
        };
        // between the middles of the bitmap's pixels
        let (column, row) = (along * finer - 0.5, self.foot - up * finer - 0.5);
        let (left, top) = (column.floor(), row.floor());
        let (right_part, lower_part) = (column - left, row - top);
        let corner = |dx: f64, dy: f64| self.pixel(left + dx, top + dy);
        let upper = corner(0.0, 0.0) * (1.0 - right_part) + corner(1.0, 0.0) * right_part;
        let lower = corner(0.0, 1.0) * (1.0 - right_part) + corner(1.0, 1.0) * right_part;
        upper * (1.0 - lower_part) + lower * lower_part
    }

    /// The pixel of the whole line's bitmap; none outside.
    fn pixel(&self, column: f64, row: f64) -> f64 {
        if column < 0.0 || row < 0.0 {
            return 0.0;
        }
        let (at, within) = (column / self.columns, column % self.columns);
        let letter = self.letters.get(at as usize).copied().flatten();
        let ink = letter.and_then(|letter| letter.pixel(within as usize, row as usize));
        f64::from(ink.unwrap_or(0)) / 255.0
    }
}
