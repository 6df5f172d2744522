//! Each picture against its own neighbourhood: what is lighter and what darker than its surroundings.
//!
//! The inner disc of a ring is lighter than the mean over a window of about the ring's size, however blurred it is, as
//! long as it shows as a local extremum at all; a global or mid-level threshold loses it much earlier. One window size
//! serves the rings of about one octave; the pyramid supplies the others.

use super::margins::{Margins, TILE, Usual, tile_margins};
use super::runs::{Runs, Side};
use crate::frame::{Pixel, Plane, widest};
use rayon::prelude::*;

/// Half the side of the window of the mean, px of the level: the window is 17 x 17.
pub(super) const HALF_WINDOW: usize = 8;

/// Rows that one task computes, whole tiles; fixed, so that sums run in the same order whatever the threads.
const ROWS_PER_TASK: usize = 2 * TILE;

/// The smoothed picture minus its local mean, how noisy it is where, and the pixels that stand out.
#[derive(Debug, Clone)]
pub(super) struct BandPass {
    /// Grey difference; positive where lighter than the surroundings.
    pub(super) plane: Plane<f32>,
    /// Differences smaller than these are not told from noise or quantisation.
    pub(super) margins: Margins,
    /// The pixels above the margins and those below.
    light: Runs,
    dark: Runs,
}

impl BandPass {
    /// Of a picture. Everything is computed strip by strip, while the strip's pixels are near.
    pub(super) fn of<T: Pixel>(picture: &Plane<T>) -> Self {
        let (width, height) = (picture.width(), picture.height());
        let mut plane = Plane::filled(width, height, 0.0_f32);
        let usual = Usual::of(picture);
        let strips: Vec<Strip> = plane
            .data_mut()
            .par_chunks_mut((ROWS_PER_TASK * width).max(1))
            .enumerate()
            .map(|(task, rows)| strip(picture, task * ROWS_PER_TASK, &usual, rows))
            .collect();
        let mut band = Self {
            plane,
            margins: Margins::new(width),
            light: Runs::default(),
            dark: Runs::default(),
        };
        for strip in strips {
            band.margins.extend(strip.margins);
            band.light.extend(strip.light);
            band.dark.extend(strip.dark);
        }
        band
    }

    /// Of differences that are known already.
    #[cfg(test)]
    pub(super) fn of_differences(plane: Plane<f32>, margin: f32) -> Self {
        let margins = Margins::everywhere(margin, plane.width(), plane.height());
        let (mut light, mut dark) = (Runs::default(), Runs::default());
        for y in 0..plane.height() {
            light.add_row(plane.row(y), margins.of_row(y), Side::Light);
            dark.add_row(plane.row(y), margins.of_row(y), Side::Dark);
        }
        Self {
            plane,
            margins,
            light,
            dark,
        }
    }

    /// The pixels that stand out to one side.
    pub(super) fn runs(&self, side: Side) -> &Runs {
        match side {
            Side::Light => &self.light,
            Side::Dark => &self.dark,
        }
    }
}

/// What is known of some rows.
struct Strip {
    margins: Vec<f32>,
    light: Runs,
    dark: Runs,
}

/// Fills rows of the band from `first` on.
fn strip<T: Pixel>(picture: &Plane<T>, first: usize, usual: &Usual, rows: &mut [f32]) -> Strip {
    let width = picture.width();
    let count = rows.len() / width;
    let above = first.saturating_sub(HALF_WINDOW);
    let below = (first + count + HALF_WINDOW).min(picture.height());
    let mut smooth = Plane::filled(width, below - above, 0.0_f32);
    let mut room = Vec::new();
    for y in above..below {
        smooth_row(picture, y, &mut room, smooth.row_mut(y - above));
    }
    less_mean(&smooth, first - above, rows);
    let margins = tile_margins(&smooth, first - above..first - above + count, usual);
    let (mut light, mut dark) = (Runs::default(), Runs::default());
    let tiles = width.div_ceil(TILE);
    for (y, row) in rows.chunks_exact(width).enumerate() {
        let margins = &margins[y / TILE * tiles..][..tiles];
        light.add_row(row, margins, Side::Light);
        dark.add_row(row, margins, Side::Dark);
    }
    Strip {
        margins,
        light,
        dark,
    }
}

/// One row under binomial 3 x 3 smoothing (1 2 1), borders replicated.
pub(super) fn smooth_row<T: Pixel>(
    picture: &Plane<T>,
    y: usize,
    columns: &mut Vec<f32>,
    row: &mut [f32],
) {
    columns.resize(row.len() + 2, 0.0);
    let above = picture.row(y.saturating_sub(1));
    let below = picture.row((y + 1).min(picture.height() - 1));
    let around = [above, picture.row(y), below];
    widest(
        #[inline(always)]
        || smooth_rows(around, columns, row),
    );
}

/// The same from the rows around; `columns` is one pixel wider at either end.
#[inline(always)]
fn smooth_rows<T: Pixel>([above, here, below]: [&[T]; 3], columns: &mut [f32], row: &mut [f32]) {
    let width = row.len();
    let (above, here, below) = (&above[..width], &here[..width], &below[..width]);
    for (x, column) in columns[1..=width].iter_mut().enumerate() {
        *column = above[x].raw() + 2.0 * here[x].raw() + below[x].raw();
    }
    columns[0] = columns[1];
    columns[width + 1] = columns[width];
    let scale = T::UNIT / 16.0;
    let (left, middle, right) = (&columns[..width], &columns[1..=width], &columns[2..]);
    for (x, pixel) in row.iter_mut().enumerate() {
        *pixel = scale * (left[x] + 2.0 * middle[x] + right[x]);
    }
}

/// The rows from `first` on of a picture less the mean over the part of the window that lies inside it.
fn less_mean(picture: &Plane<f32>, first: usize, out: &mut [f32]) {
    let (width, height) = (picture.width(), picture.height());
    let within = |at: usize, size: usize| {
        let last = (at + HALF_WINDOW).min(size - 1);
        (at.saturating_sub(HALF_WINDOW), last)
    };
    let shares: Vec<f32> = (0..width)
        .map(|x| within(x, width))
        .map(|(first, last)| ((last - first + 1) as f32).recip())
        .collect();
    let (mut top, mut bottom) = within(first, height);
    let mut sums = WindowSums::new(width);
    (top..=bottom).for_each(|y| sums.add(picture.row(y), 1.0));
    for (i, row) in out.chunks_exact_mut(width).enumerate() {
        let (new_top, new_bottom) = within(first + i, height);
        if new_bottom > bottom {
            sums.add(picture.row(new_bottom), 1.0);
            bottom = new_bottom;
        }
        if new_top > top {
            sums.add(picture.row(top), -1.0);
            top = new_top;
        }
        let share = ((bottom - top + 1) as f32).recip();
        let here = picture.row(first + i);
        sums.subtract_mean((here, row), &shares, share);
    }
}

/// Sums of the columns of a window that slides down, and room for those along a row.
struct WindowSums {
    /// With half a window of nothing at either end.
    columns: Vec<f32>,
    room: [Vec<f32>; 2],
}

impl WindowSums {
    fn new(width: usize) -> Self {
        let padded = vec![0.0; width + 2 * HALF_WINDOW];
        Self {
            room: [padded.clone(), padded.clone()],
            columns: padded,
        }
    }

    fn add(&mut self, row: &[f32], sign: f32) {
        let columns = &mut self.columns[HALF_WINDOW..HALF_WINDOW + row.len()];
        widest(
            #[inline(always)]
            || {
                for (column, value) in columns.iter_mut().zip(row) {
                    *column += sign * value;
                }
            },
        );
    }

    /// A row less the mean of its windows. The sums over 16 columns come from those over 8, and so on: no pixel waits for the one
    /// before it, as it would where a window slides along.
    fn subtract_mean(&mut self, (here, out): (&[f32], &mut [f32]), shares: &[f32], share: f32) {
        let Self { columns, room } = self;
        let [one, other] = room;
        widest(
            #[inline(always)]
            || {
                add_shifted(columns, 1, one);
                add_shifted(one, 2, other);
                add_shifted(other, 4, one);
                add_shifted(one, 8, other);
                let (last, sums) = (&columns[2 * HALF_WINDOW..], &other[..]);
                let width = out.len();
                let (last, sums) = (&last[..width], &sums[..width]);
                let (here, shares) = (&here[..width], &shares[..width]);
                for (x, out) in out.iter_mut().enumerate() {
                    *out = here[x] - (sums[x] + last[x]) * shares[x] * share;
                }
            },
        );
    }
}

/// Sums of values and those `by` places after them; the last ones are left as they were.
#[inline(always)]
fn add_shifted(values: &[f32], by: usize, out: &mut [f32]) {
    for (out, (a, b)) in out.iter_mut().zip(values.iter().zip(&values[by..])) {
        *out = a + b;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(f: impl Fn(usize, usize) -> f32) -> Plane<f32> {
        let data = (0..60 * 70).map(|i| f(i % 60, i / 60)).collect();
        Plane::from_vec(60, 70, data).unwrap()
    }

    #[test]
    fn the_mean_agrees_with_its_definition() {
        let p = picture(|x, y| ((x * 31 + y * 17) % 23) as f32);
        let mut less = Plane::filled(60, 70, 0.0);
        less_mean(&p, 0, less.data_mut());
        for (x, y) in [
            (0_usize, 0_usize),
            (59, 69),
            (30, 33),
            (5, 64),
            (52, 31),
            (8, 32),
        ] {
            let (mut sum, mut count) = (0.0, 0.0);
            for v in y.saturating_sub(HALF_WINDOW)..=(y + HALF_WINDOW).min(69) {
                for u in x.saturating_sub(HALF_WINDOW)..=(x + HALF_WINDOW).min(59) {
                    sum += p.at(u, v);
                    count += 1.0;
                }
            }
            assert!((less.at(x, y) - (p.at(x, y) - sum / count)).abs() < 1e-3);
        }
    }

    #[test]
    fn a_linear_picture_has_no_band_and_light_spots_are_positive() {
        let flat = BandPass::of(&picture(|x, y| 0.01 * x as f32 + 0.003 * y as f32));
        assert!(flat.plane.at(30, 30).abs() < 1e-5);
        let spot = picture(|x, y| {
            if x.abs_diff(30) < 3 && y.abs_diff(30) < 3 {
                1.0
            } else {
                0.2
            }
        });
        assert!(BandPass::of(&spot).plane.at(30, 30) > 0.5);
    }

    #[test]
    fn tiny_pictures_do_not_panic() {
        for (width, height) in [(1, 1), (2, 1), (1, 3), (5, 2)] {
            let band = BandPass::of(&Plane::filled(width, height, 9_u8));
            assert_eq!(band.plane.data().len(), width * height);
        }
    }
}
