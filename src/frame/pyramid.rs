//! A pyramid of halved pictures: level 0 is the frame itself, each level above averages 2 x 2 pixels.

use super::{Frame, Pixel, Pixels, Plane};
use rayon::prelude::*;

/// One level of a pyramid in pixels of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Level(pub u32);

impl Level {
    /// How many frame pixels one pixel of this level spans.
    pub fn scale(self) -> f64 {
        f64::from(1_u32 << self.0)
    }

    /// A coordinate of this level in frame pixels (pixel centres are whole numbers in both).
    pub fn to_frame(self, level_px: f64) -> f64 {
        (level_px + 0.5) * self.scale() - 0.5
    }
}

/// The first halving of a frame; `None` where a side is shorter than 2 px.
pub fn half_of_frame(frame: &Frame) -> Option<Plane<f32>> {
    match &frame.pixels {
        Pixels::U8(plane) => half(plane),
        Pixels::U16(plane) => half(plane),
    }
}

/// Mean of every 2 x 2 block, grey 0..1; an odd last row or column is left out. `None` where a side is shorter than
/// 2 px.
pub fn half<T: Pixel>(plane: &Plane<T>) -> Option<Plane<f32>> {
    let (width, height) = (plane.width() / 2, plane.height() / 2);
    if width == 0 || height == 0 {
        return None;
    }
    let mut out = Plane::filled(width, height, 0.0_f32);
    out.data_mut()
        .par_chunks_mut(width)
        .enumerate()
        .for_each(|(y, row)| {
            let (top, bottom) = (plane.row(2 * y), plane.row(2 * y + 1));
            for ((pixel, a), b) in row
                .iter_mut()
                .zip(top.chunks_exact(2))
                .zip(bottom.chunks_exact(2))
            {
                *pixel = 0.25 * (a[0].unit() + a[1].unit() + b[0].unit() + b[1].unit());
            }
        });
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halving_keeps_a_linear_picture_linear_at_the_mapped_coordinates() {
        let data = (0..60)
            .map(|i| ((i % 10) * 3 + (i / 10) * 7) as u16 * 100)
            .collect();
        let plane = Plane::from_vec(10, 6, data).unwrap();
        let halved = half(&plane).unwrap();
        assert_eq!((halved.width(), halved.height()), (5, 3));
        for (x, y) in [(0, 0), (4, 2), (2, 1)] {
            let (u, v) = (Level(1).to_frame(x as f64), Level(1).to_frame(y as f64));
            let expected = plane.bilinear(u, v).unwrap();
            assert!((halved.at(x, y) - expected).abs() < 1e-6);
        }
    }

    #[test]
    fn a_single_row_has_no_half() {
        assert!(half(&Plane::filled(10, 1, 0_u8)).is_none());
    }
}
