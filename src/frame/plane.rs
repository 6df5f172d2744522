//! A rectangle of pixels of one type, rows contiguous and without padding.

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
        let (x0, y0) = (x as usize, y as usize);
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
        out.extend((0..count).map(|i| {
            let p = at(i);
            let (x, y) = (
                (p.x as usize).min(self.width - 2),
                (p.y as usize).min(self.height - 2),
            );
            let (fx, fy) = ((p.x - x as f64) as f32, (p.y - y as f64) as f32);
            let first = y * self.width + x;
            let top = &self.data[first..first + 2];
            let bottom = &self.data[first + self.width..first + self.width + 2];
            let line = |pair: &[T]| {
                let (left, right) = (pair[0].raw(), pair[1].raw());
                left + (right - left) * fx
            };
            let (top, bottom) = (line(top), line(bottom));
            (top + (bottom - top) * fy) * T::UNIT
        }));
    }
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
