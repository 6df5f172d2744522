//! A rectangle of pixels of one type, rows contiguous and without padding.

use super::widest;
use nalgebra::{Point2, Vector2};

/// A grey value: what it is as a fraction of full scale.
pub trait Pixel: Copy + Default + Send + Sync + PartialOrd + 'static {
    /// The grey value scaled to 0..1 (an f32 pixel is already).
    fn unit(self) -> f32 {
        self.raw() * Self::UNIT
    }

    /// The value as a number.
    fn raw(self) -> f32;

    /// One over full scale.
    const UNIT: f32;
}

impl Pixel for u8 {
    const UNIT: f32 = 1.0 / 255.0;

    fn raw(self) -> f32 {
        f32::from(self)
    }
}

impl Pixel for u16 {
    const UNIT: f32 = 1.0 / 65535.0;

    fn raw(self) -> f32 {
        f32::from(self)
    }
}

impl Pixel for f32 {
    const UNIT: f32 = 1.0;

    fn raw(self) -> f32 {
        self
    }
}

/// A `width` x `height` rectangle of pixels.
#[derive(Debug, Clone, PartialEq)]
pub struct Plane<T> {
    width: usize,
    height: usize,
    data: Vec<T>,
}

impl<T: Pixel> Plane<T> {
    /// Wraps pixels stored row by row; `None` where `data` is not `width * height` long.
    pub fn from_vec(width: usize, height: usize, data: Vec<T>) -> Option<Self> {
        (width.checked_mul(height) == Some(data.len())).then_some(Self {
            width,
            height,
            data,
        })
    }

    /// A plane of one value.
    pub fn filled(width: usize, height: usize, value: T) -> Self {
        Self {
            width,
            height,
            data: vec![value; width * height],
        }
    }

    /// Width, px.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height, px.
    pub fn height(&self) -> usize {
        self.height
    }

    /// All pixels, row by row.
    pub fn data(&self) -> &[T] {
        &self.data
    }

    /// All pixels, row by row, to be written.
    pub fn data_mut(&mut self) -> &mut [T] {
        &mut self.data
    }

    /// One row; panics when `y` is outside, like a slice.
    pub fn row(&self, y: usize) -> &[T] {
        &self.data[y * self.width..(y + 1) * self.width]
    }

    /// One row to be written; panics when `y` is outside, like a slice.
    pub fn row_mut(&mut self, y: usize) -> &mut [T] {
        &mut self.data[y * self.width..(y + 1) * self.width]
    }

    /// The pixel at (x, y); panics outside, like a slice.
    pub fn at(&self, x: usize, y: usize) -> T {
        self.data[y * self.width + x]
    }

    /// Grey value 0..1 between pixels, bilinear; `None` outside the pixel centres.
    pub fn bilinear(&self, x: f64, y: f64) -> Option<f32> {
        let (x_last, y_last) = (self.width.checked_sub(1)?, self.height.checked_sub(1)?);
        if !(x >= 0.0 && y >= 0.0 && x <= x_last as f64 && y <= y_last as f64) {
            return None;
        }
        // the way by i32 takes half as long as straight to usize
        let (x0, y0) = (x as i32 as usize, y as i32 as usize);
        let (x1, y1) = ((x0 + 1).min(x_last), (y0 + 1).min(y_last));
        let (fx, fy) = ((x - x0 as f64) as f32, (y - y0 as f64) as f32);
        let top = self.at(x0, y0).unit() * (1.0 - fx) + self.at(x1, y0).unit() * fx;
        let bottom = self.at(x0, y1).unit() * (1.0 - fx) + self.at(x1, y1).unit() * fx;
        Some(top * (1.0 - fy) + bottom * fy)
    }

    /// Appends the bilinear grey values 0..1 at `origin`, `origin + step` and so on, `count` at most, as long as they are inside
    /// the pixel centres.
    pub fn along(&self, origin: Point2<f64>, step: Vector2<f64>, count: usize, out: &mut Vec<f32>) {
        if self.width < 2 || self.height < 2 {
            return;
        }
        let inside = |v: f64, size: usize| v >= 0.0 && v <= (size - 1) as f64;
        let at = |i: usize| origin + step * i as f64;
        let holds = |i: usize| {
            let p = at(i);
            inside(p.x, self.width) && inside(p.y, self.height)
        };
        let count = if count > 0 && holds(0) && holds(count - 1) {
            // a straight line that begins and ends inside stays there
            count
        } else {
            (0..count).find(|&i| !holds(i)).unwrap_or(count)
        };
        let ends = [at(0), at(count.saturating_sub(1))];
        let first = |a: f64, b: f64, size: usize| (a.min(b).max(0.0) as usize).min(size - 2);
        let corner = (
            first(ends[0].x, ends[1].x, self.width),
            first(ends[0].y, ends[1].y, self.height),
        );
        let from = origin - Vector2::new(corner.0 as f64, corner.1 as f64);
        let mut done = 0;
        while done < count {
            let part = TOGETHER.min(count - done);
            let begin = from + step * done as f64;
            self.part_along(corner, (begin, step), &mut [0.0; TOGETHER][..part], out);
            done += part;
        }
    }

    /// Up to [`TOGETHER`] of them, by places relative to a corner, which are small enough for f32. What has no need of the pixels is done
    /// for all of them before and after.
    fn part_along(
        &self,
        corner: (usize, usize),
        (begin, step): (Point2<f64>, Vector2<f64>),
        room: &mut [f32],
        out: &mut Vec<f32>,
    ) {
        let last = (self.width - 2 - corner.0, self.height - 2 - corner.1);
        let first = corner.1 * self.width + corner.0;
        widest(
            #[inline(always)]
            || {
                let (x, fx) = split((begin.x as f32, step.x as f32), last.0);
                let (y, fy) = split((begin.y as f32, step.y as f32), last.1);
                let mut corners = [[0.0_f32; TOGETHER]; 4];
                for i in 0..room.len().min(TOGETHER) {
                    let at = first + y[i] as usize * self.width + x[i] as usize;
                    let rows = &self.data[at..][..self.width + 2];
                    corners[0][i] = rows[0].raw();
                    corners[1][i] = rows[1].raw();
                    corners[2][i] = rows[self.width].raw();
                    corners[3][i] = rows[self.width + 1].raw();
                }
                let [a, b, c, d] = &corners;
                for (i, out) in room.iter_mut().enumerate().take(TOGETHER) {
                    let (top, bottom) =
                        (a[i] + (b[i] - a[i]) * fx[i], c[i] + (d[i] - c[i]) * fx[i]);
                    *out = (top + (bottom - top) * fy[i]) * T::UNIT;
                }
            },
        );
        out.extend_from_slice(room);
    }
}

/// Places along a line that are computed together.
const TOGETHER: usize = 16;

/// Whole and broken part of `begin`, `begin + step` and so on, the whole one from 0 to `last`.
#[inline(always)]
fn split((begin, step): (f32, f32), last: usize) -> ([i32; TOGETHER], [f32; TOGETHER]) {
    let (mut whole, mut part) = ([0; TOGETHER], [0.0; TOGETHER]);
    let last = last as i32;
    for i in 0..TOGETHER {
        let place = begin + step * i as f32;
        whole[i] = (place as i32).max(0).min(last);
        part[i] = place - whole[i] as f32;
    }
    (whole, part)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bilinear_is_exact_on_a_plane_and_none_outside() {
        let data = (0..12)
            .map(|i| (i % 4) as f32 + 10.0 * (i / 4) as f32)
            .collect();
        let plane = Plane::from_vec(4, 3, data).unwrap();
        assert_eq!(plane.bilinear(1.5, 0.5), Some(6.5));
        assert_eq!(plane.bilinear(3.0, 2.0), Some(23.0));
        assert_eq!(plane.bilinear(3.01, 2.0), None);
        assert_eq!(plane.bilinear(-0.01, 0.0), None);
        assert_eq!(plane.bilinear(f64::NAN, 0.0), None);
    }

    #[test]
    fn along_a_line_grey_values_are_the_bilinear_ones_up_to_the_border() {
        let data = (0..42).map(|i| ((i * 37) % 251) as u8).collect();
        let plane = Plane::from_vec(7, 6, data).unwrap();
        for (origin, step, inside) in [
            (Point2::new(1.2, 2.3), Vector2::new(0.31, -0.17), 14),
            (Point2::new(0.0, 0.0), Vector2::new(1.0, 0.5), 7),
            (Point2::new(6.0, 5.0), Vector2::new(-0.1, 0.0), 20),
            (Point2::new(6.1, 5.0), Vector2::new(-0.1, 0.0), 0),
        ] {
            let mut found = Vec::new();
            plane.along(origin, step, 20, &mut found);
            assert_eq!(found.len(), inside);
            for (i, grey) in found.iter().enumerate() {
                let p = origin + step * i as f64;
                assert!((grey - plane.bilinear(p.x, p.y).unwrap()).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn sizes_must_add_up() {
        assert!(Plane::from_vec(2, 2, vec![0_u8; 5]).is_none());
        assert!(Plane::from_vec(usize::MAX, 2, vec![0_u8; 2]).is_none());
    }
}
