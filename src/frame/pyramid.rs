//! A pyramid of halved pictures: level 0 is the frame itself, each level above averages 2 x 2 pixels.

use super::{Frame, Pixel, Pixels, Plane, widest};
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

/// Output rows that one task computes.
const ROWS_PER_TASK: usize = 16;

/// The first halving of a frame; `None` where a side is shorter than 2 px.
pub fn half_of_frame(frame: &Frame) -> Option<Plane<f32>> {
    reduced_frame::<2>(frame)
}

/// Two halvings of a frame at once; `None` where a side is shorter than 4 px.
pub fn quarter_of_frame(frame: &Frame) -> Option<Plane<f32>> {
    reduced_frame::<4>(frame)
}

/// Mean of every 2 x 2 block, grey 0..1; an odd last row or column is left out. `None` where a side is shorter than
/// 2 px.
pub fn half<T: Pixel>(plane: &Plane<T>) -> Option<Plane<f32>> {
    reduced::<2, T>(plane)
}

fn reduced_frame<const BY: usize>(frame: &Frame) -> Option<Plane<f32>> {
    match &frame.pixels {
        Pixels::U8(plane) => reduced::<BY, u8>(plane),
        Pixels::U16(plane) => reduced::<BY, u16>(plane),
    }
}

/// Mean of every block of `BY` x `BY` pixels, grey 0..1.
fn reduced<const BY: usize, T: Pixel>(plane: &Plane<T>) -> Option<Plane<f32>> {
    let (width, height) = (plane.width() / BY, plane.height() / BY);
    if width == 0 || height == 0 {
        return None;
    }
    let scale = T::UNIT / (BY * BY) as f32;
    let mut out = Plane::filled(width, height, 0.0_f32);
    out.data_mut()
        .par_chunks_mut(ROWS_PER_TASK * width)
        .enumerate()
        .for_each(|(task, rows)| {
            let mut columns = vec![0.0_f32; BY * width];
            for (i, row) in rows.chunks_exact_mut(width).enumerate() {
                let first = BY * (task * ROWS_PER_TASK + i);
                widest(
                    #[inline(always)]
                    || {
                        columns.fill(0.0);
                        for y in first..first + BY {
                            for (sum, value) in columns.iter_mut().zip(plane.row(y)) {
                                *sum += value.raw();
                            }
                        }
                        for (pixel, sums) in row.iter_mut().zip(columns.chunks_exact(BY)) {
                            *pixel = scale * sums.iter().sum::<f32>();
                        }
                    },
                );
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
    fn a_quarter_is_half_of_a_half() {
        let data = (0..23 * 18).map(|i| ((i * 89) % 256) as u8).collect();
        let frame = Frame::from_u8(Plane::from_vec(23, 18, data).unwrap(), "x");
        let twice = half(&half_of_frame(&frame).unwrap()).unwrap();
        let quarter = quarter_of_frame(&frame).unwrap();
        assert_eq!((quarter.width(), quarter.height()), (5, 4));
        for (a, b) in quarter.data().iter().zip(twice.data()) {
            assert!((a - b).abs() < 1e-6);
        }
    }

    #[test]
    fn a_single_row_has_no_half() {
        assert!(half(&Plane::filled(10, 1, 0_u8)).is_none());
    }
}
