//! Passes over a picture that see every pixel with the mean of its 3 x 3 neighbourhood, borders replicated.
//!
//! Means are rounded; a pixel outside the picture counts as the nearest one inside. Bands of rows are worked on in
//! parallel, each with its own running sums, so nothing but the result is ever stored.

use super::levels::Grey;
use crate::frame::Plane;
use rayon::prelude::*;
use std::ops::Range;

/// Rows worked on at a time: enough that the two rows a band reads twice do not count.
const BAND_ROWS: usize = 64;

/// Collects something over all pixels: `visit(so far, row, means)` for every row, then `merge` over the bands.
///
/// The result must not depend on the order of merging: sums of integers, smallest and largest.
pub(super) fn collect<T: Grey, A: Send>(
    plane: &Plane<T>,
    empty: impl Fn() -> A + Sync + Send,
    visit: impl Fn(&mut A, &[T], &[T]) + Sync + Send,
    merge: impl Fn(A, A) -> A + Sync + Send,
) -> A {
    (0..plane.height().div_ceil(BAND_ROWS))
        .into_par_iter()
        .fold(&empty, |mut so_far, band| {
            let end = ((band + 1) * BAND_ROWS).min(plane.height());
            for_each_row(plane, band * BAND_ROWS..end, |_, row, means| {
                visit(&mut so_far, row, means);
            });
            so_far
        })
        .reduce(&empty, merge)
}

/// A picture of `new_value(value, mean)` of every pixel.
pub(super) fn map<T: Grey>(
    plane: &Plane<T>,
    new_value: impl Fn(T, T) -> T + Sync + Send,
) -> Plane<T> {
    let width = plane.width();
    let mut mapped = Plane::filled(width, plane.height(), T::default());
    let bands = mapped.data_mut().par_chunks_mut((width * BAND_ROWS).max(1));
    bands.enumerate().for_each(|(band, out)| {
        let first = band * BAND_ROWS;
        for_each_row(plane, first..first + out.len() / width, |y, row, means| {
            let out = &mut out[(y - first) * width..][..width];
            for ((out, &value), &mean) in out.iter_mut().zip(row).zip(means) {
                *out = new_value(value, mean);
            }
        });
    });
    mapped
}

/// Calls `visit(y, row, means)` for the rows in `rows`, top to bottom.
fn for_each_row<T: Grey>(
    plane: &Plane<T>,
    rows: Range<usize>,
    mut visit: impl FnMut(usize, &[T], &[T]),
) {
    let width = plane.width();
    if width == 0 {
        return;
    }
    // sums of three in each column, with the first and the last column once more outside
    let mut columns = vec![0_u32; width + 2];
    let mut means = vec![T::default(); width];
    for y in rows {
        let above = plane.row(y.saturating_sub(1));
        let row = plane.row(y);
        let below = plane.row((y + 1).min(plane.height() - 1));
        for (((sum, &a), &b), &c) in columns[1..=width].iter_mut().zip(above).zip(row).zip(below) {
            *sum = Into::<u32>::into(a) + Into::<u32>::into(b) + Into::<u32>::into(c);
        }
        columns[0] = columns[1];
        columns[width + 1] = columns[width];
        let (left, middle, right) = (&columns[..width], &columns[1..=width], &columns[2..]);
        for (((mean, &a), &b), &c) in means.iter_mut().zip(left).zip(middle).zip(right) {
            *mean = T::mean_of_nine(a + b + c);
        }
        visit(y, row, &means);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn means<T: Grey>(plane: &Plane<T>) -> Vec<T> {
        map(plane, |_, mean| mean).data().to_vec()
    }

    #[test]
    fn borders_are_replicated() {
        // (0, 0): 4 x 10 + 2 x 20 + 2 x 30 + 1 x 50 = 190 -> 21.1; (2, 0): 4 x 90 + 2 x 20 + 2 x 60 + 50 = 570 -> 63.3
        let plane = Plane::from_vec(3, 2, vec![10_u8, 20, 90, 30, 50, 60]).unwrap();
        let all = means(&plane);
        assert_eq!((all[0], all[2]), (21, 63));
        assert_eq!(means(&Plane::filled(1, 1, 65_535_u16)), [65_535]);
        assert!(means(&Plane::filled(0, 3, 0_u8)).is_empty());
    }

    #[test]
    fn bands_make_no_difference() {
        let (width, height) = (5, 3 * BAND_ROWS + 7);
        let data = (0..width * height).map(|k| (k * k % 251) as u8).collect();
        let plane = Plane::from_vec(width, height, data).unwrap();
        let mut expected = Vec::<u8>::new();
        for_each_row(&plane, 0..height, |_, _, means| expected.extend(means));
        assert_eq!(means(&plane), expected);
        let sum = collect(
            &plane,
            || 0_u64,
            |sum, _, means| *sum += means.iter().map(|&m| u64::from(m)).sum::<u64>(),
            |a, b| a + b,
        );
        assert_eq!(sum, expected.iter().map(|&m| u64::from(m)).sum::<u64>());
    }

    proptest! {
        #[test]
        fn agrees_with_nine_look_ups(
            (width, height, data) in (1_usize..9, 1_usize..9).prop_flat_map(|(w, h)| {
                (Just(w), Just(h), proptest::collection::vec(any::<u16>(), w * h))
            }),
        ) {
            let plane = Plane::from_vec(width, height, data).unwrap();
            let all = means(&plane);
            for y in 0..height {
                for x in 0..width {
                    let mut sum = 0.0;
                    for dy in 0..3 {
                        for dx in 0..3 {
                            let near_x = (x + dx).saturating_sub(1).min(width - 1);
                            let near_y = (y + dy).saturating_sub(1).min(height - 1);
                            sum += f64::from(plane.at(near_x, near_y));
                        }
                    }
                    prop_assert!((f64::from(all[y * width + x]) - sum / 9.0).abs() <= 0.5);
                }
            }
        }
    }
}
