//! Each picture against its own neighbourhood: what is lighter and what darker than its surroundings.
//!
//! The inner disc of a ring is lighter than the mean over a window of about the ring's size, however blurred it is, as
//! long as it shows as a local extremum at all; a global or mid-level threshold loses it much earlier. One window size
//! serves the rings of about one octave; the pyramid supplies the others.

use crate::frame::{Pixel, Plane};
use rayon::prelude::*;

/// Half the side of the window of the mean, px of the level: the window is 17 x 17.
pub(super) const HALF_WINDOW: usize = 8;

/// Rows that one task computes; fixed, so that sums run in the same order whatever the threads.
const ROWS_PER_TASK: usize = 32;

/// The smoothed picture minus its local mean, and how noisy it is.
#[derive(Debug, Clone)]
pub(super) struct BandPass {
    /// Grey difference; positive where lighter than the surroundings.
    pub(super) plane: Plane<f32>,
    /// Differences smaller than this are not told from noise or quantisation.
    pub(super) margin: f32,
}

/// How far above the noise a difference must be, in standard deviations.
const NOISE_FACTOR: f32 = 2.5;
/// The least difference that counts, as a fraction of the picture's range.
const RANGE_FRACTION: f32 = 0.008;

impl BandPass {
    /// Of a picture; `sign` is 1 where rings are dark and -1 where they are light, so that inner discs are positive.
    pub(super) fn of<T: Pixel>(picture: &Plane<T>, sign: f32) -> Self {
        let smooth = smooth(picture);
        let margin = (NOISE_FACTOR * noise(&smooth)).max(RANGE_FRACTION * range(&smooth));
        let mut plane = box_mean(&smooth);
        plane
            .data_mut()
            .par_chunks_mut(ROWS_PER_TASK * smooth.width().max(1))
            .zip(
                smooth
                    .data()
                    .par_chunks(ROWS_PER_TASK * smooth.width().max(1)),
            )
            .for_each(|(mean, value)| {
                for (m, v) in mean.iter_mut().zip(value) {
                    *m = sign * (v - *m);
                }
            });
        Self { plane, margin }
    }
}

/// Binomial 3 x 3 smoothing (1 2 1), borders replicated.
fn smooth<T: Pixel>(picture: &Plane<T>) -> Plane<f32> {
    let (width, height) = (picture.width(), picture.height());
    let mut out = Plane::filled(width, height, 0.0_f32);
    out.data_mut()
        .par_chunks_mut(width.max(1))
        .enumerate()
        .for_each(|(y, row)| {
            let above = picture.row(y.saturating_sub(1));
            let here = picture.row(y);
            let below = picture.row((y + 1).min(height - 1));
            let mut column = vec![0.0_f32; width];
            for (c, ((a, h), b)) in column.iter_mut().zip(above.iter().zip(here).zip(below)) {
                *c = 0.25 * (a.unit() + 2.0 * h.unit() + b.unit());
            }
            row[0] = 0.25 * (3.0 * column[0] + column[1.min(width - 1)]);
            for (pixel, c) in row[1..].iter_mut().zip(column.windows(3)) {
                *pixel = 0.25 * (c[0] + 2.0 * c[1] + c[2]);
            }
            if width > 1 {
                row[width - 1] = 0.25 * (3.0 * column[width - 1] + column[width - 2]);
            }
        });
    out
}

/// Mean over the part of the window that lies inside the picture.
fn box_mean(picture: &Plane<f32>) -> Plane<f32> {
    let (width, height) = (picture.width(), picture.height());
    let mut out = Plane::filled(width, height, 0.0_f32);
    out.data_mut()
        .par_chunks_mut(ROWS_PER_TASK * width.max(1))
        .enumerate()
        .for_each(|(task, rows)| {
            let first = task * ROWS_PER_TASK;
            let window = |y: usize| {
                (
                    y.saturating_sub(HALF_WINDOW),
                    (y + HALF_WINDOW).min(height - 1),
                )
            };
            let (mut top, mut bottom) = window(first);
            let mut columns = vec![0.0_f32; width];
            for y in top..=bottom {
                add(&mut columns, picture.row(y), 1.0);
            }
            for (i, row) in rows.chunks_mut(width).enumerate() {
                let (new_top, new_bottom) = window(first + i);
                if new_bottom > bottom {
                    add(&mut columns, picture.row(new_bottom), 1.0);
                    bottom = new_bottom;
                }
                if new_top > top {
                    add(&mut columns, picture.row(top), -1.0);
                    top = new_top;
                }
                mean_along(&columns, row, (bottom - top + 1) as f32);
            }
        });
    out
}

fn add(columns: &mut [f32], row: &[f32], sign: f32) {
    for (c, v) in columns.iter_mut().zip(row) {
        *c += sign * v;
    }
}

/// Slides the window along a row of column sums.
fn mean_along(columns: &[f32], row: &mut [f32], rows_in_window: f32) {
    let width = columns.len();
    let mut sum: f32 = columns[..(HALF_WINDOW + 1).min(width)].iter().sum();
    for x in 0..width {
        let count = (x + HALF_WINDOW).min(width - 1) - x.saturating_sub(HALF_WINDOW) + 1;
        row[x] = sum / (count as f32 * rows_in_window);
        if x + HALF_WINDOW + 1 < width {
            sum += columns[x + HALF_WINDOW + 1];
        }
        if x >= HALF_WINDOW {
            sum -= columns[x - HALF_WINDOW];
        }
    }
}

/// Every how many pixels the statistics of a picture are sampled.
const SAMPLING: usize = 7;

/// Standard deviation of the noise that smoothing left: the median of second differences over three pixels, which
/// structure hardly moves.
fn noise(smooth: &Plane<f32>) -> f32 {
    let mut differences: Vec<f32> = (0..smooth.height())
        .step_by(SAMPLING)
        .flat_map(|y| {
            smooth
                .row(y)
                .windows(7)
                .step_by(SAMPLING)
                .map(|w| (w[3] - 0.5 * (w[0] + w[6])).abs())
        })
        .collect();
    // three independent pixels with weights 1, 1/2, 1/2: variance 1.5; the median of |normal| is 0.6745 sigma
    quantile(&mut differences, 0.5) / (0.6745 * 1.5_f32.sqrt())
}

/// From the 2nd to the 98th percentile of the grey values.
fn range(smooth: &Plane<f32>) -> f32 {
    let mut values: Vec<f32> = (0..smooth.height())
        .step_by(SAMPLING)
        .flat_map(|y| smooth.row(y).iter().step_by(SAMPLING).copied())
        .collect();
    quantile(&mut values, 0.98) - quantile(&mut values, 0.02)
}

fn quantile(values: &mut [f32], fraction: f32) -> f32 {
    if values.is_empty() {
        return 0.0;
    }
    let at = ((values.len() - 1) as f32 * fraction) as usize;
    *values.select_nth_unstable_by(at, f32::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(f: impl Fn(usize, usize) -> f32) -> Plane<f32> {
        let data = (0..60 * 70).map(|i| f(i % 60, i / 60)).collect();
        Plane::from_vec(60, 70, data).unwrap()
    }

    #[test]
    fn box_mean_agrees_with_its_definition() {
        let p = picture(|x, y| ((x * 31 + y * 17) % 23) as f32);
        let mean = box_mean(&p);
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
            assert!((mean.at(x, y) - sum / count).abs() < 1e-3);
        }
    }

    #[test]
    fn a_linear_picture_has_no_band_and_light_spots_are_positive() {
        let flat = BandPass::of(&picture(|x, y| 0.01 * x as f32 + 0.003 * y as f32), 1.0);
        assert!(flat.plane.at(30, 30).abs() < 1e-5);
        let spot = picture(|x, y| {
            if x.abs_diff(30) < 3 && y.abs_diff(30) < 3 {
                1.0
            } else {
                0.2
            }
        });
        assert!(BandPass::of(&spot, 1.0).plane.at(30, 30) > 0.5);
        assert!(BandPass::of(&spot, -1.0).plane.at(30, 30) < -0.5);
    }

    #[test]
    fn tiny_pictures_do_not_panic() {
        for (width, height) in [(1, 1), (2, 1), (1, 3), (5, 2)] {
            let band = BandPass::of(&Plane::filled(width, height, 9_u8), 1.0);
            assert_eq!(band.plane.data().len(), width * height);
        }
    }
}
