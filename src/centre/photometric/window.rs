//! The pixels a ring is fitted to: a rectangle of the frame, linearised, and binned where the blur allows it.

use super::gram::WIDEST;
use crate::frame::{Frame, Linear, Pixel, Pixels, Plane};

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

    /// Pixels from one row to the next in a window's buffers: rows are padded to whole vectors, the widest there are.
    pub(super) fn stride(&self) -> usize {
        self.width.next_multiple_of(WIDEST)
    }
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

/// Part of a window at either end of the range from which on it is no photograph's light.
const BOTH_ENDS: f64 = 0.1;

/// Which end of the sensor's range a pixel stands at: its light is at least, or at most, what it says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// Nothing lighter can be told.
    Top,
    /// Nothing darker can be told.
    Bottom,
}

/// Light of a window's pixels, and which of them are believed.
#[derive(Debug, Clone, PartialEq)]
pub struct Window {
    /// Where they are.
    pub grid: Grid,
    /// Light, 1 at full scale; row by row, rows padded to [`Grid::stride`].
    pub(super) values: Vec<f32>,
    /// 1 for a pixel that counts, 0 for one that shows something else, is censored or pads a row.
    pub(super) weights: Vec<f32>,
    /// Pixels that were clipped (at least one of those binned), by their index.
    pub(super) censored: Vec<(usize, End)>,
}

impl Window {
    /// A window of no light, all of whose pixels count.
    pub(super) fn blank(grid: Grid) -> Self {
        let mut weights = vec![0.0; grid.stride() * grid.height];
        for row in weights.chunks_exact_mut(grid.stride()) {
            row[..grid.width].fill(1.0);
        }
        Self {
            grid,
            values: vec![0.0; weights.len()],
            weights,
            censored: Vec::new(),
        }
    }

    /// Cuts a window out of a frame, each of its pixels the mean light of `bin` x `bin`; `None` where nothing is left.
    pub fn cut(frame: &Frame, rectangle: Rectangle, bin: usize, linear: &Linear) -> Option<Self> {
        match &frame.pixels {
            Pixels::U8(plane) => {
                Self::cut_plane(plane, rectangle, bin, (0, u8::MAX), |v| linear.of_u8(v))
            }
            Pixels::U16(plane) => {
                Self::cut_plane(plane, rectangle, bin, (0, u16::MAX), |v| linear.of_u16(v))
            }
        }
    }

    fn cut_plane<T: Pixel>(
        plane: &Plane<T>,
        rectangle: Rectangle,
        bin: usize,
        (bottom, top): (T, T),
        light: impl Fn(T) -> f32,
    ) -> Option<Self> {
        let bin = bin.max(1);
        let grid = Grid {
            left_px: rectangle.x as f64 + 0.5 * (bin as f64 - 1.0),
            top_px: rectangle.y as f64 + 0.5 * (bin as f64 - 1.0),
            pixel_px: bin as f64,
            width: rectangle.width / bin,
            height: rectangle.height / bin,
        };
        let stride = grid.stride();
        let mut values = vec![0.0_f32; stride * grid.height];
        let mut weights = vec![0.0_f32; stride * grid.height];
        let mut censored = Vec::new();
        let scale = 1.0 / (bin * bin) as f32;
        let columns = rectangle.x..rectangle.x + grid.width * bin;
        for row in 0..grid.height {
            let start = row * stride;
            let values = &mut values[start..start + grid.width];
            let (mut highest, mut lowest) = (bottom, top);
            for line in 0..bin {
                let pixels = &plane.row(rectangle.y + row * bin + line)[columns.clone()];
                for &pixel in pixels {
                    highest = if pixel > highest { pixel } else { highest };
                    lowest = if pixel < lowest { pixel } else { lowest };
                }
                if bin == 1 {
                    let pairs = values.iter_mut().zip(pixels);
                    pairs.for_each(|(value, &pixel)| *value = light(pixel));
                } else {
                    for (value, pixels) in values.iter_mut().zip(pixels.chunks_exact(bin)) {
                        *value += pixels.iter().map(|&pixel| light(pixel)).sum::<f32>();
                    }
                }
            }
            if bin > 1 {
                values.iter_mut().for_each(|value| *value *= scale);
            }
            weights[start..start + grid.width].fill(1.0);
            if highest < top && lowest > bottom {
                continue;
            }
            for column in 0..grid.width {
                let lines = (0..bin).map(|line| plane.row(rectangle.y + row * bin + line));
                let mut pixels = lines.flat_map(|line| {
                    let first = rectangle.x + column * bin;
                    &line[first..first + bin]
                });
                let end = pixels.find_map(|&pixel| match pixel {
                    pixel if pixel >= top => Some(End::Top),
                    pixel if pixel <= bottom => Some(End::Bottom),
                    _ => None,
                });
                if let Some(end) = end {
                    censored.push((start + column, end));
                    weights[start + column] = 0.0;
                }
            }
        }
        let mut window = Self {
            grid,
            values,
            weights,
            censored,
        };
        if window.is_of_two_greys() {
            for (at, _) in window.censored.drain(..) {
                window.weights[at] = 1.0;
            }
        }
        (grid.width > 0 && grid.height > 0).then_some(window)
    }

    /// Whether much stands at both ends of the range: a drawing or a picture that somebody has thresholded, whose black and white mean what they
    /// say. Taken for clipped, no pixel of it would tell how bright the paper is.
    fn is_of_two_greys(&self) -> bool {
        let top = self.censored.iter().filter(|(_, end)| *end == End::Top);
        let (top, all) = (top.count(), self.censored.len());
        let least = BOTH_ENDS * (self.grid.width * self.grid.height) as f64;
        top.min(all - top) as f64 >= least
    }

    /// Leaves out the pixels of which `counts` (place in frame px) says no.
    pub fn keep(&mut self, counts: impl Fn(f64, f64) -> bool) {
        let (grid, stride) = (self.grid, self.grid.stride());
        for row in 0..grid.height {
            for column in 0..grid.width {
                let weight = &mut self.weights[row * stride + column];
                if *weight > 0.0 && !counts(grid.x(column), grid.y(row)) {
                    *weight = 0.0;
                }
            }
        }
        self.censored
            .retain(|&(at, _)| counts(grid.x(at % stride), grid.y(at / stride)));
    }

    /// Pixels that count, censored ones not among them.
    pub fn count(&self) -> usize {
        self.weights.iter().filter(|&&w| w > 0.0).count()
    }
}
