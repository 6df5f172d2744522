//! How often each pair of grey level and neighbourhood mean level occurs (paper equations 10 to 12).

use super::levels::{Grey, LEVELS, Levels};
use super::neighbourhood;
use crate::frame::Plane;

/// Counts f(i, j) of pixels with grey level `i` and neighbourhood mean level `j`, both below `levels`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct JointHistogram {
    levels: usize,
    counts: Vec<u32>,
}

impl JointHistogram {
    /// A histogram from its counts, row `i` after row `i`; `None` where they are not a square.
    pub fn from_counts(levels: usize, counts: Vec<u32>) -> Option<Self> {
        (levels.checked_mul(levels) == Some(counts.len())).then_some(Self { levels, counts })
    }

    /// The histogram of a picture, in one pass.
    pub(super) fn of<T: Grey>(plane: &Plane<T>, levels: &Levels<T>) -> Self {
        let counts = neighbourhood::collect(
            plane,
            || vec![0_u32; LEVELS * LEVELS],
            |counts, row, means| {
                for (&value, &mean) in row.iter().zip(means) {
                    counts[levels.of_value(value) * LEVELS + levels.of_value(mean)] += 1;
                }
            },
            add_counts,
        );
        Self {
            levels: LEVELS,
            counts,
        }
    }

    /// Levels of each of the two axes (the paper's L).
    pub fn levels(&self) -> usize {
        self.levels
    }

    /// f(i, 0), f(i, 1), ... of one grey level; panics where `i` is not below the levels, like a slice.
    pub fn row(&self, i: usize) -> &[u32] {
        &self.counts[i * self.levels..(i + 1) * self.levels]
    }
}

/// Counts of two parts of a picture together.
pub(super) fn add_counts(mut a: Vec<u32>, b: Vec<u32>) -> Vec<u32> {
    for (a, b) in a.iter_mut().zip(b) {
        *a += b;
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_pairs_of_value_and_mean() {
        // 0 0 90: means by replicated borders 0, 30, 60 (every row the same)
        let plane = Plane::from_vec(3, 2, vec![0_u8, 0, 90, 0, 0, 90]).unwrap();
        let histogram = JointHistogram::of(&plane, &Levels::of(&plane));
        assert_eq!(histogram.row(0)[0], 2);
        assert_eq!(histogram.row(0)[30], 2);
        assert_eq!(histogram.row(90)[60], 2);
        let total: u32 = (0..LEVELS).flat_map(|i| histogram.row(i)).sum();
        assert_eq!(total, 6);
    }
}
