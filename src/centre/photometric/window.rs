//! The pixels a ring is fitted to: a rectangle of the frame, binned where the blur allows it.

use crate::frame::{Frame, Pixel, Pixels, Plane};
use std::ops::Range;

/// The places of a window's pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// Centre of the first column, px of the frame.
    pub left_px: f64,
    /// Centre of the first row, px of the frame.
    pub top_px: f64,
    /// Side of a pixel of the window, px of the frame.
    pub pixel_px: f64,
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

impl Grid {
    /// Centre of a column, px of the frame.
    pub(super) fn x(&self, column: usize) -> f64 {
        self.left_px + column as f64 * self.pixel_px
    }

    /// Centre of a row, px of the frame.
    pub(super) fn y(&self, row: usize) -> f64 {
        self.top_px + row as f64 * self.pixel_px
    }

    /// Rows and columns exchanged.
    pub(super) fn transposed(&self) -> Self {
        Self {
            left_px: self.top_px,
            top_px: self.left_px,
            pixel_px: self.pixel_px,
            width: self.height,
            height: self.width,
        }
    }

    /// Rows whose centres lie between two heights, px of the frame.
    pub(super) fn rows_within(&self, first_px: f64, last_px: f64) -> Range<usize> {
        let place = |y: f64| (y - self.top_px) / self.pixel_px;
        indices_within(place(first_px), place(last_px), self.height)
    }

    /// Columns whose centres lie between two places, px of the frame; where there are none, those that would be next.
    pub(super) fn columns_within(&self, first_px: f64, last_px: f64) -> Range<usize> {
        let place = |x: f64| (x - self.left_px) / self.pixel_px;
        indices_within(place(first_px), place(last_px), self.width)
    }
}

/// Whole numbers between two, of 0..count.
fn indices_within(first: f64, last: f64, count: usize) -> Range<usize> {
    // a cast of a float truncates and saturates: below zero it is zero
    let whole = first as usize;
    let first = (if (whole as f64) < first {
        whole.saturating_add(1)
    } else {
        whole
    })
    .min(count);
    let past = if last < 0.0 {
        0
    } else {
        (last as usize).saturating_add(1)
    }
    .min(count);
    first..past.max(first)
}

/// A rectangle of the frame in frame pixels: first column and row, width and height.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rectangle {
    /// First column.
    pub x: usize,
    /// First row.
    pub y: usize,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

/// Grey values of a window, 0..1, and which of them are believed.
#[derive(Debug, Clone, PartialEq)]
pub struct Window {
    /// Where they are.
    pub grid: Grid,
    /// Row by row.
    pub values: Vec<f64>,
    /// 1 for a pixel that counts, 0 for one that shows something else or is clipped.
    pub weights: Vec<f64>,
}

impl Window {
    /// Cuts a window out of a frame, each of its pixels the mean of `bin` x `bin`. Pixels of which `counts` says no, and those
    /// at the ends of the frame's range, do not count. `None` where nothing is left.
    pub fn cut(
        frame: &Frame,
        rectangle: Rectangle,
        bin: usize,
        counts: impl Fn(f64, f64) -> bool,
    ) -> Option<Self> {
        match &frame.pixels {
            Pixels::U8(plane) => Self::cut_plane(plane, rectangle, bin, (0, u8::MAX), counts),
            Pixels::U16(plane) => Self::cut_plane(plane, rectangle, bin, (0, u16::MAX), counts),
        }
    }

    fn cut_plane<T: Pixel>(
        plane: &Plane<T>,
        rectangle: Rectangle,
        bin: usize,
        ends: (T, T),
        counts: impl Fn(f64, f64) -> bool,
    ) -> Option<Self> {
        let bin = bin.max(1);
        let grid = Grid {
            left_px: rectangle.x as f64 + 0.5 * (bin as f64 - 1.0),
            top_px: rectangle.y as f64 + 0.5 * (bin as f64 - 1.0),
            pixel_px: bin as f64,
            width: rectangle.width / bin,
            height: rectangle.height / bin,
        };
        let size = grid.width * grid.height;
        let (mut values, mut weights) = (Vec::with_capacity(size), Vec::with_capacity(size));
        let area = (bin * bin) as f64;
        for row in 0..grid.height {
            for column in 0..grid.width {
                let (x, y) = (rectangle.x + column * bin, rectangle.y + row * bin);
                let (mut sum, mut clipped) = (0.0, false);
                for line in y..y + bin {
                    for &pixel in &plane.row(line)[x..x + bin] {
                        sum += f64::from(pixel.unit());
                        clipped |= pixel <= ends.0 || pixel >= ends.1;
                    }
                }
                values.push(sum / area);
                let believed = !clipped && counts(grid.x(column), grid.y(row));
                weights.push(if believed { 1.0 } else { 0.0 });
            }
        }
        (size > 0).then_some(Self {
            grid,
            values,
            weights,
        })
    }

    /// Pixels that count.
    pub fn count(&self) -> usize {
        self.weights.iter().filter(|&&w| w > 0.0).count()
    }
}
