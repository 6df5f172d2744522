//! A rectangle of pixels of one type, rows contiguous and without padding.

/// A grey value: what it is as a fraction of full scale.
pub trait Pixel: Copy + Default + Send + Sync + PartialOrd + 'static {
    /// The grey value scaled to 0..1 (an f32 pixel is already).
    fn unit(self) -> f32;
}

impl Pixel for u8 {
    fn unit(self) -> f32 {
        f32::from(self) * (1.0 / 255.0)
    }
}

impl Pixel for u16 {
    fn unit(self) -> f32 {
        f32::from(self) * (1.0 / 65535.0)
    }
}

impl Pixel for f32 {
    fn unit(self) -> f32 {
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
    fn sizes_must_add_up() {
        assert!(Plane::from_vec(2, 2, vec![0_u8; 5]).is_none());
        assert!(Plane::from_vec(usize::MAX, 2, vec![0_u8; 2]).is_none());
    }
}
