//! A frame reduced to a few thousand grey values, to see cheaply whether it shows what another one shows.

use super::{Frame, Pixel, Pixels, Plane};

/// Cells along the longer side, at most.
const LONGEST: usize = 96;
/// Full scale of a cell.
const FULL_SCALE: f32 = 255.0;

/// Mean grey values of the cells of a frame, 0 to 255 whatever its depth.
#[derive(Debug, Clone, PartialEq)]
pub struct Thumbnail {
    size: (usize, usize),
    /// Side of a cell, px.
    side: usize,
    cells: Vec<f32>,
}

impl Thumbnail {
    /// Of a frame, in square cells; what is left over at the right and at the bottom counts to the last cells.
    pub fn of(frame: &Frame) -> Self {
        Self::with_longest(frame, LONGEST)
    }

    /// The same with at most so many cells along the longer side, to look at.
    pub fn with_longest(frame: &Frame, longest: usize) -> Self {
        let size = (frame.width(), frame.height());
        let side = size.0.max(size.1).div_ceil(longest.max(1)).max(1);
        let cells = match &frame.pixels {
            Pixels::U8(plane) => means(plane, side, FULL_SCALE / f32::from(u8::MAX)),
            Pixels::U16(plane) => means(plane, side, FULL_SCALE / f32::from(u16::MAX)),
        };
        Self { size, side, cells }
    }

    /// The grey values, 0 to 255, by rows.
    pub fn cells(&self) -> &[f32] {
        &self.cells
    }

    /// Cells across and down.
    pub fn grid(&self) -> (usize, usize) {
        grid(self.size, self.side)
    }

    /// Width and height of the frame, px.
    pub fn frame_px(&self) -> (usize, usize) {
        self.size
    }

    /// Side of a cell, px of the frame.
    pub fn cell_px(&self) -> usize {
        self.side
    }

    /// The largest difference of two cells in the same place, 0 to 255; `None` for frames of different sizes.
    pub fn difference(&self, other: &Self) -> Option<f32> {
        let cells = self.cells.iter().zip(&other.cells);
        let difference = cells.fold(0.0, |most: f32, (a, b)| most.max((a - b).abs()));
        (self.size == other.size).then_some(difference)
    }
}

fn grid((width, height): (usize, usize), side: usize) -> (usize, usize) {
    ((width / side).max(1), (height / side).max(1))
}

fn means<P: Pixel + Into<u32>>(plane: &Plane<P>, side: usize, scale: f32) -> Vec<f32> {
    let height = plane.height();
    let (columns, rows) = grid((plane.width(), height), side);
    let mut sums = vec![(0_u64, 0_u64); columns * rows];
    for y in 0..height {
        let row = (y / side).min(rows - 1) * columns;
        for (cell, pixels) in plane.row(y).chunks(side).enumerate() {
            let (sum, count) = &mut sums[row + cell.min(columns - 1)];
            *sum += pixels.iter().map(|p| u64::from((*p).into())).sum::<u64>();
            *count += pixels.len() as u64;
        }
    }
    sums.iter()
        .map(|(sum, count)| scale * (*sum as f64 / (*count).max(1) as f64) as f32)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(width: usize, height: usize, grey: impl Fn(usize, usize) -> u8) -> Frame {
        let pixels = (0..width * height).map(|at| grey(at % width, at / width));
        Frame::from_u8(
            Plane::from_vec(width, height, pixels.collect()).unwrap(),
            "a",
        )
    }

    #[test]
    fn a_cell_is_the_mean_of_its_pixels_in_either_depth() {
        let eight = frame(200, 101, |x, y| ((x * 7 + y * 13) % 250) as u8);
        let thumbnail = Thumbnail::of(&eight);
        assert_eq!(thumbnail.cells.len(), 66 * 33);
        let mean = (0..9).map(|at| ((at % 3 * 7 + at / 3 * 13) % 250) as f32);
        assert!((thumbnail.cells[0] - mean.sum::<f32>() / 9.0).abs() < 1e-3);
        let Pixels::U8(plane) = &eight.pixels else {
            unreachable!()
        };
        let deep: Vec<u16> = (0..101)
            .flat_map(|y| plane.row(y).iter().map(|p| u16::from(*p) * 257))
            .collect();
        let deep = Frame::from_u16(Plane::from_vec(200, 101, deep).unwrap(), "a");
        assert!(Thumbnail::of(&deep).difference(&thumbnail).unwrap() < 1e-3);
    }

    #[test]
    fn one_cell_that_differs_is_seen_and_sizes_are_not_compared() {
        let grey = Thumbnail::of(&frame(320, 240, |_, _| 100));
        let spot = |x, y| if x / 8 == 20 && y / 8 == 10 { 140 } else { 100 };
        let spotted = Thumbnail::of(&frame(320, 240, spot));
        assert_eq!(grey.difference(&spotted), Some(40.0));
        assert_eq!(
            grey.difference(&Thumbnail::of(&frame(320, 239, |_, _| 100))),
            None
        );
        assert_eq!(Thumbnail::of(&frame(1, 1, |_, _| 9)).cells, [9.0]);
    }

    #[test]
    fn it_may_be_larger_to_be_looked_at() {
        let larger = Thumbnail::with_longest(&frame(640, 483, |x, _| (x / 4) as u8), 320);
        assert_eq!((larger.grid(), larger.cell_px()), ((320, 241), 2));
        assert_eq!(larger.cells().len(), 320 * 241);
        assert_eq!(larger.cells()[7], 3.0);
    }
}
