//! The frame of the camera as the ground of a figure: pixels in, coordinates of the picture out.

use crate::report::svg::{Anchor, Svg};
use nalgebra::Point2;

/// Width of every figure, units; a telephone shows about 340 of its own pixels for it.
pub(super) const WIDTH: f64 = 480.0;
/// Height of a tall frame at most.
const TALLEST: f64 = 480.0;
/// Height of a line of text.
pub(super) const LINE: f64 = 18.0;
/// Room about the frame, so that its line is not cut.
const MARGIN: f64 = 1.0;

/// A figure with the frame in it.
pub(super) struct FramePlot {
    pub svg: Svg,
    /// Units for a pixel.
    pub scale: f64,
    origin: [f64; 2],
    size: [f64; 2],
}

impl FramePlot {
    /// The frame of a size, px, with room for some lines of legend below it.
    pub fn new(frame_px: (f64, f64), legend_lines: f64, label: impl Into<String>) -> Self {
        let (width, height) = (frame_px.0.max(1.0), frame_px.1.max(1.0));
        let scale = ((WIDTH - 2.0 * MARGIN) / width).min(TALLEST / height);
        let size = [width * scale, height * scale];
        let origin = [0.5 * (WIDTH - size[0]), MARGIN];
        let total = size[1] + 2.0 * MARGIN + legend_lines * LINE;
        let mut svg = Svg::new(WIDTH, total, label);
        svg.rect("ground", origin, size);
        Self {
            svg,
            scale,
            origin,
            size,
        }
    }

    /// Where a pixel lies.
    pub fn at(&self, pixel: Point2<f64>) -> [f64; 2] {
        // the frame begins half a pixel before the centre of its first pixel
        [
            self.origin[0] + (pixel.x + 0.5) * self.scale,
            self.origin[1] + (pixel.y + 0.5) * self.scale,
        ]
    }

    /// Corner and size of a cell of a grid of cells over the frame.
    pub fn cell(
        &self,
        (column, row): (usize, usize),
        (columns, rows): (usize, usize),
    ) -> [[f64; 2]; 2] {
        let size = [self.size[0] / columns as f64, self.size[1] / rows as f64];
        let at = [
            self.origin[0] + column as f64 * size[0],
            self.origin[1] + row as f64 * size[1],
        ];
        [at, size]
    }

    /// The outline of the frame, over what is drawn in it.
    pub fn outline(&mut self) {
        self.svg.rect("outline", self.origin, self.size);
    }

    /// Left end of the base line of a line of legend, 0 the first.
    pub fn legend(&self, line: f64) -> [f64; 2] {
        [MARGIN, self.origin[1] + self.size[1] + (line + 1.0) * LINE]
    }

    /// The size of the frame, at the right of the first line of legend.
    pub fn say_size(&mut self, frame_px: (f64, f64)) {
        let at = [WIDTH - MARGIN, self.legend(0.0)[1]];
        let text = format!("{} x {} px", frame_px.0, frame_px.1);
        self.svg.text("muted", at, Anchor::End, &text);
    }
}
