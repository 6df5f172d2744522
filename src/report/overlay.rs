//! A frame with what was found in it, for people: ellipses, centres, indices, directions, coverage and a caption.

use super::canvas::{Canvas, Stroke};
use super::text::{self, Size};
use super::visible::visible;
use crate::board::Board;
use crate::centre::Ellipse;
use crate::detect::{Detection, Indices, Miss, Ring};
use crate::frame::Frame;
use image::imageops::{self, FilterType};
use image::{DynamicImage, GrayImage, Rgb, RgbImage};
use nalgebra::{Point2, Vector2};

const OUTER: Rgb<u8> = Rgb([0, 200, 255]);
const INNER: Rgb<u8> = Rgb([255, 170, 0]);
const CENTRE: Rgb<u8> = Rgb([255, 60, 170]);
const COLUMN_AXIS: Rgb<u8> = Rgb([255, 50, 40]);
const ROW_AXIS: Rgb<u8> = Rgb([40, 220, 60]);
const KEPT: Rgb<u8> = Rgb([90, 160, 255]);
const LABEL: Rgb<u8> = Rgb([255, 255, 255]);
const MISS: Rgb<u8> = Rgb([255, 210, 80]);

/// How large an overlay is, as a factor of the frame's size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale(f64);

impl Scale {
    /// The size of the frame.
    pub const FULL: Self = Self(1.0);

    /// A factor from 0.01 to 8; `None` for any other number.
    pub fn new(factor: f64) -> Option<Self> {
        (0.01..=8.0).contains(&factor).then_some(Self(factor))
    }
}

impl Default for Scale {
    fn default() -> Self {
        Self::FULL
    }
}

/// The frame, made visible, with the rings of a detection or the reason of a miss. `kept` are the centres of views kept
/// so far, px of the frame: the coverage, drawn as faint dots.
///
/// The outer ellipses are blue, the inner ones orange, the centres pink crosses; at ring (0, 0) a red arrow points
/// along the row to the next column and a green one to the next row.
pub fn overlay(
    frame: &Frame,
    board: &Board,
    result: Result<&Detection, &Miss>,
    kept: &[Point2<f64>],
    scale: Scale,
) -> RgbImage {
    let mut drawing = Drawing::new(frame, scale);
    drawing.coverage(kept);
    match result {
        Ok(detection) => {
            drawing.rings(detection);
            drawing.axes(detection);
            drawing.labels(detection);
            drawing.caption(&found(board, detection), LABEL);
        }
        Err(miss) => drawing.caption(&format!("no board: {miss}"), MISS),
    }
    drawing.canvas.into_picture()
}

fn found(board: &Board, detection: &Detection) -> String {
    let numbering = match detection.indices {
        Indices::Absolute => "",
        Indices::Relative => ", indices relative",
    };
    format!(
        "{} x {} board, {} rings, blur {:.1} px{numbering}",
        board.rows(),
        board.columns(),
        detection.rings.len(),
        detection.blur_sigma_px(),
    )
}

/// The canvas and how the frame lies on it.
struct Drawing {
    canvas: Canvas,
    /// Pixels of the canvas for one of the frame, by axis (the sides are whole numbers).
    per_px: Vector2<f64>,
    /// Lines are this much thicker on pictures so large that they are looked at reduced.
    boldness: f64,
    text: Size,
}

impl Drawing {
    fn new(frame: &Frame, Scale(factor): Scale) -> Self {
        let side = |px: usize| ((px as f64 * factor).round() as u32).max(1);
        let (width, height) = (side(frame.width()), side(frame.height()));
        let grey = visible(frame);
        let grey = if grey.is_empty() {
            GrayImage::new(width, height)
        } else if width < grey.width() || height < grey.height() {
            // box averages: no aliasing, and several times faster than the general filter
            imageops::thumbnail(&grey, width, height)
        } else if width > grey.width() || height > grey.height() {
            imageops::resize(&grey, width, height, FilterType::Triangle)
        } else {
            grey
        };
        let picture = DynamicImage::ImageLuma8(grey).into_rgb8();
        let large = width.max(height) >= 1600;
        Self {
            canvas: Canvas::new(picture),
            per_px: Vector2::new(
                f64::from(width) / frame.width().max(1) as f64,
                f64::from(height) / frame.height().max(1) as f64,
            ),
            boldness: if large { 2.0 } else { 1.0 },
            text: if large { Size::Large } else { Size::Small },
        }
    }

    /// A point of the frame on the canvas; both count from the centre of the top-left pixel.
    fn point(&self, p: Point2<f64>) -> Point2<f64> {
        let half = Vector2::new(0.5, 0.5);
        Point2::from((p.coords + half).component_mul(&self.per_px) - half)
    }

    /// An ellipse of the frame on the canvas; the axes' scales differ by less than a pixel over the picture.
    fn ellipse(&self, ellipse: &Ellipse) -> Ellipse {
        let scale = self.per_px.x.midpoint(self.per_px.y);
        Ellipse {
            centre: self.point(ellipse.centre),
            major: ellipse.major * scale,
            minor: ellipse.minor * scale,
            angle: ellipse.angle,
        }
    }

    fn stroke(&self, colour: Rgb<u8>) -> Stroke {
        Stroke {
            colour,
            half_width: 0.6 * self.boldness,
            opacity: 1.0,
        }
    }

    fn coverage(&mut self, kept: &[Point2<f64>]) {
        let dot = Stroke {
            colour: KEPT,
            half_width: 1.8 * self.boldness,
            opacity: 0.45,
        };
        for &point in kept {
            let at = self.point(point);
            self.canvas.dot(at, dot);
        }
    }

    fn rings(&mut self, detection: &Detection) {
        let arm = 4.0 * self.boldness;
        for ring in &detection.rings {
            for (ellipse, colour) in [(ring.ellipses.outer, OUTER), (ring.ellipses.inner, INNER)] {
                let (ellipse, stroke) = (self.ellipse(&ellipse), self.stroke(colour));
                self.canvas.ellipse(&ellipse, stroke);
            }
            let (at, stroke) = (self.point(ring.centre.point), self.stroke(CENTRE));
            for arm in [Vector2::new(arm, 0.0), Vector2::new(0.0, arm)] {
                self.canvas.line(at - arm, at + arm, stroke);
            }
        }
    }

    /// The directions of increasing column and row at ring (0, 0), or at the first ring that has both neighbours.
    fn axes(&mut self, detection: &Detection) {
        let centre = |row: u16, column: u16| {
            let at = (row, column);
            let ring = detection.rings.iter().find(|r| (r.row, r.column) == at);
            ring.map(|r| r.centre.point)
        };
        let corner = detection.rings.iter().find_map(|ring| {
            let (row, column) = (ring.row, ring.column);
            let next_column = centre(row, column.checked_add(1)?)?;
            let next_row = centre(row.checked_add(1)?, column)?;
            Some((ring.centre.point, next_column, next_row))
        });
        let Some((origin, next_column, next_row)) = corner else {
            return;
        };
        let from = self.point(origin);
        for (to, colour) in [(next_column, COLUMN_AXIS), (next_row, ROW_AXIS)] {
            let mut stroke = self.stroke(colour);
            stroke.half_width *= 1.7;
            let to = self.point(to);
            let tip = from + (to - from) * 0.7;
            self.canvas.arrow(from, tip, 9.0 * self.boldness, stroke);
        }
    }

    /// "row,column" below every ring, or at the corners alone where the rings stand too close for text.
    fn labels(&mut self, detection: &Detection) {
        let crowded = self.smallest_gap(detection) < 4.5 * self.text.character_px() as f64;
        let rows = detection.rings.iter().map(|r| r.row);
        let columns = detection.rings.iter().map(|r| r.column);
        let ends = [
            rows.clone().min(),
            rows.max(),
            columns.clone().min(),
            columns.max(),
        ];
        for ring in &detection.rings {
            let corner =
                ends[..2].contains(&Some(ring.row)) && ends[2..].contains(&Some(ring.column));
            if corner || !crowded {
                self.label(ring);
            }
        }
    }

    fn label(&mut self, ring: &Ring) {
        let outer = self.ellipse(&ring.ellipses.outer);
        let (sin, cos) = outer.angle.sin_cos();
        let down = (outer.major * sin).hypot(outer.minor * cos);
        let label = format!("{},{}", ring.row, ring.column);
        let width = label.len() as i64 * self.text.character_px();
        // `as` saturates, so a wild ellipse puts its label outside the picture
        let x = (outer.centre.x.round() as i64).saturating_sub(width / 2);
        let y = (outer.centre.y + down).round() as i64;
        let outside = |at: i64, side: u32| at < -width || at > i64::from(side);
        if !outside(x, self.canvas.width()) && !outside(y, self.canvas.height()) {
            text::draw(&mut self.canvas, x, y, &label, self.text, LABEL);
        }
    }

    /// Smallest distance on the canvas between neighbours of a row, px; infinite where there are none.
    fn smallest_gap(&self, detection: &Detection) -> f64 {
        let pairs = detection
            .rings
            .windows(2)
            .filter(|pair| pair[0].row == pair[1].row);
        let gaps = pairs.map(|pair| {
            let [a, b] = [&pair[0], &pair[1]].map(|ring| self.point(ring.centre.point));
            (a - b).norm()
        });
        gaps.fold(f64::INFINITY, f64::min)
    }

    /// Text on a darkened band along the lower edge.
    fn caption(&mut self, caption: &str, colour: Rgb<u8>) {
        let (line, character) = (self.text.line_px(), self.text.character_px());
        let (width, height) = (
            i64::from(self.canvas.width()),
            i64::from(self.canvas.height()),
        );
        let margin = line / 4;
        let columns = ((width - 2 * margin) / character).max(1);
        let lines = text::wrap(caption, columns as usize);
        let top = (height - lines.len() as i64 * line - 2 * margin).max(0);
        for y in top..height {
            for x in 0..width {
                self.canvas.blend(x, y, Rgb([0, 0, 0]), 0.6);
            }
        }
        for (k, text) in (0..).zip(&lines) {
            let y = top + margin + k * line;
            text::draw(&mut self.canvas, margin, y, text, self.text, colour);
        }
    }
}

#[cfg(test)]
mod tests;
