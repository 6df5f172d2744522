//! Antialiased shapes on a colour picture.
//!
//! Every shape is its distance function: a pixel is covered as far as its distance to the line leaves it, so
//! lines have no joints and no steps. Coordinates are those of the picture, the centre of the top-left pixel at (0, 0).

use crate::centre::Ellipse;
use image::{Rgb, RgbImage};
use nalgebra::{Point2, Vector2};

/// Side of the squares that are skipped whole where a line passes by at a distance, px.
const TILE: i64 = 8;

/// How a line is drawn.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stroke {
    /// Colour of the line.
    pub colour: Rgb<u8>,
    /// Half of its width, px.
    pub half_width: f64,
    /// 0 invisible, 1 solid.
    pub opacity: f64,
}

/// A picture being drawn on.
pub(super) struct Canvas {
    picture: RgbImage,
}

impl Canvas {
    /// Draws on this picture.
    pub fn new(picture: RgbImage) -> Self {
        Self { picture }
    }

    /// The finished picture.
    pub fn into_picture(self) -> RgbImage {
        self.picture
    }

    /// Width, px.
    pub fn width(&self) -> u32 {
        self.picture.width()
    }

    /// Height, px.
    pub fn height(&self) -> u32 {
        self.picture.height()
    }

    /// Mixes a colour into one pixel; pixels outside are left out.
    pub fn blend(&mut self, x: i64, y: i64, colour: Rgb<u8>, opacity: f64) {
        let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y)) else {
            return;
        };
        if let Some(pixel) = self.picture.get_pixel_mut_checked(x, y) {
            for (old, new) in pixel.0.iter_mut().zip(colour.0) {
                let mixed = f64::from(*old) + (f64::from(new) - f64::from(*old)) * opacity;
                *old = mixed.round() as u8;
            }
        }
    }

    /// The outline of an ellipse; nothing where it is not a finite one.
    pub fn ellipse(&mut self, ellipse: &Ellipse, stroke: Stroke) {
        let (sin, cos) = ellipse.angle.sin_cos();
        let (major, minor, centre) = (ellipse.major, ellipse.minor, ellipse.centre);
        if !(minor > 0.0 && major >= minor) {
            return;
        }
        let reach = Vector2::new(
            (major * cos).hypot(minor * sin),
            (major * sin).hypot(minor * cos),
        );
        // q is 1 on the ellipse; it grows by at most 1 / minor a px, which bounds the distance from below
        let place = |p: Point2<f64>| {
            let d = p - centre;
            let (u, v) = (cos * d.x + sin * d.y, cos * d.y - sin * d.x);
            let q = (u / major).hypot(v / minor);
            let slope = (u / (major * major)).hypot(v / (minor * minor)) / q;
            (q, slope)
        };
        let at_least = |p| minor * (place(p).0 - 1.0).abs();
        let distance = |p| {
            let (q, slope) = place(p);
            if slope > 0.0 {
                (q - 1.0).abs() / slope
            } else {
                minor
            }
        };
        self.fill(centre - reach, centre + reach, stroke, at_least, distance);
    }

    /// A straight line with round ends.
    pub fn line(&mut self, from: Point2<f64>, to: Point2<f64>, stroke: Stroke) {
        let along = to - from;
        let distance = |p: Point2<f64>| {
            let length2 = along.norm_squared();
            let part = if length2 > 0.0 {
                (p - from).dot(&along) / length2
            } else {
                0.0
            };
            (p - from - along * part.clamp(0.0, 1.0)).norm()
        };
        self.fill(from.inf(&to), from.sup(&to), stroke, distance, distance);
    }

    /// A line with an arrow head at its end.
    pub fn arrow(&mut self, from: Point2<f64>, to: Point2<f64>, head_px: f64, stroke: Stroke) {
        self.line(from, to, stroke);
        if let Some(back) = (from - to).try_normalize(1e-9) {
            let aside = Vector2::new(-back.y, back.x) * 0.5;
            self.line(to, to + (back + aside) * head_px, stroke);
            self.line(to, to + (back - aside) * head_px, stroke);
        }
    }

    /// A filled disc as large as the stroke is wide.
    pub fn dot(&mut self, at: Point2<f64>, stroke: Stroke) {
        self.line(at, at, stroke);
    }

    /// Covers every pixel between the corners as far as `distance` says. `at_least` is a lower bound of the distance that
    /// changes by at most 1 a px.
    fn fill(
        &mut self,
        low: Point2<f64>,
        high: Point2<f64>,
        stroke: Stroke,
        at_least: impl Fn(Point2<f64>) -> f64,
        distance: impl Fn(Point2<f64>) -> f64,
    ) {
        if !(low.coords.iter().chain(high.coords.iter())).all(|v| v.is_finite()) {
            return;
        }
        let reach = stroke.half_width + 0.5;
        let columns = covered(low.x - reach, high.x + reach, self.width());
        let rows = covered(low.y - reach, high.y + reach, self.height());
        let half = 0.5 * (TILE - 1) as f64;
        for y0 in rows.clone().step_by(TILE as usize) {
            for x0 in columns.clone().step_by(TILE as usize) {
                let middle = Point2::new(x0 as f64 + half, y0 as f64 + half);
                if at_least(middle) > reach + half * std::f64::consts::SQRT_2 {
                    continue;
                }
                for y in y0..(y0 + TILE).min(rows.end) {
                    for x in x0..(x0 + TILE).min(columns.end) {
                        let covered = reach - distance(Point2::new(x as f64, y as f64));
                        if covered > 0.0 {
                            self.blend(x, y, stroke.colour, stroke.opacity * covered.min(1.0));
                        }
                    }
                }
            }
        }
    }
}

/// The pixels of one axis between two coordinates that lie in the picture.
fn covered(low: f64, high: f64, side: u32) -> std::ops::Range<i64> {
    let side = f64::from(side);
    let start = low.ceil().clamp(0.0, side) as i64;
    let end = (high.floor() + 1.0).clamp(0.0, side) as i64;
    start..end.max(start)
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHITE: Rgb<u8> = Rgb([255, 255, 255]);
    const THIN: Stroke = Stroke {
        colour: WHITE,
        half_width: 0.5,
        opacity: 1.0,
    };

    /// Sum of the picture in units of white pixels: the area that was drawn.
    fn area(canvas: Canvas) -> f64 {
        let picture = canvas.into_picture();
        picture.pixels().map(|p| f64::from(p.0[0])).sum::<f64>() / 255.0
    }

    #[test]
    fn the_area_of_a_line_is_its_length_times_its_width() {
        let mut canvas = Canvas::new(RgbImage::new(120, 90));
        canvas.line(Point2::new(10.3, 12.9), Point2::new(103.1, 70.2), THIN);
        let expected = 92.8_f64.hypot(57.3);
        assert!((area(canvas) - expected).abs() < 0.03 * expected);
    }

    #[test]
    fn an_ellipse_is_drawn_once_around_whatever_its_shape() {
        for (major, minor) in [(40.0, 40.0), (45.0, 12.0), (48.0, 3.0), (2.5, 2.0)] {
            let ellipse = Ellipse {
                centre: Point2::new(50.2, 49.7),
                major,
                minor,
                angle: 0.6,
            };
            let mut canvas = Canvas::new(RgbImage::new(100, 100));
            canvas.ellipse(&ellipse, THIN);
            // the perimeter by a fine polygon
            let points =
                (0..4000).map(|k| ellipse.point(f64::from(k) * std::f64::consts::TAU / 4000.0));
            let points: Vec<_> = points.collect();
            let perimeter: f64 = (0..4000)
                .map(|k| (points[k] - points[(k + 1) % 4000]).norm())
                .sum();
            let lit = |p: &Point2<f64>| {
                canvas
                    .picture
                    .get_pixel(p.x.round() as u32, p.y.round() as u32)
                    .0[0]
                    > 0
            };
            assert!(points.iter().all(lit), "{major} {minor}");
            let area = area(canvas);
            assert!(
                (area - perimeter).abs() < 0.1 * perimeter,
                "{major} {minor}: {area} {perimeter}"
            );
        }
    }

    #[test]
    fn what_lies_outside_or_is_not_finite_is_left_out() {
        let mut canvas = Canvas::new(RgbImage::new(20, 10));
        let mut ellipse = Ellipse {
            centre: Point2::new(1e12, -500.0),
            major: 30.0,
            minor: 20.0,
            angle: 0.0,
        };
        canvas.ellipse(&ellipse, THIN);
        ellipse.centre.x = f64::NAN;
        canvas.ellipse(&ellipse, THIN);
        ellipse.minor = 0.0;
        canvas.ellipse(&ellipse, THIN);
        canvas.line(Point2::new(-9.0, -5.0), Point2::new(-1e300, -5.0), THIN);
        canvas.arrow(
            Point2::new(-50.0, 90.0),
            Point2::new(f64::INFINITY, 4.0),
            5.0,
            THIN,
        );
        canvas.blend(-1, 3, WHITE, 1.0);
        canvas.blend(3, 10, WHITE, 1.0);
        assert_eq!(area(canvas), 0.0);
    }
}
